#!/usr/bin/env python3
"""Runs the studies of docs/paper.md, writes their tables as CSV, draws the figures, renews the tables of the text.

`make paper` calls this program. The tables stand in docs/paper.md between the lines <!-- table NAME --> and <!-- end -->.
"""
import argparse
import concurrent.futures
import csv
import itertools
import os
import re
import subprocess
import sys
import time

try:
    import h5py
    import matplotlib
except ModuleNotFoundError as missing:
    sys.exit(f"paper.py: {missing}; run it with .venv/bin/python, which `make run` makes")

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402 (after the choice of the backend)
import numpy as np  # noqa: E402

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
sys.path.insert(0, os.path.join(ROOT, "tools"))
import launch  # noqa: E402 (after the path)
from marks import markdown, renew  # noqa: E402

STYLE = {"font.size": 9, "axes.titlesize": 9, "axes.linewidth": 0.6, "xtick.major.width": 0.6, "ytick.major.width": 0.6,
         "legend.frameon": False, "savefig.dpi": 130, "mathtext.fontset": "cm", "lines.linewidth": 1.3, "lines.markersize": 4}
# name: options, label, colour, marker; legends and tables have the same sequence
METHODS = {
    "linear": ("-method_basis linear", "linear", "tab:red", "o"),
    "ugimp": ("-method_basis gimp -method_gimp_update none", "GIMP", "tab:olive", "v"),
    "cpgimp": ("-method_basis gimp -method_gimp_update stretch", "GIMP, stretched", "tab:green", "^"),
    "bspline2": ("-method_basis bspline2", "quadratic B-spline", "tab:blue", "s"),
    "bspline3": ("-method_basis bspline3", "cubic B-spline", "tab:purple", "D"),
    "bspline2_steffen": ("-method_basis bspline2 -method_wall_basis steffen", "quadratic, steffen walls", "tab:blue", "s"),
    "bspline3_steffen": ("-method_basis bspline3 -method_wall_basis steffen", "cubic, steffen walls", "tab:purple", "D"),
}
BASES = ["linear", "ugimp", "cpgimp", "bspline2", "bspline3"]
UPDATES = ["usf", "usl", "musl"]
CFL = 0.2  # c dt/h of all runs of bars
CELLS = [8, 16, 32, 64, 128, 256, 512]
SMALL, LARGE = 1e-3, 0.05  # amplitudes over the length of the bar
PLANE = {  # the block of options/mms.opts: name: words, options, bases
    "usf": ("usf, flip (the assignment)", "-method_update usf -method_transfer flip -dt_cfl 0.4", ["linear"]),
    "musl": ("musl, flip", "-method_update musl -method_transfer flip -dt_cfl 0.4", BASES),
    "usl": ("usl, aflip", "-method_update usl -method_transfer aflip -dt_cfl 0.3", BASES),
    "default": ("preset balanced (the default)", "-method_preset balanced -method_update usl -method_transfer aflip -method_affine_strain 1 -dt_cfl 0.8", ["bspline3"]),
}
PLANE_CELLS = [8, 16, 32, 64, 128, 256]  # along an edge
FAIL_BEFORE = 5  # of these grids are enough to show that most methods fail
TO_THE_END = {("usl", "cpgimp"), ("default", "bspline3")}
PER_CELL = [1, 2, 3, 4, 6, 8, 12, 16]

