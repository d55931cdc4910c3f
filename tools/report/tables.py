"""The tables and the numbers in the text of docs/report.md, model.md and performance.md, all from docs/data: table_NAME
makes the table at the mark NAME, and numbers() all numbers."""

import math
from collections import defaultdict
from dataclasses import replace

import data
from data import BOXES, CLASSES, DIRECT, POOL, PROCESSES, SCENES, SWARM, WAYS, WEAK, title
from marks import markdown

SHARES = (1e5, 1e9), (0, 1e5)  # particles a process of the runs on two processes: strong scaling, and weak or smaller
GOAL, STEP = (0.9, 1.1), (0.85, 1.15)  # closed form over simulation, predicted over measured
FULL = {DIRECT: "spatial direct", SWARM: "spatial swarm", POOL: "pool"}
LADDERS = (("usf, flip (the assignment)", "linear"), ("musl, flip", "linear"), ("musl, flip", "quadratic B-spline"), ("usl, aflip", "quadratic B-spline"),
           ("preset balanced (the default)", "cubic B-spline"), ("usl, aflip", "GIMP, stretched"))  # fmt: skip
BASES = {"linear": "linear", "bspline2": "quadratic", "bspline3": "cubic", "gimp": "GIMP"}
LEAVES_OUT = {
    "critical path": ("the network; most waiting; competition for memory of more than two cores", "caches that are cold after each turn"),
    "closed form": ("disturbances; waiting, except by imbalance", ""),
    "injected simulation": ("caches; competition for memory; disturbances", ""),
    "emulated simulation": ("competition for memory", "all processes in the caches of one core"),
}


def thousands(n):
    return f"{int(n):,}".replace(",", " ")


def digits(x):
    """Three digits of a number of particles or processes."""
    return thousands(float(f"{x:.3g}"))


def span(values, form="{:.2f}"):
    """The least and the largest, or the only one."""
    values = list(values)
    return " to ".join(dict.fromkeys(form.format(v) for v in (min(values), max(values))))


def inside(ratios, low, high):
    return f"{sum(low <= q <= high for q in ratios)} of {len(ratios)}"


def speedups(scene, study, kind, how=DIRECT):
    return {p: p * e for p, e in data.efficiency(scene, study, kind, how).items()}


def cell(values, p, form="{:.2f}"):
    return form.format(values[p]) if p in values else ""


# ---- The first page
def all_classes(processes):
    """Efficiencies of strong scaling, direct, of all scenes, in all classes."""
    return {kind: [data.efficiency(s, "strong", kind)[processes] for s in SCENES] for kind in CLASSES}


def table_answer():
    words = [kind.replace(" simulation", "") for kind in CLASSES]
    lines = [[title(s), thousands(data.constants(s)["particles"]), cell(speedups(s, "strong", "measured"), 2),
              *(f"{speedups(s, 'strong', kind)[p]:.3g}" for p in (8, 32) for kind in CLASSES)] for s in SCENES]  # fmt: skip
    return markdown(["scene", "particles", "on 2, measured", *(f"{p}: {w}" if w == words[0] else w for p in (8, 32) for w in words)], lines)


def interval(kind, pool=False, shares=SHARES[0]):
    return [q["efficiency"] for q in data.pairs(kind) if (q["way"] == POOL) == pool and shares[0] <= q["share"] < shares[1]]


def table_sure():
    found = {kind: [interval(kind, pool, shares) for pool in (False, True) for shares in SHARES] for kind in CLASSES}
    head = ["class", "spatial, 100 000 or more a process", "spatial, 8 000 to 17 000", "pool, 100 000 or more", "pool, 8 000 to 17 000", "leaves out", "adds"]
    return markdown(head, [[kind, *(f"{span(q)} ({len(q)})" for q in some), *LEAVES_OUT[kind]] for kind, some in found.items()])


