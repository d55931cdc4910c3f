"""Scenes of the starter problems, as functions of n, and what is read from their runs, as functions of the run and n.

A scene says nothing of -method_*, -dt_*, -body_<b>_ppc and -material_<m>_tension_cutoff: the program's defaults answer.
Damping of all motion (-damping_time) is there where a state of rest is asked for. The material is m, the body is b.
"""
import math

import exact
import numpy as np
import problems

# ---- Parts of scenes


def join(values):
    return ",".join(f"{value:.12g}" for value in values)


def grid(lower, upper, h, gravity=(), **walls):
    text = f"-dim {len(lower)} -grid_lower {join(lower)} -grid_upper {join(upper)} -grid_h {join([h] * len(lower))} "
    text += " ".join(f"-bc_{face}_type {kind}" for face, kind in walls.items())
    return text + (f" -gravity {join(gravity)}" if gravity else "")


def material(model, more="", **constants):
    words = " ".join(f"-material_m_{key} {value:.12g}" for key, value in constants.items())
    return f" -materials m -material_m_model {model} {words} {more}"


def rubber(E, nu=0.3, rho=1000):
    return material("neohookean", rho=rho, E=E, nu=nu)


def soil(friction_angle, **more):
    return material("druckerprager", "-material_m_fit plane_strain", rho=2000, friction_angle=friction_angle, **more)


STEEL = material("vonmises", rho=7800, E=2e11, nu=0.3, **{"yield": 4e8})
COPPER = material("vonmises", rho=8930, E=1.17e11, nu=0.35, **{"yield": 4e8}, hardening=1e8)
CLAY = material("vonmises", rho=2000, E=2e7, nu=0.49, **{"yield": 2e4 * math.sqrt(3)})
SAND = soil(31, E=1e6, nu=0.3)
WATER = material("fluid", rho=1000, K=1e6)


def body(shape, **parts):
    words = [f"-body_b_{key} " + (f"'{part}'" if isinstance(part, str) else join(np.atleast_1d(part)))
             for key, part in parts.items()]
    return " ".join([f" -bodies b -body_b_shape {shape} -body_b_material m", *words])


def box(lower, upper, **more):
    return body("box", lower=lower, upper=upper, **more)


def load(kind, value, face="xmax"):
    return f" -loads p -load_p_body b -load_p_face {face} -load_p_type {kind} -load_p_value '{value}'"


def ends(time, lines=100, snapshots=0, damping=0.0, history="lower,upper,center", more=""):
    """The end, lines of the history, snapshots (0: none), damping, columns of the body."""
    text = f" -time_end {time:.12g} -history_every {time / lines:.12g}"
    text += f" -output_every {time / snapshots:.12g}" if snapshots else " -output_format none"
    text += f" -damping_time {damping:.12g}" if damping else ""
    return text + (f" -history_bodies b -history_body_quantities {history} " if history else " ") + more


# ---- What is read from several kinds of runs

def last(name, scale=1.0):
    """The last value of a column of the history."""
    return lambda run, n: scale * run.column(name)[-1]


def way(name):
    return lambda run, n: run.column(name)[-1] - run.column(name)[0]


def kept(name):
    return lambda run, n: run.column(name)[-1] / run.column(name)[0]


def stretch(run, n):
    """Along x, of the whole body."""
    long = run.column("upper_b_x") - run.column("lower_b_x")
    return long[-1] / long[0]


def volumes(run, n):
    """Sum over the particles."""
    return run.particles(-1, "volume")[0].sum()


def rms(values, weights):
    """Of values of the particles, by their volumes or masses, in which those at the surface of a body differ."""
    return math.sqrt(np.average(values**2, weights=weights))


def impulse(run, face, axis):
    """Times, and the impulse of a wall so far as a part of the whole."""
    t = run.column("time")
    J = np.cumsum(run.column(f"reaction_{face}_{axis}") * np.diff(t, prepend=0))
    return t, J / J[-1]


