#!/usr/bin/env python3
"""Draws a run: six snapshots of the particles, spread over its time, and below them curves over time.

It reads FILE.h5 and the history beside it (FILE.csv). Particles are drawn as their domains, which deform with them (a fluid's: half
of the way to the neighbours that it had at the start); where these don't suit, --no-domains draws discs of the true size. They are
coloured by one quantity:

  stress        von Mises stress (1-D: the axial stress)
  pressure      minus the mean stress
  speed         magnitude of the velocity
  compression   determinant of F, current over initial volume
  displacement  distance from where the particle was in the first snapshot
  error         distance from where it is in the exact solution (-mms_type axis, vortex or ring, -reference_type shear)
  bands         eight bands of equal x at the start, to show how they deform
  body          which body a particle belongs to
  or any field of the file's particles (of a vector or tensor, its magnitude), or a component: stress_yy, v_x

A quantity that is only rounding, such as the stress of a body that flies freely, is drawn as a constant. The curves below are, a
panel for each word of --below:

  energy        kinetic and strain energy (default), with their total, or with the work of gravity and loads and what was lost
  velocity      of the centre of mass
  error         root mean square of the error (default where the colours show it)
  front         largest x that a particle reaches
  height        largest y, in 3-D z
  and with --history the columns of the history that it names: reaction_*,total_energy

--curves draws what is known of the scene into these panels and into the snapshots. The file is a table with the columns where,
style, label, x, y. Where: a word of --below, a column of the history, or t=TIME, a snapshot; style: line or points; x, y: time [s] and
value, or a place [m]. Lines with # before it may have the source, which is printed below the picture, and units:

  # source: Phil. Trans. R. Soc. A 244 (1952) 312
  # front: x in 0.054 s, y in 0.05715 m

Of the table of a convergence study, NAME_study.csv, it draws the error over what was refined instead, with a line of slope 2
beside it; of that of a work-precision study, NAME_workprecision.csv, the error over the time, a curve for each method, with
rings around the runs that no other beats in both; of that of a limit-load study, NAME_limit.csv, the factor and its bracket over
the size of the cells.
"""
import argparse
import collections
import csv
import fnmatch
import os
import re
import sys

import drawing
from drawing import GREY, STYLE, fail, np, plt, scale

BELOW = ("energy", "velocity", "error", "front", "height")


# ---- Reading

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


def columns_of(history, patterns):
    """The columns of the history that the patterns name, in its order."""
    if history is None:
        fail("--history: there is no history beside the file; name one by --csv")
    chosen = []
    for pattern in patterns.split(","):
        some = fnmatch.filter(history.dtype.names, pattern.strip())
        if not some:
            fail(f"--history {pattern}: no such column; there are: {' '.join(history.dtype.names)}")
        chosen += [name for name in some if name not in chosen]
    return chosen


def read_curves(path):
    """Known curves: dictionaries of where, style, label, x and y; and the lines that name their source."""
    units, sources, lines = {}, [], []
    try:
        with open(path, newline="", encoding="utf-8") as file:
            for line in file:
                if not line.startswith("#"):
                    lines.append(line)
                    continue
                unit = re.match(r"# *(\S+): x in (\S+) s, y in (\S+) \S+", line)
                if unit:
                    units[unit[1]] = float(unit[2]), float(unit[3])
                elif re.match("# *source:", line):
                    sources.append(line.split(":", 1)[1].strip())
        curves = collections.defaultdict(list)
        for row in csv.DictReader(lines):
            if row["style"] not in ("line", "points"):
                fail(f"{path}: style '{row['style']}'; choose line or points")
            factors = units.get(row["where"], (1, 1))
            curves[row["where"], row["style"], row["label"]].append((float(row["x"]) * factors[0], float(row["y"]) * factors[1]))
    except (OSError, ValueError) as error:
        fail(f"cannot read {path}: {error}")
    except (KeyError, TypeError):
        fail(f"{path}: its columns must be where, style, label, x, y")
    if not curves:
        fail(f"{path} has no curves")
    known = [{"where": where, "style": style, "label": label, "x": np.array(points)[:, 0], "y": np.array(points)[:, 1]}
             for (where, style, label), points in curves.items()]
    return {"curves": known, "sources": sources, "path": path, "drawn": set()}


