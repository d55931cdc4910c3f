"""Rigid bodies (-body_<b>_rigid): a block slides on a floor that is inclined by three angles; a fixed floor bears the weight of
what rests on it, and feels nothing early; a roller that turns drives a plate; the balance of energy closes where a ram moves;
friction and impacts only take energy; a free
disk and a free ball roll and slide on a wall as the formulas say, a box comes to rest; momentum is kept where a free body
strikes; a plate presses on a disk as by Hertz; grips that are tied stretch a bar; bodies that meet or pass through each other stop the run. The bits are the same on any number of
processes, with a pool, after a restart and after retries.

usage: test_rigid.py PEBBLE SOURCE MPIEXEC
"""
import re

import numpy as np

import check

check.arguments(__doc__, 0)
QUIET = "-output_format none -report_indicator false".split()
SOFT = ["-materials m", "-material_m_model neohookean", "-material_m_rho 1000", "-material_m_E 1e6", "-material_m_nu 0.3"]


def words(values):
    return ",".join(repr(float(v)) for v in values)


def grid(lower, upper, h):
    cells = [round((b - a) / h) for a, b in zip(lower, upper)]
    return [f"-dim {len(cells)}", "-grid_lower " + words(lower), "-grid_upper " + words(a + c * h for a, c in zip(lower, cells)), "-grid_cells " + ",".join(map(str, cells))]


def box(name, lower, upper, *more):
    return [f"-body_{name}_shape box", f"-body_{name}_lower {words(lower)}", f"-body_{name}_upper {words(upper)}", *(f"-body_{name}_{word}" for word in more)]


def run(name, lines, *more, n=1):
    """Runs a scene of these lines; returns its history and the run."""
    path = check.write(name + ".opts", ["-history_bodies all", *lines])
    done = check.must("-options_file", path, *QUIET, "-output_name", name, *more, n=n)
    return check.history(f"output/{name}.csv"), done


def slope_scene(tilt, mu, h=1 / 12, end=0.6):
    """A block of 1 x 0.5 on a plane, with gravity at 30 degrees from its normal; all turned by `tilt`, a matrix."""
    turn = np.array([[np.cos(np.radians(tilt)), -np.sin(np.radians(tilt))], [np.sin(np.radians(tilt)), np.cos(np.radians(tilt))]])
    corners = [turn @ at for at in ([-0.5, 0], [0.5, 0], [0.5, 0.5], [-0.5, 0.5])]
    return turn, grid([-2, -1], [3, 3], h) + SOFT + [
        "-gravity " + words(turn @ [5, -10 * 0.75 ** 0.5]), "-bodies block,floor", "-body_block_material m", "-body_block_shape polygon",
        '-body_block_vertices "' + " ".join(f"{float(x)!r},{float(y)!r}" for x, y in corners) + '"',
        "-body_floor_rigid fixed", "-body_floor_shape halfspace", "-body_floor_point 0,0", "-body_floor_normal " + words(turn @ [0, 1]), f"-body_floor_mu {mu}", f"-time_end {end}"]


def slope(tilt, mu, h=1 / 12, end=0.6):
    """Its way by the exact one, and how far it leaves the plane, in cells."""
    turn, lines = slope_scene(tilt, mu, h, end)
    found, _ = run("slope", lines)
    way, off = turn.T @ [found["center_block_x"][-1] - found["center_block_x"][0], found["center_block_y"][-1] - found["center_block_y"][0]]
    return way / (5 * end ** 2 * (0.5 - mu * 0.75 ** 0.5)), off / h


def check_slope():
    for tilt in (0, 17, 45):
        way, off = slope(tilt, 0.3)
        check.that(abs(way - 1) < 0.03 and abs(off) < 0.1, f"a block slides on a floor inclined by {tilt} degrees: {way:.4f} of the exact way, {off:+.3f} cells off the floor")


def rest(*more):
    """A block on a fixed floor between the lines of the grid."""
    return grid([0, 0], [3, 2], 0.1) + SOFT + ["-gravity 0,-10", "-bodies block,floor", *box("block", [1, 0.53], [2, 1.03], "material m"),
                                             *box("floor", [0, 0.1], [3, 0.53], "rigid fixed", "mu 0.3"), *more]


def check_weight():
    found, done = run("rest", rest("-damping_kinetic", "-time_end 0.6", "-history_energy"))
    late = found["time"] > 0.3
    load, moment = found["reaction_floor_y"][late].mean(), found["torque_floor_z"][late].mean()
    check.that(abs(load / 5000 - 1) < 0.01 and abs(moment) < 0.01 * 5000 and done.find("^rigid +(floor: box, fixed, friction 0.3)$"),
               f"a floor bears the weight of a block: {load / 5000:.5f} of it, torque about its middle {moment:.2g} N m")
    check.fault(None if not found["work_floor"].any() and "energy_rigid" not in found else "a fixed floor does work")
    fall, _ = run("fall", rest("-time_end 0.3", "-history_every 0"), "-body_block_lower", "1,0.83", "-body_block_upper", "2,1.33")
    touches = fall["time"][np.nonzero(fall["reaction_floor_y"])[0][0]]
    check.that(abs(touches - (0.6 / 10) ** 0.5) < 0.01, f"a block that falls feels the floor {touches - 0.06 ** 0.5:+.4f} s after it meets it")


