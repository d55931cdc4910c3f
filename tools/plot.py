#!/usr/bin/env python3
"""Draws a run: six snapshots of the particles, spread over its time, and its energies.

Reads FILE.h5 and the history beside it (FILE.csv). Particles have their true size and are coloured by one quantity:

  stress       von Mises stress (1-D: the axial stress)
  pressure     minus the mean stress
  speed        magnitude of the velocity
  compression  determinant of F, current over initial volume
  body         which body a particle belongs to
  or any field of the file's particles (of a vector or tensor, its magnitude)
"""
import argparse
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

PANELS = 6
STYLE = {"font.size": 9, "axes.titlesize": 9, "axes.linewidth": 0.6, "xtick.major.width": 0.6,
         "ytick.major.width": 0.6, "legend.frameon": False, "savefig.dpi": 200, "mathtext.fontset": "cm"}
GREY = "0.45"
# The view of 3-D runs: orthographic, from the front right and above. Rows: right and up on paper, towards the eye.
AZIMUTH, ELEVATION = np.radians(-58), np.radians(22)
VIEW = np.array([[-np.sin(AZIMUTH), np.cos(AZIMUTH), 0],
                 [-np.sin(ELEVATION) * np.cos(AZIMUTH), -np.sin(ELEVATION) * np.sin(AZIMUTH), np.cos(ELEVATION)],
                 [np.cos(ELEVATION) * np.cos(AZIMUTH), np.cos(ELEVATION) * np.sin(AZIMUTH), np.sin(ELEVATION)]])


def fail(message):
    sys.exit(f"plot.py: {message}")


def text(value):
    return value.decode() if isinstance(value, bytes) else str(value)


# ---- Reading

def quantity(particles, name, dim):
    """One number a particle, its label with unit, and whether its sign matters."""
    def read(field):
        if field not in particles:
            known = sorted({"stress", "pressure", "speed", "compression"} | set(particles))
            fail(f"no field '{name}' in {particles.file.filename}; choose one of: {' '.join(known)}")
        return particles[field][...], text(particles[field].attrs.get("units", "")).replace("m3", "m$^3$")

    if name == "stress":
        s, unit = read("stress")
        if dim == 1:
            return s[:, 0], f"axial stress [{unit}]", True
        xx, xy, xz, yy, yz, zz = s.T
        mises = np.sqrt(0.5 * ((xx - yy)**2 + (yy - zz)**2 + (zz - xx)**2) + 3 * (xy**2 + yz**2 + xz**2))
        return mises, f"von Mises stress [{unit}]", False
    if name == "pressure":
        s, unit = read("stress")
        return -(s[:, 0] + s[:, 3] + s[:, 5]) / 3, f"pressure [{unit}]", True
    if name == "speed":
        v, unit = read("v")
        return np.linalg.norm(v, axis=1), f"speed [{unit}]", False
    if name == "compression":
        return np.linalg.det(read("F")[0].reshape(-1, 3, 3)), "volume ratio det F", False
    values, unit = read(name)
    signed = values.ndim == 1 and bool((values < 0).any())
    values = values if values.ndim == 1 else np.linalg.norm(values, axis=1)
    return values, name + (f" [{unit}]" if unit not in ("", "1") else ""), signed


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
               "snapshots": []}
        for k in sorted(nearest):
            particles = file[names[k]]["particles"]
            values, run["label"], run["signed"] = quantity(particles, field, dim)
            run["snapshots"].append({"time": times[k], "x": particles["x"][...], "values": values,
                                     "size": particles["volume"][...]**(1 / dim)})
    if not len(run["snapshots"][0]["values"]):
        fail(f"{path} has no particles")
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
    """The 12 edges of the grid's box on paper, those behind the particles first, and how many these are."""
    corners = np.array(np.meshgrid(*zip(run["lower"], run["upper"]), indexing="ij")).reshape(3, -1).T
    behind = (corners @ VIEW[2]).argmin()
    edges = [(a, b) for a in range(8) for b in range(a) if a ^ b in (1, 2, 4)]
    edges.sort(key=lambda edge: behind not in edge)
    flat = corners @ VIEW[:2].T
    return [flat[list(edge)] for edge in edges], 3


def draw_axes_names(axes, run):
    """Names along the three edges at the front."""
    low, high = run["lower"], run["upper"]
    middle = (low + high) / 2
    places = {"x": (middle[0], low[1], low[2]), "y": (high[0], middle[1], low[2]), "z": (low[0], low[1], middle[2])}
    shifts = {"x": (-2, -8), "y": (5, -7), "z": (-6, 0)}
    for name, place in places.items():
        axes.annotate(f"${name}$", VIEW[:2] @ np.array(place), shifts[name], textcoords="offset points",
                      ha="center", va="center", color=GREY)