# ---- Drawing

def draw_known(axes, known, where, x_factor, y_factor):
    """Draws the known curves of one place; whether there are any."""
    some = [curve for curve in known["curves"] if curve["where"] == where] if known else []
    for k, curve in enumerate(some):
        how = {"linestyle": ("--", ":", "-.")[k % 3], "linewidth": 1.1} if curve["style"] == "line" else \
            {"linestyle": "none", "marker": "os^D"[k % 4], "markersize": 4, "markerfacecolor": "none", "markeredgewidth": 0.9}
        axes.plot(curve["x"] * x_factor, curve["y"] * y_factor, color=("crimson", "0.35", "tab:green")[k % 3], zorder=4, label=curve["label"], **how)
        known["drawn"].add(where)
    return bool(some)


def loser_of(options):
    """What takes energy in the scene, in words; "" where the sum of energies says nothing about it."""
    def given(pattern):
        return {name: value for name, value in options.items() if re.fullmatch(pattern, name)}

    if options.get("mms_type", "none") != "none" or "acceleration" in options or {"moving", "piston"} & set(given("bc_.*_type").values()) or \
            {"moving", "free"} & set(given("body_.*_rigid").values()):
        return ""  # forces whose work the history's external_work has not
    models = set(given("material_.*_model").values())
    losers = {"friction": "druckerprager" in models or "friction" in given("bc_.*_type").values(),
              "plastic flow": "vonmises" in models,  # johnsoncook keeps most of it as heat
              "viscosity": any(value not in ("0", "0.0") for value in given("material_.*_viscosity").values()),
              "damping": any(value != "0" for value in given("method_damping_.*|.*damping_(time|kinetic).*").values())}
    return " and ".join(name for name, does in losers.items() if does) or "the method"


def energy_curves(run, history):
    """The curves of the energies: name, values, colour, style."""
    work = history["external_work"] if "external_work" in history.dtype.names else np.zeros(len(history))
    total, loser = history["total_energy"], loser_of(run["options"])
    kinetic, strain = (history[f"{name}_energy"] for name in ("kinetic", "strain"))
    heat = " and heat" if "johnsoncook" in [value for name, value in run["options"].items() if name.endswith("_model")] else ""
    curves = [("kinetic", kinetic, "tab:blue", "-"), ("strain" + heat, strain, "tab:orange", "-")]
    most = max(np.abs(values).max() for values in (kinetic, strain, total, work))
    pulled = bool(np.abs(work).max() > 1e-6 * most)
    if pulled:
        gravity = any(float(number) for number in run["options"].get("gravity", "0").split(",") if number.strip())
        name = "gravity" if gravity and "load_work" not in history.dtype.names else "gravity and loads" if gravity else "loads"
        curves.insert(0, (f"work of {name}", work, "0.15", "--"))
    if not loser or (loser == "the method" and not pulled):
        return [("total", total, "0.15", "-")] + curves
    lost = -history["energy_residual"] if "energy_residual" in history.dtype.names else total[0] + work - total
    return curves + [("lost by the method" if loser == "the method" else f"lost to {loser}, and by the method", lost, "tab:red", "-")]


