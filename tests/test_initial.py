"""Initial states: a column that starts with its weight stays at rest, for every law, with linear hats and gimp to rounding,
with splines up to a residual that falls with h; stress and deformation by formula are what the law says; the same bits on
any number of processes.

usage: test_initial.py PEBBLE SOURCE MPIEXEC
"""
import math
import re

import numpy as np

import check

check.arguments(__doc__, 0)
G = 10
LAWS = {"elastic": "E 1e6 nu 0.3", "neohookean": "E 1e6 nu 0.3", "vonmises": "E 1e6 nu 0.3 yield 1e5",
        "druckerprager": "E 1e6 nu 0.3 friction_angle 30", "fluid": "K 1e6 viscosity 1"}


def material(name, law, rho=2000, more=""):
    words = f"model {law} rho {rho} {LAWS[law]} {more}".split()
    return [f"-material_{name}_{key} {value}" for key, value in zip(words[::2], words[1::2])]


def column(name, law="druckerprager", dim=2, axis=None, sign=-1, cells=8, bodies=None, materials=None, more=()):
    """A column of height 1 between slip walls, which fills them to 4/5 along gravity."""
    axis = dim - 1 if axis is None else axis
    top = [1.25 if d == axis else 0.5 for d in range(dim)]
    upper = [1 if d == axis else top[d] for d in range(dim)]
    lower = [0.0] * dim
    if sign > 0:  # gravity towards the upper end
        lower[axis], upper[axis] = 0.25, 1.25
    words = lambda values: ",".join(str(v) for v in values)
    lines = [f"-dim {dim}", "-gravity " + words(sign * G if d == axis else 0 for d in range(dim)), "-grid_lower " + words([0] * dim),
             "-grid_upper " + words(top), "-grid_cells " + words(round(t * cells) for t in top)]
    lines += [f"-bc_{'xyz'[d]}{side}_type slip" for d in range(dim) for side in ("min", "max")]
    lines += materials or ["-materials m", *material("m", law)]
    lines += bodies or ["-bodies b", "-body_b_shape box", "-body_b_lower " + words(lower), "-body_b_upper " + words(upper), "-body_b_material m"]
    return check.write(name + ".opts", [*lines, "-time_end 1", "-history_every 0", *more])


def rest(path, name, *options, steps=30):
    """rms velocity after the first step, and the largest of all, in those of a free fall of one step."""
    run = check.must("-options_file", path, "-time_max_steps", steps, "-output_name", name, *options)
    if "-initial_stress k0" in open(path).read() and "none" not in options[-1:]:
        check.fault(f"{name} rests, but there is a warning" if "does not rest" in run.out else None)
    h = check.history(f"output/{name}.csv")
    v = np.sqrt(2 * h["kinetic_energy"] / h["mass"]) / (G * h["time"][1])
    return v[1], v.max()


def check_rest():
    """The laws, dimensions, directions, and layers of two materials with other lattices; nothing else is as the weight is."""
    hats = "-method_basis linear -method_update musl -method_flip 1 -output_format none -report_indicator false".split()
    layers = ["-bodies soil,water", "-body_soil_shape box", "-body_soil_lower 0,0", "-body_soil_upper 0.5,0.5", "-body_soil_material m",
              "-body_water_shape box", "-body_water_lower 0,0.5", "-body_water_upper 0.5,1", "-body_water_material w", "-body_water_ppc 2,3"]
    both = ["-materials m,w", *material("m", "druckerprager"), *material("w", "fluid", 1000)]
    jobs = [(law, dict(law=law), []) for law in LAWS]
    jobs += [("1-D", dict(dim=1), []), ("3-D", dict(dim=3, law="neohookean"), []), ("along x", dict(axis=0, law="vonmises"), []),
             ("upwards", dict(sign=1), []), ("layers", dict(bodies=layers, materials=both), []),
             ("gimp", dict(law="fluid"), ["-method_basis", "gimp", "-method_update", "usl", "-method_gimp_update", "none"]),
             ("k0 given", {}, ["-material_m_k0", "0.7"])]
    for name, what, more in jobs:
        word = name.replace(" ", "_")
        path = column(word, **what, more=["-initial_stress k0"])
        first, most = rest(path, word, *hats, *more)
        check.that(most < 1e-10, f"{name}: at rest to {first:.1e} of the weight in a step, {most:.1e} in 30")
    first, _ = rest(path, "unstressed", *hats, "-initial_stress", "none", steps=1)
    check.that(0.5 < first < 1.5, f"without stress it falls: {first:.2f} of g")


