"""Columns of the history that one asks for: walls, bodies, probes; output at exact times; plastic strain of druckerprager.

    test_measure.py PEBBLE SOURCE MPIEXEC
"""
import math

import h5py
import numpy as np

import check

QUIET = ["-report_limits", "false", "-report_indicator", "false"]

# A block that fills the grid and starts with a velocity that drives it against every wall.
BLOCK = """-dim 2 -gravity 3,-10 -grid_lower 0,0 -grid_upper 1,1 -grid_cells 6,6 -materials s -material_s_model neohookean
-material_s_rho 1000 -material_s_E 1e6 -material_s_nu 0.3 -bodies b -body_b_shape box -body_b_lower 0,0
-body_b_upper 1,1 -body_b_material s -time_end 0.03 -history_every 0.003 -history_walls all
-output_format none -method_basis bspline2 -history_energy""".split() + [
    "-body_b_velocity", "2*(x-0.4)-y,1.5*(y-0.5)+x"] + QUIET

# Two equal blocks thrown on the floor: a metal without hardening, and a soil whose cone is nearly a cylinder, with the same
# yield stress at any pressure.
YIELD, ANGLE = 2e4, 1e-3
COHESION = YIELD * math.sqrt(2 / 3) * math.tan(math.radians(ANGLE)) / (
    3 * math.sqrt(2 / 3) * 2 * math.sin(math.radians(ANGLE)) / (3 - math.sin(math.radians(ANGLE))))
THROWN = f"""-dim 2 -gravity 0,-10 -grid_lower 0,0 -grid_upper 3,1.5 -grid_cells 24,12
-materials steel,soil -material_steel_model vonmises -material_steel_rho 1000 -material_steel_E 1e6
-material_steel_nu 0.3 -material_steel_yield {YIELD} -material_soil_model druckerprager -material_soil_rho 1000
-material_soil_E 1e6 -material_soil_nu 0.3 -material_soil_friction_angle {ANGLE} -material_soil_cohesion {COHESION!r}
-bodies left,right -body_left_shape box -body_left_lower 0.5,0 -body_left_upper 1,1
-body_left_material steel -body_left_velocity 0,-2 -body_right_shape box -body_right_lower 2,0
-body_right_upper 2.5,1 -body_right_material soil -body_right_velocity 0,-2
-bc_ymin_type friction -bc_ymin_mu 0.2 -time_end 0.06 -history_every 0.004 -output_every 0.02
-history_walls ymin -history_bodies all -history_energy
-history_body_quantities particles,mass,kinetic_energy,strain_energy,dissipation,momentum,angular_momentum,center,lower,upper,back,front,stress_min,stress_max,von_mises
-probes place,air,tip,seven -probe_place_at 0.75,0.5 -probe_place_fields velocity,stress,volume,plastic_strain,error_indicator
-probe_air_at 1.5,1.2 -probe_tip_follow 1,1 -probe_tip_fields velocity,F,stress,plastic_strain,body
-probe_seven_particle 7 -checkpoint_every 0.02 -checkpoint_keep 9
-output_fields velocity,stress,plastic_strain,volume,body,von_mises,pressure""".split() + QUIET


def walls(**kinds):
    words = []
    for face, kind in kinds.items():
        words += [f"-bc_{face}_type", kind]
        words += ["-bc_%s_mu" % face, "0.3"] if kind == "friction" else []
        words += ["-bc_%s_velocity" % face, "0.5,0"] if kind == "moving" else []
    return words


def imbalance(history, gravity=(3, -10)):
    """The largest part of a change of momentum between two lines that walls and gravity do not explain."""
    dt = np.diff(check.kicked(history))
    worst, size = 0, 0
    for axis, g in zip("xy", gravity):
        impulses = [values[1:] * dt for name, values in history.items()
                    if name.startswith("reaction_") and name.endswith("_" + axis)]
        change = np.diff(history["momentum_" + axis])
        worst = max(worst, np.abs(change - sum(impulses) - history["mass"][1:] * g * dt).max())
        size = max(size, max(np.abs(one).max() for one in impulses))
    return worst / size


