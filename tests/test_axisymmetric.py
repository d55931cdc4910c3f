"""Bodies of revolution (-geometry axisymmetric) against what is exact: a uniform expansion with every basis, update and
transfer; the mass of balls and of lattices that do not fit; breathing cylinders and balls; a rod under a piston, with the
forces of a full turn; thick tube and sphere under pressure; a plane far from the axis; the energy. The same bits on any number
of processes, in the pool, after a restart and after steps that were undone. Both frames. verify_axisymmetric.py goes further.

usage: test_axisymmetric.py PEBBLE SOURCE MPIEXEC [PART...]   (parts: the functions check_<part>; default: all)
"""
import itertools
import math

import numpy as np

import check
from setups_axisymmetric import MODES, TOTAL, breathing, contact_time, impact, lame, round_scene, run_scene

parts = check.arguments(__doc__, None)
BASES = ("linear", "gimp", "bspline2", "bspline3")
METHODS = list(itertools.product(("usl", "musl", "usf"), ("flip", "apic", "aflip", "xpic", "afmpm")))


def method(basis, update, transfer):
    return {"method_basis": basis, "method_update": update, "method_transfer": transfer}


def expansion(way, steps, stiff):
    """v_r = r in a cylinder from the axis on: what is wrong with F and v of the particles within a third of its radius."""
    scene = round_scene(grid_upper="4,1", grid_h="0.125,0.125", body_b_upper="3,1", bc_ymin_type="slip", bc_ymax_type="slip",
                        body_b_velocity="x,0", material_m_E=stiff, dt_size="1e-4", time_end=1, time_max_steps=steps, **way)
    run_scene("expansion", scene)
    found = check.particles("expansion.h5", -1, ("x", "v", "F"))
    near = found["x"][:, 0] < 1
    F, x = found["F"][near].reshape(-1, 9), found["x"][near, 0] / (1 + steps * 1e-4)
    return max(abs(F[:, [0, 8]] - 1 - steps * 1e-4).max(), abs(found["v"][near, 0] / x - 1).max() * 1e-4)


def check_expansion():
    """F11 = F33 = 1 + t of soft matter; and of stiff matter too, since a uniform stress is in balance but at the rim, as far as
    the particles fill the body, which they do to (1 + t)^2."""
    worst = max(((expansion(method(basis, *way), 1, 1), basis, way) for basis in BASES for way in (METHODS if basis == "bspline2" else METHODS[::4])))
    check.that(worst[0] < 1e-11, f"expansion: F and v after a step to {worst[0]:.1e} ({worst[1]}, {' '.join(worst[2])})")
    for basis, update in itertools.product(("gimp", "bspline2", "bspline3"), ("usl", "musl")):
        found = expansion(method(basis, update, "flip"), 4, 1e6)
        check.that(found < 1e-9, f"expansion: F and v after 4 steps of {basis}, {update}, to {found:.1e}")
    ways = [{"method_basis": basis, "body_b_offset": f"{offset},0"} for basis in BASES for offset in (0, 0.03)]
    ways += [{"method_mass_order": 1}, {"method_mass_order": 3}, {"method_locking": "fbar"}, {"method_damping_rate": 0.25}, {"material_m_model": "elastic"}]
    worst = max((expansion({**TOTAL, **way}, 4, 1e6), str(way)) for way in ways)
    check.that(worst[0] < 1e-12, f"expansion: F and v after 4 steps of the total frame to {worst[0]:.1e} ({worst[1]})")


