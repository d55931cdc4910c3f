#!/usr/bin/env python3
"""Measures the time of a full step in ns per particle on one process: a filled box moves diagonally by about 5 % of a cell a step.

    tools/speed.py [--pebble ./pebble,other] [--sizes 1e5,1e6] [--updates usl,usf,musl] [--only linear2,...] [--repeat 3]
    tools/speed.py -- -method_transfer apic        options of Pebble follow after --

Several programs are run in turn, so that their ratio holds on a noisy machine; the least time of the repeats counts.
"""
import argparse
import re
import resource
import sys
import tempfile
from pathlib import Path

import launch

CASES = {"linear2": ("linear", 2), "quadratic2": ("bspline2", 2), "cubic2": ("bspline3", 2), "gimp2": ("gimp", 2),
         "linear3": ("linear", 3), "quadratic3": ("bspline2", 3)}


def options(basis, dim, n, update, steps):
    """Options of a body of whole cells, with 9 particles a cell in 2-D and 8 in 3-D, in a grid of twice (1.6 times) its edge."""
    edge = round((n / 9) ** 0.5) if dim == 2 else round((n / 8) ** (1 / 3))
    cells = 2 * edge if dim == 2 else round(1.6 * edge)
    first = (cells - edge) // 4
    h, c = 1 / cells, 36.69  # c is the speed of waves in the material below
    speed = 0.5 * c  # with dt = h/(10 c) this is 5 % of a cell a step
    vector = lambda x: ",".join([str(x)] * dim)
    return {"dim": dim, "grid_lower": vector(0), "grid_upper": vector(1), "grid_cells": vector(cells),
            "materials": "m", "material_m_model": "neohookean", "material_m_rho": 1000, "material_m_E": 1e6,
            "material_m_nu": 0.3, "bodies": "b", "body_b_shape": "box", "body_b_lower": vector(first * h),
            "body_b_upper": vector((first + edge) * h), "body_b_ppc": vector(3 if dim == 2 else 2),
            "body_b_material": "m", "body_b_velocity": ",".join([f"{speed}+0.1*sin(6*x)"] * dim), "method_basis": basis,
            "method_update": update, "method_transfer": "flip", "dt_size": 0.1 * h / c, "time_end": 1e9,
            "time_max_steps": steps, "output_format": "none", "history_every": 1e9}


def seconds(pebble, opts, extra):
    """Processor time of a run, and what run() returns."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    rows = run(pebble, opts, extra)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, rows


def run(pebble, opts, extra):
    """ns per particle and step of each phase, and the digest, as the run prints them."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "speed.opts"
        path.write_text("".join(f"-{k} {v}\n" for k, v in opts.items()))
        out = launch.run([pebble, "-options_file", str(path), "-output_dir", folder, *extra], capture_output=True,
                             text=True, check=False)
    rows = re.findall(r"^  (\w+) +[\d.]+ +[\d.]+ +([\d.]+) ", out.stdout, re.M)
    if not rows:
        sys.exit(out.stdout + out.stderr)
    return {name: float(ns) for name, ns in rows}, re.findall(r"digest\W+(\w+)", out.stdout)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pebble", default="./pebble")
    parser.add_argument("--sizes", default="1e5,1e6")
    parser.add_argument("--updates", default="usl")
    parser.add_argument("--only", default=",".join(CASES))
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--phases", action="store_true")
    parser.add_argument("extra", nargs="*")
    args = parser.parse_args()
    for name in args.only.split(","):
        basis, dim = CASES[name]
        for size in args.sizes.split(","):
            for update in args.updates.split(","):
                steps = (300 if dim == 2 else 120) if float(size) < 5e5 else 45
                best, start, shown = {}, {}, {}
                for _ in range(args.repeat):
                    for pebble in args.pebble.split(","):
                        few, _ = seconds(pebble, options(basis, dim, float(size), update, 1), args.extra)
                        many, shown[pebble] = seconds(pebble, options(basis, dim, float(size), update, steps), args.extra)
                        start[pebble] = min(start.get(pebble, few), few)
                        best[pebble] = min(best.get(pebble, many), many)
                n = 1e9 / float(size) / (steps - 1)
                for pebble, (rows, digest) in shown.items():
                    line = f"{name:11} {size:5} {update:5} {Path(pebble).name:16} {(best[pebble] - start[pebble]) * n:7.1f}"
                    if args.phases:
                        line += "  wall " + " ".join(f"{k} {v:.1f}" for k, v in rows.items())
                    print(line, *digest, flush=True)


if __name__ == "__main__":
    main()
