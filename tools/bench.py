#!/usr/bin/env python3
"""Measures pebble on this machine, and other programs on the same work: `make bench`, or with BENCH=short or BENCH=full.

The work is that of tools/bench/scene.py. Programs that are compared run in alternation, so that other work on the machine slows
all alike; figures are the minimum and the median of the repeats, ratios are of minima. Times are those of the steps per
particle and step, without start-up and without the compilation of kernels. The groups are:

  bare     a whole step over its arithmetic alone (tools/bench/bare.c), whose mass, momentum and energies must agree with pebble's
  seed     against examples/seed_serial.c, the plain serial program: it has its own body of as many particles, in which usl soon is
           unstable; pebble's body drifts and crosses more cells. Both are compared on the serial program's body. (The time of
           the serial program is the processor's.)
  peers    against steps in Taichi and Warp (tools/bench/), on one core; their energy must agree with pebble's
  updates  usf and musl against usl, at 1e5 particles
  ranks    2 processes against 1, at 1e6 particles, with both ways of migration; the digests must be equal
  predicted  time of the scenes of options/ over what they predict by their first steps (tools/bench/predicted.py)
  matrix   (full) every basis and dimension, 1e4 to 4e6 particles, 4, 9 and 16 a cell (3-D: 4, 8, 16, 27), 1 and 2
           processes; at least 30 steps, at most 3 repeats, at the largest size 2. --plan says how long it takes
  modes    (full) both migrations and the pool on 2 processes
  large    (full) the cost of a particle with 1e7 particles over its cost with 1e6, both on 2 processes: set-up, steps, keeping the
           particles in order, two snapshots, memory; 1 process against 2 with 1e7, at most 2 repeats; a migration over its
           prediction. It takes 6 GiB and a quarter of an hour
  writes   (full) two snapshots of 1e6 particles against a plain write of the same bytes, both until the disk has them

Each ratio has a target, or none. It is of the least times of both programs and stands beside the ratio of their medians and
the least favourable one of two runs that followed each other. --short has fewer sizes, repeats and peers, for three minutes.

The program writes output/bench.csv, prints the table of ratios, and writes sections of docs/performance.md, between their marks:
floor (bare, seed, peers), bench (updates, ranks), large and matrix, each with its file in docs/data/bench, if all groups of the section
ran and nothing failed; then docs/bench.png too. Otherwise, and with --short, the plot goes to output/.
"""
import argparse
import csv
import datetime
import functools
import glob
import json
import math
import os
import re
import statistics
import subprocess
import sys
import tempfile
import time

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
FOLDER = os.path.join(ROOT, "tools", "bench")
sys.path.insert(0, os.path.join(ROOT, "tools"))
sys.path.insert(0, FOLDER)
from scene import HALF, Scene  # noqa: E402 (after the path)
import launch  # noqa: E402
import predicted  # noqa: E402

BASES = {"linear": "linear", "bspline2": "quadratic", "bspline3": "cubic", "gimp": "GIMP"}
SIZES = "1e4,1e5,1e6,4e6"  # of the matrix
PER_CELL = {1: [(4,), (9,), (16,)], 2: [(2, 2), (3, 3), (4, 4)], 3: [(2, 2, 1), (2, 2, 2), (4, 2, 2), (3, 3, 3)]}
LARGE = 4e6  # from so many particles on, the matrix has 2 repeats, and only the usual number of particles a cell
USUAL = {1: (9,), 2: (3, 3), 3: (2, 2, 2)}
METHODS = [(2, "linear"), (2, "bspline2"), (2, "bspline3"), (2, "gimp"), (3, "linear"), (3, "bspline2")]
SECTIONS = {"floor": ("bare", "seed", "peers"), "bench": ("updates", "ranks"), "large": ("large",)}  # of docs/performance.md, besides the matrix
# Targets: a whole step of usl over its bare kernels with 1e5 particles, and with 1e6.
OVER_BARE = dict(zip(METHODS, (1.45, 1.45, 1.2, 1.2, 1.15, 1.15)))
OVER_BARE_LARGE = 1.6
TIMES_FASTER = {"warp": 2, "taichi": 7}  # of the same scheme
UPDATES = 1.9  # a step of usf or musl over one of usl
COMPACT = ("usf", "musl", "usl with domains that stretch")  # have one row for all in the document
# A rough time of a step, to choose the number of steps: {program: {dimension: ns per particle and step}}.
ROUGH = {"warp": {2: 45, 3: 180}, "taichi": {2: 200, 3: 800}, "seed": {2: 330}}
PEBBLE = {(1, basis): 10 for basis in BASES} | dict(zip(METHODS, (16, 19, 24, 24, 42, 63))) | {
    (3, "gimp"): 85, (3, "bspline3"): 170}
LARGE_STEPS = 24  # of each run of the group `large`
# 1 process against 2 with 1e7 particles: {case: (kind of migration, target)}.
FASTER_LARGE = {"2 processes": ("swarm", 1.75), "2 processes, direct": ("direct", 1.85)}
# Runs a command and then prints the largest memory of any of its processes, in KiB.
MOST_MEMORY = """import resource, subprocess, sys
status = subprocess.call(sys.argv[1:])
print("largest", resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss, flush=True)
sys.exit(status)"""
MOST = 1000  # steps of a run: linear with usl is unstable, and in 1-D it fails after 2000
SLOWER = 1.5  # factor by which the plan takes steps to be slower than the above
TIMEOUT = 900


class Failed(Exception):
    pass


def command_output(command, **more):
    try:
        done = launch.run(command, capture_output=True, text=True, timeout=TIMEOUT, **more)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise Failed(str(error)) from error
    if done.returncode:
        lines = [line for line in (done.stderr + done.stdout).splitlines() if re.search(r"\w", line)] or ["no message"]
        lines = [line for line in lines if re.search(r"^\[?\d*\]?\W*error\b", line, re.I)] or lines
        raise Failed(f"exit status {done.returncode}: {lines[0].strip()} ({' '.join(command)})")
    return done.stdout


# ---- What runs: each class has `row` (what it is, for the table) and time() -> ns per particle and step

