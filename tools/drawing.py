"""What tools/plot.py and tools/movie.py share: reading a run, and drawing its particles.

A picture is made of a run, a dictionary:

  title, dim, lower, upper, cells, options   of the file
  snapshots     of each that is drawn: time, round (the time as the title gives it), x, values, size and, where particles are
                drawn with their domains, domain: the sides of each particle's parallelogram or parallelepiped as columns;
                rigid: the corners of the faces of rigid bodies, [faces, dim, dim], of edges in 2-D, triangles in 3-D
  series        over all snapshots: time, front (largest x of the particles), height (largest y, in 3-D z), error
  label, signed, noise        of the quantity that the colours show
  length, second, seconds     units: name of that of lengths, factor and name of that of times
"""
import collections
import os
import re
import sys

if sys.prefix != sys.base_prefix:  # in .venv: there goes the list of fonts too, which would go to the user's home folder
    os.environ.setdefault("MPLCONFIGDIR", os.path.join(sys.prefix, "matplotlib"))
PROGRAM = os.path.basename(sys.argv[0])
try:
    import h5py
    import matplotlib
except ModuleNotFoundError as missing:
    FOLDER = os.path.dirname(os.path.realpath(__file__))
    sys.exit(f"{PROGRAM}: {missing}; " + (
        "run it with .venv/bin/python, which `make run` makes" if not os.path.exists(os.path.join(FOLDER, "..", "installed")) else
        "it needs the Python packages h5py, matplotlib and numpy: install Debian's python3-h5py and python3-matplotlib, or activate a "
        f"virtual environment and install those of {FOLDER}/requirements.txt with pip"))

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402 (after the choice of the backend)
import numpy as np  # noqa: E402
from matplotlib.cm import ScalarMappable  # noqa: E402
from matplotlib.collections import EllipseCollection, LineCollection, PolyCollection  # noqa: E402
from matplotlib.colors import ListedColormap, Normalize  # noqa: E402
from matplotlib.patches import PathPatch  # noqa: E402
from matplotlib.path import Path  # noqa: E402
from matplotlib.ticker import MaxNLocator  # noqa: E402
from PIL import Image  # noqa: E402 (matplotlib needs it too)

PANELS = 6
STYLE = {"font.size": 9, "axes.titlesize": 9, "axes.linewidth": 0.6, "xtick.major.width": 0.6,
         "ytick.major.width": 0.6, "legend.frameon": False, "savefig.dpi": 200, "mathtext.fontset": "cm", "svg.fonttype": "none"}
GREY = "0.45"
RIGID = "0.75"
# The view of 3-D runs: orthographic, from the front right and above. Its rows point to the right, up, and towards the eye.
AZIMUTH, ELEVATION = np.radians(-58), np.radians(22)
VIEW = np.array([[-np.sin(AZIMUTH), np.cos(AZIMUTH), 0],
                 [-np.sin(ELEVATION) * np.cos(AZIMUTH), -np.sin(ELEVATION) * np.sin(AZIMUTH), np.cos(ELEVATION)],
                 [np.cos(ELEVATION) * np.cos(AZIMUTH), np.cos(ELEVATION) * np.sin(AZIMUTH), np.sin(ELEVATION)]])
LIGHT = np.array([0.35, -0.5, 0.79])  # towards it: what looks up is brightest, what looks right darkest


def fail(message):
    sys.exit(f"{PROGRAM}: {message}")


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


def round_time(time, step, every=0):
    """The time that a snapshot stands for: a run writes at the first step after each multiple of -output_every. Otherwise the
    shortest decimal number within one step."""
    if every > 0 and abs(round(time / every) * every - time) <= step:
        return float(f"{round(time / every) * every:.6g}")
    for digits in range(1, 6):
        short = float(f"{time:.{digits}g}")
        if abs(short - time) <= step:
            return short
    return float(f"{time:.4g}")


# ---- Exact solutions: displacements at time t of particles that started at X, as src/known/reference.c has them

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
    if name == "von_mises":
        values, unit = read(name)
        return values, "von Mises stress", unit, False
    if name == "pressure":
        s, unit = read("stress" if "stress" in particles else name)
        return s if s.ndim == 1 else -(s[:, 0] + s[:, 4] + s[:, 8]) / 3, name, unit, True
    if name == "speed":
        v, unit = read("v")
        return np.linalg.norm(v, axis=1), "speed", unit, False
    if name == "compression":
        return np.linalg.det(read("F")[0].reshape(-1, 3, 3)), "volume ratio det F", "1", False
    if name in ("displacement", "error", "bands"):
        x, ids = read("x")[0][:, :dim], read("id")[0]
        was = start_of(run, ids)
        if was is None:
            fail(f"no {name}: there are particles that were not there at the start")
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
    field, _, part = name.rpartition("_")
    if name not in particles and field in particles and part in text(particles[field].attrs.get("components", "")).split():
        values, unit = read(field)
        at = text(particles[field].attrs["components"]).split().index(part)
        return values[:, at], f"{field.replace('_', ' ')} {part}", unit, True
    values, unit = read(name)
    signed = values.ndim == 1 and bool((values < 0).any())
    values = values if values.ndim == 1 else np.linalg.norm(values, axis=1)
    return values, name.replace("_", " "), unit, signed


