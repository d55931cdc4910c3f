"""What a run prints of its time: the prediction in words, the phases of steps that took a second or are asked for, what a dry
run adds; and the note on a pool whose patches are fewer than its workers. Times are read, not judged.

usage: test_prints.py PEBBLE SOURCE MPIEXEC (some | rest)

some: of the scenes whose steps are counted a third, and of the pools less than half; rest: the others
"""
import os
import re
import subprocess
import sys

import numpy as np

import check

REST = check.arguments(__doc__, 1) == ["rest"]
DISKS = ["-options_file", check.scene("disks"), "-check_momentum", "0", "-check_energy", "0", "-output_format", "none", "-report_limits", "false"]
UNITS = {"second": 1, "minute": 60, "hour": 3600, "day": 86400, "year": 3.156e7}
PREDICT = r"^predict +(\S+) steps of (\S+) s: roughly (\S+) (\w+?)s? without output \((.*); a run of more than a second measures it first\)$"


def predicted(*options, scene=DISKS):
    """The line of the prediction: steps, s a step, number, unit, origin."""
    run = check.must(*scene, *options, "-dry_run")
    found = re.search(PREDICT, run.out, re.M)
    check.need(found, f"no prediction: {run.out}")
    return float(found[1]), float(found[2]), float(found[3]), found[4], found[5]


def words():
    """The time in words is that of the steps, in the unit that suits it."""
    units = {}
    for power in range(-1, 14, 1 if REST else 2):
        steps, step, number, unit, origin = predicted("-time_end", f"3e{power}")
        seconds = steps * step
        check.fault(None if abs(number * UNITS[unit] / seconds - 1) < 0.06 else f"{steps} steps of {step} s are about {number} {unit}s")
        below = {"second": 90, "minute": 90, "hour": 48, "day": 730, "year": 1e99}[unit]
        check.fault(None if number <= below and (unit == "second" or number * UNITS[unit] >= 1.4 * UNITS[unit]) else f"{number} {unit}s are not the unit that suits")
        check.fault(None if origin == "rough constants" else origin)
        units[unit] = number
    check.that(list(units) == list(UNITS), f"times in {', '.join(units)}s")
    run = check.must(*DISKS, "-time_end", "1e8", "-dry_run")
    check.that(re.search(PREDICT, run.out, re.M) and "e+" not in re.search(PREDICT, run.out, re.M)[3], "without an exponent where it is of ordinary length")


def steps():
    """Scenes make about as many steps as predicted, so that the factor holds. (impact is squeezed: its dt falls.)"""
    ratios = {}
    for k, name in enumerate(("disks", "drop", "friction", "barx", "cantilever", "column", "shear", "dambreak", "mms", "elastic_column", "impact")):
        if REST != (k % 3 > 0):
            continue
        more = ("-output_format", "none", "-output_dir", "steps", "-report_limits", "false")
        run = check.must("-options_file", check.scene(name), *more)
        ratios[name] = int(run.find(r"^done +(\d+) steps")) / float(run.find(r"^predict +(\S+) steps"))
    off = {name: f"{ratio:.2f}" for name, ratio in ratios.items() if not 1 / 1.3 < ratio < 1.3}
    check.that(set(off) <= {"impact"}, f"steps made over steps predicted: {min(ratios.values()):.2f} to {max(ratios.values()):.2f}, more than 1.3: {off}")


TABLE = r"^phase +s +%.*\n(  \w+ .*\n)+  all .*\nmodel      constants .*$"


OUTPUT = r"^output     (\S+) s for history and snapshots$"


def seconds(run):
    return float(run.find(r"^done .* in (\S+) s"))


def first(good, runs):
    """The first of some runs that is good, else the last: the time of a run hangs on the machine and on what else it does."""
    for options in runs:
        run = check.must(*DISKS, *options)
        if good(run):
            break
    return run


