"""What the figures of docs/report.md show: figure_NAME draws docs/report-NAME.png."""

import os
import subprocess
import sys

import figures
from closed import BOXES, WEAK, way
from data import ROOT
from words import group, scene, thousands



class Drawings:
    def place(self, name):
        return os.path.join(self.args.out, f"report-{name}.png")

    def figure_disks(self):
        self.pebble("-options_file", "options/disks.opts")
        command = [
            sys.executable,
            os.path.join(ROOT, "tools", "plot.py"),
            os.path.join(self.work.name, "disks.h5"),
            "--small",
            "--out",
            self.place("disks"),
        ]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        print(f"  {os.path.relpath(self.place('disks'))}")

    def runs(self, study):
        """All runs on two processes and more, real and simulated, with `class` and `processes`."""
        out = [r for r in self.real(study) if r["processes"] > 1]
        for name in (study, f"{study}-large") if study == "weak" else (study,):
            rows = [r for r in self.data.simulated(name) if r["platform"] == "cluster" and r["ranks"] > 1]
            out += [{**r, "class": f"{r['mode']} simulation", "processes": r["ranks"]} for r in rows]
        return out

    def panel(self, runs, name):
        """{way: [(class, [(processes, efficiency)])]} of a scene."""
        out = {}
        for (how, kind), some in group([r for r in runs if r["scene"] == name], lambda r: (way(r), r["class"])).items():
            out.setdefault(how, []).append((kind, [(r["processes"], r["efficiency"]) for r in some]))
        return out

    def figure_strong(self):
        runs = self.runs("strong")
        panels = {name: self.panel(runs, name) for name in dict.fromkeys(r["scene"] for r in runs)}
        for name, rows in group([r for r in self.against_simulation() if r[1] == "strong"], lambda r: r[0]).items():
            one = self.alone(name, BOXES[name])
            points = [(1, 1.0)] + [(p, one / t / p) for _, _, p, _, _, t, _, _ in rows if p <= 32]
            panels[name]["spatial, direct"].append(("closed form", points))
        figures.efficiency(self.place("strong"), [scene(name) for name in panels], list(panels.values()), columns=3)

    def figure_weak(self):
        runs, panels = self.runs("weak"), {}
        for name in BOXES:
            panels[name] = self.panel(runs, name)
            for label, swarm in (("spatial, direct", False), ("spatial, DMSwarmMigrate", True)):
                line = [(2**k, self.same_source(name, 2**k, swarm)[0]) for k in range(21)]
                panels[name].setdefault(label, []).append(("closed form", line))
        figures.efficiency(
            self.place("weak"),
            [f"{scene(name)}, {thousands(WEAK)} particles a process" for name in panels],
            list(panels.values()),
        )

    def figure_pool(self):
        panels, costs = {}, [10 ** (k / 4) for k in range(0, 21)]
        for name in BOXES:
            m, s, lines = self.closed(name), self.whole(name), {}
            for p in (8, 32):
                dear = [(t, m.dearer(1e-9 * t)) for t in costs]
                lines["pool", p] = [(t, d.step(s) / self.best_pool(d, s, p)) for t, d in dear]
                lines["spatial, direct", p] = [(t, d.step(s) / self.spatial(d, name, p)[0]) for t, d in dear]
            panels[scene(name)] = lines
        figures.pool(self.place("pool"), panels)

    def figure_messages(self):
        """Draws imbalance, and bytes a particle and step, counted in the runs of strong scaling."""
        rows = [r for r in self.real("strong") if r["class"] == "critical path" and r["migrate"] != "swarm"]
        imbalance, size = {}, {}
        for (name, how), found in group(
            [r for r in rows if r["processes"] > 1], lambda r: (r["scene"], way(r))
        ).items():
            size[scene(name), how] = [(r["processes"], r["bytes_per_particle_step"]) for r in found]
            if how == "spatial, direct":
                imbalance[scene(name), how] = [(r["processes"], r["imbalance"]) for r in found]
        figures.messages(self.place("messages"), imbalance, size)
