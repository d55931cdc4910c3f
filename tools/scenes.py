"""The scenes of the scaling studies: `make scaling`, `make simulate` and `make report` all take them from here, so real
runs, simulated runs and the closed form are of the same scenes.

A scene has three sizes: for strong scaling, about 16,000 particles (calibration of costs, and weak scaling on one
process), and for some about a million. The size is a tuple of cells for the boxes and a number for the others.
"""

import csv
import math
import os
import platform
import re
import subprocess
import typing

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
BOX = """-scene_title "filled box"
-dim {dim}
-grid_lower {lower}
-grid_upper {cells}
-grid_cells {cells}
{walls}
-materials rubber
-material_rubber_model neohookean
-material_rubber_rho 1000
-material_rubber_E 1e6
-material_rubber_nu 0.3
-bodies box
-body_box_shape box
-body_box_lower {lower}
-body_box_upper {cells}
-body_box_ppc {ppc}
-body_box_material rubber
-body_box_velocity {velocity}
-time_end 1e9
"""


def comma(values):
    return ",".join(map(str, values))


def box(cells):
    """A box full of rubber that swings, at up to a tenth of its speed of sound, with 2 particles a cell and axis."""
    axes = "xyz"[: len(cells)]
    walls = "\n".join(f"-bc_{a}{s}_type slip" for a in axes for s in ("min", "max"))
    velocity = comma(f"4*sin(pi*{a}/{n})" for a, n in zip(axes, cells))
    return BOX.format(
        dim=len(cells),
        lower=comma("0" * len(cells)),
        cells=comma(cells),
        walls=walls,
        velocity=velocity,
        ppc=comma([2] * len(cells)),
    )


def of_options(name, cells, *more):
    """A scene of options/ without its method, with other cells, and motion from the start: without it all particles of
    a body would cross cells in the same steps, or none for long."""
    others = [f"-{word} " for word in ("ppc", "velocity") if any(f"_{word} " in line for line in more)]
    with open(os.path.join(ROOT, "options", f"{name}.opts")) as file:
        kept = "".join(
            line
            for line in file
            if not line.startswith(("-method_", "-dt_cfl", "-grid_cells", "-history_every", *others))
        )
    return kept + "\n".join((f"-grid_cells {comma(cells)}", *more)) + "\n"


def disks(cells):
    spin = (f"-body_disk{k}_velocity {v}-0.3*(y-{c}),{v}+0.3*(x-{c})" for k, v, c in ((1, 0.1, 0.2), (2, -0.1, 0.8)))
    return of_options("disks", cells, "-body_disk1_ppc 2,2", "-body_disk2_ppc 2,2", *spin)


def dambreak(cells):
    return of_options("dambreak", cells, "-body_column_velocity 4*x,-4*y")


def disks3d(cells):
    spin = (
        f"-body_ball{k}_velocity {v}-0.3*(y-{c}),{v}+0.3*(x-{c}),{v}" for k, v, c in ((1, 0.1, 0.3), (2, -0.1, 0.7))
    )
    return of_options("disks3d", cells, *spin)


def dambreak3d(cells):
    return of_options("dambreak3d", cells, "-body_column_velocity 2*x,2*y,-4*z")


class Scene(typing.NamedTuple):
    name: str
    title: str
    basis: str
    update: str
    cfl: float  # the time step is this many cells over the speed of sound and the fastest particle
    motion: str  # in words
    maker: typing.Callable  # of the text, without the method
    shape: tuple  # cells of size 1; times a size and rounded they are the grid's
    strong: object
    small: object
    large: object = None

    @property
    def dim(self):
        return len(self.shape)

    def cells(self, size):
        return tuple(size) if isinstance(size, tuple) else tuple(round(c * size) for c in self.shape)

    def text(self, size):
        method = (
            f"-method_basis {self.basis}\n-method_update {self.update}\n-method_transfer flip\n-dt_cfl {self.cfl}\n"
        )
        return self.maker(self.cells(size)) + method

    def weak(self, processes):
        """The size with as many particles a process as `small` has in all: for boxes exactly, for others as near as
        cells allow."""
        if isinstance(self.small, tuple):
            return tuple(c * p for c, p in zip(self.small, near_cube(self.dim, processes)))
        step = math.lcm(*(round(1 / (c % 1)) for c in self.shape if c % 1), 1)
        return step * round(self.small * processes ** (1 / self.dim) / step)

    def record(self):
        """What the scene is, in a row: equal rows are equal scenes."""
        return {
            "scene": self.name,
            "basis": self.basis,
            "update": self.update,
            "cfl": self.cfl,
            "cells": "x".join(map(str, self.cells(self.strong))),
            "weak_cells": "x".join(map(str, self.cells(self.small))),
            "motion": self.motion,
        }


