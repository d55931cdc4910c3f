#!/usr/bin/env python3
"""What the preset `solid` gains: errors and the time of the steps on ladders of grids, of it and of `balanced`,
into docs/data/solid.csv; and the table that compares the two at equal time.

    solid.py                      what is missing; --again: all;  --problems bar mms: these alone

The time of the steps is the least of several turns, in which the methods run one after the other: of a run the time of its
phases, or if they take longer than 0.1 s its processor time less that of a run of no step, if that is less, so that other work
on the machine counts little.

At equal time. The error of `solid` at the time that `balanced` takes on a grid is read from its own errors over time, by straight
lines between grids in logarithms; beyond its ladder it is that of the nearest grid, and marked so by the table.
"""
import argparse
import math
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)
import problems  # noqa: E402 (after the path)
import run  # noqa: E402
from marks import markdown  # noqa: E402
from problems import PROBLEMS  # noqa: E402

METHODS = {"balanced": ("-method_preset balanced", 2), "solid": ("-method_preset solid", 2), "solid 3": ("-method_preset solid", 3)}  # and particles a cell and axis
GRIDS = {"bar": [8, 16, 32, 64, 128], "barx": [16, 32, 64, 128, 256, 512], "column": [16, 32, 64, 128, 256], "mms": [8, 16, 32, 64, 128], "shear": [8, 16, 32, 64, 128],
         "cantilever": [2, 4, 8, 16], "ring": [24, 48, 96, 192], "vortex": [30, 60, 120, 240], "pressure": [15, 30, 60]}
SHORT, SHORT_TURNS = 0.5, 12  # s: runs that take less have more turns
COLUMNS = ["problem", "n", "method", "options", "error", "steps", "particles", "seconds"]


def measure(program, out, problem, n, turns, rows):
    found, zero = {}, run.folder_of(out, problem, n, "zero")
    for turn in range(SHORT_TURNS):
        if turn >= turns and any(float(row["seconds"]) > SHORT for row in found.values()):
            break
        for method, (options, ppc) in METHODS.items():
            folder = run.folder_of(out, problem, method, n)
            words = [*problems.options(problem, n, ppc, folder), *options.split(), "-report_phases", "true"]
            done, whole = run.processor_time(program, folder, words)
            seconds = float(done.find(r"^  all +\S+ +\S+ +\S+ +(\S+)") or "inf") * int(done.find(r"^done +(\d+) steps"))
            if seconds > 0.1:
                seconds = min(seconds, whole - run.processor_time(program, zero, [*words, "-time_max_steps", "0"])[1])
            if method not in found or seconds < float(found[method]["seconds"]):
                error = PROBLEMS[problem].error(done) if done.status == 0 else math.nan
                found[method] = dict(zip(COLUMNS, [problem, n, method, options, f"{error:.4g}", done.find(r"^done +(\d+) steps"), done.find(r" (\d+) particles"), f"{seconds:.4g}"]))
            done.done()
    for method, row in found.items():
        rows[problem, n, method] = row
        print(problem, n, method, row["error"], row["seconds"], flush=True)


def ladder(rows, problem, method):
    """(seconds, error, n) by grid."""
    found = [rows.get((problem, n, method)) for n in GRIDS[problem]]
    return [(float(r["seconds"]), float(r["error"]), int(r["n"])) for r in found if r]


def at(points, seconds):
    """The error at that time, and whether it lies beyond the grids measured."""
    if seconds <= points[0][0]:
        return points[0][1], seconds < points[0][0]
    for (t0, e0, _), (t1, e1, _) in zip(points, points[1:]):
        if t0 <= seconds <= t1:
            return e0 * (seconds / t0)**(math.log(e1 / e0) / math.log(t1 / t0)), False
    return points[-1][1], True


def read(folder):
    return {(row["problem"], int(row["n"]), row["method"]): row for row in run.read(os.path.join(folder, "solid.csv"))}


def table(results):
    """The comparison at the grid of the tables, on that grid and at equal time, and the shares at equal time on all grids."""
    rows, lines = read(results.folder if os.path.exists(os.path.join(results.folder, "solid.csv")) else problems.DATA), []
    for problem in GRIDS:
        n = PROBLEMS[problem].common
        cell = {method: rows[problem, n, method] for method in METHODS}
        step = {method: float(row["seconds"]) / int(row["steps"]) for method, row in cell.items()}
        shares = {}
        for method in ("solid", "solid 3"):
            found = ((k, *at(ladder(rows, problem, method), t), e) for t, e, k in ladder(rows, problem, "balanced"))
            shares[method] = {k: f"{error / e:.2f}" + ("*" if beyond else "") for k, error, beyond, e in found}
        lines.append([f"{problem} {n}", *(f"{step[method] / step['balanced']:.2f}" for method in shares), *(f"{float(row['error']):.2g}" for row in cell.values()),
                      *(shares[method][n] for method in shares), ", ".join(shares["solid"].values())])
    return markdown(["problem", "time of a step", "3 x 3", "error of balanced", "of solid", "3 x 3", "share at equal time", "3 x 3", "share on all grids, from coarse to fine"], lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pebble", default=os.path.join(run.ROOT, "pebble"))
    parser.add_argument("--data", default=problems.DATA)
    parser.add_argument("--out", default=os.path.join(run.ROOT, "output", "studies"))
    parser.add_argument("--problems", nargs="+", choices=GRIDS, default=list(GRIDS))
    parser.add_argument("--again", action="store_true")
    parser.add_argument("--turns", type=int, default=5)
    parser.add_argument("--jobs", help="as of the other studies; here one run at a time")
    arguments = parser.parse_args()
    rows = read(arguments.data)
    for problem in arguments.problems:
        for n in GRIDS[problem]:
            if arguments.again or any((problem, n, method) not in rows for method in METHODS):
                measure(arguments.pebble, arguments.out, problem, n, 2 if n == GRIDS[problem][-1] else arguments.turns, rows)
                run.write(os.path.join(arguments.data, "solid.csv"), COLUMNS, [rows[p, k, m] for p in GRIDS for k in GRIDS[p] for m in METHODS if (p, k, m) in rows])


if __name__ == "__main__":
    main()
