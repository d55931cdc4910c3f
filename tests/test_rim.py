"""What particles at the surface of a body have of their places of the lattice (-method_rim): volumes and centroids of shapes, the
same bits on any number of processes and after a restart, symmetry, and errors at curved rims.

usage: test_rim.py PEBBLE SOURCE MPIEXEC
"""
import math

import h5py
import numpy as np

import check

check.arguments(__doc__, 0)
MATERIAL = ["-materials m", "-material_m_model neohookean", "-material_m_rho 1000", "-material_m_E 1e5", "-material_m_nu 0.3", "-body_b_material m", "-bodies b"]


def scene(dim, *body, h=0.125, steps=0, more=()):
    lines = [f"-dim {dim}", "-grid_lower " + ",".join(["0"] * dim), "-grid_upper " + ",".join(["1"] * dim), "-grid_h " + ",".join([str(h)] * dim), *MATERIAL,
             *(f"-body_b_{word}" for word in body), f"-time_max_steps {steps}", "-time_end 1", "-output_fields volume", "-output_every 1", *more]
    return check.write("rim.opts", lines)


def start(*options):
    told = check.must(*options, "-output_dir", ".", "-output_name", "rim")
    with h5py.File("rim.h5") as file:
        p = file["step_000000/particles"]
        return told, p["x"][:], p["volume"][:]


# A shape, its volume and its centroid, and how far the volume may be off, over the exact one.
SHAPES = [
    (1, ("shape box", "lower 0.13", "upper 0.77"), 0.64, (0.45,), 1e-3),
    (2, ("shape box", "lower 0.13,0.22", "upper 0.77,0.79"), 0.64 * 0.57, (0.45, 0.505), 0.02),
    (2, ("shape sphere", "center 0.51,0.47", "radius 0.33"), math.pi * 0.33**2, (0.51, 0.47), 2e-3),
    (2, ("shape annulus", "center 0.5,0.5", "inner_radius 0.2", "radius 0.4"), math.pi * 0.12, (0.5, 0.5), 2e-3),
    (2, ('shape polygon', 'vertices "0.1,0.1 0.9,0.2 0.3,0.8"'), 0.27, (1.3 / 3, 1.1 / 3), 5e-3),
    (2, ("shape expression", 'expression "0.3-abs(x-0.5)-abs(y-0.5)"'), 0.18, (0.5, 0.5), 0.01),
    (3, ("shape box", "lower 0.13,0.22,0.3", "upper 0.77,0.79,0.81"), 0.64 * 0.57 * 0.51, (0.45, 0.505, 0.555), 0.02),
    (3, ("shape sphere", "center 0.51,0.47,0.5", "radius 0.37"), 4 / 3 * math.pi * 0.37**3, (0.51, 0.47, 0.5), 5e-3),
    (3, ("shape cylinder", "center 0.5,0.5,0.5", "axis 1,1,0", "radius 0.25", "length 0.5"), math.pi * 0.25**2 * 0.5, (0.5, 0.5, 0.5), 0.01)]


def check_volumes():
    """Volumes and centroids of bodies are those of their shapes, and better than those of whole places."""
    for dim, body, volume, centre, allowed in SHAPES:
        path, off, away = scene(dim, *body), {}, {}
        for rim in ("whole", "cut"):
            _, x, V = start("-options_file", path, "-method_rim", rim)
            off[rim], away[rim] = abs(V.sum() / volume - 1), np.abs((V[:, None] * x).sum(0)[:dim] / V.sum() - centre).max() / 0.0625
        check.that(off["cut"] <= allowed and away["cut"] < 0.06, f"{dim}-D {body[0]}: volume off by {off['cut']:.1e} (whole places: {off['whole']:.1e}), centroid by {away['cut']:.1e} spacings "
                   f"({away['whole']:.1e})")
        check.fault(None if V.min() > 0 and len(V) > 1 else f"{body}: a particle without volume")
    aligned = scene(2, "shape box", "lower 0.125,0.25", "upper 0.75,0.5")
    check.that(check.must("-options_file", aligned, "-output_dir", ".").digest == check.must("-options_file", aligned, "-output_dir", ".", "-method_rim", "whole").digest,
               "a box along the lattice has the same particles")
    _, x, V = start("-options_file", scene(2, "shape box", "lower 0.1,0.15", "upper 0.7,0.18"))
    check.that(abs(V.sum() / 0.018 - 1) < 0.1, f"a plate of half a spacing has its volume: {V.sum():.4f} of 0.018")


def check_symmetry():
    """A disk in the middle of a cell is the same from all sides."""
    _, x, V = start("-options_file", scene(2, "shape sphere", "center 0.5,0.5", "radius 0.33"))
    rows = lambda x: np.array(sorted(map(tuple, np.column_stack([np.round(x, 9), V]))))
    x = x[:, :2] - 0.5
    same = all(np.allclose(rows(x), rows(turned), atol=1e-8) for turned in (x[:, ::-1], -x, np.column_stack([x[:, 1], -x[:, 0]])))
    check.that(same, "a disk is the same when it is turned and reflected")