def check_masses():
    """Mass of full turns, whatever the offset of the lattice: that of rings about its places, but for what is left out on the
    axis, less than a tenth of the square of a cell."""
    b, h = 1 / 16, 1 / 8
    for basis, offset in itertools.product(BASES, (0, 0.3, 0.5, 0.8)):
        run_scene("mass", round_scene(body_b_offset=f"{offset * b},0", time_max_steps=0, **method(basis, "usl", "flip")))
        mass = check.history("mass.csv")["mass"][0] / (1000 * math.pi)
        places = (np.arange(40) + 0.5 + offset) * b
        area = (places[places < 1][-1] + 0.5 * b)**2
        check.that(abs(mass - area) < 0.1 * h**2, f"mass of a cylinder, {basis}, offset {offset} spacings: {mass / area:.6f} of the exact one")
    run_scene("mass", round_scene(grid_lower="0,-1", grid_h="0.03125,0.03125", body_b_shape="sphere", body_b_center="0,0",
                                  body_b_radius=0.75, body_b_lower=None, body_b_upper=None, time_max_steps=0))
    mass = check.history("mass.csv")["mass"][0] / (1000 * 4 / 3 * math.pi * 0.75**3)
    check.that(abs(mass - 1) < 2e-3, f"mass of a ball: {mass:.5f} of the exact one")
    for (radius, exact, most), way in itertools.product(((0, 4 / 3 * 0.4, 8e-3), (1, 2 * math.pi, 1e-3)), ({"method_rim": "cut"}, {**TOTAL, "body_b_offset": "0.02,0.01"})):
        run_scene("mass", round_scene(body_b_shape="sphere", body_b_center=f"{radius},1", body_b_radius=0.4, body_b_lower=None, body_b_upper=None, time_max_steps=0, **way))
        mass = check.history("mass.csv")["mass"][0] / (1000 * math.pi * 0.4**2 * exact)
        check.that(abs(mass - 1) < most, f"mass of a {'ring' if radius else 'ball'} with cut places, {way}: {mass:.6f} of the exact one")


def check_modes():
    for (shape, nu), k in MODES.items():
        for frame, most in (({}, 0.01), (TOTAL, 0.001)):
            off, energy, rest = breathing(shape, nu, 16, **frame)
            check.that(abs(off) < most, f"breathing {shape}, nu {nu}, {frame}: frequency {100 * off:+.3f} % off k R = {k}, 16 cells")
            check.that(abs(energy - 1) < 0.03, f"breathing {shape}, nu {nu}, {frame}: energy {energy:.4f} of the start after 3 periods")


def check_energy():
    """What remains of the balance falls with dt, also with plastic flow and F-bar."""
    plastic = {"material_m_model": "vonmises", "material_m_yield": 2e4, "method_locking": "fbar"}
    for what, more in itertools.product((method("bspline2", "musl", "flip"), TOTAL), ({}, {"method_locking": "fbar"}, plastic)):
        left = []
        for dt in (4e-4, 1e-4):
            run_scene("energy", round_scene(grid_upper="2,1.5", body_b_upper="1,1", body_b_velocity="2*x*(1-x/2),-y", bc_ymin_type="slip",
                                            dt_size=dt, time_end=0.04, history_energy="true", **what, **more))
            rows = check.history("energy.csv")
            left.append(abs(rows["energy_integration"]).max() / rows["total_energy"].max())
        check.that(left[1] < 0.4 * left[0] and left[1] < 0.01, f"energy, {what}, {more}: {left[0]:.2e} and {left[1]:.2e} of it remain at dt and dt/4")


def check_piston():
    """A rod is pressed by a smooth plane, and is free to grow wider: its stress, and the force of the full section, also where
    the lattice of particles does not fit and places are cut."""
    lam, mu, stretch, wide = 1e6 * 0.3 / (1.3 * 0.4), 1e6 / 2.6, 0.975, 1.0
    for _ in range(50):
        wide -= (lam * math.log(wide**2 * stretch) + mu * (wide**2 - 1)) / (2 * lam / wide + 2 * mu * wide)
    J = wide**2 * stretch
    force = (lam * math.log(J) + mu * (stretch**2 - 1)) / J * math.pi * wide**2
    for offset in (0, 0.5):
        run_scene("piston", round_scene(grid_upper="1.5,2.5", body_b_upper="1,2", bc_ymin_type="slip", bc_ymax_type="piston",
                                        bc_ymax_distance=0.5, bc_ymax_velocity='"-0.05*(1-cos(2*pi*min(t,1)))"', damping_time=0.02,
                                        history_walls="ymin,ymax", time_end=1.5, body_b_offset=f"{offset / 16},0"))
        rows = check.history("piston.csv")
        found = check.particles("piston.h5", -1, ("x", "F"))
        F = found["F"].reshape(-1, 9)
        up, down = rows["reaction_ymax_y"][-1] / force, -rows["reaction_ymin_y"][-1] / force
        check.that(abs(up - 1) < 1e-3 and abs(down - 1) < 1e-3, f"rod under a piston, offset {offset}: forces {up:.5f} and {down:.5f} of the exact one")
        check.that(abs(F[:, 0] / wide - 1).max() < 2e-4 and abs(F[:, 8] / wide - 1).max() < 2e-4, f"rod under a piston: it grows wider by {F[:, 8].mean():.5f}, exactly {wide:.5f}")


