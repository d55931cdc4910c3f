"""Every table and every number that is marked in docs/report.md and docs/model.md is what docs/data say, and the sentences
that compare numbers are true of the data (tools/report). With falsified data or text each kind of them is found.

usage: test_report.py PEBBLE SOURCE MPIEXEC [made]

made: instead, making the report, which measures nothing, changes no file.
"""

import csv
import hashlib
import os
import re
import shutil
import subprocess
import sys

import check

words = check.arguments(__doc__, None)


def files(folder):
    """{path: hash of its content} of the documents and of their data."""
    out = {}
    for place, _, names in os.walk(folder):
        for name in names:
            with open(os.path.join(place, name), "rb") as f:
                out[os.path.relpath(os.path.join(place, name), folder)] = hashlib.sha256(f.read()).hexdigest()
    return out


if words:
    copy = check.folder("copy")
    for part in ("docs", "tools", "lab", "options"):
        shutil.copytree(os.path.join(check.source, part), os.path.join(copy, part), ignore=shutil.ignore_patterns("__pycache__"))
    before, tools = files(os.path.join(copy, "docs")), os.path.join(copy, "tools", "report")
    for command in (["constants.py", check.program], ["report.py"]):
        done = subprocess.run([sys.executable, os.path.join(tools, command[0]), *command[1:]], capture_output=True, text=True)
        check.that(done.returncode == 0, f"{command[0]} succeeds {done.stderr[-800:]}")
    after = files(os.path.join(copy, "docs"))
    changed = sorted(name for name in before | after if before.get(name) != after.get(name))
    check.that(not changed and len(before) > 80, f"making the report changes none of {len(before)} files: {changed}")
    check.end()

sys.path.insert(0, os.path.join(check.source, "tools", "report"))
import claims  # noqa: E402 (after the path)
import data  # noqa: E402
import report  # noqa: E402

DATA = data.FOLDER[0]
text = report.read("report.md")
faults = report.check()
check.that(not faults, f"the documents are what the data say {faults[:5]}")
for what, place in (("Table", r"^\|.*\n\| ---"), ("Figure", r"^!\[")):
    found = [int(n) for n in re.findall(rf"^\*\*{what} (\d+)\.\*\*", text, re.M)]
    check.that(found == list(range(1, len(re.findall(place, text, re.M)) + 1)), f"the captions of the {what.lower()}s are numbered in sequence: {found}")
check.that(len(claims.CLAIMS) > 30, f"{len(claims.CLAIMS)} sentences compare numbers")
for name, tables, numbers in (("report.md", 9, 40), ("model.md", 1, 4), ("performance.md", 3, 12)):
    found = len(report.marks.names(report.read(name))), report.read(name).count("<!-- number ")
    check.that(found[0] >= tables and found[1] >= numbers, f"docs/{name} has {found} tables and numbers from the data")


# ---- Falsified data
def false(what, file, column, value, **row):
    """Something whose text contains `what` is found once the column of the rows that have these values is another one."""
    folder = check.folder("data")
    shutil.copytree(DATA, folder, dirs_exist_ok=True)
    path = os.path.join(folder, file)
    with open(path, newline="") as f:
        rows = list(csv.DictReader(f))
    some = [r for r in rows if all(r[k] == str(v) for k, v in row.items())]
    check.need(some, f"{file} has no row with {row}")
    for r in some:
        r[column] = value
    with open(path, "w", newline="") as f:
        out = csv.DictWriter(f, rows[0])
        out.writeheader()
        out.writerows(rows)
    data.use(folder)
    faults = report.check()
    data.use(DATA)
    check.that(any(what in fault for fault in faults), f"{file} falsified, {len(faults)} faults are found, one of them of {what!r}")


runs, strong = "scaling/runs.csv", "simulated/strong.csv"
direct = dict(study="strong", strategy="spatial", migrate="direct")
measured, path = {"class": "measured"}, {"class": "critical path"}
false("faster than one process and than the pool", runs, "efficiency", "0.1", scene="disks", processes=2, **measured, **direct)
false("faster than one process and than the pool", strong, "efficiency", "0.01", scene="box3d", strategy="spatial", migrate="direct", mode="injected", ranks=8)
false("the pool took longer than one process", runs, "efficiency", "0.6", scene="dambreak", study="strong", strategy="pool", processes=2, **measured)
false("It was the same on all numbers", runs, "digest", "0123456789abcdef", scene="box2d", processes=8, **path, **direct)
false("its bytes grow with the number of cuts", runs, "bytes_per_particle_step", "1e4", scene="disks3d", processes=32, **path, **direct)
false("in every one of its tests", "simulated/validate.csv", "emulated", "1e-5", strategy="spatial", ranks=2, scene="disks")
false("had the bits of the real program", "simulated/strong-large.csv", "same_as_real", "no", scene="disks", ranks=64)
false("keep more than 0.8", "simulated/weak-large.csv", "efficiency", "0.7", scene="box3d", ranks=512)
false("bytes and reductions equal formulas", "scaling/counts.csv", "equal", "no", scene="box3d", strategy="pool", processes=8)
false("On one core it did", "scaling/users.csv", "predicted", "1", processes=1)
false("fewer on two, where bodies may move", "scaling/users.csv", "measured", "1", processes=1)
false("With linear functions", "ladders.csv", "error", "0.01", method="musl, flip", basis="linear", cells=64)
false("rises on 256", "ladders.csv", "error", "0.001", basis="cubic B-spline", cells=256)
false("only the dam break in 3-D", "scaling/lengths.csv", "seconds_per_step", "1", scene="box2d", processes=2, steps=400)
false("A plain serial program", "bench/seed.csv", "min_ns", "1", program="seed_serial")
false("the pool is ahead beyond", "constants.csv", "value", "1e-9", scene="box3d", constant="M")
false("DMSwarmMigrate was never faster", runs, "seconds_per_step", "1e-6", scene="disks", processes=32, study="strong", migrate="swarm", **path)
for column, scene in (("efficiency", "box2d"), ("efficiency", "disks3d")):  # a digit of a table or number
    false("| strong | ", strong, column, "0.9", scene=scene, strategy="spatial", migrate="direct", mode="injected", ranks=16)
false("11.8", "bench/seed.csv", "min_ns", "264.3", program="seed_serial", particles=99856)

try:
    data.use(check.folder("empty"))
    check.that(not report.check(), "without data nothing can be checked")
except OSError as missing:
    check.that(missing.filename.endswith(".csv"), f"missing data are named: {missing.filename}")
data.use(DATA)

# ---- Falsified text
numbers = report.tables.numbers()
for what, old, new in (
    ("has no sentence", "It was the same on all", "It was another one on all"),
    ("the data", "20 of 20", "19 of 20"),
):
    check.that(old in text and any(what in fault for fault in report.faults("report.md", text.replace(old, new), numbers)), f"{old!r} falsified: {what}")
check.end()
