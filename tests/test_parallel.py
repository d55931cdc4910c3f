"""The same bits on any number of processes: digest, history and snapshots of the spatial decomposition and of the worker
pool are those of the serial run, whatever the process grid, the cuts, the way particles migrate and where particles lie.

usage: test_parallel.py PEBBLE SOURCE MPIEXEC PART [COUNTS]
PART    scenes (the three of FASTER), others (the other scenes), grids, periodic, migration, migration_all, roundoff,
        borders, placement, fit, large; borders are more of what placement begins with
COUNTS  process counts, as 2,3,5, that every scene gets with both strategies (default: a mix of 2, 3, 4, 6 and 8)
"""
import glob
import math
import os
import re
import shutil
import sys

import h5py
import numpy as np

import check

MIX = (2, 3, 4, 6, 8)
ROUNDOFF = 1e-10 # of -parallel_sums roundoff: norm of the difference over the norm


class Result:
    """A run and what it leaves: its digest, and bytes or arrays of its files."""

    def __init__(self, folder, n, arguments):
        self.command = f"{'' if n == 1 else f'mpiexec -n {n} '}pebble {' '.join(map(str, arguments))}"
        self.told = check.pebble(*arguments, "-output_dir", folder, "-output_name", "run", n=n)
        self.status, self.digest = self.told.status, self.told.digest
        self.grid = self.told.find(r"^parallel .*, spatial ([0-9x]+)") or self.told.find(r"^parallel .* (pool)")
        self.history = self.snapshots = None
        if self.status == 0:
            self.history = check.content(os.path.join(folder, "run.csv"))
            self.snapshots = read_snapshots(os.path.join(folder, "run.h5"))
        shutil.rmtree(folder, ignore_errors=True)

    def ended(self):
        """Did it end well? Says why not."""
        return self.told.good or check.that(False, f"exit status {self.status}: {self.command}\n{self.told.out[-2000:]}{self.told.err[-2000:]}")


def read_snapshots(path):
    """{path of a dataset: array, path of an attribute of a step: value}"""
    found = {}
    if not os.path.exists(path):
        return found
    with h5py.File(path) as file:
        for step in (key for key in file if key.startswith("step_")):
            for key, value in file[step].attrs.items():
                found[f"{step}@{key}"] = np.asarray(value)
            file[step].visititems(lambda name, item, step=step: found.__setitem__(f"{step}/{name}", item[()]) if isinstance(item, h5py.Dataset) else None)
    return found


def differences(a, b):
    """What differs between two results, in words; empty if nothing."""
    words = []
    if a.digest != b.digest:
        words.append(f"digest {b.digest} instead of {a.digest}")
    if a.history != b.history:
        pairs = zip((a.history or b"").splitlines(), (b.history or b"").splitlines())
        line = next((k for k, (x, y) in enumerate(pairs) if x != y), "count")
        words.append(f"history differs from line {line} on")
    if set(a.snapshots or ()) != set(b.snapshots or ()):
        words.append("other snapshots or fields")
    for key in sorted(set(a.snapshots or ()) & set(b.snapshots or ())):
        if a.snapshots[key].shape != b.snapshots[key].shape or a.snapshots[key].tobytes() != b.snapshots[key].tobytes():
            words.append(f"{key} differs")
            break
    return "; ".join(words)


def compare(name, arguments, variants, same=True):
    """Runs serially, then each (processes, further options), and compares. Returns the results."""
    folder = re.sub(r"\W+", "_", name)
    serial = Result(folder, 1, arguments)
    if not serial.ended():
        return [serial]
    results = [serial]
    for n, *more in variants:
        result = Result(folder, n, [*arguments, *more])
        results.append(result)
        if not result.ended():
            continue
        words = differences(serial, result)
        says = " ".join(str(word).replace("-parallel_", "") for word in more)
        if same:
            check.that(not words, f"{name}: {n} processes, {result.grid}{', ' + says if says else ''}: " + (words or f"digest {result.digest}, history of {len(result.history)} B, {len(result.snapshots)} arrays of snapshots are the serial ones") + (f"\n     {result.command}" if words else ""))
    return results


