"""The memory of the processes of a run: flat over many steps with migrations, and as large as -dry_run predicts.

usage: test_memory.py PEBBLE SOURCE MPIEXEC flat STEPS | find STEPS

flat   a block drifts through a periodic grid, so that particles change process in most steps; the history is written on
       the way. The memory of each process (VmRSS of /proc) is read all the time, and a line is fitted to it
       after a quarter of the steps. Prints its slope in bytes a step.
find   the same with a library that loses 64 bytes in each reduction, of which a step has one at least: the slope shows it
"""
import os
import re
import subprocess
import threading
import time

import numpy as np

import check
import mpi

MOST = 4        # bytes a step by which the memory of a process may grow
LOST = 64       # bytes that the library of `find` loses in a step
PERIOD = 0.1    # s between two looks at a process
# name, processes, options
WAYS = [("direct", 3, ["-parallel_strategy", "spatial", "-parallel_migrate", "direct"]),
        ("swarm", 3, ["-parallel_strategy", "spatial", "-parallel_migrate", "swarm"]),
        ("recut", 4, ["-parallel_strategy", "spatial", "-parallel_balance", "auto"]),
        ("pool", 3, ["-parallel_strategy", "pool"]),
        ("serial", 1, [])]
LEAK = """#include <mpi.h>
#include <stdlib.h>
#include <string.h>
int MPI_Allreduce(const void *in, void *out, int n, MPI_Datatype type, MPI_Op op, MPI_Comm comm)
{
  void *volatile lost = malloc(%d);
  memset(lost, 1, %d);
  return PMPI_Allreduce(in, out, n, type, op, comm);
}
"""


def drift(steps):
    """A block of 10 x 10 cells that moves by 0.4 cells a step along both axes of a periodic grid of 24 x 24."""
    return ["-dim", 2, "-grid_lower", "0,0", "-grid_upper", "24,24", "-grid_cells", "24,24",
            "-bc_xmin_type", "periodic", "-bc_xmax_type", "periodic", "-bc_ymin_type", "periodic", "-bc_ymax_type", "periodic",
            "-materials", "m", "-material_m_model", "neohookean", "-material_m_rho", 1, "-material_m_E", 1e-2,
            "-material_m_nu", 0.3, "-bodies", "b", "-body_b_shape", "box", "-body_b_lower", "2,2", "-body_b_upper", "12,12",
            "-body_b_ppc", "2,2", "-body_b_material", "m", "-body_b_velocity", "4,2.5", "-dt_size", 0.1,
            "-time_end", 0.1 * steps, "-history_every", 1, "-output_format", "none", "-report_limits", "false", "-output_dir", "."]


def memory(pid):
    """VmRSS of a process in bytes, None if it has ended."""
    try:
        with open(f"/proc/{pid}/status") as file:
            found = re.search(r"^VmRSS:\s+(\d+) kB", file.read(), re.M)
    except OSError:
        return None
    return found and 1024 * int(found.group(1))


def watch(session, n, series):
    """Reads the memory of the n processes of a session until they end; series[rank] gets (time, bytes)."""
    pids = {}
    deadline = time.monotonic() + 30
    while len(pids) < n and time.monotonic() < deadline:
        pids = {0: session} if n == 1 else {r: p for p in mpi.members(session) if (r := mpi.rank_of(p)) is not None}
        time.sleep(0.02)

    def look():
        while pids:
            now = time.monotonic()
            for rank, pid in list(pids.items()):
                most = memory(pid)
                if most is None:
                    del pids[rank]
                else:
                    series.setdefault(rank, []).append((now, most))
            time.sleep(PERIOD)
    threading.Thread(target=look, daemon=True).start()


def slopes(name, n, steps, options, env=None):
    """The run's output, and the growth of each process in bytes a step after the first quarter, with the largest memory."""
    series = {}
    run = check.run([check.program, *drift(steps), "-output_name", name, *options], n, 3600, env=env,
                    during=lambda session: watch(session, n, series))
    check.need(run.good, f"{name}: status {run.status}: {run.said[-500:]}")
    found = []
    for rank in sorted(series):
        t, m = np.array(series[rank][1:-1]).T  # the last look may see a process that ends
        late = t > t[0] + 0.25 * (t[-1] - t[0])
        a_second = np.polyfit(t[late] - t[0], m[late], 1)[0]
        found.append((a_second * (t[-1] - t[0]) / steps, m.max()))
    return run, found


def flat(steps):
    for name, n, options in WAYS:
        run, found = slopes(name, n, steps, options)
        moved = run.find(r"in (\d+) of \d+ steps")
        check.that(n == 1 or name == "pool" or moved and int(moved) > 0.3 * steps, f"{name}: migrations in {moved} of {steps} steps")
        check.that(len(found) == n and all(slope < MOST for slope, _ in found),
                   f"{name} on {n}: {steps} steps, growth in bytes a step " + " ".join(f"{slope:.3f}" for slope, _ in found) +
                   ", at most MB " + " ".join(f"{1e-6 * most:.1f}" for _, most in found))


def find(steps):
    source = check.write("leak.c", LEAK % (LOST, LOST))
    subprocess.run(["mpicc", "-shared", "-fPIC", "-o", "leak.so", source], check=True)
    name, n, options = WAYS[0]
    _, found = slopes("leak", n, steps, options, {"LD_PRELOAD": os.path.abspath("leak.so")})
    check.that(all(slope > LOST for slope, _ in found),
               f"{LOST} bytes lost in each step: growth in bytes a step " + " ".join(f"{slope:.3f}" for slope, _ in found))


words = check.arguments(__doc__, 2)
{"flat": flat, "find": find}[words[0]](int(words[1]))
check.end()
