"""Bad states: a step that fails is undone and made again (-check_state retry) with the same bits however many processes make
it; particles that leave the grid are removed and counted (-particles_leave delete); nothing that is not a number gets into a
file, and no run hangs.

usage: test_states.py PEBBLE SOURCE MPIEXEC some|all
"""
import csv
import glob
import os
import re

import h5py
import numpy as np

import check

(PART,) = check.arguments(__doc__, 1)
ALL = PART == "all"
DISKS = ["-options_file", check.scene("disks"), "-check_momentum", "0", "-check_energy", "0", "-report_indicator", "false"]
CRASH = DISKS + ["-body_disk1_velocity", "5,5", "-body_disk2_velocity", "-5,-5", "-dt_cfl", "1"] # turned inside out in step 6
LEAVE = DISKS + ["-body_disk1_velocity", "-0.6,0.2", "-body_disk2_velocity", "0.1,0.3", "-time_end", "0.5", "-particles_leave", "delete"]
QUIET = ["-output_format", "none"]
WAYS = {"1": (1, []), "3": (3, []), "pool": (3, ["-parallel_strategy", "pool"])}
MANY = WAYS | {"3 direct": (3, ["-parallel_migrate", "direct"]), "3 auto": (3, ["-parallel_balance", "auto"]), "2": (2, [])}


def runs(name, options, ways):
    """The same run in several ways, each in a folder of its own: {way: Run}."""
    def one(way):
        n, more = ways[way]
        return check.pebble(*options, *more, "-output_dir", folder(name, way), n=n)
    return dict(zip(ways, check.at_once(one, ways)))


def folder(name, way):
    return f"{name}_{way}".replace(" ", "_").replace(",", "_")


def stopped(run):
    """What a run says of its stop; None if it says nothing, or not just once."""
    found = re.findall(r"^stopped at step (\d+), t=\S+ s: (.*)$", run.err, re.M)
    return found[0] if len(found) == 1 else None


def finite(where):
    """Are all numbers in the files of a folder finite? (A law without heat has no temperature: nan.)"""
    for path in glob.glob(os.path.join(where, "*.csv")):
        with open(path, newline="") as file:
            if not all(np.isfinite(float(value)) for row in list(csv.reader(file))[1:] for value in row):
                return False
    good = []
    for path in glob.glob(os.path.join(where, "**", "*.h5"), recursive=True):
        with h5py.File(path) as file:
            file.visititems(lambda name, item: good.append(bool(np.isfinite(item[...]).all()))
                            if isinstance(item, h5py.Dataset) and item.dtype.kind == "f" and not name.endswith("temperature") else None)
    return all(good)


# ---- A step that fails is made again

ways = MANY if ALL else WAYS
stop = check.pebble(*CRASH, *QUIET, "-time_max_steps", "60", "-output_dir", "crash_stop")
check.that(stop.status == 3 and "turned inside out" in stop.err and not stop.digest and "retr" not in stop.out, "stop: a crash stops the run")
again = runs("crash", CRASH + QUIET + ["-time_max_steps", "60", "-check_state", "retry"], ways)
first = again["1"]
undone = first.find(r"^retries +(\d+) tries were undone, in \d+ of \d+ steps")
check.that(first.status == 0 and undone and int(undone) > 0, f"retry: the same scene goes on, {undone} tries undone")
check.that(len(re.findall("^retry ", first.out, re.M)) == 1 and "particle" in first.find("^retry (.*)$"), "the first retry is told, with its reason, once")
for way, run in again.items():
    check.that(run.digest == first.digest and run.find("^(retries.*)$") == first.find("^(retries.*)$") and check.content(os.path.join(folder("crash", way), "disks.csv")) == check.content("crash_1/disks.csv"),
               f"retry, {way}: same bits, history and retries")

