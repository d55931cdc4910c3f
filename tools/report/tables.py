"""The tables of docs/report.md: table_NAME makes the table NAME, as Markdown."""

import csv
import math
import os
import re

import marks
import model
from closed import BOXES, FAR, WEAK, ClosedForm, way
from data import ROOT, Missing
from data import rows as rows_of

PROCESSES = (1, 2, 4, 8, 16, 32)
SIMULATOR = 0.88, 1.06  # the goal of simulated over measured times
NAMES = {
    "box2d": "filled box, 2-D",
    "box3d": "filled box, 3-D",
    "disks": "two disks",
    "disks3d": "two balls, 3-D",
    "dambreak": "dam break",
    "dambreak3d": "dam break, 3-D",
    "column": "sand column",
    "bar": "bar",
}


TRANSPORT = {"": "", "shared": "shared memory", "tcp": "TCP"}


def scene(name):
    return NAMES.get(name, str(name))


def group(rows, key):
    out = {}
    for row in rows:
        out.setdefault(key(row), []).append(row)
    return out


def two(x):
    return "" if x is None or x == "" else f"{x:.2f}"


def seconds(t):
    return f"{1e6 * t:.0f} µs" if t < 9.995e-4 else f"{1e3 * t:.3g} ms"


def thousands(n):
    return f"{int(n):,}".replace(",", " ")


def inside(ratios, low, high):
    """In words, the range of these ratios, and how many are inside the bounds."""
    return f"{min(ratios):.2f} to {max(ratios):.2f}, {sum(low <= q <= high for q in ratios)} of {len(ratios)} inside"


