"""Pebble from Python: starts the program and reads what it wrote.

    import pebble_mpm as pebble
    result = pebble.run("options/disks.opts", grid_cells=(40, 40), time_end=0.5)
    result.history["total_energy"]              # a column of the history, a NumPy array
    result.snapshots[-1].particles.stress       # of the last snapshot, in the order of the particles' ids
    result.digest, result.time, result.steps, result.warnings
    results = pebble.sweep("options/disks.opts", dt_cfl=[0.2, 0.4], material_soft_E=[500, 1000])     # four runs

Options have the names that `pebble -help` prints, without the minus. A run that is refused or stops raises an Error
whose text is Pebble's own line. pebble.load("output/disks") reads the files of an earlier run."""

import concurrent.futures
import contextlib
import functools
import itertools
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence

import h5py
import numpy as np

HERE = os.path.dirname(os.path.realpath(__file__))
REFUSED, STOPPED = 2, 3  # exit statuses: the options are wrong; the run stopped, or missed a bound that was asked for


class Error(Exception):
    """A run that did not end well. Its text is the line that the program printed; status and result are what there is
    of it."""

    def __init__(self, line, result):
        super().__init__(line)
        self.status, self.result = result.status, result


def find_program():
    """Path of the program: that of the variable PEBBLE, which then has to be there, else the one of this folder or of
    this installation, else of PATH."""
    named = os.environ.get("PEBBLE", "")
    if named and not os.access(named, os.X_OK):
        raise FileNotFoundError(f"there is no program {named}, which the variable PEBBLE names")
    places = [
        named,
        os.path.join(HERE, "..", "pebble"),
        os.path.join(HERE, "..", "..", "..", "bin", "pebble"),
    ]
    found = next((path for path in places if os.path.isfile(path)), shutil.which("pebble"))
    if not found:
        raise FileNotFoundError(
            "there is no program pebble beside this module, nor in PATH: build it by make in the folder of Pebble, and "
            "repeat `pip install .` there, or name it by the environment variable PEBBLE, or by program="
        )
    return os.path.abspath(found)


def word(value):
    """A value as the program reads it: lists with commas, true and false, numbers with all their digits."""
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, (tuple, list, np.ndarray)):
        return ",".join(map(word, value))
    return repr(float(value)) if isinstance(value, (float, np.floating)) else str(value)


def words(options):
    """Options as words of a command line. None: the option is not given."""
    return [text for name, value in options.items() if value is not None for text in (f"-{name}", word(value))]


# ---- Files


class History(dict):
    """{column: values} of a history; columns are attributes too."""

    def __getattr__(self, name):
        if name not in self:
            raise AttributeError(f"no column {name} in the history; there are {', '.join(self)}")
        return self[name]


class Fields(Mapping):
    """The fields of a group of a snapshot: read when they are asked for, by name or as attributes."""

    def __init__(self, path, group, order=None, keep=None):
        self.path, self.group, self.order, self._keep = path, group, order, keep

    def __getitem__(self, name):
        with h5py.File(self.path) as file:
            values = file[self.group][name][:]
            return values if self.order is None else values[np.argsort(file[self.group][self.order][:], kind="stable")]

    def __getattr__(self, name):
        if name.startswith("_") or name not in self:
            raise AttributeError(f"no field {name}" + ("" if name.startswith("_") else f"; there are {', '.join(self)}"))
        return self[name]

    def __iter__(self):
        with h5py.File(self.path) as file:
            names = (
                [name for name, field in file[self.group].items() if isinstance(field, h5py.Dataset)]
                if self.group in file
                else []
            )
        return iter(names)

    def __len__(self):
        return len(list(iter(self)))


class Snapshot:
    """A state: step, time [s], dt [s], digest; particles[field], in the order of their ids; grid[field], by z, y, x;
    rigid[field], of the surfaces of rigid bodies, without fields if there are none."""

    def __init__(self, path, group, keep=None):
        with h5py.File(path) as file:
            attributes = {name: text(value) for name, value in file[group].attrs.items()}
        self.step, self.time, self.dt = int(attributes["step"]), float(attributes["time"]), float(attributes["dt"])
        self.digest = attributes["digest"]
        self.particles = Fields(path, f"{group}/particles", "id", keep)
        self.grid = Fields(path, f"{group}/grid", keep=keep)
        self.rigid = Fields(path, f"{group}/rigid", keep=keep)


class Snapshots(Sequence):
    """The snapshots of a file by their place in time, none if there is no file; attributes: of the whole file."""

    def __init__(self, path, keep=None):
        self.path, self.groups, self.attributes, self._keep = path, [], {}, keep
        if os.path.exists(path):
            with h5py.File(path) as file:
                self.groups = sorted(
                    (name for name in file if name.startswith("step_")), key=lambda name: int(name[5:])
                )
                self.attributes = {name: text(value) for name, value in file.attrs.items()}

    def __getitem__(self, place):
        if isinstance(place, slice):
            return [Snapshot(self.path, name, self._keep) for name in self.groups[place]]
        return Snapshot(self.path, self.groups[place], self._keep)

    def __len__(self):
        return len(self.groups)

    @property
    def steps(self):
        return np.array([int(name[5:]) for name in self.groups])

    @property
    def times(self):
        return np.array([snapshot.time for snapshot in self])


