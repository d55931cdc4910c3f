"""Scenes of bodies of revolution with exact results, for test_axisymmetric.py and verify_axisymmetric.py."""
import math

import numpy as np

import check

# k R of the breathing of free bodies of radius R, by their shape and Poisson's ratio; the frequency is k c_p
MODES = {("cylinder", 0): 1.841184, ("cylinder", 0.3): 2.125749, ("sphere", 0): 2.081576, ("sphere", 0.3): 2.670215}


def round_scene(**more):
    """A neo-Hookean cylinder on the axis, and what is different; None leaves an option out."""
    scene = {"dim": 2, "geometry": "axisymmetric", "grid_lower": "0,0", "grid_upper": "2,2", "grid_h": "0.125,0.125", "materials": "m",
             "material_m_model": "neohookean", "material_m_rho": 1000, "material_m_E": 1e6, "material_m_nu": 0.3, "bodies": "b",
             "body_b_shape": "box", "body_b_lower": "0,0", "body_b_upper": "1,1", "body_b_material": "m", "time_end": 1, **more}
    return {key: value for key, value in scene.items() if value is not None}


TOTAL = {"method_frame": "total"}


def run_scene(name, scene, must=True, **more):
    """Runs it here; the results are name.csv and name.h5."""
    path = check.write(name + ".opts", [f"-{key} {value}" for key, value in scene.items()])
    return (check.must if must else check.pebble)("-options_file", path, "-output_dir", ".", **more)


def speed(E, nu, rho=1000):
    return math.sqrt(E * (1 - nu) / ((1 + nu) * (1 - 2 * nu)) / rho)


def breathing(shape, nu, n, **more):
    """A free body of radius 1, n cells, that starts with the velocity of its lowest mode: by how much the frequency is off,
    the mean of the energy over the third period over that of the first (it swings by a part of first order in dt), and what no term of its balance explains over it."""
    k, c, h = MODES[shape, nu], speed(1e6, nu), 1 / n
    period = 2 * math.pi / (k * c)
    if shape == "cylinder":  # J1(k r), in powers of r
        velocity = f"{1e-4 * c}*x*(1-{k**2}*x^2/8+{k**4}*x^4/192-{k**6}*x^6/9216),0"
        place = {"grid_upper": f"1.5,{4 * h}", "body_b_upper": f"1,{4 * h}", "bc_ymin_type": "slip", "bc_ymax_type": "slip"}
    else:  # the spherical Bessel function j1(k r)
        radial = f"{1e-4 * c}*(1-{k**2}*(x^2+y^2)/10+{k**4}*(x^2+y^2)^2/280-{k**6}*(x^2+y^2)^3/15120)"
        velocity = f"x*{radial},y*{radial}"
        place = {"grid_lower": "0,-1.5", "grid_upper": "1.5,1.5", "body_b_shape": "sphere", "body_b_center": "0,0", "body_b_radius": 1,
                 "body_b_lower": None, "body_b_upper": None}
    run_scene("breathing", round_scene(**{"grid_h": f"{h},{h}", "material_m_nu": nu, "body_b_velocity": f'"{velocity}"', "time_end": 3.2 * period,
                                          "history_every": period / 100, "history_energy": "true", **place, **more}))
    rows = check.history("breathing.csv")
    swing, t = rows["kinetic_energy"] - rows["strain_energy"], rows["time"]
    at = np.where(swing[:-1] * swing[1:] < 0)[0]  # four times in a period
    times = t[at] - swing[at] * (t[at + 1] - t[at]) / (swing[at + 1] - swing[at])
    total = rows["total_energy"]
    found = 4 * np.polyfit(np.arange(len(times)), times, 1)[0]
    return period / found - 1, total[(t >= 2 * period) & (t < 3 * period)].mean() / total[t < period].mean(), abs(rows["energy_integration"]).max() / total[0]


