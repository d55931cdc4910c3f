#!/usr/bin/env python3
"""The short model of docs/model.md: five constants, and the speed-up S(P) of each strategy from them.

    short_model.py options/disks.opts output/disks.model 1e6    constants and speed-ups of a scene with 10^6 particles
    short_model.py --write                                      the tables of docs/model.md, beside the full model

The constants are differences of the full model (src/cost, asked by predict.c) with the constants of a calibration, so
both have the same program and machine behind them. The full model cuts the scene as the program does it; the short
one has cubes. The scenes of the page are those of tools/simulate, on the assumed cluster of closed.py.
"""

import argparse
import math
import os
import sys
import tempfile
from dataclasses import dataclass
from types import SimpleNamespace

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
sys.path[:0] = [os.path.join(ROOT, "tools"), os.path.join(ROOT, "tools", "simulate")]
import launch  # noqa: E402 (after the path)
import marks  # noqa: E402
import model  # noqa: E402
import simulate  # noqa: E402
from closed import NETWORK  # noqa: E402
from data import Data  # noqa: E402
from scenes import SCENES  # noqa: E402

NEAR = 20000  # particles for which the constants are taken: their data fit into the caches of a process of a large run
ALWAYS = 1e9  # particles that change process in a step: a migration in every step
PROCESSES = (2, 4, 8, 16, 32)


@dataclass
class Short:
    """The five constants, in s: of a particle; of a step that has neighbours; of a particle of a face of a
    process's cube; of each doubling of the processes; of a particle, for the master of a pool."""

    dim: int
    particle: float
    latency: float
    face: float
    doubling: float
    master: float

    def step(self, total, processes, imbalance=1.0):
        """Seconds of a step of spatial decomposition."""
        n = total / processes
        if processes == 1:
            return self.particle * total
        return (
            imbalance * self.particle * n
            + self.latency
            + self.face * n ** (1 - 1 / self.dim)
            + self.doubling * math.log2(processes)
        )

    def speedup(self, total, processes, imbalance=1.0):
        return self.particle * total / self.step(total, processes, imbalance)

    def efficiency(self, n, processes, imbalance=1.0):
        """That of n particles a process."""
        return self.particle * n / self.step(n * processes, processes, imbalance)

    def most(self, total):
        """The number of processes on which even cubes without faces are fastest; more of them are slower."""
        return math.log(2) * self.particle * total / self.doubling

    def least(self, efficiency, processes, imbalance=1.0):
        """The least number of particles a process for this efficiency (isoefficiency), or infinity."""
        if 1 / efficiency <= imbalance:
            return math.inf
        low, high = 1.0, 1e18
        while high / low > 1 + 1e-9:
            middle = math.sqrt(low * high)
            low, high = (low, middle) if self.efficiency(middle, processes, imbalance) >= efficiency else (middle, high)
        return high

    def pool(self, processes):
        """The speed-up of a pool."""
        if processes == 1:
            return 1.0
        return min(self.bound(), (processes - 1) * self.particle / (self.particle + self.master))

    def bound(self):
        """What the speed-up of a pool cannot exceed."""
        return self.particle / self.master

    def workers(self):
        """The workers that reach it."""
        return 1 + self.bound()


def short(m, per_cell, total, edge):
    """The five constants of a model for cubes with so many particles a cell, and for the pool with patches of this
    edge, which has a scene of `total` particles."""
    d, n = m.dim, NEAR

    def step(**more):
        return m.step(model.Share(n, n / per_cell, **more))

    def migrating(**more):
        return step(neighbours=2**d - 1, axes=d, crossing=ALWAYS, **more)

    alone, doubling = step(), step(processes=4) - step(processes=2)
    two = migrating(processes=2)
    face = n ** (1 - 1 / d)  # particles of one face; nodes of it are fewer
    ghosts = d * (m.predictor.stencil - 1) * (n / per_cell) ** (1 - 1 / d)
    sides = migrating(processes=2, ghosts=ghosts, row=d * face, waits=1) - two
    busy = m.pool(model.Share(total, total / per_cell, processes=2), edge)[1]
    return Short(d, alone / n, two - alone - doubling, sides / face, doubling, busy / total)