def check_spin():
    """Rollers, of a radius of 18 cells, under a plate: it gets the speed of their rims."""
    lines = grid([0, 0], [3, 1.5], 0.05) + SOFT + ["-gravity 0,-10", "-bodies plate,left,right", *box("plate", [1, 1], [2.4, 1.3], "material m"), "-time_end 0.5"]
    for name, x in (("left", 1.3), ("right", 2.1)):
        lines += [f"-body_{name}_{word}" for word in ("shape sphere", f"center {x},0.1", "radius 0.9", "rigid moving", "mu 0.5", "spin -1/3", f"pivot {x},0.1")]
    found, _ = run("rollers", lines)
    speed = found["momentum_plate_x"][-20:].mean() / found["mass_plate"][-1]
    check.that(abs(speed / 0.3 - 1) < 0.1 and abs(found["angle_left_z"][-1] + 0.5 / 3) < 1e-12, f"rollers give a plate {speed:.4f} m/s of their 0.3, turned by {found['angle_left_z'][-1]:.4f}")


def check_energy():
    """A rigid ram presses a block on a rigid floor; the balance closes as it does with a wall that moves."""
    for update, transfer in (("usl", "aflip"), ("musl", "flip"), ("usf", "apic"), ("usl", "afmpm")):
        lines = rest(*box("ram", [0.8, 1.03], [2.2, 1.5], "rigid moving", 'velocity "0, -0.2*sin(5*t)"', "mu 0.3"),
                     "-time_end 0.3", "-history_energy", f"-method_update {update}", f"-method_transfer {transfer}")
        found, _ = run("ram", lines, "-gravity", "0,0", "-bodies", "block,floor,ram")
        work, off = found["energy_rigid"][-1], np.abs(found["energy_integration"]).max()
        same = abs(found["work_ram"][-1] + found["work_floor"][-1] - work)
        check.that(work > 100 and off < (0.05 if update == "usf" else 0.015) * work and same < 1e-9 * work, f"a ram, {update} {transfer}: work {work:.2f} J, of which {off:.3f} J are not explained; friction {found['energy_friction'][-1]:.3f} J")
    done = check.must("-options_file", check.scene("wedge"), *QUIET, "-output_name", "wedge", "-time_max_steps", 2, "-gravity", "0,-1",
                      "-acceleration", "0,-1", "-bc_xmin_type", "moving", "-bc_xmin_velocity", "0,0")
    check.that("with the work of body forces, moving walls, rigid bodies (summed with -history_energy)" in done.out, "the residual says whose work it has")


def check_friction():
    """Friction and impacts at a rigid body only take energy, in every step (with usf and flip of a slide alone); of a slide the balance closes."""
    for update, transfer in (("usl", "aflip"), ("musl", "flip"), ("usf", "flip"), ("usl", "xpic")):
        for tilt, mu, speed in ((0, 0.3, 2), (17, 0.3, 0), (0, 0.7, 0)):
            turn, lines = slope_scene(tilt, mu, h=1 / 8, end=0.2)
            found, _ = run("friction", lines + ["-body_block_velocity " + words(turn @ [0, -speed])], "-history_energy", "-history_every", "0", "-method_update", update, "-method_transfer", transfer)
            least, off = np.diff(found["energy_friction"]), np.abs(found["energy_integration"]).max()
            energy = found["total_energy"].max() + np.abs(found["energy_gravity"]).max()
            slides = mu < 0.5 and not speed
            check.that((least.max() < 1e-12 * energy or (update == "usf" and not slides)) and found["energy_friction"][-1] < -0.05 * energy and (not slides or off < (0.015 if update == "usf" else 0.005) * energy),
                       f"block {f'meets a floor with {speed} m/s' if speed else 'slides' if slides else 'sticks'}, {update} {transfer}: friction {found['energy_friction'][-1]:.2f} J, in no step more than {least.max():.1e} J; {off / energy:.4f} of the energy not explained")


def free(dim, *more, wall="friction", end=1.0):
    """A free body above a wall, and a crumb of matter far away from it."""
    up = [8, 2, 2][:dim]
    return grid([0] * dim, up, 0.25) + SOFT + [*(["-bodies crumb,b"] if "-bodies" not in " ".join(more) else []), *box("crumb", [7.5, 0, 0][:dim], [8, 0.5, 0.5][:dim], "material m"), f"-bc_ymin_type {wall}", "-bc_xmax_type slip",
                                              f"-time_end {end}", "-body_b_rigid free", "-body_b_rho 1000", *more]


