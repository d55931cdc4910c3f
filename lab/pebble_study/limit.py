"""The limit-load study: static runs raise the load or gravity of a scene, or divide its strength, until no equilibrium is
found or the body flows: for an equal part of the load it yields many times as much as in the first step, or goes far for
its size. So on several grids, each twice as fine as the one before. The limit lies between the largest factor that holds
and the smallest that does not, its bracket. (Beyond the limit a body can come to rest again in another shape, as a slope
does that has slid; so that an equilibrium is found does not tell that the limit was not passed. Nor does the first step
suffice: soft ground settles so much in it that a slope rests again before it has slid many times as far.)"""

import csv
import math
import os
import re
import time

import numpy as np
import pebble_mpm as pebble

from . import scene, series
from .scene import Refused

COLUMNS = "grid,h,cells,particles,holds,fails,ends,factor,softer,runs,seconds,key".split(",")
TEXTS = ("cells", "ends", "key")
FAILED = r"no equilibrium was found (?:near the last one, at t=\S+ s: that )?at t=(\S+) s"
SOLVER = r" out of balance(?:, most at \([^)]*\))?, of \S+ N \(([^()]+)\)"  # Newton's method ended without a solution; PETSc's reason
REMEDIES = ({"snes_max_it": "80", "snes_linesearch_type": "bt"}, {"snes_max_it": "80", "snes_linesearch_type": "l2"})
STEPS = 10  # of a load, where the scene does not say
LEAST, MOST = 1 / 64, 64.0  # divisors of the strength that are tried
GROWTH, TRIES = 1.5, 12  # of gravity from run to run, until it is too much; runs at most
SAFETY = 3.0  # the error of the finer of two grids, over what changed from the coarser one: Roache's index of convergence at the first order
EARLY = 0.02  # a body that yields so much more than at first, or for which no equilibrium is found, may bear as much more than that
SOFT = 0.12  # the same of a body that slides: a footing on clay of E/c = 100
HARDLY = 2.0  # a body that has softened less before Newton's method failed may be in equilibrium beyond it: that is a failure of the solver
FEW, FAR = 8.0, 0.1  # or it yields so many times as much as at first, and goes so far, over its size, for as much load as it bears already: it slides
SUDDEN, LEAP = 3.0, 0.02  # or it goes so many times as far as before, and so far over its size, in the first step of a later stage, in which all may happen at once
NOTHING = 1e-6  # the factor below which no scene is meant: nothing holds the body
STRENGTH = {  # what is divided, and what else changes: (law, {option: function of (value, F)})
    "vonmises": {"yield": lambda value, F: value / F, "hardening": lambda value, F: value / F},
    "druckerprager": {
        "cohesion": lambda value, F: value / F,
        "friction_angle": lambda value, F: math.degrees(math.atan(math.tan(math.radians(value)) / F)),
    },
}
# Options of motion in time, which stand aside where the scene has no -method_time static of its own.
MOTION = ("method_", "damping_", "dt_", "check_", "history_energy", "history_rest", "time_rest", "output_")


class NoLimit(Exception):
    """No factor without an equilibrium was found, or none with one."""


def bracket(holds, start, growth, tolerance, least=LEAST, most=MOST):
    """(low, high): low holds, high does not, and their difference is at most `tolerance` of their mean. From `start` on
    the factor grows, or falls, by powers of `growth`, then the interval is halved. NoLimit where no such pair is
    in [least, most]."""
    low = high = None
    factor, grows = start, growth
    while low is None or high is None:
        if not least <= factor <= most:
            raise NoLimit(
                f"the strength divided by {low:g} still holds"
                if high is None
                else f"the strength divided by {high:g} does not hold"
            )
        if holds(factor):
            low = factor
        else:
            high = factor
        factor, grows = (low * grows if high is None else high / grows), grows * growth
    while high - low > tolerance * 0.5 * (low + high):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if holds(middle) else (low, middle)
    return low, high


