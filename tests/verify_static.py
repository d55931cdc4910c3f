"""Statics (-method_time static) beside exact solutions and limits: what was measured, what is exact, what is allowed.

usage: verify_static.py PEBBLE SOURCE MPIEXEC PART

PART: column reissner cylinder footing round motion layer manufactured hertz multigrid
"""
import math
import re

import h5py
import numpy as np

import check


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


def column():
    """As high at first as rho g l/E = 1, nu = 0, in 20 steps: the nominal stress, here also that of Cauchy, is rho g times what
    is above; neo-Hookean, stretch sqrt(1 + q^2) - q at q = rho g (l - X)/E."""
    def exact(X):
        integral = lambda z: (z * math.sqrt(1 + z * z) + math.asinh(z) - z * z) / 2
        return integral(1) - integral(1 - X)

    y, stress = [], []
    for n in (16, 32, 64):
        X, states, _ = run(f"column{n}", body("box", 1, "neohookean", material_m_E=1e6, material_m_nu=0, body_b_lower=0, body_b_upper=1, grid_lower=0, grid_upper=1,
                                             grid_cells=n, gravity=-1000, bc_xmin_type="fixed", dt_size=0.05))
        at, found = X[:, 0], states[-1][2].reshape(len(X), -1)[:, 0]
        y.append(math.sqrt(np.mean((at + states[-1][1][:, 0] - [exact(value) for value in at]) ** 2)))
        stress.append(math.sqrt(np.mean((found / 1e6 + 1 - at) ** 2)))
    for what, errors, least, most in (("places, rms over height", y, 1.9, 4.5e-6), ("stress, rms over that of the foot", stress, 1.3, 4e-4)):
        order = math.log2(errors[-2] / errors[-1])
        row(order > least and errors[-1] < most, f"column under its weight, {what}, 16, 32, 64", " ".join(f"{e:.2e}" for e in errors) + f" order {order:.2f}", "0",
            f"{most:g}, order {least}")


def reissner():
    """The cantilever of AMPLE (Coombs and Augarde 2020) beside Reissner's beam, which stretches and shears; over its length."""
    exact = {0.2: (0.1533, 0.4852), 0.4: (0.3196, 0.6666), 0.6: (0.4258, 0.7454), 0.8: (0.4970, 0.7891), 1.0: (0.5480, 0.8175)}
    for h in ("0.5", "0.25"):
        X, states, _ = run("reissner" + h.replace(".", ""), [line for line in check.content(check.scene("reissner")).decode().splitlines()
                                                              if not re.match(r"-(grid_h|method_time|time_end|output_every) ", line)], "-grid_h", f"{h},{h}", "-output_every", "0.2")
        end = X[:, 0] > X[:, 0].max() - 1e-9
        for share, want in exact.items():
            _, u, _ = min(states, key=lambda state: abs(state[0] - share))
            found = -u[end].mean(0)[:2] / 10
            row(max(abs(found / want - 1)) < 0.02, f"cantilever, {100 * share:.0f} kN, h = {h}", f"{found[0]:.4f} {found[1]:.4f}", f"{want[0]:.4f} {want[1]:.4f}", "2 %")


def cylinder():
    """A quarter of a thick cylinder, radii 1 and 2, under pressure from inside of 1e-5 E, beside Lame: the rms of the radial
    displacement's error over that of the displacement. The surface is a staircase."""
    errors = []
    for n in (8, 16, 32):
        X, states, _ = run(f"cylinder{n}", body("expression", 2, "neohookean", material_m_E=1000, material_m_nu=0.3, body_b_expression='"min(4-x^2-y^2,x^2+y^2-1)"',
                                               body_b_lower="0,0", body_b_upper="2,2", grid_lower="0,0", grid_upper="2.5,2.5", grid_h=f"{1 / n},{1 / n}", bc_xmin_type="slip",
                                               bc_ymin_type="slip", loads="p", load_p_body="b", load_p_type="pressure", load_p_value='"0.01*t*(X^2+Y^2<2.25)"', dt_size=0.5))
        r, u = np.hypot(X[:, 0], X[:, 1]), states[-1][1]
        want = 1.3 * 0.01 / 1000 / 3 * (0.4 * r + 4 / r)
        got = (u[:, 0] * X[:, 0] + u[:, 1] * X[:, 1]) / r
        errors.append(math.sqrt(np.mean((got - want) ** 2) / np.mean(want**2)))
    row(errors[0] > errors[1] > errors[2] and errors[2] < 0.006, "thick cylinder, 8, 16, 32 cells in its wall", " ".join(f"{100 * e:.2f} %" for e in errors), "0 (Lame)", "0.6 %, falling")


def footing():
    """The largest load of a strip footing for which an equilibrium is found, over 2 + pi times the strength of the clay."""
    found = []
    for h in ("0.25", "0.125"):
        X, states, told = run("footing" + h.replace(".", ""), [line for line in check.content(check.scene("footing_static")).decode().splitlines()
                                                                if not re.match(r"-(grid_h|grid_upper|method_time|time_end) ", line)],
                              "-grid_h", f"{h},{h}", "-grid_upper", "6,3.5", "-dt_retry", "4", "-time_end", "1.4", status=3)
        found.append(float(re.search(r"stopped at step \d+, t=(\S+) s", told.said)[1]))
    row(abs(found[1] - 1) < 0.05 and abs(found[0] - 1) < 0.1, "strip footing, limit over 2 + pi, h = 1/4, 1/8", " ".join(f"{value:.3f}" for value in found), "1 (Prandtl)", "10 %, 5 %")


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
    """A layer that is held at its sides under a pressure of 1e-6 (lambda + 2 mu): it sinks by that share."""
    modulus = 1e6 * 0.7 / (1.3 * 0.4)
    X, states, told = run("layer", body("box", 2, "elastic", material_m_E=1e6, material_m_nu=0.3, body_b_lower="0,0", body_b_upper="1,1", grid_lower="0,0", grid_upper="1,1.5", grid_h="0.125,0.125",
                                        bc_xmin_type="slip", bc_xmax_type="slip", bc_ymin_type="fixed", loads="p", load_p_body="b", load_p_type="pressure", load_p_face="ymax",
                                        load_p_value=f'"{1e-6 * modulus}*t"', dt_size=1))
    error = np.abs(states[-1][1][:, 1] / X[:, 1] / -1e-6 - 1).max()
    row(error < 5e-3, "layer under pressure, largest error of a displacement", f"{100 * error:.2f} %", "0", "0.5 %")


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


[part] = check.arguments(__doc__, 1)
{"column": column, "reissner": reissner, "cylinder": cylinder, "footing": footing, "round": round, "motion": motion, "layer": layer, "manufactured": manufactured, "hertz": hertz, "multigrid": multigrid}[part]()
check.end()
