#!/usr/bin/env python3
"""Measures the starter problems (starters.py) with the default settings; renews docs/data/trust.csv and docs/trust.md.

    trust.py                         runs all on all grids: minutes; exit status 1 if a row is not as it has to be
    trust.py --only "sand column"    this alone (any number of names); --grids 1: on the first grid of each
    trust.py --page                  runs nothing, renews the page from the data; --check: only compares them
    trust.py --take FILE             the same with the rows of another run, which --data FILE wrote
    trust.py --scene "sand column"   prints the options file of its first grid

A row is wrong if the run stops, or if the number differs from the right one by more than the row allows, unless the run
printed the warning that the row names. starters.py lists what is wrong today; what is listed and right is an error too.
"""
import argparse
import concurrent.futures
import math
import os
import re
import resource
import shlex
import sys
import time

import h5py
import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.join(HERE, "..", "..")
sys.path[:0] = [HERE, os.path.join(ROOT, "tools", "studies"), os.path.join(ROOT, "tools")]
import marks  # noqa: E402 (after the path)
import run as studies  # noqa: E402
from starters import KNOWN, STARTERS  # noqa: E402

DATA, PAGE = (os.path.join(ROOT, "docs", *name) for name in (("data", "trust.csv"), ("trust.md",)))
COLUMNS = ["starter", "number", "n", "right", "got", "error", "limit", "status", "steps", "particles", "says"]


class Run(studies.Run):
    """A run of a starter, of which its numbers are read."""

    def __init__(self, pebble, folder, scene):
        words = shlex.split(scene)
        super().__init__(pebble, folder, [*words, "-report_limits", "false"], (0, 2, 3))
        self.dim, self.h = int(words[words.index("-dim") + 1]), float(words[words.index("-grid_h") + 1].split(",")[0])
        self.up = "xyz"[self.dim - 1]

    def column(self, name):
        """A column of the history."""
        return np.array(self.history(name))

    def particles(self, which, *fields):
        """Fields of the particles of a snapshot, in the order of their ids."""
        with h5py.File(self.path(".h5")) as file:
            steps = sorted((key for key in file if key.startswith("step_")), key=lambda key: file[key].attrs["time"])
            found = file[steps[which]]["particles"]
            order = np.argsort(found["id"][:])
            return [found[field][:][order] for field in fields]

    def says(self):
        """Its warnings, and why it stopped or was refused."""
        lines = re.findall(r"^(?:warning|stopped at step .*?:) +(.*)", self.said + self.err, re.M)
        return " | ".join(dict.fromkeys(lines)) or self.err.strip()[:200]


def measure(pebble, parent, name, n):
    """The rows of a starter on a grid."""
    starter, folder = STARTERS[name], studies.folder_of(parent, name, n)
    run = Run(pebble, folder, starter.scene(n))
    if starter.then and not run.status:
        before, run = run, Run(pebble, folder, f"{starter.scene(n)} {starter.then}")
        run.said = before.said + run.said
    rows = []
    for number in starter.numbers:
        steps = sum(map(int, re.findall(r"^done +(\d+) steps", run.said, re.M)))
        row = dict(starter=name, number=number.name, n=n, right=f"{number.right:.6g}", got="", error="",
                   limit=number.limits[starter.grids.index(n)], status=run.status, steps=steps,
                   particles=run.find(r" (\d+) particles"), says=run.says())
        if not run.status:
            try:
                got = float(number.get(run, n))
            except (ArithmeticError, LookupError, ValueError):  # of a run in which there is no such thing
                got = math.nan
            off = max(0, number.right - got) if number.least else abs(got - number.right)
            row |= dict(got=f"{got:.6g}", error=f"{off / (number.scale or abs(number.right)):.4g}")
        rows.append({key: str(value) for key, value in row.items()})
    run.done()
    return rows


def key_of(row):
    return row["starter"], row["number"], row["n"]


def wrong(row):
    """What is wrong with a row, or nothing."""
    if row["status"] != "0":
        return f"{'is refused' if row['status'] == '2' else 'stops'}: {row['says'].split(' | ')[-1]}"
    warns = STARTERS[row["starter"]].warns
    if float(row["error"]) <= float(row["limit"]) or warns and re.search(warns, row["says"]):
        return ""
    return f"is {row['got']}, right is {row['right']}: error {row['error']}, allowed {row['limit']}"


def known(row):
    """Why a row is wrong today, or nothing."""
    return KNOWN.get((row["starter"], row["number"], int(row["n"])), "")


def judge(row):
    """Whether a row is as it has to be, and a line about it."""
    fault, why, name = wrong(row), known(row), f"{row['starter']}, {row['n']} cells: {row['number']}"
    if fault:
        return bool(why), f"{name} {fault}{', known: ' + why if why else ''}"
    line = f"{name} {row['got']}, right {row['right']}, error {row['error']} <= {row['limit']}"
    return not why, line + (": it is right, take it out of WRONG in starters.py" if why else "")