SPATIAL = ("-parallel_strategy", "spatial")
POOL = ("-parallel_strategy", "pool")


# Wide stencils, domains of particles, transfers with fields of their own: the parts that ask for one meet them by turns.
METHODS = ["-method_basis linear", "-method_basis bspline2\n-method_transfer apic", "-method_basis gimp\n-method_gimp_update stretch",
           "-method_basis bspline3\n-method_transfer xpic", "-method_basis gimp\n-method_transfer pic", "-method_basis bspline3\n-method_wall_basis steffen"]


def write_scene(name, dim, cells, bodies, h=None, extra="", E=1000.0, nu=0.3, rho=1000.0, method=METHODS[0]):
    """An options file. bodies: one or two dicts of lower, upper (m), velocity, ppc, offset, each of
    a material of its own. Particles lie where offset puts them, also on the last face of the grid: no rim is cut."""
    every = lambda value: ",".join(map(str, value if isinstance(value, (list, tuple)) else [value] * dim))
    h = h or 1.0 / max(cells)
    materials = [("light", "neohookean", rho), ("heavy", "elastic", 3 * rho)][:len(bodies)]
    text = f"-dim {dim}\n-grid_lower {every(0)}\n-grid_upper {every([n * h for n in cells])}\n-grid_cells {every(list(cells))}\n-materials {','.join(row[0] for row in materials)}\n"
    for material, model, density in materials:
        text += f"-material_{material}_model {model}\n-material_{material}_rho {density}\n-material_{material}_E {E!r}\n-material_{material}_nu {nu}\n"
    text += f"-bodies {','.join('b%d' % k for k in range(len(bodies)))}\n"
    for k, body in enumerate(bodies):
        text += f"-body_b{k}_shape box\n-body_b{k}_lower {every(body['lower'])}\n-body_b{k}_upper {every(body['upper'])}\n"
        text += f"-body_b{k}_material {materials[k][0]}\n-body_b{k}_velocity \"{every(body.get('velocity', 0))}\"\n"
        text += f"-body_b{k}_ppc {every(body.get('ppc', 2))}\n-body_b{k}_offset {every(body.get('offset', 0))}\n"
    return ["-options_file", check.write(name + ".opts", text + method + "\n-method_rim whole\n-check_law warn\n-history_every 0\n" + extra + "\n")]


# ---- every scene of options/, every integrator

# Faster than the scenes, so that contact and migration happen within the steps; the checks would stop usl.
FASTER = {
    "bar": ["-body_bar_velocity", "0.9*sin(pi/2*x)", "-history_every", "0", "-output_every", "0.05"],
    "disks": ["-body_disk1_velocity", "0.4,0.3", "-body_disk2_velocity", "-0.3,-0.4", "-history_every", "0", "-output_every", "0.3", "-check_momentum", "1e9"],
    "disks3d": ["-method_basis", "linear", "-dt_cfl", "0.4", "-body_ball1_velocity", "0.8,0.8,0.7", "-body_ball2_velocity", "-0.8,-0.7,-0.8", "-output_every", "0.12", "-history_every", "0.01", "-check_momentum", "1e9"],
}
STEPS = {"usf": 60, "usl": 40, "musl": 80}