def estimate(brackets, early=EARLY):
    """(lowest, highest, why) of the limit on grids that are ever finer, from the brackets [(low, high)] of grids that are
    each twice as fine as the one before. The error on the finest grid counts on both sides: limits need not fall, or rise,
    with every grid. A change is not known to be smaller than what the brackets leave open. early: the part by which what counts as failed may bear more."""
    low, high = brackets[-1]
    if len(brackets) < 2:
        return low, high * (1 + early), "one grid: what smaller cells would change is not known (--levels)"
    middles, halves = [0.5 * sum(pair) for pair in brackets], [0.5 * (b - a) for a, b in brackets]
    changes = [b - a for a, b in zip(middles, middles[1:])]
    least = halves[-1] + halves[-2]
    rest = series.rest(changes)
    if len(brackets) == 2:
        error, why = SAFETY * max(abs(changes[-1]), least), f"{SAFETY:g} times what changed from the grid before, on both sides; a third grid says more"
    elif rest:
        error, why = max(abs(rest[0]) + rest[1], abs(changes[-1]), least), "what finer grids will change by the last three (Richardson), on both sides"
    else:
        error, why = SAFETY * max(map(abs, [*changes[-2:], least])), f"{SAFETY:g} times the larger of the last two changes, which do not fall, on both sides"
    return low - error, (high + error) * (1 + early), why


def plain(name, options):
    """The option that a name sets, without `stage_<s>_` where it does so in a stage."""
    for stage in options.get("stages", "").split(","):
        if stage and name.startswith(f"stage_{stage}_"):
            return name[len(f"stage_{stage}_") :]
    return name


def ends(options):
    """The times at which the stages of a scene end, at the latest; without stages that of its end."""
    stages = [stage for stage in options.get("stages", "").split(",") if stage]
    if not stages:
        return [float(options["time_end"])]
    return np.cumsum([float(options[f"stage_{stage}_time"]) for stage in stages]).tolist()


def paired(before, after):
    """The places [n, 3] in two snapshots of the particles that both have: a stage may remove some."""
    _, first, second = np.intersect1d(*(snapshot.particles["id"].ravel() for snapshot in (before, after)), return_indices=True)
    return before.particles["x"][first], after.particles["x"][second]


