"""Walls that act when matter arrives: the gap at the first force, how long contact lasts and what comes back, for flat, round and
sharp bodies, laws, bases and offsets of the lattice; Hertz; friction of an oblique impact; pistons that push, pull and
meet; matter that starts on walls. The bits are the same on any number of processes, after a restart and after retries.

usage: test_walls.py PEBBLE SOURCE MPIEXEC (some | rest)

some: every other method, law or offset where there are several. rest: the others, and what takes longer, Hertz above all
"""
import glob
import math

import h5py
import numpy as np

import check

(PART,) = check.arguments(__doc__, 1)
QUIET = "-output_format none -report_indicator false".split()


def run(name, lines, *more, n=1):
    """Runs a scene of these lines with a line of the history for each step; returns it, and the run."""
    path = check.write(name + ".opts", lines)
    done = check.must("-options_file", path, *QUIET, "-history_every", 0, "-output_name", name, *more, n=n, timeout=600)
    return check.history(f"output/{name}.csv"), done


def coarse(done):
    """How many times longer the steps are than 0.4 h/(c + |v|), but at least 1: what a balance lacks is of first order in dt."""
    return max(1, float(done.find(r"= (\S+) h/\(c\+")) / 0.4)


def material(law="neohookean", rho=1, E=1, nu=0, more=()):
    lines = ["-materials m", f"-material_m_model {law}", f"-material_m_rho {rho}", *more]
    return lines + ([f"-material_m_K {E}"] if law == "fluid" else [f"-material_m_E {E}", f"-material_m_nu {nu}"])


def share(cases):
    """The part of some cases that is for this part of the test."""
    return cases[PART == "rest"::2]


def words(values):
    return ",".join(repr(float(v)) for v in values)


def contact(h, face, speed):
    """The times between which the face pushes, and the part of its impulse beside a few steps at both ends."""
    force = h[face]
    on = np.nonzero(np.abs(force) > 1e-3 * np.abs(force).max())[0]
    return h["time"][on[0] - 1], h["time"][on[-1]], np.count_nonzero(np.diff((np.abs(force) > 1e-9 * np.abs(force).max()).astype(int)))


def bar(what, *more, n=32, dim=1, gap=0.3, speed=0.01, wall="separate", walls=(), distance=0, **law):
    """A bar, or a block, of length, density and wave speed 1 that strikes a wall flat: it stays for 2 and leaves as fast."""
    h, width = 1 / n, 6
    lower, upper = [distance + gap * h, h], [distance + 1 + gap * h, (width - 1) * h]
    lines = [f"-dim {dim}", "-grid_lower " + words([0] * dim), "-grid_upper " + words([1 + 8 * h, width * h][:dim]),
             "-grid_cells " + ",".join(str(c) for c in [n + 8, width][:dim]), *material(**law), "-bodies b", "-body_b_shape box", "-body_b_material m",
             "-body_b_lower " + words(lower[:dim]), "-body_b_upper " + words(upper[:dim]), "-body_b_velocity " + words([-speed, 0][:dim]),
             f"-bc_xmin_type {wall}", *walls, f"-time_end {gap * h / speed + 2.4}", "-history_walls xmin", "-history_energy"]
    found, done = run("bar", lines, *more)
    start, end, switches = contact(found, "reaction_xmin_x", speed)
    energy = found["kinetic_energy"] + found["strain_energy"]
    left, back = energy / energy[0], found["momentum_x"][-1] / found["momentum_x"][0]
    at = gap - speed * start / h
    check.that(abs(at) < 0.02 and 1.94 < end - start < 2.12 and -1 < back < -0.91 and 0.92 < left[-1] and left.max() < 1.0005 and switches == 2,
               f"{what}: first force {at:+.3f} cells before the wall, for {end - start:.3f}, back with {-back:.3f}, energy {left[-1]:.3f} (most {left.max():.5f})")
    wall_takes, rest = found["energy_friction"][-1] / energy[0], np.abs(found["energy_integration"]).max() / energy[0]
    check.fault(None if rest < 0.03 * coarse(done) and -0.08 < wall_takes <= 1e-12 else f"{what}: the wall takes {wall_takes:.4f} of the energy, integration {rest:.4f}")
    return left[-1]


