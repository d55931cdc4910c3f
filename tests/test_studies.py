"""The studies of methods (tools/studies): the documents are what their data say, regret and cost are what they are meant to
be, and the program still gives the errors of the data.

usage: test_studies.py PEBBLE SOURCE MPIEXEC
"""
import csv
import os
import subprocess
import sys

import check

check.arguments(__doc__, 0)
STUDIES = os.path.join(check.source, "tools", "studies")
sys.path[:0] = [os.path.join(check.source, "tools"), STUDIES]
import problems  # noqa: E402 (after the path)
import tables  # noqa: E402
from methods import METHODS, REFERENCE, Method  # noqa: E402
from problems import DATA, MAIN, PROBLEMS  # noqa: E402


def tool(name, *arguments):
    done = subprocess.run([sys.executable, os.path.join(STUDIES, name), *map(str, arguments)], capture_output=True, text=True, timeout=check.TIMEOUT)
    return done.returncode, done.stdout + done.stderr


# ---- Documents
status, said = tool("studies.py", "--check")
check.that(status == 0, f"documents and data: {said.strip()}")

# ---- Regret on errors that are known: C (cost)^(-2/3) for each method, steps n, particles n^2, all methods of the same
# speed but one, which takes 8 times as long for the same errors: at equal cost its error is 8^(2/3) = 4 times as large.
folder = "made_up"
os.makedirs(folder, exist_ok=True)
added = {"slow": Method("-slow", stable=True), "bad": Method("-bad", stable=False), "good but unstable": Method("-wild", stable=False)}
size = {REFERENCE: 1, "slow": 1, "bad": 3, "good but unstable": 0.5}
with open(os.path.join(folder, "choosing.csv"), "w", newline="") as file:
    out = csv.writer(file)
    out.writerow("problem method options ppc cfl n status error steps particles why".split())
    for name, factor in size.items():
        for p in MAIN:
            for n in PROBLEMS[p].levels:
                stops = name == "bad" and p == "shear" and n == PROBLEMS[p].common
                out.writerow([p, name, (METHODS | added)[name].options, 2, 0.4, n, 3 if stops else 0, 100 * factor * PROBLEMS[p].floor * (PROBLEMS[p].common / n)**2, n, n * n, ""])
with open(os.path.join(folder, "method_cost.csv"), "w") as file:
    file.write("dim,method,options,ns,ratio,particles,bytes\n" + "".join(f"{dim},{name},x,1,{8 if name == 'slow' else 1},1,1\n" for dim in (2, 3) for name in size))
made_up = tables.Results(folder, added)
slow, bad, wild = (made_up.regret(name) for name in added)
check.that(all(abs(slow[p] - 4) < 1e-9 for p in MAIN), f"8 times as slow: regret {slow}")
check.that(abs(tables.summary(made_up.regret("slow", "level"))[0] - 1) < 1e-12, "at equal grids its regret is 1")
check.that(all(abs(bad[p] - 3) < 1e-9 for p in MAIN if p != "shear") and bad["shear"] == tables.INF, f"errors 3 times as large, and a run that stops: {bad}")
check.that(all(value == 1 for value in wild.values()), f"better than the best with margin: {wild}")
check.that(tables.summary(bad) == (tables.INF, tables.INF), "a method that stops has no mean")
reach = [made_up.to_reach(REFERENCE, "mms", 0.4 / k) / made_up.cost(REFERENCE, "mms", 16) for k in (1, 4, 8, 64)]
check.that(abs(reach[0] - 1) < 1e-9 and abs(reach[1] - 8) < 1e-9 and abs(reach[2] - 8**1.5) < 1e-9 and reach[3] == tables.INF, f"cost to reach an error: {reach}")

# ---- The step of a method that ends with `own` is the program's
problems.plain("drop", "plain.opts", problems.METHOD)
for name in (name for name in METHODS if name.endswith(" own")):
    told = check.pebble("-options_file", "plain.opts", "-dry_run", *METHODS[name].options.split()).find(r"= (\S+) h/\(c\+")
    check.that(told == f"{METHODS[name].cfl:g}", f"{name}: -dt_cfl {METHODS[name].cfl:g}, the program's {told}")

# ---- The program and the data
status, said = tool("run.py", "--pebble", check.program, "--problems", "bar", "barx", "--methods", "gimpS usl flip", "--data", "own", "--out", "runs", "--common")
check.that(status == 0, f"run.py: exit status {status}")
if status:
    print(said)
own, kept = tables.Results("own"), tables.Results(DATA)
for p in "bar", "barx":
    mine, theirs = (results.error("gimpS usl flip", p, PROBLEMS[p].common) for results in (own, kept))
    check.that(mine and theirs and abs(mine / theirs - 1) < 0.01, f"{p}: error {mine}, in docs/data {theirs}")
again = tool("run.py", "--pebble", check.program, "--problems", "bar", "barx", "--methods", "gimpS usl flip", "--data", "own", "--out", "runs", "--common")[1]
check.that(again.startswith("0 runs"), f"a study that is complete makes no run: {again.splitlines()[:1]}")
check.end()