class Pebble:
    def __init__(self, args, scene, basis, update, steps, ranks=1, extra=(), half=None):
        self.folder = tempfile.TemporaryDirectory()
        self.args, self.steps, self.ranks, self.digests = args, steps, ranks, set()
        path = os.path.join(self.folder.name, "scene.opts")
        with open(path, "w") as f:
            f.write(scene.options(basis, update, steps, half))
        mpi = [args.mpiexec, "-n", str(ranks)] if ranks > 1 else []
        self.command = mpi + [args.pebble, "-options_file", path, "-output_dir", self.folder.name,
                                 "-output_format", "none", "-report_limits", "false", "-report_phases", *extra]
        self.environment = launch.environment(ranks, args.cores)
        self.row = dict(program="pebble", dim=scene.dim, basis=basis, update=update, particles=scene.particles,
                        per_cell=scene.ppc, processes=ranks, steps=steps, options=" ".join(extra))

    def time(self):
        self.said = out = command_output(self.command, env=self.environment)
        row, digest = re.search(r"^  all +\S+ +\S+ +(\S+)", out, re.M), re.search(r"^digest (\w+)", out, re.M)
        if not row or not digest:
            raise Failed(f"{' '.join(self.command)}: no table of phases or no digest in its output")
        self.digests.add(digest[1])
        return float(row[1])

    def totals(self):
        """The last line of the last run's history."""
        with open(os.path.join(self.folder.name, "scene.csv")) as f:
            return list(csv.DictReader(f))[-1]

    def kinetic(self):
        return float(self.totals()["kinetic_energy"])


class Bare:
    """Bare kernels for as many lanes as pebble uses here."""

    def __init__(self, args, scene, basis, steps, half=None):
        self.command = [f"{args.bare}_{lanes(args.pebble)}", *scene.bare(basis, steps, half)]
        self.row = dict(program="bare", dim=scene.dim, basis=basis, update="usl", particles=scene.particles,
                        per_cell=scene.ppc, processes=1, steps=steps)

    def time(self):
        self.said = command_output(self.command)
        return float(re.search(r"^ns per particle-step (\S+)", self.said, re.M)[1])

    def total(self, name):
        return [float(x) for x in re.search(rf"^{name} (.*)", self.said, re.M)[1].split()]