def lame(shape, n, **more):
    """A thick tube or sphere, radii 1 and 2, n cells between them, E = 1000, nu = 0.3, under an inner pressure of 1: radius,
    displacement there and what is exact (Lame), inside and outside."""
    E, nu, h = 1000, 0.3, 1 / n
    load = {"loads": "p", "load_p_body": "b", "load_p_type": "pressure", "time_end": 1.5, "damping_time": 0.05}
    if shape == "tube":
        exact = lambda r: (1 + nu) / E / 3 * ((1 - 2 * nu) * r + 4 / r)  # noqa: E731
        place = {"grid_lower": "0.5,0", "grid_upper": f"2.5,{6 * h}", "body_b_lower": "1,0", "body_b_upper": f"2,{6 * h}", "bc_ymin_type": "slip",
                 "bc_ymax_type": "slip", "load_p_face": "xmin", "load_p_value": '"min(1,t/0.3)"'}
    else:
        exact = lambda r: 1 / E / 7 * ((1 - 2 * nu) * r + (1 + nu) / 2 * 8 / r**2)  # noqa: E731
        place = {"grid_lower": "0,-2.5", "grid_upper": "2.5,2.5", "body_b_shape": "annulus", "body_b_center": "0,0", "body_b_inner_radius": 1,
                 "body_b_radius": 2, "body_b_lower": None, "body_b_upper": None, "load_p_value": '"min(1,t/0.3)*(X^2+Y^2<2.25)"'}
    run_scene("lame", round_scene(**{"grid_h": f"{h},{h}", "material_m_model": "elastic", "material_m_rho": 1, "material_m_E": E, **load, **place,
                                     **more}))
    X, x = (check.particles("lame.h5", which, ("x",))["x"][:, :2] for which in (0, -1))
    axes = X * [1, 0] if shape == "tube" else X
    R = np.hypot(*axes.T)
    u = ((x - X) * axes).sum(1) / R
    result = []
    for radius in (1, 2):
        near = abs(R - radius) < 0.3
        result.append((radius, np.polyval(np.polyfit(R[near], u[near], 2), radius), exact(radius)))
    return result


def drawn(inner, n, **more):
    """A ball of radius 2, n cells for each unit of length, with a hole of radius `inner` or none, that is drawn to its centre by a
    force k r per mass: the error of the displacement over the exact one, rms by volume. Inside, u = A r + B/r^2 + C r^3."""
    E, nu, k, h = 1000, 0.3, 0.0175, 1 / n
    lam, mu = E * nu / (1 + nu) / (1 - 2 * nu), E / 2 / (1 + nu)
    C = k / (10 * (lam + 2 * mu))
    free = [[3 * lam + 2 * mu, -4 * mu / r**3] for r in (inner or 1, 2)]  # no stress at a surface
    free[0] = free[0] if inner else [0, 1]
    A, B = np.linalg.solve(free, [-(5 * lam + 6 * mu) * C * r**2 for r in (inner, 2)])
    shape = {"body_b_shape": "annulus", "body_b_inner_radius": inner} if inner else {"body_b_shape": "sphere"}
    run_scene("drawn", round_scene(**{"grid_lower": "0,-2.5", "grid_upper": "2.5,2.5", "grid_h": f"{h},{h}", "body_b_center": "0,0", "body_b_radius": 2,
                                      "body_b_lower": None, "body_b_upper": None, "material_m_model": "elastic", "material_m_rho": 1, "material_m_E": E,
                                      "acceleration": f'"-{k}*X*min(1,t/0.3),-{k}*Y*min(1,t/0.3)"', "time_end": 1.5, "damping_time": 0.05, **shape, **more}))
    X, x = (check.particles("drawn.h5", which, ("x",))["x"][:, :2] for which in (0, -1))
    R = np.hypot(*X.T)
    u, exact = ((x - X) * X).sum(1) / R, A * R + B / R**2 + C * R**3
    return math.sqrt(np.average((u - exact)**2, weights=X[:, 0]) / np.average(exact**2, weights=X[:, 0]))


def impact(n, **more):
    """A ball of radius 1, n cells, that meets a rigid plate at 0.1 m/s, or what `more` has in its place: the history, and by Hertz the
    time of contact and the largest force."""
    h, E, nu, rho = 1 / n, 1e6, 0.3, 1000
    stiff, mass = 4 / 3 * E / (1 - nu**2), 4 / 3 * math.pi * rho
    depth = (5 * mass * 0.1**2 / (4 * stiff))**0.4
    run_scene("impact", round_scene(**{"grid_lower": f"0,{-4 * h}", "grid_upper": f"1.25,{2 + 4 * h}", "grid_h": f"{h},{h}", "bodies": "b,r", "body_b_shape": "sphere",
                                       "body_b_center": f"0,{1 + 0.05 * h}", "body_b_radius": 1, "body_b_lower": None, "body_b_upper": None, "body_b_velocity": "0,-0.1",
                                       "body_r_shape": "box", "body_r_lower": f"0,{-4 * h}", "body_r_upper": "1.25,0", "body_r_rigid": "fixed", "history_bodies": "r",
                                       "history_every": 0, "time_end": 4.2 * depth / 0.1 + 0.5 * h, **more}))
    return check.history("impact.csv"), 2.94 * depth / 0.1, stiff * depth**1.5


def contact_time(rows, force):
    """The time from the first force above a hundredth of the largest one to the last."""
    on = np.nonzero(force > 0.01 * force.max())[0]
    return rows["time"][on[-1]] - rows["time"][on[0] - 1]