def check_flat():
    for basis, update, transfer, more in share((
            ("bspline3", "usl", "aflip", ()), ("bspline3", "musl", "flip", ("-dt_cfl", 0.15)), ("bspline3", "usf", "flip", ("-dt_cfl", 0.15)),
            ("bspline3", "usl", "afmpm", ("-method_order", 2, "-dt_cfl", 0.4)), ("bspline2", "usl", "flip", ()), ("bspline2", "musl", "aflip", ()), ("gimp", "usl", "flip", ()),
            ("gimp", "musl", "aflip", ("-method_affine_strain", 0)), ("linear", "musl", "flip", ("-dt_cfl", 0.1)))):
        bar(f"{basis} {update} {transfer}", "-method_basis", basis, "-method_update", update, "-method_transfer", transfer, *more)
    for offset in share((0.1, 0.23, 0.4)):
        bar(f"the lattice shifted by {offset} cells", "-body_b_offset", offset / 32, gap=0.55)
    for law in share(("elastic", "vonmises")):
        bar(law, law=law, more=("-material_m_yield 1e9",) if law == "vonmises" else ())
    kept = [bar(f"{n} cells", n=n) for n in (32, 64)]
    check.that(1 - kept[1] < 0.65 * (1 - kept[0]), f"what the wall takes falls with the cells: {1 - kept[0]:.4f}, {1 - kept[1]:.4f}")
    bar("a block in 2-D, friction", dim=2, wall="friction", walls=("-bc_xmin_mu 0.3",))
    bar("a piston at rest", wall="piston", walls=("-bc_xmin_velocity 0", "-bc_xmin_distance 0.0375", "-bc_xmin_pulls false"), distance=0.0375)


def disk(name, *more, n=16, speed=10.0, gap=0.3, slide=0.0, shape="sphere", wall="-bc_ymin_type separate", cells=(48, 40), at=0.0121, end=2e-4, R=0.01, law=None, run_more=()):
    """A disk, or a block on its edge, that falls on the floor."""
    h = R / n
    y = R + gap * h
    lines = ["-dim 2", "-grid_lower 0,0", "-grid_upper " + words([cells[0] * h, cells[1] * h]), f"-grid_cells {cells[0]},{cells[1]}", wall,
             *(law or material(rho=1200, E=1e9, nu=0.3)), "-bodies b", "-body_b_material m", f"-body_b_velocity {slide!r},{-speed!r}", f"-time_end {end + gap * h / speed!r}",
             "-history_walls ymin", "-history_energy", "-history_bodies b", "-history_body_quantities lower"]
    if shape == "sphere":
        lines += ["-body_b_shape sphere", "-body_b_center " + words([at, y]), f"-body_b_radius {R}"]
    else:
        lines += ["-body_b_shape polygon", "-body_b_vertices " + words([at, y - R, at + R, y, at, y + R, at - R, y])]
    found, done = run(name, lines, *more, *run_more)
    start = contact(found, "reaction_ymin_y", speed)[0]
    energy = found["kinetic_energy"] + found["strain_energy"]
    before = gap - speed * start / h
    check.that(-0.15 < before < 0.02 and energy.max() < 1.0005 * energy[0] and found["momentum_y"][-1] > 0 and found["lower_b_y"].min() >= -0.25 * h,
               f"{name}: first force {before:+.3f} cells before the floor; energy {energy[-1] / energy[0]:.3f}")
    return found, energy[-1] / energy[0]


def check_round():
    for offset in share(("0,0", "1.1e-4,2.3e-4", "0,0.5e-4")):
        _, left = disk("disk", "-body_b_offset", offset)
        check.fault(None if left > 0.93 else f"disk, offset {offset}: only {left:.3f} of the energy is left")
    soft = material(rho=1200, E=1e8, nu=0.45)
    disk("soft_disk", "-body_b_offset", "1.1e-4,0.6e-4", law=soft, end=6e-4, speed=5.0)
    for at in share((0.0125, 0.0121, 0.01234)):
        _, left = disk("edge", shape="edge", at=at)
        check.fault(None if left > 0.8 else f"block on its edge at {at}: only {left:.3f} of the energy is left")
    for mu, slides in ((0.1, True), (1.0, False)):
        found, _ = disk(f"oblique_{mu}", slide=10.0, wall=f"-bc_ymin_type friction\n-bc_ymin_mu {mu}", cells=(60, 40))
        ratio = -(found["momentum_x"][-1] - found["momentum_x"][0]) / (found["momentum_y"][-1] - found["momentum_y"][0])
        check.that(abs(ratio - mu) < 1e-3 if slides else 0.15 < ratio < 0.35, f"oblique impact, mu = {mu}: the impulse along the floor is {ratio:.4f} of that into it")


