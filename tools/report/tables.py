"""The tables and the numbers in the text of docs/report.md and docs/model.md, all from docs/data: table_NAME and
number_NAME make what stands at the mark NAME. Numbers of one group are made by a function of their own, in NUMBERS."""

import math
from collections import defaultdict

import data
from data import BOXES, CLASSES, DIRECT, POOL, PROCESSES, SCENES, SWARM, WAYS, WEAK, title
from marks import markdown

SHARES = (1e5, 1e9), (0, 1e5)  # particles a process of the runs on two processes: strong scaling, and weak or smaller
# The critical paths that were probably disturbed: more processes had higher efficiencies, or nearly so.
DISTURBED = {("disks", "weak", 4), ("disks", "weak", 8), ("disks3d", "weak", 8), ("disks3d", "weak", 16)}
GOAL, STEP = (0.9, 1.1), (0.85, 1.15)  # closed form over simulation, predicted over measured


def thousands(n):
    return f"{int(n):,}".replace(",", " ")


def three(x):
    return f"{x:.3g}" if x < 99.95 else thousands(round(x))


def seconds(t):
    return f"{1e6 * t:.0f} µs" if t < 9.995e-4 else f"{1e3 * t:.3g} ms"


def span(values, digits="{:.2f}"):
    """The least and the largest, or the only one."""
    values = list(values)
    return " to ".join(dict.fromkeys(digits.format(v) for v in (min(values), max(values))))


def inside(ratios, low, high):
    return f"{sum(low <= q <= high for q in ratios)} of {len(ratios)}"


def speedups(scene, study, kind, how=DIRECT):
    return {p: p * e for p, e in data.efficiency(scene, study, kind, how).items()}


# ---- The first page
def all_classes(processes):
    """Efficiencies of strong scaling, direct, of all scenes, in all classes."""
    return {kind: [data.efficiency(s, "strong", kind)[processes] for s in SCENES] for kind in CLASSES}


def table_answer():
    lines = []
    for s in SCENES:
        cells = [title(s), thousands(data.constants(s)["particles"]), three(speedups(s, "strong", "measured")[2])]
        cells += [three(speedups(s, "strong", kind)[p]) for p in (8, 32) for kind in CLASSES]
        lines.append(cells)
    head = [f"{p}: {kind.replace(' simulation', '')}" if kind == CLASSES[0] else kind.replace(" simulation", "") for p in (8, 32) for kind in CLASSES]
    return markdown(["scene", "particles", "on 2, measured", *head], lines)


def interval(kind, pool=False, shares=SHARES[0]):
    return [q["efficiency"] for q in data.pairs(kind) if (q["way"] == POOL) == pool and shares[0] <= q["share"] < shares[1]]


def table_sure():
    words = {
        "critical path": ("the network; most waiting; competition for memory of more than two cores", "caches that are cold after each turn"),
        "closed form": ("disturbances; waiting, except by imbalance", ""),
        "injected simulation": ("caches; competition for memory; disturbances", ""),
        "emulated simulation": ("competition for memory", "all processes in the caches of one core"),
    }
    lines = []
    for kind in CLASSES:
        found = [interval(kind, pool, shares) for pool in (False, True) for shares in SHARES]
        lines.append([kind, *(f"{span(some)} ({len(some)})" for some in found), *words[kind]])
    head = ["class", "spatial, 100 000 or more a process", "spatial, 8 000 to 17 000", "pool, 100 000 or more", "pool, 8 000 to 17 000", "leaves out", "adds"]
    return markdown(head, lines)