# A bar of unit length, stiffness and density between two walls: u = A sin(2 pi X) sin(pi t). With nu = 0 the neo-Hookean
# law in 1-D is P = (F - 1/F)/2, so the body force that keeps the bar on this path is b = u_tt - dP/dX:
#   u_tt = -pi^2 u,  dP/dX = (1 + 1/F^2)/2 u_XX,  u_XX = -4 pi^2 u   =>   b = pi^2 u (1 + 2/F^2)
BAR = """-dim 1
-grid_lower 0
-grid_upper 1
-grid_cells {n}
-bc_xmin_type fixed
-bc_xmax_type fixed
-materials unit
-material_unit_model neohookean
-material_unit_rho 1
-material_unit_E 1
-material_unit_nu 0
-bodies bar
-body_bar_shape box
-body_bar_lower 0
-body_bar_upper 1
-body_bar_ppc {r}
-body_bar_material unit
-body_bar_velocity "{A!r}*pi*sin(2*pi*x)"
-acceleration "{A!r}*pi^2*sin(2*pi*X)*sin(pi*t)*(1 + 2/(1 + 2*pi*{A!r}*cos(2*pi*X)*sin(pi*t))^2)"
-method_transfer flip
-time_end 1
-dt_size {dt!r}
-output_every 0.1
-output_fields {fields}
-history_every 1e9
"""
# The same bar, small strains, fixed at the left only, in its first mode: period 4. The tip moves 0.064 = 1.27 cells.
MODE = """-dim 1
-grid_lower 0
-grid_upper 1.2
-grid_cells 24
-bc_xmin_type fixed
-materials unit
-material_unit_model elastic
-material_unit_rho 1
-material_unit_E 1
-material_unit_nu 0
-bodies bar
-body_bar_shape box
-body_bar_lower 0
-body_bar_upper 1
-body_bar_ppc 2
-body_bar_material unit
-body_bar_velocity "0.1*sin(pi/2*x)"
-method_transfer flip
-time_end 80
-dt_size 0.01
-output_format none
-history_every 0.1
"""
PERIOD = 4


def exact(X, t, A):
    """Displacement and stress of the bar between walls; in 1-D the Cauchy stress is P."""
    u = A * np.sin(2 * np.pi * X) * np.sin(np.pi * t)
    F = 1 + 2 * np.pi * A * np.cos(2 * np.pi * X) * np.sin(np.pi * t)
    return u, (F - 1 / F) / 2


def check_body_force():
    """Checks b against u_tt - dP/dX by central differences, since no run is worth its time with a wrong formula."""
    rng, e, worst = np.random.default_rng(1), 1e-4, 0
    for A in SMALL, LARGE:
        X, t = rng.random(1000), rng.random(1000)
        u, F = exact(X, t, A)[0], 1 + 2 * np.pi * A * np.cos(2 * np.pi * X) * np.sin(np.pi * t)
        u_tt = (exact(X, t + e, A)[0] - 2 * u + exact(X, t - e, A)[0]) / e**2
        P_X = (exact(X + e, t, A)[1] - exact(X - e, t, A)[1]) / (2 * e)
        worst = max(worst, np.abs(np.pi**2 * u * (1 + 2 / F**2) - (u_tt - P_X)).max() / (np.pi**2 * A))
    if worst > 1e-5:
        sys.exit(f"paper.py: the body force is wrong by {worst:.1e}")
    print(f"body force against differences: {worst:.1e} (allowed 1e-5)")


def scene(name):
    """The text of a scene of options/."""
    with open(os.path.join(ROOT, "options", name + ".opts")) as file:
        return file.read()