def balance():
    one = walls(xmin="fixed", xmax="separate", ymin="friction", ymax="moving")
    two = walls(xmin="slip", xmax="friction", ymin="moving", ymax="fixed")
    jobs = [(one, "usf", "flip", "-method_flip", "0.7"), (two, "usl", "flip"), (one, "musl", "flip"),
            (two, "usl", "pic"), (one, "musl", "apic"), (two, "usf", "aflip"), (one, "usl", "xpic", "-method_order", "1"),
            (two, "musl", "xpic", "-method_order", "3"), (one, "usl", "afmpm", "-method_order", "3")]

    def job(k):
        faces, update, transfer, *more = jobs[k]
        name = f"balance{k}"
        run = check.pebble(*BLOCK, *faces, "-method_update", update, "-method_transfer", transfer, *more,
                           "-output_name", name)
        return run, check.history(f"output/{name}.csv") if run.good else None

    for (faces, update, transfer, *more), (run, history) in zip(jobs, check.at_once(job, range(len(jobs)))):
        if not check.that(run.good, f"{update} {transfer} {' '.join(more)} runs {run.err.strip()[-200:]}"):
            continue
        left = imbalance(history)
        check.that(left < 1e-13, f"{update} {transfer} {' '.join(more)}: walls and gravity change the momentum, "
                                 f"but for {left:.1e}")
        if transfer in ("xpic", "afmpm"):
            continue
        work = sum(history["work_" + face][-1] for face in ("xmin", "xmax", "ymin", "ymax"))
        terms = history["energy_walls"][-1] + history["energy_friction"][-1]
        check.that(abs(work - terms) < 1e-12 * abs(terms), f"the works of the walls are the terms of the energy: {work:.6g} J")
    run = check.pebble(*BLOCK, *one, "-dt_cfl", "1.4", "-check_state", "retry", "-check_energy", "0.3", "-method_transfer", "flip",
                       "-output_name", "retried")
    undone = run.find(r"^retries +(\d+) tries")
    left = imbalance(check.history("output/retried.csv")) if run.good else 1
    check.that(undone and left < 1e-13, f"with {undone} tries that were undone too: {left:.1e} {run.err.strip()[-200:]}")


def rest():
    """A column settles: the floor carries its weight, and each wall what the others do not."""
    run = check.must(*"""-dim 2 -gravity 0,-10 -grid_lower 0,0 -grid_upper 0.5,2 -grid_cells 2,8 -materials s
        -material_s_model neohookean -material_s_rho 1000 -material_s_E 1e6 -material_s_nu 0.3 -bodies b
        -body_b_shape box -body_b_lower 0,0 -body_b_upper 0.5,1 -body_b_material s -bc_xmin_type slip
        -bc_xmax_type slip -bc_ymin_type fixed -method_transfer pic -method_basis linear -method_update usl -time_end 2
        -history_every 1 -history_walls ymin,xmin,xmax -output_format none -output_name rest""".split(), *QUIET)
    h = check.history("output/rest.csv")
    force = h["reaction_ymin_y"][-1]
    check.that(run.good and abs(force - 5000) < 1, f"a column of 5000 N at rest: the floor carries {force:.2f} N")
    check.that(h["reaction_xmin_x"][-1] > 100 and
               abs(h["reaction_xmin_x"][-1] + h["reaction_xmax_x"][-1]) < 1e-9 * 5000, "its sides carry each other")
    check.that(h["reaction_ymin_y"][0] == 0 and np.all(h["work_ymin"] == 0), "a wall at rest does no work")