class Scenes:
    """The models of the scenes of tools/simulate."""

    def __init__(self, args):
        self.args, self.data, self.work = args, Data(os.path.join(ROOT, "docs", "data")), tempfile.TemporaryDirectory()
        simulate.WORK = simulate.Path(self.work.name)
        self.predictors = {}

    def options(self, name):
        return [
            "-options_file",
            simulate.write_scene(name, SCENES[name].strong, 40),
            "-output_dir",
            self.work.name,
        ]

    def calibration(self, dim):
        """The constants of the filled box in so many dimensions."""
        file = self.data.model(f"box{dim}d")
        with open(file) as f:
            method = next(line.split()[1] for line in f if line.startswith("method "))
        return model.load(file, SimpleNamespace(method=method, dim=dim))

    def full(self, name):
        """The full model of a scene: the costs of its phases as injected (costs.csv), all else of the calibration
        of the filled box with as many dimensions, and the network of the cluster. Also the particles a cell."""
        if name not in self.predictors:
            self.predictors[name] = model.Predictor(self.args.predictor, *map(str, self.options(name)))
        p = self.predictors[name]
        per_cell = 2**p.dim  # in all of these scenes
        m = self.calibration(p.dim).with_network(**NETWORK)
        m.predictor, m.origin, m.rates = p, "costs.csv", {}
        costs = self.data.costs()[name]
        for phase in [*p.phases, SimpleNamespace(name="SORT", kind="")]:
            each = costs[phase.name] * (per_cell if phase.kind == "nodes" else 1)
            m.rates[phase.name] = model.Rate(0, (1, 2, 3), (each, each, each))
        return m, per_cell

    def said(self, name, m, edge):
        """What `pebble -dry_run -report_processes` prints of the scene by this model, with a pool whose patches
        have this edge."""
        file = os.path.join(self.work.name, f"{name}.model")
        model.save(m, file)
        command = [
            self.args.pebble,
            *self.options(name),
            "-parallel_migrate",
            "direct",
            "-dry_run",
            "-report_processes",
        ]
        command += ["-model_file", file, "-pool_cells", edge]
        done = launch.run(command, capture_output=True, text=True)
        said = model.parse(done.stdout)
        if done.returncode or said.get("constants") != m.origin:
            sys.exit(f"short_model.py: {' '.join(map(str, command))}\n{done.stdout[-800:]}{done.stderr[-800:]}")
        return said

    def compare(self, name):
        """What the table of a scene needs: its particles, the short model, the best edge of the pool's patches, the
        bound of the pool by the program, and rows of processes, imbalance as the program counts it, and speed-ups
        by the short and the full model, of spatial decomposition and of the pool."""
        m, per_cell = self.full(name)
        total = self.said(name, m, 2)["particles"]
        edge = m.patch(model.Share(total, total / per_cell))
        said, s = self.said(name, m, edge), short(m, per_cell, total, edge)
        one, rows = said["rows"][1]["spatial"], []
        for p in PROCESSES:
            row = said["rows"][p]
            i = row["imbalance"]
            rows.append((p, i, s.speedup(total, p, i), one / row["spatial"], s.pool(p), one / row["pool"]))
        return total, s, edge, said["bound"], rows


def worst(found, ours, theirs):
    """The rows of all scenes by their difference in per cent, the largest first: (per cent, scene, row)."""
    off = [(100 * (row[ours] / row[theirs] - 1), name, row) for name, (*_, rows) in found.items() for row in rows]
    return sorted(off, key=lambda one: -abs(one[0]))


def sign(x, digits=1):
    return f"{x:+.{digits}f} %".replace("-", "\N{MINUS SIGN}")


