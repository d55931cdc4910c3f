#!/usr/bin/env python3
"""Measures pebble on this machine, and other programs on the same work (tools/bench/scene.py): `make bench`.

Programs that are compared run in alternation, so that other work slows all alike; figures are the minimum and the median of
the repeats. Times are those of steps, without start-up and without the compilation of kernels. The groups are:

  bare     an instrument: a whole step over its arithmetic alone (bare.c), whose totals must agree with pebble's
  seed     against the plain serial program, which has its own body of as many particles; pebble's drifts and crosses more cells
  peers    against steps in Taichi and Warp, on one core; their energy must agree with pebble's
  updates  usf and musl against usl, at 1e5 particles
  ranks    2 processes against 1, at 1e6 particles, with both ways of migration; the digests must be equal
  presets  the presets on scenes of options/ that they are for, on 1 and 2 processes
  predicted  time of the scenes of options/ over what they say by their first steps (predicted.py)

--short has fewer sizes, repeats and peers, for three minutes. Without it the program writes docs/data/bench where nothing
failed: a file for each group, and machine.csv. `make report` writes the tables of docs/performance.md.
"""

import argparse
import contextlib
import csv
import datetime
import glob
import json
import os
import re
import statistics
import subprocess
import sys
import tempfile

import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
FOLDER = os.path.join(ROOT, "tools", "bench")
VENV = os.path.join(ROOT, "build", "bench-venv")
sys.path[:0] = [os.path.join(ROOT, "tools"), FOLDER]
import launch  # noqa: E402 (after the path)
import predicted  # noqa: E402
import scenes  # noqa: E402
from scene import HALF, LAMBDA, MU, RHO, Scene  # noqa: E402

USUAL = {2: (3, 3), 3: (2, 2, 2)}  # particles a cell
# The methods, and a rough time of a step of them and of others, ns a particle, to choose the number of steps.
METHODS = {(2, "linear"): 16, (2, "bspline2"): 19, (2, "bspline3"): 24, (2, "gimp"): 24, (3, "linear"): 42, (3, "bspline2"): 63}
ROUGH = {"warp": {2: 45, 3: 180}, "taichi": {2: 200, 3: 800}, "seed": {2: 330}}
# Scenes of options/ and the presets that they are timed with, for their first steps.
PROBLEMS = {"disks": ("fast", "balanced", "accurate", "energy"), "ring": ("balanced", "accurate", "solid"),
            "dambreak": ("fast", "balanced", "energy"), "granular_column": ("balanced",), "taylor3d": ("balanced",)}  # fmt: skip
COLUMNS = "group program dim basis update particles per_cell processes steps options memory repeats min_ns median_ns all_ns".split()


class Failed(Exception):
    pass


def output(command, **more):
    try:
        done = launch.run(command, capture_output=True, text=True, timeout=900, **more)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise Failed(str(error)) from error
    if done.returncode:
        raise Failed(f"{' '.join(command)}: exit status {done.returncode}: {(done.stderr + done.stdout).strip()[-300:]}")
    return done.stdout


def near(what, theirs, ours, tolerance, scale=None):
    if not abs(theirs - ours) <= tolerance * (scale or max(abs(theirs), abs(ours))):
        raise Failed(f"{what}: {theirs}, pebble's {ours}")


# ---- What runs: each has `row` (what it is, for the table) and time() -> ns per particle and step
class Pebble:
    """Runs of a scene. After time() `row` has the bytes of a particle with its order and scratch."""

    def __init__(self, args, name, text, ranks, extra, **row):
        self.folder, self.name, self.digests = tempfile.TemporaryDirectory(), name, set()
        path = os.path.join(self.folder.name, f"{name}.opts")
        with open(path, "w") as f:
            f.write(text)
        mpi = [args.mpiexec, "-n", str(ranks)] if ranks > 1 else []
        self.command = [*mpi, args.pebble, "-options_file", path, "-output_dir", self.folder.name,
                        "-output_format", "none", "-report_limits", "false", "-report_phases", *extra]  # fmt: skip
        self.environment = launch.environment(ranks, os.cpu_count())
        self.row = dict(program="pebble", processes=ranks, options=" ".join(extra)) | row

    def time(self):
        out = output(self.command, env=self.environment)
        patterns = r"^  all +\S+ +\S+ +(\S+)", r"^digest (\w+)", r"^fields .*, (\d+) with order", r"^kernels .* (\d+) lanes?", r"^scene .*?(\d)-D ", r"^scene .*  (\d+) particles"
        found = [re.search(pattern, out, re.M) for pattern in patterns]
        if None in found:
            raise Failed(f"{' '.join(self.command)}: no line {patterns[found.index(None)]}")
        ns, digest, memory, self.lanes, dim, particles = (match[1] for match in found)
        self.digests.add(digest)
        self.row |= dict(memory=memory if self.row["per_cell"] is None else "", dim=int(dim), particles=int(particles))
        return float(ns)

    def totals(self):
        """The last line of the history of a run, and a scale of momentum."""
        self.time()
        with open(os.path.join(self.folder.name, f"{self.name}.csv")) as f:
            t = {name: float(value) for name, value in list(csv.DictReader(f))[-1].items()}
        return t, t["mass"] * (2 * t["kinetic_energy"] / t["mass"]) ** 0.5


