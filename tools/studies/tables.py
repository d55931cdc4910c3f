"""What is made of the data of the studies: errors, regret, cost to reach an error, and their tables in Markdown.

Cost. steps x particles x ns of the method (method_cost.csv, on the scene of that dimension; 1-D takes the ratio of 2-D),
in units of the reference method's ns. It is not the time that a run took, which depends on the load of the machine.

Regret. The error of a method over the best error of the methods with margin (methods.py), where a best below the floor of
the problem counts as the floor, and a ratio below 1 as 1. It is taken at equal cost: that of the reference method (quadratic
splines, usl, FLIP) at the common level of the problem. The error of a method at that cost is read from its own errors over
cost, by straight lines between grids in logarithms; beyond its finest grid the last line goes on, at most by a factor of 2
in cost, and is taken as level where the error grew. The terminal also gets the same at equal grids, whatever the cost, and
against the best of all methods, with margin or without.
"""
import csv
import math
import os

from marks import markdown
from methods import METHODS, OLD_DEFAULT, PRESETS, REFERENCE, VARIANTS, VARIED
from motion import STEPS
from problems import DATA, MAIN, PROBLEMS

INF = math.inf


def read(path):
    if not os.path.exists(path):
        return []
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def number(x):
    """Two digits: 0.018, 6.2e-4."""
    if x is None:
        return "-"
    if not math.isfinite(x):
        return "stops"
    if x >= 0.995e-2:
        return f"{x:.2f}" if x >= 0.0995 else f"{x:.3f}"
    digits, power = f"{x:.1e}".split("e")
    return f"{digits}e{int(power)}"


def ratio(x, digits=1):
    return "-" if x is None else "stops" if not math.isfinite(x) else f"{x:.{digits}f}" if x < 99.5 else f"{x:.0f}"


class Results:
    """The rows of choosing.csv and method_cost.csv, by method, problem, grid, particles per cell and cfl."""

    def __init__(self, folder=DATA, added=None):
        self.folder, self.methods = folder, METHODS | (added or {})
        self.rows, self.ns, self.guessed = {}, {}, set()
        for row in read(os.path.join(folder, "choosing.csv")):
            name = row["method"]
            if row["problem"] not in PROBLEMS:
                continue
            if name in PRESETS:
                self.rows[name, row["problem"], int(row["n"])] = row
            elif name in self.methods and row["options"] == self.methods[name].options:
                self.rows[name, row["problem"], int(row["n"]), int(row["ppc"]), float(row["cfl"])] = row
        for row in read(os.path.join(folder, "method_cost.csv")) or read(os.path.join(DATA, "method_cost.csv")):
            self.ns[int(row["dim"]), row["method"]] = float(row["ratio"])
        for dim in 2, 3:
            for name in self.methods:
                like = [name.removesuffix(" own")]  # the same step, whatever its length; aflip does what apic does
                if "aflip" in name:
                    like += [other for other in self.methods if other.split()[:2] == name.split()[:2] and "apic" in other]
                found = next((other for other in [name, *like] if (dim, other) in self.ns), None)
                if found is None or found.split()[2:3] != name.split()[2:3]:
                    self.guessed.add(name)
                self.ns[dim, name] = self.ns.get((dim, found), 1.0)

    def error(self, name, problem, n, ppc=2, cfl=None):
        """Relative error; infinite if the run was stopped, None if there is no such run."""
        row = self.rows.get((name, problem, n, ppc, cfl or self.methods[name].cfl))
        if row is None:
            return None
        return self.number(row)

    def number(self, row):
        return float(row["error"]) if row["status"] == "0" and row["error"] != "nan" else INF

    def cost(self, name, problem, n, ppc=2, cfl=None):
        row = self.rows.get((name, problem, n, ppc, cfl or self.methods[name].cfl))
        return int(row["steps"]) * int(row["particles"]) * self.ns[max(2, PROBLEMS[problem].dim), name] if row else None

    def curve(self, name, problem):
        """(cost, error) of the grids that were measured, up to the first that stopped."""
        points = []
        for n in PROBLEMS[problem].levels:
            e = self.error(name, problem, n)
            if e is None:
                continue
            if e == INF:
                break
            points.append((self.cost(name, problem, n), max(e, 1e-12)))
        return points

    def at_cost(self, name, problem, cost):
        """The error at that cost; None if nothing was measured, infinite if the method stops there."""
        points = self.curve(name, problem)
        measured = [e for n in PROBLEMS[problem].levels if (e := self.error(name, problem, n)) is not None]
        if not measured:
            return None
        if not points or (INF in measured and cost > points[-1][0]):
            return INF
        if len(points) == 1 or cost <= points[0][0]:
            return points[0][1] if abs(math.log(cost / points[0][0])) < math.log(2) else None
        for (c0, e0), (c1, e1) in zip(points, points[1:]):
            if cost <= c1 or (c1, e1) == points[-1]:
                slope = math.log(e1 / e0) / math.log(c1 / c0)
                if cost > c1:
                    return None if cost > 2 * c1 else e1 * (cost / c1)**min(slope, 0)
                return e0 * (cost / c0)**slope
        return None

    def to_reach(self, name, problem, tolerance):
        """The least cost at which the error is, and on all finer grids stays, below; infinite if it does not get there."""
        points = self.curve(name, problem)
        if not points:
            return None
        if points[-1][1] > tolerance:
            return INF
        k = len(points) - 1
        while k and points[k - 1][1] <= tolerance:
            k -= 1
        if not k:  # already the coarsest grid
            return points[0][0]
        (c0, e0), (c1, e1) = points[k - 1:k + 1]
        return c0 * (tolerance / e0)**(math.log(c1 / c0) / math.log(e1 / e0))

    def at(self, name, problem, equal):
        """The error at the common grid, or at the cost that the reference has there."""
        p = PROBLEMS[problem]
        if equal == "level":
            return self.error(name, problem, p.common)
        cost = self.cost(REFERENCE, problem, p.common)
        return self.at_cost(name, problem, cost) if cost else None

    def regret(self, name, equal="cost", everyone=False):
        """{problem: regret} of the main problems; None where something was not measured. everyone: the best of all methods."""
        found = {}
        for problem in MAIN:
            errors = [self.at(m, problem, equal) for m in self.methods if self.methods[m].margin or everyone]
            errors = [e for e in errors if e is not None]
            mine = self.at(name, problem, equal)
            found[problem] = max(1.0, mine / max(min(errors), PROBLEMS[problem].floor)) if errors and mine is not None else None
        return found


