#!/usr/bin/env python3
"""Draws a run: six snapshots of the particles, spread over its time, and below them curves over time.

It reads FILE.h5 and the history beside it (FILE.csv). Particles have their true size and are coloured by one quantity:

  stress        von Mises stress (1-D: the axial stress)
  pressure      minus the mean stress
  speed         magnitude of the velocity
  compression   determinant of F, current over initial volume
  displacement  distance from where the particle was in the first snapshot
  error         distance from where it is in the exact solution (-mms_type axis, vortex or ring, -reference_type shear)
  bands         eight bands of equal x at the start, to show how they deform
  body          which body a particle belongs to
  or any field of the file's particles (of a vector or tensor, its magnitude)

A quantity that is only rounding, such as the stress of a body that flies freely, is drawn as a constant. The curves below are:

  energy        kinetic, strain and total (default)
  velocity      of the centre of mass
  error         root mean square of the error (default where the colours show it)

Of the table of a convergence study, NAME_study.csv, it draws the error over what was refined instead, with a line of slope 2
beside it; of that of a work-precision study, NAME_workprecision.csv, the error over the time, a curve for each method, with
rings around the runs that no other beats in both.
"""
import argparse
import collections
import csv
import os
import sys

try:
    import h5py
    import matplotlib
except ModuleNotFoundError as missing:
    sys.exit(f"plot.py: {missing}; run it with .venv/bin/python, which `make run` makes")

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402 (after the choice of the backend)
import numpy as np  # noqa: E402
from matplotlib.cm import ScalarMappable  # noqa: E402
from matplotlib.collections import EllipseCollection, LineCollection  # noqa: E402
from matplotlib.colors import Normalize  # noqa: E402
from PIL import Image  # noqa: E402 (matplotlib needs it too)

PANELS = 6
STYLE = {"font.size": 9, "axes.titlesize": 9, "axes.linewidth": 0.6, "xtick.major.width": 0.6,
         "ytick.major.width": 0.6, "legend.frameon": False, "savefig.dpi": 200, "mathtext.fontset": "cm", "svg.fonttype": "none"}
GREY = "0.45"
# The view of 3-D runs: orthographic, from the front right and above. Its rows point to the right, up, and towards the eye.
AZIMUTH, ELEVATION = np.radians(-58), np.radians(22)
VIEW = np.array([[-np.sin(AZIMUTH), np.cos(AZIMUTH), 0],
                 [-np.sin(ELEVATION) * np.cos(AZIMUTH), -np.sin(ELEVATION) * np.sin(AZIMUTH), np.cos(ELEVATION)],
                 [np.cos(ELEVATION) * np.cos(AZIMUTH), np.cos(ELEVATION) * np.sin(AZIMUTH), np.sin(ELEVATION)]])


def fail(message):
    sys.exit(f"plot.py: {message}")


def text(value):
    return value.decode() if isinstance(value, bytes) else str(value)


def scale(largest, unit):
    """The factor to multiply by, and the unit with a prefix, so that the largest number lies between 0.1 and 1000."""
    steps = {"m": {1: "m", 1e3: "mm", 1e6: "µm"}, "s": {1: "s", 1e3: "ms", 1e6: "µs"},
             "Pa": {1e-9: "GPa", 1e-6: "MPa", 1e-3: "kPa", 1: "Pa"}, "J": {1e-6: "MJ", 1e-3: "kJ", 1: "J", 1e3: "mJ", 1e6: "µJ"}}
    for factor, name in sorted(steps.get(unit, {}).items()):
        if largest * factor >= (0.1 if unit in "ms" else 1):
            return factor, name
    return 1, unit


# ---- Exact solutions: displacements at time t of particles that started at X, as src/physics/reference.c has them