def moved(before, after):
    """The mean of how far the hundredth of the particles went that went farthest, m. [n, 3] each."""
    far = np.sort(np.sqrt(((after - before) ** 2).sum(1)))
    return far[-max(1, len(far) // 100) :].mean()


def softness(times, steps, parts=()):
    """How many times as much as in the first step the body yields in each step, for an equal part of the load, which grows
    with time. times: of the ends of the steps, s; steps: how far they moved it; parts: when the stages end, each of which has
    a first step of its own, which counts if it moved the body more than the very first."""
    times, rates = np.asarray(times, float), np.asarray(steps, float)
    rates = rates / np.diff(times, prepend=0)
    if not len(rates) or not rates[0] > 0:
        return np.full(len(rates), math.nan)
    stage = np.searchsorted(np.asarray(parts, float) * (1 + 1e-9), times, "left")
    first = [rates[np.flatnonzero(stage == k)[0]] for k in stage]
    return rates / np.maximum(first, rates[0])


def slides(times, steps, soft, size, parts=()):
    """Whether the body slides in each step: it goes far, over its size, for as much load as there is since its stage began, and yields
    several times as much as at first; or it does so suddenly as a later stage begins. Arguments as above; soft: the softness; size: of
    the body, m."""
    times, steps = np.asarray(times, float), np.asarray(steps, float)
    stage = np.searchsorted(np.asarray(parts, float) * (1 + 1e-9), times, "left")
    begins = np.array([0.0, *parts])[stage] if len(parts) else np.zeros(len(times))
    far = steps / np.diff(times, prepend=0) * (times - begins) > FAR * size
    sudden = (np.diff(stage, prepend=stage[:1]) > 0) & (steps > LEAP * size) & (steps > SUDDEN * (np.cumsum(steps) - steps))
    return far & (np.asarray(soft) > FEW) | sudden


def read_end(times, soft, failed, softer, slid=()):
    """(last time that holds, first that does not or None, how soft it was in the last step that holds) of a run with
    steps to these times, the softness in them, the time at which no equilibrium was found, or None, and where it slides."""
    flows = next((k for k, value in enumerate(soft) if value > softer or (len(slid) and slid[k])), None)
    if flows is not None:
        return (times[flows - 1] if flows else 0.0), times[flows], (soft[flows - 1] if flows else math.nan)
    return (times[-1] if len(times) else 0.0), failed, (soft[-1] if len(soft) else math.nan)


def how(flows, line, softer):
    """How a run ends that does not hold, but for slides: it flows, it has no equilibrium, or the solver may have failed, by its last line: Newton's method found
    nothing though the body had hardly softened before."""
    if flows:
        return "flow"
    return "solver" if re.search(SOLVER, line) and not softer >= HARDLY else "no equilibrium"


def static(words, processes):
    """Options of a scene, made static: if it is not, what belongs to motion in time stands aside, but for what is on the
    command line. Returns them and the names of what stands aside."""
    typed = dict(zip(words, words[1:])).get("-method_time", "static")
    if typed != "static":
        raise Refused(f"-method_time {typed} does not apply: a limit is looked for with -method_time static")
    try:
        options = scene.database(words, processes)
    except Refused:  # words of statics alone, as -snes_max_it
        options = scene.database([*words, "-method_time", "static"], processes)
        options = scene.Options({k: v for k, v in options.items() if k != "method_time"}, options.typed - {"method_time"})
    if options.get("method_time") == "static":
        return options, []
    aside = [name for name in options if plain(name, options).startswith(MOTION) and name not in options.typed]
    told = [name for name in aside if not plain(name, options).startswith("output_")]
    kept = dict.fromkeys(name for name in aside if name not in ("output_dir", "output_name"))
    return options | kept | {"method_time": "static"}, told


def materials(options):
    """{name: law} of the materials."""
    return {name: options.get(f"material_{name}_model", "") for name in options["materials"].split(",")}


def weakened(options, F):
    """The options with the strength of all materials divided by F; dilation is at most friction."""
    changed = {}
    stages = [f"stage_{stage}_" for stage in options.get("stages", "").split(",") if stage]
    for name, law in materials(options).items():
        friction, dilation = 0.0, 0.0  # degrees; a stage may change them
        for stage in ["", *stages]:
            for what, divide in STRENGTH.get(law, {}).items():
                option = f"{stage}material_{name}_{what}"
                if option in options:
                    changed[option] = f"{divide(float(options[option]), F):.15g}"
            friction = float(changed.get(f"{stage}material_{name}_friction_angle", friction))
            dilation = float(options.get(f"{stage}material_{name}_dilation_angle") or dilation)
            if law == "druckerprager" and dilation > friction:
                changed[f"{stage}material_{name}_dilation_angle"] = f"{friction:.15g}"
    return options | changed


class Limit:
    def __init__(self, study):
        words, options = study.words, study.options
        self.study, self.facts, self.levels, self.tolerance = study, study.facts, words.levels, words.tolerance
        self.mode = "strength" if words.reduce else words.raised or "load"
        self.parts = ends(options)
        self.end = self.parts[-1]
        self.loads = {name: None for name in options.get("loads", "").split(",") if name}  # in all at the end, N
        self.gravity = [g for g in scene.numbers(options.get("gravity", "0"), self.facts.dim)]
        self.check()
        self.dt = self.facts.fixed or min(np.diff(self.parts, prepend=0)) / STEPS
        quiet = {name: None for name in options if name.startswith("output_") and name not in ("output_dir", "output_name")}
        self.options = options | quiet | {"output_every": "0", "output_fields": "body", "output_format": "hdf5", "check_state": "retry"}
        self.start, self.soon, self.rows, self.path = 1.0, self.end, [], study.path("_limit.csv")

    # ---- What it takes

    def check(self):
        """Refuses scenes in which nothing can be raised or reduced."""
        words, options = self.study.words, self.study.options
        if words.reduce and words.raised:
            raise Refused("--reduce does not apply with --raise: choose one of them")
        if len(self.parts) > 1 and self.mode != "strength":
            raise Refused("--raise does not apply with -stages, whose loads do not grow in proportion to time: --reduce strength does")
        laws = materials(options)
        if self.mode == "strength" and not any(law in STRENGTH for law in laws.values()):
            raise Refused(f"--reduce strength does not apply: no material has the model {' or '.join(STRENGTH)}")
        pushed = any(self.gravity) or "acceleration" in options
        if not self.loads and not pushed:
            raise Refused("the study needs something that can become too much: give the scene -loads or -gravity")
        if self.mode == "gravity" and not any(self.gravity):
            raise Refused("--raise gravity does not apply: the scene has no -gravity")
        if self.mode == "gravity" and self.loads:
            raise Refused("--raise gravity does not apply to a scene with -loads: --raise load raises both")

    def notes(self):
        """Says what makes the result doubtful before the first run."""
        say, options, facts = self.study.say, self.study.options, self.facts
        if self.study.aside:
            say(f"note       of the scene these stand aside in statics: -{' -'.join(self.study.aside)}")
        if facts.basis in ("gimp", "linear"):
            say(f"note       {facts.basis} locks where volume is kept: the factor is too high, or there is none; leave out -method_basis")
        axisymmetric = options.get("geometry") == "axisymmetric"
        for name, law in materials(options).items():
            if law == "druckerprager" and facts.dim == 2 and not axisymmetric and options.get(f"material_{name}_fit") != "plane_strain":
                say(f"note       {name} is stronger in plane strain than its friction_angle says: give -material_{name}_fit plane_strain")
            if law == "vonmises" and float(options.get(f"material_{name}_hardening") or 0) > 0:
                say(f"note       {name} hardens: its load may grow without a limit")
        if self.mode == "load":
            self.check_growth()

    def check_growth(self):
        """Finds how large the loads are at the end, and says which of them do not grow in proportion to time."""
        say, line = self.study.say, r"^load +{}: .* in all (\([^)]*\)|\S+) \S+(?: m)? at t=(\S+) s"
        half = scene.run(self.options, self.study.processes, dry_run=True, time_end=0.5 * self.end)
        whole = scene.run(self.options, self.study.processes, dry_run=True)
        for told in re.findall(r"^note .*", whole.out, re.M):
            say(told)
        for name in self.loads:
            found = [re.search(line.format(name), result.out, re.M) for result in (half, whole)]
            if not all(found):
                continue
            part, all_of_it = (math.hypot(*map(float, match[1].strip("()").split(","))) for match in found)
            if abs(2 * part - all_of_it) > 0.01 * all_of_it:
                say(f"note       load {name} is not in proportion to time: {part:g} N at half of -time_end, at most {all_of_it:g} N; the factor is t/time_end")
            else:
                self.loads[name] = all_of_it
        if "acceleration" in self.options:
            say("note       the factor is t/time_end: for that -acceleration has to be in proportion to t")
        ramp = self.options.get("gravity_ramp")
        if any(self.gravity) and ramp is not None and float(ramp) != self.end:
            say("note       gravity does not grow to -time_end (-gravity_ramp): the factor is that of the loads")

    # ---- Runs

    def grid(self, level):
        options = scene.refined(self.options, self.facts, level) if level else self.options
        return options | {"dt_size": f"{self.dt:.15g}"}

    def try_run(self, options):
        """(last time that holds, first that does not or None) of a run; a run that ends otherwise is an Error. If the solver may have
        failed it is made again with more iterations and a line search, as far as the scene does not choose these, and the run that
        comes farther counts."""
        best = self.run_once(options)
        for more in REMEDIES:
            if self.ends != "solver":
                break
            told = self.softer, self.ends
            again = self.run_once(options | {name: value for name, value in more.items() if name not in options})
            if again[1] is not None and again[0] <= best[0]:
                self.softer, self.ends = told
            else:
                best = again
        return best

    def run_once(self, options):
        result = scene.run(options, self.study.processes)
        self.runs += 1
        found = re.search(FAILED, result.line) if result.status else None
        if result.status and not (result.status == pebble.STOPPED and found):
            raise pebble.Error(result.line, result)
        self.study.warn(result)
        states, softer = list(result.snapshots), self.study.words.softer
        times = [state.time for state in states[1:]]
        steps = [moved(*paired(*pair)) for pair in zip(states, states[1:])]
        size = min((length for length in np.ptp(states[0].particles["x"], axis=0) if length > 0), default=math.inf)
        self.told = f"moved {moved(*paired(states[0], states[-1])):.3g} m"
        self.line = result.line
        soft = softness(times, steps, self.parts)
        slid = slides(times, steps, soft, size, self.parts)
        last, failed, self.softer = read_end(times, soft, float(found[1]) if found else None, softer, slid)
        self.ends = "holds"
        if failed is not None:
            flows = len(times) > 0 and failed <= times[-1]
            self.ends = how(flows, result.line, self.softer)
            if flows and not soft[times.index(failed)] > softer:
                self.ends = "slide"
        return last, failed

    def weaken(self, level):
        """The bracket of the divisor of the strength."""
        options = self.grid(level)
        options |= {"dt_retry": options.get("dt_retry") or "4"}

        ended = {}

        def holds(F):
            since = time.monotonic()
            last, failed = self.try_run(weakened(options, F))
            told = "holds" if failed is None else f"does not ({self.ends}), at {100 * failed / self.end:.3g} % of the load"
            self.study.say(f"run        grid {level + 1}: strength/{F:.5g} {told}; {self.told}; {time.monotonic() - since:.2g} s")
            if self.ends == "solver" and "holds" not in [ends for ends, _ in ended.values()]:
                raise NoLimit(f"the solver failed with strength/{F:.5g}, where the body had hardly softened: {self.line}; try a smaller -dt_size")
            if self.ends == "solver" and any(abs(last - end) < 1e-9 * self.end for end in self.parts[:-1]):
                self.ends = "no equilibrium"  # a stage began, before which all was well: how soft the body was says nothing
            ended[F] = self.ends, self.softer
            return failed is None

        growth = 1.2 if not level else 1 + 4 * self.tolerance
        low, high = bracket(holds, self.start, growth, self.tolerance)
        self.ends, self.softer = ended[high][0], max(ended[low][1], ended[high][1])
        return low, high

    def lift(self, level):
        """The bracket of the factor of the load, or of gravity, by runs with shorter steps until it is small enough. Where
        gravity does not suffice, it is made stronger."""
        options, dt, end = self.grid(level), self.dt, self.soon
        if any(self.gravity) and not options.get("gravity_ramp"):
            options |= {"gravity_ramp": f"{self.end:.15g}"}
        for _ in range(TRIES):
            halvings = max(1, math.ceil(math.log2(dt / (0.3 * self.tolerance * self.end))))
            changed = {"dt_size": f"{dt:.15g}", "dt_retry": halvings, "time_end": f"{end:.15g}"}
            if self.mode == "gravity":
                changed["gravity"] = ",".join(f"{self.start * g:.15g}" for g in self.gravity)
            since = time.monotonic()
            last, failed = self.try_run(options | changed)
            low, high = self.start * last / self.end, self.start * (failed or math.inf) / self.end
            told = f"{low:.5g} holds" + (f", {high:.5g} does not ({self.ends})" if failed else "")
            self.study.say(f"run        grid {level + 1}: the factor {told}; {self.told}; {time.monotonic() - since:.2g} s")
            if failed is not None and high < NOTHING * self.start:
                raise NoLimit("the scene does not carry a millionth of its load: nothing holds the body (-bc_<f>_type separate only pushes), or the load is that much too large")
            if failed is not None and high - low <= self.tolerance * 0.5 * (low + high):
                return low, high
            if failed is None and end < self.end:
                end = self.end
            elif failed is None:
                if self.mode == "load":
                    raise NoLimit("the scene carries its whole load; let it grow further, in proportion to t")
                self.start *= GROWTH
            else:
                dt = min(0.5 * dt, 0.8 * self.tolerance * last if last > 0 else 0.1 * failed)
                end = min(self.end, 1.05 * failed)
        raise NoLimit(f"after {TRIES} runs the factor is between {low:g} and {high:g}")

    def begin_at(self, factor):
        """Lets the search on the next grid begin near the factor of this one."""
        self.start = {"load": 1.0, "gravity": 1.05 * factor, "strength": factor}[self.mode]
        self.soon = min(self.end, 1.05 * factor * self.end) if self.mode == "load" else self.end

    def make(self, level, before):
        options = self.grid(level)
        facts = self.each[level]
        key = scene.digits(options, self.study.processes, self.mode, self.tolerance, self.study.words.softer)
        row = before.get(key)
        if row:
            row = {name: text if name in TEXTS else float(text or "nan") for name, text in row.items()}
            self.study.say(f"known      grid {level + 1}: {row['holds']:.5g} holds, {row['fails']:.5g} does not ({row['ends']})")
            self.begin_at(row["factor"])
        else:
            self.runs, self.softer, self.ends, since = 0, math.nan, "", time.monotonic()
            low, high = (self.weaken if self.mode == "strength" else self.lift)(level)
            row = {"holds": low, "fails": high, "factor": 0.5 * (low + high), "ends": self.ends, "softer": self.softer}
            row |= {"runs": self.runs, "seconds": time.monotonic() - since}
            self.begin_at(row["factor"])
        self.rows.append(row | {"grid": level + 1, "h": facts.h[0], "cells": "x".join(map(str, facts.cells)), "particles": facts.particles, "key": key})
        if row["ends"] == "solver":
            self.study.say(
                f"warning    grid {level + 1}: before it failed the body was only {row['softer']:.3g} times as soft as at first: the solver may have failed where "
                "there is an equilibrium, also with more iterations and line searches; try a smaller -dt_size"
            )

        if row["ends"] == "slide":
            self.study.say(
                f"note       grid {level + 1}: the body counts as failed since it slides far, though it yields less than {self.study.words.softer:g} times as much as at first: "
                "its ground is soft for its load. A larger E tells sharper where it fails, and does not change the limit"
            )

    def write(self):
        forms = {"grid": "d", "particles": "d", "runs": "d", "seconds": ".4g", "softer": ".4g"}
        with open(self.path + ".new", "w", newline="", encoding="utf-8") as file:
            out = csv.writer(file, lineterminator="\n")
            out.writerow(COLUMNS)
            out.writerows([scene.text_of(row[name], forms.get(name, "r")) for name in COLUMNS] for row in self.rows)
        os.replace(self.path + ".new", self.path)

    # ---- What it prints

    def report(self):
        say, rows = self.study.say, self.rows
        say(f"{'grid':>5}  {'h':>9}  {'particles':>9}  {'holds':>9}  {'fails':>9}  {'by':<14}  {'softer':>7}  {'runs':>4}  {'seconds':>7}")
        for row in rows:
            say(
                f"{row['grid']:5.0f}  {row['h']:9.4g}  {row['particles']:9.0f}  {row['holds']:9.5g}  {row['fails']:9.5g}  {row['ends']:<14}  "
                f"{scene.text_of(row['softer'], '.3g', '-'):>7}  {row['runs']:4.0f}  {row['seconds']:7.3g}"
            )
        last = rows[-1]
        half = 0.5 * (last["fails"] - last["holds"])
        change = f", {100 * (last['factor'] / rows[-2]['factor'] - 1):+.2g} % from the grid before" if len(rows) > 1 else ""
        early = SOFT if last["ends"] == "slide" else EARLY
        low, high, why = estimate([(row["holds"], row["fails"]) for row in rows], early)
        say(f"factor     {last['factor']:.4g} +- {half:.2g} on the finest grid{change}")
        for name, whole in self.loads.items() if self.mode == "load" else ():
            if whole is not None:
                say(f"           load {name} is {whole * last['factor']:.4g} N then")
        if last["ends"] == "solver":
            say(f"limit      not found: at least {low:.4g}, by the cells; on the finest grid the solver failed, and no limit was seen")
        else:
            say(f"limit      {low:.4g} to {high:.4g}: {why}")
        say("uncertain  this range is of the cells and of the bracket alone: not of the strength, the dilation and the shape of the scene. The body counts")
        say(f"           as failed where no equilibrium is found, where it yields more than {self.study.words.softer:g} times as much as at first (flow; --softer), or")
        say(f"           more than {FEW:g} times and by more than {FAR:g} of its least extent for as much load as it bears already (slide), which can be before")
        say(f"           its limit: for that the range goes {100 * early:g} % higher")

    def check_grids(self):
        self.each = []
        for level in range(self.levels):
            facts = scene.Facts(self.grid(level), self.study.processes)
            if facts.refused:
                raise Refused(f"grid {level + 1} of the study: {facts.refused}")
            self.each.append(facts)
            if self.study.dry:
                self.study.say(f"grid {level + 1:2}    {'x'.join(map(str, facts.cells))} cells, {facts.particles} particles")

    def run(self):
        study = self.study
        what = {
            "load": "the load grows, as the scene's in time,",
            "gravity": "gravity grows",
            "strength": "the strength of the materials is divided by a factor that grows",
        }[self.mode]
        grids = f"{self.levels} grids" if self.levels > 1 else "one grid"
        study.say(f"study      limit of {self.facts.title}: {what} until no equilibrium is found; to {100 * self.tolerance:g} %, {grids}")
        self.notes()
        self.check_grids()
        if study.dry:
            study.say("dry run    the study is valid; no step was made")
            return 0
        before, status = scene.read_table(self.path, COLUMNS[:2]), 0
        for level in range(self.levels):
            try:
                self.make(level, before)
            except (NoLimit, pebble.Error) as none:
                study.complain(f"no limit on grid {level + 1}: {none}" if isinstance(none, NoLimit) else str(none))
                status = 3
                break
            self.write()
        if self.rows:
            self.report()
            study.end(self.path)
        return status