@functools.cache
def lanes(pebble):
    """Returns how many lanes pebble's kernels have on this machine."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "lanes.opts")
        with open(path, "w") as f:
            f.write(Scene(2, 100, USUAL[2]).options("linear", "usl", 1))
        said = command_output([pebble, "-options_file", path, "-output_dir", folder, "-output_format", "none"])
    found = re.search(r"^kernels .* (\d+) lanes?", said, re.M)
    if not found:
        raise Failed(f"{pebble} does not say how many lanes it has")
    return int(found[1])


class Seed:
    def __init__(self, args, scene, steps):
        self.command = [args.seed, "setup=block", "material=neohookean", f"cells={scene.grid}",
                        f"ppc={scene.per_axis[0]}", f"steps={steps}", "time=1"]
        self.row = dict(program="seed_serial", dim=2, basis="linear", update="usf", particles=scene.particles,
                        per_cell=scene.ppc, processes=1, steps=steps)

    def time(self):
        out = command_output(self.command)
        self.energy = float(re.search(r"^kinetic (\S+)", out, re.M)[1])
        return float(re.search(r"^ns per particle-step (\S+)", out, re.M)[1])


class Peer:
    """A process in Taichi or Warp that has compiled its kernels and waits for numbers of steps."""

    def __init__(self, name, scheme, python, scene, steps):
        self.steps = steps
        self.label = f"{name}, {scheme}"
        environment = dict(os.environ, WARP_CACHE_PATH=os.path.join(ROOT, "build", "bench-venv", "warp"))
        self.log = tempfile.TemporaryFile("w+")
        self.process = subprocess.Popen(
            [python, os.path.join(FOLDER, f"peer_{name}.py"), scheme, str(scene.dim), str(scene.particles),
             *map(str, scene.per_axis)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self.log, text=True,
            env=environment)
        if self.answer()["particles"] != scene.particles:
            raise Failed(f"{self.label}: another number of particles")
        self.row = dict(program=name, dim=scene.dim, basis="bspline2", update="usl" if scheme == "flip" else "mls",
                        particles=scene.particles, per_cell=scene.ppc, processes=1, steps=steps)

    def answer(self):
        for line in self.process.stdout:  # the other lines are greetings of the library
            if line.startswith("{"):
                return json.loads(line)
        self.process.wait()
        self.log.seek(0)
        raise Failed(f"{self.label}: {(self.log.read().strip().splitlines() or ['ended'])[-1]}")

    def run(self, steps):
        try:
            self.process.stdin.write(f"{steps}\n")
            self.process.stdin.flush()
        except OSError as error:
            raise Failed(f"{self.label}: {error}") from error
        return self.answer()

    def time(self):
        return self.run(self.steps + 1)["ns"]  # the first step is not timed

    def close(self):
        self.process.stdin.close()
        try:
            self.process.wait(30)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()


# ---- What is kept

class Results:
    def __init__(self, args):
        self.args, self.series, self.ratios, self.problems = args, [], [], []

    def problem(self, text):
        self.problems.append(text)
        print(f"  FAILED {text}", flush=True)

    def alternate(self, group, runs, repeats=None):
        """Times all runs in turns; returns {name: row with min and median}, without those that failed."""
        times = {name: [] for name in runs}
        for _ in range(repeats or self.args.repeats):
            for name in list(times):
                try:
                    times[name].append(runs[name].time())
                except Failed as failure:
                    self.problem(f"{group}: {name}: {failure}")
                    del times[name]
        rows = {}
        for name, t in times.items():
            rows[name] = dict(group=group, **runs[name].row, repeats=len(t), times=t, min_ns=min(t),
                              median_ns=statistics.median(t), all_ns=" ".join(f"{x:.4g}" for x in t))
            print(f"  {name:44s} {rows[name]['particles']:8d}  min {min(t):7.1f}  median "
                  f"{statistics.median(t):7.1f} ns", flush=True)
        self.series += rows.values()
        self.write(self.args.csv)
        return rows

    def ratio(self, what, rows, over, under, target, at_least=True):
        if over in rows and under in rows:
            a, b = rows[over], rows[under]
            self.in_turns(a["group"], what, a["times"], b["times"], target, at_least)
        else:
            self.ratios.append(dict(what=what, value=None, median=None, worst=None, target=target, at_least=at_least, unit=""))

    def in_turns(self, group, what, over, under, target, at_least=True):
        """Adds the ratio of two lists of values that were found in turns."""
        pairs = [a / b for a, b in zip(over, under)]
        self.ratios.append(dict(what=what, value=min(over) / min(under), median=statistics.median(over) / statistics.median(under),
                                worst=min(pairs) if at_least else max(pairs), target=target, at_least=at_least, unit="", group=group))

    def nanoseconds(self, what, rows, name):
        row = rows.get(name)
        self.ratios.append(dict(what=what, value=row and row["min_ns"], median=row and row["median_ns"],
                                worst=row and max(row["times"]), target=None, at_least=False, unit=" ns",
                                group=row and row["group"]))

    def write(self, path, groups=None):
        columns = ["group", "program", "dim", "basis", "update", "particles", "per_cell", "processes", "steps",
                   "options", "repeats", "min_ns", "median_ns", "all_ns"]
        os.makedirs(os.path.dirname(path) or ".", exist_ok=True)
        with open(path, "w", newline="") as f:
            writer = csv.DictWriter(f, columns, restval="", extrasaction="ignore")
            writer.writeheader()
            writer.writerows(row for row in self.series if groups is None or row["group"] in groups)


def judged(ratio):
    if ratio["value"] is None:
        return ratio.get("absent", "failed")
    if ratio["target"] is None:
        return ""
    better = ratio["value"] >= ratio["target"] if ratio["at_least"] else ratio["value"] <= ratio["target"]
    return "met" if better else "missed"


def table(ratios):
    """Yields the cells of each row of the table of ratios: what, of minima, of medians, the worst, target, met or missed."""
    for r in ratios:
        form = "{:.1f} ns" if r["unit"] else "{:.2f}"
        bound = "" if r["target"] is None else f"{'>=' if r['at_least'] else '<='} {r['target']:g}{r['unit']}"
        yield r["what"], *("-" if r.get(k) is None else form.format(r[k]) for k in ("value", "median", "worst")), bound, judged(r)


# ---- The groups

def choose(args, scene, ns, least, part=1.0):
    steps = round(1e9 * part * args.seconds / ns / scene.particles)
    return max(least, min(scene.room(), MOST, steps))


def rough(dim, basis, per_cell=9):
    """A rough time of a step of pebble, ns a particle."""
    return PEBBLE[dim, basis] * (1.2 if per_cell < 8 else 1)


def pebble_steps(args, scene, basis, part=1.0):
    return choose(args, scene, rough(scene.dim, basis, scene.ppc), 30, part)


def pebble(args, scene, basis, update="usl", ranks=1, extra=()):
    return Pebble(args, scene, basis, update, pebble_steps(args, scene, basis), ranks, extra)


def size(scene):
    return f"{scene.particles:.0e}".replace("e+0", "e")


def close(a, b, tolerance):
    return abs(a - b) <= tolerance * max(abs(a), abs(b))


def check_bare(args, dim, basis):
    """Checks that the bare kernels compute what pebble does: 12 steps of halves that run into each other."""
    scene = Scene(dim, 1e4, USUAL[dim])
    theirs, ours = Bare(args, scene, basis, 12, HALF), Pebble(args, scene, basis, "usl", 12, half=HALF)
    theirs.time()
    ours.time()
    totals = {name: float(value) for name, value in ours.totals().items()}
    scale = totals["mass"] * (2 * totals["kinetic_energy"] / totals["mass"]) ** 0.5
    differences = {"mass": theirs.total("mass")[0] / totals["mass"] - 1,
                   "kinetic energy": theirs.total("kinetic")[0] / totals["kinetic_energy"] - 1,
                   "strain energy": theirs.total("strain")[0] / totals["strain_energy"] - 1}
    for axis, p in zip("xyz"[:dim], theirs.total("momentum")):
        differences[f"momentum along {axis}"] = (p - totals[f"momentum_{axis}"]) / scale
    for name, difference in differences.items():
        if not abs(difference) <= 1e-11:
            raise Failed(f"bare kernels, {BASES[basis]} {dim}-D: {name} differs from pebble's by {difference:.1e} of it")
    return max(map(abs, differences.values()))


def bare(args, results):
    differences = []
    for dim, basis in METHODS:
        try:
            differences.append(check_bare(args, dim, basis))
        except Failed as failure:
            results.problem(f"bare: {failure}")
    if differences:
        print(f"  mass, momentum and energies of the bare kernels differ from pebble's by {max(differences):.1e} at most")
    for n in (1e5, 1e6) if args.short else (1e4, 1e5, 1e6):
        for dim, basis in METHODS:
            if args.short and n > 1e5 and (dim, basis) != (2, "bspline2"):
                continue
            scene, name = Scene(dim, n, USUAL[dim]), f"{BASES[basis]} {dim}-D"
            ours = pebble(args, scene, basis)
            rows = results.alternate("bare", {f"{name} usl": ours, f"{name} bare": Bare(args, scene, basis, ours.steps)})
            if n > 1e4:
                results.ratio(f"step / bare kernels, {name}, {size(scene)}", rows, f"{name} usl", f"{name} bare",
                              OVER_BARE[dim, basis] if n < 1e6 else OVER_BARE_LARGE, False)


def seed(args, results):
    for n in (1e5, 2.5e5):  # the serial program's mesh has at most 500 cells a side: 2.5e5 particles at 4 per cell
        scene = Scene(2, n, (2, 2), drift=False)
        check = Seed(args, scene, 10), Pebble(args, scene, "linear", "usf", 10)
        try:
            for run in check:
                run.time()
            if not close(check[0].energy, check[1].kinetic(), 1e-10):
                raise Failed(f"kinetic energy {check[1].kinetic()} of pebble, {check[0].energy} of the seed")
        except Failed as failure:
            results.problem(f"seed: {failure}")
        steps, ours = choose(args, scene, ROUGH["seed"][2], 5), Scene(2, scene.particles, (2, 2))
        rows = results.alternate("seed", {"seed_serial": Seed(args, scene, steps),
                                          "linear 2-D usl": pebble(args, ours, "linear", "usl"),
                                          "linear 2-D usf": pebble(args, ours, "linear", "usf")})
        for update, target in (("usl", 15), ("usf", 8)):
            results.ratio(f"seed_serial / pebble {update}, linear 2-D, 4 per cell, {scene.particles}", rows,
                          "seed_serial", f"linear 2-D {update}", target)


def check_peer(args, peer, scene, scheme):
    """Checks total mass and momentum, and where the scheme is the same that the kinetic energy is that of pebble's step."""
    steps = 12
    ours = Pebble(args, scene, "bspline2", "usl", steps)
    ours.time()
    theirs = peer.run(steps)
    scale = theirs["mass"] * (2 * theirs["kinetic"] / theirs["mass"]) ** 0.5
    if not close(theirs["grid_mass"], theirs["mass"], 1e-12):
        raise Failed(f"{peer.label}: mass of the nodes {theirs['grid_mass']}, of the particles {theirs['mass']}")
    for a, b in zip(theirs["momentum"], theirs["momentum_start"]):
        if abs(a - b) > 1e-10 * scale:
            raise Failed(f"{peer.label}: momentum {b} -> {a}")
    # MLS-MPM is another scheme, which has to compute only about the same motion.
    if not close(theirs["kinetic"], ours.kinetic(), 1e-6 if scheme == "flip" else 1e-2):
        raise Failed(f"{peer.label}: kinetic energy {theirs['kinetic']}, pebble's {ours.kinetic()}")


