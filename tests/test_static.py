"""Steps without inertia (-method_time static): displacements, stresses and forces of walls beside exact values and published ones,
the limit load of a footing, Newton's convergence for each law, bodies cut by the grid at random, the same bits where they are
promised, restarts, and what is refused or found wrong while it runs.

usage: test_static.py PEBBLE SOURCE MPIEXEC [PART...]   (parts: the functions check_<part>; default: all)
"""
import math
import re

import h5py
import numpy as np

import check

parts = check.arguments(__doc__, None)
STATIC = ("-method_time", "static", "-checkpoint_wall", "0")
QUIET = ("-output_format", "none", "-history_every", "0")


def body(shape, dim=2, law="neohookean", E="1e6", nu="0.3", rho="1000", **more):
    """Options of one body b of material m; of a box `more` are lower and upper."""
    return [f"-dim {dim}", "-materials m", f"-material_m_model {law}", f"-material_m_rho {rho}", f"-material_m_E {E}",
            f"-material_m_nu {nu}", "-bodies b", f"-body_b_shape {shape}", *(f"-body_b_{k} {v}" for k, v in more.items()), "-body_b_material m"]


def run(name, scene, *options, n=1, status=0):
    """A run of these lines of options, which has to end with this status."""
    result = check.pebble("-options_file", check.write(name + ".opts", scene), *STATIC, "-output_dir", name, *map(str, options), n=n)
    check.fault(None if result.status == status else f"{name}: exit status {result.status}\n{result.said}")
    return result


def particles(name):
    """Datasets of the first and of the last snapshot, by id."""
    with h5py.File(f"{name}/{name}.h5") as file:
        steps = sorted(k for k in file if k.startswith("step_"))
        both = [{k: file[s]["particles"][k][:] for k in ("id", "x", "stress", "F")} for s in (steps[0], steps[-1])]
    for one in both:
        order = np.argsort(one["id"].ravel())
        for k in one:
            one[k] = one[k][order]
    return both


def moved(name):
    """Positions at the start and displacements at the end."""
    first, last = particles(name)
    return first["x"], last["x"] - first["x"]


def newton(result):
    return int(result.find(r"^static .* with (\d+) Newton"))


# The clamped beam that finite elements have too, 4 m x 1 m under 0.02 m/s^2: its end falls by 7.7703 mm.
BEAM = ["-grid_lower 0,-1", "-grid_upper 4.5,1.5", "-gravity 0,-0.02", "-bc_xmin_type fixed", *body("box", lower="0,0", upper="4,1", rho=1050),
        "-time_end 1"]


def check_beam():
    """Small deflection beside finite elements; the force of the wall is the weight; strain energy is the work of gravity."""
    for h in (0.25, 0.125):
        result = run("beam", BEAM, "-grid_h", f"{h},{h}", "-history_walls", "xmin", "-history_every", "0.1")
        x, u = moved("beam")
        end = u[x[:, 0] > x[:, 0].max() - 1e-9, 1].mean()
        check.that(abs(end / -0.0077703 - 1) < 0.0075, f"h = {h}: the end falls by {-1e3 * end:.4f} mm, 7.7703 by finite elements")
        last = check.history("beam/beam.csv")
        check.that(abs(last["reaction_xmin_y"][-1] / 84 - 1) < 1e-9, f"h = {h}: the wall carries {last['reaction_xmin_y'][-1]:.12g} N, the weight is 84 N")
        check.that(abs(last["energy_residual"][-1]) < 2e-3 * last["strain_energy"][-1],
                   f"h = {h}: of the work of gravity {last['external_work'][-1]:.5g} J, {last['energy_residual'][-1]:.2g} J are missing")
        check.that(last["newton_iterations"][-1] == newton(result) and last["steps_cut"][-1] == 0 and last["force_unbalanced"][-1] < 1e-7,
                   f"h = {h}: the history has {last['newton_iterations'][-1]:g} iterations, and {last['force_unbalanced'][-1]:.2g} N out of balance")
    parts = [line for line in BEAM if not line.startswith("-time_end")] + ["-stages a,b", "-stage_a_time 1", "-stage_b_time 1", "-dt_size 0.5", "-grid_h 0.25,0.25", "-history_walls xmin", "-history_every 0"]
    run("stages", parts, *QUIET[:2])
    carried = check.history("stages/stages.csv")["reaction_xmin_y"]
    check.that(np.allclose(carried, [0, 42, 84, 84, 84], rtol=1e-6), f"in a second stage gravity acts whole: the wall carries {', '.join(f'{v:.6g}' for v in carried)} N")
    # Reissner's beam of AMPLE under 100 kN at its end (Coombs and Augarde 2020): it has fallen by 0.8175 of its length.
    long = ["-grid_lower 0,-9.5", "-grid_upper 11,2", "-grid_h 0.5,0.5", "-bc_xmin_type fixed", *body("box", law="vonmises", E="12e6", nu="0.2",
            rho=1, lower="0,-0.5", upper="10,0.5", ppc="3,3"), "-material_m_yield 1e30", "-method_locking none", "-loads end", "-load_end_body b", "-load_end_type traction",
            "-load_end_face xmax", "-load_end_value 0,-1e5*t", "-time_end 1"]
    run("long", long)
    x, u = moved("long")
    end = u[x[:, 0] > x[:, 0].max() - 1e-9].mean(0)
    check.that(abs(-end[1] / 8.175 - 1) < 0.02 and abs(-end[0] / 5.480 - 1) < 0.02, f"the long beam's end moves by {end[0]:.3f}, {end[1]:.3f} m; Reissner: -5.480, -8.175")


def check_column():
    """A column under its own weight, as high at first as rho g l/E = 1: exact positions and stress for neo-Hookean nu = 0."""
    def exact(X):
        I = lambda z: (z * math.sqrt(1 + z * z) + math.asinh(z) - z * z) / 2
        return I(1) - I(1 - X)

    errors = []
    for n in (8, 16, 32):
        run("column", ["-grid_lower 0", "-grid_upper 1", f"-grid_cells {n}", "-gravity -1000", "-bc_xmin_type fixed", "-dt_size 0.05",
                       *body("box", 1, nu=0, lower=0, upper=1), "-time_end 1"])
        first, last = particles("column")
        X, x = first["x"][:, 0], last["x"][:, 0]
        stress = last["stress"].reshape(len(X), -1)[:, 0]
        errors.append((np.sqrt(np.mean((x - [exact(v) for v in X]) ** 2)), np.sqrt(np.mean((stress / 1e6 + (1 - X)) ** 2))))
    order = [math.log2(a[k] / b[k]) for k in (0, 1) for a, b in (errors[-2:],)]
    check.that(errors[-1][0] < 2e-4 and order[0] > 1.5, f"positions: errors {[f'{e[0]:.2g}' for e in errors]}, order {order[0]:.2f}")
    check.that(errors[-1][1] < 2e-2 and order[1] > 0.8, f"stress: errors {[f'{e[1]:.2g}' for e in errors]}, order {order[1]:.2f}")


def check_patch():
    """A bar that a moving wall stretches, with nu = 0, is stretched equally up to its free sides, which cut cells: with every basis,
    and nodes that are stabilised, in 1-D to 3-D."""
    for dim in (1, 2, 3):
        for basis in ("linear", "gimp", "bspline2", "bspline3"):
            one = lambda a, rest: ",".join([str(a)] + [str(rest)] * (dim - 1))
            scene = [f"-grid_lower {one(0, 0)}", f"-grid_upper {one(1, 1)}", f"-grid_cells {one(6, 5)}", "-bc_xmin_type slip",
                     "-bc_xmax_type moving", f'-bc_xmax_velocity "{",".join(["0.1"] + ["0"] * (dim - 1))}"',
                     *body("box", dim, nu=0, lower=one(0, 0), upper=one(1, "0.93")), "-time_end 1", f"-method_basis {basis}"]
            scene += ["-bc_ymin_type slip", "-bc_zmin_type slip"][:dim - 1]
            run("patch", scene, "-snes_rtol", 1e-13, *(("-ksp_type", "preonly", "-pc_type", "lu") if dim == 3 else ()))
            first, last = particles("patch")
            F = last["F"].reshape(-1, 3, 3)
            spread, size = np.abs(F - F.mean(0)).max(), np.abs(F.mean(0) - np.eye(3)).max()
            check.that(abs(size - 0.1) < 1e-10 and spread < 1e-10, f"{dim}-D, {basis}: F differs by {spread:.1g} between particles, strain {size:.9f}")


