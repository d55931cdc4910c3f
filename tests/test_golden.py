"""Pebble against states of an independent implementation of the same scheme, tests/reference/golden.json.

usage: test_golden.py PEBBLE SOURCE MPIEXEC

Every run is translated into an options file and repeated. Compared are the sums over all particles after 1, 10 and 100
steps, a sample of particles after 100, and mass and force of the nodes in the first step where the reference has them.
Errors are normwise: largest difference over the field's largest value; sums that may cancel (momentum, angular
momentum) are measured by the sum of their terms' magnitudes. A fluid has no F here, only its volume; what cannot be
compared for want of a field is said.
A run whose floor is open must be stopped, not clamped, at the step that its record says, and what it wrote before must
be readable.
"""
import json
import os
import re

import h5py
import numpy as np

import check
import setups

IN_PLANE = {1: [1, 0, 0, 0, 0, 0], 2: [1, 2, 0, 1, 0, 0], 3: [1, 2, 2, 1, 2, 1]}  # how often each stands in dim x dim
SHORT, LONG, NOISE = 1e-13, 1e-12, 100       # tolerance after 1 and 10 steps, after 100, and in units of the run's noise
# Which noise of a run tells how well a sum can agree.
NOISE_OF = {"x": "x", "v": "v", "F": "F", "sig": "sig", "V": "F", "momentum": "v", "angular": "v", "ke": "v", "se": "sig",
            "com": "x", "sum_x2": "x", "sum_F2": "F", "sum_sig2": "sig", "sum_V": "F"}


def report(run, step, what, error, tolerance):  # NaN is not good
    check.that(error <= tolerance, f"{run:<42} {step:>4} steps  {what:<14} {error:9.2e}  (allowed {tolerance:.1e})")


def missing(run, step, what):
    report(run, step, what + " MISSING", np.nan, 0)


def allowed(run, step, key):
    """Tolerance of a quantity: the noise is that of the last state."""
    noise = [part.get(NOISE_OF[key], 0) for part in run.get("noise", {}).values()] if key in NOISE_OF else []
    return SHORT if step <= 10 else max([LONG] + [NOISE * part for part in noise])


def masses(spec, found):
    """Mass of each particle: bodies share nothing but their order of ids, and the runs have one body each."""
    assert len(spec["bodies"]) == 1
    return np.full(len(found["x"]), spec["bodies"][0]["rho"] * spec["bodies"][0]["b"] ** spec["ndim"])


def vectors(values):
    """Rows filled to three components."""
    return np.hstack([values, np.zeros((len(values), 3 - values.shape[1]))])


def has_F(run):
    return all(body["material"]["kind"] != "fluid" for body in run["spec"]["bodies"])


def compare_sums(run, step, want, found, line, grid_mass):
    """The reference's sums over all particles: here from the snapshot, energies and mass from the history."""
    m, x, v = masses(run["spec"], found)[:, None], found["x"], found["v"]
    turn = m * np.cross(vectors(x), vectors(v))  # angular momentum about the origin, all three components in any dim
    values = {  # name: (value, scale or None: the largest value itself)
        "t": (line["time"], None),
        "step": (line["step"], None),
        "mass": (line["mass"], None),
        "grid_mass": (grid_mass, None),
        "momentum": ([line["momentum_" + axis] for axis in "xyz"[:x.shape[1]]], np.abs(m * v).sum()),
        # about the origin; never smaller than the arms and momenta that are summed
        # with APIC the reference counts the particles' own spin too, which the files do not hold
        "angular": (turn.sum(0) if run["spec"]["affine"] == "none" else None, (m[:, 0] * np.linalg.norm(x, axis=1) * np.linalg.norm(v, axis=1)).sum()),
        "ke": (line["kinetic_energy"], None),
        # quadratic in a small strain, from terms of the order of 1 that cancel: measured by all the energy there is
        "se": (line["strain_energy"], want["ke"] + want["se"]),
        "com": ((m * x).sum(0) / m.sum(), None),
        "sum_x2": ((x ** 2).sum(), None),
        "sum_F2": ((found["F"] ** 2).sum() if has_F(run) else None, None),  # of the dim x dim part, as is the next
        "sum_sig2": ((IN_PLANE[x.shape[1]] * found["stress"] ** 2).sum(), None),
        "sum_V": (found["V"].sum(), None),
    }
    for key, reference in want.items():
        if key not in values:
            missing(run["id"], step, key)
            continue
        value, scale = values[key]
        if value is None:
            print(f"--   {run['id']:<42} {step:>4} steps  {key:<14} not in the files")
            continue
        scale = scale or np.abs(reference).max()
        report(run["id"], step, key, np.abs(np.subtract(value, reference)).max() / scale, allowed(run, step, key))


