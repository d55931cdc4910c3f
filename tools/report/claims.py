"""The claims of docs/report.md: every sentence of it that compares two numbers is a row here, with the data that it reads and a
condition. `make report` fails where a row does not hold, or where its sentence is not in the text.

A row is a function under @claim(sentence, data): it yields comparisons (of what, number, relation, number), all of which must hold.
In a sentence {name} stands for a number that the text has as <!-- number name -->.
"""

import operator
import re

from closed import BOXES, way
from data import Missing
from evidence import CLASSES
from goals import STEP
from words import inside, scene

RELATIONS = {"<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge, "==": operator.eq}
CLAIMS = {}


def claim(sentence, data):
    def add(condition):
        CLAIMS[condition.__name__] = (" ".join(sentence.split()), data, condition)
        return condition

    return add


def plain(text):
    """The text in one line, with {name} for each number that is made."""
    return " ".join(re.sub(r"<!-- number (\w+) -->[^<\n]*<!-- end -->", r"{\1}", text).split())


def fault(name, report, text=None):
    """What is wrong with a claim, or None."""
    sentence, data, condition = CLAIMS[name]
    if text is not None and sentence not in text:
        return f"claim {name}: docs/report.md has no sentence {sentence!r}"
    number = 0
    for number, (what, a, relation, b) in enumerate(condition(report), 1):
        if not RELATIONS[relation](a, b):
            return f"claim {name} does not hold ({data}): {what}: {a:.6g} {relation} {b:.6g} is false; the text says {sentence!r}"
    return None if number else f"claim {name} compares nothing ({data})"


def wrong(report, text=None):
    """What is wrong with the claims, a line each."""
    out, text = [], plain(text) if text is not None else None
    for name in CLAIMS:
        try:
            out.append(fault(name, report, text))
        except Missing as m:
            report.note(f"claim {name}", str(m))
    return [line for line in out if line]


# ---- First page
RUNS, SIMULATED = "docs/data/scaling/runs.csv", "docs/data/simulated/strong.csv"


@claim("It was faster than one process and than the pool in every run of every scene on 2 to 32 processes, measured, by the critical path and simulated",
       f"{RUNS}, docs/data/simulated/strong.csv and weak.csv")
def spatial_ahead(r):
    for study in ("strong", "weak"):
        for kind in ("measured", "critical path", "simulated"):
            for name in r.all_scenes():
                try:
                    spatial = r.efficiencies(name, study, kind=kind)
                except Missing:
                    continue
                for pool in ("pool", "workers"):
                    for p, e in r.efficiencies(name, study, pool, kind).items():
                        yield f"{scene(name)}, {study}, {kind}, {p} processes: speed-up over that of the pool", spatial[p] * p, ">", e * p
                for p in (p for p in spatial if 1 < p <= 32):
                    yield f"{scene(name)}, {study}, {kind}, {p} processes: speed-up", spatial[p] * p, ">", 1


@claim("Every figure for more processes is the answer of a model, and Table 2 says how well each model did where it could be tested, on two processes.", RUNS)
def measured_on_two(r):
    for row in r.real("strong") + r.real("weak"):
        if row["class"] == "measured":
            yield "processes of a measured run", row["processes"], "<=", 2


@claim("The critical path promised more than was measured in {path_above} runs of spatial decomposition, most of them by a few per cent.", RUNS)
def path_promises(r):
    some = [q["efficiency"] for q in r.pairs() if q["class"] == "critical path" and not q["pool"]]
    yield "runs in which the measured efficiency is less", sum(e < 1 for e in some), ">", len(some) / 2
    yield "of these, by at most 6 %", sum(0.94 <= e < 1 for e in some), ">", sum(e < 1 for e in some) / 2


@claim("Injected simulation was faster than the real run in {injected_below}.", "docs/data/simulated/validate.csv")
def injected_faster(r):
    some = [q["time"] for q in r.pairs() if q["class"] == "injected simulation" and not q["pool"]]
    yield "runs that it makes shorter", sum(t < 1 for t in some), ">", len(some) / 2


@claim("Emulated simulation has the widest interval for large scenes.", "docs/data/simulated/validate.csv, docs/data/scaling/runs.csv")
def emulated_widest(r):
    low, high, _ = r.interval("emulated simulation")
    for kind in CLASSES:
        if kind != "emulated simulation":
            a, b, _ = r.interval(kind)
            yield f"width beside {kind}", high / low, ">", b / a


# ---- Mathematics and serial program
ORDERS = "docs/data/choosing.csv"


@claim("With linear functions the error is larger on 64 cells than on 8:", ORDERS)
def linear_fails(r):
    for method in ("lin usf flip", "lin musl flip"):
        e = dict(r.ladders()[method])
        yield method, e[64], ">", e[8]


@claim("Quadratic splines with musl fail in the same way, but later: their error on 64 cells is three times that on 16.", ORDERS)
def quadratic_fails(r):
    e = dict(r.ladders()["bs2 musl flip"])
    yield "error on 64 over 16 cells", e[64] / e[16], ">", 2.5
    yield "error on 64 over 16 cells", e[64] / e[16], "<", 3.5
    yield "error on 16 and on 8 cells", e[16], "<", e[8]


@claim("With usl they stop converging at 64 cells.", ORDERS)
def quadratic_stops(r):
    orders = r.orders("bs2 usl flip")
    yield "last order", orders[-1], "<", 0.5
    yield "order before", orders[-2], ">", 0.5


@claim("The default still converges there, at first order and no longer at second.", ORDERS)
def default_converges(r):
    orders = r.orders("bs3 usl aflip 1")
    yield "last order", orders[-1], ">", 0.7
    yield "last order", orders[-1], "<", 1.5
    yield "order before", orders[-2], ">", 1.5


@claim("Of these methods only GIMP, whose functions are averaged over domains that stretch with the particles, has the second order on all grids.", ORDERS)
def gimp_second(r):
    for method in r.ladders():
        yield f"least order of {method}", min(r.orders(method)), ">=" if method == "gimpS usl flip" else "<", 1.95


@claim("A plain serial program without vectors takes {plain} times as long as pebble for the same work", "docs/data/bench/floor.csv")
def plain_slower(r):
    rows = [q for q in r.data.file("bench/floor.csv") if q["group"] == "seed" and q["update"] == "usf"]
    for n in {q["particles"] for q in rows}:
        a, b = r.least_ns(rows, n)
        yield f"ns a particle, {n} particles", a, ">", b


@claim("Two disks on 1024 x 1024 cells then have an imbalance (largest over mean number of particles) of {imbalance_now} on 32 processes, where equal boxes would have {equal_boxes}.",
       "docs/data/tiles.csv, pebble -dry_run")
def cuts_balance(r):
    yield "imbalance", r.balances()["disks, 1024 x 1024 cells"][32], "<", r.equal_boxes()


# ---- Model
@claim("With DMSwarmMigrate the efficiency on a million processes is less than half of that with direct migration.", "docs/data/models")
def swarm_far(r):
    for name in BOXES:
        yield scene(name), r.weak(name, 16384, 1000000, True), "<", r.weak(name, 16384, 1000000) / 2


@claim("The simulated boxes of Table 11 needed more particles than these cubes, since they are cut between tiles and wait for each other.", "docs/data/models, docs/data/simulated")
def boxes_need_more(r):
    for name in BOXES:
        yield f"{scene(name)}, 1024 processes", r.kept(name)[1024], ">", r.least_particles(name, 0.8, 1024)


# ---- Results
@claim("It was the same on all numbers of processes, with both migrations and with the pool, in each of {bits}.", RUNS)
def same_bits(r):
    for name, study, particles, _, _, different in r.digests():
        yield f"digests of {name}, {study}, {particles} particles", different, "==", 1


@claim("All simulated runs had the bits of the real program on one process.", "docs/data/simulated")
def simulated_bits(r):
    for name in ("strong", "weak", "strong-large", "weak-large"):
        rows = r.data.simulated(name)
        yield f"{name}: runs with the same bits", sum(q["same_as_real"] == "yes" for q in rows), "==", len(rows)


@claim("In every scene injected simulation promises more on 32 processes, {injected_32}, than the critical path, {path_32}.", f"{SIMULATED}, {RUNS}")
def injected_promises(r):
    for name in r.all_scenes():
        yield scene(name), r.efficiencies(name, "strong")[32], ">", r.efficiencies(name, "strong", kind="critical path")[32]


@claim("Emulated simulation is lowest of all there, {emulated_32}.", f"{SIMULATED}, {RUNS}")
def emulated_lowest(r):
    for name in r.all_scenes():
        emulated = r.efficiencies(name, "strong", mode="emulated")[32]
        for other in (r.efficiencies(name, "strong")[32], r.efficiencies(name, "strong", kind="critical path")[32]):
            yield scene(name), round(emulated, 2), "<=", round(other, 2)


@claim("The critical path of weak scaling of the box in 2-D is lower on 16 processes than on 32,", RUNS)
def disturbed(r):
    path = r.efficiencies("box2d", "weak", kind="critical path")
    yield "efficiency", path[16], "<", path[32]


@claim("The two balls, whose cuts are 32 slabs, have the lowest simulated efficiency on 32 processes:", SIMULATED)
def slabs_lowest(r):
    cut = next(q["cut"] for q in r.simulated("strong") if (q["scene"], q["ranks"], way(q)) == ("disks3d", 32, "spatial, direct"))
    yield "slabs", max(map(int, str(cut).split("x"))), "==", 32
    for name in r.all_scenes():
        if name != "disks3d":
            yield f"balls and {scene(name)}", r.efficiencies("disks3d", "strong")[32], "<", r.efficiencies(name, "strong")[32]


@claim("With 16 384 particles a process and direct migration both boxes keep more than 0.8 up to 1 024 processes.", "docs/data/simulated/weak-large.csv")
def weak_keeps(r):
    for name in BOXES:
        for p, e in r.efficiencies(name, "weak-large").items():
            yield f"{scene(name)}, {p} processes", e, ">", 0.8


@claim("With a million particles in all, on as many processes, a process has 1 024 of them, and the efficiency is below 0.6.", "docs/data/simulated/strong-large.csv")
def strong_falls(r):
    for name in BOXES:
        yield scene(name), r.efficiencies(name, "strong-large")[1024], "<", 0.6


@claim("On 32 processes a step with DMSwarmMigrate was never shorter than one with `direct`, and in the two disks it took half as long again in the simulation.",
       f"{SIMULATED}, {RUNS}")
def swarm_longer(r):
    for (name, kind, p), ratio in r.ratios_of_migration().items():
        if p == 32:
            yield f"{scene(name)}, {kind}", ratio, ">=", 0.999
    yield "two disks", r.ratios_of_migration()["disks", "simulated", 32], ">", 1.4
    yield "two disks", r.ratios_of_migration()["disks", "simulated", 32], "<", 1.75


@claim("In weak scaling the box in 2-D has an efficiency of {swarm_256} on 256 simulated processes with DMSwarmMigrate and of {direct_256} with `direct`.",
       "docs/data/simulated/weak-large.csv")
def swarm_weak(r):
    yield "efficiency", r.efficiencies("box2d", "weak-large", "spatial, DMSwarmMigrate")[256], "<", r.efficiencies("box2d", "weak-large")[256]


# ---- Pools
@claim("On two processes the pool took longer than one process in every run.", RUNS)
def pool_on_two(r):
    for study in ("strong", "weak"):
        for name in r.all_scenes():
            for kind in ("pool", "workers"):
                if e := r.efficiencies(name, study, kind, "measured").get(2):
                    yield f"speed-up of {scene(name)}, {study}, {kind}", 2 * e, "<", 1


@claim("a step took {workers_three} of one process's, where spatial decomposition took {spatial_three}, so that neither was ahead", "docs/data/workers.csv")
def three_alike(r):
    (a, b), (c, d) = r.three("workers"), r.three("spatial")
    yield "least of the pool and largest of spatial decomposition", a, "<", d
    yield "least of spatial decomposition and largest of the pool", c, "<", b


@claim("Spatial decomposition is ahead of both there, on every number of processes in Table 14.", "docs/data/models, pebble -dry_run")
def pools_behind(r):
    for name in r.all_scenes():
        found = r.best_pools(name)
        for kind in ("master", "workers"):
            for p in (2, 8, 32):
                yield f"{scene(name)}, {kind}, {p} processes", found[kind][p], "<", found["spatial"][p]


@claim("Where a box can be cut evenly the pool approaches spatial decomposition and does not pass it.", "docs/data/models")
def pool_approaches(r):
    m, whole = r.closed("box2d"), r.whole("box2d")
    for p in (8, 32):
        for t in (1e-7, 1e-5, 1e-4):
            d = m.dearer(t)
            yield f"step of the 2-D box on {p} processes, law {t:g} s dearer", r.best_pool(d, whole, p), ">", r.spatial(d, "box2d", p)[0]


@claim("In 3-D on 32 processes, where whole tiles leave an imbalance, it passes {overtakes}.", "docs/data/models")
def pool_passes(r):
    yield "cost of the law in s (1: none)", r.overtakes() or 1, "<", 1e-3


# ---- Messages, balance, model
@claim("all {counts} counted numbers of messages, bytes and reductions equal formulas", "docs/data/scaling/counts.csv")
def counts_equal(r):
    yield "numbers that are equal", sum(q["equal"] == "yes" for q in r.counts()), "==", len(r.counts())


@claim("so its bytes grow with the number of cuts; on up to 32 processes they stay below those of the pool, which sends every particle.", RUNS)
def bytes_below(r):
    rows = [q for q in r.real("strong") if q["processes"] > 1 and q["class"] == "critical path"]
    pool = {q["scene"]: q["bytes_per_particle_step"] for q in rows if q["strategy"] == "pool"}
    for q in rows:
        if way(q) == "spatial, direct":
            yield f"{scene(q['scene'])}, {q['processes']} processes", q["bytes_per_particle_step"], "<", pool[q["scene"]]


@claim("Before sums were made by tiles, the two disks had an imbalance of {imbalance_before} on 32 processes; now it is {imbalance_now}.", "docs/data/tiles.csv, pebble -dry_run")
def tiles_cost(r):
    yield "imbalance", float(r.number_imbalance_before()), "<", r.balances()["disks, 1024 x 1024 cells"][32]


@claim("the critical path on 32 processes became {tiles_gain} times shorter in three scenes when the change was made", "docs/data/tiles.csv")
def tiles_gain(r):
    rows = [q for q in r.tiles() if q["after"]]
    yield "scenes", len(rows), "==", 3
    for q in rows:
        yield q["scene"], q["after"], "<", q["before"]


@claim("All first steps of the 16 scenes of `options/`, on one process and on two, are within 15 %, from {short_span}.", "docs/data/scaling/validation.csv")
def short_runs_inside(r):
    some = r.short_runs()
    yield "scenes and numbers of processes", len(some), "==", 32
    yield "within 15 %", inside(some, *STEP), "==", len(some)


@claim("Fewer whole runs of the same scenes are within 15 %: 23 and 20 of 32 in two series.", "docs/data/scaling/users.csv")
def whole_runs_inside(r):
    for (found, of, _), n in zip(r.users(), (23, 20)):
        yield "inside", found, "==", n
        yield "of", of, "==", 32
        yield "inside, beside short runs", found, "<", inside(r.short_runs(), *STEP)
    yield "series", len(r.users()), "==", 2


@claim("With DMSwarmMigrate and in the pool the formulas are too slow.", "docs/data/simulated")
def formulas_slow(r):
    for which in ("spatial, DMSwarmMigrate", "pool"):
        some = r.against(which)
        yield f"{which}: runs in which they are slower by more than 10 %", sum(q > 1.1 for q in some), ">", sum(q < 0.9 for q in some)


@claim("On 4 to 32 processes the closed form was faster than the critical path in every run of spatial decomposition, {many_span} of it,", RUNS)
def closed_faster(r):
    for q in r.path_ratios():
        yield f"{scene(q['scene'])}, {q['study']}, {q['processes']} processes", q["ratio"], "<", 1


@claim("On two quiet cores it did, within 15 %.", "docs/data/scaling/validation.csv")
def model_right(r):
    some = r.short_runs()
    yield "within 15 %", inside(some, *STEP), "==", len(some)