def noise(run, name, time):
    """The value that a quantity must exceed to be more than rounding."""
    extent, options = (run["upper"] - run["lower"]).max(), run["options"]
    if name.startswith("stress") or name == "pressure":
        moduli = [float(value) for option, value in options.items()
                  if option.startswith("material_") and option.rsplit("_", 1)[1] in "EK"]
        return 1e-10 * max(moduli, default=0)
    if name in ("displacement", "error"):
        return 1e-13 * extent
    return 1e-10 * extent / time if (name == "speed" or name.split("_")[0] == "v") and time > 0 else 1e-300

def start_of(run, ids):
    """Where the particles were in the first snapshot; None if some were not there."""
    at = np.searchsorted(run["ids"], ids)
    if not len(run["ids"]) or not np.array_equal(run["ids"][np.minimum(at, len(run["ids"]) - 1)], ids):
        return None
    return run["start"][at]


# ---- Domains

def share_of_cell(run):
    """The volume of a particle at the start, by its spacing: a cell over the number of particles that most cells have."""
    cells = np.floor((run["start"] - run["lower"]) / run["h"]).astype(np.int64)
    counts = np.unique(cells, axis=0, return_counts=True)[1]
    return run["h"].prod() / (np.median(counts) if len(counts) else 1)


def is_round(run):
    """Is it of bodies of revolution, of which x is the radius?"""
    return run["options"].get("geometry", "") == "axisymmetric"


def volumes_of(run, particles):
    """The particles' volumes, of bodies of revolution the areas of their sections; where the file has none, those by their
    spacing at the start, and by F if the file has it."""
    if "volume" in particles:
        volume = particles["volume"][...]
        return volume / (2 * np.pi * np.maximum(particles["x"][:, 0], 1e-3 * run["h"][0])) if is_round(run) else volume
    volume = np.full(len(particles["x"]), share_of_cell(run))
    return volume * np.abs(np.linalg.det(particles["F"][...].reshape(-1, 3, 3))) if "F" in particles else volume


def sides_at_rest(run, particles):
    """Sides of each particle's box before it was deformed: in the proportions of a cell over the particles per cell."""
    dim, options = run["dim"], run["options"]
    bodies = [name.strip() for name in options.get("bodies", "").split(",")]
    shape = np.empty((len(bodies), dim))
    for k, body in enumerate(bodies):
        try:
            ppc = np.array([float(number) for number in options[f"body_{body}_ppc"].split(",")])
        except (KeyError, ValueError):
            ppc = np.ones(1)
        shape[k] = run["h"] / (ppc if len(ppc) in (1, dim) else 1)
    body = particles["body"][...].astype(int) if "body" in particles else np.zeros(len(particles["x"]), int)
    sides = shape[np.clip(body, 0, len(bodies) - 1)]
    volume = volumes_of(run, particles)
    if "F" in particles:
        F = particles["F"][...].reshape(-1, 3, 3)
        volume = volume / np.abs(np.linalg.det(F)) * (F[:, 2, 2] if is_round(run) and "volume" in particles else 1)
    return sides * (volume / sides.prod(axis=1))[:, None]**(1 / dim), body


def lattice_domains(was, x, sides):
    """Domains of particles that carry no shape (a fluid knows only its volume): half of the way to each neighbour that
    the particle had in the lattice at the start. Neighbours that went far away don't count."""
    dim = x.shape[1]
    domains = np.eye(dim) * sides[:, None, :]
    side = np.median(sides, axis=0)  # those at the surface of a body may be larger or smaller, and start beside their places
    whole = np.abs(sides / side - 1).max(1).argmin()
    place = np.round((was - was[whole]) / side).astype(np.int64)
    place -= place.min(0) - 1
    count = place.max(0) + 2
    if np.prod(count.astype(float)) > 1e8:
        return domains
    table = np.full(count, -1, np.int32)
    table[tuple(place.T)] = np.arange(len(x))
    for d in range(dim):
        way, found = np.zeros((len(x), dim)), np.zeros(len(x))
        for sign in (1, -1):
            to = place.copy()
            to[:, d] += sign
            other = table[tuple(to.T)]
            step = sign * (x[other] - x)
            near = (other >= 0) & (np.linalg.norm(step, axis=1) < 12 * sides[:, d])
            way[near] += step[near]
            found[near] += 1
        some = found > 0
        domains[some, :, d] = way[some] / found[some, None]
    return domains


