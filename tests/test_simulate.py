"""The simulator, where `make simulate` has built it: the same bits as the real program; simulated time that is the same each
time, and counts what costs it is given.

usage: test_simulate.py PEBBLE SOURCE MPIEXEC
"""
import argparse
import shutil
import sys
from pathlib import Path

import check

check.arguments(__doc__, 0)
pebble, source = Path(check.program), Path(check.source)
sys.path.insert(0, str(source / "tools/simulate"))
import simulate  # noqa: E402

STEPS, RANKS = 5, 4
args = argparse.Namespace(simulator=source / "build/simulate/pebble", repeat=1)
simulate.WORK = Path.cwd()
if not shutil.which("smpirun"):
    print("skipped: no smpirun")
    sys.exit(77)
if max(f.stat().st_mtime for f in (source / "src").rglob("*.*")) > args.simulator.stat().st_mtime:
    print("skipped: the simulator is older than the sources; make simulate builds it anew")
    sys.exit(77)
costs = simulate.read_costs()["box2d"]
size = simulate.weak_size("box2d", RANKS)
scene = simulate.write_scene("box2d", size, STEPS)


def run(how="direct", ranks=RANKS, **other):
    return simulated(ranks, "injected", how, {**costs, **other})


def simulated(ranks, mode, migrate, costs):
    return simulate.simulated(args, scene, simulate.hosts(ranks), ranks, mode, "spatial", migrate, "cluster", costs)


digest = simulate.true_digest(pebble, scene)
first, again, alone, emulated = run(), run(), run(ranks=1), simulated(RANKS, "emulated", "direct", costs)
check.that(all(r["digest"] == digest for r in (first, again, alone, emulated, run("swarm"))), "the same bits as the real program")
check.that(first["seconds"] == again["seconds"], f"simulated times are equal: {first['seconds']} and {again['seconds']} s")
check.that(1 < RANKS * first["seconds"] / alone["seconds"] < 1.5, f"{alone['seconds']} s on one process, {first['seconds']} s on {RANKS}")
# A nanosecond more for each particle in P2G, which no message hides: every process waits for it.
more = run(P2G=costs["P2G"] + 1)["seconds"] - first["seconds"]
each = 1e-9 * first["particles"] / RANKS
check.that(abs(more / each - 1) < 0.02, f"{more} s more, expected {each}")
check.end()
