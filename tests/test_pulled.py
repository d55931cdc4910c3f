"""Bodies under tension, with the default settings: bars that a load or a force on their last cell pulls, a disk that is pulled
all around, and what light nodes have to do with it.

usage: test_pulled.py PEBBLE SOURCE MPIEXEC [WORDS]

WORDS: some, or all offsets, grids and presets.
"""
import math

import numpy as np

import check

E, H = 1e5, 16
words = check.arguments(__doc__, 1)
OFFSETS = (0, 0.2, 0.4, 0.6, 0.8)  # of the lattice, in its spacings


def root(f, low, high):
    """Where f, which grows, is 0."""
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if f(middle) < 0 else (low, middle)
    return 0.5 * (low + high)


def stretch(T, nu, sides):
    """The stretch of the law under a nominal stress T E along one axis, with that many free sides."""
    mu, lam = E / 2 / (1 + nu), E * nu / (1 + nu) / (1 - 2 * nu)
    side = lambda s: root(lambda r: mu * (r * r - 1) + lam * math.log(s * r**sides), 0.2, 2) if sides else 1
    return root(lambda s: (mu * (s * s - 1) + lam * math.log(s * side(s)**sides)) / s - T * E, 1, 5)


def bar(dim, h=H, offset=0, nu=0, width=0.25, end=7):
    low, high = 0.25 - width / 2, 0.25 + width / 2
    box = lambda x, y: ",".join([str(x)] + [str(y)] * (dim - 1))
    return [f"-dim {dim}", f"-grid_lower {box(0, 0)}", f"-grid_upper {box(2, 0.5)}", f"-grid_h {box(1 / h, 1 / h)}", f"-bc_xmin_type {'slip' if nu else 'fixed'}",
            "-materials m", "-material_m_model neohookean", "-material_m_rho 1000", f"-material_m_E {E}", f"-material_m_nu {nu}", "-bodies b", "-body_b_shape box",
            f"-body_b_lower {box(0, low)}", f"-body_b_upper {box(1, high)}", f"-body_b_offset {box(offset * 0.5 / h, offset * 0.5 / h)}", "-body_b_material m",
            "-damping_time 0.2", f"-time_end {end}", "-history_every 0.1", "-history_bodies b", "-history_body_quantities lower,upper", "-output_format none"]


def load(dim, T):
    value = ",".join([f"{T * E}*min(t/4,1)"] + ["0"] * (dim - 1))
    return ["-loads p", "-load_p_body b", "-load_p_face xmax", "-load_p_type traction", f'-load_p_value "{value}"']


def force(dim, T, h=H, width=0.25):
    value = ",".join([f"{T * E * width**(dim - 1)}*min(t/4,1)"] + ["0"] * (dim - 1))
    return ["-loads p", "-load_p_body b", "-load_p_type force", f'-load_p_where "X-{1 - 1 / h}"', f'-load_p_value "{value}"']


def pull(name, lines, right, limit, *options):
    """Runs a bar; checks that it is at rest, and its stretch."""
    told = check.pebble("-options_file", check.write("bar.opts", lines), "-output_dir", ".", *options)
    if not told.good:
        return check.that(False, f"{name}: {told.err.strip()[-200:]}")
    h = check.history("bar.csv")
    length = np.array(h["upper_b_x"]) - np.array(h["lower_b_x"])
    s, moves = length[-1] / length[0], h["kinetic_energy"][-1] / h["strain_energy"][-1]
    check.that(abs(s / right - 1) < limit and moves < 1e-6, f"{name}: stretch {s:.4f}, right {right:.4f}; kinetic energy {moves:.0e} of the strain energy")


