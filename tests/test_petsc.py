#!/usr/bin/env python3
"""What PETSc shows of a run: test_petsc.py PEBBLE SOURCE MPIEXEC

-dm_view prints the grid's DMDAs with the names of their unknowns, cut as the run says, and the swarm with its
particles and fields. -log_view has the stages of a run; the stage of the steps has an event for each phase and part of a
step, with its operations, and counts the ghost updates and their messages. PETSc's options that would cut the grid in
another way are refused before there is a DM, and so are viewers that would overwrite each other.
"""
import re

import check

REFUSED = 2
STEPS = 100
SUMS = "mass momentum_x momentum_y momentum_z force_x force_y force_z none"
PARTS = ["FORCES", "REDUCE", "MIGRATE", "SORT", "SETTLE", "other"]  # of a step, which are no phases
STAGES = ["MPM set-up", "MPM steps", "MPM output"]


def scene(name, *arguments):
    return ["-options_file", check.scene(name), "-output_dir", ".", *arguments]


def output(n, name, *arguments):
    return check.must(*scene(name, *arguments), n=n).out


def viewed(n, name, dim, *arguments):
    """-dm_view of a scene: the lines of each DM, in their order; what they say is checked against the scene."""
    what = " ".join([name, f"on {n}", *arguments])
    out = output(n, name, "-time_max_steps", "1", "-dm_view", *arguments)
    plain = output(n, name, "-time_max_steps", "1", *arguments)
    names = [f"{of}_{axis}" for of in ("velocity", "acceleration") for axis in "xyz"[:dim]]
    check.that(f"\nUnknowns of a node of grid: {' '.join(names)}\n" in out, f"{what}: the grid's unknowns are named")
    check.that(f"\nUnknowns of a node of sums: {SUMS}\n" in out, f"{what}: the unknowns of the sums are named")
    check.that(re.search(r"^DM Object: grid .*\n *type: da$", out, re.M), f"{what}: the DMDA has its name")
    check.that(re.search(r"^DM Object: particles .*\n *type: swarm$", out, re.M), f"{what}: the swarm has its name")
    boxes = re.findall(r"^Processor \[(\d+)\] (.*) w (\d+) s (\d+)\n(X range.*)", out, re.M)
    grids = {width: [(rank, sizes, stencil, box) for rank, sizes, w, stencil, box in boxes if w == width] for width in (str(2 * dim), "8")}
    check.that(len(boxes) == len(set(boxes)) and grids[str(2 * dim)] == grids["8"] and len(boxes) == 2 * len(grids["8"]),
               f"{what}: both DMDAs have the same boxes")
    particles = int(re.search(r"(\d+) particles", plain)[1])
    ranks = re.search(r"Number of particles per rank: ([\d ]+)", out)
    check.that(ranks and sum(map(int, ranks[1].split())) == particles, f"{what}: the swarm has {particles} particles")
    check.that(out.rpartition("digest")[2] == plain.rpartition("digest")[2] != "", f"{what}: the state is as without -dm_view")
    return grids["8"]


def logged(n, name, *arguments):
    """Events of each stage: name -> sums of the columns over the processes, "summary" being the whole stage; and the
    phases of the table."""
    out = output(n, name, "-time_max_steps", STEPS, "-report_phases", "-log_view", ":log.csv:ascii_csv", *arguments)
    table = re.findall(r"^  (\S+) ", out.partition("\nphase ")[2].partition("\n  all ")[0], re.M)
    stages = {}
    for row in check.rows("log.csv"):
        if row["Rank"]:
            event = stages.setdefault(row["Stage Name"], {}).setdefault(row["Event Name"], {})
            for column in ("Count", "Time", "Num Messages", "Message Length", "FLOP"):
                event[column] = event.get(column, 0) + float(row[column])
    return stages, [phase for phase in table if phase not in PARTS]


check.arguments(__doc__, 0)

