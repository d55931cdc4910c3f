"""Claims of the first page and of sections 2 to 5 of docs/report.md."""

from claims import RUNS, claim
from closed import BOXES
from data import Missing
from evidence import CLASSES
from words import scene


@claim(
    "It was faster than one process and than the pool in every run of every scene on 2 to 32 processes, measured, by"
    " the critical path and simulated",
    f"{RUNS}, docs/data/simulated/strong.csv and weak.csv",
)
def spatial_ahead(r):
    for study in ("strong", "weak"):
        for kind in ("measured", "critical path", "simulated"):
            for name in r.all_scenes():
                try:
                    spatial = r.efficiencies(name, study, kind=kind)
                except Missing:
                    continue
                for p, e in r.efficiencies(name, study, "pool", kind).items():
                    yield (
                        f"{scene(name)}, {study}, {kind}, {p} processes: speed-up over that of the pool",
                        spatial[p] * p,
                        ">",
                        e * p,
                    )
                for p in (p for p in spatial if 1 < p <= 32):
                    yield f"{scene(name)}, {study}, {kind}, {p} processes: speed-up", spatial[p] * p, ">", 1


@claim(
    "Every figure for more processes is the answer of a model, and Table 2 says how well each model did where it could"
    " be tested, on two processes.",
    RUNS,
)
def measured_on_two(r):
    for row in r.real("strong") + r.real("weak"):
        if row["class"] == "measured":
            yield "processes of a measured run", row["processes"], "<=", 2


@claim(
    "The critical path promised more than was measured in {path_above} runs of spatial decomposition, most of them by a"
    " few per cent.",
    RUNS,
)
def path_promises(r):
    some = [q["efficiency"] for q in r.pairs() if q["class"] == "critical path" and not q["pool"]]
    yield "runs in which the measured efficiency is less", sum(e < 1 for e in some), ">", len(some) / 2
    yield "of these, by at most 6 %", sum(0.94 <= e < 1 for e in some), ">", sum(e < 1 for e in some) / 2


@claim("Injected simulation was faster than the real run in {injected_below}.", "docs/data/simulated/validate.csv")
def injected_faster(r):
    some = [q["time"] for q in r.pairs() if q["class"] == "injected simulation" and not q["pool"]]
    yield "runs that it makes shorter", sum(t < 1 for t in some), ">", len(some) / 2


@claim(
    "Emulated simulation was slower than the real run in each of these, probably because all processes share the caches"
    " of one core; whether it is on more processes was not tested.",
    "docs/data/simulated/validate.csv",
)
def emulated_slower(r):
    for q in r.pairs():
        if q["class"] == "emulated simulation" and not q["pool"]:
            yield "time over the real one", q["time"], ">", 1


# ---- Mathematics and serial program
ORDERS = "docs/data/choosing.csv"


@claim("With linear functions the error is larger on 64 cells than on 8:", ORDERS)
def linear_fails(r):
    for method in ("lin usf flip", "lin musl flip"):
        e = dict(r.ladders()[method])
        yield method, e[64], ">", e[8]


@claim(
    "Quadratic splines with musl fail in the same way, but later: their error on 64 cells is three times that on 16.",
    ORDERS,
)
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


@claim(
    "Of these methods only GIMP, whose functions are averaged over domains that stretch with the particles, has the"
    " second order on all grids.",
    ORDERS,
)
def gimp_second(r):
    for method in r.ladders():
        yield f"least order of {method}", min(r.orders(method)), ">=" if method == "gimpS usl flip" else "<", 1.95


@claim(
    "A plain serial program without vectors takes {plain} times as long as pebble for the same work",
    "docs/data/bench/floor.csv",
)
def plain_slower(r):
    rows = [q for q in r.data.file("bench/floor.csv") if q["group"] == "seed" and q["update"] == "usf"]
    for n in {q["particles"] for q in rows}:
        a, b = r.least_ns(rows, n)
        yield f"ns a particle, {n} particles", a, ">", b


@claim(
    "Two disks on 1024 x 1024 cells then have an imbalance (largest over mean number of particles) of {imbalance_now}"
    " on 32 processes, where equal boxes would have {equal_boxes}.",
    "docs/data/tiles.csv, pebble -dry_run",
)
def cuts_balance(r):
    yield "imbalance", r.balances()["disks, 1024 x 1024 cells"][32], "<", r.equal_boxes()


# ---- Model
@claim(
    "With DMSwarmMigrate the efficiency on a million processes is less than half of that with direct migration.",
    "docs/data/models",
)
def swarm_far(r):
    for name in BOXES:
        yield scene(name), r.weak(name, 16384, 1000000, True), "<", r.weak(name, 16384, 1000000) / 2


@claim(
    "The simulated boxes of Table 11 needed more particles than these cubes, since they are cut between tiles and wait"
    " for each other.",
    "docs/data/models, docs/data/simulated",
)
def boxes_need_more(r):
    for name in BOXES:
        yield f"{scene(name)}, 1024 processes", r.kept(name)[1024], ">", r.least_particles(name, 0.8, 1024)


@claim("Larger scenes can use more:", "docs/data/simulated")
def larger_more(r):
    found = {(a["scene"], a["study"]): a["processes"] for a in r.answers()}
    for (name, study), p in found.items():
        if study == "strong-large":
            yield f"processes of {scene(name)}", p, ">", found[name, "strong"]


@claim(
    "The critical path, injected simulation and the closed form are no bounds: each was too fast in some runs and too"
    " slow in others.",
    f"{RUNS}, docs/data/simulated/validate.csv",
)
def no_bounds(r):
    for kind in CLASSES:
        if kind == "emulated simulation":
            continue
        low, high, _ = r.interval(kind)
        yield f"least of {kind}", low, "<", 1
        yield f"largest of {kind}", high, ">", 1
