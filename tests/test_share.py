"""No process holds or visits what is others': with an equal share of a scene each, a process of many needs no more memory and
no more instructions than one of few. What it did for each particle of the others would show as a byte or an instruction for
each of them; 100 million particles on 64 processes are 98 million others.

usage: test_share.py PEBBLE SOURCE MPIEXEC memory|instructions

A column of elastic material is cut along its axis, into as many parts of 12 x 12 x 12 cells as there are processes. The largest
number of all processes counts.

memory        the column moves along its axis, so that particles change process in the first step: the memory that a
              process has of its own (RssAnon of /proc) as MPI ends, without snapshots and with two. The memory that
              Open MPI shares among the processes of a machine is not counted: it grows with their number
instructions  the column is at rest: those of the program's own code, and without snapshots of PETSc's too, as valgrind counts
              them, from start to end. (With
              snapshots PETSc packs the rows of all particles that another process writes, which are more of its share the
              more processes there are.) Those of MPI are not counted: most of them wait
"""
import collections
import os
import re
import subprocess

import check

SIDE = 12
# Of the processes' own memory, as MPI ends.
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


def column(processes, ppc, speed):
    """Options of the column, and how many particles a process has."""
    return ["-dim", 3, "-grid_lower", "0,0,0", "-grid_upper", f"16,16,{SIDE * processes + 4}",
            "-grid_cells", f"16,16,{SIDE * processes + 4}", "-materials", "m", "-material_m_model", "neohookean",
            "-material_m_rho", 1, "-material_m_E", 1e-2, "-material_m_nu", 0.3, "-bodies", "b", "-body_b_shape", "box",
            "-body_b_lower", "2,2,1", "-body_b_upper", f"14,14,{SIDE * processes + 1}", "-body_b_ppc", ",".join([str(ppc)] * 3),
            "-body_b_material", "m", "-body_b_velocity", f"0,0,{speed}", "-method_update", "musl", "-dt_size", 0.1, "-time_end", 1e6,
            "-time_max_steps", 2, "-history_every", 1e9, "-report_limits", "false", "-output_dir", "."], SIDE ** 3 * ppc ** 3


def run(command, n, **more):
    found = check.run(command, n, 900, **more)
    check.need(found.good, f"status {found.status} on {n}: {found.said[-500:]}")
    return found


def memory(few, many, ppc, options, env):
    """Bytes that the largest process of many has more than that of few, for each particle that is others'."""
    own = {}
    for n in (few, many):
        words, share = column(n, ppc, 4)
        found = run([check.program, *words, *options], n, env=env)
        check.need(int(found.find(r"particles changed process (\d+) times") or 0) > 0, f"no particle changed process on {n}")
        sizes = [1024 * int(kB) for kB in re.findall(r"own\s+(\d+) kB", found.err)]
        check.need(len(sizes) == n, f"{len(sizes)} of {n} processes told their memory")
        own[n] = max(sizes)
    more = (own[many] - own[few]) / ((many - few) * share)
    check.that(more < 1, f"memory of a process with {share} particles, {' '.join(map(str, options))}: {1e-6 * own[few]:.2f} MB of {few}, "
                         f"{1e-6 * own[many]:.2f} of {many}, {more:.2f} B for each particle of the others")


def counted(path):
    """Instructions that valgrind wrote for a process: those of the program's own code, and of PETSc's."""
    found, names, ours, called = collections.Counter(), {}, None, False
    with open(path) as file:
        for line in file:
            if named := re.match(r"c?ob=\((\d+)\)(?: (.*))?", line):
                names.setdefault(named[1], named[2])
                ours = names[named[1]] if line.startswith("ob=") else ours
            elif line.startswith("calls="):
                called = True  # the next line has what the called function took
            elif re.match(r"[-+*\d]", line):
                if not called:
                    found[os.path.basename(ours or "").split("_real")[0].split(".so")[0]] += int(line.split()[1])
                called = False
    return found[os.path.basename(check.program)], found["libpetsc"]


def instructions(few, many, ppc, options, what):
    """The same of instructions; `what` says whether PETSc's count too."""
    taken = {}
    for n in (few, many):
        words, share = column(n, ppc, 0)
        run(["valgrind", "--tool=callgrind", f"--callgrind-out-file={os.getcwd()}/counts.{n}.%p", check.program, *words, *options], n,
            env={"PEBBLE_VECTOR": "4"})
        both = [counted(name) for name in os.listdir(".") if name.startswith(f"counts.{n}.") and not os.path.islink(name)]
        for name in os.listdir("."):
            if name.startswith("counts."):
                os.remove(name)
        check.need(len(both) == n and all(own > 1e6 for own, _ in both), f"counts of {len(both)} of {n} processes: {both}")
        taken[n] = max(own + (petsc if what == "with PETSc's" else 0) for own, petsc in both)
    more = (taken[many] - taken[few]) / ((many - few) * share)
    check.that(more < 1, f"instructions of a process with {share} particles, {' '.join(map(str, options))}, {what}: {1e-6 * taken[few]:.2f} million "
                         f"of {few}, {1e-6 * taken[many]:.2f} of {many}, {more:.2f} for each particle of the others")


words = check.arguments(__doc__, 1)
none, two = ["-output_format", "none"], ["-output_every", 1e9]
if words[0] == "memory":
    with open("own.c", "w") as file:
        file.write(OWN)
    subprocess.run(["mpicc", "-shared", "-fPIC", "-o", "own.so", "own.c"], check=True)
    env = {"LD_PRELOAD": os.path.abspath("own.so")}
    memory(4, 16, 3, none, env)
    memory(16, 32, 3, two, env)
else:
    instructions(4, 12, 2, none, "with PETSc's")
    instructions(4, 12, 2, two, "without PETSc's")
check.end()
