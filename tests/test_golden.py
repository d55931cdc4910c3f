"""Pebble against states of an independent implementation of the same scheme, tests/reference/golden.json.

usage: test_golden.py PEBBLE SOURCE [WORK]     (WORK: folder for the files, default the current one)

Every run is translated into an options file and repeated for 1, 10 and 100 steps. Compared are the sums over all
points after each, a sample of points after 100, and mass and force of the nodes in the first step where the reference
has them. Errors are normwise: largest difference over the field's largest value; sums that may cancel (momentum,
angular momentum) are measured by the sum of their terms' magnitudes.
Last, a run whose floor is opened must be stopped, not clamped, and what it wrote before must be readable.
"""
import csv
import json
import os
import re
import subprocess
import sys

import h5py
import numpy as np

MODELS = {"neo": "neohookean", "linear": "elastic"}
WALLS = {"free": "free", "sticky": "fixed", "slip": "slip"}
# Components of the file's tensors (xx xy xz yx ... and xx xy xz yy yz zz) that the reference lists, for dim 1, 2, 3.
F_PARTS = {1: [0], 2: [0, 1, 3, 4], 3: range(9)}
STRESS_PARTS = {1: [0, 3, 5], 2: [0, 1, 3, 5], 3: range(6)}
IN_PLANE = {1: [1, 0, 0, 0, 0, 0], 2: [1, 2, 0, 1, 0, 0], 3: [1, 2, 2, 1, 2, 1]}  # how often each stands in dim x dim
SHORT, LONG = 1e-13, 1e-12                   # tolerance after 1 and 10 steps, and after 100
failures = 0


def report(run, step, what, error, tolerance):
    global failures
    good = bool(error <= tolerance)  # NaN is not good
    failures += not good
    print(f"{'ok  ' if good else 'FAIL'} {run:<32} {step:>4} steps  {what:<14} {error:9.2e}  (allowed {tolerance:.1e})")


def missing(run, step, what):
    report(run, step, what + " MISSING", np.nan, 0)


def numbers(values):
    return ",".join(repr(float(value)) for value in values)


def options(run, walls=None):
    """The text of the options file for the reference's specification."""
    spec = run["spec"]
    dim, cells, h = spec["ndim"], np.array(spec["ncells"]), np.array(spec["h"], float)
    lower = np.array(spec["origin"], float)
    assert spec["basis"] == "linear" and spec["affine"] == "none" and not spec.get("consts") and not spec.get("fixed_nodes")
    lines = [f"-scene_title \"{run['id']}\"", f"-dim {dim}", f"-grid_lower {numbers(lower)}",
             f"-grid_upper {numbers(lower + cells * h)}", f"-grid_cells {','.join(map(str, cells))}",
             f"-gravity {numbers(spec['gravity'])}", "-method_basis linear", f"-method_update {spec['order']}",
             "-method_transfer flip", f"-method_flip {spec['flip']}", f"-dt_size {spec['dt']!r}", "-time_end 1e6",
             "-output_every 1e6", "-history_every 0"]
    for face, kind in (walls or spec["walls"]).items():
        lines.append(f"-bc_{face[0]}{'min' if face[1] == '-' else 'max'}_type {WALLS[kind]}")
    names = [f"b{k}" for k in range(len(spec["bodies"]))]
    lines += ["-materials " + ",".join("m" + name for name in names), "-bodies " + ",".join(names)]
    for name, body in zip(names, spec["bodies"]):
        material, ppc = body["material"], h / body["b"]
        assert (ppc == ppc.round()).all() and "region" not in body
        lines += [f"-material_m{name}_model {MODELS[material['kind']]}", f"-material_m{name}_rho {body['rho']!r}",
                  f"-material_m{name}_E {material['E']!r}", f"-material_m{name}_nu {material['nu']!r}",
                  f"-body_{name}_shape box", f"-body_{name}_lower {numbers(body['lo'])}",
                  f"-body_{name}_upper {numbers(body['hi'])}", f"-body_{name}_ppc {','.join(str(int(n)) for n in ppc)}",
                  f"-body_{name}_offset {numbers(body['offset'])}", f"-body_{name}_material m{name}",
                  f"-body_{name}_velocity \"{', '.join(body['velocity'])}\""]
    return "\n".join(lines) + "\n"


def simulate(pebble, work, name, text, *extra):
    """Runs pebble on an options file of this text; its exit status and what it said."""
    path = os.path.join(work, name + ".opts")
    with open(path, "w") as file:
        file.write(text)
    result = subprocess.run([pebble, "-options_file", path, "-output_dir", work, *extra], stdout=subprocess.PIPE,
                            stderr=subprocess.STDOUT, text=True)
    return result.returncode, result.stdout


