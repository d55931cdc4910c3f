"""The closed form of the report's scenes: constants, what the program prints of them, shares, comparison with the simulator."""

import math
import os
import re
import sys
import tempfile

import model
from data import ROOT, Data, Missing
from data import rows as rows_of

sys.path.insert(0, os.path.join(ROOT, "tools"))
import launch  # noqa: E402 (after the path)
import scenes  # noqa: E402
from scenes import SCENES, near_cube  # noqa: E402

# All closed forms and simulations have this cluster: latency 1 us, 0.3 us of a processor on either side of a message, 12.5 GB/s.
LATENCY, OVERHEAD, WIRE = 1e-6, 0.3e-6, 0.08e-9
NETWORK = dict(message=LATENCY + 2 * OVERHEAD, post=2 * OVERHEAD, wire=WIRE, reduction=LATENCY + 2 * OVERHEAD)
BOXES = {name: SCENES[name].strong for name in ("box2d", "box3d")}  # scenes of the closed form: their cells
WEAK = 16384  # particles a process
PATCH = 16  # cells of a patch of the pool on an axis, unless -pool_cells says otherwise
WAYS = {
    ("spatial", "direct"): "spatial, direct",
    ("spatial", "swarm"): "spatial, DMSwarmMigrate",
    ("pool", "direct"): "pool",
    ("pool", "swarm"): "pool",
}


def way(row):
    return (
        "one process"
        if row.get("processes", row.get("ranks")) == 1
        else WAYS.get((row["strategy"], row["migrate"]), row["strategy"])
    )


