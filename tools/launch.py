"""How runs that are timed are started."""
import os

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
