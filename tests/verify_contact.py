"""Contact between bodies beside exact solutions, on grids of which each is finer than the last.

usage: verify_contact.py PEBBLE SOURCE MPIEXEC PART GRIDS

PART: bars slope rolling ball hertz drop disks turned rest float methods footing brake wedge friction. GRIDS: coarse (the first grid alone) or all. Every
row says what was measured, what is exact, and what is allowed.

Blocks on slopes and disks that roll get their weight within 0.2 s, so that they do not bounce; what is exact then follows from
the same formula of t.
"""
import math

import h5py
import numpy as np

import check

RAMP = 0.2  # s


def simulate(name, options, n=1):
    """Runs a scene of these options; the history as arrays."""
    lines = [f"-{key}" + ("" if value is True else f" {value}") for key, value in {"output_format": "none", **options}.items()]
    check.must("-options_file", check.write(name + ".opts", lines), "-output_dir", ".", n=n, timeout=1200)
    rows = check.rows(name + ".csv")
    return {key: np.array([float(row[key]) for row in rows]) for key in rows[0]}


def materials(**moduli):
    """Options of neo-Hookean materials of density 1000 and nu 0.3, each of its E."""
    found = {"materials": ",".join(moduli)}
    for name, E in moduli.items():
        found.update({f"material_{name}_model": "neohookean", f"material_{name}_rho": 1000, f"material_{name}_E": E, f"material_{name}_nu": 0.3})
    return found


def body(name, material, shape, **options):
    return {f"body_{name}_material": material, f"body_{name}_shape": shape, **{f"body_{name}_{key}": value for key, value in options.items()}}


def vector(values):
    return ",".join(repr(float(value)) for value in values)


def frame(tilt):
    """Unit vectors down a slope of so many degrees, and out of it."""
    a = math.radians(tilt)
    return np.array([math.cos(a), -math.sin(a)]), np.array([math.sin(a), math.cos(a)])


def ramped(g):
    """-acceleration of weight that grows to g."""
    return '"' + ",".join(f"{float(value)!r}*(t<{RAMP}?(1-cos(pi*t/{RAMP}))/2:1)" for value in g) + '"'


def ramped_motion(t):
    """Velocity and way of what such a unit acceleration moves."""
    T = RAMP
    return (np.where(t < T, t / 2 - np.sin(np.pi * t / T) * T / (2 * np.pi), t - T / 2),
            np.where(t < T, t ** 2 / 4 - (1 - np.cos(np.pi * t / T)) * T * T / (2 * np.pi ** 2), T * T / 4 - T * T / np.pi ** 2 + T * (t - T) / 2 + (t - T) ** 2 / 2))


def row(good, name, measured, exact, allowed):
    check.that(good, f"{name:<52} {measured:<58} | exact {exact} | {allowed}")


def grids(cells, how):
    return cells[:1] if how == "coarse" else cells


# ---- Two bars: they touch for 2 L/c and exchange their velocities; the stress is rho c v. A bar that hits one at rest of twice
# its length stops, and the other one goes on with half its velocity.
def bars_scene(n, lengths, speeds, gap=0.1, **more):
    lower = 0.45
    a, b = (lower, lower + lengths[0]), (lower + lengths[0] + gap, lower + lengths[0] + gap + lengths[1])
    upper = math.ceil(b[1] + 0.5)
    return {"dim": 1, "grid_lower": 0, "grid_upper": upper, "grid_cells": n * upper, "materials": "m", "material_m_model": "neohookean",
            "material_m_rho": 1, "material_m_E": 1, "material_m_nu": 0, "bodies": "a,b", **body("a", "m", "box", lower=a[0], upper=a[1], velocity=speeds[0]),
            **body("b", "m", "box", lower=b[0], upper=b[1], velocity=speeds[1]), "history_bodies": "all", "history_every": 0.02,
            "contact_mu": 0, "time_end": 12, **more}


def peak_stress(name):
    with h5py.File(name + ".h5") as file:
        return max(np.abs(file[f"step_{step:06d}/particles/stress"][:].reshape(len(file[f"step_{step:06d}/particles/id"]), -1)[:, 0]).max() for step in check.steps(file))


def touching(found, what, tolerance):
    """First and last time at which a column is off its value at the start, and at the end, by more than a share."""
    p, t = found[what], found["time"]
    return t[np.abs(p - p[0]) > tolerance * abs(p[0])][0], t[np.abs(p - p[-1]) > 0.02 * abs(p[-1])][-1]