def check_soft():
    """A stiff body elsewhere in the scene changes nothing: springs of weak nodes are as stiff as the matter there. Sand without
    cohesion carries its weight, although it starts with a stress at the apex of its cone."""
    block = ["-dim 2", "-bodies a,b", "-materials clay,steel", *(f"-material_{m}_{k} {v}" for m, law in (("clay", "vonmises"), ("steel", "neohookean"))
             for k, v in dict(model=law, rho=1800, nu=0.3, **({"E": 1e7, "yield": 2e4} if m == "clay" else {})).items()),
             "-grid_lower 0,0", "-grid_upper 4,2", "-grid_cells 16,8", "-bc_ymin_type fixed", "-gravity 0,-9.81", "-time_end 1", "-dt_size 0.1",
             "-body_a_shape box", "-body_a_lower 0.3,0", "-body_a_upper 1.4,0.9", "-body_a_material clay", "-body_b_shape box", "-body_b_lower 3,0", "-body_b_upper 3.7,0.9", "-body_b_material steel"]
    for name, E in (("hard", 3e10), ("soft", 1e7)):
        run(name, block, "-material_steel_E", E)
    start, hard = moved("hard")
    here = start[:, 0] < 2
    off = np.abs(hard - moved("soft")[1])[here].max() / np.abs(hard[here]).max()
    check.that(off < 1e-6, f"steel beside clay changes the clay's displacements by {off:.1e} of them")
    sand = body("box", law="druckerprager", E="2e7", rho=2000, lower="0,0", upper="2,10")
    run("sand", sand + ["-material_m_friction_angle 35", "-grid_lower 0,0", "-grid_upper 2,12", "-grid_cells 4,24", "-bc_xmin_type slip", "-bc_xmax_type slip", "-bc_ymin_type fixed", "-gravity 0,-9.81", "-time_end 1"])
    top = moved("sand")[1][:, 1].min()
    exact = -2000 * 9.81 * 100 / 2 / (2e7 * 0.7 / (1.3 * 0.4))
    check.that(abs(top / exact - 1) < 0.02, f"sand without cohesion settles by {1000 * top:.2f} mm, small strains {1000 * exact:.2f}")


def check_cylinder():
    """A thick cylinder under pressure from inside beside Lame: a quarter between planes of symmetry; the error falls."""
    errors = []
    for n in (8, 16):
        scene = ["-grid_lower 0,0", "-grid_upper 2.5,2.5", f"-grid_h {1 / n},{1 / n}", "-bc_xmin_type slip", "-bc_ymin_type slip",
                 *body("expression", E="1000", expression='"min(4-x^2-y^2,x^2+y^2-1)"', lower="0,0", upper="2,2"), "-loads p", "-load_p_body b", "-load_p_type pressure",
                 '-load_p_value "0.01*t*(X^2+Y^2<2.25)"', "-time_end 1", "-dt_size 0.5"]
        run("cylinder", scene)
        x, u = moved("cylinder")
        r = np.hypot(x[:, 0], x[:, 1])
        exact = 1.3e-3 * 0.01 / 3 * (0.4 * r + 4 / r)
        got = (u[:, 0] * x[:, 0] + u[:, 1] * x[:, 1]) / r
        errors.append(np.sqrt(np.mean((got - exact) ** 2)) / np.sqrt(np.mean(exact ** 2)))
    check.that(errors[1] < 0.03 and errors[1] < errors[0], f"radial displacement: errors {errors[0]:.3g}, {errors[1]:.3g}")


ROUND = ["-geometry axisymmetric", "-grid_lower 0,0", "-bc_xmin_type slip", "-bc_ymin_type slip", "-loads p", "-load_p_body b", "-load_p_type pressure", "-time_end 1"]


def ring(n, **more):
    """A disk of a thick cylinder, 1 m and 2 m in radius, between smooth walls."""
    return [*ROUND, "-grid_upper 2.5,1", f"-grid_h {1 / n},{1 / n}", "-bc_ymax_type slip", "-load_p_face xmin", *body("box", lower="1,0", upper="2,1", **more)]


def shell(n, **more):
    """Half of a thick ball, 1 m and 2 m in radius."""
    return [*ROUND, "-grid_upper 2.5,2.5", f"-grid_h {1 / n},{1 / n}", *body("expression", lower="0,0", upper="2,2", expression='"min(4-x^2-y^2,x^2+y^2-1)"', ppc="3,3", **more)]


def check_round():
    """Bodies of revolution: a thick cylinder and a thick ball under pressure from inside beside Lame; Newton's method converges as
    fast in large strain, with F-bar too; the same bits after a restart, the same displacements on several processes."""
    errors, limits = {}, {}
    for n in (8, 16):
        for name, scene, load, exact in (("ring", ring(n, E="1000"), "0.01*t", lambda r: 1.3e-3 * 0.01 / 3 * (0.4 * r + 4 / r)),
                                         ("shell", shell(n, E="1000"), "0.01*t*(X^2+Y^2<2.25)", lambda r: 1e-5 / 7 * (0.4 * r + 0.65 * 8 / r**2))):
            run(name, scene, "-load_p_value", load, "-dt_size", 0.5)
            x, u = moved(name)
            R = x[:, :2] if name == "shell" else x[:, :1]
            r = np.sqrt((R**2).sum(1))
            want, got = exact(r), (u[:, :R.shape[1]] * R).sum(1) / r
            errors[name, n] = np.sqrt(np.mean((got - want) ** 2) / np.mean(want**2))
    check.that(errors["ring", 8] < 1.5e-3 and errors["ring", 16] < 5e-4, f"cylinder: errors {errors['ring', 8]:.2g}, {errors['ring', 16]:.2g}")
    check.that(errors["shell", 16] < 0.01 and errors["shell", 8] < 0.02, f"ball: errors {errors['shell', 8]:.2g}, {errors['shell', 16]:.2g}")
    for more in ((), ("-material_m_nu", 0.49, "-method_locking", "fbar")):
        told = run("ring", ring(8, E="1000"), "-load_p_value", "100*t", "-dt_size", 1, "-dt_strain", 10, "-snes_monitor", "-snes_rtol", 1e-11, *more, *QUIET)
        norms = [float(v) for v in re.findall(r"SNES Function norm (\S+)", told.out)]
        rate = math.log(norms[-1] / norms[-2]) / math.log(norms[-2] / norms[-3])
        check.that(rate > 1.5, f"large strain {more}: residuals {' '.join(f'{v / norms[0]:.1e}' for v in norms)}, ratio {rate:.2f}")
    # Flow at the yield stress Y begins to fill the wall at 2/sqrt(3) Y ln 2 in the cylinder, at 2 Y ln 2 in the ball.
    for name, scene, load, known in (("ring", ring(8, law="vonmises", E="1e4"), "2*t", 2 / math.sqrt(3) * math.log(2)),
                                     ("shell", shell(8, law="vonmises", E="1e4"), "2*t*(X^2+Y^2<2.25)", 2 * math.log(2))):
        told = run(name, scene, "-material_m_yield", 1, "-load_p_value", load, "-dt_retry", 4, *QUIET, status=3)
        limits[name] = 2 * float(re.search(r"stopped at step \d+, t=(\S+) s", told.said)[1]) / known
    check.that(0.97 < limits["ring"] < 1.03 and 0.95 < limits["shell"] < 1.1, f"limits over those known: cylinder {limits['ring']:.3f}, ball {limits['shell']:.3f}")
    updated_round()
    scene = [*ring(8, E="1000"), "-load_p_value 100*t"]
    whole = [run(f"round{n}", scene, n=n) for n in (1, 2, 3)]
    off = max(np.abs(moved(f"round{n}")[1] - moved("round1")[1]).max() for n in (2, 3))
    check.that(off < 1e-7, f"1, 2, 3 processes: displacements differ by {off:.2g} m")
    run("roundgo", scene, "-time_max_steps", 5, "-checkpoint_every", 0.1)
    again = run("roundgo", scene, "-restart_file", "latest")
    check.that(again.digest == whole[0].digest, f"restarted: {again.digest}, whole {whole[0].digest}")


