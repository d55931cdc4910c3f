"""A parallel run that fails ends, says why once, and leaves its results readable; a run that does not gives the same bits
each time.

usage: test_robust_parallel.py PEBBLE SOURCE WORK MPIEXEC [PART,...]
PART      killed, bad, repeat (default: all)
"""
import os
import re
import shutil
import signal
import sys
import time

import h5py
import numpy as np

import mpi

WITHIN = 10  # s from the death of a process to the end of the run
failures = 0


def check(condition, what):
    global failures
    failures += not condition
    print("ok  " if condition else "FAIL", what, flush=True)
    return condition


def check_files(name, folder):
    """Snapshots that were written before are readable, lines of the history are whole."""
    with open(os.path.join(folder, "run.csv")) as file:
        text = file.read()
    lines = text.split("\n")
    columns = lines[0].count(",")
    whole = lines[-1] == "" and all(line.count(",") == columns for line in lines[:-1])
    check(whole and len(lines) > 3, f"{name}: {len(lines) - 2} lines of history are whole")
    try:
        with h5py.File(os.path.join(folder, "run.h5")) as file:
            steps = sorted(key for key in file if key.startswith("step_"))
            with open(os.path.join(folder, "run.xdmf")) as xdmf: # names the snapshots that are complete
                complete = sorted(set(re.findall(r"/(step_\d+)/", xdmf.read())))
            good = all(np.isfinite(file[step]["particles"][field][:]).all() for step in complete for field in ("id", "x", "v", "F", "stress"))
            check(good and len(complete) >= 2 and set(complete) <= set(steps), f"{name}: {len(complete)} snapshots named by the XDMF file are readable")
    except OSError as error:
        check(False, f"{name}: run.h5: {error}")


def part_killed(pebble, source, work, mpiexec):
    scene = ["-options_file", os.path.join(source, "options", "disks.opts"), "-time_end", "1e9", "-check_energy", "1e9", "-check_momentum", "1e9",
             "-body_disk1_velocity", "0,0", "-body_disk2_velocity", "0,0", "-dt_size", "0.001", "-output_every", "0.1", "-history_every", "0.02"]
    text = open(scene[1]).read()
    scene[1] = os.path.join(work, "endless.opts")
    with open(scene[1], "w") as file:
        file.write("\n".join(line for line in text.splitlines() if not line.startswith("-dt_")) + "\n")
    for strategy in ("spatial", "pool"):
        for victim in (2, 0):
            name = f"{strategy}, kill -9 of rank {victim} of 4"
            folder = os.path.join(work, f"killed_{strategy}_{victim}")
            death = []

            def during(session):
                xdmf, patience = os.path.join(folder, "run.xdmf"), time.monotonic() + 30
                snapshots = lambda: open(xdmf).read().count("particles/id") if os.path.exists(xdmf) else 0
                while snapshots() < 3 and time.monotonic() < patience and mpi.members(session):
                    time.sleep(0.005)
                pid = mpi.process(session, victim)
                if pid:
                    os.kill(pid, signal.SIGKILL)
                    death.append(time.monotonic())

            shutil.rmtree(folder, ignore_errors=True)
            status, out, err = mpi.run(4, [pebble, *scene, "-parallel_strategy", strategy, "-output_dir", folder, "-output_name", "run"], 60, mpiexec, during)
            took = time.monotonic() - death[0] if death else 1e9
            check(death and took < WITHIN, f"{name}: the run ended {took:.1f} s later")
            check(status not in (0, mpi.TIMED_OUT, mpi.LEFT_BEHIND), f"{name}: exit status {status}, no process left behind")
            check("digest" not in out and re.search(r"signal 9|KILLED|[Kk]illed|rank \d", err), f"{name}: said: {' '.join(err.split())[:160]}")
            check_files(name, folder)


