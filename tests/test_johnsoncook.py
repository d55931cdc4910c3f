"""johnsoncook: one driven particle against an integration of its equations of its own, with much smaller steps; the shock of
a plate against us = c0 + s up; melting, the largest tension and the balance of energy.

usage: test_johnsoncook.py PEBBLE SOURCE MPIEXEC
"""
import math

import numpy as np

import check
import setups

check.arguments(__doc__, 0)
# Copper: Johnson and Cook (1983) for its strength.
RHO, G, C0, S, GAMMA = 8960.0, 4.63e10, 3940.0, 1.489, 1.99
A, B, N, C, M, MELTS, T0, HEAT, SHARE = 9e7, 2.92e8, 0.31, 0.025, 1.09, 1356.0, 298.0, 383.0, 0.9
COPPER = {"model": "johnsoncook", "rho": RHO, "G": G, "c0": C0, "hugoniot_slope": S, "gruneisen": GAMMA, "yield": A, "hardening": B, "hardening_power": N,
          "rate_factor": C, "softening_power": M, "melting": MELTS, "temperature": T0, "specific_heat": HEAT}
KAPPA = RHO * C0 ** 2
STEPS = 400


def run(name, lines, material, *words):
    text = "\n".join([*lines, "-materials m", *(f"-material_m_{key} {value}" for key, value in material.items()), "-bodies b", "-body_b_material m"])
    status, said = setups.simulate(name, text + "\n", *words)
    check.that(status == 0, f"{name}: exit status {status} {said[-300:] if status else ''}")
    return said


def element(name, dim, rates, steps, dt, material):
    """Stress, plastic strain and temperature of a particle in one cell whose nodes are all driven: v_x = rates[0] x and, in 2-D
    and 3-D, v_y = rates[1] y."""
    vector = lambda *values: setups.numbers((list(values) + [0.0] * 3)[:dim])
    faces = {f"{axis}{end}": "slip" for axis in "xyz"[:dim] for end in ("min", "max")}
    faces.update({"xmin": "moving", "xmax": "moving"})
    if dim > 1:
        faces["ymax"] = "free"
    run(name, [f"-dim {dim}", f"-grid_lower {vector()}", f"-grid_upper {vector(1, 1, 1)}", f"-grid_cells {','.join(['1'] * dim)}",
               *(f"-bc_{face}_type {kind}" for face, kind in faces.items()), f"-bc_xmin_velocity {vector(0, rates[1])}", f"-bc_xmax_velocity {vector(*rates)}",
               "-method_basis linear", "-method_update usf", "-method_transfer flip", "-body_b_shape box", f"-body_b_lower {vector()}",
               f"-body_b_upper {vector(1, 1, 1)}", f"-body_b_ppc {','.join(['1'] * dim)}", f"-dt_size {dt!r}", "-time_end 1e6", f"-time_max_steps {steps}",
               "-output_every 1e9", "-history_every 1e9"], material)
    found = check.particles(name + ".h5")
    return found["stress"][0].reshape(3, 3), found["plastic_strain"][0], found["temperature"][0]


def strength(ep, rate, T, C=C):
    hot = min(1.0, max(0.0, (T - T0) / (MELTS - T0)))
    return (A + B * ep ** N) * (1 + C * math.log(max(1.0, rate))) * (1 - hot ** M)


def flow(trial, ep, dt, T):
    """The root of trial - 3 G x = Y(ep + x, x/dt, T) by halving its interval."""
    lo, hi = 0.0, trial / (3 * G)
    for _ in range(100):
        x = 0.5 * (lo + hi)
        lo, hi = (x, hi) if trial - 3 * G * x > strength(ep + x, x / dt, T) else (lo, x)
    return x


