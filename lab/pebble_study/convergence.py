"""The convergence study: runs of one scene, each finer than the one before by a factor of two; their errors, the
differences of successive runs, observed orders of convergence, and where the runs lead. Errors are against the scene's
known solution, a known value, or the finest run."""

import csv
import math
import os

import numpy as np
import pebble_mpm as pebble

from . import scene, series
from .scene import Refused

COLUMNS = ["run", "", "particles", "steps", "error", "order", "seconds", "relative", "difference", "quantity", "key"]


class Convergence:
    def __init__(self, study):
        self.study, self.options, self.facts, self.vary = study, study.options, study.facts, study.words.vary
        self.quantity, self.levels = study.quantity, study.words.levels
        self.known = self.quantity.value is not None if self.quantity.on else study.known
        if self.vary == "ppc" and not self.known and not self.quantity.on:
            raise Refused("--vary ppc does not apply: comparison with the finest run takes other grids or time steps")
        if study.words.order_min is not None and not self.known and self.levels < 3:
            raise Refused(
                f"--levels {self.levels} leaves no order for --order-min where the solution is not known: a pair of "
                "differences needs 3 runs"
            )
        self.what = {"grid": "h", "ppc": "1/ppc", "dt": "dt" if self.facts.fixed else "cfl"}[self.vary]
        self.rows, self.samples = [], []
        self.path = study.path("_study.csv")

    def options_of(self, level):
        options, facts = self.options, self.facts
        if self.vary == "grid":
            options = scene.refined(options, facts, level)
        elif self.vary == "ppc":
            ppc = scene.per_cell(options, facts, self.study.processes)
            options = options | {
                f"body_{name}_ppc": tuple(n << level for n in its) for name, its in zip(scene.bodies(options), ppc)
            }
        else:
            options = options | (
                {"dt_size": facts.fixed / 2**level} if facts.fixed else {"dt_cfl": facts.cfl / 2**level}
            )
        if not self.quantity.on and options.get("output_format") == "none":  # its last snapshot is compared
            options = options | {"output_format": "hdf5", "output_every": 1e300, "output_fields": "body"}
        return options | {"output_name": f"{self.study.name}-{level + 1}"}

    def check_runs(self):
        """Asks the program what it says of each run before the first is made."""
        self.each = []
        for level in range(self.levels):
            facts = scene.Facts(self.options_of(level), self.study.processes)
            if facts.refused:
                raise Refused(f"run {level + 1} of the study: {facts.refused}")
            self.each.append(facts)
            if self.study.dry:
                self.study.say(
                    f"run {level + 1:2}     {'x'.join(map(str, facts.cells))} cells, {facts.particles} particles"
                )

    def make(self, level, before):
        """Makes run `level`, or takes it from the table and the files that an earlier study left."""
        options, facts = self.options_of(level), self.each[level]
        key = scene.digits(options, self.study.processes)
        base = os.path.join(self.study.folder, options["output_name"])
        row = before.get(key)
        again = row and all(os.path.exists(base + end) for end in (".csv", *([] if self.quantity.on else [".h5"])))
        if again:
            result = pebble.load(base)
            row = {name: float(text) if text else math.nan for name, text in row.items() if name != "key"}
        else:
            result = scene.run(options, self.study.processes, self.study.folder, options["output_name"])
            if result.status:
                raise pebble.Error(result.line, result)
            self.study.warn(result)
            row = {
                "particles": facts.particles,
                "steps": result.steps,
                "seconds": result.seconds,
                "error": result.error,
            }
            row["relative"] = result.error / result.size if result.size > 0 else math.nan
        row |= {
            "run": level + 1,
            self.what: {"h": facts.h[0], "dt": facts.fixed, "cfl": facts.cfl}.get(self.what),
            "order": math.nan,
        }
        if self.vary == "ppc":
            row["1/ppc"] = 1 / scene.per_cell(options, facts, self.study.processes)[0][0]
        row["quantity"], row["key"] = self.quantity.of(result) if self.quantity.on else math.nan, key
        if not self.quantity.on:
            self.samples.append(scene.samples(options, self.study.processes, result.snapshots[-1], facts))
        self.rows.append(row)
        self.study.say(
            f"{'known' if again else 'run':<10} {level + 1} of {self.levels}: {'x'.join(map(str, facts.cells))} "
            f"cells, {facts.particles} particles, "
            f"{row['steps']:.0f} steps, {row['seconds']:.3g} s"
        )

    def compare(self):
        """Sets errors, differences and orders of the runs that there are."""
        rows, last = self.rows, len(self.rows) - 1
        for k, row in enumerate(rows):
            row["difference"] = math.nan
            if self.quantity.on:
                to = self.quantity.value if self.known else rows[last]["quantity"]
                row["error"] = abs(row["quantity"] - to)
                row["relative"] = row["error"] / abs(to) if to else math.nan
                if k < last:
                    row["difference"] = rows[k + 1]["quantity"] - row["quantity"]
                continue
            if not self.known and k < last:
                error, size = series.compare(self.samples[k], self.samples[last], np.array(self.facts.length))
                row["error"], row["relative"] = error, error / size if size > 0 else math.nan
            if k < last:
                row["difference"] = series.compare(self.samples[k], self.samples[k + 1], np.array(self.facts.length))[0]
        if not self.known:  # the finest run has no error of its own
            rows[last]["error"] = rows[last]["relative"] = math.nan
        self.pairs = series.orders(
            [row["error"] for row in rows] if self.known else [row["difference"] for row in rows[:last]]
        )
        for k, row in enumerate(rows):
            row["order"] = self.pairs[k] if series.agree(self.pairs[: k + 1]) and k < len(self.pairs) else math.nan

    def write(self):
        columns = [self.what if name == "" else name for name in COLUMNS if name != "quantity" or self.quantity.on]
        whole = {"run": "d", "particles": "d", "steps": "d", "seconds": ".4g", "order": ".6g"}
        with open(self.path + ".new", "w", newline="", encoding="utf-8") as file:
            out = csv.writer(file, lineterminator="\n")
            out.writerow(columns)
            for row in self.rows:
                out.writerow([scene.text_of(row.get(name, math.nan), whole.get(name, "r")) for name in columns])
        os.replace(self.path + ".new", self.path)

    # ---- What it prints

    def print_table(self):
        say, on = self.study.say, self.quantity.on
        say(
            f" run  {self.what:>10}   particles     steps  "
            + (f"{'quantity':>12}  " if on else "")
            + f"{'error (' + self.quantity.unit + ')':>12}    relative  to next run    order   seconds"
        )
        for row in self.rows if self.known else self.rows[:-1]:
            say(
                f"{row['run']:4.0f}  {row[self.what]:10.4g}  {row['particles']:10.0f}  {row['steps']:8.0f}  "
                + (f"{row['quantity']:12.6g}  " if on else "")
                + "  ".join(
                    scene.text_of(row[name], form, "-").rjust(width)
                    for name, form, width in (
                        ("error", ".5g", 12),
                        ("relative", ".3g", 10),
                        ("difference", ".5g", 12),
                        ("order", ".3f", 7),
                        ("seconds", ".3g", 8),
                    )
                )
            )

    def print_limit(self):
        say, pairs, n, unit = self.study.say, self.pairs, len(self.rows), self.quantity.unit
        kind = "errors" if self.known else "differences"
        if series.agree(pairs):
            say(
                f"order      {pairs[-1]:.3f}: the last {3 if self.known else 4} runs agree on it within "
                f"{series.BAND:g} (the pair before: {pairs[-2]:.3f})"
            )
        elif len(pairs) > 2 and None not in pairs[-2:]:
            why = f"which differ by more than {series.BAND:g}" if min(pairs[-2:]) > 0 else "of which one does not fall"
            say(f"order      -: the last two pairs of {kind} give {pairs[-2]:.3f} and {pairs[-1]:.3f}, {why}")
        else:
            say(f"order      -: it takes two pairs of {kind} that are not 0")
        differences = [row["difference"] for row in self.rows[:-1]]
        rest = series.rest(differences)
        if not rest:
            say(
                "limit      none: the differences of the runs do not fall"
                if n > 2
                else "limit      unknown: it takes three runs"
            )
        elif self.quantity.on:
            limit, end = self.rows[-1]["quantity"] + rest[0], f" {unit}" if unit else ""
            say(f"limit      {self.quantity.text} goes to {limit:.6g} +- {rest[1]:.2g}{end} (Richardson)")
        else:
            say(f"limit      the last run is {rest[0]:.3g} +- {rest[1]:.2g} m from where the runs lead (Richardson)")
        if not self.known:
            lack = f"about {abs(rest[0]):.3g} {unit}" if rest else "which is not known"
            say(
                f"bias       errors are against the finest run: they lack its own error, {lack}, so they fall too "
                "fast; orders are those of the differences"
            )

    def print_verdict(self):
        errors, differences = [row["error"] for row in self.rows], [row["difference"] for row in self.rows[:-1]]
        say, n, unit = self.study.say, len(self.rows), self.quantity.unit
        known = "value" if self.quantity.on else "solution"
        if self.known and errors[-1] > errors[-2]:
            say(
                f"note       the error grew from run {n - 1} to run {n}: most of it does not come from {self.what}, "
                "or the method does not converge here"
            )
        if self.known and n > 2 and series.falls(errors) and errors[-2] > errors[-3]:
            say(
                f"verdict    -: the errors do not fall steadily, {errors[-3]:.3g}, {errors[-2]:.3g}, {errors[-1]:.3g} "
                f"{unit}: make one run more"
            )
        elif self.known and series.falls(errors):
            say(f"verdict    converges to the known {known}, as far as these runs tell")
        elif self.known and series.falls(differences):
            say(
                f"verdict    does not converge to the known {known}: the runs lead to another, and an error of about "
                f"{errors[-1]:.3g} {unit} does not come from {self.what}"
            )
        elif n < 3:
            say("verdict    -: it takes three runs")
        elif series.falls(differences):
            say("verdict    converges, as far as these runs tell")
        else:
            say(
                f"verdict    does not converge: the last differences of runs, {abs(differences[-2]):.3g} and "
                f"{abs(differences[-1]):.3g} {unit}, do not fall"
            )

    def check_order(self):
        least, pair = self.study.words.order_min, self.pairs[-1]
        if least is None or pair is not None and pair >= least:
            return 0
        kind = "errors" if self.known else "differences"
        self.study.complain(
            f"the order of the last pair of {kind}, {pair:.3f}, is below --order-min {least:g}"
            if pair is not None
            else f"no order for --order-min {least:g}: {'an error' if self.known else 'a difference'} is 0"
        )
        return 3

    def run(self):
        study, against = (
            self.study,
            "the finest run" if not self.known else "its known value" if self.quantity.on else "the known solution",
        )
        study.say(
            f"study      convergence of {self.facts.title}: {self.levels} runs, refining {self.vary}, "
            f"{self.quantity.text or 'displacements'} against {against}"
        )
        self.check_runs()
        if study.dry:
            study.say("dry run    the study is valid; no step was made")
            return 0
        before, status = scene.read_table(self.path, ["run", self.what, "particles"]), 0
        for level in range(self.levels):
            try:
                self.make(level, before)
            except pebble.Error as stopped:
                study.complain(str(stopped))
                status = 3
                break
            self.write()
        if not self.rows or status and not self.known:
            return status
        self.compare()
        self.print_table()
        self.write()
        if len(self.rows) > 1:
            self.print_limit()
            self.print_verdict()
        errors = [row["error"] for row in (self.rows if self.known else self.rows[:-1])]
        study.end(self.path, "" if all(0 < error < math.inf for error in errors) else "an error is 0 or not finite")
        return status or self.check_order()