def updated_round():
    """The same in the updated frame: Lame, the limit of the cylinder, fast convergence in the second step, a wide cylinder beside the exact
    stretches that it has in large strain, bits after a restart, several processes."""
    for n, most in ((8, 1.5e-3), (16, 5e-4)):
        run("ring", ring(n, E="1000"), "-load_p_value", "0.01*t", "-dt_size", 0.5, *UPDATED)
        x, u = moved("ring")
        want = 1.3e-3 * 0.01 / 3 * (0.4 * x[:, 0] + 4 / x[:, 0])
        error = np.sqrt(np.mean((u[:, 0] - want) ** 2) / np.mean(want**2))
        check.that(error < most, f"updated frame, cylinder, {n} cells: error {error:.2g}")
    for more in ((), ("-material_m_nu", 0.49, "-method_locking", "fbar")):
        told = run("ring", ring(8, E="1000"), "-load_p_value", "100*t", "-dt_size", 0.5, "-dt_strain", 10, "-snes_monitor", "-snes_rtol", 1e-11, *more, *UPDATED, *QUIET)
        norms = [float(v) for v in re.findall(r"SNES Function norm (\S+)", told.out.rpartition("  0 SNES")[2])]
        norms = [v for v in norms if v > 1e-12 * norms[0]]
        rate = math.log(norms[-1] / norms[-2]) / math.log(norms[-2] / norms[-3])
        check.that(rate > 1.5, f"updated frame, large strain {more}: residuals {' '.join(f'{v / norms[0]:.1e}' for v in norms)}, ratio {rate:.2f}")
    told = run("ring", ring(8, law="vonmises", E="1e4"), "-material_m_yield", 1, "-load_p_value", "2*t", "-dt_retry", 4, *UPDATED, *QUIET, status=3)
    limit = 2 * float(re.search(r"stopped at step \d+, t=(\S+) s", told.said)[1]) / (2 / math.sqrt(3) * math.log(2))
    check.that(0.97 < limit < 1.03, f"updated frame, limit over that known: {limit:.3f}")
    # A disk that is pulled at its rim, of constant height, is stretched by F along r and around the axis: P = lambda ln(F^2)/F + mu (F - 1/F).
    wide = ["-geometry axisymmetric", "-grid_lower 0,0", "-grid_upper 2.25,1", "-grid_h 0.125,0.125", "-bc_xmin_type slip", "-bc_ymin_type slip", "-bc_ymax_type slip",
            *body("box", E="1000", lower="0,0", upper="1.5,1"), "-loads p", "-load_p_body b", "-load_p_type traction", "-load_p_face xmax", "-load_p_value 300*t,0", "-time_end 1"]
    pull = lambda F: 300 / 0.52 * 2 * math.log(F) / F + 1000 / 2.6 * (F - 1 / F)
    for frame in ("total", "updated"):
        run("wide", wide, "-dt_size", 0.1, "-method_frame", frame)
        F = particles("wide")[1]["F"].reshape(-1, 3, 3)
        off = [pull(F[:, k, k].mean()) / 300 - 1 for k in (0, 2)]
        check.that(max(map(abs, off)) < 0.01 and F[:, 0, 0].mean() > 1.18, f"{frame} frame: a disk widens by {F[:, 0, 0].mean():.5f}, around the axis by {F[:, 2, 2].mean():.5f}; its stress is off by {off[0]:.1e} and {off[1]:.1e}")
    scene = [*ring(8, E="1000"), "-load_p_value 100*t"]
    whole = {n: run(f"round{n}", scene, *UPDATED, n=n) for n in (1, 2, 3)}
    off = max(np.abs(moved(f"round{n}")[1] - moved("round1")[1]).max() for n in (2, 3))
    check.that(off < 1e-7, f"updated frame, 1, 2, 3 processes: displacements differ by {off:.2g} m")
    run("roundgo", scene, *UPDATED, "-time_max_steps", 5, "-checkpoint_every", 0.1)
    again = run("roundgo", scene, *UPDATED, "-restart_file", "latest")
    check.that(again.digest == whole[1].digest, f"updated frame, restarted: {again.digest}, whole {whole[1].digest}")


def check_separate():
    """Walls that only push: a beam that is lifted at its end leaves the floor where beam theory says; one that is pressed and then
    lifted is where it is without the floor; one that sags comes to lie on it; the sum of forces is right each time."""
    floor = ["-bc_ymin_type separate", "-grid_lower 0,0", "-time_end 1", "-loads p", "-load_p_body b", "-load_p_type traction", "-load_p_face xmax",
             "-history_walls", "ymin", "-history_every", 0.1]
    floor = [*floor[:7], " ".join(map(str, floor[7:9])), " ".join(map(str, floor[9:]))]
    long = [*floor, "-grid_upper 8.5,2", "-grid_h 0.125,0.125", "-bc_xmin_type slip", "-gravity 0,-1", "-gravity_ramp 0",
            *body("box", E="1e5", rho=1, lower="0,0", upper="8,0.5"), "-load_p_value 0,2*t"]  # 1 N at the end, 4 N of weight
    runs = [run(f"lifted{n}", long, n=n) for n in (1, 2)]
    x, u = moved("lifted1")
    foot = x[:, 1] < 0.125
    inertia = 1e5 / 0.91 / 12 * 0.5**3
    last = check.history("lifted1/lifted1.csv")
    up = x[foot & (u[:, 1] > 1e-6), 0].min()
    check.that(abs(last["reaction_ymin_y"][-1] - 3) < 1e-6, f"the floor carries {last['reaction_ymin_y'][-1]:.9f} N, the weight less the force is 3 N")
    check.that(abs(up - 4.19) < 0.3, f"the beam is 1e-6 m above the floor at {up:.3f} m; beam theory: 4.19 m")
    end = u[x[:, 0] > 7.9, 1].mean()
    check.that(abs(end / (0.5 * 4**4 / 24 / inertia) - 1) < 0.08, f"its end is lifted by {1e3 * end:.3f} mm, by beam theory {1e3 * 0.5 * 4**4 / 24 / inertia:.3f} mm")
    check.that(u[:, 1].min() > -1e-4 and runs[0].find(r"solver .* snes (\w+)") == "vinewtonrsls", f"nothing sinks by more than {-1e3 * u[:, 1].min():.3f} mm")
    off = np.abs(moved("lifted2")[1] - u).max()
    check.that(off < 1e-8, f"1 and 2 processes: displacements differ by {off:.2g} m")
    run("go", long, "-time_max_steps", 5, "-checkpoint_every", 0.1)
    again = run("go", long, "-restart_file", "latest")
    check.that(again.digest == runs[0].digest, f"restarted: {again.digest}, whole {runs[0].digest}")
    short = [*floor, "-grid_upper 4.5,2", "-grid_h 0.25,0.25", "-bc_xmin_type fixed", *body("box", E="1e5", rho=1, lower="0,0", upper="4,1"), '-load_p_value "0,40*(t-0.5)"']
    run("pressed", short)
    run("alone", short, "-bc_ymin_type", "free", "-history_walls", "xmin")
    hold = check.history("pressed/pressed.csv")["reaction_ymin_y"]
    off = np.abs(moved("pressed")[1] - moved("alone")[1]).max() / np.abs(moved("alone")[1]).max()
    check.that(hold[1] > 10 and abs(hold[-1]) < 1e-9 and off < 1e-3, f"pressed with 16 N the floor carries {hold[1]:.3f} N, and {hold[-1]:.1g} N from the lifted beam, which moves as without it but for {off:.1g}")
    run("sags", ["-bc_ymin_type separate", "-grid_lower 0,0", "-time_end 1", "-grid_upper 4.5,2", "-grid_h 0.25,0.25", "-bc_xmin_type fixed", "-gravity 0,-1",
                 *body("box", E="1e4", rho=1, lower="0,0.02", upper="4,1.02"), "-history_walls ymin", "-history_every 0.1"])
    x, u = moved("sags")
    rows, hold = x[:, 1] < 0.2, check.history("sags/sags.csv")["reaction_ymin_y"]
    below = 0.02 + u[rows, 1].min()
    check.that(abs(hold[2] - 2 * hold[1]) < 1e-3 and hold[-1] > 10 * hold[1] + 0.1 and abs(below) < 0.004,  # the corner that xmin holds counts to ymin
               f"a beam 2 cm above the floor: the floor carries {hold[1]:.3f}, {hold[2]:.3f} ... {hold[-1]:.3f} N; in the end the beam's foot is {1e3 * below:.2f} mm above it")
    ball = run("ball", ["-geometry axisymmetric", "-grid_lower 0,0", "-grid_upper 1.25,1", "-grid_h 0.0625,0.0625", "-bc_xmin_type slip", "-bc_ymin_type separate",
                        "-bc_ymax_type moving", "-bc_ymax_velocity 0,-0.02", *body("expression", E=1000, rho=1, expression='"1-x^2-(y-1)^2"', lower="0,0", upper="1,1"), "-time_end 1",
                        "-history_walls ymin", "-history_every 0.1"])
    force = check.history("ball/ball.csv")["reaction_ymin_y"][-1]
    check.that(abs(force / (4 / 3 * 1000 / 0.91 * 0.02**1.5) - 1) < 0.08 and newton(ball) < 60, f"a ball pressed on the floor by 0.02 of its radius: {force:.3f} N, Hertz {4 / 3 * 1000 / 0.91 * 0.02**1.5:.3f} N; {newton(ball)} Newton iterations")
    for n in (1, 2):
        run(f"lift{n}", long, *UPDATED, n=n)
    x, u = moved("lift1")
    last = check.history("lift1/lift1.csv")
    up = x[(x[:, 1] < 0.125) & (u[:, 1] > 1e-6), 0].min()
    check.that(abs(last["reaction_ymin_y"][-1] - 3) < 1e-6 and abs(up - 4.19) < 0.3, f"updated frame: the floor carries {last['reaction_ymin_y'][-1]:.9f} N; the beam is above it at {up:.3f} m")
    off = np.abs(moved("lift2")[1] - u).max()
    check.that(u[:, 1].min() > -1e-4 and off < 1e-8, f"nothing sinks by more than {-1e3 * u[:, 1].min():.3f} mm; 1 and 2 processes differ by {off:.2g} m")
    run("press", short, *UPDATED)
    run("free", short, "-bc_ymin_type", "free", "-history_walls", "xmin", *UPDATED)
    hold, other = check.history("press/press.csv")["reaction_ymin_y"], moved("free")[1]
    off = np.abs(moved("press")[1] - other).max() / np.abs(other).max()
    check.that(hold[1] > 10 and abs(hold[-1]) < 1e-9 and off < 2e-3, f"pressed the floor carries {hold[1]:.3f} N, and {hold[-1]:.1g} N from the lifted beam, which moves as without it but for {off:.1g}")
    fall = ["-bc_ymin_type separate", "-grid_lower 0,0", "-time_end 1", "-dt_size 0.05", "-grid_upper 4.5,2.5", "-grid_h 0.25,0.25", "-bc_xmin_type fixed", "-gravity 0,-1",
            *body("box", E="400", rho=1, lower="0,0.75", upper="4,1.75"), "-history_walls ymin", "-history_every 0.05"]
    run("falls", fall, *UPDATED)
    x, u = moved("falls")
    end, hold = 0.75 + u[x[:, 1] < 0.9, 1].min(), check.history("falls/falls.csv")["reaction_ymin_y"]
    check.that(abs(hold[1]) < 1e-9 and hold.min() > -1e-9 and hold[-1] > 0.1 and abs(end) < 0.15, f"a beam 0.75 m above the floor comes to it: {end:.4f} m above it the lowest particle, which carries {hold[-1]:.3f} N")
    through = run("through", ["-bc_ymin_type separate", "-grid_lower 0,0", "-time_end 1", "-grid_upper 4.5,3", "-grid_h 0.25,0.25", "-bc_xmin_type fixed", "-gravity 0,-1",
                              *body("box", E="300", rho=1, lower="0,1", upper="4,2")], *QUIET, status=3)
    check.that("b has met its wall ymin (separate)" in through.said, f"a body that comes from afar is told: {through.err.strip()[-200:]}")