def part_bad(pebble, source, work, mpiexec):
    disks = ["-options_file", os.path.join(source, "options", "disks.opts"), "-check_energy", "1e9", "-check_momentum", "1e9"]
    disks3d = ["-options_file", os.path.join(source, "options", "disks3d.opts"), "-check_energy", "1e9", "-check_momentum", "1e9"]
    cases = {
        "turned inside out, usf": (disks + ["-body_disk1_velocity", "5,5", "-body_disk2_velocity", "-5,-5", "-dt_cfl", "1"], "turned inside out"),
        "turned inside out, musl": (disks + ["-method_update", "musl", "-body_disk1_velocity", "3,3", "-body_disk2_velocity", "-3,-3", "-dt_cfl", "1.4"], "turned inside out"),
        "turned inside out, 3-D": (disks3d + ["-body_ball1_velocity", "9,8,9", "-body_ball2_velocity", "-8,-9,-9", "-dt_cfl", "1.8", "-time_end", "10"], "turned inside out"),
        "leaves the grid": (disks + ["-body_disk1_velocity", "-0.3,0.1", "-body_disk2_velocity", "0.2,0"], "left the grid"),
        "leaves the grid, musl 3-D": (disks3d + ["-body_ball1_velocity", "0.1,-0.9,0", "-body_ball2_velocity", "0,0,0.5"], "left the grid"),
        "energy": (disks[:2] + ["-check_energy", "1e-6"], "energy changed by"),
    }
    for k, (name, (arguments, reason)) in enumerate(cases.items()):
        serial = None
        for n, strategy in ((1, "spatial"), (2, "spatial"), (5, "spatial"), ((2, 4)[k % 2], "pool")):
            folder = os.path.join(work, "bad")
            shutil.rmtree(folder, ignore_errors=True)
            status, out, err = mpi.run(n, [pebble, *arguments, "-parallel_strategy", strategy, "-output_dir", folder, "-output_name", "run"], 60, mpiexec)
            lines = mpi.own_lines(err)
            with open(os.path.join(folder, "run.csv"), "rb") as file:
                history = file.read()
            if n == 1:
                serial = (lines, history)
                check(status == 3 and len(lines) == 1 and reason in lines[0], f"{name}: serial run, exit status {status}: {lines}")
            else:
                check(status == 3 and (lines, history) == serial, f"{name}: {strategy} on {n} processes, exit status {status}: " + ("the same single line, the same history" if (lines, history) == serial else f"{lines}; history {'same' if history == serial[1] else 'differs'}"))


def part_repeat(pebble, source, work, mpiexec):
    arguments = ["-options_file", os.path.join(source, "options", "disks.opts"), "-time_max_steps", "50", "-body_disk1_velocity", "0.4,0.3", "-output_format", "none", "-check_momentum", "1e9", "-check_energy", "1e9"]
    text = open(arguments[1]).read()
    arguments[1] = os.path.join(work, "repeat.opts")
    with open(arguments[1], "w") as file:
        file.write("\n".join(line for line in text.splitlines() if not line.startswith("-output_")) + "\n")
    seen = {}
    for k in range(20):
        more = (["-parallel_migrate", ("swarm", "direct")[k // 2 % 2]], ["-parallel_strategy", "pool", "-pool_cells", "4"])[k % 2]
        status, out, err = mpi.run(4, [pebble, *arguments, *more, "-output_dir", os.path.join(work, "repeat")], 60, mpiexec)
        found = re.search(r"^digest +([0-9a-f]{16})$", out, re.M)
        key = found.group(1) if found and status == 0 else f"exit status {status}: {err[-500:]}"
        seen[key] = seen.get(key, 0) + 1
    check(len(seen) == 1 and not next(iter(seen)).startswith("exit"), f"20 runs on 4 processes, spatial and pool in turn: {seen}")


def main(pebble, source, work, mpiexec, parts="killed,bad,repeat"):
    work = os.path.abspath(work)
    os.makedirs(work, exist_ok=True)
    for part in parts.split(","):
        globals()["part_" + part](os.path.abspath(pebble), source, work, mpiexec)
    if failures:
        sys.exit(f"FAIL: {failures} checks")


if __name__ == "__main__":
    if len(sys.argv) not in (5, 6):
        sys.exit(__doc__)
    main(*sys.argv[1:])
