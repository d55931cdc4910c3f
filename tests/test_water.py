"""Water and sand whose volumes relax, with the default settings: what a splash leaves is water again, what rests stays at rest.

usage: test_water.py PEBBLE SOURCE MPIEXEC [WORDS]

WORDS: some, jet, footing, rest, rest_others, bits; most: each scene on 40 cells in a metre and in 3-D, and each preset, by turns; or all [CELLS...]:
each scene with all presets on grids of so many cells, and in 3-D; with 80 cells only balanced.
"""
import glob
import math
import os
import re

import numpy as np

import check

RHO, G = 1000, 9.81
words = check.arguments(__doc__, None)


def tank(cells, walls, *parts, size=(1, 1), K=1e6, g=G):
    """Water in a closed tank; the lines of an options file."""
    dim, text = len(size), lambda values: ",".join(f"{v:.12g}" for v in values)
    return [f"-dim {dim}", "-grid_lower " + text([0] * dim), "-grid_upper " + text(size), "-grid_h " + text([1 / cells] * dim), "-gravity " + text([0] * (dim - 1) + [-g]),
            *(f"-bc_{axis}{side}_type {walls}" for axis in "xyz"[:dim] for side in ("min", "max")), "-materials m", "-material_m_model fluid", f"-material_m_rho {RHO}",
            f"-material_m_K {K}", "-bodies b", "-body_b_material m", *parts, "-history_bodies b", "-history_body_quantities center", "-history_every 0.02"]


def box(lower, upper):
    text = lambda values: ",".join(f"{v:.12g}" for v in values)
    return ["-body_b_shape box", "-body_b_lower " + text(lower), "-body_b_upper " + text(upper)]


# Lines of a scene on so many cells; gravity; area or volume of the water, its depth at rest, and that area's floor; the time at
# which the run ends, and the time constant of the damping after it (of the second run, of 3 s), or of the whole run.
SCENES = {
    "dam break, closed": (lambda n: tank(n, "slip", *box([0, 0], [0.4, 0.8]), K=2e6), G, 0.32, 1, 3, 0.3),
    "dam break": (lambda n: tank(n, "separate", *box([0, 0], [0.4, 0.8])), G, 0.32, 1, 2.5, 0.3),
    "drop": (lambda n: tank(n, "separate", *box([0.25, 0.3], [0.75, 0.7]), g=10), 10, 0.2, 1, 6, None),
    "dam break, 3-D": (lambda n: tank(n, "separate", *box([0, 0, 0], [0.4, 0.4, 0.5]), size=(1, 0.4, 0.6)), G, 0.08, 0.4, 2, 0.3),
}


def probes(h, size):
    """Places of probes, a cell above the floor."""
    at = [[x * size[0], *(0.5 * s for s in size[1:-1]), h] for x in (0.15, 0.3, 0.5, 0.7, 0.85)]
    names = [f"p{k}" for k in range(len(at))]
    return at, ["-probes " + ",".join(names), *(f"-probe_{name}_at " + ",".join(f"{v:.12g}" for v in x) for name, x in zip(names, at)),
                *(f"-probe_{name}_fields stress" for name in names)]


def splash(scene, cells, *options, longest=1.0):
    """Runs a scene until it is at rest and checks what water then has to be."""
    lines, g, volume, floor, end, damped = SCENES[scene][0](cells), *SCENES[scene][1:]
    dim, h, depth = 3 if "3-D" in scene else 2, 1 / cells, volume / floor
    size = [float(v) for v in lines[2].split()[1].split(",")]
    at, more = probes(h, size)
    name = f"{scene}, {cells} cells{', ' if options else ''}{' '.join(options)}"
    path = check.write("splash.opts", lines + more)
    words = ["-options_file", path, "-output_dir", ".", "-output_name", "splash", "-report_indicator", "false", *options]
    if damped:
        told = check.pebble(*words, "-time_end", end, "-output_format", "none", "-checkpoint_every", end, timeout=3000)
        if told.good:
            told = check.pebble(*words, "-time_end", end + 3 * longest, "-damping_time", damped, "-restart_file", "latest", "-output_every", 100, timeout=3000)
    else:
        told = check.pebble(*words, "-time_end", end * longest, "-damping_time", 0.5, "-output_every", 100, timeout=3000)
    if not told.good:
        return check.that(False, f"{name}: {told.err.strip()[-250:]}")
    found, rest = check.history("splash.csv"), check.particles("splash.h5")
    left = found["total_energy"] - found["external_work"]
    grown = (left - np.minimum.accumulate(left)).max() / abs(found["external_work"]).max()
    level = 2 * found[f"center_b_{'xyz'[dim - 1]}"][-1]
    p = -rest["stress"].reshape(len(rest["stress"]), -1)[:, [0, 4, 8]].mean(1)
    deep = rest["x"][:, dim - 1] < depth - 1.5 * h
    dead, space = (p[deep] <= 0).mean(), rest["volume"].sum() / volume
    x, up = rest["x"], rest["x"][:, dim - 1]
    near = [(np.abs(x[:, :dim] - np.array(place)) < 1.5 * h).all(1) for place in at]
    mean = max([(p / (RHO * g) + up)[k].mean() / depth - 1 for k in near], key=abs)
    last = max([-np.mean([found[f"probe_p{k}_stress_{c}"][-1] for c in ("xx", "yy", "zz")]) / (RHO * g * (depth - h)) - 1 for k in range(len(at))], key=abs)
    # what flip keeps of the noise of velocities, and so of pressure, is more (docs/choosing.md)
    flips = "fast" in name or "energy" in name
    check.that(grown < (6e-3 if flips else 1e-3) and abs(level - depth) < max(0.01 * depth, h / 20) and abs(space - 1) < 0.01 and dead <= 0.02 and abs(mean) < (0.05 if flips else 0.03),
               f"{name}: level {level:.4f} of {depth:.4f} ({(level / depth - 1) * 100:+.2f} %), volumes {space:.4f}, without pressure {dead:.3f}, pressure near the floor {mean * 100:+.1f} % (probes, whose particles are not at their height: {last * 100:+.1f} %), growth of energy {grown:.1e}")