def bars(how):
    errors = []
    for n in grids((32, 64, 128), how):
        found = simulate(f"bars{n}", bars_scene(n, (1, 1), (0.01, -0.01), output_format="hdf5", output_fields="stress", output_every=0.1))
        v = -found["momentum_a_x"][-1] / 0.01
        start, end = touching(found, "momentum_a_x", 1e-6)
        peak, lost = peak_stress(f"bars{n}") / 0.01, np.abs(found["momentum_x"]).max() / 0.02
        errors.append(1 - v)
        row(v >= 0.94 and 0.97 <= (end - start) / 2 <= 1.03 and 4.98 <= start <= 5.08 and peak <= 1.6 and lost < 1e-13, f"bars, {n} cells each",
            f"v {v:.4f} touch at {start:.2f} for {end - start:.2f} peak {peak:.2f} p {lost:.0e}", "1, 5, 2, 1, 0", ">= 0.94, 4.98 .. 5.08, 3 %, <= 1.6, 1e-13")
    if len(errors) > 1:
        row(all(b < a for a, b in zip(errors, errors[1:])), "bars: velocity lost falls", " ".join(f"{e:.4f}" for e in errors), "0", "falls")
    for n in grids((32, 64), how):
        found = simulate(f"unequal{n}", bars_scene(n, (1, 2), (0.01, 0), time_end=17))
        v = found["momentum_a_x"][-1] / 0.01, found["momentum_b_x"][-1] / 2 / 0.01
        lost = np.abs(found["momentum_x"] / 0.01 - 1).max()
        row(abs(v[0]) <= 0.02 and abs(v[1] - 0.5) <= 0.02 and lost < 1e-13, f"bars 1:2, {n} cells", f"v {v[0]:.4f} {v[1]:.4f} p {lost:.0e}", "0, 0.5, 0", "0.02, 0.02, 1e-13")


# ---- A block on a slope of 30 degrees: gravity is turned, and the floor may be inclined too.
def slope_scene(h, mu, tilt, **more):
    along, out = frame(tilt)
    g = 10 * (0.5 * along - math.sqrt(0.75) * out)
    scene = {"dim": 2, "grid_lower": "0,0", "grid_h": f"{h},{h}", "acceleration": ramped(g), **materials(m=1e7, f=1e7), "bodies": "floor,block",
             "bc_ymin_type": "fixed", "bc_xmin_type": "fixed", "bc_xmax_type": "fixed", "history_bodies": "block", "history_every": 0.02, "time_end": 0.7, "contact_mu": mu}
    if tilt == 0:
        scene.update({"grid_upper": "3,1.5", **body("floor", "f", "box", lower="0,0", upper="3,0.5"), **body("block", "m", "box", lower="0.5,0.5", upper="1.5,1")})
    else:
        corner = np.array([0, 0.5 + 3 * math.tan(math.radians(tilt))])
        foot = corner + 0.5 * along
        top = math.ceil((corner[1] + 0.75) * 4) / 4
        corners = " ".join(vector(foot + a * along + b * out) for a, b in ((0, 0), (1, 0), (1, 0.5), (0, 0.5)))
        scene.update({"grid_upper": f"3,{top}", **body("floor", "f", "halfspace", point=vector(corner), normal=vector(out)),
                      **body("block", "m", "polygon", vertices=f'"{corners}"')})
    return {**scene, **more}


def slope(how):
    ways = {}
    for tilt in (0, 17):
        along, out = frame(tilt)
        for mu in (0, 0.3, 0.7):
            for h in grids((1 / 8, 1 / 12, 1 / 16), how):
                found = simulate(f"slope{tilt}-{mu}-{round(1 / h)}", slope_scene(h, mu, tilt))
                x = np.stack([found["center_block_x"], found["center_block_y"]], 1)
                way = ways[tilt, mu, h] = ((x - x[0]) @ along)[-1]
                free = 10 * ramped_motion(found["time"][-1])[1] * 0.5
                exact = 10 * ramped_motion(found["time"][-1])[1] * max(0, 0.5 - mu * math.sqrt(0.75))
                name = f"block on a slope, floor at {tilt}, mu {mu}, H/h {0.5 / h:.0f}"
                if exact:
                    row(abs(way / exact - 1) <= 0.03, name, f"way {way:.4f}, off {way / exact - 1:+.4f}", f"{exact:.4f}", "3 %")
                else:
                    row(abs(way) <= 3e-3 * free, name, f"way {way:.5f}, {way / free:.4f} of the free one", "0", "3e-3 of the free one, elastic")
    for _, mu, h in [key for key in ways if key[0] == 0 and key[1] < 0.5]:
        both = ways[17, mu, h] / ways[0, mu, h] - 1
        row(abs(both) <= 0.03, f"block, floor at 17 beside that at 0, mu {mu}, H/h {0.5 / h:.0f}", f"ways differ by {both:+.4f}", "0", "3 %")
    for mu in (0, 0.3) if how == "all" else ():  # on a level floor what remains is the elastic displacement, on all grids
        errors = []
        for h in (1 / 8, 1 / 16, 1 / 32):
            found = simulate("falls", slope_scene(h, mu, 17))
            x = np.stack([found["center_block_x"], found["center_block_y"]], 1)
            errors.append(abs((x[-1] - x[0]) @ frame(17)[0] / (10 * ramped_motion(found["time"][-1])[1] * (0.5 - mu * math.sqrt(0.75))) - 1))
        row(errors[0] > errors[1] > errors[2], f"block, floor at 17, mu {mu}, H/h 4, 8, 16: error of its way", " ".join(f"{e:.5f}" for e in errors), "0", "falls")
    for tilt, h in [(tilt, h) for tilt in (0, 17) for h in (1 / 8, 1 / 16)] if how == "all" else []:
        off = []
        for E in (1e7, 1e8):
            found = simulate("stiff", slope_scene(h, 0.3, tilt, material_m_E=E, material_f_E=E))
            x = np.stack([found["center_block_x"], found["center_block_y"]], 1)
            off.append(((x[-1] - x[0]) @ frame(tilt)[0]) / (10 * ramped_motion(found["time"][-1])[1] * (0.5 - 0.3 * math.sqrt(0.75))) - 1)
        row(abs(off[1]) <= 5e-4 and abs(off[1]) < 0.2 * abs(off[0]), f"block on a slope, floor at {tilt}, ten times as stiff, H/h {0.5 / h:.0f}",
            f"off {off[1]:+.5f} (before {off[0]:+.5f})", "0", "5e-4: the error is the elastic displacement")


