"""How programs with MPI are started: each with a temporary folder of its own, and those that are timed with settings."""
import os
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir, "lab"))
from pebble_mpm import own_folder  # noqa: E402 (after the path)

# The makefile's settings are for tests, which share few cores. When one run at a time has a free core for each process, waiting
# processes need not yield, each process stays on its core, and large messages may be read from the other's memory.
TIMED = {"OMPI_MCA_mpi_yield_when_idle": "0", "OMPI_MCA_hwloc_base_binding_policy": "core"}
COPY = "OMPI_MCA_btl_vader_single_copy_mechanism"


def environment(processes, cores):
    """The environment of a run on `processes` processes, where `cores` cores are free."""
    if processes > cores:
        return dict(os.environ)
    return {name: value for name, value in os.environ.items() if name != COPY} | TIMED


def settings(processes, cores):
    """In words, what that environment says to Open MPI about waiting, binding and copies."""
    chosen = environment(processes, cores)
    return ", ".join(f"{name.removeprefix('OMPI_MCA_')} {chosen.get(name, 'as Open MPI has it')}" for name in (*TIMED, COPY))


def run(command, env=None, **more):
    """subprocess.run with a temporary folder of its own."""
    with own_folder(env) as environment:
        return subprocess.run(list(map(str, command)), env=environment, **more)
