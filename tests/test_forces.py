"""Body forces, loads on surfaces and walls that depend on the velocity, against what mechanics says of them.

usage: test_forces.py PEBBLE SOURCE MPIEXEC
"""
import h5py
import numpy as np

import check

BASES = {"linear": "-method_basis linear", "gimp": "-method_basis gimp", "bspline2": "-method_basis bspline2", "bspline3": "-method_basis bspline3"}


def run(name, lines, *more, n=1):
    """Runs an options file of these lines; its digest."""
    told = check.pebble("-options_file", check.write(name + ".opts", lines), "-output_dir", ".", *more, n=n)
    if not told.good:
        check.that(False, f"{name}: exit status {told.status}\n{told.out[-800:]}\n{told.err[-800:]}")
    return told.digest if told.good else None


def history(name):
    return check.history(name + ".csv")


def history_dim(name):
    return sum(key.startswith("momentum_") for key in history(name))


def particles(name, which=-1):
    """The particles of a snapshot by id; time in s."""
    found, dim = check.particles(name + ".h5", which), history_dim(name)
    return {key: value[:, :dim] if key in ("x", "v") else value for key, value in found.items()}


def block(lower="0.3,0.3", upper="0.7,0.7", grid="2,2", cells="20,20", E=1e4, nu=0.3, rho=1000, steps=40, dt=1e-3, model="neohookean", velocity="0*x,0*x", ppc=2):
    """A block of h = 0.1 in a box; h/ppc divides it, so that its volume is exact."""
    dim = len(cells.split(","))
    return [f"-dim {dim}", "-grid_lower " + ",".join(["0"] * dim), f"-grid_upper {grid}", f"-grid_cells {cells}", "-materials m", f"-material_m_model {model}",
            f"-material_m_rho {rho}", *([f"-material_m_E {E}", f"-material_m_nu {nu}"] if model != "fluid" else [f"-material_m_K {E}"]), "-bodies b", "-body_b_shape box", f"-body_b_lower {lower}",
            f"-body_b_upper {upper}", "-body_b_ppc " + ",".join([str(ppc)] * dim), "-body_b_material m", f'-body_b_velocity "{velocity}"', f"-time_max_steps {steps}", "-time_end 1e6",
            f"-dt_size {dt}", "-history_every 0", "-output_every 1e9"]


def load(kind, value, face="all"):
    return ["-loads l", "-load_l_body b", f"-load_l_type {kind}", f'-load_l_value "{value}"', f"-load_l_face {face}"]


def same(name, lines, *more):
    """The same digest in two boxes and by a pool of three."""
    serial = run(name, lines, *more)
    for n, strategy in ((2, "spatial"), (3, "pool")):
        other = run(name + "_" + strategy, lines, *more, "-parallel_strategy", strategy, n=n)
        check.that(serial and other == serial, f"{name}: {strategy} on {n} processes: {other} against {serial}")


def check_acceleration():
    for basis, method in BASES.items():
        for update in ("usf", "usl", "musl"):
            scene, words = block("0.8,0.8", "1.2,1.2", velocity="0.3,0.2"), (*method.split(), "-method_update", update)
            run("gravity", scene + ["-gravity 0.5,-2"], *words)
            run("accelerated", scene + ['-acceleration "0.5, 0-2"'], *words)
            a, b = particles("gravity"), particles("accelerated")
            error = max(np.abs(a["x"] - b["x"]).max(), np.abs(a["v"] - b["v"]).max())
            check.that(error < 2e-14, f"acceleration is gravity, {basis} {update}: {error:.1e}")
    dt, n = 1e-3, 40  # v_n = v_0 + dt sum a(t_k), x likewise, with a at the start of each step
    run("timed", block("0.8,0.8", "1.2,1.2", velocity="0.3,0.2", dt=dt, steps=n) + ['-acceleration "3*sin(40*t), 2*t"'])
    t = dt * np.arange(n)
    v = np.array([0.3, 0.2]) + dt * np.cumsum(np.stack([3 * np.sin(40 * t), 2 * t], 1), 0)
    p, q = particles("timed"), particles("timed", 0)
    check.that(np.abs(p["v"] - v[-1]).max() < 1e-14, f"acceleration of time: velocity off by {np.abs(p['v'] - v[-1]).max():.1e}")
    check.that(np.abs(p["x"] - q["x"] - dt * v.sum(0)).max() < 1e-14, f"acceleration of time: place off by {np.abs(p['x'] - q['x'] - dt * v.sum(0)).max():.1e}")
    same("of_place", block(velocity="0.3,0.2") + ['-acceleration "2*(0.5-x)+Y, sin(9*t)*X"'])