def thrown():
    run = check.must(*THROWN, "-output_name", "one")
    h = check.history("output/one.csv")
    check.that(len(re_lines(run.out, "probe  ")) == 1 and "probe      tip follows particle" in run.out,
               "the particle of a probe is told")
    for name in ("mass", "kinetic_energy", "strain_energy", "momentum_x", "momentum_y", "angular_momentum_z"):
        both = [h[name_of(name, body)] for body in ("left", "right")]
        size = np.abs(both[0]).max() + np.abs(both[1]).max() + 1e-300
        check.that(np.abs(both[0] + both[1] - h[name]).max() < 1e-13 * size + 1e-9 * (name == "momentum_x"),
                   f"the {name} of the bodies is that of all")
    heat = h["dissipation_left"][-1] + h["dissipation_right"][-1]
    check.that(abs(heat + h["energy_laws"][-1]) < 1e-10 * heat and heat > 10,
               f"the dissipation is what the laws took: {heat:.5g} J")
    p = check.particles("output/one.h5")
    left = p["body"] == 0
    ep = p["plastic_strain"]
    V0 = h["mass_left"][0] / 1000 / left.sum()
    work = YIELD * V0 * ep[left].sum()
    check.that(abs(h["dissipation_left"][-1] - work) < 0.02 * work,
               f"without hardening it is the yield stress times the plastic strain: {h['dissipation_left'][-1]:.5g}, {work:.5g} J")
    check.must(*THROWN[:THROWN.index("-probes")], *QUIET, "-output_name", "every")
    every = check.particles("output/every.h5")["plastic_strain"]
    check.that(np.array_equal(every, ep), f"snapshots with all fields have it too, of metal and of soil: {every[left].max():.3g}, {every[~left].max():.3g}")
    gap = np.abs(ep[left] - ep[~left]).max() / ep.max()
    check.that(ep.max() > 0.01 and gap < 2e-3,
               f"druckerprager with the yield stress of vonmises has its plastic strain: {gap:.1e} of {ep.max():.3g}")
    x = p["x"][left]
    half, x = np.sqrt(p["volume"][~left]) / 2, p["x"][~left]
    check.that(all(close(h[f"{end}_right_{'xy'[d]}"][-1], take(x[:, d] + sign * half)) for d in (0, 1)
                   for end, take, sign in (("lower", np.min, -1), ("upper", np.max, 1))), "the ends, at the edges of particles")
    check.that(all(close(sign * h[f"{end}_right_{'xy'[d]}"][-1], quantile(sign * x[:, d] + half, 0.995))
                   for d in (0, 1) for end, sign in (("back", -1), ("front", 1))), "the ends of all but 0.5 % of the mass")
    x = p["x"][left]
    check.that(all(0.03 < sign * (h[f"{end}_left_{'xy'[d]}"][-1] - take(x[:, d])) < 0.033 for d in (0, 1)
                   for end, take, sign in (("lower", np.min, -1), ("upper", np.max, 1))), "those of metal, which has elastic strains of some per cent")
    for body, of in (("left", left), ("right", ~left)):
        principal = np.linalg.eigvalsh(p["stress"][of].reshape(-1, 3, 3))
        check.that(close(h[f"stress_min_{body}"][-1], principal.min()) and close(h[f"stress_max_{body}"][-1], principal.max())
                   and h[f"von_mises_{body}"][-1] == p["von_mises"][of].max(), f"the extreme stresses of {body}")
    check.that(all(abs(h[f"center_left_{'xy'[d]}"][-1] - x[:, d].mean()) < 1e-12 for d in (0, 1)), "the centre")
    tip = int(run.find(r"^probe +tip follows particle (\d+)"))
    start = check.particles("output/one.h5", 0)["x"]
    check.that(np.argmin(np.hypot(start[:, 0] - 1, start[:, 1] - 1)) == tip, "the nearest particle")
    same = [h["probe_tip_x"][-1] == p["x"][tip, 0], h["probe_tip_velocity_y"][-1] == p["v"][tip, 1],
            h["probe_tip_stress_xy"][-1] == p["stress"][tip, 1], h["probe_tip_stress_zz"][-1] == p["stress"][tip, 8],
            h["probe_tip_plastic_strain"][-1] == ep[tip], h["probe_seven_y"][-1] == p["x"][7, 1]]
    check.that(all(same), "a probe shows what its particle has")
    check.that(h["probe_place_velocity_y"][0] == -2 and abs(h["probe_place_velocity_x"][0]) == 0 and
               np.isfinite(h["probe_place_stress_yy"]).all(), "a place shows a constant field as it is")
    check.that(np.isnan(h["probe_air_velocity_x"]).all(), "where no particle is the values are nan")
    tried = check.pebble(*THROWN, "-dt_cfl", "1.5", "-check_state", "retry", "-check_energy", "0.05", "-output_name",
                         "tried")
    t = check.history("output/tried.csv")
    heat = t["dissipation_left"][-1] + t["dissipation_right"][-1]
    check.that(tried.find(r"^retries +(\d+) tries") and abs(heat + t["energy_laws"][-1]) < 1e-10 * heat,
               f"the same with tries that were undone: {heat:.5g} J {tried.err.strip()[-200:]}")
    text = check.content("output/one.csv")
    for what, n, more in (("3 processes", 3, []), ("the pool", 3, ["-parallel_strategy", "pool"])):
        other = check.pebble(*THROWN, *more, "-output_name", "other", n=n)
        check.that(other.digest == run.digest and check.content("output/other.csv") == text, f"{what}: the same history")
    again = check.pebble(*THROWN, "-output_name", "one", "-restart_file", "output/one-checkpoint-2.h5", n=2)
    check.that(again.digest == run.digest and check.content("output/one.csv") == text,
               f"a restart goes on with the same columns {again.err.strip()}")