def check_lame():
    for shape, frame, allowed in (("tube", {}, 0.006), ("sphere", {}, 0.04), ("tube", TOTAL, 0.004), ("sphere", TOTAL, 0.02)):
        for radius, found, exact in lame(shape, 8, **frame):
            check.that(abs(found / exact - 1) < allowed, f"{shape} under pressure, {frame}: u({radius}) = {found:.4e}, exactly {exact:.4e}")


def check_water():
    """Water in a round tank: the pressure is right on the axis too, and the foot carries all."""
    told = run_scene("water", round_scene(grid_upper="1,1.5", bc_xmax_type="slip", bc_ymin_type="slip", material_m_model="fluid", material_m_E=None,
                                   material_m_nu=None, material_m_K=2e6, acceleration='"0,-9.81*min(t/0.5,1)"', time_end=3, damping_time=0.1,
                                   history_walls="ymin"))
    check.that("the volumes of m are not relaxed, with -geometry axisymmetric" in told.said, "water in a round tank: a note on its level")
    found = check.particles("water.h5", -1, ("x", "stress"))
    x, p = found["x"], -found["stress"].reshape(-1, 9)[:, 8]
    off = abs(p - 9810 * (1 - x[:, 1])) / 9810
    rows = check.history("water.csv")
    force = rows["reaction_ymin_y"][-1] / (9.81 * rows["mass"][0])
    check.that(off.max() < 0.04 and off[x[:, 0] < 0.125].max() < 0.02,
               f"water in a round tank: pressure to {off.max():.4f} of that at the foot, on the axis to {off[x[:, 0] < 0.125].max():.4f}")
    check.that(abs(force - 1) < 1e-4, f"water in a round tank: force on the foot {force:.6f} of the weight")


def check_ground():
    """What starts with the stress due to its weight has the horizontal one around the axis too, and rests as in a plane."""
    soil = {"material_m_model": "druckerprager", "material_m_rho": 2000, "material_m_friction_angle": 30}
    laws = {"elastic": {"material_m_model": "elastic"}, "neohookean": {"material_m_k0": 0.7}, "soil": soil, "soil, gimp": {**soil, **method("gimp", "musl", "flip")},
            "fluid": {"material_m_model": "fluid", "material_m_E": None, "material_m_nu": None, "material_m_K": 2e6},
            "formula": {"initial_stress": '"-9e3*(1-y),0,-9810*(1-y),-9e3*(1-y)"'}}
    ratios = dict(zip(laws, (0.3 / 0.7, 0.7, 0.5, 0.5, 1, 9 / 9.81)))
    for law, more in laws.items():
        lines = round_scene(**{"grid_upper": "1,1.5", "bc_xmax_type": "slip", "bc_ymin_type": "slip", "gravity": "0,-9.81", "material_m_E": 1e7, "initial_stress": "k0",
                               "time_end": 0.1, **more})
        moved = []
        for place in ({"geometry": "plane_strain", "bc_xmin_type": "slip"}, {}):
            if law != "formula" or not place:
                runs = [run_scene("ground", {**lines, **place}, n=n).digest for n in (1, 3)]
                start, end = (check.particles("ground.h5", which, ("x", "stress")) for which in (0, -1))
                moved.append(abs(end["x"] - start["x"]).max())
        stress = start["stress"].reshape(-1, 9)
        off = abs(stress[:, [0, 8]] / stress[:, [4]] / ratios[law] - 1).max()
        check.that(off < 5e-3 and runs[0] == runs[1], f"ground, {law}: horizontal stress and that around the axis to {off:.1e}, one digest")
        check.that(moved[-1] < 1e-12 if "gimp" in law else moved[-1] < 1e-5 if law == "formula" else moved[1] < (100 if law == "fluid" else 3) * moved[0],
                   f"ground, {law}: it moves by {moved[-1]:.1e} m, in a plane by {moved[0]:.1e} m")
    told = run_scene("ground", {**lines, **TOTAL}, must=False)
    check.that("-initial_stress does not apply with -method_frame total: particles are undeformed at the start" in told.said, "ground: not in the total frame")