def exact(options, X, t):
    kind = options.get("mms_type", options.get("reference_type"))
    body = options.get("bodies", "")

    def numbers(name):
        return np.array([float(number) for number in options[name].split(",")])

    def of_body(name):
        return numbers(f"body_{body}_{name}")

    def material(name):
        return float(options[f"material_{options[f'body_{body}_material']}_{name}"])

    if kind not in ("axis", "vortex", "ring", "shear"):
        fail("no error: the scene has no -mms_type axis, vortex or ring, and no -reference_type shear")
    A = float(options.get("mms_amplitude", options.get("reference_amplitude")))
    dim, u = X.shape[1], np.zeros_like(X)
    if kind == "axis":
        lower, length = of_body("lower"), of_body("upper") - of_body("lower")
        turn = np.pi * np.sqrt(material("E") / material("rho")) / length[0] * t + 2 * np.pi * np.arange(dim) / dim
        return A * np.sin(2 * np.pi * (X - lower) / length) * np.sin(turn)
    if kind == "shear":
        lower, height = of_body("lower")[1], (of_body("upper") - of_body("lower"))[1]
        k = np.pi * int(options.get("reference_mode", 1)) / height
        omega = k * np.sqrt(material("E") / 2 / (1 + material("nu")) / material("rho"))
        u[:, 0] = A * np.sin(k * (X[:, 1] - lower)) * np.sin(omega * t)
        return u
    Y = X - of_body("center")
    R, ri, ro = np.linalg.norm(Y, axis=1), of_body("inner_radius")[0], of_body("radius")[0]
    if kind == "vortex":
        s = (2 * R - ri - ro) / (ro - ri)
        a = A * np.sin(np.pi * t / float(options.get("mms_period", 1))) * (1 - s * s)**2
        u[:, 0], u[:, 1] = Y[:, 0] * np.cos(a) - Y[:, 1] * np.sin(a), Y[:, 0] * np.sin(a) + Y[:, 1] * np.cos(a)
        return u - Y
    omega = np.pi * np.sqrt(material("E") / material("rho")) / (ri + ro)
    U = A * R * (-6 * ri * ro + R * (3 * (ri + ro) - 2 * R)) / (ro**2 * (ro - 3 * ri)) * np.sin(omega * t)
    return U[:, None] * Y / R[:, None]


# ---- Reading

def read_options(line):
    """The options of the run by name: a word that starts with a minus and a letter is a name, what follows is its value."""
    options, name = {}, None
    for word in line.split():
        if word.startswith("-") and word[1:2].isalpha():
            name = word[1:]
            options[name] = ""
        elif name:
            options[name] = f"{options[name]} {word}".strip()
    return options


def quantity(run, particles, name, time):
    """One number for each particle, its name, its unit, and whether its sign matters."""
    def read(field):
        if field not in particles:
            known = sorted({"stress", "pressure", "speed", "compression", "displacement", "error", "bands"} | set(particles))
            fail(f"no field '{name}' in {particles.file.filename}; choose one of: {' '.join(known)}")
        return particles[field][...], text(particles[field].attrs.get("units", ""))

    dim = run["dim"]
    if name == "stress":
        s, unit = read("stress")
        if dim == 1:
            return s[:, 0], "axial stress", unit, True
        xx, xy, xz, _, yy, yz, _, _, zz = s.T
        mises = np.sqrt(0.5 * ((xx - yy)**2 + (yy - zz)**2 + (zz - xx)**2) + 3 * (xy**2 + yz**2 + xz**2))
        return mises, "von Mises stress", unit, False
    if name == "pressure":
        s, unit = read("stress")
        return -(s[:, 0] + s[:, 4] + s[:, 8]) / 3, "pressure", unit, True
    if name == "speed":
        v, unit = read("v")
        return np.linalg.norm(v, axis=1), "speed", unit, False
    if name == "compression":
        return np.linalg.det(read("F")[0].reshape(-1, 3, 3)), "volume ratio det F", "1", False
    if name in ("displacement", "error", "bands"):
        x, ids = read("x")[0][:, :dim], read("id")[0]
        order = np.argsort(ids)
        if "start" not in run:
            run["start"] = x[order]
        if len(run["start"]) != len(x):
            fail(f"no {name}: the number of particles changes")
        was = np.empty_like(x)
        was[order] = run["start"]
        if name == "bands":
            low, high = run["start"][:, 0].min(), run["start"][:, 0].max()
            return np.floor(8 * (was[:, 0] - low) / (high - low) * (1 - 1e-9)) % 2, "band", "1", False
        u = x - was
        for d in range(dim):  # a particle that left through a periodic face has come in through the other
            if run["options"].get(f"bc_{'xyz'[d]}min_type") == "periodic":
                length = run["upper"][d] - run["lower"][d]
                u[:, d] -= length * np.round(u[:, d] / length)
        if name == "error":
            u -= exact(run["options"], was, time)
        return np.linalg.norm(u, axis=1), name, "m", False
    values, unit = read(name)
    signed = values.ndim == 1 and bool((values < 0).any())
    values = values if values.ndim == 1 else np.linalg.norm(values, axis=1)
    return values, name.replace("_", " "), unit, signed