class Tables(ClosedForm):
    def table_answer(self):
        """Says which strategy, at how many processes, suits which scene: a line for each scene, with one number of processes."""
        scenes, lacking = {}, []  # {(scene, is it the large one): {class: {processes: {way: row}}}}
        for large, rows, p, kind in (
            (False, lambda: self.simulated("strong", "injected"), "ranks", "simulated"),
            (False, lambda: self.real("strong"), "processes", ""),
            (True, lambda: self.simulated("strong-large", "injected"), "ranks", "simulated"),
        ):
            try:
                for r in rows():
                    found = scenes.setdefault((r["scene"], large), {}).setdefault(r.get("class", kind), {})
                    found.setdefault(r[p], {})[way(r)] = {**r, "speedup": r["efficiency"] * r[p]}
            except Missing as m:
                lacking.append(str(m))
        if not scenes:
            raise Missing("; ".join(lacking))

        def keeps(runs):
            """The most processes up to which all runs, spatial and direct, have an efficiency of 0.8; and whether it is the most tried."""
            tried = sorted(p for p in runs if "spatial, direct" in runs[p])
            low = [p for p in tried if runs[p]["spatial, direct"]["efficiency"] < 0.8]
            kept = [p for p in tried if not low or p < low[0]]
            return max(kept, default=1), kept == tried

        lines = []
        order = [name for name, _ in scenes]
        for (name, _), found in sorted(scenes.items(), key=lambda f: (order.index(f[0][0]), f[0][1])):
            kind = "simulated" if "simulated" in found else "critical path"
            runs = found[kind]
            p, most = keeps(runs)
            row = next(iter(runs[p if p in runs else min(runs)].values()))
            ways = {how: r["speedup"] for how, r in runs.get(p, {}).items() if how != "spatial, DMSwarmMigrate"}
            use = max(ways, key=ways.get, default="one process")
            two_ = found.get("measured", {}).get(2, {}).get("spatial, direct")
            pools = []
            for k in ("measured", "simulated"):
                if some := {n: ways["pool"]["speedup"] for n, ways in found.get(k, {}).items() if "pool" in ways}:
                    n = max(some, key=some.get)
                    pools.append(f"{some[n]:.2f} on {n}, {k}")
            edge = str(keeps(found["critical path"])[0]) if "critical path" in found else ""
            speedup = f"{ways[use]:.3g}" if ways else "1"
            first = thousands(p) + (" or more" if most else "")
            each = thousands(row["particles"] / p)
            measured = f"{two_['speedup']:.3g}" if two_ else ""
            lines.append([scene(name), thousands(row["particles"]), use, first, speedup, kind, each, edge, measured, "; ".join(pools)])
        head = "scene", "particles", "use", "recommended processes", "speed-up on these", "evidence of that", "particles a process"
        head += "processes by the critical path, the pessimistic estimate", "speed-up on 2 processes, measured", "the pool at best: speed-up"
        text = marks.markdown(head, lines)
        for what in lacking:
            self.note("answer", what)
            text += f"\n\n*Not in the table: {what}.*"
        return text

    def table_goals(self):
        lines = []

        def goal(text, make):
            try:
                found = make()
            except Missing as m:
                self.note("goals", str(m))
                lines.append([text, "no data", "", "open", "", ""])
                return
            for value_, kind, met, *more in found:
                verdict = met if isinstance(met, str) else "other size" if met is None else "met" if met else "**missed**"
                lines.append([text, value_, kind, verdict, *more, *[""] * (2 - len(more))])
                text = ""

        def assumed(rows, p, kind, most):
            """ns a particle and step on one process, in these rows; and the efficiency with DMSwarmMigrate on the largest number of
            processes up to `most`."""
            one = [r for r in rows if r[p] == 1 and r.get("class", "simulated") == kind]
            base = min(one, key=lambda r: r["particles"], default=None)
            rows = [r for r in rows if 1 < r[p] <= most and r.get("class", "simulated") == kind]
            swarm = max((r for r in rows if way(r) == "spatial, DMSwarmMigrate"), key=lambda r: r[p], default=None)
            return (
                f"{1e9 * base['seconds_per_step'] / base['particles']:.0f}" if base else "",
                f"{swarm['efficiency']:.2f}" + ("" if swarm[p] == most else f" on {swarm[p]}") if swarm else "",
            )

        def strong(name, bound=None):
            found, lacking = [], []
            for of, rows, p in (
                ("scaling", lambda: self.real("strong"), "processes"),
                (
                    "simulated",
                    lambda: [r for r in self.data.simulated("strong") if r["scene"] == name and r["mode"] == "injected"],
                    "ranks",
                ),
            ):
                try:
                    some = [r for r in rows() if r["scene"] == name and r[p] in (1, 32)]
                    for r in some:
                        if r[p] == 32 and way(r) == "spatial, direct":
                            net, n = r["efficiency"] * r["imbalance"], r["particles"] / 32
                            found.append(
                                (
                                    f"{thousands(n)} a process: {net:.2f} net, {r['efficiency']:.2f} gross",
                                    r.get("class", "simulated"),
                                    "no goal" if not bound else net >= bound if abs(n / 8000 - 1) < 0.3 or net >= bound else None,
                                    *assumed(some, p, r.get("class", "simulated"), 32),
                                )
                            )
                except Missing as m:
                    lacking.append(m)
            if not found:
                raise lacking[0] if lacking else Missing(f"no row of {scene(name)} on 32 processes")
            return found

        def imbalance():
            found = self.imbalance("options/disks.opts", "-grid_cells", "1024,1024")
            return [(f"{found:.3f}", "counted: exact on any machine", found <= 1.05)]

        def gross_net(e, imbalance):
            return f"{e:.3f} gross, {e * imbalance:.3f} net"

        def weak(name, p, bound):
            rows = []
            for study in ("weak", "weak-large"):
                try:
                    rows += [
                        r
                        for r in self.data.simulated(study)
                        if r["scene"] == name
                        and r["mode"] == "injected"
                        and r["strategy"] == "spatial"
                        and r["platform"] == "cluster"
                    ]
                except Missing:
                    pass
            direct = [r for r in rows if way(r) == "spatial, direct"]
            found, most = [], max((r["ranks"] for r in direct), default=0)
            for r in direct:
                if r["ranks"] == p or (r["ranks"] == most < p == 1024):
                    met = r["efficiency"] >= bound
                    found.append(
                        (
                            gross_net(r["efficiency"], r["imbalance"]) + ("" if r["ranks"] == p else f", on {r['ranks']}"),
                            "simulated",
                            met if r["ranks"] == p or not met else None,
                            *assumed(rows, "ranks", "simulated", r["ranks"]),
                        )
                    )
            try:
                e, imbalance = self.boxes(name, p)
                one = 1e9 * self.simulated_alone(name) / WEAK
                swarm = two(self.boxes(name, p, True)[0])
                found.append((gross_net(e, imbalance), "closed form, as simulated", e >= bound, f"{one:.0f}", swarm))
                e, m = self.weak(name, WEAK, p), self.closed(name)
                one = 1e9 * m.step(m.cube(WEAK, 2**m.dim, 1, self.moved(name))) / WEAK
                found.append((f"{e:.3f}", "closed form", e >= bound, f"{one:.0f}", two(self.weak(name, WEAK, p, True))))
            except Missing as m:
                if not found:
                    raise
                self.note("goals", str(m))
            return found

        def simulation():
            found = []
            for which in ("spatial, direct", "spatial, DMSwarmMigrate", "pool"):
                rows = self.against_simulation(which)
                worst = max(rows, key=lambda r: abs(r[5] / r[4] - 1))
                found.append(
                    (
                        f"{which}: {sum(abs(r[5] / r[4] - 1) <= 0.1 for r in rows)} of {len(rows)} runs on 2 to"
                        f" {max(r[2] for r in rows)} processes inside; largest difference {100 * (worst[5] / worst[4] - 1):+.1f} %"
                        f" ({scene(worst[0])}, {worst[1]}, {worst[2]})",
                        "closed form / simulated",
                        abs(worst[5] / worst[4] - 1) <= 0.1,
                    )
                )
            return found

        def validation():
            rows = [r for r in self.data.validation() if r.get("processes", 1) in (1, 2) and (r.get("strategy") != "pool")]
            ratios = [(r["predicted"] / r["measured"], r) for r in rows if r["measured"]]
            if not ratios:
                raise Missing("no row of 1 or 2 processes in the validation")
            worst = max(ratios, key=lambda q: abs(math.log(q[0])))
            of = f" ({scene(worst[1].get('scene', '?'))}, {worst[1].get('processes', 1)})"
            some = [q for q, _ in ratios]
            found = [(f"scenes of `options/`, least of many short runs: {inside(some, 0.85, 1.15)}; worst {worst[0]:.2f}{of}", some)]
            for what, pool in (("spatial", False), ("pool", True)):
                some = [r["ratio"] for r in self.ratios() if r["class"] == "measured" and (r["strategy"] == "pool") == pool]
                if some:
                    found.append((f"scenes of 6.2 and 6.3, {what}: {inside(some, 0.85, 1.15)}", some))
            return [(text, "closed form / measured", all(abs(q - 1) <= 0.15 for q in some)) for text, some in found]

        def many():
            some = [r["ratio"] for r in self.ratios() if r["class"] == "critical path" and r["processes"] >= 4]
            if not some:
                raise Missing("no run on 4 processes and more has both a critical path and a prediction")
            return [(inside(some, 0.85, 1.15), "closed form / critical path", "no goal")]

        def simulator():
            low, high = SIMULATOR
            return [
                (f"{what}: {inside(some, low, high)}", "simulated / measured", low <= min(some) and max(some) <= high)
                for what, some in self.simulator()
            ]

        strongly = "strong efficiency on 32 processes, {}, 8 000 particles a process"
        goal(strongly.format("3-D quadratic") + ": at least 0.90 net of imbalance", lambda: strong("box3d", 0.9))
        goal(strongly.format("2-D linear"), lambda: strong("box2d"))
        goal("imbalance of two disks on 1024 x 1024 cells, 32 processes: at most 1.05", imbalance)
        for name, what in (("box2d", "2-D linear"), ("box3d", "3-D quadratic")):
            for p, bound in ((1024, 0.9), (32768, 0.88)):
                goal(
                    f"weak efficiency, 16 000 particles a process, {what}, {thousands(p)} processes: at least {bound:.2f}",
                    lambda: weak(name, p, bound),
                )
        goal("model against simulation, filled boxes: within 10 %", simulation)
        goal("predicted / measured on 1 and 2 processes, all scenes: within 15 %", validation)
        goal("predicted / critical path on 4 to 32 processes, spatial decomposition", many)
        goal("simulator, set to this machine, against real runs on it: -12 to +6 %", simulator)
        return marks.markdown(["goal", "found", "evidence", "", "ns a particle on one process", "with DMSwarmMigrate"], lines)

    def curves(self, rows, processes="processes", extra=""):
        """A table of efficiencies: a line for each scene and way, a column for each number of processes."""
        columns = sorted({r[processes] for r in rows if r[processes] > 1})
        lines, base = [], {}
        for r in rows:  # weak studies run larger scenes on one process too, for their digests
            key = r["scene"], r.get("mode"), r.get("platform")
            if r[processes] == 1 and (key not in base or r["particles"] < base[key]["particles"]):
                base[key] = r
        for key, found in group(
            [r for r in rows if r[processes] > 1], lambda r: (r["scene"], way(r), r.get("mode"), r.get("platform"))
        ).items():
            by = {}
            for r in found:
                by.setdefault(r[processes], {})[r.get("class", "simulated")] = r
            one = base.get((key[0], key[2], key[3]))
            cells, cuts = [], [next((r["cut"] for r in by.get(p, {}).values() if r.get("cut")), "") for p in columns]
            for p in columns:
                kinds = by.get(p, {})
                cells.append(" / ".join(f"{r['efficiency']:.2f}{self.sign(k)}" for k, r in sorted(kinds.items())) or "")
            lines.append(
                [
                    scene(key[0]),
                    key[1] + (f", {key[2]}" if key[2] else "") + (f", {key[3]}" if key[3] == "fattree" else ""),
                    thousands(one["particles"]) if one else "",
                    seconds(one["seconds_per_step"]) if one else "",
                    *cells,
                ]
            )
            if any(cuts) and key[1] == "spatial, direct" and key[3] != "fattree":
                lines.append([scene(key[0]), "*boxes of these*", "", "", *cuts])
        return marks.markdown(["scene", "way", "particles on one process", "time of that", *map(thousands, columns)], lines)

    @staticmethod
    def sign(kind):
        return {"measured": "ᵐ", "critical path": "ᶜ", "simulated": "", "closed form": "ᶠ"}[kind]

    def real(self, study):
        """Rows of a study but those of the closed form and those that only give a digest."""
        rows = [
            r
            for r in self.data.scaling()
            if r["study"] == study and r["class"] in ("measured", "critical path") and r["efficiency"] != ""
        ]
        if not rows:
            raise Missing(f"`docs/data/scaling/*.csv` has no rows of study {study}: `make scaling` writes them")
        return rows

    def table_strong_real(self):
        return self.curves(self.real("strong"))

    def table_phases(self):
        """Has the processor time of each phase in strong scaling, spatial decomposition with direct migration: mean / slowest process."""
        rows = [r for r in self.data.phases() if r["study"] == "strong" and r["migrate"] in ("", "direct") and r["strategy"] != "pool"]
        columns, lines = sorted({r["processes"] for r in rows}), []
        for name in ("box2d", "box3d", "disks"):
            mine = [r for r in rows if r["scene"] == name]
            for phase in dict.fromkeys(r["phase"] for r in mine):
                found = {r["processes"]: r for r in mine if r["phase"] == phase}
                if any(r["slowest_seconds"] for r in found.values()):
                    cells = [(found[p]["mean_seconds"], found[p]["slowest_seconds"]) if p in found else None for p in columns]
                    lines.append([scene(name), phase, *map(self.pair, cells)])
            sums = [[sum(r[k] for r in mine if r["processes"] == p) for k in ("mean_seconds", "slowest_seconds")] for p in columns]
            if mine:
                lines.append([scene(name), "**all**", *map(self.pair, sums)])
                whole = [f"{p * mean / sums[0][0]:.2f}; {slowest / mean:.2f}" for p, (mean, slowest) in zip(columns, sums)]
                lines.append([scene(name), "*work of all processes over that of one; slowest over mean*", *whole])
        if not lines:
            raise Missing("`docs/data/scaling/phases.csv` has no rows of strong scaling: `make scaling` writes them")
        return marks.markdown(["scene", "phase", "one process", *map(str, columns[1:])], lines)

    @staticmethod
    def pair(times):
        if not times:
            return ""
        mean, slowest = (f"{1e6 * t:.3g}" if t < 9.995e-4 else f"{1e6 * t:.0f}" for t in times)
        return mean if mean == slowest else f"{mean} / {slowest}"

    def table_weak_real(self):
        return self.curves(self.real("weak"))

    def simulated(self, name, mode):
        rows = [r for r in self.data.simulated(name) if r["mode"] == mode]
        if not rows:
            raise Missing(f"`docs/data/simulated/{name}.csv` has no rows of mode {mode}: `make simulate` writes them")
        return rows

    def table_strong_simulated(self):
        return self.curves(self.simulated("strong", "injected"), "ranks")

    def table_weak_simulated(self):
        return self.curves(self.simulated("weak", "injected"), "ranks")

    def table_large_simulated(self):
        return self.curves(self.simulated("weak-large", "injected"), "ranks")

    def table_large_strong(self):
        return self.curves(self.simulated("strong-large", "injected"), "ranks")

    def table_emulated(self):
        rows = [r for r in self.simulated("strong", "emulated") if r["strategy"] == "spatial"]
        return self.curves(rows, "ranks")

    def table_messages(self):
        rows = [r for r in self.real("strong") if r["processes"] in (2, 8, 32) and r.get("messages_per_step", "") != ""]
        sizes, lines = sorted({r["processes"] for r in rows}), []
        for key, found in group(rows, lambda r: (r["scene"], way(r))).items():
            by = {r["processes"]: r for r in found}
            lines.append(
                [
                    scene(key[0]),
                    key[1],
                    *(
                        (
                            f"{by[p]['messages_per_step']:.4g}; {by[p]['bytes_per_particle_step']:.3g} B; {by[p]['reductions_per_step']:.3g}"
                            if p in by
                            else ""
                        )
                        for p in sizes
                    ),
                ]
            )
        return marks.markdown(
            [
                "scene",
                "way",
                *(
                    f"{p} processes: messages a step; bytes a particle and step; reductions a step" if k == 0 else f"{p}"
                    for k, p in enumerate(sizes)
                ),
            ],
            lines,
        )

    def table_bits(self):
        rows, lines = [r for r in self.data.scaling() if r["digest"] != ""], []
        for key, found in group(rows, lambda r: (r["scene"], r["study"], r["particles"], r["steps"])).items():
            digests = {str(r["digest"]) for r in found}
            runs = {(r["strategy"], r["migrate"], r["processes"]) for r in found}
            if len(runs) > 1:
                lines.append(
                    [
                        scene(key[0]),
                        key[1],
                        thousands(key[2]),
                        key[3],
                        len(runs),
                        "one" if len(digests) == 1 else f"**{len(digests)} differ**",
                    ]
                )
        return marks.markdown(["scene", "study", "particles", "steps", "runs: numbers of processes and ways", "digests"], lines)

    def table_migration(self):
        lines = []
        for kind, rows, p in (
            ("", lambda: self.real("strong"), "processes"),
            ("simulated", lambda: self.simulated("strong", "injected"), "ranks"),
        ):
            try:
                found = rows()
            except Missing as m:
                self.note("migration", str(m))
                continue
            for (name, n, k), both in group(
                [r for r in found if r["strategy"] == "spatial" and r[p] in (2, 8, 32)],
                lambda r: (r["scene"], r[p], r.get("class", kind)),
            ).items():
                t = {r["migrate"]: r["seconds_per_step"] for r in both}
                if len(t) == 2:
                    lines.append([scene(name), n, seconds(t["direct"]), seconds(t["swarm"]), two(t["swarm"] / t["direct"]), k])
        if not lines:
            raise Missing("no scene ran with both ways of migration: `make scaling` and `make simulate` write them")
        return marks.markdown(["scene", "processes", "direct", "DMSwarmMigrate", "ratio", "evidence"], lines)

    def table_pool(self):
        lines = []
        for name, (_, what) in BOXES.items():
            m, s = self.closed(name), self.whole(name)
            edge = m.patch(s)
            busy, serial = m.pool(model.replace(s, processes=8), edge)[1], m.step(s)
            sizes, of_patch = m.farmed(s, edge)[1], m.numbers["job"] + m.numbers["message"]
            alone = m.parts(s)
            ends = sum(alone[k] + 2 * b * (m.numbers["pool"] + m.numbers["wire"]) for k, b in sizes.items())
            best = (s.nodes / math.sqrt(ends / len(sizes) / of_patch)) ** (1 / m.dim)
            lines.append(
                [
                    what,
                    f"{1e9 * serial / s.particles:.1f}",
                    f"{1e9 * busy / s.particles:.1f}",
                    edge,
                    f"{best:.0f}",
                    two(serial / busy) + (" **below 1**" if serial < busy else ""),
                    *(f"{1e9 * max(0, (b * busy - serial) / s.particles):.0f}" for b in (1, 2, 4, 16)),
                ]
            )
        head = "scene", "one process, ns a particle and step", "master, ns", "best patch, cells an axis", "by the root"
        bound = "bound of the speed-up", "a law more expensive by this many ns makes the bound 1", "2", "4", "16"
        return marks.markdown([*head, *bound], lines)

    def table_pool_scenes(self):
        """Has the bound in all scenes of the studies, as the program printed it: the speed-up on the most processes of its table."""
        rows = [r for r in self.data.scaling() if r["study"] == "strong" and r["class"] == "closed form"]
        lines = []
        for name, found in group(rows, lambda r: r["scene"]).items():
            one = next((r for r in found if r["processes"] == 1), None)
            pool = max((r for r in found if r["strategy"] == "pool"), key=lambda r: r["processes"], default=None)
            if one and pool:
                alone, busy = (1e9 * r["seconds_per_step"] / one["particles"] for r in (one, pool))
                sizes = thousands(one["particles"]), f"{alone:.1f}", thousands(pool["processes"]), f"{busy:.1f}"
                bound = two(alone / busy) + (" **below 1**" if alone < busy else "")
                lines.append([scene(name), *sizes, bound, f"{max(0, busy - alone):.0f}"])
        if not lines:
            raise Missing("`docs/data/scaling/runs.csv` has no closed form of the pool: `make scaling` writes it")
        head = "scene", "particles", "one process, ns a particle and step", "processes of the pool", "pool, ns", "bound"
        return marks.markdown([*head, "1 with a law more expensive by so many ns"], lines)

    def table_crossover(self):
        """Has the terms of the cross-over of both strategies, and the imbalance from which on the pool would be ahead."""
        lines = []
        for name, (_, what) in BOXES.items():
            m, whole = self.closed(name), self.whole(name)
            for p in (2, 8, 32):
                s = model.replace(whole, processes=p)
                edge = m.patch(whole)
                alone, farmed = m.parts(whole), m.farmed(s, edge)[1]
                work = sum(alone[k] for k in farmed)
                rest = sum(alone.values()) - work
                pool, busy = m.pool(s, edge)
                spatial, i = self.spatial(m, name, p)
                messages = spatial - self.part(m, whole, i / p)
                lines.append(
                    [
                        what,
                        p,
                        *map(seconds, (self.part(m, whole, i / p), messages, rest, busy - rest, (work + busy - rest) / (p - 1))),
                        seconds(spatial),
                        seconds(pool),
                        "spatial" if spatial < pool else "pool",
                        f"{i:.2f}",
                        *(self.level(m.dearer(1e-9 * extra), name, p) for extra in (0, 1e4, 1e6)),
                    ]
                )
        head = "scene", "P", "T_1(i N/P)", "X", "R", "T_m", "(w + T_m)/(P - 1)", "T_spatial", "T_pool", "ahead", "i"
        return marks.markdown([*head, "pool ahead from i =", "law more expensive by 10 µs", "by 1 ms"], lines)

    def level(self, m, name, p):
        """The imbalance at which both strategies take equal times, with the best patch."""
        whole = self.whole(name)
        spatial, i = self.spatial(m, name, p)
        messages, pool = spatial - self.part(m, whole, i / p), self.best_pool(m, whole, p)
        if self.part(m, whole, 1) + messages < pool:
            return "none"  # the pool is slower even than one process that has all
        low, high = 0.5, float(p)
        for _ in range(40):
            middle = (low + high) / 2
            low, high = (middle, high) if self.part(m, whole, middle / p) + messages < pool else (low, middle)
        return two(low)

    @staticmethod
    def part(m, whole, share):
        """Seconds of a step of one process that has a share of all particles, and as much of the nodes."""
        return m.step(model.Share(whole.particles * share, whole.nodes * share))

    def table_blocks(self):
        lines = []
        for name, (_, what) in BOXES.items():
            for swarm in (False, True):
                lines.append(
                    [
                        what,
                        "DMSwarmMigrate" if swarm else "direct",
                        *(two(self.weak(name, WEAK, p, swarm)) for p in FAR[5:] if p in (32, 1024, 32768, 1000000)),
                    ]
                )
        return marks.markdown(["scene", "migration", "32", "1 024", "32 768", "1 000 000"], lines)

    def table_losses(self):
        """Has what a step on many processes takes beyond a step of one process with as many particles each, in parts of the step."""
        lines = []
        for name, (_, what) in BOXES.items():
            m, per, c = self.closed(name), 2 ** len(BOXES[name][0]), self.moved(name)
            alone, quick = m.step(m.cube(WEAK, per, 1, c)), m.with_(wire=0, copy=0)
            for p in (32, 1024, 32768):
                s = m.cube(WEAK, per, p, c)
                t, parts = m.step(s), m.parts(s)
                bytes_ = t - quick.step(s)
                settled = parts["MIGRATE"], parts["REDUCE"] - m.parts(m.cube(WEAK, per, 1, c))["REDUCE"]
                shares = (t - alone - bytes_ - sum(settled), bytes_, *settled)
                lines.append([what, thousands(p), *(f"{100 * x / t:.1f} %" for x in shares), two(alone / t)])
        return marks.markdown(
            ["scene", "processes", "messages to neighbours", "their bytes", "MIGRATE", "REDUCE", "efficiency"], lines
        )

    def table_least(self):
        lines = []
        for name, (_, what) in BOXES.items():
            m = self.closed(name)
            for e in (0.8, 0.9):
                lines.append(
                    [
                        what,
                        e,
                        *(
                            thousands(float(f"{m.least(2**m.dim, p, self.moved(name), e):.2g}"))
                            for p in (2, 32, 1024, 32768, 1000000)
                        ),
                    ]
                )
        return marks.markdown(["scene", "efficiency", "2 processes", "32", "1 024", "32 768", "1 000 000"], lines)

    def table_constants(self):
        lines = []
        for name, (_, what) in BOXES.items():
            m = self.closed(name)
            measured = model.load(self.data.model(name), m.predictor).numbers
            for k in ("P2G", "ADVANCE", "G2P", "SORT"):
                r = m.rates[k]
                lines.append([what, k, f"{1e6 * r.call:.2g} µs", *(f"{1e9 * each:.2f} ns" for each in r.each)])
            for k, unit in (
                ("copy", "ns a byte, g_copy"),
                ("kept", "ns a byte, g_kept"),
                ("pool", "ns a byte, f"),
                ("job", "ns a patch, h" + " (0: less than can be told)" * (measured["job"] == 0)),
                ("migration[0].call", "ns a migration by DMSwarmMigrate, m0"),
                ("migration[0].particle", "ns a particle that is there then, m2"),
                ("migration[1].call", "ns a direct migration, m0"),
                ("migration[1].leaver", "ns a particle that leaves, m4"),
            ):
                lines.append([what, re.sub(r"\[\d\].", ", ", k), f"{1e9 * measured[k]:.3g} {unit}", "", "", ""])
        sizes = ("1 500", "20 000", "400 000")
        text = marks.markdown(["scene", "constant", "each call", *(f"each, about {n}" for n in sizes)], lines)
        origin = re.sub(r", of (\d+)$", r"; of \1 such, the least or the median", self.closed("box2d").origin)
        return f"{text}\n\n{origin[:1].upper()}{origin[1:]}."

    def table_against_simulation(self):
        return marks.markdown(
            [
                "scene",
                "study",
                "processes",
                "cut",
                "simulated",
                "closed form",
                "difference",
                "imbalance, counted",
                "by formula",
            ],
            [
                [
                    scene(name),
                    study,
                    thousands(p),
                    cut,
                    seconds(sim),
                    seconds(form),
                    f"{100 * (form / sim - 1):+.1f} %",
                    f"{counted:.3f}",
                    f"{formula:.3f}",
                ]
                for name, study, p, cut, sim, form, counted, formula in self.against_simulation()
            ],
        )

    def simulator(self):
        """What was simulated and compared with real runs, and simulated over measured times. Injected runs on one process are left
        out: their costs come from these very runs, so they show nothing."""
        by = group(
            self.data.simulated("validate"),
            lambda r: (r["strategy"] == "pool", r["ranks"], r.get("transport", "shared") if r["ranks"] > 1 else ""),
        )
        return [
            (
                f"{mode}, {'pool, ' * pool}{n} process{'es, ' * (n > 1)}{TRANSPORT[transport]}",
                [r[f"{mode}_over_real"] for r in some],
            )
            for mode in ("injected", "emulated")
            for (pool, n, transport), some in sorted(by.items())
            if n > 1 or mode == "emulated"
        ]

    def number_enclosed(self):
        """How many real runs on two processes lie between both modes of the simulator."""
        rows = [r for r in self.data.simulated("validate") if r["ranks"] > 1]
        return f"{sum(r['injected_over_real'] <= 1 <= r['emulated_over_real'] for r in rows)} of {len(rows)}"

    def table_simulator(self):
        rows, text = self.data.simulated("validate"), "As it was measured before the runs,"
        for net in self.data.simulated("networks"):
            text += (
                f" a short message through {TRANSPORT[net['transport']]} takes {1e6 * net['message']:.3g} µs, {1e6 * net['post']:.3g} µs"
                f" of it at processors (taken as 0.8 of it at most), and a byte {1e-9 / net['wire']:.3g} GB/s;"
            )
        text = text.removesuffix(";") + ".\n"
        low, high = SIMULATOR
        for what, some in self.simulator():
            missed = "" if low <= min(some) and max(some) <= high else " **The goal is missed.**"
            text += f"\n* {what}: {inside(some, low, high)}.{missed}"
        lines = [
            [
                scene(r["scene"]),
                thousands(r["particles"]),
                way(r),
                r["ranks"],
                TRANSPORT[r.get("transport", "shared")] if r["ranks"] > 1 else "",
                seconds(r["real"]),
                two(r["injected_over_real"]),
                two(r["emulated_over_real"]),
            ]
            for r in rows
        ]
        head = ["scene", "particles", "way", "processes", "messages by", "measured", "injected, over it", "emulated, over it"]
        return text + "\n\n" + marks.markdown(head, lines)

    def table_validation(self):
        lines = []
        for r in self.data.validation():
            q = r["predicted"] / r["measured"]
            lines.append(
                [
                    scene(r.get("scene", "")),
                    thousands(r["particles"]),
                    r.get("processes", ""),
                    seconds(r["measured"]),
                    seconds(r["predicted"]),
                    two(q),
                    "" if abs(q - 1) <= 0.15 else "outside",
                ]
            )
        return marks.markdown(
            ["scene", "particles", "processes", "measured", "predicted", "predicted / measured", "15 %"], lines
        )

    def ratios(self):
        """The runs of the studies with `ratio`: the closed form with the constants of this machine over the wall time, or over the
        critical path. That of the pool has no messages, and is left out."""
        rows = [r for r in self.data.scaling() if r["study"] in ("strong", "weak") and r["steps"] != ""]
        out = []
        for runs in group(rows, lambda r: (r["scene"], r["study"], r["processes"], r["particles"], way(r))).values():
            t = {r["class"]: r["seconds_per_step"] for r in runs}
            for r in runs:
                if r["class"] == "measured" or r["class"] == "critical path" and way(r) not in ("pool", "one process"):
                    out.append({**r, "ratio": t["closed form"] / r["seconds_per_step"]})
        if not out:
            raise Missing("`docs/data/scaling/runs.csv` has no runs and predictions: `make scaling` writes them")
        return out

    def table_path(self):
        """Has the predicted step over the measured one, or over the critical path."""
        found, columns = self.ratios(), [(1, "measured"), *((p, k) for p in PROCESSES[1:] for k in ("measured", "critical path"))]
        columns = [c for c in columns if any((r["processes"], r["class"]) == c for r in found)]
        base, lines = {}, []
        for r in found:
            if r["processes"] == 1 and r["particles"] <= base.get((r["scene"], r["study"]), r)["particles"]:
                base[r["scene"], r["study"]] = r
        for (name, study, how), runs in group(
            [r for r in found if r["processes"] > 1], lambda r: (r["scene"], r["study"], way(r))
        ).items():
            by = {(r["processes"], r["class"]): two(r["ratio"]) for r in runs}
            if one := base.get((name, study)):
                by[1, "measured"] = two(one["ratio"])
            lines.append([scene(name), study, how, *(by.get(c, "") for c in columns)])
        return marks.markdown(["scene", "study", "way", *(f"{p}{self.sign(k)}" for p, k in columns)], lines)

    def table_counts(self):
        rows = rows_of(self.data.need("scaling/counts.csv", "`make scaling`")[0])
        lines = []
        for (name, strategy, p, cut), found in group(
            rows, lambda r: (r["scene"], r["strategy"], r["processes"], r["grid"])
        ).items():
            same = sum(r["equal"] == "yes" for r in found)
            lines.append(
                [
                    scene(name),
                    strategy,
                    p,
                    cut if strategy != "pool" else "",
                    thousands(sum(r["counted"] for r in found if r["quantity"].startswith("messages"))),
                    (
                        thousands(sum(r["counted"] for r in found if r["quantity"].startswith("bytes")))
                        if strategy != "pool"
                        else ""
                    ),
                    f"all {same}" if same == len(found) else f"**{same} of {len(found)}**",
                ]
            )
        return marks.markdown(
            ["scene", "way", "processes", "cut", "messages a step", "bytes a step", "numbers equal to the formulas"], lines
        )

    def table_cuts(self):
        lines = []
        for name, options in (
            ("disks, 1024 x 1024 cells", ("options/disks.opts", "-grid_cells", "1024,1024")),
            ("disks, 20 x 20 cells", ("options/disks.opts",)),
            ("disks3d, 32 x 32 x 32 cells", ("options/disks3d.opts", "-method_basis", "linear")),
        ):
            rows = model.parse(self.pebble("-options_file", options[0], *options[1:], "-dry_run", "-report_processes"))["rows"]
            lines.append([name, *(f"{rows[p]['imbalance']:.3f}" if p in rows else "" for p in PROCESSES[1:])])
        return marks.markdown(["scene", *map(str, PROCESSES[1:])], lines)

    def table_orders(self):
        lines = []
        for label, points in self.ladders().items():
            points = sorted(points, reverse=True)
            orders = [math.log(a[1] / b[1]) / math.log(a[0] / b[0]) for a, b in zip(points, points[1:])]
            lines.append([label, *(f"{e:.2e}" for _, e in points), *(f"{o:.2f}" for o in orders)])
        return marks.markdown(["basis", "8 cells", "16", "32", "order of convergence 8-16", "16-32"], lines)

    def ladders(self):
        if "ladders" not in self.said:
            out = {}
            for label, more in (
                ("linear", ("-method_basis", "linear")),
                ("quadratic B-spline", ("-method_basis", "bspline2")),
                ("GIMP, stretched", ()),
            ):
                self.pebble(
                    "-options_file",
                    "options/mms.opts",
                    "-grid_cells",
                    "8,8",
                    "-study_type",
                    "convergence",
                    "-study_levels",
                    "3",
                    "-method_update",
                    "musl",
                    "-method_transfer",
                    "flip",
                    "-dt_cfl",
                    "0.4",
                    *more,
                )
                with open(os.path.join(self.work.name, "mms_study.csv")) as f:
                    out[label] = [(float(r["h"]), float(r["error"])) for r in csv.DictReader(f)]
            self.said["ladders"] = out
        return self.said["ladders"]

    # ---- Numbers in the text
    def imbalance(self, *options):
        """Imbalance on 32 processes."""
        row = model.parse(self.pebble("-options_file", *options, "-dry_run", "-report_processes"))["rows"].get(32)
        if not row:
            raise Missing(f"`pebble -dry_run -report_processes` printed no row of 32 processes for {options[0]}")
        return row["imbalance"]

    def number_cut_disks(self):
        return f"{self.imbalance('options/disks.opts', '-grid_cells', '1024,1024'):.3f}"

    def number_cut_disks3d(self):
        return two(self.imbalance("options/disks3d.opts", "-method_basis", "linear"))

    def serial(self, name):
        """ns a particle and step, measured on one process."""
        for r in self.real("strong"):
            if r["scene"] == name and r["processes"] == 1 and r["class"] == "measured":
                return f"{1e9 * r['seconds_per_step'] / r['particles']:.0f}"
        raise Missing(f"`docs/data/scaling/runs.csv` has no run of {name} on one process: `make scaling` writes it")

    def number_serial_2d(self):
        return self.serial("box2d")

    def number_serial_3d(self):
        return self.serial("box3d")

    def least(self, name, efficiency=0.8, processes=1024):
        m = self.closed(name)
        return thousands(float(f"{m.least(2**m.dim, processes, self.moved(name), efficiency):.2g}"))

    def number_least_2d(self):
        return self.least("box2d")

    def number_least_3d(self):
        return self.least("box3d")

    def kept(self, name):
        """The numbers of particles a process from which on all simulated runs kept an efficiency of 0.8, and on how many processes."""
        runs = []
        for study in ("strong", "weak", "strong-large", "weak-large"):
            try:
                runs += [r for r in self.simulated(study, "injected") if r["scene"] == name and way(r) == "spatial, direct"]
            except Missing:
                pass
        runs = [(r["particles"] // r["ranks"], r["ranks"], r["efficiency"]) for r in runs if r["platform"] == "cluster"]
        least = max((n for n, _, e in runs if e < 0.8), default=0)
        most = {}
        for n, p, _ in sorted(runs):
            if n > least and p > max(most.values(), default=1):
                most[n] = p
        if not most:
            raise Missing(f"no simulated run of {name} has an efficiency of 0.8: `make simulate` writes them")
        words = ", ".join(f"{thousands(n)} on up to {thousands(p)} processes" for n, p in most.items())
        if short := [(e, p) for n, p, e in runs if n == least and e < 0.8]:
            words += f" (with {thousands(least)} on {thousands(min(short)[1])}: {two(min(short)[0])})"
        return words

    def number_kept_2d(self):
        return self.kept("box2d")

    def number_kept_3d(self):
        return self.kept("box3d")

    def number_path_range(self):
        some = [r["ratio"] for r in self.ratios() if r["class"] == "critical path" and r["processes"] >= 4]
        return f"{min(some):.2f} to {max(some):.2f}" if some else "(no data)"

    def strong_on_32(self, name, kind):
        rows = self.simulated("strong", "injected") if kind == "simulated" else self.real("strong")
        for r in rows:
            if r["scene"] == name and r.get("processes", r.get("ranks")) == 32 and way(r) == "spatial, direct":
                if r.get("class", "simulated") == kind:
                    return two(r["efficiency"])
        raise Missing(f"no run of {name} on 32 processes, {kind}")

    def number_path_2d(self):
        return self.strong_on_32("box2d", "critical path")

    def number_path_3d(self):
        return self.strong_on_32("box3d", "critical path")

    def number_simulated_2d(self):
        return self.strong_on_32("box2d", "simulated")

    def number_simulated_3d(self):
        return self.strong_on_32("box3d", "simulated")

    def travels(self, name):
        """Bytes of a particle's fields that the pool's master sends and receives in a step."""
        m = self.closed(name)
        return str(sum(phase.bytes for phase in m.predictor.phases))

    def number_travels_2d(self):
        return self.travels("box2d")

    def number_travels_3d(self):
        return self.travels("box3d")

    def number_overtakes(self):
        """The cost of the law from which on the pool is ahead of spatial decomposition in 3-D on 32 processes."""
        m, s = self.closed("box3d"), self.whole("box3d")
        for k in range(0, 121):
            d = m.dearer(1e-9 * 10 ** (k / 20))
            if self.best_pool(d, s, 32) < self.spatial(d, "box3d", 32)[0]:
                return f"beyond {float(f'{10 ** (k / 20 - 3):.1g}'):g} µs a particle and step"
        return "at no cost of the law"

    def number_crosses(self):
        """The number of processes from which on spatial decomposition is ahead, as the program prints it for both boxes."""
        found = []
        for name in BOXES:
            self.closed(name)
            found.append(self.said[name].get("ahead", "none"))
        return found[0] if len(set(found)) == 1 else f"{found[0]} in 2-D and {found[1]} in 3-D"

    def bench(self, pattern):
        """Numbers of docs/performance.md: the first number of each line that fits a pattern."""
        with open(os.path.join(ROOT, "docs", "performance.md")) as f:
            found = [float(x) for x in re.findall(rf"^\| {pattern}[^|\n]*\| ([\d.]+)", f.read(), re.M)]
        if not found:
            raise Missing(f"`docs/performance.md` has no line {pattern}: `make bench` writes it")
        return found

    def number_plain(self):
        found = self.bench("seed_serial / pebble us[lf], linear 2-D")
        return f"{min(found):.0f} to {max(found):.0f}"

    def number_two_2d(self):
        return self.span("1 process / 2 processes, (?!direct).* 2-D, 1e6")

    def number_two_3d(self):
        return self.span("1 process / 2 processes, (?!direct).* 3-D, 1e6")

    def span(self, pattern):
        """The least and the largest of what the bench found, one number if they print alike."""
        found = self.bench(pattern)
        return " to ".join(dict.fromkeys((f"{min(found):.1f}", f"{max(found):.1f}")))

    def number_cut_equal(self):
        """Imbalance of the disks on 32 processes with equal boxes, counted by the program: docs/performance.md, The partition."""
        with open(os.path.join(ROOT, "docs", "performance.md")) as f:
            found = re.search(r"^\| disks, 1024 x 1024 cells \|(?:.*\n\| *)*?\| 32 \| ([\d.]+) ", f.read(), re.M)
        if not found:
            raise Missing("`docs/performance.md` has no imbalance of the disks on 32 processes with equal boxes")
        return f"{float(found[1]):.1f}"

    def number_most_simulated(self):
        """The largest number of processes in a simulation."""
        most = []
        for name in ("strong", "weak", "weak-large", "strong-large"):
            try:
                most.append(max(r["ranks"] for r in self.data.simulated(name)))
            except Missing:
                pass
        if not most:
            raise Missing("`docs/data/simulated` has no curves: `make simulate` writes them")
        return thousands(max(most))
