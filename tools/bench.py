#!/usr/bin/env python3
"""Measures pebble on this machine, and other programs on the same work: `make bench`, or with BENCH=short or BENCH=full.

The work is that of tools/bench/scene.py. Programs that are compared run in alternation, so that other work on the machine
slows all alike; figures are the minimum and the median of the repeats. Times are those of the steps per particle and
step, without start-up and without the compilation of kernels. The groups are:

  seed     against examples/seed_serial.c, the plain serial program: it has its own body of as many particles, in which usl is soon
           unstable; pebble's body drifts and crosses more cells. Both are compared on the serial program's body.
  peers    against steps in Taichi and Warp (tools/bench/), on one core; their energy must agree with pebble's
  updates  usf and musl against usl, at 1e5 particles
  ranks    2 processes against 1, at 1e6 particles, with both ways of migration; the digests must be equal
  presets  the presets on scenes of options/ that they are for, on 1 and 2 processes
  bare     an instrument: a whole step over its arithmetic alone (tools/bench/bare.c), whose mass, momentum and energies must
           agree with pebble's
  predicted  time of the scenes of options/ over what they say by their first steps (tools/bench/predicted.py)
  large    (full) 1e7 particles against 1e6 on 2 processes; 1e7 on 1 process against 2. It takes 6 GiB

--short has fewer sizes, repeats and peers, for three minutes. The program writes output/bench.csv, and where nothing failed
docs/data/bench: a file for each group that ran, and machine.csv. `make report` writes the tables of docs/performance.md.
"""

import argparse
import csv
import datetime
import json
import os
import re
import statistics
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
FOLDER = os.path.join(ROOT, "tools", "bench")
sys.path[:0] = [os.path.join(ROOT, "tools"), FOLDER]
import launch  # noqa: E402 (after the path)
import predicted  # noqa: E402
import scenes  # noqa: E402
from scene import HALF, Scene  # noqa: E402

BASES = {"linear": "linear", "bspline2": "quadratic", "bspline3": "cubic", "gimp": "GIMP"}
USUAL = {2: (3, 3), 3: (2, 2, 2)}  # particles a cell
# The methods, and a rough time of a step of them and of others, ns a particle, to choose the number of steps.
METHODS = {(2, "linear"): 16, (2, "bspline2"): 19, (2, "bspline3"): 24, (2, "gimp"): 24, (3, "linear"): 42, (3, "bspline2"): 63}
ROUGH = {"warp": {2: 45, 3: 180}, "taichi": {2: 200, 3: 800}, "seed": {2: 330}}
MOST = 1000  # steps of a run: linear with usl is unstable
TIMEOUT = 900
# Scenes of options/ and the presets that they are timed with, for their first steps.
PROBLEMS = {"disks": ("fast", "balanced", "accurate", "energy"), "ring": ("balanced", "accurate", "solid"),
            "dambreak": ("fast", "balanced", "energy"), "granular_column": ("balanced",), "taylor3d": ("balanced",)}  # fmt: skip
CASES = {"1 process": (1, ()), "2 processes": (2, ()), "2 processes, direct": (2, ("-parallel_migrate", "direct"))}
COLUMNS = "group program dim basis update particles per_cell processes steps options memory repeats min_ns median_ns all_ns".split()


class Failed(Exception):
    pass


def output(command, **more):
    try:
        done = launch.run(command, capture_output=True, text=True, timeout=TIMEOUT, **more)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise Failed(str(error)) from error
    if done.returncode:
        lines = [line.strip() for line in (done.stderr + done.stdout).splitlines() if re.search(r"\w", line)] or ["no message"]
        raise Failed(f"exit status {done.returncode}: {next((line for line in lines if 'error' in line.lower()), lines[0])} ({' '.join(command)})")
    return done.stdout


