"""The sentences of docs/report.md that compare numbers, each with the condition that makes it true. `make report` and
the test `report` fail where one does not hold, or does not stand in the text. ... stands for numbers that are made."""

import re

import data
import tables
from data import BOXES, CLASSES, DIRECT, POOL, SCENES, SWARM

CLAIMS = {}


def claim(sentence):
    def add(condition):
        CLAIMS[" ".join(sentence.split())] = condition
        return condition

    return add


def plain(text):
    """The text in one line, with ... for each number that is made."""
    return " ".join(re.sub(r"<!-- number \w+ -->[^<\n]*<!-- end -->", "...", text).split())


def wrong(text):
    """What is wrong with the claims, a line each."""
    text = plain(text)
    for sentence, condition in CLAIMS.items():
        if sentence not in text:
            yield f"docs/report.md has no sentence {sentence!r}"
        if not condition():
            yield f"what docs/report.md says is not true of the data: {sentence!r}"


def every(*kinds, how=DIRECT, studies=("strong", "weak")):
    """Each (scene, study, class, processes, speed-up) on 2 to 32 processes."""
    for kind in kinds:
        for study in studies:
            for s in SCENES:
                for p, x in tables.speedups(s, study, kind, how).items():
                    if 1 < p <= 32:
                        yield s, study, kind, p, x


@claim("It was faster than one process and than the pool in every run of every scene on 2 to 32 processes, in every class of evidence.")
def spatial_ahead():
    pool = {key[:4]: key[4] for key in every("measured", *CLASSES, how=POOL)}
    some = list(every("measured", *CLASSES))
    return len(some) > 100 and all(x > 1 and x > pool.get((s, *rest), 0) for s, *rest, x in some)


@claim("On two processes the pool took longer than one process in every run.")
def pool_on_two():
    return all(x < 1 for *_, x in every("measured", how=POOL))


@claim("Every figure for more processes is the answer of a model.")
def measured_on_two():
    return all(r["processes"] <= 2 for study in ("strong", "weak") for r in data.runs(study, "measured"))


@claim("The critical path was the most exact where it could be tested")
def path_most_exact():
    off = {kind: max(abs(q - 1) for shares in tables.SHARES for q in tables.interval(kind, shares=shares)) for kind in CLASSES}
    return min(off, key=off.get) == "critical path"


@claim("and its numbers are low: on 8 processes an efficiency of ..., on 32 of ....")
def path_lowest():
    some = {p: tables.all_classes(p) for p in (8, 32)}
    return all(min(some[p]["critical path"]) <= min(e for q in some[p].values() for e in q) + 0.005 for p in (8, 32))


@claim("most of them by a few per cent")
def path_promises():
    some = [q["efficiency"] for q in data.pairs("critical path") if q["way"] != POOL]
    return sum(e < 1 for e in some) > len(some) / 2 < 2 * sum(0.94 <= e < 1 for e in some)


@claim("Emulated simulation was slower than the real run in every one of its tests")
def emulated_slower():
    return all(q["time"] < 1 for q in data.pairs("emulated simulation") if q["way"] != POOL)


@claim("None of the others is a bound: each was too fast in some runs and too slow in others.")
def no_bounds():
    some = {kind: [q for shares in tables.SHARES for q in tables.interval(kind, shares=shares)] for kind in CLASSES if kind[0] != "e"}
    return all(min(q) < 1 < max(q) for q in some.values())


@claim("With linear functions the error is larger on 64 cells than on 8")
def linear_fails():
    return all((e := tables.ladder(m, "linear"))[64] > e[8] for m in ("usf, flip (the assignment)", "musl, flip"))


@claim("Quadratic splines with musl are best on 32 cells, with usl too.")
def quadratic_fails():
    return all(min(e := tables.ladder(m, "quadratic B-spline"), key=e.get) == 32 for m in ("musl, flip", "usl, aflip"))


@claim("The error of the default falls up to 128 cells and rises on 256.")
def default_stops():
    e = tables.ladder(*tables.LADDERS[4])
    return e[8] > e[16] > e[32] > e[64] > e[128] < e[256]


@claim("Only stretched GIMP, whose functions are averaged over domains that stretch with the particles, keeps the second order.")
def gimp_second():
    last = {key: list(tables.ladder(*key).values())[-2:] for key in tables.LADDERS}
    return all((a / b > 3.6) == (key[1] == "GIMP, stretched") for key, (a, b) in last.items())


@claim("A plain serial program without vectors takes ... times as long as pebble for the same work")
def plain_slower():
    return float(tables.serial()["plain"].split()[0]) > 1


@claim("On a million processes the efficiency with DMSwarmMigrate is at most half of that with direct migration")
def swarm_far():
    return all(tables.cubes(s, "swarm", 2**20) < 0.5 * tables.cubes(s, "direct", 2**20) for s in BOXES)


