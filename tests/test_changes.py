"""What may change at a restart: forces, walls, laws and the method act from then on, on any number of processes with the same
bits; the balances of energy and momentum count what the change gives; what may not change is refused by name.

usage: test_changes.py PEBBLE SOURCE MPIEXEC
"""
import glob
import os
import shutil

import numpy as np

import check

check.arguments(__doc__, 0)

SOIL = check.write("soil.opts", """\
-dim 2
-gravity 0,-9.81
-grid_lower 0,0
-grid_upper 1.6,1
-grid_h 0.05,0.05
-bc_xmin_type slip
-bc_xmax_type slip
-bc_ymin_type fixed
-materials soil
-material_soil_model druckerprager
-material_soil_rho 1800
-material_soil_E 2e6
-material_soil_nu 0.3
-material_soil_friction_angle 30
-material_soil_cohesion 5e3
-bodies soil,lid
-body_soil_shape box
-body_soil_lower 0,0
-body_soil_upper 0.8,0.6
-body_soil_material soil
-body_lid_shape box
-body_lid_lower 0.1,0.6
-body_lid_upper 0.6,0.7
-body_lid_material soil
-acceleration "0,0"
-damping_time 0.1
-time_end 0.04
-history_every 0.004
-output_every 0.02
-checkpoint_every 1e30
""")
FREE = check.write("free.opts", """\
-dim 2
-gravity 1,-2
-grid_lower 0,0
-grid_upper 4,4
-grid_h 0.1,0.1
-materials rubber
-material_rubber_model neohookean
-material_rubber_rho 1000
-material_rubber_E 1e5
-material_rubber_nu 0.3
-bodies ball
-body_ball_shape sphere
-body_ball_center 2,2
-body_ball_radius 0.4
-body_ball_material rubber
-body_ball_velocity "0.3*(y-2), 1-0.2*(x-2)"
-time_end 0.04
-history_every 0.004
-output_format none
-checkpoint_every 1e30
""")
GO = ["-restart_file", "latest", "-time_end", 0.08]


def go(scene, first, what, *more, ways=(1, 2, 3, "pool")):
    """Goes on from a copy of a finished run in several ways; checks that digest and history are the same; returns the first."""
    runs = []
    for way in ways:
        shutil.rmtree("go", ignore_errors=True)
        shutil.copytree(first, "go")
        one = check.scene_in(scene, "go", *GO, *more, way=way)
        check.need(one.good, f"{what} on {way}: {one.said[-600:]}")
        runs.append((one.digest, check.content(glob.glob("go/*.csv")[0]), one))
    same = all(one[:2] == runs[0][:2] for one in runs)
    check.that(same, f"{what}: the same digest and history in {len(runs)} ways")
    return runs[0][2], check.history(glob.glob("go/*.csv")[0])


def acts():
    """Each change is taken, is listed, and gives another state than no change does."""
    check.need(check.scene_in(SOIL, "first").good, "the run before")
    plain, _ = go(SOIL, "first", "no change", ways=(1, 3))
    for more in (["-gravity", "2,-9.81"], ["-acceleration", "3*t,0"], ["-bc_xmax_type", "free", "-bc_xmin_type", "separate"], ["-bc_ymin_type", "friction", "-bc_ymin_mu", 0.2],
                 ["-material_soil_cohesion", 10], ["-material_soil_E", 4e6], ["-method_basis", "gimp"], ["-method_transfer", "flip", "-method_update", "musl"],
                 ["-method_transfer", "apic"], ["-method_locking", "fbar"], ["-gravity", "0,-20", "-damping_time", 0.5]):
        said, rows = go(SOIL, "first", " ".join(map(str, more)), *more, ways=(1, 3, "pool"))
        check.that(said.digest != plain.digest and more[0] in (said.find("^restart +changed options: (.*)$") or ""), f"{more[0]} acts, and is listed")
        check.that((np.diff(rows["step"]) > 0).all() and rows["time"][-1] == 0.08, f"{more[0]}: one history without a gap")


def dt():
    """The first step is as long as the changed law allows."""
    stiff = ["-material_soil_E", 2e8]
    said, rows = go(SOIL, "first", "a stiffer soil", *stiff, "-history_every", 0, ways=(1,))
    after = rows["dt"][rows["time"] > 0.0401]
    check.that(after.max() < 0.2 * rows["dt"][1], f"dt falls from {rows['dt'][1]:.2g} to {after.max():.2g} s at once")


def balance():
    """A change gives energy and momentum, which the balances count: the residual does not jump."""
    check.need(check.scene_in(FREE, "free", "-check_momentum", 1e-11).good, "the free body")
    for more in (["-gravity", "-3,5"], ["-material_rubber_E", 3e5, "-material_rubber_nu", 0.2]):
        _, rows = go(FREE, "free", more[0], *more, "-check_momentum", 1e-11, ways=(1, 2))
        size = rows["kinetic_energy"].max()
        jump = abs(np.diff(rows["energy_residual"])).max() / size
        check.that(jump < 2e-3, f"{more[0]}: the residual changes by at most {jump:.1e} of the energy between lines")
    stored, k = rows["strain_energy"], np.searchsorted(rows["time"], 0.0401)
    check.that(stored[k] > 1.5 * stored[k - 1], f"the stored energy grows from {stored[k - 1]:.3g} to {stored[k]:.3g} J, which counts as work")


