"""A run in stages has the bits of a chain of restarts by hand, on any number of processes; it has one history and goes on from
any of its checkpoints; what may not change in a stage is refused before the first step.

usage: test_stages.py PEBBLE SOURCE MPIEXEC
"""
import glob
import os
import re
import shutil

import numpy as np

import check

check.arguments(__doc__, 0)

BASE = """\
-dim 2
-gravity 0,-9.81
-grid_lower 0,0
-grid_upper 1.6,1
-grid_h 0.05,0.05
-bc_xmin_type slip
-bc_xmax_type moving
-bc_xmax_velocity 0,0
-bc_ymin_type fixed
-materials soil
-material_soil_model druckerprager
-material_soil_rho 1800
-material_soil_E 2e6
-material_soil_nu 0.3
-material_soil_friction_angle 30
-material_soil_fit plane_strain
-material_soil_cohesion 5e3
-bodies soil,lid,gate
-body_soil_shape box
-body_soil_lower 0,0
-body_soil_upper 0.8,0.6
-body_soil_material soil
-body_lid_shape box
-body_lid_lower 0.1,0.6
-body_lid_upper 0.6,0.8
-body_lid_material soil
-body_gate_shape box
-body_gate_lower 0.8,0
-body_gate_upper 1,0.8
-body_gate_rigid fixed
-history_every 0.004
-output_every 0.03
"""
STAGES = """\
-stages settle,cut,shake
-stage_settle_time 2
-stage_settle_time_rest 1e-2
-stage_settle_damping_kinetic
-stage_cut_time 0.05
-stage_cut_damping_kinetic default
-stage_cut_remove gate,lid
-stage_cut_material_soil_cohesion 10
-stage_shake_time 0.06
-stage_shake_gravity 3,-9.81
-stage_shake_bc_xmax_type slip
-stage_shake_bc_xmax_velocity default
-stage_shake_method_transfer flip
"""
check.write("base.opts", BASE)
check.write("staged.opts", BASE + STAGES)


def digests(told):
    return [line.split()[1] for line in told.out.splitlines() if line.startswith("digest ")]


def without_stage(folder):
    """The history without its column stage, and that column."""
    lines = [line.split(",") for line in check.content(f"{folder}/staged.csv").decode().splitlines()]
    k = lines[0].index("stage")
    return [line[:k] + line[k + 1:] for line in lines], [line[k] for line in lines[1:]]


def by_hand():
    """The chain of restarts, as one would write it."""
    def part(end, *more):
        told = check.pebble("-options_file", "base.opts", "-output_dir", "hand", "-output_name", "staged", "-checkpoint_every", 1e30, "-checkpoint_keep", 10, "-time_end", end, *more)
        check.need(told.good, told.said[-500:])
        return told.digest, float(check.rows("hand/staged.csv")[-1]["time"])
    check.folder("hand")
    cut = ["-remove", "gate,lid", "-material_soil_cohesion", 10, "-restart_file", "latest"]
    first, t = part(2, "-damping_kinetic", "-time_rest", "1e-2")
    second, t = part(f"{t + 0.05:.15g}", *cut)
    text = check.content("base.opts").decode().replace("-bc_xmax_velocity 0,0\n", "")
    check.write("base.opts", text.replace("xmax_type moving", "xmax_type slip"))
    third, t = part(f"{t + 0.06:.15g}", *cut, "-gravity", "3,-9.81", "-method_transfer", "flip")
    check.write("base.opts", BASE)
    return [first, second, third]


def same():
    hand = by_hand()
    whole = check.scene_in("staged.opts", "one")
    check.that(digests(whole) == hand and len(set(hand)) == 3, f"three stages have the digests of restarts by hand: {digests(whole)} {hand}")
    rows, stage = without_stage("one")
    by = [line.split(",") for line in check.content("hand/staged.csv").decode().splitlines()]
    check.that(rows == by, "and their history, each number of it")
    check.that(sorted(set(stage)) == ["1", "2", "3"] and stage == sorted(stage), "with a column stage, which the history by hand does not have")
    snapshots = [os.path.basename(path) for path in sorted(glob.glob("one/staged.snapshots/*.h5"))]
    check.that(snapshots == [os.path.basename(path) for path in sorted(glob.glob("hand/staged.snapshots/*.h5"))] and len(snapshots) > 4, f"and its {len(snapshots)} snapshots")
    for way in (2, 3, "pool"):
        other = check.scene_in("staged.opts", "many", way=way)
        check.that(digests(other) == hand and check.content("many/staged.csv") == check.content("one/staged.csv"), f"the same digests and history on {way}")
    check.that("(-time_rest)" in whole.out and whole.out.count("stage      ") == 3, "each stage is told: " + whole.find("^(stage .*shake.*)$"))
    again = check.pebble("-rerun", "one/staged.h5", "-output_dir", check.folder("rerun"))
    check.that(digests(again) == hand, f"-rerun of the results repeats all stages: {digests(again)} {again.err.strip()}")