def rounded(domains, most=3):
    """Domains of the same volumes that are at most so many times as long as they are wide: F of what has flowed far is a needle,
    which shows nothing of where the matter is."""
    left, sizes, right = np.linalg.svd(domains)
    sizes = np.maximum(sizes, 1e-300)
    mean = np.exp(np.log(sizes).mean(1, keepdims=True))
    power = np.minimum(1, np.log(most) / np.maximum(np.log(sizes[:, :1] / sizes[:, -1:]), 1e-300))
    return (left * (mean * (sizes / mean)**power)[:, None, :]) @ right


def flows(run, body):
    """Is the body of a soil, whose F says nothing of its shape once it has flowed?"""
    name = run["options"].get("bodies", "").split(",")[body].strip()
    return run["options"].get(f"material_{run['options'].get(f'body_{name}_material')}_model") == "druckerprager"


def domains_of(run, particles):
    """The sides of each particle's domain, as columns: F times its box at rest."""
    dim, x = run["dim"], particles["x"][:, :run["dim"]]
    sides, body = sides_at_rest(run, particles)
    if "F" not in particles:
        return np.eye(dim) * sides[:, None, :]
    F = particles["F"][...].reshape(-1, 3, 3)[:, :dim, :dim]
    domains, was = F * sides[:, None, :], start_of(run, particles["id"][...])
    for one in np.unique(body):
        at = body == one
        if was is not None and np.abs(F[at] - F[at, :1, :1] * np.eye(dim)).max() <= 1e-12 and np.abs(F[at, 0, 0] - 1).max() > 1e-12:
            domains[at] = lattice_domains(was[at], x[at], sides[at])
        if flows(run, one):
            domains[at] = rounded(domains[at], 3 * (sides[at].max(1) / sides[at].min(1)).max())
    return domains


# ---- Runs

def nearest_snapshots(times, wanted, count):
    """Of the snapshots' times those to draw: all (count None), those that were asked for, or some spread over the run."""
    if wanted is None:
        return list(range(len(times))) if count is None else \
            sorted({int(np.abs(times - t).argmin()) for t in np.linspace(times[0], times[-1], count)})
    for t in wanted:
        if not times[0] - 1e-12 <= t <= times[-1] * (1 + 1e-6):
            fail(f"--times {t:g}: the snapshots are from {times[0]:g} to {times[-1]:g} s")
    return sorted({int(np.abs(times - t).argmin()) for t in wanted})


def read_run(path, field, *, times=None, count=PANELS, domains=True, limits=None, cut=None, series=()):
    """The run, with the snapshots to draw: `times`, or `count` of them, or all. `limits`: by axis, lowest and highest
    place to draw. `cut`: axis and place of the plane in which a 3-D run is drawn. `series`: names of those wanted."""
    try:
        file = h5py.File(path, "r")
    except OSError as error:
        fail(f"cannot read {path}: {'no such file' if not os.path.exists(path) else error}")
    with file:
        names = sorted((name for name in file if name.startswith("step_")), key=lambda name: int(name[5:]))
        if not names or not {"dim", "grid_lower", "grid_upper"} <= set(file.attrs):
            fail(f"{path} is not a file of pebble, or has no snapshots")
        at = np.array([file[name].attrs["time"] for name in names])
        chosen = nearest_snapshots(at, times, count)
        dim = int(file.attrs["dim"])
        run = {"title": text(file.attrs.get("title", "")) or text(file.attrs.get("scene", "")), "dim": dim, "was_dim": dim, "axes": "xyz"[:dim],
               "lower": np.array(file.attrs["grid_lower"], float)[:dim], "upper": np.array(file.attrs["grid_upper"], float)[:dim],
               "cells": np.array(file.attrs["grid_cells"])[:dim] if "grid_cells" in file.attrs else [],
               "options": read_options(text(file.attrs.get("options", ""))), "snapshots": [],
               "series": collections.defaultdict(list)}
        run["h"] = (run["upper"] - run["lower"]) / (run["cells"] if len(run["cells"]) else 1)
        run["noise"] = noise(run, field, at[-1])
        first = file[names[0]]["particles"]
        run["ids"] = first["id"][...]
        order = np.argsort(run["ids"])
        run["ids"], run["start"] = run["ids"][order], first["x"][:, :dim][order]
        check_view(run, limits, cut, domains)
        for k, name in enumerate(names):
            if k not in chosen and not series:
                continue
            particles, step = file[name]["particles"], float(file[name].attrs.get("dt", 0))
            run["series"]["time"].append(at[k])
            for one in series:
                run["series"][one].append(of_snapshot(run, particles, one, at[k]))
            if k not in chosen:
                continue
            values, label, unit, signed = quantity(run, particles, field, at[k])
            run["signed"] = signed or run.get("signed", False)
            snapshot = {"time": at[k], "step": step, "x": particles["x"][:, :dim], "values": values,
                        "size": volumes_of(run, particles)**(1 / dim)}
            if domains and dim > 1:
                snapshot["domain"] = domains_of(run, particles)
            if "rigid" in file[name] and dim > 1:
                rigid = file[name]["rigid"]
                snapshot["rigid"] = rigid["x"][:, :dim][rigid["faces"][...]]
            run["snapshots"].append(snapshot)
    tell_far(times, run)
    look_at(run, limits, cut)
    if not sum(len(snapshot["values"]) for snapshot in run["snapshots"]):
        fail(f"{path} has no particles" + (" there" if limits or cut else ""))
    in_units(run, label, unit, at[-1])
    return run


