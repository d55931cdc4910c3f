"""The sentences of docs/report.md that compare numbers, each with the condition that makes it true. `make report` and
the test `report` fail where one does not hold, or does not stand in the text. ... stands for numbers that are made."""

import re

import data
import tables
from data import BOXES, CLASSES, DIRECT, POOL, SCENES, SWARM
from tables import ladder, speedups

STUDIES, LARGE = ("strong", "weak"), ("strong", "weak", "strong-large", "weak-large")


def every(*kinds, how=DIRECT):
    """{(scene, study, class, processes): speed-up} on 2 to 32 processes."""
    return {(s, study, kind, p): x for kind in kinds for study in STUDIES for s in SCENES
            for p, x in speedups(s, study, kind, how).items() if 1 < p <= 32}  # fmt: skip


def ratios(kind):
    return [q for shares in tables.SHARES for q in tables.interval(kind, shares=shares)]


def off(kind):
    return max(abs(q - 1) for q in ratios(kind))


def path():
    return [q["efficiency"] for q in data.pairs("critical path") if q["way"] != POOL]


def lengths():
    """The scenes in which runs of 400 steps lose more than a tenth of the efficiency of those of 40."""
    t = {(r["scene"], r["processes"], r["steps"]): r["seconds_per_step"] for r in data.rows("scaling/lengths.csv")}
    return [s for s in SCENES if t[s, 1, 400] / t[s, 2, 400] * t[s, 2, 40] / t[s, 1, 40] < 0.9]


def slabs():
    cuts = {r["cut"] for r in data.simulations("strong", "injected simulation") if (r["scene"], r["ranks"], r["way"]) == ("disks3d", 32, DIRECT)}
    return all(max(map(int, str(cut).split("x"))) == 32 for cut in cuts)


def bytes_below():
    rows = data.runs("strong", "critical path")
    pool = {r["scene"]: r["bytes_per_particle_step"] for r in rows if r["way"] == POOL}
    return all(r["bytes_per_particle_step"] < pool[r["scene"]] for r in rows if r["way"] == DIRECT)


def least_off(processes):
    return max(abs(data.short(s).least(e, p) / n - 1) for s in BOXES for e in (0.8, 0.9) for p, n in data.kept(s, e).items() if p == processes)


def share(some):
    return sum(0.85 <= q <= 1.15 for q in some) / len(some)


def second_order():
    """The methods of Table 3 whose error falls by nearly four times on the last grid."""
    last = {key: list(ladder(*key).values())[-2:] for key in tables.LADDERS}
    return [basis for (_, basis), (a, b) in last.items() if a / b > 3.6]