def duration(run, face, axis):
    """Time in which the impulse of a wall grows from 5 to 95 %."""
    t, J = impulse(run, face, axis)
    early, late = np.interp([0.05, 0.95], np.maximum.accumulate(J), t)
    return late - early


def rests(run, n):
    """How much of the displacement of the probe c comes in the last half of the run."""
    t, y = run.column("time"), run.column("probe_c_y")
    return (y[-1] - np.interp(t[-1] / 2, t, y)) / (y[-1] - y[0])


# ---- Bars and beams

def pulled_bar(dim, part, nu):
    """Held at one end, by a plane of symmetry where its sides are free to move; loaded at the other by part x E."""
    def scene(n):
        held = "slip" if nu and dim > 1 else "fixed"
        value = f"{part * 1e5:.12g}*min(t/4, 1)" + ", 0" * (dim - 1)
        return (grid([0] * dim, [2, 0.5, 0.5][:dim], 1 / n, xmin=held) + rubber(1e5, nu)
                + box([0, 0.125, 0.125][:dim], [1, 0.375, 0.375][:dim]) + load("traction", value)
                + ends(7, damping=0.2))
    return scene


def metal_bar(n):
    return (grid([0, 0], [0.125, 0.05], 0.1 / n, xmin="slip") + STEEL + box([0, 0.0125], [0.1, 0.0375])
            + load("traction", "3.2e8*min(t/2e-4, 1), 0") + ends(6e-4, damping=2e-5))


def hanging_bar(dim):
    def scene(n):
        return (grid([0, -1][-dim:], [0.5, 1][-dim:], 1 / n, [0, -50][-dim:], **{f"{'xy'[dim - 1]}max": "fixed"})
                + rubber(1e5, 0) + box([0.125, 0][-dim:], [0.375, 1][-dim:]) + ends(4, damping=0.2))
    return scene


def hanging_length(run, n):
    return 1 - run.column(f"lower_b_{run.up}")[-1]


def beam(gravity, time, **more):
    return lambda n: (grid([0, -5], [5, 2], 1 / n, [0, -gravity], xmin="fixed") + rubber(1e6, rho=1050)
                      + box([0, 0], [4, 1]) + ends(time, more="-output_fields body", **more))


def fall(run, n):
    return -problems.deepest(run, 4)


def lost(run, n):
    """Energy at the end that is missing, over the work of gravity."""
    return run.column("energy_residual")[-1] / abs(run.column("external_work")).max()


def vibrating_bar(n):
    return (grid([0], [25 + 50 / n], 25 / n, xmin="fixed") + material("elastic", rho=1, E=100, nu=0)
            + box([0], [25], velocity="0.1*sin(pi*x/50)") + ends(50, 1000))


def vibration(run, n):
    """rms difference of the centre of the bar from (2/pi) v0/w sin(w t), over the rms of that."""
    t, x, w = run.column("time"), run.column("center_b_x"), math.pi / 5
    right = 0.2 / math.pi / w * np.sin(w * t)
    return math.sqrt(((x - x[0] - right)**2).mean() / (right**2).mean())


C = math.sqrt(1e6 / 1000)  # speed of waves in the next two bars, which are 1 m long and have nu = 0


def loaded_bar(n):
    return (grid([0, 0], [1.25, 0.5], 1 / n, xmin="fixed") + rubber(1e6, 0) + box([0, 0.125], [1, 0.375])
            + load("pressure", "1e3") + ends(2 / C, more="-history_walls xmin"))


def wall_impulse(run, n):
    return abs((run.column("reaction_xmin_x")[1:] * np.diff(run.column("time"))).sum())


def bar_on_wall(n):
    return (grid([0, 0], [1.5, 0.5], 1 / n, xmin="separate") + rubber(1e6, 0)
            + box([0.125, 0.125], [1.125, 0.375], velocity=f"{-0.01 * C:.12g}, 0")
            + ends(0.6, 600, history="momentum,lower", more="-history_walls xmin"))


def bar_contact_time(run, n):
    """In ms; the force is constant."""
    return 1000 * duration(run, "xmin", "x") / 0.9


