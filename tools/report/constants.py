#!/usr/bin/env python3
"""Makes docs/data/constants.csv, the constants of all closed forms in docs, and docs/data/model.csv, what the full model
(src/cost) says with the same constants. No time is measured here: `make report` calls it, and the test `report_made`.

constants.csv: `all` has what is the same in all scenes; for each scene `T1` is the measured step on one process, `C` =
T1/N, and L, B, R, M follow from the formulas of docs/model.md. The phases of the full model share T1 as costs.csv says.
model.csv: speed-ups of a scene (`strong`, `weak`) in the cuts of the program, and of cubes of 16 384 particles (`cubes`);
in rows of `least` the column particles has those a process needs for the efficiency that they have.
"""

import argparse
import os
import re
import sys
import tempfile
from dataclasses import replace

from data import POOL, ROOT, rows, runs, simulations
from short_model import PROCESSES, Model

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
REACH = 2, 32, 1024, 32768, 1000000


def recorded(study, name, processes):
    """The edge of the patches of a simulated run of the pool."""
    return next(r["pool_cells"] for r in simulations(study, "injected simulation") if (r["scene"], r["way"], r["ranks"]) == (name, POOL, processes))


def dry_run(command, constants=None):
    """What `-dry_run -report_processes` prints of the model, which has to have constants of this origin."""
    done = launch.run([*command, "-dry_run", "-report_processes"], capture_output=True, text=True)
    out = {"rows": {}}
    for p, spatial, imbalance, pool in re.findall(r"^ +(\d+) +(\S+) +\S+ \w+ +\S+ +\S+ +(\S+)(?: +(\S+) +\S+ \w+ +\S+)?$", done.stdout, re.M):
        out["rows"][int(p)] = {"spatial": float(spatial), "imbalance": float(imbalance), "pool": float(pool or "nan")}
    for name, pattern in (("bound", r"no number of workers exceeds a speed-up of (\S+);"), ("speed", r"\|v\|=(\S+) m/s"), ("dt", r"   dt=(\S+) s"),
                          ("particles", r"^scene .*  (\d+) particles")):  # fmt: skip
        if m := re.search(pattern, done.stdout, re.M):
            out[name] = float(m[1])
    if done.returncode or constants and f"constants {constants}\n" not in done.stdout:
        sys.exit(f"constants.py: {' '.join(map(str, command))}\n{done.stdout[-800:]}{done.stderr[-800:]}")
    return out