def text(value):
    return value.decode() if isinstance(value, bytes) else value


def read_history(path):
    """{column: values} of a history; the values of a column that has none in a line are NaN there."""
    with open(path, encoding="utf-8") as file:
        names = file.readline().rstrip("\n").split(",")
    values = np.genfromtxt(path, delimiter=",", skip_header=1, ndmin=2).reshape(-1, len(names))
    return History((name, values[:, k]) for k, name in enumerate(names))


# ---- Runs


class Result:
    """What a run left: status, out and err, which it printed; and what was read from that and from its files,
    folder/name.*. options: those that were given to run()."""

    def __init__(self, folder, name, status=0, out="", err="", keep=None):
        self.folder, self.name, self.status, self.out, self.err = folder, name, status, out, err
        self.options = {}
        self._keep = keep  # a temporary folder, which lasts as long as the result and its snapshots

    def path(self, end):
        return os.path.join(self.folder, self.name + end)

    @functools.cached_property
    def history(self):
        """{column: NumPy array} of the history; columns are attributes too."""
        return read_history(self.path(".csv"))

    @functools.cached_property
    def snapshots(self):
        return Snapshots(self.path(".h5"), self._keep)

    def find(self, pattern):
        """The group of a pattern in what was printed; None if it is not there."""
        found = re.search(pattern, self.out + self.err, re.M)
        return found and found[1]

    def number(self, pattern):
        """The same as a number, NaN if it is not there."""
        return float(self.find(pattern) or "nan")

    @property
    def digest(self):
        return self.find(r"^digest +([0-9a-f]{16})$")

    @property
    def steps(self):
        return int(self.find(r"^done +(\d+) steps") or self.find(r"^stopped at step (\d+),") or 0)

    @property
    def time(self):
        """The simulated time that the run reached, s."""
        return self.number(r"^(?:done +\d+ steps|stopped at step \d+), t=(\S+) s")

    @property
    def seconds(self):
        """How long the run took, s; step_seconds: its steps alone, without output."""
        return self.number(r"^done .* in (\S+) s\b")

    @property
    def step_seconds(self):
        return 1e-9 * self.number(r"^speed +(\S+) ns/particle/step") * self.particles * self.steps

    @property
    def particles(self):
        """How many particles there were at the start."""
        return int(self.find(r"^scene .* (\d+) particles") or 0)

    @property
    def error(self):
        """Against the known solution: rms error of the displacement, m; size: the rms of the solution itself, m."""
        return self.number(r"^reference  rms error of the displacement (\S+) m")

    @property
    def size(self):
        return self.number(r"^reference  .*; its rms is (\S+) m")

    @property
    def warnings(self):
        return [
            line.split(maxsplit=1)[1] for line in dict.fromkeys(self.out.splitlines()) if line.startswith("warning ")
        ]

    @property
    def line(self):
        """The line that says why a run was refused or stopped: the first of standard error that is not of MPI."""
        lines = own_lines(self.err)
        told = " ".join(self.err.split()).strip("- ")
        return lines[0] if lines else f"exit status {self.status}: {told[:400] or 'without a message'}"

    @property
    def reason(self):
        """The same without where it stopped."""
        return re.sub(r"^stopped at step \d+, t=\S+ s: ", "", self.line)


def own_lines(err):
    """Lines of standard error that are not mpiexec's notices, which stand between lines of dashes."""
    lines, notice = [], False
    for line in err.splitlines():
        if len(line) > 20 and set(line) == {"-"}:
            notice = not notice
        elif not notice and line.strip() and not line.startswith("[warn] Epoll "):
            lines.append(line)
    return lines


# A process alone need not look for networks nor at the computer's parts, nor prepare to start others: Open MPI starts eight
# times as fast then.
ALONE = {
    "OMPI_MCA_pml": "ob1",
    "OMPI_MCA_btl": "self",
    "OMPI_MCA_ess_singleton_isolated": "1",
    "HWLOC_COMPONENTS": "no_os,stop",
    "HWLOC_PLUGINS_PATH": "/nowhere",
}


@contextlib.contextmanager
def own_folder(env=None):
    """An environment of a start, this one or env, with a folder for temporary files that no other start has: MPI makes
    there a folder of one name for all runs of a user, and of two runs that start or end in the same moment one may
    fail. Its name is short, as sockets need."""
    with tempfile.TemporaryDirectory(prefix="mpi-", ignore_cleanup_errors=True) as folder:
        yield dict(os.environ if env is None else env) | {"TMPDIR": folder}