def goes_on():
    """A run that ends in any stage goes on from there."""
    whole, csv = digests(check.scene_in("staged.opts", "one")), check.content("one/staged.csv")
    steps = [int(row["step"]) for row in check.rows("one/staged.csv")]
    stage = [row["stage"] for row in check.rows("one/staged.csv")]
    ends = [max(s for s, k in zip(steps, stage) if k == which) for which in "123"]
    for stop in (ends[0] - 20, ends[0] + 10, ends[1], ends[1] + 7):
        check.folder("stop")
        check.scene_in("staged.opts", "stop", "-time_max_steps", stop)
        told = check.scene_in("staged.opts", "stop", "-restart_file", "latest", way=2)
        check.that(digests(told)[-1] == whole[-1] and check.content("stop/staged.csv") == csv, f"stopped at step {stop}, stage {1 + (stop > ends[0]) + (stop > ends[1])}: the same end {told.err.strip()}")
    done = check.scene_in("staged.opts", "stop", "-restart_file", "latest")
    check.that(digests(done) == whole[-1:] and check.content("stop/staged.csv") == csv, "a run that has ended has nothing to do")
    alone = check.pebble("-options_file", "base.opts", "-output_dir", "hand", "-output_name", "staged", "-restart_file", "hand/staged-checkpoint-1.h5", "-time_end", 2)
    staged = check.scene_in("staged.opts", "hand", "-restart_file", "hand/staged-checkpoint-1.h5")
    check.that(alone.good and staged.status == 2 and "is of no stage of this run" in staged.err, staged.err.strip())
    shutil.copy(sorted(glob.glob("one/staged-checkpoint-*.h5"))[-1], "last.h5")
    after = check.pebble("-options_file", "base.opts", "-output_dir", "after", "-restart_file", "last.h5", "-time_end", 2, "-remove", "gate,lid", "-material_soil_cohesion", 10,
                         "-gravity", "3,-9.81", "-method_transfer", "flip", "-time_max_steps", ends[2] + 5)
    check.that(after.good and "changed options" in after.out and "gravity" not in after.find("^restart +changed options: (.*)$"), "a run without stages goes on from the last one, and knows its options")