def check_plane():
    """Far from the axis it is plane strain: a block that hits a wall with friction, with every transfer."""
    ways = [method("bspline2", update, transfer) for update, transfer in (("usl", "aflip"), ("musl", "flip"), ("usf", "xpic"), ("musl", "afmpm"))]
    hits = {"body_b_velocity": "1,-2", "bc_ymin_type": "friction", "bc_ymin_mu": 0.3}
    held = {"body_b_velocity": '"1-2*y,sin(3*y)"', "bc_ymin_type": "fixed", "body_b_shape": "polygon"}
    for way in [{**hits, **way} for way in ways] + [{**held, **TOTAL}]:
        places = []
        for far, geometry in ((0, "plane_strain"), (1e5, "axisymmetric")):
            box = {"body_b_lower": f"{far + 0.5},0.25", "body_b_upper": f"{far + 1.5},1"}
            if "body_b_shape" in way:
                box = {"body_b_lower": None, "body_b_upper": None, "body_b_vertices": f"{far + 0.513},0,{far + 1.487},0,{far + 1.187},0.91"}
            run_scene("plane", round_scene(geometry=geometry, grid_lower=f"{far},0", grid_upper=f"{far + 2},2", time_end=0.05, **{**way, **box}))
            places.append(check.particles("plane.h5", -1, ("x",))["x"][:, :2] - [far, 0])
        off = abs(places[1] - places[0]).max()
        check.that(off < 2e-5, f"far from the axis, {way}: places differ from plane strain by {off:.1e} m")


def check_meets():
    """Bodies that meet: an elastic ball strikes a rigid plate (Hertz), and another one like it, as if the plate were between them; a
    rigid ball has the mass of its solid, and gives an elastic one what it loses; a rod under a rough rigid plate keeps its foot's width."""
    rows, time, force = impact(16, dt_size=1e-3)
    found, took = rows["reaction_r_y"], contact_time(rows, rows["reaction_r_y"])
    given = (found[1:] * np.diff(rows["time"])).sum() / (rows["momentum_y"][-1] - rows["momentum_y"][0])
    check.that(abs(took / time - 1) < 0.08 and abs(found.max() / force - 1) < 0.08 and rows["momentum_y"][-1] > -0.95 * rows["momentum_y"][0],
               f"ball on a rigid plate, 16 cells: {took / time:.3f} of the time and {found.max() / force:.3f} of the force of Hertz")
    check.that(abs(given - 1) < 1e-12, f"ball on a rigid plate: its reactions are the change of momentum to {abs(given - 1):.0e}")
    twin = {"body_c_shape": "sphere", "body_c_center": f"0,{-1 - 0.05 / 16}", "body_c_radius": 1, "body_c_material": "m", "body_c_velocity": "0,0.1", "contact_mu": 0.2}
    both, *_ = impact(16, **{"dt_size": 1e-3, "grid_lower": "0,-2.25", "bodies": "b,c", "body_r_shape": None, "body_r_lower": None, "body_r_upper": None, "body_r_rigid": None,
                             "history_bodies": "b,c", **twin})
    one, other = both["momentum_b_y"], both["momentum_c_y"]
    check.that(abs(one + other).max() < 1e-12 * abs(one[0]) and abs(one[-1] - rows["momentum_y"][-1]) < 0.01 * abs(one[0]),
               f"two balls: {-one[-1] / one[0]:.4f} of their speed is left, of one on a plate {-rows['momentum_y'][-1] / rows['momentum_y'][0]:.4f}")
    free = {"grid_lower": "0,-2.25", "body_r_shape": "sphere", "body_r_center": twin["body_c_center"], "body_r_radius": 1, "body_r_lower": None, "body_r_upper": None,
            "body_r_rigid": "free", "body_r_rho": 3000}
    rows, *_ = impact(16, **free)
    mass = 2 * rows["rigid_kinetic_energy"][-1] / rows["velocity_r_y"][-1]**2
    change = rows["momentum_y"] - rows["momentum_y"][0] + mass * rows["velocity_r_y"]
    check.that(abs(mass / (4000 * math.pi) - 1) < 1e-4 and abs(change).max() < 1e-12 * mass, f"rigid ball: {mass / (4000 * math.pi):.6f} of its mass, momentum to {abs(change).max() / mass:.0e} m/s")
    press = {"grid_upper": "2,3", "body_b_upper": "1,2", "bodies": "b,r", "bc_ymin_type": "slip", "body_r_shape": "box", "body_r_lower": "0,2", "body_r_upper": "1.5,3",
             "body_r_rigid": "moving", "body_r_velocity": '"0,-0.05*(1-cos(2*pi*min(t,1)))"', "damping_time": 0.02, "history_bodies": "r", "history_walls": "ymin", "time_end": 1.2}
    for mu in (0, 1):
        run_scene("press", round_scene(**press, body_r_mu=mu))
        rows = check.history("press.csv")
        up, down = rows["reaction_r_y"][-1], -rows["reaction_ymin_y"][-1]
        start, end = (check.particles("press.h5", which, ("x",))["x"] for which in (0, -1))
        top = start[:, 1] > 2 - 0.0625
        wide = (end[top, 0] / start[top, 0]).max()
        check.that(abs(up / down - 1) < 1e-4 and (abs(wide - 1.0076) < 1e-3 if mu == 0 else wide < 1.002),
                   f"rod under a rigid plate, friction {mu}: {up:.5g} and {down:.5g} N, its top is {wide:.5f} times as wide")
    wrong = run_scene("aside", round_scene(**{**press, "body_r_velocity": '"0.1*max(0,t-0.01),-0.05"'}), must=False)
    check.that(wrong.status == 3 and "-body_r_velocity has" in wrong.said and "along x at t = 0.0" in wrong.said, "a plate on the axis that begins to move along the radius stops the run")