def check_water():
    """A block of water, whose particles do not begin where it does, falls freely until it touches."""
    for name, law in (("water", material("fluid", 1000, 1e5)), ("sand", material("druckerprager", 2000, 1e6, 0.3, ("-material_m_friction_angle 30",)))):
        for offset in share(("0,0", "0.003,0.005")):
            lines = ["-dim 2", "-grid_lower 0,0", "-grid_upper 1,0.75", "-grid_h 0.025,0.025", "-bc_ymin_type separate", "-bc_xmin_type slip", "-bc_xmax_type slip", "-gravity 0,-9.81",
                     *law, "-bodies b", "-body_b_shape box", "-body_b_material m", "-body_b_lower 0.25,0.1", "-body_b_upper 0.75,0.5", "-history_walls ymin", "-time_end 0.2"]
            found, _ = run(name, lines, "-body_b_offset", offset, "-dt_cfl", 0.4)  # the time is known to a step
            start, free = contact(found, "reaction_ymin_y", 1)[0], math.sqrt(0.2 / 9.81)
            check.that(abs(start / free - 1) < 0.01, f"{name}, offset {offset}: touches the floor at {start:.4f} s, free fall takes {free:.4f}")


def check_rest(presets):
    """What stands on a floor from the start stands there as on a slip wall."""
    block = ["-dim 2", "-grid_lower 0,0", "-grid_upper 2,1.5", "-grid_h 0.0625,0.0625", "-gravity 0,-10", *material(rho=1000, E=1e5, nu=0.3), "-bodies b", "-body_b_shape box",
             "-body_b_material m", "-body_b_lower 0.5,0", "-body_b_upper 1.5,1", "-history_walls ymin", "-history_bodies b", "-history_body_quantities center,lower", "-damping_time 0.1",
             "-time_end 2.5"]
    for preset in presets:
        found = [run("rest", block, "-bc_ymin_type", wall, "-method_preset", preset)[0] for wall in ("slip", "separate")]
        for h in found:
            check.fault(None if abs(h["reaction_ymin_y"][-1] / 1e4 - 1) < 1e-4 else f"{preset}: the floor carries {h['reaction_ymin_y'][-1]} of 10000 N")
        sinks, low = (found[1][c][-1] - found[0][c][-1] for c in ("center_b_y", "lower_b_y"))
        check.that(abs(sinks) < 3e-5 and abs(low) < 6e-5, f"{preset}: a block on a floor that only pushes is {-sinks:.1e} m lower than on a slip wall, its lowest particle {-low:.1e}")


def check_beds():
    """What starts with the stress of its weight stays on the floor."""
    bed = ["-dim 2", "-grid_lower 0,0", "-grid_upper 2,1.5", "-grid_h 0.0625,0.0625", "-gravity 0,-9.81", "-bodies b", "-body_b_shape box", "-body_b_material m", "-body_b_lower 0,0",
           "-body_b_upper 2,1", "-bc_xmin_type slip", "-bc_xmax_type slip", "-bc_ymin_type separate", "-initial_stress k0", "-time_end 0.3"]
    for name, law in (("soil", material("druckerprager", 2000, 1e7, 0.3, ("-material_m_friction_angle 30",))), ("water", material("fluid", 1000, 1e6)), ("rubber", material(rho=1000, E=1e6, nu=0.3))):
        h, _ = run("bed", bed + law)
        still = h["kinetic_energy"].max() / h["strain_energy"][0]
        check.that(still < 1e-6, f"{name} that starts with the stress of its weight stays on the floor: kinetic {still:.1e} of its strain energy")