def tell_far(wanted, run):
    """Says of which of the times that were asked for there is no snapshot."""
    for time in wanted or ():
        near = min(run["snapshots"], key=lambda snapshot: abs(snapshot["time"] - time))
        if abs(near["time"] - time) > max(near["step"], 1e-6 * time) * (1 + 1e-9):
            print(f"{PROGRAM}: --times {time:g}: the nearest snapshot is of {near['time']:.4g} s", file=sys.stderr)


def check_view(run, limits, cut, domains):
    for axis in limits or {}:
        low, high = limits[axis]
        if axis not in run["axes"]:
            fail(f"--{axis}lim: the run has only {' '.join(run['axes'])}")
        d = run["axes"].index(axis)
        if high <= run["lower"][d] or low >= run["upper"][d]:
            fail(f"--{axis}lim {low:g},{high:g}: nothing of the grid, which is from {run['lower'][d]:g} to {run['upper'][d]:g} m")
    if cut and run["dim"] < 3:
        fail("--slice is for runs in 3-D")
    if cut and not run["lower"]["xyz".index(cut[0])] <= cut[1] <= run["upper"]["xyz".index(cut[0])]:
        d = "xyz".index(cut[0])
        fail(f"--slice {cut[0]}={cut[1]:g} is outside of the grid, which is from {run['lower'][d]:g} to {run['upper'][d]:g} m")


def of_snapshot(run, particles, name, time):
    """One number of a snapshot: how far its particles reach, or the error."""
    if name == "error":
        mass = particles["mass"][...] if "mass" in particles else None
        return np.sqrt(np.average(quantity(run, particles, "error", time)[0]**2, weights=mass))
    axis = 0 if name == "front" else run["dim"] - 1
    x = particles["x"][:, axis]
    return (x + 0.5 * volumes_of(run, particles)**(1 / run["dim"])).max() if len(x) else np.nan


def look_at(run, limits, cut):
    """Restricts the run to what is looked at: a box, a plane."""
    for axis, (low, high) in (limits or {}).items():
        d = run["axes"].index(axis)
        run["lower"][d], run["upper"][d] = low, high
    keep_axes = [d for d in range(run["dim"]) if not cut or "xyz"[d] != cut[0]]
    for snapshot in run["snapshots"]:
        x, keep = snapshot["x"], np.ones(len(snapshot["x"]), bool)
        if limits and (run["dim"] == 3 or cut):
            keep &= ((x >= run["lower"]) & (x <= run["upper"])).all(axis=1)
        if cut:
            d = "xyz".index(cut[0])
            reach = np.abs(snapshot["domain"][:, d]).sum(axis=1) if "domain" in snapshot else snapshot["size"]
            away = np.abs(x[:, d] - cut[1])
            keep &= away <= 0.5 * reach * (1 + 1e-9)
            order = np.argsort(-away, kind="stable")  # the nearest particles last, on top
            keep = order[keep[order]]
        for name in ("x", "values", "size", "domain"):
            if name in snapshot:
                snapshot[name] = snapshot[name][keep]
        if cut and "rigid" in snapshot:
            snapshot["rigid"] = cut_triangles(snapshot["rigid"], "xyz".index(cut[0]), cut[1])[:, :, keep_axes]
        if cut:
            snapshot["x"] = snapshot["x"][:, keep_axes]
            if "domain" in snapshot:
                snapshot["domain"] = snapshot["domain"][:, keep_axes][:, :, keep_axes]
    if cut:
        run["lower"], run["upper"], run["dim"] = run["lower"][keep_axes], run["upper"][keep_axes], 2
        run["axes"] = "".join("xyz"[d] for d in keep_axes)
        run["title"] += f", ${cut[0]}$ = {cut[1]:g} m"


