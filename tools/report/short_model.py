#!/usr/bin/env python3
"""The models of docs/model.md: the short one, of five constants, and the full one (src/cost), asked by predict.c.

    short_model.py options/disks.opts output/disks.model 1e6    constants and speed-ups of a scene with 10^6 particles

The constants are differences of the full model with the constants of a calibration, so both have the same program and
machine behind them. The full model cuts the scene as the program does it; the short one has cubes. Times are in s.
"""

import argparse
import math
import os
import re
import subprocess
import sys
import tempfile
from dataclasses import dataclass

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
sys.path.insert(0, os.path.join(ROOT, "tools"))
import launch  # noqa: E402 (after the path)

NEAR = 20000  # particles for which differences are taken: their data fit into the caches of a process of a large run
ALWAYS = 1e9  # particles that change process in a step: a migration in every step
PROCESSES = (2, 4, 8, 16, 32)
SHARE = "particles nodes ghosts neighbours processes axes crossing row waits".split()  # of a process: MPMShare


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
        return self.speedup(n * processes, processes, imbalance) / processes

    def most(self, total):
        """The number of processes on which even cubes are fastest: there a tenth of a per mille more of them is as good."""
        return bisect(2.0, lambda p: self.step(total, 1.0001 * p) >= self.step(total, p))

    def least(self, efficiency, processes, imbalance=1.0):
        """The least number of particles a process for this efficiency (isoefficiency), or infinity."""
        possible = 1 / efficiency > imbalance
        return bisect(1.0, lambda n: self.efficiency(n, processes, imbalance) >= efficiency) if possible else math.inf

    def pool(self, processes):
        """The speed-up of a pool."""
        return min(self.bound(), (processes - 1) * self.C / (self.C + self.M)) if processes > 1 else 1.0

    def bound(self):
        """What the speed-up of a pool cannot exceed; 1 + bound() workers reach it."""
        return self.C / self.M


def bisect(low, reached):
    """The least number above `low` for which something is reached."""
    high = 1e18
    while high / low > 1 + 1e-9:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if reached(middle) else (middle, high)
    return high


class Model:
    """The full model of a scene's method. Facts of the method: `method`, `dim`, `stencil`, `tile`, `travels`, and in
    `phases` the kind of each phase, nodes or particles. Its constants, to be set: `rates` has for each phase the numbers
    of a file's line (a call, then three times: at so many, so much each), `numbers` the others."""

    def __init__(self, program, *options):
        self.command, self.rates, self.numbers, self.direct, self.phases = [program, *options, "-dry_run"], {}, {}, True, {}
        for name, *words in map(str.split, self.run("").partition("ready\n")[0].splitlines()):
            if name == "phase":
                self.phases[words[0]] = words[1]
            else:
                setattr(self, name, words[0] if name == "method" else int(words[0]))

    def run(self, requests):
        done = launch.run(self.command, input=requests, stdout=subprocess.PIPE, text=True)
        return done.stdout if not done.returncode else sys.exit(f"{' '.join(map(str, self.command))} fails")

    def ask(self, *requests):
        """The words of the answers to requests, each a tuple of words and numbers."""
        text = "".join(" ".join(w if isinstance(w, str) else f"{w:.17g}" for w in request) + "\n" for request in requests)
        answers = self.run(f"direct {int(self.direct)}\n{self.lines()}{text}").partition("ready\n")[2].splitlines()
        return [answer.split() for answer in answers]

    def steps(self, *shares):
        """Seconds of a step of each share."""
        requests = [("step", *(share.get(name, name == "processes") for name in SHARE)) for share in shares]
        return [float(t) for t, in self.ask(*requests)]

    def lines(self):
        """The constants as lines of a file."""
        rates = (f"rate {name} " + " ".join(f"{v:.17g}" for v in values) for name, values in self.rates.items())
        return "".join(line + "\n" for line in (*rates, *(f"{k} {v:.17g}" for k, v in self.numbers.items())))

    def load(self, path):
        """Takes the constants of a file that `make calibrate` wrote, for vectors of any width."""
        with open(path) as f:
            text = f.read()
        found, ours = (re.sub(r"^(\d-D:\d+:\d+:)\d+", r"\1", m) for m in (*re.findall(r"^method (\S+)", text, re.M), self.method))
        if found != ours:
            raise ValueError(f"{path}: no constants of the method {self.method}")
        self.rates = {name: list(map(float, values.split())) for name, values in re.findall(r"^rate (\w+) (.*)", text, re.M)}
        self.numbers = {k: float(v) for k, v in re.findall(r"^([a-z]+(?:\[\d\]\.[a-z]+)?) ([-+.\deE]+)$", text, re.M)}

    def short(self, per_cell, total, edge):
        """The five constants for cubes with so many particles a cell, and for the pool with patches of this edge, which
        has a scene of `total` particles."""
        d, n = self.dim, NEAR
        face = n ** (1 - 1 / d)  # particles of one face; nodes of it are fewer
        alone = dict(particles=n, nodes=n / per_cell)
        two = alone | dict(neighbours=2**d - 1, axes=d, crossing=ALWAYS, processes=2)
        sides = two | dict(ghosts=d * (self.stencil - 1) * (n / per_cell) ** (1 - 1 / d), row=d * face, waits=1)
        one, two, sides, on_2, on_4 = self.steps(alone, two, sides, alone | {"processes": 2}, alone | {"processes": 4})
        ((_, busy),) = self.ask(("master", total, total / per_cell, 2, edge))
        return Short(d, one / n, two - one - (on_4 - on_2), (sides - two) / face, on_4 - on_2, float(busy) / total)


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
        m = Model(args.predictor, "-options_file", args.options, "-output_dir", folder)
        m.load(args.calibration)
        total, per_cell = args.particles, args.per_cell or 2**m.dim
        s = m.short(per_cell, total, int(m.ask(("edge", total, total / per_cell, 8))[0][0]))
    for name, of in zip("CLBRM", ("a particle", "a step", "a particle of a face", "a doubling of the processes", "a particle for the master of a pool")):
        print(f"{name} {getattr(s, name):.3g} s {of}")
    print(f"spatial is fastest on about {s.most(total):.3g} processes")
    print(f"the pool's bound is {s.bound():.3g}, which {1 + s.bound():.3g} workers reach")
    for p in args.processes:
        spatial = s.speedup(total, p, args.imbalance if p > 1 else 1)
        print(f"  {p:7}  spatial S {spatial:9.2f}  E {spatial / p:.3f}   pool S {s.pool(p):7.3f}")


if __name__ == "__main__":
    main()
