"""Every material in one cell with one particle whose nodes are all driven by walls: its stress against closed formulas.

usage: test_element.py PEBBLE SOURCE MPIEXEC

Extension and compression: one wall moves, the rest slip, v_x = rate x everywhere: F_11 = (1 + dt rate)^n, exactly. Shear:
the upper wall moves along itself, v_x = rate y: F_12 = n dt rate. The paths of extension and compression keep their axes,
so that each law has a closed solution at any strain, with any number of steps. In 1-D, 2-D (plane strain) and 3-D.
"""
import math
import re

import numpy as np

import check
import setups

check.arguments(__doc__, 0)
STEPS, DT, RHO = 40, 1e-3, 1000.0
E, NU, Y, H, K, MU_F, C = 1e5, 0.3, 1e3, 2e4, 1e5, 7.0, 500.0
LAM, MU = E * NU / (1 + NU) / (1 - 2 * NU), E / 2 / (1 + NU)
BULK = LAM + 2 * MU / 3
EYE = np.eye(3)


def simulate(name, dim, motion, rate, update, material, across=None, words=()):
    """The stress [3, 3] after STEPS steps. across: the rate in y of an extension. What the program says is added to the
    list `words`."""
    cells = [3] + [1] * (dim - 1)  # the particle is carried along x; the nodes of shear are all on the walls of y
    if motion != "shear":
        cells[0] = 1
    faces = {f"{axis}{end}": "slip" for axis in "xyz"[:dim] for end in ("min", "max")}
    moved = "ymax" if motion == "shear" else "xmax"
    faces.update({"xmin": "free", "xmax": "free", "ymin": "fixed"} if motion == "shear" else {"xmin": "slip"})
    faces[moved] = "moving"
    if across is not None:
        faces.update({"xmin": "moving", "ymax": "free"})  # with those of x, that of y > 0, all nodes are driven
    velocity = setups.numbers(([rate, across or 0.0] + [0.0] * dim)[:dim])
    lines = [f"-dim {dim}", f"-grid_lower {setups.numbers([0] * dim)}", f"-grid_upper {setups.numbers(cells)}",
             f"-grid_cells {','.join(map(str, cells))}", f"-gravity {setups.numbers([0] * dim)}", f"-bc_{moved}_velocity {velocity}",
             *(f"-bc_{face}_type {kind}" for face, kind in faces.items()), "-method_basis linear", f"-method_update {update}",
             "-method_transfer flip", "-materials m", f"-material_m_rho {RHO}",
             *(f"-material_m_{option} {value}" for option, value in material.items()), "-bodies b", "-body_b_shape box",
             f"-body_b_lower {setups.numbers([0] * dim)}", f"-body_b_upper {setups.numbers([1] * dim)}",
             f"-body_b_ppc {','.join(['1'] * dim)}", "-body_b_material m", f"-dt_size {DT!r}", "-time_end 1e6",
             f"-time_max_steps {STEPS}", "-output_every 1e9", "-history_every 1e9"]
    if across is not None:
        lines.append(f"-bc_xmin_velocity {setups.numbers(([0.0, across] + [0.0] * dim)[:dim])}")
    status, said = setups.simulate(name, "\n".join(lines) + "\n")
    if isinstance(words, list):
        words.append(said)
    if status:
        check.that(False, f"{name}: exit status {status}\n{said[-600:]}")
        return None
    state = setups.snapshot(name, STEPS, dim)
    xx, xy, xz, yy, yz, zz = state["stress"][0]
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def gradient(motion, rate):
    F = np.eye(3)
    if motion == "shear":
        F[0, 1] = STEPS * DT * rate
    else:
        F[0, 0] = (1 + DT * rate) ** STEPS
    return F


def uniaxial(mean, q, J):
    """Cauchy stress of a Kirchhoff stress with this mean and tau_11 - tau_22 = q."""
    return (mean * EYE + q * np.diag([2, -1, -1]) / 3) / J


# ---- The laws: Cauchy stress of F and of the rate of the last step.
def elastic(F, motion, rate):
    e = (F + F.T) / 2 - EYE
    return LAM * np.trace(e) * EYE + 2 * MU * e


def neohookean(F, motion, rate):
    J = np.linalg.det(F)
    return (LAM * math.log(J) * EYE + MU * (F @ F.T - EYE)) / J


def fluid(F, motion, rate, gamma=7.0, tension=None):
    J = np.linalg.det(F)
    p = K / gamma * (J ** -gamma - 1) if gamma else K * (1 - J)
    L = np.zeros((3, 3))
    L[0, 1 if motion == "shear" else 0] = rate
    D = (L + L.T) / 2
    return -(p if tension is None else max(p, -tension)) * EYE + 2 * MU_F * (D - np.trace(D) / 3 * EYE)