def history(work, name):
    with open(os.path.join(work, name + ".csv"), newline="") as file:
        return {int(row["step"]): {key: float(value) for key, value in row.items()} for row in csv.DictReader(file)}


def state(file, step, dim):
    """Points of a snapshot in the order of their ids, with the reference's components."""
    points = file[f"step_{step:06d}/particles"]
    order = np.argsort(points["id"][:])
    assert (points["id"][:][order] == np.arange(len(order))).all()
    columns = {"x": range(dim), "v": range(dim), "F": F_PARTS[dim]}
    found = {key: points[key][:][order][:, list(part)] for key, part in columns.items()}
    found["stress"] = points["stress"][:][order]
    found["sig"], found["V"] = found["stress"][:, list(STRESS_PARTS[dim])], points["volume"][:][order][:, None]
    return found


def masses(spec, found):
    """Mass of each point: bodies share nothing but their order of ids, and the runs have one body each."""
    assert len(spec["bodies"]) == 1
    return np.full(len(found["x"]), spec["bodies"][0]["rho"] * spec["bodies"][0]["b"] ** spec["ndim"])


def vectors(values):
    """Rows filled to three components."""
    return np.hstack([values, np.zeros((len(values), 3 - values.shape[1]))])


def compare_sums(run, step, want, found, line, grid_mass, tolerance):
    """The reference's sums over all points: here from the snapshot, energies and mass from the history."""
    m, x, v = masses(run["spec"], found)[:, None], found["x"], found["v"]
    turn = m * np.cross(vectors(x), vectors(v))  # angular momentum about the origin, all three components in any dim
    values = {  # name: (value, scale or None: the largest value itself)
        "t": (line["time"], None),
        "step": (line["step"], None),
        "mass": (line["mass"], None),
        "grid_mass": (grid_mass, None),
        "momentum": ([line["momentum_" + axis] for axis in "xyz"[:x.shape[1]]], np.abs(m * v).sum()),
        # about the origin; never smaller than the arms and momenta that are summed
        "angular": (turn.sum(0), (m[:, 0] * np.linalg.norm(x, axis=1) * np.linalg.norm(v, axis=1)).sum()),
        "ke": (line["kinetic_energy"], None),
        # quadratic in a small strain, from terms of the order of 1 that cancel: measured by all the energy there is
        "se": (line["strain_energy"], want["ke"] + want["se"]),
        "com": ((m * x).sum(0) / m.sum(), None),
        "sum_x2": ((x ** 2).sum(), None),
        "sum_F2": ((found["F"] ** 2).sum(), None),  # of the dim x dim part, as is the next
        "sum_sig2": ((IN_PLANE[x.shape[1]] * found["stress"] ** 2).sum(), None),
        "sum_V": (found["V"].sum(), None),
    }
    for key, reference in want.items():
        if key not in values:
            missing(run["id"], step, key)
            continue
        value, scale = values[key]
        scale = scale or np.abs(reference).max()
        report(run["id"], step, key, np.abs(np.subtract(value, reference)).max() / scale, tolerance)


def compare_nodes(run, file, want):
    """Mass and internal force of the nodes in the first step. Pebble shows no forces, but what they do: with FLIP,
    v_p(1) - v_p(0) = dt sum_i phi_i(x_p) a_i, with a = f/m + g where no wall holds the node."""
    spec = run["spec"]
    dim, h, origin = spec["ndim"], np.array(spec["h"]), np.array(spec["origin"])
    mass = file["step_000000/grid/mass"][:]
    ijk = np.rint((np.array(want["x"]) - origin) / h).astype(int)
    at = tuple(np.hstack([ijk, np.zeros((len(ijk), 3 - dim), int)])[:, ::-1].T)  # the file's arrays are [z][y][x]
    report(run["id"], 1, "node mass", np.abs(mass[at] - want["m"]).max() / np.max(want["m"]), SHORT)
    report(run["id"], 1, "other nodes", abs(mass.sum() - np.sum(want["m"])) / np.sum(want["m"]), SHORT)

    a = np.array(want["f_int"]) / np.array(want["m"])[:, None] + spec["gravity"]
    for face, kind in spec["walls"].items():
        d = "xyz".index(face[0])
        held = ijk[:, d] == (0 if face[1] == "-" else spec["ncells"][d])
        if kind == "sticky":
            a[held] = 0
        elif kind == "slip":
            a[held, d] = 0
    before, after = state(file, 0, dim), state(file, 1, dim)
    phi = np.clip(1 - np.abs((before["x"][:, None] - want["x"]) / h), 0, None).prod(2)  # [point][node]
    change = after["v"] - before["v"]
    # the difference of two velocities cannot be known better than they are
    scale = max(np.abs(change).max(), np.abs(before["v"]).max())
    report(run["id"], 1, "node force", np.abs(change - spec["dt"] * phi @ a).max() / scale, SHORT)