def checked():
    """Faults of any stage are told before the first step."""
    for add, words in (("-stage_cut_grid_h 0.1,0.1", "-stage_cut_grid_h: -grid_h may not change in a stage"), ("-stage_cut_output_name x", "-stage_cut_output_name: -output_name may not change in a stage, since all stages share it"),
                       ("-stage_settle_grid_h 0.1,0.1", "-stage_settle_grid_h: -grid_h may not change in a stage; give -grid_h"),
                       ("-stage_shake_gravty 0,1", "-stage_shake_gravty is not an option of this scene; did you mean -stage_shake_gravity ?"),
                       ("-stage_shake_hocus_pocus_fidibus 1", "-stage_shake_hocus_pocus_fidibus is not an option of this scene; a stage takes options that may change, such as -stage_shake_gravity"),
                       ("-stage_shak_gravity 0,1", "-stage_shak_gravity is not an option of this scene: -stages declares the names of stages, and this one is not among them"),
                       ("-stage_shake_gravity 0,x", "stage shake: fault.opts:45: -gravity 0,x"), ("-stage_cut_material_soil_yield 3", "stage cut: fault.opts:46: -material_soil_yield does not apply"),
                       ("-stage_shake_remove soil", "stage shake: -remove gate,lid,soil: no particle would be left"), ("-stage_settle_remove lid", "-stage_settle_remove does not apply: nothing can leave before the first stage"),
                       ("-time_end 3", "-time_end does not apply with -stages: each lasts -stage_<s>_time"), ("-stage_cut_time_end 3", "-stage_cut_time_end does not apply: a stage lasts -stage_cut_time"),
                       ("-stage_cut_bc_xmin_type periodic\n-stage_cut_bc_xmax_type periodic\n-stage_cut_bc_xmax_velocity default", "may not change; a wall cannot become or cease to be periodic or a piston"),
                       ("-stage_cut_contact_mu 0.3", "stage cut: fault.opts:46: -contact_mu is not given before and is 0.3 in this stage; it may not change; contact between bodies cannot begin or end"),
                       ("-contact_mu 0.3\n-stage_cut_contact_mu default", "stage cut: -contact_mu is 0.3 before and is not given in this stage; it may not change; contact between bodies cannot begin or end"),
                       ("-stage_cut_method_carry all", "-stage_cut_method_carry: -method_carry may not change in a stage, since all stages share it; give -method_carry"),
                       ("-stage_cut_method_time static", "stage cut: "), ("-stage_cut_check_energy 0.1", "stage cut: fault.opts:46: -check_energy does not apply")):
        keys = {line.split()[0] for line in add.split("\n")}
        check.write("fault.opts", BASE + "".join(line + "\n" for line in STAGES.splitlines() if line.split()[0] not in keys) + add + "\n")
        for more in ([], ["-dry_run"]):
            told = check.scene_in("fault.opts", check.folder("fault"), *more)
            check.that(told.status == 2 and len(told.lines) == 1 and words in told.err and "digest" not in told.out and not os.listdir("fault"), f"{add!r} {' '.join(more)}: {told.err.strip()}")
    check.write("fault.opts", BASE + STAGES.replace("-stage_cut_time 0.05\n", ""))
    told = check.scene_in("fault.opts", check.folder("fault"))
    check.that(told.status == 2 and "-stage_cut_time is required" in told.err, told.err.strip())
    check.write("fault.opts", BASE + "-stages a,a_b\n-stage_a_time 1\n-stage_a_b_time 2\n-stage_a_b_gravity 1,0\n")
    told = check.scene_in("fault.opts", check.folder("fault"), "-dry_run")
    check.that(told.status == 0, f"of stages a and a_b the longer name counts: {told.err.strip()}")
    check.write("fault.opts", BASE + "-time_end 1\n-stage_a_time 1\n")
    told = check.scene_in("fault.opts", check.folder("fault"))
    check.that(told.status == 2 and "-stage_a_time is not an option of this scene: -stages declares the names of stages" in told.err, told.err.strip())
    dry = check.scene_in("staged.opts", check.folder("dry"), "-dry_run")
    check.that(dry.status == 0 and "the scene is valid" in dry.out and not os.path.exists("dry/staged.csv"), "-dry_run checks all stages, and makes no step")
    one, = re.findall(r"^predict +(\S+) steps of", dry.out, re.M)
    all_, = re.findall(r"^predict +that is this stage; with steps as here, all stages to t=2.11 s take (\S+) steps, roughly ", dry.out, re.M)
    check.that(abs(float(all_) / float(one) - 2.11 / 2) < 1e-3, f"it predicts {one} steps of the first, {all_} of all")


def carried():
    """What a later stage needs of particles they have from the start; what they cannot have is refused before the first step."""
    first, second = "-stages a,b\n-stage_a_time 0.03\n-stage_b_time 0.03\n", ("-output_every", 0.03, "-history_every", 0.004)
    check.write("carried.opts", BASE + first + "-output_fields velocity\n-stage_b_output_fields velocity,plastic_strain\n")
    whole = check.scene_in("carried.opts", "carried")
    by = [check.scene_in("base.opts", "hand2", *second, "-output_fields", "velocity,plastic_strain", "-checkpoint_every", 1e30, "-time_end", 0.03),
          check.scene_in("base.opts", "hand2", *second, "-output_fields", "velocity,plastic_strain", "-restart_file", "latest", "-time_end", 0.06)]
    check.that(whole.good and digests(whole) == [one.digest for one in by], f"plastic strain that a later stage shows is summed from the start, as by hand: {whole.err.strip()}")
    matter = [line for line in BASE.splitlines() if not any(word in line for word in ("gate", "friction", "fit", "cohesion", "_E ", "_nu ", "_model", "-bodies", "xmax", "output"))]
    bare = "\n".join(matter) + "\n-bodies soil,lid\n-output_format none\n-bc_xmax_type slip\n" + first
    metal = bare + "-material_soil_model vonmises\n-material_soil_E 2e6\n-material_soil_nu 0.3\n-material_soil_yield 1e4\n-method_locking none\n"
    for text, change in ((bare + "-material_soil_model fluid\n-material_soil_K 2e6\n", "-stage_b_material_soil_viscosity 10"), (metal, "-stage_b_bc_ymin_type separate"), (metal.replace("-bc_ymin_type fixed", "-bc_ymin_type separate"), "-stage_b_bc_ymin_type fixed")):
        plain = check.scene_in(check.write("carried.opts", text), "carried")
        check.write("carried.opts", text + change + "\n")
        runs = [check.scene_in("carried.opts", "carried", way=way) for way in (1, 2, "pool")]
        check.that(all(one.good and digests(one) == digests(runs[0]) for one in runs) and digests(plain)[1] != digests(runs[0])[1], f"{change}: two stages, with the same digests in three ways: {runs[0].err.strip()}")
    check.write("carried.opts", bare + "-material_soil_model neohookean\n-material_soil_E 2e6\n-material_soil_nu 0.3\n-method_basis bspline2\n-stage_b_method_basis gimp\n")
    told = check.scene_in("carried.opts", check.folder("carried"))
    check.that(told.status == 2 and len(told.lines) == 1 and "stage b: carried.opts:29: -method_basis gimp begins in this stage, and its domains, which stretch with elastic matter, have to do so from the start; give -method_basis gimp for all stages, or another basis here" in told.err and "digest" not in told.out, told.err.strip())


