"""The problems on which methods are compared, one row each: a scene of options/, what is different from it, the grids, and
how the error is found. To add one, add a row.

Errors are relative: the rms error of the displacement, by mass, over its rms (exact and manufactured solutions, and the
ring under pressure), the error of the tip over its deflection (cantilever), the energy lost in a collision over that before it.
"""
import csv
import math
import os
import re
import sys
from typing import Callable, NamedTuple

import numpy as np

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
sys.path.insert(0, os.path.join(ROOT, "lab"))
import pebble_mpm as pebble  # noqa: E402 (after the path)

DATA = os.path.join(ROOT, "docs", "data")


class Problem(NamedTuple):
    dim: int
    scene: str            # file of options/
    options: Callable     # n -> what is different from it
    levels: list          # cells n, from coarse to fine
    common: int           # the level of the tables: the finest that every method was measured at
    error: Callable       # Run -> relative error
    bodies: str           # names of its bodies
    floor: float = 1e-3   # an error below counts as this one: what the reference itself is good for, or nobody needs
    about: str = ""       # what the error is, in words


# ---- Errors

def reference(run):
    """What the program prints at the end of a run whose solution is known."""
    return run.number(r"^reference .* relative error is (\S+)$")


def positions(path):
    """Times, positions [snapshot][particle][axis] in the order of the ids, velocities where there are any, and masses
    [particle], None where the files have none."""
    snapshots = pebble.load(path).snapshots
    x = [snapshot.particles["x"] for snapshot in snapshots]
    v = [snapshot.particles["v"] for snapshot in snapshots if "v" in list(snapshot.particles)]
    return snapshots.times, np.array(x), np.array(v), snapshots[0].particles.get("mass")


def reach(x, m):
    """Where 99.5 % of the mass is behind, of particles at x with masses m; of equal masses np.quantile."""
    order = np.argsort(x)
    middle = np.cumsum(m[order]) - m[order] / 2
    return np.interp(0.995, (middle - middle[0]) / (middle[-1] - middle[0]), x[order])


TIP = -2.3899  # m, the deepest place of the middle of the end X = 4 by spectral elements (reference_cantilever.py)


def deepest(run, end):
    """The lowest place of a beam's end X = end. The last column of particles is a quarter of a cell before it, where the beam
    sinks 1 % less (8 cells across it), so the line through the last two columns is followed to the end."""
    t, x, _, _ = positions(run.path(".h5"))
    X = x[0][:, 0]
    last, before = np.unique(X.round(9))[[-1, -2]]
    u, v = ((x[:, abs(X - column) < 1e-6, 1] - x[0][abs(X - column) < 1e-6, 1]).mean(1) for column in (last, before))
    u = u + (u - v) * (end - last) / (last - before)
    k = u.argmin()
    if 0 < k < len(u) - 1:  # the parabola through the three lowest
        a, b, c = u[k - 1:k + 2]
        return b - (a - c)**2 / (8 * (a - 2 * b + c))
    return u[k]


def tip(run):
    return abs(deepest(run, 4) / TIP - 1)


def ring_displacement():
    """R and u of the ring of options/pressure.opts computed along its radius alone (reference_pressure.py)."""
    with open(os.path.join(DATA, "pressure_reference.csv")) as file:
        rows = list(csv.DictReader(file))
    return (np.array([float(row[key]) for row in rows]) for key in ("R", "u"))


def pressure(run):
    R, u = ring_displacement()
    _, x, _, m = positions(run.path(".h5"))
    X = x[0][:, :2]
    r = np.hypot(*X.T)
    exact = X / r[:, None] * np.interp(r, R, u)[:, None]
    return math.sqrt((m * (((x[-1] - x[0])[:, :2] - exact)**2).sum(1)).sum() / (m * (exact**2).sum(1)).sum())


def lost(run):
    """Of the total energy, kinetic and strain; a gain counts too."""
    energy = run.history("total_energy")
    return abs(energy[-1] / energy[0] - 1)


# ---- The problems

def square(n, dim=2):
    return f"-grid_cells {','.join([str(n)] * dim)}"