def check_inertia():
    """Implicit steps with inertia: a standing wave in a bar beside what one mode does with these steps, up to 128 times as long as
    explicit ones; energy; a block that is thrown up and lands; bits."""
    bar = ["-grid_lower 0", "-grid_upper 1", "-grid_cells 128", "-bc_xmin_type fixed", "-bc_xmax_type fixed", *body("box", 1, "elastic", E=1, nu=0, rho=1, lower=0, upper=1),
           "-reference_type standing", "-reference_amplitude 1e-5", "-time_end 0.75"]
    w, exact = math.pi, math.sin(0.75 * math.pi)
    for steps in (3, 6, 12, 24):
        dt = 0.75 / steps
        for time, theory in (("euler", ((1 / (1 - 1j * w * dt)) ** steps).imag), ("newmark", math.sin(2 * steps * math.atan(w * dt / 2)))):
            told = run(time, bar, "-method_time", time, "-dt_size", dt, "-snes_rtol", 1e-10, *QUIET)
            error = float(told.find(r"the relative error is (\S+)"))
            check.that(abs(error * exact / abs(theory - exact) - 1) < (0.01 if time == "euler" or steps < 24 else 0.02), f"{time}, {steps} steps: error {error:.4g}, of one mode {abs(theory / exact - 1):.4g}")
    # Of a beam that its weight sets swinging, far beyond where strain is small: gains and losses of a newmark step cancel.
    swing = ["-grid_lower 0,-1.5", "-grid_upper 4.5,1.5", "-grid_h 0.25,0.25", "-gravity 0,-3", "-bc_xmin_type fixed", *body("box", rho=1050, lower="0,0", upper="4,0.93"), "-time_end 8"]
    off = {}
    for time, more in (("newmark", ("-dt_size", 0.02, "-method_gamma", 0.5, "-snes_rtol", 1e-9)), ("newmark", ()), ("newmark", ("-method_gamma", 0.7)), ("euler", ())):
        told = run("swing", swing, "-method_time", time, "-dt_size", 0.04, *more, "-history_every", 0)
        last = check.history("swing/swing.csv")
        off[time, len(more)] = last["energy_residual"] / last["strain_energy"].max()
    most = np.abs(off["newmark", 0]).max()
    half = np.abs(off["newmark", 6]).max()
    check.that(most < 2e-3 and half < most, f"newmark keeps the energy of a swinging beam to {most:.2g} of it in 200 steps, and to {half:.2g} in 400 steps of half the length")
    check.that(off["newmark", 2][-1] < -0.05 and off["euler", 0][-1] < -0.2, f"gamma = 0.7 and euler take {-off['newmark', 2][-1]:.2f} and {-off['euler', 0][-1]:.2f} of it")
    runs = {n: run(f"swing{n}", swing, "-method_time", "newmark", "-dt_size", 0.1, "-time_end", 2, n=n) for n in (1, 2, 3)}
    for n in (2, 3):
        apart = np.abs(moved(f"swing{n}")[1] - moved("swing1")[1]).max()
        check.that(apart < 1e-6, f"newmark, {n} processes and 1: displacements differ by {apart:.2g} m")
    run("swinggo", swing, "-method_time", "newmark", "-dt_size", 0.1, "-time_end", 2, "-time_max_steps", 9, "-checkpoint_every", 0.5)
    again = run("swinggo", swing, "-method_time", "newmark", "-dt_size", 0.1, "-time_end", 2, "-restart_file", "latest")
    check.that(again.digest == runs[1].digest, f"restarted: {again.digest}, whole {runs[1].digest}")
    run("thrown", ["-grid_lower 0,0", "-grid_upper 2,2", "-grid_h 0.25,0.25", "-gravity 0,-1", "-bc_ymin_type separate", *body("box", lower="0.5,0", upper="1.5,1", velocity="0,0.5"),
                   "-time_end 3", "-history_every 0.1", "-history_walls ymin"], "-method_time", "euler", "-dt_size", 0.01)
    last, ground = check.history("thrown/thrown.csv"), moved("thrown")[1][:, 1].min()
    check.that(abs(last["kinetic_energy"][5] / 125) < 1e-9 and abs(last["reaction_ymin_y"][5]) < 1e-6, f"thrown up, the floor gives {last['reaction_ymin_y'][5]:.1g} N and it stands still after 0.5 s, {last['kinetic_energy'][5]:.1g} J are left of 125 J")
    check.that(abs(last["reaction_ymin_y"][-1] / 1000 - 1) < 1e-5 and abs(ground) < 5e-3, f"when it has landed, the floor carries {last['reaction_ymin_y'][-1]:.4f} N of its weight of 1000 N, and it stands {1e3 * ground:.2f} mm above it")
    far = run("far", swing, "-method_time", "euler", "-dt_size", 1, "-gravity", "0,-1e5", "-dt_retry", 1, *QUIET, status=3)
    check.that("no solution of the step was found" in far.said, "a step that has no solution is told")


