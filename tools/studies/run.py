#!/usr/bin/env python3
"""Measures methods on problems: errors into docs/data/choosing.csv, the time of a step into docs/data/method_cost.csv.

    run.py                                   what is missing of all methods (methods.py) on all problems (problems.py)
    run.py --methods "bs2 usl flip" ...      of these alone; --problems bar mms: on these alone
    run.py --add "NAME=OPTIONS" ...          of a candidate that methods.py does not have; NAME:0.3=OPTIONS with -dt_cfl 0.3,
                                             NAME:own=OPTIONS with what the program takes for the method
    run.py --varied                          what is missing of more particles per cell, smaller steps, and the presets;
                                             --methods balanced: of this preset alone
    run.py --motion                          spinning bodies and a drifting bar (motion.py), into docs/data/motion.csv
    run.py --cost                            the time of a step of methods that have none yet (one run at a time, in turns)
    run.py --table                           prints errors and regret beside the methods with margin

Runs that are there are not repeated (--again: they are), so a study that was stopped goes on. Errors do not depend on the
load of the machine; so two runs go at a time (--jobs). With --pebble another program can be tried: give --data another
folder then, since rows are known by problem, method, options, grid, particles per cell and -dt_cfl.
"""
import argparse
import concurrent.futures
import csv
import os
import re
import resource
import shutil
import subprocess
import sys
import threading
import time

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.join(HERE, "..", "..")
sys.path[:0] = [os.path.join(ROOT, "lab"), os.path.join(ROOT, "tools"), HERE]
import motion  # noqa: E402 (after the path)
import pebble_mpm as pebble  # noqa: E402
import problems  # noqa: E402
from methods import METHODS, PRESETS, REFERENCE, TOTAL, VARIANTS, VARIED, Method, own_cfl  # noqa: E402
from problems import MAIN, PROBLEMS  # noqa: E402

KEY = ["problem", "method", "options", "ppc", "cfl", "n"]
COLUMNS = [*KEY, "status", "error", "steps", "particles", "why"]
KEY_MOTION = motion.KEY
COST = ["dim", "method", "options", "ns", "ratio", "particles", "bytes"]
LIMIT = 900  # s; a run that takes longer counts as stopped


def folder_of(parent, *name):
    """A new folder for the files of a run."""
    path = os.path.join(parent, re.sub(r"[^\w.]", "_", "_".join(map(str, name))))
    shutil.rmtree(path, ignore_errors=True)
    os.makedirs(path)
    return path


class Run:
    """One run and its files, in a folder of its own: pebble_mpm's result, and what the studies ask of it."""

    def __init__(self, program, folder, arguments, allowed=(0, 3)):
        try:
            self.result = pebble.run(arguments, folder=folder, program=program, timeout=LIMIT, check=False, output_name="run")
        except subprocess.TimeoutExpired:
            self.result = pebble.Result(folder, "run", 3, "", f"longer than {LIMIT} s")
        self.folder, self.path, self.number = folder, self.result.path, self.result.number
        self.status, self.said, self.err = self.result.status, self.result.out, self.result.err
        if self.status not in allowed:
            raise RuntimeError(f"exit status {self.status}: {' '.join(map(str, arguments))}\n{self.err.strip()[-800:]}")

    def find(self, pattern):
        return self.result.find(pattern) or ""

    def history(self, column):
        return self.result.history[column]

    def columns(self):
        return list(self.result.history)

    def done(self):
        shutil.rmtree(self.folder, ignore_errors=True)


def read(path):
    if not os.path.exists(path):
        return []
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def write(path, columns, rows):
    with open(path + ".new", "w", newline="") as file:
        out = csv.DictWriter(file, columns, lineterminator="\n")
        out.writeheader()
        out.writerows(rows)
    os.replace(path + ".new", path)


class Data:
    """The rows of a CSV file; what comes new is written at once, so that nothing is lost when the study is stopped."""

    def __init__(self, path, key, columns):
        self.path, self.key, self.columns, self.lock = path, key, columns, threading.Lock()
        known = [*PROBLEMS, *motion.CASES]  # what was measured of others is dropped
        self.rows = {tuple(row[name] for name in key): {column: row[column] for column in columns} for row in read(path) if row[key[0]] in known}

    def add(self, row):
        with self.lock:
            row = {column: str(row[column]) for column in self.columns}
            self.rows[tuple(row[name] for name in self.key)] = row
            self.write()

    def write(self):
        order = [*PROBLEMS, *motion.CASES]

        def place(row):
            return [order.index(row[name]) if name in ("problem", "case") else (0, float(row[name])) if re.match(r"[0-9.]+$", row[name]) else (1, row[name]) for name in self.key]
        write(self.path, self.columns, sorted(self.rows.values(), key=place))