def check_bars():
    for T in (0.15, 0.3):
        for offset in OFFSETS:
            pull(f"load {T} E, 1-D, offset {offset}", bar(1, offset=offset) + load(1, T), stretch(T, 0, 0), 0.005)
            pull(f"force {T} E, 1-D, offset {offset}", bar(1, offset=offset) + force(1, T), stretch(T, 0, 0), 0.01)
    for name in ("-method_basis bspline2", "-method_basis gimp", "-method_preset accurate", "-method_preset fast"):
        pull(f"load 0.3 E, 1-D, {name}", bar(1, offset=0.6) + load(1, 0.3), stretch(0.3, 0, 0), 0.01, *name.split())
        T = 0.25 if "fast" in name else 0.3  # there the last particles are 0.6 cells apart at the start
        pull(f"force {T} E, 1-D, {name}", bar(1, offset=0.6) + force(1, T), stretch(T, 0, 0), 0.01, *name.split())
    pull("load 0.5 E, 1-D", bar(1) + load(1, 0.5), stretch(0.5, 0, 0), 0.005)
    pull("load 0.3 E, 2-D, nu 0.3", bar(2, offset=0.2, nu=0.3) + load(2, 0.3), stretch(0.3, 0.3, 1), 0.005)
    pull("load 0.3 E, 2-D, nu 0.3, first particles far from the wall", bar(2, offset=0.4, nu=0.3) + load(2, 0.3), stretch(0.3, 0.3, 1), 0.005)
    pull("load 0.3 E, 2-D, two particles thin", bar(2, nu=0.3, width=1 / H) + load(2, 0.3), stretch(0.3, 0.3, 1), 0.005)
    pull("force 0.3 E, 2-D", bar(2, offset=0.6, width=0.125) + force(2, 0.3, width=0.125), stretch(0.3, 0, 0), 0.01)


def check_disk(T=0.3, offset=0.4):
    """A disk that is pulled all around is stretched alike everywhere."""
    mu, lam, nu = E / 2.6, E * 0.3 / 1.3 / 0.4, 0.3
    right = root(lambda s: (mu * (s * s - 1) + 2 * lam * math.log(s)) / s - T * E, 1, 3)
    lines = ["-dim 2", "-grid_lower -1,-1", "-grid_upper 1,1", f"-grid_h {1 / H},{1 / H}", "-materials m", "-material_m_model neohookean", "-material_m_rho 1000", f"-material_m_E {E}", f"-material_m_nu {nu}",
             "-bodies b", "-body_b_shape sphere", "-body_b_center 0,0", "-body_b_radius 0.5", f"-body_b_offset {offset * 0.5 / H},{offset * 0.3 / H}", "-body_b_material m", "-loads p", "-load_p_body b", "-load_p_face all",
             "-load_p_type traction", f'-load_p_value "{T * E}*min(t/2,1)*X/0.5, {T * E}*min(t/2,1)*Y/0.5"', "-damping_time 0.1", "-time_end 4", "-output_every 4"]
    told = check.pebble("-options_file", check.write("disk.opts", lines), "-output_dir", ".")
    if not told.good:
        return check.that(False, f"disk: {told.err.strip()[-200:]}")
    X, x = check.particles("disk.h5", 0)["x"][:, :2], check.particles("disk.h5")["x"][:, :2]
    X, x = X - X.mean(0), x - x.mean(0)
    A = np.linalg.lstsq(X, x, rcond=None)[0]
    off = math.sqrt(((x - X @ A)**2).sum(1).mean()) / 0.5
    check.that(abs(np.trace(A) / 2 / right - 1) < 0.01 and off < 0.01, f"disk: stretch {np.trace(A) / 2:.4f}, right {right:.4f}; rms distance from it {off:.4f} of the radius")


