"""Methods of a study: their names, and what src/step/stable.def, the table of measured bounds, says of their steps."""

import os
import re

import pebble_mpm as pebble

from .scene import Refused

FLIPS, ORDERS = (
    ("flip", "aflip"),
    ("xpic", "afmpm"),
)  # transfers that take -method_flip, and -method_order (transfer.def)
KINDS = ["rest flip", "rest affine", "flip", "damped", "aflip 0", "aflip 0.5", "aflip 1", "apic", "filtered", "afmpm"]
TABLE = os.path.join(pebble.HERE, "..", "src", "step", "stable.def")
MOST = 32  # words of a list


def names(option):
    """What the program takes as the value of an option."""
    said = pebble.start([pebble.find_program(), "-help", option])[1]
    return re.search(rf"^ +-{option} .*\((\S+\|\S+)\)$", said, re.M)[1].split("|")


def bases():
    """Bases, and gimp_stretch for gimp with -method_gimp_update stretch."""
    return [*names("method_basis"), "gimp_stretch"]


def read_list(option, text, legal=None, most=None):
    """The words of a list: each of them one of `legal` up to a colon, or a number in (0,most]."""
    words = [word for word in re.split("[, ]+", text) if word]
    if not words:
        raise Refused(f"--{option} is empty")
    if len(words) > MOST:
        raise Refused(f"--{option}: at most {MOST} words")
    for word in words:
        if legal and word.partition(":")[0] not in legal:
            raise Refused(f"--{option} {word}: choose a list of {' '.join(legal)}")
        if legal is None and not (re.fullmatch(r"[\d.]+(e[+-]?\d+)?", word) and 0 < float(word) <= most):
            raise Refused(f"--{option} {word}: choose a list of numbers > 0, at most {most:g}")
    return words


def read_transfers(text):
    words = read_list("transfer", text, names("method_transfer"))
    for word in words:
        transfer, colon, number = word.partition(":")
        if colon and transfer not in FLIPS + ORDERS:
            raise Refused(f"--transfer {word}: this transfer takes neither -method_flip nor -method_order")
        if colon and not re.fullmatch(r"[\d.]+(e[+-]?\d+)?", number):
            raise Refused(f"--transfer {word}: no number stands after the colon")
    return words


def table(path=TABLE):
    """{(basis, update): {kind: largest stable C}}."""
    with open(path, encoding="utf-8") as file:
        rows = [line[11 : line.index(")")].split(", ") for line in file if line.startswith("MPM_STABLE(")]
    return {(row[0], row[1]): dict(zip(KINDS, map(float, row[2:]))) for row in rows}


def total(path=TABLE):
    """{basis: largest stable C with a mass of order 1, 2, 3} in the total frame."""
    with open(path, encoding="utf-8") as file:
        rows = [line[17 : line.index(")")].split(", ") for line in file if line.startswith("MPM_STABLE_TOTAL(")]
    return {row[0]: [float(word) for word in row[1:]] for row in rows}


def bounds(basis, update, transfer, flip=None, rate=None, strain=None, viscosity=None):
    """(at rest, where particles cross cells): the largest stable C = c dt/h of a method by the table, 0 for none;
    src/step/stable.c has the same rules."""
    row = table().get((basis, update))
    if not row:
        return 0.0, 0.0
    if transfer == "aflip":
        kind = f"aflip {1 if (strain or 0) > 0.5 else 0.5 if (strain or 0) > 0 else 0}"
    elif transfer in ("pic", "xpic"):
        kind = "filtered"
    elif transfer == "flip" and ((1 if flip is None else flip) < 0.995 or rate or viscosity):
        kind = "damped"
    else:
        kind = transfer
    crossing = row.get(kind, 0.0)
    return crossing if kind == "afmpm" else row[
        "rest affine" if transfer in ("apic", "aflip") else "rest flip"
    ], crossing
