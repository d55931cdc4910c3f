"""Statics (-method_time static) beside exact solutions and limits: what was measured, what is exact, what is allowed.

usage: verify_static.py PEBBLE SOURCE MPIEXEC PART

PART: column reissner cylinder footing round motion layer manufactured hertz multigrid newton energy beam parallel failure pays
"""
import json
import math
import os
import re
import resource
import sys

import h5py
import numpy as np

import check
import mpi

PARTS = re.search("^PART: (.*)", __doc__, re.M)[1].split()


def row(good, name, measured, exact, allowed):
    check.that(good, f"{name:<52} {measured:<60} exact {exact:<28} allowed {allowed}")


def body(shape, dim, law, **more):
    return [f"-dim {dim}", "-materials m", f"-material_m_model {law}", "-material_m_rho 1000", "-bodies b", f"-body_b_shape {shape}", "-body_b_material m",
            *(f"-{key} {value}" for key, value in more.items())]


def run(name, lines, *options, status=0, n=1):
    """A run; the places of particles at first, how they moved, their stresses, shares of time, and what the run said."""
    path = check.write(name + ".opts", [*lines, "-method_time static", "-time_end 1", "-checkpoint_wall 0"])
    told = check.pebble("-options_file", path, "-output_dir", ".", *options, n=n, timeout=1200)
    check.fault(None if told.status == status else f"{name}: exit status {told.status}\n{told.said}")
    with h5py.File(name + ".h5") as file:
        steps = sorted(key for key in file if key.startswith("step_"))
        states = []
        for step in steps:
            particles = file[step]["particles"]
            order = np.argsort(particles["id"][:].ravel())
            states.append((float(file[step].attrs["time"]), particles["x"][:][order], particles["stress"][:][order]))
    X = states[0][1]
    return X, [(time, x - X, stress) for time, x, stress in states], told


def lambert(z):
    """W with W exp(W) = z."""
    w = np.log1p(z)
    for _ in range(50):
        w = w - (w * np.exp(w) - z) / (np.exp(w) * (w + 1))
    return w


# The stretch of a column at q, and the integral of it from 0 to z.
STRETCH = {
    "vonmises": (lambda q: lambert(q) / q, lambda z: lambert(z) + lambert(z) ** 2 / 2),
    "neohookean": (lambda q: np.sqrt(1 + q * q) - q, lambda z: (z * np.sqrt(1 + z * z) + np.arcsinh(z) - z * z) / 2),
    "elastic": (lambda q: 1 - q, lambda z: z - z * z / 2),
}


def standing(name, law, s, n, *more):
    """A column whose weight over E and its section is s, in 20 steps: places at first and at the end over its height, stress over s E."""
    X, states, told = run(name, [*body("box", 1, law, material_m_E=1e6, material_m_nu=0, body_b_lower=0, body_b_upper=1, body_b_ppc=2, grid_lower=0, grid_upper=1, grid_cells=n,
                                       gravity=-1000 * s, bc_xmin_type="fixed", dt_size=0.05), *(["-material_m_yield 1e30", "-method_locking none"] if law == "vonmises" else [])], *more)
    return X[:, 0], X[:, 0] + states[-1][1][:, 0], states[-1][2].reshape(len(X), -1)[:, 0] / (1e6 * s), told