def peers(args, results):
    python, names, reasons = install(args)
    for name, reason in reasons.items():
        print(f"  {name.capitalize()} is left out: {reason}")
        results.ratios.append(dict(what=f"{name.capitalize()} / pebble, quadratic 2-D and 3-D", value=None, group="peers",
                                   target=TIMES_FASTER[name], at_least=True, unit="", absent="left out"))
    for dim in (2, 3) if names else ():
        for n in (1e5,) if args.short else (1e5, 1e6):
            scene, runs, started = Scene(dim, n, USUAL[dim]), {}, []
            ours = f"quadratic {dim}-D usl"
            runs[ours] = pebble(args, scene, "bspline2")
            try:
                for name in names:
                    for scheme in ("flip",) if args.short else ("flip", "mls"):
                        try:
                            steps = choose(args, scene, ROUGH[name][dim], 2)
                            peer = Peer(name, scheme, python, scene, steps)
                            started.append(peer)
                            if n == 1e5:
                                check_peer(args, peer, scene, scheme)
                            runs[f"{name} {scheme} {dim}-D"] = peer
                        except Failed as failure:
                            results.problem(f"peers: {failure}")
                rows = results.alternate("peers", runs)
            finally:
                for peer in started:
                    peer.close()
            for name, target in TIMES_FASTER.items():
                for scheme, text in (("flip", "same scheme"), ("mls", "MLS-MPM")):
                    if name in names and (scheme == "flip" or not args.short):
                        results.ratio(f"{name.capitalize()} ({text}) / pebble, quadratic {dim}-D, {size(scene)}", rows,
                                      f"{name} {scheme} {dim}-D", ours, target if scheme == "flip" else None)


def updates(args, results):
    for dim, basis in METHODS:
        scene, name = Scene(dim, 1e5, USUAL[dim]), f"{BASES[basis]} {dim}-D"
        runs = {f"{name} {update}": pebble(args, scene, basis, update) for update in ("usl", "usf", "musl")}
        if basis == "gimp":
            runs[f"{name} stretch"] = pebble(args, scene, basis, extra=("-method_gimp_update", "stretch"))
        rows = results.alternate("updates", runs)
        results.nanoseconds(f"step, {name}, {size(scene)}", rows, f"{name} usl")
        if basis == "gimp":
            results.ratio(f"usl with domains that stretch / usl, {name}, {size(scene)}", rows, f"{name} stretch", f"{name} usl",
                          None, False)
        for update in ("usf", "musl"):
            results.ratio(f"{update} / usl, {name}, {size(scene)}", rows, f"{name} {update}", f"{name} usl", UPDATES, False)


def same_bits(results, group, name, runs, repeats=None):
    """Times runs, and reports a problem unless their digests are equal."""
    rows = results.alternate(group, runs, repeats)
    digests = set().union(*(run.digests for run in runs.values()))
    if len(digests) > 1:
        results.problem(f"{group}: {name}: digests differ: {digests}")
    return rows


def ranks(args, results):
    for dim, basis in METHODS:
        scene, name = Scene(dim, 1e6, USUAL[dim]), f"{BASES[basis]} {dim}-D usl"
        cases = {"1 process": (1, ()), "2 processes": (2, ()),
                 "2 processes, direct": (2, ("-parallel_migrate", "direct"))}
        rows = same_bits(results, "ranks", name, {f"{name}, {case}": pebble(args, scene, basis, "usl", *what)
                                                  for case, what in cases.items()})
        results.nanoseconds(f"step, {BASES[basis]} {dim}-D, {size(scene)}", rows, f"{name}, 1 process")
        for case in list(cases)[1:]:
            results.ratio(f"1 process / {case}, {BASES[basis]} {dim}-D, {size(scene)}", rows, f"{name}, 1 process",
                          f"{name}, {case}", 1.85)


def cells_of_matrix(args):
    """(size asked for, scene, basis, steps, repeats) of each entry of the matrix."""
    for dim in (1, 2, 3):
        for basis in BASES:
            for per_axis in PER_CELL[dim]:
                for n in map(float, args.sizes.split(",")):
                    if n >= LARGE and per_axis != USUAL[dim]:
                        continue
                    scene = Scene(dim, n, per_axis)
                    repeats = min(3 if n < LARGE else 2, args.repeats)
                    yield n, scene, basis, pebble_steps(args, scene, basis, 0.5), repeats