def summary(regrets):
    """Geometric mean and largest; None if something is missing."""
    values = list(regrets.values())
    if any(v is None for v in values):
        return None, None
    return (INF if INF in values else math.exp(sum(map(math.log, values)) / len(values))), max(values)


def method_names(results):
    """Methods that were measured, best geometric mean of the regret first."""
    names = [name for name in METHODS if any(key[0] == name for key in results.rows)]
    return sorted(names, key=lambda name: (summary(results.regret(name))[0] or INF, name))


def shown(results):
    """Those methods without the ones at 0.4 that are there with the program's own step too: docs/data/choosing.csv has them."""
    return [name for name in method_names(results) if f"{name} own" not in METHODS]


# ---- Tables

def margin(results, name):
    return {True: "yes", False: "no", None: "?"}[results.methods[name].margin]


def errors_table(results, names=None):
    head = ["method", "cfl", "time 2-D", "3-D", *(f"{p} {PROBLEMS[p].common}" for p in MAIN)]
    return markdown(head, [[name, f"{results.methods[name].cfl:g}", *(f"{results.ns[d, name]:.2f}" for d in (2, 3)), *(number(results.error(name, p, PROBLEMS[p].common)) for p in MAIN)]
                           for name in names or results.methods])


def regret_table(results, names=None, others=False):
    lines = []
    for name in names or method_names(results):
        regrets = results.regret(name)
        mean, largest = summary(regrets)
        more = [value for kind in (results.regret(name, "level"), results.regret(name, everyone=True)) for value in summary(kind)] if others else []
        lines.append([name, margin(results, name), ratio(mean, 2), ratio(largest), *(ratio(regrets[p]) for p in MAIN), *(ratio(v, 2 - k % 2) for k, v in enumerate(more))])
    return markdown(["method", "margin", "mean", "largest", *MAIN, *(["equal grids: mean", "largest", "best of all: mean", "largest"] if others else [])], lines)


def cheapest(results, problem, tolerance):
    """The least cost and the method that has it, among those with margin."""
    found = [(cost, name) for name in results.methods if results.methods[name].margin and (cost := results.to_reach(name, problem, tolerance)) is not None]
    return min(found, default=(INF, ""))


TOLERANCES = {0.1: "10 %", 0.01: "1 %", 0.001: "0.1 %"}


def digit_table(results):
    """What each digit costs with the method that is cheapest there."""
    lines = []
    for p in PROBLEMS:
        costs = {t: cheapest(results, p, t) for t in TOLERANCES}
        line, before = [p], None
        for t in TOLERANCES:
            cost, name = costs[t]
            line += [name or "none", "" if not name else "1" if before is None else f"{cost / before:.3g}"] if cost < INF else ["none", ""]
            before = before or (cost if cost < INF else None)
        lines.append(line)
    return markdown(["problem", "10 %", "cost", "1 %", "cost", "0.1 %", "cost"], lines)