def bar_gap(run, n):
    """In cells, between wall and end, at a hundredth of the impulse."""
    return run.column("lower_b_x")[np.argmax(impulse(run, "xmin", "x")[1] > 0.01)] * n


def rebound(axis):
    return lambda run, n: -kept(f"momentum_b_{axis}")(run, n)


# ---- Disks and rings

def spinning_disk(n):
    return (grid([-0.5, -0.5], [0.5, 0.5], 0.25 / n) + rubber(1e4)
            + body("sphere", center=[0, 0], radius=0.25, velocity="0 - y, x")
            + ends(6 * math.pi, snapshots=3, more="-output_fields mass,velocity"))


def spin(run, n):
    """Angular momentum of the particles at the end over that at the start."""
    def at(which):
        m, x, v = run.particles(which, "mass", "x", "v")
        return (m * (x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0])).sum()
    return at(-1) / at(0)


def ring(n):
    pressure = "1e4*(X*X + Y*Y < 0.5625)*(t < 0.8 ? (1 - cos(pi*t/0.8))/2 : 1)"
    return (grid([-1.25, -1.25], [1.25, 1.25], 0.5 / n) + rubber(1e6)
            + body("annulus", center=[0, 0], inner_radius=0.5, radius=1) + load("pressure", pressure, "all")
            + ends(1, snapshots=1, more="-output_fields mass"))


def inner_rim(run, n):
    """Displacement of the inner rim in mm, from the particles within 5 cm of it."""
    R, u = problems.ring_displacement()
    (m, x0), (x,) = run.particles(0, "mass", "x"), run.particles(-1, "x")
    r = np.hypot(*x0.T[:2])
    near = r < 0.55
    moved = ((x - x0) * x0).sum(1) / r
    return 1000 * u[0] * (m * moved)[near].sum() / (m[near] * np.interp(r[near], R, u)).sum()


# ---- Metals

def upsetting(dim):
    face = f"{'xyz'[dim - 1]}max"
    walls = {f"{axis}min": "slip" for axis in "xyz"[:dim]} | {face: "piston"}

    def scene(n):
        return (grid([0] * dim, [0.2] * (dim - 1) + [0.1], 0.1 / n, **walls)
                + f" -bc_{face}_velocity '-10*min(t/1e-4, 1)'" + STEEL + box([0] * dim, [0.1] * dim)
                + ends(2.05e-3, 400, 1, more=f"-history_walls {face}"))
    return scene


def plates(run, n):
    """Mean force in MPa over the section, which keeps its volume, from 5 to 20 % of compression."""
    section = 0.1**(run.dim - 1) / (1 - (run.column("time") - 0.5e-4) / 0.01)
    return abs(run.column(f"reaction_{run.up}max_{run.up}") / section)[100:].mean() / 1e6


def mean_stress(right):
    """rms difference of the mean stress of the particles from the right one in MPa, over that."""
    def get(run, n):
        stress, volume = run.particles(-1, "stress", "volume")
        return rms(-stress[:, [0, 4, 8]].mean(1) / 1e6 / right - 1, volume)
    return get


def taylor(n):
    return (grid([0, 0, 0], [0.0096, 0.0096, 0.0352], 0.0032 / n, xmin="slip", ymin="slip", zmin="separate") + COPPER
            + body("expression", expression="0.0032^2 - x^2 - y^2", lower=[0, 0, 0], upper=[0.0032, 0.0032, 0.0324],
                   velocity="0, 0, -227") + ends(8e-5))


def taylor_length(run, n):
    return 1000 * (run.column("upper_b_z") - run.column("lower_b_z"))[-1]


def taylor_foot(run, n):
    return 500 * (run.column("upper_b_x") + run.column("upper_b_y"))[-1]


# ---- Bodies on walls