def check_pistons():
    pull = ["-dim 2", "-grid_lower 0,0", "-grid_upper 2,0.5", "-grid_h 0.0625,0.0625", "-bc_xmin_type fixed", "-bc_xmax_type piston", "-bc_xmax_distance 1",
            '-bc_xmax_velocity "t < 3 ? 1/6*(1-cos(2*pi*t/3)) : 0"', *material(rho=1000, E=1e5), "-bodies b", "-body_b_shape box", "-body_b_lower 0,0.125", "-body_b_upper 1,0.375",
            "-body_b_material m", "-damping_time 0.2", "-time_end 4.5", "-history_walls xmin,xmax", "-history_bodies b", "-history_body_quantities upper"]
    want = 1e5 / 2 * (1.5 - 1 / 1.5) * 0.25
    for method, most in share((("", 0.005), ("-method_preset fast", 0.02), ("-method_preset accurate", 0.005), ("-method_basis bspline2", 0.02), ("-method_basis gimp -method_transfer flip", 0.005),
                         ("-method_basis gimp -method_gimp_update stretch -method_transfer aflip -method_affine_strain 0.5", 0.005), ("-grid_h 0.05,0.05", 0.005))):
        h, _ = run("pull", pull, *method.split())
        end, held, pulled = h["upper_b_x"][-1], -h["reaction_xmin_x"][-1], h["reaction_xmax_x"][-1]
        check.that(abs(end - 1.5) < 0.003 and abs(held / want - 1) < most and abs(pulled / want - 1) < most,
                   f"pulled {method}: the end is at {end:.4f} m of 1.5, the forces are {held:.0f} and {pulled:.0f} N of {want:.0f}")
    h, _ = run("lets_go", pull, "-bc_xmax_pulls", "false", "-time_end", 2)
    check.that(np.abs(h["reaction_xmax_x"]).max() == 0 and abs(h["upper_b_x"][-1] - 1) < 1e-9, "a piston that only pushes leaves the bar behind")
    push = ["-dim 2", "-grid_lower 0,0", "-grid_upper 2,0.5", "-grid_h 0.0625,0.0625", "-bc_xmax_type slip", "-bc_xmin_type piston", "-bc_xmin_distance 0.7", '-bc_xmin_velocity "t < 2 ? 0.1*(1-cos(pi*t)) : 0"',
            *material(rho=1000, E=1e5), "-bodies b", "-body_b_shape box", "-body_b_lower 1,0.125", "-body_b_upper 2,0.375", "-body_b_material m", "-damping_time 0.2", "-time_end 3.5",
            "-history_walls all", "-history_bodies b", "-history_body_quantities lower,center", "-history_energy"]
    h, _ = run("before", push)  # it goes from 0.7 to 0.9
    check.that(np.abs(h["reaction_xmin_x"]).max() == 0 and h["kinetic_energy"].max() == 0, "a piston in front of a bar is not felt before it touches")
    for method in share(("", "-method_basis gimp -method_transfer flip", "-method_preset fast", "-method_basis bspline2 -method_update musl -method_transfer flip -dt_cfl 0.1")):
        h, _ = run("push", push, "-bc_xmin_distance", 0.9, *method.split())
        want, force = 1e5 / 2 * (1 / 0.9 - 0.9) * 0.25, h["reaction_xmin_x"][-1]  # it goes to 1.1
        touched = h["time"][np.nonzero(h["reaction_xmin_x"])[0][0]]
        place = 0.9 + 0.1 * (touched - math.sin(math.pi * touched) / math.pi)
        check.that(abs(force / want - 1) < 0.02 and abs(place - 1) < 0.005 and abs(h["reaction_xmax_x"][-1] / want + 1) < 0.02,
                   f"pushed {method}: touches at {place:.4f} m of 1, presses with {force:.0f} N of {want:.0f}")
        rest = np.abs(h["energy_integration"]).max()
        check.fault(None if rest < 0.05 * h["energy_walls"][-1] else f"pushed {method}: of the piston's work, {h['energy_walls'][-1]:.1f} J, {rest:.2f} J are not explained")
    for method in share(("flip", "apic", "pic", "xpic", "afmpm")):
        h, _ = run("sum", [line for line in push if "damping" not in line], "-bc_xmin_distance", 0.9, "-method_basis", "bspline2", "-method_update", "musl", "-method_transfer", method,
                   "-time_end", 1.5, "-gravity", "0,-1",
                   "-bc_ymin_type", "friction", "-bc_ymin_mu", 0.2, "-body_b_lower", "1,0", "-body_b_upper", "2,0.25", *(["-method_order", 2] if method in ("xpic", "afmpm") else []))
        kick = np.diff(check.kicked(h))
        for axis, g in ("x", 0), ("y", -1):
            faces = sum(h[f"reaction_{face}_{axis}"][1:] for face in ("xmin", "xmax", "ymin"))
            gave, has = np.cumsum((faces + g * h["mass"][1:]) * kick), h[f"momentum_{axis}"][1:]
            check.fault(None if np.abs(gave - has).max() < 1e-10 * max(1, np.abs(faces).max()) else f"{method}, {axis}: walls gave {gave[-1]}, the bar has {has[-1]}")
        check.that(np.abs(h["reaction_ymin_y"].mean() / 250 - 1) < 0.1, f"{method}: the walls' impulses are the change of momentum")


