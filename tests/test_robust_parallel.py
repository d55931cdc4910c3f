"""A parallel run that fails ends, says why once, and leaves its results readable; a run that does not gives the same bits
each time.

usage: test_robust_parallel.py PEBBLE SOURCE MPIEXEC killed|bad|repeat|pairs

killed: a process dies. bad: particles turn inside out or leave, checks are exceeded. repeat: 20 runs. pairs: 40 times two
runs that start in the same moment.
"""
import os
import re
import signal
import time

import h5py
import numpy as np

import check
import mpi


def check_files(name, folder):
    """Snapshots that were written before are readable, lines of the history are whole."""
    with open(os.path.join(folder, "run.csv")) as file:
        text = file.read()
    lines = text.split("\n")
    columns = lines[0].count(",")
    whole = lines[-1] == "" and all(line.count(",") == columns for line in lines[:-1])
    check.that(whole and len(lines) > 3, f"{name}: {len(lines) - 2} lines of history are whole")
    try:
        with h5py.File(os.path.join(folder, "run.h5")) as file:
            steps = sorted(key for key in file if key.startswith("step_"))
            with open(os.path.join(folder, "run.xdmf")) as xdmf: # names the snapshots that are complete
                complete = sorted(set(re.findall(r"/(step_\d+)/", xdmf.read())))
            good = all(np.isfinite(file[step]["particles"][field][:]).all() for step in complete for field in ("id", "x", "v", "F", "stress"))
            check.that(good and len(complete) >= 2 and set(complete) <= set(steps), f"{name}: {len(complete)} snapshots named by the XDMF file are readable")
    except OSError as error:
        check.that(False, f"{name}: run.h5: {error}")


def without(path, scene, start):
    """A scene without the lines that start so; its path."""
    with open(scene) as file:
        return check.write(path, "".join(line for line in file if not line.startswith(start)))


def part_killed():
    scene = ["-options_file", check.scene("disks"), "-time_end", "1e6", "-check_energy", "1e9", "-check_momentum", "1e9",
             "-body_disk1_velocity", "0,0", "-body_disk2_velocity", "0,0", "-dt_size", "0.001", "-output_every", "0.1", "-history_every", "0.02"]
    scene[1] = without("endless.opts", scene[1], "-dt_")

    def kill(case):
        """The run, the moments of the kill and of its end."""
        strategy, victim = case
        folder, death = check.folder(f"killed_{strategy}_{victim}"), []

        def during(session):
            xdmf = os.path.join(folder, "run.xdmf")
            mpi.until(lambda: os.path.exists(xdmf) and open(xdmf).read().count("particles/id") > 2, lambda: mpi.members(session))
            pid = mpi.process(session, victim)
            if pid:
                os.kill(pid, signal.SIGKILL)
                death.append(time.monotonic())

        told = check.pebble(*scene, "-parallel_strategy", strategy, "-output_dir", folder, "-output_name", "run", n=4, during=during)
        return told, death, time.monotonic()

    cases = [(strategy, victim) for strategy in ("spatial", "pool") for victim in (2, 0)]
    # Two at once: mpiexec waits for a second after it has told processes to end.
    for (strategy, victim), (told, death, end) in zip(cases, check.at_once(kill, cases)):
        name = f"{strategy}, kill -9 of rank {victim} of 4"
        check.need(death, f"{name}: there was no process to kill")
        check.that(told.status not in (0, mpi.TIMED_OUT, mpi.LEFT_BEHIND), f"{name}: the run ended {end - death[0]:.1f} s later: exit status {told.status}, no process left behind")
        check.that("digest" not in told.out and re.search(r"signal 9|KILLED|[Kk]illed|rank \d", told.err), f"{name}: said: {' '.join(told.err.split())[:160]}")
        check_files(name, f"killed_{strategy}_{victim}")


