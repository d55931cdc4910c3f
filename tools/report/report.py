#!/usr/bin/env python3
"""Makes the tables and figures of docs/report.md anew from docs/data, and docs/report.html from that: `make report`.

The tables stand between the lines <!-- table NAME --> and <!-- end -->; the function table_NAME of tables.py makes them. Numbers in
the text are <!-- number NAME -->...<!-- end -->; number_NAME makes them. A table whose data are missing becomes a sentence that says
which these are, and the program ends with status 1.

    report.py                  tables, figures and HTML from the data in the repository (runs Pebble for a few seconds)
    report.py --calibrate      first measures docs/data/models/*.model anew on this machine (minutes; nothing else should run)
"""

import argparse
import math
import os
import re
import subprocess
import sys

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
sys.path[:0] = [os.path.join(ROOT, "tools"), os.path.join(ROOT, "tools", "scaling")]
import figures  # noqa: E402 (after the path)
import marks  # noqa: E402
import model  # noqa: E402
import plots  # noqa: E402
from closed import BOXES, FAR, PATCH, WEAK, way  # noqa: E402
from data import Missing  # noqa: E402
from data import rows as rows_of  # noqa: E402
from tables import Tables, group, scene, thousands  # noqa: E402


class Report(Tables):
    # ---- Figures
    def place(self, name):
        return os.path.join(self.args.out, f"report-{name}.png")

    def figure_disks(self):
        self.pebble("-options_file", "options/disks.opts")
        path = self.place("disks")
        subprocess.run(
            [
                sys.executable,
                os.path.join(ROOT, "tools", "plot.py"),
                os.path.join(self.work.name, "disks.h5"),
                "--small",
                "--out",
                path,
            ],
            check=True,
            stdout=subprocess.DEVNULL,
        )
        print(f"  {os.path.relpath(path)}")

    def figure_convergence(self):
        figures.convergence(self.place("convergence"), self.ladders())

    def figure_strong(self):
        panels = {}  # {scene: {way: [(class, points)]}}
        for rows, p, kind in self.both("strong"):
            for key, some in group([r for r in rows if r[p] > 1], lambda r: (r["scene"], way(r), r.get("class", kind))).items():
                panel = panels.setdefault(scene(key[0]), {})
                panel.setdefault(key[1], []).append((key[2], [(r[p], r["efficiency"]) for r in some]))
        try:
            for name, rows in group([r for r in self.against_simulation() if r[1] == "strong"], lambda r: r[0]).items():
                one = self.alone(name, BOXES[name][0])
                points = [(1, 1.0)] + [(p, one / t / p) for _, _, p, _, _, t, _, _ in rows if p <= 32]
                panels.setdefault(scene(name), {}).setdefault("spatial, direct", []).append(("closed form, as simulated", points))
        except Missing as m:
            self.note("figure strong", str(m))
        for name, points in self.bands("strong").items():
            panels.setdefault(scene(name), {}).setdefault("spatial, direct", []).append(("emulated to injected", points))
        figures.efficiency(self.place("strong"), list(panels), list(panels.values()), columns=3)

    def bands(self, study):
        """{scene: [(processes, (emulated, injected efficiency))]} of spatial decomposition with direct migration, where both ran."""
        rows = [r for r in self.data.simulated(study) if way(r) == "spatial, direct" and r["platform"] == "cluster"]
        out = {}
        for (name, p), both in group(rows, lambda r: (r["scene"], r["ranks"])).items():
            found = {r["mode"]: r["efficiency"] for r in both}
            if len(found) == 2:
                out.setdefault(name, []).append((p, (found["emulated"], found["injected"])))
        return out

    def both(self, study):
        found, lacking = [], []
        for rows, p, kind in (
            (lambda: self.real(study), "processes", ""),
            (lambda: self.simulated(study, "injected"), "ranks", "simulated"),
        ):
            try:
                found.append((rows(), p, kind))
            except Missing as m:
                lacking.append(m)
        if not found:
            raise lacking[0]
        for m in lacking:
            self.note(f"figure {study}", str(m))
        return found

    def figure_weak(self):
        panels = []
        for name, (_, what) in BOXES.items():
            panel = {
                label: [
                    ("closed form", [(p, self.weak(name, WEAK, p, swarm)) for p in FAR]),
                    ("closed form, as simulated", [(2**k, self.boxes(name, 2**k, swarm)[0]) for k in range(21)]),
                ]
                for label, swarm in (("direct", False), ("DMSwarmMigrate", True))
            }
            found = list(self.both("weak"))
            try:
                if points := self.bands("weak").get(name):
                    panel["direct"].append(("emulated to injected", points))
                found.append((self.simulated("weak-large", "injected"), "ranks", "simulated"))
            except Missing as m:
                self.note("figure weak", str(m))
            for rows, p, kind in found:
                for k, some in group(
                    [
                        r
                        for r in rows
                        if r["scene"] == name and r["strategy"] == "spatial" and r.get("platform", "cluster") == "cluster"
                    ],
                    lambda r: (r["migrate"], r.get("class", kind)),
                ).items():
                    label = "direct" if k[0] == "direct" else "DMSwarmMigrate"
                    points = [(r[p], r["efficiency"]) for r in some if r[p] > 1]
                    if points:
                        panel[label].append((k[1], points))
            panels.append(panel)
        figures.efficiency(self.place("weak"), [f"weak scaling, {what}" for _, what in BOXES.values()], panels)

    def figure_pool(self):
        panels = {}
        for name, (_, what) in BOXES.items():
            m, s, lines = self.closed(name), self.whole(name), {}
            costs = [10 ** (k / 4) for k in range(0, 21)]
            for p in (8, 32):
                lines[f"pool, {p} processes"] = []
                for t in costs:
                    d = m.dearer(1e-9 * t)
                    lines[f"pool, {p} processes"].append((t, d.step(s) / self.best_pool(d, s, p)))
                lines[f"spatial, {p} processes"] = [
                    (t, (d := m.dearer(1e-9 * t)).step(s) / self.spatial(d, name, p)[0])
                    for t in costs
                ]
            panels[what] = lines
        figures.pool(self.place("pool"), panels)

    def figure_messages(self):
        """Draws imbalance, and bytes a particle and step, counted in the runs of strong scaling and for filled boxes also by formula."""
        rows = [r for r in self.real("strong") if r["class"] == "critical path" and r["migrate"] != "swarm"]
        cuts = group(
            [r for r in rows_of(self.data.need("scaling/counts.csv", "`make scaling`")[0]) if r["strategy"] == "spatial"],
            lambda r: (r["scene"], r["processes"]),
        )
        imbalance, size = {}, {}
        for name, found in group(rows, lambda r: r["scene"]).items():
            imbalance[scene(name)] = [("counted", [(r["processes"], r["imbalance"]) for r in found if r["strategy"] != "pool"])]
            size[scene(name)] = [
                ("counted", [(r["processes"], r["bytes_per_particle_step"]) for r in found if r["strategy"] == strategy])
                for strategy in ("spatial", "pool")
            ]
            if name not in BOXES:
                continue
            m, s, made = self.closed(name), self.whole(name), {p: rows for (n, p), rows in cuts.items() if n == name}
            imbalance[scene(name)].append(
                ("formula", [(1, 1.0)] + [(p, self.even(name, r[0]["grid"])) for p, r in made.items()])
            )
            sent = [(p, sum(r["formula"] for r in found if r["quantity"].startswith("bytes"))) for p, found in made.items()]
            size[scene(name)].append(("formula", [(p, b / s.particles) for p, b in sent]))
            dealt = sum(m.farmed(s, PATCH)[1].values()) / s.particles
            size[scene(name)].append(("formula", [(p, dealt) for p in made]))
        figures.messages(self.place("messages"), imbalance, size)

    def even(self, name, cut):
        """Imbalance of a filled box by formula."""
        m = self.closed(name)
        return m.box(BOXES[name][0], [int(p) for p in str(cut).split("x")], 2**m.dim, 0)[1]

    def figure_parts(self):
        panels = {}
        for name, (_, what) in BOXES.items():
            m = self.closed(name)
            panels[f"{what}, {thousands(WEAK)} a process"] = [
                (p, m.parts(m.cube(WEAK, 2**m.dim, p, self.moved(name)))) for p in (1, 2, 32, 1024, 32768, 1000000)
            ]
        figures.shares(self.place("parts"), panels)

    # ---- All
    def number(self, name):
        make = getattr(self, f"number_{name}", None)
        if not make:
            sys.exit(f"report.py: docs/report.md has a number {name} that nothing makes")
        try:
            return make()
        except Missing as m:
            self.note(f"number {name}", str(m))
            return "(no data)"

    def run(self):
        path = os.path.join(ROOT, "docs", "report.md")
        with open(path) as f:
            text = f.read()
        for name in marks.names(text):
            make = getattr(self, f"table_{name}", None)
            if not make:
                sys.exit(f"report.py: docs/report.md has a table {name} that nothing makes")
            try:
                block = make()
            except Missing as m:
                self.note(f"table {name}", str(m))
                block = f"*No data: {m}.*"
            text = marks.renew(text, name, block)
        text = marks.numbers(text, self.number)
        for name in re.findall(r"\]\(report-(\w+)\.png\)", text):
            try:
                getattr(self, f"figure_{name}")()
            except Missing as m:
                self.note(f"figure {name}", str(m))
        plots.draw(os.path.join(self.args.data, "scaling"), self.args.out)
        with open(os.path.join(self.args.out, "report.md"), "w") as f:
            f.write(text)
        print(f"  {os.path.relpath(os.path.join(self.args.out, 'report.md'))}")
        try:
            import page
        except ModuleNotFoundError as missing:
            sys.exit(f"report.py: {missing}; run it by `make report`")
        page.write(text, self.args.out, os.path.join(self.args.out, "report.html"))
        for where, what in self.missing:
            print(f"report.py: {where}: {what}", file=sys.stderr)
        return 1 if self.missing else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pebble", default=os.path.join(ROOT, "pebble"), type=os.path.abspath)
    parser.add_argument("--calibrator", default=os.path.join(ROOT, "build", "mpicc", "calibrate"), type=os.path.abspath)
    parser.add_argument("--predictor", default=os.path.join(ROOT, "build", "mpicc", "predict"), type=os.path.abspath)
    parser.add_argument("--mpiexec", default="mpiexec")
    parser.add_argument("--data", default=os.path.join(ROOT, "docs", "data"), help="folder of the CSV files")
    parser.add_argument("--out", default=os.path.join(ROOT, "docs"), help="where the report and its figures go")
    parser.add_argument("--calibrate", nargs="?", type=int, const=6, metavar="REPEATS")
    args = parser.parse_args()
    report = Report(args)
    if args.calibrate:
        report.calibrate(args.calibrate)
    return report.run()


if __name__ == "__main__":
    sys.exit(main())