def noise(run, name, time):
    """The value that a quantity must exceed to be more than rounding."""
    extent, options = (run["upper"] - run["lower"]).max(), run["options"]
    if name in ("stress", "pressure"):
        moduli = [float(value) for option, value in options.items()
                  if option.startswith("material_") and option.rsplit("_", 1)[1] in "EK"]
        return 1e-10 * max(moduli, default=0)
    if name in ("displacement", "error"):
        return 1e-13 * extent
    return 1e-10 * extent / time if name in ("speed", "v") and time > 0 else 1e-300


def read_run(path, field):
    """Title, dimension and box of the run, and the snapshots to draw."""
    try:
        file = h5py.File(path, "r")
    except OSError as error:
        fail(f"cannot read {path}: {'no such file' if not os.path.exists(path) else error}")
    with file:
        names = sorted((name for name in file if name.startswith("step_")), key=lambda name: int(name[5:]))
        if not names or not {"dim", "grid_lower", "grid_upper"} <= set(file.attrs):
            fail(f"{path} is not a file of pebble, or has no snapshots")
        times = np.array([file[name].attrs["time"] for name in names])
        nearest = {int(np.abs(times - t).argmin()) for t in np.linspace(times[0], times[-1], PANELS)}
        dim = int(file.attrs["dim"])
        run = {"title": text(file.attrs.get("title", "")) or text(file.attrs.get("scene", "")), "dim": dim,
               "lower": np.array(file.attrs["grid_lower"], float), "upper": np.array(file.attrs["grid_upper"], float),
               "cells": np.array(file.attrs["grid_cells"])[:dim] if "grid_cells" in file.attrs else [],
               "options": read_options(text(file.attrs.get("options", ""))), "snapshots": [], "error": []}
        run["noise"] = noise(run, field, times[-1])
        for k in range(len(names)):
            if k not in nearest and field != "error":
                continue
            particles = file[names[k]]["particles"]
            values, name, unit, run["signed"] = quantity(run, particles, field, times[k])
            if field == "error":
                run["error"].append((times[k], np.sqrt((values**2).mean())))
            if k in nearest:
                run["snapshots"].append({"time": times[k], "x": particles["x"][...], "values": values,
                                         "size": particles["volume"][...]**(1 / dim)})
    if not len(run["snapshots"][0]["values"]):
        fail(f"{path} has no particles")
    # All snapshots share the prefixes of units: of lengths by the box, of times by the last, of the quantity by its largest value.
    largest = np.percentile(np.abs(np.concatenate([snapshot["values"] for snapshot in run["snapshots"]])), 99.5)
    factor, unit = scale(largest, unit) if largest > run["noise"] else (1, unit)
    unit = unit.replace("m3", "m$^3$")
    run["label"] = name + (f" [{unit}]" if unit not in ("", "1") else "")
    run["noise"] *= factor
    length, run["length"] = scale(max(abs(run["lower"]).max(), abs(run["upper"]).max()), "m")
    run["second"], run["seconds"] = scale(times[-1], "s")
    run["lower"], run["upper"] = run["lower"] * length, run["upper"] * length
    for snapshot in run["snapshots"]:
        snapshot["values"] = snapshot["values"] * factor
        snapshot["x"], snapshot["size"] = snapshot["x"] * length, snapshot["size"] * length
    return run


def read_history(path, required):
    """The columns of the CSV file, or None where there is none and none was asked for."""
    if not required and not os.path.exists(path):
        return None
    try:
        history = np.atleast_1d(np.genfromtxt(path, delimiter=",", names=True))
    except (OSError, ValueError) as error:
        fail(f"cannot read {path}: {str(error).splitlines()[0]}")
    if not {"time", "kinetic_energy", "strain_energy", "total_energy"} <= set(history.dtype.names or ()):
        fail(f"{path} is not a history of pebble: no columns of time and energies")
    return history


# ---- Drawing

