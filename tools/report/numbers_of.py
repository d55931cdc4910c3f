"""The numbers in the text: number_NAME makes the number NAME of docs/report.md."""

from closed import BOXES, way
from data import Missing
from goals import STEP
from words import group, inside, names, scene, span, thousands, three, two


class Numbers:
    # ---- First page
    def number_interval(self):
        return "{:.2f} to {:.2f}".format(*self.interval("injected simulation")[:2])

    def least_and_most(self, key):
        some = [a[key] for a in self.answers() if a["study"] == "strong"]
        return f"{thousands(min(some))} to {thousands(max(some))}"

    def number_processes(self):
        return self.least_and_most("processes")

    def number_speedups(self):
        some = [a["speedup"] for a in self.answers() if a["study"] == "strong"]
        return f"{min(some):.3g} to {max(some):.3g}"

    def number_two(self):
        return span([a["two"] for a in self.answers() if a.get("two")])

    def kept_runs(self, name):
        """[(particles a process, processes, efficiency)] of the simulated runs of a box, spatial and direct."""
        runs = []
        for study in ("strong", "weak", "strong-large", "weak-large"):
            runs += [
                r
                for r in self.simulated(study)
                if (r["scene"], way(r), r["platform"]) == (name, "spatial, direct", "cluster")
            ]
        return [(r["particles"] // r["ranks"], r["ranks"], r["efficiency"]) for r in runs]

    def kept(self, name):
        """{processes: least particles a process with which all simulated runs on up to so many keep 0.8}"""
        runs, out = self.kept_runs(name), {}
        for p in sorted({p for _, p, _ in runs}):
            worst = max((n for n, q, e in runs if q <= p and e < 0.8), default=0)
            if enough := [n for n, q, e in runs if q == p and n > worst and e >= 0.8]:
                out[p] = min(enough)
        return out

    def kept_words(self, name):
        found = self.kept(name)
        last = {}
        for p, n in found.items():
            last[n] = p  # the most processes for each number of particles
        return " and ".join(
            f"{thousands(n)} particles a process on up to {thousands(p)}" for n, p in sorted(last.items()) if p >= 32
        )

    def number_kept_2d(self):
        return self.kept_words("box2d")

    def number_kept_3d(self):
        return self.kept_words("box3d")

    def number_most_simulated(self):
        return thousands(
            max(
                max(r["ranks"] for r in self.data.simulated(n))
                for n in ("strong", "weak", "weak-large", "strong-large")
            )
        )

    # ---- Scenes and serial program
    def number_differing(self):
        """Which scenes are not yet the same in real and simulated runs, in a sentence."""
        found = self.differing()
        if not found:
            return "Real and simulated runs are of the same scenes"
        return (
            f"The real runs of {names([scene(s) for s in found])} are older than this rule and of other definitions"
            " than the simulated ones, so a difference between their rows may be one of scenes"
        )

    def serial(self, name):
        """ns a particle and step, measured on one process."""
        for r in self.real("strong"):
            if (r["scene"], r["processes"], r["class"]) == (name, 1, "measured"):
                return 1e9 * r["seconds_per_step"] / r["particles"]
        raise Missing(f"`docs/data/scaling/runs.csv` has no run of {name} on one process: `make scaling` writes it")

    def number_serial_2d(self):
        return f"{self.serial('box2d'):.0f}"

    def number_serial_3d(self):
        return f"{self.serial('box3d'):.0f}"

    def travels(self, name):
        """Bytes of a particle's fields that the pool's master sends and receives in a step."""
        self.closed(name)
        return str(sum(phase.bytes for phase in self.predictor(name).phases))

    def number_travels_2d(self):
        return self.travels("box2d")

    def number_travels_3d(self):
        return self.travels("box3d")

    # ---- Results
    def number_bits(self):
        found = self.digests()
        return f"{len(found)} scenes and sizes, {sum(n for *_, n, _ in found)} runs"

    def number_path_32(self):
        some = [self.efficiencies(s, "strong", kind="critical path")[32] for s in self.all_scenes()]
        return span(some)

    def number_injected_32(self):
        return span([self.efficiencies(s, "strong")[32] for s in self.all_scenes()])

    def number_emulated_32(self):
        return span([self.efficiencies(s, "strong", mode="emulated")[32] for s in self.all_scenes()])

    def all_scenes(self):
        return list(dict.fromkeys(r["scene"] for r in self.real("strong")))

    def number_swarm_256(self):
        swarm = self.efficiencies("box2d", "weak-large", "spatial, DMSwarmMigrate")
        return two(swarm[256])

    def number_direct_256(self):
        return two(self.efficiencies("box2d", "weak-large")[256])

    def migrating(self):
        """{scene: (steps with a migration, steps)} of the real runs of filled boxes on 32 processes with
        DMSwarmMigrate."""
        rows = [
            r for r in self.real("strong") if (r["processes"], r["migrate"]) == (32, "swarm") and r["scene"] in BOXES
        ]
        return {r["scene"]: (r["migrating_steps"], r["steps"]) for r in rows}

    def number_migrating(self):
        found = sorted(set(self.migrating().values()))
        return " and ".join(f"{a} of {b}" for a, b in found)

    def number_injected_below(self):
        some = [q for q in self.pairs() if q["class"] == "injected simulation" and not q["pool"]]
        return f"{sum(q['time'] < 1 for q in some)} of {len(some)}"

    def number_path_above(self):
        """In how many pairs the critical path promises more than was measured."""
        some = [q for q in self.pairs() if q["class"] == "critical path" and not q["pool"]]
        return f"{sum(q['efficiency'] < 1 for q in some)} of {len(some)}"

    def number_short_span(self):
        return span(self.short_runs())

    def number_short_runs(self):
        some = self.short_runs()
        return f"{inside(some, *STEP)} of {len(some)}"

    def number_interval_strong(self):
        measured, simulated = (
            [self.efficiencies(name, "strong", **how)[2] for name in self.all_scenes()] for how in ({"kind": "measured"}, {})
        )
        return span([m / s for m, s in zip(measured, simulated)])

    def number_users(self, processes=(1, 2)):
        whole = [ratio for _, p, ratio in self.users() if p in processes]
        return f"{inside(whole, *STEP)} of {len(whole)}"

    def number_users_one(self):
        return self.number_users((1,))

    def number_users_two(self):
        return self.number_users((2,))

    def number_users_span(self):
        return span([1 / ratio for _, _, ratio in self.users()])

    def number_many_span(self):
        return span([r["ratio"] for r in self.path_ratios()])

    def path_ratios(self):
        """Closed form over critical path, spatial decomposition on 4 to 32 processes, with `ratio`."""
        rows = [r for r in self.data.scaling() if r["strategy"] == "spatial" and 4 <= r["processes"] <= 32]
        out = []
        for runs in group(rows, lambda r: (r["scene"], r["study"], r["processes"], r["particles"], way(r))).values():
            t = {r["class"]: r["seconds_per_step"] for r in runs}
            if "critical path" in t and "closed form" in t:
                out.append({**runs[0], "ratio": t["closed form"] / t["critical path"]})
        return out

    def number_imbalance_now(self):
        return f"{self.balances()['disks, 1024 x 1024 cells'][32]:.3f}"

    # ---- The pool
    def number_pool_best(self):
        return span([max(self.best_pools(s)["pool"].values()) for s in self.all_scenes()])

    def number_overtakes(self):
        """The cost of the law from which on the pool is ahead of spatial decomposition in 3-D on 32 processes."""
        if (t := self.overtakes()) is None:
            return "at no cost of the law up to 1 ms"
        return f"beyond {float(f'{1e6 * t:.2g}'):g} µs a particle and step"

    def overtakes(self):
        m, s = self.closed("box3d"), self.whole("box3d")
        for k in range(0, 121):
            d = m.dearer(1e-9 * 10 ** (k / 20))
            if self.best_pool(d, s, 32) < self.spatial(d, "box3d", 32)[0]:
                return 1e-9 * 10 ** (k / 20)
        return None

    # ---- Runs ten times as long
    def longer(self):
        """{scene: (step on one process, efficiency on two)}, each of the long runs over the short ones."""
        out = {}
        for name, rows in group(self.data.scaling_file("lengths"), lambda r: r["scene"]).items():
            few, many = sorted({r["steps"] for r in rows})
            t = {(r["processes"], r["steps"]): r["seconds_per_step"] for r in rows}
            out[name] = (t[1, many] / t[1, few], t[1, many] / t[2, many] * t[2, few] / t[1, few])
        return out

    def number_longer_step(self):
        return span([step for step, _ in self.longer().values()])

    def number_longer_efficiency(self):
        return span([efficiency for _, efficiency in self.longer().values()])

    # ---- Others
    def number_plain(self):
        """The plain serial program over pebble, by make bench."""
        rows = [r for r in self.data.file("bench/floor.csv") if r["group"] == "seed" and r["update"] == "usf"]
        out = [q / p for n in {r["particles"] for r in rows} for q, p in [self.least_ns(rows, n)]]
        least, most = f"{min(out):.1f}", f"{max(out):.1f}"
        return least if least == most else f"{least} to {most}"

    @staticmethod
    def least_ns(rows, particles):
        ns = {r["program"]: r["min_ns"] for r in rows if r["particles"] == particles}
        return ns["seed_serial"], ns["pebble"]

    def number_counts(self):
        return str(len(self.counts()))

    def tiles(self):
        """What tiles changed: rows of quantity, scene, before, after."""
        return self.data.file("tiles.csv")

    def number_imbalance_before(self):
        return f"{next(r['before'] for r in self.tiles() if r['quantity'] == 'imbalance on 32 processes'):.3f}"

    def number_equal_boxes(self):
        return f"{self.equal_boxes():.2f}"

    def equal_boxes(self):
        """The imbalance of the two disks on 32 processes with equal boxes, by -parallel_balance none."""
        return next(r["before"] for r in self.tiles() if r["quantity"].startswith("imbalance of equal"))

    def number_tiles_gain(self):
        return span([r["before"] / r["after"] for r in self.tiles() if r["after"]])

    def number_goals_met(self):
        met, of = self.goals_met()
        words = "zero one two three four five six seven eight".split()
        return (
            f"{'None' if not met else words[met].capitalize()} of the {words[of]} goals"
            f" {'is' if met < 2 else 'are'} met"
        )