def method():
    """Basis, update and transfer that are given in a later stage only, or no more, another basis or wall: particles keep the volumes of the start, as by hand."""
    ball = "-gravity 0,-9.81\n-dim 2\n-grid_lower 0,0\n-grid_upper 1,1\n-grid_h 0.05,0.05\n-materials m\n-material_m_model neohookean\n-material_m_rho 1000\n-material_m_E 1e5\n-material_m_nu 0.3\n-bodies a\n"
    ball += "-body_a_material m\n-output_format none\n-history_every 0.004\n"
    given, other = {"method_basis": "bspline2", "method_update": "usl", "method_transfer": "flip"}, {"method_basis": "bspline2", "bc_ymin_type": "free"}
    disk, ring = "-body_a_shape sphere\n-body_a_radius 0.21\n-body_a_center ", "-body_a_shape box\n-body_a_lower 0,0\n-body_a_upper 0.3,0.4\n-body_a_offset 0,0.01\n-method_rim whole\n-geometry axisymmetric\n"
    for plain, stages in ((disk + "0.5,0.22\n", ({}, given, {}, given)), (disk + "0.5,0.22\n", (given, {}, given)), (disk + "0,0.22\n-geometry axisymmetric\n", ({}, given, other)), (ring, ({}, given, other))):
        names, own = "abcd"[:len(stages)], {"bc_ymin_type": "slip"}
        first = "".join(f"-{option} {value}\n" for option, value in {**own, **stages[0]}.items())
        later = "".join(f"-stage_{name}_{option} {({**own, **stage}).get(option, 'default')}\n" for name, stage in zip(names[1:], stages[1:]) for option in {**given, **other})
        check.write("method.opts", ball + plain + first + f"-stages {','.join(names)}\n" + "".join(f"-stage_{name}_time 0.01\n" for name in names) + later)
        check.folder("method2")
        hand = []
        for k, stage in enumerate(stages):
            check.write("ball.opts", ball + plain + "".join(f"-{option} {value}\n" for option, value in {**own, **stage}.items()))
            hand.append(check.scene_in("ball.opts", "method2", "-checkpoint_every", 1e30, "-time_end", 0.01 * (k + 1), *(["-restart_file", "latest"] if k else [])))
        runs, dry = [check.scene_in("method.opts", "method", way=way) for way in (1, 3, "pool")], check.scene_in("method.opts", "method", "-dry_run")
        check.that(all(one.good and digests(one) == [by.digest for by in hand] for one in runs) and dry.status == 0 and len(set(digests(runs[0]))) == len(names),
                   f"{' '.join(plain.split()[-4:])}, stages with {stages}: as by hand, in three ways {runs[0].err.strip()}{dry.err.strip()}")