def colours(run):
    """One map of colours for all snapshots; a few extreme particles do not decide its range."""
    values = np.concatenate([snapshot["values"] for snapshot in run["snapshots"]])
    values = values[np.isfinite(values)]
    if not len(values):
        fail("the values to draw are not finite")
    middle = (values.max() + values.min()) / 2
    if np.ptp(values) <= max(2 * run["noise"], 1e-9 * abs(middle)):  # only rounding is left: one colour
        reach = abs(middle) if abs(middle) > run["noise"] else 1.0
        low = middle - reach if run["signed"] or middle > run["noise"] else 0
        return ScalarMappable(Normalize(low, low + 2 * reach), "coolwarm" if run["signed"] else "viridis"), "neither"
    low, high = np.percentile(values, [0.5, 99.5])
    if run["signed"]:
        high = max(abs(low), abs(high)) or 1.0
        low = -high
    elif low >= 0 and low < 0.5 * high:
        low = 0.0
    if high <= low:
        low, high = low - 0.5 * (low != 0), low + (abs(low) or 1.0)
    above, below = values.max() > high * (1 + 1e-9), values.min() < low - 1e-9 * abs(low)
    extend = {(0, 0): "neither", (1, 0): "max", (0, 1): "min", (1, 1): "both"}[int(above), int(below)]
    return ScalarMappable(Normalize(low, high), "coolwarm" if run["signed"] else "viridis"), extend


def box_edges(run):
    """The 12 edges of the grid's box on paper, those behind the particles first, and how many of them are behind."""
    corners = np.array(np.meshgrid(*zip(run["lower"], run["upper"]), indexing="ij")).reshape(3, -1).T
    behind = (corners @ VIEW[2]).argmin()
    edges = [(a, b) for a in range(8) for b in range(a) if a ^ b in (1, 2, 4)]
    edges.sort(key=lambda edge: behind not in edge)
    flat = corners @ VIEW[:2].T
    return [flat[list(edge)] for edge in edges], 3


def draw_axes_names(axes, run):
    """Writes names along the three edges at the front."""
    low, high = run["lower"], run["upper"]
    middle = (low + high) / 2
    places = {"x": (middle[0], low[1], low[2]), "y": (high[0], middle[1], low[2]), "z": (low[0], low[1], middle[2])}
    shifts = {"x": (-4, -9), "y": (7, -8), "z": (-13, 0)}
    for k, (name, place) in enumerate(places.items()):
        for value in (low[k], middle[k], high[k])[name == "y":]:  # y starts where x ends
            at = np.array(place)
            at[k] = value
            word = f"${name}$ [{run['length']}]" if value == middle[k] else f"{value:.4g}"
            axes.annotate(word, VIEW[:2] @ at, shifts[name], textcoords="offset points", ha="center", va="center",
                          color=GREY, fontsize=7, rotation=90 if name == "z" and value == middle[k] else 0)


def draw_particles(axes, run, snapshot, colour):
    """Draws each particle as the disc around the square of its area (in 3-D: a disc in the cube of its volume, a little larger), so that
    a continuous body looks continuous."""
    dim, x = run["dim"], snapshot["x"]
    size = (1.15 if dim == 3 else np.sqrt(2)) * snapshot["size"]
    order, faces = np.arange(len(x)), colour.to_rgba(snapshot["values"])
    if dim == 3:
        order = np.argsort(x @ VIEW[2], kind="stable")
        edges, back = box_edges(run)
        axes.add_collection(LineCollection(edges[:back], colors="0.75", linewidths=0.5, zorder=0))
        axes.add_collection(LineCollection(edges[back:], colors=GREY, linewidths=0.6, zorder=3))
        flat, limits = x @ VIEW[:2].T, np.concatenate(edges)
        depth = x @ VIEW[2]  # far particles a little paler
        fade = 0.35 * (depth.max() - depth) / max(np.ptp(depth), 1e-300)
        faces[:, :3] += (1 - faces[:, :3]) * fade[:, None]
    else:
        flat, limits = x[:, :2], np.array([run["lower"], run["upper"]])[:, :2]
    axes.add_collection(EllipseCollection(size[order], size[order], np.zeros(len(x)), units="xy", offsets=flat[order],
                                          offset_transform=axes.transData, facecolors=faces[order],
                                          edgecolors=(0, 0, 0, 0.25) if dim == 3 else "none",
                                          linewidths=0.15 if dim == 3 else 0))
    low, high = limits.min(0), limits.max(0)
    margin = (0.08 if dim == 3 else 0.01) * (high - low).max()
    axes.set(xlim=(low[0] - margin, high[0] + margin), ylim=(low[1] - margin, high[1] + margin), aspect="equal")
    if dim == 3:
        axes.set_axis_off()
        draw_axes_names(axes, run)
    else:
        axes.add_patch(plt.Rectangle(low, *(high - low), fill=False, edgecolor=GREY, linewidth=0.6))
        for spine in axes.spines.values():
            spine.set_visible(False)