def hencky(F):
    """Kirchhoff stress without flow: 2 mu dev(ln V) + K tr(ln V)."""
    values, n = np.linalg.eigh(F @ F.T)
    e = n @ np.diag(np.log(values) / 2) @ n.T
    return LAM * np.trace(e) * EYE + 2 * MU * e


def vonmises(F, motion, rate):
    """Flow beyond q = Y + H ep, along a straight path: ep = (2 mu |e| - Y)/(3 mu + H)."""
    e = math.log(F[0, 0])
    ep = max(0.0, (2 * MU * abs(e) - Y) / (3 * MU + H))
    return uniaxial(BULK * e, math.copysign(2 * MU * abs(e) - 3 * MU * ep, e), F[0, 0])


def druckerprager(F, motion, rate, phi=20.0, psi=0.0, cohesion=0.0):
    """On the cone |dev tau| = alpha (T0 - tr tau), at its apex, or elastic; the path from zero is straight."""
    def slope(angle):
        s = math.sin(math.radians(angle))
        return math.sqrt(2 / 3) * 2 * s / (3 - s)

    e, alpha, beta = math.log(F[0, 0]), slope(phi), slope(psi)
    apex = 3 * cohesion / math.tan(math.radians(phi))
    norm, trace = 2 * MU * math.sqrt(2 / 3) * abs(e), 3 * BULK * e
    if e > 0 and trace >= apex:  # pulled apart
        return apex / 3 * EYE / F[0, 0]
    f = norm + alpha * (trace - apex)
    if f > 0:  # back along the flow: gamma of the deviator and beta of each axis
        gamma = f / (2 * MU + 9 * BULK * alpha * beta)
        norm, trace = norm - 2 * MU * gamma, trace - 9 * BULK * beta * gamma
        assert abs(norm + alpha * (trace - apex)) < 1e-9 * norm
    return uniaxial(trace / 3, math.copysign(math.sqrt(1.5) * norm, e), F[0, 0])


SOLID = {"E": E, "nu": NU}
SAND = {"model": "druckerprager", **SOLID}
METAL = {"model": "vonmises", **SOLID, "yield": Y, "hardening": H}
WATER = {"model": "fluid", "K": K, "viscosity": MU_F, "eos": "tait", "tait_gamma": 7.0, "tension_cutoff": "inf", "relaxation": 0}
LAWS = [  # what, material, law, its parameters
    ("elastic", {"model": "elastic", **SOLID}, elastic, {}),
    ("neohookean", {"model": "neohookean", **SOLID}, neohookean, {}),
    ("fluid", WATER, fluid, {}),
    ("fluid, linear", {"model": "fluid", "K": K, "viscosity": MU_F, "eos": "linear", "tension_cutoff": "inf", "relaxation": 0}, fluid, {"gamma": 0}),
    ("fluid without tension", dict(WATER, tension_cutoff=0.0), fluid, {"tension": 0.0}),
    ("vonmises", METAL, vonmises, {}),
    ("druckerprager 20", dict(SAND, friction_angle=20.0), druckerprager, {"phi": 20.0}),
    ("druckerprager 40", dict(SAND, friction_angle=40.0), druckerprager, {"phi": 40.0}),
    ("druckerprager 20, dilation 8", dict(SAND, friction_angle=20.0, dilation_angle=8.0), druckerprager, {"phi": 20.0, "psi": 8.0}),
    ("druckerprager 20, cohesion", dict(SAND, friction_angle=20.0, cohesion=C), druckerprager, {"cohesion": C}),
]


def compare(what, stress, exact, allowed=1e-12):
    scale = max(np.abs(exact).max(), 1e-3 * E)
    error = np.abs(stress - exact).max() / scale
    check.that(error <= allowed, f"{what}: stress off by {error:.1e} of {scale:.3g} Pa, allowed {allowed:.0e}")


def check_straight():
    for what, material, law, parameters in LAWS:
        for dim in (1, 2, 3):
            for motion, rate in (("extension", 5.0), ("compression", -5.0)):
                for update in ("usf", "usl", "musl") if dim == 2 else ("usf",):
                    stress = simulate("element", dim, motion, rate, update, material)
                    if stress is not None:
                        F = gradient(motion, rate)
                        compare(f"{what}, {dim}-D {motion} {update} to F = {F[0, 0]:.3f}", stress, law(F, motion, rate, **parameters))


