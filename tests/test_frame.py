"""The total frame (-method_frame total): errors on known solutions and their orders, the same bits on any number of processes, after
a restart and after steps that were undone; what it keeps (energy and angular momentum of a spinning disk, energy by terms,
forces of walls); large deformation; and what it says of bodies that meet something.

usage: test_frame.py PEBBLE SOURCE MPIEXEC [PART...]   (parts: the functions check_<part>; default: all)
"""
import math
import re

import numpy as np

import check

parts = check.arguments(__doc__, None)
TOTAL = ("-method_frame", "total", "-output_format", "none", "-history_every", "0", "-checkpoint_wall", "0")


def error(name, *options):
    """The relative error of a scene of options/, of which only the frame is changed."""
    run = check.must("-options_file", check.scene(name), *TOTAL, *map(str, options))
    return float(run.find(r"so the relative error is (\S+)"))


def body(shape, dim=2, law="neohookean", **more):
    """Options of one body b of material m, E = 1e6, rho = 1000; of a box these are lower and upper."""
    region = [f"-body_b_shape {shape}", *(f"-body_b_{key} {value}" for key, value in more.items())]
    return [f"-dim {dim}", "-materials m", f"-material_m_model {law}", "-material_m_rho 1000", "-material_m_E 1e6",
            "-material_m_nu 0.3", "-bodies b", *region, "-body_b_material m"]


def run(name, scene, *options, n=1, status=0, total=TOTAL):
    """A run of these lines of options, which has to end with this status."""
    result = check.pebble("-options_file", check.write(name + ".opts", scene), *total, *map(str, options), n=n)
    check.fault(None if result.status == status else f"{name}: exit status {result.status}\n{result.said}")
    return result