def ball(v, gap):
    """A quarter of it is computed."""
    time = exact.Hertz(0.01, 1e9, 0.3, 1200, v).time

    def scene(n):
        return (grid([0, 0, 0], [0.012, 0.012, 0.024], 0.01 / n, xmin="slip", ymin="slip", zmin="separate")
                + rubber(1e9, rho=1200) + body("expression", velocity=f"0, 0, {-v}",
                                               expression=f"0.01^2 - x^2 - y^2 - (z - {0.01 + gap:.12g})^2")
                + ends(gap / v + 2 * time, history="momentum", more="-history_walls zmin"))
    return scene


def ball_contact_time(run, n):
    """In us."""
    return 1e6 * duration(run, "zmin", "z") / exact.Hertz(0.01, 1e9, 0.3, 1200, 1).share


def ball_force(run, n):
    return 4 * run.column("reaction_zmin_z").max()


def sliding_block(n):
    return (grid([0, 0], [2.5, 0.75], 1 / n, [0, -10], ymin="friction") + " -bc_ymin_mu 0.3" + rubber(1e6)
            + box([0.125, 0], [0.625, 0.25], velocity="3, 0") + ends(1.3))


def disk_on_slope(mu):
    """Gravity is turned by 30 degrees instead of the floor."""
    return lambda n: (grid([0, 0], [4, 1.5], 0.5 / n, [5, -8.66025], ymin="friction") + f" -bc_ymin_mu {mu}"
                      + rubber(1e6) + body("sphere", center=[0.75, 0.5], radius=0.5) + ends(1))


def oblique(n):
    return (grid([0, 0], [3, 1.5], 0.25 / n, ymin="friction") + " -bc_ymin_mu 0.2" + rubber(1e6)
            + body("sphere", center=[0.5, 0.35], radius=0.25, velocity="2, -1") + ends(0.4, 400, history="momentum"))


def impulse_ratio(run, n):
    return -way("momentum_b_x")(run, n) / way("momentum_b_y")(run, n)


# ---- Soils

SOIL = 2000 * 9.81 * 10 / (2e7 * 0.65 / (1.35 * 0.3))  # rho g H/M of the layer: see exact.column


def layer(n):
    return (grid([0, 0], [8, 12], 10 / n, [0, -9.81], xmin="slip", xmax="slip", ymin="fixed") + soil(30, E=2e7, nu=0.35)
            + box([0, 0], [8, 10]) + ends(2, damping=0.05, snapshots=1))


def settlement(run, n):
    """In mm, of the surface."""
    return 1e4 * (1 - run.column("upper_b_y")[-1] / 10)


def vertical_stress(run, n):
    """rms error over rho g H. What lies above a particle did so at the start too."""
    weight = 2000 * 9.81 * (10 - run.particles(0, "x")[0][:, 1])
    stress, volume = run.particles(-1, "stress", "volume")
    return rms(stress[:, 4] + weight, volume) / (2000 * 9.81 * 10)


def slope(factor):
    """Its strength, 20 degrees and 10 kPa, is divided by the factor."""
    angle = math.degrees(math.atan(math.tan(math.radians(20)) / factor))
    return lambda n: (grid([0, 0], [32, 12], 10 / n, [0, -10], xmin="slip", xmax="slip", ymin="fixed")
                      + soil(angle, cohesion=1e4 / factor, E=1e8, nu=0.3)
                      + body("polygon", vertices="0,0 32,0 12,10 0,10") + " -initial_stress k0"
                      + ends(4, damping=0.1, history="", more="-probes c -probe_c_follow 11.8,9.9"))


def footing(part, grows, held):
    """On undrained clay, c_u = 20 kPa; a half is computed. The load grows to part x (2 + pi) c_u, then it is held."""
    value = f"0, -{part * (2 + math.pi) * 2e4:.12g}*(X < 1)*min(t/{grows}, 1)"
    return lambda n: (grid([0, 0], [6, 5], 1 / n, xmin="slip", xmax="slip", ymin="fixed") + CLAY + box([0, 0], [6, 4])
                      + load("traction", value, "ymax")
                      + ends(grows + held, damping=0.1, history="", more="-probes c -probe_c_follow 0.1,3.9"))


