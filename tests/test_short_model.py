"""The short model of docs/model.md has the limits that the page derives. No time is judged here.

usage: test_short_model.py PEBBLE SOURCE MPIEXEC
"""

import math
import os
import random
import sys

import check

check.arguments(__doc__, 0)
sys.path.insert(0, os.path.join(check.source, "tools", "report"))
import short_model  # noqa: E402 (after the path)


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
    all(near(s.pool(2 + s.C / s.M), s.C / s.M) and s.pool(2 + 0.99 * s.C / s.M) < s.C / s.M for s in some),
    "which 1 + C/M workers reach",
)

check.end()