def check_start():
    """Explicit runs that start from the state of a static one, in both frames: a slope that is at rest stays so, but for what the springs of
    weak nodes held; one whose crest is loaded then fails. What may not change is refused."""
    slope = ["-grid_lower 0,0", "-grid_upper 35,16.25", "-grid_h 0.625,0.625", "-gravity 0,-10", "-bc_xmin_type slip", "-bc_xmax_type slip", "-bc_ymin_type fixed",
             *body("polygon", vertices='"0,0 35,0 35,5 25,5 15,15 0,15"', law="druckerprager", E="1e8", rho=2000), "-material_m_fit plane_strain", "-material_m_cohesion 20e3",
             "-material_m_friction_angle 20", "-material_m_dilation_angle 0", "-gravity_ramp 0.5", "-time_end 1", "-dt_size 0.1", "-loads crest", "-load_crest_body b",
             "-load_crest_type pressure", "-load_crest_face ymax", "-load_crest_value 0*t", "-checkpoint_every 1"]
    weight, files = 2000 * 10 * (35 * 5 + 15 * 10 + 50), {}
    for factor, most in ((1e-3, 6e-5), (1e-5, 1e-6)):
        name = f"slope{factor:g}"
        run(name, slope, "-method_stabilize_factor", factor)
        files[factor] = f"{name}/{name}-checkpoint-1.h5"
        idle = run("idle", slope, "-method_stabilize_factor", factor, "-time_end", 1.1, "-restart_file", files[factor], "-snes_monitor", *QUIET[:2])
        force = float(re.search(r"0 SNES Function norm (\S+)", idle.out)[1])
        check.that(force < most * weight, f"springs of {factor:g}: in the next step {force / weight:.2g} of the weight are out of balance, the norm of all nodes")
    for frame, name, more, most in (("total", "rests", (), 1e-6), ("updated", "moves", ("-method_preset", "balanced"), 1e-4)):
        go = ("-method_time", "explicit", "-method_frame", frame, *more, "-dt_size", "auto", "-restart_file", files[1e-5])
        run(name, slope, *go, "-time_end", 1.3, "-history_every", 0)
        last = check.history(f"{name}/{name}.csv")
        share = last["kinetic_energy"].max() / last["strain_energy"][0]
        off = np.abs(last["energy_residual"] - last["energy_residual"][0]).max() / last["strain_energy"][0]
        check.that(share < most and off < (3e-4 if frame == "total" else 3e-3), f"{frame} frame, explicit: kinetic energy up to {share:.2g} of the strain energy, {off:.2g} of it is missing")
    fails = ("-method_time", "explicit", "-method_preset", "balanced", "-dt_size", "auto", "-restart_file", files[1e-5])
    digests = {run(f"fails{n}", slope, *fails, "-load_crest_value", "6e5*(X<15)*(X>7)*min(1,5*(t-1))", "-time_end", 1.6, "-check_parting", "warn", n=n).digest for n in (1, 2)}
    x, u = moved("fails1")
    check.that(len(digests) == 1 and np.abs(u).max() > 0.5, f"with a load on its crest it moves by up to {np.abs(u).max():.2f} m; on 1 and 2 processes {digests}")
    for options, line, status in ((("-grid_h", "1.25,1.25"), "-grid_h is 0.625,0.625 in the checkpoint", 2), (("-method_basis", "gimp", "-method_gimp_update", "stretch"), "-method_gimp_update is", 2),
                                  (("-method_preset", "solid", "-method_basis", "linear"), "in the total frame the state is on the nodes of the basis", 2)):
        told = run("refused", slope, *fails, *options, "-time_end", 2, *QUIET, status=status)
        check.that(line in told.said, f"{options}: {told.err.strip()[-160:]}")
    told = run("taken", slope, *fails, "-method_basis", "linear", "-method_update", "musl", "-method_transfer", "flip", "-time_end", 2, "-time_max_steps", 12, *QUIET)
    check.that(told.good, f"basis, update and transfer of a motion that follows statics: {told.err.strip()[-160:]}")
    block = ["-grid_lower 0,0", "-grid_upper 2,2", "-grid_h 0.25,0.25", "-gravity 0,-1", "-bc_ymin_type fixed", *body("box", lower="0.5,0", upper="1.5,1")]
    for given, status in (((), 3), (("-body_b_ppc", "2,2"), 0)):
        run("block", block, *given, "-dt_size", 1, "-time_end", 1, "-checkpoint_every", 1)
        told = run("block", block, *given, "-method_time", "explicit", "-method_preset", "accurate", "-dt_size", "auto", "-restart_file", "latest", "-time_end", 1.01, status=status)
        check.that(told.good or "its particles have other masses, volumes" in told.said, f"then a preset with 3 x 3 particles a cell, {given}: {told.err.strip()[-160:]}")


FOOTING = ["-grid_lower 0,0", "-grid_upper 6,3.5", "-bc_xmin_type slip", "-bc_xmax_type slip", "-bc_ymin_type fixed",
           *body("box", law="vonmises", E="1000", rho=1, lower="0,0", upper="6,3"), "-material_m_yield 1.7320508", "-loads q", "-load_q_body b",
           "-load_q_type pressure", "-load_q_face ymax", '-load_q_value "8*t*(X<1)"', "-time_end 1"]


def check_footing():
    """A strip footing on clay: loads are carried up to (2 + pi) c, and not beyond; then the run ends with status 3, the state
    of the last equilibrium, and says so. The same load twice gives the same bits."""
    runs = [run(f"footing{k}", FOOTING, "-grid_h", "0.25,0.25", "-dt_retry", 4, "-history_every", 0.01, status=3) for k in range(2)]
    limit = 8 * float(re.search(r"stopped at step \d+, t=(\S+) s", runs[0].said)[1]) / (2 + math.pi)
    check.that(0.95 < limit < 1.15, f"the footing carries {limit:.3f} (2 + pi) c")
    check.that("no equilibrium was found" in runs[0].said and "the state is that before it" in runs[0].said, "the run says that there is no equilibrium")
    check.that(runs[0].digest and runs[0].digest == runs[1].digest, f"twice the same bits: {runs[0].digest}, {runs[1].digest}")
    last = check.history("footing0/footing0.csv")
    check.that(abs(last["time"][-1] * 8 / (2 + math.pi) - limit) < 1e-3 and last["steps_cut"][-1] > 0, f"the history ends at t = {last['time'][-1]:g} s")
    deep = run("deep", FOOTING, "-grid_h", "0.5,0.5", "-load_q_value", "3*t*(X<1)", "-dt_strain", "1e-5", "-dt_retry", "2", status=3)
    check.that("-dt_strain allows 1e-05" in deep.said, "a step with more strain than -dt_strain is not taken")


def check_newton():
    """Newton's method ends as it should with an exact tangent: the logarithms of successive residuals grow by 1.5 or more, with
    F-bar too, also under a pressure."""
    alone, metal = ("-method_locking", "none"), ("-material_m_yield", "0.08")
    pressed = ("-loads", "p", "-load_p_body", "b", "-load_p_type", "pressure", "-load_p_face", "xmax", "-load_p_value", "0.01*t")
    laws = [("elastic", 0.01, ()), ("neohookean", 0.05, ()), ("vonmises", 0.02, (*alone, "-material_m_yield", "1e30")), ("vonmises", 0.02, (*alone, *metal)),
            ("vonmises", 0.02, (*alone, "-material_m_yield", "0.05", "-material_m_hardening", "0.1")),
            ("vonmises", 0.02, (*metal, *pressed)), ("neohookean", 0.02, ("-material_m_nu", 0.49, "-method_locking", "fbar", *pressed)),
            ("druckerprager", 0.02, ("-material_m_friction_angle", 30, "-material_m_dilation_angle", 30, "-material_m_cohesion", 0.02)),
            ("druckerprager", 0.02, ("-material_m_friction_angle", 30, "-material_m_cohesion", 0.02))]
    for law, g, more in laws:
        scene = ["-grid_lower 0,0", "-grid_upper 7,6", "-grid_cells 7,6", "-bc_ymin_type fixed", f"-gravity {0.4 * g},-{g}", "-gravity_ramp 0",
                 *body("box", law=law, E=1, rho=1, lower="1,0", upper="5,4"), "-time_end 1", "-dt_size 1", "-method_stabilize_factor 0.01"]
        result = run("newton", scene, "-snes_monitor", "-snes_linesearch_type", "basic", "-snes_rtol", "1e-11", "-snes_max_it", 30, "-dt_strain", 10, *more, *QUIET)
        norms = [float(v) for v in re.findall(r"SNES Function norm (\S+)", result.out)]
        norms = [v for v in norms if v > 1e-12 * norms[0]]
        ratio = max((math.log(c / b) / math.log(b / a) for a, b, c in zip(norms, norms[1:], norms[2:]) if c < b < a and b < 1e-2 * norms[0]), default=0)
        check.that(ratio >= 1.5, f"{law} {more}: residuals {' '.join(f'{v / norms[0]:.1e}' for v in norms)}, ratio {ratio:.2f}")


UPDATED = ("-method_frame", "updated")