def cut_triangles(triangles, d, place):
    """The edges in which a plane cuts triangles, [edges, 2, 3]. Of two triangles with a common edge both have the same place
    there, to the last bit."""
    above = triangles[:, :, d] > place
    found = []
    for k in range(3):  # the corner that is alone on its side, and the two others
        alone = (above[:, k] != above[:, (k + 1) % 3]) & (above[:, k] != above[:, (k + 2) % 3])
        a, ends = triangles[alone, k], []
        for other in (triangles[alone, (k + 1) % 3], triangles[alone, (k + 2) % 3]):
            swap = (a[:, d] > other[:, d])[:, None]
            low, high = np.where(swap, other, a), np.where(swap, a, other)
            ends.append(low + ((place - low[:, d]) / (high[:, d] - low[:, d]))[:, None] * (high - low))
        found.append(np.stack(ends, axis=1))
    return np.concatenate(found)


def loops_of(edges):
    """Closed edges [edges, 2, 2], whose common ends have the same bits, as a list of loops [points, 2]."""
    ends = collections.defaultdict(list)
    names = [[tuple(end) for end in edge] for edge in edges.tolist()]
    names = [edge for edge in names if edge[0] != edge[1]]
    for k, edge in enumerate(names):
        for end in edge:
            ends[end].append(k)
    left, loops = set(range(len(names))), []
    while left:
        k = min(left)
        left.discard(k)
        loop = list(names[k])
        while loop[-1] != loop[0]:
            k = next((k for k in ends[loop[-1]] if k in left), None)
            if k is None:
                break
            left.discard(k)
            loop.append(names[k][1] if names[k][0] == loop[-1] else names[k][0])
        loops.append(np.array(loop))
    return loops


def in_units(run, name, unit, end):
    """All snapshots share the prefixes of units: of lengths by the box, of times by the last, of the quantity by its largest value."""
    largest = np.percentile(np.abs(np.concatenate([snapshot["values"] for snapshot in run["snapshots"]])), 99.5)
    factor, unit = scale(largest, unit) if largest > run["noise"] else (1, unit)
    unit = unit.replace("m3", "m$^3$")
    run["label"] = name + (f" [{unit}]" if unit not in ("", "1") else "")
    run["noise"] *= factor
    length, run["length"] = scale(max(abs(run["lower"]).max(), abs(run["upper"]).max()), "m")
    run["metre"] = length
    run["second"], run["seconds"] = scale(end, "s")
    run["lower"], run["upper"] = run["lower"] * length, run["upper"] * length
    try:
        every = float(run["options"].get("output_every", 0))
    except ValueError:
        every = 0
    for snapshot in run["snapshots"]:
        snapshot["round"] = round_time(*(run["second"] * one for one in (snapshot["time"], snapshot["step"], every)))
        snapshot["values"] = snapshot["values"] * factor
        for name in ("x", "size", "domain", "rigid"):
            if name in snapshot:
                snapshot[name] = snapshot[name] * length


# ---- Drawing

def colours(run):
    """One map of colours for all snapshots; a few extreme particles do not decide its range."""
    values = np.concatenate([snapshot["values"] for snapshot in run["snapshots"]])
    values = values[np.isfinite(values)]
    if not len(values):
        fail("the values to draw are not finite")
    map_ = matplotlib.colormaps["coolwarm" if run["signed"] else "viridis"]
    if run["dim"] == 3:  # paler, so that light and shade show
        map_ = ListedColormap(0.25 + 0.75 * map_(np.linspace(0, 1, 256))[:, :3])
    map_ = map_.with_extremes(bad="0.85")  # particles that have no such value
    middle = (values.max() + values.min()) / 2
    if np.ptp(values) <= max(2 * run["noise"], 1e-9 * abs(middle)):  # only rounding is left: one colour
        reach = abs(middle) if abs(middle) > run["noise"] else 1.0
        low = middle - reach if run["signed"] or middle > run["noise"] else 0
        return ScalarMappable(Normalize(low, low + 2 * reach), map_), "neither"
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
    return ScalarMappable(Normalize(low, high), map_), extend


def box_edges(run):
    """The 12 edges of the grid's box on paper, those behind the particles first, and how many of them are behind."""
    corners = np.array(np.meshgrid(*zip(run["lower"], run["upper"]), indexing="ij")).reshape(3, -1).T
    behind = (corners @ VIEW[2]).argmin()
    edges = [(a, b) for a in range(8) for b in range(a) if a ^ b in (1, 2, 4)]
    edges.sort(key=lambda edge: behind not in edge)
    flat = corners @ VIEW[:2].T
    return [flat[list(edge)] for edge in edges], 3