def phases():
    """The table is printed after a second of steps, or where it is asked for, and never where it is refused."""
    short = ["-time_end", "0.5"]
    run = first(lambda run: seconds(run) < 1, 3 * [short])
    check.that(not re.search(r"^(phase|model|output|  all) ", run.out, re.M) and run.find(r"^speed  .*(process)$"), "a short run prints no phases, but its speed")
    asked = first(lambda run: run.find(OUTPUT), 3 * [[*short, "-report_phases"]])
    check.that(re.search(TABLE, asked.out, re.M), "-report_phases asks for them")
    check.that(asked.digest == run.digest, "and the bits are the same")
    check.that(asked.find(OUTPUT), "with the time of the output")
    check.that(not re.search(TABLE, check.must(*DISKS, *short, "-report_phases", "false").out, re.M), "-report_phases false does not")
    lengthy = first(lambda run: seconds(run) > 1.2, (["-dt_size", dt, "-history_every", "10"] for dt in ("1e-4", "3e-5", "1e-5")))
    check.that(re.search(TABLE, lengthy.out, re.M), f"steps that take {seconds(lengthy)} s print them")
    often = first(lambda run: run.find(OUTPUT) and seconds(run) - float(run.find(OUTPUT)) > 1.2,
                  (["-dt_size", dt, "-history_every", "0", "-report_phases", "false"] for dt in ("3e-4", "1e-4", "3e-5")))
    check.that(often.find(OUTPUT) and not re.search(TABLE, often.out, re.M), "and with -report_phases false only the output, if it takes a second")
    for n, strategy in (2, "spatial"), (2, "pool"):
        check.that(re.search(TABLE, check.must(*DISKS, *short, "-report_phases", "-parallel_strategy", strategy, n=n).out, re.M), f"{strategy} on {n}")


def later():
    """A run that takes more than a second says so by its first steps; tools/bench.py reads what was predicted and measured."""
    command = [check.program, *DISKS, "-dt_size", "1e-7", "-history_every", "1e9", "-output_dir", "later"]
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=check.mpi.ENVIRONMENT | dict(os.environ))
    told = next((line for line in process.stdout if line.startswith("predict    after")), "")
    process.kill()
    process.wait()
    check.mpi.keep(told)
    found = re.fullmatch(r"predict    after (\S+) s: (\S+) more steps of (\S+) s, about (\S+) (\w+?)s? in all with output\n", told)
    check.need(found, f"the time by the first steps: {told}")
    spent, left, step, number, unit = float(found[1]), float(found[2]), float(found[3]), float(found[4]), found[5]
    check.that(left > 5e5 and 0.9 < number * UNITS[unit] / (spent + left * step) < 1.2, f"it is what is left times the time of a step, and what was: {told.strip()}")
    sys.path[:0] = [os.path.join(check.source, "tools"), os.path.join(check.source, "tools", "bench")]
    import predicted

    text = "scene      a   10 particles (4+6)\npredict    20 steps of 0.1 s: about 2 seconds without\n%sdone       40 steps, t=3 s, in 5.5 s\nspeed      2e6 ns/particle/step, 1\n"
    check.that(predicted.of(text % "") == (0.8, 2.0) and predicted.of(text % "predict    after 0.1 s: 30 more steps of 0.1 s, about 3 seconds in all with output\n") == (5.5, 3.0) and
               predicted.of("done") is None, "what make bench reads")


def statics():
    """A static run says how many steps it will make, how long that takes by its first two iterations, and again by its steps."""
    command = [check.program, "-options_file", check.scene("reissner"), "-dt_size", "1e-4", "-history_every", "1e9", "-output_every", "1e9", "-output_dir", "statics"]
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=check.mpi.ENVIRONMENT | dict(os.environ))
    told = []
    for line in process.stdout:
        if line.startswith("predict"):
            told.append(line)
            if line.startswith("predict    after"):
                break
    process.kill()
    process.wait()
    check.mpi.keep("".join(told))
    check.need(len(told) == 3 and told[0].startswith("predict    10000 steps, in each a solve;"), f"three predictions of a static run: {told}")
    first = re.match(r"predict    two iterations of Newton's method took (\S+) s: with 5 in each of 10000 steps about (\S+) (\w+?)s? in all; plastic flow takes more", told[1])
    check.that(first and 0.8 < float(first[2]) * UNITS[first[3]] / (float(first[1]) * 5 / 2 * 10000) < 1.25, f"by two iterations of five: {told[1].strip()}")
    later = re.match(r"predict    after (\S+) s: (\S+) of 1 s of the load in (\d+) steps, about (\S+) (\w+?)s? in all with output", told[2])
    check.that(later and abs(float(later[2]) - 1e-4 * float(later[3])) < 1e-8 and float(later[4]) * UNITS[later[5]] > 0.5 * float(later[1]) / float(later[2]) * 0.1, f"by the steps that were made: {told[2].strip()}")