def matrix(args, results):
    for _, scene, basis, steps, repeats in cells_of_matrix(args):
        name = f"{BASES[basis]} {scene.dim}-D usl, {scene.ppc} per cell"
        same_bits(results, "matrix", name, {f"{name}, {ranks} process{'es' * (ranks - 1)}":
                                            Pebble(args, scene, basis, "usl", steps, ranks) for ranks in (1, 2)}, repeats)


def plan(args):
    """Says about how long the matrix takes, by size: start-up and end, then steps."""
    lines, total = [], 0.0
    for size in map(float, args.sizes.split(",")):
        cells = [cell[1:] for cell in cells_of_matrix(args) if cell[0] == size]
        # On two processes a run takes about 1/1.7 of the time on one.
        minutes = sum(repeats * (0.6 + 1.2e-6 * scene.particles + (1 + 1 / 1.7) * 1e-9 * SLOWER * steps
                                 * scene.particles * rough(scene.dim, basis, scene.ppc))
                      for scene, basis, steps, repeats in cells) / 60
        total += minutes
        steps = [steps for _, _, steps, _ in cells]
        lines.append(f"  {size:.0e} particles: {len(cells)} scenes on 1 and 2 processes, {min(steps)} to {max(steps)} "
                     f"steps, {cells[0][-1]} repeats, about {minutes:.0f} minutes")
    return "\n".join([f"matrix: about {total:.0f} minutes", *lines])


def modes(args, results):
    scene = Scene(2, 1e6, USUAL[2])
    one = "linear 2-D usf, 1 process"
    cases = {one: (1, ()), "2 processes, swarm": (2, ()), "2 processes, direct": (2, ("-parallel_migrate", "direct")),
             "2 processes, pool": (2, ("-parallel_strategy", "pool"))}
    rows = results.alternate("modes", {name: pebble(args, scene, "linear", "usf", *case)
                                       for name, case in cases.items()})
    for name in list(cases)[1:]:
        results.ratio(f"1 process / {name}, linear 2-D usf, {size(scene)}", rows, one, name, None)


class Large(Pebble):
    """A run with two snapshots. After time(), `parts` has the ns per particle of each part of the run, `memory` the bytes of
    the largest process, and `migrate` the time of its migrations over the predicted one, if it has any."""

    def __init__(self, args, scene, ranks):
        super().__init__(args, scene, "linear", "usl", LARGE_STEPS, ranks, ("-output_format", "hdf5", "-output_every", "1e9", "-log_view"))
        self.command = [sys.executable, "-c", MOST_MEMORY, *self.command]

    def time(self):
        ns = super().time()
        stages = dict(re.findall(r"^ \d: +(MPM [\w-]+): (\S+)", self.said, re.M))
        order = re.search(r"^SORT +\S+ +\S+ +(\S+)", self.said, re.M)[1]  # of the slower process
        cost = {"set-up": stages["MPM set-up"], "steps": 1e-9 * ns * self.steps * self.row["particles"], "order": order,
                "snapshots": stages["MPM output"]}
        self.parts = {part: 1e9 * float(s) / self.row["particles"] for part, s in cost.items()}
        self.memory = 1024 * int(re.search(r"^largest (\d+)", self.said, re.M)[1])
        migrate = re.search(r"^ +MIGRATE .* (\S+)$", self.said, re.M)
        self.migrate = migrate and float(migrate[1])
        return ns


def large(args, results):
    small, few, many = runs = [Large(args, Scene(3, n, USUAL[3]), 2) for n in (1e4, 1e6, 1e7)]
    parts, migrate = {}, []
    try:
        for _ in range(args.repeats):
            for run in runs:
                run.time()
                for part, ns in run.parts.items():
                    parts.setdefault(part, {}).setdefault(run, []).append(ns)
                parts.setdefault("memory", {}).setdefault(run, []).append(2 * (run.memory - small.memory) / run.row["particles"])
            migrate.append(many.migrate)
    except Failed as failure:
        return results.problem(f"large: {failure}")
    for part, found in parts.items():
        unit = "B" if part == "memory" else "ns"
        results.series += [dict(run.row, group="large", options=f"{part}, {unit}", repeats=len(found[run]), min_ns=min(found[run]),
                                median_ns=statistics.median(found[run]), all_ns=" ".join(f"{x:.4g}" for x in found[run])) for run in (few, many)]
        print(f"  {part:10s} {min(found[few]):7.1f} {unit} a particle with 1e6, {min(found[many]):7.1f} with 1e7", flush=True)
        results.in_turns("large", f"1e7 / 1e6, {part}, linear 3-D, 2 processes", found[many], found[few], 1.1, False)
    if all(migrate):
        results.in_turns("large", "migrations, measured / predicted, linear 3-D, 1e7, 2 processes", migrate, [1] * len(migrate), None,
                         False)
    for basis in ("linear", "bspline2"):
        scene, name = Scene(3, 1e7, USUAL[3]), f"{BASES[basis]} 3-D usl"
        cases = {"1 process": (1, ())} | {case: (2, ("-parallel_migrate", way)) for case, (way, _) in FASTER_LARGE.items()}
        rows = same_bits(results, "large", name, {f"{name}, {case}": Pebble(args, scene, basis, "usl", LARGE_STEPS, *what)
                                                  for case, what in cases.items()}, min(2, args.repeats))
        for case, (_, target) in FASTER_LARGE.items():
            results.ratio(f"1 process / {case}, {BASES[basis]} 3-D, 1e7", rows, f"{name}, 1 process", f"{name}, {case}", target)


def writes(args, results):
    """Two snapshots against a plain write of their bytes to the same folder, both until the disk has them."""
    run, plain, ours = Large(args, Scene(3, 1e6, USUAL[3]), 1), [], []
    for _ in range(args.repeats):
        try:
            run.time()
        except Failed as failure:
            return results.problem(f"writes: {failure}")
        names = glob.glob(os.path.join(run.folder.name, "*.snapshots", "*.h5"))
        data = []
        start = time.monotonic()
        for name in names:
            with open(name, "rb") as f:
                os.fsync(f.fileno())
        ours.append(1e-9 * run.parts["snapshots"] * run.row["particles"] + time.monotonic() - start)
        for name in names:
            with open(name, "rb") as f:
                data.append(f.read())
        start = time.monotonic()
        for k, part in enumerate(data):
            with open(os.path.join(run.folder.name, f"plain.{k}"), "wb", buffering=0) as f:
                f.write(part)
                os.fsync(f.fileno())
        plain.append(time.monotonic() - start)
        print(f"  {1e-6 * sum(map(len, data)):.0f} MB: snapshots {ours[-1]:.2f} s, plain write {plain[-1]:.2f} s", flush=True)
    results.in_turns("writes", "plain write / snapshots, linear 3-D, 1e6, 1 process", plain, ours, 0.5)