def check_pressure():
    for basis, method in BASES.items():
        for face, lower in (("ppc 2", "0.8,0.8"), ("wide", "0.7,0.8")):
            run("pressed", block(lower, "1.2,1.2", dt=2e-3) + load("pressure", "200"), *method.split())
            h, p = history("pressed"), particles("pressed")
            momentum = max(np.abs(h["momentum_x"]).max(), np.abs(h["momentum_y"]).max())
            scale = (h["mass"][0] * np.sqrt((p["v"] ** 2).sum(1).mean()))
            q = particles("pressed", 0)
            check.that(scale > 0.1 and momentum < 1e-12 * scale, f"pressure on all sides, {basis}: momentum {momentum:.1e} of {scale:.1e}")
            check.that(np.abs(p["x"].mean(0) - q["x"].mean(0)).max() < 1e-14, f"pressure on all sides, {basis}: the centre moves by {np.abs(p['x'].mean(0) - q['x'].mean(0)).max():.1e}")
            check.that(p["volume"].sum() < q["volume"].sum(), f"pressure on all sides, {basis}: it is compressed")
    # pressure p on the side xmin of a body that turns: the impulse of each step is dt sum p J F^-T e_x A (Nanson) of the
    # particles that are 1 to 2 cells below the side, where the load is given to the body, and its direction turns with it
    omega, dt, p = 50.0, 1e-4, 1e5
    for update in ("usf", "musl"):
        run("turning", block("0.8,0.8", "1.2,1.2", E=1e8, dt=dt, steps=100, velocity=f"0-{omega}*(y-1), {omega}*(x-1)") + load("pressure", str(p), "xmin"), "-method_update", update, "-output_every", "0")
        h = history("turning")
        q = particles("turning", 0)
        side = (q["x"][:, 0] > 0.9) & (q["x"][:, 0] < 1)
        with h5py.File("turning.h5") as file:
            F = [file[key]["particles/F"][:][np.argsort(file[key]["particles/id"][:])][side] for key in sorted(key for key in file if key.startswith("step_"))]
        force = p * 0.05 / 2 * np.array([np.stack([f[:, 4], -f[:, 1]], 1).sum(0) for f in F[:-1]])
        got = np.diff(np.stack([h["momentum_x"], h["momentum_y"]], 1), axis=0) / dt
        error, angle = np.abs(got - force).max() / np.abs(force).max(), np.arctan2(force[-1, 1], force[-1, 0])
        check.that(error < 1e-9 and side.sum() == 16, f"pressure on a side of a turning body, {update}: force off by {error:.1e}")
        check.that(angle > 0.3, f"pressure on a side of a turning body, {update}: it turns by {angle:.3f} rad")  # the grid smooths the spin of 4 cells
    same("pressed_in_parallel", block("0.33,0.33", "0.71,0.71", velocity="0.5,0.2") + load("pressure", "200*(1+x)*cos(30*t)"))
    same("pressed_fluid", block(model="fluid", velocity="0.5,0.2") + load("pressure", "50"))
    same("pressed_3d", block("0.3,0.3,0.3", "0.6,0.6,0.6", "1,1,1", "10,10,10", steps=8, velocity="0.5,0.2,0*x") + load("pressure", "50"))


