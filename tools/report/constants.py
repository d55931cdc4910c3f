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
import sys
import tempfile

import model
from data import POOL, ROOT, rows, runs, simulations
from short_model import PROCESSES, short

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


def calibrated(name):
    """Costs of a scene's phases and migrations, s, as injected into simulations."""
    return {r["name"]: 1e-9 * r["ns"] for r in rows("simulated/costs.csv") if r["scene"] == name}


def recorded(study, name, processes):
    """The edge of the patches of a simulated run of the pool."""
    return next(r["pool_cells"] for r in simulations(study, "injected simulation") if (r["scene"], r["way"], r["ranks"]) == (name, POOL, processes))


class Scene:
    """A scene with its constants, for `pebble -dry_run` and predict.c."""

    def __init__(self, args, folder, name):
        self.args, self.folder, self.scene = args, folder, scenes.SCENES[name]
        self.options = ["-output_dir", folder, "-output_format", "none"]
        path = scenes.write(folder, name, self.scene.strong)
        p = model.Predictor(args.predictor, "-options_file", path, *self.options)
        self.per_cell, costs, fixed = 2**p.dim, calibrated(name), {k: v for k, (v, _, _) in ALL.items()}
        each = {phase: costs[phase] * (self.per_cell if p.phases.get(phase) == "nodes" else 1) for phase in (*p.phases, "SORT")}
        self.model = model.Model(p, {k: [0, 1, t, 2, t, 3, t] for k, t in each.items()}, origin="constants.csv")
        hop = fixed["latency"] + fixed["post"]
        # A network carries bytes while the master of a pool packs others: the longer of both counts.
        self.model.numbers = dict(exchange=0, copy=0, message=hop, reduction=hop, post=fixed["post"], wire=fixed["wire"], kept=fixed["kept"],
                                  job=fixed["job"], pool=max(0, fixed["pool"] - fixed["wire"]))
        for way, word in enumerate(("swarm", "direct")):
            self.model.numbers |= {
                f"migration[{way}].call": costs["SWARM"] * (word == "swarm"),
                f"migration[{way}].particle": costs["SWARM_PARTICLE"] * (word == "swarm"),
                # direct: half of the cost arises at either end, and both ends wait at the same time; the bytes are the network's
                f"migration[{way}].leaver": (0.5 * costs["LEAVER"] if word == "direct" else 0) + fixed["wire"] * (12 + p.travels),
            }
        self.one = next(r for r in runs("strong", "measured") if (r["scene"], r["processes"]) == (name, 1))
        self.model = self.model.slower(self.one["seconds_per_step"] / self.said(path, "direct", 2)["rows"][1]["spatial"])
        total = self.one["particles"]
        self.edge = recorded("strong", name, 8)
        self.short = short(self.model, self.per_cell, total, self.edge)
        self.short.C = self.one["seconds_per_step"] / total

    def said(self, path, migrate, edge):
        """What `pebble -dry_run -report_processes` says by this model."""
        file = os.path.join(self.folder, f"{self.scene.name}.model")
        self.model.save(file)
        command = [self.args.pebble, "-options_file", path, *self.options, "-parallel_migrate", migrate, "-pool_cells", edge]
        done = launch.run([*command, "-dry_run", "-report_processes", "-model_file", file], capture_output=True, text=True)
        said = model.parse(done.stdout)
        if done.returncode or said.get("constants") != self.model.origin:
            sys.exit(f"constants.py: {' '.join(map(str, command))}\n{done.stdout[-800:]}{done.stderr[-800:]}")
        return said

    def constants(self):
        name, s = self.scene.name, self.short
        yield name, "dimensions", s.dim, "", "tools/scenes.py"
        yield name, "particles", self.one["particles"], "", "scaling/runs.csv"
        yield name, "T1", f"{self.one['seconds_per_step']:.4g}", "s", "scaling/runs.csv: measured on one process"
        yield name, "C", f"{s.C:.4g}", "s/particle", "T1/N"
        yield name, "L", f"{s.L:.4g}", "s", "model.md (2)"
        yield name, "B", f"{s.B:.4g}", "s/particle of a face", "model.md (3)"
        yield name, "R", f"{s.R:.4g}", "s", "model.md (4)"
        yield name, "M", f"{s.M:.4g}", "s/particle", "model.md (5)"
        yield name, "patch", self.edge, "cells", "simulated/strong.csv: the edge of the pool's patches"

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
        steps = {"weak": self.said(scenes.write(self.folder, self.scene.name, self.scene.small), "direct", self.edge)["rows"][1]["spatial"] / 16384}
        for p in PROCESSES:
            yield from self.rows("weak", self.scene.weak(p), [p], steps)
        moved, m, q = self.said(scenes.write(self.folder, self.scene.name, self.scene.strong), "direct", self.edge)["moved"], self.model, self.per_cell
        for way in ("direct", "swarm"):
            m.direct = way == "direct"
            for p in (2**k for k in range(1, 21)):
                e = m.step(m.cube(16384, q, 1, moved)) / m.step(m.cube(16384, q, p, moved))
                yield self.row("cubes", f"spatial {way}", p, 16384 * p, e, 1)
        m.direct = True
        for e in (0.8, 0.9):
            for p in REACH:
                yield self.row("least", "spatial direct", p, float(f"{m.least(q, p, moved, e):.3g}"), e, 1)


def balance(args, folder):
    """Imbalance of the two disks on 32 processes."""
    command = [args.pebble, "-options_file", os.path.join(ROOT, "options", "disks.opts"), "-grid_cells", "1024,1024", "-dry_run"]
    done = launch.run([*command, "-output_dir", folder, "-report_processes"], capture_output=True, text=True)
    found = model.parse(done.stdout)
    return "disks", "balance", "spatial direct", 32, found["particles"], "", f"{found['rows'][32]['imbalance']:.4g}"


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
            constants += scene.constants()
            found += scene.all_rows()
        found.append(balance(args, folder))
    for file, head, lines in (
        ("constants", ("scene", "constant", "value", "unit", "source"), constants),
        ("model", ("scene", "study", "way", "processes", "particles", "efficiency", "imbalance"), found),
    ):
        scenes.table(os.path.join(args.out, f"{file}.csv"), [dict(zip(head, line)) for line in lines])


if __name__ == "__main__":
    main()