class Runner:
    def __init__(self, pebble, tool, folder):
        self.pebble, self.tool, self.folder = pebble, tool, folder
        self.said = {}  # name of a run: what it printed
        self.pool = concurrent.futures.ThreadPoolExecutor(2)
        os.makedirs(os.path.join(folder, "runs"), exist_ok=True)

    def path(self, name):
        return os.path.join(self.folder, "runs", name)

    def quadrature(self, what):
        return list(csv.DictReader(launch.run([self.tool, what], check=True, stdout=subprocess.PIPE, text=True).stdout.splitlines()))

    def simulate(self, name, scene, options):
        """Runs a scene. True if it reached its end, False if the program stopped it (a particle left the grid, or its deformation inverted)."""
        with open(self.path(name + ".opts"), "w") as file:
            file.write(scene)
        command = [self.pebble, "-options_file", self.path(name + ".opts"), "-output_dir", self.path(""), *options.split()]
        result = launch.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if result.returncode not in (0, 3):
            sys.exit(f"{result.stdout}\npaper.py: exit status {result.returncode}: {' '.join(command)}")
        self.said[name] = result.stdout
        return result.returncode == 0

    def bar(self, update, A, r, method, n, fields="velocity", cfl=CFL):
        """Largest rms error of the displacement over the snapshots, relative to A; infinite if the run is stopped, no number if it
        is refused: a domain of a whole cell cannot stretch."""
        if method == "cpgimp" and r == 1:
            return np.nan
        name = f"bar_{update}_{method}_{A}_{r}_{n}_{cfl}"
        done = self.simulate(name, BAR.format(n=n, r=r, A=A, dt=cfl / n, fields=fields), f"{METHODS[method][0]} -method_update {update}")
        worst = 0
        with h5py.File(self.path(name + ".h5")) as file:
            X = file["step_000000/particles/x"][:, 0]
            for step in (file[k] for k in file if k.startswith("step_")):
                u = step["particles/x"][:, 0] - X
                worst = max(worst, np.sqrt(np.mean((u - exact(X, step.attrs["time"], A)[0])**2)) / A)
        return worst if done else np.inf

    def ladder(self, name, method):
        """Relative rms errors of the displacement at the end, {cells: error}, of the block of options/mms.opts on finer and finer
        grids, and whether the program says that they converge."""
        run, levels = f"plane_{name}_{method}", len(PLANE_CELLS) if (name, method) in TO_THE_END else FAIL_BEFORE
        with open(self.path(run + ".opts"), "w") as file:
            file.write(scene("mms"))
        told = launch.run([sys.executable, os.path.join(ROOT, "lab", "study.py"), "convergence", self.path(run + ".opts"), "--program", self.pebble, "--levels", levels,
                           *f"{METHODS[method][0]} {PLANE[name][1]} -grid_cells {PLANE_CELLS[0]},{PLANE_CELLS[0]} -output_format none -history_every 1 -check_parting warn".split(),
                           "-output_dir", self.path("")], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if told.returncode not in (0, 3):
            sys.exit(f"{told.stdout}\npaper.py: exit status {told.returncode}: {run}")
        with open(self.path(f"{run}_study.csv")) as file:
            errors = [float(row["relative"]) for row in csv.DictReader(file) if row["relative"]]
        errors += [np.inf] * (levels - len(errors))
        verdict = re.search(r"^verdict +(does not converge|converges)", told.stdout, re.M)
        return dict(zip(PLANE_CELLS, errors)), verdict[1] if verdict else "open"

    def mode(self, method, update):
        """Whether the run reached its end, its times, and the energy at these over that at the start."""
        name = f"mode_{method}_{update}"
        done = self.simulate(name, MODE, f"{METHODS[method][0]} -method_update {update}")
        line = np.genfromtxt(self.path(name + ".csv"), delimiter=",", names=True)
        return done, line["time"], line["total_energy"] / line["total_energy"][0]

    def disks(self, method, update, cfl):
        name = f"disks_{method}_{update}_{cfl}"
        done = self.simulate(name, scene("disks"), f"{METHODS[method][0]} -method_update {update} -dt_cfl {cfl} -check_energy 1e6 -check_momentum 1e6 -output_format none")
        line = np.genfromtxt(self.path(name + ".csv"), delimiter=",", names=True)
        return done, line["time"], line["total_energy"] / line["total_energy"][0]

    def map(self, function, keys):
        keys = list(keys)
        return dict(zip(keys, self.pool.map(lambda key: function(*key), keys)))

    def write(self, name, header, rows):
        with open(os.path.join(self.folder, name + ".csv"), "w", newline="") as file:
            csv.writer(file).writerows([header, *rows])


# ---- Text

def number(x):
    """A number with two digits: 0.018, 6.2e-4."""
    if not np.isfinite(x):
        return "refused" if np.isnan(x) else "stops"
    if x >= 0.995e-2:
        return f"{x:.2f}" if x >= 0.1 else f"{x:.3f}"
    digits, power = f"{x:.1e}".split("e")
    return f"{digits}e{int(power)}"


def slope(axes, x, y, order, text, dx=1.04, dy=1.0, align="left"):
    """Draws a thin line of the given order of convergence through (x[0], y), with its name at its end."""
    x = np.array(x, float)
    axes.plot(x, y * (x / x[0])**order, color="0.55", linewidth=0.8, linestyle=":", zorder=0)
    axes.text(x[-1] * dx, y * (x[-1] / x[0])**order * dy, text, color="0.4", fontsize=8, va="center", ha=align)


def ticks(axes, values, label):
    axes.set_xscale("log", base=2)
    axes.set_xticks(values, [str(v) for v in values])
    axes.minorticks_off()
    axes.set_xlabel(label)


def finish(figure, name):
    figure.savefig(os.path.join(ROOT, "docs", name))
    plt.close(figure)


# ---- 1. The internal force of a node

def quadrature(run):
    rows = run.quadrature("force")
    run.write("force", rows[0], [row.values() for row in rows])
    jumps, worst = run.quadrature("jumps"), run.quadrature("worst")
    run.write("jumps", jumps[0], [row.values() for row in jumps])
    ratios = sorted({float(row["r"]) for row in rows})
    force = {}
    for row in rows:
        force.setdefault((row["voxels"], row["basis"]), []).append(float(row["force"]))
    figure, panels = plt.subplots(1, 2, figsize=(7.6, 3.5), sharey=True, layout="constrained")
    for axes, voxels, title in zip(panels, ("equal", "mapped"), ("equal voxels", "voxels stretched by $F$ = 0.69 ... 1.31")):
        for method in BASES:
            y = force[voxels, method]
            if max(y) > 1e-12:
                _, label, colour, marker = METHODS[method]
                axes.loglog(ratios, y, color=colour, marker=marker, label=label)
        axes.set(title=title, xlabel="particles per cell $r = h/b$", xlim=(1.1, 75))
        axes.set_xticks([2, 4, 8, 16, 32], ["2", "4", "8", "16", "32"])
        axes.minorticks_off()
        for method, order, text in (("linear", -1, "$r^{-1}$"), ("bspline2", -2, "$r^{-2}$"), ("bspline3", -3, "$r^{-3}$")):
            slope(axes, [ratios[1], ratios[-1]], force["equal", method][1] * 1.5, order, text, dx=1.1)
    panels[0].set(ylabel=r"largest $|f_i|$ inside, over $\sigma \times$ area (exact: 0)", ylim=(1e-6, 3))
    panels[0].text(1.3, 2.2e-6, "GIMP, both forms: below 2e-14", fontsize=8, color=METHODS["cpgimp"][2])
    panels[1].text(1.3, 2.2e-6, "GIMP, stretched: below 2e-14", fontsize=8, color=METHODS["cpgimp"][2])
    panels[1].legend(loc="lower left", bbox_to_anchor=(0, 0.08), fontsize=8)
    finish(figure, "paper-quadrature.png")

    degree = {"linear": 1, "bspline2": 2, "bspline3": 3}
    law, lines = [], []
    for voxels in "equal", "mapped":
        for method in BASES:
            y = force[voxels, method]
            zero, last = max(y) < 1e-12, np.log(y[-2] / y[-1]) / np.log(ratios[-1] / ratios[-2])
            fit = f"{np.mean(np.array(y) * np.array(ratios)**degree[method]):#.3g}/r" + ("", "^2", "^3")[degree[method] - 1] if voxels == "equal" and method in degree else ""
            lines.append([voxels, METHODS[method][1], *("<2e-14" if zero else number(v) for v in y[1::2]), "exact" if zero else f"{last:.2f}", fit])
    table = markdown(["voxels", "basis", *(f"r = {r:g}" for r in ratios[1::2]), "last order", "fit"], lines)
    for method, k in degree.items():
        mine = [row for row in jumps if row["basis"] == method]
        sizes = [f"{float(row['jump']):g}" for row in mine if float(row["r"]) == ratios[1]]
        cut = [float(row["coefficient"]) for row in mine]
        most = max(float(row["coefficient"]) for row in worst if row["basis"] == method)
        differs = max(float(row["theory_differs"]) for row in rows if row["voxels"] == "equal" and row["basis"] == method)
        law.append([METHODS[method][1], k, ", ".join(sizes), f"{min(cut):.4f} ... {max(cut):.4f}", f"{float(mine[0]['theory']):.4f}",
                    f"{most:.3f}", f"{differs:.0e}"])
    return {"force": table, "jumps": markdown(
        ["basis", "k", "jumps of the k-th derivative, times h^k", "one cut voxel, measured", "theory 1/(2^k k!)",
         "all breaks, worst r", "forces minus theory"], law)}


# ---- 2. The bar between walls

def convergence(run):
    methods, ratios = list(METHODS), [2, 4]
    cases = {"small": ("musl", SMALL), "large": ("musl", LARGE), "usl": ("usl", LARGE)}
    error = run.map(run.bar, ((*case, r, method, n) for case, r, method, n in itertools.product(cases.values(), ratios, methods, CELLS)))
    run.write("convergence", ["update", "amplitude", "per_cell", "basis", "cells", "error"], [(*key, repr(float(e))) for key, e in error.items()])
    figure, panels = plt.subplots(3, 2, figsize=(7.6, 8.6), sharex=True, sharey=True, layout="constrained")
    for (i, (name, case)), (j, r) in itertools.product(enumerate(cases.items()), enumerate(ratios)):
        axes = panels[i, j]
        for method in methods:
            _, label, colour, marker = METHODS[method]
            steffen = "steffen" in method
            axes.loglog(CELLS, [error[*case, r, method, n] for n in CELLS], color=colour, marker=marker, label=label,
                        linestyle="--" if steffen else "-", markerfacecolor="white" if steffen else colour)
        axes.set_title(f"$A$ = {case[1]:g} m, {r} particles per cell, update {case[0]}")
        ticks(axes, CELLS, "cells per length of the bar" if i == len(cases) - 1 else "")
        slope(axes, [8, 64], 0.011, -2, "second order", dx=1.0, dy=0.6, align="right")
        if name == "small":
            slope(axes, [32, 128], 0.08, -1, "first order", dx=0.27, dy=6.5)
    for axes in panels[:, 0]:
        axes.set_ylabel("largest rms error of $u$, over $A$")
    panels[0, 0].set_ylim(1.5e-5, 2.5)
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, fontsize=8)
    finish(figure, "paper-convergence.png")
    tables = {}
    for name, (shown, bases) in {"small": ([2], methods), "usl": ([2, 4], BASES)}.items():
        lines = [[r, METHODS[method][1], *(number(error[*cases[name], r, method, n]) for n in CELLS)] for r, method in itertools.product(shown, bases)]
        tables[name] = markdown(["r", "basis", *(f"{n} cells" for n in CELLS)], lines)
    fine = [(update, LARGE, 4, method, 256) for method in BASES for update in ("musl", "usl")]
    halved = run.map(lambda *key: run.bar(*key, cfl=CFL / 2), fine)
    lines = [[METHODS[method][1], *(number(e) for key in fine if key[3] == method for e in (error[key], halved[key]))] for method in BASES]
    tables["halved"] = markdown(["256 cells, r = 4, A = 0.05 m", "musl, c dt/h = 0.2", "musl, 0.1", "usl, 0.2", "usl, 0.1"], lines)
    return tables