def compare(pebble, work, run):
    spec, dim = run["spec"], run["spec"]["ndim"]
    tested = set()
    for step in sorted(int(step) for step in run["at_step"]):
        name = f"{run['id']}-{step}"
        status, said = simulate(pebble, work, name, options(run), "-time_max_steps", str(step))
        if status:
            print(said)
            missing(run["id"], step, f"exit status {status}:")
            continue
        tolerance = SHORT if step <= 10 else LONG
        with h5py.File(os.path.join(work, name + ".h5")) as file:
            found, lines = state(file, step, dim), history(work, name)
            report(run["id"], step, "particles", abs(len(found["x"]) - run["particles"]), 0)
            compare_sums(run, step, run["at_step"][str(step)], found, lines[step],
                         file[f"step_{step:06d}/grid/mass"][:].sum(), tolerance)
            if step == 1 and "nodes_step1" in run:
                compare_nodes(run, file, run["nodes_step1"])
            if step == spec["steps"]:  # the sample is of the last state
                ids = [point["p"] for point in run["sample"]]
                for key in ("x", "v", "F", "sig", "V"):
                    if any(key not in point for point in run["sample"]):
                        missing(run["id"], step, "sample " + key)
                        continue
                    want = np.array([np.atleast_1d(point[key]) for point in run["sample"]])
                    noise = max((run["noise"][kind].get(key, 0) for kind in run["noise"]), default=0)
                    report(run["id"], step, "sample " + key, np.abs(found[key][ids] - want).max() / np.abs(want).max(),
                           max(tolerance, 100 * noise))
                    tested.add("sample")
        tested.add(step)
    for item in (1, 10, 100, "sample"):
        if item not in tested:
            missing(run["id"], 0, str(item))


def check_refusal(pebble, work, run):
    """The same block without a floor falls out of the grid."""
    global failures
    walls = {face: kind for face, kind in run["spec"]["walls"].items() if face != "y-"}
    name = "floor-free"
    dt = run["spec"]["dt"]
    status, said = simulate(pebble, work, name, options(run, walls), "-time_end", repr(2000 * dt), "-output_every", repr(20 * dt))
    stop = re.search(r"point (\d+) left the grid, to \(([^)]*)\)", said)
    complaints = []
    if status != 3:
        complaints.append(f"exit status {status}, not 3")
    if not stop:
        complaints.append("no message that names the point:\n" + said)
    elif not float(stop.group(2).split(",")[1]) < run["spec"]["origin"][1]:
        complaints.append(f"the point is said to be at {stop.group(2)}, which is not below the floor")
    try:
        lines = history(work, name)
        if len(lines) < 50 or list(lines) != list(range(len(lines))) or not np.isfinite([list(line.values()) for line in lines.values()]).all():
            complaints.append(f"the history has {len(lines)} lines, or a hole, or a number that is not finite")
        with h5py.File(os.path.join(work, name + ".h5")) as file:
            steps = sorted(int(key[5:]) for key in file if key.startswith("step_"))
            if len(steps) < 3:
                complaints.append(f"{len(steps)} snapshots")
            for step in steps:
                points = state(file, step, 2)
                if not all(np.isfinite(value).all() for value in points.values()):
                    complaints.append(f"snapshot {step} is not finite")
                if not (points["x"] >= 0).all():
                    complaints.append(f"a point of snapshot {step} is outside")
    except (OSError, KeyError, ValueError) as error:
        complaints.append(f"history or snapshots are not readable: {error}")
    failures += bool(complaints)
    print("FAIL" if complaints else "ok  ", name, f"exit status {status}; {stop.group(0) if stop else ''}", *complaints, sep="  ")


def main(pebble, source, work="."):
    with open(os.path.join(source, "tests", "reference", "golden.json")) as file:
        runs = json.load(file)["runs"]
    for run in runs:
        compare(pebble, work, run)
    check_refusal(pebble, work, next(run for run in runs if run["id"] == "2d-neo-linear-none-usf-flip1"))
    if failures or len(runs) != 5:
        sys.exit(f"FAIL: {failures} of the quantities of {len(runs)} runs")


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    main(*sys.argv[1:])