def column():
    """A column under its own weight, nu = 0, whose nominal stress, here also that of Cauchy, is rho g times what is above: its height and
    the stretch of its foot for three laws, two columns of other codes, and the order of the errors in both frames."""
    for law, heights in (("vonmises", (0.5, 1, 2)), ("neohookean", (0.5, 1, 2)), ("elastic", (0.5,))):
        for s in heights:
            stretch, integral = STRETCH[law]
            X, y, _, told = standing("height", law, s, 64, *(["-check_law", "warn"] if law == "elastic" else []))
            steps = np.diff(y) / np.diff(X)
            found, want = (y[-1] + 1 - X[-1], 2 * steps[0] - steps[1]), (integral(s) / s, stretch(s))
            row(abs(found[0] / want[0] - 1) < 2e-4 and abs(found[1] / want[1] - 1) < 5e-3, f"column, {law}, rho g l/E = {s:g}: height, stretch of the foot", f"{found[0]:.6f} {found[1]:.6f}", f"{want[0]:.6f} {want[1]:.6f}", "0.02 %, 0.5 %")
    _, y, _, _ = standing("ample", "vonmises", 80 * 10 * 50 / 1e6, 64)
    row(abs(50 * (1 - y[-1] - 1 / 256) / 0.962009 - 1) < 2e-3, "column of AMPLE: its top falls by, m", f"{50 * (1 - y[-1] - 1 / 256):.6f}", "0.962009", "0.2 %")
    _, y, _, _ = standing("ampssie", "vonmises", 50 * 9.81 * 0.8 / 283.06, 64)
    row(abs(0.8 * (y[-1] + 1 / 256) / 0.53863 - 1) < 1e-3, "column of AMPSSIE: its height, m", f"{0.8 * (y[-1] + 1 / 256):.5f}", "0.53863", "0.1 %")

    def errors(law, sizes, *more):
        stretch, integral = STRETCH[law]
        y, stress = [], []
        for n in sizes:
            X, at, found, _ = standing("column", law, 1, n, *more)
            y.append(math.sqrt(np.mean((at - integral(1) + integral(1 - X)) ** 2)))
            stress.append(math.sqrt(np.mean((found + 1 - X) ** 2)))
        return y, stress

    y, stress = errors("neohookean", (16, 32, 64))
    for what, found, least, most in (("places, rms over height", y, 1.9, 4.5e-6), ("stress, rms over that of the foot", stress, 1.3, 4e-4)):
        order = math.log2(found[-2] / found[-1])
        row(order > least and found[-1] < most, f"column under its weight, {what}, 16, 32, 64", " ".join(f"{e:.2e}" for e in found) + f" order {order:.2f}", "0",
            f"{most:g}, order {least}")
    # The updated frame: rms errors of another program (of its own, in Python) with 8 to 128 cells; of GIMP with stretched domains the order is 2.
    for basis, more, expected in (("gimp, stretched", ("gimp", "-method_gimp_update", "stretch"), ((4.3e-4, 9.5e-5, 1.8e-5, 3.4e-6, 6.1e-7), (1.5e-2, 5.3e-3, 1.8e-3, 7.6e-4, 3.4e-4))),
                                  ("gimp", ("gimp", "-method_gimp_update", "none"), ((4.4e-3, 2.8e-3, 2.0e-3, 1.0e-3, 9.0e-4), (5.0e-2, None, None, None, 1.9e-2))),
                                  ("bspline2", ("bspline2",), ((6.0e-4, 5.6e-4, 8.0e-4, 3.4e-4, 4.4e-4), (1.4e-2, 7.8e-3, 1.1e-2, 1.2e-2, 1.1e-2))),
                                  ("linear", ("linear",), ((2.1e-2, 2.1e-2, 2.2e-2, 2.1e-2, 2.3e-2), (0.17, None, None, None, 0.13)))):
        both = errors("vonmises", (8, 16, 32, 64, 128), "-method_frame", "updated", "-method_basis", *more)
        for what, found, want in zip(("places", "stress"), both, expected):
            order = math.log2(found[1] / found[-1]) / 3
            least = (2 if what == "places" else 1) if basis == "gimp, stretched" else -9
            row(all(b is None or a < 1.3 * b for a, b in zip(found, want)) and order > least, f"the same, {basis}, updated frame, {what}, 8 to 128", " ".join(f"{e:.1e}" for e in found) + f" order {order:.2f}",
                " ".join(f"{e:.1e}" if e else "-" for e in want), "1.3 times it" + (f", order {least}" if least > 0 else ""))


def without(scene, *names):
    """The lines of a scene of options/ but for its preset, these options, and what `run` gives."""
    leave = "|".join(("method_time", "time_end", "method_preset", *names))
    return [line for line in check.content(check.scene(scene)).decode().splitlines() if not re.match(rf"-({leave}) ", line)]


# The inextensible elastica with a dead load P at its end: alpha = P l^2/EI, shortening and deflection over l.
ELASTICA = {1: (0.05643, 0.30172), 2: (0.16064, 0.49346), 3: (0.25442, 0.60325), 4: (0.32894, 0.66996), 5: (0.38763, 0.71379), 6: (0.43459, 0.74457), 8: (0.50483, 0.78498), 10: (0.55500, 0.81061)}


def reissner():
    """The cantilever of AMPLE (Coombs and Augarde 2020) beside Reissner's beam, which stretches and shears, in both frames; one four times as
    slender beside the elastica; over their lengths."""
    exact = {0.2: (0.1533, 0.4852), 0.4: (0.3196, 0.6666), 0.6: (0.4258, 0.7454), 0.8: (0.4970, 0.7891), 1.0: (0.5480, 0.8175)}
    runs = [("", h, ("-method_preset", "solid"), 0.02) for h in ("0.5", "0.25")]
    runs += [(f", updated, {basis}", "0.25", ("-method_frame", "updated", "-method_stabilize_factor", "0.01", "-method_basis", basis, *more), allowed)
             for basis, more, allowed in (("bspline2", (), 0.02), ("gimp", ("-method_gimp_update", "stretch"), 0.02), ("linear", (), 0.05))]
    for what, h, more, allowed in runs:
        X, states, told = run("reissner", without("reissner"), "-grid_h", f"{h},{h}", "-output_every", "0.2", *more)
        end = X[:, 0] > X[:, 0].max() - 1e-9
        for share, want in exact.items():
            _, u, _ = min(states, key=lambda state: abs(state[0] - share))
            found = -u[end].mean(0)[:2] / 10
            row(max(abs(found / want - 1)) < allowed, f"cantilever{what}, {100 * share:.0f} kN, h = {h}", f"{found[0]:.4f} {found[1]:.4f}", f"{want[0]:.4f} {want[1]:.4f}", f"{100 * allowed:g} %")
        newton = int(told.find(r"^static .* with (\d+) Newton")) / int(told.find(r"^static +(\d+) solves"))
        row(newton < 6.5, f"cantilever{what}, h = {h}, iterations of Newton's method in a step", f"{newton:.1f}", "5", "6.5")
    P = 10 * 12e6 * 0.25**3 / 12 / (1 - 0.2**2) / 10**2
    X, states, _ = run("slender", without("reissner"), "-method_preset", "solid", "-grid_lower", "0,-9.5",
                       "-grid_h", "0.0625,0.0625", "-body_beam_lower", "0,-0.125", "-body_beam_upper", "10,0.125", "-load_end_value", f"0,{-P / 0.25}*t", "-output_every", "0.1", "-output_exact")
    end = X[:, 0] > X[:, 0].max() - 1e-9
    for alpha, want in ELASTICA.items():
        _, u, _ = min(states, key=lambda state: abs(10 * state[0] - alpha))
        found = -u[end].mean(0)[:2] / 10
        row(max(abs(found / want - 1)) < 0.02, f"slender cantilever, P l^2/EI = {alpha}", f"{found[0]:.5f} {found[1]:.5f}", f"{want[0]:.5f} {want[1]:.5f} (elastica)", "2 %")


