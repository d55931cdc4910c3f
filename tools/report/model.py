"""The performance model, as the program has it: constants, shares of a run, and what a program made of src/cost (predict.c) answers
about them. Here is what the program has no words for: full boxes in given cuts, more expensive materials, another network.

Symbols are those of docs/report.md, section 5. Times are in s, sizes in particles, nodes and bytes.
"""

import atexit
import contextlib
import itertools
import math
import os
import re
import subprocess
import sys
from dataclasses import astuple, dataclass, field, replace  # noqa: F401 (replace is for others)
from typing import NamedTuple

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
import launch  # noqa: E402 (after the path)


@dataclass
class Share:
    """The share of one process: particles, nodes, ghost nodes as tiles send them, neighbours; the whole run's number of processes;
    axes that are cut; of the whole run the particles that change process in a step; particles of a row along the cuts here, and the
    probability that a row crosses a cut of an axis."""

    particles: float
    nodes: float
    ghosts: float = 0
    neighbours: float = 0
    processes: int = 1
    axes: int = 0
    crossing: float = 0
    row: float = 0
    waits: float = 0
    received: float = -1  # ghost nodes of the processes below whose sums come here; negative: as many as its own

    def words(self):
        return " ".join(f"{v:.17g}" for v in astuple(self))


class Part(NamedTuple):
    """A part of an axis of a box: its particles in units of a cell's, its nodes, the ghost nodes above, and those of the part below
    that lie in it."""

    particles: float
    nodes: int
    above: int
    below: int


@dataclass
class Rate:
    call: float
    size: tuple
    each: tuple


class Phase(NamedTuple):
    name: str
    kind: str  # to_nodes, nodes, to_particles
    forces: bool  # sums them
    bytes: int  # of a particle, to a worker of the pool and back


class Predictor:
    """predict.c at work for the method of a scene: facts of the method, and answers for a model."""

    def __init__(self, program, *options):
        command = [program, *options, "-dry_run"]
        self.folder = contextlib.ExitStack()
        environment = self.folder.enter_context(launch.own_folder())
        self.run = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment)
        atexit.register(self.close)
        self.known, self.phases = None, []
        while (line := self.run.stdout.readline().split()) != ["ready"]:
            if not line:
                raise RuntimeError(f"{' '.join(command)} does not answer")
            if line[0] == "phase":
                self.phases.append(Phase(line[1], line[2], line[3] == "forces", int(line[4])))
            elif line[0] == "method":
                self.method = line[1]
            else:
                setattr(self, line[0], int(line[1]))  # dim, stencil, tile, travels

    def close(self):
        self.run.stdin.close()
        self.run.stdout.close()
        self.run.wait()
        self.folder.close()

    def ask(self, model, requests):
        """The answers to some requests, each a line."""
        state = model.lines() + f"direct {int(model.direct)}\n"
        if state != self.known:
            self.run.stdin.write("clear\n" + state)
            self.known = state
        answers = []
        for k in range(0, len(requests), 64):  # more at once could fill the pipes in both directions
            some = requests[k : k + 64]
            self.run.stdin.write("".join(r + "\n" for r in some))
            self.run.stdin.flush()
            answers += [self.run.stdout.readline().strip() for _ in some]
        if not all(answers):
            raise RuntimeError(f"predict: no answer to {requests[answers.index('')]}")
        return answers


def named(answer):
    return {name: float(value) for name, value in (word.split("=") for word in answer.split())}


