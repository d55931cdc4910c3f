"""The tables and the numbers in the text of docs/report.md, model.md and performance.md, all from docs/data: table_NAME
makes the table at the mark NAME, and numbers() all numbers."""

import functools
import itertools
import math
from collections import defaultdict
from dataclasses import replace

import data
from data import BOXES, CLASSES, DIRECT, POOL, PROCESSES, SCENES, SWARM, WAYS, WEAK, find
from marks import markdown, pivot

STUDIES = "strong", "weak"
SIZES = {"100 000 or more": (1e5, 1e9), "8 000 to 17 000": (0, 1e5)}  # particles a process of runs on two
LADDERS = (
    ("usf, flip (the assignment)", "linear"),
    ("musl, flip", "linear"),
    ("musl, flip", "quadratic B-spline"),
    ("usl, aflip", "quadratic B-spline"),
    ("preset balanced (the default)", "cubic B-spline"),
    ("usl, aflip", "GIMP, stretched"),
)
BASES = {"linear": "linear", "bspline2": "quadratic", "bspline3": "cubic", "gimp": "GIMP"}


def thousands(n, digits=15):
    """A number with a space between its thousands; of large ones the first digits."""
    return f"{float(f'{n:.{digits}g}'):,.0f}".replace(",", " ")


def span(values, form="{:.2f}"):
    """The least and the largest, or the only one."""
    values = list(values)
    return " to ".join(dict.fromkeys(form.format(v) for v in (min(values), max(values))))


def inside(ratios, low, high):
    return f"{sum(low <= q <= high for q in ratios)} of {len(ratios)}"


def speedups(scene, study, kind, how=DIRECT):
    return {p: p * e for p, e in data.efficiency(scene, study, kind, how).items()}


# ---- The first page
def all_classes(processes):
    """Efficiencies of strong scaling, direct, of all scenes, in all classes."""
    return {kind: [data.efficiency(s, "strong", kind)[processes] for s in SCENES] for kind in CLASSES}


def table_answer():
    cells = {}
    for s in SCENES:
        cells[SCENES[s].title, "2: measured"] = f"{speedups(s, 'strong', 'measured')[2]:.2f}"
        for p, kind in itertools.product((8, 32), CLASSES):
            cells[SCENES[s].title, f"{p}: {kind.split(' sim')[0]}"] = f"{speedups(s, 'strong', kind)[p]:.3g}"
    return pivot(["scene"], cells)


def interval(kind, ways=(DIRECT, SWARM), size=(1e5, 1e9)):
    """Measured efficiencies on two processes over those of the class."""
    return [q for how, n, q, _ in data.pairs(kind) if how in ways and size[0] <= n < size[1]]


def table_sure():
    cells = {}
    for kind, (words, ways), (particles, size) in itertools.product(CLASSES, {"spatial": (DIRECT, SWARM), "pool": (POOL,)}.items(), SIZES.items()):
        q = interval(kind, ways, size)
        cells[kind, f"{words}, {particles}"] = f"{span(q)} ({len(q)})"
    return pivot(["class"], cells)


# ---- Mathematics
def ladder(method, basis):
    return find("ladders", "error", "cells", method=method, basis=basis)


def table_orders():
    ladders = {(basis, method): ladder(method, basis) for method, basis in LADDERS}
    cells = {(*line, f"{n} cells"): f"{100 * e:.2g} %" for line, by in ladders.items() for n, e in by.items()}
    for line, by in ladders.items():
        *_, a, b = by.values()
        cells[*line, "last order"] = f"{math.log2(a / b):.1f}"
    return pivot(["basis", "update, transfer"], cells)


# ---- The model
def table_constants():
    units = {"T1": (1e3, ".3g", "ms"), "C": (1e9, ".1f", "ns"), "L": (1e6, ".1f", "µs"), "B": (1e9, ".0f", "ns"), "R": (1e6, ".1f", "µs"), "M": (1e9, ".1f", "ns")}
    lines = []
    for s, c in ((s, data.constants(s)) for s in SCENES):
        texts = (f"{unit * c[name]:{form}} {word}" for name, (unit, form, word) in units.items())
        lines.append([SCENES[s].title, thousands(c["particles"]), *texts, c["patch"], f"{c['C'] / c['M']:.2f}"])
    return markdown(["scene", "N", "T(1), measured", *"CLBRM", "patch, cells", "bound C/M"], lines)