def check_pressed():
    """Water and gas that a piston has pressed together in a closed box keep the pressure of their law, wherever the plane is in a cell, and so
    beside a rigid body; nothing is behind the piston, of a gas at half its volume either."""
    box = ["-dim 2", "-grid_lower 0,0", "-grid_upper 1,0.2", "-grid_h 0.05,0.05", "-bc_xmin_type slip", "-bc_ymin_type slip", "-bc_ymax_type slip", "-bodies b", "-body_b_shape box",
           "-body_b_lower 0,0", "-body_b_material m", "-history_walls xmin"]
    piston, water = ["-bc_xmax_type piston"], material("fluid", rho=1000, E=2.2e6)
    ram = ["-bodies b,ram", "-body_ram_shape box", "-body_ram_lower 0.8,-0.1", "-body_ram_upper 1,0.3", "-body_ram_rigid moving", '-body_ram_velocity "t < 0.25 ? -0.032 : 0, 0"', "-body_b_upper 0.8,0.2"]
    for name, lines, place in (("moves", [*piston, '-bc_xmax_velocity "t < 0.25 ? -0.04 : 0"', "-body_b_upper 1,0.2"], 0.99),
                               *((f"rests at {at}", [*piston, "-bc_xmax_velocity 0", f"-bc_xmax_distance {1 - at:g}", f"-body_b_upper {at},0.2", '-body_b_deformation "0.99,0,0,1"'], at) for at in (0.96, 0.975, 0.99)),
                               ("ram", ram, 0.792)):
        h, _ = run("pressed", [line for line in box if not (line == "-bodies b" and lines is ram)] + water + lines, "-time_end", 0.5, "-output_format", "hdf5")
        got, want, most = -h["reaction_xmin_x"][h["time"] > 0.35].mean() / 0.2, 2.2e6 / 7 * (0.99**-7 - 1), 0.008 if lines is ram else 0.015
        behind = (check.particles("output/pressed.h5", -1, ["x"])["x"][:, 0] > place).sum()
        check.that(abs(abs(got) / want - 1) < most and not behind, f"pressed water, {name}: {abs(got):.0f} Pa of {want:.0f}, {behind} particles behind what presses it")
    gas = material("fluid", rho=1.2, E=1.4e5, more=("-material_m_tait_gamma 1.4",))
    h, _ = run("pressed", box + gas + piston + ['-bc_xmax_velocity "t < 0.2 ? -2.5 : 0"', "-body_b_upper 1,0.2", "-method_preset fast", "-material_m_relaxation 0"], "-grid_h", "0.04,0.04", "-time_end", 0.22,
               "-output_format", "hdf5")
    behind = check.particles("output/pressed.h5", -1, ["x"])["x"][:, 0].max() - 0.5
    check.that(behind < 1e-4, f"of a gas at half its volume, which has no order, the last particle is {behind:.2g} m behind the piston")
    filled, air = ["-body_b_upper 1,0.2", "-body_b_offset 0.003,0.002"], 1e5 * (2**1.4 - 1)
    squeezed = [*piston, '-bc_xmax_velocity "t < 0.2 ? -2.5 : 0"', *filled]
    thrust = ["-grid_upper 1.2,0.2", *(line.replace("0.8,-0.1", "1,-0.1").replace("1,0.3", "1.2,0.3").replace("0.25 ? -0.032", "0.2 ? -2.5") for line in ram[:-1]), *filled]
    for name, lines, most in ("a piston", squeezed, 0.01), ("a ram", thrust, 0.04):
        again = [line for line in box if line.split()[0] not in {words.split()[0] for words in lines}] + gas + lines
        h, done = run("pressed", again, "-time_end", 0.25)
        line = done.find(r"^preset +balanced: (-.*)$")
        check.that("-body_b_ppc 3,3" in line and run("preset", again, "-time_end", 0.25, *line.split())[1].digest == done.digest, f"a gas that {name} presses: {line}")
        got = abs(h["reaction_xmin_x"][h["time"] > 0.22].mean()) / 0.2
        check.that(abs(got / air - 1) < most, f"a gas that {name} presses to half its volume, with the defaults: {got:.0f} Pa of {air:.0f}")
    for fluid, lines in (water, [*piston, '-bc_xmax_velocity "0-t"', "-body_b_upper 1,0.2"]), (water, ram), (gas, [*piston, '-bc_xmax_velocity "0-t"', "-body_b_upper 1,0.2"]):
        path = check.write("press_bits.opts", [line for line in box if not (line == "-bodies b" and lines is ram)] + fluid + lines)
        ways = (1, []), (3, ["-parallel_strategy", "spatial"]), (3, ["-parallel_strategy", "pool"])
        digests = [check.must("-options_file", path, *QUIET, "-time_end", 0.1, *way, n=n).digest for n, way in ways]
        check.must("-options_file", path, *QUIET, "-time_end", 0.1, "-time_max_steps", 37, "-checkpoint_every", 1e30, n=3)
        digests.append(check.must("-options_file", path, *QUIET, "-time_end", 0.1, "-restart_file", "latest").digest)
        check.that(len(set(digests)) == 1 and digests[0], f"pressed {'gas' if fluid is gas else 'water'}: digests {' '.join(map(str, digests))}")


