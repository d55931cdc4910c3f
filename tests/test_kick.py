"""Steps whose length changes cost no accuracy: velocities change over half of the step before and half of the present one.

usage: test_kick.py PEBBLE SOURCE MPIEXEC
"""
import math
import re

import numpy as np

import check

check.arguments(__doc__, 0)
G, WEIGHT = 2.0, 1000 * 0.25  # m/s^2; kg, of the body that falls


def error(cells, *more):
    """The rms error of the displacement in options/shear.opts over its rms."""
    told = check.must("-options_file", check.scene("shear"), "-grid_cells", f"{cells // 2},{cells}", "-output_format", "none", *more)
    return float(re.search(r"^reference .* relative error is (\S+)$", told.out, re.M)[1])


def check_order():
    """In options/shear.opts c rises and falls with the motion. The error falls as with a constant dt, whose length is the mean of
    the others. If velocities changed over dt, it would be 3.8e-3 and 1.6e-3."""
    coarse, fine = error(16), error(32)
    check.that(coarse < 1.5e-3 and coarse / fine > 4, f"shear, steps that change: error {coarse:.3g} with 16 cells, {fine:.3g} with 32")
    fixed = error(32, "-dt_size", 4.031 / 647)
    check.that(fine < 1.3 * fixed, f"shear with 32 cells: error {fine:.3g}, {fixed:.3g} with as many steps of equal length")
    cut = error(32, "-history_exact", "-history_every", 0.0317)
    check.that(cut < 1.3 * fixed, f"shear with 32 cells, steps cut for lines of the history: error {cut:.3g}")


def check_momentum():
    """A stiff spring that oscillates makes dt change; the body beside it falls, its momentum is M g times the sum of the kicks.
    A last step that differs by rounding alone is no change."""
    path = check.write("fall.opts", [
        "-dim 1", "-grid_lower 0", "-grid_upper 4", "-grid_cells 32", "-materials m", "-material_m_model neohookean", "-material_m_rho 1000",
        "-material_m_E 1e5", "-material_m_nu 0", "-bodies fall,spring", "-body_fall_shape box", "-body_fall_lower 3", "-body_fall_upper 3.25", "-body_fall_material m",
        "-body_spring_shape box", "-body_spring_lower 0.5", "-body_spring_upper 1.5", "-body_spring_material m",
        '-body_spring_velocity "4*(x-1)"', f"-gravity {-G!r}", "-bc_xmin_type free", "-bc_xmax_type free", "-time_end 0.3", "-history_every 0",
        "-history_bodies fall", "-history_body_quantities momentum"])
    check.must("-options_file", path, "-output_format", "none")
    rows = check.history("output/fall.csv")
    dt = rows["dt"][1:]
    kick = np.concatenate([dt[:1], 0.5 * (dt[:-1] + dt[1:])])
    p, law = rows["momentum_fall_x"], -WEIGHT * G * np.concatenate([[0], np.cumsum(kick)])
    check.that(np.abs(check.kicked(rows)[1:] - np.cumsum(kick)).max() < 1e-12, "the kicks are t + (dt_1 - dt)/2")
    check.that(dt.max() / dt.min() > 1.1, f"dt is between {dt.min():.4g} and {dt.max():.4g} s")
    check.that(np.abs(p - law).max() < 1e-12 * abs(law[-1]), f"momentum of a body that falls: {p[-1]:.15g} kg m/s, M g times the kicks {law[-1]:.15g}")
    check.must("-options_file", path, "-output_format", "none", "-dt_size", 0.003, "-output_name", "equal")
    p, t = (check.history("output/equal.csv")[name] for name in ("momentum_fall_x", "time"))
    check.that(abs(p[-1] / (-WEIGHT * G * t[-1]) - 1) < 1e-12, "with steps of equal length it is M g t")


check_order()
check_momentum()
check.end()
