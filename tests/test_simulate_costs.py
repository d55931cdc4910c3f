"""The costs that simulated runs get where processes share a memory: their arithmetic, and that short runs find them.
The simulator is not needed, and no time is judged.

usage: test_simulate_costs.py PEBBLE SOURCE MPIEXEC
"""

import argparse
import os
import sys
from pathlib import Path

import check

check.arguments(__doc__, 0)
sys.path.insert(0, os.path.join(check.source, "tools", "simulate"))
import simulate  # noqa: E402 (after the path)

# ---- Of copies that run at once, each phase counts with its longest time; of the repetitions the least of these.
copies = [
    {"seconds": 3.0, "digest": "a", "phases": {"P2G": 10.0, "G2P": 7.0}},
    {"seconds": 4.0, "digest": "b", "phases": {"P2G": 8.0, "G2P": 9.0}},
]
check.that(
    simulate.slowest(copies) == {"seconds": 4.0, "digest": "b", "phases": {"P2G": 10.0, "G2P": 9.0}},
    "the slowest copy counts",
)
check.that(simulate.slowest(copies[:1]) == copies[0], "a single one is what it was")
again = [[{**copies[0], "seconds": 5.0, "phases": {"P2G": 9.5, "G2P": 9.5}}], copies]
turns, simulate_real = iter(again), simulate.real
simulate.real = lambda args, path, **way: next(turns)
(best,) = simulate.in_turns(argparse.Namespace(calibrations=2), "path", [{"copies": 2}])
check.that(
    best["phases"] == {"P2G": 9.5, "G2P": 9.0} and best["seconds"] == 4.0, f"the least of the slowest counts: {best}"
)
simulate.real = simulate_real

# ---- Factors, and what a run gets of them
factors = simulate.memory_factors(
    {"P2G": 10.0, "G2P": 8.0, "SORT": 2.0, "ADVANCE": 0.0}, {"P2G": 12.0, "G2P": 7.6, "ADVANCE": 1.0}
)
check.that(
    factors == {"P2G": 1.2, "G2P": 1.0}, f"factors are ratios, of phases that both have, and at least 1: {factors}"
)
costs = {"P2G": 10.0, "G2P": 8.0, "JOB": 500.0}
check.that(simulate.sharing(costs, factors, 1, 2) == costs, "one process has its memory for itself")
check.that(
    simulate.sharing(costs, factors, 2, 2) == {"P2G": 12.0, "G2P": 8.0, "JOB": 500.0},
    "two share it; a cost without a factor stays",
)
check.that(
    abs(simulate.sharing(costs, factors, 2, 3)["P2G"] - 11) < 1e-12, "of three the second adds half of what both add"
)
check.that(
    simulate.sharing(costs, factors, 9, 2) == simulate.sharing(costs, factors, 2, 2),
    "more processes than there are cores add nothing",
)
check.that(simulate.sharing(costs, {}, 2, 1) == costs, "a machine of one core has no factors")

# ---- Runs of this machine
simulate.WORK, simulate.MEMORY, simulate.BUSY_SECONDS = Path.cwd(), Path.cwd() / "memory.csv", 0.01
simulate.BUSY = {"copies": 2}
args = argparse.Namespace(pebble=Path(check.program), calibrations=2)
for _ in range(2):  # a second measurement takes the place of the first
    found = simulate.measure_memory(args, "box2d", (16, 16), 1e-4)
rows = simulate.read_rows(simulate.MEMORY)
check.that(
    {"P2G", "ADVANCE", "G2P"} <= set(found) and all(f >= 1 for f in found.values()), f"factors of a scene: {found}"
)
check.that(
    [(row["name"], row["factor"], row["processes"], row["particles"]) for row in rows]
    == [(k, f"{f:.3f}", "2", "1024") for k, f in found.items()],
    "which are in memory.csv, once",
)

check.end()
