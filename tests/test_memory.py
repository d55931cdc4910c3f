"""The memory of the processes of a run: flat over many steps with migrations, for a process's own particles only, and as large as
-dry_run predicts.

usage: test_memory.py PEBBLE SOURCE MPIEXEC flat STEPS | find STEPS | peak some|all|large | share all | near all

flat   a block drifts through a periodic grid, so that particles change process in most steps; history and snapshots are
       written on the way. The memory of each process is read all the time: pages of its own and shared ones, but not those
       of files, which Linux takes away now and then. What is lost in each step shows all the time, except while it fits
       where memory was freed before; lists of MPI and pages of the heap fill now and then, by tens of kB at once. So the steps
       after the first quarter are cut into ten parts, and the third least of their growths counts, in bytes a step (up to 0.9
       were measured, where the grid is cut anew, else 0); what all grow together has a wider bound. The
       last line of the history tells the step before and after each look, and a look that lasts for many steps does not
       count, so it does not matter how fast a run is, or whether it stands still. Where the grid is cut anew again and
       again, pages fill during some 30000 steps, so this run has three times as many steps
find   the same with a library that loses 16 bytes (32 with the heap's own) in each reduction, of which a step has one at
       least: each process then grows by more than `flat` allows, also where the grid is cut anew again and again. (No run
       is longer than the others: pages that fill only add to what grows)
peak   the largest memory of a process, VmHWM as MPI ends, is what -dry_run told, to 10 %: of scenes on one process, on 2 and
       in the pool, and of a large one of a million particles
share  a column of elastic material is cut along its axis into one cube of cells for each process, and moves along it, so that
       particles change process. As MPI ends, a process among many has less than 1 B more of its own memory, for each additional
       particle of other processes, than a process among few: without snapshots and with two. Without snapshots a
       cell has one particle, so what a process had for each cell would show too. The memory that Open MPI shares among the
       processes of a machine is not counted: it grows with their number
near   two small bodies in a corner of a large grid, in contact: where they touch, the largest memory of the process is larger than
       where they are apart by less than half of what the nodes of the grid take, which a run tells
"""
import os
import re
import subprocess
import threading
import time

import numpy as np

import check
import mpi

MOST = 4        # bytes a step by which the memory of a process may grow; a page of 4 kB in a part of 1500 steps is 2.7
WHOLE = 1e6     # bytes by which it may grow in all parts together; 0 to 0.3e6 were measured
PARTS = 10      # of a run, after its first quarter
LOST = 16       # bytes that the library of `find` loses in a step
PERIOD = 0.1    # s between two looks at a process
LAPSE = 40      # steps during a look
# name, processes, how many times the steps, options
WAYS = [("direct", 3, 1, ["-parallel_strategy", "spatial", "-parallel_migrate", "direct"]),
        ("swarm", 3, 1, ["-parallel_strategy", "spatial", "-parallel_migrate", "swarm"]),
        ("recut", 4, 3, ["-parallel_strategy", "spatial", "-parallel_balance", "auto"]),
        ("pool", 3, 1, ["-parallel_strategy", "pool"]),
        ("serial", 1, 1, [])]
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


# Tells the largest memory of the process, and its own pages (which smaps_rollup counts; other counters may lag behind), as MPI ends.
TELL = """#include <mpi.h>
#include <stdio.h>
#include <string.h>
static void tell(const char *path, const char *name)
{
  char  line[256];
  FILE *file = fopen(path, "r");
  while (fgets(line, sizeof line, file))
    if (!strncmp(line, name, strlen(name))) fputs(line, stderr);
  fclose(file);
}
int MPI_Finalize(void)
{
  tell("/proc/self/status", "VmHWM:");
  tell("/proc/self/smaps_rollup", "Anonymous:");
  return PMPI_Finalize();
}
"""
NEAR = 0.10  # part by which a peak may differ from what -dry_run told