# Units of the columns of the history by their names; the first pattern that fits counts.
UNITS = (("time|dt", "s"), (r"step|particles(_\w+)?|\w+_iterations|steps_cut|probe_\w+_(body|plastic_strain|error_indicator|F_..)", "1"),
         (r"probe_\w+_(stress_..|von_mises|pressure)|stress_\w+|von_mises_\w+", "Pa"), (r"probe_\w+_velocity_.|velocity_\w+", "m/s"), (r"probe_\w+_temperature", "K"),
         (r"probe_\w+_volume", "m³"), (r"(lost_)?mass(_\w+)?|probe_\w+_mass", "kg"), (r"probe_\w+_.|(center|lower|upper|front|back|pivot)_\w+", "m"),
         (r"angular_momentum_\w+", "kg m²/s"), (r"(lost_)?momentum_\w+", "kg m/s"), (r"reaction_\w+|force_unbalanced", "N"), (r"torque_\w+", "N m"),
         (r"angle_\w+", "rad"), (r"spin_\w+", "rad/s"), (r"\w*(energy|work|dissipation)(_\w+)?", "J"))


def unit_of(column):
    return next((unit for pattern, unit in UNITS if re.fullmatch(pattern, column)), "")


def draw_curves(axes, run, history, below, known):
    """Draws one kind of curves over time: a word of BELOW, or the columns of the history in a list."""
    second, title = run["second"], None
    times = np.array(run["series"]["time"]) if below in ("error", "front", "height") else history["time"]
    places = [below]
    if below in ("error", "front", "height"):
        values = np.array(run["series"][below])
        factor, unit = scale(np.nanmax(np.abs(values)), "m")
        name = {"error": "rms error", "front": "front: largest x", "height": f"height: largest {'xyz'[run['was_dim'] - 1]}"}[below]
        axes.plot(times * second, values * factor, "-" if known else ".-", color="0.15", linewidth=1.3, markersize=4, label="this run")
        label = f"{name} [{unit}]"
    elif below == "velocity":
        factor, label, title = 1, "velocity [m/s]", "centre of mass"
        for d, axis in enumerate("xyz"[:run["was_dim"]]):
            axes.plot(times * second, history[f"momentum_{axis}"] / history["mass"], linewidth=1.5, label=f"$v_{axis}$")
        axes.axhline(0, color="0.8", linewidth=0.6, zorder=0)
    elif below == "energy":
        curves = energy_curves(run, history)
        factor, unit = scale(max(np.abs(values).max() for _, values, _, _ in curves), "J")
        for name, values, colour, style in curves:
            axes.plot(times * second, values * factor, style, color=colour, linewidth=1.8 if name == "total" else 1.3,
                      label=name, marker="." if len(times) == 1 else None)
        label, title = f"energy [{unit}]", "energy"
    else:
        units = {unit_of(name) for name in below}
        mixed = len(units) > 1
        factor, unit = 1, "" if mixed else units.pop()
        if unit == "J":
            factor, unit = scale(max(np.abs(history[name]).max() for name in below), "J")
        for k, name in enumerate(below):
            axes.plot(times * second, history[name] * factor, color=f"C{k % 10}", linewidth=1.3,
                      label=name.replace("_", " ") + (f" [{unit_of(name)}]" if mixed else ""))
        label = " ".join([below[0].replace("_", " ")] * (len(below) == 1) + [f"[{unit}]"] * (not mixed)) or "value, in the unit of its name"
        places = below
    several = [draw_known(axes, known, place, second, factor) for place in places]
    axes.set(ylabel=label)
    if len(axes.lines) > 1 and not (below == "error" and not any(several)):
        axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), title=title, alignment="left", fontsize=8)
    for snapshot in run["snapshots"]:
        axes.axvline(snapshot["time"] * second, color="0.85", linewidth=0.7, zorder=0)
    end = max(times[-1], run["snapshots"][-1]["time"]) * second
    axes.set(xlabel=f"time [{run['seconds']}]", xlim=(0, end or 1))
    axes.margins(y=0.08)
    axes.spines[["top", "right"]].set_visible(False)