def part_bad():
    disks = ["-options_file", check.scene("disks"), "-check_energy", "1e9", "-check_momentum", "1e9"]
    disks3d = ["-options_file", check.scene("disks3d"), "-check_energy", "1e9", "-check_momentum", "1e9"]
    cases = {
        "turned inside out, usf": (disks + ["-body_disk1_velocity", "5,5", "-body_disk2_velocity", "-5,-5", "-dt_cfl", "1"], "turned inside out"),
        "turned inside out, musl": (disks + ["-method_update", "musl", "-body_disk1_velocity", "3,3", "-body_disk2_velocity", "-3,-3", "-dt_cfl", "1.4"], "turned inside out"),
        "turned inside out, 3-D": (disks3d + ["-body_ball1_velocity", "9,8,9", "-body_ball2_velocity", "-8,-9,-9", "-dt_cfl", "1.8", "-time_end", "10"], "turned inside out"),
        "leaves the grid": (disks + ["-body_disk1_velocity", "-0.3,0.1", "-body_disk2_velocity", "0.2,0"], "left the grid"),
        "leaves the grid, musl 3-D": (disks3d + ["-body_ball1_velocity", "0.1,-0.9,0", "-body_ball2_velocity", "0,0,0.5"], "left the grid"),
        "energy": (disks[:2] + ["-check_energy", "1e-6"], "energy changed by"),
    }
    ways = lambda k: ((1, "spatial"), (2, "spatial"), (5, "spatial"), ((2, 4)[k % 2], "pool"))

    def result(job):
        k, arguments, (n, strategy) = job
        folder = check.folder(f"bad_{k}_{n}_{strategy}")
        told = check.pebble(*arguments, "-parallel_strategy", strategy, "-output_dir", folder, "-output_name", "run", n=n, plain=n > 1)
        return told.status, told.lines, check.content(folder + "/run.csv")

    # Several at once: mpiexec waits for a second after it has told processes to end.
    results = iter(check.at_once(result, [(k, arguments, way) for k, (arguments, _) in enumerate(cases.values()) for way in ways(k)], 4))
    for k, (name, (_, reason)) in enumerate(cases.items()):
        serial = None
        for n, strategy in ways(k):
            status, lines, history = next(results)
            if n == 1:
                serial = (lines, history)
                check.that(status == 3 and len(lines) == 1 and reason in lines[0], f"{name}: serial run, exit status {status}: {lines}")
            else:
                check.that(status == 3 and (lines, history) == serial, f"{name}: {strategy} on {n} processes, exit status {status}: " + ("the same single line, the same history" if (lines, history) == serial else f"{lines}; history {'same' if history == serial[1] else 'differs'}"))


def part_repeat():
    arguments = ["-options_file", check.scene("disks"), "-time_max_steps", "50", "-body_disk1_velocity", "0.4,0.3", "-output_format", "none", "-check_momentum", "1e9", "-check_energy", "1e9"]
    arguments[1] = without("repeat.opts", arguments[1], "-output_")
    seen = {}
    for k in range(20):
        more = (["-parallel_migrate", ("swarm", "direct")[k // 2 % 2]], ["-parallel_strategy", "pool", "-pool_cells", "4"])[k % 2]
        told = check.pebble(*arguments, *more, "-output_dir", "repeat", n=4)
        key = told.digest if told.good else f"exit status {told.status}: {told.err[-500:]}"
        seen[key] = seen.get(key, 0) + 1
    check.that(len(seen) == 1 and not next(iter(seen)).startswith("exit"), f"20 runs on 4 processes, spatial and pool in turn: {seen}")


def part_pairs():
    """Two runs that start, and so end, in the same moment do not disturb each other. Where they share a temporary folder
    (tools/launch.py) two to five pairs of a hundred fail: "mkdir was unable to create the desired directory"."""
    openmpi = "Open MPI" in check.run([check.mpiexec, "--version"]).said
    for n in (1, 2):  # sh is no program with MPI: only mpiexec writes to its folder
        told = check.at_once(lambda _: check.run(["sh", "-c", "echo $TMPDIR $(ls $TMPDIR)"], n), range(2))
        words = [line.split() for run in told for line in run.out.splitlines()]
        folders = {folder for folder, *_ in words}
        check.that(len(words) == 2 * n and len(folders) == 2 and not any(map(os.path.exists, folders)), f"two runs on {n} have a folder each, which is gone afterwards: {sorted(folders)}")
        check.that(n == 1 or not openmpi or all(inside for _, *inside in words), f"mpiexec uses it: {[inside for _, *inside in words]}")
    arguments = ["-options_file", check.scene("disks"), "-time_max_steps", "1", "-output_format", "none"]
    ways = [(2, {}), (1, {"plain": True})]  # with mpiexec, and without; these as a user starts them
    for k in range(40):
        n, more = ways[k % 4 == 3]
        both = check.at_once(lambda which: check.pebble(*arguments, "-output_dir", f"pair{which}", n=n, **more), range(2))
        good = all(told.good and not told.err for told in both) and both[0].digest == both[1].digest
        check.that(good, f"pair {k}: two runs on {n}: exit statuses {[told.status for told in both]}, digests {[told.digest for told in both]}")
        for told in both:
            if told.err:
                print(told.err[-1000:])


(part,) = check.arguments(__doc__, 1)
globals()["part_" + part]()
check.end()