def measure(program, parent, key):
    problem, method, options, ppc, cfl, n = key
    folder = folder_of(parent, problem, method, n, ppc, cfl)
    run = Run(program, folder, [*problems.options(problem, n, None if ppc == "preset" else ppc, folder), *options.split(), *(["-dt_cfl", cfl] if cfl != "preset" else [])])
    row = dict(zip(KEY, key), status=run.status, error="", steps=run.find(r"^done +(\d+) steps") or 0, particles=run.find(r" (\d+) particles") or 0, why=why(run))
    if run.status == 0:
        row["error"] = f"{PROBLEMS[problem].error(run):.6g}"
    run.done()
    return row


def measure_motion(program, parent, key):
    case, method, options, cfl = key
    folder = folder_of(parent, case, method, cfl)
    words = [*motion.CASES[case].split(), *options.split(), "-dt_cfl", cfl]
    if case in motion.SCENES:
        scene = os.path.join(folder, "scene.opts")
        problems.plain(motion.SCENES[case], scene, problems.METHOD)
        words = ["-options_file", scene, *words]
    run = Run(program, folder, words, (0, 2, 3))  # 2: gimp stretch refuses fluids
    row = dict(zip(KEY_MOTION, key), status=run.status) | (dict.fromkeys(motion.COLUMNS[5:], "") if run.status == 2 else motion.evaluate(case, run))
    row["why"] = why(run)
    run.done()
    return row


def why(run):
    """The reason of a run that was stopped."""
    return re.sub(r"\s+", " ", run.err.strip().splitlines()[-1] if run.err.strip() else "stopped")[:120] if run.status else ""


def study(arguments, data, wanted, measure, value):
    """Makes the runs that are not in data yet; returns how many could not be made."""
    wanted = [key for key in wanted if arguments.again or tuple(map(str, key)) not in data.rows]
    print(f"{len(wanted)} runs, {arguments.jobs} at a time", flush=True)
    start, failed = time.monotonic(), 0
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        jobs = {pool.submit(measure, arguments.pebble, arguments.out, key): key for key in wanted}
        for k, job in enumerate(concurrent.futures.as_completed(jobs)):
            key = jobs[job]
            try:
                row = job.result()
                data.add(row)
                told = f"stopped: {row['why']}" if row["status"] else value(row)
            except RuntimeError as wrong:
                failed, told = failed + 1, str(wrong)
            print(f"{k + 1:4} {time.monotonic() - start:6.0f} s  {key[0]:10} {key[1]:20} {key[4] if len(key) > 4 else ''!s:>4} {key[5] if len(key) > 5 else key[3]!s:>4}  {told}", flush=True)
    data.write()
    return failed


# ---- Time of a step

SCENES = {2: ("disks", "-grid_cells 160,160 -body_disk1_ppc 2,2 -body_disk2_ppc 2,2", 400), 3: ("disks3d", "-grid_cells 48,48,48", 60)}
TURNS = 5