# ---- Mathematics and serial program
def ladder(method, basis):
    return {r["cells"]: float(r["error"]) for r in data.rows("ladders.csv") if (r["method"], r["basis"]) == (method, basis)}


def table_orders():
    lines, sizes = [], sorted({r["cells"] for r in data.rows("ladders.csv")})
    for method, basis in LADDERS:
        e = {n: 100 * error for n, error in ladder(method, basis).items()}
        lines.append([basis, method, *(cell(e, n, "{:.2g} %") for n in sizes), f"{math.log2(list(e.values())[-2] / list(e.values())[-1]):.1f}"])
    return markdown(["basis", "update, transfer", *(f"{n} cells" for n in sizes), "last order"], lines)


# ---- The model
def table_constants():
    units = (("T1", 1e3, "{:.3g} ms"), ("C", 1e9, "{:.1f} ns"), ("L", 1e6, "{:.1f} µs"), ("B", 1e9, "{:.0f} ns"), ("R", 1e6, "{:.1f} µs"), ("M", 1e9, "{:.1f} ns"))
    lines = [[title(s), thousands(c["particles"]), *(form.format(unit * c[k]) for k, unit, form in units), c["patch"], f"{c['C'] / c['M']:.2f}"]
             for s, c in ((s, data.constants(s)) for s in SCENES)]  # fmt: skip
    return markdown(["scene", "N", "T(1), measured", *"CLBRM", "patch, cells", "bound C/M"], lines)


def least():
    """{scene: {processes: particles a process for an efficiency of 0.9 by the short and the full model}}"""
    return {s: {p: (data.short(s).least(0.9, p), n) for p, n in data.modelled(s, "least", column="particles").items()} for s in BOXES}


def table_least():
    lines = [[title(s), model, *(digits(n[k]) for n in by.values())] for s, by in least().items() for k, model in enumerate(("short", "full"))]
    return markdown(["scene", "model", *map(thousands, least()["box2d"])], lines)


def apart(how):
    """Speed-ups of strong scaling by the short model over those by the full one."""
    both = ((data.efficiency(s, "strong", "closed form", how), data.modelled(s, "strong", FULL[how])) for s in SCENES)
    return [closed[p] / e for closed, full in both for p, e in full.items()]


def table_example():
    s, total, lines = data.short("box2d"), data.constants("box2d")["particles"], []
    spatial, pool = ({p: p * e for p, e in data.modelled("box2d", "strong", FULL[how]).items()} for how in (DIRECT, POOL))
    for p in (*PROCESSES, 128, 1024):
        parts, S = s.parts(total, p), s.speedup(total, p)
        lines.append([p, *(f"{1e6 * t:.1f}" for t in (*parts, sum(parts))), f"{S:.2f}", f"{S / p:.2f}", cell(spatial, p), f"{s.pool(p):.2f}", cell(pool, p)])
    return markdown(["P", "C n, µs", "L, µs", "B √n, µs", "R log2 P, µs", "T, µs", "S", "E", "S, full model", "S, pool", "pool, full model"], lines)


# ---- Results
def table_scenes():
    lines = []
    for r in data.rows("scaling/scenes.csv"):
        s = r["scene"]
        sizes = [min(q["particles"] for q in data.runs(study, "measured") if q["scene"] == s) for study in ("strong", "weak")]
        patches = next(q["pool_cells"] for q in data.runs("strong", "measured") if (q["scene"], q["way"]) == (s, POOL)), data.constants(s)["patch"]
        imbalance = {q["processes"]: q["imbalance"] for q in data.runs("strong", "critical path") if (q["scene"], q["way"]) == (s, DIRECT)}
        lines.append([title(s), f"{BASES[r['basis']]}, {r['update']}", r["cells"].replace("x", " x "), "; ".join(map(thousands, sizes)),
                      "{}; {}".format(*patches), f"{imbalance[8]:.2f}; {imbalance[32]:.2f}", r["motion"]])  # fmt: skip
    return markdown(["scene", "basis, update", "cells, strong scaling", "particles: strong; weak on 1", "cells of a patch: real; simulated", "imbalance: 8; 32", "motion at the start"], lines)


