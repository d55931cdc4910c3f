"""Every options/*.opts: passes -dry_run, runs, its history is finite, and programs of gcc and clang give the same bits,
each alone and on 3 processes, spatial and pool.

usage: test_scenes.py PEBBLE SOURCE MPIEXEC [WORK]     (WORK: folder for the files, default the current one)
"""
import csv
import glob
import math
import os
import re
import subprocess
import sys

import mpi

STEPS = 200  # of the comparison of compilers
failures = 0


def check(condition, what):
    global failures
    failures += not condition
    print("ok  " if condition else "FAIL", what, flush=True)


def run(*command):
    # a make that this starts must not take part in the one that started this
    environment = {key: value for key, value in os.environ.items() if key not in ("MAKEFLAGS", "MAKELEVEL", "MFLAGS")}
    result = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment)
    return result.returncode, result.stdout


def build(source, work, compiler):
    """The program by this compiler, in a folder of its own."""
    folder = os.path.abspath(os.path.join(work, "build_" + compiler))
    program = os.path.join(folder, "pebble")
    status, said = run("make", "-j2", "-C", source, f"CC={compiler}", f"BUILD={folder}", f"PEBBLE={program}", program)
    if status or not os.path.exists(program):
        sys.exit(f"{said}\nFAIL: no program by {compiler}")
    return program


def digest(program, scene, work, steps, mpiexec=None, strategy="spatial"):
    command = [program, "-options_file", scene, "-time_max_steps", str(steps), "-output_dir", work]
    if mpiexec:
        status, said, err = mpi.run(3, command + ["-parallel_strategy", strategy], mpiexec=mpiexec)
        said += err
    else:
        status, said = run(*command)
    found = re.search(r"^digest +([0-9a-f]{16})$", said, re.M)
    if status or not found:
        print(said)
    return found.group(1) if found and not status else f"none, exit status {status}"


def check_scene(pebble, scene, work):
    name = os.path.splitext(os.path.basename(scene))[0]
    dry = os.path.join(work, "dry")
    status, said = run(pebble, "-options_file", scene, "-dry_run", "-output_dir", dry)
    check(status == 0 and not glob.glob(os.path.join(dry, name + ".*")), f"{name}: -dry_run exits {status} and writes no results")
    if status:
        print(said)
    found = digest(pebble, scene, work, 5)
    check(not found.startswith("none"), f"{name}: 5 steps, digest {found}")
    path = os.path.join(work, name + ".csv")
    if not os.path.exists(path):
        return check(False, f"{name}: no history")
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    numbers = [float(value) for row in rows for value in row.values()]
    check(rows and all(map(math.isfinite, numbers)), f"{name}: {len(rows)} lines of history, {len(numbers)} finite numbers")
    check(rows and int(rows[-1]["step"]) == 5, f"{name}: the last line is of step {rows[-1]['step'] if rows else None}")
    check(os.path.exists(os.path.join(work, name + ".h5")), f"{name}: snapshots")


def main(pebble, source, mpiexec, work="."):
    scenes = sorted(glob.glob(os.path.join(source, "options", "*.opts")))
    check(len(scenes) >= 3, f"{len(scenes)} scenes")
    for scene in scenes:
        check_scene(pebble, scene, work)
    programs = {compiler: build(source, work, compiler) for compiler in ("gcc", "clang")}
    for scene in scenes:
        digests = {compiler: digest(program, scene, os.path.join(work, compiler), STEPS) for compiler, program in programs.items()}
        same = len(set(digests.values())) == 1 and not digests["gcc"].startswith("none")
        for compiler, program in programs.items():
            for strategy in ("spatial", "pool"):
                found = digest(program, scene, os.path.join(work, compiler), STEPS, mpiexec, strategy)
                check(found == digests["gcc"], f"{os.path.basename(scene)}: {compiler}, {strategy} on 3 processes: digest {found}")
        check(same, f"{os.path.basename(scene)}: digest after at most {STEPS} steps by gcc {digests['gcc']}, by clang {digests['clang']}")
    if failures:
        sys.exit(f"FAIL: {failures} checks")


if __name__ == "__main__":
    if len(sys.argv) not in (4, 5):
        sys.exit(__doc__)
    main(*sys.argv[1:])