TUBE = dict(body_b_expression='"min(4-x^2-y^2,x^2+y^2-1)"', body_b_lower="0,0", body_b_upper="2,2", grid_lower="0,0", grid_upper="2.5,2.5", bc_xmin_type="slip", bc_ymin_type="slip", loads="p", load_p_body="b",
            load_p_type="pressure")


def fields(name, field):
    """A field of the particles in all snapshots of a run, by time."""
    with h5py.File(name + ".h5") as file:
        steps = [file[key] for key in file if key.startswith("step_")]
        return sorted(((float(step.attrs["time"]), step["particles"][field][:].ravel()) for step in steps), key=lambda pair: pair[0])


def cylinder():
    """A quarter of a thick cylinder, radii 1 and 2, under pressure from inside of 1e-5 E, beside Lame: the rms of the radial
    displacement's error over that of the displacement; the displacements of both rims, by the fit A r + B/r, also of matter that hardly changes its volume,
    with F-bar. The surface is a staircase. Metal: the first that yields, in a disk of revolution, and how far it does."""
    errors = []
    for n in (8, 16, 32):
        for nu, locking in ((0.3, "none"), (0.499, "fbar"), (0.499, "none")):
            if n == 32 and nu > 0.3:
                continue
            X, states, _ = run(f"cylinder{n}", body("expression", 2, "neohookean", material_m_E=1000, material_m_nu=nu, grid_h=f"{1 / n},{1 / n}", load_p_value='"0.01*t*(X^2+Y^2<2.25)"', dt_size=0.5,
                                                   method_locking=locking, **TUBE))
            r, u = np.hypot(X[:, 0], X[:, 1]), states[-1][1]
            want = (1 + nu) * 0.01 / 1000 / 3 * ((1 - 2 * nu) * r + 4 / r)
            got = (u[:, 0] * X[:, 0] + u[:, 1] * X[:, 1]) / r
            if nu == 0.3:
                errors.append(math.sqrt(np.mean((got - want) ** 2) / np.mean(want**2)))
            if n > 8:
                (A, B), *_ = np.linalg.lstsq(np.stack([r, 1 / r], axis=1), 100 * got, rcond=None)
                rims, exact, allowed = (A + B, 2 * A + B / 2), (1.906667e-3, 1.213333e-3) if nu == 0.3 else (1.999666e-3, 1.001332e-3), 0.05 if nu > 0.3 else 0.02
                row(max(abs(np.array(rims) / exact - 1)) < allowed, f"thick cylinder, nu = {nu}, F-bar {locking}, {n} cells: both rims move by", f"{rims[0]:.6f} {rims[1]:.6f}", f"{exact[0]:.6f} {exact[1]:.6f}", f"{100 * allowed:g} %")
    row(errors[0] > errors[1] > errors[2] and errors[2] < 0.006, "thick cylinder, 8, 16, 32 cells in its wall", " ".join(f"{100 * e:.2f} %" for e in errors), "0 (Lame)", "0.6 %, falling")
    run("yields", body("box", 2, "vonmises", geometry="axisymmetric", material_m_E=1e4, material_m_nu=0.499, material_m_yield=1, body_b_lower="1,0", body_b_upper="2,0.25", grid_lower="0,0", grid_upper="2.5,0.25",
                       grid_h="0.03125,0.03125", bc_xmin_type="slip", bc_ymin_type="slip", bc_ymax_type="slip", loads="p", load_p_body="b", load_p_type="pressure", load_p_face="xmin", load_p_value="0.5*t",
                       dt_size=0.01, output_every=0.01))
    first = next(0.5 * time for time, strain in fields("yields", "plastic_strain") if strain.max() > 0)
    row(abs(first / 0.43301 - 1) < 0.03, "thick cylinder, nu = 0.499, 32 cells: it yields first at, over its yield stress", f"{first:.4f}", "0.4330", "3 %")
    X, _, _ = run("tube", without("tube_static"), "-method_preset", "solid")
    far = np.hypot(X[:, 0], X[:, 1])[fields("tube", "plastic_strain")[-1][1] > 1e-7].max()
    row(abs(far - 1.5) < 0.06, "thick cylinder at 0.72078 of its yield stress: it has flowed up to, m", f"{far:.3f}", "1.5", "0.06")