def two_processes():
    lengths = {(r["scene"], r["processes"], r["steps"]): r["seconds_per_step"] for r in data.rows("scaling/lengths.csv")}
    measured = {study: [speedups(s, study, "measured")[2] for s in SCENES] for study in ("strong", "weak")}
    long, few = ([lengths[s, 1, n] / lengths[s, 2, n] for s in SCENES] for n in (400, 40))
    return {
        "two": span(measured["strong"]), "two_weak": span(measured["weak"]), "two_long": span(long), "two_short": span(few),
        "dam_long": f"{long[list(SCENES).index('dambreak3d')]:.2f}", "dam_short": f"{few[list(SCENES).index('dambreak3d')]:.2f}",
        "swarm_two": span(migration()["measured", 2]), "swarm_32": span(migration()["critical path", 32]),
        "swarm_32_simulated": span(migration()["injected simulation", 32]),
    }  # fmt: skip


def headline():
    out = {}
    for p in (8, 32):
        found = all_classes(p)
        every = [e for some in found.values() for e in some]
        out |= {f"e_{p}": span(every), f"s_{p}": span((p * e for e in every), "{:.1f}")}
        out |= {f"{kind.split()[0]}_{p}": span(some) for kind, some in found.items()}
    out |= {f"sure_{kind.split()[0]}": span(interval(kind)) for kind in CLASSES}
    out["few_injected"] = span(interval("injected simulation", shares=SHARES[1]))
    some = [q for q in data.pairs("critical path") if q["way"] != POOL]
    out["path_above"] = f"{sum(q['efficiency'] < 1 for q in some)} of {len(some)}"
    return out


# ---- Mathematics and serial program
LADDERS = (
    ("usf, flip (the assignment)", "linear"),
    ("musl, flip", "linear"),
    ("musl, flip", "quadratic B-spline"),
    ("usl, aflip", "quadratic B-spline"),
    ("preset balanced (the default)", "cubic B-spline"),
    ("usl, aflip", "GIMP, stretched"),
)


def ladder(method, basis):
    return {r["cells"]: float(r["error"]) for r in data.rows("ladders.csv") if (r["method"], r["basis"]) == (method, basis)}


def table_orders():
    lines, sizes = [], sorted({r["cells"] for r in data.rows("ladders.csv")})
    for method, basis in LADDERS:
        e = ladder(method, basis)
        cells = [("" if n not in e else f"{100 * e[n]:.2g} %" if math.isfinite(e[n]) else "stops") for n in sizes]
        a, b = list(e.values())[-2:]
        lines.append([basis, method, *cells, f"{math.log2(a / b):.1f}" if math.isfinite(b) else ""])
    return markdown(["basis", "update, transfer", *(f"{n} cells" for n in sizes), "last order"], lines)


def serial():
    floor = [r for r in data.rows("bench/seed.csv") if r["update"] == "usf"]
    ratios = []
    for n in {r["particles"] for r in floor}:
        ns = {r["program"]: r["min_ns"] for r in floor if r["particles"] == n}
        ratios.append(ns["seed_serial"] / ns["pebble"])
    out = {f"serial_{s[-2:]}": f"{1e9 * data.constants(s)['C']:.0f}" for s in BOXES}
    return out | {"plain": span(ratios, "{:.1f}"), "imbalance": f"{data.modelled('disks', 'balance', 'spatial direct', 'imbalance')[32]:.2f}"}


# ---- The model
def table_constants():
    lines = []
    for s in SCENES:
        c = data.constants(s)
        five = f"{1e9 * c['C']:.1f} ns", f"{1e6 * c['L']:.1f} µs", f"{1e9 * c['B']:.0f} ns", f"{1e6 * c['R']:.1f} µs", f"{1e9 * c['M']:.1f} ns"
        lines.append([title(s), thousands(c["particles"]), seconds(c["T1"]), *five, c["patch"], f"{data.short(s).bound():.2f}"])
    return markdown(["scene", "N", "T(1), measured", "C", "L", "B", "R", "M", "patch, cells", "bound C/M"], lines)