def check_traction():
    for face, area, mass in (("xmax", 0.4, 160), ("ymin", 0.4, 160)):
        for basis, method in BASES.items():
            dt, n, T = 1e-3, 30, np.array([70.0, -30.0])
            run("pulled", block("0.8,0.8", "1.2,1.2", dt=dt, steps=n) + load("traction", "70, 0-30", face), *method.split())
            h = history("pulled")
            p = np.array([h["momentum_x"][-1], h["momentum_y"][-1]])
            error = np.abs(p - T * area * n * dt).max() / (70 * area * n * dt)
            check.that(abs(h["mass"][0] - mass) < 1e-9 and error < 1e-12, f"traction on {face}, {basis}: impulse off by {error:.1e}")
    same("pulled_in_parallel", block(velocity="0.5,0.2") + load("traction", "70*t, 10*X", "ymax"))
    # a bar under end traction swings about T/E with twice that as the largest: Dirac's column. Small strain, 1-D, nu = 0.
    E, rho, T = 1e4, 1000, 10.0
    c = np.sqrt(E / rho)
    run("bar", block("0", "1", "1.5", "30", E=E, nu=0, dt=2e-3, steps=int(round(4 / c / 2e-3)) * 2, velocity="0*x") + load("traction", str(T), "xmax") + ["-bc_xmin_type fixed"], "-method_basis", "linear", "-output_every", "0.01")
    with h5py.File("bar.h5") as file:
        keys = sorted(key for key in file if key.startswith("step_"))
        last = [file[key]["particles/x"][:].max() for key in keys]
    tip = np.array(last) - last[0]
    check.that(abs(tip.mean() / (T / E) - 1) < 0.03 and abs(tip.max() / (2 * T / E) - 1) < 0.05, f"bar under traction: mean strain {tip.mean() / (T / E):.3f}, largest {tip.max() / (T / E):.3f} of T/E (1 and 2)")


def volume_load(kind, value, where=None, point=None):
    return ["-loads l", "-load_l_body b", f"-load_l_type {kind}", f'-load_l_value "{value}"', *([f'-load_l_where "{where}"'] if where else []), *([f"-load_l_point {point}"] if point else [])]


def turned(p, dim, about):
    """The moment of the particles' accelerations about a point, from velocities after one step from rest; [3]."""
    r, v = (np.pad(a, ((0, 0), (0, 3 - dim))) for a in (p["x"] - p["v"] * p["t"] - about, p["v"] / p["t"]))
    return np.cross(r, v).sum(0)