# ---- The peers' programs

def install(args):
    """Returns the Python of build/bench-venv, which of the peers it has, and for the others the reason why not."""
    venv = os.path.join(ROOT, "build", "bench-venv")
    python, packages = os.path.join(venv, "bin", "python"), {"warp": "warp-lang", "taichi": "taichi"}
    with open(os.path.join(ROOT, "tools", "requirements-bench.txt")) as f:
        pins = dict(line.strip().split("==") for line in f if "==" in line)
    pip = [python, "-m", "pip", "--disable-pip-version-check"]
    names, reasons = [], {}
    if args.no_peers:
        return python, names, dict.fromkeys(packages, "--no-peers")
    if args.short and not os.path.exists(os.path.join(venv, "bin", "pip")):
        return python, names, dict.fromkeys(packages, "not installed, and --short does not install it")
    try:
        if not os.path.exists(os.path.join(venv, "bin", "pip")):
            command_output([sys.executable, "-m", "venv", "--clear", venv])
        have = {package["name"].lower(): package["version"]
                for package in json.loads(command_output([*pip, "list", "--format", "json"]))}
    except (Failed, ValueError) as failure:
        return python, names, dict.fromkeys(packages, f"no {venv}: {failure}")
    for name, package in packages.items():
        wanted = [package, "numpy"]
        try:
            if any(have.get(p) != pins[p] for p in wanted):
                if args.short:
                    raise Failed("not installed, and --short does not install it")
                print(f"  installing {package} {pins[package]} in build/bench-venv ...", flush=True)
                command_output([*pip, "install", "-q", "--retries", "1", *(f"{p}=={pins[p]}" for p in wanted)])
            names.append(name)
        except Failed as failure:
            reasons[name] = f"cannot be installed: {str(failure)[:200]}"
    return python, names, reasons


# ---- The machine, the plot, the document

def machine(args):
    """Lines that describe the machine and the programs of a measurement."""
    def first(path, pattern, default="unknown"):
        try:
            with open(path) as f:
                found = re.search(pattern, f.read(), re.M)
                return found[1].strip() if found else default
        except OSError:
            return default

    flags = first("/proc/cpuinfo", r"^flags\s*:(.*)$", "").split()
    vectors = [name for flag, name in (("avx512f", "AVX-512"), ("avx2", "AVX2"), ("asimd", "NEON")) if flag in flags]
    memory = int(first("/proc/meminfo", r"^MemTotal:\s*(\d+)", "0")) / 2**20
    version = command_output([args.pebble, "-version"]).strip()
    mpi = command_output([args.mpiexec, "--version"]).splitlines()[0]
    model = first("/proc/cpuinfo", r"^model name\s*:(.*)$") + (f" ({vectors[0]})" if vectors else "")
    return [f"{model}, {os.cpu_count()} cores, {memory:.0f} GiB, {os.uname().sysname} {os.uname().release}", version,
            f"{mpi}; flags {args.flags or 'unknown'}; "
            f"of the bare kernels, for {lanes(args.pebble)} lanes, {args.flags_bare or 'unknown'}; "
            f"seed_serial: {args.flags_seed or 'unknown'}",
            f"2 processes: {launch.settings(2, args.cores)}"]


def short(what):
    """What a bar is of, without the words that the title of its panel has."""
    what = what.replace("step / bare kernels, ", "")
    what = re.sub(r"^1 process / 2 processes(, direct)?, (.*)", lambda m: m[2] + (", direct" if m[1] else ""), what)
    return re.sub(r" / pebble( us[lf])?", lambda m: f" /{m[1]}" if m[1] else "", what)


def draw_bars(axis, bars, title):
    """Ratios as bars, grey where they miss the target, which is a line; lines between groups of the same program."""
    for y, r in enumerate(reversed(bars)):
        axis.barh(y, r["value"], color="C0" if (r.get("verdict") or judged(r)) == "met" else "0.75", height=0.72)
        axis.plot((r["target"], r["target"]), (y - 0.42, y + 0.42), color="k", linewidth=1.4)
        axis.annotate(f"{r['value']:.3g}", (max(r["value"], r["target"]), y), (4, 0), textcoords="offset points", va="center", fontsize=8)
    names = [r["what"].split(" / ")[0].split(" (")[0] for r in reversed(bars)]
    for y in range(1, len(bars)):
        if names[y] != names[y - 1]:
            axis.axhline(y - 0.5, color="0.85", linewidth=0.8, zorder=0)
    axis.set_yticks(range(len(bars)), [short(r["what"]) for r in reversed(bars)], fontsize=8)
    axis.tick_params(axis="y", length=0)
    axis.set_ylim(-0.6, len(bars) - 0.4)
    axis.set_xlim(0, 1.15 * max(max(r["value"], r["target"]) for r in bars))
    axis.set_title(title)
    axis.spines[["top", "right"]].set_visible(False)