def limit_load(run, n):
    """Limit of a load q c_u that grows to 1.4 times 2 + pi. Beyond it the excess accelerates the sinking ground and
    overcomes its damping, q - limit = M (dv/dt + v/0.1 s): the line through the states from q = 5.5 to 7 gives both."""
    t, v = run.column("time"), -run.column("probe_c_velocity_y")
    q = 1.4 * (2 + math.pi) * t / t[-1]
    used = (q > 5.5) & (q < 7)
    return np.polyfit((v / 0.1 + np.gradient(v, t))[used], q[used], 1)[1]


def sand_footing(n):
    """A rigid rough footing, 2 m wide, of which a half is computed, is pushed into dry sand of 30 degrees."""
    return (grid([0, 0], [6, 3], 1 / n, [0, -9.81], xmin="slip", xmax="slip", ymin="fixed") + soil(30, E=5e7, nu=0.3)
            + box([0, 0], [6, 2.5]).replace("-bodies b", "-bodies foot,b")
            + " -body_foot_shape box -body_foot_lower 0,2.5 -body_foot_upper 1,3 -body_foot_rigid moving -body_foot_mu 0.6"
            + " -body_foot_velocity '0,-0.05*min(t/0.2,1)' -initial_stress k0" + ends(2, history="").rstrip() + " -history_bodies foot")


def n_gamma(run, n):
    """Mean over the last fifth of the way of 0.1 m, less what the sand beside the sunken footing adds, 18.4 rho g s."""
    load, sunk = -run.column("reaction_foot_y"), 0.05 * (run.column("time") - 0.1)
    return np.mean((load / 19620 - 18.4 * sunk)[-20:])


def heap(width):
    return lambda n: (grid([0, 0], [4, 1.25], 1 / n, [0, -9.81], xmin="slip", xmax="slip", ymin="fixed") + SAND
                      + box([0, 0], [width, 1]) + ends(2, snapshots=1, more="-output_fields mass"))


def run_out(width):
    """Of 99.5 % of the sand."""
    def get(run, n):
        m, x = run.particles(-1, "mass", "x")
        return problems.reach(x[:, 0], m) / width - 1
    return get


def thrown_sand(n):
    return (grid([0, 0], [1, 2], 0.4 / n, [0, -9.81], xmin="slip", xmax="slip", ymin="separate") + SAND
            + box([0, 0], [1, 0.4], velocity="0, 3 + 5*y*sin(4*pi*x)") + ends(4, damping=0.3, snapshots=1))


def sand_gap(run, n):
    """In cells, between the floor and the lowest particle."""
    return run.column("lower_b_y")[-1] / run.h


# ---- Water

def tank(n, *parts, size=(1, 1)):
    walls = {f"{axis}{side}": "slip" for axis in "xyz"[:len(size)] for side in ("min", "max")}
    return grid([0] * len(size), size, 1 / n, [0] * (len(size) - 1) + [-9.81], **walls) + WATER + "".join(parts)


def still_tank(n):
    return tank(n, box([0, 0], [1, 0.5]), " -initial_stress k0", ends(2, snapshots=1))


def hydrostatic(run, n):
    """rms error of the pressure of particles below 1.5 h, over rho g H."""
    x, stress, volume = run.particles(-1, "x", "stress", "volume")
    deep = x[:, 1] < 0.5 - 1.5 * run.h
    return rms(-stress[:, [0, 4, 8]].mean(1) / 9810 - (0.5 - x[:, 1]), volume * deep) / 0.5


def sloshing(n):
    velocity = "-0.05*cosh(pi*y)*sin(pi*x), 0.05*sinh(pi*y)*cos(pi*x)"
    return tank(n, box([0, 0], [1, 0.5], velocity=velocity), " -initial_stress k0", ends(5, 1000))


def period(run, n):
    """From the zeros of the displacement of the centre."""
    t, x = run.column("time"), run.column("center_b_x") - 0.5
    k = np.flatnonzero(x[1:-1] * x[2:] < 0) + 1
    zeros = t[k] - x[k] * (t[k + 1] - t[k]) / (x[k + 1] - x[k])
    return 2 * (zeros[-1] - zeros[0]) / (len(zeros) - 1)