def statics():
    """Statics to a motion, in two stages."""
    text = BASE.replace("-bodies soil,lid,gate", "-bodies soil,lid").replace("-bc_xmax_type moving\n-bc_xmax_velocity 0,0\n", "").replace("druckerprager", "neohookean")
    text = "".join(line + "\n" for line in text.splitlines() if "gate" not in line and "friction" not in line and "fit" not in line and "cohesion" not in line)
    check.write("static.opts", text + "-method_frame total\n-stages weight,push\n-stage_weight_time 1\n-stage_weight_method_time static\n-stage_push_time 0.05\n-stage_push_method_time explicit\n-stage_push_gravity 2,-9.81\n")
    told = check.scene_in("static.opts", "static")
    rows = check.history("static/static.csv")
    check.that(told.good and rows["kinetic_energy"][rows["stage"] == 1].max() == 0 and rows["kinetic_energy"][-1] > 0, f"statics, then a push: {told.err.strip()}")
    check.that(not np.isnan(rows["newton_iterations"][0]) and np.isnan(rows["newton_iterations"][-1]), "columns of statics end with their stage")
    rest = text + "-stages weight,rest\n-stage_weight_time 1\n-stage_weight_method_time static\n-stage_rest_time 0.02\n-stage_rest_method_time explicit\n"
    check.write("rest.opts", rest.replace("-history_every 0.004", "-history_every 0"))
    told = check.scene_in("rest.opts", "rest")
    rows = check.history("rest/rest.csv")
    strain, kinetic = rows["strain_energy"][rows["stage"] == 1][-1], rows["kinetic_energy"].max()
    check.that(told.good and kinetic < 1e-4 * strain, f"what statics leave at rest stays so in the updated frame: {kinetic:.1e} J of {strain:.1e} J")
    check.that("dt fell" not in told.out and "dt has fallen" not in told.out, "no warning that dt fell where steps of a load end")
    check.write("round.opts", rest + "-geometry axisymmetric\n")
    runs = [check.scene_in("round.opts", "round", way=way) for way in (1, 2)]
    check.that(runs[0].good and digests(runs[0]) == digests(runs[1]), f"and in the updated frame bodies of revolution keep the volumes that they had in the total frame: {digests(runs[0])} {digests(runs[1])} {runs[0].err.strip()}")
    check.write("shaken.opts", rest + "-stage_rest_acceleration 5,0\n-stage_rest_dt_cfl 0.1\n")
    bare, told = check.scene_in("shaken.opts", "bare"), check.scene_in("shaken.opts", "energy", "-history_energy")
    rows = check.history("energy/shaken.csv")
    size, left = abs(rows["external_work"]).max(), max(abs(rows[f"energy_{term}"]).max() for term in ("integration", "residual"))
    check.that(bare.digest == told.digest and left < 2e-3 * size and rows["load_work"][-1] > 1e-3 * size and np.allclose(rows["energy_gravity"][rows["stage"] == 1], rows["external_work"][rows["stage"] == 1]),
               f"the terms of the energy go on from statics to a motion; {left / size:.1e} of the work is left")
    check.that("J with the work of body forces (summed with -history_energy)" in bare.out and "summed with" not in told.out, "the residual says whose work it has")


def weaker():
    """The stress at the start is that of the start alone: a later stage, and a restart by hand, may have less strength or no gravity."""
    clay = "-material_clay_model vonmises\n-material_clay_rho 1800\n-material_clay_E 1e7\n-material_clay_nu 0.3\n-material_clay_yield 60000\n-damping_kinetic\n-output_format none\n-initial_stress k0\n"
    ground = "-dim 2\n-gravity 0,-9.81\n-grid_lower 0,0\n-grid_upper 10,6\n-grid_h 0.5,0.5\n-bc_xmin_type slip\n-bc_xmax_type slip\n-bc_ymin_type fixed\n-materials clay\n-bodies ground,pit\n-body_ground_cut pit\n"
    ground += "".join(f"-body_{name}_shape box\n-body_{name}_lower 0,{low}\n-body_{name}_upper {right},5\n-body_{name}_material clay\n" for name, low, right in (("ground", 0, 10), ("pit", 3, 3)))
    check.write("settled.opts", ground + clay)
    first = check.scene_in("settled.opts", "weaker", "-time_end", 0.1, "-history_every", 0.004, "-checkpoint_every", 1e30)
    check.need(first.good, first.said[-500:])
    last = sorted(glob.glob("weaker/settled-checkpoint-*.h5"))[-1]
    for k, (change, value) in enumerate((("material_clay_yield", "30000"), ("material_clay_yield", "25000"), ("gravity", "0,0"), ("gravity", "2,-9.81"))):
        check.write("weaker.opts", ground + clay + f"-history_every 0.004\n-stages settle,dig\n-stage_settle_time 0.1\n-stage_dig_time 0.1\n-stage_dig_remove pit\n-stage_dig_{change} {value}\n")
        dry, told = check.scene_in("weaker.opts", "weak", "-dry_run"), check.scene_in("weaker.opts", "weak")
        hand = ["settled.opts", f"hand{k}", "-restart_file", last, "-time_end", 0.2, "-history_every", 0.004, "-remove", "pit", f"-{change}", value]
        by, look = check.scene_in(*hand), check.scene_in(*hand, "-dry_run")
        check.that(told.good and digests(told) == [first.digest, by.digest], f"{change} {value} in a stage after k0, as by hand: {digests(told)} {told.err.strip()}{by.err.strip()}")
        check.that(dry.status == look.status == 0 and "initial " not in by.out and "initial_stress" not in dry.out + look.out + by.out, f"and nothing is said of the start: {dry.err.strip()}{look.err.strip()}")


same()
goes_on()
checked()
carried()
method()
statics()
weaker()
check.end()
