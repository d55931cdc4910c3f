"""Vibrating bars against exact solutions: period and energy of options/bar.opts, orders of accuracy of a fixed bar.

usage: test_bar.py PEBBLE SOURCE MPIEXEC
"""
import h5py
import numpy as np

import check

PERIOD = 0.4  # s, of options/bar.opts: 4 L sqrt(rho/E)
PERIODS = 10
# A bar of unit length, density and stiffness, held at both ends, in its first mode: u = A sin(pi x) sin(pi t). Relative rms
# displacement error at t = 1/2, a quarter of the period, with 2 particles a cell, dt = 0.1 h and A = 1e-5, of an
# independent implementation (two digits).
AMPLITUDE, QUARTER, CFL = 1e-5, 0.5, 0.1
REFERENCE = {"usf": {16: 2.2e-2, 32: 1.0e-2, 64: 5.0e-3, 128: 2.5e-3}, "musl": {16: 2.1e-3, 32: 5.1e-4, 64: 1.3e-4, 128: 3.3e-5}}


def frequency(t, y, omega):
    """omega of the cosine and sine that fit y best, by Gauss and Newton."""
    for _ in range(20):
        c, s = np.cos(omega * t), np.sin(omega * t)
        a, b = np.linalg.lstsq(np.stack([c, s], 1), y, rcond=None)[0]
        step = np.linalg.lstsq(np.stack([c, s, t * (b * c - a * s)], 1), y - a * c - b * s, rcond=None)[0][2]
        omega += step
    assert abs(step) < 1e-9 * omega
    return omega, a


def check_vibration():
    """Period from the momentum, energy from the means over the first and the last period."""
    exact = 2 * np.pi / PERIOD
    errors = {}
    for update in ("musl", "usf", "usl"):
        check.must("-options_file", check.scene("bar"), "-method_update", update, "-time_end", repr(PERIODS * PERIOD),
                   "-history_every", "0", "-output_every", "1e9", "-output_dir", ".", "-output_name", "bar_" + update)
        line = check.history(f"bar_{update}.csv")
        t, energy = line["time"], line["total_energy"]
        omega, amplitude = frequency(t, line["momentum_x"] / line["mass"], exact * 1.01)
        errors[update] = exact / omega - 1
        first, last = (np.average(energy[part], weights=line["dt"][part]) for part in (t <= PERIOD, t > t[-1] - PERIOD))
        drift, swing = last / first - 1, np.abs(energy / energy[0] - 1).max()
        check.that(abs(errors[update]) <= 0.005, f"{update}: period {2 * np.pi / omega:.7f} s, exact {PERIOD} s, error {errors[update]:+.2e} (allowed 5e-3)")
        check.that(abs(amplitude / (0.1 * 2 / np.pi) - 1) <= 0.01, f"{update}: amplitude of the mean velocity {amplitude:.6f} m/s, exact 0.0636620 (allowed 1 %)")
        check.that(abs(drift) <= (0.01 if update != "usl" else 0.02), f"{update}: energy drifts by {drift:+.2e} in {PERIODS} periods, swings within {swing:.2e} of its start (allowed drift {'1e-2' if update != 'usl' else '2e-2'})")
        check.that(swing <= 0.02, f"{update}: largest change of energy {swing:.2e} (allowed 2e-2)")
        check.that((line["mass"] == line["mass"][0]).all(), f"{update}: mass is constant")
    # usf and musl are the same steps seen at another moment, so their spectra are the same
    check.that(abs(errors["usf"] - errors["musl"]) <= 5e-4, f"usf and musl: periods differ by {errors['usf'] - errors['musl']:+.2e} (allowed 5e-4)")


def displacement_error(update, n, cfl):
    """Relative rms displacement error of the bar held at both ends at a quarter of its period."""
    name, h = f"mode_{update}_{n}_{cfl}", 1 / n
    steps = round(QUARTER / (cfl * h))
    scene = check.write(name + ".opts", f"""-dim 1
-grid_lower 0
-grid_upper 1
-grid_cells {n}
-bc_xmin_type fixed
-bc_xmax_type fixed
-materials unit
-material_unit_model elastic
-material_unit_rho 1
-material_unit_E 1
-material_unit_nu 0
-bodies bar
-body_bar_shape box
-body_bar_lower 0
-body_bar_upper 1
-body_bar_ppc 2
-body_bar_material unit
-body_bar_velocity "{AMPLITUDE!r}*pi*sin(pi*x)"
-method_basis linear
-method_update {update}
-method_transfer flip
-time_end 10
-time_max_steps {steps}
-dt_size {cfl * h!r}
-output_every 1e9
-history_every 1e9
""")
    check.must("-options_file", scene, "-output_dir", ".")
    with h5py.File(name + ".h5") as file:
        first, last = file["step_000000/particles"], file[f"step_{steps:06d}/particles"]
        t = file[f"step_{steps:06d}"].attrs["time"]
        assert (first["id"][:] == last["id"][:]).all() and abs(t - QUARTER) < 1e-12
        start, u = first["x"][:, 0], last["x"][:, 0] - first["x"][:, 0]
    exact = AMPLITUDE * np.sin(np.pi * start) * np.sin(np.pi * t)
    return np.sqrt(((u - exact) ** 2).mean() / (exact ** 2).mean())


def check_orders():
    for update, reference in REFERENCE.items():
        found = {n: displacement_error(update, n, CFL) for n in reference}
        cells = sorted(found)
        orders = [np.log2(found[n] / found[m]) for n, m in zip(cells, cells[1:])]
        print(f"{update}, n = {cells}: errors {' '.join(f'{found[n]:.4e}' for n in cells)}, orders {' '.join(f'{o:.3f}' for o in orders)}")
        for n in cells:
            unit = 10 ** np.floor(np.log10(reference[n]) - 1)  # of the last of two digits
            check.that(abs(found[n] - reference[n]) <= 0.51 * unit, f"{update}, n = {n}: error {found[n]:.4e}, reference {reference[n]:.1e}")
        if update == "musl":
            check.that(min(orders) >= 1.9, f"musl: orders {' '.join(f'{o:.3f}' for o in orders)} (at least 1.9, expected 2)")
        else:
            check.that(all(0.9 <= o <= 1.1 for o in orders[1:]), f"usf: orders {' '.join(f'{o:.3f}' for o in orders)} (expected 1)")
        # half the step at n = 32: the first-order error in time of usf halves, musl has only that of the grid
        steps = [0.4, 0.2, 0.1, 0.05]
        errors = [displacement_error(update, 32, cfl) for cfl in steps]
        orders = [np.log2(a / b) for a, b in zip(errors, errors[1:])]
        text = f"{update}, n = 32, c dt/h = {steps}: errors {' '.join(f'{e:.3e}' for e in errors)}"
        if update == "musl":
            check.that(max(errors) <= 1.5 * min(errors), text + " (within 1.5 of each other)")
        else:
            check.that(all(0.9 <= o <= 1.1 for o in orders), f"{text}, orders {' '.join(f'{o:.3f}' for o in orders)} (1 +- 0.1)")
            # usf adds the gradient of v(0) dt to F before x has moved: x stays behind by that, pi dt of the amplitude
            check.that(all(abs(e / (np.pi * cfl / 32) - 1) <= 0.15 for e, cfl in zip(errors, steps)), f"usf: errors over pi dt: {' '.join(f'{e / (np.pi * cfl / 32):.3f}' for e, cfl in zip(errors, steps))} (1 +- 0.15)")


check.arguments(__doc__, 0)
check_vibration()
check_orders()
check.end()
