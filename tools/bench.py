#!/usr/bin/env python3
"""Measures pebble on this machine, and other programs on the same work: `make bench`, or with BENCH=short or BENCH=full.

The work is that of tools/bench/scene.py. Programs that are compared run in alternation, so that other work on the machine slows
all alike; figures are the minimum and the median of the repeats, ratios are of minima. Times are those of the steps per
particle and step, without start-up and without the compilation of kernels. The groups are:

  seed     against examples/seed_serial.c, the plain serial program: it has its own body of as many particles, in which usl soon is
           unstable; pebble's body drifts and crosses more cells. Both are compared on the serial program's body. (The time of
           the serial program is the processor's.)
  peers    against steps in Taichi and Warp (tools/bench/), on one core; their energy must agree with pebble's
  updates  usf and musl against usl, at 1e5 particles
  ranks    2 processes against 1, at 1e6 particles, with both ways of migration; the digests must be equal
  predicted  time of the scenes of options/ over what they say by their first steps (tools/bench/predicted.py)
  presets  the presets on scenes of options/ that they are for, on 1 and 2 processes
  bare     an instrument: a whole step over its arithmetic alone (tools/bench/bare.c), whose mass, momentum and energies must
           agree with pebble's
  large    (full) 1e7 particles against 1e6 on 2 processes; 1e7 on 1 process against 2. It takes 6 GiB

A ratio may have a target. It stands beside the ratio of the medians and the least favourable one of two runs that followed
each other. --short has fewer sizes, repeats and peers, for three minutes.

The program writes output/bench.csv, and where nothing failed docs/data/bench: a file for each group that ran, and machine.csv.
`make report` writes the tables of docs/performance.md from them.
"""
import argparse
import csv
import datetime
import functools
import json
import os
import re
import statistics
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
FOLDER = os.path.join(ROOT, "tools", "bench")
sys.path.insert(0, os.path.join(ROOT, "tools"))
sys.path.insert(0, FOLDER)
from scene import HALF, Scene  # noqa: E402 (after the path)
import launch  # noqa: E402
import predicted  # noqa: E402
import scenes  # noqa: E402

BASES = {"linear": "linear", "bspline2": "quadratic", "bspline3": "cubic", "gimp": "GIMP"}
USUAL = {2: (3, 3), 3: (2, 2, 2)}  # particles a cell
METHODS = [(2, "linear"), (2, "bspline2"), (2, "bspline3"), (2, "gimp"), (3, "linear"), (3, "bspline2")]
TIMES_FASTER = {"warp": 2, "taichi": 7}  # of the same scheme
# A rough time of a step, to choose the number of steps: {program: {dimension: ns per particle and step}}.
ROUGH = {"warp": {2: 45, 3: 180}, "taichi": {2: 200, 3: 800}, "seed": {2: 330}}
PEBBLE = dict(zip(METHODS, (16, 19, 24, 24, 42, 63)))
LARGE_STEPS = 24  # of each run of the group `large`
MOST = 1000  # steps of a run: linear with usl is unstable
TIMEOUT = 900
# Scenes of options/ and the presets that they are timed with.
PROBLEMS = {"disks": ("fast", "balanced", "accurate", "energy"), "ring": ("balanced", "accurate", "solid"),
            "dambreak": ("fast", "balanced", "energy"), "granular_column": ("balanced",), "taylor3d": ("balanced",)}  # fmt: skip


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
    """Runs of a scene of tools/bench/scene.py. After time() `memory` has the bytes of a particle with its order and scratch."""

    def __init__(self, args, scene, basis, update, steps, ranks=1, extra=(), half=None):
        self.folder = tempfile.TemporaryDirectory()
        self.args, self.steps, self.ranks, self.digests = args, steps, ranks, set()
        path = os.path.join(self.folder.name, "scene.opts")
        with open(path, "w") as f:
            f.write(scene.options(basis, update, steps, half))
        self.start(path, ranks, extra)
        self.row = dict(program="pebble", dim=scene.dim, basis=basis, update=update, particles=scene.particles,
                        per_cell=scene.ppc, processes=ranks, steps=steps, options=" ".join(extra))

    def start(self, path, ranks, extra):
        mpi = [self.args.mpiexec, "-n", str(ranks)] if ranks > 1 else []
        self.command = [*mpi, self.args.pebble, "-options_file", path, "-output_dir", self.folder.name,
                        "-output_format", "none", "-report_limits", "false", "-report_phases", *extra]
        self.environment = launch.environment(ranks, self.args.cores)

    def time(self):
        self.said = out = command_output(self.command, env=self.environment)
        row, digest = re.search(r"^  all +\S+ +\S+ +(\S+)", out, re.M), re.search(r"^digest (\w+)", out, re.M)
        if not row or not digest:
            raise Failed(f"{' '.join(self.command)}: no table of phases or no digest in its output")
        self.digests.add(digest[1])
        self.memory = int(re.search(r"^fields .*, (\d+) with order", out, re.M)[1])
        return float(row[1])

    def totals(self):
        """The last line of the last run's history."""
        with open(os.path.join(self.folder.name, "scene.csv")) as f:
            return list(csv.DictReader(f))[-1]

    def kinetic(self):
        return float(self.totals()["kinetic_energy"])