def per_cell(run):
    cases = [("musl", 64), ("musl", 128), ("usl", 128)]
    error = run.map(run.bar, ((update, LARGE, r, method, n) for (update, n), method, r in itertools.product(cases, BASES, PER_CELL)))
    run.write("per_cell", ["update", "amplitude", "per_cell", "basis", "cells", "error"], [(*key, repr(float(e))) for key, e in error.items()])
    figure, panels = plt.subplots(1, 3, figsize=(7.6, 3.5), sharey=True, layout="constrained")
    lines = []
    for axes, (update, n) in zip(panels, cases):
        for method in BASES:
            _, label, colour, marker = METHODS[method]
            e = [error[update, LARGE, r, method, n] for r in PER_CELL]
            axes.loglog(PER_CELL, e, color=colour, marker=marker, label=label)
            if (update, n) == ("usl", 128):
                lines.append([label, *map(number, e)])
        axes.set_title(f"$h$ = 1/{n} m, update {update}")
        ticks(axes, [1, 2, 4, 8, 16], "particles per cell $r$")
    panels[0].set_ylabel("largest rms error of $u$, over $A$")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=5, fontsize=8)
    finish(figure, "paper-ppc.png")
    return {"ppc": markdown(["basis", *(f"r = {r}" for r in PER_CELL)], lines)}


