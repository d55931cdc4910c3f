"""What all tests share: how pebble is started, how its files are read, and how checks are counted.

    import check
    words = check.arguments(__doc__)     # check.program, check.source and check.mpiexec, from the command line
    run = check.pebble("-options_file", check.scene("disks"), n=3)
    check.that(run.status == 0 and run.digest == expected, f"disks on 3 processes: {run.digest}")
    check.end()                          # how many checks failed; the exit status is 1 if any did, or if there were none

A test is started as `test_name.py PEBBLE SOURCE MPIEXEC [WORD...]` in an empty folder, and writes its files there.
"""
import csv
import os
import re
import shutil
import sys
from concurrent.futures import ThreadPoolExecutor

import h5py
import numpy as np

import mpi
from pebble_mpm import read_history as history  # noqa: F401 (for those who use this module; mpi knows the path)

TIMEOUT = 120  # s a run
program = source = mpiexec = None
checks = failures = 0


def arguments(usage, words):
    """Reads the command line; returns the words after MPIEXEC, of which there must be so many (None: any number)."""
    global program, source, mpiexec
    if len(sys.argv) < 4 or words is not None and len(sys.argv) != 4 + words:
        sys.exit(usage)
    program, source, mpiexec = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2]), sys.argv[3]
    return sys.argv[4:]


# ---- Checks

def that(condition, what):
    """Counts a check and says it; returns whether it holds."""
    global checks, failures
    checks += 1
    failures += not condition
    print("ok  " if condition else "FAIL", what, flush=True)
    return bool(condition)


def fault(wrong):
    """Counts a check that is only said if it fails: wrong says what is wrong, or is None."""
    global checks, failures
    checks += 1
    failures += bool(wrong)
    if wrong:
        print("FAIL", wrong, flush=True)


def need(condition, wrong):
    """The same, where what follows builds on it: if it fails it ends the test."""
    fault(None if condition else wrong)
    if not condition:
        end()


def end():
    print(f"{checks} checks, {failures} failed")
    sys.exit(bool(failures) or not checks)


# ---- Runs

class Run:
    """What a run left: status, out, err, said (both), digest (None if it printed none)."""

    def __init__(self, status, out, err):
        self.status, self.out, self.err, self.said = status, out, err, out + err
        self.digest = self.find(r"^digest +([0-9a-f]{16})$")

    def find(self, pattern):
        """The group of a pattern in the output; None if it is not there."""
        found = re.search(pattern, self.out, re.M)
        return found and found.group(1)

    @property
    def lines(self):
        """Standard error without notices of mpiexec."""
        return mpi.own_lines(self.err)

    @property
    def good(self):
        return self.status == 0 and self.digest is not None


def run(command, n=1, timeout=TIMEOUT, **more):
    """A program on n processes; `more` is for mpi.run."""
    return Run(*mpi.run(n, command, timeout, mpiexec or "mpiexec", **more))


def pebble(*options, n=1, lanes=None, **more):
    """Pebble with these options, at most so many lanes."""
    env = {"PEBBLE_VECTOR": str(lanes)} if lanes else None
    return run([program, *options], n, env=env, **more)


def must(*options, **more):
    """The same; a run that fails ends the test."""
    result = pebble(*options, **more)
    if result.status:
        sys.exit(f"{result.said}\nFAIL: exit status {result.status}: pebble {' '.join(map(str, options))}")
    return result


# Ways to run that give the same bits: a number of processes, or a pool.
WAYS = {1: [], 2: [], 3: [], "pool": ["-parallel_strategy", "pool"]}


def scene_in(scene, folder, *more, way=1):
    """A run of an options file, with its results in a folder, in one of the WAYS."""
    return pebble("-options_file", scene, "-output_dir", folder, *more, *WAYS[way], n=2 if way == "pool" else way)


def at_once(function, jobs, workers=2):
    """function of each job, two at a time; the results in order."""
    with ThreadPoolExecutor(workers) as pool:
        return list(pool.map(function, jobs))


def scene(name):
    return os.path.join(source, "options", name + ".opts")


def is_static(path):
    """Whether a scene is of statics, whose bits are those of PETSc's solvers: they depend on its version, the compiler and the
    number of processes, and no pool runs it."""
    return b"\n-method_time static\n" in content(path)


def folder(name):
    """An empty folder of this name."""
    shutil.rmtree(name, ignore_errors=True)
    os.makedirs(name)
    return name


def write(path, text):
    """Writes a file of this text, or of these lines; returns its path."""
    with open(path, "w") as file:
        file.write(text if isinstance(text, str) else "\n".join(text) + "\n")
    return path


# ---- Files

def content(path):
    with open(path, "rb") as file:
        return file.read()


def rows(path):
    """Lines of a CSV file as dicts of texts."""
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def kicked(rows):
    """The time over which velocities have changed, s, of the lines of a history with a line after the first step (docs/method.md)."""
    first = rows["dt"][1]
    return np.where(rows["time"] > 0, rows["time"] + 0.5 * (first - rows["dt"]), 0)


def steps(file):
    """Numbers of the snapshots in an open HDF5 file."""
    return sorted(int(key[5:]) for key in file if key.startswith("step_"))


def group(file, which=-1):
    """The group of one of the snapshots, by its place among them."""
    return file[f"step_{steps(file)[which]:06d}"]


def particles(path, which=-1, fields=None):
    """Fields of the particles of a snapshot, in the order of their ids."""
    with h5py.File(path) as file:
        found = group(file, which)["particles"]
        order = np.argsort(found["id"][:])
        return {key: found[key][:][order] for key in fields or found if isinstance(found[key], h5py.Dataset)}