MODE = "-reference_type expression -reference_displacement 0.1/(5*pi)*sin(pi/2*X)*sin(5*pi*t) -time_end 4.9"
PROBLEMS = {
    "bar": Problem(1, "bar", lambda n: f"-grid_upper {1 + 1 / n!r} -grid_cells {n + 1} {MODE}", [8, 16, 32, 64], 32, reference, "bar",
                   about="exact, 12 periods"),
    "barx": Problem(1, "barx", lambda n: f"-grid_cells {n}", [16, 32, 64, 128, 256], 128, reference, "bar", about="exact, particles cross cells"),
    "column": Problem(1, "elastic_column", lambda n: f"-grid_cells {n + n // 4}", [16, 32, 64, 128], 64, reference, "column", about="exact, with shocks"),
    "mms": Problem(2, "mms", square, [8, 16, 32, 64], 32, reference, "block", about="manufactured"),
    "shear": Problem(2, "shear", lambda n: f"-grid_cells {n // 2},{n}", [8, 16, 32, 64], 32, reference, "layer", about="exact, finite shear"),
    "ring": Problem(2, "ring", square, [24, 48, 96], 96, reference, "ring", about="manufactured, curved rims"),
    "vortex": Problem(2, "vortex", square, [30, 60, 120], 120, reference, "ring", about="manufactured, the middle turns"),
    "cantilever": Problem(2, "cantilever", lambda n: f"-grid_h {1 / n!r},{1 / n!r} -time_end 2 -output_every 0.02 -output_fields body", [2, 4, 8, 16], 8, tip, "beam", 3e-3,
                          about="deepest place of the tip"),
    "pressure": Problem(2, "pressure", lambda n: square(n) + " -output_every 1 -output_fields mass", [15, 30, 60], 30, pressure, "ring",
                        about="displacement, load on a rim"),
    "disks": Problem(2, "disks", lambda n: square(n), [10, 20, 40], 20, lost, "disk1 disk2", 1e-2, about="energy lost in a collision"),
    "disks_contact": Problem(2, "disks_contact", lambda n: square(n) + " -contact_mu 0", [20, 40, 80], 40, lost, "disk1 disk2", 1e-2,
                             about="energy lost in a smooth collision with contact"),
    "mms3d": Problem(3, "mms", lambda n: f"-dim 3 -geometry cartesian -grid_lower 0,0,0 -grid_upper 1,1,1 {square(n, 3)} -bc_zmin_type slip -bc_zmax_type slip "
                     "-body_block_lower 0,0,0 -body_block_upper 1,1,1", [8, 16], 16, reference, "block", about="manufactured, 3-D"),
    "disks3d": Problem(3, "disks3d", lambda n: square(n, 3), [8, 16, 24], 16, lost, "ball1 ball2", 1e-2, about="energy lost in a collision of balls"),
}
MAIN = "bar barx column mms shear ring vortex cantilever pressure disks".split()  # those that regret is made of


def plain(scene, path, without):
    """A copy of a scene of options/ without the options of that pattern, so that the method is what the study says."""
    with open(os.path.join(ROOT, "options", scene + ".opts")) as file:
        lines = [line for line in file if not re.match(without, line)]
    with open(path, "w") as file:
        file.writelines(lines)


METHOD = r"-(method_\w+|dt_cfl)\b"
PRESET = r"-(method_\w+|dt_cfl|ppc)\b"  # a preset has its own particles per cell


def options(name, n, ppc, folder):
    """All options of a run but those of the method; its scene is written to that folder. ppc None: as the preset has it."""
    p = PROBLEMS[name]
    text, scene = p.options(n), os.path.join(folder, "scene.opts")
    plain(p.scene, scene, METHOD if ppc else PRESET)
    more = ["-check_energy", "0", "-check_momentum", "0", "-history_every", "1e9"]
    if "-output_every" not in text:
        more += ["-output_format", "none"]
    for body in p.bodies.split() if ppc else []:
        more += [f"-body_{body}_ppc", ",".join([str(ppc)] * p.dim)]
    return ["-options_file", scene, *text.split(), *more]