def combine(lines, repeats):
    """One line of a calibration's file from that of several."""
    found = [re.match(r"(rate \w+|[a-z]+(?:\[\d\]\.[a-z]+)?) ([-+.\de ]+)$", line) for line in lines]
    if lines[0].startswith("from"):
        return f"{lines[0]}, of {repeats}"
    if not all(found):
        return lines[0]
    name, columns = found[0][1], list(zip(*(m[2].split() for m in found)))
    least = {2, 4} if name.startswith("rate") else {0} if name in ("message", "copy", "kept", "reduction", "flop", "byte") else set()
    values = [min(c, key=float) if k in least else sorted(c, key=float)[len(c) // 2] for k, c in enumerate(columns)]
    return f"{name} {' '.join(values)}"


class ClosedForm:
    """The part that tables and figures have in common."""

    def __init__(self, args):
        self.args, self.data, self.missing = args, Data(args.data), []
        self.work = tempfile.TemporaryDirectory()
        self.predictors, self.models, self.said = {}, {}, {}

    def note(self, where, what):
        if (where, what) not in self.missing:
            self.missing.append((where, what))

    # ---- Pebble
    def options(self, name):
        """Options of the scene of strong scaling."""
        return "-options_file", scenes.write(self.work.name, name, SCENES[name].strong)

    def pebble(self, *options, ranks=1, program=None):
        command = ([self.args.mpiexec, "-n", str(ranks)] if ranks > 1 else []) + [
            program or self.args.pebble,
            *map(str, options),
            "-output_dir",
            self.work.name,
        ]
        done = launch.run(command, capture_output=True, text=True, cwd=ROOT)
        if done.returncode:
            sys.exit(f"report.py: {' '.join(command)}\n{done.stdout[-800:]}{done.stderr[-800:]}")
        return done.stdout

    def calibrate(self, repeats):
        """docs/data/models/*.model from several calibrations, since other work on the machine disturbs them: times of a particle,
        node, message or byte only get longer by it, so the least counts; of constants that are differences the median counts."""
        folder = os.path.join(self.args.data, "models")
        os.makedirs(folder, exist_ok=True)
        for name in BOXES:
            texts = []
            for k in range(repeats):
                path = os.path.join(self.work.name, f"{name}{k}.model")
                self.pebble(*self.options(name), "-model_file", path, ranks=2, program=self.args.calibrator)
                with open(path) as f:
                    texts.append(f.read().splitlines())
                print(f"  {name}: calibration {k + 1} of {repeats}", flush=True)
            with open(os.path.join(folder, f"{name}.model"), "w") as f:
                f.writelines(combine(lines, repeats) + "\n" for lines in zip(*texts))

    # ---- The closed form
    def predictor(self, name):
        """What answers about the model for the method of a box."""
        if name not in self.predictors:
            options = *self.options(name), "-output_dir", self.work.name
            self.predictors[name] = model.Predictor(self.args.predictor, *options)
        return self.predictors[name]

    def closed(self, name):
        """The model of a box on the cluster; what the program prints by it goes to self.said."""
        if name not in self.models:
            path = self.data.model(name)
            try:
                m = model.load(path, self.predictor(name)).with_network(**NETWORK)
            except ValueError as wrong:
                raise Missing(
                    f"`docs/data/models/{name}.model` is of another version of the program: `make report REPORT=calibrate` renews it"
                ) from wrong
            file = os.path.join(self.work.name, f"{name}.model")
            model.save(m, file)
            options = *self.options(name), "-parallel_migrate", "direct", "-dry_run", "-report_processes"
            said = model.parse(self.pebble(*options, "-model_file", file))
            if said.get("constants") != m.origin:
                sys.exit(f"report.py: `pebble -dry_run` did not take the constants of {name}")
            self.models[name], self.said[name] = m, said
        return self.models[name]

    def moved(self, name):
        """Cells, of 1 m, by which the fastest particle moves in a step."""
        self.closed(name)
        return self.said[name]["speed"] * self.said[name]["dt"]

    def whole(self, name):
        cells = BOXES[name]
        return model.Share(math.prod(cells) * 2 ** len(cells), math.prod(c + 1 for c in cells))

    def weak(self, name, n, processes, swarm=False, m=None):
        """Weak efficiency of cubes of n particles."""
        m = m or self.closed(name)
        m.direct = not swarm
        per, c = 2**m.dim, self.moved(name)
        e = m.step(m.cube(n, per, 1, c)) / m.step(m.cube(n, per, processes, c))
        m.direct = True
        return e

    def cut(self, name, processes):
        """Processes along each axis, as the program cut a box in the runs whose messages were counted."""
        for row in rows_of(self.data.need("scaling/counts.csv", "`make scaling`")[0]):
            if (row["scene"], row["strategy"], row["processes"]) == (name, "spatial", processes):
                return [int(p) for p in str(row["grid"]).split("x")]
        raise Missing(f"`docs/data/scaling/counts.csv` has no run of {name} on {processes} processes: `make scaling` writes it")

    def spatial(self, m, name, processes):
        """Seconds of a step and imbalance of a box that is cut as the program does it; particles cross its cuts as in `injected`."""
        cells, cut = BOXES[name], self.cut(name, processes)
        return m.box(cells, cut, 2**m.dim, *self.injected(name, cells, cut)[1:])

    @staticmethod
    def best_pool(m, s, processes):
        """Seconds of a step of the pool with the best patches, which Model.patch finds."""
        return m.pool(model.replace(s, processes=processes), m.patch(s))[0]

    def injected(self, name, cells, cut):
        """The model with the costs that the simulator injects, and no others; how many rows of particles change process in a step; and
        the probability that a row crosses a cut of an axis."""
        costs, dim = self.data.costs()[name], len(BOXES[name])
        m = model.Model(self.predictor(name), origin="costs.csv")
        for k, each in (("P2G", costs["P2G"]), ("ADVANCE", 2**dim * costs["ADVANCE"]), ("G2P", costs["G2P"]), ("SORT", costs["SORT"])):
            m.rates[k] = model.Rate(0, (1, 2, 3), (each, each, each))  # ADVANCE is of a node here; in costs.csv it is of a particle
        # Particles of these boxes cross a cut in whole layers, 2 a cell: q is the number of layers a step, not of particles.
        # (Rubber, sound at 36.7 m/s; 4 sin(pi x/L) m/s along each axis; dt = 0.4 h/(c + |v|).)
        step = 0.4 / (36.7 + 4 * math.sqrt(m.dim))
        crossed = [2 * 4 * math.sin(math.pi * j / p) * step for p in cut for j in range(1, p)]
        # Sums cost 0.2 ns a byte at either end; motion is sent without cost. The pool's master packs for 0.2 and takes in for 0.11 ns a byte.
        m.numbers = {"copy": 0, "kept": 0.4e-9, "pool": 0.155e-9, "job": 500e-9}
        m = m.with_network(**NETWORK)
        for k in (0, 1):
            m.numbers[f"migration[{k}].particle"] = costs["SWARM_PARTICLE"] if k == 0 else 0
            m.numbers[f"migration[{k}].call"] = costs["SWARM"] if k == 0 else 0
            # direct: half of the cost arises at either end, and both ends wait at the same time; the bytes are the network's.
            m.numbers[f"migration[{k}].leaver"] = k * 0.5 * costs.get("LEAVER", 0) + WIRE * (12 + m.predictor.travels)
        waits = 1 - math.prod(1 - q for q in crossed) ** (1 / max(1, sum(p > 1 for p in cut)))
        return m, sum(crossed), waits

    def against_simulation(self, which="spatial, direct"):
        """Rows of scene, study, processes, cut, simulated s, closed form s, imbalance in the simulation and by formula, for the cuts that
        the simulated runs had, or for the pool with patches of the program's size. All ran on the cluster with one switch."""
        out = []
        for study in ("strong", "strong-large", "weak", "weak-large"):
            try:
                rows = self.data.simulated(study)
            except Missing:
                if study.endswith("large"):
                    continue
                raise
            for row in rows:
                name, ranks = row["scene"], row["ranks"]
                if (
                    name in BOXES
                    and ranks > 1
                    and row["mode"] == "injected"
                    and way(row) == which
                    and row["platform"] == "cluster"
                ):
                    cells = self.cells_of(row, study)
                    cut = [int(p) for p in str(row["cut"] or "x".join("1" * len(cells))).split("x")]
                    m, *crossing = self.injected(name, cells, cut)
                    m.direct = row["migrate"] == "direct"
                    if which == "pool":
                        nodes = math.prod(c + 1 for c in cells)
                        t, imbalance = m.pool(model.Share(row["particles"], nodes, processes=ranks), PATCH)[0], 1
                    else:
                        t, imbalance = m.box(cells, cut, 2**m.dim, *crossing)
                    out.append(
                        (name, study.split("-")[0], ranks, row["cut"], row["seconds_per_step"], t, row["imbalance"], imbalance)
                    )
        if not out:
            raise Missing("`docs/data/simulated/*.csv` has no injected runs of filled boxes: `make simulate` writes them")
        return out

    @staticmethod
    def cells_of(row, study):
        if study == "strong":
            return BOXES[row["scene"]]
        scene = SCENES[row["scene"]]
        return scene.large if study == "strong-large" else scene.weak(row["ranks"])

    def alone(self, name, cells):
        """Seconds of a step on one process with the costs that the simulator injects."""
        one = [1] * len(cells)
        return self.injected(name, cells, one)[0].box(cells, one, 2 ** len(cells), 0)[0]

    def simulated_alone(self, name):
        """Seconds of a step on one process in the simulated runs of weak scaling. The closed form counts the sorting of particles in each
        step, but a run with few particles sorts only in steps in which some changed cell."""
        for study in ("weak-large", "weak"):
            try:
                rows = self.data.simulated(study)
            except Missing:
                continue
            for r in rows:
                if (r["scene"], r["mode"], r["platform"], r["ranks"], r["migrate"]) == (name, "injected", "cluster", 1, "direct"):
                    return r["seconds_per_step"]
        return self.alone(name, SCENES[name].small)

    def boxes(self, name, ranks, swarm=False):
        """Weak efficiency with the costs that the simulator injects, and imbalance, of the boxes that the program chose in the
        simulated run, or where there is none of boxes with equally many cells each."""
        cuts = {}
        for study in ("weak", "weak-large"):
            try:
                rows = [r for r in self.data.simulated(study) if r["scene"] == name and r["mode"] == "injected"]
                cuts |= {r["ranks"]: r["cut"] for r in rows if r["cut"]}
            except Missing:
                pass
        cells = self.cells_of({"scene": name, "ranks": ranks}, "weak")
        cut = [int(p) for p in str(cuts[ranks]).split("x")] if ranks in cuts else near_cube(len(cells), ranks)
        m, *crossing = self.injected(name, cells, cut)
        m.direct = not swarm
        t, imbalance = m.box(cells, cut, 2**m.dim, *crossing)
        return self.simulated_alone(name) / t, imbalance