class Other:
    """A program that prints `ns per particle-step`: examples/seed_serial.c or bare.c, without Pebble."""

    def __init__(self, command, scene, **row):
        self.command, self.row = command, dict(dim=scene.dim, particles=scene.particles, per_cell=scene.ppc, processes=1) | row

    def time(self):
        self.said = output(self.command)
        return float(re.search(r"^ns per particle-step (.*)", self.said, re.M)[1])


class Bare(Other):
    """For as many lanes as pebble uses here."""

    def __init__(self, args, scene, basis, steps, lanes, half=None):
        self.file, self.scene, self.half = tempfile.NamedTemporaryFile(), scene, half or scene.half(basis)
        numbers = scene.particles, scene.grid, 0.5 / scene.per_axis[0], RHO * scene.volume, scene.volume, LAMBDA, MU, scene.dt
        super().__init__([f"{args.bare}_{lanes}", self.file.name, str(scene.dim), basis, str(steps), *map(repr, numbers)], scene,
                         program="bare", basis=basis, update="usl", steps=steps)  # fmt: skip

    def time(self):
        x, v = self.scene.arrays(self.half)
        np.concatenate([x.T * self.scene.grid, v.T]).tofile(self.file.name)
        return super().time()

    def totals(self):
        """Those of the history of pebble."""
        self.time()
        s, d = self.scene, self.scene.dim
        values = np.fromfile(self.file.name).reshape(-1, s.particles)
        v, F = values[:d], values[d:].T.reshape(-1, d, d)
        log, mass = np.log(np.linalg.det(F)), RHO * s.volume
        strain = 0.5 * MU * ((F * F).sum((1, 2)) - d - 2 * log) + 0.5 * LAMBDA * log**2
        momentum = {f"momentum_{axis}": mass * p for axis, p in zip("xyz", v.sum(1))}
        return momentum | dict(mass=mass * s.particles, kinetic_energy=0.5 * mass * (v * v).sum(), strain_energy=s.volume * strain.sum())


class Peer:
    """A process in Taichi or Warp that has compiled its kernels and waits for numbers of steps."""

    def __init__(self, name, scheme, scene, steps):
        self.label = f"{name}, {scheme}"
        words = [os.path.join(VENV, "bin", "python"), os.path.join(FOLDER, f"peer_{name}.py"), scheme, str(scene.dim), str(scene.particles), *map(str, scene.per_axis)]
        environment = os.environ | {"WARP_CACHE_PATH": os.path.join(VENV, "warp")}
        self.process = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment)
        self.row = dict(program=name, dim=scene.dim, basis="bspline2", update="usl" if scheme == "flip" else "mls",
                        particles=scene.particles, per_cell=scene.ppc, processes=1, steps=steps)  # fmt: skip
        near(f"{self.label}: particles", self.answer()["particles"], scene.particles, 0)

    def answer(self):
        for line in self.process.stdout:  # the other lines are greetings of the library
            if line.startswith("{"):
                return json.loads(line)
        raise Failed(f"{self.label}: it ended")

    def run(self, steps):
        with contextlib.suppress(OSError):  # if it has ended
            print(steps, file=self.process.stdin, flush=True)
        return self.answer()

    def time(self):
        return self.run(self.row["steps"] + 1)["ns"]  # the first step is not timed