def footing():
    """The largest load of a strip footing for which an equilibrium is found, over 2 + pi times the strength of the clay: as the scene is, and
    in the updated frame with three bases, with and without F-bar, beside another program (of its own, in Python)."""
    def limit(name, h, *more):
        _, _, told = run(name, without("footing_static"), "-grid_h", f"{h},{h}", "-grid_upper", "6,3.5", "-dt_retry", "4", "-time_end", "1.4", *more, status=3)
        return float(re.search(r"stopped at step \d+, t=(\S+) s", told.said)[1])

    found = [limit("footing", h, "-method_preset", "solid") for h in (0.25, 0.125)]
    row(abs(found[1] - 1) < 0.05 and abs(found[0] - 1) < 0.1, "strip footing, limit over 2 + pi, h = 1/4, 1/8", " ".join(f"{value:.3f}" for value in found), "1 (Prandtl)", "10 %, 5 %")
    for basis, locking, expected in (("linear", "none", (1.31, 1.18)), ("gimp", "none", (1.25, 1.09)), ("bspline2", "none", (1.19, 1.09)), ("linear", "fbar", (1.08, 1.045)), ("gimp", "fbar", (1.22, 1.09)), ("bspline2", "fbar", (1.18, 1.09))):
        found = [limit("footing", h, "-method_frame", "updated", "-method_basis", basis, "-method_locking", locking, "-method_stabilize_factor", "0.01") for h in (0.25, 0.125)]
        row(found[1] < found[0] < 1.35 and 1 <= found[1] < 1.15, f"strip footing, updated, {basis}, F-bar {locking}, h = 1/4, 1/8", " ".join(f"{value:.3f}" for value in found), " ".join(f"{value:g}" for value in expected), "falls, to 1 to 1.15")


def round():
    """Bodies of revolution, radii 1 and 2, under pressure from inside: radial displacements beside Lame, and limits."""
    for name, body_of, face, radius, exact, limit in (
        ("cylinder", dict(shape="box", body_b_lower="1,0", body_b_upper="2,1"), "xmin", lambda x: x[:, 0], lambda r: 1.3e-5 / 3 * (0.4 * r + 4 / r), 2 / math.sqrt(3) * math.log(2)),
        ("ball", dict(shape="expression", body_b_lower="0,0", body_b_upper="2,2", body_b_expression='"min(4-x^2-y^2,x^2+y^2-1)"', body_b_ppc="3,3"), "all",
         lambda x: np.hypot(x[:, 0], x[:, 1]), lambda r: 1e-5 / 7 * (0.4 * r + 5.2 / r**2), 2 * math.log(2))):
        errors, factors, where = [], [], "*(X^2+Y^2<2.25)" if name == "ball" else ""
        shape = body_of.pop("shape")
        for n in (8, 16, 32):
            common = dict(geometry="axisymmetric", grid_lower="0,0", grid_upper="2.5,2.5" if name == "ball" else "2.5,1", grid_h=f"{1 / n},{1 / n}", bc_xmin_type="slip", bc_ymin_type="slip",
                          loads="p", load_p_body="b", load_p_type="pressure", load_p_face=face, dt_size=0.2, **body_of)
            if name == "cylinder":
                common["bc_ymax_type"] = "slip"
            X, states, _ = run(f"{name}{n}", body(shape, 2, "neohookean", material_m_E=1000, material_m_nu=0.3, load_p_value=f'"0.01*t{where}"', **common))
            r, u = radius(X), states[-1][1]
            along = u[:, 0] if name == "cylinder" else (u[:, 0] * X[:, 0] + u[:, 1] * X[:, 1]) / r
            errors.append(math.sqrt(np.mean((along - exact(r)) ** 2) / np.mean(exact(r) ** 2)))
            if n < 32:
                _, _, told = run(f"{name}limit{n}", body(shape, 2, "vonmises", material_m_E=1e4, material_m_nu=0.3, material_m_yield=1, load_p_value=f'"{2 * limit}*t{where}"', **common),
                                 "-dt_retry", "5", status=3)
                factors.append(2 * float(re.search(r"stopped at step \d+, t=(\S+) s", told.said)[1]))
        row(errors[-1] < (0.0002 if name == "cylinder" else 0.008) and errors[-1] < errors[0], f"thick {name} of revolution, 8, 16, 32 cells", " ".join(f"{100 * e:.3f} %" for e in errors), "0 (Lame)",
            "0.02 %" if name == "cylinder" else "0.8 %")
        row(all(abs(f - 1) < 0.03 for f in factors), f"thick {name} of revolution, its limit, 8, 16 cells", " ".join(f"{f:.3f}" for f in factors), "1", "3 %")


