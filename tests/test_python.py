"""Pebble from Python: fields and columns as attributes, sweeps, the notebook examples/sweep.ipynb, `pip install .`, and how the
module finds the program.

usage: test_python.py PEBBLE SOURCE MPIEXEC
"""
import contextlib
import io
import json
import os
import subprocess
import sys

import numpy as np

import check
import mpi

check.arguments(__doc__, 0)
LAB = os.path.join(check.source, "lab")
os.environ.update(mpi.ENVIRONMENT | dict(os.environ) | {"PEBBLE": check.program, "MPIEXEC": check.mpiexec, "MPLBACKEND": "Agg"})
sys.path.insert(0, LAB)
import pebble_mpm as pebble  # noqa: E402 (after the path)

DISKS = check.scene("disks")


def fails(kind, wrong, call):
    try:
        call()
    except kind as error:
        return check.that(wrong in str(error), f"{kind.__name__}: {error}")
    return check.that(False, f"no {kind.__name__}: {wrong}")


def attributes():
    r = pebble.run(DISKS, material_soft_E=800.0, time_end=0.1)
    particles = r.snapshots[-1].particles
    check.that(np.array_equal(particles.x, particles["x"]) and np.array_equal(r.history.time, r.history["time"]) and r.history.time[-1] == 0.1
               and particles.von_mises.shape == (1624,), "fields and columns are attributes")
    fails(AttributeError, "no field colour; there are", lambda: particles.colour)
    fails(AttributeError, "no column heat in the history; there are step, time", lambda: r.history.heat)
    check.that(r.options == {"material_soft_E": 800.0, "time_end": 0.1}, f"the options of a run: {r.options}")


def sweeps():
    err = io.StringIO()
    with contextlib.redirect_stderr(err):
        runs = pebble.sweep(DISKS, material_soft_E=[500.0, 1000.0], dt_cfl=[0.2, 0.4], grid_cells=(16, 16), time_end=0.1, progress=True, folder="swept")
    given = [(run.options["material_soft_E"], run.options["dt_cfl"]) for run in runs]
    check.that(given == [(500, 0.2), (500, 0.4), (1000, 0.2), (1000, 0.4)] and sorted(os.listdir("swept")) == list("0123"), f"each combination: {given}")
    alone = [pebble.run(DISKS, material_soft_E=E, dt_cfl=cfl, grid_cells=(16, 16), time_end=0.1).digest for E, cfl in given]
    check.that([run.digest for run in runs] == alone and len(set(alone)) == 4, f"with the bits of runs alone: {alone}")
    bar = err.getvalue().split("\r")
    check.that(bar[1].startswith("[....") and len(bar) == 6 and bar[-1].startswith(f"[{'#' * 30}] 4 of 4 runs, ") and bar[-1].endswith("\n"), f"a bar of progress: {bar[-1]}")
    with contextlib.redirect_stderr(io.StringIO()) as quiet:
        two = pebble.sweep(DISKS, workers=1, processes=2, time_end=[0.05], dt_cfl=0.4)
    check.that(len(two) == 1 and two[0].status == 0 and not quiet.getvalue(), "one run on two processes, without a bar where no one looks")
    fails(pebble.Error, "with dt_cfl=-1: -dt_cfl", lambda: pebble.sweep(DISKS, dt_cfl=[0.4, -1], time_end=0.01))
    both = pebble.sweep(DISKS, dt_cfl=[0.4, -1], time_end=0.01, check=False)
    check.that([run.status for run in both] == [0, pebble.REFUSED], "refused runs are returned, where that is asked for")


def notebook():
    """Its cells run, in sequence, where it lies."""
    with open(os.path.join(check.source, "examples", "sweep.ipynb"), encoding="utf-8") as file:
        book = json.load(file)
    code = ["".join(cell["source"]) for cell in book["cells"] if cell["cell_type"] == "code"]
    check.that(not any(cell["outputs"] for cell in book["cells"] if cell["cell_type"] == "code"), "the notebook is kept without outputs")
    here, said, names = os.getcwd(), io.StringIO(), {"__name__": "__main__"}
    os.chdir(os.path.join(check.source, "examples"))
    try:
        with contextlib.redirect_stdout(said):
            for cell in code:
                exec(compile(cell, "sweep.ipynb", "exec"), names)
    finally:
        os.chdir(here)
    reach = names["run_out"]
    check.that(len(reach) == 4 and reach == sorted(reach, reverse=True) and 0.3 < reach[-1] < reach[0] < 0.6 and "20 degrees: 0.4" in said.getvalue(), f"the notebook: {said.getvalue()}")
    check.that(len(names["figure"].axes) == 3, "and its picture")


def installs():
    """pip install . into an environment of its own, without any download; the program comes along."""
    made = subprocess.run([sys.executable, "-m", "venv", "--without-pip", "place"], capture_output=True, text=True)
    check.need(made.returncode == 0, f"an environment: {made.stderr}")
    python = os.path.abspath("place/bin/python")
    libraries = {"PYTHONPATH": os.path.dirname(os.path.dirname(np.__file__))}
    plain = {name: value for name, value in os.environ.items() if name not in ("PEBBLE", "PYTHONPATH")}
    for words in ([], ["-e"]):
        done = subprocess.run([sys.executable, "-m", "pip", "--python", python, "install", "--no-deps", "--no-index", *words, check.source], capture_output=True, text=True, env=plain)
        check.need(done.returncode == 0, f"pip install {' '.join(words)} .: {done.stdout[-500:]} {done.stderr[-500:]}")
        code = "import pebble_mpm as p; r = p.run(%r, time_max_steps=2); print(p.__file__, p.find_program(), r.digest)" % DISKS
        if not os.path.exists(os.path.join(check.source, "pebble")):
            continue
        told = subprocess.run([python, "-c", code], capture_output=True, text=True, env=plain | libraries, cwd="place")
        file, program, digest = (told.stdout.split() + [""] * 3)[:3]
        right = os.path.join(LAB, "pebble_mpm.py") if words else os.path.join(os.path.dirname(os.path.dirname(python)), "bin", "pebble")
        check.that((file if words else program) == right and digest == pebble.run(DISKS, time_max_steps=2).digest, f"pip install {' '.join(words)} .: {told.stdout} {told.stderr[-300:]}")
    # Without a program beside it, and none in PATH.
    os.makedirs("bare", exist_ok=True)
    with open(os.path.join(LAB, "pebble_mpm.py")) as source, open("bare/pebble_mpm.py", "w") as copy:
        copy.write(source.read())
    libraries["PYTHONPATH"] = os.pathsep.join([os.path.abspath("bare"), libraries["PYTHONPATH"]])
    find = [sys.executable, "-c", "import pebble_mpm as p; print(p.find_program())"]
    lost = subprocess.run(find, capture_output=True, text=True, env=plain | libraries | {"PATH": "/nowhere"})
    check.that("there is no program pebble beside this module, nor in PATH: build it by make" in lost.stderr, f"no program: {lost.stderr[-300:]}")
    named = subprocess.run(find, capture_output=True, text=True, env=plain | libraries | {"PATH": "/nowhere", "PEBBLE": check.program})
    check.that(named.stdout.strip() == check.program, "PEBBLE names it")
    os.makedirs("path", exist_ok=True)
    if not os.path.lexists("path/pebble"):
        os.symlink(check.program, "path/pebble")
    there = subprocess.run(find, capture_output=True, text=True, env=plain | libraries | {"PATH": os.path.abspath("path")})
    check.that(there.stdout.strip() == os.path.abspath("path/pebble"), "or PATH has it")


for part in (attributes, sweeps, notebook, installs):
    part()
check.end()
