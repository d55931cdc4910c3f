"""Claims of sections 6 and 7 of docs/report.md."""

from claims import RUNS, SIMULATED, claim
from closed import BOXES, way
from evidence import CLASSES
from goals import MODEL, STEP
from words import inside, scene


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


@claim(
    "So short runs stand for long ones in all scenes but the dam break in 3-D, which lost more than a tenth of its"
    " efficiency;",
    "docs/data/scaling/lengths.csv",
)
def short_stand_for_long(r):
    for name, (_, efficiency) in r.longer().items():
        yield scene(name), efficiency, "<" if name == "dambreak3d" else ">", 0.9


@claim(
    "In every scene injected simulation promises more on 32 processes, {injected_32}, than the critical path,"
    " {path_32}.",
    f"{SIMULATED}, {RUNS}",
)
def injected_promises(r):
    for name in r.all_scenes():
        yield (
            scene(name),
            r.efficiencies(name, "strong")[32],
            ">",
            r.efficiencies(name, "strong", kind="critical path")[32],
        )


@claim("Emulated simulation is below the injected one in every scene too, {emulated_32}.", SIMULATED)
def emulated_lower(r):
    for name in r.all_scenes():
        emulated = r.efficiencies(name, "strong", mode="emulated")[32]
        yield scene(name), emulated, "<", r.efficiencies(name, "strong")[32]


@claim("The two balls, whose cuts are 32 slabs, have the lowest simulated efficiency on 32 processes:", SIMULATED)
def slabs_lowest(r):
    cut = next(
        q["cut"]
        for q in r.simulated("strong")
        if (q["scene"], q["ranks"], way(q)) == ("disks3d", 32, "spatial, direct")
    )
    yield "slabs", max(map(int, str(cut).split("x"))), "==", 32
    yield "imbalance", r.simulated_imbalance("disks3d", 32), ">", 1.2
    for name in r.all_scenes():
        if name != "disks3d":
            yield (
                f"balls and {scene(name)}",
                r.efficiencies("disks3d", "strong")[32],
                "<",
                r.efficiencies(name, "strong")[32],
            )


@claim(
    "With 16 384 particles a process and direct migration both boxes keep more than 0.8 up to 1 024 processes.",
    "docs/data/simulated/weak-large.csv",
)
def weak_keeps(r):
    for name in BOXES:
        for p, e in r.efficiencies(name, "weak-large").items():
            yield f"{scene(name)}, {p} processes", e, ">", 0.8


@claim(
    "With a million particles in all, on as many processes, a process has 1 024 of them, and the efficiency is below"
    " 0.6.",
    "docs/data/simulated/strong-large.csv",
)
def strong_falls(r):
    for name in BOXES:
        yield scene(name), r.efficiencies(name, "strong-large")[1024], "<", 0.6


@claim(
    "On 32 processes a step with DMSwarmMigrate was never shorter than one with `direct`, and in the two disks it took"
    " half as long again in the simulation.",
    f"{SIMULATED}, {RUNS}",
)
def swarm_longer(r):
    for (name, kind, p), ratio in r.ratios_of_migration().items():
        if p == 32:
            yield f"{scene(name)}, {kind}", ratio, ">=", 0.999
    yield "two disks", r.ratios_of_migration()["disks", "simulated", 32], ">", 1.4
    yield "two disks", r.ratios_of_migration()["disks", "simulated", 32], "<", 1.75


@claim(
    "In weak scaling the box in 2-D has an efficiency of {swarm_256} on 256 simulated processes with DMSwarmMigrate and"
    " of {direct_256} with `direct`.",
    "docs/data/simulated/weak-large.csv",
)
def swarm_weak(r):
    yield (
        "efficiency",
        r.efficiencies("box2d", "weak-large", "spatial, DMSwarmMigrate")[256],
        "<",
        r.efficiencies("box2d", "weak-large")[256],
    )


# ---- The pool
@claim("On two processes the pool took longer than one process in every run.", RUNS)
def pool_on_two(r):
    for study in ("strong", "weak"):
        for name in r.all_scenes():
            if e := r.efficiencies(name, study, "pool", "measured").get(2):
                yield f"speed-up of {scene(name)}, {study}", 2 * e, "<", 1


@claim(
    "Spatial decomposition is ahead there, on every number of processes in Table 14.",
    "docs/data/models, pebble -dry_run",
)
def pool_behind(r):
    for name in r.all_scenes():
        found = r.best_pools(name)
        for p in (2, 8, 32):
            yield f"{scene(name)}, {p} processes", found["pool"][p], "<", found["spatial"][p]


@claim(
    "Where a box can be cut evenly the pool approaches spatial decomposition and does not pass it.", "docs/data/models"
)
def pool_approaches(r):
    m, whole = r.closed("box2d"), r.whole("box2d")
    for p in (8, 32):
        for t in (1e-7, 1e-5, 1e-4):
            d = m.dearer(t)
            yield (
                f"step of the 2-D box on {p} processes, law {t:g} s dearer",
                r.best_pool(d, whole, p),
                ">",
                r.spatial(d, "box2d", p)[0],
            )


@claim("In 3-D on 32 processes, where whole tiles leave an imbalance, it passes {overtakes}.", "docs/data/models")
def pool_passes(r):
    yield "cost of the law in s (1: none)", r.overtakes() or 1, "<", 1e-3