def check_falls():
    """The balance of energy with free bodies: exact in flight, on a wall, and within 0.2 % where a disk rolls down elastic ground."""
    for name, lines in (("flies", free(3, "-gravity 0,-2,0", "-body_b_velocity 1,0.5,0.2", "-body_b_spin 3,1,2", *box("b", [1, 1, 0.5], [2, 1.5, 1.5]), wall="slip", end=0.4)),
                        ("stands", free(2, "-gravity 1,-10", "-bc_ymin_mu 0.5", "-body_b_velocity 1,0", *box("b", [1, 0.2], [2, 0.7]), end=0.6))):
        found, _ = run(name, lines, "-dt_size", 1e-3, "-history_energy")
        most = found["rigid_kinetic_energy"].max()
        off, work = np.abs(found["energy_integration"]).max(), found["external_work"][-1]
        taken = found["energy_friction"][-1]
        check.that(most > 100 and off < (1e-4 if name == "flies" else 5e-4) * most and (taken < -10) == (name == "stands") and abs(found["energy_residual"][-1] - taken) < 1e-3 * most,
                   f"a free box {name}: of {most:.1f} J {off:.1e} J are not explained, gravity gives {work:.1f} J, walls take {-taken:.2f} J")
    done = check.must("-options_file", check.scene("roll"), *QUIET, "-output_name", "roll", "-history_energy")
    found = check.history("output/roll.csv")
    energy = found["total_energy"][-1]
    off, rise = np.abs(found["energy_integration"]).max() / energy, np.diff(found["energy_friction"]).max()
    check.that(rise <= 0, f"a disk rolls down elastic ground: friction takes {-found['energy_friction'][-1]:.1f} J of {energy:.0f}, and between two lines gives {rise:.1e} J at most")
    check.that(off < 0.002 and found["rigid_kinetic_energy"][-1] > 0.99 * energy and "energy_rigid" not in found and done.find(r", of free rigid bodies 0 -> (6\d+\.\d+) J, total"),
               f"a disk rolls down elastic ground: {off:.5f} of its energy are not explained")


def check_pushed():
    """A body force moves a free body as gravity does, in rest on a wall too, and its work counts with the loads."""
    lines = free(2, "-body_b_velocity 1,0", "-bc_ymin_mu 0.5", *box("b", [1, 0.2], [2, 0.7]), end=0.6)
    by = {name: run(name, lines, *more, "-dt_size", 1e-3, "-history_energy")[0] for name, more in (("heavy", ["-gravity", "1,-10"]), ("pushed", ["-acceleration", "1,-10"]))}
    for column in ("pivot_b_x", "pivot_b_y", "velocity_b_x", "spin_b_z"):
        off = np.abs(by["heavy"][column] - by["pushed"][column]).max()
        check.that(off < 1e-12, f"{column} of a free box under -acceleration is that under -gravity: {off:.1e}")
    work = by["pushed"]["load_work"][-1], by["heavy"]["external_work"][-1], by["pushed"]["external_work"][-1]
    check.that(work[0] > 100 and abs(work[1] / work[0] - 1) < 1e-3 and abs(work[2] / work[0] - 1) < 1e-12, f"the body force does the work of gravity, {work[0]:.2f} J, gravity {work[1]:.2f} J")


def check_floats():
    """What a box that floats takes of the energy by friction never comes back; the push out of it counts with the volumes."""
    lines = grid([0, 0], [2, 1.5], 0.1) + ["-gravity 0,-10", "-bodies pool,b", "-materials w", "-material_w_model fluid", "-material_w_rho 1000", "-material_w_K 1e6", *(f"-bc_{face}_type slip" for face in ("xmin", "xmax", "ymin")),
                                           *box("pool", [0, 0], [2, 0.8], "material w", "cut b"), *box("b", [0.8, 0.4], [1.2, 0.8], "rigid free", "rho 500", "mu 0"), "-time_end 1", "-history_energy", "-history_every 0.01"]
    for update, transfer, most in (("usl", "aflip", 0.035), ("musl", "flip", 0.015)):
        found, _ = run("floats", lines, "-method_update", update, "-method_transfer", transfer, "-material_w_relaxation", 1)
        rise, off = np.diff(found["energy_friction"]).max(), np.abs(found["energy_integration"]).max() / found["external_work"].max()
        check.that(rise <= 0 and found["energy_friction"][-1] < 0 and off < most, f"a rigid box floats, {update}: friction takes {-found['energy_friction'][-1]:.2f} J and gives {rise:.1e} J at most between two lines; {off:.3f} of the work is not explained")


def check_rolls():
    hole = "-body_b_cut hole", "-body_hole_shape sphere", "-body_hole_center 1,0.5", "-body_hole_radius 0.25", "-body_hole_material none"
    for dim, name, inertia, more in ((2, "disk", 0.5, ()), (3, "ball", 0.4, ()), (2, "annulus", 0.625, ("-body_b_inner_radius 0.25",)),
                                     (2, "disk with a hole", 0.625, hole), (3, "cylinder", 0.5, ("-body_b_length 1", "-body_b_axis 0,0,1"))):
        shape = name if name in ("annulus", "cylinder") else "sphere"
        for angle, mu in ((30, 0.5), (45, 0.2)) + (((0.2, 0.5),) if shape == "annulus" else ()):
            down, across = 10 * np.sin(np.radians(angle)), 10 * np.cos(np.radians(angle))
            found, _ = run("rolls", free(dim, "-bodies crumb,b" + (",hole" if more == hole else ""), "-gravity " + words([down, -across, 0][:dim]), f"-bc_ymin_mu {mu}", f"-body_b_shape {shape}", "-body_b_center " + words([1, 0.5, 1][:dim]), "-body_b_radius 0.5", *more),
                           "-dt_size", 1e-3)
            rolls = mu * across > down / (1 + 1 / inertia)
            way, spin = (down / (1 + inertia) / 2, down / (1 + inertia) / 0.5) if rolls else ((down - mu * across) / 2, mu * across / inertia / 0.5)
            x, w = (found["pivot_b_x"][-1] - 1) / way, -found["spin_b_z"][-1] / spin
            check.that(abs(x - 1) < 2e-3 and abs(w - 1) < 2e-3 and abs(found["pivot_b_y"] - 0.5).max() < 1e-9, f"a free {name} {'rolls' if rolls else 'slides'}: way {x:.5f}, spin {w:.5f} of the exact ones")


