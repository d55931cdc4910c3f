"""The methods that the studies compare, one row each: name, options, and length of the step. To add one, add a row;
`make studies STUDIES=missing` measures what is missing, and no more.

Names are basis, update, transfer: bs2 and bs3 are quadratic and cubic splines, gimpS is GIMP with stretched domains; behind
aflip stands its -method_affine_strain. A name that ends with `own` is at the program's own -dt_cfl for that method, the others
at 0.4. A method has margin if src/step/stable.def, the table of measured bounds of C = c dt/h where particles cross cells,
allows a step at least 1.15 times as long. Only such methods can be the best that others are compared with (regret).
"""
import math
import os
import re
import sys
from typing import NamedTuple

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
MARGIN = 1.15  # MPM_STABLE_MARGIN
LONGEST = 0.8  # MPM_STABLE_LONGEST
sys.path.insert(0, os.path.join(ROOT, "lab"))
from pebble_study import methods as study  # noqa: E402 (after the path)

BOUNDS = study.table()


def bound(options):
    """The largest stable C of a method where particles cross cells; None if the table has none."""
    given = dict(re.findall(r"-method_(\w+) (\S+)", options))
    if (given.get("basis"), given.get("update")) not in BOUNDS:
        return None
    numbers = {name: float(given[option]) for name, option in (("flip", "flip"), ("rate", "damping_rate"), ("strain", "affine_strain"), ("viscosity", "damping_viscosity"))
               if option in given}
    return study.bounds(given["basis"], given["update"], given.get("transfer", "flip"), **numbers)[1]


def own_cfl(options):
    """The program's -dt_cfl if none is given (src/step/stable.c)."""
    largest = (bound(options) or 0) / MARGIN
    return min(LONGEST, math.floor(largest * 20 + 1e-9) / 20) if largest >= 0.15 else 0.4


class Method(NamedTuple):
    options: str
    cfl: float = 0.4
    stable: bool | None = None  # None: by the table

    @property
    def margin(self):
        largest = bound(self.options)
        return self.stable if self.stable is not None else None if largest is None else largest >= MARGIN * self.cfl - 1e-9


BASES = {"bs2": "-method_basis bspline2", "bs3": "-method_basis bspline3", "gimp": "-method_basis gimp -method_gimp_update none",
         "gimpS": "-method_basis gimp -method_gimp_update stretch", "lin": "-method_basis linear"}
COLOURS = {"bs2": "tab:blue", "bs3": "tab:purple", "gimp": "tab:olive", "gimpS": "tab:green", "lin": "tab:red"}
MARKERS = {"usf": "v", "usl": "o", "musl": "s"}
LINES = {"flip": "-", "apic": "--", "aflip": "-.", "afmpm": (0, (3, 1, 1, 1)), "pic": ":", "xpic": ":"}


def method(name):
    """What a name stands for."""
    basis, update, transfer, *more = name.split()
    own = more[-1:] == ["own"]
    options = f"{BASES[basis]} -method_update {update} -method_transfer {transfer}"
    if transfer == "aflip":
        options += f" -method_affine_strain {more[0]}"
    return Method(options, own_cfl(options) if own else 0.4)


REFERENCE = "bs2 usl flip"  # the method whose time a step is 1, and whose cost is compared at
OLD_DEFAULT = "bs2 musl flip"  # what the default was
names = (
    REFERENCE, OLD_DEFAULT, "bs2 usl apic", "bs2 musl apic", "bs3 usl flip", "bs3 musl flip", "bs3 usl apic", "bs3 musl apic", "gimp usl flip", "gimp musl flip",
    "gimp usl apic", "gimp musl apic", "gimpS usl flip", "gimpS musl flip", "gimpS usl apic", "gimpS musl apic", "lin usf flip", "lin musl flip",
    "gimpS usl aflip 0 own", "gimpS usl flip own", "gimpS usl apic own", "bs2 usl aflip 1 own", "bs3 usl aflip 1 own", "gimpS usl aflip 0.5 own", "gimpS usl aflip 0.25 own",
    "bs2 usl aflip 0 own", "bs3 usl aflip 0 own", "gimpS usl aflip 0", "gimpS usl aflip 0.25", "gimpS usl aflip 0.5", "bs2 usl aflip 0", "bs2 usl aflip 1", "bs3 usl aflip 0",
    "bs3 usl aflip 1", "bs3 usl aflip 0.5", "bs3 usl afmpm")
METHODS = {name: method(name) for name in names if not (name.endswith(" own") and method(name).cfl == 0.4)}  # that is the one at 0.4
# Methods shown in figures: those with margin, if a curve is theirs alone, and these.
SHOWN = [OLD_DEFAULT, "gimpS musl flip", "lin usf flip"]
# Methods of which particles per cell and the length of a step are varied too, at the common grid of each problem.
VARIED = ["bs2 usl flip", "bs2 musl flip", "bs3 usl flip", "gimpS usl flip", "gimpS usl apic"]
VARIANTS = [(2, None), (3, None), (2, 0.1)]  # particles per cell and axis, -dt_cfl (None: the method's own)


def presets(path=os.path.join(ROOT, "src", "run", "preset.def")):
    """{preset of the program: what it is in a scene of elastic laws, as the names above}; it is measured as it is."""
    short, found = {"bspline2": "bs2", "bspline3": "bs3", "gimp": "gimp", "linear": "lin"}, {}
    with open(path) as file:
        for line in file:
            if line.startswith("MPM_PRESET("):
                name, scenes, basis, stretch, update, transfer, strain, *_ = line[11:line.index(")")].split(", ")
                if scenes == "elastic":
                    found[name] = f"{short[basis]}{'S' if stretch == 'PETSC_TRUE' else ''} {update} {transfer}" + (f" {strain}" if transfer == "aflip" else "")
            if line.startswith("MPM_PRESET_TOTAL("):
                name, scenes, basis, mass, *_ = line[17:line.index(")")].split(", ")
                if scenes == "elastic":
                    found[name] = f"{short[basis]} total {mass}"
    return found


PRESETS = presets()
# The methods of presets of the total frame, whose step has a time too; they are not compared on all problems, since bodies
# may meet nothing in it.
TOTAL = {name: Method(f"-method_frame total {BASES[name.split()[0]]} -method_mass_order {name.split()[2]}", 0.7) for name in PRESETS.values() if name.split()[1] == "total"}