def table_least():
    """Isoefficiency by the short and the full model, side by side."""
    lines = []
    for s in BOXES:
        for e in (0.8, 0.9):
            full = data.kept(s, e)
            lines.append([title(s), e, "short", *(thousands(float(f"{data.short(s).least(e, p):.3g}")) for p in full)])
            lines.append([title(s), e, "full", *map(thousands, full.values())])
    return markdown(["scene", "efficiency", "model", *map(thousands, data.kept("box2d", 0.8))], lines)


def cubes(scene, how, processes):
    return data.modelled(scene, "cubes", f"spatial {how}")[processes]


def least_ratios():
    some = {(s, e, p): data.short(s).least(e, p) / n for s in BOXES for e in (0.8, 0.9) for p, n in data.kept(s, e).items()}
    return {"least_apart": span(some.values(), "{:.1f}"), "least_2d": span((q for (s, *_), q in some.items() if s == "box2d"), "{:.1f}"),
            "least_far": span((q for (_, _, p), q in some.items() if p >= 1024), "{:.2f}")} | {
            f"million_{how}": span((cubes(s, how, 2**20) for s in BOXES)) for how in ("direct", "swarm")}  # fmt: skip


def distances(study="strong"):
    """Short over full model: (ratio, scene, way, processes)."""
    for s in SCENES:
        for how, word in ((DIRECT, "spatial direct"), (POOL, "pool")):
            full, closed = data.modelled(s, study, word), data.efficiency(s, study, "closed form", how)
            yield from ((closed[p] / full[p], s, how, p) for p in full)


def apart():
    out = {}
    for name, how in (("spatial", DIRECT), ("pool", POOL)):
        some = [q for q, _, h, _ in distances() if h == how]
        out |= {f"apart_{name}": span(some), f"apart_{name}_5": inside(some, 0.95, 1.05)}
    return out


def table_example():
    s, total, lines = data.short("box2d"), data.constants("box2d")["particles"], []
    for p in (1, *PROCESSES[1:], 128, 1024):
        n = total / p
        parts = [s.C * n, *((s.L, s.B * math.sqrt(n), s.R * math.log2(p)) if p > 1 else (0, 0, 0))]
        full = [data.modelled("box2d", "strong", how).get(p) for how in ("spatial direct", "pool")]
        both = [f"{p * e:.2f}" if e else "" for e in full]
        lines.append([p, *(f"{1e6 * t:.1f}" for t in (*parts, sum(parts))), *(f"{x:.2f}" for x in (s.speedup(total, p), s.speedup(total, p) / p)),
                      both[0], f"{s.pool(p):.2f}", both[1]])  # fmt: skip
    return markdown(["P", "C n, µs", "L, µs", "B √n, µs", "R log2 P, µs", "T, µs", "S", "E", "S, full model", "S, pool", "pool, full model"], lines)


def table_limits():
    lines = []
    for name in SCENES:
        s = data.short(name)
        least = [thousands(float(f"{s.least(0.8, p):.3g}")) for p in (32, 1024, 32768)]
        lines.append([title(name), thousands(float(f"{s.most(data.constants(name)['particles']):.3g}")), *least, f"{s.bound():.2f}", f"{1 + s.bound():.1f}"])
    return markdown(["scene", "P of the largest S", "n for E = 0.8 on 32", "on 1 024", "on 32 768", "the pool's bound", "its workers"], lines)


# ---- Results
def table_scenes():
    basis, lines = {"linear": "linear", "bspline2": "quadratic"}, []
    for r in data.rows("scaling/scenes.csv"):
        sizes = [min(q["particles"] for q in data.runs(study, "measured") if q["scene"] == r["scene"]) for study in ("strong", "weak")]
        what = f"{basis[r['basis']]}, {r['update']}"
        real = next(q["pool_cells"] for q in data.runs("strong", "measured") if (q["scene"], q["way"]) == (r["scene"], POOL))
        patches = f"{real}; {data.constants(r['scene'])['patch']}"
        lines.append([title(r["scene"]), what, r["cells"].replace("x", " x "), "; ".join(map(thousands, sizes)), patches, r["motion"]])
    return markdown(["scene", "basis, update", "cells, strong scaling", "particles: strong; weak on 1", "cells of a patch: real; simulated", "motion at the start"], lines)