def plot(results, path):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    plt.rcParams.update({"font.size": 9, "axes.titlesize": 10, "axes.linewidth": 0.6, "legend.frameon": False})
    bars = [r for r in results.ratios if r["value"] is not None and r["target"]]
    kernels = [r for r in bars if r["what"].startswith("step / bare")]
    ranks = [r for r in bars if r["what"].startswith("1 process")]
    peers = sorted((r for r in bars if " / pebble" in r["what"]), key=lambda r: r["what"].split(" / ")[0].split(" (")[0])
    most = max(len(kernels), len(ranks), len(peers), 4)
    figure = plt.figure(figsize=(12, 3.2 + 0.23 * most), layout="constrained")
    figure.get_layout_engine().set(h_pad=0.08, w_pad=0.08)
    upper, lower = figure.subfigures(2, 1, height_ratios=(2.8, 0.5 + 0.23 * most))
    for dim, axis in zip((2, 3), upper.subplots(1, 2)):
        per_cell = 9 if dim == 2 else 8
        for color, basis in enumerate(BASES):
            for program, style in (("pebble", "o-"), ("bare", ".:")):
                best = {}
                for row in results.series:
                    if (row["program"], row["dim"], row["basis"], row["update"], row["per_cell"], row["processes"]) == (
                            program, dim, basis, "usl", per_cell, 1):
                        best[row["particles"]] = min(row["min_ns"], best.get(row["particles"], float("inf")))
                if best:
                    axis.plot(*zip(*sorted(best.items())), style, color=f"C{color}", markersize=4,
                              label=BASES[basis] if program == "pebble" else None)
        axis.plot([], [], ".:", color="0.3", label="bare kernels")
        axis.set_xscale("log")
        axis.set_ylim(bottom=0)
        axis.set_xlabel("particles")
        axis.set_ylabel("ns per particle and step")
        axis.set_title(f"a step, {dim}-D, usl, {per_cell} particles per cell, 1 process")
        axis.spines[["top", "right"]].set_visible(False)
        axis.legend(loc="center left", bbox_to_anchor=(1, 0.5), fontsize=8)
    panels = [(kernels, "a step / its bare kernels"), (peers, "other programs / pebble"), (ranks, "1 process / 2 processes")]
    panels = [panel for panel in panels if panel[0]]
    for axis, panel in zip(lower.subplots(1, len(panels), squeeze=False).flat if panels else (), panels):
        draw_bars(axis, *panel)
    figure.supxlabel("bars: black line: target; blue: met, grey: missed", fontsize=9)
    figure.savefig(path, dpi=130)
    return path


def redraw(args):
    """Draws docs/bench.png from what is in docs: the series of the floor, and the tables of ratios. Makes the table of the
    matrix anew from its file."""
    results = Results(args)
    with open(os.path.join(args.docs, "data", "bench", "floor.csv"), newline="") as f:
        for row in csv.DictReader(f):
            results.series.append({**row, **{k: int(row[k]) for k in ("dim", "particles", "per_cell", "processes")},
                                   "min_ns": float(row["min_ns"])})
    with open(os.path.join(args.docs, "performance.md")) as f:
        text = f.read()
    for section in SECTIONS:
        part = text.split(f"<!-- {section}: written")[1].split(f"<!-- {section}: end")[0]
        for what, value, sign, target, verdict in re.findall(
                r"^\| (.+?) \| ([\d.]+) \| .*? \| ([<>])= ([\d.]+) \| (\w+) \|$", part, re.M):
            results.ratios.append(dict(what=what, value=float(value), target=float(target), at_least=sign == ">", unit="",
                                       verdict=verdict))
    told = re.findall(r"^\* .*$", text.split("<!-- matrix: written")[1].split("<!-- matrix: end")[0], re.M)
    with open(matrix_file(args), newline="") as f:
        renew(os.path.join(args.docs, "performance.md"), "matrix", "`make bench BENCH=full`", [*told, "", *matrix_table(csv.DictReader(f))])
    return plot(results, os.path.join(args.docs, "bench.png"))


def renew(path, mark, by, lines):
    """Replaces the section between the marks."""
    begin, end = f"<!-- {mark}: written by {by} -->", f"<!-- {mark}: end -->"
    with open(path) as f:
        text = f.read()
    if begin not in text or end not in text:
        print(f"{path} has no marks for {mark}")
        return
    before, rest = text.split(begin, 1)
    with open(path, "w") as f:
        f.write("\n".join([before + begin, "", *lines, "", end]) + rest.split(end, 1)[1])


def matrix_table(rows):
    """The matrix for the usual number of particles a cell, as rows of Markdown, from the rows of matrix.csv."""
    sizes = [float(n) for n in SIZES.split(",")]
    best = {}
    for row in rows:
        dim, processes, particles = (int(row[name]) for name in ("dim", "processes", "particles"))
        if int(row["per_cell"]) == math.prod(USUAL[dim]):
            asked = min(sizes, key=lambda n: abs(math.log(particles / n)))
            best[dim, row["basis"], asked, processes] = float(row["min_ns"])
    text = ["| | " + " | ".join(f"{n:.0e}".replace("e+0", "e") for n in sizes) + " |", "| --- |" + " --- |" * len(sizes)]
    for dim in USUAL:
        for basis in BASES:
            cells = [(best.get((dim, basis, n, 1)), best.get((dim, basis, n, 2))) for n in sizes]
            text.append(f"| {dim}-D {BASES[basis]} | "
                        + " | ".join(f"{one:.1f} ({one / two:.2f})" if one and two else "" for one, two in cells) + " |")
    return text


def matrix_file(args):
    return os.path.join(args.docs, "data", "bench", "matrix.csv")