def motion():
    """A standing wave in a bar of 128 cells, in steps of C h/c up to t = 0.75: the error over that of theory, of one mode."""
    w, exact = math.pi, math.sin(0.75 * math.pi)
    for time, allowed in (("euler", 0.01), ("newmark", 0.02)):
        found, theory = [], []
        for steps in (3, 6, 12, 24):
            dt = 0.75 / steps
            lines = body("box", 1, "elastic", material_m_E=1000, material_m_nu=0, body_b_lower=0, body_b_upper=1, grid_lower=0, grid_upper=1, grid_cells=128, bc_xmin_type="fixed", bc_xmax_type="fixed",
                         reference_type="standing", reference_amplitude=1e-5, dt_size=dt)
            path = check.write(f"{time}{steps}.opts", [*lines, f"-method_time {time}", "-time_end 0.75", "-output_format none", "-checkpoint_wall 0", "-snes_rtol 1e-10"])
            found.append(float(check.pebble("-options_file", path, "-output_dir", ".").find(r"the relative error is (\S+)")))
            theory.append(abs((((1 / (1 - 1j * w * dt)) ** steps).imag if time == "euler" else math.sin(2 * steps * math.atan(w * dt / 2))) / exact - 1))
        row(all(abs(a / b - 1) < allowed for a, b in zip(found, theory)), f"bar in time, {time}, C = 32, 16, 8, 4", " ".join(f"{e:.4g}" for e in found), " ".join(f"{e:.4g}" for e in theory), f"{100 * allowed:g} % of it")


def layer():
    """A layer that is held at its sides under a pressure of 1e-6 (lambda + 2 mu): it sinks by that share. With splines the error is that of
    sums over particles in the two outermost cells, over which a load is spread by weights that fall linearly: it halves with the cells, falls with the
    number of particles, and with gimp, whose functions are averaged over particles, there is none."""
    modulus = 1e6 * 0.7 / (1.3 * 0.4)
    for name, h, ppc, basis, most in (("8 cells", 0.125, 2, "bspline2", 3.5e-3), ("16 cells", 0.0625, 2, "bspline2", 1.7e-3), ("8 cells, 4 x 4 particles", 0.125, 4, "bspline2", 1e-3), ("8 cells, gimp", 0.125, 2, "gimp", 1e-8)):
        X, states, told = run("layer", body("box", 2, "elastic", material_m_E=1e6, material_m_nu=0.3, body_b_lower="0,0", body_b_upper="1,1", body_b_ppc=f"{ppc},{ppc}", grid_lower="0,0", grid_upper="1,1.5",
                                            grid_h=f"{h},{h}", bc_xmin_type="slip", bc_xmax_type="slip", bc_ymin_type="fixed", loads="p", load_p_body="b", load_p_type="pressure", load_p_face="ymax",
                                            load_p_value=f'"{1e-6 * modulus}*t"', dt_size=1, method_basis=basis))
        error = np.abs(states[-1][1][:, 1] / X[:, 1] / -1e-6 - 1).max()
        row(error < most, f"layer under pressure, worst place, {name}", f"{100 * error:.2g} %", "0", f"{100 * most:g} %")


def manufactured():
    """u_d = A t sin(2 pi X_d) in a square of neo-Hookean material between smooth walls, A = 0.02: the body force that it needs is given as a
    formula."""
    A, lame, mu, errors = 0.02, 1 * 0.3 / (1.3 * 0.4), 1 / 2.6, []
    stretch = {d: f"(1+{A}*t*2*pi*cos(2*pi*{d}))" for d in "XY"}
    force = ",".join(f"({lame}*(1-ln({stretch['X']}*{stretch['Y']}))/({stretch[d]}^2)+{mu}*(1+1/({stretch[d]}^2)))*{A}*t*4*pi^2*sin(2*pi*{d})/1000" for d in "XY")
    for n in (8, 16, 32):
        X, states, _ = run(f"manufactured{n}", body("box", 2, "neohookean", material_m_E=1, material_m_nu=0.3, body_b_lower="0,0", body_b_upper="1,1", grid_lower="0,0", grid_upper="1,1", grid_cells=f"{n},{n}",
                                                    bc_xmin_type="slip", bc_xmax_type="slip", bc_ymin_type="slip", bc_ymax_type="slip", acceleration=f'"{force}"', dt_size=0.5))
        errors.append(math.sqrt(np.mean((states[-1][1][:, :2] - A * np.sin(2 * math.pi * X[:, :2])) ** 2)) / A)
    order = math.log2(errors[-2] / errors[-1])
    row(order > 1.9 and errors[-1] < 3e-3, "manufactured statics, rms error over amplitude, 8, 16, 32", " ".join(f"{e:.2e}" for e in errors) + f" order {order:.2f}", "0", "3e-3, order 1.9")


def hertz():
    """Half of a ball of radius 1 pressed on a smooth floor: the force at an approach of 0.02, over that of Hertz, who has a half-space."""
    found = []
    for n in (16, 32, 64):
        run(f"hertz{n}", body("expression", 2, "neohookean", geometry="axisymmetric", grid_lower="0,0", grid_upper="1.25,1", grid_h=f"{1 / n},{1 / n}", bc_xmin_type="slip", bc_ymin_type="separate", bc_ymax_type="moving",
                              bc_ymax_velocity="0,-0.02", material_m_E=1000, material_m_nu=0.3, body_b_expression='"1-x^2-(y-1)^2"', body_b_lower="0,0", body_b_upper="1,1", history_walls="ymin", history_every=0.1))
        found.append(check.history(f"hertz{n}.csv")["reaction_ymin_y"][-1] / (4 / 3 * 1000 / 0.91 * 0.02**1.5))
    row(all(abs(f - 1) < 0.07 for f in found), "ball on a floor, force, 2, 4, 9 cells in the contact", " ".join(f"{f:.3f}" for f in found), "1 (Hertz)", "7 %")


