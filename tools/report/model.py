"""The performance model of src/model.c once more, in Python, for what `pebble -dry_run` does not print: full cubes on up to a
million processes, more expensive materials, constants of another network. `agrees` compares it with the program.

Symbols are those of docs/report.md, section 5. Times are in s, sizes in particles, nodes and bytes.
"""

import copy
import itertools
import math
import re
from dataclasses import dataclass, field, replace
from typing import NamedTuple

NODES = {"linear": 2, "gimp": 3, "bspline2": 3, "bspline3": 4}  # nodes of the stencil along an axis
# The phases of a step have a name, a kind, fields in, fields out, and if they sum to nodes the sums (mass, momentum, force).
PHASES = {
    "usl": [
        ("P2G", "to_nodes", "x cell v F", "", "mpf"),
        ("ADVANCE", "nodes", "", "", ""),
        ("G2P", "to_particles", "id x cell v F", "x cell v F", ""),
    ],
    "usf": [
        ("P2G_MASS", "to_nodes", "x cell v", "", "mp"),
        ("VELOCITY", "nodes", "", "", ""),
        ("G2P_STRESS", "to_particles", "id x cell F", "F", ""),
        ("P2G_FORCE", "to_nodes", "x cell F", "", "f"),
        ("ADVANCE", "nodes", "", "", ""),
        ("G2P_MOTION", "to_particles", "id x cell v", "x cell v", ""),
    ],
    "musl": [
        ("P2G", "to_nodes", "x cell v F", "", "mpf"),
        ("ADVANCE", "nodes", "", "", ""),
        ("G2P_MOTION", "to_particles", "x cell v", "v dx", ""),
        ("P2G_MOMENTUM", "to_nodes", "x cell v", "", "p"),
        ("VELOCITY", "nodes", "", "", ""),
        ("G2P_STRESS", "to_particles", "id x cell F dx", "x cell F", ""),
    ],
}
TILE = {"linear": 2, "gimp": 4, "bspline2": 4, "bspline3": 4}  # cells of a tile on an axis


def log2(processes):
    return math.ceil(math.log2(processes)) if processes > 1 else 0


@dataclass
class Share:
    """The share of one process: particles, nodes, ghost nodes as tiles send them, neighbours; the whole run's number of processes, and
    of particles that change process in a step; particles of a row along the cuts here, and the probability that a row crosses a cut
    of an axis."""

    particles: float
    nodes: float
    ghosts: float = 0
    neighbours: float = 0
    processes: int = 1
    crossing: float = 0
    axes: int = 0  # axes that are cut
    row: float = 0
    waits: float = 0
    received: float = None  # ghost nodes of the processes below whose sums come here; None: as many as its own


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

    def seconds(self, n):
        each = self.each[0]
        for n0, n1, e0, e1 in zip(self.size, self.size[1:], self.each, self.each[1:]):
            if n > n0:
                each = e0 + min(1, math.log(n / n0) / math.log(n1 / n0)) * (e1 - e0)
        return self.call + n * each


