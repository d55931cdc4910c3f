"""The sentences of docs/report.md that compare numbers, each with the condition that makes it true. `make report` and
the test `report` fail where one does not hold, or does not stand in the text. ... stands for numbers that are made."""

import re

import data
import tables
from data import BOXES, CLASSES, DIRECT, POOL, SCENES, SWARM, WAYS, find, rows
from tables import STUDIES, all_classes, interval, ladder, migration, predicted, speedups


def every(*kinds, how=DIRECT):
    """{(scene, study, class, processes): speed-up} on 2 to 32 processes."""
    some = {(s, study, kind): speedups(s, study, kind, how) for kind in kinds for study in STUDIES for s in SCENES}
    return {(*key, p): x for key, by in some.items() for p, x in by.items() if 1 < p <= 32}


def ratios(kind):
    """Measured efficiency over that of the class, spatial decomposition, large and small shares."""
    return [q for size in tables.SIZES.values() for q in interval(kind, size=size)]


def within(some):
    return sum(0.85 <= q <= 1.15 for q in some) / len(some)


CLAIMS = {
    "It was faster than one process and than the pool in every run of every scene on 2 to 32 processes, in every class of evidence.":
        lambda: (pool := every("measured", *CLASSES, how=POOL)) and all(x > max(1, pool.get(key, 0)) for key, x in every("measured", *CLASSES).items()),
    "On two processes the pool took longer than one process in every run": lambda: max(every("measured", how=POOL).values()) < 1,
    "Every figure for more processes is the answer of a model.": lambda: max(p for *_, p in every("measured")) == 2,
    "The critical path was the most exact where it could be tested":
        lambda: min(CLASSES, key=lambda kind: max(abs(q - 1) for q in ratios(kind))) == "critical path",
    "four tenths of the processors' time is the most that is lost there": lambda: min(map(min, all_classes(8).values())) > 0.595,
    "times in weak scaling, the least in a disturbed run,":
        lambda: 2 in tables.disturbed(min(SCENES, key=lambda s: speedups(s, "weak", "measured")[2]), "weak"),
    "but seven tenths of that time may be lost.": lambda: 0.25 < min(map(min, all_classes(32).values())) < 0.35,
    "Emulated simulation, which was too slow in every test, promises less.":
        lambda: all(q < e for p in (8, 32) for q, e in zip(all_classes(p)["emulated simulation"], all_classes(p)["injected simulation"])),
    "Emulated simulation was slower than the real run in every one of its tests":
        lambda: all(time < 1 for how, *_, time in data.pairs("emulated simulation") if how != POOL),
    "None of the others is a bound: each was too fast in some runs and too slow in others.":
        lambda: all(min(ratios(kind)) < 1 < max(ratios(kind)) for kind in CLASSES if kind != "emulated simulation"),
    "These are the scenes, the same for all classes of evidence": lambda: rows("scaling/scenes") == rows("simulated/scenes"),
    "With linear functions the error is larger on 64 cells than on 8":
        lambda: all(ladder(*key)[64] > ladder(*key)[8] for key in tables.LADDERS if key[1] == "linear"),
    "Quadratic splines with musl are best on 32 cells, with usl too.":
        lambda: all(min(by, key=by.get) == 32 for by in (ladder(*key) for key in tables.LADDERS if key[1] == "quadratic B-spline")),
    "The error of the default falls up to 128 cells and rises on 256.":
        lambda: (e := ladder(*tables.LADDERS[4])) and sorted(e, key=e.get, reverse=True) == [8, 16, 32, 256, 64, 128],
    "Only stretched GIMP, whose functions are averaged over domains that stretch with the particles, keeps the second order.":
        lambda: [basis for (_, basis), (*_, a, b) in ((key, ladder(*key).values()) for key in tables.LADDERS) if a / b > 3.6] == ["GIMP, stretched"],
    "The two agree from 1 024 processes on better than on few": 
        lambda: (off := [max(abs(by[p][0] / by[p][1] - 1) for by in tables.least().values()) for p in (2, 32, 1024)]) == sorted(off, reverse=True),
    "It was the same on all numbers of processes, with both migrations and with the pool, in each of ....":
        lambda: all(different == 1 for _, different in tables.digests()),
    "All simulated runs had the bits of the real program on one process.":
        lambda: all(r["same_as_real"] == "yes" for study in ("strong", "weak", "strong-large", "weak-large") for r in rows(f"simulated/{study}")),
    "only the dam break in 3-D lost more than a tenth of its efficiency":
        lambda: [s for s in SCENES if tables.lengths(400)[s] < 0.9 * tables.lengths(40)[s]] == ["dambreak3d"],
    "In every scene injected simulation and closed form promise more on 32 processes than the critical path":
        lambda: all(a > b for kind in CLASSES[1:3] for a, b in zip(all_classes(32)[kind], all_classes(32)["critical path"])),
    "The two balls, whose cuts are 32 slabs, have the lowest efficiency on 32 processes in every class.":
        lambda: all(min(e) == e[list(SCENES).index("disks3d")] for e in all_classes(32).values())
        and find(data.evidence("strong", "injected simulation"), "cut", scene="disks3d", way=DIRECT)[32] == "1x1x32",
    "So the classes differ by more on 32 processes than any of them did from the measurement on two":
        lambda: max(a / b for a, b in zip(*(all_classes(32)[kind] for kind in ("closed form", "emulated simulation"))))
        > max(max(q) / min(q) for q in map(interval, CLASSES)),
    "With 16 384 particles a process both boxes keep more than 0.8 up to 1 024 processes.":
        lambda: all(e > 0.8 for s in BOXES for e in data.efficiency(s, "weak-large", "injected simulation").values()),
    "With a million particles in all the efficiency on 1 024 processes is below 0.6":
        lambda: all(data.efficiency(s, "strong-large", "injected simulation")[1024] < 0.6 for s in (*BOXES, "disks")),
    "On 32 processes DMSwarmMigrate was never faster than `direct`":
        lambda: all(q > 0.998 for kind in ("critical path", "injected simulation") for q in migration(kind, 32).values()),
    "On two processes neither is ahead.": lambda: 0.95 < min(q := migration("measured", 2).values()) < 1 < max(q) < 1.05,
    "In 3-D on 32 processes, where whole tiles leave an imbalance, the pool is ahead beyond ... µs a particle and step.":
        lambda: 1e-6 < (tables.overtakes() or 1) < 1e-4 and tables.overtakes("box2d") is None,
    "so its bytes grow with the number of cuts; on up to 32 processes they stay below those of the pool":
        lambda: all(b < pool[p] for s in SCENES for direct, pool in [[find(data.evidence("strong", "critical path"), "bytes_per_particle_step", scene=s, way=how)
                                                                      for how in (DIRECT, POOL)]] for p, b in direct.items()),
    "all ... counted numbers of messages, bytes and reductions equal formulas": lambda: all(r["equal"] == "yes" for r in rows("scaling/counts")),
    "fewer on two, where bodies may move over the cuts": lambda: within(predicted()[1]) > within(predicted()[2]),
    "The program's own model is within 10 % of injected simulation in all runs of the filled boxes with direct migration. With DMSwarmMigrate it often is not":
        lambda: [all(0.9 <= q <= 1.1 for q in tables.against(how)) for how in WAYS] == [True, False, False],
    "the simulation has the steps of the other machine, which take longer (filled boxes: ... times as long)":
        lambda: float(tables.numbers()["c_simulated"].split()[0]) > 1,
    "None of the eight goals is met by all classes of evidence.": lambda: not any(all(map(good, sum(found.values(), []))) for found, good in tables.goals()),
    "On one core it did, within 15 % in ... whole runs; on two in fewer": lambda: within(predicted()[1]) >= 0.9 > within(predicted()[2]),
}  # fmt: skip


def wrong(text):
    """What is wrong with the claims, a line each."""
    plain = " ".join(re.sub(r"<!-- number \w+ -->[^<\n]*<!-- end -->", "...", text).split())
    for sentence, condition in CLAIMS.items():
        if sentence not in plain:
            yield f"docs/report.md has no sentence {sentence!r}"
        if not condition():
            yield f"what docs/report.md says is not true of the data: {sentence!r}"