def library(name, text):
    """A library of this text, to be loaded before others; its environment."""
    path = check.write(name + ".c", text)
    subprocess.run(["mpicc", "-shared", "-fPIC", "-o", name + ".so", path], check=True)
    return {"LD_PRELOAD": os.path.abspath(name + ".so")}


def drift(steps):
    """A block of 10 x 10 cells that moves by 0.4 cells a step along both axes of a periodic grid of 24 x 24."""
    return ["-dim", 2, "-grid_lower", "0,0", "-grid_upper", "24,24", "-grid_cells", "24,24",
            "-bc_xmin_type", "periodic", "-bc_xmax_type", "periodic", "-bc_ymin_type", "periodic", "-bc_ymax_type", "periodic",
            "-materials", "m", "-material_m_model", "neohookean", "-material_m_rho", 1, "-material_m_E", 1e-2,
            "-material_m_nu", 0.3, "-bodies", "b", "-body_b_shape", "box", "-body_b_lower", "2,2", "-body_b_upper", "12,12",
            "-body_b_ppc", "2,2", "-body_b_material", "m", "-body_b_velocity", "4,2.5", "-dt_size", 0.1,
            "-time_end", 0.1 * steps, "-history_every", 1, "-output_every", 0.1 * steps / 40, "-report_limits", "false", "-output_dir", "."]


def memory(pid):
    """Bytes of a process in pages that are no file's, also of those that were moved to the disk; None if it has ended. smaps_rollup
    counts pages; the counters of status may lag behind by some hundred kB."""
    try:
        with open(f"/proc/{pid}/smaps_rollup") as pages, open(f"/proc/{pid}/status") as status:
            found = re.findall(r"^(?:Anonymous|Swap|RssShmem):\s+(\d+) kB", pages.read() + status.read(), re.M)
    except OSError:
        return None
    return 1024 * sum(map(int, found)) if len(found) == 3 else None


def step_of(history):
    """The step of the last whole line of a history; 0 before there is one."""
    try:
        with open(history, "rb") as file:
            file.seek(max(0, os.fstat(file.fileno()).st_size - 2000))
            lines = file.read().split(b"\n")
    except OSError:
        return 0
    return int(lines[-2].split(b",")[0]) if len(lines) > 2 and lines[-2][:1].isdigit() else 0


def watch(session, n, history, series):
    """Reads the memory of the n processes of a session until they end; series[rank] gets (step, bytes)."""
    pids = {}
    while len(pids) < n and (found := mpi.members(session)):
        pids = {0: session} if n == 1 else {r: p for p in found if (r := mpi.rank_of(p)) is not None}
        time.sleep(0.02)

    def look():
        while pids:
            for rank, pid in list(pids.items()):
                before, most, after = step_of(history), memory(pid), step_of(history)
                if most is None:
                    del pids[rank]
                elif after - before <= LAPSE:
                    series.setdefault(rank, []).append((after, most))
            time.sleep(PERIOD)
    threading.Thread(target=look, daemon=True).start()


def slopes(name, n, steps, options, env=None):
    """The run's output, and of each process the growth in bytes a step, that of the whole run in bytes, and the largest memory."""
    series, history = {}, name + ".csv"
    run = check.run([check.program, *drift(steps), "-output_name", name, *options], n, 3600, env=env,
                    during=lambda session: watch(session, n, history, series))
    check.need(run.good, f"{name}: status {run.status}: {run.said[-500:]}")
    found, end = [], step_of(history)
    for rank in sorted(series):
        step, m = np.array([look for look in series[rank] if look[0] < end]).T  # later looks see a process that ends
        parts = np.linspace(0.25, 1, PARTS + 1) * step[-1]
        at = np.interp(parts, step, m)
        found.append((np.sort(np.diff(at) / np.diff(parts))[2], at[-1] - at[0], m.max()))
    return run, found