def start(command, processes=1, timeout=None):
    """(exit status, standard output, standard error) of a command on so many processes, by mpiexec or what MPIEXEC
    names."""
    command = [*([*os.environ.get("MPIEXEC", "mpiexec").split(), "-n", processes] if processes > 1 else []), *command]
    with own_folder((ALONE if processes == 1 else {}) | dict(os.environ)) as environment:
        done = subprocess.run(
            list(map(str, command)),
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            env=environment,
            timeout=timeout,
        )
    return done.returncode, done.stdout, done.stderr


def run(scene=None, processes=1, folder=None, program=None, timeout=None, check=True, **options):
    """Runs Pebble and returns the Result.

    scene     an options file; or words of a command line, as ["-options_file", path, "-dim", "2"]; None: options alone
    folder    for the files of the run; None: a temporary one, which is removed when the result is not used any more
    program   path of pebble; None: the one that find_program finds
    timeout   s; a run that takes longer is ended with subprocess.TimeoutExpired
    check     False: a run that is refused or stops returns its result as others do
    options   as dt_cfl=0.2, grid_cells=(8, 8), dry_run=True; they count more than those of the scene
    """
    given = (
        []
        if scene is None
        else ["-options_file", scene]
        if isinstance(scene, (str, os.PathLike))
        else list(map(str, scene))
    )
    known, keep, asked = dict(zip(given, given[1:])), None, options
    name = (
        options.get("output_name")
        or known.get("-output_name")
        or os.path.splitext(os.path.basename(known.get("-options_file", "run")))[0]
    )
    place = folder or options.get("output_dir") or known.get("-output_dir")
    if not place and not options.get("dry_run"):
        keep = tempfile.TemporaryDirectory(prefix="pebble-", ignore_cleanup_errors=True)
        place = keep.name
    if not options.get("dry_run"):
        options = options | {"output_dir": place, "output_name": name}
    command = [program or find_program(), *given, *words(options)]
    result = Result(place and str(place), name, *start(command, processes, timeout), keep)
    result.options = asked
    if check and result.status:
        raise Error(result.line, result)
    return result


class Bar:
    """A bar of progress on standard error, with the time left."""

    def __init__(self, total, shown):
        self.total, self.shown, self.done, self.start = total, shown, 0, time.monotonic()
        self.draw()

    def draw(self):
        if not self.shown:
            return
        spent = time.monotonic() - self.start
        left = f", {spent * (self.total - self.done) / self.done:.0f} s left" if 0 < self.done < self.total else ""
        full = 30 * self.done // max(1, self.total)
        line = f"[{'#' * full}{'.' * (30 - full)}] {self.done} of {self.total} runs, {spent:.0f} s{left}"
        print(f"\r{line:<78}", end="" if self.done < self.total else "\n", file=sys.stderr, flush=True)

    def step(self):
        self.done += 1
        self.draw()


def sweep(scene=None, workers=None, progress=None, processes=1, folder=None, check=True, **options):
    """Runs a scene with each combination of the values of options that are lists, several runs at a time; returns their
    Results in sequence, the last list varying fastest. result.options has the options of each.

    workers   runs at a time; None: as many as there are cores for
    progress  a bar on standard error; None: if that is a terminal or a notebook
    folder    for the files: of run k they are in folder/k
    check     False: runs that are refused or stop return their results as others do; else, after all, the first such
              Error is raised
    options   a list has the values to try, a tuple is one value: grid_cells=[(8, 8), (16, 16)]; others as in run()
    """
    lists = {name: values for name, values in options.items() if isinstance(values, (list, range, np.ndarray))}
    cases = [options | dict(zip(lists, values)) for values in itertools.product(*lists.values())]
    workers = workers or max(1, len(os.sched_getaffinity(0)) // processes)
    if progress is None:
        progress = sys.stderr.isatty() or "ipykernel" in sys.modules
    bar = Bar(len(cases), progress)

    def one(k):
        place = None if folder is None else os.path.join(folder, str(k))
        return run(scene, processes, place, check=False, **cases[k])

    with concurrent.futures.ThreadPoolExecutor(workers) as pool:
        runs = [pool.submit(one, k) for k in range(len(cases))]
        try:
            for _ in concurrent.futures.as_completed(runs):
                bar.step()
        except BaseException:  # Ctrl-C: those that have not begun do not
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    results = [done.result() for done in runs]
    wrong = next((result for result in results if result.status), None)
    if check and wrong:
        given = ", ".join(f"{name}={wrong.options[name]}" for name in lists)
        raise Error(f"with {given}: {wrong.line}" if given else wrong.line, wrong)
    return results


def load(path):
    """The Result of an earlier run by the path of its files, with or without their ending. What it printed is not
    kept."""
    folder, name = os.path.split(re.sub(r"\.(csv|h5|xdmf)$", "", os.fspath(path)))
    if not any(os.path.exists(os.path.join(folder, name + end)) for end in (".csv", ".h5")):
        raise FileNotFoundError(f"there are no results {path}.csv or .h5")
    return Result(folder or os.curdir, name)


if __name__ == "__main__":
    sys.exit("pebble_mpm is a module: import pebble_mpm as pebble")