def bspline(xi, knots, k, degree):
    """Value at xi of the B-spline number k on the knots (de Boor and Cox)."""
    if degree == 0:
        last = knots[k] < knots[k + 1] == knots[-1]  # the last span takes its end
        return ((knots[k] <= xi) & ((xi < knots[k + 1]) | (last & (xi == knots[-1])))).astype(float)
    value = np.zeros_like(xi)
    if knots[k + degree] > knots[k]:
        value += (xi - knots[k]) / (knots[k + degree] - knots[k]) * bspline(xi, knots, k, degree - 1)
    if knots[k + degree + 1] > knots[k + 1]:
        value += (knots[k + degree + 1] - xi) / (knots[k + degree + 1] - knots[k + 1]) * bspline(xi, knots, k + 1, degree - 1)
    return value


def basis_1d(basis, boundary, xi, n):
    """Values at xi (in cells, 0..n) of the functions of the nodes 0..n: [particle][node]."""
    if basis == "linear":
        return np.clip(1 - np.abs(xi[:, None] - np.arange(n + 1)), 0, None)
    degree = {"quadratic": 2, "cubic": 3}[basis]
    if boundary == "steffen":  # knots repeated at the walls, the first two functions added
        inner = np.arange(1, n) if degree == 3 else np.arange(n) + 0.5
        knots = np.concatenate([np.zeros(degree + 1), inner, np.full(degree + 1, float(n))])
        phi = np.stack([bspline(xi, knots, k, degree) for k in range(n + 3)], 1)
        return np.hstack([phi[:, :2].sum(1, keepdims=True), phi[:, 2:-2], phi[:, -2:].sum(1, keepdims=True)])
    assert boundary == "extrap"  # uniform, with the coefficients beyond the walls c_-1 = 2 c_0 - c_1
    first = -1 - (degree + 1) / 2
    knots = first + np.arange(n + degree + 4)
    phi = np.stack([bspline(xi, knots, k, degree) for k in range(n + 3)], 1)  # of the nodes -1 .. n+1
    phi[:, 1] += 2 * phi[:, 0]
    phi[:, 2] -= phi[:, 0]
    phi[:, -2] += 2 * phi[:, -1]
    phi[:, -3] -= phi[:, -1]
    return phi[:, 1:-1]


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

    assert spec["affine"] == "none" and spec["flip"] == 1
    a = np.array(want["f_int"]) / np.array(want["m"])[:, None] + spec["gravity"]
    for face, kind in spec["walls"].items():
        d = "xyz".index(face[0])
        held = ijk[:, d] == (0 if face[1] == "-" else spec["ncells"][d])
        if kind == "sticky":
            a[held] = 0
        elif kind == "slip":
            a[held, d] = 0
    before, after = setups.state(file, 0, dim), setups.state(file, 1, dim)
    phi = np.ones((len(before["x"]), len(ijk)))  # [particle][node]
    for d in range(dim):
        phi *= basis_1d(spec["basis"], spec["boundary"], (before["x"][:, d] - origin[d]) / h[d], spec["ncells"][d])[:, ijk[:, d]]
    report(run["id"], 1, "unity", np.abs(phi.sum(1) - 1).max(), SHORT)  # no node is missing in the reference
    change = after["v"] - before["v"]
    # the difference of two velocities cannot be known better than they are
    scale = max(np.abs(change).max(), np.abs(before["v"]).max())
    report(run["id"], 1, "node force", np.abs(change - spec["dt"] * phi @ a).max() / scale, SHORT)