# ---- What runs: each has `row` (what it is, for the table) and time() -> ns per particle and step
class Pebble:
    """Runs of a scene. After time() `memory` has the bytes of a particle with its order and scratch."""

    def __init__(self, args, name, text, ranks, extra, **row):
        self.folder, self.name, self.digests = tempfile.TemporaryDirectory(), name, set()
        path = os.path.join(self.folder.name, f"{name}.opts")
        with open(path, "w") as f:
            f.write(text)
        mpi = [args.mpiexec, "-n", str(ranks)] if ranks > 1 else []
        self.command = [*mpi, args.pebble, "-options_file", path, "-output_dir", self.folder.name,
                        "-output_format", "none", "-report_limits", "false", "-report_phases", *extra]  # fmt: skip
        self.environment = launch.environment(ranks, args.cores)
        self.row = dict(program="pebble", processes=ranks, options=" ".join(extra)) | row

    def time(self):
        out = output(self.command, env=self.environment)
        row, digest = re.search(r"^  all +\S+ +\S+ +(\S+)", out, re.M), re.search(r"^digest (\w+)", out, re.M)
        if not row or not digest:
            raise Failed(f"{' '.join(self.command)}: no table of phases or no digest in its output")
        self.digests.add(digest[1])
        self.memory, self.lanes = (int(re.search(p, out, re.M)[1]) for p in (r"^fields .*, (\d+) with order", r"^kernels .* (\d+) lanes?"))
        dim, particles = re.search(r"^scene .*?(\d)-D .*  (\d+) particles", out, re.M).groups()
        self.row |= dict(dim=int(dim), particles=int(particles))
        return float(row[1])

    def totals(self):
        """The last line of the last run's history."""
        with open(os.path.join(self.folder.name, f"{self.name}.csv")) as f:
            return {name: float(value) for name, value in list(csv.DictReader(f))[-1].items()}


def pebble(args, scene, basis, update="usl", ranks=1, extra=(), steps=None, half=None):
    steps = steps or choose(args, scene, METHODS[scene.dim, basis] * (1.2 if scene.ppc < 8 else 1), 30)
    return Pebble(args, "scene", scene.options(basis, update, steps, half), ranks, extra, basis=basis, update=update, per_cell=scene.ppc, steps=steps)


def preset(args, name, word, ranks, steps=200):
    """A scene of options/ with a preset; its name and the preset's stand in the columns of basis and update."""
    with open(os.path.join(ROOT, "options", f"{name}.opts")) as f:
        text = "".join(line for line in f if not line.startswith(("-method_", "-dt_cfl", "-output_every", "-check_energy")))
    text += f"-method_preset {word}\n-time_max_steps {steps}\n-parallel_migrate direct\n"
    return Pebble(args, name, text, ranks, (), basis=name, update=word, steps=steps)


class Other:
    """A program that prints `ns per particle-step` and totals: examples/seed_serial.c or bare.c, without Pebble."""

    def __init__(self, command, **row):
        self.command, self.row = command, dict(processes=1) | row

    def time(self):
        self.said = output(self.command)
        return self.total("ns per particle-step")[0]

    def total(self, name):
        return [float(x) for x in re.search(rf"^{name} (.*)", self.said, re.M)[1].split()]


def bare_kernels(args, scene, basis, steps, lanes, half=None):
    """For as many lanes as pebble uses here."""
    return Other([f"{args.bare}_{lanes}", *scene.bare(basis, steps, half)], program="bare", dim=scene.dim, basis=basis, update="usl",
                 particles=scene.particles, per_cell=scene.ppc, steps=steps)  # fmt: skip


def seed_serial(args, scene, steps):
    words = ["setup=block", "material=neohookean", f"cells={scene.grid}", f"ppc={scene.per_axis[0]}", f"steps={steps}", "time=1"]
    return Other([args.seed, *words], program="seed_serial", dim=2, basis="linear", update="usf", particles=scene.particles, per_cell=scene.ppc, steps=steps)