A = 0.05715  # width of the column of Martin and Moyce in m


def moyce(n):
    return (grid([0, 0], [5 * A, 2.25 * A], A / n, [0, -9.81], xmin="slip", xmax="slip", ymin="slip")
            + material("fluid", rho=1000, K=2.2426e5, viscosity=1e-3) + box([0, 0], [A, 2 * A])
            + ends(0.18, snapshots=90, more="-output_fields mass"))


def front(*places):
    """Time at which 99.5 % of the water is behind a place in A, or from one place to another, in sqrt(a/2g)."""
    def get(run, n):
        t, x, _, m = problems.positions(run.path(".h5"))
        reached = np.maximum.accumulate([problems.reach(now, m) for now in x[..., 0]])
        times = np.interp(np.array(places) * A, reached, t) / math.sqrt(A / 2 / 9.81)
        return times[-1] - (times[0] if len(times) > 1 else 0)
    return get


def pressed(n, fluid, velocity, end):
    """A closed box, 1 m x 0.2 m, whose side is a piston."""
    walls = grid([0, 0], [1, 0.2], 1 / n, xmin="slip", ymin="slip", ymax="slip", xmax="piston")
    return (walls + f" -bc_xmax_velocity '{velocity}'" + fluid + box([0, 0], [1, 0.2])
            + ends(end, snapshots=1, history="", more="-history_walls xmin,xmax"))


def pressed_water(n):
    return pressed(n, material("fluid", rho=1000, K=2.2e6), "t < 0.5 ? -0.02 : 0", 0.8)


def pressed_gas(n):
    air = material("fluid", rho=1.2, K=1.4e5, tait_gamma=1.4)
    return pressed(n, air, "t < 0.2 ? -2.5 : 0", 0.25)


def wall_pressure(face, since):
    """Mean pressure on the face, 0.2 m long, in kPa, over the times from `since` on."""
    def get(run, n):
        late = run.column("time") > since
        return abs(run.column(f"reaction_{face}_x")[late].mean()) / 0.2 / 1e3
    return get


def beyond(place):
    """Share of the mass whose x is above `place`."""
    def get(run, n):
        x, mass = run.particles(-1, "x", "mass")
        return np.average(x[:, 0] > place, weights=mass)
    return get


def closed_dam(n):
    return tank(n, box([0, 0], [0.4, 0.8]), ends(3, snapshots=1, more="-checkpoint_every 3"))


def closed_dam3d(n):
    more = ends(2, snapshots=1, more="-checkpoint_every 2")
    return tank(n, box([0, 0, 0], [0.4, 0.4, 0.5]), more, size=(1, 0.4, 0.6))


def falling_drop(n):
    shape = "max(0.2 - y, 0.0225 - (x - 0.5)^2 - (y - 0.6)^2)"
    return tank(n, body("expression", expression=shape), ends(6, damping=0.5, snapshots=1))


def growth(run, n):
    """Largest rise of kinetic and strain energy less the work of gravity, over the largest work."""
    left = run.column("total_energy") - run.column("external_work")
    return (left - np.minimum.accumulate(left)).max() / abs(run.column("external_work")).max()


def level(mass):
    """Of water at rest: twice the height of its centre, for the mass that the scene means."""
    return lambda run, n: 2 * run.column(f"center_b_{run.up}")[-1] * mass / run.column("mass")[0]


def volume(mass):
    """Of water at rest, for the mass that the scene means."""
    return lambda run, n: volumes(run, n) * mass / run.column("mass")[0]


def idle(depth):
    """Of water at rest: share of what is deeper than 1.5 h that has no pressure."""
    def get(run, n):
        x, stress, volume = run.particles(-1, "x", "stress", "volume")
        deep = x[:, run.dim - 1] < depth - 1.5 * run.h
        return np.average(stress[:, [0, 4, 8]].sum(1) >= 0, weights=volume * deep)
    return get