def multigrid():
    """Iterations of CG with multigrid (GAMG) for one of Newton's method, to 1e-6, on 1, 2, 3, 4 processes: of a beam twice as long as
    high, held at one end, and a square block on a floor that holds it, under their weights."""
    for name, length, wall in (("beam", 2, "xmin"), ("block", 1, "ymin")):
        counts = {}
        for n in (32, 64, 128):
            scene = body("box", 2, "neohookean", material_m_E=1e6, material_m_nu=0.3, body_b_lower="0,0", body_b_upper=f"{length},1", grid_lower="0,-1" if length == 2 else "0,0",
                         grid_upper=f"{length + 0.5},2", grid_h=f"{length / n},{length / n}", gravity="0,-0.1", dt_size=1, **{f"bc_{wall}_type": "fixed"})
            for processes in (1, 2, 3, 4):
                _, _, told = run(f"{name}{n}", scene, "-ksp_type", "cg", "-pc_type", "gamg", n=processes)
                newton, linear = map(int, re.search(r"^static .* with (\d+) Newton and (\d+) linear", told.out, re.M).groups())
                counts[n, processes] = linear / newton
        for processes in (1, 2, 3, 4):
            of = [counts[n, processes] for n in (32, 64, 128)]
            row(max(of) - of[0] <= 3, f"{name}, multigrid on {processes}, 32, 64, 128 cells", " ".join(f"{c:.1f}" for c in of), "", "3 more")


def newton():
    """Residuals of Newton's method over the first one, beside those of another program (of its own, in Python): the last ratio of logarithms is at least 1.5, and
    it takes at most one iteration more."""
    metal, soil = ("-method_locking", "none", "-material_m_yield"), ("-material_m_friction_angle", 30, "-material_m_cohesion", 0.02, "-material_m_dilation_angle")
    for law, g, more, expected in (
        ("elastic", 0.01, (), "6.7e-2 2.3e-4 2.0e-9 6.6e-15"),
        ("neohookean", 0.05, (), "6.3e-1 5.4e-2 5.5e-3 7.4e-6 1.7e-10"),
        ("vonmises", 0.05, (*metal, 1e30), "8.2e-1 5.3e-2 1.8e-3 5.5e-7 1.0e-12"),
        ("vonmises", 0.02, (*metal, 0.05, "-material_m_hardening", 0.1), "3.1e-1 3.9e-1 8.3e-2 8.3e-3 5.0e-5 5.7e-9 4.0e-15"),
        ("vonmises", 0.02, (*metal, 0.08), "2.5e-1 1.4e-2 8.6e-5 1.4e-9"),
        ("druckerprager", 0.02, (*soil, 30), "2.9e-1 1.6e-2 1.0e-4 5.6e-9"),
        ("druckerprager", 0.02, (*soil, 0), "2.9e-1 1.9e-2 5.8e-5 1.6e-9"),
    ):
        lines = body("box", 2, law, material_m_E=1, material_m_nu=0.3, body_b_lower="1,0", body_b_upper="5,4", body_b_ppc="2,2", grid_lower="0,0", grid_upper="7,6", grid_cells="7,6", bc_ymin_type="fixed",
                     gravity=f"{0.0004 * g},{-0.001 * g}", gravity_ramp=0, dt_size=1, method_basis="bspline2", method_stabilize_factor=0.01)
        _, _, told = run("newton", lines, "-snes_monitor", "-snes_linesearch_type", "basic", "-snes_rtol", "1e-11", "-dt_strain", "10", *map(str, more))
        norms = [float(norm) for norm in re.findall(r"SNES Function norm (\S+)", told.out)]
        parts = [norm / norms[0] for norm in norms[1:]]
        clean = [1, *(part for part in parts if part > 1e-12)]
        ratio = math.log(clean[-1] / clean[-2]) / math.log(clean[-2] / clean[-3])
        want = [float(part) for part in expected.split()]
        count = [next((k for k, part in enumerate(some) if part < 1e-8), len(some)) for some in (parts, want)]
        row(ratio >= 1.5 and count[0] <= count[1] + 1, f"Newton, {law} {' '.join(map(str, more[-3:]))}", " ".join(f"{part:.1e}" for part in parts) + f" ratio {ratio:.2f}", expected, "ratio 1.5")


def energy():
    """What is left of the energy of a bar of 32 cells that swings 25 periods in steps of 4 h/c, and of 10 periods with a large amplitude, beside another
    program (of its own, in Python), which carries velocities on particles. Here nodes carry them, and nothing is lost in transfers."""
    bar = dict(material_m_nu=0, body_b_lower=0, body_b_upper=1, grid_lower=0, grid_upper=1, grid_cells=32, bc_xmin_type="fixed", bc_xmax_type="fixed", dt_size=0.125, method_preset="solid")
    for time, law, amplitude, periods, expected in (("newmark", "elastic", 1e-5, 25, "0.93"), ("euler", "elastic", 1e-5, 25, "5e-11"), ("newmark", "neohookean", 0.05, 10, "0.88")):
        lines = body("box", 1, law, material_m_E=1000, body_b_velocity=f'"{amplitude}*pi*sin(pi*x)"', **bar)
        check.fault(None if check.pebble("-options_file", check.write("swings.opts", [*lines, f"-method_time {time}", f"-time_end {2 * periods}", "-output_format none", "-history_every 0", "-checkpoint_wall 0"]),
                                         "-snes_rtol", "1e-10", "-output_dir", ".").good else f"{time} {law} fails")
        kept = check.history("swings.csv")["total_energy"]
        share = kept[-1] / kept[0]
        row(share < 1e-9 if time == "euler" else 0.93 <= share < 1.02, f"bar in time, {time}, {law}, A = {amplitude:g}: energy after {periods} periods", f"{share:.3g}", expected, "under 1e-9" if time == "euler" else "0.93 to 1.02")