def check_volume_loads():
    dt, steps = 1e-3, 40  # the sum of forces at the starts of steps is the momentum, whatever the method and the body do
    for basis, method in BASES.items():
        run("force", block("0.4,0.8", "1.2,1.2", dt=dt, steps=steps) + volume_load("force", "30*t, 0-2", "X > 1"), "-output_every", "0", *method.split())
        h, t = history("force"), dt * np.arange(steps)
        for axis, exact in (("x", dt * (30 * t).sum()), ("y", -2 * dt * steps)):
            error = abs(h[f"momentum_{axis}"][-1] - exact)
            check.that(error < 1e-13, f"force, {basis}: momentum along {axis} is {h[f'momentum_{axis}'][-1]}, it should be {exact}")
    first = particles("force", 1)
    check.that((np.abs(first["v"][particles("force", 0)["x"][:, 0] < 0.58]) < 1e-12).all(), "force: it moves particles far from where it acts in the first step")
    # A bar that is held at one end and stretched by a force on all of it is a bar that hangs: u = F L/(2 E) at its end.
    still = ["-bc_xmin_type fixed", "-damping_time 0.02", "-time_end 0.6", "-output_every 0.6", "-history_every 0.6", "-dt_cfl 0.4"]
    bar = [line for line in block("0", "1", grid="2", cells="40", E=1e4, nu=0, rho=1, velocity="0*x", ppc=2) if not line.startswith(("-time_", "-dt_", "-output_", "-history_"))]
    for where, exact in ((None, 50 / 1e4), ("X > 0.5", 75 / 1e4)):
        run("stretched", bar + still + volume_load("force", "100", where))
        end = (particles("stretched")["x"] - particles("stretched", 0)["x"]).max()
        check.that(abs(end / exact - 1) < 0.02, f"force on {where or 'all'} of a bar: its end moves by {end}, it should by {exact}")
    # A torque: the sum of the moments about its point; about its centre the forces have no sum.
    solid = ("0.6,0.7,0.8", "1.0,1.2,1.4", "2,2,2", "20,20,20")
    for name, dim, args, value, about in (("plane", 2, ("0.6,0.7", "1.0,1.2"), "3", None), ("plane_point", 2, ("0.6,0.7", "1.0,1.2"), "3", "0.5,0.4"),
                                          ("space", 3, solid, "3,0-1,2", None), ("space_point", 3, solid, "3,0-1,2", "0.9,0.4,0.2")):
        run(name, block(*args, dt=dt, steps=1, velocity=",".join(["0*x"] * dim)) + volume_load("torque", value, point=about), "-method_basis", "linear", "-method_transfer", "flip")
        run(name + "_cubic", block(*args, dt=dt, steps=1, velocity=",".join(["0*x"] * dim)) + volume_load("torque", value, point=about))
        p = {**particles(name), "t": dt}
        want = np.array([0, 0, 3.0]) if dim == 2 else np.array([3, -1, 2.0])
        momentum, turn = history(name + "_cubic"), []
        for axis in "xyz"[:dim]:
            if not about:
                check.that(abs(momentum[f"momentum_{axis}"][-1]) < 1e-15, f"{name}: a torque about the centre moves the body along {axis}")
        for axis in ("z" if dim == 2 else "xyz"):
            turn.append(momentum[f"angular_momentum_{axis}"][-1] / dt)
        middle = [float(word) for word in (about or ("0.8,0.95" if dim == 2 else "0.8,0.95,1.1")).split(",")]
        net = np.array([momentum[f"momentum_{axis}"][-1] / dt for axis in "xyz"[:dim]] + [0] * (3 - dim))
        about_origin = np.cross(np.array(middle + [0] * (3 - dim)), net) + want  # moment about 0 of forces with this moment about the point
        error = np.abs(np.array(turn) - about_origin[3 - len(turn):]).max()
        check.that(error < 1e-10 and np.isfinite(p["v"]).all(), f"{name}: moment {turn}, it should be {about_origin}")
    same("shared", block(velocity="0.3,0.2") + volume_load("torque", "5*sin(90*t)", "X+Y > 0.8"))
    same("pushed", block("0.3,0.3,0.3", "0.7,0.7,0.7", "1,1,1", "10,10,10", steps=20, velocity="0.3,0.2,0.1") + volume_load("force", "5,t,0"))
    for kind, value, what in (("force", "0*t,0", "(0, 0) N"), ("torque", "0", "0 N m")):
        told = check.must("-options_file", check.write("nothing.opts", block(steps=1) + volume_load(kind, value)), "-output_dir", ".")
        check.that(f"{kind} on 64 particles of b, in all {what} at t=0 s" in told.out and "load l is 0 at the start and after each hundredth of -time_end; see -load_l_value" in told.out, f"a {kind} of 0 is told of")
    for kind, value, what in (("force", "3*t,0-40*t", "(0.3, -4) N at t=0.1 s\n"), ("torque", "0-5", "-5 N m at t=0 s\n")):
        told = check.must("-options_file", check.write("signed.opts", block(steps=1) + volume_load(kind, value)), "-output_dir", ".", "-dry_run", "-time_end", "0.1")
        check.that(f"in all {what}" in told.out, f"the sign and direction of a {kind} are told")
    # The part of the body that a load acts on is told where it is not all of it, on any number of processes.
    for n, kind, where, places in ((1, "force", "0.65-X", "56 particles of b, x from 0.3 to 0.65 m, in all"), (2, "force", "X-0.65", "8 particles of b, x from 0.65 to 0.7 m, in all"),
                                   (1, "torque", "(X>0.4)*(Y<0.5)", "24 particles of b, x from 0.4 to 0.7 m, y from 0.3 to 0.5 m, in all"), (1, "force", "X", "64 particles of b, in all")):
        told = check.must("-options_file", check.write("part.opts", block(steps=1) + volume_load(kind, "2" if kind == "torque" else "2,0", where)), "-output_dir", ".", "-dry_run", n=n)
        check.that(places in told.out, f"a {kind} where {where} is on {places}")
    # What does not hold is refused.
    for what, words, answer in (("an empty set", volume_load("force", "1,1", "X > 9"), "-load_l_where is positive for no particle of body b"),
                                ("a torque on a particle", volume_load("torque", "1", "(X > 0.3)*(X < 0.35)*(Y > 0.3)*(Y < 0.35)"), "the 1 particle that it acts on cannot take it, since they lie at its point"),
                                ("a force of place", volume_load("force", "x,1"), '"x"'), ("a face of a force", volume_load("force", "1,1") + ["-load_l_face xmin"], "-load_l_face"),
                                ("a place of a pressure", load("pressure", "1") + ['-load_l_where "X"'], "-load_l_where"), ("a point of a force", volume_load("force", "1,1", point="1,1"), "-load_l_point")):
        told = check.pebble("-options_file", check.write("wrong.opts", block(steps=1) + words), "-output_dir", ".")
        check.that(told.status == 2 and answer in told.err, f"{what}: status {told.status}, {told.err}")
    line = block("0.3,0.3,0.3", "0.7,0.7,0.7", "1,1,1", "10,10,10", velocity="0*x,0*x,0*x") + volume_load("torque", "1,0,0", "(Y > 0.3)*(Y < 0.35)*(Z > 0.3)*(Z < 0.35)")
    for what, lines, answer in (("a torque on a line", line, "they lie on one line through its point"), ("a torque in 1-D", bar + ["-time_end 1"] + volume_load("torque", "1"), "torque needs -dim 2 or 3"),
                                ("a torque on a periodic grid", block() + ["-bc_xmin_type periodic", "-bc_xmax_type periodic"] + volume_load("torque", "1"), "the grid is periodic along x"),
                                ("too many loads", block() + ["-loads " + ",".join(f"l{k}" for k in range(31))] + [f"-load_l{k}_{word}" for k in range(31) for word in ("body b", "type force", "value 1,1")],
                                 "31 loads, of which some are forces or torques; then 30 are allowed")):
        told = check.pebble("-options_file", check.write("wrong.opts", lines), "-output_dir", ".")
        check.that(told.status == 2 and answer in told.err, f"{what}: status {told.status}, {told.err}")


