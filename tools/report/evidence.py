"""The classes of evidence, how well each has held where it could be tested, and the tables of the report's first page.
"""

import marks
from closed import ClosedForm, way
from data import Missing
from words import MANY, group, scene, thousands, three, two

KEPT = 0.8  # the efficiency that a recommended number of processes keeps
CLASSES = "critical path", "injected simulation", "emulated simulation", "closed form"


class Evidence(ClosedForm):
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

    def simulated(self, name, mode="injected"):
        rows = [r for r in self.data.simulated(name) if r["mode"] == mode]
        if not rows:
            raise Missing(f"`docs/data/simulated/{name}.csv` has no rows of mode {mode}: `make simulate` writes them")
        return rows

    def efficiencies(self, name, study, how="spatial, direct", kind="simulated", mode="injected", platform="cluster"):
        """{processes: efficiency} of a scene in a class of evidence."""
        if kind == "simulated":
            rows = [
                {**r, "class": kind, "processes": r["ranks"]}
                for r in self.simulated(study, mode)
                if r["platform"] == platform
            ]
        else:
            rows = self.real(study)
        return {r["processes"]: r["efficiency"] for r in rows if (r["scene"], way(r), r["class"]) == (name, how, kind)}

    # ---- Where truth is known
    def pairs(self):
        """For each run on two processes of which wall time and another class are known: class, scene, particles,
        `pool`, `time`: time of the class over wall time; `efficiency`: measured efficiency over that of the class.
        """
        out = []
        rows = [r for r in self.data.scaling() if r["study"] in ("strong", "weak") and r["processes"] == 2]
        for runs in group(rows, lambda r: (r["scene"], r["study"], r["particles"], way(r))).values():
            by = {r["class"]: r for r in runs}
            for kind in ("critical path", "closed form"):
                if "measured" in by and kind in by:
                    m, r = by["measured"], by[kind]
                    time, efficiency = r["seconds_per_step"] / m["seconds_per_step"], m["efficiency"] / r["efficiency"]
                    out.append({"class": kind, "time": time, "efficiency": efficiency, "row": m, **self.key(r)})
        rows = self.data.simulated("validate")
        one = {(r["scene"], r["particles"]): r for r in rows if r["ranks"] == 1}
        for r in (r for r in rows if r["ranks"] == 2):
            alone = one[r["scene"], r["particles"]]
            for mode in ("injected", "emulated"):
                efficiency = alone["real"] / r["real"] / (alone[mode] / r[mode])
                out.append(
                    {
                        "class": f"{mode} simulation",
                        "time": r[f"{mode}_over_real"],
                        "efficiency": efficiency,
                        "row": r,
                        **self.key(r),
                    }
                )
        return out

    @staticmethod
    def key(row):
        return {"scene": row["scene"], "particles": row["particles"], "pool": row["strategy"] != "spatial"}

    def interval(self, kind, pool=False, large=True, what="efficiency"):
        """The least and the largest, and of how many pairs."""
        found = [
            q[what] for q in self.pairs() if (q["class"], q["pool"], q["particles"] >= MANY) == (kind, pool, large)
        ]
        if not found:
            raise Missing(
                f"no runs on two processes of {kind} have a measured time: `make scaling` and `make simulate` write"
                " them"
            )
        return min(found), max(found), len(found)

    def table_sure(self):
        """For each class, the interval of measured over its efficiency on two processes, and what it leaves out."""
        without = {
            "critical path": (
                "network; waiting but for the slowest process of each phase; competition for memory beyond two cores."
                " It has caches that are cold after each turn"
            ),
            "injected simulation": (
                "caches, competition for memory, disturbances: a particle costs the same on every process"
            ),
            "emulated simulation": (
                "competition for memory. It has all processes in the caches of one core, and all disturbances of the"
                " machine that simulates"
            ),
            "closed form": "disturbances; waiting but for the imbalance of particles and a constant",
        }
        lines = []
        for kind in CLASSES:
            cells = []
            for pool, large in ((False, True), (False, False), (True, True)):
                low, high, n = self.interval(kind, pool, large)
                cells.append(f"{low:.2f} to {high:.2f} ({n})")
            lines.append([kind, *cells, without[kind]])
        head = (
            "class of evidence",
            "spatial, at least 100 000 particles",
            "spatial, fewer",
            "pool, at least 100 000",
            "what it leaves out, and what it has too much",
        )
        return marks.markdown(head, lines)

    # ---- The answer
    @staticmethod
    def keeps(efficiencies):
        """The most processes up to which an efficiency of 0.8 is kept before rounding, and whether it is the most
        tried."""
        tried = sorted(p for p in efficiencies if p > 1)
        low = next((p for p in tried if efficiencies[p] < KEPT), None)
        return max((p for p in tried if low is None or p < low), default=1), low is None

    def particles(self, name, study):
        return next(r["particles"] for r in self.simulated(study) if r["scene"] == name)

    def answers(self):
        """A dictionary for each scene and size: the recommended processes with their speed-up, and what other classes
        say of it."""
        low, high, _ = self.interval("injected simulation")
        out = []
        for name in dict.fromkeys(r["scene"] for r in self.simulated("strong")):
            for study in ("strong", "strong-large"):
                found = self.efficiencies(name, study)
                if not found:
                    continue
                p, most = self.keeps(found)
                one = {
                    "scene": name,
                    "study": study,
                    "processes": p,
                    "most": most,
                    "particles": self.particles(name, study),
                }
                one |= {"speedup": (s := found.get(p, 1) * p), "range": (s * low, s * high)}
                if study == "strong":
                    path, real = (self.efficiencies(name, "strong", kind=k) for k in ("critical path", "measured"))
                    pool = self.efficiencies(name, "strong", "pool", "measured")
                    one |= {
                        "path": path[p] * p if p in path else None,
                        "two": 2 * real[2] if 2 in real else None,
                        "pool": 2 * pool[2] if 2 in pool else None,
                    }
                out.append(one)
        return out

    def table_answer(self):
        lines = []
        for a in sorted(
            self.answers(),
            key=lambda a: (list(dict.fromkeys(b["scene"] for b in self.answers())).index(a["scene"]), a["study"]),
        ):
            low, high = a["range"]
            cells = [
                scene(a["scene"]),
                thousands(a["particles"]),
                thousands(a["processes"]) + " or more" * a["most"],
                three(a["speedup"]),
                f"{low:.3g} to {high:.3g}",
            ]
            lines.append(
                [*cells, *(three(a[k]) if a.get(k) else "" for k in ("path", "two")), two(a.get("pool") or "")]
            )
        head = (
            "scene",
            "particles",
            "processes",
            "speed-up: injected simulation",
            "with its interval of Table 2",
            "critical path",
            "on 2, measured",
            "pool on 2, measured",
        )
        return marks.markdown(head, lines)