def check_stiff():
    """Stresses of some Pa in metal, which are near the rounding of its law."""
    for name, law, top, stress in (("plate", "vonmises", 0.006, "k0"), ("foil", "vonmises", 3e-4, "k0"), ("formula", "vonmises", 0.006, "-2,0,-5"), ("rubber", "neohookean", 3e-4, "k0")):
        words = "E 2.1e11 nu 0.32" + " yield 2.5e8" * (law == "vonmises")
        stiff = [f"-material_m_{key} {value}" for key, value in zip(*[iter(f"model {law} rho 7850 {words}".split())] * 2)]
        path = check.write("stiff.opts", ["-dim 2", "-gravity 0,-9.81", "-grid_lower 0,0", f"-grid_upper {5 * top},{5 * top}", "-grid_cells 20,20", *[f"-bc_{wall}_type slip" for wall in ("xmin", "xmax", "ymin")],
                                          "-materials m", *stiff, "-bodies b", "-body_b_shape box", "-body_b_lower 0,0", f"-body_b_upper {5 * top},{top}", "-body_b_material m", f"-initial_stress {stress}", "-time_end 1e-6", "-output_format none"])  # fmt: skip
        told = check.pebble("-options_file", path)
        check.that(told.good and "does not rest" not in told.out, f"{name}, {law}, {top * 1e3:g} mm of steel, {stress}: {told.err.strip()}")


def check_splines():
    """The residual is that of the layers at top and floor: it falls, and nothing creeps from it in 600 steps."""
    found = {}
    for cells in (8, 16):
        path = column(f"spline{cells}", cells=cells, more=["-initial_stress k0"])
        first, most = rest(path, f"spline{cells}", "-output_format", "none", "-method_basis", "bspline2", "-method_flip", "1",
                           "-method_update", "usl", "-report_indicator", "false", steps=600 if cells == 8 else 1)
        found[cells] = first
        if cells == 8:
            h = check.history("output/spline8.csv")
            sinks = -h["external_work"] / (h["mass"] * G)
            early, late = sinks[100:300].mean(), sinks[-200:].mean()
            check.that(np.abs(sinks).max() < 5e-5 and abs(late - early) < 2e-6,
                       f"splines: the centre moves by {np.abs(sinks).max():.1e} of the height, on average {early:.1e}, later {late:.1e}")
    check.that(found[8] < 0.02 and found[16] < 0.8 * found[8], f"splines: the residual is {found[8]:.4f} and {found[16]:.4f} of g for 8 and 16 cells")


