"""A process holds its own particles only. If each process has the same number of particles, a process among many takes less
than 1 B more, for each additional particle of other processes, than a process among few. With 100 million particles on 64
processes, the others of each have 98 million.

usage: test_share.py PEBBLE SOURCE MPIEXEC

A column of elastic material is cut along its axis into one cube of cells for each process. It moves along the axis, so
particles change process in the first step. Measured is each process's own memory (RssAnon in /proc/self/status) when
MPI_Finalize is called, in runs without snapshots and with two; the largest counts. Without snapshots a cell has one
particle, so what a process had for each cell would show too. The memory that Open MPI shares among the processes of a
machine is not counted: it grows with their number.
"""
import os
import re
import subprocess

import check

# A library that is loaded before MPI: MPI_Finalize then prints the process's own memory.
OWN = """#include <mpi.h>
#include <stdio.h>
#include <string.h>
int MPI_Finalize(void)
{
  char  line[256];
  FILE *file = fopen("/proc/self/status", "r");
  while (fgets(line, sizeof line, file))
    if (!strncmp(line, "RssAnon:", 8)) fprintf(stderr, "own %s", line + 8);
  fclose(file);
  return PMPI_Finalize();
}
"""


def column(processes, side, ppc, speed):
    """Options of the column, whose cubes have `side` cells on an edge, and how many particles a process has."""
    width, length = side + 4, side * processes + 4
    return ["-dim", 3, "-grid_lower", "0,0,0", "-grid_upper", f"{width},{width},{length}",
            "-grid_cells", f"{width},{width},{length}", "-materials", "m", "-material_m_model", "neohookean",
            "-material_m_rho", 1, "-material_m_E", 1e-2, "-material_m_nu", 0.3, "-bodies", "b", "-body_b_shape", "box",
            "-body_b_lower", "2,2,1", "-body_b_upper", f"{side + 2},{side + 2},{length - 3}",
            "-body_b_ppc", f"{ppc},{ppc},{ppc}",
            "-body_b_material", "m", "-body_b_velocity", f"0,0,{speed}", "-method_update", "musl", "-dt_size", 0.1,
            "-time_end", 1e6, "-time_max_steps", 2, "-history_every", 1e9, "-report_limits", "false",
            "-output_dir", "."], (side * ppc) ** 3


def run(command, n, **more):
    found = check.run(command, n, 900, **more)
    check.need(found.good, f"status {found.status} on {n}: {found.said[-500:]}")
    return found


def memory(few, many, side, ppc, options, env):
    """Checks how many bytes the largest of `many` processes has more than the largest of `few`, for each additional
    particle of other processes."""
    own = {}
    for n in (few, many):
        words, share = column(n, side, ppc, 4)
        found = run([check.program, *words, *options], n, env=env)
        check.need(int(found.find(r"particles changed process (\d+) times") or 0) > 0, f"no particle changed process on {n}")
        sizes = [1024 * int(kB) for kB in re.findall(r"own\s+(\d+) kB", found.err)]
        check.need(len(sizes) == n, f"{len(sizes)} of {n} processes told their memory")
        own[n] = max(sizes)
    more = (own[many] - own[few]) / ((many - few) * share)
    check.that(more < 1, f"memory of a process with {share} particles, {' '.join(map(str, options))}: {1e-6 * own[few]:.2f} MB "
                         f"of {few}, {1e-6 * own[many]:.2f} of {many}, {more:.2f} B for each particle of the others")


check.arguments(__doc__, 0)
none, two = ["-output_format", "none"], ["-output_every", 1e9]
with open("own.c", "w") as file:
    file.write(OWN)
subprocess.run(["mpicc", "-shared", "-fPIC", "-o", "own.so", "own.c"], check=True)
env = {"LD_PRELOAD": os.path.abspath("own.so")}
memory(4, 16, 24, 1, none, env)
memory(16, 32, 12, 3, two, env)
check.end()