def draw_particles(axes, run, snapshot, colour):
    """Discs around the squares of the particles' area (3-D: in the cubes of their volume, a little larger), so that
    a continuous body looks like one."""
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
    margin = (0.04 if dim == 3 else 0.01) * (high - low).max()
    axes.set(xlim=(low[0] - margin, high[0] + margin), ylim=(low[1] - margin, high[1] + margin), aspect="equal")
    if dim == 3:
        axes.set_axis_off()
        draw_axes_names(axes, run)
    else:
        axes.add_patch(plt.Rectangle(low, *(high - low), fill=False, edgecolor=GREY, linewidth=0.6))
        for spine in axes.spines.values():
            spine.set_visible(False)


def draw_line(axes, run, snapshot, colour):
    """1-D: the quantity over x."""
    values = np.concatenate([other["values"] for other in run["snapshots"]])
    low, high = min(values.min(), 0), max(values.max(), 0)
    margin = 0.06 * (high - low) or 1
    axes.axhline(0, color="0.8", linewidth=0.6, zorder=0)
    axes.scatter(snapshot["x"][:, 0], snapshot["values"], s=9, c=colour.to_rgba(snapshot["values"]),
                 edgecolors="0.2", linewidths=0.2)
    axes.set(xlim=(run["lower"][0], run["upper"][0]), ylim=(low - margin, high + margin))


def draw_energies(axes, run, history):
    work = history["external_work"] if "external_work" in (history.dtype.names or ()) else 0 * history["time"]
    for name, style in {"total": ("0.15", "-"), "kinetic": ("tab:blue", "-"), "strain": ("tab:orange", "-")}.items():
        pulled = name == "total" and np.any(work != 0)
        axes.plot(history["time"], history[f"{name}_energy"] - (work if pulled else 0), style[1], color=style[0],
                  label="total - work of gravity" if pulled else name,
                  linewidth=1.8 if name == "total" else 1.3, marker="." if len(history) == 1 else None)
    for snapshot in run["snapshots"]:
        axes.axvline(snapshot["time"], color="0.85", linewidth=0.7, zorder=0)
    end = max(history["time"][-1], run["snapshots"][-1]["time"])
    axes.set(xlabel="time [s]", ylabel="energy [J]", xlim=(0, end or 1))
    axes.margins(y=0.08)
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), title="energy", alignment="left")
    axes.spines[["top", "right"]].set_visible(False)


def draw(run, history, out):
    dim, count = run["dim"], len(run["snapshots"])
    columns = min(count, 3)
    rows = -(-count // columns)
    # Panels as wide as the page allows, as high as the box needs.
    size = run["upper"][:2] - run["lower"][:2]
    if dim == 3:
        size = np.ptp(np.concatenate(box_edges(run)[0]), axis=0)
    aspect = 0.6 if dim == 1 else size[1] / size[0]
    width = min(3.1, 3.4 / aspect) if aspect > 0.25 else 4.2
    height = width * aspect + 0.35
    energies = 1.9 if history is not None else 0
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
        axes.set_title(f"$t = {snapshot['time']:.4g}$ s")
        if dim < 3 and k + columns >= count:
            axes.set_xlabel("$x$ [m]")
            axes.tick_params(labelbottom=True)
        if dim < 3 and k % columns == 0:
            axes.set_ylabel("$y$ [m]" if dim == 2 else run["label"])
    if dim > 1:
        parts[0].colorbar(colour, ax=list(panels), label=run["label"], extend=extend, shrink=0.9, pad=0.02, aspect=30)
    if energies:
        draw_energies(parts[1].subplots(), run, history)
    cells = " × ".join(str(n) for n in run["cells"])
    particles = f"{len(run['snapshots'][0]['x']):,} particles".replace(",", "\u2009")
    title = [run["title"], particles, cells and f"{cells} cells"]
    figure.suptitle(", ".join(part for part in title if part), fontsize=11)
    try:
        figure.savefig(out)
    except (OSError, ValueError) as error:
        fail(f"cannot write {out}: {error}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", metavar="FILE.h5")
    parser.add_argument("--csv", metavar="FILE.csv", help="history (default: beside FILE.h5, if it is there)")
    parser.add_argument("--out", metavar="FILE.png", help="picture (default: beside FILE.h5)")
    parser.add_argument("--field", default="stress", help="what the colours show (default: stress)")
    arguments = parser.parse_args()
    base = os.path.splitext(arguments.file)[0]
    run = read_run(arguments.file, arguments.field)
    history = read_history(arguments.csv or base + ".csv", arguments.csv is not None)
    plt.rcParams.update(STYLE)
    draw(run, history, arguments.out or base + ".png")


if __name__ == "__main__":
    main()