def beam():
    """The clamped beam of 4 m x 1 m beside damped explicit runs of an independent implementation and finite elements; the scene cantilever, at rest."""
    with open(os.path.join(check.source, "tests", "reference", "tables.json")) as file:
        small = json.load(file)["cantilever"]
    for name, more in (("linear-none", ("linear",)), ("ugimp-ghost", ("gimp", "-method_gimp_update", "none")), ("quadratic-extrap", ("bspline2",)), ("cubic-extrap", ("bspline3",))):
        for h, want in zip((0.25, 0.125), small[f"small-{name}-musl"]["tip_uy"]):
            X, states, _ = run("beam", body("box", 2, "neohookean", material_m_E=1e6, material_m_nu=0.3, body_b_lower="0,0", body_b_upper="4,1", grid_lower="0,-1", grid_upper="4.5,1.5",
                                            gravity="0,-0.021", bc_xmin_type="fixed", method_frame="updated", method_stabilize_factor=0), "-grid_h", f"{h},{h}", "-method_basis", *more)
            tip = states[-1][1][X[:, 0] > X[:, 0].max() - 1e-9, 1].mean()
            row(abs(tip / want - 1) < 0.005, f"clamped beam, {more[0]}, h = {h}: its end moves by, m", f"{tip:.7f}", f"{want:.7f} (finite elements -0.0077703)", "0.5 %")
    for basis, h, want in (("bspline2", 0.25, -1.263), ("bspline2", 0.125, -1.266), ("bspline2", 0.0625, -1.270), ("gimp", 0.125, -1.263), ("linear", 0.125, -1.339)):
        more = ("-method_gimp_update", "stretch") if basis == "gimp" else ()
        X, states, _ = run("cantilever", without("cantilever", "check_energy", "method_basis", "method_update", "method_transfer", "method_affine_strain", "dt_size", "dt_cfl"), "-method_frame", "updated", "-method_basis", basis,
                           "-grid_h", f"{h},{h}", "-dt_size", "0.05", "-method_stabilize_factor", "0.01", *more)
        tip = states[-1][1][X[:, 0] > X[:, 0].max() - 1e-9, 1].mean()
        row(abs(tip / want - 1) < 0.005, f"options/cantilever.opts at rest, {basis}, h = {h}: its end", f"{tip:.4f}", f"{want:.4f}", "0.5 %")


def parallel():
    """The scene reissner on 1 to 4 processes, each with other cuts of the grid: the same digest each time, with all cuts."""
    for n in (1, 2, 3, 4):
        runs = [run("parallel", without("reissner"), "-method_preset", "solid", n=n) for _ in range(2)]
        places = runs[0][1][-1][1]
        whole, digest = (places, runs[0][2].digest) if n == 1 else (whole, digest)
        off = np.abs(places - whole).max() / 0.5
        row(runs[0][2].good and runs[0][2].digest == runs[1][2].digest == digest and off < 1e-6, f"reissner on {n}: places, over h; digest twice", f"{off:.1e} {runs[0][2].digest} {runs[1][2].digest}", "0, the same", "1e-6")


def failure():
    """A footing beyond its limit: the run ends with status 3 and the state of the last good step, which a run that makes no more steps has too."""
    scene = ("-method_preset", "solid", "-grid_h", "0.5,0.5", "-grid_upper", "6,3.5", "-dt_retry", "3", "-time_end", "1.4")
    _, states, told = run("fails", without("footing_static"), *scene, status=3)
    steps, time = re.search(r"stopped at step (\d+), t=(\S+) s", told.said).groups()
    _, _, good = run("good", without("footing_static"), *scene, "-time_max_steps", steps)
    row(good.digest == told.digest and abs(states[-1][0] / float(time) - 1) < 1e-5, f"footing, stopped after {steps} steps: digest, and of a run of as many", f"{told.digest} {good.digest}", "the same", "0")