# ---- The page
class Page:
    """Tables and numbers of docs/model.md."""

    def __init__(self, scenes):
        self.scenes, self.found = scenes, {name: scenes.compare(name) for name in SCENES}
        self.off = worst(self.found, 2, 3)
        self.pool_off = worst(self.found, 4, 5)

    def table_constants(self):
        lines = []
        for name, (total, s, edge, _, _) in self.found.items():
            five = (
                f"{1e9 * s.particle:.1f} ns",
                f"{1e6 * s.latency:.1f} µs",
                f"{1e9 * s.face:.0f} ns",
                f"{1e6 * s.doubling:.1f} µs",
            )
            lines.append([name, f"{total:,}".replace(",", " "), *five, f"{1e9 * s.master:.1f} ns", edge])
        return marks.markdown(
            ["scene", "particles N", "C", "L", "B", "R", "M", "edge of the pool's patches, cells"], lines
        )

    def table_example(self):
        total, s, _, _, rows = self.found["box2d"]
        known, lines = {row[0]: row for row in rows}, []
        for p in (1, *PROCESSES, 128, 1024):
            n = total / p
            parts = (
                s.particle * n,
                *((s.latency, s.face * math.sqrt(n), s.doubling * math.log2(p)) if p > 1 else (0, 0, 0)),
            )
            ours, (_, _, _, full, _, full_pool) = s.speedup(total, p), known.get(p, [math.nan] * 6)
            figures = [f"{v:.2f}" if v == v else "" for v in (ours, ours / p, full, s.pool(p), full_pool)]
            lines.append([p, *(f"{1e6 * t:.1f}" for t in (*parts, sum(parts))), *figures])
        head = [
            "P",
            "C n, µs",
            "L, µs",
            "B √n, µs",
            "R log2 P, µs",
            "T, µs",
            "S",
            "E",
            "S, full model",
            "S, pool",
            "pool, full model",
        ]
        return marks.markdown(head, lines)

    def table_limits(self):
        lines = []
        for name, (total, s, *_) in self.found.items():
            least = [f"{s.least(0.8, p):,.0f}".replace(",", " ") for p in (32, 1024, 32768)]
            lines.append(
                [name, f"{s.most(total):,.0f}".replace(",", " "), *least, f"{s.bound():.2f}", f"{s.workers():.1f}"]
            )
        head = [
            "scene",
            "P of the largest S",
            "n for E = 0.8 on 32",
            "on 1 024",
            "on 32 768",
            "the pool's bound",
            "its workers",
        ]
        return marks.markdown(head, lines)

    def table_distance(self):
        lines = [
            [name, row[0], f"{row[1]:.3f}", f"{row[2]:.2f}", f"{row[3]:.2f}", sign(off)] for off, name, row in self.off
        ]
        return marks.markdown(["scene", "P", "i", "S, short", "S, full", "short / full - 1"], lines[:12])

    def table_pool_distance(self):
        lines = [[name, row[0], f"{row[4]:.2f}", f"{row[5]:.2f}", sign(off)] for off, name, row in self.pool_off]
        return marks.markdown(["scene", "P", "S, short", "S, full", "short / full - 1"], lines[:6])

    def number_least(self):
        return sign(min(off for off, *_ in self.off), 0)

    def number_most(self):
        return sign(max(off for off, *_ in self.off), 0)

    def number_pool_least(self):
        return sign(min(off for off, *_ in self.pool_off), 0)

    def number_pool_most(self):
        return sign(max(off for off, *_ in self.pool_off), 0)

    def number_within(self):
        return f"{sum(abs(off) <= 5 for off, *_ in self.off)} of {len(self.off)}"

    def number_cache(self):
        m = self.scenes.calibration(2)
        least, most = (
            sum(m.rates[name].each[k] for name in ("P2G", "G2P", "SORT")) + m.rates["ADVANCE"].each[k] / 4
            for k in (1, 2)
        )
        return sign(100 * (most / least - 1), 0).lstrip("+")

    def write(self, path):
        with open(path) as f:
            text = f.read()
        for name in marks.names(text):
            text = marks.renew(text, name, getattr(self, f"table_{name}")())
        text = marks.numbers(text, lambda name: getattr(self, f"number_{name}")())
        with open(path, "w") as f:
            f.write(text)


def show(s, total, processes, imbalance):
    """Prints the constants and what follows from them."""
    print(f"C {s.particle:.3g} s a particle")
    print(f"L {s.latency:.3g} s a step")
    print(f"B {s.face:.3g} s a particle of a face")
    print(f"R {s.doubling:.3g} s a doubling of the processes")
    print(f"M {s.master:.3g} s a particle for the master of a pool")
    print(f"spatial is fastest on about {s.most(total):.3g} processes")
    print(f"the pool's bound is {s.bound():.3g}, which {s.workers():.3g} workers reach")
    for p in processes:
        spatial = s.speedup(total, p, imbalance if p > 1 else 1)
        print(f"  {p:7}  spatial S {spatial:9.2f}  E {spatial / p:.3f}   pool S {s.pool(p):7.3f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("options", nargs="?", help="options file of a scene")
    parser.add_argument("calibration", nargs="?", help="file of its constants, by make calibrate")
    parser.add_argument("particles", nargs="?", type=float, help="of the whole scene")
    parser.add_argument("--write", action="store_true", help="renew docs/model.md")
    parser.add_argument(
        "--cluster", action="store_true", help="with the network of the report's cluster, not that of the calibration"
    )
    parser.add_argument("--per-cell", type=float, help="particles a cell; without it 2 an axis")
    parser.add_argument(
        "--imbalance", type=float, default=1.0, help="largest over mean number of particles of a process"
    )
    parser.add_argument("--processes", type=lambda text: [int(p) for p in text.split(",")], default=[1, *PROCESSES])
    parser.add_argument("--pebble", default=os.path.join(ROOT, "pebble"))
    parser.add_argument("--predictor", default=os.path.join(ROOT, "build", "mpicc", "predict"))
    args = parser.parse_args()
    if not os.path.exists(args.predictor):
        parser.error(f"--predictor: {args.predictor} is not there; make calibrate builds it")
    for path in (args.options, args.calibration) if args.particles and not args.write else ():
        if not os.path.exists(path):
            parser.error(f"{path} is not there; make calibrate SCENE=<options file> writes a calibration")
    if args.write:
        Page(Scenes(args)).write(os.path.join(ROOT, "docs", "model.md"))
    elif args.particles:
        with tempfile.TemporaryDirectory() as folder:
            m = model.load(
                args.calibration, model.Predictor(args.predictor, "-options_file", args.options, "-output_dir", folder)
            )
            m = m.with_network(**NETWORK) if args.cluster else m
            per_cell = args.per_cell or 2**m.dim
            edge = m.patch(model.Share(args.particles, args.particles / per_cell))
            show(short(m, per_cell, args.particles, edge), args.particles, args.processes, args.imbalance)
    else:
        parser.error("options file, calibration and number of particles, or --write")


if __name__ == "__main__":
    main()