# ---- Messages, balance, model
@claim("all {counts} counted numbers of messages, bytes and reductions equal formulas", "docs/data/scaling/counts.csv")
def counts_equal(r):
    yield "numbers that are equal", sum(q["equal"] == "yes" for q in r.counts()), "==", len(r.counts())


@claim(
    "so its bytes grow with the number of cuts; on up to 32 processes they stay below those of the pool, which sends"
    " every particle.",
    RUNS,
)
def bytes_below(r):
    rows = [q for q in r.real("strong") if q["processes"] > 1 and q["class"] == "critical path"]
    pool = {q["scene"]: q["bytes_per_particle_step"] for q in rows if q["strategy"] == "pool"}
    for q in rows:
        if way(q) == "spatial, direct":
            yield (
                f"{scene(q['scene'])}, {q['processes']} processes",
                q["bytes_per_particle_step"],
                "<",
                pool[q["scene"]],
            )


@claim(
    "Before sums were made by tiles, the two disks had an imbalance of {imbalance_before} on 32 processes; now it is"
    " {imbalance_now}.",
    "docs/data/tiles.csv, pebble -dry_run",
)
def tiles_cost(r):
    yield "imbalance", float(r.number_imbalance_before()), "<", r.balances()["disks, 1024 x 1024 cells"][32]


@claim(
    "the critical path on 32 processes became {tiles_gain} times shorter in three scenes when the change was made",
    "docs/data/tiles.csv",
)
def tiles_gain(r):
    rows = [q for q in r.tiles() if q["after"]]
    yield "scenes", len(rows), "==", 3
    for q in rows:
        yield q["scene"], q["after"], "<", q["before"]


@claim(
    "Of the first steps of the scenes of `options/`, on one process and on two, {short_runs} are within 15 %, and all are"
    " from {short_span}.",
    "docs/data/scaling/validation.csv",
)
def short_runs_inside(r):
    some = r.short_runs()
    yield "within 15 %", inside(some, *STEP), ">=", 0.9 * len(some)


@claim(
    "Of whole runs a smaller share is within 15 %: {users}.",
    "docs/data/scaling/users.csv",
)
def whole_runs_inside(r):
    some, whole = r.short_runs(), [ratio for _, _, ratio in r.users()]
    yield "share of the whole runs", inside(whole, *STEP) / len(whole), "<", inside(some, *STEP) / len(some)


@claim(
    "On one process {users_one} are, on two {users_two}: a likely reason is that bodies move over the cuts, which the"
    " prediction from the first state does not know.",
    "docs/data/scaling/users.csv",
)
def users_on_two(r):
    one, two = ([ratio for _, p, ratio in r.users() if p == n] for n in (1, 2))
    yield "inside on one and on two processes", inside(one, *STEP), ">", inside(two, *STEP)


@claim(
    "Those of spatial decomposition are within 10 % of it in all runs on up to 32 processes, those of the pool are too"
    " slow.",
    "docs/data/simulated, docs/data/models",
)
def formulas_near(r):
    for which in ("spatial, direct", "spatial, DMSwarmMigrate"):
        some = r.against(which)
        yield f"{which}: runs within 10 %", inside(some, *MODEL), "==", len(some)
    some = r.against("pool")
    yield "pool: runs slower by more than 10 %, and faster", sum(q > 1.1 for q in some), ">", sum(q < 0.9 for q in some)


@claim(
    "On 4 to 32 processes the closed form was faster than the critical path in every run of spatial decomposition,"
    " {many_span} of it,",
    RUNS,
)
def closed_faster(r):
    for q in r.path_ratios():
        yield f"{scene(q['scene'])}, {q['study']}, {q['processes']} processes", q["ratio"], "<", 1


@claim("On two quiet cores it did, within 15 % in {short_runs} short runs.", "docs/data/scaling/validation.csv")
def model_right(r):
    some = r.short_runs()
    yield "within 15 %", inside(some, *STEP), ">=", 0.9 * len(some)


@claim(
    "So the classes differ by more on 32 processes than each of them did from the measurement on two.",
    f"{SIMULATED}, docs/data/simulated/validate.csv, {RUNS}",
)
def classes_differ(r):
    width = max(high / low for low, high, _ in (r.interval(kind) for kind in CLASSES))
    some = [r.efficiencies(s, "strong")[32] / r.efficiencies(s, "strong", mode="emulated")[32] for s in r.all_scenes()]
    yield "largest over least efficiency of a scene on 32 processes", max(some), ">", width


@claim("In the real runs of the filled boxes on 32 processes these were {migrating} steps.", RUNS)
def often_migrates(r):
    for name, (a, b) in r.migrating().items():
        yield f"steps of {scene(name)}", a, "<=", b


@claim(
    "It would be worth using for its balance with a law that takes ten to twenty microseconds or more",
    "docs/data/models",
)
def dear_laws(r):
    yield "cost of the law in s (1: none)", r.overtakes() or 1, "<", 2e-5
    yield "cost of the law in s", r.overtakes() or 1, ">", 1e-5


@claim("A more expensive law of the material makes the pool's speed-up larger, as Figure 4 shows.", "docs/data/models")
def dearer_helps(r):
    for name in BOXES:
        m, whole = r.closed(name), r.whole(name)
        for p in (8, 32):
            cheap, dear = (d.step(whole) / r.best_pool(d, whole, p) for d in (m, m.dearer(1e-5)))
            yield f"speed-up of the pool, {scene(name)}, {p} processes", cheap, "<", dear