def check_box():
    found, _ = run("tumbles", free(2, "-gravity 0,-10", "-bc_ymin_mu 0.5", "-body_b_velocity 1,0", "-body_b_spin 3", *box("b", [1, 1], [2, 1.5]), end=1.6), "-dt_size", 2e-3)
    mass, inertia = 500, 500 * 1.25 / 12
    energy = mass / 2 * (found["velocity_b_x"] ** 2 + found["velocity_b_y"] ** 2) + inertia / 2 * found["spin_b_z"] ** 2 + 10 * mass * found["pivot_b_y"]
    flies = found["time"] < 0.2
    check.that(np.diff(energy).max() < 1e-9 * energy[0] and abs(found["pivot_b_y"][-1] - 0.25) < 1e-6 and np.abs(found["angle_b_z"][flies] - 3 * found["time"][flies]).max() < 1e-12,
               f"a free box tumbles on a wall and lies at {found['pivot_b_y'][-1]:.6f} m; its energy never grows")


STRIKES = grid([0, 0], [3, 2], 0.05) + SOFT + [
    "-bodies block,disk", *box("block", [1.5, 0.5], [2, 1.5], "material m"), "-time_end 0.3", "-body_disk_rigid free", "-body_disk_shape sphere", "-body_disk_center 1.2,1.1",
    "-body_disk_radius 0.25", "-body_disk_rho 2000", "-body_disk_velocity 1,0.3", "-body_disk_mu 0.3", "-body_disk_spin 2"]


def check_strikes():
    mass = 2000 * np.pi / 16
    for update, transfer in (("usl", "aflip"), ("musl", "flip"), ("usf", "apic"), ("usl", "afmpm"), ("usl", "xpic")):
        found, _ = run("strikes", STRIKES, "-method_update", update, "-method_transfer", transfer)
        p = np.array([found["momentum_block_" + axis] + mass * found["velocity_disk_" + axis] for axis in "xy"])
        off, given = np.abs(p - p[:, :1]).max() / p[0, 0], found["momentum_block_x"][-1] / p[0, 0]
        check.that(off < 1e-12 and given > 0.6, f"a free disk strikes a block, {update} {transfer}: it gives {given:.3f} of its momentum, the sum changes by {off:.0e}")


def check_symmetric():
    """Planes of symmetry through a free body: what is in the grid moves as in the whole scene, in 2-D on one plane, in 3-D on two, and
    in 3-D about the normal of one. Linear functions alone are mirrored exactly there."""
    for dim, planes, spin in ((2, 1, 0), (3, 2, 0), (3, 1, 2)):
        found = []
        for whole in (True, False):
            lower = [-0.6 if whole or d >= planes else 0 for d in range(dim - 1)] + [0]
            pads = [[f"-bc_{'xyz'[d]}{side}_type slip" for side in ("min", "max")] for d in range(dim - 1)]
            lines = grid(lower, [0.6] * (dim - 1) + [1.2], 0.1) + SOFT + ["-bodies block,ball", *box("block", lower, [0.6] * (dim - 1) + [0.4], "material m", "ppc " + ",".join("2" * dim)), *sum(pads, []), f"-bc_{'xyz'[dim - 1]}min_type fixed",
                     "-gravity " + words([0] * (dim - 1) + [-10]), "-time_end 0.1", "-body_ball_rigid free", "-body_ball_shape sphere", "-body_ball_center " + words([0] * (dim - 1) + [0.71]), "-body_ball_radius 0.3",
                     "-body_ball_rho 3000", "-body_ball_mu 0.3", "-body_ball_velocity " + words([0] * (dim - 2) + ([0.2, -1] if spin else [0, -1])), *(["-body_ball_spin 2,0,0"] if spin else [])]
            found.append(run("symmetric", lines, "-history_energy", "-dt_size", 5e-4, *"-method_basis linear -method_update musl -method_transfer flip".split())[0])
        up, mass = "xyz"[dim - 1], 2 ** planes
        off = max(np.abs(found[0][key] - found[1][key]).max() for key in [f"pivot_ball_{axis}" for axis in "xyz"[:dim]] + [f"velocity_ball_{axis}" for axis in "xyz"[:dim]] + [f"spin_ball_{axis}" for axis in "xyz" if f"spin_ball_{axis}" in found[0]])
        push, energy = (np.abs(found[0][key] - mass * found[1][key]).max() / np.abs(found[0][key]).max() for key in ("reaction_ball_" + up, "rigid_kinetic_energy"))
        check.that(off < 1e-7 and push < 1e-7 and energy < 1e-7 and np.abs(found[0]["reaction_ball_" + up]).max() > 100,
                   f"planes of symmetry, {planes} in {dim}-D: a free ball {'that spins ' * (spin > 0)}moves as in the whole scene to {off:.0e}, pushes 1/{mass} of it to {push:.0e}, its energy to {energy:.0e}")