# ---- A disk or ball that rolls down a slope of 45 degrees.
def rolling_scene(h, mu, dim, length=4.0, **more):
    pad, mid, wide = (",0", ",0.625", ",1.25") if dim == 3 else ("", "", "")
    floor = 0.25
    g = 10 * math.sqrt(0.5)
    scene = {"dim": dim, "grid_lower": "0,0" + pad, "grid_upper": f"{length},{floor + 1.25}{wide}", "grid_h": ",".join([f"{h}"] * dim),
             "acceleration": ramped([g, -g] + [0] * (dim - 2)), **materials(m=1e7, f=1e7), "bodies": "floor,ball", "bc_ymin_type": "fixed", "bc_xmin_type": "fixed",
             "bc_xmax_type": "fixed", **body("floor", "f", "box", lower="0,0" + pad, upper=f"{length},{floor}{wide}"),
             **body("ball", "m", "sphere", center=f"0.75,{floor + 0.5}{mid}", radius=0.5), "history_bodies": "ball", "history_every": 0.02, "contact_mu": mu}
    if dim == 3:
        scene.update({"bc_zmin_type": "slip", "bc_zmax_type": "slip"})
    return {**scene, **more}


def rolls(mu, dim):
    """Acceleration and angular acceleration of a disk or ball on a slope of 45 degrees."""
    inertia, g = (0.5, 0.4)[dim - 2], 10 * math.sqrt(0.5)
    sticks = 1 <= mu * (1 + 1 / inertia)
    a = g / (1 + inertia) if sticks else g * (1 - mu)
    return a, a / 0.5 if sticks else mu * g / (inertia * 0.5)


def roll(name, scene, mu, dim):
    """Velocity and angular velocity at the end, each over the exact one (of a slide without friction: the latter over that of
    rolling)."""
    found = simulate(name, scene)
    inertia = (0.5, 0.4)[dim - 2]
    a, spin = rolls(mu, dim)
    m, speed = found["mass_ball"][0], ramped_motion(found["time"][-1])[0]
    p = found["momentum_ball_x"][-1], found["momentum_ball_y"][-1]
    L = found["angular_momentum_ball_z"][-1] - found["center_ball_x"][-1] * p[1] + found["center_ball_y"][-1] * p[0]
    return p[0] / m / (a * speed), -L / (inertia * m * 0.25) / ((spin or rolls(1, dim)[1]) * speed)


def rigid_roll(name, h, mu, dim, **more):
    """The same of a rigid ball on elastic ground."""
    scene = rolling_scene(h, mu, dim, **more)
    scene = {key: value for key, value in scene.items() if key not in ("contact_mu", "body_ball_material") and not key.startswith("material_m_")}
    found = simulate(name, {**scene, "materials": "f", "body_ball_rigid": "free", "body_ball_rho": 1000, "body_ball_mu": mu})
    a, spin = rolls(mu, dim)
    speed = ramped_motion(found["time"][-1])[0]
    return found["velocity_ball_x"][-1] / (a * speed), -found["spin_ball_z"][-1] / ((spin or rolls(1, dim)[1]) * speed)


def rolling(how):
    for mu in (0, 0.2, 0.5):
        for h in grids((1 / 12, 1 / 16, 1 / 24), how):
            v, w = roll(f"disk{mu}-{h}", rolling_scene(h, mu, 2, time_end=0.7), mu, 2)
            wide = 0.12 if h > 0.07 else 0.08
            row(abs(v - 1) <= 0.05 and abs(w - (mu > 0)) <= wide, f"disk, mu {mu} {'rolls' if mu > 1 / 3 else 'slides'}, R/h {0.5 / h:.0f}",
                f"v {v:.4f} angular v {w:.4f}", f"1, {int(mu > 0)}", f"5 %, {wide}")
    for mu in (0, 0.2, 0.5):
        last = 1
        for h in grids((1 / 12, 1 / 16, 1 / 24), how):
            v, w = rigid_roll(f"rigid{mu}-{h}", h, mu, 2, time_end=0.7)
            off = max(abs(v - 1), abs(w - (mu > 0)))
            row(off <= 0.05 and off < last, f"rigid disk, mu {mu} {'rolls' if mu > 1 / 3 else 'slides'}, R/h {0.5 / h:.0f}", f"v {v:.4f} angular v {w:.4f}", f"1, {int(mu > 0)}", "5 %, falls")
            last = off


def ball(how):
    for mu in (0.1, 0.5):
        for h in grids((1 / 8, 1 / 12, 1 / 16), how):
            for name, (v, w), wide in (("", roll(f"ball{mu}-{h}", rolling_scene(h, mu, 3, length=2.5, time_end=0.5), mu, 3), (0.25, 0.12, 0.05)),
                                       ("rigid ", rigid_roll(f"rigid_ball{mu}-{h}", h, mu, 3, length=2.5, time_end=0.5), (0.1, 0.05, 0.05))):
                allowed = (0.1, wide[0]) if h > 0.1 else (0.05, wide[1] if h > 0.07 else wide[2])
                row(abs(v - 1) <= allowed[0] and abs(w - 1) <= allowed[1], f"{name}ball, mu {mu} {'rolls' if mu > 2 / 7 else 'slides'}, R/h {0.5 / h:.0f}", f"v {v:.4f} angular v {w:.4f}", "1, 1",
                    f"{100 * allowed[0]:.0f} %, {100 * allowed[1]:.0f} %")


