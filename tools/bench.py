#!/usr/bin/env python3
"""Times whole runs of pebble on this machine: `make bench`.

The work is a square block of elastic material that is sheared to and fro, 9 points a cell, without output. Runs of one
process, two processes (both migrations) and the worker pool alternate, so that what else the machine does hits all
alike; figures are the minimum and the median of the repeats, ratios are of minima. The time is that of the steps (the
`all` row of the phase table), not of start-up.
"""
import argparse
import os
import re
import statistics
import subprocess
import sys
import tempfile

SCENE = """
-dim 2
-grid_lower 0,0
-grid_upper 1,1
-grid_cells {cells},{cells}
-materials m
-material_m_model neohookean
-material_m_rho 1000
-material_m_E 1e6
-material_m_nu 0.3
-bodies b
-body_b_shape box
-body_b_lower 0.25,0.25
-body_b_upper 0.75,0.75
-body_b_ppc 3,3
-body_b_material m
-body_b_velocity "2*sin(2*pi*y), 1.3*sin(2*pi*x)"
-method_basis linear
-method_update {update}
-time_end 1
-time_max_steps {steps}
-output_format none
-history_every 1
"""

CASES = {  # name: (processes, options)
    "1 process": (1, []),
    "spatial 2, swarm": (2, []),
    "spatial 2, direct": (2, ["-parallel_migrate", "direct"]),
    "pool 2": (2, ["-parallel_strategy", "pool"]),
}


def run(args, scene, processes, options):
    """Runs once; returns (ns per particle-step, digest)."""
    command = [args.mpiexec, "-n", str(processes), args.pebble, "-options_file", scene, "-output_dir",
               os.path.dirname(scene)] + options
    out = subprocess.run(command, capture_output=True, text=True)
    if out.returncode:
        sys.exit(f"{' '.join(command)}\n{out.stdout}{out.stderr}")
    row = re.search(r"^  all +\S+ +\S+ +(\S+)", out.stdout, re.M)
    return float(row[1]), re.search(r"^digest (\w+)", out.stdout, re.M)[1]


def main():
    p = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    p.add_argument("--pebble", default="./pebble")
    p.add_argument("--mpiexec", default="mpiexec")
    p.add_argument("--particles", type=float, default=1e6)
    p.add_argument("--steps", type=int, default=30)
    p.add_argument("--repeats", type=int, default=5)
    p.add_argument("--update", default="usf", help="usf, usl or musl")
    p.add_argument("--csv", help="also write the table there")
    args = p.parse_args()
    cells = 4 * round((args.particles * 4 / 9) ** 0.5 / 4)
    with tempfile.TemporaryDirectory() as folder:
        scene = os.path.join(folder, "block.opts")
        with open(scene, "w") as f:
            f.write(SCENE.format(cells=cells, update=args.update, steps=args.steps))
        times, digests = {name: [] for name in CASES}, set()
        for _ in range(args.repeats):
            for name, (processes, options) in CASES.items():
                ns, digest = run(args, scene, processes, options)
                times[name].append(ns)
                digests.add(digest)
    base = min(times["1 process"])
    print(f"{9 * cells * cells // 4} particles, {args.steps} steps, linear / {args.update}, {os.cpu_count()} cores")
    print(f"{'':20s} {'min':>8s} {'median':>8s}   ns per particle-step;  times faster than 1 process")
    rows = []
    for name, t in times.items():
        print(f"{name:20s} {min(t):8.1f} {statistics.median(t):8.1f} {base / min(t):8.2f}")
        rows.append(f"{name},{min(t)},{statistics.median(t)},{base / min(t)}\n")
    if args.csv:
        with open(args.csv, "w") as f:
            f.write("case,min_ns,median_ns,ratio\n" + "".join(rows))
    if len(digests) > 1:
        sys.exit(f"digests differ: {digests}")


if __name__ == "__main__":
    main()