def part_scenes(counts, chosen=True):
    """Those of FASTER, or the others."""
    scenes = sorted(path for path in glob.glob(check.scene("*")) if not check.is_static(path))  # test_static.py has those of statics
    check.that(set(FASTER) <= {os.path.splitext(os.path.basename(path))[0] for path in scenes}, f"{len(scenes)} scenes")
    for s, path in enumerate(scenes):
        scene = os.path.splitext(os.path.basename(path))[0]
        if (scene in FASTER) != chosen:
            continue
        arguments = ["-options_file", path, *FASTER.get(scene, [])]
        with open(path) as file: # refused where forces do work that it does not know
            arguments += ["-check_energy", "1e9"] if "\n-check_energy" in file.read() else []
        if scene not in FASTER: # the others as they are, a few steps
            n = (counts or MIX)[s % len(counts or MIX)]
            compare(scene, [*arguments, "-time_max_steps", 20], [(n, *SPATIAL), (MIX[(s + 1) % 3], *POOL)])
            continue
        for u, (update, steps) in enumerate(STEPS.items()):
            if counts:
                variants = [(n, *strategy) for strategy in (SPATIAL, POOL) for n in counts]
            else: # each scene meets each count in either strategy
                spatial = [MIX[(s + u + k) % 5] for k in (0, 2)] + [4] * (u == 1)
                pool = [MIX[(s + u + k) % 5] for k in (1, 3)]
                variants = [(n, *SPATIAL) for n in dict.fromkeys(spatial)] + [(n, *POOL) for n in dict.fromkeys(pool)]
            compare(f"{scene} {update}", [*arguments, "-method_update", update, "-time_max_steps", steps], variants)


def part_others(counts):
    part_scenes(counts, chosen=False)


# ---- process grids

def drift(dim):
    return ["0.2-0.3*(y-0.5)", "0.1+0.3*(x-0.5)", "-0.1+0.1*x"][:dim] if dim > 1 else ["0.2+0.1*x"]


def part_grids(counts):
    """Equal cuts of long, tall and square grids, so that every kind of process grid occurs; with walls and gravity."""
    seen = []
    for name, dim, cells, variants in (
            ("strips along x", 2, (40, 5), [(4, "4x1"), (3, "3x1")]),
            ("strips along y", 2, (5, 40), [(4, "1x4"), (6, "1x6")]),
            ("square", 2, (20, 20), [(4, "2x2"), (6, None), (8, None)]),
            ("strips along z", 3, (5, 5, 24), [(4, "1x1x4")]),
            ("cube", 3, (12, 12, 12), [(8, "2x2x2"), (6, None)]),
            ("plate", 3, (12, 12, 3), [(4, "2x2x1")]),
            ("line", 1, (40,), [(6, "6")])):
        h = 1 / max(cells)
        size = [n * h for n in cells]
        bodies = [{"lower": [0.0] * dim, "upper": [s * 0.55 for s in size], "velocity": drift(dim)}, {"lower": [s * 0.6 for s in size], "upper": [s * 0.95 for s in size], "velocity": ["-0.3"] * dim}]
        faces = [f"{axis}{side}" for axis in "xyz"[:dim] for side in ("min", "max")]
        walls = "\n".join(f"-bc_{face}_type {('slip', 'fixed')[k % 2]}" for k, face in enumerate(faces))
        scene = write_scene("grid_" + name.replace(" ", "_"), dim, cells, bodies, extra=f"{walls}\n-gravity {','.join(['-0.2', '-0.5', '0.3'][:dim])}\n-time_end 100\n-dt_cfl 0.3\n-output_every 0.2")
        results = compare(name, [*scene, "-time_max_steps", "60"], [(n, "-parallel_balance", "none") for n, _ in variants])
        for result, (n, grid) in zip(results[1:], variants):
            seen.append(result.grid)
            if grid:
                check.that(result.grid == grid, f"{name}: {n} processes make {result.grid}, expected {grid}")
    kinds = {"Nx1": r"[2-9]x1", "1xN": r"1x[2-9]", "mixed": r"[2-9]x[2-9]", "1x1xN": r"1x1x[2-9]", "2x2x2": r"2x2x2", "N": r"[2-9]"}
    for kind, pattern in kinds.items():
        check.that(any(re.fullmatch(pattern, grid or "") for grid in seen), f"a process grid {kind} occurs among {', '.join(map(str, dict.fromkeys(seen)))}")