def columns():
    """The history gets the columns of both parts, with nan where a part had none, and goes on from any checkpoint after."""
    check.need(check.scene_in(SOIL, "none", "-acceleration", "0,0", "-history_rest", "false", "-checkpoint_keep", 10).good, "a history without columns of rest")
    shutil.rmtree("both", ignore_errors=True)
    shutil.copytree("none", "both")
    check.scene_in(SOIL, "both", *GO, "-history_rest", "-particles_leave", "delete", "-checkpoint_every", 0.01, way=2)
    rows = check.history("both/soil.csv")
    old = rows["time"] < 0.0401
    check.that(np.isnan(rows["unbalanced"][old]).all() and not np.isnan(rows["unbalanced"][~old]).any() and np.isnan(rows["lost_mass"][old]).all(),
               "columns that come have nan before")
    check.that(rows["kinetic_energy"].size == rows["time"].size and (np.diff(rows["time"]) > 0).all(), "the others go on")
    shutil.copytree("both", "back", dirs_exist_ok=True)
    whole = check.content("back/soil.csv")
    again = check.scene_in(SOIL, "back", *GO, "-history_rest", "-particles_leave", "delete", "-restart_file", sorted(glob.glob("back/soil-checkpoint-*.h5"), key=os.path.getmtime)[-2])
    check.that(again.good and check.content("back/soil.csv") == whole, f"a restart from the middle of the second part: {again.find('^(warning.*)') or 'the same history'}")
    check.scene_in(SOIL, "both", "-restart_file", "latest", "-time_end", 0.1)
    rows = check.history("both/soil.csv")
    check.that(np.isnan(rows["unbalanced"][-1]) and not np.isnan(rows["mass"][-1]), "columns that go have nan after")


def static():
    """Statics become a motion that begins at rest, in equilibrium."""
    scene = check.write("block.opts", open(FREE).read().replace("sphere", "box").replace("-body_ball_center 2,2\n-body_ball_radius 0.4", "-body_ball_lower 1,0\n-body_ball_upper 2,1")
                        .replace('-body_ball_velocity "0.3*(y-2), 1-0.2*(x-2)"\n', "") + "-bc_ymin_type fixed\n")
    statics = ["-method_time", "static", "-method_stabilize_factor", 0]
    first = check.scene_in(scene, "static", *statics, "-gravity", "0,-9.81")
    check.need(first.good, first.said[-500:])
    said, rows = go(scene, "static", "statics, then a motion", "-method_time", "explicit", "-method_frame", "total", "-gravity", "0,-9.81", "-time_end", 0.3, ways=(1, 2))
    moved = rows["kinetic_energy"][rows["time"] > 0.0401].max() / rows["strain_energy"][-1]
    check.that(moved < 1e-6, f"it stays at rest: kinetic energy {moved:.1e} of the strain energy")
    check.that("newton_iterations" in rows and np.isnan(rows["newton_iterations"][-1]), "the columns of statics end")
    _, rows = go(scene, "static", "statics, then a push", "-method_time", "explicit", "-method_frame", "total", "-gravity", "3,-9.81", ways=(1, 2))
    check.that(rows["kinetic_energy"][-1] > 0, "and moves when it is pushed")
    back = check.scene_in(scene, "go", "-restart_file", "latest", *statics, "-method_frame", "total", "-gravity", "3,-9.81", "-time_end", 1)
    check.that(back.status == 2 and "a motion cannot become statics" in back.err, back.err.strip())