@dataclass
class Model:
    dim: int
    basis: str
    update: str
    rates: dict = field(default_factory=dict)
    numbers: dict = field(default_factory=dict)
    direct: bool = True
    origin: str = ""

    # ---- Sizes of messages
    def bytes(self, fields):
        size = {"id": 8, "x": 8 * self.dim, "v": 8 * self.dim, "F": 8 * self.dim**2, "dx": 8 * self.dim, "cell": 4}
        return sum(size[f] for f in fields.split())

    def sums(self, parts):
        return sum({"m": 1, "p": self.dim, "f": self.dim}[p] for p in parts) + (3 - self.dim if parts == "mpf" else 0)

    def spread(self, power):
        """How many tiles reach a node, over `power` axes."""
        return (1 + (NODES[self.basis] - 1) / TILE[self.basis]) ** power

    def ghosts(self, sides):
        """Ghost nodes of a full box, [(own nodes, nodes above)] an axis, as its tiles send them: on an axis where it is above the
        box a node is in the last tile alone, so at an edge or a corner fewer tiles reach it than at a side."""
        one = self.spread(1)
        return (math.prod(one * own + above for own, above in sides) - math.prod(one * own for own, _ in sides)) / one ** (self.dim - 1)

    # ---- A step in spatial decomposition
    def parts(self, s):
        """Seconds of each part of a step."""
        m, none = self.numbers, Rate(0, (1,), (0,))
        t = {}
        posts = m["exchange"] + s.neighbours * m["post"] if s.neighbours > 0 else 0
        way = max(0, m["message"] - m["post"]) if s.neighbours > 0 else 0
        for name, kind, _, _, sums in PHASES[self.update]:
            rate = self.rates.get(name, none)
            if kind == "to_nodes":
                kept = s.ghosts if s.received is None else (s.ghosts + s.received) / 2
                t[name] = rate.seconds(s.particles) + posts + kept * self.spread(self.dim - 1) * self.sums(sums) * 8 * m["kept"]
            elif kind == "nodes":
                t[name] = rate.seconds(s.nodes) + posts + way + s.ghosts * 2 * self.dim * 8 * (m["wire"] + m["copy"])
            else:
                t[name] = rate.seconds(s.particles)
        for name in "SORT", "SETTLE":
            t[name] = self.rates.get(name, none).seconds(s.particles)
        way = {k: m[f"migration[{int(self.direct)}].{k}"] for k in ("call", "stage", "process", "particle", "leaver")}
        chance = 1 - math.exp(-s.crossing) if s.processes > 1 else 0
        stages = s.axes if self.direct else log2(s.processes)
        t["MIGRATE"] = chance * (
            way["call"] + way["stage"] * stages + way["particle"] * s.particles + way["process"] * s.processes
        ) + way["leaver"] * s.row * s.waits
        t["REDUCE"] = self.rates.get("REDUCE", none).call + log2(s.processes) * m["reduction"]
        t["other"] = self.rates.get("other", none).seconds(s.particles)
        return t

    def step(self, s):
        return sum(self.parts(s).values())

    # ---- A step in the pool
    def farmed(self, s, edge):
        """Patches of edge^dim cells, and for each phase of the pool the bytes to and from the master."""
        edge = math.ceil(edge / TILE[self.basis]) * TILE[self.basis]
        chunks, wide, size = max(1, s.nodes / edge**self.dim), (edge + NODES[self.basis] - 1) ** self.dim, {}
        for name, kind, fields, back, sums in PHASES[self.update]:
            if kind == "to_nodes":
                size[name] = s.particles * self.bytes(fields) + s.nodes * self.spread(self.dim) * 8 * self.sums(sums)
            elif kind == "to_particles":
                size[name] = s.particles * (self.bytes(fields) + self.bytes(back)) + chunks * wide * 8 * 2 * self.dim
        return chunks, size

    def pool(self, s, edge):
        """Seconds of a step with processes - 1 workers and patches of edge^dim cells, and those for which the master is busy;
        s is the share of a run on one process."""
        m, busy, total = self.numbers, 0.0, 0.0
        alone = self.parts(replace(s, processes=1))
        chunks, sizes = self.farmed(s, edge)
        for name, size in sizes.items():
            one = alone.pop(name)
            master = chunks * (m["job"] + m["message"]) + size * (m["pool"] + m["wire"])
            work = self.rates[name].seconds(s.particles) if name in self.rates else one
            busy += master
            total += max(master, (work + master) / min(s.processes - 1, chunks)) + (work + 2 * master) / chunks
        rest = sum(alone.values())
        return total + rest, busy + rest

    def patch(self, s):
        """The edge of the patches with which the predicted step on 8 processes is shortest, as `-dry_run` looks for it."""
        s, tile = replace(s, processes=8), TILE[self.basis]
        return min(range(tile, 257, tile), key=lambda c: self.pool(s, c)[0])

    # ---- Shares
    def cube(self, n, per_cell, processes, moved):
        """One of many full cubes of n particles each, the fastest of which moves by `moved` cells a step."""
        reach, cells = NODES[self.basis] - 1, n / per_cell
        side = cells ** (1 / self.dim)
        s = Share(n, (side + reach) ** self.dim, processes=processes)
        if processes > 1:
            s.ghosts = self.ghosts([(side, reach)] * self.dim)
            s.neighbours, s.axes = 2**self.dim - 1, self.dim
            layer, rows, cuts = self.dim * cells / side, per_cell ** (1 / self.dim), processes ** (1 / self.dim) - 1
            s.crossing = moved * processes * layer * per_cell
            s.row, s.waits = layer * per_cell / rows, 1 - (1 - min(1, rows * moved)) ** cuts
        return s

    def axis(self, cells, parts, up):
        """One axis of a full box between walls, cut into parts as even as tiles allow. Near walls a spline's stencil is moved
        onto the grid, so the first and the last cell of stencils have more particles. up: which way halves are rounded."""
        reach = NODES[self.basis] - 1
        n = cells + 1 - reach
        load = [1.0] * n + [0.0] * reach
        load[0] += (cells - n) / 2
        load[n - 1] += (cells - n) / 2
        tile = TILE[self.basis]
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
            slowest, most = 0.0, 0.0
            for where in itertools.product(*(set(self.axis(c, p, up)) for c, p, up in zip(cells, cut, ups))):
                own = math.prod(w.particles for w in where)
                layer = (math.prod(w.particles + w.above for w in where) - own) / (NODES[self.basis] - 1)
                above = 2 ** sum(w.above > 0 for w in where) - 1
                s = Share(
                    own * per_cell,
                    math.prod(w.nodes for w in where),
                    self.ghosts([(w.nodes, w.above) for w in where]),
                    above,
                    math.prod(cut),
                    crossing,
                    sum(p > 1 for p in cut),
                    layer * per_cell ** (1 - 1 / self.dim),
                    waits,
                    self.ghosts([(w.nodes, w.below) for w in where]),
                )
                slowest, most = max(slowest, self.step(s)), max(most, own)
            found.append((slowest, most * math.prod(cut) / math.prod(cells)))
        return min(found)

    # ---- Other constants
    def with_(self, **numbers):
        other = copy.deepcopy(self)
        other.numbers.update(numbers)
        return other

    def with_network(self, message, post, wire, reduction):
        """The same processor with another network; the part of migration that is messages changes with it, as in tools/calibrate. What an
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
            **{"migration[0].stage": 24 * reduction, "migration[1].stage": message + post, "migration[0].process": 80 * wire},
        )

    def dearer(self, seconds):
        """The model with a law that takes so many seconds more for each particle and evaluation; it is evaluated once a step, in the sum
        of forces."""
        other = copy.deepcopy(self)
        name = next(p[0] for p in PHASES[self.update] if "f" in p[4])
        r = other.rates[name]
        other.rates[name] = Rate(r.call, r.size, tuple(e + seconds for e in r.each))
        return other


def load(path):
    """Reads a model from a file that `make calibrate` wrote."""
    with open(path) as f:
        text = f.read()
    method = re.search(r"^method (\d)-D:(\d+):\S*", text, re.M)
    if not method:
        raise ValueError(f"{path}: no line `method`")
    bases = ["linear", "gimp", "bspline2", "bspline3"]
    update = "usl" if ":G2P." in method[0] else "usf" if ":P2G_MASS." in method[0] else "musl"
    model = Model(int(method[1]), bases[int(method[2])], update, origin=(re.search(r"^from (.*)", text, re.M) or ["", ""])[1])
    number = r"([-+.\deE]+)"
    for name, values in re.findall(r"^rate (\w+) (.*)", text, re.M):
        call, *pairs = map(float, values.split())
        model.rates[name] = Rate(call, tuple(pairs[::2]), tuple(pairs[1::2]))
    for name, value in re.findall(rf"^([a-z]+(?:\[\d\]\.[a-z]+)?) {number}$", text, re.M):
        model.numbers[name] = float(value)
    return model


def save(model, path, like, lanes=None):
    """Writes a calibration's file `like` with the rates and numbers of this model; with `lanes`, as if it were of so many lanes."""
    with open(like) as f:
        text = f.read()

    def rate(found):
        r = model.rates.get(found[1], Rate(0, (1, 2, 3), (0, 0, 0)))
        pairs = " ".join(f"{n:g} {each:.8g}" for n, each in zip(r.size, r.each))
        return f"rate {found[1]} {r.call:.8g} {pairs}"

    text = re.sub(r"^rate (\w+) .*", rate, text, flags=re.M)
    if lanes:
        text = re.sub(r"^(method \d-D:\d+:\d+:)\d+", rf"\g<1>{lanes}", text, flags=re.M)
    for name, value in model.numbers.items():
        text = re.sub(rf"^{re.escape(name)} .*$", f"{name} {value:.8g}", text, flags=re.M)
    with open(path, "w") as f:
        f.write(text)