def close(a, b):
    return abs(a - b) <= 1e-12 * abs(b)


def quantile(values, share):
    """The smallest value up to which there is this share of particles of one mass."""
    return np.sort(values)[math.ceil(share * len(values) * (1 - 1e-12)) - 1]


def ends():
    """A body that is stretched, turned and sheared from the start ends where its particles' deformed boxes do; one whose surface cuts
    its lattice ends there."""
    F = np.array([[1.2, 0.3], [-0.1, 0.8]])
    box = """-dim 2 -grid_lower -1,-1 -grid_upper 2,2 -grid_cells 24,24 -materials s -material_s_model neohookean -material_s_rho 1000
        -material_s_E 1e6 -material_s_nu 0.3 -bodies b -body_b_shape box -body_b_lower 0.1,0.2 -body_b_material s -time_end 1e-6
        -history_bodies b -history_body_quantities lower,upper,back,front""".split()
    check.must(*box, "-body_b_upper", "0.6,0.7", "-body_b_deformation", ",".join(map(str, F.ravel())), "-method_rim", "whole", "-output_name", "turned")
    h, x = check.history("output/turned.csv"), check.particles("output/turned.h5", 0)["x"]
    half = 0.03125 * np.sqrt((F**2).sum(1))
    check.that(all(close(h[f"{end}_b_{'xy'[d]}"][0], sign * ((sign * x[:, d]).max() + half[d]))
                   for d in (0, 1) for end, sign in (("lower", -1), ("upper", 1))), "the ends of a deformed body")
    check.must(*box, "-body_b_upper", "0.615,0.715", "-output_name", "cut")
    h = check.history("output/cut.csv")
    check.that(all(abs(h[f"upper_b_{axis}"][0] - right) < 0.15 * 0.0625 for axis, right in (("x", 0.615), ("y", 0.715))),
               f"of a body that its lattice does not fit: {h['upper_b_x'][0]:.4f}, {h['upper_b_y'][0]:.4f} m")


def stresses():
    """Von Mises stress and pressure are those of the stress, with that out of the plane, in every dimension."""
    for dim, more in ((1, []), (2, []), (3, []), (2, ["-geometry", "axisymmetric"])):
        box = lambda value: ",".join([str(value)] * dim)
        check.must("-dim", dim, "-grid_lower", box(0), "-grid_upper", box(1), "-grid_cells", box(4), "-materials", "s", "-material_s_model",
                   "neohookean", "-material_s_rho", 1000, "-material_s_E", 1e6, "-material_s_nu", 0.3, "-bodies", "b", "-body_b_shape",
                   "box", "-body_b_lower", box(0), "-body_b_upper", box(0.5), "-body_b_material", "s", "-time_end", 0.01,
                   "-body_b_velocity", ",".join(["3*x*x", "2*x-x*x", "x"][:dim]), *more, *QUIET, "-output_name", "stresses")
        p = check.particles("output/stresses.h5")
        s = p["stress"].reshape(-1, 3, 3)
        mean = np.trace(s, axis1=1, axis2=2) / 3
        mises = np.sqrt(1.5 * ((s - mean[:, None, None] * np.eye(3))**2).sum((1, 2)))
        size = np.abs(s).max()
        check.that(size > 1e3 and np.abs(s[:, 2, 2]).max() > 0.01 * size and np.abs(p["von_mises"] - mises).max() < 1e-12 * size and
                   np.abs(p["pressure"] + mean).max() < 1e-12 * size, f"stresses in {dim}-D {' '.join(more)}: up to {size:.3g} Pa")