# ---- Hertz: a disk of radius 1 that its weight presses on a plate, b = 0.125; normal stress on the axis p0/sqrt(1 + (z/b)^2).
def hertz_scene(h, tilt, g, **more):
    along, out = frame(tilt)
    scene = {"dim": 2, "grid_lower": "0,0", "grid_upper": "3,3", "grid_h": f"{h},{h}", "gravity": vector(-g * out), "materials": "d,p"}
    for name, E in (("d", 1), ("p", 4)):
        scene.update({f"material_{name}_model": "neohookean", f"material_{name}_rho": 1, f"material_{name}_E": E, f"material_{name}_nu": 0.3})
    scene.update({"bodies": "plate,disk", **body("disk", "d", "sphere", center=vector(np.array([1.5, 0.75]) + out), radius=1), "bc_ymin_type": "fixed",
                  "damping_kinetic": True, "time_end": 25, "output_format": "hdf5", "output_every": 25, "output_fields": "stress,body", "contact_mu": 0})
    if tilt == 0:
        scene.update({"bc_xmin_type": "slip", "bc_xmax_type": "slip", **body("plate", "p", "box", lower="0,0", upper="3,0.75")})
    else:
        scene.update({"bc_xmin_type": "fixed", "bc_xmax_type": "fixed", **body("plate", "p", "halfspace", point="1.5,0.75", normal=vector(out))})
    return {**scene, **more}


def axis_stress(name, h, tilt, b):
    """Normal stress times sqrt(1 + (z/b)^2), its mean over three cells on the axis, of plate and disk."""
    along, out = frame(tilt)
    with h5py.File(name + ".h5") as file:
        particles = file[f"step_{check.steps(file)[-1]:06d}/particles"]
        x, stress, of = particles["x"][:][:, :2] - [1.5, 0.75], particles["stress"][:], particles["body"][:]
    normal = -np.einsum("i,pij,j->p", out, stress.reshape(len(x), 3, 3)[:, :2, :2], out)
    u, w = x @ along, x @ out
    found = []
    for side in (0, 1):
        near = (of == side) & (np.abs(u) < 0.5 * h)
        z = np.abs(w[near] - (w[near].min() - h / 4 if side else w[near].max() + h / 4))
        found.append((normal[near] * np.sqrt(1 + (z / b) ** 2))[z < 3 * h].mean())
    return found


def hertz(how):
    b, stiff = 0.125, 1 / (0.91 + 0.91 / 4)
    force = b * b * math.pi * stiff / 4
    p0 = 2 * force / (math.pi * b)
    found = {}
    for tilt in (0, 17):
        for h in grids((1 / 16, 1 / 24, 1 / 32), how):
            simulate(f"hertz{tilt}-{round(1 / h)}", hertz_scene(h, tilt, force / math.pi))
            plate, disk = (value / p0 for value in axis_stress(f"hertz{tilt}-{round(1 / h)}", h, tilt, b))
            found[tilt, h] = (plate, disk)
            row(abs(plate - 1) <= 0.1 and abs(disk - 1) <= 0.1, f"Hertz, plate at {tilt}, {2 * b / h:.0f} cells in the width", f"p0 of plate {plate:.3f}, of disk {disk:.3f}", "1", "10 %")
    if how != "all":
        return
    last = (1, 1)  # Hertz is exact for b/R -> 0: beyond 1/16 and 1/8 with as many cells in b, on a line
    for h in (1 / 16, 1 / 24, 1 / 32):
        simulate("hertz_half", hertz_scene(h / 2, 0, force / (4 * math.pi)))
        off = [abs(2 * 2 * value / p0 - whole - 1) for value, whole in zip(axis_stress("hertz_half", h / 2, 0, b / 2), found[0, h])]
        row(off[0] < last[0] and off[1] < last[1] and max(off) < 0.035, f"Hertz, b/R to 0, {2 * b / h:.0f} cells in the width", f"p0 off by {off[0]:.4f} in the plate, {off[1]:.4f} in the disk", "0", "falls")
        last = off


# ---- Two disks collide.
def disks_scene(cells, angle=0.0, offset=0.0, mu=0.3, turned=False, **more):
    """Disks of radius 0.2 in a unit square, along a line at an angle, each off that line by half the offset."""
    to = np.array([math.cos(math.radians(angle)), math.sin(math.radians(angle))])
    side = np.array([-to[1], to[0]])
    centers = [np.array([0.5, 0.5]) + sign * (0.297 * to + 0.5 * offset * side) for sign in (-1, 1)]
    speeds = [0.14142 * to, -0.14142 * to]
    if turned:
        centers, speeds = ([np.array([1 - y, x]) for x, y in centers], [np.array([-y, x]) for x, y in speeds])
    return {"dim": 2, "grid_lower": "0,0", "grid_upper": "1,1", "grid_cells": f"{cells},{cells}", **materials(m=1e3), "bodies": "a,b",
            **body("a", "m", "sphere", center=vector(centers[0]), radius=0.2, velocity=vector(speeds[0]), ppc="2,2"),
            **body("b", "m", "sphere", center=vector(centers[1]), radius=0.2, velocity=vector(speeds[1]), ppc="2,2"),
            "history_bodies": "all", "history_every": 0.01, "time_end": 1.8, "contact_mu": mu, **more}