def dry():
    """A dry run: phases with the time of a step and of all; other numbers of processes only with -report_processes."""
    plain = check.must(*DISKS, "-dry_run").out
    part = re.search(r"^model      constants .*\n  phase +s/step +s in all   on as many processes as here\n((?:  \w+ +\S+ +\S+\n)+)", plain, re.M)
    check.need(part, f"phases of a dry run: {plain}")
    rows = [(name, float(step), float(all_)) for name, step, all_ in map(str.split, part[1].splitlines())]
    count = float(re.search(PREDICT, plain, re.M)[1])
    check.that(rows[-1][0] == "all" and all(abs(all_ / (count * step) - 1) < 0.01 for _, step, all_ in rows), f"{len(rows)} rows: s in all are {count:g} times s a step")
    check.that(abs(sum(row[1] for row in rows[:-1]) / rows[-1][1] - 1) < 0.01, "and the last is the sum")
    check.that("processes  " not in plain and "pool:" not in plain, "no table of many processes")
    whole = check.must(*DISKS, "-dry_run", "-report_processes").out
    sizes = re.findall(r"^ +(\d+) +(\S+) +(\S+) (\w+?)s? +\S+ +\S+ +\S+(?: +(\S+) +(\S+) (\w+?)s? +\S+)?$", whole, re.M)
    check.that([row[0] for row in sizes][:4] == ["1", "2", "4", "8"] and "pool: with these patches" in whole, "-report_processes asks for it")
    for row in sizes:
        for step, number, unit in (row[1:4], row[4:7]) if row[4] else (row[1:4],):
            check.fault(None if abs(float(number) * UNITS[unit] / (count * float(step)) - 1) < 0.06 else f"{row}: {number} {unit}s are not {count:g} times {step} s")
    check.that(plain.splitlines()[:4] == whole.splitlines()[:4], "all else is the same")
    notes = check.must(*DISKS, "-time_max_steps", "1", "-report_processes").out
    check.that("note       -report_processes has no effect without -dry_run\n" in notes, "it has no effect in a run, which says so")
    notes = check.must(*DISKS, "-dry_run", "-report_phases").out
    check.that("note       -report_phases has no effect with -dry_run\n" in notes, "nor has -report_phases in a dry run")
    notes = check.must(*DISKS, "-dry_run", "-pool_cells", "8").out
    check.that("note       -pool_cells has no effect on one process\n" in notes, "nor an option of many processes without the table")


def patches(x, cells):
    """Patches of so many cells an edge that particles at x, in cells, lie in."""
    return len({tuple(at) for at in np.floor(x / cells).astype(int)})


def pool():
    """The note on a pool whose patches with particles are fewer than its workers, counted here from positions, and its remedy."""
    linear = [*DISKS[:-4], "-report_limits", "false", "-method_basis", "linear", "-time_max_steps", "0", "-output_fields", "velocity"]
    noted = []
    for grid, cells, n in ((20, 16, 8), (20, 6, 8), (20, 2, 8), (20, 100000, 3), (8, 4, 7)) if REST else ((20, 16, 4), (8, 2, 10), (8, 5, 6), (20, 16, 2)):
        run = check.must(*linear, "-grid_cells", f"{grid},{grid}", "-parallel_strategy", "pool", "-pool_cells", cells, n=n)
        x, workers = check.particles("output/disks.h5", 0, ["x"])["x"][:, :2] * grid, n - 1
        cells += cells % 2  # whole tiles
        has = patches(x, cells)
        note = run.find(r"^note       (the pool has fewer .*)$")
        if has >= workers:
            check.that(note is None, f"{has} patches for {workers} workers: no note")
            continue
        fits = [edge for edge in range(2, min(cells, grid + 1), 2) if patches(x, edge) >= workers]
        said, most = f"the pool has fewer patches with particles than workers, {has} for {workers}, so some have no work: ", patches(x, 2)
        said += (f"-pool_cells {fits[-1]} makes {patches(x, fits[-1])}" if fits else
                 f"-pool_cells 2 makes {most}, and smaller ones are not possible; use {most + 1} processes at most")
        check.that(note == said, f"{grid} cells, {n} processes: {note}" + ("" if note == said else f", expected {said}"))
        noted.append(bool(fits))
        if fits:
            again = check.must(*linear, "-grid_cells", f"{grid},{grid}", "-parallel_strategy", "pool", "-pool_cells", fits[-1], n=n)
            check.that("the pool has fewer" not in again.out, "with that there is no note")
    check.fault(None if REST or set(noted) == {True, False} else "one remedy was not told")


for part in (words, steps, pool) if REST else (words, steps, phases, later, statics, dry, pool):
    part()
check.end()