# ---- -dm_view: the same DMs for each way to run.
boxes = viewed(1, "disks", 2)
check.that(len(boxes) == 1, "disks on 1: one box")
boxes = viewed(2, "disks", 2)
check.that(len(boxes) == 2, "disks on 2: two boxes")
viewed(3, "disks", 2, "-parallel_sums", "roundoff")
check.that(len(viewed(3, "disks", 2, "-parallel_strategy", "pool")) == 1, "disks, pool on 3: the master has the DMs")
check.that(len(viewed(2, "dambreak3d", 3)) == 2, "dambreak3d on 2: two boxes")
out = output(1, "disks", "-time_max_steps", "1", "-dm_view", "::ascii_info_detail")
fields = re.findall(r"^ *\[ *\d+\] +(\w+) : Mem", out, re.M)
check.that(set(fields) >= {"DMSwarm_pid", "DMSwarm_rank", "x", "v", "F", "cell"}, f"the swarm shows its fields: {' '.join(fields)}")

# ---- -log_view: every phase and part of a step, with its operations.
for n, name, with_parts in (1, "disks", ["SORT"]), (2, "disks", ["REDUCE", "SORT", "SETTLE", "MIGRATE"]), (2, "mms", ["FORCES", "REDUCE", "SETTLE"]):
    stages, phases = logged(n, name)
    for stage in STAGES:
        whole = stages.get(stage, {}).get("summary", {"Count": 0, "Time": 0, "Num Messages": 0})
        check.that(whole["Count"] == n and whole["Time"] > 0 and (whole["Num Messages"] > 0) == (n > 1),
                   f"{name} on {n}: the stage {stage} on each process, {whole['Time']:.3g} s, {whole['Num Messages']:.0f} messages")
    check.need(set(STAGES) <= set(stages), f"{name} on {n}: the stages are {' '.join(stages)}")
    made = stages["MPM set-up"].get("DMSwarmSetSizes", {"Count": 0})["Count"]
    check.that(made >= n, f"{name} on {n}: the swarm gets its size in the set-up, {made:.0f} times")
    events = stages["MPM steps"]
    check.that(len(phases) >= 3, f"{name} on {n}: phases {' '.join(phases)}")
    for phase in phases:
        event = events.get(phase, {"Count": 0, "FLOP": 0})
        check.that(event["Count"] == n * STEPS and event["FLOP"] > 0,
                   f"{name} on {n}: {phase} {event['Count']:.0f} times, {event['FLOP']:.3g} operations")
    for part in with_parts:
        count = events.get(part, {"Count": 0})["Count"]
        every = part in ("REDUCE", "SETTLE", "FORCES")
        check.that(count == n * STEPS if every else 0 < count <= n * STEPS, f"{name} on {n}: {part} {count:.0f} times")
    if n > 1:
        updates = [phase for phase in phases if not phase.startswith(("P2G", "G2P"))]
        sent = events.get("SFBcastBegin", {"Count": 0, "Num Messages": 0})
        messages = sent["Num Messages"] / 2  # each is counted where it is sent and where it arrives
        check.that(len(updates) >= 1 and sent["Count"] == n * STEPS * len(updates) and messages == (n - 1) * STEPS * len(updates),
                   f"{name} on {n}: {messages:.0f} messages of ghost updates, one after {' and '.join(updates)}")

# ---- Options of DMs that are refused, before there is a DM.
other = "is not an option of this scene"
only = "it takes no value, or ::ascii_info_detail"
for option, line in ([(option, other) for option in (["-da_processors_x", "2"], ["-da_grid_x", "30"], ["-da_refine", "1"], ["-da_overlap", "2"],
                                                     ["-da_bd_all", "periodic"], ["-dm_vec_type", "mpi"], ["-dm_bind_below", "9"], ["-sf_type", "window"])]
                     + [(["-dm_view", value], only) for value in ("draw", ":grid.txt", "hdf5:grid.h5", "binary", "no_such_viewer")]):
    more = [] if option[0] == "-dm_view" else ["-dm_view"]
    run = check.pebble(*scene("disks", *option, *more))
    check.that(run.status == REFUSED and run.out == "" and run.err.count("\n") == 1 and line in run.err and run.err.startswith(option[0]),
               f"{' '.join(option)}: {run.err.strip() or run.out[:100]}")

check.end()
