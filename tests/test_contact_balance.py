"""The balance of energy closes where bodies touch (-history_energy): a rigid wedge in clay and in clay that does not yield, a
rigid plate that pushes a block, a block that slides down, two disks that collide with friction, and a box that floats. What
no term explains, `integration`, is at most 0.1 % of the largest energy and work, of the box 1 %, and falls with the step.

usage: test_contact_balance.py PEBBLE SOURCE MPIEXEC
"""
import numpy as np

import check

check.arguments(__doc__, 0)
QUIET = "-output_format none -report_indicator false -history_energy".split()
SOFT = ["-material_m_model neohookean", "-material_m_rho 1000", "-material_m_E 1e6", "-material_m_nu 0.3"]
METHODS = ("usl aflip", "usl flip", "musl flip", "usl afmpm")


def scene(size, h, bodies, *more):
    """A grid from 0 to `size`, and bodies {name: {option: value}}."""
    lines = ["-dim 2", "-grid_lower 0,0", f"-grid_upper {size[0]},{size[1]}", f"-grid_h {h},{h}", "-materials m", "-bodies " + ",".join(bodies), *more]
    return lines + [f"-body_{name}_{option} {value}" for name, options in bodies.items() for option, value in options.items()]


def balance(name, path, *more):
    """Runs a scene; returns what no term explains, what the mapping gives and what friction takes, in parts of the largest
    energy and work."""
    check.must("-options_file", path, *QUIET, "-output_name", name, *more)
    found = check.history(f"output/{name}.csv")
    given = sum(np.abs(found[key]).max() for key in ("energy_rigid", "energy_gravity") if key in found)
    most = found["total_energy"].max() + given
    return np.abs(found["energy_integration"]).max() / most, found["energy_transfer"][-1] / most, found["energy_friction"][-1] / most


def closes(what, path, *more, most=0.001, moves=1.0):
    left, mapped, friction = balance("balance", path, *more)
    check.that(left < most and abs(mapped) < moves and friction < 0, f"{what}: {left:.5f} of the energy is not explained; the mapping gives {mapped:+.4f}, friction {friction:+.4f}")
    return left


def method(words):
    update, transfer = words.split()
    return ["-method_update", update, "-method_transfer", transfer]


wedge = ["-grid_cells", "24,18", "-history_every", 0.004]
for cfl in (0.4, 0.1):
    closes(f"a wedge cuts clay, C = {cfl}", check.scene("wedge"), *wedge, "-dt_cfl", cfl)
    closes(f"a wedge presses clay that does not yield, C = {cfl}", check.scene("wedge"), *wedge, "-material_clay_yield", 1e9, "-time_end", 0.1, "-dt_cfl", cfl)

plate = scene([2, 1.2], 0.1, {"b": {"shape": "box", "lower": "0.5,0", "upper": "1.5,0.55", "material": "m"},
                              "plate": {"shape": "box", "lower": "0.3,0.55", "upper": "1.7,0.9", "rigid": "moving", "velocity": "0,-0.2", "mu": "0.3"}},
              *SOFT, "-bc_ymin_type fixed", "-time_end 0.3", "-history_every 0.003")
for words in METHODS:
    closes(f"a plate pushes a block, {words}", check.write("plate.opts", plate), *method(words))

slope = scene([3, 2], 0.125, {"b": {"shape": "box", "lower": "0.5,0.53", "upper": "1.5,1.03", "material": "m"},
                              "floor": {"shape": "halfspace", "point": "0,0.53", "normal": "0,1", "rigid": "fixed", "mu": "0.3"}},
              *SOFT, "-gravity 5,-8.66", "-time_end 0.4", "-history_every 0.004")
for words in METHODS:
    closes(f"a block slides down, {words}", check.write("slope.opts", slope), *method(words))

# What is left falls with the step.
disks = scene([1, 1], 0.05, {name: {"shape": "sphere", "center": center, "radius": "0.2", "velocity": velocity, "material": "m"}
                             for name, center, velocity in (("a", "0.29,0.45", "3,0"), ("b", "0.71,0.55", "-3,0"))},
              *SOFT, "-contact_mu 0.3", "-time_end 0.05", "-history_every 0.0005")
pool = scene([2, 1.5], 0.1, {"pool": {"shape": "box", "lower": "0,0", "upper": "2,0.8", "material": "m", "cut": "b"},
                             "b": {"shape": "box", "lower": "0.8,0.4", "upper": "1.2,0.8", "rigid": "free", "rho": "500", "mu": "0"}},
             "-material_m_model fluid", "-material_m_rho 1000", "-material_m_K 1e6", "-material_m_relaxation 1", *(f"-bc_{face}_type slip" for face in ("xmin", "xmax", "ymin")),
             "-gravity 0,-10", "-time_end 0.5", "-history_every 0.005")
for what, lines, methods, most in (("disks collide", disks, METHODS, 0.001), ("a box floats", pool, METHODS[:3], 0.01)):
    for words in methods:
        left = [closes(f"{what}, {words}, C = {C}", check.write("meets.opts", lines), *method(words), "-dt_cfl", C, most=most) for C in (0.8, 0.4)]
        check.that(left[1] < 0.6 * left[0], f"{what}, {words}: with half the step {left[1] / left[0]:.2f} of that is left")
# The same terms on any number of processes, by the pool, and after a restart.
path, words = check.write("meets.opts", pool), [*QUIET, "-time_end", 0.1, "-output_name", "same"]
check.must("-options_file", path, *words)
rows = check.content("output/same.csv")
for n, strategy in ((3, "spatial"), (3, "pool")):
    check.must("-options_file", path, *words, "-parallel_strategy", strategy, n=n)
    check.that(check.content("output/same.csv") == rows, f"a box floats: the same terms by {strategy} on {n} processes")
check.must("-options_file", path, *words, "-time_max_steps", 20, "-checkpoint_every", 1e30)
check.must("-options_file", path, *words, "-restart_file", "latest")
check.that(check.content("output/same.csv").splitlines()[-1] == rows.splitlines()[-1], "a box floats: the same terms after a restart")
check.end()