def near_cube(dim, parts):
    """parts (a power of 2) as a product of dim factors that differ little."""
    p = [1] * dim
    while math.prod(p) < parts:
        p[p.index(min(p))] *= 2
    return p


SWINGS, SPIN = (
    "4 sin(pi x/L) m/s along each axis, cells of 1 m",
    "each body spins at 0.3 rad/s and moves to the other at 0.1 m/s an axis",
)
SCENES = {
    s.name: s
    for s in (
        Scene("box2d", "filled box, 2-D", "linear", "usl", 0.4, SWINGS, box, (1, 1), (256, 256), (64, 64), (512, 512)),
        Scene(
            "box3d",
            "filled box, 3-D",
            "bspline2",
            "usl",
            0.4,
            SWINGS,
            box,
            (1, 1, 1),
            (32, 32, 32),
            (16, 16, 8),
            (64, 64, 32),
        ),
        Scene("disks", "two disks", "linear", "usf", 0.4, SPIN, disks, (1, 1), 512, 128, 1024),
        Scene(
            "dambreak",
            "dam break",
            "bspline2",
            "musl",
            0.3,
            "the column spreads at (4x, -4y) m/s",
            dambreak,
            (5, 2.25),
            160,
            48,
        ),
        Scene("disks3d", "two balls, 3-D", "linear", "musl", 0.4, SPIN, disks3d, (1, 1, 1), 80, 32),
        Scene(
            "dambreak3d",
            "dam break, 3-D",
            "bspline2",
            "musl",
            0.4,
            "the column spreads at (2x, 2y, -4z) m/s",
            dambreak3d,
            (4, 4, 3),
            18,
            8,
        ),
    )
}


def write(folder, name, size, more=""):
    """Writes the scene's options file, and returns its path."""
    os.makedirs(folder, exist_ok=True)
    path = os.path.join(folder, f"{name}-{'x'.join(map(str, SCENES[name].cells(size)))}.opts")
    with open(path, "w") as file:
        file.write(SCENES[name].text(size) + more)
    return path


# ---- What is recorded beside the rows of a study
def table(path, rows):
    with open(path, "w", newline="") as file:
        out = csv.DictWriter(file, rows[0], lineterminator="\n")
        out.writeheader()
        out.writerows(rows)


def said(*command):
    """The first line that a command prints, or nothing."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, timeout=60)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return (done.stdout + done.stderr).splitlines()[0].strip() if done.stdout + done.stderr else ""


def machine(program, mpiexec, what=""):
    """[(name, value)]: processor, cores, lanes, compiler, MPI, PETSc and the program's commit. `what` is said beside
    the PETSc of the program."""
    with open("/proc/cpuinfo") as file:
        cpu = next((line.split(":")[1].strip() for line in file if line.startswith("model name")), platform.processor())
    version = re.match(r"(.*), PETSc ([\d.]+), (.*)", said(program, "-version"))
    name, petsc, compiler = version.groups() if version else ("", "", "")
    return {
        "processor": cpu,
        "cores": os.cpu_count(),
        "system": f"{platform.system()} {platform.release()}",
        "compiler": compiler,
        "MPI": said(mpiexec, "--version"),
        "PETSc" + what: petsc,
        "program": name,
        "load at the start": f"{os.getloadavg()[0]:.1f}",
    }


def record(folder, facts):
    """Writes scenes.csv and machine.csv beside the rows of a study."""
    os.makedirs(folder, exist_ok=True)
    table(os.path.join(folder, "scenes.csv"), [s.record() for s in SCENES.values()])
    table(os.path.join(folder, "machine.csv"), [{"name": k, "value": v} for k, v in facts.items()])
