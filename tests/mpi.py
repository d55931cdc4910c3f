"""Starts a program on some processes, and sees to it that none of them outlives the run. Every run has a temporary folder
of its own.

    status, out, err = mpi.run(4, [pebble, "-options_file", scene], timeout=60)
    mpi.py MPIEXEC N COMMAND...     the same from a command line, for programs that have no test script

One process is started without mpiexec. Linux only: processes are found in /proc.
"""
import os
import re
import signal
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir, "tools"))
import launch  # noqa: E402 (after the path)
from pebble_mpm import ALONE, own_lines  # noqa: E402, F401 (own_lines: for those who use this module)

TIMED_OUT, LEFT_BEHIND = 124, 125  # exit statuses that stand for what happened to the run
SAID = os.environ.get("PEBBLE_SAID")  # file for the lines that runs print, which messages.py reads
kept = set()

# As in the makefile, which says why; for tests that are started by hand.
ENVIRONMENT = {
    "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe", "OMPI_MCA_hwloc_base_binding_policy": "none",
    "OMPI_MCA_mpi_yield_when_idle": "1", "OMPI_MCA_btl_vader_single_copy_mechanism": "none",
    "OMPI_MCA_btl_base_warn_component_unused": "0",
}
# Open MPI starts twice as fast where it does not look for networks. What it computes is the same.
FAST = {"OMPI_MCA_pml": "ob1"}


def members(session):
    """The living processes of a session. (Not of a group: mpiexec gives each rank a group of its own.)"""
    found = []
    for pid in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{pid}/stat") as file:
                state, _, _, its = file.read().rpartition(")")[2].split()[:4]
        except OSError:
            continue
        if int(its) == session and state not in "ZX":
            found.append(int(pid))
    return found


def rank_of(pid):
    """The MPI rank of a process, None for mpiexec itself."""
    try:
        with open(f"/proc/{pid}/environ", "rb") as file:
            words = dict(word.split(b"=", 1) for word in file.read().split(b"\0") if b"=" in word)
    except OSError:
        return None
    for name in (b"OMPI_COMM_WORLD_RANK", b"PMIX_RANK", b"PMI_RANK"):
        if name in words:
            return int(words[name])
    return None


def process(session, rank):
    """The process of a rank of a run."""
    return next((pid for pid in members(session) if rank_of(pid) == rank), None)


def end(session):
    """Kills what is left of a session."""
    while members(session):
        for pid in members(session):
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
        time.sleep(0.02)


def keep(*texts):
    """Keeps lines that a run printed for messages.py; of those that differ in numbers only, the first. Returns the texts."""
    if SAID:
        new = []
        for line in "\n".join(texts).splitlines():
            alike = re.sub(r"\d+", "0", line)
            if alike not in kept:
                kept.add(alike)
                new.append(line + "\n")
        if new:
            with open(SAID, "a") as file:
                file.write("".join(new))
    return texts


def run(n, arguments, timeout=120, mpiexec="mpiexec", during=None, plain=False, cwd=None, env=None):
    """Runs arguments[0] with the others on n processes: (exit status, standard output, standard error). The status is
    TIMED_OUT if it had to be killed, LEFT_BEHIND if a process outlived it; then all are killed. during(session) is
    called once the run has been started; a run's session is the number of its first process. plain: as a user starts it,
    without what makes the start faster. env: more for the environment."""
    command = list(map(str, arguments))
    if n > 1:
        command = [mpiexec, "-n", str(n)] + command
    fast = {} if plain else FAST if n > 1 else ALONE
    with launch.own_folder(ENVIRONMENT | dict(os.environ) | fast | (env or {})) as environment, \
            tempfile.TemporaryFile("w+", errors="replace") as out, tempfile.TemporaryFile("w+", errors="replace") as err:
        first = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=out, stderr=err, start_new_session=True,
                                 env=environment, cwd=cwd)
        said = ""
        try:
            deadline = time.monotonic() + timeout
            if during:
                during(first.pid)
            try:
                status = first.wait(max(0.1, deadline - time.monotonic()))
            except subprocess.TimeoutExpired:
                status, said = TIMED_OUT, f"killed after {timeout} s\n"
            else:
                patience = time.monotonic() + 3
                while members(first.pid) and time.monotonic() < patience:
                    time.sleep(0.02)
                left = members(first.pid)
                if left:
                    status, said = LEFT_BEHIND, f"exit status {status}, but processes are left behind: {left}\n"
        finally:
            end(first.pid)
            first.wait()
        out.seek(0)
        err.seek(0)
        return status, *keep(out.read(), err.read() + said)


if __name__ == "__main__":
    result = run(int(sys.argv[2]), sys.argv[3:], mpiexec=sys.argv[1])
    sys.stdout.write(result[1])
    sys.stderr.write(result[2])
    sys.exit(result[0])