def check_updated():
    """Static steps of the updated frame, whose weights are those of the state as each step begins: a column and beams beside what is
    known, a footing's limit, Newton's convergence with and without F-bar, displacements on several processes, bits after a restart."""
    found = {}
    for basis in ("gimp", "bspline2"):
        errors = []
        for n in (16, 32):
            run("column", ["-grid_lower 0", "-grid_upper 1", f"-grid_cells {n}", "-gravity -1000", "-bc_xmin_type fixed", "-dt_size 0.05", f"-method_basis {basis}",
                           *(["-method_gimp_update stretch"] if basis == "gimp" else []), *body("box", 1, nu=0, lower=0, upper=1), "-time_end 1"], *UPDATED)
            first, last = particles("column")
            X, x = first["x"][:, 0], last["x"][:, 0]
            integral = lambda z: (z * math.sqrt(1 + z * z) + math.asinh(z) - z * z) / 2
            errors.append(np.sqrt(np.mean((x - [integral(1) - integral(1 - v) for v in X]) ** 2)))
        found[basis] = errors
    check.that(found["gimp"][1] < 1e-4 and found["gimp"][1] < 0.4 * found["gimp"][0] and found["bspline2"][1] < 1e-3,
               f"column, half as high in the end: errors of places over its height, 16 and 32 cells: {', '.join(f'{k} {v[0]:.1e} {v[1]:.1e}' for k, v in found.items())}")
    told = run("beam", BEAM, "-grid_h", "0.25,0.25", "-history_walls", "xmin", "-history_every", 0.1, *UPDATED)
    x, u = moved("beam")
    end, last = u[x[:, 0] > x[:, 0].max() - 1e-9, 1].mean(), check.history("beam/beam.csv")
    check.that(abs(end / -0.0077703 - 1) < 0.01, f"beam: the end falls by {-1e3 * end:.4f} mm, 7.7703 by finite elements")
    check.that(abs(last["reaction_xmin_y"][-1] / 84 - 1) < 1e-6, f"the wall carries {last['reaction_xmin_y'][-1]:.12g} N, the weight is 84 N")
    check.that(abs(last["energy_residual"][-1]) < 5e-3 * last["strain_energy"][-1], f"of the work of gravity {last['external_work'][-1]:.5g} J, {last['energy_residual'][-1]:.2g} J are missing")
    long = ["-grid_lower 0,-9.5", "-grid_upper 11,2", "-grid_h 0.5,0.5", "-bc_xmin_type fixed", *body("box", law="vonmises", E="12e6", nu="0.2",
            rho=1, lower="0,-0.5", upper="10,0.5", ppc="3,3"), "-material_m_yield 1e30", "-method_locking none", "-loads end", "-load_end_body b", "-load_end_type traction",
            "-load_end_face xmax", "-load_end_value 0,-1e5*t", "-time_end 1", "-dt_size 0.05"]
    runs = {n: run(f"long{n}", long, *UPDATED, n=n) for n in (1, 2, 3)}
    x, u = moved("long1")
    end = u[x[:, 0] > x[:, 0].max() - 1e-9].mean(0)
    check.that(abs(-end[1] / 8.175 - 1) < 0.03 and abs(-end[0] / 5.480 - 1) < 0.03, f"the long beam's end moves by {end[0]:.3f}, {end[1]:.3f} m; Reissner: -5.480, -8.175")
    for n in (2, 3):
        off = np.abs(moved(f"long{n}")[1] - u).max()
        check.that(off < 1e-5 * 0.5, f"{n} processes and 1: displacements differ by {off:.2g} m")
        check.that(run(f"long{n}", long, *UPDATED, n=n).digest == runs[n].digest, f"{n} processes: {runs[n].digest} twice")
    run("longgo", long, *UPDATED, "-time_max_steps", 9, "-checkpoint_every", 0.1)
    again = run("longgo", long, *UPDATED, "-restart_file", "latest")
    check.that(again.digest == runs[1].digest, f"restarted: {again.digest}, whole {runs[1].digest}")
    told = run("footing", FOOTING, "-grid_h", "0.25,0.25", "-dt_retry", 4, *UPDATED, *QUIET, status=3)
    limit = 8 * float(re.search(r"stopped at step \d+, t=(\S+) s", told.said)[1]) / (2 + math.pi)
    check.that(0.93 < limit < 1.15, f"the footing carries {limit:.3f} (2 + pi) c")
    metal = ("-material_m_yield", "0.08")
    for law, g, more in (("elastic", 0.01, ()), ("neohookean", 0.02, ()), ("vonmises", 0.02, (*metal, "-method_locking", "none")), ("vonmises", 0.02, metal),
                         ("neohookean", 0.08, ("-material_m_nu", 0.49, "-method_locking", "fbar")), ("druckerprager", 0.02, ("-material_m_friction_angle", 30, "-material_m_cohesion", 0.02))):
        scene = ["-grid_lower 0,0", "-grid_upper 7,6", "-grid_cells 7,6", "-bc_ymin_type fixed", f"-gravity {0.4 * g},-{g}", "-loads p", "-load_p_body b", "-load_p_type pressure",
                 "-load_p_face xmax", "-load_p_value 0.01*t", *body("box", law=law, E=1, rho=1, lower="1,0", upper="5,4"), "-time_end 1", "-dt_size 0.5", "-method_stabilize_factor 0.01"]
        told = run("newton", scene, "-snes_monitor", "-snes_linesearch_type", "basic", "-snes_rtol", "1e-11", "-snes_max_it", 30, "-dt_strain", 10, *more, *UPDATED, *QUIET)
        norms = [float(v) for v in re.findall(r"SNES Function norm (\S+)", told.out.rpartition("  0 SNES")[2])]
        norms = [v for v in norms if v > 1e-12 * norms[0]]
        ratio = max((math.log(c / b) / math.log(b / a) for a, b, c in zip(norms, norms[1:], norms[2:]) if c < b < a and b < 1e-2 * norms[0]), default=0)
        check.that(ratio >= 1.5 and len(norms) > 2, f"{law} {more}: second step, residuals {' '.join(f'{v / norms[0]:.1e}' for v in norms)}, ratio {ratio:.2f}")


def check_dug():
    """A layer between smooth walls, of which two bodies are dug away in statics (-remove): its places beside the exact ones of the
    neo-Hookean law under the weight that is left, the weight on the floor, the same bits on two processes."""
    rho, g, E, nu, H = 1900, 9.81, 2e7, 0.3, (14, 12, 10)
    mu, lame = E / 2 / (1 + nu), E * nu / (1 + nu) / (1 - 2 * nu)
    stretch, stress = (lambda F: (F, (mu * (F * F - 1) + lame * np.log(F)) / F))(np.linspace(0.9, 1, 20001))
    boxes = {"ground": (0, 10), "upper": (12, 14), "lower": (10, 12)}
    scene = ["-dim 2", f"-gravity 0,-{g}", "-grid_lower 0,0", "-grid_upper 2,15", "-grid_h 0.5,0.5", "-bc_xmin_type slip", "-bc_xmax_type slip", "-bc_ymin_type fixed", "-materials m", "-material_m_model neohookean",
             f"-material_m_rho {rho}", f"-material_m_E {E}", f"-material_m_nu {nu}", f"-bodies {','.join(boxes)}", "-history_walls ymin", "-history_every 0", "-probes base", "-probe_base_follow 1,9.9",
             "-stages weight,first,second", "-stage_weight_time 1", "-stage_first_time 1", "-stage_first_remove upper", "-stage_second_time 1", "-stage_second_remove lower"]  # fmt: skip
    for name, (low, high) in boxes.items():
        scene += [f"-body_{name}_{what}" for what in ("shape box", f"lower 0,{low}", f"upper 2,{high}", "material m")]
    told = [run("dug", scene, *UPDATED, n=n) for n in (1, 2)]
    check.that(told[0].digest == told[1].digest, f"on 1 and 2 processes: {told[0].digest} {told[1].digest}")
    check.that("history_rest" not in told[0].out and "note       -history_rest adds no columns with -method_time static: each step ends at rest" in run("rests", scene, "-history_rest", "-dry_run", *UPDATED).out,
               "-history_rest stands aside, with a note")
    rows = check.history("dug/dug.csv")
    places, start = [rows["probe_base_y"][rows["stage"] == k][-1] for k in (1, 2, 3)], rows["probe_base_y"][0]
    exact = [np.interp(-rho * g * (high - np.linspace(0, start, 2001)), stress, stretch).mean() * start for high in H]
    for k in (1, 2):
        heave, known = places[k] - places[k - 1], exact[k] - exact[k - 1]
        check.that(abs(heave / known - 1) < 0.005, f"the base rises by {1000 * heave:.3f} mm when the weight of 2 m leaves, exact {1000 * known:.3f}")
    moved = float(told[0].out.rpartition("moved      since the start, at the most: ground by ")[2].partition(" m")[0])
    check.that(abs(moved / (start - places[2]) - 1) < 0.02, f"how far it moved is told: {moved} m, the base {start - places[2]:.4f} m")
    total = run("total", scene, *QUIET, status=2)
    check.that("in the updated one, with -method_frame updated" in total.err, total.err.strip())
    floor = rows["reaction_ymin_y"][rows["stage"] == 3][-1]
    check.that(abs(floor / (rho * g * 20) - 1) < 1e-6, f"the floor carries {floor:.9g} N, the weight that is left is {rho * g * 20:.9g} N")


def sparse(path):
    """The matrix of a file by PETSc's binary viewer, and its rows of one body after another that no entry joins."""
    ints = np.fromfile(path, ">i4")
    n, entries = int(ints[1]), int(ints[3])
    counts, columns = ints[4:4 + n], ints[4 + n:4 + n + entries]
    values = np.frombuffer(open(path, "rb").read()[4 * (4 + n + entries):], ">f8")[:entries]
    rows = np.repeat(np.arange(n), counts)
    of = np.arange(n)  # the least row that is joined to it
    while True:
        least = of.copy()
        np.minimum.at(least, rows, of[columns])
        if (least == of).all():
            break
        of = least
    for first in np.unique(of):
        mine = np.flatnonzero(of == first)
        place = np.full(n, -1)
        place[mine] = np.arange(len(mine))
        inside = place[rows] >= 0
        A = np.zeros((len(mine), len(mine)))
        A[place[rows[inside]], place[columns[inside]]] = values[inside]
        yield A


