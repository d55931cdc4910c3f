"""The short model of docs/model.md: its limits are those that the page derives, and its constants are those of the page's
formulas and of docs/data/constants.csv. No time is judged here.

usage: test_short_model.py PEBBLE SOURCE MPIEXEC BUILD
"""

import math
import os
import random
import re
import subprocess
import sys
import tempfile
from types import SimpleNamespace

import check

(BUILD,) = check.arguments(__doc__, 1)
sys.path.insert(0, os.path.join(check.source, "tools", "report"))
import constants  # noqa: E402 (after the path)
import data  # noqa: E402
import short_model  # noqa: E402
from scenes import SCENES, write  # noqa: E402


def near(x, y, within=1e-9):
    return abs(x - y) <= within * abs(y)


# ---- The formulas, with constants of four orders of magnitude
draw = random.Random(24)
some = [
    short_model.Short(dim, *(10 ** draw.uniform(low, low + 4) for low in (-10, -7, -9, -8, -10)))
    for dim in (2, 3)
    for _ in range(50)
]
P = [2**k for k in range(21)]
check.that(all(s.speedup(1e6, 1) == 1 and s.pool(1) == 1 for s in some), "on one process both speed-ups are 1, exactly")
check.that(
    all(s.efficiency(1e4, p) > s.efficiency(1e4, 2 * p) for s in some for p in P),
    "weak efficiency falls with the processes",
)
check.that(
    all(s.speedup(1e6, p, i) < p / i for s in some for p in P[1:] for i in (1.0, 1.5))
    and all(near(s.speedup(1e40, 1024, 1.5), 1024 / 1.5, 1e-6) for s in some),
    "a speed-up is below P/i, which it tends to for large scenes",
)
for s in some:
    for B in (0.0, s.B):
        s.B = B
        most = s.most(1e9)
        check.fault(
            None
            if s.speedup(1e9, most) > max(s.speedup(1e9, 0.99 * most), s.speedup(1e9, 1.01 * most))
            else f"{s}: not fastest on {most}"
        )
        check.fault(None if B or near(most, math.log(2) * s.C * 1e9 / s.R, 1e-3) else f"{s}: fastest on {most}, not as (11)")
    s.B = 1e-8
for s in some:
    for e, p, i in ((0.8, 32, 1.0), (0.9, 32768, 1.05)):
        n = s.least(e, p, i)
        check.fault(
            None
            if near(s.efficiency(n, p, i), e, 1e-7)
            else f"{s}: {n} particles keep {s.efficiency(n, p, i)}, not {e}"
        )
        log, rest = s.L + s.R * math.log2(p), s.C * (1 / e - i)
        closed = ((s.B + math.sqrt(s.B**2 + 4 * rest * log)) / (2 * rest)) ** 2
        check.fault(None if s.dim == 3 or near(n, closed, 1e-7) else f"{s}: {n} particles, by (13) {closed}")
check.that(some[0].least(0.8, 32, 1.25) == math.inf, "no number of particles keeps an efficiency of 1/i")
check.that(
    all(s.pool(2) <= s.pool(3) <= s.pool(1e9) == s.C / s.M for s in some),
    "the speed-up of a pool grows to C/M, exactly",
)
check.that(
    all(near(s.pool(2 + s.bound()), s.bound()) and s.pool(2 + 0.99 * s.bound()) < s.bound() for s in some),
    "which 1 + C/M workers reach",
)