def check_shear():
    for what, material, law, parameters in LAWS[:5]:
        for dim in (2, 3):
            for update in ("usf", "usl", "musl"):
                stress = simulate("element", dim, "shear", 8.0, update, material)
                if stress is not None:
                    compare(f"{what}, {dim}-D shear {update} to 0.32", stress, law(gradient("shear", 8.0), "shear", 8.0, **parameters))
    # Metal: elastic up to 0.008; then on the surface, q = Y + H ep, in which small strains give ep to their own order.
    for dim in (2, 3):
        stress = simulate("element", dim, "shear", 0.2, "usf", METAL)
        if stress is not None:
            compare(f"vonmises, {dim}-D shear to 0.008, elastic", stress, hencky(gradient("shear", 0.2)))
        stress = simulate("element", dim, "shear", 1.0, "usf", METAL)
        if stress is not None:
            ep = (math.sqrt(3) * MU * 0.04 - Y) / (3 * MU + H)
            q = math.sqrt(1.5) * np.linalg.norm(stress - np.trace(stress) / 3 * EYE)
            check.that(abs(q / (Y + H * ep) - 1) < 2e-3 and abs(stress[0, 1] * math.sqrt(3) / q - 1) < 2e-3,
                  f"vonmises, {dim}-D shear to 0.04: q {q:.4f}, small strains {Y + H * ep:.4f}, tau_xy sqrt(3)/q {stress[0, 1] * math.sqrt(3) / q:.5f}")
            check.that(abs(np.trace(stress)) < 1e-10 * q, f"vonmises, {dim}-D shear to 0.04: its flow makes no pressure, {np.trace(stress):.1e} Pa")
        # Sand: none without pressure; with cohesion up to |dev tau| = alpha T0, and no pressure without dilation.
        stress = simulate("element", dim, "shear", 1.0, "usf", dict(SAND, friction_angle=20.0))
        if stress is not None:
            check.that(np.abs(stress).max() < 1e-9 * E, f"druckerprager, {dim}-D shear without pressure: {np.abs(stress).max():.1e} Pa")
        stress = simulate("element", dim, "shear", 1.0, "usf", dict(SAND, friction_angle=20.0, cohesion=C))
        if stress is not None:
            s = math.sin(math.radians(20))
            most = math.sqrt(2 / 3) * 2 * s / (3 - s) * 3 * C / math.tan(math.radians(20))
            norm = np.linalg.norm(stress - np.trace(stress) / 3 * EYE)
            check.that(abs(norm / most - 1) < 1e-10 and abs(np.trace(stress)) < 1e-10 * most, f"druckerprager, cohesion, {dim}-D shear: |dev| {norm:.6f}, on the cone {most:.6f}")


def check_friction():
    """Sand with cohesion in plane-strain compression: (s1 - s3)/2 = sin(phi) (T0/3 - (s1 + s3)/2) with the angle phi that
    the program prints at the start; beside it the closed formula. -material_m_fit tells in which deformation it is the
    angle that was asked for. The strains of a step are not logarithmic, which leaves some 0.03 degrees."""
    for dim in (2, 3):
        for fit, psi in (("", 0.0), ("triaxial", 10.0), ("plane_strain", 0.0), ("plane_strain", 10.0)):
            s, t = math.sin(math.radians(30)), math.sin(math.radians(psi))
            flow = math.sqrt(2) * t / math.sqrt(9 + 3 * t * t) if fit == "plane_strain" else math.sqrt(2 / 3) * 2 * t / (3 - t)
            cone = 2 * s / 3 / (flow * s + math.sqrt(2 - 3 * flow * flow)) if fit == "plane_strain" else math.sqrt(2 / 3) * 2 * s / (3 - s)
            exact = math.degrees(math.asin(3 * cone * math.sqrt(2 - 3 * flow * flow) / (2 - 3 * cone * flow)))
            along = 3 * flow / math.sqrt(2 - 3 * flow * flow)  # sine of the dilation angle in plane strain: no pressure builds up
            material = dict(SAND, friction_angle=30.0, dilation_angle=psi, cohesion=C, **({"fit": fit} if fit else {}))
            words = []
            stress = simulate("friction", dim, "extension", 5.0 * (1 + along), "usf", material, -5.0 * (1 - along), words)
            if stress is None:
                continue
            printed = re.search(r"friction +m flows at ([0-9.]+) degrees in plane strain, at ([0-9.]+) in triaxial", words[0])
            stress *= ((1 + DT * 5 * (1 + along)) * (1 - DT * 5 * (1 - along))) ** STEPS  # tau = J sigma
            apex = C / math.tan(math.radians(30))
            acts = math.degrees(math.asin((stress[0, 0] - stress[1, 1]) / 2 / (apex - (stress[0, 0] + stress[1, 1]) / 2)))
            what = f"druckerprager 30, {dim}-D, fit {fit or 'not given'}, dilation {psi:g}"
            check.that(abs(acts - exact) < 0.05, f"{what}: acts like {acts:.6f} degrees in plane strain, by the formula {exact:.6f}")
            check.that(printed and abs(float(printed[1]) - exact) < 0.051, f"{what}: prints {printed and printed[0]}")
            check.that(printed and abs(float(printed[2 - (fit == 'plane_strain')]) - 30) < 1e-9, f"{what}: 30 degrees where it is fitted")
            warned = "-material_m_fit plane_strain" in words[0]
            check.that(warned == (dim == 2 and not fit), f"{what}: {'a' if warned else 'no'} warning")


check_straight()
check_shear()
check_friction()
check.end()