def draw_axes_names(axes, run):
    """Writes names at the ends of the three edges at the front; the title has the lengths."""
    low, high = run["lower"], run["upper"]
    ends = {"x": ((high[0], low[1], low[2]), (0, -7)), "y": ((high[0], high[1], low[2]), (6, -4)), "z": ((low[0], low[1], high[2]), (-4, 5))}
    for name, (end, shift) in ends.items():
        axes.annotate(f"${name}$", VIEW[:2] @ np.array(end), shift, textcoords="offset points", ha="center", va="center",
                      color=GREY, fontsize=9).set_in_layout(False)


def visible(flat, depth, size):
    """Which particles in 3-D aren't hidden: behind none of the pixels of a particle's place is one that is much nearer."""
    pixel = size.mean() / 3
    at = ((flat - flat.min(0)) / pixel).astype(np.int64) + 2
    nearest = np.full(at.max(0) + 3, -np.inf)
    shifts = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)]
    for i, j in shifts:  # a particle covers at least three pixels by three
        np.maximum.at(nearest, (at[:, 0] + i, at[:, 1] + j), depth)
    seen = np.zeros(len(flat), bool)
    for i, j in shifts:
        seen |= depth > nearest[at[:, 0] + i, at[:, 1] + j] - 3 * size.max()
    return seen


def draw_solids(axes, x, domain, faces):
    """Draws the faces of parallelepipeds that look towards the eye, from far to near, brighter where they face the light."""
    order = np.argsort(x @ VIEW[2], kind="stable")
    x, domain, faces = x[order], domain[order], faces[order]
    corners, colours_, depths = [], [], []
    for k in range(3):
        a, b, c = domain[:, :, k], domain[:, :, (k + 1) % 3], domain[:, :, (k + 2) % 3]
        normal = np.cross(b, c)
        normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
        normal *= np.where(normal @ VIEW[2] < 0, -1, 1)[:, None]
        outward = np.where((a * normal).sum(1) < 0, -1, 1)[:, None]
        middle = x + 0.5 * outward * a
        corners.append(np.stack([middle + 0.5 * (p * b + q * c) for p, q in ((1, 1), (1, -1), (-1, -1), (-1, 1))], axis=1) @ VIEW[:2].T)
        shade = 0.62 + 0.38 * np.clip(normal @ LIGHT, 0, 1)
        shaded = faces.copy()
        shaded[:, :3] *= shade[:, None]
        colours_.append(shaded)
        depths.append(middle @ VIEW[2])
    first = np.argsort(np.stack(depths, axis=1), axis=1, kind="stable")  # of each particle the far faces first
    rows = np.arange(len(x))[:, None]
    polygons = np.stack(corners, axis=1)[rows, first].reshape(-1, 4, 2)
    shaded = np.stack(colours_, axis=1)[rows, first].reshape(-1, 4)
    axes.add_collection(PolyCollection(polygons, facecolors=shaded, edgecolors=shaded * [0.9, 0.9, 0.9, 1], linewidths=0.2))


def draw_rigid(axes, run, snapshot):
    """Draws rigid bodies: filled in 2-D, where a hole is what an even number of loops encloses; in 3-D as if of glass."""
    faces = snapshot["rigid"]
    if not len(faces):
        return
    if run["dim"] == 2:
        path = Path.make_compound_path(*(Path(np.concatenate([loop, loop[:1]]), closed=True) for loop in loops_of(faces)))
        axes.add_patch(PathPatch(path, facecolor=RIGID, edgecolor=GREY, linewidth=0.5, zorder=0.5))
        return
    normal = np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    shade = 0.35 + 0.4 * np.abs(normal @ LIGHT)
    order = np.argsort(faces.mean(1) @ VIEW[2], kind="stable")
    colours_ = np.concatenate([np.repeat(shade[order, None], 3, axis=1), np.full((len(faces), 1), 0.35)], axis=1)
    axes.add_collection(PolyCollection((faces @ VIEW[:2].T)[order], facecolors=colours_, edgecolors="none", zorder=2))