def check_meeting():
    lines = ["-dim 2", "-grid_lower 0,0", "-grid_upper 4,1", "-grid_h 0.25,0.25", "-bc_xmin_type piston", "-bc_xmin_velocity 1", "-bc_xmin_distance 1", *material(rho=1000, E=1e5), "-bodies b",
             "-body_b_shape box", "-body_b_lower 1.5,0", "-body_b_upper 1.75,1", "-body_b_material m", "-particles_leave delete", "-time_end 2"]
    for name, more, text, at in (
            ("meet", ["-bc_xmax_type", "piston", "-bc_xmax_velocity", "0-2*t", "-bc_xmax_distance", 1], "the pistons of -bc_xmin_type and -bc_xmax_type meet", 1),
            ("reach", ["-bc_xmin_velocity", 2, "-body_b_lower", "0.25,0", "-body_b_upper", "0.5,1"], "the piston of -bc_xmin_type reaches the face xmax", 1.5),
            ("back", ["-bc_xmin_velocity", -1], "the piston of -bc_xmin_type leaves the grid through its face", 1)):
        path = check.write("meeting.opts", lines)
        done = check.pebble("-options_file", path, *QUIET, *more, "-bc_xmin_pulls", "false")
        time = float(done.find(r"^warning +the pistons? .* at t=([0-9.]+) s, which ends the run") or "nan")
        check.that(done.status == 3 and text in done.out and text in done.err and abs(time - at) < 0.02, f"{name}: foreseen at {time} s ({at}); {done.err.strip()[:100]}")
    fine = check.pebble("-options_file", path, "-dry_run", "-bc_xmin_velocity", 0.1)
    check.that(fine.status == 0 and "which ends the run" not in fine.out, "a piston that goes nowhere is not warned of")


