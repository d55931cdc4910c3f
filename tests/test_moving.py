"""Walls that move: a velocity that is a formula of t gives matter the wall's acceleration and displacement, its work is
that of the energy's terms, and a formula without t has the bits of a number; a piston moves through the grid and takes
matter along; both are the same on any number of processes, after a restart and after steps that were undone.

usage: test_moving.py PEBBLE SOURCE MPIEXEC
"""
import math

import numpy as np

import check

check.arguments(__doc__, 0)
SOLID = ["-materials m", "-material_m_model neohookean", "-material_m_rho 1000", "-material_m_E 1e5", "-material_m_nu 0.3"]
QUIET = "-output_format none -report_indicator false".split()


def box(name, dim, upper, cells, body, *lines):
    words = lambda values: ",".join(str(v) for v in values)
    return check.write(name + ".opts", [
        f"-dim {dim}", "-grid_lower " + words([0] * dim), "-grid_upper " + words(upper), "-grid_cells " + words(cells), *SOLID,
        "-bodies b", "-body_b_shape box", "-body_b_lower " + words(body[0]), "-body_b_upper " + words(body[1]), "-body_b_material m", *lines])


def check_motion():
    """A cell between two walls with the same velocity: its particles have exactly the velocity of the walls' steps."""
    path = box("cell", 1, [1], [1], ([0], [1]), "-method_basis linear", "-dt_size 0.001", "-time_end 0.02", "-history_every 0",
               *(f'-bc_{f}_type moving\n-bc_{f}_velocity "0.2+sin(3*t)"' for f in ("xmin", "xmax")), "-body_b_velocity 0.2")
    for update in ("usl", "musl", "usf"):
        check.must("-options_file", path, "-method_update", update, "-method_transfer", "flip", "-output_name", update)
        h = check.history(f"output/{update}.csv")
        want = 1000 * (0.2 + np.sin(3 * (h["time"][1:] - 0.0005)))
        p = check.particles(f"output/{update}.h5")
        went = 0.001 * (0.2 + np.sin(3 * 0.001 * (np.arange(20) + 0.5))).sum()
        check.that(np.abs(h["momentum_x"][1:] / want - 1).max() < 1e-12 and np.abs(p["x"][:, 0] - [0.25 + went, 0.75 + went]).max() < 1e-12,
                   f"{update}: particles between walls have the walls' velocity and displacement, {went:.4f} m")
    for what, velocity, more in (("a number", "0.3, 0.1", []), ("a formula", "0.3+0*t, 0.1", [])):
        path = box("lid", 2, [1, 1], [8, 8], ([0, 0], [1, 1]), "-bc_ymin_type fixed", "-bc_ymax_type moving", f'-bc_ymax_velocity "{velocity}"',
                   "-time_end 1", "-time_max_steps 8", *more)
        digest = check.must("-options_file", path, *QUIET).digest
        if what == "a number":
            first = digest
    check.that(digest == first, f"a formula without t has the bits of a number: {first} {digest}")


def check_work():
    """A plate that is sheared by its upper wall, forth and back: what the wall does is what the plate has."""
    path = box("shear", 2, [0.5, 0.5], [8, 8], ([0, 0], [0.5, 0.5]), "-bc_ymin_type fixed", "-bc_ymax_type moving",
               '-bc_ymax_velocity "0.3*sin(20*t)*t, 0"', "-bc_xmin_type periodic", "-bc_xmax_type periodic", "-method_basis bspline2",
               "-method_update usl", "-time_end 0.15", "-history_energy")
    for cfl in (0.4, 0.1):
        run = check.must("-options_file", path, *QUIET, "-dt_cfl", cfl)
        h = check.history("output/shear.csv")
        change, rest = h["total_energy"][-1], np.abs(h["energy_integration"]).max()
        check.that(change > 0.1 and rest < 0.06 * cfl * np.abs(h["energy_walls"]).max(),
                   f"cfl {cfl}: the walls' work {h['energy_walls'][-1]:.4f} J makes {change:.4f} J, integration {rest:.2g} J")
        check.that("which nothing in the scene explains" not in run.out, "no warning of energy that grows")