def compare(run):
    """Runs it and compares; what the run must end with when it has an error, check_refusal looks at."""
    spec, dim = run["spec"], run["spec"]["ndim"]
    tested = set()
    status, said = run["result"]
    if status != (3 if run["error"] else 0):
        print(said)
        missing(run["id"], 0, f"exit status {status}:")
        return
    lines = setups.history(run["id"])
    with h5py.File(run["id"] + ".h5") as file:
        for step in sorted(int(step) for step in run["at_step"]):
            found = setups.state(file, step, dim)
            report(run["id"], step, "particles", abs(len(found["x"]) - run["particles"]), 0)
            compare_sums(run, step, run["at_step"][str(step)], found, lines[step], file[f"step_{step:06d}/grid/mass"][:].sum())
            if step == 1 and "nodes_step1" in run:
                compare_nodes(run, file, run["nodes_step1"])
            if step == spec["steps"]:  # the sample is of the last state
                ids = [particle["p"] for particle in run["sample"]]
                for key in ("x", "v", "F", "sig", "V") if has_F(run) else ("x", "v", "sig", "V"):
                    if any(key not in particle for particle in run["sample"]):
                        missing(run["id"], step, "sample " + key)
                        continue
                    want = np.array([np.atleast_1d(particle[key]) for particle in run["sample"]])
                    report(run["id"], step, "sample " + key, np.abs(found[key][ids] - want).max() / np.abs(want).max(),
                           allowed(run, step, key))
                    tested.add("sample")
            tested.add(step)
    for item in (1, 10) if run["error"] else (1, 10, 100, "sample"):
        if item not in tested:
            missing(run["id"], 0, str(item))
    if run["error"]:
        check_refusal(run)


def check_refusal(run):
    """A block without a floor falls out of the grid: at which step, and what is left of the run."""
    status, said = run["result"]
    stop = re.search(r"particle (\d+) of \w+ left the grid, to \(([^)]*)\)", said)
    expected = int(re.match(r"step (\d+):", run["error"]).group(1))
    complaints, refused = [], None
    if not stop:
        complaints.append("no message that names the particle:\n" + said)
    elif not float(stop.group(2).split(",")[1]) < run["spec"]["origin"][1]:
        complaints.append(f"the particle is said to be at {stop.group(2)}, which is not below the floor")
    try:
        lines = setups.history(run["id"])
        refused = max(lines) + 1
        if abs(refused - expected) > 1:
            complaints.append(f"refused in step {refused}, the record says {expected}")
        if list(lines) != list(range(len(lines))) or not np.isfinite([list(line.values()) for line in lines.values()]).all():
            complaints.append(f"the history has {len(lines)} lines, and a hole or a number that is not finite")
        with h5py.File(run["id"] + ".h5") as file:
            steps = check.steps(file)
            if len(steps) < expected - 1:
                complaints.append(f"{len(steps)} snapshots")
            for step in steps:
                particles = setups.state(file, step, run["spec"]["ndim"])
                if not all(np.isfinite(value).all() for value in particles.values()):
                    complaints.append(f"snapshot {step} is not finite")
                if not (particles["x"] >= 0).all():
                    complaints.append(f"a particle of snapshot {step} is outside")
    except (OSError, KeyError, ValueError) as error:
        complaints.append(f"history or snapshots are not readable: {error}")
    check.that(not complaints, "  ".join([run["id"], f"exit status {status}; refused in step {refused} ({expected} +- 1)",
                                          stop.group(0) if stop else "", *complaints]))


def simulate(run):
    return setups.simulate(run["id"], setups.options(run["spec"], run["id"], output_every=0.0, history_every=0.0))


check.arguments(__doc__, 0)
with open(os.path.join(check.source, "tests", "reference", "golden.json")) as reference:
    runs = json.load(reference)["runs"]
check.that(len(runs) == 22, f"{len(runs)} runs of the reference")
for one, one["result"] in zip(runs, check.at_once(simulate, runs)):
    compare(one)
check.end()