def check_on_walls():
    """Particles exactly on walls, with every basis."""
    lines = ["-dim 2", "-gravity 0,-9.81", "-grid_lower 0,0", "-grid_upper 1,1", "-grid_h 0.05,0.05", *material(rho=1000, E=1e5, nu=0.3), "-bodies b", "-body_b_shape box", "-body_b_lower 0,0",
             "-body_b_upper 0.4,0.8", "-body_b_offset 0.0125,0.0125", "-body_b_material m", "-time_end 1"]
    for method in share(("", "-method_basis bspline2", "-method_basis gimp -method_transfer flip", "-method_basis gimp -method_gimp_update stretch -method_transfer flip",
                         "-method_basis linear -method_update musl -method_transfer flip -dt_cfl 0.1")):
        for wall in ("fixed", "slip", "separate"):
            h, done = run("on_walls", lines, *method.split(), *(w for f in ("xmin", "xmax", "ymin", "ymax") for w in (f"-bc_{f}_type", wall)))
            total = h["total_energy"] - h["external_work"]
            check.that(h["time"][-1] == 1 and total.max() < 0.02 * coarse(done) * h["external_work"].max(), f"{wall} {method}: a block that starts on walls runs, energy grows by {total.max():.3f} J at most")


def check_edges():
    """Pistons that meet in edges: with gimp nodes beyond the faces get the velocity of the edge. And the velocities of the nodes in the
    snapshot of the start, when no step has been made, are numbers."""
    for dim, basis in ((2, "linear"), (2, "gimp"), (2, "gimp -method_gimp_update stretch"), (2, "bspline3"), (3, "gimp -method_gimp_update stretch")):
        every, faces = lambda value, n=dim: ",".join([value] * n), [axis + side for axis in "xyz"[:dim] for side in ("min", "max")]
        lines = [f"-dim {dim}", "-grid_lower " + every("0"), "-grid_upper " + every("1"), "-grid_cells " + every("12" if dim == 2 else "8"), *(f"-bc_{face}_type piston" for face in faces),
                 *(f"-bc_{face}_velocity 0" for face in faces), *material(rho=1000, E=1e4, nu=0.3), "-bodies b", "-body_b_shape box", "-body_b_lower " + every("0"), "-body_b_upper " + every("1"),
                 "-body_b_material m", '-body_b_velocity "' + ",".join(["0.2*sin(2*pi*x)", "-0.2*sin(2*pi*y)", "0.1*sin(2*pi*z)"][:dim]) + '"', "-dt_size 0.005", f"-time_end {0.3 if dim == 2 else 0.1}",
                 "-output_every 1e9"]
        found, _ = run("edges", lines, "-method_transfer", "apic", "-method_update", "usl", "-method_basis", *basis.split())
        total = found["kinetic_energy"] + found["strain_energy"]
        check.that(total.max() < 1.06 * total[0], f"a block between pistons, {dim}-D {basis}: its energy grows by {total.max() / total[0] - 1:.1e} at most")
    for name in ("friction", "gate", "impact"):
        check.must("-options_file", check.scene(name), "-time_max_steps", 0, "-output_dir", ".", "-output_name", "start", "-output_fields", "grid")
        with h5py.File(sorted(glob.glob("start.snapshots/*.h5"))[0]) as file:
            v = file["step_000000/grid/v"][()]
        check.that(np.isfinite(v).all(), f"{name}: the {v.size} velocities of nodes at the start are numbers")


def check_equal(everything):
    ball = ["-dim 3", "-grid_lower 0,0,0", "-grid_upper 2,2,2", "-grid_h 0.125,0.125,0.125", "-bc_ymin_type friction", "-bc_ymin_mu 0.2", "-bc_zmax_type separate", "-bc_xmin_type piston",
            '-bc_xmin_velocity "0.3*sin(9*t)"', "-bc_xmin_distance 0.4", *material(rho=1000, E=1e5, nu=0.3), "-bodies b", "-body_b_shape sphere", "-body_b_center 0.95,0.6,1.35", "-body_b_radius 0.5",
            "-body_b_material m", "-body_b_velocity -1,-2,1.5", "-time_end 1", "-time_max_steps 60"]
    path = check.write("ball.opts", ball)
    for method in ([], ["-method_basis", "gimp", "-method_update", "musl", "-method_transfer", "flip"], ["-method_basis", "bspline2", "-method_update", "usf", "-method_transfer", "afmpm"])[:None if everything else 1]:
        ways = [(1, []), (3, ["-parallel_migrate", "direct"]), (3, ["-parallel_strategy", "pool"]), *([(2, []), (4, [])] if everything else [])]
        digests = [check.must("-options_file", path, *QUIET, *method, *way, n=n).digest for n, way in ways]
        check.must("-options_file", path, *QUIET, *method, "-time_max_steps", 37, "-checkpoint_every", 1e30, n=3)
        digests.append(check.must("-options_file", path, *QUIET, *method, "-restart_file", "latest").digest)
        digests.append(check.must("-options_file", path, *QUIET, *method, "-check_state", "retry").digest)
        check.that(len(set(digests)) == 1 and digests[0], f"{' '.join(method)}: digests {' '.join(map(str, digests))}")