def check_piston():
    """A block in front of a piston, which goes 5 cells and stops."""
    path = box("piston", 2, [2, 0.5], [32, 8], ([0.125, 0], [0.625, 0.5]), "-bc_xmin_type piston", "-bc_xmin_distance 0.125",
               '-bc_xmin_velocity "t < 0.5 ? 1.25*sin(2*pi*t)^2 : 0"', "-bc_ymin_type slip", "-bc_ymax_type slip", "-method_basis bspline2",
               "-method_update usl", "-time_end 0.5", "-damping_time 0.05")
    check.must("-options_file", path)
    x = check.particles("output/piston.h5", fields=["x"])["x"][:, 0]
    place = 0.125 + 0.3125
    check.that(place - 1 / 16 < x.min() < place + 1 / 16 and abs(x.max() - x.min() - 0.5 + 1 / 32) < 0.05,
               f"the block was pushed from 0.125 to {x.min():.3f} m, the piston is at {place} m")
    check.must("-options_file", path, *QUIET, "-history_energy")
    h = check.history("output/piston.csv")
    walls, rest = np.abs(h["energy_walls"]).max(), np.abs(h["energy_integration"]).max()
    check.that(walls > 10 and rest < 0.02 * walls, f"the piston's work, up to {walls:.4g} J, is followed to {rest:.2g} J")


def check_force():
    """The force of a piston that presses a block by five cells is that of uniaxial strain, without a period of cells."""
    path = box("pressed", 2, [0.2, 1.5], [4, 30], ([0, 0], [0.2, 1]), "-bc_xmin_type slip", "-bc_xmax_type slip", "-bc_ymin_type slip",
               "-bc_ymax_type piston", "-bc_ymax_distance 0.5", "-bc_ymax_velocity -0.1*min(t/0.1,1)", "-damping_time 0.05", "-history_walls ymax",
               "-history_every 0.01", "-time_end 2.55")
    check.must("-options_file", path, *QUIET, "-material_m_E", 2e7)
    h = check.history("output/pressed.csv")
    t, force = (h[name][h["time"] > 1.05] for name in ("time", "reaction_ymax_y"))
    long = 1 - 0.1 * (t - 0.055)  # a line is the mean since the one before
    exact = 0.2 * 2e7 / 1.3 * (0.3 / 0.4 * np.log(long) + (long**2 - 1) / 2) / long
    wrong = force / exact - 1
    wave = np.abs(wrong - np.polyval(np.polyfit(t, wrong, 3), t)).max()
    check.that(abs(wrong).max() < 0.01 and wave < 2e-3, f"the force of a piston is {wrong.min():.4f} to {wrong.max():.4f} of the exact one beside it, and swings by {wave:.2g}")


def check_equal():
    """1 and 3 processes and the pool, a restart, and a run in which steps are undone."""
    for name in ("gate", "settle"):
        if name == "gate":
            path, more = check.scene("gate"), ["-bc_xmin_velocity", "2*sin(20*t)^2", "-time_max_steps", 40]
        else:
            path = box("settle", 2, [1, 1], [16, 16], ([0, 0], [1, 0.75]), "-bc_ymin_type moving", '-bc_ymin_velocity "0.2*sin(9*t), 0"',
                       "-bc_xmin_type slip", "-bc_xmax_type slip", "-gravity 0,-10", "-damping_time 0.1", "-damping_kinetic",
                       "-body_b_deformation 1,0.02*x,0,1", "-time_end 1")
            more = ["-time_max_steps", 70]
        runs = [check.must("-options_file", path, *QUIET, *more, *way, n=n).digest
                for n, way in ((1, []), (3, []), (3, ["-parallel_strategy", "pool"]))]
        check.must("-options_file", path, *QUIET, *more, "-time_max_steps", 31, "-checkpoint_every", 1e30, n=3)
        runs.append(check.must("-options_file", path, *QUIET, *more, "-restart_file", "latest").digest)
        runs.append(check.must("-options_file", path, *QUIET, *more, "-check_state", "retry").digest)
        check.that(len(set(runs)) == 1 and runs[0], f"{name}: digests {' '.join(map(str, runs))}")
    single = [check.must("-options_file", path, *QUIET, *more, "-bc_ymin_velocity", velocity).digest for velocity in ("0, max(0, 0.1*t)", "max(0, 0.1*t)")]
    check.that(single[0] == single[1], f"one formula is the velocity along the normal: digests {' '.join(single)}")
    stops = check.must("-options_file", path, *QUIET, *more).find(r"^damping +all velocities were set to 0 (\d+) times$")
    check.that(int(stops) > 0, f"kinetic damping stopped {stops} times in these runs")
    late = check.pebble("-options_file", path, *QUIET, "-bc_ymin_velocity", "0.1/(t<0.02), 0")
    check.that(late.status == 3 and "-bc_ymin_velocity is not finite at t = 0.0" in late.err, f"not finite later: {late.err.strip()[:100]}")
    warned = check.pebble("-options_file", path, "-dry_run", "-bc_ymin_velocity", "0, t").out
    check.that("advances along its normal" in warned and "piston" in warned, "a moving wall that advances by formula is warned of")
    check.that("advances along its normal" not in check.pebble("-options_file", path, "-dry_run").out, "one that slides is not")