class Peer:
    """A process in Taichi or Warp that has compiled its kernels and waits for numbers of steps."""

    def __init__(self, name, scheme, python, scene, steps):
        self.label, self.log = f"{name}, {scheme}", tempfile.TemporaryFile("w+")
        words = [python, os.path.join(FOLDER, f"peer_{name}.py"), scheme, str(scene.dim), str(scene.particles), *map(str, scene.per_axis)]
        environment = dict(os.environ, WARP_CACHE_PATH=os.path.join(ROOT, "build", "bench-venv", "warp"))
        self.process = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self.log, text=True, env=environment)
        if self.answer()["particles"] != scene.particles:
            raise Failed(f"{self.label}: another number of particles")
        self.row = dict(program=name, dim=scene.dim, basis="bspline2", update="usl" if scheme == "flip" else "mls",
                        particles=scene.particles, per_cell=scene.ppc, processes=1, steps=steps)  # fmt: skip

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
        return self.run(self.row["steps"] + 1)["ns"]  # the first step is not timed


# ---- What is kept
class Results:
    def __init__(self, args):
        self.args, self.series, self.problems = args, [], []

    def problem(self, text):
        self.problems.append(text)
        print(f"  FAILED {text}", flush=True)

    def attempt(self, what, *args):
        """Calls something that may fail; returns what it returns, or None."""
        try:
            return what(*args)
        except Failed as failure:
            self.problem(str(failure))

    def alternate(self, group, runs, repeats=None):
        """Times all runs in turns, and prints how many times as long as the first each took."""
        times = {name: [] for name in runs}
        for _ in range(repeats or self.args.repeats):
            for name in [name for name, t in times.items() if None not in t]:
                times[name].append(self.attempt(runs[name].time))
        first = None
        for name, t in times.items():
            if None not in t:
                first = first or min(t)
                self.series.append(dict(group=group, **runs[name].row, memory=getattr(runs[name], "memory", ""), repeats=len(t), min_ns=min(t),
                                        median_ns=statistics.median(t), all_ns=" ".join(f"{x:.4g}" for x in t)))  # fmt: skip
                print(f"  {name:44s} {runs[name].row['particles']:8d}  min {min(t):7.1f}  median {statistics.median(t):7.1f} ns  {min(t) / first:5.2f}", flush=True)
        self.write(self.args.csv)

    def same_bits(self, group, runs, repeats=None):
        """Times runs, and reports a problem unless their digests are equal."""
        self.alternate(group, runs, repeats)
        if len(digests := set().union(*(run.digests for run in runs.values()))) > 1:
            self.problem(f"{group}: {', '.join(runs)}: digests differ: {digests}")

    def write(self, path, group=None):
        os.makedirs(os.path.dirname(path) or ".", exist_ok=True)
        with open(path, "w", newline="") as f:
            writer = csv.DictWriter(f, COLUMNS, restval="", lineterminator="\n")
            writer.writeheader()
            writer.writerows(row for row in self.series if group in (None, row["group"]))

    def record(self, groups, about):
        """Writes a file for each group that ran, and the machine."""
        folder = os.path.join(ROOT, "docs", "data", "bench")
        groups = [name for name in groups if any(row["group"] == name for row in self.series)]  # the peers may be left out
        for name in groups:
            self.write(os.path.join(folder, f"{name}.csv"), name)
        path = os.path.join(folder, "machine.csv")
        with open(path, newline="") as f:
            rows = [row for row in csv.DictReader(f) if row["group"] not in groups]
        scenes.table(path, rows + [dict(group=name, name=k, value=v) for name in groups for k, v in about.items()])


# ---- The groups
def choose(args, scene, ns, least):
    return max(least, min(scene.room(), MOST, round(1e9 * args.seconds / ns / scene.particles)))


def near(what, theirs, ours, tolerance, scale=None):
    if not abs(theirs - ours) <= tolerance * (scale or max(abs(theirs), abs(ours))):
        raise Failed(f"{what}: {theirs}, pebble's {ours}")


def totals_of(run):
    run.time()
    t = run.totals()
    return t, t["mass"] * (2 * t["kinetic_energy"] / t["mass"]) ** 0.5  # and a scale of momentum