def least():
    """{scene: {processes: particles a process for an efficiency of 0.9 by the short and the full model}}"""
    return {s: {p: (data.short(s).least(0.9, p), n) for p, n in data.modelled(s, "least", column="particles").items()} for s in BOXES}


def table_least():
    cells = {(SCENES[s].title, model, thousands(p)): thousands(n, 3) for s, by in least().items() for p, both in by.items() for model, n in zip(("short", "full"), both)}
    return pivot(["scene", "model"], cells)


def apart(how):
    """Speed-ups of strong scaling by the short model over those by the full one."""
    both = ((data.efficiency(s, "strong", "closed form", how), data.modelled(s, "strong", how)) for s in SCENES)
    return [closed[p] / e for closed, full in both for p, e in full.items()]


def table_example():
    s, total, lines = data.short("box2d"), data.constants("box2d")["particles"], []
    for p in (*PROCESSES, 128, 1024):
        parts, S = s.parts(total, p), s.speedup(total, p)
        spatial, pool = (f"{p * e[p]:.2f}" if p in e else "" for e in (data.modelled("box2d", "strong", how) for how in (DIRECT, POOL)))
        lines.append([p, *(f"{1e6 * t:.1f}" for t in (*parts, sum(parts))), f"{S:.2f}", f"{S / p:.2f}", spatial, f"{s.pool(p):.2f}", pool])
    return markdown(["P", "C n, µs", "L, µs", "B √n, µs", "R log2 P, µs", "T, µs", "S", "E", "S, full model", "S, pool", "pool, full model"], lines)


# ---- Results
def table_scenes():
    lines = []
    for r in data.rows("scaling/scenes"):
        s = r["scene"]
        sizes = (thousands(min(q["particles"] for q in data.evidence(study, "measured") if q["scene"] == s)) for study in STUDIES)
        patch = find(data.evidence("strong", "measured"), "pool_cells", "scene", way=POOL)[s]
        imbalance = find(data.evidence("strong", "critical path"), "imbalance", scene=s, way=DIRECT)
        lines.append([SCENES[s].title, f"{BASES[r['basis']]}, {r['update']}", r["cells"].replace("x", " x "), "; ".join(sizes), f"{patch}; {data.constants(s)['patch']}",
                      f"{imbalance[8]:.2f}; {imbalance[32]:.2f}"])  # fmt: skip
    return markdown(["scene", "basis, update", "cells, strong scaling", "particles: strong; weak on 1", "cells of a patch: real; simulated", "imbalance: 8; 32"], lines)


def disturbed(scene, study):
    """Numbers of processes of critical paths whose efficiency times imbalance is less than on twice as many: other work took their time."""
    net = {r["processes"]: r["efficiency"] * r["imbalance"] for r in data.evidence(study, "critical path") if (r["scene"], r["way"]) == (scene, DIRECT)}
    return [p for p, e in net.items() if e < 0.97 * net.get(2 * p, 0)]


def scaling(*kinds):
    """Speed-ups on 1 to 32 processes, strong and weak: direct / DMSwarmMigrate / pool in a cell."""
    cells = {}
    for study, s, kind, p in itertools.product(STUDIES, SCENES, kinds, PROCESSES[1:]):
        found = [speedups(s, study, kind, how).get(p) for how in WAYS]
        mark = "*" if kind == "critical path" and p in disturbed(s, study) else ""
        if any(found):
            texts = " / ".join(f"{x:.2f}" if x else "-" for x in found)
            cells[study, SCENES[s].title, "1", f"{p}, measured" if kind == "measured" else str(p)] = texts.replace(" ", f"{mark} ", 1)
    return pivot(["scaling", "scene", "1"], cells)