def disturbed(scene, study):
    """Numbers of processes of critical paths whose efficiency times imbalance is less than on twice as many: other work took their time."""
    net = {r["processes"]: r["efficiency"] * r["imbalance"] for r in data.runs(study, "critical path") if (r["scene"], r["way"]) == (scene, DIRECT)}
    return [p for p, e in net.items() if e < 0.97 * net.get(2 * p, 0)]


def scaling(kind, measured=False):
    """Speed-ups on 1 to 32 processes, strong and weak: direct / DMSwarmMigrate / pool in a cell; measured: also on two."""
    lines = []
    for study, s in ((study, s) for study in ("strong", "weak") for s in SCENES):
        found, real = ([speedups(s, study, k, how) for how in WAYS] for k in (kind, "measured"))
        cells = [" / ".join(cell(by, p) or "-" for by in found).replace(" /", "*" * (measured and p in disturbed(s, study)) + " /", 1) for p in PROCESSES[1:]]
        if any(found):
            lines.append([study, title(s), "1", *[" / ".join(cell(by, 2) or "-" for by in real)] * measured, *cells])
    return markdown(["scaling", "scene", "1", *["2, measured"] * measured, *map(str, PROCESSES[1:])], lines)


def table_all():
    return scaling("injected simulation")


def table_path():
    return scaling("critical path", True)


def table_large():
    """Injected simulation on 64 to 1024 processes."""
    groups, sizes = defaultdict(dict), (64, 128, 256, 512, 1024)
    for study in ("weak", "strong"):
        for r in (r for r in data.simulations(f"{study}-large", "injected simulation") if r["processes"] > 1):
            n = r["particles"] // (r["processes"] if study == "weak" else 1)
            groups[study, title(r["scene"]), r["way"] + ", racks of 32" * (r["platform"] == "fattree"), thousands(n)][r["processes"]] = r["efficiency"]
    lines = [[*key, *(cell(by, p) for p in sizes)] for key, by in groups.items()]
    return markdown(["scaling", "scene", "way", "particles: strong in all, weak a process", *map(thousands, sizes)], lines)


def migration(kind, processes):
    """Steps with DMSwarmMigrate over those with direct migration, strong scaling, by scene."""
    t = {(r["scene"], r["way"]): r["seconds"] for r in data.evidence("strong", kind) if r["processes"] == processes}
    return {s: t[s, SWARM] / t[s, DIRECT] for s in SCENES if (s, SWARM) in t}


def digests():
    """For each scene, study, particles and steps that ran in several ways: numbers of runs and of different digests."""
    groups = defaultdict(dict)
    for r in data.rows("scaling/runs.csv"):
        if r["digest"] != "" and r["class"] != "oversubscribed":
            groups[r["scene"], r["study"], r["particles"], r["steps"]].setdefault((r["strategy"], r["migrate"], r["processes"]), set()).add(str(r["digest"]))
    return [(len(some), len(set().union(*some.values()))) for some in groups.values() if len(some) > 1]


def overtakes(scene="box3d", processes=32):
    """The cost of the law, s, from which on the pool is ahead of spatial decomposition by the closed form, or None."""
    short, total = data.short(scene), data.constants(scene)["particles"]
    i = data.modelled(scene, "strong", column="imbalance")[processes]
    costs = ((t, replace(short, C=short.C + t)) for t in (1e-9 * 10 ** (k / 20) for k in range(121)))
    return next((t for t, d in costs if d.pool(processes) > d.speedup(total, processes, i)), None)