def processor_time(program, folder, arguments):
    """Of one run, s, user and system. It counts no time in which other programs have the core."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    run = Run(program, folder, arguments)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return run, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def cost(arguments, methods):
    """ns per particle and step on a scene of each dimension without loads: processor time of a run less that of one without
    steps, the least of several turns. In each turn every method runs once, so that other work on the machine slows all
    alike; what is compared are ratios."""
    path = os.path.join(arguments.data, "method_cost.csv")
    old = {(row["dim"], row["method"]): row for row in read(path)}
    methods = {name: m for name, m in methods.items() if not any(m.options == METHODS[other].options for other in METHODS if other != name and f"{other} own" == name)}
    wanted = {name: m for name, m in methods.items() if arguments.again or any(old.get((str(dim), name), {}).get("options") != m.options for dim in SCENES)}
    if not wanted:
        print("0 methods")
        return
    wanted = {REFERENCE: METHODS[REFERENCE]} | wanted
    for dim, (scene, more, steps) in SCENES.items():
        best, told, folder = {}, {}, folder_of(arguments.out, "cost")
        problems.plain(scene, os.path.join(folder, "scene.opts"), problems.METHOD)
        for _ in range(TURNS):
            for name, m in wanted.items():
                words = ["-options_file", os.path.join(folder, "scene.opts"), *more.split(), *m.options.split(), "-output_format", "none", "-history_every", "1e9",
                         "-check_energy", "0", "-check_momentum", "0", "-report_limits", "false", "-time_max_steps"]
                start = processor_time(arguments.pebble, folder, [*words, "0"])[1]
                run, whole = processor_time(arguments.pebble, folder, [*words, str(steps)])
                told[name] = run.find(r" (\d+) particles"), run.find(r"^fields .* (\d+) B/particle")
                best[name] = min(best.get(name, float("inf")), (whole - start) / steps / int(told[name][0]) * 1e9)
        for name, m in wanted.items():
            old[str(dim), name] = dict(zip(COST, [str(dim), name, m.options, f"{best[name]:.4g}", f"{best[name] / best[REFERENCE]:.3f}", *told[name]]))
            print(f"{dim}-D {name:20} {best[name]:6.1f} ns, {best[name] / best[REFERENCE]:.3f} of {REFERENCE}", flush=True)
        write(path, COST, sorted(old.values(), key=lambda row: (row["dim"], row["method"])))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pebble", default=os.path.join(ROOT, "pebble"))
    parser.add_argument("--data", default=problems.DATA, help="folder of the CSV files")
    parser.add_argument("--out", default=os.path.join(ROOT, "output", "studies"), help="folder of the runs")
    parser.add_argument("--methods", nargs="+", metavar="NAME", help="default: all of methods.py, or with --add none of them")
    parser.add_argument("--add", nargs="+", metavar="NAME=OPTIONS", default=[])
    parser.add_argument("--problems", nargs="+", choices=PROBLEMS, default=list(PROBLEMS), metavar="NAME")
    parser.add_argument("--ppc", type=int, default=2)
    parser.add_argument("--cfl", type=float, help="default: the method's own")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--again", action="store_true")
    parser.add_argument("--common", action="store_true", help="only the grid of the tables of each problem")
    parser.add_argument("--varied", action="store_true")
    parser.add_argument("--cost", action="store_true")
    parser.add_argument("--motion", action="store_true")
    parser.add_argument("--table", action="store_true")
    arguments = parser.parse_args()
    for path in arguments.data, arguments.out:
        os.makedirs(path, exist_ok=True)
    added = {}
    for text in arguments.add:
        name, options = text.split("=", 1)
        name, _, cfl = name.partition(":")
        added[name] = Method(options, own_cfl(options) if cfl == "own" else float(cfl or 0.4))
    unknown = set(arguments.methods or []) - set(METHODS) - (set(PRESETS) if arguments.varied else set())
    if unknown:
        sys.exit(f"run.py: no method {', '.join(unknown)} in methods.py")
    methods = {name: METHODS[name] for name in arguments.methods or ([] if added else METHODS) if name in METHODS} | added
    failed = 0
    if arguments.cost:
        cost(arguments, methods | ({} if arguments.methods or added else TOTAL))
    elif arguments.motion:
        data = Data(os.path.join(arguments.data, "motion.csv"), KEY_MOTION, motion.COLUMNS)
        wanted = [(case, name, m.options, f"{cfl or m.cfl:g}") for case in motion.CASES for name, m in methods.items() for cfl in motion.STEPS.get(case, (arguments.cfl,))]
        failed = study(arguments, data, wanted, measure_motion, lambda row: ", ".join(f"{name} {row[name]}" for name in motion.COLUMNS[5:-1] if row[name]))
    elif not arguments.table:
        data = Data(os.path.join(arguments.data, "choosing.csv"), KEY, COLUMNS)
        if arguments.varied:
            cases = [(name, METHODS[name].options, ppc, f"{cfl or METHODS[name].cfl:g}") for name in VARIED for ppc, cfl in VARIANTS]
            cases = [(name, f"-method_preset {name}", "preset", "preset") for name in PRESETS] + cases
            wanted = [(p, *case, PROBLEMS[p].common) for case in cases if case[0] in (arguments.methods or [case[0]]) for p in MAIN]
        else:
            wanted = [(p, name, m.options, arguments.ppc, f"{arguments.cfl or m.cfl:g}", n) for name, m in methods.items() for p in arguments.problems for n in PROBLEMS[p].levels
                      if not arguments.common or n == PROBLEMS[p].common]
        failed = study(arguments, data, wanted, measure, lambda row: row["error"])
    if arguments.table or added:
        import tables  # noqa: E402 (it needs the data)
        print(tables.plain(tables.Results(arguments.data, added), list(methods)))
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
