#!/usr/bin/env python3
"""Makes docs/data/constants.csv, the constants of all closed forms in docs, and docs/data/model.csv, what the full model
(src/cost) says with the same constants: `constants.py PEBBLE`. No time is measured here.

constants.csv: T1 is the measured step on one process; C, L, B and R are by the formulas (1) to (4) of docs/model.md, and M
by the bound of the pool that the full model prints. model.csv: the efficiencies that `-dry_run -report_processes` prints, in
the cuts of the program; its phases share T1 as simulated/costs.csv says. In rows of `least`, particles has those that a
process of a full cube needs for that efficiency.
"""

import functools
import os
import re
import sys
import tempfile

from data import BOXES, DIRECT, POOL, PROCESSES, ROOT, SWARM, evidence, find

sys.path.insert(0, os.path.join(ROOT, "tools"))
import launch  # noqa: E402 (after the path)
import scenes  # noqa: E402

# The assumed cluster, and the costs that the simulated runs have beside those of costs.csv (tools/simulate, FIXED).
ALL = {
    "latency": (1e-6, "s", "assumed: a message on its way"),
    "post": (0.6e-6, "s", "assumed: the processors at both ends of a message"),
    "wire": (0.08e-9, "s/B", "assumed: 12.5 GB/s for each process"),
    "kept": (0.4e-9, "s/B", "clocks around the code: sums packed and unpacked, tools/simulate"),
    "pool": (0.155e-9, "s/B", "clocks around the code: the master packs (0.2) and takes in (0.11 ns), tools/simulate"),
    "job": (0.5e-6, "s", "clocks around the code: a patch handed out, tools/simulate"),
}
LATENCY, POST, WIRE, KEPT, MASTER, JOB = (number for number, *_ in ALL.values())
HOP = LATENCY + POST
# Of a step: exchanges, those of them of motions, and the numbers of a node in sums and motions, here without those for each axis.
STEPS = {"usl": (2, 1, (1, 2), 2), "usf": (4, 2, (1, 2), 3), "musl": (4, 2, (1, 3), 3)}


def dry_run(folder, path, *options, constants=""):
    """What the full model says of a scene: {what: number}, and `rows`, {processes: step, imbalance, step of the pool}."""
    command = [sys.argv[1], "-options_file", path, "-output_format", "none", "-output_dir", folder, *options]
    done = launch.run([*command, "-dry_run", "-report_processes"], capture_output=True, text=True)
    if done.returncode or f"constants {constants}" not in done.stdout:
        sys.exit(f"constants.py: {' '.join(map(str, command))}\n{done.stdout[-800:]}{done.stderr[-800:]}")
    patterns = {"bound": r"exceeds a speed-up of (\S+);", "particles": r"^scene .*  (\d+) particles", "bytes": r"^fields .* (\d+) B/particle"}
    found = {name: float(re.search(pattern, done.stdout, re.M)[1]) for name, pattern in patterns.items()}
    table = re.findall(r"^ +(\d+) +(\S+) +\S+ \w+ +\S+ +\S+ +(\S+)(?: +(\S+) +\S+ \w+ +\S+)?$", done.stdout, re.M)
    found["rows"] = {int(p): [float(t or "nan") for t in step] for p, *step in table}
    found["least"] = re.findall(r"[:,] (\S+) on (\d+)", re.search(r"^  spatial keeps 0.9.*", done.stdout, re.M)[0])
    return found