def check_walls():
    """Periodic faces and moving walls, in both frames: a layer that is pushed sideways along its floor shears by rho g (H - Y)/mu, which is exact at any
    strain; a bar that a wall stretches, with nu = 0, has the same strain everywhere; on 1 and 2 processes."""
    layer = ["-grid_lower 0,0", "-grid_upper 1,1.5", "-grid_cells 8,12", "-bc_xmin_type periodic", "-bc_xmax_type periodic", "-bc_ymin_type fixed", '-acceleration "100*t,0"',
             *body("box", lower="0,0", upper="1,1"), "-time_end 1", "-dt_size 0.25"]
    bar = ["-grid_lower 0,0", "-grid_upper 2,1", "-grid_cells 8,4", "-bc_xmin_type slip", "-bc_xmax_type moving", "-bc_ymin_type slip", *body("box", nu=0, lower="0,0", upper="2,0.6"), "-time_end 1"]
    mu = 1e6 / 2.6
    for frame, most in (("total", 0.01), ("updated", 0.02)):
        for n in (1, 2):
            run("layer", layer, "-method_frame", frame, n=n)
            x, u = moved("layer")
            exact = 1000 * 100 / mu * (x[:, 1] - x[:, 1] ** 2 / 2)
            moves = (u[:, 0] + 0.5) % 1 - 0.5  # what leaves at one face comes in at the other
            off = np.abs(moves - exact).max() / exact.max()
            check.that(off < most and np.abs(u[:, 1]).max() < most * exact.max(), f"{frame} frame, {n} processes, periodic: the layer shears by {moves.max():.5f} m, off by {off:.1e} of {exact.max():.5f}")
            by = 0.1 if frame == "total" else 0.01  # there particles may not leave the grid, whose face stays; only in one step they are where sums are exact
            run("bar", bar, "-method_frame", frame, "-bc_xmax_velocity", f"{2 * by},0", "-dt_size", 0.25 if frame == "total" else 1, n=n)
            F = particles("bar")[1]["F"].reshape(-1, 3, 3)
            off = np.abs(F - np.diag([1 + by, 1, 1])).max() / by
            check.that(off < 1e-6, f"{frame} frame, {n} processes, moving: the bar is stretched by {by:g} everywhere, but for {off:.1e} of it")


def check_lines():
    """Particles on lines of the grid, where the linear basis gives the next nodes no mass but a gradient: they move as those beside the lines."""
    found = {}
    for name, off in (("on", 0), ("near", 1e-7)):
        rows = [f"{1 + off + i / 2:.17g},{off + j / 2 if j else 0.05:.17g},{(0.5 if i in (0, 8) else 1) * (0.5 if j in (0, 4) else 1) / 4:g}" for i in range(9) for j in range(5)]
        check.write("points.csv", ["x,y,volume", *rows])
        lines = ["-grid_lower 0,0", "-grid_upper 7,5", "-grid_h 1,1", "-bc_ymin_type fixed", "-gravity 0.02,-0.02", *body("file", E=1, rho=1, file="points.csv"), "-time_end 1", "-dt_size 1", "-method_basis linear"]
        for frame, n in (("total", 1), ("total", 2), ("updated", 1)):
            run(name, lines, "-method_frame", frame, n=n)
            found[name, frame, n] = moved(name)[1]
    for frame, n in (("total", 1), ("total", 2), ("updated", 1)):
        on, near = found["on", frame, n], found["near", frame, n]
        off = np.abs(on - near).max() / np.abs(near).max()
        check.that(off < 1e-4, f"{frame} frame, {n} processes: on the lines of the grid and 1e-7 beside them displacements differ by {off:.1e} of {np.abs(near).max():.4f}")