def varied_table(results):
    lines = []
    for name in VARIED:
        for ppc, cfl in VARIANTS[1:]:  # the first is in the table of errors
            cfl = cfl or results.methods[name].cfl
            lines.append([name, ppc, f"{cfl:g}", *(number(results.error(name, p, PROBLEMS[p].common, ppc, cfl)) for p in MAIN)])
    return markdown(["method", "ppc", "cfl", *(f"{p} {PROBLEMS[p].common}" for p in MAIN)], lines)


def preset_table(results):
    lines = []
    for name, like in PRESETS.items():
        rows = {p: results.rows.get((name, p, PROBLEMS[p].common)) for p in MAIN}
        work = [int(row["steps"]) * int(row["particles"]) / results.cost(REFERENCE, p, PROBLEMS[p].common) for p, row in rows.items() if row and row["status"] == "0"]
        mean = math.exp(sum(map(math.log, work)) / len(work)) if work and all(rows.values()) else None
        lines.append([name, like, *(ratio(mean and mean * results.ns.get((dim, like), 1)) for dim in (2, 3)), *(number(row and results.number(row)) for row in rows.values())])
    return markdown(["preset", "method", "cost 2-D", "3-D", *(f"{p} {PROBLEMS[p].common}" for p in MAIN)], lines)


def motion_rows(results):
    return {(row["method"], row["case"], float(row["cfl"])): row for row in read(os.path.join(results.folder, "motion.csv"))
            if row["method"] in METHODS and row["options"] == METHODS[row["method"]].options}


def flow_table(results):
    """Sand and water, where there is no exact solution: what depends on the method, and on the length of the step. Methods with
    which no run reaches its end are left out."""
    rows, lines = motion_rows(results), []
    cases = [("sand", "front", 2), ("dam", "front", 2), ("dam", "energy", 3)]
    for name in shown(results):
        mine = {(case, cfl): rows.get((name, case, cfl)) for case in STEPS for cfl in STEPS[case]}
        if not all(mine.values()):
            continue
        if all(mine[case, cfl]["status"] != "0" for case, _, _ in cases for cfl in STEPS[case]):
            continue
        lines.append([name])
        for case, column, digits in cases:
            for cfl in STEPS[case]:
                row = mine[case, cfl]
                lines[-1].append("refused" if row["status"] == "2" else "stops" if row["status"] != "0" else f"{float(row[column]):.{digits}f}")
    return markdown(["method", "sand runs out (m), cfl 0.4", "0.1", "front of the water (m), cfl 0.4", "0.1", "energy missing, cfl 0.4", "0.1"], lines)


def motion_table(results):
    rows, lines = motion_rows(results), []
    for name in shown(results):
        mine = [rows.get((name, case, METHODS[name].cfl)) for case in ("spin", "disk", "drift")]
        if not all(mine):
            continue
        spin, disk, drift = mine

        def kept(row, column):
            return f"{float(row[column]):.3f}" if row[column] else "stops"
        grown = float(drift["energy"]) if drift["status"] == "0" else INF
        lines.append([name, *(kept(spin, c) for c in ("turns3", "turns30", "turns100")), kept(disk, "turns3"), kept(disk, "turns100"),
                      kept(disk, "energy") if disk["status"] == "0" else "stops", "stops" if grown == INF else "< 1e-9" if grown < 1e-9 else f"{grown:.0e}"])
    return markdown(["method", "block, 3 turns", "30", "100", "disk, 3 turns", "100", "disk, energy", "drift: strain energy"], lines)


TABLES = {"errors": lambda r: errors_table(r, shown(r)), "regret": lambda r: regret_table(r, shown(r)), "digit": digit_table,
          "varied": varied_table, "presets": preset_table,
          "motion": motion_table, "flow": flow_table}


def plain(results, names):
    """Errors and regret for the terminal: these methods, below them those with margin."""
    names = [*names, *(name for name in results.methods if results.methods[name].margin and name not in names and any(key[0] == name for key in results.rows))]
    text = errors_table(results, names) + "\n\nregret at equal cost (and at equal grids)\n" + regret_table(results, names, others=True)
    guessed = [name for name in names if name in results.guessed]
    if guessed:
        text += f"\ntime of a step not measured, taken as that of apic or of {REFERENCE}: {', '.join(guessed)}  (run.py --cost)"
    return align(text)


def align(text):
    """Columns of Markdown tables of equal width."""
    blocks, out = [], []
    for line in [*text.split("\n"), ""]:
        if line.startswith("|"):
            blocks.append([cell.strip() for cell in line.strip("|").split("|")])
            continue
        if blocks:
            width = [max(len(row[k]) for row in blocks) for k in range(len(blocks[0]))]
            out += ["  ".join(cell.ljust(w) if k == 0 else cell.rjust(w) for k, (cell, w) in enumerate(zip(row, width))) for row in blocks if set(row) != {"---"}]
            blocks = []
        out.append(line)
    return "\n".join(out).rstrip()
