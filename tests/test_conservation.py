"""What a free body must keep: mass, momentum, number of particles, zero stress in translation, energy of the disks; and
what must not matter to a run: how often and in which format it writes.

usage: test_conservation.py PEBBLE SOURCE MPIEXEC
"""
import os

import h5py
import numpy as np

import check

TOLERANCE = 1e-13
ENERGY = 0.04  # of the disks: largest change of the total energy
E = 1000.0     # Young's modulus of all scenes here
# Spin, shear and stretch about the middle of the block, and a drift.
VELOCITY = {
    2: "0.3 - 0.8*(y-0.5) + 0.2*sin(2*pi*x), -0.2 + 0.8*(x-0.5) + 0.3*(y-0.5)",
    3: "0.3 - 0.8*(y-0.5) + 0.2*sin(2*pi*z), -0.2 + 0.8*(x-0.5) + 0.3*(y-0.5), 0.1 + 0.5*(x-0.5) - 0.4*cos(2*pi*y)",
}


def simulate(name, *arguments):
    """Runs pebble; its digest. Results are name.*"""
    return check.must(*arguments, "-output_dir", ".", "-output_name", name).digest


def block(name, dim, model, update, velocity, extra=""):
    """An options file: a block of two bodies (so of two kinds) in the middle of an open box; its particles lie off the
    grid's lines."""
    every = lambda value: ",".join([str(value)] * dim)
    return "-options_file", check.write(name + ".opts", f"""-dim {dim}
-grid_lower {every(0)}
-grid_upper {every(1)}
-grid_cells {every(10)}
-materials light,heavy
-material_light_model {model}
-material_light_rho 1000
-material_light_E {E!r}
-material_light_nu 0.3
-material_heavy_model {model}
-material_heavy_rho 3000
-material_heavy_E {E!r}
-material_heavy_nu 0.3
-bodies left,right
-body_left_shape box
-body_left_lower {every(0.3)}
-body_left_upper {','.join(['0.5'] + ['0.7'] * (dim - 1))}
-body_left_offset {every(0.011)}
-body_left_material light
-body_left_velocity "{velocity}"
-body_right_shape box
-body_right_lower {','.join(['0.5'] + ['0.3'] * (dim - 1))}
-body_right_upper {every(0.7)}
-body_right_offset {every(0.011)}
-body_right_material heavy
-body_right_velocity "{velocity}"
-method_basis linear
-method_update {update}
-dt_size auto
-dt_cfl 0.3
-history_every 0
{extra}
""")


def speed(name):
    """sum m|v| of the particles, largest over the snapshots; masses from the stress-free volumes of the bodies."""
    with h5py.File(name + ".h5") as file:
        largest = 0.0
        first = file["step_000000/particles"]
        for step in (file[key] for key in file if key.startswith("step_")):
            particles = step["particles"]
            m = first["volume"][:] * np.where(first["body"][:] == first["body"][:].min(), 1000.0, 3000.0)
            assert (particles["id"][:] == first["id"][:]).all()
            largest = max(largest, (m * np.linalg.norm(particles["v"][:], axis=1)).sum())
    return largest


def check_kept(name, scale, gravity=(0, 0, 0)):
    """Mass and number of particles to the last digit, momentum to rounding."""
    rows = check.rows(name + ".csv")
    axes = [axis for axis in "xyz" if "momentum_" + axis in rows[0]]
    t = check.kicked(check.history(name + ".csv"))
    mass = float(rows[0]["mass"])
    p = np.array([[float(row["momentum_" + axis]) for axis in axes] for row in rows])
    change = np.abs(p - p[0] - mass * np.outer(t, gravity[:len(axes)])).max()
    check.that(len(rows) > 10 and len({row["mass"] for row in rows}) == 1, f"{name}: mass is {rows[0]['mass']} kg in all {len(rows)} lines")
    check.that(len({row["particles"] for row in rows}) == 1, f"{name}: {rows[0]['particles']} particles in all lines")
    check.that(change <= TOLERANCE * scale, f"{name}: momentum{' less m g t' if any(gravity) else ''} changes by {change / scale:.1e} of sum m|v| (allowed {TOLERANCE})")