def leaves():
    """Bodies leave, of matter and rigid ones: the balances count what they take along."""
    pair = check.write("pair.opts", open(FREE).read().replace("-bodies ball", "-bodies ball,other") + "-body_other_shape sphere\n-body_other_center 1,3\n-body_other_radius 0.4\n"
                       "-body_other_material rubber\n-body_other_velocity 2,1\n-output_every 0.02\n".replace("-output_every", "# -output_every"))
    check.need(check.scene_in(pair, "pair").good, "two balls")
    said, rows = go(pair, "pair", "a ball leaves", "-remove", "other", "-check_momentum", 1e-11)
    k = np.searchsorted(rows["time"], 0.0401)
    size = rows["kinetic_energy"].max()
    check.that(rows["mass"][k] < 0.6 * rows["mass"][0] and rows["particles"][k] < 0.6 * rows["particles"][0], f"{said.find('^(restart .*leave.*)$')}")
    check.that(abs(np.diff(rows["energy_residual"])).max() < 1e-4 * size, f"the residual changes by at most {abs(np.diff(rows['energy_residual'])).max() / size:.1e} of the energy")
    check.that("particles left with their bodies or left the grid, with" in said.out, said.find("^(lost.*)$"))
    again = check.scene_in(pair, "go", "-restart_file", "latest", "-time_end", 0.1, "-remove", "other")
    check.that(again.good and "leave with their bodies" not in again.out, "a later restart names it too, and nothing leaves twice")
    for more, words in ((["-time_end", 0.1], "other had left before"), (["-time_end", 0.1, "-remove", "other,ball"], "no particle would be left"),
                        (["-time_end", 0.1, "-remove", "other,balll"], "-remove balll: the scene has no body of that name with particles, and no rigid one")):
        told = check.scene_in(pair, "go", "-restart_file", "latest", *more)
        check.that(told.status == 2 and len(told.lines) == 1 and words in told.err, told.err.strip())
    told = check.scene_in(pair, "go", "-remove", "other")
    check.that(told.status == 2 and "-remove does not apply: bodies leave at a restart" in told.err, told.err.strip())
    # a column of soil between a wall and a rigid gate, which leaves; and a free ball that does
    gate = check.write("gate.opts", open(SOIL).read().replace("-bodies soil,lid", "-bodies soil,lid,gate,ball") + "-body_gate_shape box\n-body_gate_lower 0.8,0\n-body_gate_upper 1,0.8\n"
                       "-body_gate_rigid fixed\n-body_ball_shape sphere\n-body_ball_center 1.3,0.7\n-body_ball_radius 0.15\n-body_ball_rigid free\n-body_ball_rho 2000\n".replace("-damping", "# -damping"))
    text = check.content(gate).decode().replace("-damping_time 0.1\n", "").replace("-cohesion 5e3", "-cohesion 10")
    check.write("gate.opts", text)
    check.need((first := check.scene_in(gate, "gate", "-history_energy")).good, first.said[-500:])
    held, _ = go(gate, "gate", "the gate stays", "-history_energy", ways=(1,))
    said, rows = go(gate, "gate", "gate, lid and ball leave", "-remove", "gate,ball,lid", "-history_energy", "-time_end", 0.12)
    k = np.searchsorted(rows["time"], 0.0401)
    size = rows["kinetic_energy"].max() + abs(rows["external_work"]).max()
    check.that(said.digest != held.digest and rows["rigid_kinetic_energy"][k - 1] > 0 and rows["rigid_kinetic_energy"][k] == 0, "the soil is let go, and the ball is gone")
    jump = abs(np.diff(rows["energy_integration"] + rows["energy_lag"]))  # the lag of what leaves goes to integration
    check.that(jump[k - 1] < 3 * max(jump[k - 2], jump[k]) + 1e-6 * size, f"the terms close: integration changes by {jump[k - 1]:.2e} J as they leave, by {jump[k - 2]:.2e} before and {jump[k]:.2e} after")
    total = check.scene_in(SOIL.replace("soil.opts", "block.opts"), "total", "-restart_file", sorted(glob.glob("static/block-checkpoint-*.h5"))[0], "-method_frame", "total", "-gravity", "0,-9.81", "-remove", "ball")
    check.that(total.status == 2 and "-remove does not apply in the total frame" in total.err, total.err.strip())


def refused():
    """What may not change is refused by name; what particles would need and do not have, too."""
    for more, words in ((["-grid_upper", "1.65,1"], "-grid_upper"), (["-body_soil_upper", "0.8,0.5"], "-body_soil_upper"), (["-body_soil_ppc", "3,3"], "-body_soil_ppc"),
                        (["-material_soil_rho", 1900], "-material_soil_rho"), (["-method_preset", "accurate"], "-method_preset"), (["-method_rim", "whole"], "-method_rim"),
                        (["-bc_xmax_type", "piston", "-bc_xmax_velocity", "0"], "cannot become or cease to be periodic or a piston"),
                        (["-geometry", "axisymmetric"], "-geometry"), (["-body_soil_velocity", "1,0"], "-body_soil_velocity"), (["-history_bodies", "all"], "-history_bodies")):
        told = check.scene_in(SOIL, "first", *GO, *more)
        check.that(told.status == 2 and len(told.lines) == 1 and words in told.err and "it may not change" in told.err, f"{' '.join(map(str, more))}: {told.err.strip()}")
    told = check.scene_in(SOIL, "first", *GO, "-contact_mu", 0.3)
    check.that(told.status == 2 and "contact between bodies cannot begin or end" in told.err, told.err.strip())
    metal = ["-material_soil_model", "vonmises", "-material_soil_yield", 1e4, "-method_locking", "none", "-output_format", "none"]
    bare = check.write("metal.opts", "".join(line for line in open(SOIL) if "friction" not in line and "cohesion" not in line and "output_every" not in line and "_model" not in line))
    check.need(check.scene_in(bare, "bare", *metal).good, "a metal without F")
    told = check.scene_in(bare, "bare", *GO, *metal, "-bc_ymin_type", "separate")
    check.that(told.status and "its particles have no F" in told.err, told.err.strip())


acts()
dt()
balance()
columns()
static()
leaves()
refused()
check.end()
