"""The figure of docs/mpm.md: the functions of a node, their slopes, and the force on a node of a bar under uniform
stress that moves through the grid. The force is - sum V sigma phi', equation (4) of docs/method.md; the exact one is 0.

usage: mpm_figure.py [PICTURE]     (docs/mpm.png unless given)
"""
import os
import sys

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402 (after the choice of the backend)

STYLE = {"font.size": 9, "axes.titlesize": 9, "axes.spines.top": False, "axes.spines.right": False,
         "axes.linewidth": 0.6, "xtick.major.width": 0.6, "ytick.major.width": 0.6, "legend.frameon": False,
         "savefig.dpi": 110, "lines.linewidth": 1.2}
PPC, STRETCH = 2, 1.2  # particles per cell at the start, and by how much the bar is longer than then
CELLS = 12             # of the bar, on either side of the node


def hat(s):
    return np.maximum(0, 1 - np.abs(s))


def hat_integral(s):
    """The integral of the hat from below to s."""
    s = np.clip(s, -1, 1)
    return 0.5 + s - np.sign(s) * s * s / 2


def linear(s):
    return hat(s), np.where((s >= -1) & (s < 0), 1.0, np.where((s >= 0) & (s < 1), -1.0, 0.0))


def gimp(s):
    """The hat averaged over a domain of the size that it has at the start."""
    half = 0.5 / PPC
    return (hat_integral(s + half) - hat_integral(s - half)) / (2 * half), (hat(s + half) - hat(s - half)) / (2 * half)


def bspline2(s):
    a = np.abs(s)
    value = np.where(a <= 0.5, 0.75 - s * s, np.where(a <= 1.5, (1.5 - a) ** 2 / 2, 0))
    return value, np.where(a <= 0.5, -2 * s, np.where(a <= 1.5, -np.sign(s) * (1.5 - a), 0))


def bspline3(s):
    a = np.abs(s)
    value = np.where(a <= 1, 2 / 3 - s * s + a ** 3 / 2, np.where(a <= 2, (2 - a) ** 3 / 6, 0))
    return value, np.where(a <= 1, -2 * s + 1.5 * a * s, np.where(a <= 2, -np.sign(s) * (2 - a) ** 2 / 2, 0))


BASES = {"linear": (linear, "0.6"), "gimp": (gimp, "tab:orange"), "bspline2": (bspline2, "tab:blue"),
         "bspline3": (bspline3, "black")}


def force(basis, shift):
    """The force on the node at 0 over the stress (and area), for a bar whose particles have moved by `shift` cells."""
    spacing = STRETCH / PPC
    places = (np.arange(-CELLS * PPC, CELLS * PPC) + 0.5) * spacing
    return -spacing * basis(places[None, :] + shift[:, None])[1].sum(axis=1)


def main():
    root = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
    out = sys.argv[1] if len(sys.argv) > 1 else os.path.join(root, "docs", "mpm.png")
    plt.rcParams.update(STYLE)
    figure, (values, slopes, forces) = plt.subplots(1, 3, figsize=(9, 2.6), layout="constrained")
    s, shift = np.linspace(-2.2, 2.2, 1761), np.linspace(0, 1, 2001)
    for name, (basis, colour) in BASES.items():
        value, slope = basis(s)
        values.plot(s, value, color=colour, label=name)
        slopes.plot(s, slope, color=colour)
        forces.plot(shift, force(basis, shift), color=colour)
        print(f"{name}: force at most {abs(force(basis, shift)).max():.2g} of the stress")
    values.set_title("basis function of a node")
    slopes.set_title("its slope, times h")
    forces.set_title("force on the node / stress")
    for axes in (values, slopes):
        axes.set_xlabel("distance from the node, in cells")
    forces.set_xlabel("distance that the bar has moved, in cells")
    values.legend(loc="upper right", handlelength=1, fontsize=8, borderaxespad=0)
    figure.savefig(out, metadata={"Software": None})


main()