def scaling(kind, first=()):
    """Lines of speed-ups on 1 to 32 processes, strong and weak, of all ways. first: numbers of processes for which the
    measured speed-up has a column of its own."""
    lines = []
    for study in ("strong", "weak"):
        for s in SCENES:
            for how in WAYS:
                found, real = speedups(s, study, kind, how), speedups(s, study, "measured", how)
                if not found:
                    continue
                star = {p: " *" * ((s, study, p) in DISTURBED and how == DIRECT) for p in PROCESSES}
                cells = [f"{found[p]:.2f}{star[p]}" if p in found else "" for p in PROCESSES[1:]]
                lines.append([study, title(s), how, "1", *(f"{real[p]:.2f}" if p in real else "" for p in first), *cells])
    return lines


def table_all():
    return markdown(["scaling", "scene", "way", *map(str, PROCESSES)], scaling("injected simulation"))


def table_path():
    return markdown(["scaling", "scene", "way", "1", "2, measured", *map(str, PROCESSES[1:])], scaling("critical path", (2,)))


def table_large():
    """Injected simulation on 64 to 1024 processes."""
    groups = defaultdict(dict)
    for study in ("weak-large", "strong-large"):
        for r in data.simulations(study, "injected simulation"):
            if r["processes"] > 1:
                groups[study.split("-")[0], r["scene"], r["way"] + ", racks of 32" * (r["platform"] == "fattree")][r["processes"]] = r
    lines = []
    for (study, s, how), by in groups.items():
        n = next(r["particles"] // (r["processes"] if study == "weak" else 1) for r in by.values())
        lines.append([study, title(s), how, thousands(n), *(f"{by[p]['efficiency']:.2f}" if p in by else "" for p in (64, 128, 256, 512, 1024))])
    return markdown(["scaling", "scene", "way", "particles: strong in all, weak a process", "64", "128", "256", "512", "1 024"], lines)


def migration():
    """{(class, processes): steps with DMSwarmMigrate over those with direct migration, strong scaling}"""
    out = defaultdict(list)
    for kind in ("measured", "critical path", "injected simulation"):
        t = {(r["scene"], r["way"], r["processes"]): r["seconds"] for r in data.evidence("strong", kind)}
        for (s, how, p), seconds in t.items():
            if how == SWARM:
                out[kind, p].append(seconds / t[s, DIRECT, p])
    return out


def kept_by_simulation(scene, level=0.8):
    """{processes: least particles a process with which all simulated runs on up to so many keep an efficiency}"""
    known = [(r["particles"] // r["ranks"], r["ranks"], r["efficiency"]) for study in ("strong", "weak", "strong-large", "weak-large")
             for r in data.evidence(study, "injected simulation") if (r["scene"], r["way"]) == (scene, DIRECT)]  # fmt: skip
    out = {}
    for p in sorted({p for _, p, _ in known}):
        worst = max((n for n, q, e in known if q <= p and e < level), default=0)
        if enough := [n for n, q, e in known if q == p and n > worst and e >= level]:
            out[p] = min(enough)
    return out


def kept_words(scene):
    last = {n: p for p, n in kept_by_simulation(scene).items()}  # the most processes for each number of particles
    return " and ".join(f"{thousands(n)} particles a process on up to {thousands(p)}" for n, p in sorted(last.items()) if p >= 32)


def digests():
    """For each scene, study, particles and steps that ran in several ways: numbers of runs and of different digests."""
    groups = defaultdict(list)
    for r in data.rows("scaling/runs.csv"):
        if r["digest"] != "" and r["class"] != "oversubscribed":
            groups[r["scene"], r["study"], r["particles"], r["steps"]].append(r)
    for some in groups.values():
        runs = {(r["strategy"], r["migrate"], r["processes"]) for r in some}
        if len(runs) > 1:
            yield len(runs), len({str(r["digest"]) for r in some})


def pool_best(kind):
    return [max(speedups(s, "strong", kind, POOL).values()) for s in SCENES]


def overtakes(scene="box3d", processes=32):
    """The cost of the law, s, from which on the pool is ahead of spatial decomposition by the closed form, or None."""
    short, total = data.short(scene), data.constants(scene)["particles"]
    i = data.modelled(scene, "strong", "spatial direct", "imbalance")[processes]
    for k in range(121):
        d = data.replace(short, C=short.C + 1e-9 * 10 ** (k / 20))
        if d.pool(processes) > d.speedup(total, processes, i):
            return 1e-9 * 10 ** (k / 20)
    return None


def results():
    found = list(digests())
    weak = {how: data.efficiency("box2d", "weak-large", "injected simulation", how)[256] for how in (DIRECT, SWARM)}
    migrating = [r for r in data.runs("strong", "critical path") if (r["processes"], r["way"]) == (32, SWARM) and r["scene"] in BOXES]
    return {
        "bits": f"{len(found)} scenes and sizes, {sum(n for n, _ in found)} runs",
        "direct_256": f"{weak[DIRECT]:.2f}", "swarm_256": f"{weak[SWARM]:.2f}",
        "migrating": " and ".join(f"{r['migrating_steps']} of {r['steps']}" for r in migrating),
        "kept_2d": kept_words("box2d"), "kept_3d": kept_words("box3d"),
        "pool_two": span(speedups(s, "strong", "measured", POOL)[2] for s in SCENES),
        "pool_path": span(pool_best("critical path")), "pool_injected": span(pool_best("injected simulation")),
        "pool_closed": span(pool_best("closed form")),
        "overtakes": f"{float(f'{1e6 * overtakes():.2g}'):g}" if overtakes() else "no cost",
        "counts": str(len(data.rows("scaling/counts.csv"))),
        "machine_real": next(r["value"] for r in data.rows("scaling/machine.csv") if r["name"] == "program"),
    }  # fmt: skip


# ---- Is the model right?
def against(how, scenes=BOXES):
    """Efficiency by the full model over that of the injected simulation, 2 to 32 processes, strong and weak."""
    word = {DIRECT: "spatial direct", SWARM: "spatial swarm", POOL: "pool"}[how]
    for study in ("strong", "weak"):
        for s in scenes:
            full, simulated = data.modelled(s, study, word), data.efficiency(s, study, "injected simulation", how)
            yield from (full[p] / simulated[p] for p in full if p in simulated)


def predicted():
    """Predicted over measured steps of the scenes of options/: of short runs, and {processes: those of whole runs}."""
    short = [r["predicted"] / r["seconds_per_step"] for r in data.rows("scaling/validation.csv")]
    whole = {p: [r["predicted"] / r["measured"] for r in data.rows("scaling/users.csv") if r["processes"] == p] for p in (1, 2)}
    return short, whole


def path_ratios():
    """Critical path over closed form: efficiencies of spatial decomposition on 4 to 32 processes."""
    for study in ("strong", "weak"):
        for s in SCENES:
            closed = data.efficiency(s, study, "closed form")
            yield from (e / closed[p] for p, e in data.efficiency(s, study, "critical path").items() if p >= 4)


def goals():
    """Rows of the table: number, goal, found, verdict."""
    lines = []

    def add(goal, words, met):
        lines.append([len(lines) + 1, goal, words, "met" if met else "**missed**"])

    rows = {kind: {(r["scene"], r["processes"], r["way"]): r for r in data.evidence("strong", kind)} for kind in ("injected simulation", "critical path")}
    found = {kind: by["box3d", 32, DIRECT] for kind, by in rows.items()}
    add("strong efficiency times imbalance at least 0.90: filled box, 3-D, 8 000 particles a process, 32 processes",
        "; ".join(f"{kind}: {r['efficiency'] * r['imbalance']:.2f}" for kind, r in found.items()), all(r["efficiency"] * r["imbalance"] >= 0.9 for r in found.values()))  # fmt: skip
    add("imbalance at most 1.05: two disks on 1024 x 1024 cells, 32 processes", f"{serial()['imbalance']}, counted", float(serial()["imbalance"]) <= 1.05)
    for s in BOXES:
        for p, bound in ((1024, 0.9), (32768, 0.88)):
            some = {"injected simulation": data.efficiency(s, "weak-large", "injected simulation").get(p), "closed form": data.short(s).efficiency(WEAK, p), "full model": cubes(s, "direct", p)}
            some = {kind: e for kind, e in some.items() if e}
            add(f"weak efficiency at least {bound:.2f}: {title(s)}, {thousands(WEAK)} particles a process, {thousands(p)} processes",
                "; ".join(f"{kind}: {e:.3f}" for kind, e in some.items()), all(e >= bound for e in some.values()))  # fmt: skip
    some = {how: list(against(how)) for how in WAYS}
    add("full model within 10 % of the injected simulation, filled boxes, 2 to 32 processes",
        "; ".join(f"{how}: {inside(q, *GOAL)} ({span(q)})" for how, q in some.items()), all(GOAL[0] <= x <= GOAL[1] for q in some.values() for x in q))  # fmt: skip
    short, whole = predicted()
    everyone = whole[1] + whole[2]
    add("predicted within 15 % of the measured step, the scenes of `options/` (16 when it was set, 24 in the data) on 1 and 2 processes",
        f"short runs in turns with the calibration: {inside(short, *STEP)}; whole runs as users start them: {inside(everyone, *STEP)}",
        all(STEP[0] <= q <= STEP[1] for q in short + everyone))  # fmt: skip
    return lines


def table_goals():
    return markdown(["", "goal (all set by commit 194835d, 2026-11-21)", "found", ""], goals())


def validation():
    short, whole = predicted()
    met, words = sum(line[-1] == "met" for line in goals()), "None One Two Three Four Five Six Seven Eight".split()
    return {
        "goals_met": f"{words[met]} of the eight goals {'is' if met == 1 else 'are'} met",
        "short_runs": inside(short, *STEP), "short_span": span(short),
        "users_one": inside(whole[1], *STEP), "users_two": inside(whole[2], *STEP), "users_span": span(1 / q for q in whole[1] + whole[2]),
        "path_closed": span(path_ratios()),
    } | {f"against_{name}": f"{inside(q, *GOAL)} ({span(q)})" for name, q in (
        ("direct", list(against(DIRECT))), ("swarm", list(against(SWARM))), ("pool", list(against(POOL))))}  # fmt: skip


# ---- docs/performance.md
PRESETS = {"fast": "bs2 usl flip", "balanced": "bs3 usl aflip 1", "accurate": "bs3 usl afmpm", "energy": "bs3 musl flip", "solid": "bs2 total 2"}
WORK = (2, 99225), (2, 998001), (3, 97336), (3, 1000000)  # dimension and particles of the peers' scenes


def timed(group, **which):
    """The row of docs/data/bench for these columns."""
    return next((r for r in data.rows(f"bench/{group}.csv") if all(r[k] == v for k, v in which.items())), None)


def table_presets():
    cost = {(r["dim"], r["method"]): r for r in data.rows("method_cost.csv")}
    lines = []
    for preset, method in PRESETS.items():
        both = [cost[dim, method] for dim in (2, 3)]
        lines.append([f"`{preset}`", *(f"{r['ratio'] / cost[r['dim'], PRESETS['balanced']]['ratio']:.2f}" for r in both), *(r["bytes"] for r in both)])
    return markdown(["preset", "step over that of `balanced`, 2-D", "3-D", "state of a particle, 2-D, B", "3-D, B"], lines)


def table_steps():
    names, lines = {"linear": "linear", "bspline2": "quadratic", "bspline3": "cubic", "gimp": "GIMP"}, []
    for usl in (r for r in data.rows("bench/ranks.csv") if r["processes"] == 1):
        which = dict(dim=usl["dim"], basis=usl["basis"])
        two = [timed("ranks", **which, processes=2, options=o)["min_ns"] for o in ("", "-parallel_migrate direct")]
        few = {u: timed("updates", **which, update=u)["min_ns"] for u in ("usl", "usf", "musl")}
        kernels = [timed("bare", program=p, particles=usl["particles"], **which)["min_ns"] for p in ("pebble", "bare")]
        lines.append([f"{usl['dim']}-D {names[usl['basis']]}", f"{usl['min_ns']:.0f}", f"{1e3 / usl['min_ns']:.0f}", f"{1e3 / two[0]:.0f}", *(f"{usl['min_ns'] / t:.2f}" for t in two),
                      *(f"{few[u] / few['usl']:.2f}" for u in ("usf", "musl")), f"{kernels[0] / kernels[1]:.2f}"])  # fmt: skip
    head = ["usl, 10^6 particles", "ns a particle", "10^6 particles a second: 1 process", "2", "1 over 2 processes", "with `direct`", "usf over usl, 10^5", "musl over usl", "step over bare kernels"]
    return markdown(head, lines)


def gains():
    """{what one would take instead: times of pebble's step in the scenes of WORK, or None}"""
    words, out = {"usl": "same scheme", "mls": "MLS-MPM"}, {}
    for program, target in (("warp", 2), ("taichi", 7)):
        for scheme in words:
            row = out[f"{program.capitalize()}, {words[scheme]}", target if scheme == "usl" else None] = []
            for dim, n in WORK:
                ours, theirs = (timed("peers", program=p, update=u, dim=dim, particles=n) for p, u in (("pebble", "usl"), (program, scheme)))
                row.append(theirs["min_ns"] / ours["min_ns"])
    for update, target in (("usf", 8), ("usl", 15)):
        twin = [timed("seed", program="seed_serial", particles=99856)["min_ns"] / timed("seed", program="pebble", update=update, particles=99856)["min_ns"]]
        out[f"the plain serial program, pebble with {update}", target] = [*twin, None, None, None]
    return out


def table_gains():
    lines = []
    for (what, target), found in gains().items():
        met = f"{target}: {sum(q >= target for q in found if q)} of {sum(q is not None for q in found)}" if target else ""
        lines.append([what, *(f"{q:.1f}" if q else "" for q in found), met])
    return markdown(["in place of pebble", "2-D, 10^5 particles", "2-D, 10^6", "3-D, 10^5", "3-D, 10^6", "target: met"], lines)


def on_two():
    one = [r for r in data.rows("bench/ranks.csv") if r["processes"] == 1]
    some = [r["min_ns"] / q["min_ns"] for r in one for q in data.rows("bench/ranks.csv") if (q["dim"], q["basis"], q["processes"]) == (r["dim"], r["basis"], 2)]
    bare = [timed("bare", program="pebble", dim=r["dim"], basis=r["basis"], particles=r["particles"])["min_ns"] / r["min_ns"] for r in data.rows("bench/bare.csv") if r["program"] == "bare" and r["particles"] > 5e4]
    short, whole = predicted()
    return {"two_bench": span(some), "two_below": inside(some, 0, 1.85), "over_bare": span(bare, "{:.1f}"), "bench_when": next(r["value"] for r in data.rows("bench/machine.csv") if r["name"] == "when")[:10],
            "twin": span((q[0] for (what, _), q in gains().items() if "serial" in what), "{:.0f}"), "users_one_span": span(1 / q for q in whole[1])}  # fmt: skip


def numbers():
    """{name: text} of all numbers."""
    out = {}
    for group in (two_processes, headline, serial, least_ratios, apart, results, validation, on_two):
        out |= group()
    return out
