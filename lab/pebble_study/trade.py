"""The work-precision study: error, time and memory of settings of methods on a series of grids. Errors are parts of
the solution's size. Where the solution is not known, one run with the finest grid halved once more is the reference
for all, and a second one with another basis says how far it can be trusted."""

import concurrent.futures
import csv
import dataclasses
import math
import os

import numpy as np
import pebble_mpm as pebble

from . import front, methods, scene, series
from .scene import Refused

TEXTS = ("study", "basis", "gimp_update", "update", "transfer", "cells", "status", "key", "note")
FORMS = (
    dict.fromkeys(("flip", "strain", "rate", "cfl"), ".10g")
    | dict.fromkeys(("order", "ppc", "particles", "steps", "front", "repeats"), ".0f")
    | dict.fromkeys(("seconds", "seconds_min", "seconds_max", "memory"), ".6g")
    | {"h": ".17g", "error": ".17g", "ns": ".5g"}
)
COLUMNS = (
    "study,basis,gimp_update,update,transfer,flip,order,strain,rate,ppc,cells,cfl,h,particles,steps,seconds,"
    "seconds_min,seconds_max,ns,memory,error,status,front,repeats,key,note"
).split(",")
# -method_*: they belong to one method, and would be refused with another.
OF_ONE = ("flip", "order", "gimp_update", "affine_strain", "damping_rate", "frame", "mass_order")
DEFAULTS = {"update": "usl,musl", "transfer": "flip,apic,aflip"}
# Who asks for presets alone gets two methods beside them, which can make the references.
WITH_PRESETS = {"basis": "bspline2,bspline3", "update": "usl", "transfer": "aflip"}


@dataclasses.dataclass(eq=False)
class Setting:
    """What is replaced in the scene besides its grid: the method, particles per cell, -dt_cfl; or a preset, which sets
    all of these, with a -dt_cfl beside it or without; or nothing, of the scene's own."""

    name: str
    basis: str = ""
    update: str = ""
    word: str = ""  # of --transfer
    ppc: int = 0
    cfl: float = 0.0
    preset: str = ""
    own: bool = False  # is it what the scene has?
    predicted: float = 0.0  # s of the run on the first grid, by the model
    axes: list | None = None  # particles per cell and axis of each body

    def apply(self, options, facts):
        names, cleared = scene.bodies(options), {f"method_{name}": None for name in OF_ONE}
        if self.basis:
            basis, under, gimp = self.basis.partition("_")
            transfer, _, number = self.word.partition(":")
            options = options | cleared
            if options.get("method_preset") == "solid":  # it has no update and no transfer
                options["method_preset"] = None
            options |= {"method_basis": basis, "method_update": self.update, "method_transfer": transfer}
            if not basis.startswith("bspline"):
                options["method_wall_basis"] = None
            if basis == "gimp":
                options["method_gimp_update"] = gimp or "none"
            if number:
                options["method_order" if transfer in methods.ORDERS else "method_flip"] = number
        if self.preset:
            chosen = {f"method_{name}": None for name in ("basis", "update", "transfer", "wall_basis")}
            particles = {f"body_{name}_ppc": None for name in names}
            options = options | cleared | chosen | particles | {"dt_cfl": None, "method_preset": self.preset}
        if self.ppc:
            options = options | {f"body_{name}_ppc": [self.ppc] * facts.dim for name in names}
        return options | ({"dt_cfl": self.cfl} if self.cfl else {})


