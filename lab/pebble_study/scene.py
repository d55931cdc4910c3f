"""A scene of a study: its options with some of them replaced, and what the program says of it before the first step."""

import csv
import hashlib
import math
import os
import re
import tempfile

import numpy as np
import pebble_mpm as pebble

from . import series

ELSEWHERE = (
    "options_file",
    "options_view",
    "output_dir",
    "output_name",
    "dry_run",
    "log_view",
    "options_left",
)  # change no result
WRONG = (
    r"^warning +\S+ with \S+ and \S+ ((?:is unstable where particles cross cells|stops all motion in|was wrong by).*)$"
)
KERNELS = re.compile(
    r"^kernels +(\S+)(?: (stretch|steffen))? / (\S+) / (\w+)(?: mass order (\d))?(?: ([\d.e+-]+))?(?: strain (\S+))?(?: damping rate (\S+))?"
    r"(?: viscosity (\S+) m\^2/s)? / ",
    re.M,
)


class Refused(Exception):
    """What a study or the program does not take: one line."""


class Options(dict):
    """{name: value}; None: it is not given. typed: names that were on the command line, where they may make those of a
    file idle."""

    def __init__(self, values, typed=()):
        super().__init__(values)
        self.typed = typed

    def __or__(self, more):
        return Options({**self, **more}, self.typed)


def database(words, processes):
    """All Options of a scene, -options_file and its path first, those of its files too."""
    result = pebble.run(words, processes, check=False, dry_run=True, options_view=True)
    if result.status:
        raise Refused(result.line)
    block = re.search(r"^#PETSc Option Table entries:\n(.*?)^#End", result.out, re.M | re.S)
    if not block:
        raise Refused("the program did not list its options (-options_view)")
    options = dict(re.match(r"-(\S+) ?(.*)", line).groups() for line in block[1].splitlines())
    given = [words[k + 1] for k, word in enumerate(words) if word == "-options_file"]
    for name, value in options.items():  # a file is named beside the scene
        beside = [os.path.join(os.path.dirname(path), value) for path in given]
        if re.fullmatch(r"body_\w+_file", name):
            options[name] = next((os.path.abspath(path) for path in [*beside, value] if os.path.exists(path)), value)
    typed = {word[1:] for word in words[2:] if word.startswith("-")}
    return Options({name: value for name, value in options.items() if name not in ("dry_run", "options_view")}, typed)


class Facts:
    """What the program says of options without a step, or of a run in its result. refused: the line with which it
    refuses them, or ""; then the rest is not there. wrong: why the method is doubtful wherever particles cross cells,
    or ""."""

    def __init__(self, options, processes, result=None):
        result = result or run(options, processes, dry_run=True)
        self.refused = result.line if result.status == pebble.REFUSED or not result.out else ""
        self.wrong = result.find(WRONG) or ""
        if self.refused:
            return
        self.title, cells = re.search(r"^scene +(.*?)   \d-D.*?   (\S+) cells ", result.out, re.M).groups()
        self.cells = [int(n) for n in cells.split("x")]
        self.dim = len(self.cells)
        lower, upper = (numbers(options[f"grid_{end}"], self.dim) for end in ("lower", "upper"))
        self.h = [(b - a) / n for a, b, n in zip(lower, upper, self.cells)]
        self.length = [
            b - a if options.get(f"bc_{axis}min_type") == "periodic" else np.inf
            for a, b, axis in zip(lower, upper, "xyz")
        ]
        self.counts = [int(n) for n in result.find(r"^scene .* particles \((\S+)\)").split("+")]
        self.particles = sum(self.counts)
        self.basis, form, self.update, self.transfer, mass, number, *rest = KERNELS.search(result.out).groups()
        self.stretched = form == "stretch"
        self.strain, self.rate, self.viscosity = (float(text) if text else None for text in rest)
        flips, orders = self.transfer in ("flip", "aflip"), self.transfer in ("xpic", "afmpm")
        self.flip = (float(number) if number else 1.0) if flips else None
        self.order = int(number) if orders else int(mass) if mass else None  # mass: in the total frame
        self.total = mass is not None
        self.fixed = 0.0 if options.get("dt_size") in (None, "auto") else float(options["dt_size"])
        preset = result.find(r"^preset .* -dt_cfl (\S+)")
        self.cfl = float(
            options.get("dt_cfl") or preset or result.find(r"^stability .* = (\S+) h/(?:\(c\+\|v\|\)|c$)") or "nan"
        )
        self.memory = 1e6 * result.number(r"^fields .* B/node: (\S+) MB")
        self.predicted = result.number(r"^  all +\S+ +(\S+)")

    @property
    def method(self):
        """What makes two runs of a grid the same."""
        return (
            self.basis,
            self.stretched,
            self.update,
            self.transfer,
            self.flip,
            self.strain,
            self.rate,
            self.order,
            self.particles,
            self.cfl,
            self.fixed,
        )


def numbers(text, dim):
    found = [float(word) for word in pebble.word(text).split(",")]
    return found * dim if len(found) == 1 else found