def check_friction():
    """A block on the floor under gravity decelerates by mu g, and sticks at last; with a large mu at once."""
    g, mu, v0 = 10.0, 0.3, 1.0
    for basis, method in BASES.items():
        for transfer in ("flip",) if basis == "linear" else ("flip", "apic"):  # linear and apic: noise, as particles cross cells
            floor = ["-bc_ymin_type friction", f"-bc_ymin_mu {mu}", f"-gravity 0,-{g}"]
            lower, upper = ("0.2,0", "1.0,0.3")
            run("slide", block(lower, upper, E=1e6, dt=5e-4, steps=400, velocity=f"{v0},0*x") + floor, *method.split(), "-method_transfer", transfer, "-output_every", "1")
            h = history("slide")
            t, v = h["time"], h["momentum_x"] / h["mass"]
            slope = -np.polyfit(t[40:], v[40:], 1)[0]
            check.that(abs(slope / (mu * g) - 1) < 0.01, f"friction, {basis} {transfer}: decelerates by {slope / (mu * g):.4f} mu g")
    run("stick", block("0.2,0", "1.0,0.3", E=1e6, dt=5e-4, steps=400) + ["-bc_ymin_type friction", "-bc_ymin_mu 2", "-gravity 2,-10"], "-output_every", "1")
    h = history("stick")
    check.that(np.abs(h["momentum_x"] / h["mass"])[200:].max() < 0.05, f"friction: a block that sticks creeps at {np.abs(h['momentum_x'] / h['mass'])[200:].max():.1e} m/s at most, falling would be {2 * h['time'][-1]:.2g}")
    same("slide_in_parallel", block("0.2,0", "1.0,0.3", velocity="1,0*x") + ["-bc_ymin_type friction", "-bc_ymin_mu 0.3", "-gravity 0,-10"])