def lengths(steps):
    """{scene: measured speed-up on two processes in runs of so many steps}"""
    t = {(r["scene"], r["processes"]): r["seconds_per_step"] for r in data.rows("scaling/lengths.csv") if r["steps"] == steps}
    return {s: t[s, 1] / t[s, 2] for s in SCENES}


# ---- Is the model right?
def against(how):
    """Efficiency by the full model over that of the injected simulation, filled boxes, 2 to 32 processes, strong and weak."""
    both = ((data.modelled(s, study, FULL[how]), data.efficiency(s, study, "injected simulation", how)) for study in ("strong", "weak") for s in BOXES)
    return [full[p] / simulated[p] for full, simulated in both for p in full if p in simulated]


def predicted():
    """Predicted over measured steps of the scenes of options/: of short runs, and {processes: those of whole runs}."""
    whole = {p: [r["predicted"] / r["measured"] for r in data.rows("scaling/users.csv") if r["processes"] == p] for p in (1, 2)}
    return [r["predicted"] / r["seconds_per_step"] for r in data.rows("scaling/validation.csv")], whole


def goals():
    """Goal, what was found, whether it is met."""
    net = {kind: next(r["efficiency"] * r["imbalance"] for r in data.evidence("strong", kind) if (r["scene"], r["processes"], r["way"]) == ("box3d", 32, DIRECT))
           for kind in ("injected simulation", "critical path")}  # fmt: skip
    yield "strong efficiency times imbalance at least 0.90: filled box, 3-D, 8 000 particles a process, 32 processes", net, min(net.values()) >= 0.9
    imbalance = data.modelled("disks", "balance", column="imbalance")[32]
    yield "imbalance at most 1.05: two disks on 1024 x 1024 cells, 32 processes", {"counted": imbalance}, imbalance <= 1.05
    for s in BOXES:
        for p, bound in ((1024, 0.9), (32768, 0.88)):
            some = {"injected simulation": data.efficiency(s, "weak-large", "injected simulation").get(p), "closed form": data.short(s).efficiency(WEAK, p)}
            some = {kind: e for kind, e in some.items() if e}
            yield f"weak efficiency at least {bound:.2f}: {title(s)}, {thousands(WEAK)} particles a process, {thousands(p)} processes", some, min(some.values()) >= bound
    some = {how: against(how) for how in WAYS}
    words = {how: f"{inside(q, *GOAL)} ({span(q)})" for how, q in some.items()}
    yield "full model within 10 % of the injected simulation, filled boxes, 2 to 32 processes", words, all(GOAL[0] <= x <= GOAL[1] for q in some.values() for x in q)
    short, whole = predicted()
    both = {"short runs in turns with the calibration": short, "whole runs as users start them": whole[1] + whole[2]}
    yield (f"predicted within 15 % of the measured step, the scenes of `options/` (16 when it was set, {len(whole[1])} in the data) on 1 and 2 processes",
           {what: inside(q, *STEP) for what, q in both.items()}, all(STEP[0] <= x <= STEP[1] for q in both.values() for x in q))  # fmt: skip


def table_goals():
    lines = [[k, goal, "; ".join(f"{what}: {v if isinstance(v, str) else f'{v:.3f}'}" for what, v in found.items()), "met" if met else "**missed**"]
             for k, (goal, found, met) in enumerate(goals(), 1)]  # fmt: skip
    return markdown(["", "goal (all set by commit 194835d, 2026-11-21)", "found", ""], lines)


# ---- docs/performance.md
def timed(group, **which):
    """ns of the row of docs/data/bench with these columns."""
    return next(r["min_ns"] for r in data.rows(f"bench/{group}.csv") if all(r[k] == v for k, v in which.items()))