# ---- What the program says
def parse(text):
    """Reads the table that `pebble -dry_run` prints of the model, and the lines below it."""
    out = {"rows": {}, "blocks": {}}
    for line in text.splitlines():
        if m := re.match(r" +(\d+) +(\S+) +(\S+) +(\S+) +(\S+)(?: +(\S+) +(\S+))?$", line):
            out["rows"][int(m[1])] = {
                "spatial": float(m[2]),
                "efficiency": float(m[4]),
                "imbalance": float(m[5]),
                "pool": float(m[6]) if m[6] else None,
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
        if m := re.match(r"scene .* (\d+) (?:point|particle)s", line):
            out["particles"] = int(m[1])
        if m := re.match(r"kernels .* (\d+) lanes", line):
            out["lanes"] = int(m[1])
        if m := re.match(r"model +constants (.*)", line):
            out["constants"] = m[1]
    return out


def blocks(model, per_cell, processes, moved, efficiency=0.9):
    """The least number of particles a process at which full cubes keep this efficiency."""
    n = 64.0
    while n < 1e9:
        if model.step(model.cube(n, per_cell, 1, moved)) >= efficiency * model.step(
            model.cube(n, per_cell, processes, moved)
        ):
            return n
        n *= 1.02
    return 0.0


def agrees(model, said, cells, edge=16, tolerance=0.02):
    """Compares this module with the program for a full box of cells; returns a list of sentences that say where they differ."""
    nodes = math.prod(c + 1 for c in cells)
    whole, wrong = Share(said["particles"], nodes), []

    def hold(what, ours, theirs, allowed=tolerance):
        if abs(ours - theirs) > allowed * abs(theirs):
            wrong.append(f"{what}: {ours:.4g} here, {theirs:.4g} from the program")

    hold("step on one process", model.step(whole), said["rows"][1]["spatial"])
    for p, row in said["rows"].items():
        if row["pool"]:
            hold(f"step of the pool on {p}", model.pool(replace(whole, processes=p), edge)[0], row["pool"])
    best = (model.pool(replace(whole, processes=8), c)[0] for c in (model.patch(whole), said["patch"]))
    hold("step of the pool on 8 with the best patches", *best)
    total, busy = model.pool(replace(whole, processes=8), edge)
    hold("bound of the pool", model.step(whole) / busy, said["bound"], max(tolerance, 0.006 / said["bound"]))
    moved = said["speed"] * said["dt"]  # cells of 1 m
    for p, n in said["blocks"].items():
        hold(f"particles for 0.9 on {p}", blocks(model, said["particles"] / nodes, p, moved), n, 0.04)
    return wrong