class Trade:
    def __init__(self, study):
        self.study, self.words, self.facts = study, study.words, study.facts
        words, cells = study.words, study.facts.cells
        if any(n % (1 << words.coarser) for n in cells):
            axis, n = next((axis, n) for axis, n in zip("xyz", cells) if n % (1 << words.coarser))
            raise Refused(
                f"--coarser {words.coarser}: the {n} cells on axis {axis} are no multiple of {1 << words.coarser}"
            )
        legal = {
            "basis": methods.bases(),
            "update": methods.names("method_update"),
            "preset": [*methods.names("method_preset"), "none"],
        }
        alone = words.preset and words.preset != "none" and not (words.basis or words.update or words.transfer or words.ppc)
        default = WITH_PRESETS if alone else DEFAULTS
        self.lists = {
            name: methods.read_list(
                name,
                getattr(words, name) or default.get(name) or ",".join(word for word in legal[name] if word != "none"),
                legal[name],
            )
            for name in legal
        }
        self.lists["transfer"] = methods.read_transfers(words.transfer or default["transfer"])
        self.lists["ppc"] = methods.read_list("ppc", words.ppc, None, 64) if words.ppc else ["0"]
        self.lists["cfl"] = methods.read_list("cfl", words.cfl, None, 2) if words.cfl else ["0"]
        if any(not word.isdigit() for word in self.lists["ppc"]):
            raise Refused(f"--ppc {words.ppc}: the numbers must be whole")
        if words.cfl and study.facts.fixed:
            raise Refused("--cfl does not apply: -dt_size is fixed")
        self.quantity = study.quantity
        self.needed = self.quantity.value is None if self.quantity.on else not study.known  # are references?
        self.path, self.rows, self.floor, self.reference = study.path("_workprecision.csv"), [], 0.0, None
        self.jobs = max(1, (os.cpu_count() or 1) // study.processes)

    def options_of(self, setting, level):
        return setting.apply(scene.refined(self.study.options, self.facts, level - self.words.coarser), self.facts)

    # ---- Settings

    def combine(self):
        """Every combination of the lists, then the presets."""
        for basis in self.lists["basis"]:
            for update in self.lists["update"]:
                for transfer in self.lists["transfer"]:
                    for ppc in self.lists["ppc"]:
                        for cfl in self.lists["cfl"]:
                            name = (
                                f"{basis} {update} {transfer}"
                                + (f", {ppc} ppc" if ppc != "0" else "")
                                + (f", cfl {cfl}" if cfl != "0" else "")
                            )
                            yield Setting(name, basis, update, transfer, int(ppc), float(cfl))
        for preset in self.lists["preset"]:
            for cfl in self.lists["cfl"] if preset != "none" else []:
                yield Setting(f"preset {preset}" + (f", cfl {cfl}" if cfl != "0" else ""), preset=preset, cfl=float(cfl))

    def choose(self):
        """The settings, without those that the program refuses or warns of, for each of which a line is said."""
        own, some = Setting("the scene's own setting"), list(self.combine())
        with concurrent.futures.ThreadPoolExecutor(self.jobs) as pool:
            facts = list(
                pool.map(lambda setting: scene.Facts(self.options_of(setting, 0), self.study.processes), [own, *some])
            )
        mine = facts[0]
        if mine.refused:
            raise Refused(f"--coarser: the coarsest run: {mine.refused}")
        chosen = []
        for setting, its in zip(some, facts[1:]):
            setting.own = not its.refused and its.method == mine.method
            if its.refused or its.wrong and not setting.own:
                self.study.say(f"skipped    {setting.name}: {its.refused or its.wrong}")
            elif not (setting.own and any(other.own for other in chosen)):  # flip and flip:1
                setting.predicted = its.predicted
                chosen.append(setting)
        if mine.wrong:
            self.study.say(f"warning    the scene's own setting: {mine.wrong}")
        if not any(setting.own for setting in chosen):
            own.own, own.predicted = True, mine.predicted
            chosen.append(own)
        self.settings = chosen

    def candidates(self):
        """Who may make the references: of the bases of the list, the last first, the setting that is the first in all
        other lists."""
        found = []
        for basis in reversed(self.lists["basis"]):
            found += [
                setting
                for setting in self.settings
                if setting.basis == basis
                and setting.update == self.lists["update"][0]
                and setting.word == self.lists["transfer"][0]
            ][:1]
        return found

    # ---- The table

    def make_rows(self):
        """The rows of the study, with what the file has of them; returns how many runs are there."""
        against = [self.quantity.text, self.quantity.value, self.words.levels if self.needed else None]
        self.refer = self.candidates()[:2] if self.needed else []
        if self.needed and len(self.refer) < 2:
            raise Refused(
                "--basis: without a known solution two bases are needed that this scene takes, one for the reference "
                "and one to confirm it"
            )
        against += [setting.name for setting in self.refer]
        wanted = [("run", setting, level) for setting in self.settings for level in range(self.words.levels)]
        wanted += [(word, setting, self.words.levels) for word, setting in zip(("reference", "confirm"), self.refer)]
        file = read(self.path)
        for word, setting, level in wanted:
            key = scene.digits(
                self.options_of(setting, level),
                self.study.processes,
                *(against if word == "run" else [word, self.quantity.text]),
            )
            empty = dict.fromkeys(FORMS, math.nan) | dict.fromkeys(TEXTS, "") | {"repeats": 0, "front": 0}
            row = file.pop(key, None) or empty
            row |= {"study": word, "setting": setting, "level": level, "key": key}
            row["done"] = self.enough(row)
            self.rows.append(row)
        known = sum(row["done"] and row["study"] == "run" for row in self.rows)
        self.others = [row | {"study": "other", "front": 0} for row in file.values()]
        return known

    def write(self):
        with open(self.path + ".new", "w", newline="", encoding="utf-8") as file:
            out = csv.writer(file, lineterminator="\n")
            out.writerow(COLUMNS)
            for row in [*self.rows, *self.others]:
                if row["status"]:
                    out.writerow(
                        [row[name] if name in TEXTS else scene.text_of(row[name], FORMS[name]) for name in COLUMNS]
                    )
        os.replace(self.path + ".new", self.path)

    # ---- Runs

    def make(self, row, compare):
        """Makes one run of a row: sets its numbers but for the error. Returns the result and, if compare, its
        particles."""
        options = self.options_of(row["setting"], row["level"])
        kept = {"output_every": 1e300, "output_fields": "body", "output_format": "hdf5" if compare else "none"}
        if not compare:
            kept |= {"output_every": None, "output_fields": None}
        result = scene.run(options | kept, self.study.processes)
        stopped = result.status != 0
        if row["status"] != "ok":
            self.describe(row, options, result, stopped)
        if result.steps:
            n, s = row["repeats"], result.step_seconds
            row["seconds"] = (n * row["seconds"] + s) / (n + 1) if n else s
            row["seconds_min"] = min(row["seconds_min"], s) if n else s
            row["seconds_max"] = max(row["seconds_max"], s) if n else s
            row["ns"] = 1e9 * row["seconds_min"] / (row["particles"] * max(1, row["steps"]))
        row["repeats"] += 1
        row["done"] = self.enough(row)
        if not compare or stopped:
            return result, None
        return result, scene.samples(options, self.study.processes, result.snapshots[-1], self.its)

    def enough(self, row):
        """Whether a run was made as often as wanted, now or before."""
        often = self.words.repeats if row["study"] == "run" else 1
        return row["status"] not in ("", "ok") or row["repeats"] >= often

    def describe(self, row, options, result, stopped):
        """What a result says of its run, but for error and times."""
        facts = self.its = scene.Facts(options, self.study.processes, result)
        row |= {"status": "stopped" if stopped else "ok", "note": result.reason if stopped else ""}
        if not facts.refused:
            if row["setting"].axes is None:
                row["setting"].axes = scene.per_cell(options, facts, self.study.processes)
            _, crossing = methods.bounds(
                facts.basis, facts.update, facts.transfer, facts.flip, facts.rate, facts.strain, facts.viscosity
            )
            if not stopped and not facts.fixed and facts.cfl > crossing * (1 + 1e-9):
                row["note"] = f"steps too long where particles cross cells: stable up to {crossing:g} h/c"
            row |= {
                "basis": facts.basis,
                "gimp_update": ("stretch" if facts.stretched else "none") if facts.basis == "gimp" else "",
                "update": facts.update,
                "transfer": facts.transfer,
                "flip": facts.flip,
                "strain": facts.strain,
                "rate": facts.rate,
                "order": facts.order,
                "ppc": row["setting"].axes[0][0],
                "cells": "x".join(map(str, facts.cells)),
                "cfl": math.nan if facts.fixed else facts.cfl,
                "h": facts.h[0],
                "particles": facts.particles,
                "steps": result.steps,
                "memory": facts.memory / 2**20,
            }
        row["note"] = row["note"].translate(str.maketrans(',"\n', ";;;"))

    def error_of(self, result, samples):
        """As a part of the solution's size; NaN if there is none."""
        if self.quantity.on:
            to = self.reference if self.needed else self.quantity.value
            return abs(self.quantity.of(result) - to) / abs(to) if to else math.nan
        error, size = result.error, result.size
        if self.needed:
            error, size = series.compare(samples, self.reference, np.array(self.facts.length))
        return error / size if size > 0 else math.nan

    def print_row(self, number, row):
        end = "" if math.isnan(row["error"]) else f"error {100 * row['error']:.3g} %"
        if row["status"] != "ok":
            end = f"{row['status']}: {row['note']}"
        self.study.say(
            f"{number:<10} {row['setting'].name:<34} {row['cells']:<13} {row['steps']:8.0f} steps  "
            f"{row['seconds']:9.4g} s  {end}"
        )

    def make_references(self):
        """The reference and the second one that confirms it, and their difference; whether there are both. A candidate
        whose run stops leaves its place to the next."""
        rows, names = [row for row in self.rows if row["study"] != "run"], []
        for setting in self.candidates():
            row = rows[len(names)]
            row |= {"setting": setting, "status": "", "repeats": 0}
            result, samples = self.make(row, not self.quantity.on)
            if names and row["status"] == "ok":
                row["error"] = self.floor = self.error_of(result, samples)
            elif row["status"] == "ok":
                self.reference = self.quantity.of(result) if self.quantity.on else samples
            self.print_row("second" if names else "reference", row)
            if row["status"] != "ok":
                row["status"] = ""
                continue
            names.append(setting.name)
            if len(names) == 2:
                self.study.say(
                    f"           {names[0]} and {names[1]} differ by {100 * self.floor:.2g} %: nothing is said of "
                    "errors below"
                )
                return not math.isnan(self.floor)
        return False

    def make_runs(self):
        """The runs that are left, in turns: all of them once, then all of them again."""
        runs = [row for row in self.rows if row["study"] == "run"]
        left, made = sum(not row["done"] for row in runs), 0
        for turn in range(self.words.repeats):
            for row in runs:
                if row["done"] or row["repeats"] > turn:
                    continue
                anew = not row["status"]
                result, samples = self.make(row, anew and self.needed and not self.quantity.on)
                if anew:
                    made += 1
                    row["error"] = self.error_of(result, samples) if row["status"] == "ok" else math.nan
                    self.print_row(f"{made}/{left}", row)
                self.write()

    # ---- The study

    def dry_run(self):
        """The runs that would be made, with the time that the model gives them: 2^(dim + 1) times as long on each next
        grid."""
        more, everything = 2 ** (self.facts.dim + 1), 0.0
        for setting in self.settings:
            left = [row for row in self.rows if row["setting"] is setting and row["study"] == "run" and not row["done"]]
            here = sum(setting.predicted * more ** row["level"] * (self.words.repeats - row["repeats"]) for row in left)
            everything += here + (setting.predicted * more**self.words.levels if setting in self.refer else 0)
            self.study.say(
                f"runs       {setting.name:<34} {len(left)} of {self.words.levels} grids, about {time_words(here)}"
            )
        self.study.say(
            f"dry run    the study is valid; by the model about {time_words(everything)} of "
            f"steps{', with its references' if self.needed else ''}; no step was made"
        )

    def run(self):
        study = self.study
        self.choose()
        known = self.make_rows()
        study.say(
            f"study      trade of {self.facts.title}: {len(self.settings)} settings on {self.words.levels} grids, "
            f"{self.quantity.text or 'displacements'} against "
            f"{'a finer run' if self.needed else 'what is known'}"
        )
        if known:
            study.say(
                f"note       {known} runs are in {self.path} with the same options and version: they are not made again"
            )
        if study.dry:
            self.dry_run()
            return 0
        anew = any(row["study"] == "run" and not row["status"] for row in self.rows)
        self.floor = next((row["error"] for row in self.rows if row["study"] == "confirm"), 0.0)
        if self.needed and (anew or math.isnan(self.floor)) and not self.make_references():
            study.complain("no reference: fewer than two of the methods in --basis came to the end")
            return 3
        self.make_runs()
        self.report()
        self.write()
        study.end(self.path, "" if any(front.counts(row) for row in self.rows) else "no run has an error")
        return 0

    def report(self):
        """The front and the cheapest settings."""
        runs, say = [row for row in self.rows if row["study"] == "run"], self.study.say
        front.mark(runs, self.floor)
        say("front      runs that no other beats in both time and error")
        say(
            "           method                             ppc   cfl  cells            seconds   error (%)       MiB "
            " ns/particle/step"
        )
        best = sorted((row for row in runs if row["front"]), key=lambda row: row["seconds_min"])
        for row in best:
            less = "< " if row["error"] < self.floor else "  "
            say(
                f"           {method_of(row):<34} {row['ppc']:3.0f}  {row['cfl']:4.2g}  {row['cells']:<13} "
                f"{row['seconds_min']:10.4g}  {less}{100 * max(row['error'], self.floor):9.3g}"
                f"  {row['memory']:8.3g}  {row['ns']:8.1f}"
            )
        if not best:
            say("           none: no run has an error")
        if any(row["seconds_min"] < 0.01 for row in best):
            say("note       some of these runs took less than 0.01 s: their times say little")
        for error in (0.1, 0.01, 0.001):
            self.print_cheapest(runs, error)

    def print_cheapest(self, runs, error):
        say, cheap, head = (
            self.study.say,
            front.cheapest(runs, error),
            f"{'for ' + format(100 * error, 'g') + ' %':<10} ",
        )
        if error < self.floor:
            say(f"{head}nothing is said: the two references differ by {100 * self.floor:.2g} %")
            return
        if cheap is None:
            say(f"{head}no run reached it; more --levels may")
            return
        say(
            f"{head}{self.repeat(cheap)}\n           error {100 * cheap['error']:.2g} %, {cheap['steps']:.0f} steps, "
            f"{cheap['seconds_min']:.3g} s, {cheap['memory']:.3g} MiB"
        )
        best = front.fastest([[row for row in runs if row["setting"] is setting] for setting in self.settings], error)
        own = [row for row in runs if row["setting"].own]
        if best is None:
            return
        lost, some = front.loss(own, best, error), [row for row in own if front.counts(row)]
        if lost and lost[0] <= 1:
            say("           the scene's own method is no slower for this error")
        elif lost:
            say(
                f"           the scene's own method takes {lost[0]:.2f} ({lost[1]:.2f} to {lost[2]:.2f}) times as "
                "long for this error"
            )
        elif some:
            least = min(some, key=lambda row: row["error"])
            say(
                f"           the scene's own method does not reach it: at best {100 * least['error']:.2g} %, with "
                f"{least['cells']} cells"
            )
        else:
            say("           the scene's own method has no error: it stopped")

    def repeat(self, row):
        """The options by which a user repeats a run."""
        setting, words = (
            row["setting"],
            {
                "method_basis": row["basis"],
                "method_gimp_update": row["gimp_update"] or None,
                "method_update": row["update"],
                "method_transfer": row["transfer"],
            },
        )
        there = {
            name: value for name, value in row.items() if name in FORMS and value is not None and not math.isnan(value)
        }
        words["method_affine_strain"] = f"{there['strain']:g}" if "strain" in there else None
        if "flip" in there and not self.facts.viscosity:
            words |= (
                {"method_damping_rate": f"{there['rate']:g}"}
                if there.get("rate", 0) > 0
                else {"method_flip": f"{there['flip']:g}"}
            )
        words["method_order"] = f"{there['order']:.0f}" if "order" in there else None
        if row["update"] == "leapfrog":  # of the total frame
            words = {"method_preset": "solid", "method_basis": row["basis"], "method_mass_order": words["method_order"]}
        cells = [int(n) for n in row["cells"].split("x")]
        if "grid_h" in self.study.options:
            words["grid_h"] = ",".join(
                f"{h * n / its:.17g}" for h, n, its in zip(self.facts.h, self.facts.cells, cells)
            )
        else:
            words["grid_cells"] = tuple(cells)
        for name in scene.bodies(self.study.options) if setting.ppc or setting.preset else ():
            words[f"body_{name}_ppc"] = [int(row["ppc"])] * self.facts.dim
        words |= (
            {"dt_cfl": f"{row['cfl']:.10g}"}
            if "cfl" in there
            else {"dt_size": f"{self.facts.fixed / 2 ** (row['level'] - self.words.coarser):.10g}"}
        )
        return " ".join(pebble.words(words))


def method_of(row):
    there = {
        name: value for name, value in row.items() if name in FORMS and value is not None and not math.isnan(value)
    }
    words = [row["basis"] + (" stretch" if row["gimp_update"] == "stretch" else ""), row["update"], row["transfer"]]
    words += [f"{there['order']:.0f}"] if "order" in there else []
    words += [f"strain {there['strain']:g}"] if "strain" in there else []
    words += (
        [f"rate {there['rate']:g}"] if "rate" in there else [f"{there['flip']:g}"] if there.get("flip", 1) < 1 else []
    )
    return " ".join(words)


def time_words(seconds):
    for unit, size in (("days", 86400), ("hours", 3600), ("minutes", 60)):
        if seconds >= 2 * size:
            return f"{seconds / size:.2g} {unit}"
    return f"{seconds:.3g} seconds"


def read(path):
    """{key: row} of the table that there is."""
    if not os.path.exists(path):
        return {}
    with open(path, newline="", encoding="utf-8") as file:
        lines = list(csv.reader(file))
    rows = {}
    for number, line in enumerate(lines, 1):
        try:
            if (line != COLUMNS) if number == 1 else (len(line) != len(COLUMNS)):
                raise ValueError
            row = dict(zip(COLUMNS, line))
            if number > 1:
                rows[row["key"]] = {
                    name: text if name in TEXTS else float(text) if text else math.nan for name, text in row.items()
                }
        except ValueError:
            raise Refused(f"line {number} of {path} is not of a work-precision study; move the file away") from None
    return rows