def check_ends():
    meet = check.pebble("-options_file", check.write("meet.opts", STRIKES + box("stop", [0, 1.38], [1.4, 1.5], "rigid fixed")), *QUIET, "-bodies", "block,disk,stop")
    check.that(meet.status == 3 and "the rigid bodies disk and stop meet at t=" in meet.err, f"rigid bodies that meet: {meet.err.strip()}")
    gone = check.pebble("-options_file", check.write("gone.opts", STRIKES), *QUIET, "-body_disk_velocity", "-20,0")
    check.that(gone.status == 3 and "the rigid body disk left the grid, to x = " in gone.err, f"a free body that leaves the grid: {gone.err.strip()}")
    check.that("; enlarge the grid (-grid_lower), close it by a wall (-bc_xmin_type), or choose an earlier -time_end" in gone.err, f"a free body that leaves the grid has a remedy: {gone.err.strip()}")
    gone = check.pebble("-options_file", check.write("gone.opts", STRIKES), *QUIET, "-body_disk_velocity", "-20,0", "-bc_xmin_type", "periodic", "-bc_xmax_type", "periodic")
    check.that(gone.status == 3 and re.search(r"the rigid body disk reaches 0\.\d+ m beyond the periodic face xmin at t=\S+ s; rigid bodies do not cross periodic faces: enlarge the grid", gone.err), f"a free body at a periodic face: {gone.err.strip()}")
    lines = rest("-time_end 0.004", *box("ram", [0.8, 1.3], [2.2, 1.5], "rigid moving", "velocity 1e300,0"))
    fast = check.pebble("-options_file", check.write("fast.opts", lines), *QUIET, "-bodies", "block,floor,ram")
    check.that(fast.status == 3 and "the speed inf m/s of the rigid body ram limits it; see -body_ram_velocity and -body_ram_spin" in fast.err, f"a ram that is too fast for any step: {fast.err.strip()}")
    fast = check.must("-options_file", check.write("fast.opts", lines), *QUIET, "-bodies", "block,floor,ram", "-body_ram_lower", "0.8,1.6", "-body_ram_upper", "1,1.7", "-body_ram_pivot", "0.9,1.65",
                      "-body_ram_velocity", "0,0", "-body_ram_spin", "exp(600*t)", "-time_end", 0.018)
    check.that(fast.find(r"dt has fallen to \S+ s at t=\S+ s, from \S+ s: the speed \S+ m/s of the rigid body (ram) limits it; about"), "a ram that shortens the step is named")
    lines = rest("-time_end 0.3", *box("ram", [0.8, 1.3], [2.2, 1.5], "rigid moving", 'velocity "0, 0.01/(t < 0.1)"'))
    nan = check.pebble("-options_file", check.write("nan.opts", lines), *QUIET, "-bodies", "block,floor,ram")
    check.that(nan.status == 3 and "-body_ram_velocity is not finite at t = 0.1" in nan.err, f"a formula that ends: {nan.err.strip()}")


def grip(h, tilt, *more, shift=0.0, stretch=0.1, end=1.2):
    """A bar of 2 x 0.4 between two grips of which one moves, all turned by `tilt`; material without lateral strain."""
    turn = np.array([[np.cos(np.radians(tilt)), -np.sin(np.radians(tilt))], [np.sin(np.radians(tilt)), np.cos(np.radians(tilt))]])
    lines = grid([-1, -1], [5, 5] if tilt else [5, 1], h) + ["-materials m", "-material_m_model neohookean", "-material_m_rho 1000", "-material_m_E 1e6", "-material_m_nu 0", "-bodies bar,held,pulled",
                                                            "-body_bar_material m", "-body_held_rigid fixed", "-body_held_tied", "-body_pulled_rigid moving", "-body_pulled_tied", "-damping_time 0.1", f"-time_end {end}"]
    for name, x, wide in (("bar", (-0.3, 2.3), 0.2), ("held", (-0.5, 0), 0.4), ("pulled", (2, 2.5), 0.4)):
        corners = [turn @ (np.array(at) + [shift, 0]) for at in ([x[0], -wide], [x[1], -wide], [x[1], wide], [x[0], wide])]
        lines += [f"-body_{name}_shape polygon", f'-body_{name}_vertices "' + " ".join(f"{float(at[0])!r},{float(at[1])!r}" for at in corners) + '"']
    speed = turn @ [4 * stretch / end, 0]
    return turn, lines + ['-body_pulled_velocity "' + ",".join(f"{float(v)!r}*(t < {end / 2})" for v in speed) + '"', *more]