def part_periodic(counts):
    """Two blocks cross periodic faces and meet there; a process may be its own neighbour, or the neighbour on both sides."""
    for dim, faces, cells, variants in (
            (1, "x", (24,), [(2, *SPATIAL), (5, "-parallel_migrate", "direct"), (3, *POOL)]),
            (2, "x", (16, 16), [(2, "-parallel_balance", "none"), (6, "-parallel_balance", "none"), (4, *POOL, "-pool_cells", "5")]),
            (2, "xy", (16, 16), [(4, "-parallel_balance", "none"), (3, "-parallel_migrate", "direct"), (8, "-parallel_balance", "start"), (3, *POOL)]),
            (2, "xy", (3, 20), [(4, "-parallel_balance", "none"), (4, "-parallel_balance", "auto", "-parallel_migrate", "direct")]),
            (1, "x", (9,), [(2, *SPATIAL), (2, *POOL)]), # a last tile narrower than a stencil, in 2-D on both axes
            (2, "xy", (13, 18), [(6, "-parallel_balance", "none"), (3, "-parallel_migrate", "direct"), (3, *POOL, "-pool_cells", "4")]),
            (2, "xy", (14, 13), [(4, "-parallel_balance", "none"), (9, "-parallel_balance", "none"), (3, *POOL)]), # cubic
            (3, "xz", (12, 8, 9), [(8, "-parallel_balance", "none"), (3, "-parallel_migrate", "direct"), (2, *POOL)])):
        cubic = ["-method_basis", "bspline3"] if cells == (14, 13) else []
        h = 1 / max(cells)
        size = [n * h for n in cells]
        bodies = [{"lower": [0.0] * dim, "upper": [s * 0.4 for s in size], "velocity": ["-0.6", "-0.5", "0.4"][:dim]}, {"lower": [s * 0.5 for s in size], "upper": [s * 0.9 for s in size], "velocity": ["0.5", "0.6", "-0.3"][:dim]}]
        kinds = "\n".join(f"-bc_{axis}{side}_type periodic" for axis in faces for side in ("min", "max"))
        kinds += "".join(f"\n-bc_{axis}{side}_type slip" for axis in "xyz"[:dim] if axis not in faces for side in ("min", "max"))
        scene = write_scene(f"periodic{dim}{faces}{cells[0]}", dim, cells, bodies, extra=f"{kinds}\n-time_end 100\n-dt_cfl 0.3\n-output_every 0.2")
        compare(f"{'x'.join(map(str, cells))} cells, periodic in {faces}", [*scene, *cubic, "-time_max_steps", "60"], variants)


# ---- migration and cuts

def flight(dim):
    """A soft body flies across most of the grid in 80 steps and turns a little."""
    cells, ppc, size = {1: ((400,), 16, [40]), 2: ((96, 14), 8, [20, 8]), 3: ((56, 12, 12), 3, [14, 7, 7])}[dim]
    body = {"lower": [2.0] * dim, "upper": [2.0 + n for n in size], "ppc": ppc}
    speed = {1: 4.0, 2: 0.8, 3: 0.45}[dim]
    body["velocity"] = [f"{speed}+0.002*y" if dim > 1 else f"{speed}+0.001*x", f"0.02-0.002*(x-{2 + size[0] / 2})", "0.01"][:dim]
    return write_scene(f"flight{dim}", dim, cells, [body], h=1.0, rho=1e6, extra="-dt_size 1\n-time_end 80\n-output_every 40")


def cuts(result):
    """How often the grid was cut anew."""
    return int(result.told.find(r"^balance .* anew (\d+) times") or 0)


def part_migration_all(counts):
    part_migration(counts, True)


def part_migration(counts, every=False):
    """Every migration and every balance in 2-D, and one pair in the others; or each with each."""
    for dim, updates in ((2, ("musl", "usf") if every else ("musl",)), (3, ("musl",)), (1, ("usf",))):
        scene = flight(dim)
        for update in updates:
            n = 4 if dim == 1 else 7 # too many for strips along the motion, which would stay balanced
            variants = [(n, "-parallel_migrate", migrate, "-parallel_balance", balance) for migrate in ("swarm", "direct") for balance in ("none", "start", "auto")]
            if not every:
                variants = [variants[k] for k in ((0, 2, 4) if dim == 2 else (5,) if dim == 3 else (1, 5))]
            elif update != "musl" or dim != 2:
                variants = [variants[k] for k in (1, 2, 5)]
            if dim == 2:
                variants += [(6, "-parallel_migrate", "direct", "-parallel_balance", "auto"), (3, *POOL)]
            results = compare(f"flight {dim}-D {update}", [*scene, "-method_update", update], variants)
            if dim > 1:
                anew = {balance: [cuts(r) for r in results if r.command.find(f"balance {balance}") > 0] for balance in ("none", "start", "auto")}
                check.that(anew["auto"] and min(anew["auto"]) > 0 and not any(anew["none"] + anew["start"]), f"flight {dim}-D {update}: times the grid was cut anew: {anew}")
            lines = (results[0].history or b"").splitlines()
            counted = {line.rsplit(b",", 1)[1] for line in lines[1:]}
            check.that(len(lines) > 70 and len(counted) == 1, f"flight {dim}-D {update}: {counted} particles in {len(lines) - 1} lines")