def check_restless():
    """A body that cannot rest in the stress by its weight gets a warning that says where it moves; one that shall move or settle gets none."""
    def first(name, *options, free=(), lower="0,0", upper="0.5,1", n=1, cells=8):
        path = column(name, cells=cells, bodies=["-bodies b", "-body_b_shape box", f"-body_b_lower {lower}", f"-body_b_upper {upper}", "-body_b_material m"],
                      more=["-initial_stress k0", "-time_max_steps 1", "-output_every 0", "-material_m_cohesion 1e5"] + [f"-bc_{face}_type free" for face in free])
        with open(path) as file:  # the last of two lines would contradict the first
            lines = [line for line in file if not any(line == f"-bc_{face}_type slip\n" for face in free)]
        run = check.must("-options_file", check.write(path, "".join(lines)), "-report_indicator", "false", *options, n=n)
        return run, re.search(r"^warning    b does not rest in its stress of -initial_stress k0: near \((\S+), (\S+)\) it starts with an acceleration of (\S+) g\. "
                              r"It needs a level surface, a wall below and walls at all sides; else let it settle with -damping_kinetic$", run.out, re.M)

    for x in 0.125, 0.25:
        run = check.must("-options_file", column("sill", cells=16, bodies=["-bodies b,r", "-body_b_shape box", "-body_b_lower 0,0", "-body_b_upper 0.5,1", "-body_b_material m", "-body_b_cut r", "-body_r_shape box",
                         f"-body_r_lower {x},0.375", f"-body_r_upper {x + 0.125},0.5", "-body_r_rigid fixed"], more=["-initial_stress k0", "-time_max_steps 1", "-material_m_cohesion 1e5"]), "-report_indicator", "false")  # fmt: skip
        said = re.search(r"b does not rest in its stress of -initial_stress k0: near \(\S+, \S+\), beside the rigid body r, it starts with an acceleration of (\S+) g\. It needs a level surface, a wall below and walls at all sides, and no rigid body; else let it settle with -damping_kinetic$", run.out, re.M)
        check.that(said, f"beside a rigid body in it: {run.find('^warning +(.*does not rest.*)$')}")
    for what, more in (("no wall below", dict(free=["ymin"])), ("a gap below", dict(lower="0,0.25")), ("no wall at one side", dict(free=["xmax"])),
                       ("a gap at one side", dict(upper="0.375,1"))):
        name = what.replace(" ", "_")
        run, warned = first(name, **more)
        p = check.particles(f"output/{name}.h5")
        a = np.linalg.norm(p["v"], axis=1) / (G * check.history(f"output/{name}.csv")["time"][-1])
        k = a.argmax()
        check.that(warned and abs(float(warned[3]) / a[k] - 1) < 0.06 and abs(float(warned[1]) - p["x"][k, 0]) < 1e-4 and abs(float(warned[2]) - p["x"][k, 1]) < 1e-4,
                   f"{what}: {warned and warned[0]}")
        for n, strategy in (2, "spatial"), (3, "pool"):
            again = first(name, "-parallel_strategy", strategy, n=n, **more)[1]
            check.that(warned and again and again[0] == warned[0], f"the same line by {strategy} on {n}")
    # The acceleration of a free side is as large as k0; g is the limit.
    whole = float(first("limit", "-material_m_k0", 0.5, free=["xmax"])[1][3])
    for part in (0.9, 1.1):
        run, warned = first("limit", "-material_m_k0", 0.5 * part / whole, free=["xmax"])
        check.that(bool(warned) == (part > 1), f"a warning at {part} g: {warned and warned[3]}")
    # A slope settles, and gets no warning.
    path = column("slope", bodies=["-bodies b", "-body_b_shape polygon", '-body_b_vertices "0,0 0.5,0 0.5,0.6 0.1,1 0,1"', "-body_b_material m"],
                  more=["-initial_stress k0", "-time_max_steps 1", "-material_m_cohesion 1e5"])
    check.that("does not rest" not in check.must("-options_file", path, "-report_indicator", "false").out, "no warning of a slope of 45 degrees")
    path = column("free", bodies=["-bodies b,r", "-body_b_shape box", "-body_b_lower 0,0", "-body_b_upper 0.25,1", "-body_b_material m", "-body_r_shape box",
                                  "-body_r_lower 0.3,0", "-body_r_upper 0.4,0.1", "-body_r_rigid free", "-body_r_rho 1000"], more=["-initial_stress k0", "-time_max_steps 1"])
    said = re.search(r"else let it settle (.*)$", check.must("-options_file", path, "-report_indicator", "false").out, re.M)
    check.that(said and said[1] == "first, since rigid bodies that are free cannot be damped: start later what is to be seen", f"beside a free rigid body: {said and said[1]}")
    path = column("plate", bodies=["-bodies b,r", "-body_b_shape box", "-body_b_lower 0,0", "-body_b_upper 0.5,0.75", "-body_b_material m", "-body_r_shape box", "-body_r_lower 0,0.75",
                                   "-body_r_upper 0.25,0.9", "-body_r_rigid moving", "-body_r_velocity 0,-0.1"], more=["-initial_stress k0", "-time_max_steps 1"])
    check.that("does not rest" not in check.must("-options_file", path, "-report_indicator", "false").out, "no warning below a plate that moves from the start")
    for what, options in (("it shall settle", ["-damping_kinetic"]), ("it has a velocity", ["-body_b_velocity", "0,1e-3"])):
        run, warned = first("meant", *options, free=["ymin"])
        check.that(not warned, f"no warning where {what}")