def path(rates, time, n):
    """Cauchy stress, plastic strain and temperature of the path F = diag(exp(integral of rates)), in n steps: axes stay, so the
    elastic logarithmic strains are integrated straight; pressure by dE = (-p + heat) along the way (no isentrope)."""
    e, ep, T, J, E = np.zeros(3), 0.0, T0, 1.0, 0.0
    dt = time / n
    hugoniot = lambda J: KAPPA * (1 - J) / (1 - S * (1 - J)) ** 2 * (1 - GAMMA * (1 - J) / 2)
    for _ in range(n):
        e = e + np.array([rates[0], rates[1], 0.0]) * dt
        new = J * math.exp((rates[0] + rates[1]) * dt)
        T *= math.exp(GAMMA * (J - new))  # dT/T = -GAMMA dJ where nothing flows
        dev = e - e.mean()
        trial = 2 * G * math.sqrt(1.5 * dev @ dev)
        warm = 0.0
        if trial > strength(ep, 0.0, T):
            x = flow(trial, ep, dt, T)
            e = e.mean() + dev * (1 - 3 * G * x / trial)
            ep, warm = ep + x, SHARE * (trial - 3 * G * x) * x
        T += warm / (RHO * HEAT)
        # trapezoids: E' = E + warm - (p + p') (J' - J)/2 with p' = hugoniot + GAMMA E'
        p = hugoniot(J) + GAMMA * E
        E = (E + warm - 0.5 * (p + hugoniot(new)) * (new - J)) / (1 + 0.5 * GAMMA * (new - J))
        J = new
    p = hugoniot(J) + GAMMA * E
    return np.diag(2 * G * (e - e.mean()) / J) - p * np.eye(3), ep, T


def check_paths():
    """Uniaxial compression to 0.8 of the length, and plane strain without change of volume, at 1e4/s and at 1/s."""
    for rate in (1e4, 1.0):
        dt = 0.2 / rate / STEPS
        for what, dims, along in (("uniaxial", (1, 2, 3), (-1.0, 0.0)), ("isochoric", (2, 3), (1.0, -1.0))):
            logs = [math.log(1 + a * rate * dt) / dt for a in along]
            stress, ep, T = path(logs, 0.2 / rate, 8 * STEPS)
            for dim in dims:
                got, strain, warm = element("path", dim, [a * rate for a in along], STEPS, dt, COPPER)
                name = f"{what}, {dim}-D, {rate:g}/s"
                shear, exact = got[0, 0] - got[1, 1], stress[0, 0] - stress[1, 1]
                check.that(abs(shear / exact - 1) < 2e-3, f"{name}: s_xx - s_yy {shear / 1e6:.3f} MPa, integrated {exact / 1e6:.3f} MPa")
                p, exact = -np.trace(got) / 3, -np.trace(stress) / 3
                check.that(abs(p - exact) < 2e-4 * KAPPA * 0.2, f"{name}: pressure {p / 1e9:.4f} GPa, integrated {exact / 1e9:.4f} GPa")
                check.that(abs(strain / ep - 1) < 1e-3, f"{name}: plastic strain {strain:.5f}, integrated {ep:.5f}")
                check.that(abs(warm - T) < 5e-3 * (T - T0), f"{name}: temperature {warm:.3f} K, integrated {T:.3f} K")
            if what == "isochoric":  # flow by Johnson and Cook's formula at the rate of all strain, 2/sqrt(3) of the rate
                q = math.sqrt(1.5) * np.linalg.norm(got - np.trace(got) / 3 * np.eye(3))
                formula = strength(strain, 2 / math.sqrt(3) * rate, warm)
                check.that(abs(q / formula - 1) < 1e-3, f"{name}: yield stress {q / 1e6:.3f} MPa, by the formula {formula / 1e6:.3f} MPa")


def check_ends():
    """Where it melts it has no strength; tension has a largest value."""
    got, _, T = element("melts", 2, (-1e4, 0.0), 200, 1e-7, dict(COPPER, melting=320))
    q = np.linalg.norm(got - np.trace(got) / 3 * np.eye(3))
    check.that(T > 330 and q < 1e-9 * A, f"melting at 320 K: {T:.1f} K, deviator {q:.3g} Pa")
    got, _, _ = element("spalls", 3, (1e4, 0.0), 100, 1e-7, dict(COPPER, tension_cutoff=2e9))
    check.that(abs(np.trace(got) / 3 / 2e9 - 1) < 1e-12, f"tension_cutoff 2 GPa: mean stress {np.trace(got) / 3e9:.12f} GPa")
    got, _, _ = element("pulled", 3, (1e4, 0.0), 100, 1e-7, COPPER)
    check.that(np.trace(got) / 3 > 8e9, f"without it: {np.trace(got) / 3e9:.3f} GPa")


