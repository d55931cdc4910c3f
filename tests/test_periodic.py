"""Periodic faces: a deforming body that flies through the faces of a periodic box moves as the same body in a large open one, keeps mass
and momentum to rounding, and has the same bits on every number of processes, spatial and pool, in 1, 2 and 3
dimensions. A body at rest across a face is as one away from it.

usage: test_periodic.py PEBBLE SOURCE MPIEXEC
"""
import h5py
import numpy as np

import check

FACES = ["xmin", "xmax", "ymin", "ymax", "zmin", "zmax"]


def scene(name, dim, boxes, periodic, update, extra=()):
    """Writes a scene with a body that crosses every face; `boxes` unit boxes of 8 cells an axis. All is in binary
    fractions, so that cells are the same numbers in both grids."""
    n = 8 if dim < 3 else 6
    one = lambda x: ",".join([str(x)] * dim)
    velocity = ["1.75+0.2*sin(2*pi*x)", "0.75+0.2*cos(2*pi*x)", "-1.25"][:dim]
    lines = [f"-dim {dim}", f"-grid_lower {one(-boxes)}", f"-grid_upper {one(boxes + 1)}", f"-grid_cells {one((2 * boxes + 1) * n)}",
             "-materials m", "-material_m_model neohookean", "-material_m_rho 1000", "-material_m_E 1e4", "-material_m_nu 0.25",
             "-bodies b", "-body_b_shape box", f"-body_b_lower {one(0.25)}", f"-body_b_upper {one(0.75)}", f"-body_b_ppc {one(2)}",
             "-body_b_material m", f'-body_b_velocity "{",".join(velocity)}"', "-method_basis linear", f"-method_update {update}",
             "-dt_size 0.00390625", "-time_end 1", "-history_every 0.125", "-output_every 0.5", *extra]
    if periodic:
        lines += [f"-bc_{face}_type periodic" for face in FACES[:2 * dim]]
    return check.write(name + ".opts", lines)


def run(n, opts, *arguments):
    """Runs a scene; returns its digest, its history's bytes and its last particles."""
    folder = opts[:-5]
    digest = check.must("-options_file", opts, "-output_dir", folder, *arguments, n=n).digest
    with h5py.File(f"{folder}/{folder}.h5") as file:
        grid = check.group(file)["grid/mass"][:].sum()
    return digest, check.content(f"{folder}/{folder}.csv"), check.particles(f"{folder}/{folder}.h5", fields=("x", "v", "F")), grid


check.arguments(__doc__, 0)
for dim in (1, 2, 3):
    for update in ("usf", "musl"):
        name = f"{update}{dim}"
        opts = scene(name, dim, 0, True, update, ["-check_momentum 1e-12"])
        digest, history, here, mass = run(1, opts)
        _, _, there, _ = run(1, scene(name + "open", dim, 2, False, update))
        there["x"][:, :dim] -= np.floor(there["x"][:, :dim])
        for field in ("x", "v", "F"):
            worst = np.abs(here[field] - there[field]).max() / np.abs(there[field]).max()
            check.that(worst < 1e-10, f"{name}: {field} as in an open box, difference {worst:.1e}")
        rows = np.genfromtxt(history.decode().splitlines(), delimiter=",", names=True)
        check.that(len(set(rows["mass"])) == 1 and len(set(rows["particles"])) == 1, f"{name}: mass and particles constant")
        check.that(abs(mass / rows["mass"][0] - 1) < 1e-13, f"{name}: the nodes hold the whole mass, {mass / rows['mass'][0] - 1:.1e}")
        for n in (2, 3, 4) if update == "usf" else (2, 4):
            for strategy in (["spatial"], ["spatial", "-parallel_migrate", "direct"], ["pool", "-pool_cells", "3"]):
                d, h, _, _ = run(n, opts, "-parallel_strategy", *strategy)
                check.that(d == digest and h == history, f"{name}: {' '.join(strategy)} on {n}: digest {d}")
check.end()