def part_roundoff(counts):
    arguments = ["-options_file", check.scene("disks"), *FASTER["disks"], "-time_max_steps", "80"]
    for update in ("musl", "usf"):
        differ = False
        serial, *others = compare(f"roundoff {update}", [*arguments, "-method_update", update], [(n, "-parallel_sums", "roundoff", "-parallel_migrate", migrate) for n, migrate in ((2, "direct"), (4, "swarm"), (6, "direct"))], same=False)
        for result in others:
            if result.status or serial.status:
                continue
            differ |= result.digest != serial.digest
            same_ids = all((result.snapshots[key] == value).all() for key, value in serial.snapshots.items() if key.endswith("particles/id"))
            worst, where = 0.0, None
            for key, a in serial.snapshots.items():
                if "/particles/" in key and not key.endswith(("/id", "/body")):
                    norm = np.linalg.norm(a) if not key.endswith(("/stress", "/von_mises", "/pressure")) else max(np.linalg.norm(a), 1000.0 * math.sqrt(len(a)) * 1e-3) # E times a strain of 0.1 %
                    error = np.linalg.norm(result.snapshots[key] - a) / norm
                    worst, where = max((worst, where), (error, key), key=lambda pair: pair[0])
            check.that(same_ids and worst <= ROUNDOFF, f"roundoff {update}: {result.grid}: differs from serial by {worst:.1e} ({where}), allowed {ROUNDOFF}")
            last = result.history.splitlines()[-1].rsplit(b",", 1)[1]
            check.that(last == serial.history.splitlines()[-1].rsplit(b",", 1)[1], f"roundoff {update}: {result.grid}: {last.decode()} particles at the end")
        check.that(differ, f"roundoff {update}: partial sums do differ in the last bits")


# ---- where particles lie