def check_grip():
    """Two grips stretch a bar by 0.1: its force is that of the law, E A (s - 1/s)/2 with s = 1.1, at any angle; the other grip bears it."""
    exact = 1e6 * 0.4 * (1.1 - 1 / 1.1) / 2
    for tilt, shift, h, most in ((0, 0, 0.05, 0.02), (0, 0.05, 0.1, 0.02), (30, 0, 1 / 15, 0.03)):
        turn, lines = grip(h, tilt, "-history_energy", "-dt_cfl 0.4", shift=shift)
        found, done = run("grip", lines)
        force = [(turn.T @ [found[f"reaction_{name}_x"][-20:].mean(), found[f"reaction_{name}_y"][-20:].mean()])[0] / exact for name in ("pulled", "held")]
        off = np.abs(found["energy_integration"]).max() / found["energy_rigid"][-1]
        check.that(abs(force[0] - 1) < most and abs(sum(force)) < 0.005 and off < 0.01 and done.find("^rigid +(pulled: polygon, moving, tied)$"),
                   f"a bar between grips at {tilt} degrees, moved by {shift / h} cells: forces {force[0]:+.4f} and {force[1]:+.4f} of the exact one, {off:.1e} of the work not explained")
    path = check.write("grip.opts", ["-history_bodies all", *grip(0.1, 30)[1]])
    one = check.must("-options_file", path, *QUIET, "-time_end", 0.3).digest
    others = {"3 processes": check.must("-options_file", path, *QUIET, "-time_end", 0.3, n=3).digest,
              "pool": check.must("-options_file", path, *QUIET, "-time_end", 0.3, "-parallel_strategy", "pool", n=3).digest}
    check.must("-options_file", path, *QUIET, "-time_end", 0.3, "-time_max_steps", 60, "-checkpoint_every", 1e30)
    others["restart"] = check.must("-options_file", path, *QUIET, "-time_end", 0.3, "-restart_file", "latest", n=2).digest
    check.that(set(others.values()) == {one}, f"grips: the same bits on {', '.join(others)}")
    empty = check.must("-options_file", path, *QUIET, "-time_max_steps", 1, "-body_held_vertices", "-0.9,-0.9 -0.5,-0.9 -0.5,-0.5 -0.9,-0.5")
    check.that("-body_held_tied: no particle lies in the rigid body held at the start, and it holds what lies in it; let matter reach two cells into it" in empty.out, "a grip that holds nothing is warned of")
    path = check.write("shallow.opts", grip(0.1, 0)[1])
    deep = [check.must("-options_file", path, *QUIET, "-time_max_steps", 1, "-body_held_vertices", f"-0.9,-0.4 {x},-0.4 {x},0.4 -0.9,0.4").find(
        r"-body_held_tied: matter lies only (\S+) cells deep in the rigid body held at the start; let it reach two cells into it") for x in (-0.2, -0.1)]
    check.that(deep == ["1", None], f"a grip that holds less than two cells of matter is warned of: {deep}")


def check_couette():
    """A fluid sticks to rigid bodies that are tied: the force of plane Couette flow, viscosity times rate times area."""
    lines = grid([0, 0], [0.5, 2], 0.1) + [f"-bc_{face}_type {kind}" for face, kind in (("xmin", "periodic"), ("xmax", "periodic"), ("ymin", "fixed"), ("ymax", "fixed"))] + [
        "-materials w", "-material_w_model fluid", "-material_w_rho 1", "-material_w_K 400", "-material_w_viscosity 0.5", "-bodies w,lid,floor", *box("w", [0, 0.2], [0.5, 1.8], "material w"),
        *box("lid", [-1, 1.5], [2, 2], "rigid moving", "velocity 0.2,0", "tied"), *box("floor", [-1, 0], [2, 0.5], "rigid fixed", "tied"), "-time_end 2"]
    found, _ = run("couette", lines)
    force = [found[f"reaction_{name}_x"][-1] / (0.5 * 0.2 * 0.5) for name in ("lid", "floor")]
    check.that(abs(force[0] - 1) < 0.05 and abs(sum(force)) < 1e-3, f"Couette flow between tied bodies, 10 cells wide: forces {force[0]:+.4f} and {force[1]:+.4f} of the exact one")


def check_thin():
    """A plate thinner than two cells between matter on both sides is warned of; matter on one side, and bodies in contact, feel it rightly."""
    for thick, gap, contact in ((0.05, 0, False), (0.2, 0, False), (0.05, 1, False), (0.05, 0, True)):
        lines = grid([0, 0], [5, 2], 0.1) + SOFT + ["-bodies a,b,plate", *box("plate", [2.53, 0], [2.53 + thick, 2], "rigid fixed"), *box("a", [1.53, 0.5], [2.53, 1.5], "material m", "velocity 1,0"),
                                                    *box("b", [2.53 + thick + gap, 0.5], [3.33 + thick + gap, 1.5], "material m"), "-time_end 0.1"] + ["-contact_mu 0"] * contact
        found, done = run("thin", lines)
        passes = np.abs(found["momentum_b_x"]).max() / found["momentum_a_x"][0]
        told = done.find(r"the rigid body plate is only (0\.5) cells thick near \(2\.\d+, .*\), between matter on both sides: up to a quarter of a blow passes through it; make it 2 cells thick, or give -contacts")
        bad = thick < 0.1 and not gap and not contact
        check.that(bool(told) == bad and (0.1 < passes < 0.3 if bad else passes < 0.02), f"a plate of {thick / 0.1:.1f} cells, matter on {'one side' if gap else 'both sides, in contact' if contact else 'both sides'}: {passes:.3f} of a blow passes")
    lines = grid([0, 0], [5, 2], 0.1) + SOFT + ["-bodies a,b,plate", *box("plate", [2.53, 0], [2.535, 2], "rigid fixed"), *box("a", [1.53, 0.5], [2.53, 1.5], "material m", "velocity 1,0"), *box("b", [2.535, 0.5], [3.335, 1.5], "material m"), "-time_end 0.01"]
    check.that("the rigid body plate is less than 0.1 cells thick near " in run("foil", lines)[1].out, "a foil is warned of, by less than 0.1 cells")