def check_bits_meets():
    """Digests where bodies meet: a rigid ball falls on a block that lies on another one, with friction."""
    lines = round_scene(grid_upper="2,3", body_b_upper="1.25,0.75", bodies="b,c,r", body_c_shape="box", body_c_lower="0,0.75", body_c_upper="1,1.25", body_c_material="m",
                        contact_mu=0.3, bc_ymin_type="separate", body_r_shape="sphere", body_r_center="0,1.77", body_r_radius=0.5, body_r_rigid="free", body_r_rho=2000, body_r_mu=0.2,
                        body_r_velocity="0,-4", gravity="0,-10", history_bodies="all", history_energy="true", time_end=0.1)
    digests = {str(n): run_scene("bits", lines, n=n).digest for n in (1, 2, 3)}
    digests["pool"] = run_scene("bits", {**lines, "parallel_strategy": "pool", "pool_cells": "8"}, n=3).digest
    steps = int(check.history("bits.csv")["step"][-1])
    run_scene("bits", {**lines, "time_max_steps": steps // 2, "checkpoint_every": 1e9})
    digests["restart"] = run_scene("bits", {**lines, "restart_file": "latest", "checkpoint_every": 1e9}, n=2).digest
    check.that(len(set(digests.values())) == 1 and None not in digests.values(), f"bodies that meet: digests {digests}")


def check_bits():
    """Digests on 1 to 4 processes, in the pool, with all fields, and after a restart."""
    scene = dict(grid_upper="1.5,2.5", body_b_upper="1,2", body_b_velocity="x,1-2*y", bc_ymin_type="separate", time_end=0.1,
                 gravity="0,-10", loads="p", load_p_body="b", load_p_type="pressure", load_p_value='"1e4*t"')
    laws = {"neohookean": {}, "vonmises": {"material_m_model": "vonmises", "material_m_yield": 2e4, "method_locking": "fbar"},
            "fluid": {"material_m_model": "fluid", "material_m_E": None, "material_m_nu": None, "material_m_K": 1e6, "material_m_viscosity": 10}}
    ways = {"neohookean": method("gimp", "musl", "aflip"), "vonmises": {}, "fluid": method("linear", "usf", "afmpm")}
    for law, more in laws.items():
        lines = round_scene(**{**scene, **more, **ways[law]})
        digests = {str(n): run_scene("bits", lines, n=n).digest for n in (1, 2, 3, 4)}
        digests["pool"] = run_scene("bits", {**lines, "parallel_strategy": "pool", "pool_cells": "8"}, n=3).digest
        digests["all"] = run_scene("bits", {**lines, "method_carry": "all"}, lanes=2).digest
        steps = int(check.history("bits.csv")["step"][-1])
        run_scene("bits", {**lines, "time_max_steps": steps // 2, "checkpoint_every": 1e9})
        digests["restart"] = run_scene("bits", {**lines, "restart_file": "latest", "checkpoint_every": 1e9}, n=2).digest
        check.that(len(set(digests.values())) == 1 and None not in digests.values(), f"{law}: digests {digests}")


def check_bits_total():
    """The same of the total frame, with a history of walls and energy; and when steps were undone."""
    ball = {"grid_lower": "0,-1.25", "grid_upper": "1.5,1.5", "body_b_shape": "sphere", "body_b_center": "0,0", "body_b_radius": 1, "body_b_lower": None, "body_b_upper": None,
            "loads": "p", "load_p_body": "b", "load_p_type": "pressure", "load_p_value": '"1e4*t"', "acceleration": '"-3*X,-10"'}
    ring = {"grid_lower": "0.5,0", "grid_upper": "2.5,1.5", "body_b_shape": "annulus", "body_b_center": "1.5,0.5", "body_b_inner_radius": 0.2, "body_b_radius": 0.5,
            "body_b_lower": None, "body_b_upper": None, "bc_ymin_type": "fixed", "gravity": "0,-10"}
    metal = {"material_m_model": "vonmises", "material_m_yield": 2e4, "bc_ymin_type": "slip", "bc_ymax_type": "moving", "bc_ymax_velocity": '"0,0-sin(9*t)"', "grid_upper": "1.5,1",
             "damping_time": 0.2}
    for what, more in {"ball": ball, "ring": ring, "metal": metal}.items():
        walls = {"history_walls": "all"} if what != "ball" else {}
        lines = round_scene(**{**TOTAL, "body_b_velocity": "x,1-2*y", "time_end": 0.1, "history_energy": "true", **walls, **more})
        whole = run_scene("bits", lines)
        check.fault(None if what != "metal" or "-method_locking fbar" in whole.out else "metals have no F-bar")
        digests, histories = {"1": whole.digest}, {check.content("bits.csv")}
        for n in (2, 3, 4):
            digests[str(n)] = run_scene("bits", lines, n=n).digest
            histories.add(check.content("bits.csv"))
        digests["pool"] = run_scene("bits", {**lines, "parallel_strategy": "pool", "pool_cells": "8"}, n=3).digest
        histories.add(check.content("bits.csv"))
        digests["solid"] = run_scene("bits", {"method_preset": "solid", **{key: value for key, value in lines.items() if key != "method_frame"}}).digest
        digests["narrow"] = run_scene("bits", lines, lanes=2).digest
        steps = int(check.history("bits.csv")["step"][-1])
        run_scene("bits", {**lines, "time_max_steps": steps // 2, "checkpoint_every": 1e9}, n=3)
        digests["restart"] = run_scene("bits", {**lines, "restart_file": "latest", "checkpoint_every": 1e9}, n=2).digest
        histories.add(check.content("bits.csv"))
        check.that(len(set(digests.values())) == 1 and None not in digests.values() and len(histories) == 1, f"total frame, {what}: one history, digests {digests}")
        undone = [run_scene("bits", {**lines, "check_state": "retry", "dt_cfl": 1.9, "time_max_steps": 20}, n=n) for n in (1, 3)]
        check.that("tries were undone" in undone[0].out and undone[0].digest == undone[1].digest, f"total frame, {what}: retry, one digest")


def check_file():
    check.write("p.csv", "x,y,volume\n0.5,0.5,0.01\n")
    told = run_scene("file", round_scene(body_b_shape="file", body_b_file="p.csv", body_b_lower=None, body_b_upper=None), must=False)
    check.that(told.status == 2 and told.lines == ["file.opts:12: -body_b_shape file does not apply: with -geometry axisymmetric bodies have other shapes"],
               f"particles from a file: {told.lines}")


for part in parts or [name[6:] for name in list(globals()) if name.startswith("check_")]:
    globals()["check_" + part]()
check.end()