def run(options, processes, folder=None, name="run", **more):
    """The Result of a run with these options, which may be refused or stop."""
    given = {
        option: pebble.word(value)
        for option, value in options.items()
        if value is not None and option not in ("output_dir", "output_name")
    }
    typed = [option for option in given if option in getattr(options, "typed", ())]
    words = [word for option in typed for word in (f"-{option}", given[option]) if word]
    with tempfile.TemporaryDirectory(prefix="pebble-") as place:
        path = os.path.join(place, "study.opts")
        with open(path, "w", encoding="utf-8") as file:
            file.writelines(f"-{option} {quoted(value)}\n" for option, value in given.items() if option not in typed)
        result = pebble.run(["-options_file", path, *words], processes, folder, check=False, output_name=name, **more)
    result.err = re.sub(re.escape(path) + r":\d+: ", "", result.err)
    return result


def quoted(value):
    """A value as an options file has it."""
    return value if not re.search(r"[\s#]", value) else f"'{value}'" if '"' in value else f'"{value}"'


def bodies(options):
    """Names of the bodies with particles, in the order of these. (Those of material `none` are shapes for others.)"""
    none = "none" if "none" not in options["materials"].lower().split(",") else None
    names = options["bodies"].split(",")
    return [name for name in names if options.get(f"body_{name}_material", "").lower() != none]


def refined(options, facts, level):
    """Cells, and a given -dt_size, 2^level times as fine as those of the scene that facts tell of."""
    cells = [n << level if level > 0 else n >> -level for n in facts.cells]
    changed = options | {"grid_h": None, "grid_cells": tuple(cells)}
    return changed | ({"dt_size": facts.fixed / 2**level} if facts.fixed else {})


def digits(options, *more):
    """16 digits that name a run: its options, the program's version, and more."""
    kept = {name: pebble.word(value) for name, value in options.items() if value is not None and name not in ELSEWHERE}
    return hashlib.sha256(repr((sorted(kept.items()), version(), more)).encode()).hexdigest()[:16]


def version(known={}):
    program = pebble.find_program()
    if program not in known:
        known[program] = pebble.start([program, "-version"])[1].strip()
    return known[program]


def begun(options, processes):
    """The first snapshot of a scene, as its options are without a known solution, which may start displaced: where all
    particles start, and their masses; and the names of the columns of its history."""
    plain = options | dict.fromkeys([name for name in options if re.match(r"mms_|reference_", name)])
    start = {"time_max_steps": 0, "output_format": "hdf5", "output_every": 1e300, "output_fields": "mass"}
    result = run(plain | start, processes)
    if result.status:
        raise Refused(result.line)
    return result.snapshots[0], list(result.history)


def lattice(options, processes, start=None):
    """[n, 3] places of the particles of a scene on their lattices; start: its first snapshot. Those at the surface of a
    body may start beside theirs (-method_rim cut)."""
    start = start or begun(options, processes)[0]
    whole = options | {"method_rim": "whole"}
    if len(np.unique(start.particles["mass"])) > 1 and not Facts(whole, processes).refused:
        start = begun(whole, processes)[0]
    return start.particles["x"]


def per_cell(options, facts, processes):
    """[particles per cell and axis] of each body."""
    given = [options.get(f"body_{name}_ppc") for name in bodies(options)]
    if all(given):
        return [[int(n) for n in numbers(text, facts.dim)] for text in given]
    places = lattice(options, processes)[:, : facts.dim]
    return [
        [round(h / series.spacing(axis, 0.5 * h)) for h, axis in zip(facts.h, part.T)] for part in parts(places, facts)
    ]


def parts(values, facts):
    """An array of all particles, in the order of their ids, by bodies."""
    return np.split(values, np.cumsum(facts.counts)[:-1])


def samples(options, processes, end, facts):
    """The bodies of a run, to be compared with those of another: from where they start and the last snapshot, in which
    particles that left the grid are missing."""
    start = begun(options, processes)[0]
    places = lattice(options, processes, start)[:, : facts.dim]
    some = np.isin(start.particles["id"], end.particles["id"])
    X, x, m = start.particles["x"][:, : facts.dim], end.particles["x"][:, : facts.dim], start.particles["mass"]
    u = np.full_like(X, np.nan)
    u[some] = x - X[some]
    halves = [0.5 * h for h in facts.h]  # spacing on an axis where there is one particle
    return [series.Body(*each, halves) for each in zip(*(parts(values, facts) for values in (X, u, m, places)))]


def read_table(path, first):
    """{key: row} of the table that an earlier study left, whose columns begin with `first`. Other files are not
    replaced."""
    if not os.path.exists(path):
        return {}
    with open(path, newline="", encoding="utf-8", errors="replace") as file:
        reader = csv.DictReader(file)
        if (reader.fieldnames or [])[: len(first)] != first:
            raise Refused(f"{path} is not the table of a study; move the file away")
        return {row["key"]: row for row in reader if row.get("key")}


def text_of(value, form, none=""):
    """A number in this form (r: with all its digits), or what stands where there is none."""
    if isinstance(value, str):
        return value
    if value is None or math.isnan(value):
        return none
    return repr(float(value)) if form == "r" else format(int(value) if form == "d" else value, form)