@dataclass
class Model:
    predictor: Predictor
    rates: dict = field(default_factory=dict)
    numbers: dict = field(default_factory=dict)
    direct: bool = True
    origin: str = ""

    @property
    def dim(self):
        return self.predictor.dim

    def lines(self):
        """The constants as lines of a file."""
        rates = (f"rate {k} {r.call:.17g} " + " ".join(f"{n:.17g} {e:.17g}" for n, e in zip(r.size, r.each)) for k, r in self.rates.items())
        return "".join(line + "\n" for line in (*rates, *(f"{k} {v:.17g}" for k, v in self.numbers.items())))

    def ask(self, *request):
        return self.predictor.ask(self, [" ".join(w if isinstance(w, str) else f"{w:.17g}" for w in request)])[0]

    # ---- What the program says
    def parts(self, s):
        """Seconds of each part of a step in spatial decomposition: the phases first, then those that every step has, then others that
        take time."""
        found = named(self.ask("parts", s.words()))
        first = dict.fromkeys([p.name for p in self.predictor.phases] + ["SORT", "SETTLE", "MIGRATE", "REDUCE", "other"])
        return {name: found[name] for name in first} | {name: t for name, t in found.items() if name not in first and t > 0}

    def step(self, s):
        return float(self.ask("step", s.words()))

    def farmed(self, s, edge):
        """Jobs of the pool in a step with patches of edge^dim cells, and for each phase the bytes to and from the master; s is the share
        of a run on one process."""
        size = named(self.ask("dealt", s.particles, s.nodes, edge))
        return size.pop("jobs"), size

    def pool(self, s, edge):
        """Seconds of a step with processes - 1 workers and patches of edge^dim cells, and those for which the master is busy;
        s is the share of a run on one process."""
        return tuple(map(float, self.ask("master", s.particles, s.nodes, s.processes, edge).split()))

    def patch(self, s):
        """The edge of the patches with which the predicted step on 8 processes is shortest, as `-dry_run` looks for it."""
        return int(self.ask("edge", s.particles, s.nodes, 8))

    def cube(self, n, per_cell, processes, moved):
        """One of many full cubes of n particles each, the fastest of which moves by `moved` cells a step."""
        return Share(*map(float, self.ask("cube", n, per_cell, processes, moved).split()))

    def least(self, per_cell, processes, moved, efficiency=0.9):
        """The least number of particles a process at which full cubes keep this efficiency."""
        return float(self.ask("least", per_cell, processes, moved, efficiency))

    # ---- Shares of full boxes
    def ghosts(self, sides):
        """Ghost nodes of a full box, [(own nodes, nodes above)] an axis, as its tiles send them: on an axis where it is above the
        box a node is in the last tile alone, so at an edge or a corner fewer tiles reach it than at a side."""
        one = 1 + (self.predictor.stencil - 1) / self.predictor.tile  # tiles that reach a node, on an axis
        return (math.prod(one * own + above for own, above in sides) - math.prod(one * own for own, _ in sides)) / one ** (self.dim - 1)

    def axis(self, cells, parts, up):
        """One axis of a full box between walls, cut into parts as even as tiles allow. Near walls a spline's stencil is moved
        onto the grid, so the first and the last cell of stencils have more particles. up: which way halves are rounded."""
        reach = self.predictor.stencil - 1
        n = cells + 1 - reach
        load = [1.0] * n + [0.0] * reach
        load[0] += (cells - n) / 2
        load[n - 1] += (cells - n) / 2
        tile = self.predictor.tile
        edges = [tile * k for k in range((cells + 1) // tile)] + [cells + 1]
        cuts, total = [0], 0.0
        for a, b in zip(edges, edges[1:-1]):
            one = sum(load[a:b])
            total += one
            while len(cuts) < parts and total + (0 if up else one / 2 + 1e-9) >= len(cuts) * cells / parts:
                cuts.append(b)
        cuts.append(cells + 1)
        return [Part(sum(load[a:b]), b - a, min(reach, cells + 1 - b), min(reach, a)) for a, b in zip(cuts, cuts[1:])]

    def box(self, cells, cut, per_cell, crossing, waits=0):
        """Seconds of a step, and the imbalance, of a full box that is cut into cut[0] x cut[1] ... boxes. Both are of the slowest process,
        for the better rounding of the cuts. crossing and waits are those of Share."""
        found = []
        for ups in itertools.product((False, True), repeat=len(cut)):
            shares, most = [], 0.0
            for where in itertools.product(*(set(self.axis(c, p, up)) for c, p, up in zip(cells, cut, ups))):
                own = math.prod(w.particles for w in where)
                layer = (math.prod(w.particles + w.above for w in where) - own) / (self.predictor.stencil - 1)
                shares.append(
                    Share(
                        particles=own * per_cell,
                        nodes=math.prod(w.nodes for w in where),
                        ghosts=self.ghosts([(w.nodes, w.above) for w in where]),
                        neighbours=2 ** sum(w.above > 0 for w in where) - 1,
                        processes=math.prod(cut),
                        axes=sum(p > 1 for p in cut),
                        crossing=crossing,
                        row=layer * per_cell ** (1 - 1 / self.dim),
                        waits=waits,
                        received=self.ghosts([(w.nodes, w.below) for w in where]),
                    )
                )
                most = max(most, own)
            steps = self.predictor.ask(self, [f"step {s.words()}" for s in shares])
            found.append((max(map(float, steps)), most * math.prod(cut) / math.prod(cells)))
        return min(found)

    # ---- Other constants
    def with_(self, **numbers):
        return replace(self, rates=dict(self.rates), numbers=self.numbers | numbers)

    def with_network(self, message, post, wire, reduction):
        """The same processor with another network; the messages of a migration change with it. What an
        exchange costs beyond its messages is the waiting of two processes of this machine, so it is no property of a network. A
        network carries bytes while the master of a pool packs others, where processes that share memory copy them: the longer of
        both counts."""
        return self.with_(
            exchange=0,
            pool=max(0, self.numbers["pool"] - wire),
            message=message,
            post=post,
            wire=wire,
            reduction=reduction,
        )

    def dearer(self, seconds):
        """The model with a law that takes so many seconds more for each particle and evaluation; it is evaluated once a step, in the sum
        of forces."""
        other = self.with_()
        name = next(p.name for p in self.predictor.phases if p.forces)
        r = other.rates[name]
        other.rates[name] = Rate(r.call, r.size, tuple(e + seconds for e in r.each))
        return other


def load(path, predictor):
    """Reads a model from a file that `make calibrate` wrote."""
    with open(path) as f:
        text = f.read()
    method = re.search(r"^method (\S+)", text, re.M)
    if not method or lanes(method[1], "") != lanes(predictor.method, ""):
        raise ValueError(f"{path}: no constants of the method {predictor.method}")
    model = Model(predictor, origin=(re.search(r"^from (.*)", text, re.M) or ["", ""])[1])
    for name, values in re.findall(r"^rate (\w+) (.*)", text, re.M):
        call, *pairs = map(float, values.split())
        model.rates[name] = Rate(call, tuple(pairs[::2]), tuple(pairs[1::2]))
    for name, value in re.findall(r"^([a-z]+(?:\[\d\]\.[a-z]+)?) ([-+.\deE]+)$", text, re.M):
        model.numbers[name] = float(value)
    return model


def lanes(method, number):
    """The method with this number of lanes: the constants of a machine with vectors of another width are as good."""
    return re.sub(r"^(\d-D:\d+:\d+:)\d+", rf"\g<1>{number}", method)


def save(model, path):
    """Writes the model to a file, for the program of this machine."""
    with open(path, "w") as f:
        f.write(f"method {model.predictor.method}\nfrom {model.origin}\n" + model.lines())


# ---- What the program says
def parse(text):
    """Reads the table that `pebble -dry_run -report_processes` prints of the model, and the lines below it."""
    out = {"rows": {}, "blocks": {}}
    for line in text.splitlines():
        if m := re.match(r" +(\d+) +(\S+) +\S+ \w+ +\S+ +(\S+) +(\S+)(?: +(\S+) +\S+ \w+ +\S+)?$", line):
            out["rows"][int(m[1])] = {
                "spatial": float(m[2]),
                "efficiency": float(m[3]),
                "imbalance": float(m[4]),
                "pool": float(m[5]) if m[5] else None,
            }
        if m := re.search(r"no number of workers exceeds a speed-up of (\S+);", line):
            out["bound"] = float(m[1])
        if m := re.search(r"best patches on 8 processes (\d+)", line):
            out["patch"] = int(m[1])
        if m := re.search(r"spatial is (?:ahead from (\d+) processes on|never ahead)", line):
            out["ahead"] = m[1] or "none"
        if "spatial keeps 0.9" in line:
            out["blocks"] = {int(p): float(n) for n, p in re.findall(r"([-+.\de]+) on (\d+)", line)}
        if m := re.search(r"\|v\|=(\S+) m/s   dt=(\S+) s", line):
            out["speed"], out["dt"] = float(m[1]), float(m[2])
        if m := re.match(r"scene .* (\d+) particles", line):
            out["particles"] = int(m[1])
        if m := re.match(r"kernels .* (\d+) lanes", line):
            out["lanes"] = int(m[1])
        if m := re.match(r"model +constants (.*)", line):
            out["constants"] = m[1]
    return out