def table_presets():
    lines = []
    for one in (r for r in data.rows("bench/presets.csv") if r["processes"] == 1):
        ns, two = one["min_ns"], timed("presets", basis=one["basis"], update=one["update"], processes=2)
        lines.append([one["basis"], f"{one['dim']}-D", thousands(one["particles"]), f"`{one['update']}`", f"{ns:.0f}", f"{1e3 / ns:.1f}", f"{1e3 / two:.1f}", f"{ns / two:.2f}", one["memory"]])
    return markdown(["scene", "", "particles", "preset", "ns a particle", "10^6 particles a second: 1 process", "2", "1 over 2 processes", "B a particle"], lines)


def one_and_two():
    """{(dimension, basis): ns on one process, on two, on two with direct migration}"""
    cases = (1, ""), (2, ""), (2, "-parallel_migrate direct")
    keys = dict.fromkeys((r["dim"], r["basis"]) for r in data.rows("bench/ranks.csv"))
    return {(d, b): [timed("ranks", dim=d, basis=b, processes=p, options=o) for p, o in cases] for d, b in keys}


def over_bare(least):
    """{(dimension, basis, particles): step over bare kernels} with so many particles or more"""
    some = [r for r in data.rows("bench/bare.csv") if r["program"] == "bare" and r["particles"] > least]
    return {(r["dim"], r["basis"], r["particles"]): timed("bare", program="pebble", dim=r["dim"], basis=r["basis"], particles=r["particles"]) / r["min_ns"] for r in some}


def table_steps():
    kernels, lines = {key[:2]: q for key, q in over_bare(5e5).items()}, []
    for (d, b), (one, *two) in one_and_two().items():
        few = [timed("updates", dim=d, basis=b, update=u) for u in ("usl", "usf", "musl")]
        ratios = *(one / t for t in two), *(t / few[0] for t in few[1:]), kernels[d, b]
        lines.append([f"{d}-D {BASES[b]}", f"{one:.0f}", f"{1e3 / one:.0f}", f"{1e3 / two[0]:.0f}", *(f"{q:.2f}" for q in ratios)])
    return markdown(["usl, 10^6 particles", "ns a particle", "10^6 particles a second: 1 process", "2", "1 over 2 processes", "with `direct`", "usf over usl, 10^5",
                     "musl over usl", "step over bare kernels"], lines)  # fmt: skip


def gains():
    """{(what one would take instead, target): times of pebble's step}"""
    out, work = {}, ((2, 99225), (2, 998001), (3, 97336), (3, 1000000))
    for program, update, words, target in (("warp", "usl", "same scheme", 2), ("warp", "mls", "MLS-MPM", ""), ("taichi", "usl", "same scheme", 7), ("taichi", "mls", "MLS-MPM", "")):
        out[f"{program.capitalize()}, {words}", target] = [timed("peers", program=program, update=update, dim=d, particles=n) / timed("peers", program="pebble", dim=d, particles=n) for d, n in work]
    for update, target in (("usf", 8), ("usl", 15)):
        out[f"the plain serial program, pebble with {update}", target] = [timed("seed", program="seed_serial") / timed("seed", program="pebble", update=update)]
    return out


def table_gains():
    lines = [[what, *(f"{q:.1f}" for q in found), *[""] * (4 - len(found)), f"{target}: {sum(q >= target for q in found)} of {len(found)}" if target else ""]
             for (what, target), found in gains().items()]  # fmt: skip
    return markdown(["in place of pebble", "2-D, 10^5 particles", "2-D, 10^6", "3-D, 10^5", "3-D, 10^6", "target: met"], lines)


