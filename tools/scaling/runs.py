"""Has the scenes that `make scaling` runs, and reads from a run times, the critical path, the prediction, counted messages."""
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

BUILD = os.path.join(ROOT, "build", "scaling")
TIMEOUT = 600


class Failed(Exception):
    pass


# ---- The scenes. `cells` maps a number of particles to cells; the rest is options, or a file and options.

def box(dim, basis):
    """Options of a body of neo-Hookean material that fills its grid and turns about the middle, between walls that let it slide; the
    walls do not change what a process sends. Particles move by about 0.04 cells a step. The formulas are for such full boxes."""
    axes = "xyz"[:dim]
    same = lambda value: ",".join([str(value)] * dim)
    still = ", 0" * (dim - 2)
    options = {
        "dim": dim, "grid_lower": same(0), "grid_upper": same(1), "materials": "m", "material_m_model": "neohookean",
        "material_m_rho": 1000, "material_m_E": 1e6, "material_m_nu": 0.3, "bodies": "b", "body_b_shape": "box",
        "body_b_lower": same(0), "body_b_upper": same(1), "body_b_ppc": same(2), "body_b_material": "m",
        "body_b_velocity": f"4*sin(pi*x)*cos(pi*y), 0-4*cos(pi*x)*sin(pi*y){still}", "method_basis": basis,
        "method_update": "usl", "method_transfer": "flip", "dt_cfl": 0.4, "time_end": 1}
    options.update({f"bc_{axis}{end}_type": "slip" for axis in axes for end in ("min", "max")})
    return options


class Scene:
    """name; dim, basis, update; strong: particles of the strong study; cells(n): cells for about n particles."""

    def __init__(self, name, dim, basis, update, strong, cells, options, file=None):
        self.name, self.dim, self.basis, self.update, self.strong = name, dim, basis, update, strong
        self.cells, self.file = cells, file
        self.words = [word for key, value in options.items() for word in ("-" + key, str(value))]

    def options(self, cells=None):
        chosen = ["-grid_cells", ",".join(map(str, cells or self.cells(self.strong)))]
        return (["-options_file", self.file] if self.file else []) + self.words + chosen


def times(*cells):
    """A function that multiplies these cells by a scale, which it rounds to a whole number."""
    return lambda scale: tuple(c * max(1, round(scale)) for c in cells)


def scene_file(name):
    return os.path.join(ROOT, "options", name + ".opts")


def scene_method(basis, update, cfl):
    """The method of the committed data, in place of that of a scene of options/."""
    return {"method_basis": basis, "method_update": update, "method_transfer": "flip", "method_damping_rate": 0, "dt_cfl": cfl}


# Columns of water would only fall at first. They spread from the start here, so that particles cross cells as they do later.
SCENES = [
    Scene("disks", 2, "linear", "usf", 262144, lambda n: times(1, 1)((n / 4.021) ** 0.5), scene_method("linear", "usf", 0.4), scene_file("disks")),
    Scene("box2d", 2, "linear", "usl", 262144, lambda n: times(1, 1)((n / 4) ** 0.5), box(2, "linear")),
    Scene("dambreak", 2, "bspline2", "musl", 262144, lambda n: times(20, 9)(4 * (n / 2048) ** 0.5),
          {"body_column_velocity": "2*x, 0-2*y", **scene_method("bspline2", "musl", 0.3)}, scene_file("dambreak")),
    Scene("disks3d", 3, "linear", "musl", 262144, lambda n: times(1, 1, 1)((n / 0.5362) ** (1 / 3)), scene_method("linear", "musl", 0.4), scene_file("disks3d")),
    Scene("box3d", 3, "bspline2", "usl", 262144, lambda n: times(1, 1, 1)((n / 8) ** (1 / 3)), box(3, "bspline2")),
    Scene("dambreak3d", 3, "bspline2", "musl", 110592, lambda n: times(4, 4, 3)(6 * (n / 8192) ** (1 / 3)),
          {"body_column_velocity": "2*x, 2*y, 0-4*z", **scene_method("bspline2", "musl", 0.4)}, scene_file("dambreak3d")),
]


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
        self.processes, self.strategy, self.migrate, self.steps = processes, strategy, migrate, steps
        with tempfile.TemporaryDirectory() as folder:
            log = os.path.join(folder, "log.csv")
            words = ["-time_max_steps", str(steps), "-output_format", "none", "-output_dir", folder, "-history_every",
                     "1e9", "-parallel_strategy", "pool" if strategy == "pool" else "spatial", "-parallel_migrate",
                     migrate, "-report_limits", "false", "-report_phases"] + (["-report_path"] if path else [])
            words += ["-model_file", model] if model else []
            if count and processes > 1:
                words += ["-log_view", f":{log}:ascii_csv"]
            text = start(args, processes, *options, *words)
            self.events = read_events(log, strategy == "pool") if count and processes > 1 else {}

        def find(pattern):
            found = re.search(pattern, text, re.M)
            if not found:
                raise Failed(f"no {pattern!r} in the output of {' '.join(options)}")
            return found.groups()

        self.particles = int(find(r"^scene .* (\d+) particles")[0])
        self.digest = find(r"^digest (\w+)")[0]
        self.steps = int(find(r"^done +(\d+) steps")[0])
        self.grid, self.imbalance = (1,), 1.0
        if processes > 1 and strategy != "pool":
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


def dry_run(args, options, model):
    """[(processes, seconds, imbalance, seconds in the pool or None)] that the model predicts."""
    text = start(args, 1, *options, "-dry_run", "-report_processes", "-parallel_migrate", "direct", "-model_file", model)
    rows = re.findall(r"^ +(\d+) +([\d.e+-]+) +\S+ \w+ +[\d.]+ +[\d.]+ +([\d.]+)(?: +([\d.e+-]+) +\S+ \w+ +[\d.]+)?$", text, re.M)
    return [(int(p), float(t), float(i), float(pool) if pool else None) for p, t, i, pool in rows]