def check_bare(args, dim, basis):
    """The bare kernels compute what pebble does: 12 steps of halves that run into each other."""
    scene = Scene(dim, 1e4, USUAL[dim])
    ours = pebble(args, scene, basis, steps=12, half=HALF)
    (totals, scale), theirs = totals_of(ours), bare_kernels(args, scene, basis, 12, ours.lanes, HALF)
    theirs.time()
    for name, column in (("mass", "mass"), ("kinetic", "kinetic_energy"), ("strain", "strain_energy")):
        near(f"bare kernels, {BASES[basis]} {dim}-D: {name}", theirs.total(name)[0], totals[column], 1e-11)
    for axis, p in zip("xyz"[:dim], theirs.total("momentum")):
        near(f"bare kernels, {BASES[basis]} {dim}-D: momentum along {axis}", p, totals[f"momentum_{axis}"], 1e-11, scale)
    return ours.lanes


def bare(args, results):
    for dim, basis in METHODS:
        if lanes := results.attempt(check_bare, args, dim, basis):
            for n in (1e5,) if args.short else (1e5, 1e6):
                scene, name = Scene(dim, n, USUAL[dim]), f"{BASES[basis]} {dim}-D"
                ours = pebble(args, scene, basis)
                results.alternate("bare", {f"{name} bare": bare_kernels(args, scene, basis, ours.row["steps"], lanes), f"{name} usl": ours})


def check_seed(args, scene):
    theirs = seed_serial(args, scene, 10)
    theirs.time()
    near("seed: kinetic energy", theirs.total("kinetic")[0], totals_of(pebble(args, scene, "linear", "usf", steps=10))[0]["kinetic_energy"], 1e-10)


def seed(args, results):
    for n in (1e5, 2.5e5):  # the serial program's mesh has at most 500 cells a side: 2.5e5 particles at 4 per cell
        scene = Scene(2, n, (2, 2), drift=False)
        results.attempt(check_seed, args, scene)
        ours = Scene(2, scene.particles, (2, 2))
        runs = {f"linear 2-D {update}": pebble(args, ours, "linear", update) for update in ("usl", "usf")}
        results.alternate("seed", runs | {"seed_serial": seed_serial(args, scene, choose(args, scene, ROUGH["seed"][2], 5))})


def check_peer(args, peer, scene, scheme):
    """Total mass and momentum stay, and where the scheme is the same the kinetic energy is that of pebble's step."""
    theirs, (ours, scale) = peer.run(12), totals_of(pebble(args, scene, "bspline2", steps=12))
    near(f"{peer.label}: mass of the nodes", theirs["grid_mass"], theirs["mass"], 1e-12)
    for a, b in zip(theirs["momentum"], theirs["momentum_start"]):
        near(f"{peer.label}: momentum", a, b, 1e-10, scale)
    # MLS-MPM is another scheme, which has to compute only about the same motion.
    near(f"{peer.label}: kinetic energy", theirs["kinetic"], ours["kinetic_energy"], 1e-6 if scheme == "flip" else 1e-2)


def peers(args, results):
    python, names = install(args)
    for dim in (2, 3) if names else ():
        for n in (1e5,) if args.short else (1e5, 1e6):
            scene, started = Scene(dim, n, USUAL[dim]), {}
            for name in names:
                for scheme in ("flip",) if args.short else ("flip", "mls"):
                    peer = results.attempt(Peer, name, scheme, python, scene, choose(args, scene, ROUGH[name][dim], 2))
                    if peer and n == 1e5:
                        results.attempt(check_peer, args, peer, scene, scheme)
                    if peer:
                        started[f"{name} {scheme} {dim}-D"] = peer
            results.alternate("peers", {f"quadratic {dim}-D usl": pebble(args, scene, "bspline2")} | started)
            for peer in started.values():
                peer.process.communicate()


def updates(args, results):
    for dim, basis in METHODS:
        runs = {f"{BASES[basis]} {dim}-D {update}": pebble(args, Scene(dim, 1e5, USUAL[dim]), basis, update) for update in ("usl", "usf", "musl")}
        results.alternate("updates", runs)


def on_two(args, results, group, methods, particles, repeats=None):
    """1 process against 2, with both ways of migration."""
    for dim, basis in methods:
        runs = {f"{BASES[basis]} {dim}-D usl, {case}": pebble(args, Scene(dim, particles, USUAL[dim]), basis, "usl", *what) for case, what in CASES.items()}
        results.same_bits(group, runs, repeats)


