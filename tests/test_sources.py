"""Matter that flows in: its mass, momentum and energy are counted, with the same bits on any number of processes, after a restart
and in a stage; what a source cannot be is refused.

usage: test_sources.py PEBBLE SOURCE MPIEXEC
"""
import os

import numpy as np

import check

check.arguments(__doc__, 0)

JET = check.write("jet.opts", """\
-dim 2
-gravity 0,-9.81
-grid_lower 0,0
-grid_upper 2,1
-grid_h 0.05,0.05
-bc_xmin_type slip
-bc_xmax_type slip
-bc_ymin_type slip
-bc_ymax_type slip
-materials water
-material_water_model fluid
-material_water_rho 1000
-material_water_K 2e5
-bodies pool,jet
-body_pool_shape box
-body_pool_lower 0,0
-body_pool_upper 2,0.2
-body_pool_material water
-body_jet_shape box
-body_jet_lower 0,0.5
-body_jet_upper 0.2,0.7
-body_jet_velocity 2,0
-body_jet_material water
-sources jet
-source_jet_from 0.05
-source_jet_to 0.25
-time_end 0.3
-history_every 0.01
-output_every 0.1
""")
BLOCKS = check.write("blocks.opts", """\
-dim 2
-gravity 0.5,-1
-grid_lower 0,0
-grid_upper 4,4
-grid_h 0.1,0.1
-materials rubber
-material_rubber_model neohookean
-material_rubber_rho 1000
-material_rubber_E 1e5
-material_rubber_nu 0.3
-bodies block,rod
-body_block_shape box
-body_block_lower 2.5,2.5
-body_block_upper 3,3
-body_block_material rubber
-body_rod_shape box
-body_rod_lower 1,1.5
-body_rod_upper 1.4,1.9
-body_rod_velocity 0,-2
-body_rod_material rubber
-sources rod
-source_rod_to 0.35
-time_end 0.4
-history_every 0.01
-output_format none
""")


def same(scene, stop):
    """The same digest, history and snapshots in all ways, and after a restart while matter flows in."""
    name = scene.split(".")[0]
    whole = check.scene_in(scene, "one", "-checkpoint_every", 1e30)
    check.need(whole.good, whole.said[-500:])
    csv = check.content(f"one/{name}.csv")
    for way in (2, 3, "pool"):
        other = check.scene_in(scene, "many", way=way)
        check.that(other.digest == whole.digest and check.content(f"many/{name}.csv") == csv, f"{name}: the same digest and history on {way}")
    for way in (1, 3):
        check.folder("stop")
        check.scene_in(scene, "stop", "-checkpoint_every", 1e30, "-time_max_steps", stop)
        on = check.scene_in(scene, "stop", "-restart_file", "latest", way=way)
        check.that(on.digest == whole.digest and check.content(f"stop/{name}.csv") == csv, f"{name}: and after a restart at step {stop} on {way} {on.err.strip()}")
    return whole, check.history(f"one/{name}.csv")