def study(pebble, out, names, grids, jobs, say):
    """The rows of these starters on their first grids; say(good, line) of each. The longest runs begin first."""
    wanted = [(name, STARTERS[name].grids[k]) for k in reversed(range(grids)) for name in names]
    rows = {}
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        work = [pool.submit(measure, os.path.abspath(pebble), out, *key) for key in wanted]
        for job in concurrent.futures.as_completed(work):
            for row in job.result():
                rows[key_of(row)] = row
                say(*judge(row))
    return rows


def read(path=DATA):
    return {key_of(row): row for row in studies.read(path)}


def write(rows, path=DATA):
    """The rows that have a starter, in the order of the starters."""
    keys = [(name, number.name, str(n)) for name, s in STARTERS.items() for number in s.numbers for n in s.grids]
    studies.write(path, COLUMNS, [rows[key] for key in keys if key in rows])


# ---- The page

def percent(x):
    return "< 0.01" if 0 < x < 1e-4 else f"{100 * x:.2g}" if x < 0.995 else f"{100 * x:.0f}"


def cell(row):
    if row is None or row["status"] != "0":
        return "-" if row is None else "**stops**"
    error = float(row["error"])
    return percent(error) if error <= float(row["limit"]) else f"**{percent(error)}**"


def table(rows):
    lines = []
    for name, s in STARTERS.items():
        first = f"**{name}**: {s.about}", f"{', '.join(map(str, s.grids))} {s.cells}"
        for number in s.numbers:
            right = f"{'at least ' if number.least else ''}{number.right:.4g} {number.unit}".strip()
            right = f"{number.name}: {right} ({number.source})"
            mine = [cell(rows.get((name, number.name, str(n)))) for n in s.grids]
            lines.append([first[0], right, first[1], *mine, percent(number.limits[-1])])
            first = "", ""
    return marks.markdown(["problem", "number (source)", "cells", "error", "", "", "allowed"], lines)


def short(text):
    """A message without its time, its place, its numbers and its remedy."""
    text = re.sub(r"\([^()]*\)", "", re.sub(r"^seen at \S+ s: ", "", text))
    return re.split(r";|:|, near", re.sub(r"\s+", " ", text).replace(" ,", ","))[0].strip()


def remarks(rows):
    """What runs said, and what the default is not good for."""
    lines = []
    for name, s in STARTERS.items():
        texts = [text for key, row in rows.items() if key[0] == name for text in row["says"].split(" | ") if text]
        says = dict.fromkeys(map(short, texts))
        why = dict.fromkeys([s.note, *(why for key, why in KNOWN.items() if key[0] == name)])
        if says or any(why):
            lines.append([name, "; ".join(says), "; ".join(filter(None, why))])
    return marks.markdown(["problem", "what runs print", "what the default is not good for"], lines)


def page(check=False):
    """Renews the page, unless it is only to be compared; whether it was what the data say."""
    with open(PAGE) as file:
        old = new = file.read()
    rows = read()
    for name, block in ("trust", table(rows)), ("remarks", remarks(rows)):
        new = marks.renew(new, name, block)
    if new != old and not check:
        with open(PAGE, "w") as file:
            file.write(new)
    return new == old


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pebble", default=os.path.join(ROOT, "pebble"))
    parser.add_argument("--out", default=os.path.join(ROOT, "output", "trust"), help="folder of the runs")
    parser.add_argument("--data", default=DATA, help="the file of the rows")
    parser.add_argument("--only", nargs="+", choices=STARTERS, default=list(STARTERS), metavar="NAME")
    parser.add_argument("--grids", type=int, default=3, help="how many of the grids of each")
    parser.add_argument("--jobs", type=int, default=2, help="runs at a time")
    parser.add_argument("--page", action="store_true")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--take", metavar="FILE")
    parser.add_argument("--scene", choices=STARTERS, metavar="NAME")
    arguments = parser.parse_args()
    failed, start = 0, time.monotonic()

    def say(good, line):
        nonlocal failed
        failed += not good
        print(f"{'ok  ' if good else 'FAIL'} {time.monotonic() - start:5.0f} s  {line}", flush=True)
    if arguments.scene:
        starter = STARTERS[arguments.scene]
        print(re.sub(r" +(?=-[a-z])", "\n", starter.scene(starter.grids[0])).replace("'", '"'))
        return
    if arguments.take:
        write(read() | read(arguments.take))
    elif not arguments.page:
        rows = study(arguments.pebble, arguments.out, arguments.only, arguments.grids, arguments.jobs, say)
        write(read(arguments.data) | rows, arguments.data)
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        print(f"{len(rows)} numbers, {failed} not as they have to be, {used.ru_utime + used.ru_stime:.0f} s of a core")
    if arguments.data == DATA:
        same = page(arguments.check)
        what = "what the data say" if same else "not what the data say" if arguments.check else "renewed"
        print(f"docs/trust.md is {what}")
        failed += arguments.check and not same
    sys.exit(bool(failed))


if __name__ == "__main__":
    main()