# ---- Numbers
def numbers():
    """{name: text} of all numbers in the text."""
    out = {f"two{name}": span(speedups(s, study, "measured")[2] for s in SCENES) for name, study in (("", "strong"), ("_weak", "weak"))}
    out |= {"two_long": span(lengths(400).values()), "dam_long": f"{lengths(400)['dambreak3d']:.2f}", "dam_short": f"{lengths(40)['dambreak3d']:.2f}"}
    for p in (8, 32):
        every = sum(all_classes(p).values(), [])
        out |= {f"e_{p}": span(every), f"s_{p}": span((p * e for e in every), "{:.1f}")} | {f"{kind.split()[0]}_{p}": span(some) for kind, some in all_classes(p).items()}
    out["sure_critical"] = span(interval("critical path"))
    for name, key in (("swarm_two", ("measured", 2)), ("swarm_32", ("critical path", 32)), ("swarm_32_simulated", ("injected simulation", 32))):
        out[name] = span(migration(*key).values())
    out |= {f"serial_{s[-2:]}": f"{1e9 * data.constants(s)['C']:.0f}" for s in BOXES}
    ratios = [{p: short / full for p, (short, full) in by.items()} for by in least().values()]
    out |= {"least_apart": span((q for by in ratios for q in by.values()), "{:.1f}"), "least_far": span(q for by in ratios for p, q in by.items() if p >= 1024)}
    out["imbalance"] = f"{data.modelled('disks', 'balance', column='imbalance')[32]:.2f}"
    most = [data.short(s).most(data.constants(s)["particles"]) for s in SCENES]
    out["fastest"] = f"{digits(min(most))} to {digits(max(most))}"
    out |= {"apart_spatial": span(apart(DIRECT)), "apart_spatial_5": inside(apart(DIRECT), 0.95, 1.05), "apart_pool": span(apart(POOL))}
    out["bits"] = f"{len(digests())} scenes and sizes, {sum(n for n, _ in digests())} runs"
    out["pool_two"] = span(speedups(s, "strong", "measured", POOL)[2] for s in SCENES)
    out["pool_best"] = span(max(speedups(s, "strong", kind, POOL).values()) for kind in CLASSES[:3] for s in SCENES)
    out |= {"overtakes": f"{float(f'{1e6 * overtakes():.2g}'):g}" if overtakes() else "no cost", "counts": str(len(data.rows("scaling/counts.csv")))}
    out["machine_real"] = next(r["value"] for r in data.rows("scaling/machine.csv") if r["name"] == "program")
    short, whole = predicted()
    out |= {"short_runs": inside(short, *STEP), "short_span": span(short), "users_one": inside(whole[1], *STEP), "users_two": inside(whole[2], *STEP),
            "users_span": span(1 / q for q in whole[1] + whole[2]), "users_one_span": span(1 / q for q in whole[1]), "users_most": f"{1 / min(whole[2]):.2f}"}  # fmt: skip
    out |= {f"against_{name}": f"{inside(against(how), *GOAL)} ({span(against(how))})" for name, how in (("direct", DIRECT), ("swarm", SWARM), ("pool", POOL))}
    met = sum(line[-1] for line in goals())
    out["goals_met"] = f"{'None One Two Three Four Five Six Seven Eight'.split()[met]} of the eight goals {'are' if met > 1 else 'is'} met"
    one = {r["scene"]: r["seconds"] for r in data.simulations("strong", "injected simulation") if r["processes"] == 1}
    out["c_simulated"] = span(one[s] / data.constants(s)["T1"] for s in BOXES)
    two = [one / q for one, *both in one_and_two().values() for q in both]
    out |= {"two_bench": span(two), "two_below": inside(two, 0, 1.85), "over_bare": span(over_bare(5e4).values(), "{:.1f}")}
    small = [r for r in data.rows("bench/presets.csv") if (r["basis"], r["processes"]) == ("disks", 1)]
    out["two_small"] = span(r["min_ns"] / timed("presets", basis="disks", update=r["update"], processes=2) for r in small)
    out["bench_when"] = next(r["value"] for r in data.rows("bench/machine.csv") if r["name"] == "when")[:10]
    for name, word, form in (("twin", "serial", "{:.0f}"), ("warp", "Warp", "{:.1f}")):
        out[name] = span((q for (what, _), found in gains().items() if word in what for q in found), form)
    out["plain"] = f"{gains()['the plain serial program, pebble with usf', 8][0]:.1f}"
    return out