def check_light():
    """Without light nodes the force on the last cell tears it off; with a method that is given in full there are none."""
    lines = bar(1) + force(1, 0.3)
    path = check.write("plain.opts", lines)
    told = check.pebble("-options_file", path, "-output_dir", ".", "-method_light_nodes", 0)
    check.that(not told.good, f"without light nodes the end comes off: {told.err.strip()[:80]}")
    method = "-method_basis bspline3 -method_update usl -method_transfer aflip -method_affine_strain 1".split()
    ends = {name: check.pebble("-options_file", path, "-output_dir", ".", "-time_max_steps", 300, *options).digest
            for name, options in (("none", ["-method_light_nodes", 0]), ("full", method), ("default", []), ("asked for", [*method, "-method_light_nodes", 0.1]))}
    check.that(ends["none"] == ends["full"] != ends["default"] == ends["asked for"], f"light nodes are those of the preset: {ends}")


def check_momentum():
    """A body that moves and turns keeps its momentum with every preset, light nodes or not."""
    lines = ["-dim 2", "-grid_lower 0,0", "-grid_upper 4,4", "-grid_h 0.125,0.125", "-materials m", "-material_m_model neohookean", "-material_m_rho 1000", f"-material_m_E {E}", "-material_m_nu 0.3", "-bodies b",
             "-body_b_shape sphere", "-body_b_center 1.5,1.5", "-body_b_radius 0.5", "-body_b_material m", '-body_b_velocity "2-2*(y-1.5), 1+2*(x-1.5)"', "-time_end 0.5", "-output_format none"]
    path = check.write("moves.opts", lines)
    for preset in ("balanced", "accurate", "fast", "energy"):
        check.must("-options_file", path, "-output_dir", ".", "-method_preset", preset, "-method_light_nodes", 0.1)
        h = check.history("moves.csv")
        off = max(abs(h[f"momentum_{d}"][-1] - h[f"momentum_{d}"][0]) for d in "xy") / h["momentum_x"][0]
        check.that(off < 1e-12, f"{preset} with light nodes changes the momentum by {off:.0e} of it")


def check_bits():
    for name, lines in (("2-D", bar(2, offset=0.3, nu=0.3, end=0.2) + load(2, 3)), ("3-D", bar(3, h=8, nu=0.3, end=0.1) + load(3, 3))):
        path = check.write("bits.opts", lines)
        found = {f"{n} {strategy}": check.pebble("-options_file", path, "-output_dir", ".", "-parallel_strategy", strategy, n=n).digest
                 for n, strategy in ((1, "spatial"), (3, "spatial"), (4, "spatial"), (3, "pool"))}
        check.that(len(set(found.values())) == 1 and None not in found.values(), f"the same bits, {name}: {found}")


def check_all():
    """Every offset, also of the sides, on finer grids and in 3-D."""
    for h in (32, 64):
        for offset in OFFSETS:
            for T in (0.15, 0.3):
                pull(f"load {T} E, 1-D, h 1/{h}, offset {offset}", bar(1, h=h, offset=offset) + load(1, T), stretch(T, 0, 0), 0.005)
                pull(f"force {T} E, 1-D, h 1/{h}, offset {offset}", bar(1, h=h, offset=offset) + force(1, T, h), stretch(T, 0, 0), 0.005)
    for offset in OFFSETS:
        for T in (0.15, 0.3):
            pull(f"load {T} E, 2-D, nu 0.3, offset {offset}", bar(2, h=32, offset=offset, nu=0.3) + load(2, T), stretch(T, 0.3, 1), 0.005)
            pull(f"load {T} E, 3-D, nu 0.3, offset {offset}", bar(3, offset=offset, nu=0.3, width=0.125) + load(3, T), stretch(T, 0.3, 2), 0.01)
            pull(f"load {T} E, 2-D, accurate, offset {offset}", bar(2, offset=offset, nu=0.3) + load(2, T), stretch(T, 0.3, 1), 0.005, "-method_preset", "accurate")
    for offset in OFFSETS:
        for T in (0.15, 0.3):
            check_disk(T, offset)


if words[0] == "some":
    check_bars()
    check_disk()
    check_light()
    check_momentum()
    check_bits()
else:
    check_all()
check.end()