def isentropic_shock(up):
    """The speed of a shock, if the matter behind it is on the isentrope: p eta = rho up^2 with eta = up/us."""
    def p(eta, n=400):
        h, E, r = eta / n, 0.0, lambda y: KAPPA * y / (1 - S * y) ** 2 * (1 - GAMMA * y / 2)
        for k in range(n):  # the rule of the midpoint
            E += h * (r((k + 0.5) * h) + GAMMA * (E + h / 2 * (r(k * h) + GAMMA * E)))
        return r(eta) + GAMMA * E
    lo, hi = 1e-3, 0.4
    for _ in range(30):
        lo, hi = (lo, 0.5 * (lo + hi)) if p(0.5 * (lo + hi)) * 0.5 * (lo + hi) > RHO * up ** 2 else (0.5 * (lo + hi), hi)
    return up / lo


def check_shock():
    """A plate of copper without strength runs into a wall: behind the shock it is at rest, so up is its speed. The transfer
    dissipates what the shock does, and heats nothing: the matter is on the isentrope, a little below the Hugoniot."""
    n, L, soft = 200, 0.02, dict(COPPER, **{"yield": 1.0, "hardening": 0.0, "rate_factor": 0.0})
    for up in (300.0, 1000.0):
        us = C0 + S * up
        time = 0.6 * L / us
        run("shock", ["-dim 1", "-grid_lower 0", "-grid_upper 0.022", "-grid_cells 220", "-bc_xmin_type slip", "-method_basis bspline2", "-method_update usl",
                      "-method_transfer apic", "-body_b_shape box", "-body_b_lower 0", f"-body_b_upper {L}", "-body_b_ppc 2", f"-body_b_velocity {-up}",
                      "-dt_size auto", "-dt_cfl 0.3", f"-time_end {time!r}", f"-output_every {time!r}", f"-history_every {time / 60!r}", "-history_energy"], soft)
        history, end = check.history("shock.csv"), check.particles("shock.h5")
        late = history["time"] > 0.3 * time
        speed = np.polyfit(history["time"][late], history["momentum_x"][late] / (RHO * up), 1)[0]  # what is stopped, in reference lengths
        behind = np.sort(end["x"][:, 0])[[n // 4, n]]
        p = -np.mean(end["stress"].reshape(-1, 9)[(end["x"][:, 0] > behind[0]) & (end["x"][:, 0] < behind[1] * 0.7), 0])
        check.that(abs(speed / us - 1) < 0.02, f"shock at {up:g} m/s: speed {speed:.1f} m/s, c0 + s up {us:.1f} m/s (allowed 2 %)")
        cold = isentropic_shock(up)
        check.that(abs(speed / cold - 1) < 0.002 and abs(p / (RHO * cold * up) - 1) < 0.002, f"shock at {up:g} m/s: on the isentrope {cold:.1f} m/s and {RHO * cold * up / 1e9:.3f} GPa (allowed 0.2 %)")
        check.that(abs(p / (RHO * us * up) - 1) < 0.02, f"shock at {up:g} m/s: pressure {p / 1e9:.3f} GPa, rho us up {RHO * us * up / 1e9:.3f} GPa (allowed 2 %)")
        terms = {key: history["energy_" + key] for key in ("gravity", "walls", "friction", "transfer", "laws", "lag", "integration")}
        change = history["total_energy"] - history["total_energy"][0]
        off = np.abs(sum(terms.values()) - change).max() / history["total_energy"][0]
        check.that(off < 1e-12, f"shock at {up:g} m/s: the terms of the energy add up to {off:.1e}; transfer {terms['transfer'][-1] / history['total_energy'][0]:.4f}, laws {terms['laws'][-1] / history['total_energy'][0]:.1e}")


def check_dissipation():
    """The dissipation is the plastic work, whatever part of it becomes heat."""
    work = []
    for share in (0, 0.9, 1):
        told = check.pebble("-options_file", check.scene("taylor3d"), "-time_max_steps", 30, "-material_copper_heating_share", share, "-history_bodies", "all",
                            "-history_body_quantities", "dissipation", "-output_format", "none", "-output_dir", ".", "-output_name", "share")
        check.that(told.good, f"dissipation with a share of {share}: {told.err.strip()[-200:]}")
        work.append(check.history("share.csv")["dissipation_bar"][-1])
    check.that(work[0] > 0.1 and np.ptp(work) < 0.01 * work[0], f"plastic work where 0, 0.9 and all of it become heat: {work[0]:.5g} {work[1]:.5g} {work[2]:.5g} J")


check_paths()
check_ends()
check_shock()
check_dissipation()
check.end()