# What is undone leaves no trace: the run that gives up at once has the state, and the history, of one that was made to end there.
METHODS = {
    "linear usf flip": [],
    "bspline2 musl aflip": ["-method_basis", "bspline2", "-method_update", "musl", "-method_transfer", "aflip", "-dt_cfl", "2", "-history_energy"],
    "gimp stretch usl apic": ["-method_basis", "gimp", "-method_gimp_update", "stretch", "-method_update", "usl", "-method_transfer", "apic", "-dt_cfl", "1.5"],
    "vonmises fbar": ["-material_soft_model", "vonmises", "-material_soft_yield", "50", "-method_locking", "fbar", "-method_basis", "bspline2", "-method_update", "usl", "-dt_cfl", "2", "-history_energy"],
    "bspline3 usf xpic": ["-method_basis", "bspline3", "-method_transfer", "xpic", "-dt_cfl", "2"],
    "bspline2 usl afmpm": ["-method_basis", "bspline2", "-method_update", "usl", "-method_transfer", "afmpm", "-dt_cfl", "2"],
    "damping": ["-method_basis", "bspline2", "-method_update", "usl", "-method_damping_rate", "0.05", "-dt_cfl", "2"],
}
for name, method in METHODS.items() if ALL else list(METHODS.items())[:4]:
    options = CRASH + ["-body_disk1_velocity", "15,15", "-body_disk2_velocity", "-15,-15"] * (name != "linear usf flip") + QUIET + method + ["-history_every", "0"]
    gave_up = check.pebble(*options, "-check_state", "retry", "-dt_retry", "0", "-output_dir", "up")
    at = stopped(gave_up)
    check.need(gave_up.status == 3 and at and int(at[0]) > 1, f"{name}: it does not fail: {gave_up.err[-300:]}")
    good = check.pebble(*options, "-time_max_steps", at[0], "-output_dir", "good")
    check.that(gave_up.digest and gave_up.digest == good.digest and check.content("up/disks.csv") == check.content("good/disks.csv"),
               f"{name}: undone in step {int(at[0]) + 1}, state and history are those after step {at[0]}")
    check.that(os.path.exists("up/disks-checkpoint-1.h5"), f"{name}: there is a checkpoint of the last good state")
    for path in glob.glob("up/*checkpoint*"):
        os.remove(path)

# Where nothing fails, retry changes no bit.
calm = [check.must(*DISKS, *QUIET, "-time_max_steps", "60", *more, "-output_dir", "calm") for more in ([], ["-check_state", "retry"])]
check.that(calm[0].digest == calm[1].digest and "retries" not in calm[1].out, "retry without a bad state: the bits of a run without it")
row = [int(run.find(r"(\d+) with order and scratch")) for run in calm]
check.that(row[1] - row[0] == 68, f"the copy is counted: {row[0]} and {row[1]} bytes a particle") # x, v, F, cell

# A restart while dt grows back goes on with the same steps.
half = check.pebble(*CRASH, *QUIET, "-time_max_steps", "7", "-checkpoint_every", "10", "-check_state", "retry", "-output_dir", "grows")
rest = check.pebble(*CRASH, *QUIET, "-time_max_steps", "60", "-checkpoint_every", "10", "-check_state", "retry", "-output_dir", "grows", "-restart_file", "latest")
check.that(half.find("^(retries)") and rest.digest == first.digest and rest.find("^(retries.*)$") == first.find("^(retries.*)$") and check.content("grows/disks.csv").endswith(check.content("crash_1/disks.csv")[-200:]),
           f"after a restart while dt grows: same bits, same count {rest.err[-200:]}")

# A fixed dt: it is halved, and grows back by the factor given.
fixed = check.pebble(*CRASH[:-2], *QUIET, "-dt_size", "0.006", "-time_max_steps", "40", "-history_every", "0", "-check_state", "retry", "-dt_max_growth", "1.2", "-output_dir", "fixed")
dt = check.history("fixed/disks.csv")["dt"][1:]
growth = dt[1:] / dt[:-1]
check.that(fixed.find("^(retries)") and dt.max() == 0.006 and dt.min() < 0.004 and growth.max() < 1.2 * (1 + 1e-12) and (growth > 1.19).any(),
           f"fixed dt: {dt.min():.3g} to {dt.max():.3g} s, growing by at most {growth.max():.4g}")