def of_scene(folder, scene):
    """Rows of constants.csv and of model.csv."""
    name, d, box, write = scene.name, scene.dim, scene.name in BOXES, functools.partial(scenes.write, folder, scene.name)
    costs = {k: 1e-9 * ns for k, ns in find("simulated/costs", "ns", "name", scene=name).items()}
    one = next(r for r in evidence("strong", "measured") if (r["scene"], r["processes"]) == (name, 1))
    patches = {study: find(evidence(study, "injected simulation"), "pool_cells", scene=name, way=POOL) for study in ("strong", "weak")}
    edge, each = patches["strong"][8], one["seconds"] / one["particles"]
    leaving = 16 + dry_run(folder, write(scene.strong))["bytes"]  # B of a particle on its way, with its cell and what says where it goes

    def said(size, edge, migrate="direct"):
        """What the full model says, with the constants of a file written here."""
        phases = {k: t for k, t in costs.items() if k not in ("LEAVER", "SWARM", "SWARM_PARTICLE")}
        lines = ["method any", "from constants.py"]
        for phase, t in phases.items():  # those of nodes are known for each particle
            rate = each / sum(phases.values()) * t * (2**d if phase in ("VELOCITY", "ADVANCE") else 1)
            lines.append(f"rate {phase} 0 1 {rate} 2 {rate} 3 {rate}")
        # A network carries bytes while the master of a pool packs others: the longer of both counts.
        numbers = dict(post=POST, wire=WIRE, kept=KEPT, job=JOB, exchange=0, copy=0, message=HOP, reduction=HOP, pool=max(0, MASTER - WIRE))
        swarm = costs["SWARM"], costs["SWARM_PARTICLE"], WIRE * leaving
        for k, way in enumerate((swarm, (0, 0, swarm[2] + costs["LEAVER"] / 2))):
            numbers |= {f"migration[{k}].{what}": t for what, t in zip(("call", "particle", "leaver"), way)}
        path = write(size)
        with open(f"{path}.model", "w") as f:
            f.write("\n".join([*lines, *(f"{k} {v}" for k, v in numbers.items())]) + "\n")
        return dry_run(folder, path, "-parallel_migrate", migrate, "-pool_cells", edge, "-model_file", f"{path}.model", constants="constants.py")

    # ---- By the formulas of docs/model.md
    exchanges, motions, (sums, per_axis), moved = STEPS[scene.update]
    reach, tile = (1, 2) if scene.basis == "linear" else (2, 4)
    latency = exchanges * (2**d - 1) * POST + motions * (HOP - POST) + d * (HOP + POST)
    ghost = 8 * ((sums + per_axis * d) * ((tile + reach) / tile) ** (d - 1) * KEPT + moved * d * WIRE)
    # direct: half of the cost of a particle that leaves arises at either end, and both ends wait at the same time.
    face = d * (reach / 2 ** (d - 1) * ghost + WIRE * leaving + costs["LEAVER"] / 2)
    full = said(scene.strong, edge)
    constants = [
        (name, "particles", one["particles"], "", "scaling/runs.csv"),
        (name, "T1", f"{one['seconds']:.4g}", "s", "scaling/runs.csv: measured on one process"),
        (name, "leaver", f"{costs['LEAVER']:.4g}", "s/particle", "simulated/costs.csv: a particle that changes process, by a calibration"),
    ]
    units = {"C": "s/particle", "L": "s", "B": "s/particle of a face", "R": "s", "M": "s/particle"}
    for k, (constant, t) in enumerate(zip(units, (each, latency, face, HOP, each / full["bound"])), 1):
        constants.append((name, constant, f"{t:.4g}", units[constant], f"model.md ({k})"))
    constants.append((name, "patch", edge, "cells", "simulated/strong.csv: the edge of the pool's patches"))

    # ---- By the full model
    rows = []
    for study, size, processes in [("strong", scene.strong, PROCESSES[1:]), *(("weak", scene.weak(p), [p]) for p in PROCESSES[1:] if box)]:
        direct, swarm = (said(size, patches[study][processes[-1]], migrate) for migrate in ("direct", "swarm"))
        for p, (spatial, imbalance, pool) in ((p, row) for p, row in direct["rows"].items() if p in processes):
            for way, by, t, i in ((DIRECT, direct, spatial, imbalance), (POOL, direct, pool, 1), (SWARM, swarm, *swarm["rows"][p][:2])):
                rows.append((name, study, way, p, f"{by['particles']:.6g}", f"{by['rows'][1][0] / t / p:.4g}", f"{i:.4g}"))
    return constants, rows + [(name, "least", DIRECT, p, n, 0.9, 1) for n, p in full["least"] if box]


def main():
    constants, found = [("all", name, f"{number:g}", unit, source) for name, (number, unit, source) in ALL.items()], []
    with tempfile.TemporaryDirectory() as folder:
        for more, rows in (of_scene(folder, scene) for scene in scenes.SCENES.values()):
            constants, found = constants + more, found + rows
        disks = dry_run(folder, os.path.join(ROOT, "options", "disks.opts"), "-grid_cells", "1024,1024")
    found.append(("disks", "balance", DIRECT, 32, f"{disks['particles']:.6g}", "", f"{disks['rows'][32][1]:.4g}"))
    heads = {"constants": ("scene", "constant", "value", "unit", "source"), "model": ("scene", "study", "way", "processes", "particles", "efficiency", "imbalance")}
    for (file, head), lines in zip(heads.items(), (constants, found)):
        scenes.table(os.path.join(ROOT, "docs", "data", f"{file}.csv"), [dict(zip(head, line)) for line in lines])


if __name__ == "__main__":
    main()