# ---- The constants, of usl in 2-D and 3-D and of usf, by the formulas of the page and as differences of the full model
args = SimpleNamespace(pebble=check.program, predictor=os.path.join(BUILD, "predict"))
# Numbers of a node in a step: its sums (mass, momentum, force), which usf makes in two phases, and its motions
# (velocity, acceleration; with usf the velocity before that).
numbers = {"box2d": ([5], 4), "box3d": ([7], 6), "disks": ([3, 2], 6)}
for name, (count, motions) in numbers.items():
    scene = constants.Scene(args, tempfile.mkdtemp(dir="."), name)
    m, q, s = scene.model, scene.per_cell, scene.short
    x = SimpleNamespace(**{k: v for k, v in m.numbers.items() if k.isalpha()})
    d, reach, tile, exchanges = m.dim, m.stencil - 1, m.tile, 2 * len(count)
    total = scene.one["particles"]
    nodes = [k for k, kind in m.phases.items() if kind == "nodes"]
    each = {k: r[2] for k, r in m.rates.items()}
    particle = sum(t / (q if k in nodes else 1) for k, t in each.items())
    check.that(near(m.short(q, total, scene.edge).C, particle, 1e-6), f"{name}: C is {particle:.6g}, the sum of the phases")
    latency = (
        exchanges * (x.exchange + (2**d - 1) * x.post)
        + len(nodes) * (x.message - x.post)
        + m.numbers["migration[1].call"]
        + m.numbers["migration[1].particle"] * short_model.NEAR
        + d * (x.message + x.post)
    )
    tiles = ((tile + reach) / tile) ** (d - 1)
    sides = 8 * sum(count) * tiles * x.kept + 8 * motions * (x.wire + x.copy)
    face = d * (reach / q ** (1 - 1 / d) * sides + m.numbers["migration[1].leaver"])
    dealt = dict(word.split("=") for word in m.ask(("dealt", total, total / q, scene.edge))[0])
    jobs, size = float(dealt.pop("jobs")), sum(map(float, dealt.values()))
    alone = sum(total * t / (q if k in nodes else 1) for k, t in each.items() if k in (*nodes, "SORT"))
    master = (alone + jobs * (x.job + x.message) + size * (x.pool + x.wire)) / total
    kept = data.constants(name)
    check.that(near(s.C * total, scene.one["seconds_per_step"]), f"{name}: C N is the measured step on one process")
    for letter, ours, formula in (("L", s.L, latency), ("B", s.B, face), ("R", s.R, x.reduction), ("M", s.M, master), ("C", s.C, s.C)):
        check.that(near(ours, formula, 1e-6), f"{name}: {letter} {ours:.6g} is {formula:.6g} by its formula")
        check.that(near(ours, kept[letter], 1e-3), f"{name}: {letter} {ours:.6g} is {kept[letter]} in docs/data/constants.csv")
    said = scene.said(write(os.getcwd(), name, SCENES[name].strong), "direct", scene.edge)
    check.that(near(said["rows"][1]["spatial"], s.C * total, 0.02), f"{name}: the full model has the measured step on one process")
    check.that(abs(s.bound() / said["bound"] - 1) < 0.05, f"{name}: the bound of the pool is {s.bound():.3f}, by the program {said['bound']}")

# ---- The command
TOOL = [sys.executable, os.path.join(check.source, "tools", "report", "short_model.py")]
BOX = [
    write(os.getcwd(), "box2d", SCENES["box2d"].strong),
    os.path.join(check.source, "docs", "data", "models", "box2d.model"),
]


def command(*words, predictor=os.path.join(BUILD, "predict")):
    words = [*TOOL, *words, "--predictor", predictor]
    return subprocess.run(words, capture_output=True, text=True, timeout=check.TIMEOUT)


told = command(*BOX, "1e6")
shown = dict(re.findall(r"^([CLBRM]) (\S+) s ", told.stdout, re.M))
check.that(
    told.returncode == 0 and set(shown) == set("CLBRM") and all(float(v) > 0 for v in shown.values()),
    f"it prints five constants: {shown} {told.stderr}",
)
check.that(re.search(r"^ +1 +spatial S +1\.00 +E 1\.000 +pool S +1\.000$", told.stdout, re.M), "and the speed-ups")
for what, told in (
    ("no calibration", command(BOX[0], "no.model", "1e6")),
    ("no scene", command("no.opts", BOX[1], "1e6")),
    ("no predictor", command(*BOX, "1e6", predictor="no/predict")),
    ("no number of particles", command(*BOX)),
):
    said = told.stderr.strip().splitlines()
    check.that(
        told.returncode == 2 and "error: " in said[-1] and "Traceback" not in told.stderr, f"{what}: {said[-1:]}"
    )

check.end()