def check_states():
    """Stress and F of the particles at the start, against the formulas."""
    def start(name, law, *options):
        check.must("-options_file", column(name, law=law), "-time_max_steps", 1, "-time_end", 1e-9, "-output_name", name, *options)
        return check.particles(f"output/{name}.h5", 0)

    tau = "-1.5e4*(1-y)-1e3*x-500, 1e3*x, -2e4*(1-y)-1e3"
    for law in ("elastic", "neohookean", "vonmises", "druckerprager"):
        p = start("formula_" + law, law, "-initial_stress", tau)
        x, y = p["x"][:, 0], p["x"][:, 1]
        F = p["F"].reshape(-1, 3, 3)
        J = np.linalg.det(F)
        s = p["stress"].reshape(-1, 3, 3) * J[:, None, None]
        want = np.array([-1.5e4 * (1 - y) - 1e3 * x - 500, 1e3 * x, -2e4 * (1 - y) - 1e3]).T
        wrong = np.abs(np.stack([s[:, 0, 0], s[:, 0, 1], s[:, 1, 1]], 1) - want).max()
        check.that(wrong < 1e-6 and np.abs(F - F.transpose(0, 2, 1)).max() == 0 and np.abs(F[:, 2, 2] - 1).max() == 0,
                   f"{law}: stress by formula to {wrong:.1e} Pa; F is symmetric and has no strain along z")
    p = start("bent", "neohookean", "-body_b_deformation", "1+0.1*x, 0.05, 0, 0.9")
    F = p["F"].reshape(-1, 3, 3)
    x = p["x"][:, 0]
    check.that(np.abs(F[:, 0, 0] - 1 - 0.1 * x).max() < 1e-15 and (F[:, 0, 1] == 0.05).all() and (F[:, 1, 0] == 0).all()
               and (F[:, 1, 1] == 0.9).all(), "F by formula")
    mu, lam = 1e6 / 2.6, 0.3e6 / (1.3 * 0.4)
    J = 0.9 * (1 + 0.1 * x)
    W = mu / 2 * ((1 + 0.1 * x)**2 + 0.05**2 + 0.81 - 2 - 2 * np.log(J)) + lam / 2 * np.log(J)**2
    h = check.history("output/bent.csv")
    V0 = (1 / 16)**2
    check.that(abs(h["strain_energy"][0] / (W.sum() * V0) - 1) < 1e-12, "F by formula: the energy is that of the law")
    p = start("pressed", "fluid", "-body_b_deformation", "0.9, 0, 0, 0.8")
    pressure = 1e6 / 7 * (0.72**-7 - 1)
    check.that(np.abs(p["volume"] / V0 - 0.72).max() < 1e-15 and np.abs(p["stress"][:, 0] / -pressure - 1).max() < 1e-13,
               "F of a fluid: its volume and pressure")
    p = start("sheared", "vonmises", "-body_b_deformation", "1, 0.01, 0, 1")
    e = math.asinh(0.005)  # principal logarithmic strains of a simple shear
    s = p["stress"].reshape(-1, 3, 3)[0]
    difference = math.hypot(s[0, 0] - s[1, 1], 2 * s[0, 1])
    check.that(abs(difference / (4 * mu * e) - 1) < 1e-9, "F of a plastic law: be = F F^T")


def check_equal():
    """The same bits on 1 and 3 processes and in the pool, with domains that stretch too; a restart goes on with them."""
    path = column("equal", cells=16, more=["-initial_stress k0", "-time_max_steps 12"])
    for what, more in (("splines", []), ("stretched", ["-method_basis", "gimp", "-method_gimp_update", "stretch"])):
        runs = [check.must("-options_file", path, *more, *way, n=n).digest
                for n, way in ((1, []), (3, []), (3, ["-parallel_strategy", "pool"]))]
        check.must("-options_file", path, *more, "-time_max_steps", 5, "-checkpoint_every", 1e30, n=3)
        runs.append(check.must("-options_file", path, *more, "-restart_file", "latest").digest)
        check.that(len(set(runs)) == 1 and runs[0], f"{what}: digests {' '.join(runs)}")


check_rest()
check_stiff()
check_restless()
check_splines()
check_states()
check_equal()
check.end()