def warm():
    """Bodies whose law has no temperature have none: no number in snapshots, and no part in what a probe at a place shows."""
    copper = {"G": 4.7e10, "c0": 3933, "hugoniot_slope": 1.489, "gruneisen": 1.99, "yield": 9e7, "specific_heat": 383}
    check.must("-dim", 2, "-grid_lower", "0,0", "-grid_upper", "1,1", "-grid_cells", "8,8", "-materials", "hot,cold", "-material_hot_model",
               "johnsoncook", "-material_hot_rho", 8960, *(word for name, value in copper.items() for word in (f"-material_hot_{name}", value)),
               "-material_cold_model", "neohookean", "-material_cold_rho", 1000, "-material_cold_E", 1e6, "-material_cold_nu", 0.3, "-bodies", "a,b",
               "-body_a_shape", "box", "-body_a_lower", "0.25,0.25", "-body_a_upper", "0.5,0.75", "-body_a_material", "hot", "-body_b_shape", "box",
               "-body_b_lower", "0.5,0.25", "-body_b_upper", "0.75,0.75", "-body_b_material", "cold", "-time_end", "1e-6", *QUIET, "-probes", "p",
               "-probe_p_at", "0.5,0.5", "-probe_p_fields", "temperature,velocity", "-output_name", "warm")
    p, h = check.particles("output/warm.h5", 0), check.history("output/warm.csv")
    check.that(np.all(p["temperature"][p["body"] == 0] == 293) and np.isnan(p["temperature"][p["body"] == 1]).all() and
               np.abs(h["probe_p_temperature"] - 293).max() < 1e-9, "a body without a temperature has none")


def re_lines(text, start):
    return [line for line in text.splitlines() if line.startswith(start)]


def name_of(name, body):
    return f"{name[:-2]}_{body}{name[-2:]}" if name[-2:-1] == "_" else f"{name}_{body}"


BAR = """-dim 1 -grid_lower 0 -grid_upper 1 -grid_cells 20 -materials s
    -material_s_model neohookean -material_s_rho 1000 -material_s_E 1e6 -material_s_nu 0.3 -bodies b -body_b_shape box
    -body_b_lower 0.5 -body_b_upper 0.9 -body_b_material s -body_b_velocity 1 -time_end 0.3""".split() + QUIET


def leaves():
    run = check.pebble(*BAR, "-particles_leave", "delete", "-probes", "p", "-probe_p_particle", "15", "-output_format", "none",
                       "-history_bodies", "b", "-output_name", "leaves")
    h = check.history("output/leaves.csv")
    gone = np.isnan(h["probe_p_x"])
    told = re_lines(run.out, "warning    probe p")
    check.that(gone[-1] and not gone[0] and np.all(np.diff(gone.astype(int)) >= 0) and len(told) == 1,
               f"a probe whose particle left: {told}")
    check.that(np.array_equal(h["particles_b"], h["particles"]), "a body counts what is left of it")


def exact():
    more = ["-output_exact", "-output_every", "0.013", "-history_exact", "-history_every", "0.0017", "-checkpoint_every",
            "0.02", "-checkpoint_keep", "9", "-bc_xmax_type", "slip", "-time_end", "0.06"]
    run = check.pebble(*BAR, *more, "-output_name", "exact")
    if not check.that(run.good and "exact      " in run.out, f"exact times are told {run.err}"):
        return
    with h5py.File("output/exact.h5") as file:
        times = [float(file[f"step_{k:06d}"].attrs["time"]) for k in check.steps(file)]
    check.that(times == [k * 0.013 for k in range(5)] + [0.06], f"snapshots at exact times: {times}")
    h = check.history("output/exact.csv")
    check.that(list(h["time"]) == [k * 0.0017 for k in range(36)] + [0.06], "lines of the history at exact times")
    text = check.content("output/exact.csv")
    again = check.pebble(*BAR, *more, "-output_name", "exact", "-restart_file", "output/exact-checkpoint-1.h5")
    check.that(again.digest == run.digest and check.content("output/exact.csv") == text, "a restart cuts the same steps")


check.arguments(__doc__, 0)
check.folder("output")  # checkpoints of an earlier test would go on being numbered
balance()
rest()
thrown()
ends()
stresses()
warm()
leaves()
exact()
check.end()