# Checks are a part of the transaction: no line of the history is beyond a bound, whatever happens.
for bound, status in (0.001, 0), (0.0002, 3):
    energy = runs("energy", DISKS + QUIET + ["-body_disk1_velocity", "2,2", "-body_disk2_velocity", "-2,-2", "-dt_cfl", "0.9", "-check_energy", str(bound), "-check_state", "retry", "-history_every", "0", "-time_end", "0.1"],
                  WAYS if status or ALL else {"1": WAYS["1"]})
    lines = check.history("energy_1/disks.csv")
    size = np.maximum.accumulate(lines["kinetic_energy"] + lines["strain_energy"])
    check.that(energy["1"].status == status and energy["1"].find("^(retry +step.*energy changed)") and (np.abs(lines["energy_residual"]) <= bound * size).all(),
               f"-check_energy {bound} is kept in each of {len(size)} lines, by retries; exit status {status}")
    check.that(len({(run.digest, run.find("^(retries.*)$"), stopped(run)) for run in energy.values()}) == 1, "the same on any number of processes")

# A run that a check stops leaves a checkpoint of its last state, from which it goes on as if there had been no bound.
fast = DISKS + QUIET + ["-body_disk1_velocity", "2,2", "-body_disk2_velocity", "-2,-2", "-dt_cfl", "0.9", "-history_every", "0.03", "-time_end", "0.1", "-output_dir"]
whole = check.must(*fast, "whole")
for way, (n, more) in WAYS.items():
    halted = check.pebble(*fast, check.folder("halted"), *more, "-check_energy", "1e-5", n=n)
    on = check.pebble(*fast, "halted", *more, "-restart_file", "latest", n=n)
    check.that(halted.status == 3 and stopped(halted) and "energy changed" in halted.err and on.status == 0 and on.digest == whole.digest and check.content("halted/disks.csv") == check.content("whole/disks.csv"),
               f"{way}: stopped by -check_energy at {stopped(halted)}, the run goes on without it: {on.err[-300:]}")

# ---- Particles that leave are removed

left = runs("left", LEAVE + ["-output_every", "0.1", "-check_energy", "0.05", "-check_momentum", "1e-10", "-history_energy"], MANY if ALL else {way: MANY[way] for way in ("1", "3", "3 direct", "pool")})
one = left["1"]
check.that(one.status == 0 and len(re.findall("^warning .*left the grid.*is removed", one.out, re.M)) == 1, "the run goes on, the first particle is named, once")
for way, run in left.items():
    files = [check.particles(f"{folder('left', way)}/disks.h5", k) for k in (1, -1)]
    same = [check.particles("left_1/disks.h5", k) for k in (1, -1)]
    check.that(run.digest == one.digest and run.find("^(lost.*)$") == one.find("^(lost.*)$") and check.content(os.path.join(folder("left", way), "disks.csv")) == check.content("left_1/disks.csv") and
               all(np.array_equal(a[key], b[key]) for a, b in zip(files, same) for key in a), f"{way}: same bits, history and snapshots")
history = check.history("left_1/disks.csv")
n, total = history["particles"], 1624
number = int(one.find(r"^lost +(\d+) of 1624 particles"))
check.that(n[0] == total and 0 < n[-1] == total - number < total and (np.diff(n) <= 0).all(), f"{number} of {total} particles left")
mass = history["mass"] + history["lost_mass"]
check.that(np.abs(mass / mass[0] - 1).max() < 1e-14, "mass and lost mass are the mass at the start")
for axis in "xy":
    p = history[f"momentum_{axis}"] + history[f"lost_momentum_{axis}"]
    check.that(np.abs(p - p[0]).max() < 1e-12 * np.abs(p[0]), f"momentum {axis} and what left are that at the start")