def check_flight(disks):
    for update, end in (("usf", "1"), ("usl", "0.3"), ("musl", "1")):
        # before contact, both disks, so that the sum of momentum is 0; and with one of them slower, so that it is not
        for name, extra in ((f"disks_{update}", []), (f"disk_{update}", ["-body_disk2_velocity", "-0.03,-0.01"])):
            simulate(name, "-options_file", disks, "-method_update", update, "-time_end", end, "-history_every", "0", *extra)
            line = check.rows(name + ".csv")[0]
            m = float(line["mass"]) / 2
            v = np.array([[0.1, 0.1], [-0.03, -0.01] if extra else [-0.1, -0.1]])
            check_kept(name, m * np.linalg.norm(v, axis=1).sum())
        for dim in (2, 3):
            for model in ("neohookean", "elastic"):
                name = f"block{dim}_{model}_{update}"
                # usl with the linear basis is unstable in the long run
                simulate(name, *block(name, dim, model, update, VELOCITY[dim]), "-time_end", "0.2" if update == "usl" else "0.25")
                check_kept(name, speed(name))
        for dim, gravity in ((2, (1.5, -3, 0)), (3, (0.5, 1, -2))):
            name = f"falling{dim}_{update}"
            extra = f"-gravity {','.join(map(str, gravity[:dim]))}"
            simulate(name, *block(name, dim, "neohookean", update, VELOCITY[dim], extra), "-time_end", "0.2" if update == "usl" else "0.25")
            check_kept(name, speed(name), gravity)


def check_translation():
    for update in ("usf", "musl"):
        for dim in (2, 3):
            for model in ("neohookean", "elastic"):
                name = f"translation{dim}_{model}_{update}"
                velocity = ", ".join(["0.31", "-0.17", "0.23"][:dim])
                simulate(name, *block(name, dim, model, update, velocity), "-time_end", "0.9", "-output_every", "0.1")
                with h5py.File(name + ".h5") as file:
                    steps = [file[key]["particles"] for key in sorted(file) if key.startswith("step_")]
                    stress = max(np.abs(step["stress"][:]).max() for step in steps) / E
                    moved = (steps[-1]["x"][:] - steps[0]["x"][:])[:, :dim] / 0.1  # cells
                    count = len(check.rows(name + ".csv")) - 1
                check.that(np.abs(moved).max() > 2, f"{name}: moves by {np.abs(moved).max(0).round(2)} cells in {count} steps")
                check.that(stress <= TOLERANCE, f"{name}: largest stress {stress:.1e} E (allowed {TOLERANCE})")


def check_energy(disks):
    for update in ("usf", "musl"):
        name = f"energy_{update}"
        simulate(name, "-options_file", disks, "-method_update", update, "-history_every", "0")
        rows = check.rows(name + ".csv")
        total, kinetic = (np.array([float(row[key]) for row in rows]) for key in ("total_energy", "kinetic_energy"))
        check.that(len(rows) > 150 and np.isfinite(total).all(), f"{name}: {len(rows)} lines")
        check.that(np.abs(total / total[0] - 1).max() <= ENERGY, f"{name}: total energy {total.min() / total[0] - 1:+.4f} .. {total.max() / total[0] - 1:+.4f} of the start (allowed {ENERGY}); kinetic at least {kinetic.min() / total[0]:.3f}, at the end {kinetic[-1] / total[0]:.3f}")


def check_cadence(disks):
    """The same run written differently: the same digest, the same lines of history at equal steps."""
    lines = lambda name: check.content(name + ".csv")
    variants = {
        "base": [],
        "again": [],
        "rarely": ["-output_every", "1"],
        "often": ["-output_every", "0.05"],
        "each": ["-output_every", "0"],
        "without": ["-output_format", "none"],
        "fields": ["-output_fields", "velocity"],
        "each_line": ["-history_every", "0"],
        "odd_lines": ["-history_every", "0.07", "-output_every", "0.3"],
    }
    with open(disks) as file:
        text = file.readlines()
    for scene, extra in (("disks", ["-dt_size", "auto", "-method_update", "usf"]), ("disks_musl", ["-dt_size", "0.01", "-method_update", "musl"])):
        # an option that does not apply is refused: -dt_cfl with a fixed step, -output_every without snapshots
        path = check.write(scene + ".opts", "".join(line for line in text if not line.startswith(("-dt_", "-output_", "-method_update"))))
        common = ["-options_file", path, *extra, "-time_end", "2"]
        digests = {name: simulate(f"{scene}_{name}", *common, *more) for name, more in variants.items()}
        check.that(len(set(digests.values())) == 1, f"{scene}: digest {digests['base']} of {len(digests)} ways to write" if len(set(digests.values())) == 1 else f"{scene}: digests {digests}")
        base = lines(f"{scene}_base")
        for name, more in variants.items():
            if name != "base" and "-history_every" not in more:
                check.that(lines(f"{scene}_{name}") == base, f"{scene}: the history of '{name}' is byte for byte that of 'base'")
        every = set(lines(f"{scene}_each_line").splitlines())
        for name in ("base", "odd_lines"):
            some = lines(f"{scene}_{name}").splitlines()
            check.that(10 < len(some) < len(every) and set(some) <= every, f"{scene}: the {len(some) - 1} lines of '{name}' stand among the {len(every) - 1} of every step")
        check.that(not os.path.exists(f"{scene}_without.h5"), f"{scene}: -output_format none writes no snapshots")


check.arguments(__doc__, 0)
check_flight(check.scene("disks"))
check_translation()
check_energy(check.scene("disks"))
check_cadence(check.scene("disks"))
check.end()