def level_of(words, name):
    """Twice the height of the centre at the end over that at the start, and the largest kinetic energy in the strain energy."""
    check.must(*words, "-output_dir", ".", "-output_name", name, "-report_indicator", "false", "-output_format", "none")
    h = check.history(name + ".csv")
    return h["center_b_y"][-1] / h["center_b_y"][0], h["kinetic_energy"].max() / h["strain_energy"][0]


def check_rest(others):
    """What starts at rest stays at rest as without relaxation, for any basis, height and number of particles."""
    methods = ("", "-method_preset fast", "-method_preset accurate", "-method_preset energy", "-method_basis linear", "-method_basis gimp -method_gimp_update none", "-body_b_ppc 3,3",
               "-bc_ymin_type separate", "-bc_xmin_type periodic -bc_xmax_type periodic", "-material_m_eos tait -material_m_tait_gamma 7")
    for upper, some in ((0.487, methods[1::2]), (0.5, methods)) if others else ((0.487, methods[::2]),):
        path = check.write("still.opts", [*tank(20, "slip", *box([0, 0], [1, upper])), "-initial_stress k0", "-time_end 2"])
        for more in some:
            words = ["-options_file", path, *more.split()]
            (level, moves), (plain, moved) = level_of(words, "still"), level_of([*words, "-material_m_relaxation", 0], "plain")
            cut = upper * 40 % 1 > 0  # the uppermost particles lie off the lattice: the density that the grid sees is a little off there
            check.that(abs(level - 1) < (2e-4 if cut else 2e-5) + 2 * abs(plain - 1) and moves < (3e-5 if cut else 1e-5) + 3 * moved,
                       f"water at rest, {upper} m deep, {more}: level {level - 1:+.1e}, kinetic energy {moves:.0e} of the strain energy; without relaxation {plain - 1:+.1e}, {moved:.0e}")


def check_layers():
    """A light fluid on a heavy one: they stay where they are, and the pressure is continuous."""
    lines = ["-dim 2", "-grid_lower 0,0", "-grid_upper 1,1", "-grid_h 0.05,0.05", f"-gravity 0,-{G}", *(f"-bc_{face}_type slip" for face in ("xmin", "xmax", "ymin", "ymax")), "-materials oil,water",
             "-material_oil_model fluid", "-material_oil_rho 800", "-material_oil_K 4e6", "-material_water_model fluid", "-material_water_rho 1000", "-material_water_K 1e6", "-bodies a,b",
             *(line.replace("body_b", "body_a") for line in box([0, 0.3], [1, 0.6])), "-body_a_material oil", *box([0, 0], [1, 0.3]), "-body_b_material water", "-initial_stress k0", "-time_end 3", "-output_every 3"]
    check.must("-options_file", check.write("layers.opts", lines), "-output_dir", ".", "-report_indicator", "false")
    start, end = check.particles("layers.h5", 0), check.particles("layers.h5")
    y, right = end["x"][:, 1], lambda y: G * np.where(y > 0.3, 800 * (0.6 - y), 240 + 1000 * (0.3 - y))
    p, deep = -end["stress"].reshape(len(y), -1)[:, [0, 4, 8]].mean(1), y < 0.5
    off, moved = math.sqrt(((p - right(y))[deep]**2).mean()) / right(0), np.abs(end["x"] - start["x"]).max() / 0.05
    check.that(off < 0.01 and moved < 0.05, f"two fluids at rest: pressure is {off:.4f} of that at the floor off, particles move by {moved:.4f} cells")