def part_borders(counts, chosen=(1, 2, 3, 5, 6, 8, 9, 10)):
    # Particles on faces, edges and corners of cells, so of patches, and some ulp beside. They come to lie there again after
    # some steps, up to the rounding of their motion: no force disturbs so soft a material. h is a binary fraction; then not.
    borders = [(4, "-parallel_balance", "none"), (3, *POOL, "-pool_cells", "3")]
    more = [(6, "-parallel_balance", "start", "-parallel_migrate", "direct"), (8, "-parallel_balance", "none", "-parallel_migrate", "direct")]
    for number, (h, tiny) in enumerate([(0.0625, 0.0), (0.0625, 1e-17), (0.0625, 2e-16), (0.0625, -2e-16), (0.1, 0.0)] + [(0.1, k * 2.0 ** -53) for k in (-3, -2, -1, 1, 2, 3)]):
        if number not in chosen:
            continue
        bodies = [{"lower": [2 * h] * 2, "upper": [6.3 * h] * 2, "ppc": 1, "offset": h / 2 + tiny, "velocity": [h / 4, h / 16]},
                  {"lower": [9 * h] * 2, "upper": [13.3 * h] * 2, "ppc": 1, "offset": h / 2 + tiny, "velocity": [-h / 4, -h / 32]}]
        scene = write_scene(f"border{number}", 2, (16, 16), bodies, h=h, E=1e-25, extra="-dt_size 1\n-time_end 20\n-output_every 4")
        variants = borders[number // 2 % 2:number // 2 % 2 + 1] + more[number % 2:number % 2 + 1] if number else borders + more
        results = compare(f"particles on borders, h={h} {tiny:+.2g}", scene, variants)
        if number == 0 and results[0].snapshots:
            for step, axes in ((0, 2), (4, 1), (16, 1)):
                x = results[0].snapshots[f"step_{step:06d}/particles/x"][:, :axes] / h
                off = np.abs(x - np.round(x)).max() / np.finfo(float).eps
                check.that(off <= 16 * step, f"particles on borders: after {step} steps {len(x)} particles lie within {off:.0f} ulp of {'corners' if axes == 2 else 'faces'} of cells, {np.mean(x == np.round(x)):.0%} exactly")


def part_placement(counts):
    part_borders(counts, chosen=(0, 4, 7))
    # at rest on every border and on the upper faces of the grid; in 3-D on corners, edges and faces
    for dim, n in ((1, 4), (2, 6), (3, 8)):
        for ppc in (1, 2):
            body = {"lower": [0.0] * dim, "upper": [1.03125] * dim, "ppc": ppc, "offset": 0.0625 / 2 / ppc, "velocity": ["0.01*(x-0.5)", "0.01*(y-0.5)", "0.01*(z-0.5)"][:dim]}
            walls = "\n".join(f"-bc_{axis}{side}_type slip" for axis in "xyz"[:dim] for side in ("min", "max"))
            scene = write_scene(f"rest{dim}{ppc}", dim, (16,) * dim, [body], h=0.0625, extra=f"{walls}\n-time_end 1\n-dt_size 0.01\n-output_every 0.2")
            compare(f"particles at rest on borders, {dim}-D, ppc {ppc}", [*scene, "-time_max_steps", "40"], [(n, "-parallel_balance", "none"), (3, *POOL, "-pool_cells", "2")][ppc - 1:])
    # over several processes in one step: strips one tile wide, and wider
    for name, dim, cells, body, steps, n in (("27 cells", 1, (27,), ([0.0], [4.0], [11.0]), 2, 7),
                                             ("31 cells", 1, (31,), ([0.2], [2.4], [9.0]), 3, 8),
                                             ("31x1 cells", 2, (31, 1), ([0.0, 0.0], [4.0, 1.0], [9.5, 0.0]), 2, 8),
                                             ("back and forth", 2, (12, 12), ([0.5, 9.0], [2.5, 11.0], [4.2, -4.1]), 2, 6)):
        lower, upper, velocity = body
        scene = write_scene("jump_" + name.replace(" ", "_"), dim, cells, [{"lower": lower, "upper": upper, "velocity": velocity, "ppc": 3}], h=1.0, E=1e-3, nu=0.2, extra=f"-dt_size 1\n-time_end {steps}\n-output_every 0")
        results = compare(f"jumps, {name}", scene, [(n, "-parallel_balance", "none", "-parallel_migrate", migrate) for migrate in ("swarm", "direct")] + [(2, *POOL, "-pool_cells", "1")])
        check.that(results[0].status == 0 and len(results) == 4, f"jumps, {name}: in {steps} steps of {velocity} cells over {results[1].grid if len(results) > 1 else None}")
    # processes without particles; all particles in one cell; a single particle
    extra = "-time_end 3\n-dt_size 0.02\n-output_every 0.5\n-gravity 0.3,0.2"
    corner = write_scene("corner", 2, (24, 24), [{"lower": [0.02, 0.02], "upper": [0.2, 0.2], "velocity": [0.3, 0.25]}], extra=extra)
    compare("body in a corner", [*corner, "-time_max_steps", "50"], [(8, "-parallel_balance", "none"), (6, "-parallel_balance", "none", "-parallel_migrate", "direct"), (8, "-parallel_balance", "start"), (4, *POOL, "-pool_cells", "100")])
    cell = write_scene("cell", 2, (16, 16), [{"lower": [0.5, 0.5], "upper": [0.5625, 0.5625], "ppc": 12, "velocity": ["-0.2+0.1*x", "0.1"]}], extra=extra)
    compare("all particles in one cell", [*cell, "-time_max_steps", "50"], [(8, "-parallel_balance", "start"), (4, "-parallel_balance", "auto"), (4, *POOL, "-pool_cells", "1")])
    for dim, n in ((1, 4), (2, 6), (3, 8)):
        single = write_scene(f"single{dim}", dim, (16,) * dim, [{"lower": [0.5] * dim, "upper": [0.5625] * dim, "ppc": 1, "velocity": ["-0.3", "0.31", "0.1"][:dim]}], extra="-time_end 3\n-dt_size 0.1\n-output_every 0.5")
        results = compare(f"a single particle, {dim}-D", [*single, "-time_max_steps", "12"], [(n, "-parallel_balance", "none"), (2, "-parallel_migrate", "direct"), (3, *POOL, "-pool_cells", "1")][:3 if dim == 2 else 2])
        check.that((results[0].history or b"").splitlines()[-1:] and results[0].history.splitlines()[-1].endswith(b",1"), f"a single particle, {dim}-D: the history counts 1 particle")


# ---- more processes than fit

def part_fit(counts):
    for name, dim, cells, n, largest in (("5x3 cells", 2, (5, 3), 16, 6), ("9 cells", 1, (9,), 8, 5), ("5x3 cells", 2, (5, 3), 7, 6), ("1x1x3 cells", 3, (1, 1, 3), 13, 2)):
        body = {"lower": [0.01] * dim, "upper": [min(cells) * 0.9] * dim, "velocity": ["0.1"] + ["0"] * (dim - 1)}
        scene = write_scene("fit_" + name.replace(" ", "_"), dim, cells, [body], h=1.0, extra="-time_end 1\n-dt_size 0.01\n-output_every 0.1") + ["-time_max_steps", "20"]
        told = check.pebble(*scene, "-output_dir", "fit", n=n)
        lines = told.lines
        check.that(told.status == 2 and len(lines) == 1 and re.search(rf"\b{n} processes\b.*\b{largest}$", lines[0]) and "digest" not in told.out, f"{name} on {n} processes: exit status {told.status}, {lines}")
        compare(f"{name}, as many processes as fit", scene, [(largest, *SPATIAL)] + [(7, *POOL)] * (n == 7))
    # A whole row of a filled body crosses a cut at once, which all processes wait for: 4 strips cost less than boxes.
    filled = write_scene("fit_filled", 2, (64, 64), [{"lower": [0, 0], "upper": [1, 1]}], extra="-time_end 1") + ["-dry_run"]
    check.that("spatial 1x4," in check.must(*filled, "-output_dir", "fit", n=4).out, "a filled square on 4 processes is cut into strips")


# ---- many processes, larger scenes

def part_large(counts):
    scene = lambda name: ["-options_file", check.scene(name)]
    every = ["-check_energy", "1e9", "-time_max_steps", "200", "-time_end", "1000"]
    cases = {
        "disks 128x128": [*scene("disks"), *FASTER["disks"], "-grid_cells", "128,128", "-body_disk1_ppc", "2,2", "-body_disk2_ppc", "2,2", "-output_every", "0.2", "-body_disk1_velocity", "2,1.5", "-body_disk2_velocity", "-1.5,-2"],
        "bar 264": [*scene("bar"), *FASTER["bar"], "-grid_cells", "264", "-output_every", "0.02"],
        "disks3d 40^3": [*scene("disks3d"), *FASTER["disks3d"], "-grid_cells", "40,40,40", "-output_every", "0.2"],
    }
    for name, arguments in cases.items():
        results = compare(name, [*arguments, *every], [(n, *strategy) for n in counts or (16, 32) for strategy in (SPATIAL, POOL)])
        check.that(len(results) > 1 and all(r.status == 0 for r in results), f"{name}: process grids {[r.grid for r in results[1:]]}")


part, *rest = check.arguments(__doc__, None) or sys.exit(__doc__)
globals()["part_" + part]([int(word) for word in rest[0].split(",")] if rest else None)
check.end()
