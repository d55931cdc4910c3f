"""What the closed form says: constants, isoefficiency, the pool with its best patches."""

import marks
import scenes
import short_model
from closed import BOXES, WEAK
from words import scene, thousands, two

REACH = (2, 32, 1024, 32768, 1000000)  # processes


class Predictions:
    def same_source(self, name, processes, swarm=False):
        """Weak efficiency and imbalance with the costs of the simulator, of the boxes that it had. Numerator and
        denominator are both by formula, so on one process it is 1."""
        e, imbalance = self.boxes(name, processes, swarm)
        return e / self.boxes(name, 1, swarm)[0], imbalance

    # ---- The short model
    def shorts(self):
        """The models of all scenes, as docs/model.md has them: costs of phases as injected, the rest calibrated."""
        if "shorts" not in self.said:
            self.said["shorts"] = short_model.Scenes(self.args)
        return self.said["shorts"]

    def compared(self, name):
        """Particles; five constants; best edge of the pool's patches; the pool's bound; and rows of processes, imbalance,
        and speed-ups by the short and the full model, of spatial decomposition and of the pool."""
        if ("compared", name) not in self.said:
            self.said["compared", name] = self.shorts().compare(name)
        return self.said["compared", name]

    def table_constants(self):
        lines = []
        for name in scenes.SCENES:
            total, s, *_ = self.compared(name)
            five = f"{1e9 * s.particle:.1f} ns", f"{1e6 * s.latency:.1f} µs", f"{1e9 * s.face:.0f} ns"
            five += f"{1e6 * s.doubling:.1f} µs", f"{1e9 * s.master:.1f} ns"
            lines.append([scene(name), thousands(total), *five, two(s.bound())])
        head = ["scene", "particles", "$C$", "$L$", "$B$", "$R$", "$M$", "bound of the pool, $C/M$"]
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

    # ---- The pool with its best patches
    def best_pools(self, name):
        """Of a scene: best patch; for spatial decomposition and the pool {processes: speed-up}; bound of the pool."""
        _, _, edge, bound, rows = self.compared(name)
        return {
            "patch": edge,
            "spatial": {p: full for p, _, _, full, _, _ in rows},
            "pool": {p: pool for p, _, _, _, _, pool in rows},
            "bound": bound,
        }

    def table_best(self):
        lines = []
        for name in scenes.SCENES:
            found = self.best_pools(name)
            cells = [scene(name), found["patch"]]
            cells += [*(two(found["pool"].get(p)) for p in (2, 8, 32)), two(found["bound"])]
            lines.append([*cells, *(two(found["spatial"].get(p)) for p in (2, 8, 32))])
        head = ["scene", "best patch", "pool: 2", "8", "32", "bound", "spatial: 2", "8", "32"]
        return marks.markdown(head, lines)