def counted():
    said, rows = same(JET, 60)
    flow = np.interp(rows["time"], [0.05, 0.25], [0, 0.2]) * 2 * 0.2 * 1000
    layer = 1000 * 0.2 * 0.025
    check.that(abs(rows["mass"][0] - 400) < 1e-9 and abs(rows["mass"][-1] - 480) < 1e-9, f"in 0.2 s 80 kg flow in: {rows['mass'][-1] - rows['mass'][0]:g}")
    check.that(abs(rows["mass"] - 400 - flow).max() < 1.01 * layer, f"as 2 m/s through 0.2 m, to a layer of {layer:g} kg")
    check.that("0 particles have not flowed in yet; what flowed in, less what left, is 80 kg" in said.out, said.find("^(sources .*)$"))
    said, rows = same(BLOCKS, 25)
    size = rows["kinetic_energy"].max()
    kept = check.scene_in(BLOCKS, "checked", "-check_momentum", 1e-11)
    check.that(kept.good, f"momentum is kept to 1e-11: {kept.err.strip()}")
    check.that(abs(np.diff(rows["energy_residual"])).max() < 1e-3 * size, f"the residual changes by at most {abs(np.diff(rows['energy_residual'])).max() / size:.1e} of the energy between lines")
    text = open(BLOCKS).read().replace("-time_end 0.4\n", "") + "-stages still,push\n-stage_still_time 0.15\n-stage_push_time 0.25\n-stage_push_gravity 0,-1\n"
    check.write("staged.opts", text)
    one, three = check.scene_in("staged.opts", "staged"), check.scene_in("staged.opts", "staged3", way=3)
    check.that(one.good and one.out.split("digest ")[1:] and [d[:16] for d in one.out.split("digest ")[1:]] == [d[:16] for d in three.out.split("digest ")[1:]],
               f"a source flows on from stage to stage {one.err.strip()}")
    deep = check.write("deep.opts", open(JET).read().replace("-dim 2", "-dim 3").replace("0,-9.81", "0,0,-9.81").replace("0,0\n", "0,0,0\n").replace("2,1\n", "2,1,1\n").replace("0.05,0.05", "0.1,0.1,0.1")
                       .replace("2,0.2\n", "2,1,0.2\n").replace("0,0.5\n", "0,0.4,0.5\n").replace("0.2,0.7\n", "0.2,0.6,0.7\n").replace("-gravity 0,0,0,-9.81", "-gravity 0,0,-9.81").replace("velocity 2,0\n", "velocity 0,0,-2\n")
                       .replace("-output_every 0.1", "-output_format none").replace("-time_end 0.3", "-time_end 0.15") + "-bc_zmin_type slip\n-bc_zmax_type slip\n")
    one, three = check.scene_in(deep, "deep"), check.scene_in(deep, "deep", way=3)
    check.that(one.good and one.digest == three.digest, f"downward in three dimensions, {one.find('^(sources .*)$')} {one.err.strip()}")
    return deep


def shapes(deep):
    """Other shapes and directions: mass flows in as through the width or area that the velocity sees; the same bits in all ways."""
    flat = {"a disk": ("sphere", {"center": "0.6,0.5", "radius": 0.125}, (1.5, 1), 0.25), "a disk along an axis": ("sphere", {"center": "0.6,0.5", "radius": 0.125}, (-2, 0), 0.25),
            "a box askew": ("box", {"lower": "0.5,0.4", "upper": "0.7,0.5"}, (1.2, -1.6), 0.8 * 0.2 + 0.6 * 0.1),
            "a triangle": ("polygon", {"vertices": '"0.4,0.4 0.8,0.5 0.5,0.7"'}, (0, 2), 0.4)}
    for name, (shape, numbers, velocity, width) in flat.items():
        text = [line for line in open(JET) if not line.startswith(("-body_jet_shape", "-body_jet_lower", "-body_jet_upper", "-body_jet_velocity", "-output_every", "-gravity"))]
        words = {"shape": shape, "velocity": f"{velocity[0]:g},{velocity[1]:g}", **numbers}
        scene = check.write(f"{shape}{len(name)}.opts", "".join(text) + "".join(f"-body_jet_{key} {value}\n" for key, value in words.items()) + "-gravity 0,-1e-3\n-output_format none\n-check_momentum 0\n")
        said, rows = same(scene, 60) if name in ("a disk", "a box askew") else (None, None)
        if said is None:
            check.must("-options_file", scene, "-output_dir", "shape")
            rows = check.history(f"shape/{os.path.basename(scene)[:-5]}.csv")
        flow = np.interp(rows["time"], [0.05, 0.25], [0, 0.2]) * np.hypot(*velocity) * width * 1000
        off = abs(rows["mass"] - 400 - flow)
        check.that(-1e-3 * flow[-1] < (rows["mass"] - 400 - flow)[-1] < 1000 * width * 0.05 and off.max() < 1000 * width * 0.05, f"{name}: {rows['mass'][-1] - 400:g} kg flow in, of {flow[-1]:g}; on the way {off.max():.2g} off")
    text = [line for line in open(deep) if not line.startswith(("-body_jet_shape", "-body_jet_lower", "-body_jet_upper", "-body_jet_velocity"))]
    for name, more, seen in (("a ball", {"shape": "sphere", "center": "0.6,0.5,0.6", "radius": 0.2, "velocity": "1.2,0,-1.6"}, np.pi * 0.04),
                             ("a cylinder along its axis", {"shape": "cylinder", "center": "0.6,0.5,0.6", "radius": 0.2, "length": 0.2, "axis": "3,0,-4", "velocity": "1.2,0,-1.6"}, np.pi * 0.04),
                             ("a cylinder across it", {"shape": "cylinder", "center": "0.6,0.5,0.6", "radius": 0.15, "length": 0.4, "axis": "0,1,0", "velocity": "1.2,0,-1.6"}, 0.12),
                             ("a prism", {"shape": "polygon", "vertices": '"0.4,0.3 0.8,0.3 0.8,0.7"', "lower": "0.4,0.3,0.5", "upper": "0.8,0.7,0.6", "velocity": "0,0,-2"}, 0.08),
                             ("a prism across", {"shape": "polygon", "vertices": '"0.4,0.3 0.8,0.3 0.8,0.7"', "lower": "0.4,0.3,0.5", "upper": "0.8,0.7,0.7", "velocity": "2,0,0"}, 0.08)):
        scene = check.write("solid.opts", "".join(text) + "".join(f"-body_jet_{key} {value}\n" for key, value in more.items()))
        one = check.scene_in(scene, "solid")
        check.need(one.good, f"{name}: {one.err}")
        rows = check.history("solid/solid.csv")
        mass, flow = rows["mass"][-1] - rows["mass"][0], 1000 * seen * 2 * 0.1
        check.that(abs(mass / flow - 1) < 0.25, f"{name}: {mass:g} kg in 0.1 s, of {flow:g}, in layers of {2000 * seen * 0.05 / 2:.3g}")