# ---- The block of options/mms.opts, in two dimensions

def plane(run):
    """Errors on finer and finer grids, and what the program's own study of convergence says of them."""
    found = run.map(run.ladder, ((name, method) for name, (_, _, bases) in PLANE.items() for method in bases))
    with open(os.path.join(ROOT, "docs", "data", "ladders.csv"), "w", newline="") as file:  # docs/report.md has some of them
        csv.writer(file, lineterminator="\n").writerows([["method", "basis", "cells", "error", "verdict"], *(
            (PLANE[key[0]][0], METHODS[key[1]][1], n, f"{e:.4g}", verdict) for key, (errors, verdict) in found.items() for n, e in errors.items())])
    lines = []
    for (name, method), (errors, verdict) in found.items():
        e = list(errors.values())
        lines.append([PLANE[name][0], METHODS[method][1], *map(number, e), *[""] * (len(PLANE_CELLS) - len(e)), verdict])
    return {"plane": markdown(["update, transfer", "basis", *(f"{n} cells" for n in PLANE_CELLS), "verdict"], lines)}


# ---- 3. Particles that cross cells

def stress(run, method, A, r, n, when):
    """The stress along the bar at a time, and its rms error over the largest stress."""
    run.bar("musl", A, r, method, n, "velocity,stress")
    with h5py.File(run.path(f"bar_musl_{method}_{A}_{r}_{n}_{CFL}.h5")) as file:
        X = file["step_000000/particles/x"][:, 0]
        step = min((file[k] for k in file if k.startswith("step_")), key=lambda s: abs(s.attrs["time"] - when))
        sigma, t = step["particles/stress"][:, 0], step.attrs["time"]
        x = step["particles/x"][:, 0]
    true = exact(X, t, A)[1]
    return x, sigma, X + exact(X, t, A)[0], true, np.sqrt(np.mean((sigma - true)**2)) / np.abs(true).max()