def layout_of(count, aspect):
    """Rows and columns of the snapshots: wide ones stacked, narrow ones side by side, so that the block is about 2 by 3."""
    def badness(columns):
        rows = -(-count // columns)
        return abs(np.log(rows * aspect / columns / 0.6)) + 0.5 * (rows * columns - count) / count
    columns = min(range(1, count + 1), key=badness)
    return -(-count // columns), columns


def draw(run, history, below, known, out):
    dim, count = run["dim"], len(run["snapshots"])
    aspect = drawing.aspect_of(run)
    rows, columns = layout_of(count, aspect)
    # Panels are as wide as the page allows, and as high as the box needs.
    width = min(7.4 / columns, 3.6 / aspect)
    height = width * aspect + 0.3
    low = 1.9 if below else 0
    page = max(columns * width, 5.5) + 1.3, 0.45 + rows * height + low * len(below) + (0.15 if known and known["sources"] else 0)
    figure = plt.figure(figsize=page, layout="constrained")
    figure.get_layout_engine().set(w_pad=0.05, h_pad=0.05, hspace=0.02, wspace=0.02)
    parts = figure.subfigures(2, 1, height_ratios=[rows * height, low * len(below)]) if below else [figure]
    panels = parts[0].subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
    colour, extend = drawing.colours(run)
    for k, axes in enumerate(panels):
        if k >= count:
            axes.set_visible(False)
            continue
        drawing.draw_snapshot(axes, run, run["snapshots"][k], colour)
        drawing.name_axes(axes, run, k + columns >= count, k % columns == 0, k == 0, 6 if columns < 3 else 4)
    draw_places(panels, run, known)
    if dim > 1 and run["label"] != "band":
        parts[0].colorbar(colour, ax=list(panels), label=run["label"], extend=extend, shrink=0.9, pad=0.02, aspect=30)
    if below:
        for axes, what in zip(parts[1].subplots(len(below), squeeze=False).ravel(), below):
            draw_curves(axes, run, history, what, known)
    figure.suptitle(drawing.title_of(run, page[0], 11), fontsize=11)
    if known:
        missing = {curve["where"] for curve in known["curves"]} - known["drawn"]
        if not known["drawn"]:
            fail(f"{known['path']} has curves for {' '.join(sorted(missing))}: draw one of these, by --below, --history or --times")
        if known["sources"]:
            figure.supxlabel("; ".join(known["sources"]), fontsize=7, color=GREY)
    save(figure, out)
    return colour


def draw_places(panels, run, known):
    """Known curves in snapshots: surfaces, profiles."""
    for where in dict.fromkeys(curve["where"] for curve in known["curves"]) if known else ():
        if where.startswith("t="):
            try:
                time = float(where[2:])
            except ValueError:
                fail(f"{known['path']}: where '{where}' has no time")
            if run["dim"] != 2:
                fail(f"{known['path']}: {where}: curves in snapshots need 2-D, or --slice")
            near = int(np.abs([snapshot["time"] - time for snapshot in run["snapshots"]]).argmin())
            if abs(run["snapshots"][near]["time"] - time) <= 0.02 * run["snapshots"][-1]["time"]:
                draw_known(panels[near], known, where, run["metre"], run["metre"])
                panels[near].legend(loc="upper right", fontsize=7)


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
    if rows and rows[0][:3] == ["step", "time", "dt"]:
        fail(f"{path} is a history: draw it by tools/plot.py {path.removesuffix('.csv')}.h5 --history COLUMN,...")
    if not rows or len(rows[0]) < 6 or rows[0][0] != "run" or rows[0][4:6] != ["error", "order"]:
        fail(f"{path} is not the table of a study: its columns are not run, h, particles, steps, error, order")
    try:
        rows[1:] = [row for row in rows[1:] if row[4:5] != [""]]  # the finest run has no error where it is the reference
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


LIMIT = ("grid", "h", "holds", "fails", "factor", "ends")


def read_limit(path):
    """The grids of the table of a limit-load study; None if the file is no such table."""
    try:
        with open(path, newline="", encoding="utf-8") as file:
            reader = csv.DictReader(file)
            if not set(LIMIT) <= set(reader.fieldnames or ()):
                return None
            rows = np.array([[float(row[name]) for name in ("h", "factor", "holds", "fails")] for row in reader]).reshape(-1, 4)
    except (OSError, ValueError, csv.Error) as error:
        fail(f"cannot read {path}: {error}")
    if not len(rows):
        fail(f"{path} has no grid: nothing to draw")
    return rows.T


def draw_limit(path, columns, out):
    """The factor over h, with what holds and what does not."""
    h, factor, holds, fails = columns
    figure, axes = plt.subplots(figsize=(4.6, 3.6), layout="constrained")
    axes.errorbar(h, factor, [factor - holds, fails - factor], fmt="o-", color="C0", markersize=4, linewidth=1.2, capsize=4, label="holds, does not hold", gid="factor")
    axes.set(xlabel="$h$ [m]", ylabel="factor", xticks=h, xticklabels=[f"{value:.3g}" for value in h], xlim=(0, 1.1 * h.max()))
    axes.margins(y=0.3)
    axes.grid(True, color="0.9", linewidth=0.5)
    axes.legend()
    figure.suptitle(os.path.basename(path).removesuffix("_limit.csv"), fontsize=11)
    save(figure, out)


def parser_of():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", metavar="FILE.h5", help="or NAME_study.csv, NAME_workprecision.csv, NAME_limit.csv")
    parser.add_argument("--csv", metavar="FILE.csv", help="history (default: beside FILE.h5, if it is there)")
    parser.add_argument("-o", "--out", metavar="FILE.png", help="picture (default: beside FILE.h5)")
    drawing.add_arguments(parser)
    parser.add_argument("--below", metavar="WORD,...", help="curves below (default: energy): energy, velocity, error, front, height, none")
    parser.add_argument("--history", metavar="COLUMN,...", help="these columns of the history below; * stands for anything")
    parser.add_argument("--curves", metavar="FILE.csv", help="what is known of the scene, drawn in")
    parser.add_argument("--small", action="store_true", help="a small file: half as sharp, 256 colours")
    return parser


def main():
    arguments = drawing.parse(parser_of(), sys.argv[1:])
    if arguments.file.endswith(".csv"):
        plt.rcParams.update(STYLE)
        out = arguments.out or arguments.file.removesuffix(".csv") + ".png"
        limit = read_limit(arguments.file)
        work = read_work(arguments.file) if limit is None else None
        if limit is not None:
            draw_limit(arguments.file, limit, out)
        else:
            draw_work(arguments.file, work, out) if work else draw_study(arguments.file, read_study(arguments.file), out)
        print(out)
        return
    default = "none" if arguments.history else "error" if arguments.field == "error" else "energy"
    below = [word for word in (arguments.below or default).split(",") if word != "none"]
    for word in below:
        if word not in BELOW:
            fail(f"--below {word}: choose of {', '.join(BELOW)}, none; columns of the history are drawn by --history")
    base = os.path.splitext(arguments.file)[0]
    view = drawing.view_of(arguments)
    known = read_curves(arguments.curves) if arguments.curves else None
    run = drawing.read_run(arguments.file, arguments.field, series=[word for word in below if word in ("error", "front", "height")], **view)
    history = read_history(arguments.csv or base + ".csv", arguments.csv is not None)
    if history is None:
        below = [word for word in below if word not in ("energy", "velocity")]
    if arguments.history:
        below.append(columns_of(history, arguments.history))
    plt.rcParams.update(STYLE | ({"savefig.dpi": 120} if arguments.small else {}))
    out = arguments.out or base + ".png"
    colour = draw(run, history, below, known, out)
    if arguments.small:
        drawing.few_colours(out, colour, run["dim"] == 3)
    print(f"{out}   {len(run['snapshots'])} snapshots")


if __name__ == "__main__":
    main()