def check_settling():
    """Damping: motion decays as exp(-t/T) whatever dt is; a column under sudden gravity settles to the same state."""
    free = box("free", 2, [2, 0.5], [32, 8], ([0.125, 0.125], [0.375, 0.375]), "-body_b_velocity 1,0", "-damping_time 0.25", "-time_end 0.5",
               "-history_energy")
    for cfl in (0.4, 0.1):
        check.must("-options_file", free, *QUIET, "-dt_cfl", cfl)
        h = check.history("output/free.csv")
        left = h["kinetic_energy"] / h["kinetic_energy"][0]
        check.that(np.abs(left / np.exp(-8 * h["time"]) - 1).max() < 1e-12, f"cfl {cfl}: the kinetic energy falls as exp(-2 t/T)")
        check.that(np.abs(h["energy_damping"] - h["kinetic_energy"] + h["kinetic_energy"][0]).max() < 1e-12 * h["kinetic_energy"][0],
                   "the term of damping is what is lost")
    check.must("-options_file", free, *QUIET, "-time_end", 0.1, "-checkpoint_every", 1e30)
    ends = check.pebble("-options_file", check.write("ends.opts", [line for line in open(free).read().splitlines() if "damping" not in line]),
                        *QUIET, "-output_name", "free", "-restart_file", "latest")
    damped = check.history("output/free.csv")
    check.that(ends.status == 0 and np.isfinite(damped["energy_damping"][0]) and np.isnan(damped["energy_damping"][-1]) and damped["kinetic_energy"][-1] > 0.999 * damped["kinetic_energy"][damped["time"] >= 0.1][0],
               f"damping may end at a restart, and its column then has nan: {ends.err.strip()[:80]}")
    steady = box("steady", 1, [1], [16], ([0], [1]), "-gravity -10", "-bc_xmin_type slip", "-method_basis bspline2", "-method_update usl",
                 "-time_end 2", "-body_b_ppc 2")
    M = 1e5 * 0.7 / (1.3 * 0.4)
    want = (1000 * 10)**2 / (6 * M)  # of small strains
    found = {}
    for what in (["-damping_kinetic"], ["-damping_time", "0.1"]):
        for cfl in (0.4, 0.1):
            run = check.must("-options_file", steady, *QUIET, *what, "-dt_cfl", cfl, "-time_end", 2 if what[0] == "-damping_kinetic" else 3)
            h = check.history("output/steady.csv")
            found[what[0], cfl] = h["strain_energy"][-1]
            check.that(h["kinetic_energy"][-1] < 1e-9 * h["strain_energy"][-1] and abs(h["strain_energy"][-1] / want - 1) < 0.1,
                       f"{what[0]}, cfl {cfl}: at rest with {h['strain_energy'][-1]:.5f} J, small strains have {want:.5f}")
        check.that(abs(found[what[0], 0.1] / found[what[0], 0.4] - 1) < 1e-4, f"{what[0]}: the same state with a quarter of the step")
    check.must("-options_file", steady, *QUIET, "-damping_kinetic", "-checkpoint_every", 1e30)
    run = check.must("-options_file", steady, *QUIET, "-time_end", 3, "-restart_file", "latest")
    h = check.history("output/steady.csv")
    check.that("-damping_kinetic not given, was given" in run.out and np.abs(h["strain_energy"][h["time"] > 2] / found["-damping_kinetic", 0.4] - 1).max() < 1e-6,
               "a run that settled goes on without damping, at rest")
    check.that(abs(found["-damping_kinetic", 0.1] / found["-damping_time", 0.1] - 1) < 1e-4, "both dampings settle to the same state")


check_motion()
check_work()
check_piston()
check_force()
check_equal()
check_settling()
check.end()
