"""What the closed form says: constants, isoefficiency, pools with their best patches."""

import os

import launch
import marks
import model
import scenes
from closed import BOXES, NETWORK, WEAK
from words import scene, thousands, two

REACH = (2, 32, 1024, 32768, 1000000)  # processes


class Predictions:
    def same_source(self, name, processes, swarm=False):
        """Weak efficiency and imbalance with the costs of the simulator, of the boxes that it had. Numerator and
        denominator are both by formula, so on one process it is 1."""
        e, imbalance = self.boxes(name, processes, swarm)
        return e / self.boxes(name, 1, swarm)[0], imbalance

    def five(self, name):
        """The constants of the short model, in s: a particle's work, a message, a byte, the reduction for each doubling
        of the processes, the master's time for a particle."""
        m, whole = self.closed(name), self.whole(name)
        busy = m.pool(model.replace(whole, processes=8), m.patch(whole))[1] / whole.particles
        byte = m.numbers["wire"] + m.numbers["copy"]
        return m.step(whole) / whole.particles, NETWORK["message"], byte, NETWORK["reduction"], busy

    def table_constants(self):
        lines = []
        for name in BOXES:
            t, a, g, r, m = self.five(name)
            lines.append(
                [
                    scene(name),
                    f"{1e9 * t:.1f} ns",
                    f"{1e6 * a:.1f} µs",
                    f"{1e9 * g:.3f} ns",
                    f"{1e6 * r:.1f} µs",
                    f"{1e9 * m:.1f} ns",
                    two(t / m),
                ]
            )
        head = (
            "scene",
            "work of a particle, t",
            "message, a",
            "byte, g",
            "reduction, r",
            "master's work a particle, m",
            "bound of the pool, t/m",
        )
        return marks.markdown(head, lines)

    def least_particles(self, name, efficiency, processes):
        m = self.closed(name)
        return float(f"{m.least(2**m.dim, processes, self.moved(name), efficiency):.2g}")

    def table_least(self):
        """Particles a process with which cubes keep an efficiency, and weak efficiencies with 16 384."""
        lines = []
        for name in BOXES:
            for e in (0.8, 0.9):
                lines.append(
                    [
                        scene(name),
                        f"particles a process for an efficiency of {e}",
                        *(thousands(self.least_particles(name, e, p)) for p in REACH),
                    ]
                )
            for swarm in (False, True):
                how = "DMSwarmMigrate" if swarm else "direct"
                lines.append(
                    [
                        scene(name),
                        f"efficiency with {thousands(WEAK)}, {how}",
                        *(two(self.weak(name, WEAK, p, swarm)) for p in REACH),
                    ]
                )
        return marks.markdown(["scene", "", *map(thousands, REACH)], lines)

    # ---- Pools with their best patches
    def told(self, name, *more, ranks=1):
        """What the program prints of a scene on other numbers of processes; with the calibrated constants where there
        are some."""
        if (name, more) not in self.said:
            file = scenes.write(self.work.name, name, scenes.SCENES[name].strong)
            words = [
                "-options_file",
                file,
                "-parallel_migrate",
                "direct",
                "-output_format",
                "none",
                "-dry_run",
                "-report_processes",
                *more,
            ]
            folder = os.path.join(self.work.name, "rough")
            if name in BOXES:
                self.closed(name)  # writes the file of the constants
                words += ["-model_file", os.path.join(self.work.name, f"{name}.model")]
            self.said[name, more] = model.parse(self.pebble(*words, ranks=ranks, folder=folder))
        return self.said[name, more]

    def pebble(self, *options, ranks=1, program=None, folder=None):
        """The same as of the closed form, but the folder of the output may be another: an empty one has no constants to
        be found."""
        if folder is None:
            return super().pebble(*options, ranks=ranks, program=program)
        command = ([self.args.mpiexec, "-n", str(ranks)] if ranks > 1 else []) + [
            self.args.pebble,
            *map(str, options),
            "-output_dir",
            folder,
        ]
        done = launch.run(command, capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"report.py: {' '.join(command)}\n{done.stdout[-800:]}{done.stderr[-800:]}")
        return done.stdout

    def best_pools(self, name):
        """Best patch; for spatial decomposition and both pools {processes: speed-up}; bounds of the pools."""
        first = self.told(name)
        one, patch = first["rows"][1]["spatial"], first["patch"]
        dealt = self.told(name, "-pool_cells", str(patch))
        kept = self.told(name, "-parallel_strategy", "pool", "-pool_particles", "workers", ranks=2)
        by = lambda said, way: {p: one / row[way] for p, row in said["rows"].items() if row[way]}
        return {
            "patch": patch,
            "spatial": by(first, "spatial"),
            "master": by(dealt, "pool"),
            "workers": by(kept, "pool"),
            "bounds": {"master": dealt["bound"], "workers": kept["bound"]},
        }

    def table_best(self):
        lines = []
        for name in scenes.SCENES:
            found = self.best_pools(name)
            cells = [scene(name), "calibrated" if name in BOXES else "rough", found["patch"]]
            for way in ("master", "workers"):
                cells += [*(two(found[way].get(p)) for p in (2, 8, 32)), two(found["bounds"][way])]
            lines.append([*cells, *(two(found["spatial"].get(p)) for p in (2, 8, 32))])
        head = [
            "scene",
            "constants",
            "best patch",
            "master has the particles: 2",
            "8",
            "32",
            "bound",
            "workers keep them: 2",
            "8",
            "32",
            "bound",
            "spatial: 2",
            "8",
            "32",
        ]
        return marks.markdown(head, lines)