CLAIMS = {
    "It was faster than one process and than the pool in every run of every scene on 2 to 32 processes, in every class of evidence.":
        lambda: (pool := every("measured", *CLASSES, how=POOL)) and all(x > max(1, pool.get(key, 0)) for key, x in every("measured", *CLASSES).items()),
    "On two processes the pool took longer than one process in every run.": lambda: max(every("measured", how=POOL).values()) < 1,
    "Every figure for more processes is the answer of a model.": lambda: max(p for *_, p in every("measured")) == 2,
    "The critical path was the most exact where it could be tested": lambda: min(CLASSES, key=off) == "critical path",
    "and its numbers are low: on 8 processes an efficiency of ..., on 32 of ....":
        lambda: all(min(tables.all_classes(p)["critical path"]) <= 0.005 + min(map(min, tables.all_classes(p).values())) for p in (8, 32)),
    "most of them by a few per cent": lambda: sum(e < 1 for e in path()) > len(path()) / 2 < 2 * sum(0.94 <= e < 1 for e in path()),
    "Emulated simulation was slower than the real run in every one of its tests":
        lambda: all(q["time"] < 1 for q in data.pairs("emulated simulation") if q["way"] != POOL),
    "None of the others is a bound: each was too fast in some runs and too slow in others.":
        lambda: all(min(ratios(kind)) < 1 < max(ratios(kind)) for kind in CLASSES if kind != "emulated simulation"),
    "These are the scenes, the same for all classes of evidence": lambda: data.rows("scaling/scenes.csv") == data.rows("simulated/scenes.csv"),
    "With linear functions the error is larger on 64 cells than on 8":
        lambda: all(ladder(*key)[64] > ladder(*key)[8] for key in tables.LADDERS if key[1] == "linear"),
    "Quadratic splines with musl are best on 32 cells, with usl too.":
        lambda: all(min(ladder(*key).items(), key=lambda e: e[1])[0] == 32 for key in tables.LADDERS if key[1] == "quadratic B-spline"),
    "The error of the default falls up to 128 cells and rises on 256.":
        lambda: [n for n, _ in sorted(ladder(*tables.LADDERS[4]).items(), key=lambda e: -e[1])] == [8, 16, 32, 256, 64, 128],
    "Only stretched GIMP, whose functions are averaged over domains that stretch with the particles, keeps the second order.":
        lambda: second_order() == ["GIMP, stretched"],
    "A plain serial program without vectors takes ... times as long as pebble for the same work": lambda: min(tables.plain()) > 1,
    "The two agree from 1 024 processes on better than on few": lambda: least_off(2) > least_off(32) > least_off(1024),
    "On a million processes the efficiency with DMSwarmMigrate is at most half of that with direct migration":
        lambda: all(2 * tables.cubes(s, "swarm", 2**20) < tables.cubes(s, "direct", 2**20) for s in BOXES),
    "It was the same on all numbers of processes, with both migrations and with the pool, in each of ....":
        lambda: all(different == 1 for _, different in tables.digests()),
    "All simulated runs had the bits of the real program on one process.":
        lambda: all(r["same_as_real"] == "yes" for study in LARGE for r in data.rows(f"simulated/{study}.csv")),
    "only the dam break in 3-D lost more than a tenth of its efficiency": lambda: lengths() == ["dambreak3d"],
    "In every scene injected simulation and closed form promise more on 32 processes than the critical path":
        lambda: all(a > b for kind in CLASSES[1:3] for a, b in zip(tables.all_classes(32)[kind], tables.all_classes(32)["critical path"])),
    "The two balls, whose cuts are 32 slabs, have the lowest efficiency on 32 processes in every class.":
        lambda: slabs() and all(min(e) == e[list(SCENES).index("disks3d")] for e in tables.all_classes(32).values()),
    "So the classes differ by more on 32 processes than any of them did from the measurement on two":
        lambda: max(a / b for a, b in zip(*(tables.all_classes(32)[kind] for kind in ("closed form", "emulated simulation"))))
        > max(max(q) / min(q) for q in map(tables.interval, CLASSES)),
    "With 16 384 particles a process both boxes keep more than 0.8 up to 1 024 processes.":
        lambda: all(e > 0.8 for s in BOXES for e in data.efficiency(s, "weak-large", "injected simulation").values()),
    "With a million particles in all the efficiency on 1 024 processes is below 0.6":
        lambda: all(data.efficiency(s, "strong-large", "injected simulation")[1024] < 0.6 for s in (*BOXES, "disks")),
    "On 32 processes DMSwarmMigrate was never faster than `direct`": lambda: all(min(q) > 0.998 for (_, p), q in tables.migration().items() if p == 32),
    "On two it was faster in two of six measured runs, and with the two balls on 8 by the critical path.":
        lambda: sorted(q < 1 for q in tables.migration()["measured", 2]) == [False] * 4 + [True] * 2 and min(tables.migration()["critical path", 8]) < 1,
    "In 3-D on 32 processes, where whole tiles leave an imbalance, the pool is ahead beyond ... µs a particle and step.":
        lambda: 1e-6 < (tables.overtakes() or 1) < 1e-4 and tables.overtakes("box2d") is None,
    "so its bytes grow with the number of cuts; on up to 32 processes they stay below those of the pool": bytes_below,
    "all ... counted numbers of messages, bytes and reductions equal formulas": lambda: all(r["equal"] == "yes" for r in data.rows("scaling/counts.csv")),
    "Of whole runs, as users start them, a smaller share is within 15 %":
        lambda: share(tables.predicted()[0]) > share(sum(tables.predicted()[1].values(), [])) and share(tables.predicted()[1][1]) > share(tables.predicted()[1][2]),
    "The program's own model is within 10 % of injected simulation in all runs of the filled boxes with direct migration":
        lambda: [all(0.9 <= q <= 1.1 for q in tables.against(how)) for how in (DIRECT, SWARM)] == [True, False],
    "On two quiet cores it did, within 15 % in ... short runs.": lambda: share(tables.predicted()[0]) >= 0.9,
}  # fmt: skip


def wrong(text):
    """What is wrong with the claims, a line each."""
    plain = " ".join(re.sub(r"<!-- number \w+ -->[^<\n]*<!-- end -->", "...", text).split())
    for sentence, condition in CLAIMS.items():
        if sentence not in plain:
            yield f"docs/report.md has no sentence {sentence!r}"
        if not condition():
            yield f"what docs/report.md says is not true of the data: {sentence!r}"