# ---- The groups, and what is kept
class Bench:
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

    def alternate(self, group, runs):
        """Times all runs in turns, and prints how many times as long as the first each took."""
        times, first = {name: [] for name in runs}, None
        for _ in range(self.args.repeats):
            for name in [name for name, t in times.items() if None not in t]:
                times[name].append(self.attempt(runs[name].time))
        for name, t in ((name, t) for name, t in times.items() if None not in t):
            first, row = first or min(t), runs[name].row
            self.series.append(dict(group=group, **row, repeats=len(t), min_ns=min(t), median_ns=statistics.median(t), all_ns=" ".join(f"{x:.4g}" for x in t)))
            print(f"  {name:44s} {row['particles']:8d}  min {min(t):7.1f}  median {statistics.median(t):7.1f} ns  {min(t) / first:5.2f}", flush=True)
        if group in ("ranks", "presets") and len(digests := set().union(*(run.digests for run in runs.values()))) > 1:
            self.problem(f"{group}: {', '.join(runs)}: digests differ: {digests}")

    def record(self, groups, about):
        """Writes a file for each group that ran, and the machine."""
        folder = os.path.join(ROOT, "docs", "data", "bench")
        for name in groups:
            if rows := [{column: row.get(column, "") for column in COLUMNS} for row in self.series if row["group"] == name]:  # the peers may be left out
                scenes.table(os.path.join(folder, f"{name}.csv"), rows)
        with open(os.path.join(folder, "machine.csv"), newline="") as f:
            rows = [row for row in csv.DictReader(f) if row["group"] not in groups]
        scenes.table(os.path.join(folder, "machine.csv"), rows + [dict(group=name, name=k, value=v) for name in groups for k, v in about.items()])

    def choose(self, scene, ns, least):
        """A number of steps. With many of them linear with usl is unstable."""
        return max(least, min(scene.room, 1000, round(1e9 * self.args.seconds / ns / scene.particles)))

    def pebble(self, scene, basis, update="usl", ranks=1, extra=(), steps=None, half=None):
        steps = steps or self.choose(scene, METHODS[scene.dim, basis] * (1.2 if scene.ppc < 8 else 1), 30)
        return Pebble(self.args, "scene", scene.options(basis, update, steps, half), ranks, extra, basis=basis, update=update, per_cell=scene.ppc, steps=steps)

    def preset(self, name, word, ranks, steps=200):
        """A scene of options/ with a preset; its name and the preset's stand in the columns of basis and update."""
        with open(os.path.join(ROOT, "options", f"{name}.opts")) as f:
            text = "".join(line for line in f if not line.startswith(("-method_", "-dt_cfl", "-output_every", "-check_energy")))
        text += f"-method_preset {word}\n-time_max_steps {steps}\n-parallel_migrate direct\n"
        return Pebble(self.args, name, text, ranks, (), basis=name, update=word, per_cell=None, steps=steps)

    def check_bare(self, dim, basis):
        """The bare kernels compute what pebble does: 12 steps of halves that run into each other. Returns the lanes."""
        scene = Scene(dim, 1e4, USUAL[dim])
        ours = self.pebble(scene, basis, steps=12, half=HALF)
        t, scale = ours.totals()
        for name, value in Bare(self.args, scene, basis, 12, ours.lanes, HALF).totals().items():
            near(f"bare kernels, {basis} {dim}-D: {name}", value, t[name], 1e-11, scale if "momentum" in name else None)
        return ours.lanes

    def bare(self):
        for dim, basis in METHODS:
            if lanes := self.attempt(self.check_bare, dim, basis):
                for scene in (Scene(dim, n, USUAL[dim]) for n in self.args.sizes):
                    ours, name = self.pebble(scene, basis), f"{basis} {dim}-D"
                    self.alternate("bare", {f"{name} bare": Bare(self.args, scene, basis, ours.row["steps"], lanes), f"{name} usl": ours})

    def serial(self, scene, steps):
        words = ["setup=block", "material=neohookean", f"cells={scene.grid}", f"ppc={scene.per_axis[0]}", f"steps={steps}", "time=1"]
        return Other([self.args.seed, *words], scene, program="seed_serial", basis="linear", update="usf", steps=steps)

    def check_seed(self, theirs, ours):
        theirs.time()
        near("seed: kinetic energy", float(re.search(r"^kinetic (.*)", theirs.said, re.M)[1]), ours.totals()[0]["kinetic_energy"], 1e-10)

    def seed(self):
        scene = Scene(2, 1e5, (2, 2), drift=False)
        self.attempt(self.check_seed, self.serial(scene, 10), self.pebble(scene, "linear", "usf", steps=10))
        runs = {f"linear 2-D {update}": self.pebble(Scene(2, scene.particles, (2, 2)), "linear", update) for update in ("usl", "usf")}
        self.alternate("seed", runs | {"seed_serial": self.serial(scene, self.choose(scene, ROUGH["seed"][2], 5))})

    def check_peer(self, peer, scene, scheme):
        """Total mass and momentum stay, and where the scheme is the same the kinetic energy is that of pebble's step."""
        theirs, (ours, scale) = peer.run(12), self.pebble(scene, "bspline2", steps=12).totals()
        near(f"{peer.label}: mass of the nodes", theirs["grid_mass"], theirs["mass"], 1e-12)
        for a, b in zip(theirs["momentum"], theirs["momentum_start"]):
            near(f"{peer.label}: momentum", a, b, 1e-10, scale)
        # MLS-MPM is another scheme, which has to compute only about the same motion.
        near(f"{peer.label}: kinetic energy", theirs["kinetic"], ours["kinetic_energy"], 1e-6 if scheme == "flip" else 1e-2)

    def peers(self):
        names = [name for name in ("warp", "taichi") if glob.glob(f"{VENV}/lib/python*/site-packages/{name}")]
        print(f"  {', '.join(names) or 'none'} installed in build/bench-venv")
        for dim, n in ((dim, n) for dim in (2, 3) if names for n in self.args.sizes):
            scene, started = Scene(dim, n, USUAL[dim]), {}
            for name, scheme in ((name, scheme) for name in names for scheme in (("flip",) if self.args.short else ("flip", "mls"))):
                if peer := self.attempt(Peer, name, scheme, scene, self.choose(scene, ROUGH[name][dim], 2)):
                    started[f"{name} {scheme} {dim}-D"] = peer
                    if n == 1e5:
                        self.attempt(self.check_peer, peer, scene, scheme)
            self.alternate("peers", {f"bspline2 {dim}-D usl": self.pebble(scene, "bspline2")} | started)
            for peer in started.values():
                peer.process.communicate()

    def updates(self):
        for dim, basis in METHODS:
            self.alternate("updates", {f"{basis} {dim}-D {update}": self.pebble(Scene(dim, 1e5, USUAL[dim]), basis, update) for update in ("usl", "usf", "musl")})

    def ranks(self):
        cases = {"1 process": (1, ()), "2 processes": (2, ()), "2 processes, direct": (2, ("-parallel_migrate", "direct"))}
        for dim, basis in METHODS:
            scene = Scene(dim, 1e6, USUAL[dim])
            self.alternate("ranks", {f"{basis} {dim}-D usl, {case}": self.pebble(scene, basis, "usl", *what) for case, what in cases.items()})

    def presets(self):
        for name, word in ((name, word) for name, words in PROBLEMS.items() for word in words):
            self.alternate("presets", {f"{name}, {word}, {n}": self.preset(name, word, n) for n in (1, 2)})

    def predicted(self):
        predicted.measure(self, output)