def draw_particles(axes, run, snapshot, colour):
    """Draws the domain of each particle, or the disc around the square of its area (in 3-D: a disc in the cube of its volume,
    a little larger), so that a continuous body looks continuous."""
    dim, x, domain = run["dim"], snapshot["x"], snapshot.get("domain")
    size = (1.15 if dim == 3 else np.sqrt(2)) * snapshot["size"]
    faces = colour.to_rgba(snapshot["values"])
    flat, limits = x[:, :2], np.array([run["lower"], run["upper"]])[:, :2]
    if dim == 3:
        edges, back = box_edges(run)
        axes.add_collection(LineCollection(edges[:back], colors="0.75", linewidths=0.5, zorder=0))
        axes.add_collection(LineCollection(edges[back:], colors=GREY, linewidths=0.6, zorder=3))
        flat, limits = x @ VIEW[:2].T, np.concatenate(edges)
        depth = x @ VIEW[2]
        if len(x):
            seen = visible(flat, depth, snapshot["size"])
            x, flat, depth, size, faces = x[seen], flat[seen], depth[seen], size[seen], faces[seen]
            domain = None if domain is None else domain[seen]
    if domain is not None and dim == 3:
        draw_solids(axes, x, domain, faces)
    elif domain is not None:
        a, b = 0.5 * domain[:, :, 0], 0.5 * domain[:, :, 1]
        corners = flat[:, None] + np.stack([a + b, a - b, -a - b, b - a], axis=1)
        axes.add_collection(PolyCollection(corners, facecolors=faces, edgecolors=faces, linewidths=0.5))
    else:
        order = np.arange(len(x))
        if dim == 3 and len(x):
            order = np.argsort(depth, kind="stable")
            fade = 0.35 * (depth.max() - depth) / max(np.ptp(depth), 1e-300)  # far particles a little paler
            faces[:, :3] += (1 - faces[:, :3]) * fade[:, None]
        axes.add_collection(EllipseCollection(size[order], size[order], np.zeros(len(x)), units="xy", offsets=flat[order],
                                              offset_transform=axes.transData, facecolors=faces[order],
                                              edgecolors=(0, 0, 0, 0.25) if dim == 3 else "none",
                                              linewidths=0.15 if dim == 3 else 0))
    if "rigid" in snapshot:
        draw_rigid(axes, run, snapshot)
    low, high = limits.min(0), limits.max(0)
    margin = (0.08 if dim == 3 else 0.01) * (high - low).max()
    axes.set(xlim=(low[0] - margin, high[0] + margin), ylim=(low[1] - margin, high[1] + margin), aspect="equal")
    if dim == 3:
        axes.set_axis_off()
    else:
        axes.add_patch(plt.Rectangle(low, *(high - low), fill=False, edgecolor=GREY, linewidth=0.6))
        for spine in axes.spines.values():
            spine.set_visible(False)


def draw_line(axes, run, snapshot, colour):
    """Draws the quantity over x, in 1-D."""
    values = np.concatenate([other["values"] for other in run["snapshots"]])
    low, high = min(np.nanmin(values), 0), max(np.nanmax(values), 0)
    margin = 0.06 * (high - low) or 1
    axes.axhline(0, color="0.8", linewidth=0.6, zorder=0)
    axes.scatter(snapshot["x"][:, 0], snapshot["values"], s=9, c=colour.to_rgba(snapshot["values"]),
                 edgecolors="0.2", linewidths=0.2)
    axes.set(xlim=(run["lower"][0], run["upper"][0]), ylim=(low - margin, high + margin))

def draw_snapshot(axes, run, snapshot, colour):
    (draw_line if run["dim"] == 1 else draw_particles)(axes, run, snapshot, colour)
    axes.set_title(f"t = {snapshot['round']:.10g} {run['seconds']}")


def name_axes(axes, run, x=True, y=True, first=True, ticks=6):
    """Names the axes of a panel: x of those below which there is no other, y of those on the left; in 3-D of the first."""
    if run["dim"] == 3 and first:
        draw_axes_names(axes, run)
    if run["dim"] < 3:
        axes.xaxis.set_major_locator(MaxNLocator(ticks, steps=[1, 2, 5, 10]))
        axes.yaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    if run["dim"] < 3 and x:
        axes.set_xlabel(f"${'r' if is_round(run) else run['axes'][0]}$ [{run['length']}]")
        axes.tick_params(labelbottom=True)
    if run["dim"] < 3 and y:
        axes.set_ylabel(f"${'z' if is_round(run) else run['axes'][1]}$ [{run['length']}]" if run["dim"] == 2 else run["label"])


def aspect_of(run):
    """Height over width of what is drawn."""
    size = run["upper"][:2] - run["lower"][:2]
    if run["dim"] == 3:
        size = np.ptp(np.concatenate(box_edges(run)[0]), axis=0)
    return 0.65 if run["dim"] == 1 else size[1] / size[0]