def draw_line(axes, run, snapshot, colour):
    """Draws the quantity over x, in 1-D."""
    values = np.concatenate([other["values"] for other in run["snapshots"]])
    low, high = min(values.min(), 0), max(values.max(), 0)
    margin = 0.06 * (high - low) or 1
    axes.axhline(0, color="0.8", linewidth=0.6, zorder=0)
    axes.scatter(snapshot["x"][:, 0], snapshot["values"], s=9, c=colour.to_rgba(snapshot["values"]),
                 edgecolors="0.2", linewidths=0.2)
    axes.set(xlim=(run["lower"][0], run["upper"][0]), ylim=(low - margin, high + margin))


def draw_curves(axes, run, history, below):
    """Draws energies, the velocity of the centre of mass, or the error over time."""
    if below == "error":
        times, values = np.array(run["error"]).T
        factor, unit = scale(values.max(), "m")
        axes.plot(times * run["second"], values * factor, ".-", color="0.15", linewidth=1.3, markersize=4)
        axes.set(ylabel=f"rms error [{unit}]")
    elif below == "velocity":
        times = history["time"]
        for d in range(run["dim"]):
            axes.plot(times * run["second"], history[f"momentum_{'xyz'[d]}"] / history["mass"], linewidth=1.5, label=f"$v_{'xyz'[d]}$")
        axes.axhline(0, color="0.8", linewidth=0.6, zorder=0)
        axes.set(ylabel="velocity [m/s]")
        axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), title="centre of mass", alignment="left")
    else:
        times = history["time"]
        work = history["external_work"] if "external_work" in history.dtype.names else 0 * times
        curves = {"total": history["total_energy"], "kinetic": history["kinetic_energy"], "strain": history["strain_energy"]}
        pulled = bool(np.any(work != 0))
        curves["total"] = curves["total"] - work
        factor, unit = scale(max(np.abs(curve).max() for curve in curves.values()), "J")
        for name, colour in {"total": "0.15", "kinetic": "tab:blue", "strain": "tab:orange"}.items():
            axes.plot(times * run["second"], curves[name] * factor, color=colour, linewidth=1.8 if name == "total" else 1.3,
                      label="total - work of gravity" if name == "total" and pulled else name,
                      marker="." if len(times) == 1 else None)
        axes.set(ylabel=f"energy [{unit}]")
        axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), title="energy", alignment="left")
    for snapshot in run["snapshots"]:
        axes.axvline(snapshot["time"] * run["second"], color="0.85", linewidth=0.7, zorder=0)
    end = max(times[-1], run["snapshots"][-1]["time"]) * run["second"]
    axes.set(xlabel=f"time [{run['seconds']}]", xlim=(0, end or 1))
    axes.margins(y=0.08)
    axes.spines[["top", "right"]].set_visible(False)