def flat(steps):
    for name, n, times, options in WAYS:
        run, found = slopes(name, n, times * steps, options)
        moved = run.find(r"in (\d+) of \d+ steps")
        check.that(n == 1 or name == "pool" or moved and int(moved) > 0.3 * times * steps,
                   f"{name}: migrations in {moved} of {times * steps} steps")
        cuts = run.find(r"cut anew (\d+) times")
        check.that(name != "recut" or int(cuts or 0) > PARTS, f"{name}: the grid was cut anew {cuts} times")
        check.that(len(found) == n and all(slope < MOST and whole < WHOLE for slope, whole, _ in found),
                   f"{name} on {n}: {times * steps} steps, growth in bytes a step " + " ".join(f"{slope:.3f}" for slope, _, _ in found) +
                   ", of all parts in kB " + " ".join(f"{1e-3 * whole:.0f}" for _, whole, _ in found) +
                   ", at most MB " + " ".join(f"{1e-6 * most:.1f}" for _, _, most in found))


def find(steps):
    env = library("leak", LEAK % (LOST, LOST))
    for name, n, _, options in [way for way in WAYS if way[0] in ("direct", "recut")]:
        _, found = slopes(name, n, steps, options, env)
        check.that(len(found) == n and all(slope > MOST for slope, _, _ in found),
                   f"{name} on {n}: {LOST} bytes lost in each step, growth in bytes a step " + " ".join(f"{slope:.3f}" for slope, _, _ in found))


def told_sizes(run, name, n):
    """The bytes that each of the n processes of a run with the library TELL told under this name of /proc."""
    sizes = [1024 * int(kB) for kB in re.findall(rf"^{name}:\s+(\d+) kB", run.err, re.M)]
    check.need(len(sizes) == n, f"{len(sizes)} of {n} processes told their memory")
    return sizes


def told_and_found(name, n, options, env):
    """What -dry_run told of the largest memory in a process and in all, and what the run had, in MB."""
    options = ["-options_file", check.scene(name), "-time_max_steps", 40, "-report_limits", "false", "-output_dir", ".", *options]
    options += [] if "none" in options else ["-output_every", 1e9]
    dry = check.must(*options, "-dry_run", n=n)
    told = re.search(r"^memory +at the most ([\d.e+]+) MB in a process, ([\d.e+]+) MB in all", dry.out, re.M)
    check.need(told, f"{name}: no line `memory` in {dry.out}")
    run = check.run([check.program, *options], n, 600, env=env)
    check.need(run.good, f"{name}: {run.said[-500:]}")
    peaks = [1e-6 * size for size in told_sizes(run, "VmHWM", n)]
    return *map(float, told.groups()), max(peaks), sum(peaks)


def peak(which):
    env = library("tell", TELL)
    spatial, pool = ["-parallel_strategy", "spatial"], ["-parallel_strategy", "pool"]
    cases = {"some": [(name, n, more) for name in ("disks", "taylor", "footing_static") for n, more in ((1, []), (2, spatial))],
             "all": [(name[:-5], n, more) for name in sorted(os.listdir(os.path.dirname(check.scene("")))) if name.endswith(".opts")
                     for n, more in ((1, []), (2, spatial), (3, pool))],
             "large": [("disks", n, ["-grid_cells", "500,500", *more]) for n, more in ((1, []), (2, spatial), (3, pool))]
                      + [("disks", 1, ["-grid_cells", "500,500", "-output_format", "none"]),
                         ("dambreak3d", 2, ["-body_column_ppc", "6,6,6", *spatial])]}[which]
    for name, n, more in cases:
        told, told_all, most, in_all = told_and_found(name, n, more, env)
        check.that(abs(told / most - 1) < NEAR and abs(told_all / in_all - 1) < NEAR,
                   f"{name} on {n} {' '.join(more)}: told {told:.4g} MB, {most:.4g} found ({100 * (told / most - 1):+.1f} %); "
                   f"in all {told_all:.4g}, {in_all:.4g} ({100 * (told_all / in_all - 1):+.1f} %)")