def spin(found, name):
    return found[f"angular_momentum_{name}_z"]


def disks(how):
    energies = {}
    for cells in grids((20, 40, 80), how):
        for name, angle, offset in (("along x", 0, 0), ("along the diagonal", 45, 0), ("at an offset", 0, 0.2)):
            found = simulate(f"disks{cells}-{angle}-{offset}", disks_scene(cells, angle, offset))
            plain = simulate(f"plain{cells}-{angle}-{offset}", {key: value for key, value in disks_scene(cells, angle, offset).items() if key != "contact_mu"})
            m, all_p = found["mass_a"][0], 2 * found["mass_a"][0] * 0.14142
            lost = max(np.abs(found[f"momentum_{axis}"]).max() for axis in "xy") / all_p
            L = spin(found, "a") + spin(found, "b")
            L0 = all_p * (offset or 0.2)
            turn = np.abs(L - L[0]).max() / L0
            pa = np.hypot(found["momentum_a_x"] - found["momentum_a_x"][0], found["momentum_a_y"] - found["momentum_a_y"][0])
            start = found["time"][pa > 1e-6 * all_p][0]
            touch = (0.594 - (math.sqrt(0.16 - offset ** 2))) / 0.28284
            kept = [(one["kinetic_energy"] + one["strain_energy"])[-1] / one["kinetic_energy"][0] for one in (found, plain)]
            energies.setdefault(name, []).append(kept[0])
            row(lost < 1e-13 and turn < 0.02 and -0.01 <= start - touch <= 0.35 / cells / 0.28284 + 0.02 and kept[0] <= 1,
                f"disks {name}, {cells} cells", f"p {lost:.0e} L {turn:.0e} touch {start:.3f} energy {kept[0]:.3f} ({kept[1]:.3f} without)",
                f"0, 0, {touch:.3f}, 1", "1e-13, 0.02, +h/3")
    for name, kept in energies.items():
        row(kept[0] >= 0.56 and all(b > a for a, b in zip(kept, kept[1:])), f"disks {name}: energy that is lost falls", " ".join(f"{1 - e:.3f}" for e in kept), "0", "0.44, falls")


def turned(how):
    for offset in (0, 0.2):
        first, second = (simulate(f"turned{offset}-{turned}", disks_scene(20, 0, offset, turned=turned)) for turned in (False, True))
        worst = 0
        for one, other, sign in (("center_a_x", "center_a_y", 1), ("momentum_a_x", "momentum_a_y", 1), ("momentum_a_y", "momentum_a_x", -1), ("momentum_b_x", "momentum_b_y", 1)):
            worst = max(worst, np.abs(first[one] - sign * second[other]).max() / np.abs(first[one]).max() if np.abs(first[one]).max() > 1e-9 else 0)
        allowed = 1e-5 if offset else 1e-12  # impulses are found until a round changes them by less than this part
        row(worst < allowed, f"disks at offset {offset}, the scene turned by 90 degrees", f"{worst:.1e}", "0", f"{allowed:.0e}, relative")


# ---- Bodies at rest on each other: what the walls carry.
def rest_scene(h, bodies, walls, g, **more):
    scene = {"dim": 2, "grid_lower": "0,0", "grid_upper": "1.5,2", "grid_h": f"{h},{h}", "acceleration": ramped(g), **materials(m=1e6), "bodies": ",".join(bodies),
             "damping_time": 0.1, "time_end": 1.5, "history_bodies": "all", "history_every": 0.1, "history_walls": "all", "contact_mu": 0, **{f"bc_{face}_type": "slip" for face in walls}}
    for name, (lower, upper) in bodies.items():
        scene.update(body(name, "m", "box", lower=vector(lower), upper=vector(upper)))
    return {**scene, **more}


def rest(how):
    for h in grids((0.125, 0.0625), how):
        stack = {"low": ((0.25, 0), (1.25, 0.5)), "middle": ((0.5, 0.5), (1, 1)), "high": ((0.25, 1), (1.25, 1.5))}
        found = simulate(f"stack{h}", rest_scene(h, stack, ["ymin"], [0, -10]))
        weight = 1000 * 10 * 1.25
        carried, moves = found["reaction_ymin_y"][-1] / weight, max(np.abs(found[f"momentum_{name}_y"][-1]) / found[f"mass_{name}"][0] for name in stack)
        sinks = found["center_high_y"][0] - found["center_high_y"][-1]
        row(abs(carried - 1) <= 0.01 and moves < 2e-3, f"three blocks on each other, {0.5 / h:.0f} cells each", f"reaction {carried:.4f} v {moves:.0e} top sinks {sinks:.4f}", "1, 0", "1 %, 2e-3 m/s")
        corner = {"floor": ((0.5, 0), (1.5, 0.5)), "side": ((0, 0), (0.5, 1.5)), "block": ((0.5, 0.5), (1, 1))}
        found = simulate(f"corner{h}", rest_scene(h, corner, ["ymin", "xmin", "xmax"], [-10, -10]))
        weight = 1000 * 10 * 1.5
        carried = (found["reaction_xmin_x"] + found["reaction_xmax_x"])[-1] / weight, found["reaction_ymin_y"][-1] / weight
        moves = max(np.abs(found[f"momentum_{name}_{axis}"][-1]) / found[f"mass_{name}"][0] for axis in "xy" for name in corner)
        row(abs(carried[0] - 1) <= 0.01 and abs(carried[1] - 1) <= 0.01 and moves < 2e-3, f"a block in the corner of two others, {0.5 / h:.0f} cells",
            f"reactions {carried[0]:.4f} {carried[1]:.4f} v {moves:.0e}", "1, 1, 0", "1 %, 1 %, 2e-3 m/s")