def ranks(args, results):
    on_two(args, results, "ranks", METHODS, 1e6)


def presets(args, results):
    for name, words in PROBLEMS.items():
        for word in words:
            results.same_bits("presets", {f"{name}, {word}, {n}": preset(args, name, word, n) for n in (1, 2)})


def large(args, results):
    results.alternate("large", {f"linear 3-D usl, {n:g}": pebble(args, Scene(3, n, USUAL[3]), "linear", ranks=2, steps=24) for n in (1e6, 1e7)})
    on_two(args, results, "large", [(3, "linear"), (3, "bspline2")], 1e7, min(2, args.repeats))


# ---- The peers' programs, the files
def install(args):
    """The Python of build/bench-venv, and which of the peers it has: one that cannot be installed is left out."""
    venv, names = os.path.join(ROOT, "build", "bench-venv"), []
    python = os.path.join(venv, "bin", "python")
    with open(os.path.join(ROOT, "tools", "requirements-bench.txt")) as f:
        pins = dict(line.strip().split("==") for line in f if "==" in line)
    for name, package in (("warp", "warp-lang"), ("taichi", "taichi")):
        try:
            if not os.path.exists(python):
                output([sys.executable, "-m", "venv", venv])
            pip, wanted = [python, "-m", "pip", "--disable-pip-version-check"], [f"{p}=={pins[p]}" for p in (package, "numpy")]
            if not set(wanted) <= set(output([*pip, "freeze"]).split()):
                if args.short:
                    raise Failed("not installed, and --short does not install it")
                output([*pip, "install", "-q", "--retries", "1", *wanted])
            names.append(name)
        except Failed as failure:
            print(f"  {name.capitalize()} is left out: {str(failure)[:200]}")
    return python, names


def main():
    groups = {"seed": seed, "peers": peers, "updates": updates, "ranks": ranks, "presets": presets, "bare": bare, "predicted": predicted.measure, "large": large}
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--pebble", default="./pebble")
    p.add_argument("--seed", default="build/seed_serial")
    p.add_argument("--bare", default="build/mpicc/bare", help="the bare kernels, without the number of lanes")
    p.add_argument("--mpiexec", default="mpiexec")
    p.add_argument("--flags", default="unknown", help="the compilers' flags, for the description of the machine")
    p.add_argument("--cores", type=int, default=os.cpu_count(), help="cores that are free")
    p.add_argument("--short", action="store_true", help="bare kernels, seed and peers, three minutes")
    p.add_argument("--full", action="store_true", help="also 1e7 particles")
    p.add_argument("--only", help="groups, separated by commas")
    p.add_argument("--csv", default=os.path.join(ROOT, "output", "bench.csv"))
    args = p.parse_args()
    args.repeats, args.seconds = (3, 0.2) if args.short else (5, 0.8)  # how often each program runs, and about how long its steps take
    wanted = args.only.split(",") if args.only else ["bare", "seed", "peers"] if args.short else list(groups)[: None if args.full else -1]
    if unknown := set(wanted) - set(groups):
        p.error(f"{', '.join(sorted(unknown))}: choose of {', '.join(groups)}")

    results, start, load = Results(args), datetime.datetime.now(), os.getloadavg()[0]
    about = scenes.machine(args.pebble, args.mpiexec) | {"flags": args.flags, "2 processes": launch.settings(2, args.cores)}
    print("\n".join(f"{name}: {words}" for name, words in about.items()))
    if load > 0.5:
        print(f"The load average is {load:.1f}: other work is running, the figures will be too large")
    for name in wanted:
        print(f"{name}:", flush=True)
        groups[name](args, results)
    about["when"] = f"{start:%Y-%m-%d %H:%M}, {(datetime.datetime.now() - start).total_seconds() / 60:.0f} minutes, {args.repeats} repeats in alternation"
    for problem in results.problems:
        print(f"FAILED {problem}")
    if not results.problems and not args.short:
        results.record(wanted, about)
    return bool(results.problems)


if __name__ == "__main__":
    sys.exit(main())