def under_water():
    """The work by which a source pushes matter in, below a surface of water, is not told as energy that nothing explains."""
    drop = ("-body_", "-source_jet_", "-output_every", "-time_end", "-grid_upper")
    scene = check.write("deep_source.opts", "".join(line for line in open(JET) if not line.startswith(drop)) + """\
-grid_upper 1,1
-body_pool_shape box
-body_pool_lower 0,0
-body_pool_upper 1,0.05
-body_pool_material water
-body_jet_shape box
-body_jet_lower 0.2,0
-body_jet_upper 0.3,0.1
-body_jet_velocity 0,1
-body_jet_material water
-source_jet_to 3
-time_end 6
-output_format none
""")
    told = check.scene_in(scene, "under")
    check.need(told.good, told.err)
    rows = check.history("under/deep_source.csv")
    base = rows["total_energy"].max() + abs(rows["external_work"][-1])
    check.that(rows["energy_residual"][-1] > 0.05 * base, f"its residual is {rows['energy_residual'][-1] / base:.2g} of the energy and the work")
    check.that("which nothing in the scene explains" not in told.out, "and it is not told as one without a cause")


def stopped():
    """A run that stops between lines of the history tells the energies and what has flowed in of its last step."""
    text = open(JET).read().replace("-bc_xmin_type slip\n", "").replace("-history_every 0.01", "-history_every 1").replace("-output_every 0.1", "-output_format none").replace("-source_jet_from 0.05\n", "")
    said = check.scene_in(check.write("open.opts", text + "-dt_size 5e-4\n"), "stopped")
    check.need(said.status == 3 and said.err.startswith("stopped at step "), said.err)
    step = int(said.err.split()[3].strip(","))
    check.scene_in("open.opts", "before", "-time_max_steps", step - 1)
    rows = check.history("before/open.csv")
    kinetic, waiting, mass = float(said.find(r"energy +kinetic 0 -> (\S+) J")), int(said.find(r"sources +(\d+) particles")), float(said.find(r"less what left, is (\S+) kg"))
    check.that(abs(kinetic / rows["kinetic_energy"][-1] - 1) < 0.1, f"the run stopped at step {step} with {kinetic:g} J, before it it had {rows['kinetic_energy'][-1]:g} J")
    check.that(abs(mass - (160 - waiting) * 0.625) < 0.05 and mass > 0, f"{mass:g} kg have flowed in, {waiting} particles have not")