table_all = functools.partial(scaling, "injected simulation")
table_path = functools.partial(scaling, "measured", "critical path")


def table_large():
    """Injected simulation on 64 to 1024 processes."""
    cells = {}
    for study, r in ((study, r) for study in ("weak", "strong") for r in data.evidence(f"{study}-large", "injected simulation")):
        n = r["particles"] // (r["processes"] if study == "weak" else 1)
        if r["processes"] > 1:
            cells[study, SCENES[r["scene"]].title, r["way"], thousands(n), thousands(r["processes"])] = f"{r['efficiency']:.2f}"
    return pivot(["scaling", "scene", "way", "particles: strong in all, weak a process"], cells)


def migration(kind, processes):
    """Steps with DMSwarmMigrate over those with direct migration, strong scaling, by scene."""
    swarm, direct = (find(data.evidence("strong", kind), "seconds", "scene", way=how, processes=processes) for how in (SWARM, DIRECT))
    return {s: t / direct[s] for s, t in swarm.items()}


def digests():
    """For each scene, study, particles and steps that ran in several ways: numbers of ways and of different digests."""
    ways, bits = defaultdict(set), defaultdict(set)
    for r in data.rows("scaling/runs"):
        if r["digest"] != "" and r["class"] != "oversubscribed":
            key = r["scene"], r["study"], r["particles"], r["steps"]
            ways[key].add((r["strategy"], r["migrate"], r["processes"]))
            bits[key].add(r["digest"])
    return [(len(some), len(bits[key])) for key, some in ways.items() if len(some) > 1]


def overtakes(scene="box3d", processes=32):
    """The cost of the law, s, from which on the pool is ahead of spatial decomposition by the closed form, or None."""
    short, total = data.short(scene), data.constants(scene)["particles"]
    i = data.modelled(scene, "strong", column="imbalance")[processes]
    costs = ((t, replace(short, C=short.C + t)) for t in (1e-9 * 10 ** (k / 20) for k in range(121)))
    return next((t for t, dear in costs if dear.pool(processes) > dear.speedup(total, processes, i)), None)


def lengths(steps):
    """{scene: measured speed-up on two processes in runs of so many steps}"""
    t = {s: find("scaling/lengths", "seconds_per_step", scene=s, steps=steps) for s in SCENES}
    return {s: t[s][1] / t[s][2] for s in SCENES}


# ---- Is the model right?
def against(how):
    """Efficiency by the full model over that of the injected simulation, filled boxes, 2 to 32 processes, strong and weak."""
    both = ((data.modelled(s, study, how), data.efficiency(s, study, "injected simulation", how)) for study in STUDIES for s in BOXES)
    return [full[p] / simulated[p] for full, simulated in both for p in full if p in simulated]


def predicted():
    """{processes: predicted over measured steps of whole runs of the scenes of options/}"""
    return {p: [r["predicted"] / r["measured"] for r in data.rows("scaling/users") if r["processes"] == p] for p in (1, 2)}


def goals():
    """Of each goal of Table 10 what was found, {what: numbers}, and the condition for all of them."""
    of = {kind: [find(data.evidence("strong", kind), column, scene="box3d", way=DIRECT)[32] for column in ("efficiency", "imbalance")] for kind in CLASSES}
    yield {kind: [math.prod(of[kind])] for kind in ("injected simulation", "critical path")}, lambda e: e >= 0.9
    yield {"counted": [data.modelled("disks", "balance", column="imbalance")[32]]}, lambda i: i <= 1.05
    for s, (p, bound) in itertools.product(BOXES, ((1024, 0.9), (32768, 0.88))):
        simulated = data.efficiency(s, "weak-large", "injected simulation").get(p)
        found = {"injected simulation": simulated, "closed form": data.short(s).efficiency(WEAK, p)}
        yield {kind: [e] for kind, e in found.items() if e}, lambda e, bound=bound: e >= bound
    yield {how: against(how) for how in WAYS}, lambda q: 0.9 <= q <= 1.1
    yield {"whole runs": sum(predicted().values(), [])}, lambda q: 0.85 <= q <= 1.15