@claim("The two agree from 1 024 processes on better than on few")
def least_near():
    off = {p: max(abs(data.short(s).least(e, p) / n - 1) for s in BOXES for e in (0.8, 0.9) for q, n in data.kept(s, e).items() if q == p) for p in (2, 32, 1024)}
    return off[2] > off[32] > off[1024]


@claim("It was the same on all numbers of processes, with both migrations and with the pool, in each of ....")
def same_bits():
    return all(different == 1 for _, different in tables.digests())


@claim("All simulated runs had the bits of the real program on one process.")
def simulated_bits():
    return all(r["same_as_real"] == "yes" for study in ("strong", "weak", "strong-large", "weak-large") for r in data.rows(f"simulated/{study}.csv"))


@claim("only the dam break in 3-D lost more than a tenth of its efficiency")
def short_stand_for_long():
    t = {(r["scene"], r["processes"], r["steps"]): r["seconds_per_step"] for r in data.rows("scaling/lengths.csv")}
    kept = {s: t[s, 1, 400] / t[s, 2, 400] * t[s, 2, 40] / t[s, 1, 40] for s in SCENES}
    return [s for s, q in kept.items() if q < 0.9] == ["dambreak3d"]


@claim("In every scene injected simulation and closed form promise more on 32 processes than the critical path")
def injected_promises():
    e = tables.all_classes(32)
    return all(a > b for kind in ("injected simulation", "closed form") for a, b in zip(e[kind], e["critical path"]))


@claim("The two balls, whose cuts are 32 slabs, have the lowest efficiency on 32 processes in every class.")
def slabs_lowest():
    cut = next(r["cut"] for r in data.simulations("strong", "injected simulation") if (r["scene"], r["ranks"], r["way"]) == ("disks3d", 32, DIRECT))
    lowest = [min(e) == e[list(SCENES).index("disks3d")] for e in tables.all_classes(32).values()]
    return max(map(int, str(cut).split("x"))) == 32 and all(lowest)


@claim("With 16 384 particles a process both boxes keep more than 0.8 up to 1 024 processes.")
def weak_keeps():
    return all(e > 0.8 for s in BOXES for e in data.efficiency(s, "weak-large", "injected simulation").values())


@claim("With a million particles in all the efficiency on 1 024 processes is below 0.6")
def strong_falls():
    return all(data.efficiency(s, "strong-large", "injected simulation")[1024] < 0.6 for s in (*BOXES, "disks"))


@claim("On 32 processes DMSwarmMigrate was never faster than `direct`")
def swarm_longer():
    return all(min(q) > 0.998 for (_, p), q in tables.migration().items() if p == 32)


@claim("On two it was faster in two of six measured runs")
def swarm_on_two():
    return [q < 1 for q in tables.migration()["measured", 2]].count(True) == 2 and len(tables.migration()["measured", 2]) == 6


@claim("so its bytes grow with the number of cuts; on up to 32 processes they stay below those of the pool")
def bytes_below():
    rows = data.runs("strong", "critical path")
    pool = {r["scene"]: r["bytes_per_particle_step"] for r in rows if r["way"] == POOL}
    return all(r["bytes_per_particle_step"] < pool[r["scene"]] for r in rows if r["way"] == DIRECT)


@claim("all ... counted numbers of messages, bytes and reductions equal formulas")
def counts_equal():
    return all(r["equal"] == "yes" for r in data.rows("scaling/counts.csv"))


@claim("In 3-D on 32 processes, where whole tiles leave an imbalance, the pool is ahead beyond ... µs a particle and step.")
def pool_passes():
    return 1e-6 < (tables.overtakes() or 1) < 1e-4 and tables.overtakes("box2d") is None


@claim("Of whole runs, as users start them, a smaller share is within 15 %")
def whole_runs_inside():
    def share(some):
        return sum(0.85 <= q <= 1.15 for q in some) / len(some)

    short, whole = tables.predicted()
    return share(short) > share(whole[1] + whole[2]) and share(whole[1]) > share(whole[2])


@claim("The program's own model is within 10 % of injected simulation in all runs of the filled boxes with direct migration")
def model_near():
    return all(0.9 <= q <= 1.1 for q in tables.against(DIRECT)) and not all(0.9 <= q <= 1.1 for q in tables.against(SWARM))


@claim("On two quiet cores it did, within 15 % in ... short runs.")
def model_right():
    some = tables.predicted()[0]
    return sum(0.85 <= q <= 1.15 for q in some) >= 0.9 * len(some)


@claim("So the classes differ by more on 32 processes than any of them did from the measurement on two")
def classes_differ():
    some = [tables.interval(kind) for kind in CLASSES]
    e = tables.all_classes(32)
    return max(a / b for a, b in zip(e["closed form"], e["emulated simulation"])) > max(max(q) / min(q) for q in some)
