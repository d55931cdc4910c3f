"""The performance model, as the program has it: predict.c, a program made of src/cost, answers about constants and
shares of a run that are sent to it. Times are in s, sizes in particles, nodes and bytes."""

import atexit
import contextlib
import os
import re
import subprocess
import sys
from dataclasses import astuple, dataclass, field, replace

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
import launch  # noqa: E402 (after the path)


@dataclass
class Share:
    """The share of one process: particles, nodes, ghost nodes as tiles send them, neighbours; the whole run's number of
    processes; axes that are cut; of the whole run the particles that change process in a step; particles of a row along
    the cuts here, and the probability that a row crosses a cut of an axis."""

    particles: float
    nodes: float
    ghosts: float = 0
    neighbours: float = 0
    processes: int = 1
    axes: int = 0
    crossing: float = 0
    row: float = 0
    waits: float = 0


class Predictor:
    """predict.c at work for the method of a scene: facts of the method, and answers for a model. `phases` has the kind
    of each phase (nodes or particles), `bytes` those that the pool's master sends and receives of a particle."""

    def __init__(self, program, *options):
        self.folder = contextlib.ExitStack()
        environment = self.folder.enter_context(launch.own_folder())
        command = [program, *map(str, options), "-dry_run"]
        self.run = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment)
        atexit.register(self.close)
        self.known, self.phases, self.bytes = None, {}, 0
        while (line := self.run.stdout.readline().split()) != ["ready"]:
            if not line:
                raise RuntimeError(f"{' '.join(command)} does not answer")
            if line[0] == "phase":
                self.phases[line[1]], self.bytes = line[2], self.bytes + int(line[3])
            else:  # method, dim, stencil, tile, travels
                setattr(self, line[0], line[1] if line[0] == "method" else int(line[1]))

    def close(self):
        self.run.stdin.close()
        self.run.stdout.close()
        self.run.wait()
        self.folder.close()

    def ask(self, model, *request):
        """The numbers of the answer to a request."""
        state = f"clear\ndirect {int(model.direct)}\n" + model.lines()
        if state != self.known:
            self.run.stdin.write(state)
            self.known = state
        self.run.stdin.write(" ".join(w if isinstance(w, str) else f"{w:.17g}" for w in request) + "\n")
        self.run.stdin.flush()
        if not (answer := self.run.stdout.readline().split()):
            raise RuntimeError(f"predict: no answer to {request}")
        return answer


@dataclass
class Model:
    """`rates`: for each phase the numbers of a file's line: a call, then three times [at so many, so much each]."""

    predictor: Predictor
    rates: dict = field(default_factory=dict)
    numbers: dict = field(default_factory=dict)
    origin: str = ""
    direct: bool = True

    def lines(self):
        """The constants as lines of a file."""
        rates = (f"rate {name} " + " ".join(f"{v:.17g}" for v in values) for name, values in self.rates.items())
        return "".join(line + "\n" for line in (*rates, *(f"{k} {v:.17g}" for k, v in self.numbers.items())))

    def save(self, path):
        with open(path, "w") as f:
            f.write(f"method {self.predictor.method}\nfrom {self.origin}\n" + self.lines())

    def slower(self, factor):
        """The model of a processor on which all phases take so many times as long."""
        scaled = {k: [v[0] * factor, *(x * (factor if i % 2 else 1) for i, x in enumerate(v[1:]))] for k, v in self.rates.items()}
        return replace(self, rates=scaled)

    def step(self, share):
        return float(self.predictor.ask(self, "step", *astuple(share))[0])

    def dealt(self, s, edge):
        """Jobs of the pool in a step with patches of edge^dim cells, and the bytes to and from the master; s is the
        share of a run on one process."""
        found = dict(word.split("=") for word in self.predictor.ask(self, "dealt", s.particles, s.nodes, edge))
        jobs = float(found.pop("jobs"))
        return jobs, sum(map(float, found.values()))

    def busy(self, s, edge):
        """Seconds of a step for which the master of a pool is busy."""
        return float(self.predictor.ask(self, "master", s.particles, s.nodes, 2, edge)[1])

    def patch(self, s):
        """The edge of the patches with which the predicted step on 8 processes is shortest, as `-dry_run` finds it."""
        return int(self.predictor.ask(self, "edge", s.particles, s.nodes, 8)[0])

    def cube(self, n, per_cell, processes, moved):
        """One of many full cubes of n particles each, the fastest of which moves by `moved` cells a step."""
        return Share(*map(float, self.predictor.ask(self, "cube", n, per_cell, processes, moved)))

    def least(self, per_cell, processes, moved, efficiency):
        """The least number of particles a process at which full cubes keep this efficiency; 0: none."""
        return float(self.predictor.ask(self, "least", per_cell, processes, moved, efficiency)[0])


def load(path, predictor):
    """Reads a model from a file that `make calibrate` wrote, for vectors of any width."""
    with open(path) as f:
        text = f.read()
    found, wanted = (re.sub(r"^(\d-D:\d+:\d+:)\d+", r"\1", m) for m in (*re.findall(r"^method (\S+)", text, re.M)[:1], predictor.method))
    if found != wanted:
        raise ValueError(f"{path}: no constants of the method {predictor.method}")
    model = Model(predictor, origin=re.search(r"^from (.*)", text, re.M)[1])
    model.rates = {name: list(map(float, values.split())) for name, values in re.findall(r"^rate (\w+) (.*)", text, re.M)}
    numbers = re.findall(r"^([a-z]+(?:\[\d\]\.[a-z]+)?) ([-+.\deE]+)$", text, re.M)
    model.numbers = {name: float(value) for name, value in numbers}
    return model


def parse(text):
    """What `pebble -dry_run -report_processes` prints of the model."""
    out = {"rows": {}}
    for line in text.splitlines():
        if m := re.match(r" +(\d+) +(\S+) +\S+ \w+ +\S+ +(\S+) +(\S+)(?: +(\S+) +\S+ \w+ +\S+)?$", line):
            row = {"spatial": float(m[2]), "imbalance": float(m[4]), "pool": float(m[5]) if m[5] else None}
            out["rows"][int(m[1])] = row
        if m := re.search(r"no number of workers exceeds a speed-up of (\S+);", line):
            out["bound"] = float(m[1])
        if m := re.search(r"\|v\|=(\S+) m/s   dt=(\S+) s", line):
            out["moved"] = float(m[1]) * float(m[2])  # m in a step
        if m := re.match(r"scene .* (\d+) particles", line):
            out["particles"] = int(m[1])
        if m := re.match(r"model +constants (.*)", line):
            out["constants"] = m[1]
    return out