def check_modes():
    """Blocks of 4 x 4 cells, turned and stretched at random, at 40 places in the grid: with the springs their stiffness, scaled by its
    diagonal, has no zero modes but the three rigid motions, with all bases and 2 x 2 and 3 x 3 particles a cell; without them, many have."""
    random = np.random.default_rng(46)
    made = [(random.uniform(0, 2 * math.pi), random.uniform(0.9, 1.1, 2), random.uniform(0, 1, 2)) for _ in range(40)]
    for basis, bare in (("linear", (21, 14)), ("gimp", (19, 18)), ("bspline2", (23, 20)), ("bspline3", ())):
        for ppc in (2, 3):
            lattice = (np.stack(np.meshgrid(*2 * [np.arange(4 * ppc)]), -1).reshape(-1, 2) + 0.5) / ppc - 2
            lines = ["x,y,volume"]
            for k, (angle, stretch, shift) in enumerate(made):
                turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
                at = (lattice * stretch) @ turn.T + [12 * (k % 8) + 6, 12 * (k // 8) + 6] + shift
                lines += [f"{x:.17g},{y:.17g},{stretch.prod() / ppc**2:.17g}" for x, y in at]
            check.write("blocks.csv", lines)
            for factor, most in ((1e-3, 600 if bare else 3000), (1e-2, 400 if bare else 15000), (0, None)):
                if not (factor or bare):
                    continue
                run("modes", ["-grid_lower 0,0", "-grid_upper 97,61", "-grid_cells 97,61", "-bc_ymin_type fixed", "-gravity 0,-1", "-gravity_ramp 0", *body("file", E=1, rho=1, file="blocks.csv"), "-time_end 1", "-dt_size 1"], *UPDATED, "-method_basis", basis, "-method_stabilize_factor", factor, "-dt_retry", 0, "-ksp_type", "cg", "-pc_type", "jacobi", "-ksp_max_it", 1, "-ksp_view_mat", "binary:K.bin", *QUIET, status=3)
                null, worst = 0, 0
                for K in sparse("K.bin"):
                    scale = 1 / np.sqrt(K.diagonal())
                    values = np.linalg.eigvalsh(K * scale[:, None] * scale)
                    null += values[3] < 1e-10 * values[-1]
                    worst = max(worst, values[-1] / max(values[3], 1e-300))
                check.that((null == 0 and worst < most) if factor else null > 5, f"{basis}, {ppc} x {ppc} particles, springs of {factor:g}: {null} of 40 places have more than three zero modes" +
                           (f", the worst condition is {worst:.0f}" if factor else f"; another program {bare[ppc - 2]}"))


def check_cuts():
    """A column that leans, at 40 places in the grid: with the stabilisation no place is too weak to be solved, and the top sinks
    alike."""
    found = []
    for k in range(40):
        a, b = 0.37 * k % 1, 0.61 * k % 1
        corners = [(1 + a, 0), (4 + a, 0), (4.8 + a, 3 + b), (1.8 + a, 3 + b)]
        scene = ["-grid_lower 0,0", "-grid_upper 7,5", "-grid_cells 7,5", "-bc_ymin_type fixed", "-gravity 0,-1", "-time_end 1", "-dt_size 1",
                 *body("polygon", vertices='"' + " ".join(f"{x:g},{y:g}" for x, y in corners) + '"')]
        result = run("lean", scene)
        x, u = moved("lean")
        top = x[:, 1] > x[:, 1].max() - 0.7
        found.append(u[top, 1].mean() / (3 + b) ** 2 if result.good else math.nan)
    found = np.array(found)
    check.that(np.all(np.isfinite(found)) and found.std() < 0.12 * abs(found.mean()),
               f"the top sinks by {-1e3 * found.mean():.3f} mm/m^2 of height squared, from {-1e3 * found.max():.3f} to {-1e3 * found.min():.3f}")


def check_memory():
    """The memory of the preconditioner, as a run foretells it before the first step and tells it at its end, and that of the matrices."""
    solid = dict(rho=1050)
    cases = [("-grid_h 0.125,0.125", 2, 1, ()), ("-grid_h 0.0625,0.0625", 2, 1, ()), ("-grid_h 0.0625,0.0625", 2, 1, ("-method_basis", "linear")), ("-grid_h 0.125,0.125", 2, 2, ()),
             ("-grid_cells 200", 1, 1, ()), ("-grid_h 0.25,0.25,0.25", 3, 1, ()), ("-grid_h 0.25,0.25,0.25", 3, 1, ("-ksp_type", "preonly", "-pc_type", "lu"))]
    for cells, dim, n, more in cases:
        one = lambda *values: ",".join(values[:dim])
        scene = [f"-grid_lower {one('0', '-1', '0')}", f"-grid_upper {one('4', '2', '1')}", cells, f"-gravity {one('-0.01', '0', '0')}", "-bc_xmin_type fixed",
                 *body("box", dim, lower=one("0", "0", "0"), upper=one("4", "1", "1"), **solid), "-time_end 1", "-dt_size 1"]
        told = run("memory", scene, *more, *QUIET, n=n)
        matrices, before, after = (float(told.find(p)) for p in (r"matrices of (\S+) MB", r"about (\S+) MB for pc", r"pc took (\S+) MB"))
        most = 2 if "pc gamg" in told.out else 1.6
        check.that(1 / most < before / after < most and matrices > 0, f"{cells} {dim}-D {' '.join(more)} on {n}: matrices {matrices:g} MB, pc about {before:g} MB, took {after:g}")


def check_bits():
    """The same bits on any number of processes where the run promises them: in 1-D and 2-D by the default solver, in both frames, at moving and
    periodic walls, in plastic flow. By other solvers, the same bits each time on the same number; and, but for multigrid, the same bits after a restart."""
    scene = [*BEAM, "-grid_h 0.25,0.25", "-output_every 1"]
    moves = ["-grid_lower 0,0", "-grid_upper 1.25,1", "-grid_cells 15,12", "-bc_xmin_type slip", "-bc_ymin_type moving", '-bc_ymin_velocity "0,0.05"', "-bc_ymax_type slip",
             *body("box", nu=0.3, lower="0,0", upper="1.04,1"), "-time_end 1"]
    around = ["-grid_lower 0,0", "-grid_upper 1,1.25", "-grid_cells 12,15", "-bc_xmin_type periodic", "-bc_xmax_type periodic", "-bc_ymin_type fixed", "-gravity 0,-3000",
              *body("expression", nu=0.3, lower="0,0", upper="1,1", expression='"0.9+0.07*sin(6.2831853*x)-y"'), "-time_end 1", "-dt_size 0.5"]
    line = ["-grid_lower 0", "-grid_upper 1", "-grid_cells 32", "-gravity -1000", "-bc_xmin_type fixed", *body("box", 1, nu=0, lower=0, upper=0.97), "-time_end 1"]
    for name, lines, more, status in (("beam", scene, (), 0), ("beam, updated", scene, UPDATED, 0), ("moving wall", moves, (), 0), ("periodic", around, (), 0), ("1-D", line, UPDATED, 0),
                                      ("ring", [*ring(8, E="1000"), "-load_p_value 100*t"], UPDATED, 0), ("flow", FOOTING, ("-grid_h", "0.25,0.25", "-time_end", 0.55, "-dt_size", 0.05), 0)):
        runs = [run("same", lines, *more, *QUIET, n=n, status=status) for n in (1, 2, 3)]
        promised = runs[2].find("the same bits on any (number of processes)")
        check.that(promised and len({r.digest for r in runs}) == 1 and runs[0].digest, f"{name}, 1, 2, 3 processes: {' '.join(str(r.digest) for r in runs)}")
    told = [run("other", scene, "-pc_type", "redundant", "-output_every", 1, n=3) for _ in range(2)]
    run("alone", scene)
    off = np.abs(moved("other")[1] - moved("alone")[1]).max()
    check.that(told[0].find("the same bits each time on as many (processes)") and told[0].digest == told[1].digest and off < 1e-6 * 0.25, f"another solver, 3 processes: {told[0].digest} twice, displacements differ by {off:.2g} m")
    for n, more in ((1, ()), (3, ("-ksp_type", "cg", "-ksp_rtol", "1e-10", "-pc_type", "jacobi"))):
        whole = run(f"whole{n}", scene, *more, n=n)
        run(f"go{n}", scene, *more, "-time_max_steps", 5, "-checkpoint_every", 0.1, n=n)
        again = run(f"go{n}", scene, *more, "-restart_file", "latest", n=n)
        check.that(again.digest == whole.digest, f"restarted on {n}: {again.digest}, whole {whole.digest}")
    cube = ["-grid_lower 0,0,0", "-grid_upper 2,1,1", "-grid_cells 8,4,4", "-bc_xmin_type fixed", "-gravity 0,0,-1",
            *body("box", 3, "elastic", lower="0,0,0", upper="2,1,1"), "-time_end 1", "-dt_size 0.5"]
    runs = [run(f"cube{n}", cube, n=n) for n in (1, 2)]
    off = np.abs(moved("cube2")[1] - moved("cube1")[1]).max()
    check.that(all(r.good for r in runs) and off < 1e-6, f"3-D with multigrid: displacements on 1 and 2 processes differ by {off:.2g} m")


def check_wrong():
    """What a run finds wrong with options of PETSc's solvers, and that their options work."""
    bad = run("bad", [*BEAM, "-grid_h 0.5,0.5"], "-ksp_rtoll", "1", *QUIET, status=3)
    check.that("-ksp_rtoll is an option that PETSc's solvers of this run do not have" in bad.said, "an option that no solver reads is named")
    push = [line for line in BEAM if not line.startswith("-gravity")] + ["-grid_h 0.25,0.25", "-dt_size 1"]
    deep = run("inside", push, "-gravity", "0,-20", "-dt_retry", 0, *QUIET, status=3)
    check.that("a particle would be turned inside out in Newton iteration" in deep.said, "a step that turns a particle inside out is not taken")
    cg = run("indefinite", push, "-gravity", "0,-20", "-dt_retry", 3, "-ksp_type", "cg", "-pc_type", "jacobi", *QUIET, status=3)
    gmres = run("gmres", push, "-gravity", "0,-20", "-dt_retry", 3, "-ksp_type", "gmres", "-pc_type", "jacobi", "-ksp_gmres_restart", 200, *QUIET)
    check.that(re.search(r"N are out of balance, most at \([\d.e+-]+, [\d.e+-]+\), of ", cg.said), f"the run tells where most is out of balance: {cg.err.strip()[-200:]}")
    check.that("the tangent is indefinite; try -ksp_type gmres" in cg.said and gmres.good, "cg fails where the tangent is indefinite, gmres does not")
    few = run("few", [*BEAM, "-grid_h 0.5,0.5"], "-snes_max_it", 1, "-dt_retry", 0, *QUIET, status=3)
    check.that("N are out of balance" in few.said and "(-snes_max_it allows no more)" in few.said, "too few iterations name their option")
    loose = run("loose", [*BEAM, "-grid_h 0.5,0.5"], "-snes_rtol", 0.05, "-snes_type", "ksponly", "-dt_size", 0.1, *QUIET)
    check.that(re.search(r"warning +solves ended with up to 0\.0\d+ of the forces out of balance, and what follows from them is hardly a solution; leave out -snes_rtol", loose.out),
               "a solve that leaves more than a thousandth of the forces out of balance is warned of, whatever PETSc says")
    none = run("none", [*BEAM, "-grid_h 0.5,0.5"], "-snes_type", "ksponly", "-ksp_type", "richardson", "-pc_type", "none", "-ksp_richardson_scale", 1e-12, "-ksp_norm_type", "none", "-ksp_max_it", 1, "-dt_retry", 0, *QUIET, status=3)
    check.that(re.search(r"after 1 Newton iterations [1-9]\S* N are out of balance, .*\(CONVERGED_", none.said), f"a state with most forces out of balance is no equilibrium: {none.err.strip()[-200:]}")
    good = run("good", [*BEAM, "-grid_h 0.5,0.5"], "-ksp_type", "gmres", "-pc_type", "jacobi", "-ksp_rtol", "1e-10", "-snes_converged_reason", *QUIET)
    check.that("ksp gmres, pc jacobi" in good.out and "CONVERGED_FNORM_RELATIVE" in good.out, "PETSc's options choose the solvers")
    mg = run("mg", [*BEAM, "-grid_h 0.25,0.25"], "-ksp_type", "gmres", "-pc_type", "gamg", "-pc_gamg_threshold", "0.01", "-mg_levels_ksp_max_it", 3, "-ksp_view", "-ksp_converged_reason", "-snes_monitor", "-report_phases",
             "-log_view", *QUIET)
    check.that(all(text in mg.out for text in ("type: gamg", "maximum iterations=3", "Linear solve converged due to", "SNES Function norm")), "-pc_gamg_*, -mg_*, -ksp_view, -ksp_converged_reason and -snes_monitor are PETSc's")
    steps = mg.out.partition(": MPM steps")[2].partition(": MPM output")[0]
    check.that(all(re.search(rf"^{event} +\d+", steps, re.M) for event in ("SOLVE", "TANGENT", "SNESSolve", "KSPSolve")) and all(re.search(rf"^  {phase} ", mg.out, re.M) for phase in ("SOLVE", "TANGENT")),
               "-log_view has events of the solver in the stage of the steps, and the table of phases its rows")
    grown = run("grown", push, "-gravity", "0,-20", "-dt_retry", 5, "-history_every", 0)
    last = check.history("grown/grown.csv")
    dt, ratio = last["dt"][1:], last["dt"][2:-1] / last["dt"][1:-2]
    check.that(grown.good and last["steps_cut"][-1] > 0 and dt[0] <= 0.5 and 1 < ratio.max() < 1.5 + 1e-9 and last["time"][-1] == 1, f"steps that were cut grow again by at most 1.5: {' '.join(f'{v:.3g}' for v in dt)}")
    metal = "G 4e5,c0 35,hugoniot_slope 1.5,gruneisen 2,yield 1e4,hardening 3e4,hardening_power 0.3,rate_factor 0.02,softening_power 1,melting 1400,temperature 300,specific_heat 400"
    metal = run("differences", [line.replace("neohookean", "johnsoncook") for line in push if not re.match("-material_m_(E|nu) ", line)] + [f"-material_m_{word}" for word in metal.split(",")], "-gravity", "0,-1", *QUIET)
    check.that("tangent    of m by differences of its stress" in metal.out and "by differences" not in good.out, "the run says whose tangent is found by differences")


for part in parts or [name[6:] for name in list(globals()) if name.startswith("check_")]:
    globals()["check_" + part]()
check.end()