def check_separate():
    for wall, leaves in (("separate", True), ("friction", True), ("slip", False)):
        run(wall, block("0.5,0", "1.0,0.3", E=1e5, dt=1e-3, steps=150, velocity="0*x,0.5") + [f"-bc_ymin_type {wall}"] + (["-bc_ymin_mu 0.3"] if wall == "friction" else []))
        p, h = particles(wall), history(wall)
        check.that((p["x"][:, 1].min() > 0.06) == leaves, f"{wall}: a block pulled off the floor {'leaves' if leaves else 'stays'}: lowest particle at {p['x'][:, 1].min():.4f}")
        if leaves:
            check.that(abs(h["momentum_y"][-1] / h["mass"][0] - 0.5) < 1e-10, f"{wall}: it keeps its velocity, {h['momentum_y'][-1] / h['mass'][0]:.12f}")


def check_moving():
    """A layer between a fixed floor and a lid that moves along: what is at the lid goes with it."""
    for model in ("neohookean", "fluid"):
        lines = block("0,0", "1,1", "1,1", "10,10", E=1e4, dt=1e-3, steps=300, model=model) + ["-bc_ymin_type fixed", "-bc_ymax_type moving", "-bc_ymax_velocity 0.1,0", "-bc_xmin_type periodic", "-bc_xmax_type periodic", "-method_transfer apic"]  # pure FLIP never hears of the jump at the start
        if model == "fluid":
            lines += ["-material_m_viscosity 100"]
        run("lid", lines)
        with h5py.File("lid.h5") as file:
            v = check.group(file)["grid/v"][0]
        p = particles("lid")
        top, bottom = p["v"][p["x"][:, 1] > 0.95], p["v"][p["x"][:, 1] < 0.05]
        check.that(np.abs(v[-1] - np.array([0.1, 0, 0])).max() < 1e-15 and np.abs(v[0]).max() == 0, f"moving lid, {model}: its nodes have its velocity")
        check.that(np.abs(top[:, 0] - 0.1).max() < 0.03 and np.abs(bottom[:, 0]).max() < 0.03, f"moving lid, {model}: particles at it {top[:, 0].mean():.3f}, on the floor {bottom[:, 0].mean():.3f} m/s")
        if model == "fluid":  # nu = 0.1 m^2/s: nearly steady Couette flow after 0.3 s
            run("couette", lines, "-time_max_steps", "6000", "-output_every", "1", "-history_every", "1")
            p = particles("couette")
            check.that(np.abs(p["v"][:, 0] - 0.1 * p["x"][:, 1]).max() < 6e-3, f"Couette flow: off by {np.abs(p['v'][:, 0] - 0.1 * p['x'][:, 1]).max():.1e} of 0.1")
        same(f"lid_{model}", lines, "-time_max_steps", "20")
        # Between side walls the lid does not drive what is beneath it through them: at the edge they hold their normal.
        for side, method in [(side, method) for side in ("fixed", "slip", "separate") for method in ("-method_transfer aflip", "-method_update musl -method_transfer flip")]:
            run("cavity", [line for line in lines if "periodic" not in line] + [f"-bc_{face}_type {side}" for face in ("xmin", "xmax")], *method.split())
            with h5py.File("cavity.h5") as file:
                edge = check.group(file)["grid/v"][0][:, [0, -1], 0]
            outward = 0 if side == "separate" else np.abs(edge).max()  # matter may be away from a wall that only pushes
            lost = len(particles("cavity")["x"]) - len(particles("cavity", 0)["x"])
            check.that(outward == 0 and lost == 0, f"a lid between walls of type {side}, {model}, {method}: nodes at them move along their normal at {outward:.1e} m/s, {-lost} particles left")


check.arguments(__doc__, 0)
for part in (check_acceleration, check_traction, check_pressure, check_volume_loads, check_friction, check_separate, check_moving):
    part()
check.end()