def crossing(run):
    modes = run.map(run.mode, itertools.product(BASES, UPDATES))
    steps = [0.4, 0.8]
    disks = run.map(run.disks, itertools.product(BASES, UPDATES, steps))
    n, when = 64, 0.5
    noise = run.map(lambda method, r: stress(run, method, LARGE, r, n, when), itertools.product(BASES, (2, 4)))
    shown, more = ({method: noise[method, r] for method in BASES} for r in (2, 4))
    rows = []
    for name, results in ("bar", modes), ("disks", disks):
        rows += [(name, *key[:2], key[2] if key[2:] else "", done, repr(float(t[-1])), repr(float(e[-1])), repr(float(e.max()))) for key, (done, t, e) in results.items()]
    run.write("crossing", ["scene", "basis", "update", "dt_cfl", "reached_end", "last_time", "energy", "largest_energy"], rows)
    run.write("stress", ["basis", "per_cell", "error"], [(m, k, repr(float(s[4]))) for k, table in ((2, shown), (4, more)) for m, s in table.items()])

    figure = plt.figure(figsize=(7.6, 5.6), layout="constrained")
    top, bottom = figure.subfigures(2, 1, height_ratios=[1, 1.05])
    panels = top.subplots(1, 3, sharey=True)
    for axes, method in zip(panels, ("linear", "ugimp", "bspline2")):
        x, sigma, place, true, _ = shown[method]
        axes.plot(place, true, color="0.2", linewidth=1, label="exact")
        axes.plot(x, sigma, ".", color=METHODS[method][2], markersize=2.5)
        axes.set(title=f"{METHODS[method][1]}, {n} cells, $r$ = 2", xlabel="$x$ [m]", xlim=(0, 1))
        axes.set_xticks([0, 0.25, 0.5, 0.75, 1], ["0", "", "0.5", "", "1"])
    panels[0].set_ylabel(r"stress $\sigma$ [Pa]")
    panels[0].legend(loc="upper center", fontsize=8)
    span = np.abs(shown["linear"][3]).max()
    panels[0].set_ylim(-2 * span, 2 * span)
    panels = bottom.subplots(1, 2, sharey=True)
    for axes, update in zip(panels, ("usf", "musl")):
        for method in BASES:
            done, t, e = modes[method, update]
            # the energy swings within each period, as v and F are held half a step apart: mean over a period
            window = round(PERIOD / 0.1)
            mean = np.convolve(e, np.ones(window) / window, "valid")
            periods = np.convolve(t, np.ones(window) / window, "valid") / PERIOD
            axes.plot(periods, mean, color=METHODS[method][2], label=METHODS[method][1],
                      linestyle="--" if method == "cpgimp" else "-", zorder=3 if method == "cpgimp" else 2)
            if not done:
                axes.plot(periods[-1], mean[-1], "x", color=METHODS[method][2], markersize=7)
        axes.set(title=f"vibrating bar, update {update}", xlabel="time [periods]", xlim=(0, 20), xticks=range(0, 21, 5))
    panels[0].set_ylabel("energy, over that at the start")
    panels[0].set_ylim(0.8, 1.3)
    handles, labels = panels[0].get_legend_handles_labels()
    bottom.legend(handles, labels, loc="outside lower center", ncols=5, fontsize=8)
    finish(figure, "paper-crossing.png")

    def result(outcome, unit):
        done, t, e = outcome
        return f"{e[-1]:.3f}" if done else f"stops at {t[-1] / unit[0]:.3g} {unit[1]} ({e[-1]:.2f})"
    return {
        "mode": markdown(["basis", *UPDATES], [[METHODS[m][1], *(result(modes[m, u], (PERIOD, "periods")) for u in UPDATES)] for m in BASES]),
        "disks": markdown(["basis", *(f"{u}, dt_cfl {c}" for c, u in itertools.product(steps, UPDATES))],
                          [[METHODS[m][1], *(result(disks[m, u, c], (1, "s")) for c, u in itertools.product(steps, UPDATES))] for m in BASES]),
        "stress": markdown(["basis", "r = 2", "r = 4"], [[METHODS[m][1], number(shown[m][4]), number(more[m][4])] for m in BASES])}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pebble", default=os.path.join(ROOT, "pebble"))
    parser.add_argument("--quadrature", default=os.path.join(ROOT, "build", "mpicc", "quadrature"), help="the tool of quadrature.c")
    parser.add_argument("--out", default=os.path.join(ROOT, "output", "paper"), help="folder of the runs and the CSV files")
    parser.add_argument("--only", choices=["quadrature", "convergence", "plane", "per_cell", "crossing"], help="one part alone")
    arguments = parser.parse_args()
    plt.rcParams.update(STYLE)
    start = time.monotonic()
    run, tables = Runner(os.path.abspath(arguments.pebble), os.path.abspath(arguments.quadrature), arguments.out), {}
    check_body_force()
    for study in quadrature, convergence, plane, per_cell, crossing:
        if arguments.only not in (None, study.__name__):
            continue
        tables |= study(run)
        print(f"{study.__name__}: {time.monotonic() - start:.0f} s", flush=True)
    path = os.path.join(ROOT, "docs", "paper.md")
    with open(path) as file:
        text = file.read()
    for name, table in tables.items():
        text = renew(text, name, table)
    with open(path, "w") as file:
        file.write(text)


if __name__ == "__main__":
    main()