# ---- A light block floats: its centre, by Archimedes.
def float_scene(h, rho, **more):
    scene = {"dim": 2, "gravity": "0,-10", "grid_lower": "0,0", "grid_upper": "2,1.5", "grid_h": f"{h},{h}", "bc_xmin_type": "slip", "bc_xmax_type": "slip", "bc_ymin_type": "slip",
             **materials(wood=1e6), "bodies": "block,pool", **body("block", "wood", "box", lower="0.8,0.4", upper="1.2,0.8"),
             **body("pool", "water", "box", lower="0,0", upper="2,0.8", cut="block"), "damping_time": 0.5, "time_end": 4, "history_every": 0.1, "history_bodies": "block",
             "contact_mu": 0}
    scene.update({"materials": "wood,water", "material_wood_rho": rho, "material_water_model": "fluid", "material_water_rho": 1000, "material_water_K": 1e6})
    return {**scene, **more}


def floats(how):
    for h in grids((0.1, 0.05), how):
        for rho in (200, 850):  # a square block of a density between 211 and 789 turns over
            found = simulate(f"float{h}-{rho}", float_scene(h, rho))
            deep = rho / 1000 * 0.4
            exact = (1.44 + 0.4 * deep) / 2 - deep + 0.2
            late = found["time"] > 2
            y, turn = found["center_block_y"][late].mean(), found["upper_block_y"][-1] - found["lower_block_y"][-1] - (found["upper_block_y"][0] - found["lower_block_y"][0])
            row(abs(y - exact) <= 0.5 * h and abs(turn) < 0.05, f"a block of density {rho} floats, h {h}", f"centre {y:.4f}, turned by {turn:.3f} m", f"{exact:.3f}", "half a cell")


# ---- Every basis, update and transfer; the presets.
def periodic_scene(axis):
    """A block that friction brakes on a floor along this axis, which is periodic."""
    def place(along, up):
        return f"{along},{up}" if axis == 0 else f"{up},{along}"

    along, up = "xy"[axis], "yx"[axis]
    return {"dim": 2, "grid_lower": "0,0", "grid_upper": place(2, 1.5), "grid_h": "0.125,0.125", "acceleration": ramped([0, -10] if axis == 0 else [-10, 0]),
            **materials(m=1e7, f=1e7), "bodies": "floor,block", **body("floor", "f", "box", lower="0,0", upper=place(2, 0.5)),
            **body("block", "m", "box", lower=place(0.5, 0.5), upper=place(1.5, 1), velocity=place(3, 0)), f"bc_{up}min_type": "fixed",
            f"bc_{along}min_type": "periodic", f"bc_{along}max_type": "periodic", "history_bodies": "block", "history_every": 0.02, "time_end": 0.8, "contact_mu": 0.3}


def methods(how):
    for more in ({"method_preset": preset} for preset in ("fast", "balanced", "accurate", "energy")):
        found = simulate("preset", bars_scene(32, (1, 1), (0.01, -0.01), **more))
        v, (start, end), lost = -found["momentum_a_x"][-1] / 0.01, touching(found, "momentum_a_x", 1e-6), np.abs(found["momentum_x"]).max() / 0.02
        row(v >= 0.9 and 0.95 <= (end - start) / 2 <= 1.05 and 4.98 <= start <= 5.1 and lost < 1e-13, f"bars, preset {more['method_preset']}",
            f"v {v:.4f} touch at {start:.2f} for {end - start:.2f} p {lost:.0e}", "1, 5, 2, 0", ">= 0.9")
    for axis in (0, 1):
        found = simulate("periodic", periodic_scene(axis))
        v, exact = found[f"momentum_block_{'xy'[axis]}"] / found["mass_block"][0], 3 - 3 * ramped_motion(found["time"])[0]
        worst = np.abs(v - exact).max()
        row(worst <= 0.02, f"a block slides, mu 0.3, across periodic {'xy'[axis]}", f"v {v[-1]:.4f}, off by {worst:.4f} at most", f"{exact[-1]:.3f}", "0.02 m/s of 3")
    pairs = [(basis, "usl", transfer) for basis in ("gimp", "bspline2", "bspline3") for transfer in ("flip", "apic")]
    pairs += [("bspline2", update, transfer) for update in ("usf", "musl") for transfer in ("flip", "apic")] + [("bspline2", "musl", transfer) for transfer in ("aflip", "xpic", "afmpm")]
    for basis, update, transfer in pairs:
        found = simulate("method", disks_scene(20, 0, 0.2, method_basis=basis, method_update=update, method_transfer=transfer))
        all_p = 2 * found["mass_a"][0] * 0.14142
        lost = max(np.abs(found[f"momentum_{axis}"]).max() for axis in "xy") / all_p
        energy = found["total_energy"].max() / found["total_energy"][0]
        row(lost < 1e-13 and energy < 1.01, f"disks at an offset, {basis} {update} {transfer}",
            f"p {lost:.0e} most energy {energy:.4f} kept {found['total_energy'][-1] / found['total_energy'][0]:.3f}", "0, 1", "1e-13, 1.01")