def check_paths():
    """Tools that pass through others end the run, and the warning before it says when; a tool that leaves the grid is noted."""
    lines = rest("-time_end 0.3", *box("ram", [0.2, 1.3], [0.6, 1.5], "rigid moving", "velocity 0,-4"))
    done = check.pebble("-options_file", check.write("through.opts", lines), *QUIET, "-bodies", "block,floor,ram")
    check.that(done.status == 3 and "the rigid bodies ram and floor pass through each other from t=0.20" in done.said and "the rigid bodies ram and floor pass through each other at t=0.20" in done.err,
               f"a ram that passes through a floor: {done.err.strip()}")
    lines = rest("-time_end 0.3", *box("ram", [0.2, 1.3], [0.6, 1.5], "rigid moving", "velocity 0,4"))
    done = check.must("-options_file", check.write("leaves.opts", lines), *QUIET, "-bodies", "block,floor,ram")
    check.that(done.find(r"the rigid body ram leaves the grid at t=(0\.17\d*) s; from then on it meets nothing"), "a tool that leaves the grid is noted, and the run ends as usual")
    misses = r"the rigid body (ram) moved, but met nothing: its reaction was 0 all the time; check its place, -body_ram_velocity and -time_end"
    check.that(done.find(misses) and "the rigid body floor moved" not in done.out, "at its end, a tool that moved and met nothing is noted")
    hits = run("hits", rest("-time_end 0.05", *box("ram", [1.2, 1.2], [1.6, 1.4], "rigid moving", "velocity 0,-4")), "-bodies", "block,floor,ram")[1]
    check.that(not hits.find(misses), "one that met the block is not")
    steps = len(run("fast", rest("-time_end 0.05", "-history_every 0", *box("ram", [0.2, 1.3], [0.6, 1.5], "rigid moving", "velocity 0,4000")), "-bodies", "block,floor,ram")[0]["time"])
    check.that(steps < 100, f"a tool of 4000 m/s that has left the grid does not bound the step, which would be 4000 steps: {steps}")


def cut(shape, rigid, *more, velocity="0,0", law="neohookean", end=0.045):
    """A block of rubber or clay of 1 x 0.5, and a rigid body that cuts it."""
    soft = [line.replace("neohookean", law) for line in SOFT] + ["-material_m_yield 2e4"] * (law == "vonmises")
    return grid([0, 0], [1.2, 1.2], 0.05) + soft + ["-bc_ymin_type fixed", "-bodies block,tool", *box("block", [0.1, 0], [1.1, 0.5], "material m", f"velocity {velocity}"),
                                                   *(f"-body_tool_{word}" for word in (*shape, f"rigid {rigid}")), f"-time_end {end}", *more]


BLADE = ("shape polygon", 'vertices "0.6,0.52 0.75,0.9 0.75,1.2 0.45,1.2 0.45,0.9"')


def check_cuts():
    """A rigid body cuts a block at the first try: by default the run warns where this parts, and goes on. Without a rigid body that may cut it ends."""
    by = {"a blade that moves": cut(BLADE, "moving", "-body_tool_velocity 0,-10"), "one that falls": cut(BLADE, "free", "-body_tool_rho 1e5", "-body_tool_velocity 0,-10"),
          "a block that meets it": [line.replace("-bc_ymin_type fixed", "-bc_ymin_type free") for line in cut(BLADE, "fixed", velocity="0,10")]}
    for name, lines in by.items():
        path = check.write("cuts.opts", lines)
        done, stop = (check.pebble("-options_file", path, *QUIET, *more) for more in ([], ["-check_parting", "stop"]))
        told = done.find(r"(seen at t=\S+ s: block .*; the rigid body tool, \S+ cells from there, may cut it; if it does not, use more particles per cell)")
        stops = "moves" not in name or (stop.status == 3 and "block has come apart" in stop.err)
        check.that(done.good and told and stops, f"{name} cuts a block of rubber: {done.err.strip() or told}; with -check_parting stop: {stop.err.strip()[:60]}")
    dense = check.pebble("-options_file", check.write("cuts.opts", cut(BLADE, "moving", "-body_tool_velocity 0,-10", "-body_block_ppc 4,4")), *QUIET)
    told = dense.find(r"(seen at t=\S+ s: block .*; the rigid body tool, \S+ cells from there, may cut it)$")
    check.that(dense.good and told, f"no more than 4 particles per cell are advised where it cuts: {told}")
    lines = grid([0, 0], [1.2, 1.2], 0.05) + SOFT + ["-gravity 0,-8000", "-bc_ymax_type fixed", "-bodies block,tool", *box("block", [0.4, 0.7], [0.8, 1.2], "material m"), *box("tool", [0, 0], [0.1, 0.1], "rigid fixed"), "-time_end 0.02"]
    done = check.pebble("-options_file", check.write("torn.opts", lines), *QUIET)
    check.that(done.status == 3 and re.search("block has come (apart|off).*, or let it part .-check_parting warn", done.err), f"what comes apart beside a body at rest, where nothing moves against it, ends the run: {done.err.strip()[:80]}")
    clay = ["-dim 2", "-grid_lower 0,0", "-grid_upper 2,1.6", "-grid_h 0.05,0.05", "-bc_xmin_type slip", "-bc_xmax_type slip", "-bc_ymin_type fixed", "-materials m", "-material_m_model vonmises", "-material_m_rho 1800",
            "-material_m_E 1e7", "-material_m_nu 0.45", "-material_m_yield 34641", "-bodies ground,wedge", *box("ground", [0, 0], [2, 1], "material m"), "-body_wedge_shape polygon",
            '-body_wedge_vertices "1,1 1.3464,1.6 0.6536,1.6"', "-body_wedge_rigid moving", "-body_wedge_velocity 0,-1", "-time_end 0.4"]
    done = check.pebble("-options_file", check.write("clay.opts", clay), *QUIET)
    check.that(done.good and "coming apart" not in done.out, "what flows aside of a wedge is farther than before, as its deformation explains")


