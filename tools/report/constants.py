#!/usr/bin/env python3
"""Makes docs/data/constants.csv, the constants of all closed forms in docs, and docs/data/model.csv, what the full model
(src/cost) says with the same constants. No time is measured here: `make report` calls it, and the test `report_made`.

constants.csv: `all` has what is the same in all scenes. Of a scene, T1 is the measured step on one process, C, L, B and R
are by the formulas (1) to (4) of docs/model.md, and M by the bound of the pool that the full model prints.
model.csv: the efficiencies that `pebble -dry_run -report_processes` prints of a scene (`strong`, `weak`), in the cuts of
the program; its phases share T1 as simulated/costs.csv says. In rows of `least`, particles has those that a process of
a full cube needs for that efficiency.
"""

import argparse
import os
import re
import sys
import tempfile

from data import BOXES, DIRECT, POOL, PROCESSES, ROOT, rows, runs, simulations

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
X = {k: v for k, (v, _, _) in ALL.items()}
HOP = X["latency"] + X["post"]
# Of a step: exchanges, those of them of motions, and the numbers of a node in sums and motions, here without those for each axis.
STEPS = {"usl": (2, 1, (1, 2), 2), "usf": (4, 2, (1, 2), 3), "musl": (4, 2, (1, 3), 3)}


def dry_run(args, path, *options, constants=""):
    """What the full model says of a scene: {what: number}, and `rows`, {processes: step, imbalance, step of the pool}."""
    command = [args.pebble, "-options_file", path, "-output_format", "none", *options, "-dry_run", "-report_processes"]
    done = launch.run(command, capture_output=True, text=True)
    if done.returncode or f"constants {constants}" not in done.stdout:
        sys.exit(f"constants.py: {' '.join(map(str, command))}\n{done.stdout[-800:]}{done.stderr[-800:]}")
    table = re.findall(r"^ +(\d+) +(\S+) +\S+ \w+ +\S+ +\S+ +(\S+)(?: +(\S+) +\S+ \w+ +\S+)?$", done.stdout, re.M)
    found = {"rows": {int(p): [float(t or "nan") for t in step] for p, *step in table}}
    for name, pattern in (("bound", r"exceeds a speed-up of (\S+);"), ("particles", r"^scene .*  (\d+) particles"), ("bytes", r"^fields .* (\d+) B/particle")):
        found[name] = float(re.search(pattern, done.stdout, re.M)[1])
    found["least"] = re.findall(r"[:,] (\S+) on (\d+)", re.search(r"^  spatial keeps 0.9.*", done.stdout, re.M)[0])
    return found


