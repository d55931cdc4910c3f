"""The tables of section 6: scaling, migration, pools, bits, balance."""

import marks
import model
from closed import way
from data import Missing
from words import group, scene, seconds, thousands, two


class Results:
    def scaling_table(self, study):
        """Efficiencies of spatial decomposition with direct migration: a line a scene, a column a class and number of
        processes."""
        classes = (
            ("measured", "", (2,)),
            ("critical path", "", (2, 8, 32)),
            ("simulated", "injected", (2, 8, 32)),
            ("simulated", "emulated", (8, 32)),
        )
        lines = []
        for name in dict.fromkeys(r["scene"] for r in self.real(study)):
            one = min(
                (r for r in self.real(study) if (r["scene"], r["processes"]) == (name, 1)), key=lambda r: r["particles"]
            )
            cells = [scene(name), thousands(one["particles"]), seconds(one["seconds_per_step"])]
            for kind, mode, sizes in classes:
                found = self.efficiencies(name, study, kind=kind, mode=mode or "injected")
                if mode == "injected":
                    size = next((r["particles"] for r in self.simulated(study) if r["scene"] == name), "")
                    cells.append(thousands(size) if size else "")
                cells += [two(found.get(p)) for p in sizes]
            lines.append(cells)
        head = [
            "scene",
            "real: particles",
            "step on 1",
            "measured: 2",
            "critical path: 2",
            "8",
            "32",
            "simulated: particles",
            "injected: 2",
            "8",
            "32",
            "emulated: 8",
            "32",
        ]
        return marks.markdown(head, lines)

    def table_strong(self):
        return self.scaling_table("strong")

    def table_weak(self):
        return self.scaling_table("weak")

    def table_large(self):
        """Injected simulation on 64 to 1024 processes."""
        lines = []
        for study, words in (("weak-large", "weak"), ("strong-large", "strong")):
            rows = self.simulated(study)
            for (name, platform, how), found in group(
                [r for r in rows if r["ranks"] > 1], lambda r: (r["scene"], r["platform"], way(r))
            ).items():
                by = {r["ranks"]: r for r in found}
                what = how + ", racks of 32" * (platform == "fattree")
                one = next(r["particles"] for r in rows if (r["scene"], r["ranks"]) == (name, 1))
                lines.append(
                    [
                        words,
                        scene(name),
                        what,
                        thousands(one),
                        *(two(by[p]["efficiency"]) if p in by else "" for p in (64, 128, 256, 512, 1024)),
                    ]
                )
        return marks.markdown(
            ["scaling", "scene", "way", "particles on one process", "64", "128", "256", "512", "1 024"], lines
        )

    def ratios_of_migration(self):
        """{(scene, class, processes): time with DMSwarmMigrate over that with direct migration}, strong scaling."""
        rows = [{**r, "class": "simulated", "processes": r["ranks"]} for r in self.simulated("strong")] + self.real(
            "strong"
        )
        out = {}
        for key, both in group(
            [r for r in rows if r["strategy"] == "spatial"], lambda r: (r["scene"], r["class"], r["processes"])
        ).items():
            t = {r["migrate"]: r["seconds_per_step"] for r in both}
            if "direct" in t and "swarm" in t:
                out[key] = t["swarm"] / t["direct"]
        return out

    def table_migration(self):
        found = self.ratios_of_migration()
        columns = [("measured", 2), ("critical path", 8), ("critical path", 32), ("simulated", 8), ("simulated", 32)]
        lines = [
            [scene(name), *(two(found.get((name, *c))) for c in columns)] for name in dict.fromkeys(k[0] for k in found)
        ]
        return marks.markdown(
            ["scene", "measured: 2 processes", "critical path: 8", "32", "injected simulation: 8", "32"], lines
        )

    def table_pool(self):
        """Speed-ups of the pool in the runs, with the patches that these had."""
        lines = []
        for name in dict.fromkeys(r["scene"] for r in self.real("strong")):
            real, path = (self.efficiencies(name, "strong", "pool", k) for k in ("measured", "critical path"))
            try:
                simulated = self.efficiencies(name, "strong", "pool")
            except Missing:
                simulated = {}
            if not real:
                continue
            patch = next(
                (
                    r["pool_cells"]
                    for r in self.real("strong")
                    if (r["scene"], r["strategy"]) == (name, "pool") and r.get("pool_cells")
                ),
                16,
            )
            best = max(simulated, key=lambda p: p * simulated[p], default=None)
            cells = [scene(name), patch, two(2 * real[2])]
            cells += [two(p * path[p]) if p in path else "" for p in (8, 32)]
            cells += [two(8 * simulated[8]) if 8 in simulated else ""]
            lines.append([*cells, f"{best * simulated[best]:.2f} on {best}" if best else ""])
        head = (
            "scene",
            "cells of a patch",
            "measured: 2 processes",
            "critical path: 8",
            "32",
            "injected simulation: 8",
            "at best",
        )
        return marks.markdown(head, lines)

    def simulated_imbalance(self, name, processes):
        rows = self.simulated("strong")
        return next(
            r["imbalance"] for r in rows if (r["scene"], r["ranks"], way(r)) == (name, processes, "spatial, direct")
        )

    def counts(self):
        """Messages and bytes of filled boxes, counted and by formula."""
        return self.data.scaling_file("counts")

    def digests(self):
        """For each scene, number of particles and steps that ran in several ways: the number of runs and of different
        digests."""
        rows = [r for r in self.data.scaling() if r["digest"] != ""]
        out = []
        for key, found in group(rows, lambda r: (r["scene"], r["study"], r["particles"], r["steps"])).items():
            runs = {(r["strategy"], r["migrate"], r["processes"]) for r in found}
            if len(runs) > 1:
                out.append((*key, len(runs), len({str(r["digest"]) for r in found})))
        if not out:
            raise Missing("`docs/data/scaling/runs.csv` has no digests: `make scaling` writes them")
        return out

    def balances(self):
        """{scene: {processes: imbalance}} by the program's own cuts."""
        if "cuts" not in self.said:
            self.said["cuts"] = {
                label: {
                    p: row["imbalance"]
                    for p, row in model.parse(self.pebble("-options_file", *options, "-dry_run", "-report_processes"))[
                        "rows"
                    ].items()
                }
                for label, options in (
                    ("disks, 1024 x 1024 cells", ("options/disks.opts", "-grid_cells", "1024,1024")),
                    ("disks, 20 x 20 cells", ("options/disks.opts",)),
                    ("two balls, 32 x 32 x 32 cells", ("options/disks3d.opts", "-method_basis", "linear")),
                )
            }
        return self.said["cuts"]