def main():
    groups = "bare", "seed", "peers", "updates", "ranks", "presets", "predicted"
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for word, default in (("pebble", "./pebble"), ("seed", "build/seed_serial"), ("bare", "build/mpicc/bare"), ("mpiexec", "mpiexec"), ("flags", "unknown")):
        p.add_argument(f"--{word}", default=default)
    p.add_argument("--short", action="store_true", help="bare kernels, seed and peers, three minutes")
    p.add_argument("--only", help="groups, separated by commas")
    args = p.parse_args()
    # How often each program runs, about how long its steps take, s, and particles.
    args.repeats, args.seconds, args.sizes = (3, 0.2, (1e5,)) if args.short else (5, 0.8, (1e5, 1e6))
    wanted = args.only.split(",") if args.only else groups[:3] if args.short else groups
    if unknown := set(wanted) - set(groups):
        p.error(f"{', '.join(sorted(unknown))}: choose of {', '.join(groups)}")

    bench, start = Bench(args), datetime.datetime.now()
    about = scenes.machine(args.pebble, args.mpiexec) | {"flags": args.flags, "2 processes": launch.settings(2, os.cpu_count())}
    print("\n".join(f"{name}: {words}" for name, words in about.items()))
    for name in wanted:
        print(f"{name}:", flush=True)
        getattr(bench, name)()
    about["when"] = f"{start:%Y-%m-%d %H:%M}, {(datetime.datetime.now() - start).total_seconds() / 60:.0f} minutes, {args.repeats} repeats in alternation"
    if not bench.problems and not args.short:
        bench.record(wanted, about)
    return bool(bench.problems)


if __name__ == "__main__":
    sys.exit(main())