class Scene:
    def __init__(self, args, folder, name):
        self.args, self.folder, self.scene = args, folder, scenes.SCENES[name]
        self.costs = {r["name"]: 1e-9 * r["ns"] for r in rows("simulated/costs.csv") if r["scene"] == name}
        one = next(r for r in runs("strong", "measured") if (r["scene"], r["processes"]) == (name, 1))
        self.total, self.T1, self.d = one["particles"], one["seconds_per_step"], self.scene.dim
        self.patches = {(r["study"], r["ranks"]): r["pool_cells"] for study in ("strong", "weak") for r in simulations(study, "injected simulation")
                        if (r["scene"], r["way"]) == (name, POOL)}  # fmt: skip

    def said(self, size, migrate, edge):
        """What the full model says, with the constants of a file written here."""
        path = scenes.write(self.folder, self.scene.name, size)
        phases = {k: t for k, t in self.costs.items() if k not in ("LEAVER", "SWARM", "SWARM_PARTICLE")}
        slower = self.T1 / self.total / sum(phases.values())
        lines = ["method any", "from constants.py"]
        for phase, t in phases.items():  # those of nodes are known for each particle
            each = slower * t * (2**self.d if phase in ("VELOCITY", "ADVANCE") else 1)
            lines.append(f"rate {phase} 0 1 {each} 2 {each} 3 {each}")
        # A network carries bytes while the master of a pool packs others: the longer of both counts.
        numbers = {k: X[k] for k in ("post", "wire", "kept", "job")} | dict(exchange=0, copy=0, message=HOP, reduction=HOP, pool=max(0, X["pool"] - X["wire"]))
        swarm = self.costs["SWARM"], self.costs["SWARM_PARTICLE"], X["wire"] * self.leaving
        for k, way in enumerate((swarm, (0, 0, swarm[2] + self.costs["LEAVER"] / 2))):
            numbers |= {f"migration[{k}].{what}": t for what, t in zip(("call", "particle", "leaver"), way)}
        file = f"{path}.model"
        with open(file, "w") as f:
            f.write("\n".join([*lines, *(f"{k} {v}" for k, v in numbers.items())]) + "\n")
        return dry_run(self.args, path, "-output_dir", self.folder, "-parallel_migrate", migrate, "-pool_cells", edge, "-model_file", file, constants="constants.py")

    def constants(self):
        d, (exchanges, motions, (sums, per_axis), moved) = self.d, STEPS[self.scene.update]
        reach, tile = (1, 2) if self.scene.basis == "linear" else (2, 4)
        said = dry_run(self.args, scenes.write(self.folder, self.scene.name, self.scene.strong), "-output_dir", self.folder)
        self.leaving = 16 + said["bytes"]  # B of a particle on its way, with its cell and what says where it goes
        latency = exchanges * (2**d - 1) * X["post"] + motions * (HOP - X["post"]) + d * (HOP + X["post"])
        ghost = 8 * ((sums + per_axis * d) * ((tile + reach) / tile) ** (d - 1) * X["kept"] + moved * d * X["wire"])
        # direct: half of the cost of a particle that leaves arises at either end, and both ends wait at the same time.
        face = d * (reach / 2 ** (d - 1) * ghost + X["wire"] * self.leaving + self.costs["LEAVER"] / 2)
        edge, each = self.patches["strong", 8], self.T1 / self.total
        master = each / self.said(self.scene.strong, "direct", edge)["bound"]
        yield "dimensions", d, "", "tools/scenes.py"
        yield "particles", self.total, "", "scaling/runs.csv"
        yield "T1", f"{self.T1:.4g}", "s", "scaling/runs.csv: measured on one process"
        yield "leaver", f"{self.costs['LEAVER']:.4g}", "s/particle", "simulated/costs.csv: a particle that changes process, by a calibration"
        for name, t, unit, k in (("C", each, "s/particle", 1), ("L", latency, "s", 2), ("B", face, "s/particle of a face", 3), ("R", HOP, "s", 4), ("M", master, "s/particle", 5)):
            yield name, f"{t:.4g}", unit, f"model.md ({k})"
        yield "patch", edge, "cells", "simulated/strong.csv: the edge of the pool's patches"

    def rows(self, study, size, processes):
        """Efficiencies on these numbers of processes."""
        edge = self.patches[study, processes[-1]]
        for migrate in ("direct", "swarm"):
            said = self.said(size, migrate, edge)
            for p in (p for p in processes if p in said["rows"]):
                spatial, imbalance, pool = said["rows"][p]
                for way, t, i in ((f"spatial {migrate}", spatial, imbalance), ("pool", pool, 1))[: 2 if migrate == "direct" else 1]:
                    yield self.scene.name, study, way, p, f"{said['particles']:.6g}", f"{said['rows'][1][0] / t / p:.4g}", f"{i:.4g}"

    def all_rows(self):
        yield from self.rows("strong", self.scene.strong, PROCESSES[1:])
        if self.scene.name in BOXES:
            for p in PROCESSES[1:]:
                yield from self.rows("weak", self.scene.weak(p), [p])
            for n, p in self.said(self.scene.strong, "direct", self.patches["strong", 8])["least"]:
                yield self.scene.name, "least", "spatial direct", p, n, 0.9, 1


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pebble", default=os.path.join(ROOT, "pebble"))
    args = parser.parse_args()
    constants, found = [("all", name, f"{value:g}", unit, source) for name, (value, unit, source) in ALL.items()], []
    with tempfile.TemporaryDirectory() as folder:
        for name in scenes.SCENES:
            scene = Scene(args, folder, name)
            constants += [(name, *line) for line in scene.constants()]
            found += scene.all_rows()
        disks = dry_run(args, os.path.join(ROOT, "options", "disks.opts"), "-grid_cells", "1024,1024", "-output_dir", folder)
    found.append(("disks", "balance", "spatial direct", 32, f"{disks['particles']:.6g}", "", f"{disks['rows'][32][1]:.4g}"))
    for file, head, lines in (
        ("constants", ("scene", "constant", "value", "unit", "source"), constants),
        ("model", ("scene", "study", "way", "processes", "particles", "efficiency", "imbalance"), found),
    ):
        scenes.table(os.path.join(ROOT, "docs", "data", f"{file}.csv"), [dict(zip(head, line)) for line in lines])


if __name__ == "__main__":
    main()