# ---- docs/performance.md
def timings(group, *columns):
    """{(their values): ns a particle} of the rows of a group; of rows with the same values the first counts."""
    out = {}
    for r in data.rows(f"bench/{group}"):
        out.setdefault(tuple(r[c] for c in columns), r["min_ns"])
    return out


def table_presets():
    lines, t = [], timings("presets", "basis", "update", "processes")
    for r in (r for r in data.rows("bench/presets") if r["processes"] == 1):
        one, two = (t[r["basis"], r["update"], p] for p in (1, 2))
        lines.append([r["basis"], f"{r['dim']}-D", thousands(r["particles"]), f"`{r['update']}`", f"{one:.0f}", f"{1e3 / one:.1f}", f"{1e3 / two:.1f}", f"{one / two:.2f}", r["memory"]])
    return markdown(["scene", "", "particles", "preset", "ns a particle", "10^6 particles a second: 1 process", "2", "1 over 2 processes", "B a particle"], lines)


def one_over_two():
    """{(dimension, basis): [step on one process over those on two, with DMSwarmMigrate and with direct migration]}"""
    t = timings("ranks", "dim", "basis", "processes", "options")
    return {(d, b): [one / t[d, b, 2, how] for how in ("", "-parallel_migrate direct")] for (d, b, p, _), one in t.items() if p == 1}


def over_bare():
    """{(dimension, basis, particles): step over bare kernels}"""
    t = timings("bare", "program", "dim", "basis", "particles")
    return {key[1:]: t["pebble", *key[1:]] / ns for key, ns in t.items() if key[0] == "bare"}


def table_steps():
    lines, t, usual, kernels = [], timings("updates", "dim", "basis", "update"), timings("ranks", "dim", "basis"), over_bare()
    for (d, b), (two, direct) in one_over_two().items():
        one, over = usual[d, b], next(q for key, q in kernels.items() if key[:2] == (d, b) and key[2] > 5e5)
        ratios = two, direct, t[d, b, "usf"] / t[d, b, "usl"], t[d, b, "musl"] / t[d, b, "usl"], over
        lines.append([f"{d}-D {BASES[b]}", f"{one:.0f}", f"{1e3 / one:.0f}", f"{1e3 * two / one:.0f}", *(f"{q:.2f}" for q in ratios)])
    return markdown(["usl, 10^6 particles", "ns a particle", "10^6 particles a second: 1 process", "2", "1 over 2 processes", "with `direct`", "usf over usl, 10^5",
                     "musl over usl", "step over bare kernels"], lines)  # fmt: skip


def gains():
    """{what one would take instead: {work: times of pebble's step}}"""
    out, t, words = defaultdict(dict), timings("peers", "program", "update", "dim", "particles"), {"usl": "same scheme", "mls": "MLS-MPM"}
    for (program, update, d, n), ns in t.items():
        if program != "pebble":
            out[f"{program.capitalize()}, {words[update]}"][f"{d}-D, 10^{math.log10(n):.0f}"] = ns / t["pebble", "usl", d, n]
    t = timings("seed", "program", "update")
    return out | {f"the plain serial program, pebble with {update}": {"2-D, 10^5": t["seed_serial", "usf"] / t["pebble", update]} for update in ("usf", "usl")}


def table_gains():
    targets = {"Warp, same scheme": 2, "Taichi, same scheme": 7, "the plain serial program, pebble with usf": 8, "the plain serial program, pebble with usl": 15}
    cells = {(what, work): f"{q:.1f}" for what, found in gains().items() for work, q in found.items()}
    cells |= {(what, "target: met"): f"{n}: {sum(q >= n for q in gains()[what].values())} of {len(gains()[what])}" for what, n in targets.items()}
    return pivot(["in place of pebble"], cells)