def wave(*more):
    """What is left of the energy of a standing wave of sound, of 40 cells, after five periods."""
    lines = ["-dim 2", "-grid_lower 0,0", "-grid_upper 1,0.1", "-grid_h 0.025,0.025", *(f"-bc_{face}_type periodic" for face in ("xmin", "xmax", "ymin", "ymax")), "-materials m", "-material_m_model fluid",
             f"-material_m_rho {RHO}", "-material_m_K 1e6", "-material_m_tension_cutoff inf", "-bodies b", "-body_b_material m", *box([0, 0], [1, 0.1]), '-body_b_velocity "0.01*sin(2*pi*x),0"',
             f"-time_end {5 / math.sqrt(1000):.12g}"]
    told = check.must("-options_file", check.write("wave.opts", lines), "-output_dir", ".", "-output_format", "none", *more)
    energy = check.history("wave.csv")["total_energy"]
    return energy[-1] / energy[0], told.digest


def check_sound():
    """With relaxation 0 the law is the plain one, as it is where basis, update and transfer are given; with 1 sound is damped."""
    given = "-method_basis bspline3 -method_update usl -method_transfer aflip -method_affine_strain 1 -dt_cfl 0.4".split()
    (none, _), (left, _), (_, same), (_, other) = wave("-material_m_relaxation", 0), wave(), wave(*given), wave(*given, "-material_m_relaxation", 0)
    check.that(same == other and 0.95 < none < 1.001 and 0.1 < left < 0.9 * none, f"sound over 5 periods of 40 cells keeps {none:.3f} of its energy, {left:.3f} with relaxation; digests {same}, {other} without")


def check_footing():
    """A rigid rough footing pressed 0.1 m into sand keeps its load: what opens beside it takes nothing from what is pressed."""
    lines = ["-dim 2", "-grid_lower 0,0", "-grid_upper 6,3", "-grid_h 0.25,0.25", f"-gravity 0,-{G}", "-bc_xmin_type slip", "-bc_xmax_type slip", "-bc_ymin_type fixed", "-materials m", "-material_m_model druckerprager",
             "-material_m_rho 1700", "-material_m_E 5e7", "-material_m_nu 0.3", "-material_m_friction_angle 30", "-material_m_fit plane_strain", "-bodies foot,b", "-body_foot_shape box", "-body_foot_lower 0,2.5",
             "-body_foot_upper 1,3", "-body_foot_rigid moving", "-body_foot_mu 0.6", '-body_foot_velocity "0,-0.05*min(t/0.2,1)"', "-body_b_material m", *box([0, 0], [6, 2.5]), "-initial_stress k0", "-history_bodies foot",
             "-history_every 0.02", "-time_end 2"]
    words = ["-options_file", check.write("footing.opts", lines), "-output_dir", ".", "-output_name", "footing", "-output_format", "none", "-report_indicator", "false"]
    loads = []
    for more in ([], ["-material_m_relaxation", 0]):
        check.must(*words, *more)
        loads.append(-2 * check.history("footing.csv")["reaction_foot_y"][-26:].mean() / (0.5 * 1700 * G * 4))
    check.that(loads[0] > 0.85 * loads[1] > 6, f"a footing on sand: N_gamma {loads[0]:.1f} after 0.1 m, {loads[1]:.1f} without relaxation")


def check_removed():
    """A gate that a stage removes takes no room from the water that then flows through its place: the same bits wherever it was."""
    lines = [*tank(20, "slip", *box([0, 0], [0.3, 0.6]), K=2e6, size=(2, 1)), "-bodies b,gate", "-body_gate_shape box", "-body_gate_rigid fixed", "-body_gate_upper 1.6,0.95",
             "-stages hold,flow", "-stage_hold_time 0.01", "-stage_flow_time 0.25", "-stage_flow_remove gate"]
    lines.remove("-bodies b")
    words = ["-options_file", check.write("removed.opts", lines), "-output_dir", ".", "-output_name", "removed", "-output_format", "none"]
    near, far = (re.findall(r"^digest +(\w+)", check.must(*words, "-body_gate_lower", f"{at},-0.1").out, re.M)[1] for at in (0.5, 1.5))
    check.that(near == far, f"water flows through the place of a gate that has been removed with the digest {near}, elsewhere {far}")


