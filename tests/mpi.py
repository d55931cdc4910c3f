"""Starts a program on some processes, and sees to it that none of them outlives the run. Every run has a temporary folder
of its own.

    status, out, err = mpi.run(4, [pebble, "-options_file", scene], timeout=60)
    mpi.py MPIEXEC N COMMAND...     the same from a command line, for programs that have no test script

One process is started without mpiexec. Linux only: processes are found in /proc.
"""
import atexit
import os
import re
import select
import signal
import subprocess
import sys
import tempfile
import threading
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir, "tools"))
import launch  # noqa: E402 (after the path)
from pebble_mpm import ALONE, own_lines  # noqa: E402, F401 (own_lines: for those who use this module)

TIMED_OUT, LEFT_BEHIND = 124, 125  # exit statuses that stand for what happened to the run
SAID = os.environ.get("PEBBLE_SAID")  # file for the lines that runs print, which messages.py reads
STARTER = os.environ.get("PEBBLE_STARTER")  # the program that starts runs of a program on one process in less time, and
STARTED = os.environ.get("PEBBLE_STARTED")  # that program (starter.c); without them all are started as users do
RANK = os.environ.get("PEBBLE_RANK")  # what mpiexec starts then, in place of the program (rank.c)
kept = set()
starters = []  # that have nothing to do
rank_starters = []  # that of all ranks, once there are any
starting = threading.Lock()

# As in the makefile, which says why; for tests that are started by hand.
ENVIRONMENT = {
    "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe", "OMPI_MCA_hwloc_base_binding_policy": "none",
    "OMPI_MCA_mpi_yield_when_idle": "1", "OMPI_MCA_btl_vader_single_copy_mechanism": "none",
    "OMPI_MCA_btl_base_warn_component_unused": "0",
}
# Open MPI starts twice as fast where it does not look for networks and at the computer's parts. What it computes is the same.
FAST = {"OMPI_MCA_pml": "ob1", "HWLOC_COMPONENTS": "no_os,stop", "HWLOC_PLUGINS_PATH": "/nowhere"}
NO_FOLDER = {"OMPI_MCA_orte_create_session_dirs": "0"}  # of a starter; a run says so itself (src/run/program.c)


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


def left_of(first):
    """The same of a run whose first process has ended; of a program alone, which starts none, its group tells that in less time."""
    try:
        if isinstance(first, Start):
            os.killpg(first.pid, 0)
    except ProcessLookupError:
        return []
    return members(first.pid)


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


def until(ready, going, patience=100):
    """Waits until ready() is true, while going() is, since then there is nothing to wait for; returns whether it is ready. (The
    patience is for a machine that has much else to do.)"""
    deadline = time.monotonic() + patience
    while not (done := ready()) and going() and time.monotonic() < deadline:
        time.sleep(0.01)
    return bool(done or ready())


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


def new_starter(*socket):
    """A starter; what it calls is looked up at its start, once for all its copies."""
    return subprocess.Popen([STARTER, *socket], stdin=subprocess.PIPE, stdout=subprocess.PIPE, bufsize=0, start_new_session=True,
                            env=dict(os.environ) | ALONE | NO_FOLDER | {"LD_BIND_NOW": "1"})


def rank():
    """The words before a command that ask the starter of ranks for a copy of the program; none if it cannot make one."""
    name = f"pebble-{os.getpid()}"
    with starting:
        if not rank_starters:
            rank_starters.append(new_starter(name))
            rank_starters[0].listens = rank_starters[0].stdout.readline()
    return [RANK, name] if rank_starters[0].listens else []


class Start:
    """A run of STARTED by a STARTER, as far as it is a subprocess.Popen: its number, and waiting for its exit status."""

    def __init__(self, command, out, err, environment, cwd):
        try:
            self.starter = starters.pop()
        except IndexError:
            self.starter = new_starter()
        files = [f"/proc/{os.getpid()}/fd/{file.fileno()}" for file in (out, err)]
        words = [os.path.abspath(cwd or "."), *files, str(len(command)), *command]
        words += [f"{name}={value}" for name, value in environment.items()]
        request = b"".join(os.fsencode(word) + b"\0" for word in words)
        self.starter.stdin.write(b"%d\n" % len(request) + request)
        self.pid, self.status = int(self.starter.stdout.readline()), None

    def wait(self, timeout=None):
        if self.status is None:
            if not select.select([self.starter.stdout], [], [], timeout)[0]:
                raise subprocess.TimeoutExpired(STARTED, timeout)
            self.status = os.waitstatus_to_exitcode(int(self.starter.stdout.readline()))
            starters.append(self.starter)
        return self.status


@atexit.register
def dismiss():
    """Ends the starters; those that still wait for a run end with it."""
    for starter in starters + rank_starters:
        starter.stdin.close()
        starter.wait()


def run(n, arguments, timeout=120, mpiexec="mpiexec", during=None, plain=False, cwd=None, env=None):
    """Runs arguments[0] with the others on n processes: (exit status, standard output, standard error). The status is
    TIMED_OUT if it had to be killed, LEFT_BEHIND if a process outlived it; then all are killed. during(session) is
    called once the run has been started, and its time counts from then on; a run's session is the number of its first process.
    plain: as a user starts it, without what makes the start faster. env: more for the environment."""
    command = list(map(str, arguments))
    preloads = any(name.startswith("LD_") for name in env or {})
    copied = STARTER and not (plain or during or preloads) and command[0] == STARTED
    if n > 1:
        command = [mpiexec, "-n", str(n), *(rank() if copied and RANK else []), *command]
    fast = {} if plain else FAST if n > 1 else ALONE
    with launch.own_folder(ENVIRONMENT | dict(os.environ) | fast | (env or {})) as environment, \
            tempfile.TemporaryFile("w+", errors="replace") as out, tempfile.TemporaryFile("w+", errors="replace") as err:
        if copied and n == 1:
            first = Start(command, out, err, environment, cwd)
        else:
            first = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=out, stderr=err, start_new_session=True,
                                     env=environment, cwd=cwd)
        said, left = "", True
        try:
            if during:
                during(first.pid)
            try:
                status = first.wait(timeout)
            except subprocess.TimeoutExpired:
                status, said = TIMED_OUT, f"killed after {timeout} s\n"
            else:
                until(lambda: not left_of(first), lambda: True, 30)
                left = left_of(first)
                if left:
                    status, said = LEFT_BEHIND, f"exit status {status}, but processes are left behind: {left}\n"
        finally:
            if left:
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