def refused():
    for more, words in ((["-sources", "tap"], "-sources tap: no body of that name has particles on a lattice"), (["-source_jet_to", 0.01], "-source_jet_to 0.01 must be later than -source_jet_from 0.05"),
                        (["-body_jet_velocity", "0,0"], "-body_jet_velocity must be numbers, one of them not 0"),
                        (["-body_jet_velocity", "2*x,0"], "-sources: -body_jet_velocity must be numbers, one of them not 0"), (["-body_jet_velocity", "-2,0"], "-body_jet_velocity moves a particle of jet, which enters at x = 0.0125, out of the grid, which is from 0 to 2 and has to reach two cells farther; turn it, or move -body_jet_shape"), (["-body_jet_lower", "2.1,0.5", "-body_jet_upper", "2.3,0.6"], "would enter at x = 2.2875, but the grid is from 0 to 2; see -body_jet_shape"),
                        (["-sources", "jet,pool", "-source_pool_to", 1, "-body_pool_velocity", "0,1"], "-sources: all bodies are sources; a scene needs particles at the start: add a body of one cell, at rest in a corner"),
                        (["-body_jet_cut", "pool"], "-sources: the body jet may not be cut or limited by others"), (["-initial_stress", "k0"], "-sources does not apply with -initial_stress"),
                        (["-reference_type", "expression", "-reference_displacement", "0,0"], "-sources does not apply with a known solution"),
                        (["-body_jet_shape", "expression", "-body_jet_expression", "0.01-(x-0.5)^2"], "-sources: the body jet must be a box, sphere, cylinder or polygon; and a polygon in 3-D moves along z, or across it")):
        told = check.scene_in(JET, "refused", *more)
        check.that(told.status == 2 and len(told.lines) == 1 and words in told.err, f"{' '.join(map(str, more))}: {told.err.strip()}")
    filled = check.scene_in(JET, "filled", "-body_pool_upper", "0.05,0.05")
    check.that(filled.good and "0 particles have not flowed in yet; what flowed in, less what left, is 80 kg" in filled.out, f"a tank that is empty but for a cell is filled {filled.err.strip()}")
    told = check.scene_in(BLOCKS, "refused", "-method_frame", "total")
    check.that(told.status == 2 and "-sources does not apply in the total frame" in told.err, told.err.strip())
    told = check.scene_in(BLOCKS, "refused", "-geometry", "axisymmetric", "-gravity", "0,-1", "-body_rod_velocity", "1,-2")
    check.that(told.status == 2 and "-sources: -body_rod_velocity has 1 along x: with -geometry axisymmetric x is the radius, and matter flows in along y only" in told.err, told.err.strip())


def rings():
    """Rings of matter flow in along the axis: a disk, a ring and half of a ball, each with its volume of revolution; at the axis
    the volumes of particles are chosen for forces (scene/at_walls.c)."""
    drop = ("-body_jet", "-gravity", "-bc_xmax", "-grid_upper", "-body_pool_upper")
    for name, shape, area in (("disk", "box\n-body_jet_lower 0,0.7\n-body_jet_upper 0.2,0.9", 0.04), ("ring", "box\n-body_jet_lower 0.3,0.7\n-body_jet_upper 0.5,0.9", 0.16), ("ball", "sphere\n-body_jet_center 0,0.7\n-body_jet_radius 0.2", 0.04)):
        scene = check.write(f"{name}.opts", "".join(line for line in open(JET) if not line.startswith(drop)) +
                            f"-geometry axisymmetric\n-gravity 0,-9.81\n-grid_upper 1,1\n-body_pool_upper 1,0.2\n-bc_xmax_type slip\n-body_jet_shape {shape}\n-body_jet_velocity 0,-2\n-body_jet_material water\n")
        said, rows = same(scene, 60)
        flowed, right = rows["mass"][-1] - rows["mass"][0], 1000 * np.pi * area * 2 * 0.2
        check.that(abs(flowed / right - 1) < (1e-9 if name == "ring" else 5e-3), f"{name}: {flowed:.6g} kg flow in, the volume of revolution has {right:.6g} {said.err.strip()}")


shapes(counted())
under_water()
stopped()
rings()
refused()
check.end()
