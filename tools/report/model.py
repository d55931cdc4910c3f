"""The full model, as the program has it: predict.c, a program made of src/cost, answers about constants and shares of a
run that are sent to it. Times are in s, sizes in particles, nodes and bytes."""

import atexit
import contextlib
import os
import re
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
import launch  # noqa: E402 (after the path)

SHARE = "particles nodes ghosts neighbours processes axes crossing row waits".split()  # of a process: MPMShare


class Model:
    """The model of a scene's method. Facts of the method: `method`, `dim`, `stencil`, `tile`, `travels`, and in `phases`
    the kind of each phase, nodes or particles. Its constants, to be set: `rates` has for each phase the numbers of a
    file's line (a call, then three times: at so many, so much each), `numbers` the others."""

    def __init__(self, program, *options):
        self.folder, command = contextlib.ExitStack(), [program, *map(str, options), "-dry_run"]
        environment = self.folder.enter_context(launch.own_folder())
        self.run = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment)
        atexit.register(self.close)
        self.rates, self.numbers, self.origin, self.direct, self.sent, self.phases = {}, {}, "", True, None, {}
        while (line := self.run.stdout.readline().split()) != ["ready"]:
            if not line:
                raise RuntimeError(f"{' '.join(command)} does not answer")
            if line[0] == "phase":
                self.phases[line[1]] = line[2]
            else:
                setattr(self, line[0], line[1] if line[0] == "method" else int(line[1]))

    def close(self):
        self.run.stdin.close()
        self.run.stdout.close()
        self.run.wait()
        self.folder.close()

    def lines(self):
        """The constants as lines of a file."""
        rates = (f"rate {name} " + " ".join(f"{v:.17g}" for v in values) for name, values in self.rates.items())
        return "".join(line + "\n" for line in (*rates, *(f"{k} {v:.17g}" for k, v in self.numbers.items())))

    def save(self, path):
        with open(path, "w") as f:
            f.write(f"method {self.method}\nfrom {self.origin}\n" + self.lines())

    def load(self, path):
        """Takes the constants of a file that `make calibrate` wrote, for vectors of any width."""
        with open(path) as f:
            text = f.read()
        found = re.findall(r"^method (\S+)", text, re.M)
        if [re.sub(r"^(\d-D:\d+:\d+:)\d+", r"\1", m) for m in found] != [re.sub(r"^(\d-D:\d+:\d+:)\d+", r"\1", self.method)]:
            raise ValueError(f"{path}: no constants of the method {self.method}")
        self.rates = {name: list(map(float, values.split())) for name, values in re.findall(r"^rate (\w+) (.*)", text, re.M)}
        self.numbers = {k: float(v) for k, v in re.findall(r"^([a-z]+(?:\[\d\]\.[a-z]+)?) ([-+.\deE]+)$", text, re.M)}

    def slow(self, factor):
        """Makes all phases take so many times as long."""
        self.rates = {k: [v[0] * factor, *(x * (factor if i % 2 else 1) for i, x in enumerate(v[1:]))] for k, v in self.rates.items()}

    def ask(self, *request):
        """The words of the answer to a request."""
        state = f"clear\ndirect {int(self.direct)}\n" + self.lines()
        if state != self.sent:
            self.run.stdin.write(state)
            self.sent = state
        self.run.stdin.write(" ".join(w if isinstance(w, str) else f"{w:.17g}" for w in request) + "\n")
        self.run.stdin.flush()
        return self.run.stdout.readline().split() or sys.exit(f"predict: no answer to {request}")

    def step(self, **share):
        return float(self.ask("step", *(share.get(name, name == "processes") for name in SHARE))[0])

    def cube(self, n, per_cell, processes, moved):
        """Seconds of a step on one of many full cubes of n particles each, the fastest of which moves by `moved` cells."""
        return float(self.ask("cube", n, per_cell, processes, moved)[0])

    def dealt(self, particles, nodes, edge):
        """Jobs of the pool in a step with patches of edge^dim cells, and the bytes to and from the master."""
        found = {name: float(v) for name, v in (word.split("=") for word in self.ask("dealt", particles, nodes, edge))}
        return found.pop("jobs"), sum(found.values())

    def busy(self, particles, nodes, edge):
        """Seconds of a step for which the master of a pool is busy."""
        return float(self.ask("master", particles, nodes, 2, edge)[1])


def parse(text):
    """What `pebble -dry_run -report_processes` prints of the model."""
    out = {"rows": {}}
    for p, spatial, imbalance, pool in re.findall(r"^ +(\d+) +(\S+) +\S+ \w+ +\S+ +\S+ +(\S+)(?: +(\S+) +\S+ \w+ +\S+)?$", text, re.M):
        out["rows"][int(p)] = {"spatial": float(spatial), "imbalance": float(imbalance), "pool": float(pool) if pool else None}
    for name, pattern in (("bound", r"no number of workers exceeds a speed-up of (\S+);"), ("speed", r"\|v\|=(\S+) m/s"), ("dt", r"   dt=(\S+) s"),
                          ("particles", r"^scene .*  (\d+) particles"), ("constants", r"^model +constants (.*)")):  # fmt: skip
        if m := re.search(pattern, text, re.M):
            out[name] = m[1] if name == "constants" else float(m[1])
    return out