def check_coarse():
    """A free disk of few cells that slides down an elastic slope is told of, once it has slid some cells; not one of more, nor one that falls."""
    for radius, gravity, said in ((0.2, "7,-7", True), (0.2, "0,-10", False), (0.42, "7,-7", False)):
        lines = grid([0, 0], [4, 1.5], 0.05) + SOFT + [f"-gravity {gravity}", "-bodies ground,disk", "-bc_ymin_type fixed", *box("ground", [0, 0], [4, 0.25], "material m"),
                                                       *(f"-body_disk_{word}" for word in ("shape sphere", f"center 0.6,{0.252 + radius}", f"radius {radius}", "rigid free", "rho 1000", "mu 0")), "-time_end 0.3"]
        told = re.findall(r"seen at t=\S+ s: the rigid body disk, with (\S+) cells in its radius, slides or rolls on matter; .*; choose -grid_\S+ \S+$", run("coarse", lines)[1].out, re.M)
        check.that(told == ["4"] * said, f"a free disk with {radius / 0.05:.1f} cells in its radius, gravity {gravity}: {told or 'nothing is told'}")


def check_many():
    lines = rest("-time_end 1e-3")
    for k in range(8):
        lines += box(f"r{k}", [0.1 * k, 1.7], [0.1 * k + 0.05, 1.8], "rigid fixed")
    _, done = run("many", lines, "-bodies", "block,floor," + ",".join(f"r{k}" for k in range(8)))
    check.that(done.find("^rigid +(and 1 more)$"), "of nine rigid bodies eight have a line at the start")


def check_equal():
    """The same bits on any number of processes, with a pool, both migrations, less lanes, after a restart and after retries, of the history too."""
    path = check.write("equal.opts", ["-history_bodies all"] + STRIKES + box("paddle", [2.1, 0.9], [2.2, 1.8], "rigid moving", "spin 2*cos(t)", "pivot 2.15,1.3", "mu 0.2"))
    options = ["-options_file", path, *QUIET, "-bodies", "block,disk,paddle", "-time_end", 0.15, "-history_energy"]

    def digest(name, *more, **how):
        done = check.must(*options, "-output_name", name, *more, **how)
        with open(f"output/{name}.csv") as file:
            return done.digest, file.read()

    one, others = digest("one"), {}
    for n in (2, 3):
        others[f"{n} processes"] = digest(f"on{n}", n=n)
    others["pool"] = digest("pool", "-parallel_strategy", "pool", n=3)
    others["direct"] = digest("direct", "-parallel_migrate", "direct", n=3)
    others["2 lanes"] = digest("lanes", lanes=2)
    digest("again", "-time_max_steps", 40, "-checkpoint_every", 1e30, n=2)
    others["restart"] = digest("again", "-restart_file", "latest", n=3)
    wrong = [name for name, found in others.items() if found[0] != one[0] or (found[1] != one[1] and name != "restart")]
    check.that(not wrong, f"the bits of one process also on {', '.join(others)}; not on {', '.join(wrong) or 'none'}")
    last = [text[1].splitlines()[-1] for text in (one, others["restart"])]
    check.that(last[0] == last[1], "the last line of the history after a restart, with place, turn and work of the bodies")
    hasty = ["-dt_size", 0.0016, "-check_state", "retry", "-check_energy", 0.005, "-time_max_steps", 50]
    tried = [check.must(*options, "-output_name", f"tried{n}", *hasty, n=n) for n in (1, 3)]
    undone = tried[0].find(r"^retries +(\d+) tries")
    check.that(undone and int(undone) > 0 and tried[0].digest == tried[1].digest, f"the same bits on 1 and 3 processes with {undone} steps undone")


def check_hertz():
    """The force of the plate of options/hertz.opts at its approach d, by Johnson, Contact Mechanics (1985), eqs. (4.43), (5.56)."""
    check.must("-options_file", check.scene("hertz"), *QUIET, "-output_name", "hertz")
    found = check.history("output/hertz.csv")
    force, radius, stiff = np.linspace(1, 4000, 4000), 0.1, 1e6 / (1 - 0.3**2)
    approach = force / (np.pi * stiff) * (2 * np.log(4 * radius / np.sqrt(4 * force * radius / (np.pi * stiff))) - 1)
    late = found["time"] > 0.015
    off = -2 * found["reaction_plate_y"][late] / np.interp(0.15 - found["pivot_plate_y"][late], approach, force) - 1
    check.that(late.sum() > 100 and np.abs(off).max() < 0.04, f"a plate on a disk: its force is {off.min():+.4f} to {off.max():+.4f} off that of Hertz")


check_slope()
check_hertz()
check_weight()
check_spin()
check_energy()
check_friction()
check_falls()
check_pushed()
check_floats()
check_grip()
check_couette()
check_thin()
check_paths()
check_rolls()
check_box()
check_strikes()
check_symmetric()
check_ends()
check_many()
check_cuts()
check_coarse()
check_equal()
check.end()