class Preset(Pebble):
    """A scene of options/ with a preset, for its first steps."""

    def __init__(self, args, name, preset, ranks):
        self.folder = tempfile.TemporaryDirectory()
        self.args, self.steps, self.ranks, self.digests = args, 200, ranks, set()
        path = os.path.join(self.folder.name, f"{name}.opts")
        with open(os.path.join(ROOT, "options", f"{name}.opts")) as f, open(path, "w") as out:
            out.write("".join(line for line in f if not line.startswith(("-method_", "-dt_cfl", "-output_every", "-check_energy"))))
        extra = ("-method_preset", preset, "-time_max_steps", str(self.steps), "-parallel_migrate", "direct")
        self.start(path, ranks, extra)
        said = command_output([args.pebble, "-options_file", path, *extra, "-dry_run", "-output_dir", self.folder.name])
        found = re.search(r"^scene .*?(\d)-D .*  (\d+) particles", said, re.M)
        self.row = dict(program="pebble", dim=int(found[1]), basis=name, update=preset, particles=int(found[2]), per_cell="",
                        processes=ranks, steps=self.steps, options="")


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
            rows[name] = dict(group=group, **runs[name].row, memory=getattr(runs[name], "memory", ""), repeats=len(t), times=t, min_ns=min(t),
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

    def write(self, path, group=None):
        columns = ["group", "program", "dim", "basis", "update", "particles", "per_cell", "processes", "steps",
                   "options", "memory", "repeats", "min_ns", "median_ns", "all_ns"]
        os.makedirs(os.path.dirname(path) or ".", exist_ok=True)
        with open(path, "w", newline="") as f:
            writer = csv.DictWriter(f, columns, restval="", extrasaction="ignore", lineterminator="\n")
            writer.writeheader()
            writer.writerows(row for row in self.series if group in (None, row["group"]))


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
        bound = "" if r["target"] is None else f"{'>=' if r['at_least'] else '<='} {r['target']:g}"
        yield r["what"], *("-" if r.get(k) is None else f"{r[k]:.2f}" for k in ("value", "median", "worst")), bound, judged(r)


# ---- The groups

def choose(args, scene, ns, least):
    return max(least, min(scene.room(), MOST, round(1e9 * args.seconds / ns / scene.particles)))


def pebble(args, scene, basis, update="usl", ranks=1, extra=()):
    steps = choose(args, scene, PEBBLE[scene.dim, basis] * (1.2 if scene.ppc < 8 else 1), 30)
    return Pebble(args, scene, basis, update, steps, ranks, extra)


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
    for n in (1e5,) if args.short else (1e5, 1e6):
        for dim, basis in METHODS:
            scene, name = Scene(dim, n, USUAL[dim]), f"{BASES[basis]} {dim}-D"
            ours = pebble(args, scene, basis)
            rows = results.alternate("bare", {f"{name} usl": ours, f"{name} bare": Bare(args, scene, basis, ours.steps)})
            results.ratio(f"step / bare kernels, {name}, {size(scene)}", rows, f"{name} usl", f"{name} bare", None, False)


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
        rows = results.alternate("updates", {f"{name} {update}": pebble(args, scene, basis, update) for update in ("usl", "usf", "musl")})
        for update in ("usf", "musl"):
            results.ratio(f"{update} / usl, {name}, {size(scene)}", rows, f"{name} {update}", f"{name} usl", None, False)


def same_bits(results, group, name, runs, repeats=None):
    """Times runs, and reports a problem unless their digests are equal."""
    rows = results.alternate(group, runs, repeats)
    digests = set().union(*(run.digests for run in runs.values()))
    if len(digests) > 1:
        results.problem(f"{group}: {name}: digests differ: {digests}")
    return rows


CASES = {"1 process": (1, ()), "2 processes": (2, ()), "2 processes, direct": (2, ("-parallel_migrate", "direct"))}


def on_two(args, results, group, methods, particles, repeats=None):
    """1 process against 2, with both ways of migration."""
    for dim, basis in methods:
        scene, name = Scene(dim, particles, USUAL[dim]), f"{BASES[basis]} {dim}-D usl"
        rows = same_bits(results, group, name, {f"{name}, {case}": pebble(args, scene, basis, "usl", *what)
                                                for case, what in CASES.items()}, repeats)
        for case in list(CASES)[1:]:
            results.ratio(f"1 process / {case}, {BASES[basis]} {dim}-D, {size(scene)}", rows, f"{name}, 1 process", f"{name}, {case}", 1.85)


def ranks(args, results):
    on_two(args, results, "ranks", METHODS, 1e6)


def presets(args, results):
    for name, words in PROBLEMS.items():
        for preset in words:
            runs = {f"{name}, {preset}, {n}": Preset(args, name, preset, n) for n in (1, 2)}
            rows = same_bits(results, "presets", name, runs)
            results.ratio(f"1 process / 2 processes, {name}, {preset}", rows, *runs, None)


def large(args, results):
    runs = {f"linear 3-D usl, {n:g}": Pebble(args, Scene(3, n, USUAL[3]), "linear", "usl", LARGE_STEPS, 2) for n in (1e6, 1e7)}
    rows = results.alternate("large", runs)
    results.ratio("1e7 / 1e6 particles, step, linear 3-D, 2 processes", rows, *reversed(runs), 1.1, False)
    on_two(args, results, "large", [(3, "linear"), (3, "bspline2")], 1e7, min(2, args.repeats))


# ---- The peers' programs

def install(args):
    """Returns the Python of build/bench-venv, which of the peers it has, and for the others the reason why not."""
    venv, packages = os.path.join(ROOT, "build", "bench-venv"), {"warp": "warp-lang", "taichi": "taichi"}
    python = os.path.join(venv, "bin", "python")
    with open(os.path.join(ROOT, "tools", "requirements-bench.txt")) as f:
        pins = dict(line.strip().split("==") for line in f if "==" in line)
    pip, names, reasons = [python, "-m", "pip", "--disable-pip-version-check"], [], {}
    if args.no_peers:
        return python, names, dict.fromkeys(packages, "--no-peers")
    for name, package in packages.items():
        try:
            if not os.path.exists(os.path.join(venv, "bin", "pip")):
                if args.short:
                    raise Failed("not installed, and --short does not install it")
                command_output([sys.executable, "-m", "venv", "--clear", venv])
            have = {p["name"].lower(): p["version"] for p in json.loads(command_output([*pip, "list", "--format", "json"]))}
            if any(have.get(p) != pins[p] for p in (package, "numpy")):
                if args.short:
                    raise Failed("not installed, and --short does not install it")
                print(f"  installing {package} {pins[package]} in build/bench-venv ...", flush=True)
                command_output([*pip, "install", "-q", "--retries", "1", *(f"{p}=={pins[p]}" for p in (package, "numpy"))])
            names.append(name)
        except Failed as failure:
            reasons[name] = str(failure)[:200]
    return python, names, reasons


# ---- The machine, the files

def machine(args):
    """{what: words} about the machine and the programs of a measurement."""
    flags = f"{args.flags or 'unknown'}; of the bare kernels {args.flags_bare or 'unknown'}; seed_serial: {args.flags_seed or 'unknown'}"
    return scenes.machine(args.pebble, args.mpiexec) | {"flags": flags, "2 processes": launch.settings(2, args.cores)}


def record(args, results, groups, about):
    """Writes a file for each group, and the machine."""
    folder = os.path.join(args.docs, "data", "bench")
    groups = [name for name in groups if any(row["group"] == name for row in results.series)]  # the peers may be left out
    for name in groups:
        results.write(os.path.join(folder, f"{name}.csv"), name)
    path, old = os.path.join(folder, "machine.csv"), []
    if os.path.exists(path):
        with open(path, newline="") as f:
            old = [row for row in csv.reader(f)][1:]
    with open(path, "w", newline="") as f:
        rows = [row for row in old if row[0] not in groups] + [[name, *pair] for name in groups for pair in about.items()]
        csv.writer(f, lineterminator="\n").writerows([["group", "name", "value"], *rows])
    return folder


def main():
    groups = {"seed": seed, "peers": peers, "updates": updates, "ranks": ranks, "presets": presets, "bare": bare, "predicted": predicted.measure}
    more = {"large": large}
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
    p.add_argument("--full", action="store_true", help="also 1e7 particles")
    p.add_argument("--only", help="groups, separated by commas")
    p.add_argument("--no-peers", action="store_true", help="leave out Taichi and Warp")
    p.add_argument("--repeats", type=int, help="how often each program runs (5; --short: 3)")
    p.add_argument("--seconds", type=float, help="about how long the steps of one run take (0.8; --short: 0.2)")
    p.add_argument("--docs", default=os.path.join(ROOT, "docs"), help="where data go")
    p.add_argument("--csv", default=os.path.join(ROOT, "output", "bench.csv"))
    args = p.parse_args()
    args.repeats = args.repeats or (3 if args.short else 5)
    args.seconds = args.seconds or (0.2 if args.short else 0.8)
    wanted = args.only.split(",") if args.only else ["bare", "seed", "peers"] if args.short else [*groups, *(more if args.full else ())]
    groups.update(more)
    if unknown := set(wanted) - set(groups):
        p.error(f"{', '.join(sorted(unknown))}: choose of {', '.join(groups)}")

    results, start, load, about = Results(args), datetime.datetime.now(), os.getloadavg()[0], machine(args)
    print("\n".join(f"{name}: {words}" for name, words in about.items()))
    if load > 0.5:
        print(f"The load average is {load:.1f}: other work is running, the figures will be too large")
    for name in wanted:
        print(f"{name}:", flush=True)
        groups[name](args, results)
    about["when"] = (f"{start:%Y-%m-%d %H:%M}, {(datetime.datetime.now() - start).total_seconds() / 60:.0f} minutes, {args.repeats} repeats in "
                     f"alternation, load average {load:.1f} at the start")

    print(f"\n{'':68s} {'minima':>9s} {'medians':>9s} {'worst':>9s}   target")
    for what, value, median, worst, bound, verdict in table(results.ratios):
        print(f"{what:68s} {value:>9s} {median:>9s} {worst:>9s}   {bound:10s} {verdict}")
    verdicts = [judged(r) for r in results.ratios]
    print(", ".join(f"{verdicts.count(v)} {v}" for v in ("met", "missed", "failed")) + f"; {about['when']}")
    for problem in results.problems:
        print(f"FAILED {problem}")
    written = [args.csv]
    if results.problems or args.short:
        print("docs/data/bench is left as it is")
    else:
        written.append(record(args, results, [name for name in wanted if name != "predicted"], about))
    print("written:", *map(os.path.relpath, written))
    return bool(results.problems)


if __name__ == "__main__":
    sys.exit(main())
