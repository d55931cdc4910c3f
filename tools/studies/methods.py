"""The methods that the studies compare, one row each: name, options, whether it has margin, and its colour and line in
figures. To add one, add a row; `make studies STUDIES=all` measures what is missing, and no more.

name     basis, update, transfer: bs2 and bs3 are quadratic and cubic splines, gimpS is GIMP with stretched domains
options  what the method is, beside the options of the scene
margin   whether the method is stable with margin where particles cross cells, by the table of docs/stability.md: only
         such methods can be the best that others are compared with (regret). None: not measured, counts as no.
cfl      -dt_cfl of the comparison at the method's own step length
"""
from typing import NamedTuple


class Method(NamedTuple):
    options: str
    margin: bool | None = None
    cfl: float = 0.4


BASES = {"bs2": "-method_basis bspline2", "bs3": "-method_basis bspline3", "gimp": "-method_basis gimp -method_gimp_update none",
         "gimpS": "-method_basis gimp -method_gimp_update stretch", "lin": "-method_basis linear"}
COLOURS = {"bs2": "tab:blue", "bs3": "tab:purple", "gimp": "tab:olive", "gimpS": "tab:green", "lin": "tab:red"}
MARKERS = {"usf": "v", "usl": "o", "musl": "s"}
LINES = {"flip": "-", "apic": "--", "aflip": "-.", "pic": ":", "xpic": ":"}


def method(basis, update, transfer, margin=None, cfl=0.4, more=""):
    return Method(f"{BASES[basis]} -method_update {update} -method_transfer {transfer} {more}".strip(), margin, cfl)


REFERENCE = "bs2 usl flip"  # the method whose time a step is 1, and whose cost is compared at
METHODS = {
    "bs2 musl flip": method("bs2", "musl", "flip", margin=False),
    "bs2 usl flip": method("bs2", "usl", "flip", margin=True),
    "bs2 musl apic": method("bs2", "musl", "apic"),
    "bs2 usl apic": method("bs2", "usl", "apic", margin=True),
    "bs3 musl flip": method("bs3", "musl", "flip", margin=False),
    "bs3 usl flip": method("bs3", "usl", "flip", margin=True),
    "bs3 musl apic": method("bs3", "musl", "apic"),
    "bs3 usl apic": method("bs3", "usl", "apic", margin=True),
    "gimp musl flip": method("gimp", "musl", "flip", margin=False),
    "gimp usl flip": method("gimp", "usl", "flip", margin=True),
    "gimp musl apic": method("gimp", "musl", "apic"),
    "gimp usl apic": method("gimp", "usl", "apic", margin=True),
    "gimpS musl flip": method("gimpS", "musl", "flip", margin=False),
    "gimpS usl flip": method("gimpS", "usl", "flip", margin=True),
    "gimpS musl apic": method("gimpS", "musl", "apic"),
    "gimpS usl apic": method("gimpS", "usl", "apic", margin=True),
    "lin usf flip": method("lin", "usf", "flip", margin=False),
    "lin musl flip": method("lin", "musl", "flip", margin=False),
}
# What the older default was, for comparison; it stays in the tables.
OLD_DEFAULT = "bs2 musl flip"
# Methods shown in figures, beside those with margin.
SHOWN = [OLD_DEFAULT, "gimpS musl flip", "lin usf flip"]
# Methods of which particles per cell and the length of a step are varied too, at the common grid of each problem.
VARIED = ["bs2 usl flip", "bs2 musl flip", "bs3 usl flip", "gimpS usl flip", "gimpS usl apic"]
VARIANTS = [(2, None), (3, None), (2, 0.1)]  # particles per cell and axis, -dt_cfl (None: the method's own)