def timed(name, lines, *options):
    """The least processor time of two runs, s, and the history of one. It counts no time in which other programs have the core."""
    best = math.inf
    for _ in range(2):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        told = check.pebble("-options_file", check.write(name + ".opts", lines), "-output_dir", ".", "-output_format", "none", "-checkpoint_wall", 0, *options, timeout=1200)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        check.need(told.status == 0, f"{name}: {told.said}")
        best = min(best, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return best, check.history(name + ".csv")


def pays():
    """Processor time of statics beside explicit runs with -damping_kinetic of the same scene, cells and particles: a slender cantilever under its weight, until its
    end stays within 1 % of its place at rest; a footing, whose settlement depends on how the load grows, with loads that grow over longer and longer
    times until its error is that of statics in 5 steps, or over 64 s; and, where statics does not pay, a short cantilever that is bent far, until it stays within 2 % of Reissner's beam."""
    mpi.STARTER = None  # of whose runs this process has no times
    explicit = {"solid": ["-method_time", "explicit", "-method_preset", "solid"], "balanced": ["-method_time", "explicit", "-method_preset", "balanced"]}
    plain = lambda scene, *names: [line for line in check.content(check.scene(scene)).decode().splitlines() if not re.match(rf"-({'|'.join(names)}) ", line)]
    often = ("dt_size", "method_time", "method_preset", "time_end", "output_every", "history_every", "probes", r"probe_\w+")
    slender = [*body("box", 2, "neohookean", material_m_E=1e7, material_m_nu=0.3, body_b_lower="0,0", body_b_upper="40,1", grid_lower="0,-2", grid_upper="41,2", grid_h="0.5,0.5", bc_xmin_type="fixed",
                     gravity="0,-0.001"), "-probes end", "-probe_end_follow 40,0.5"]
    seconds, rows = timed("pays", slender, "-method_time", "static", "-time_end", 1, "-dt_size", 1, "-history_every", 1)
    fallen, others = rows["probe_end_y"][-1] - rows["probe_end_y"][0], {}
    for name, words in explicit.items():
        _, rows = timed("pays", slender, *words, "-damping_kinetic", "-time_end", 150, "-history_every", 0.5)
        late = np.flatnonzero(abs((rows["probe_end_y"] - rows["probe_end_y"][0]) / fallen - 1) > 0.01)[-1] + 1
        check.need(late < len(rows["time"]), f"{name}: the beam is not at rest after 150 s")
        others[name] = timed("pays", slender, *words, "-damping_kinetic", "-time_end", rows["time"][late], "-history_every", 1e9)[0]
    row(seconds < min(others.values()) / 3, "slender cantilever, seconds", f"statics {seconds:.2f} s, " + ", ".join(f"{k} {v:.2f} s" for k, v in others.items()), "", f"a third; {seconds / min(others.values()):.3f}")
    beam = [*plain("reissner", *often), "-probes end", "-probe_end_follow 10,0"]
    want, others = np.array([-5.480, -8.175]), {}
    off = lambda rows: np.hypot(*(rows[f"probe_end_{axis}"] - rows[f"probe_end_{axis}"][0] - u for axis, u in zip("xy", want))) / np.hypot(*want)
    seconds, rows = timed("pays", beam, "-method_time", "static", "-time_end", 1, "-dt_size", 0.05, "-history_every", 1)
    error = off(rows)[-1]
    words = [*explicit["solid"], "-damping_kinetic", "-load_end_value", "0,-1e5"]
    _, rows = timed("pays", beam, *words, "-time_end", 10, "-history_every", 0.02)
    late = np.flatnonzero(off(rows) > 0.02)[-1] + 1
    check.need(late < len(rows["time"]), "the beam is not at rest after 10 s")
    took = timed("pays", beam, *words, "-time_end", rows["time"][late], "-history_every", 1e9)[0]
    row(error < 0.02, "short cantilever bent far, seconds", f"statics {seconds:.2f} s ({100 * error:.1f} %), solid {took:.2f} s", "", f"2 %; {seconds / took:.2f}")
    foot = [*plain("footing_static", *often, "load_footing_value", "value"), "-probes under", "-probe_under_follow 0,3"]
    value = lambda share: f"0.95*(2+pi)*1000*{share}*(X<1)"
    sink = lambda rows: rows["probe_under_y"][0] - rows["probe_under_y"][-1]
    load = ("-load_footing_value",)
    exact = sink(timed("pays", foot, *load, value("t"), "-method_time", "static", "-time_end", 1, "-dt_size", 1 / 80, "-history_every", 1)[1])
    seconds, rows = timed("pays", foot, *load, value("t"), "-method_time", "static", "-time_end", 1, "-dt_size", 0.2, "-history_every", 1)
    error, others = abs(sink(rows) / exact - 1), {}
    for name, words in explicit.items():
        for time in (4, 16, 64):
            took, rows = timed("pays", foot, *words, *load, value(f"min(1,t/{time})"), "-damping_kinetic", "-time_end", time + 1, "-history_every", 1)
            others[name, time] = took, abs(sink(rows) / exact - 1)
            if others[name, time][1] <= error:
                break
    reached = [took for took, off in others.values() if off <= error]
    least = min(reached) if reached else min(took for (_, time), (took, _) in others.items() if time == 64)
    row(error < 0.015 and seconds < least / 3, "strip footing, seconds at an equal error", f"statics {seconds:.2f} s ({100 * error:.2f} %), " + ", ".join(f"{k} over {t} s {v:.2f} s ({100 * e:.1f} %)" for (k, t), (v, e) in others.items()), "", f"a third; {seconds / least:.2f}")


[part] = check.arguments(__doc__, 1)
if part not in PARTS:
    sys.exit(__doc__)
globals()[part]()
check.end()
