"""Runs that are killed at random moments, also inside writes, go on from their last checkpoint and end with the same bits.

    test_kill.py PEBBLE SOURCE MPIEXEC KILLS

A run on 4 processes writes a snapshot every other step and a checkpoint every third one. One of its processes, or all of them
with mpiexec, get SIGKILL at a random moment. Then every file that has its final name must be whole, the last checkpoint must
be of the last interval, and no process of Pebble may be left; a restart goes on, and is killed again, until a run reaches its
end. After the last kill a run is left to do so. Open MPI 4.1's mpiexec itself sometimes never ends (it waits for a lock in PMIx_server_finalize): this is counted.
"""
import glob
import os
import random
import signal
import statistics
import subprocess
import time

import h5py

import check
import mpi

kills = int(check.arguments(__doc__, 1)[0])
COMMAND = ["-options_file", check.scene("disks"), "-time_end", "1.5", "-history_every", "0", "-output_every", "0.03",
           "-output_fields", "velocity", "-output_dir", "killed", "-checkpoint_every", "0.04"]
rng = random.Random(19)


def results(folder):
    with h5py.File(f"{folder}/disks.h5") as file:
        return check.content(f"{folder}/disks.csv"), {step: (file[step].attrs["digest"], file[step]["particles/v"][()].tobytes())
                                                      for step in file}


def unreadable():
    """The files with a final name that cannot be read, each with the reason."""
    wrong = []
    for path in glob.glob("killed/*.h5") + glob.glob("killed/*/*.h5"):
        try:
            with h5py.File(path) as file:
                file.visititems(lambda name, item: item[()] if isinstance(item, h5py.Dataset) else None)
        except Exception as error:  # h5py raises many kinds
            wrong.append(f"{path}: {error}")
    return wrong


def last_checkpoint():
    """Time and step of the last checkpoint."""
    files = sorted(glob.glob("killed/disks-checkpoint-*.h5"), key=lambda path: int(path[:-3].split("-")[-1]))
    if not files:
        return 0, 0
    with h5py.File(files[-1]) as file:
        return float(file["run/time"][0]), int(file["run/step"][0])


def start(n):
    here = ["-restart_file", "latest"] if glob.glob("killed/disks-checkpoint-*.h5") else []
    command = [check.program, *COMMAND, *here]
    if n > 1:
        command = [check.mpiexec, "-n", str(n), *command]
    with open("said", "w") as said:
        return subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=said, stderr=said, start_new_session=True,
                                env=os.environ | mpi.ENVIRONMENT | mpi.FAST)


def ranks(process):
    """The processes of a run but mpiexec."""
    return [pid for pid in mpi.members(process.pid) if pid != process.pid or process.args[0] == check.program]


def kill(process, everyone):
    """Kills one process of the run, or all; returns how many there were."""
    pids = [pid for pid in mpi.members(process.pid) if everyone or mpi.rank_of(pid) is not None]
    for pid in pids if everyone else rng.sample(pids, min(1, len(pids))):
        try:
            os.kill(pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
    return len(pids)


whole = check.must(*[word if word != "killed" else check.folder("whole") for word in COMMAND])
reference = results("whole")
check.folder("killed")
done = ended = inside = stuck = 0
lost, waits = [], []
began = time.monotonic()
check.must(*[word if word != "killed" else check.folder("first") for word in COMMAND], n=4)
seconds = time.monotonic() - began  # how long a run takes; the next one is killed within this time
while done < kills or not ended:
    n = 4 if rng.random() < 0.9 else rng.choice([1, 2, 3])
    process = start(n)
    began = time.monotonic()
    try:
        process.wait(rng.uniform(0.2, 0.2 + 0.8 * seconds) if done < kills else check.TIMEOUT)
    except subprocess.TimeoutExpired:
        pass
    if process.poll() is None and kill(process, rng.random() < 0.5):
        done += 1
        killed = time.monotonic()
        mpi.until(lambda: not ranks(process), lambda: True)
        waits.append(time.monotonic() - killed)
        check.fault(f"kill {done}: processes {ranks(process)} are left" if ranks(process) else None)
        mpi.until(lambda: not mpi.members(process.pid), lambda: True, 20)
        stuck += bool(mpi.members(process.pid))
        mpi.end(process.pid)
        process.wait()
        inside += bool(glob.glob("killed/*pebble-new") + glob.glob("killed/*/*pebble-new"))
        for wrong in unreadable():
            check.fault(f"kill {done}: {wrong}")
        lines = check.content("killed/disks.csv").decode().splitlines() if os.path.exists("killed/disks.csv") else []
        if len(lines) < 3:
            seconds *= 1.2  # the machine is slower now
        full = [line for line in lines[1:] if line.count(",") == lines[0].count(",")]
        if full:
            t, step = last_checkpoint()
            lost.append(int(full[-1].split(",")[0]) - step)
            check.fault(f"kill {done}: the last line is of step {full[-1].split(',')[0]}, the last checkpoint of {step}"
                        if float(full[-1].split(",")[1]) > t + 0.04 + 2 * 0.016 else None)
        continue
    process.wait()
    seconds = 0.7 * seconds + 0.3 * (time.monotonic() - began)
    said = check.content("said").decode(errors="replace")
    if not check.that(process.returncode == 0 and f"digest {whole.digest}" in said and results("killed") == reference,
                      f"after {done} kills a run reached its end: status {process.returncode}, "
                      f"{'the same digest, history and snapshots' if results('killed') == reference else said[-800:]}"):
        break
    ended += 1
    check.folder("killed")
check.need(lost, "nothing was lost: the kills came too early")
check.that(True, f"figures    kills: {done}, {inside} of them inside a write; {ended} runs reached their end; steps "
           f"lost: {statistics.mean(lost):.1f} in the mean, {max(lost)} at most; the others ended within {max(waits):.2f} s, "
           f"mpiexec did not end {stuck} times")
check.end()