def draw(run, history, below, out):
    dim, count = run["dim"], len(run["snapshots"])
    columns = min(count, 3)
    rows = -(-count // columns)
    # Panels are as wide as the page allows, and as high as the box needs.
    size = run["upper"][:2] - run["lower"][:2]
    if dim == 3:
        size = np.ptp(np.concatenate(box_edges(run)[0]), axis=0)
    aspect = 0.6 if dim == 1 else size[1] / size[0]
    width = min(3.1, 3.4 / aspect) if aspect > 0.25 else 4.2
    height = width * aspect + 0.35
    energies = 1.9 if history is not None or below == "error" else 0
    page = max(columns * width, 5.5) + 1.6, 0.45 + rows * height + energies
    figure = plt.figure(figsize=page, layout="constrained")
    figure.get_layout_engine().set(w_pad=0.05, h_pad=0.05, hspace=0.02, wspace=0.02)
    parts = figure.subfigures(2, 1, height_ratios=[rows * height, energies]) if energies else [figure]
    panels = parts[0].subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
    colour, extend = colours(run)
    for k, axes in enumerate(panels):
        if k >= count:
            axes.set_visible(False)
            continue
        snapshot = run["snapshots"][k]
        (draw_line if dim == 1 else draw_particles)(axes, run, snapshot, colour)
        axes.set_title(f"$t = {snapshot['time'] * run['second']:.4g}$ {run['seconds']}")
        if dim < 3 and k + columns >= count:
            axes.set_xlabel(f"$x$ [{run['length']}]")
            axes.tick_params(labelbottom=True)
        if dim < 3 and k % columns == 0:
            axes.set_ylabel(f"$y$ [{run['length']}]" if dim == 2 else run["label"])
    if dim > 1 and run["label"] != "band":
        parts[0].colorbar(colour, ax=list(panels), label=run["label"], extend=extend, shrink=0.9, pad=0.02, aspect=30)
    if energies:
        draw_curves(parts[1].subplots(), run, history, below)
    cells = " × ".join(str(n) for n in run["cells"])
    particles = f"{len(run['snapshots'][0]['x']):,} particles".replace(",", "\u2009")
    title = [run["title"], particles, cells and f"{cells} cells"]
    figure.suptitle(", ".join(part for part in title if part), fontsize=11)
    save(figure, out)


def save(figure, out):
    try:
        figure.savefig(out)
    except (OSError, ValueError) as error:
        fail(f"cannot write {out}: {error}")


# ---- Studies

def read_study(path):
    """What was refined, its sizes, the errors and the orders between runs; None if the file is not the table of a study."""
    try:
        with open(path, newline="", encoding="utf-8") as file:
            rows = list(csv.reader(file))
    except (OSError, ValueError, csv.Error) as error:
        fail(f"cannot read {path}: {error}")
    if not rows or len(rows[0]) < 6 or rows[0][0] != "run" or rows[0][4:6] != ["error", "order"]:
        fail(f"{path} is not the table of a study: its columns are not run, h, particles, steps, error, order")
    try:
        size, error = np.array([[float(row[1]), float(row[4])] for row in rows[1:]]).reshape(-1, 2).T
        order = [float(row[5]) if row[5] else None for row in rows[1:]]
    except (IndexError, ValueError) as wrong:
        fail(f"{path} has a line that is not of a study: {wrong}")
    if not len(size) or not (size > 0).all() or not (error > 0).all() or not np.isfinite(error).all():
        fail(f"{path} has no errors, or one that is 0 or not finite: no plot with logarithmic axes")
    return rows[0][1], size, error, order, "error" if "quantity" in rows[0] else "error [m]"


def draw_study(path, study, out):
    """Error over size, both logarithmic; the order stands between two runs."""
    what, size, error, order, label = study
    figure, axes = plt.subplots(figsize=(4.6, 3.6), layout="constrained")
    axes.loglog(size, error, "o-", color="C0", markersize=4, linewidth=1.2, label="error", gid="errors")
    guide = 0.5 * error[-1] * (size / size[-1])**2
    axes.loglog(size, guide, "--", color=GREY, linewidth=0.9, label="slope 2", gid="slope")
    for k in range(1, len(size)):
        if order[k] is not None:
            middle = np.sqrt(size[k] * size[k - 1]), np.sqrt(error[k] * error[k - 1])
            axes.annotate(f"{order[k]:.2f}", middle, (-3, 5), textcoords="offset points", ha="right", color="C0")
    axes.set(xlabel=f"${what}$ [m]" if what == "h" else f"${what}$ [s]" if what == "dt" else what, ylabel=label,
             xticks=size, xticklabels=[f"{value:.3g}" for value in size])
    axes.set_xticks([], minor=True)
    axes.grid(True, color="0.9", linewidth=0.5)
    axes.legend()
    figure.suptitle(os.path.basename(path).removesuffix("_study.csv"), fontsize=11)
    save(figure, out)


WORK = ("study", "basis", "gimp_update", "update", "transfer", "flip", "order", "strain", "rate", "ppc", "cells", "cfl", "h", "seconds_min", "error", "status", "front")


def read_work(path):
    """The runs of the table of a work-precision study that came to their end; None if the file is no such table."""
    try:
        with open(path, newline="", encoding="utf-8") as file:
            reader = csv.DictReader(file)
            if not set(WORK) <= set(reader.fieldnames or ()):
                return None
            rows = [row for row in reader if row["study"] == "run" and row["status"] == "ok" and row["error"]]
        for row in rows:
            row["time"], row["part"] = float(row["seconds_min"]), float(row["error"])
    except (OSError, ValueError, csv.Error) as error:
        fail(f"cannot read {path}: {error}")
    rows = [row for row in rows if row["time"] > 0 and row["part"] > 0 and np.isfinite(row["part"])]
    if not rows:
        fail(f"{path} has no run with an error: nothing to draw")
    return rows


def draw_work(path, rows, out):
    """Error over time, both logarithmic. Colours are bases, markers transfers, lines updates."""
    curves = collections.defaultdict(list)
    varies = [key for key in ("strain", "rate", "ppc", "cfl") if len({row[key] for row in rows}) > 1]
    for row in rows:
        basis = row["basis"] + (" stretch" if row["gimp_update"] == "stretch" else "")
        share = "" if row["flip"] in ("", "1") else f" {row['flip']}"
        transfer = row["transfer"] + share + (f" {row['order']}" if row["order"] else "")
        curves[basis, row["update"], transfer, *(f"{key} {row[key]}" for key in varies)].append(row)
    bases, updates, transfers = (list(dict.fromkeys(key[k] for key in curves)) for k in range(3))
    figure, axes = plt.subplots(figsize=(7.2, 4.4), layout="constrained")
    for key, runs in curves.items():
        runs.sort(key=lambda row: -float(row["h"]))
        axes.loglog([row["time"] for row in runs], [100 * row["part"] for row in runs], linewidth=0.9, markersize=3.5, label=" ".join(key),
                    color=f"C{bases.index(key[0]) % 10}", linestyle=("-", "--", ":", "-.")[updates.index(key[1]) % 4],
                    marker="os^Dvxp*"[transfers.index(key[2]) % 8], gid="curve " + " ".join(key))
    front = sorted((row for row in rows if row["front"] == "1"), key=lambda row: row["time"])
    axes.loglog([row["time"] for row in front], [100 * row["part"] for row in front], "o", markersize=8, markerfacecolor="none", color="black",
                markeredgewidth=0.8, label="no other is faster\nand as accurate", gid="front")
    axes.set(xlabel="time of the steps [s]", ylabel="error [% of the solution]")
    axes.grid(True, color="0.9", linewidth=0.5)
    axes.legend(loc="center left", bbox_to_anchor=(1, 0.5), fontsize=6)
    figure.suptitle(os.path.basename(path).removesuffix("_workprecision.csv"), fontsize=11)
    save(figure, out)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", metavar="FILE.h5", help="or NAME_study.csv, NAME_workprecision.csv")
    parser.add_argument("--csv", metavar="FILE.csv", help="history (default: beside FILE.h5, if it is there)")
    parser.add_argument("--out", metavar="FILE.png", help="picture (default: beside FILE.h5)")
    parser.add_argument("--field", default="stress", help="what the colours show (default: stress)")
    parser.add_argument("--below", choices=("energy", "velocity", "error"), help="curves below (default: energy)")
    parser.add_argument("--small", action="store_true", help="a small file: half as sharp, 256 colours")
    arguments = parser.parse_args()
    if arguments.file.endswith(".csv"):
        plt.rcParams.update(STYLE)
        out = arguments.out or arguments.file.removesuffix(".csv") + ".png"
        work = read_work(arguments.file)
        draw_work(arguments.file, work, out) if work else draw_study(arguments.file, read_study(arguments.file), out)
        return
    below = arguments.below or ("error" if arguments.field == "error" else "energy")
    if below == "error" and arguments.field != "error":
        fail("--below error needs --field error")
    base = os.path.splitext(arguments.file)[0]
    run = read_run(arguments.file, arguments.field)
    history = read_history(arguments.csv or base + ".csv", arguments.csv is not None)
    plt.rcParams.update(STYLE | ({"savefig.dpi": 105} if arguments.small else {}))
    out = arguments.out or base + ".png"
    draw(run, history, below, out)
    if arguments.small:
        with Image.open(out) as picture:
            small = picture.convert("RGB").quantize(256, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
        small.save(out, optimize=True)


if __name__ == "__main__":
    main()