def check_bits():
    """The same bits on any number of processes, in the pool, and after a restart, with volumes that relax."""
    sand = ["-dim 2", "-grid_lower 0,0", "-grid_upper 1,2", "-grid_h 0.1,0.1", f"-gravity 0,-{G}", "-bc_xmin_type slip", "-bc_xmax_type slip", "-bc_ymin_type separate", "-materials m", "-material_m_model druckerprager",
            "-material_m_rho 2000", "-material_m_E 1e6", "-material_m_nu 0.3", "-material_m_friction_angle 31", "-material_m_fit plane_strain", "-bodies b", "-body_b_material m", *box([0, 0], [1, 0.4]),
            '-body_b_velocity "0, 3 + 5*y*sin(4*pi*x)"']
    for name, lines, end in (("water", SCENES["dam break, closed"][0](20), 0.6), ("water, 3-D", SCENES["dam break, 3-D"][0](15), 0.3), ("sand", sand, 0.4)):
        words = ["-options_file", check.write("bits.opts", lines), "-output_dir", ".", "-output_name", "bits", "-output_format", "none", "-report_indicator", "false"]
        words += ["-time_end", end, "-checkpoint_every", end / 2]
        for path in glob.glob("bits-checkpoint-*.h5"):
            os.remove(path)
        runs = {f"{n} {way}": check.pebble(*words, "-parallel_strategy", way, n=n) for n, way in ((1, "spatial"), (2, "spatial"), (3, "spatial"), (3, "pool"))}
        first = min(glob.glob("bits-checkpoint-*.h5"), key=lambda path: int(path.split("-")[-1][:-3]))
        runs["restart"] = check.pebble(*words, "-restart_file", first)
        found = {way: told.digest or told.err[-200:] for way, told in runs.items()}
        off = check.pebble(*words, "-material_m_relaxation", 0).digest
        check.that(len(set(found.values())) == 1 and runs["restart"].good and off not in found.values(), f"the same bits, {name}: {found}, {off} without relaxation")


def check_jet():
    """A plane jet that strikes a wall, one half of it: the force on the wall is rho v^2 b, and six cells off it p + rho v^2/2 is the stagnation
    pressure; nearer to the wall particles clump, and the pressure is not reliable."""
    v, b, h = 2, 0.1, 0.025
    jet = ["-dim 2", "-grid_lower 0,0", "-grid_upper 0.6,0.6", f"-grid_h {h},{h}", "-bc_xmin_type slip", "-bc_ymin_type slip", "-particles_leave delete", "-materials m", "-material_m_model fluid",
           f"-material_m_rho {RHO}", f"-material_m_K {100 * RHO * v * v}", "-bodies b,jet", *box([0, 0], [b, 0.5]), *(line.replace("_b_", "_jet_") for line in box([0, 0.5], [b, 0.6])), "-sources jet", "-source_jet_to 1",
           *(f"-body_{name}_{key} {value}" for name in ("b", "jet") for key, value in (("material", "m"), ("velocity", f"0,{-v}"))), "-probes p", f"-probe_p_at 0,{6 * h}", "-probe_p_fields pressure,velocity",
           "-time_end 0.6", "-history_every 0.002", "-history_walls ymin", "-output_format none"]
    for preset in ("balanced", "fast"):
        check.must("-options_file", check.write("jet.opts", jet), "-output_dir", ".", "-method_preset", preset)
        told = check.history("jet.csv")
        late = told["time"] > 0.25
        head = (told["probe_p_pressure"] + RHO / 2 * (told["probe_p_velocity_x"]**2 + told["probe_p_velocity_y"]**2))[late].mean() / (RHO / 2 * v * v)
        force = told["reaction_ymin_y"][late].mean() / (RHO * v * v * b)
        check.that(abs(force - 1) < 0.03 and abs(head - 1) < 0.05, f"a jet on a wall, {preset}: {force:.3f} of the force, and {head:.3f} of the stagnation pressure six cells off it")


if words[0] == "some":
    for scene in list(SCENES)[:3]:
        splash(scene, 20)
elif words[0] == "jet":
    check_jet()
elif words[0] == "footing":
    check_footing()
elif words[0] == "rest":
    check_rest(False)
    check_layers()
    check_sound()
elif words[0] == "rest_others":
    check_rest(True)
elif words[0] == "bits":
    check_bits()
    check_removed()
elif words[0] == "most":
    flat, deep = list(SCENES)[:3], list(SCENES)[3]
    for preset in ("fast", "accurate", "energy"):
        for scene in flat:
            splash(scene, 20, "-method_preset", preset)
    for scene, preset in [(scene, "balanced") for scene in flat] + list(zip(flat, ("fast", "energy", "accurate"))):
        splash(scene, 40, "-method_preset", preset)
    for preset in ("balanced", "fast"):
        splash(deep, 20, "-method_preset", preset)
elif words[0] == "all":
    for cells in words[1:]:
        for preset in ("balanced", "fast", "accurate", "energy")[:1 if cells == "80" else 4]: # 80 cells take minutes
            for scene in list(SCENES)[:3] if cells != "3-D" else list(SCENES)[3:]:
                splash(scene, int(cells) if cells != "3-D" else 20, "-method_preset", preset)
check.end()