def column(processes, side, ppc):
    """Options of the column of `share`, whose cubes have `side` cells on an edge."""
    width, length = side + 4, side * processes + 4
    return ["-dim", 3, "-grid_lower", "0,0,0", "-grid_upper", f"{width},{width},{length}",
            "-grid_cells", f"{width},{width},{length}", "-materials", "m", "-material_m_model", "neohookean",
            "-material_m_rho", 1, "-material_m_E", 1e-2, "-material_m_nu", 0.3, "-bodies", "b", "-body_b_shape", "box",
            "-body_b_lower", "2,2,1", "-body_b_upper", f"{side + 2},{side + 2},{length - 3}", "-body_b_ppc", f"{ppc},{ppc},{ppc}",
            "-body_b_material", "m", "-body_b_velocity", "0,0,4", "-method_update", "musl", "-dt_size", 0.1, "-time_end", 1e6,
            "-time_max_steps", 2, "-history_every", 1e9, "-report_limits", "false", "-output_dir", "."]


def share(_):
    env = library("tell", TELL)
    for few, many, side, ppc, options in ((4, 16, 24, 1, ["-output_format", "none"]), (16, 32, 12, 3, ["-output_every", 1e9])):
        own, particles = {}, (side * ppc) ** 3
        for n in (few, many):
            run = check.run([check.program, *column(n, side, ppc), *options], n, 900, env=env)
            check.need(run.good, f"share: status {run.status} on {n}: {run.said[-500:]}")
            check.need(int(run.find(r"particles changed process (\d+) times") or 0) > 0, f"no particle changed process on {n}")
            own[n] = max(told_sizes(run, "Anonymous", n))
        more = (own[many] - own[few]) / ((many - few) * particles)
        check.that(more < 1, f"memory of a process with {particles} particles, {options[0]} {options[1]}: {1e-6 * own[few]:.2f} MB of {few}, "
                             f"{1e-6 * own[many]:.2f} of {many}, {more:.2f} B for each particle of the others")


def near(_):
    env, most = library("tell", TELL), {}
    for name, gap in ("apart", 60), ("touching", 0):
        bodies = [word for k, b in enumerate("ab") for word in (f"-body_{b}_shape", "box", f"-body_{b}_lower", f"4,{4 + k * (16 + gap)}", f"-body_{b}_upper",
                                                                f"20,{20 + k * (16 + gap)}", f"-body_{b}_material", "m")]
        run = check.run([check.program, "-dim", 2, "-grid_lower", "0,0", "-grid_upper", "700,700", "-grid_cells", "700,700", "-materials", "m",
                         "-material_m_model", "neohookean", "-material_m_rho", 1, "-material_m_E", 1, "-material_m_nu", 0.3, "-bodies", "a,b", *bodies,
                         "-contact_mu", 0.3, "-time_end", 1e6, "-time_max_steps", 10, "-output_format", "none", "-report_indicator", "false", "-report_limits", "false",
                         "-output_dir", "."], 1, 300, env=env)
        check.need(run.good, f"near: {run.said[-500:]}")
        most[name] = told_sizes(run, "VmHWM", 1)[0]
    grid = 700 ** 2 * int(run.find(r", (\d+) B/node"))
    more = most["touching"] - most["apart"]
    check.that(more < 0.5 * grid, f"bodies in a corner: {1e-6 * most['apart']:.1f} MB where they are apart, {1e-6 * more:.1f} more where they touch; nodes of the whole grid take {1e-6 * grid:.1f}")


mpi.STARTER = None  # whose copies share its memory
words = check.arguments(__doc__, 2)
{"flat": lambda word: flat(int(word)), "find": lambda word: find(int(word)), "peak": peak, "share": share, "near": near}[words[0]](words[1])
check.end()