def check_errors():
    """The errors on two grids, and their order, which is 2 or more."""
    cases = [("mms", "-grid_cells", "{0},{0}", (), 4e-3, 9e-4), ("shear", "-grid_cells", "{0},{0}", (), 6e-4, 1.5e-4),
             ("elastic_column", "-grid_cells", "{0}", (), 1.7e-3, 3e-4), ("barx", "-grid_cells", "{0}", ("-check_energy", 1), 3e-3, 7.5e-4),
             ("mms", "-grid_cells", "{0},{0}", ("-method_basis", "bspline3", "-method_mass_order", 3, "-dt_cfl", 0.4), 2.1e-4, 5.5e-5),
             ("mms", "-grid_cells", "{0},{0}", ("-method_basis", "gimp"), 1.5e-2, 3.7e-3)]
    for name, grid, value, more, *bounds in cases:
        found = [error(name, grid, value.format(n * 5 // 4 if name == "elastic_column" else n), *more) for n in (16, 32)]
        check.that(all(f < b for f, b in zip(found, bounds)), f"{name} {more}: errors {found[0]:.3g} and {found[1]:.3g}, below {bounds}")
        check.that(math.log2(found[0] / found[1]) > 1.8, f"{name} {more}: order {math.log2(found[0] / found[1]):.2f}")
    cube = ["-dim 3", "-grid_lower 0,0,0", "-grid_upper 1,1,1", *(f"-bc_{f}_type slip" for f in ("xmin", "xmax", "ymin", "ymax", "zmin", "zmax"))]
    cube += body("box", 3, lower="0,0,0", upper="1,1,1")[1:] + ["-mms_type axis", "-mms_amplitude 0.05", "-time_end 0.06"]
    found = [float(run("axis3", cube, "-grid_cells", f"{n},{n},{n}").find(r"relative error is (\S+)")) for n in (6, 12)]
    check.that(found[1] < 1.2e-2 and math.log2(found[0] / found[1]) > 1.8, f"3-D, displaced at the start: errors {found[0]:.3g} and {found[1]:.3g}")


def check_bits():
    """Serial, 2, 3 and 4 processes have the same digest and history, in 1-D to 3-D, with every law, wall and load."""
    bar = ["-grid_lower 0", "-grid_upper 2", "-grid_cells 32", "-bc_xmin_type moving", '-bc_xmin_velocity "0.3*sin(40*t)"',
           *body("box", 1, lower=0, upper=1), "-loads p", "-load_p_body b", "-load_p_face xmax", "-load_p_type traction",
           '-load_p_value "1e4*t"', "-time_end 0.1", "-history_energy", "-history_walls xmin"]
    plate = ["-grid_lower 0,0", "-grid_upper 1,1", "-grid_cells 20,20", "-bc_xmin_type fixed", "-gravity 3,0", "-bc_ymin_type periodic",
             "-bc_ymax_type periodic", *body("box", 2, "vonmises", lower="0,0", upper=".6,1"), "-material_m_yield 3e3",
             '-body_b_velocity "x*sin(2*pi*y),0"', "-time_end 0.02", "-history_energy", "-history_walls xmin", "-damping_time 0.1"]
    cube = ["-grid_lower 0,0,0", "-grid_upper 1,1,1", "-grid_cells 13,13,13", "-bc_zmin_type slip", "-gravity 0,0,-9",
            *body("sphere", 3, "elastic", center=".5,.5,.3", radius=".3"), "-time_max_steps 6", "-time_end 1"]
    for name, scene in (("bar", bar), ("plate", plate), ("cube", cube)):
        runs = check.at_once(lambda n: run(f"{name}{n}", scene, n=n), (1, 2, 3, 4))
        runs.append(run(f"{name}_pool", scene, "-parallel_strategy", "pool", "-pool_cells", "4", n=3))
        check.that(len({r.digest for r in runs}) == 1, f"{name}, the last with the pool: {[r.digest for r in runs]}")
        check.that(len({check.content(f"output/{name}{n}.csv") for n in (1, 2, 3, 4, "_pool")}) == 1, f"{name}: one history")
    spoilt = run("swarm", cube, "-parallel_migrate", "direct", "-parallel_sums", "roundoff", n=2)
    check.that(spoilt.good, "sums by roundoff run")


def check_restart():
    """A run that goes on from a checkpoint on another number of processes ends with the same bits; one that had to undo steps
    has them on any number."""
    beam = ["-grid_lower 0,-2", "-grid_upper 3,1.5", "-grid_h .25,.25", "-bc_xmin_type fixed", "-gravity 0,-10",
            *body("box", lower="0,0", upper="2,1"), "-time_end 0.4"]
    files = ("-method_frame", "total", "-output_every", "1", "-history_every", "0.02", "-history_energy", "-output_name", "beam")
    whole = run("beam", beam, "-output_dir", "whole", total=files)
    run("beam", beam, "-output_dir", "parts", "-checkpoint_every", ".1", "-time_max_steps", "60", total=files, n=2)
    parts = run("beam", beam, "-output_dir", "parts", "-restart_file", "latest", total=files, n=3)
    check.that("restart    from step 60" in parts.out and parts.digest == whole.digest, f"restart: {parts.digest}, {whole.digest}")
    check.that(check.content("whole/beam.csv") == check.content("parts/beam.csv"), "restart: one history")
    again = check.must("-rerun", "whole/beam.h5", "-output_dir", "again")
    check.that(again.digest == whole.digest, "rerun: the same digest")
    # the factor of F-bar is part of the state
    bar = (*files[:-1], "bar", "-method_locking", "fbar", "-material_m_nu", "0.49")
    ends = [run("bar", beam, "-output_dir", "whole", total=bar).digest]
    run("bar", beam, "-output_dir", "parts", "-checkpoint_every", ".1", "-time_max_steps", "60", total=bar, n=2)
    ends.append(run("bar", beam, "-output_dir", "parts", "-restart_file", "latest", total=bar, n=3).digest)
    check.that(len(set(ends)) == 1 and ends[0] != whole.digest, f"restart with F-bar: {ends}")
    retry = ["-check_state", "retry", "-dt_cfl", "1.9", "-time_max_steps", "20"]
    for more in ([], ["-method_locking", "fbar"]):
        undone = check.at_once(lambda n: run(f"undone{n}", beam, *retry, *more, n=n), (1, 3))
        check.that("tries were undone" in undone[0].out and undone[0].digest == undone[1].digest, f"retry {more}: one digest")


def check_spin():
    """A spinning disk keeps its angular momentum and its energy. Those of its particles swing with its breathing by some 1e-4
    about those of the nodes, which do not change; their means over 5 turns stay within 1e-4."""
    R, w = 0.25, 2 * math.pi
    disk = ["-grid_lower -.5,-.5", "-grid_upper .5,.5", "-grid_cells 16,16", *body("sphere", center="0,0", radius=R),
            f'-body_b_velocity "0-{w!r}*y,{w!r}*x"', "-material_m_E 1e5", "-time_end 10"]
    disk.remove("-material_m_E 1e6")
    run("disk", disk)
    rows = check.history("output/disk.csv")
    for key, values in (("momentum", rows["angular_momentum_z"]), ("energy", rows["kinetic_energy"] + rows["strain_energy"])):
        half = len(values) // 2
        late, most = values[half:].mean() / values[:half].mean() - 1, abs(values / values[0] - 1).max()
        check.that(abs(late) < 1e-4, f"spin: mean {key} of the second 5 turns {late:+.1e} of the first")
        check.that(most < (1e-3 if key == "momentum" else 2e-2), f"spin: {key} differs by {most:.1e} at most")


def check_beam():
    """A hanging beam, 2 x 2 particles a cell, 8 cells high, swings with the frame and nothing else; the particle at its corner
    falls to -3.28 m within 1 %, and the frame says that it passes the plane of the wall that holds it."""
    beam = ["-grid_lower 0,-5", "-grid_upper 5,2", "-grid_h .125,.125", "-bc_xmin_type fixed", "-gravity 0,-10",
            *body("box", lower="0,0", upper="4,1"), "-material_m_rho 1050", "-time_end 1.5", "-probes tip", "-probe_tip_follow 4,0"]
    beam.remove("-material_m_rho 1000")
    result = run("beam", beam)
    least = check.history("output/beam.csv")["probe_tip_y"].min()
    check.that(abs(least + 3.28) < 0.0328, f"beam: {least:.4f} m")
    check.that(re.search(r"b reaches \S+ m beyond the plane of its wall xmin \(fixed\), beside the place", result.out), "beam: it is warned of the wall's plane")
    check.that("coming apart" not in result.said, "beam: no crack")


def check_rest():
    """A hanging bar and a clamped beam come to rest by -damping_kinetic with the largest step: their energy is that of statics."""
    bar = ["-grid_lower 0", "-grid_upper 2", "-grid_cells 32", "-bc_xmin_type fixed", "-gravity 1", *body("box", 1, lower=0, upper=1), "-time_end 2"]
    bar[bar.index("-material_m_nu 0.3")] = "-material_m_nu 0"
    beam = ["-grid_lower 0,-.6", "-grid_upper 1.3,.3", "-grid_h .05,.05", "-bc_xmin_type fixed", "-gravity 0,-.1", *body("box", lower="0,0", upper="1,.2"), "-time_end 2"]
    for name, scene, exact in (("bar", bar, 1 / 6), ("beam", beam, None)):
        rest = run(name, scene, "-damping_kinetic", "-time_max_steps", 6000)
        found = float(rest.find(r"^energy .* strain \S+ -> (\S+) J"))
        exact = exact or float(check.pebble("-options_file", name + ".opts", "-method_time", "static", "-output_format", "none", "-history_every", "0").find(r"strain \S+ -> (\S+) J"))
        check.that(abs(found / exact - 1) < 0.01, f"{name}: {found:.5g} J of strain at rest, by statics {exact:.5g}")


def check_pulled():
    """A bar that a load pulls to 1.161 of its length rests there, on every offset of its end in a cell."""
    for offset in (0, 0.3, 0.6):
        scene = ["-grid_lower 0", "-grid_upper 1", "-grid_cells 32", "-bc_xmin_type fixed", *body("box", 1, lower=0, upper=0.5 + offset / 32),
                 "-material_m_nu 0", "-material_m_E 1e5", "-loads p", "-load_p_body b", "-load_p_face xmax", "-load_p_type traction",
                 '-load_p_value "15000*min(t/.4,1)"', "-damping_time .1", "-time_end 1.2", "-probes end", f"-probe_end_follow {0.5 + offset / 32}"]
        for gone in ("-material_m_nu 0.3", "-material_m_E 1e6"):
            scene.remove(gone)
        out = run("pulled", scene).out
        start = float(re.search(r"probe +end follows particle \d+, which starts at \((\S+)\) m", out).group(1))
        stretch = check.history("output/pulled.csv")["probe_end_x"][-1] / start
        check.that(abs(stretch / 1.16119 - 1) < 4e-3, f"pulled, offset {offset}: stretch {stretch:.5f}")


def check_forces():
    """The terms of the energy add up to its change; the walls carry the weight, and the momentum is that of all forces."""
    block = ["-grid_lower 0,0", "-grid_upper 1,1", "-grid_cells 8,8", "-bc_ymin_type fixed", "-gravity 2,-10", *body("box", lower=".25,0", upper=".75,.5"),
             "-time_end 0.3", "-history_energy", "-history_walls ymin"]
    run("block", block)
    rows = check.history("output/block.csv")
    terms = sum(rows[key] for key in rows if key.startswith("energy_") and key != "energy_residual")
    change = rows["total_energy"] - rows["total_energy"][0]
    check.that(abs(terms - change).max() < 1e-9 * rows["kinetic_energy"].max() + 1e-9, "terms: they add up")
    check.must("-options_file", check.scene("elastic_column"), *TOTAL, "-history_energy", "-output_name", "smooth")
    smooth = check.history("output/smooth.csv")
    for key, most in (("transfer", 1e-4), ("integration", 2e-2)):
        found = abs(smooth["energy_" + key]).max() / smooth["energy_gravity"].max()
        check.that(found < most, f"terms: {key} of a column takes {found:.1e} of the work of gravity at most")
    kick = np.diff(rows["time"], prepend=0)
    kick = 0.5 * (kick + np.concatenate(([0], kick[:-1])))
    for axis, g in (("x", 2), ("y", -10)):
        force = rows[f"reaction_ymin_{axis}"]
        momentum = np.cumsum(kick * (force + 250 * g))
        check.that(abs(momentum - rows[f"momentum_{axis}"]).max() < 1e-9 * 250 * 10, f"walls: momentum along {axis} is that of all forces")
    run("rest", block, "-damping_time", "0.02", "-gravity", "0,-10", "-time_end", "0.6")
    check.that(abs(check.history("output/rest.csv")["reaction_ymin_y"][-1] - 2500) < 1, "walls: at rest they carry the weight")


def check_meets():
    """Bodies that meet each other, or a wall that does not hold them, stop the run; those that have nodes in common at the start
    though they do not touch are refused, and those that touch are told. Each message names options with which the scene runs."""
    two = ["-dim 2", "-grid_lower 0,0", "-grid_upper 2,1", "-grid_cells 32,16", "-materials m", "-material_m_model neohookean", "-material_m_rho 1000",
           "-material_m_E 1e6", "-material_m_nu 0.3", "-bodies a,b", "-body_a_material m", "-body_b_material m", "-body_a_shape box",
           "-body_b_shape box", "-body_a_lower .25,.25", "-body_a_upper .5,.5", "-body_b_upper 1.5,.5", "-time_end 0.2"]
    far = two + ["-body_b_lower 1.25,.25", "-body_a_velocity 5,0"]
    both = check.at_once(lambda n: run(f"far{n}", far, n=n, status=3), (1, 3))
    check.that("a and b have met, particles of both are in one cell" in both[0].err and both[0].digest == both[1].digest, "bodies that meet stop the run, at one step")
    check.that("in common" not in both[0].said and "touch" not in both[0].said, "bodies that are apart are not joined")
    near = two + ["-body_a_velocity 10,0"]
    for gap in (0.1, 0.4, 1, 2):
        refused = run("near", near + [f"-body_b_lower {.5 + gap / 16},.25"], status=2)
        check.that(refused.err.startswith("a and b have nodes in common though they do not touch") and refused.err.count("\n") == 1, f"bodies {gap} cells apart are refused")
    check.that(not check.pebble("-options_file", "near.opts", "-method_preset", "solid", "-parallel_strategy", "pool", n=3).good, "with a pool too")
    between = [line.replace("-bodies a,b", "-bodies a,b,c") for line in near] + ["-body_c_shape box", "-body_c_lower .5,.25", "-body_c_upper .5625,.5", "-body_c_material m"]
    told = run("between", between + ["-body_b_lower .5625,.25"], "-time_max_steps", 2)
    check.that("a and c touch" in told.out and "b and c touch" in told.out and "a and b" not in told.out, "two bodies that both touch a third one are one piece with it")
    told = check.pebble("-options_file", check.write("rests.opts", [line.replace("lower .25,", "lower 0,") for line in two] + ["-body_b_lower .5625,.25", "-bc_xmin_type fixed", "-gravity 0,-1", "-method_time static"]))
    remedy = check.pebble("-options_file", "rests.opts", "-method_frame", "updated")
    check.that(told.status == 2 and told.err.strip().endswith("use finer cells, or use -method_frame updated") and remedy.good, f"in statics the updated frame is the remedy: {told.err}{remedy.err}")
    for total in (["-method_preset", "solid"], ["-method_frame", "total"], ["-method_frame", "total", "-method_preset", "solid"]):
        for name, scene, status, most in (("near", near + ["-body_b_lower .625,.25"], 2, ()), ("far", far, 3, ())):
            use = re.search(r"use ((-method_\w+ \w+ ?)+)$", run(name, scene, *most, status=status, total=[*total, *TOTAL[2:]]).err.strip().splitlines()[0]).group(1).split()
            options = dict(zip(total[::2], total[1::2])) | dict(zip(use[::2], use[1::2]))
            run(name, scene, "-time_max_steps", 3, total=[word for pair in options.items() for word in pair] + list(TOTAL[2:]))
    for name, shapes in (("boxes", ["-body_b_lower .5,.25"]), ("disks", ["-body_b_lower .5,.25", "-body_a_shape sphere", "-body_a_center .3,.4", "-body_a_radius .2"])):
        scene = [line for line in two + shapes if name == "boxes" or not re.match("-body_a_(shape box|lower|upper)", line)]
        check.that("a and b touch at the start" in run("touch", scene, "-time_max_steps", 2).out, f"{name} that touch are joined, with a note")
    one = ["-grid_lower 0,0", "-grid_upper 1,1", "-grid_cells 16,16", "-bc_ymin_type slip", *body("box", lower=".25,.5", upper=".75,.75"), "-body_b_velocity 0,-5",
           "-time_end 0.3"]
    check.that("b has met its wall ymin (slip)" in run("falls", one, status=3).err, "a wall that does not hold a body stops the run")
    for wall in ("slip", "fixed"):
        low = ["-grid_lower 0,0", "-grid_upper 1,1", "-grid_cells 16,16", f"-bc_ymin_type {wall}", *body("box", lower=".25,.0625", upper=".75,.75"), "-time_end 0.3"]
        check.that("b starts 1 cells inside of its wall ymin, nearer than" in run("low", low, "-dry_run", status=2).err, f"a {wall} wall that would hold a body across a gap is refused")
    ball = [*low[:4], *body("sphere", center=".51,.23", radius=".23"), "-time_end 0.3"]
    check.that(run("ball", ball, "-time_max_steps", 2).good, "a disk that touches a wall is not")


def check_flow():
    """A plastic bar is squeezed by a moving wall: F leaves the range that was measured, and the run stops, or warns."""
    press = ["-grid_lower 0", "-grid_upper .5", "-grid_cells 4", "-bc_xmin_type fixed", "-bc_xmax_type moving", "-bc_xmax_velocity -2",
             *body("box", 1, "vonmises", lower="0", upper=".5"), "-material_m_yield 1e3", "-time_end 0.2485"]
    stopped = run("press", press, status=3)
    check.that(re.search(r"particle \d+ of b at .* is squeezed to 0.00\S+ of its length, and plastic laws", stopped.err), "a plastic body that is squeezed too much stops the run")
    check.that(re.search("seen at t=.* is squeezed to", run("go", press, "-check_law", "warn").out), "or is warned of")


def check_locking():
    """A nearly incompressible solid is warned of, with what helps: F-bar, with which a cantilever of it bends as far as theory
    says, and a block that swings keeps its energy. Metals have it by default, with the same bits on any number of processes."""
    E, nu, g = 1e3, 0.4999, 0.01
    rest = g * 4**4 / (8 * E / (1 - nu**2) / 12) + g * 4**2 / (2 * 5 / 6 * E / 2 / (1 + nu))  # Timoshenko's beam, 1 m high
    half = math.pi / (3.516 * math.sqrt(g / (8 * rest)))
    beam = ["-grid_lower 0,-1", "-grid_upper 4.5,2", "-grid_h .25,.25", "-bc_xmin_type fixed", f"-gravity 0,-{g}", *body("box", lower="0,0", upper="4,1"), f"-time_end {1.1 * half}",
            "-probes tip", "-probe_tip_follow 4,0.5"]
    beam = [line for line in beam if not re.match("-material_m_(E|nu|rho)", line)] + [f"-material_m_E {E}", f"-material_m_nu {nu}", "-material_m_rho 1"]
    for locking, least, most in (("none", 0, 0.8), ("fbar", 0.95, 1.03)):
        run("bends", beam, "-method_locking", locking)
        tip = check.history("output/bends.csv")["probe_tip_y"]
        found = (tip[0] - tip.min()) / (2 * rest)
        check.that(least < found < most, f"cantilever of nu = {nu}, {locking}: {found:.3f} of theory")
    block = ["-grid_lower -.5,-.5", "-grid_upper 1.5,1.5", "-grid_cells 16,16", *body("box", lower="0,0", upper="1,1"), "-time_end 0.4", "-method_locking fbar", "-dt_cfl .1", "-history_energy",
             '-body_b_velocity "0.3*sin(pi*x)*cos(pi*y),0-0.3*cos(pi*x)*sin(pi*y)"']
    run("swings", block)
    rows = check.history("output/swings.csv")
    most = abs(rows["energy_integration"]).max() / rows["total_energy"][0]
    check.that(most < 0.008, f"F-bar: the forces do the work that the strains store, but for {most:.1e} of the energy, of first order in dt")
    for dim, sides in ((2, "1,1"), (3, "1,1,1")):
        metal = [f"-grid_lower {','.join(['-.25'] * dim)}", f"-grid_upper {','.join(['1.25'] * dim)}", f"-grid_cells {','.join(['12'] * dim)}",
                 *body("box", dim, "vonmises", lower=','.join(["0"] * dim), upper=sides), "-material_m_yield 1e4", "-time_end 0.03",
                 f'-body_b_velocity "{",".join(["2*sin(3*x+y)", "0-2*cos(2*y)*x", "sin(z+x)"][:dim])}"']
        runs = check.at_once(lambda n: run(f"metal{dim}{n}", metal, n=n), (1, 3))
        runs.append(run(f"metal{dim}_pool", metal, "-parallel_strategy", "pool", "-pool_cells", "4", n=3))
        check.that("-method_locking fbar" in runs[0].out and " bar " in runs[0].find(r"^fields (.*)"), f"metals in {dim}-D have F-bar")
        check.that(len({r.digest for r in runs}) == 1, f"F-bar in {dim}-D: {[r.digest for r in runs]}")
    box = ["-grid_lower 0,0", "-grid_upper 1,1", "-grid_cells 8,8", *body("box", lower="0,0", upper="1,1"), "-time_end 0.01"]
    told = run("locks", box, "-material_m_nu", 0.49, "-dry_run")
    check.that("use a finer grid, or -method_locking fbar" in told.said, "a nearly incompressible solid is warned of")


def check_shock():
    """A step of velocity runs through a bar: it rings, and -method_damping_rate takes the overshoot away and keeps the bits."""
    bar = ["-grid_lower 0", "-grid_upper 1.5", "-grid_cells 96", *body("box", 1, lower="0", upper="1"), "-bc_xmin_type moving", "-bc_xmin_velocity 0.01",
           "-time_end 0.016"]
    for rate, least, most in ((0, 1.1, 1.3), (0.25, 0.99, 1.04)):
        runs = [run(f"shock{n}", bar, "-method_damping_rate", rate, *more, "-output_format", "hdf5", n=n) for n, more in ((1, ()), (3, ()), (2, ("-parallel_strategy", "pool")))]
        peak = check.particles("output/shock1.h5")["v"].max() / 0.01
        check.that(least < peak < most, f"damping rate {rate}: the largest velocity is {peak:.3f} of the step")
        check.that(len({r.digest for r in runs}) == 1, f"damping rate {rate}: one digest")


def check_files():
    """The file of any scene serves both frames; what stands aside is told, and the rest is refused by name (refusals.txt)."""
    result = check.must("-options_file", check.scene("vortex"), *TOTAL, "-time_max_steps", "2")
    solid = check.must("-options_file", check.scene("vortex"), "-method_preset", "solid", *TOTAL[2:], "-time_max_steps", "2")
    check.that(solid.digest == result.digest and "preset     solid: -method_frame total" in solid.out, "the preset solid is the total frame")
    both = check.write("solid.opts", ["-method_preset solid", *body("box", lower=".25,.25", upper=".75,.75"), "-grid_lower 0,0", "-grid_upper 1,1", "-grid_cells 8,8", "-time_max_steps 2",
                                      "-time_end 1", '-body_b_velocity "y,x"', "-output_format none"])
    back = check.must("-options_file", both, "-method_frame", "updated").out
    check.that("preset     balanced:" in back and "the updated frame has a method of its own and does not use these options of the file: -method_preset solid" in back, "the frame of the command line wins over the preset of a file")
    framed = check.write("framed.opts", open(both).read().replace("-method_preset solid", "-method_frame updated").splitlines())
    check.that("does not use these options of the file: -method_frame updated" in check.must("-options_file", framed, "-method_preset", "solid").out, "the preset of the command line wins over the frame of a file")
    check.that("does not use these options of the file: -method_update usl -method_transfer aflip -method_gimp_update stretch -method_basis gimp -dt_cfl 0.3" in result.out, "what stands aside is told")
    check.that("dt=" in result.out and "0.7 h/c\n" in result.out, "the default of C is 0.7")
    bar = ["-grid_lower 0", "-grid_upper 2", "-grid_cells 16", *body("file", 1, file="points.csv"), "-body_b_ppc 2", "-time_end 0.01"]
    check.write("points.csv", ["x,vx,Fxx,volume", *(f"{(k + 0.5) / 16},{k % 2},1.1,0.0625" for k in range(16))])
    check.that("-body_b_file does not apply with -method_frame total: its particles are deformed" in run("points", bar, status=2).err, "deformed particles of a table are refused")
    check.write("points.csv", ["x,vx,volume", *(f"{(k + 0.5) / 16},{k % 2},0.0625" for k in range(16))])
    runs = [run("points", bar, n=n) for n in (1, 2)]
    check.that(runs[0].digest == runs[1].digest, "particles of a table: one digest")


for part in parts or [name[6:] for name in list(globals()) if name.startswith("check_")]:
    globals()["check_" + part]()
check.end()