# ---- A rigid strip footing is pushed into clay without weight by 2 % of its width, then lifted: its load at the limit is (2 + pi) c,
# rough and smooth. Pushed farther it bears more; on coarse grids F-bar creeps, so slower it bears less, and without F-bar it locks.
def footing_scene(n, mu, c=1e4, **more):
    return {"dim": 2, "geometry": "plane_strain", "grid_lower": "1,0.75", "grid_upper": "5,2.5", "grid_h": f"{1 / n},{1 / n}", "bc_xmin_type": "slip", "bc_xmax_type": "slip",
            "bc_ymin_type": "fixed", "materials": "clay", "material_clay_model": "vonmises", "material_clay_rho": 1800, "material_clay_E": 500 * c, "material_clay_nu": 0.45,
            "material_clay_yield": c * math.sqrt(3), "bodies": "ground,footing", **body("ground", "clay", "box", lower="1,0.75", upper="5,2"), "body_footing_rigid": "moving",
            "body_footing_shape": "box", "body_footing_lower": "2.5,2", "body_footing_upper": "3.5,2.375", "body_footing_mu": mu,
            "body_footing_velocity": '"0,(t<1.4?-0.02/1.4*(1-cos(2*pi*t/1.4)):0.05*(1-cos(2*pi*(t-1.4)/0.8)))"', "time_end": 2, "history_bodies": "footing",
            "history_every": 0.01, **more}


def footing(how):
    jobs = [(mu, n) for mu in (0, 0.3, 10) for n in grids((8, 16), how)]
    found = check.at_once(lambda job: simulate(f"footing{job[0]}-{job[1]}", footing_scene(job[1], job[0])), jobs)
    for (mu, n), one in zip(jobs, found):
        load = -one["reaction_footing_y"] / 1e4
        most, pulls, end = load.max() / (2 + math.pi), -load.min(), np.abs(load[-10:]).max()
        allowed = (0.1, 0.05)[n > 8]
        row(abs(most - 1) <= allowed and pulls <= 1e-9 and end == 0, f"footing, mu {mu}, {n} cells in its width",
            f"load {most:.4f} of the limit, pulls {pulls:.1e} c, {end:.0e} when lifted", "1, 0, 0", f"{100 * allowed:.0f} %")


# ---- A disk, free and rigid, spins between two elastic plates that are pressed together by N: mu N R brakes it on either side.
def brake_scene(h, mu, N, **more):
    return {"dim": 2, "grid_lower": "0,0", "grid_upper": "2,2.25", "grid_h": f"{h},{h}", "bc_xmin_type": "slip", "bc_xmax_type": "slip", "bc_ymin_type": "fixed", **materials(m=1e7),
            "bodies": "low,high,disk", **body("low", "m", "box", lower="0,0", upper="2,0.5"), **body("high", "m", "box", lower="0,1.5", upper="2,2"), "body_disk_rigid": "free",
            "body_disk_shape": "sphere", "body_disk_center": "1,1", "body_disk_radius": 0.5, "body_disk_rho": 2000, "body_disk_spin": 4, "body_disk_mu": mu, "loads": "press",
            "load_press_body": "high", "load_press_type": "pressure", "load_press_face": "ymax", "load_press_value": f'"{N / 2}*(t<0.2?(1-cos(pi*t/0.2))/2:1)"',
            "time_end": 0.8, "history_bodies": "all", "history_every": 0.01, **more}


def brake(how):
    N, R, inertia = 1000, 0.5, 2000 * math.pi / 4 * 0.125
    for mu in (0.1, 0.3):
        for h in grids((1 / 8, 1 / 16), how):
            found = simulate(f"brake{mu}-{round(1 / h)}", brake_scene(h, mu, N))
            late = found["time"] > 0.3
            torque = -inertia * np.polyfit(found["time"][late], found["spin_disk_z"][late], 1)[0] / (2 * mu * N * R)
            total = inertia * (4 - found["spin_disk_z"][-1]) / (2 * mu * N * R * 0.7)
            row(abs(torque - 1) <= 0.05 and abs(total - 1) <= 0.05, f"a disk spins between plates, mu {mu}, R/h {R / h:.0f}", f"torque {torque:.4f}, all spin lost {total:.4f}", "1, 1", "5 %")


# ---- A rigid wedge cuts into clay (scene wedge): the force of slip lines (Hill, Lee and Tupper 1947), energy and momentum. The
# error falls with the cells (at the end the wedge is 7 and 14 cells deep), with the step hardly.
def wedge(how):
    for cells, limit in grids(((48, 0.25), (96, 0.1)), how):
        check.must("-options_file", check.scene("wedge"), "-output_dir", ".", "-output_format", "none", "-grid_cells", f"{cells},{cells * 3 // 4}", "-history_energy", "-history_bodies", "all", "-history_walls", "all",
                   "-history_every", 0.002, timeout=1200)
        rows = check.rows("wedge.csv")
        found = {key: np.array([float(one[key]) for one in rows]) for key in rows[0]}
        t = found["time"]
        deep, force = t > 0.1, np.abs(found["reaction_wedge_y"])
        share = np.sum(force[deep] * t[deep]) / np.sum(t[deep] ** 2) / (5.887 * 2e4 * 0.5)
        given = [sum(found[key] for key in found if key.startswith("reaction_") and key.endswith("_" + axis)) for axis in "xy"]
        lost = max(abs(np.sum(one[1:] * np.diff(t)) - found[f"momentum_{axis}"][-1]) for one, axis in zip(given, "xy")) / np.sum(force[1:] * np.diff(t))
        work, off = found["energy_rigid"][-1], np.abs(found["energy_integration"]).max()
        row(abs(share - 1) <= limit and lost < 1e-5 and off <= 0.01 * work and found["energy_friction"][-1] < 0, f"a wedge cuts into clay, {cells} cells",
            f"force {share:.3f}, momentum {lost:.0e}, energy {off / work:.4f}", "1, 0, 0", f"{limit * 100:.0f} %, 1e-5, 1 %")


