#!/usr/bin/env python3
"""The short model of docs/model.md: five constants, and the speed-up of each strategy from them.

    short_model.py options/disks.opts output/disks.model 1e6    constants and speed-ups of a scene with 10^6 particles

The constants are differences of the full model (src/cost, asked by predict.c) with the constants of a calibration, so
both have the same program and machine behind them. The full model cuts the scene as the program does it; the short
one has cubes.
"""

import argparse
import math
import os
import tempfile
from dataclasses import dataclass

import model

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
NEAR = 20000  # particles for which differences are taken: their data fit into the caches of a process of a large run
ALWAYS = 1e9  # particles that change process in a step: a migration in every step
PROCESSES = (2, 4, 8, 16, 32)


@dataclass
class Short:
    """The five constants, in s: of a particle; of a step that has neighbours; of a particle of a face of a
    process's cube; of each doubling of the processes; of a particle, for the master of a pool."""

    dim: int
    C: float
    L: float
    B: float
    R: float
    M: float

    def step(self, total, processes, imbalance=1.0):
        """Seconds of a step of spatial decomposition."""
        if processes == 1:
            return self.C * total
        n = total / processes
        return imbalance * self.C * n + self.L + self.B * n ** (1 - 1 / self.dim) + self.R * math.log2(processes)

    def speedup(self, total, processes, imbalance=1.0):
        return self.C * total / self.step(total, processes, imbalance)

    def efficiency(self, n, processes, imbalance=1.0):
        """That of n particles a process."""
        return self.C * n / self.step(n * processes, processes, imbalance)

    def most(self, total):
        """The number of processes on which even cubes are fastest, and more are slower."""
        low, high = 2.0, 1e18
        while high / low > 1 + 1e-9:
            a, b = low * (high / low) ** (1 / 3), low * (high / low) ** (2 / 3)
            low, high = (low, b) if self.step(total, a) < self.step(total, b) else (a, high)
        return low

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
        return min(self.bound(), (processes - 1) * self.C / (self.C + self.M)) if processes > 1 else 1.0

    def bound(self):
        """What the speed-up of a pool cannot exceed; 1 + bound() workers reach it."""
        return self.C / self.M


def short(m, per_cell, total, edge):
    """The five constants of a model for cubes with so many particles a cell, and for the pool with patches of this
    edge, which has a scene of `total` particles."""
    d, n = m.dim, NEAR
    alone, migrating = dict(particles=n, nodes=n / per_cell), dict(neighbours=2**d - 1, axes=d, crossing=ALWAYS, processes=2)
    one, two, doubling = m.step(**alone), m.step(**alone, **migrating), m.step(**alone, processes=4) - m.step(**alone, processes=2)
    face = n ** (1 - 1 / d)  # particles of one face; nodes of it are fewer
    ghosts = d * (m.stencil - 1) * (n / per_cell) ** (1 - 1 / d)
    sides = m.step(**alone, **migrating, ghosts=ghosts, row=d * face, waits=1) - two
    return Short(d, one / n, two - one - doubling, sides / face, doubling, m.busy(total, total / per_cell, edge) / total)


def show(s, total, processes, imbalance):
    """Prints the constants and what follows from them."""
    what = "a particle", "a step", "a particle of a face", "a doubling of the processes", "a particle for the master of a pool"
    for name, words in zip("CLBRM", what):
        print(f"{name} {getattr(s, name):.3g} s {words}")
    print(f"spatial is fastest on about {s.most(total):.3g} processes")
    print(f"the pool's bound is {s.bound():.3g}, which {1 + s.bound():.3g} workers reach")
    for p in processes:
        spatial = s.speedup(total, p, imbalance if p > 1 else 1)
        print(f"  {p:7}  spatial S {spatial:9.2f}  E {spatial / p:.3f}   pool S {s.pool(p):7.3f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("options", help="options file of a scene")
    parser.add_argument("calibration", help="file of its constants, by make calibrate")
    parser.add_argument("particles", type=float, help="of the whole scene")
    parser.add_argument("--per-cell", type=float, help="particles a cell; without it 2 an axis")
    parser.add_argument("--imbalance", type=float, default=1.0, help="largest over mean number of particles of a process")
    parser.add_argument("--processes", type=lambda text: [int(p) for p in text.split(",")], default=[1, *PROCESSES])
    parser.add_argument("--predictor", default=os.path.join(ROOT, "build", "mpicc", "predict"))
    args = parser.parse_args()
    for path in (args.predictor, args.options, args.calibration):
        if not os.path.exists(path):
            parser.error(f"{path} is not there; make calibrate SCENE=<options file> builds and writes it")
    with tempfile.TemporaryDirectory() as folder:
        m = model.Model(args.predictor, "-options_file", args.options, "-output_dir", folder)
        m.load(args.calibration)
        per_cell = args.per_cell or 2**m.dim
        edge = int(m.ask("edge", args.particles, args.particles / per_cell, 8)[0])
        show(short(m, per_cell, args.particles, edge), args.particles, args.processes, args.imbalance)


if __name__ == "__main__":
    main()
