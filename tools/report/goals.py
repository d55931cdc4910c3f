"""The table of goals, which were set before the runs, and that of the checks of the instruments."""

import marks
from closed import WEAK, way
from data import Missing
from words import group, inside, scene, span, thousands

SET = "194835d, 2026-11-21"  # the commit that set the goals
MODEL, STEP, SIMULATOR = (
    (0.9, 1.1),
    (0.85, 1.15),
    (0.88, 1.06),
)  # bounds of closed form / simulation, predicted / measured, simulator


def verdict(met):
    return "met" if met else "**missed**"


class Goals:
    def strong_goal(self):
        """(class, efficiency net of imbalance, gross) of the filled 3-D box on 32 processes."""
        out = []
        for kind, rows, p in (
            ("injected simulation", self.simulated("strong"), "ranks"),
            ("critical path", self.real("strong"), "processes"),
        ):
            for r in rows:
                if (r["scene"], r[p], way(r), r.get("class", kind)) == ("box3d", 32, "spatial, direct", kind):
                    out.append((kind, r["efficiency"] * r["imbalance"], r["efficiency"]))
        return out

    def weak_goal(self, name, p):
        """(class, efficiency gross, net or None): simulated if p was; by the closed form with the costs of the
        simulator."""
        out = []
        for r in self.simulated("weak-large") + self.simulated("weak"):
            if (r["scene"], r["ranks"], r["platform"], way(r)) == (name, p, "cluster", "spatial, direct"):
                out.append(("injected simulation", r["efficiency"], r["efficiency"] * r["imbalance"]))
        e, imbalance = self.same_source(name, p)
        return [*out, ("closed form", e, e * imbalance)]

    def against(self, which, most=32):
        """Closed form over simulation of filled boxes on 2 to so many processes."""
        return [r[5] / r[4] for r in self.against_simulation(which) if r[2] <= most]

    def short_runs(self):
        """Predicted over measured steps of the scenes of options/, in short runs in turns with the calibration."""
        return [r["predicted"] / r["measured"] for r in self.data.validation() if "strategy" not in r]

    def users(self):
        """Predicted over measured steps of whole runs, started one by one: (scene, processes, ratio)."""
        return [(r["scene"], r["processes"], r["predicted"] / r["measured"]) for r in self.data.scaling_file("users")]

    def goals_met(self):
        """How many, of how many."""
        lines = self.goals()
        return sum(line[-1] == "met" for line in lines), len(lines)

    def table_goals(self):
        return marks.markdown(["", f"goal (all set by commit {SET})", "found", ""], self.goals())

    def goals(self):
        lines = []

        def add(goal, make):
            try:
                found, met = make()
            except Missing as m:
                self.note("goals", str(m))
                found, met = "no data", None
            lines.append([len(lines) + 1, goal, found, "open" if met is None else verdict(met)])

        def strong():
            found = self.strong_goal()
            return "; ".join(f"{kind}: {net:.2f} net, {gross:.2f} gross" for kind, net, gross in found), all(
                n >= 0.9 for _, n, _ in found
            )

        def balance():
            found = self.balances()["disks, 1024 x 1024 cells"][32]
            return (
                f"{found:.3f}, counted; {self.number_imbalance_before()} before cuts had to lie between tiles",
                found <= 1.05,
            )

        def weak(name, p, bound):
            found = self.weak_goal(name, p)
            return "; ".join(f"{kind}: {gross:.4f} gross, {net:.4f} net" for kind, gross, net in found), all(
                g >= bound for _, g, _ in found
            )

        def model():
            words, met = [], True
            for which in ("spatial, direct", "spatial, DMSwarmMigrate", "pool"):
                some = self.against(which)
                words.append(f"{which}: {inside(some, *MODEL)} of {len(some)} ({span(some)})")
                met &= inside(some, *MODEL) == len(some)
            return "; ".join(words), met

        def step():
            some, whole = self.short_runs(), [ratio for _, _, ratio in self.users()]
            words = (
                f"short runs in turns with the calibration: {inside(some, *STEP)} of {len(some)}; whole runs as users"
                " start them: "
            )
            met = inside(some, *STEP) == len(some) and inside(whole, *STEP) == len(whole)
            return f"{words}{inside(whole, *STEP)} of {len(whole)}", met

        add(
            "strong efficiency net of imbalance at least 0.90: filled box, 3-D, 8 000 particles a process, 32"
            " processes",
            strong,
        )
        add("imbalance at most 1.05: two disks on 1024 x 1024 cells, 32 processes", balance)
        for name in ("box2d", "box3d"):
            for p, bound in ((1024, 0.9), (32768, 0.88)):
                add(
                    f"weak efficiency at least {bound:.2f}: {scene(name)}, {thousands(WEAK)} particles a process,"
                    f" {thousands(p)} processes",
                    lambda: weak(name, p, bound),
                )
        add("closed form within 10 % of the injected simulation, filled boxes, 2 to 32 processes", model)
        add("predicted within 15 % of the measured step, the scenes of `options/` (16 when it was set, now 24) on"
            " 1 and 2 processes", step)
        return lines

    def simulator(self):
        """{what was simulated: simulated over measured times}. Injected runs on one process are left out: their costs
        come from these very runs, so they show nothing."""
        rows = [r for r in self.data.simulated("validate") if r["ranks"] > 1]
        out = {}
        for mode in ("injected", "emulated"):
            for (pool, transport), some in sorted(
                group(rows, lambda r: (r["strategy"] != "spatial", r["transport"])).items()
            ):
                label = f"{mode}, {'pool' if pool else 'spatial'}, {'TCP' if transport == 'tcp' else 'shared memory'}"
                out[label] = [r[f"{mode}_over_real"] for r in some]
        return out

    def table_checks(self):
        """Checks of the instruments: the simulator beside real runs, and counts beside formulas."""
        lines = [
            [what, span(some), f"{inside(some, *SIMULATOR)} of {len(some)}"] for what, some in self.simulator().items()
        ]
        counted = self.counts()
        same = sum(r["equal"] == "yes" for r in counted)
        lines.append(["messages and bytes counted, over the formulas", "1 where equal", f"{same} of {len(counted)}"])
        return marks.markdown(["simulated over measured step, two processes", "range", "within -12 to +6 %"], lines)