class Scene:
    """A scene with its constants, for `pebble -dry_run` and predict.c."""

    def __init__(self, args, folder, name):
        self.args, self.folder, self.scene, fixed = args, folder, scenes.SCENES[name], {k: v for k, (v, _, _) in ALL.items()}
        self.options, path = ["-output_dir", folder, "-output_format", "none"], scenes.write(folder, name, self.scene.strong)
        m = self.model = Model(args.predictor, "-options_file", path, *self.options)
        costs = {r["name"]: 1e-9 * r["ns"] for r in rows("simulated/costs.csv") if r["scene"] == name}
        self.per_cell, hop = 2**m.dim, fixed["latency"] + fixed["post"]
        for phase in (*m.phases, "SORT"):
            t = costs[phase] * (self.per_cell if m.phases.get(phase) == "nodes" else 1)
            m.rates[phase] = [0, 1, t, 2, t, 3, t]
        # A network carries bytes while the master of a pool packs others: the longer of both counts.
        m.numbers = dict(exchange=0, copy=0, message=hop, reduction=hop, pool=max(0, fixed["pool"] - fixed["wire"])) | {k: fixed[k] for k in ("post", "wire", "kept", "job")}
        bytes_ = fixed["wire"] * (12 + m.travels)  # of a particle that migrates
        # direct: half of the cost arises at either end, and both ends wait at the same time.
        for k, (call, particle, leaver) in enumerate(((costs["SWARM"], costs["SWARM_PARTICLE"], bytes_), (0, 0, bytes_ + 0.5 * costs["LEAVER"]))):
            m.numbers |= {f"migration[{k}].call": call, f"migration[{k}].particle": particle, f"migration[{k}].leaver": leaver}
        self.leaver = costs["LEAVER"]
        self.one = next(r for r in runs("strong", "measured") if (r["scene"], r["processes"]) == (name, 1))
        slower = self.one["seconds_per_step"] / self.said(path, "direct", 2)["rows"][1]["spatial"]
        m.rates = {k: [0, 1, t * slower, 2, t * slower, 3, t * slower] for k, (_, _, t, *_) in m.rates.items()}
        total, self.edge = self.one["particles"], recorded("strong", name, 8)
        self.short = replace(m.short(self.per_cell, total, self.edge), C=self.one["seconds_per_step"] / total)

    def said(self, path, migrate, edge):
        """What `pebble -dry_run -report_processes` says by this model."""
        file = os.path.join(self.folder, f"{self.scene.name}.model")
        with open(file, "w") as f:
            f.write(f"method {self.model.method}\nfrom {file}\n" + self.model.lines())
        return dry_run([self.args.pebble, "-options_file", path, *self.options, "-parallel_migrate", migrate, "-pool_cells", edge, "-model_file", file], file)

    def constants(self):
        t, formulas = self.one["seconds_per_step"], (("L", "s", 2), ("B", "s/particle of a face", 3), ("R", "s", 4), ("M", "s/particle", 5))
        yield "dimensions", self.short.dim, "", "tools/scenes.py"
        yield "particles", self.one["particles"], "", "scaling/runs.csv"
        yield "T1", f"{t:.4g}", "s", "scaling/runs.csv: measured on one process"
        yield "leaver", f"{self.leaver:.4g}", "s/particle", "simulated/costs.csv: a particle that changes process, by a calibration"
        yield "C", f"{self.short.C:.4g}", "s/particle", "T1/N"
        yield from ((name, f"{getattr(self.short, name):.4g}", unit, f"model.md ({k})") for name, unit, k in formulas)
        yield "patch", self.edge, "cells", "simulated/strong.csv: the edge of the pool's patches"

    def rows(self, study, size, processes, steps):
        """Rows of one size of the scene. `steps`: of one process, for weak scaling."""
        path = scenes.write(self.folder, self.scene.name, size)
        edge = self.edge if study == "strong" else recorded(study, self.scene.name, processes[0])
        for migrate in ("direct", "swarm"):
            said = self.said(path, migrate, edge)
            steps.setdefault(study, said["rows"][1]["spatial"] / said["particles"])
            for p in (p for p in processes if p in said["rows"]):
                row, one = said["rows"][p], steps[study] * said["particles"]
                yield self.row(study, f"spatial {migrate}", p, said["particles"], one / row["spatial"] / p, row["imbalance"])
                if migrate == "direct":
                    yield self.row(study, "pool", p, said["particles"], one / row["pool"] / p, 1)

    def row(self, study, way, processes, particles, efficiency, imbalance):
        return self.scene.name, study, way, processes, f"{particles:.6g}", f"{efficiency:.4g}", f"{imbalance:.4g}"

    def all_rows(self):
        yield from self.rows("strong", self.scene.strong, PROCESSES, {})
        if not isinstance(self.scene.small, tuple):
            return
        said = self.said(scenes.write(self.folder, self.scene.name, self.scene.small), "direct", self.edge)
        for p in PROCESSES:
            yield from self.rows("weak", self.scene.weak(p), [p], {"weak": said["rows"][1]["spatial"] / said["particles"]})
        said, m, q = self.said(scenes.write(self.folder, self.scene.name, self.scene.strong), "direct", self.edge), self.model, self.per_cell
        moved = said["speed"] * said["dt"]  # cells are of 1 m
        for way in ("swarm", "direct"):
            m.direct, sizes = way == "direct", [2**k for k in range(21)]
            one, *steps = (float(t) for t, in m.ask(*(("cube", 16384, q, p, moved) for p in sizes)))
            yield from (self.row("cubes", f"spatial {way}", p, 16384 * p, one / t, 1) for p, t in zip(sizes[1:], steps))
        asked = [(e, p) for e in (0.8, 0.9) for p in REACH]
        for (e, p), (n,) in zip(asked, m.ask(*(("least", q, p, moved, e) for e, p in asked))):
            yield self.row("least", "spatial direct", p, float(f"{float(n):.3g}"), e, 1)


def balance(args, folder):
    """Imbalance of the two disks on 32 processes."""
    found = dry_run([args.pebble, "-options_file", os.path.join(ROOT, "options", "disks.opts"), "-grid_cells", "1024,1024", "-output_dir", folder])
    return "disks", "balance", "spatial direct", 32, int(found["particles"]), "", f"{found['rows'][32]['imbalance']:.4g}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pebble", default=os.path.join(ROOT, "pebble"))
    parser.add_argument("--predictor", default=os.path.join(ROOT, "build", "mpicc", "predict"))
    parser.add_argument("--out", default=os.path.join(ROOT, "docs", "data"))
    args = parser.parse_args()
    constants = [("all", name, f"{value:g}", unit, source) for name, (value, unit, source) in ALL.items()]
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for name in scenes.SCENES:
            scene = Scene(args, folder, name)
            constants += [(name, *line) for line in scene.constants()]
            found += scene.all_rows()
        found.append(balance(args, folder))
    for file, head, lines in (
        ("constants", ("scene", "constant", "value", "unit", "source"), constants),
        ("model", ("scene", "study", "way", "processes", "particles", "efficiency", "imbalance"), found),
    ):
        scenes.table(os.path.join(args.out, f"{file}.csv"), [dict(zip(head, line)) for line in lines])


if __name__ == "__main__":
    main()