def check_bits():
    for dim, body in ((2, ("shape sphere", "center 0.51,0.47", "radius 0.33", 'velocity "0.5,1"')), (3, ("shape sphere", "center 0.51,0.47,0.5", "radius 0.37", 'velocity "0.5,1,0.2"'))):
        path = scene(dim, *body, h=0.0625, steps=12, more=("-gravity " + ",".join(["0"] * (dim - 1) + ["-10"]),))
        run = lambda n, *more: check.must("-options_file", path, "-output_dir", ".", "-output_format", "none", *more, n=n).digest
        digests = [run(1), run(2), run(3, "-parallel_migrate", "direct"), run(4), run(3, "-parallel_strategy", "pool")]
        check.must("-options_file", path, "-output_dir", ".", "-time_max_steps", 6, "-checkpoint_every", 1e-9)
        digests.append(run(2, "-restart_file", "latest"))
        check.that(len(set(digests)) == 1 and digests[0], f"{dim}-D, processes and restart: {digests}")
    path = scene(2, "shape sphere", "center 0.51,0.47", "radius 0.33")
    method = "-method_basis bspline3 -method_update usl -method_transfer aflip -method_affine_strain 1".split()
    said = [check.must("-options_file", path, "-output_dir", ".", *more).digest for more in (method, [*method, "-method_rim", "whole"], [*method, "-method_rim", "cut"], ["-method_rim", "cut"], [])]
    check.that(said[0] == said[1] != said[2] and said[3] == said[4], f"whole where the method is given, else cut: {said}")


def check_errors():
    """Curved rims: a ring that swings. Whole places: 0.021 and 0.039."""
    errors = []
    for n in (24, 48):
        told = check.must("-options_file", check.scene("ring"), "-grid_cells", f"{n},{n}", "-output_dir", ".", "-output_format", "none", "-method_rim", "cut")
        errors.append(float(told.find(r"relative error is ([\d.e+-]+)")))
    check.that(errors[0] < 0.022 and errors[1] < 0.4 * errors[0], f"ring on 24 and 48 cells: errors {errors}")


def check_weight():
    """A column whose top lies between two places is at rest from the start under its weight, on any grid."""
    for top in (0.71, 0.74):
        path = scene(2, "shape box", "lower 0,0", f"upper 1,{top}", steps=200, more=("-gravity 0,-10", "-initial_stress k0", "-history_every 0.01", *(f"-bc_{side}_type slip" for side in ("xmin", "xmax", "ymin"))))
        check.must("-options_file", path, "-output_dir", ".", "-output_name", "rest")
        h = check.history("rest.csv")
        moves = max(h["kinetic_energy"]) / h["strain_energy"][0]
        check.that(moves < 1e-4, f"column of {top} m: kinetic energy {moves:.0e} of the strain energy")


def check_load():
    """The area that a run prints of a load is that on which it acts: of the body, not of its lattice."""
    path = scene(2, "shape box", "lower 0.13,0.2", "upper 0.77,0.79", steps=5, more=("-loads p", "-load_p_body b", "-load_p_type traction", "-load_p_face xmax", '-load_p_value "100,0"'))
    told = check.must("-options_file", path, "-output_dir", ".", "-output_name", "load")
    area, h = float(told.find(r"area along each axis \(([\d.]+), 0\)")), check.history("load.csv")
    check.that(abs(area / 0.59 - 1) < 0.01 and abs(h["momentum_x"][-1] / (100 * area * h["time"][-1]) - 1) < 1e-5, f"traction on a side of 0.59 m: it acts on {area} m")


def check_sums():
    """Particles of a body differ in mass; with theirs the sums are those of the history."""
    path = scene(2, "shape sphere", "center 0.51,0.47", "radius 0.33", 'velocity "y^2,x*y"', steps=5)
    check.must("-options_file", path, "-output_dir", ".", "-output_name", "sums", "-output_fields", "mass,velocity", "-history_bodies", "b")
    p, h = check.particles("sums.h5"), {name: values[-1] for name, values in check.history("sums.csv").items()}
    m, x, v = p["mass"], p["x"], p["v"]
    for name, values in dict(mass=np.ones(len(m)), kinetic_energy=0.5 * (v**2).sum(1), momentum_x=v[:, 0], momentum_y=v[:, 1]).items():
        check.that(abs((m * values).sum() / h[name] - 1) < 1e-12, f"{name} by the masses of particles: {(m * values).sum()}")
    alike = abs(m.sum() * v[:, 0].mean() / h["momentum_x"] - 1)
    check.that(abs((m * x[:, 0]).sum() / m.sum() - h["center_b_x"]) < 1e-12 and len(np.unique(m)) > 5 and alike > 1e-3, f"with equal masses momentum_x would be off by {alike:.1e}")


check_volumes()
check_symmetry()
check_bits()
check_errors()
check_weight()
check_load()
check_sums()
check.end()