# ---- Numbers
def numbers():
    """{name: text} of all numbers in the text."""
    simulated = find(data.evidence("strong", "injected simulation"), "seconds", "scene", processes=1)
    whole = predicted()
    needs = [short / full for by in least().values() for short, full in by.values()]
    two = sum(one_over_two().values(), [])
    out = {name: span(values) for name, values in {
        "two": [speedups(s, "strong", "measured")[2] for s in SCENES],
        "two_weak": [speedups(s, "weak", "measured")[2] for s in SCENES],
        "two_long": lengths(400).values(),
        "sure_critical": interval("critical path"),
        "swarm_two": migration("measured", 2).values(),
        "swarm_32": migration("critical path", 32).values(),
        "swarm_32_simulated": migration("injected simulation", 32).values(),
        "pool_two": [speedups(s, "strong", "measured", POOL)[2] for s in SCENES],
        "pool_best": [max(speedups(s, "strong", kind, POOL).values()) for kind in CLASSES[:3] for s in SCENES],
        "imbalance": [data.modelled("disks", "balance", column="imbalance")[32]],
        "apart_spatial": apart(DIRECT),
        "apart_pool": apart(POOL),
        "users_span": [1 / q for q in whole[1] + whole[2]],
        "c_simulated": [simulated[s] / data.constants(s)["T1"] for s in BOXES],
        "two_bench": two,
        "steady": [max(max(map(float, str(r["all_ns"]).split())) / r["min_ns"] for group in find("bench/machine", "name", "group") for r in data.rows(f"bench/{group}") if "all_ns" in r)],
    }.items()}  # fmt: skip
    for p in (8, 32):
        every = sum(all_classes(p).values(), [])
        out |= {f"e_{p}": span(every), f"s_{p}": span((p * e for e in every), "{:.1f}"), f"critical_{p}": span(all_classes(p)["critical path"])}
    for k, (found, good) in enumerate(goals(), 1):
        texts = {what: f"{q[0]:.3f}" if len(q) == 1 else f"{sum(map(good, q))} of {len(q)} ({span(q)})" for what, q in found.items()}
        out[f"goal_{k}"] = "; ".join(f"{what}: {text}" for what, text in texts.items())
    phases = [find("scaling/phases", "mean_seconds", "phase", scene=s, study="strong", strategy="serial") for s in BOXES]
    out |= {f"share_{name}": span((100 * by[name] / sum(by.values()) for by in phases), "{:.0f}") for name in phases[0]}
    out |= {f"serial_{s[-2:]}": f"{1e9 * data.constants(s)['C']:.0f}" for s in BOXES}
    out |= {f"{word}_{p}": inside(some, low, high) for word, low, high in (("users", 0.85, 1.15), ("factor", 1 / 1.3, 1.3)) for p, some in whole.items()}
    out |= {f"dam_{n}": f"{lengths(n)['dambreak3d']:.2f}" for n in (40, 400)}
    most = [data.short(s).most(data.constants(s)["particles"]) for s in SCENES]
    times = {word: [q for what, by in gains().items() if word in what for q in by.values()] for word in ("serial", "with usf", "Warp")}
    return out | {
        "fastest": f"{thousands(min(most), 3)} to {thousands(max(most), 3)}",
        "least_apart": span(needs, "{:.1f}"),
        "bits": f"{len(digests())} scenes and sizes, {sum(n for n, _ in digests())} runs",
        "overtakes": f"{float(f'{1e6 * overtakes():.2g}'):g}" if overtakes() else "no cost",
        "counts": str(len(data.rows("scaling/counts"))),
        "machine_real": find("scaling/machine", "value", "name")["program"],
        "told": inside([r["measured"] / r["predicted"] for r in data.rows("bench/predicted")], 0.67, 1.5),
        "two_below": inside(two, 0, 1.85),
        "over_bare": span(over_bare().values(), "{:.1f}"),
        "bench_when": find("bench/machine", "value", "group", name="when")["bare"][:10],
        "twin": span(times["serial"], "{:.0f}"),
        "plain": span(times["with usf"], "{:.1f}"),
        "warp": span(times["Warp"], "{:.1f}"),
    }