def hertz(n, speed, gap=0.3, *more):
    """A quarter of a ball on a wall; returns contact time and peak force over those of Hertz."""
    R, E, nu, rho = 0.01, 1e9, 0.3, 1200.0
    h, modulus, mass = R / n, E / (1 - nu**2), 4 / 3 * math.pi * R**3 * rho
    depth = (15 * mass * speed**2 / (16 * math.sqrt(R) * modulus))**0.4
    time, peak = 2.94328 * depth / speed, 4 / 3 * modulus * math.sqrt(R) * depth**1.5
    wide, high = int(1.15 * n) + 1, math.ceil(2 * n + gap + 2)
    upper = words([wide * h, high * h, wide * h])
    lines = ["-dim 3", "-grid_lower 0,0,0", "-grid_upper " + upper, f"-grid_cells {wide},{high},{wide}", "-bc_xmin_type slip", "-bc_zmin_type slip", "-bc_ymin_type separate",
             *material(rho=rho, E=E, nu=nu), "-bodies b,k", "-body_b_shape sphere", "-body_b_center " + words([0, R + gap * h, 0]), f"-body_b_radius {R}", "-body_b_material m", "-body_b_within k",
             "-body_k_shape box", "-body_k_material none", "-body_k_lower 0,0,0", "-body_k_upper " + upper, f"-body_b_velocity 0,{-speed},0", f"-time_end {gap * h / speed + 1.6 * time!r}",
             "-history_walls ymin"]
    found, _ = run("hertz", lines, *more)
    start, end, switches = contact(found, "reaction_ymin_y", speed)
    before, first = gap - speed * start / h, gap - speed * found["time"][np.nonzero(np.abs(found["reaction_ymin_y"]) > 1e-9 * peak)[0][0] - 1] / h
    t, f, back = (end - start) / time, 4 * found["reaction_ymin_y"].max() / peak, found["momentum_y"][-1] / -found["momentum_y"][0]
    check.that(-0.05 < before < 0.02 and first < 0.02, f"R/h = {n}, {speed} m/s, {' '.join(map(str, more))}: first force {first:+.3f} cells before the wall")
    print(f"     contact time {t:.3f}, peak {f:.3f} of Hertz's; rebound {back:.3f}", flush=True)
    return t, f


check_flat()
check_round()
check_water()
check_pistons()
check_on_walls()
if PART == "some":
    check_rest(("balanced", "fast"))
    check_beds()
    check_pressed()
    check_meeting()
    check_edges()
    check_equal(False)
else:
    check_rest(("accurate", "energy"))
    check_equal(True)
    for speed, most in ((10.0, 0.10), (1.0, 0.25)):
        coarse = [hertz(10, speed, gap) for gap in (0.05, 0.3, 0.42)]
        fine = [hertz(20, speed, gap) for gap in ((0.05, 0.3) if speed > 1 else (0.3,))]
        check.that(all(abs(v - 1) < most for pair in fine for v in pair), f"{speed} m/s: contact times and peaks with 20 cells are {fine}")
        worst = [max(abs(v - 1) for pair in found for v in pair) for found in (coarse, fine)]
        check.that(worst[1] < worst[0] or worst[1] < 0.1, f"{speed} m/s: the largest error is {worst[0]:.3f} with 10 cells, {worst[1]:.3f} with 20")
    for more in (("-method_preset", "fast"), ("-method_preset", "accurate"), ("-method_preset", "energy"), ("-method_basis", "gimp", "-method_transfer", "flip"),
                 ("-material_m_model", "elastic"), ("-body_b_offset", "1.3e-4,2.1e-4,-0.7e-4")):
        t, f = hertz(10, 10.0, 0.3, *more)
        check.that(abs(t - 1) < 0.13 and abs(f - 1) < 0.2, f"{' '.join(more)}: contact time {t:.3f}, peak {f:.3f}")

check.end()