def record_matrix(args, results, lines):
    """Writes the matrix as a file, and the usual part of it as a table of ns and speed-ups."""
    columns = ["dim", "basis", "per_cell", "particles", "processes", "steps", "repeats", "min_ns", "median_ns"]
    rows = [{**row, **{k: f"{row[k]:.4g}" for k in ("min_ns", "median_ns")}} for row in results.series if row["group"] == "matrix"]
    os.makedirs(os.path.dirname(matrix_file(args)), exist_ok=True)
    with open(matrix_file(args), "w", newline="") as f:
        writer = csv.DictWriter(f, columns, extrasaction="ignore", lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    renew(os.path.join(args.docs, "performance.md"), "matrix", "`make bench BENCH=full`",
          [*(f"* {line}" for line in lines), "", *matrix_table(rows)])
    return matrix_file(args)


def updates_table(ratios):
    """A row for each scene of 1e5 particles: its step with usl, and how many times longer steps of the others take. Of minima."""
    cells = {}
    for r in ratios:
        if found := re.match(rf"(step|(?:{'|'.join(COMPACT)}) / usl), (.*), 1e5$", r["what"]):
            cells.setdefault(found[2], {})[found[1]] = r
    columns = ["step", *(f"{name} / usl" for name in COMPACT)]
    rows = ["| 1e5 particles | " + " | ".join(columns) + " | target |", "| --- |" + " --- |" * (len(columns) + 1)]
    for scene, found in cells.items():
        shown = [next(table([found[name]]))[1] if name in found else "" for name in columns]
        judged_all = [judged(r) for r in found.values() if r["target"]]
        rows.append(f"| {scene} | " + " | ".join(shown) + f" | <= {UPDATES:g} {'met' if set(judged_all) == {'met'} else 'missed'} |")
    return [*rows, ""]


def record(args, results, section, lines):
    """Writes the table of ratios of a section, and its file."""
    groups = SECTIONS[section]
    rows = updates_table(results.ratios) if "updates" in groups else []
    rows += ["| | of minima | of medians | worst | target | |", "| --- | --- | --- | --- | --- | --- |"]
    rows += ["| " + " | ".join(cells) + " |" for cells in table([r for r in results.ratios if r.get("group") in groups])
             if cells[0].split(" / ")[0] not in COMPACT and not re.match(r"step, .*, 1e5", cells[0])]
    renew(os.path.join(args.docs, "performance.md"), section, "`make bench`", [*(f"* {line}" for line in lines), "", *rows])
    path = os.path.join(args.docs, "data", "bench", f"{section}.csv")
    os.makedirs(os.path.dirname(path), exist_ok=True)
    results.write(path, groups)
    return path


def main():
    groups = {"bare": bare, "seed": seed, "peers": peers, "updates": updates, "ranks": ranks, "predicted": predicted.measure}
    more = {"matrix": matrix, "modes": modes, "large": large, "writes": writes}
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--pebble", default="./pebble")
    p.add_argument("--seed", default="build/seed_serial")
    p.add_argument("--bare", default="build/mpicc/bare", help="the bare kernels, without the number of lanes")
    p.add_argument("--mpiexec", default="mpiexec")
    p.add_argument("--flags", default="", help="the compiler's flags, for the description of the machine")
    p.add_argument("--flags-bare", help="the flags that the bare kernels get besides")
    p.add_argument("--flags-seed", help="compiler and flags of seed_serial")
    p.add_argument("--cores", type=int, default=os.cpu_count(),
                   help="cores that are free; with fewer than processes these are started as in the tests")
    p.add_argument("--short", action="store_true", help="bare kernels, seed and peers, three minutes")
    p.add_argument("--full", action="store_true", help="the whole matrix")
    p.add_argument("--only", help="groups, separated by commas")
    p.add_argument("--no-peers", action="store_true", help="leave out Taichi and Warp")
    p.add_argument("--repeats", type=int, help="how often each program runs (5; --short: 3)")
    p.add_argument("--seconds", type=float, help="about how long the steps of one run take (0.8; --short: 0.2)")
    p.add_argument("--sizes", default=SIZES, help="particles of the matrix")
    p.add_argument("--draw", action="store_true", help="measure nothing, draw docs/bench.png and the matrix anew from docs/data and docs/performance.md")
    p.add_argument("--plan", action="store_true", help="only say how long the matrix takes (the other groups: 20 minutes, with --short 3)")
    p.add_argument("--docs", default=os.path.join(ROOT, "docs"), help="where sections, data and plot go")
    p.add_argument("--csv", default=os.path.join(ROOT, "output", "bench.csv"))
    args = p.parse_args()
    args.repeats = args.repeats or (3 if args.short else 5)
    args.seconds = args.seconds or (0.2 if args.short else 0.8)
    default = SECTIONS["floor"] if args.short else (*groups, *(more if args.full else ()))
    wanted = args.only.split(",") if args.only else list(default)
    groups.update(more)
    unknown = set(wanted) - set(groups)
    if unknown:
        p.error(f"{', '.join(sorted(unknown))}: choose of {', '.join(groups)}")

    if args.plan:
        return print(plan(args))
    if args.draw:
        return print(os.path.relpath(redraw(args)))
    results = Results(args)
    start = datetime.datetime.now()
    try:
        lines = machine(args)
    except Failed as failure:
        sys.exit(f"bench.py: {failure}")
    loads = [os.getloadavg()[0]]
    print("\n".join(lines))
    if loads[0] > 0.5:
        print(f"The load average is {loads[0]:.1f}: other work is running, the figures will be too large")
    for name in wanted:
        print(f"{name}:", flush=True)
        groups[name](args, results)
        loads.append(os.getloadavg()[0])
    minutes = (datetime.datetime.now() - start).total_seconds() / 60
    when, load = f"{start:%Y-%m-%d %H:%M}, {minutes:.0f} minutes", f"load average {loads[0]:.1f} at the start"

    print(f"\n{'':68s} {'minima':>9s} {'medians':>9s} {'worst':>9s}   target")
    for what, value, median, worst, bound, verdict in table(results.ratios):
        print(f"{what:68s} {value:>9s} {median:>9s} {worst:>9s}   {bound:10s} {verdict}")
    verdicts = [judged(r) for r in results.ratios]
    print(", ".join(f"{verdicts.count(v)} {v}" for v in ("met", "missed", "failed")) + f"; {when}, {load}")
    for problem in results.problems:
        print(f"FAILED {problem}")
    written = [args.csv]
    if not results.problems and not args.short:
        for section, of in SECTIONS.items():
            if set(of) <= set(wanted):
                written.append(record(args, results, section, [*lines, f"{when}, {args.repeats} repeats in alternation, {load}"]))
        if "matrix" in wanted:
            written.append(record_matrix(args, results, [*lines, f"{when}, {load}"]))
    if results.problems:
        print("docs/performance.md is left as it is")
    try:
        if len(written) > 1 and set(wanted) != {"matrix"}:
            written.append(redraw(args))
        else:
            written.append(plot(results, os.path.join(ROOT, "output", "bench.png")))
    except ImportError as missing:
        print(f"no plot: {missing}")
    print("written:", *map(os.path.relpath, written))
    return bool(results.problems)


if __name__ == "__main__":
    sys.exit(main())