check.that(np.abs(history["energy_residual"]).max() < 0.05 * history["total_energy"][0] and history["lost_kinetic_energy"][-1] > 0.05 * history["total_energy"][0], "the balance of energy has what left")
check.that(np.abs(history["energy_integration"]).max() < 0.05 * history["total_energy"][0], "so have the terms")
with h5py.File("left_1/disks.h5") as file, open("left_1/disks.xdmf") as text:
    counts = [len(file[f"step_{step:06d}/particles/id"]) for step in check.steps(file)]
    ids = check.group(file)["particles/id"][:]
    named = text.read()
check.that(counts[-1] == n[-1] and (np.diff(ids) > 0).all() and ids[-1] < total and all(f"NumberOfElements=\"{k}\"" in named for k in counts), f"snapshots have {counts} particles, sorted by id")
gone = check.pebble(*LEAVE, "-body_disk2_velocity", "0.2,0.9", "-time_end", "5", "-output_dir", "gone", n=3)
check.that(gone.status == 3 and stopped(gone) and "no particle is left" in stopped(gone)[1] and finite("gone"), "a run without particles ends with a line")

# It goes on from a checkpoint as if it had not stopped, and what was lost before counts.
half = check.pebble(*LEAVE, "-output_every", "0.1", "-history_energy", "-checkpoint_every", "0.2", "-time_max_steps", "30", "-output_dir", "half")
rest = check.pebble(*LEAVE, "-output_every", "0.1", "-history_energy", "-checkpoint_every", "0.2", "-restart_file", "latest", "-output_dir", "half", n=3)
check.that(half.status == 0 and rest.digest == one.digest and check.history("half/disks.csv")["lost_mass"][-1] == history["lost_mass"][-1], f"after a restart: the same bits, and all that was lost {rest.err[-200:]}")

# ---- Nothing that is not a number gets into a file

NAN = ["-options_file", check.scene("disks"), "-check_momentum", "0", "-check_energy", "0", "-acceleration", "sqrt(0.1-t), 0", "-output_every", "0.02", "-history_every", "0.01", "-time_end", "0.3"]
HUGE = DISKS + ["-output_every", "0.02", "-time_end", "0.3"]
BAD = {
    "a force that becomes NaN": (NAN, "not finite"),
    "the same, leave delete": (NAN + ["-particles_leave", "delete"], "not finite"),
    "the same, retry": (NAN + ["-check_state", "retry"], "not finite"),
    "the same, retry and delete, musl": (NAN + ["-check_state", "retry", "-particles_leave", "delete", "-method_update", "musl"], "not finite"),
    "velocity 1e200": (HUGE + ["-body_disk1_velocity", "1e200,0"], "not finite|vanishes"),
    "velocity 1e200, dt given, delete": (HUGE + ["-body_disk1_velocity", "1e200,0", "-dt_size", "0.01", "-particles_leave", "delete"], "not finite"),
    "velocity 1e100, dt given": (HUGE + ["-body_disk1_velocity", "1e100,0", "-dt_size", "0.01"], "left the grid|not finite|inside out"),
    "crushed, retry": (CRASH + ["-body_disk1_velocity", "60,60", "-body_disk2_velocity", "-60,-60", "-dt_retry", "1", "-check_state", "retry"], "inside out|left the grid"),
}
for name, (options, want) in BAD.items() if ALL else list(BAD.items())[:6]:
    for way, run in runs("bad", options, WAYS if ALL or name == "the same, retry" else {"pool" if "delete" in name else "3" if "1e200" in name else "1": WAYS["pool" if "delete" in name else "3" if "1e200" in name else "1"]}).items():
        said = stopped(run)
        check.that(run.status == 3 and said and re.search(want, said[1]) and finite(folder("bad", way)) and (("retry" in name) == bool(run.digest)), f"{name}, {way}: {said and said[1][:150]}")

check.end()
