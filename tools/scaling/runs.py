"""Runs the scenes of `make scaling`, and reads from a run times, the critical path, the prediction, counted messages."""
import collections
import csv
import os
import re
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "tools"))
import launch  # noqa: E402 (after the path)
import scenes  # noqa: E402

BUILD = os.path.join(ROOT, "build", "scaling")
TIMEOUT = 600


class Failed(Exception):
    pass


# ---- The scenes: those of tools/scenes.py

class Scene:
    """name; dim, basis, update; strong, weak(processes): sizes; cells(size)."""

    def __init__(self, scene):
        self.name, self.dim, self.basis, self.update = scene.name, scene.dim, scene.basis, scene.update
        self.strong, self.weak, self.cells = scene.strong, scene.weak, scene.cells

    def options(self, size=None):
        return ["-options_file", scenes.write(BUILD, self.name, size or self.strong)]


SCENES = [Scene(scene) for scene in scenes.SCENES.values()]


# ---- Running

def command_output(command, environment):
    try:
        done = launch.run(command, capture_output=True, text=True, timeout=TIMEOUT, env=environment)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise Failed(str(error)) from error
    if done.returncode:
        lines = [line for line in (done.stderr + done.stdout).splitlines() if re.search(r"\w", line)] or ["no message"]
        raise Failed(f"exit status {done.returncode}: {lines[0].strip()} ({' '.join(command)})")
    return done.stdout


def start(args, processes, *options, program=None):
    return command_output([args.mpiexec, "-n", str(processes), program or args.pebble, *options],
                          launch.environment(processes, args.cores))


def calibrate(args, name, processes, options):
    """Calibrates the model for a method, into a file of this build; returns its name."""
    path = os.path.join(BUILD, f"{name}.{processes}.model")
    os.makedirs(BUILD, exist_ok=True)
    if not (args.keep and os.path.exists(path)):
        start(args, processes, *options, "-model_file", path, "-output_dir", os.path.dirname(path), program=args.calibrator)
    return path


Event = collections.namedtuple("Event", "count messages bytes reductions")


def read_events(path, pool):
    """Events of the steps. Every process notes its sends and its receives, so each message is noted twice. In the pool the master,
    process 0, takes part in all messages, and workers note some before their events begin: there only the master's count."""
    sums = collections.defaultdict(lambda: [0, 0, 0, 0])
    with open(path, newline="") as file:
        for row in csv.reader(file):
            if row[0] != "MPM steps" or (pool and row[2] != "0"):
                continue
            event, part = sums[row[1]], 1 if pool else 0.5
            event[0] = max(event[0], int(float(row[3])))
            event[1] += part * float(row[5])
            event[2] += part * float(row[6])
            event[3] = max(event[3], int(float(row[7])))
    return {name: Event(*event) for name, event in sums.items()}


class Run:
    """One run: particles, steps, grid (of processes), imbalance, seconds, predicted, path, work_imbalance (slowest over
    mean of the work), phases [(name, mean, slowest, messages)] in s a step, digest, events (by -log_view)."""

    def __init__(self, args, options, processes, strategy, migrate, steps, model, count=True, path=True):
        self.processes, self.migrate, self.steps = processes, migrate, steps
        with tempfile.TemporaryDirectory() as folder:
            log = os.path.join(folder, "log.csv")
            kind, _, patch = strategy.partition(":")  # pool:8: with patches of so many cells
            self.strategy, self.patch = kind, patch
            words = ["-pool_cells", patch] if patch else []
            words += ["-time_max_steps", str(steps), "-output_format", "none", "-output_dir", folder, "-history_every",
                      "1e9", "-parallel_strategy", kind, "-parallel_migrate", migrate,
                      "-report_limits", "false", "-report_phases"] + (["-report_path"] if path else [])
            words += ["-model_file", model] if model else []
            if count and processes > 1:
                words += ["-log_view", f":{log}:ascii_csv"]
            text = start(args, processes, *options, *words)
            self.events = read_events(log, kind != "spatial") if count and processes > 1 else {}

        def find(pattern):
            found = re.search(pattern, text, re.M)
            if not found:
                raise Failed(f"no {pattern!r} in the output of {' '.join(options)}")
            return found.groups()

        self.particles = int(find(r"^scene .* (\d+) particles")[0])
        self.digest = find(r"^digest (\w+)")[0]
        self.steps = int(find(r"^done +(\d+) steps")[0])
        self.grid, self.imbalance = (1,), 1.0
        if processes > 1 and kind == "spatial":
            grid, imbalance = find(r"^parallel .* spatial ([\dx]+), particles max/mean ([\d.]+)")
            self.grid, self.imbalance = tuple(map(int, grid.split("x"))), float(imbalance)
        measured, predicted = find(r"^  all +\S+ +\S+ +\S+ +(\S+) +(\S+) +\S+$")
        self.seconds, self.predicted = float(measured), float(predicted)
        self.phases = []
        if path:
            table = re.search(r"^path +processor time.*\n((?:  \w+(?: +\S+){3}\n)+)", text, re.M)
            self.phases = [(name, *map(float, times)) for name, *times in map(str.split, table[1].splitlines())] if table else []
            mean, slowest, path = find(r"^  all +(\S+) +(\S+) +\S+ +critical path (\S+)")
            self.path, self.work_imbalance = float(path), float(slowest) / float(mean)
        if model and "constants calibrated" not in text:
            raise Failed(f"{model} was not used for {' '.join(options)}")


def dry_run(args, options, model, *more):
    """[(processes, seconds, imbalance, seconds in the pool or None)] that the model predicts, and the best edge of the pool's patches."""
    text = start(args, 1, *options, "-dry_run", "-report_processes", "-parallel_migrate", "direct", "-model_file", model, *more)
    best = re.search(r"best patches on 8 processes (\d+)", text)
    rows = re.findall(r"^ +(\d+) +([\d.e+-]+) +\S+ \w+ +[\d.]+ +[\d.]+ +([\d.]+)(?: +([\d.e+-]+) +\S+ \w+ +[\d.]+)?$", text, re.M)
    return [(int(p), float(t), float(i), float(pool) if pool else None) for p, t, i, pool in rows], best[1] if best else ""