# ---- Energy lost to friction at a rigid slope: mu times the normal force times the way; the balance closes.
def friction(how):
    for tilt in (0, 17):
        for h in grids((1 / 8, 1 / 16), how):
            along, out = frame(tilt)
            foot = [np.array([0.5, 0.5 + 3 * math.tan(math.radians(tilt))]) + a * along + b * out for a, b in ((0, 0), (1, 0), (1, 0.5), (0, 0.5))]
            found = simulate(f"friction{tilt}-{round(1 / h)}", {
                "dim": 2, "grid_lower": "0,-1", "grid_upper": "4,3", "grid_h": f"{h},{h}", "acceleration": ramped(10 * (0.5 * along - math.sqrt(0.75) * out)), **materials(m=1e7),
                "bodies": "floor,block", "body_floor_rigid": "fixed", "body_floor_shape": "halfspace", "body_floor_point": vector(foot[0]), "body_floor_normal": vector(out),
                "body_floor_mu": 0.3, **body("block", "m", "polygon", vertices='"' + " ".join(vector(x) for x in foot) + '"'), "history_energy": True, "history_bodies": "block,floor",
                "history_every": 0.02, "time_end": 0.7})
            x = np.stack([found["center_block_x"], found["center_block_y"]], 1)
            normal = np.stack([found["reaction_floor_x"], found["reaction_floor_y"]], 1) @ out
            way = (x - x[0]) @ along
            exact = -0.3 * np.sum(np.diff(way) * normal[1:])  # a block that hops has not its weight as the force
            largest = max(np.abs(found[key]).max() for key in found if key.startswith("energy_") or key == "total_energy" or key == "external_work")
            lost, off = found["energy_friction"][-1] / exact, np.abs(found["energy_integration"]).max() / largest
            row(abs(lost - 1) <= 0.03 and off <= 0.01, f"energy lost to friction, slope at {tilt}, H/h {0.5 / h:.0f}", f"{lost:.4f} of the exact one; not explained {off:.5f}", "1, 0", "3 %, 1 % of the largest")


# ---- A rigid ball drops on an elastic block, beside Hertz: the largest force and the time of contact. The contact grows to a
# quarter of the radius; the block is six times as wide as it to each side, and eight times as deep.
def drop(how):
    E, nu, R, v = 1e6, 0.3, 0.4, 0.6
    stiff = E / (1 - nu ** 2)
    deepest = 0.1 ** 2 / R
    mass = 16 / 15 * stiff * math.sqrt(R) * deepest ** 2.5 / v ** 2
    force, time = 4 / 3 * stiff * math.sqrt(R) * deepest ** 1.5, 2.943 * deepest / v
    for h in grids((0.05, 0.025), how):
        scene = {"dim": 3, "grid_lower": "-0.6,-0.6,-0.8", "grid_upper": "0.6,0.6,1", "grid_h": vector([h] * 3), **materials(m=E), "bodies": "block,ball", **{f"bc_{face}_type": "slip" for face in
                 ("xmin", "xmax", "ymin", "ymax", "zmin")}, **body("block", "m", "box", lower="-0.6,-0.6,-0.8", upper="0.6,0.6,0", ppc="2,2,2"), "body_ball_rigid": "free", "body_ball_shape": "sphere",
                 "body_ball_center": f"0,0,{R + 0.1 * h}", "body_ball_radius": R, "body_ball_mass": mass, "body_ball_velocity": f"0,0,{-v}", "time_end": 1.6 * time, "history_every": time / 50, "history_bodies": "ball"}
        found = simulate(f"drop{h}", scene)
        t, F = found["time"], found["reaction_ball_z"]
        pushes = np.abs(F) > 0.01 * force
        most, lasts, back = np.abs(F).max() / force, (t[pushes][-1] - t[pushes][0]) / time, found["velocity_ball_z"][-1] / v
        row(abs(most - 1) <= 0.1 and abs(lasts - 1) <= 0.1, f"a rigid ball drops, {0.2 / h:.0f} cells in the contact", f"force {most:.3f} of Hertz's, time {lasts:.3f}, rebound {back:.3f}", "1, 1", "10 %")


PARTS = {"bars": bars, "slope": slope, "rolling": rolling, "ball": ball, "hertz": hertz, "disks": disks, "turned": turned, "rest": rest, "float": floats,
         "methods": methods, "drop": drop, "footing": footing, "brake": brake, "wedge": wedge, "friction": friction}

if __name__ == "__main__":
    part, how = check.arguments(__doc__, 2)
    PARTS[part](how)
    check.end()