def title_of(run, width, size):
    """What the run is, in lines for a page of this width in inches and letters of this size."""
    cells = " × ".join(str(n) for n in run["cells"])
    most = max(len(snapshot["values"]) for snapshot in run["snapshots"])
    particles = f"{most:,} particles".replace(",", "\u2009")
    box = " × ".join(f"{length:.4g}" for length in run["upper"] - run["lower"]) + f" {run['length']}" if run["dim"] == 3 else ""
    lines = [""]
    for part in filter(None, (run["title"], particles, cells and f"{cells} cells", box)):
        if lines[-1] and len(lines[-1] + part) * 0.58 * size / 72 > width:
            lines[-1] += ","
            lines.append("")
        lines[-1] += (", " if lines[-1] else "") + part
    return "\n".join(lines)


def few_colours(path, colour, solid):
    """Writes a picture anew with 256 colours: those of the map (in 3-D also shaded), greys and the lines' colours, so that none
    becomes another one."""
    map_ = colour.cmap(np.linspace(0, 1, 48 if solid else 180))[:, :3]
    shades = np.concatenate([map_ * shade for shade in ((1, 0.9, 0.76, 0.62) if solid else (1,))])
    lines = plt.rcParams["axes.prop_cycle"].by_key()["color"] + ["crimson"]
    lines = np.array([matplotlib.colors.to_rgb(one) for one in lines])
    lines = np.concatenate([lines, (1 + lines) / 2])
    greys = np.repeat(np.linspace(0, 1, 256 - len(shades) - len(lines)), 3).reshape(-1, 3)
    palette = np.round(255 * np.concatenate([shades, lines, greys])).astype(np.int32)
    with Image.open(path) as picture:
        pixels = np.asarray(picture.convert("RGB")).astype(np.int32)
    codes, place = np.unique(pixels @ [65536, 256, 1], return_inverse=True)
    there = np.stack([codes >> 16, codes >> 8 & 255, codes & 255], axis=1)
    near = np.concatenate([((part[:, None] - palette)**2).sum(-1).argmin(1) for part in np.array_split(there, len(there) // 4096 + 1)])
    small = Image.fromarray(near[place].reshape(pixels.shape[:2]).astype(np.uint8), "P")
    small.putpalette(palette.astype(np.uint8).tobytes())
    small.save(path, optimize=True)


# ---- Arguments that both programs have

def numbers_of(name, value, count=None):
    try:
        numbers = [float(number) for number in value.split(",")]
    except ValueError:
        numbers = []
    if not numbers or not np.isfinite(numbers).all() or (count and len(numbers) != count):
        fail(f"{name} {value}: give {'two numbers' if count == 2 else 'numbers'} with commas between them, such as {name} {'0,1' if count == 2 else '0,0.5,1'}")
    return numbers


def add_arguments(parser):
    parser.add_argument("--field", default="stress", help="what the colours show (default: stress)")
    parser.add_argument("--times", metavar="T,...", help="times in seconds; the nearest snapshots are drawn")
    for axis in "xyz":
        parser.add_argument(f"--{axis}lim", metavar="LOW,HIGH", help=f"the part of the {axis} axis to draw, in metres")
    parser.add_argument("--slice", metavar="AXIS=PLACE", help="in 3-D: draw the particles that this plane cuts, such as y=0")
    parser.add_argument("--domains", action="store_true", default=None, help="particles as their deformed domains (default in 2-D and 3-D)")
    parser.add_argument("--no-domains", dest="domains", action="store_false", help="particles as discs")


def parse(parser, words):
    """The arguments of the command line; a list of numbers that begins with a minus is a value, not an option."""
    joined = []
    for word in words:
        if joined and re.fullmatch("--[xyz]lim", joined[-1]) and re.match(r"-[.\d]", word):
            joined[-1] += "=" + word
        else:
            joined.append(word)
    return parser.parse_args(joined)


def view_of(arguments):
    """Arguments of read_run() by those of the command line."""
    limits, cut = {}, None
    for axis in "xyz":
        value = getattr(arguments, f"{axis}lim")
        if value is not None:
            low, high = numbers_of(f"--{axis}lim", value, 2)
            if low >= high:
                fail(f"--{axis}lim {value}: the first number must be below the second")
            limits[axis] = low, high
    if arguments.slice is not None:
        axis, _, place = arguments.slice.partition("=")
        if axis not in ("x", "y", "z"):
            fail(f"--slice {arguments.slice}: give an axis and a place in metres, such as y=0")
        cut = axis, numbers_of("--slice", place, 1)[0] if place else fail(f"--slice {arguments.slice}: give an axis and a place in metres, such as y=0")
    times = None if arguments.times is None else numbers_of("--times", arguments.times)
    return {"times": times, "limits": limits, "cut": cut, "domains": arguments.domains is not False}
