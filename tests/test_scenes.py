"""Scenes of options/, in four parts.

files      Every options/*.opts: says what to look at and which method it takes, has its picture in docs/scenes.md, passes
           -dry_run, runs, and its history is finite. It gives the same bits alone and on 3 processes, spatial or pool.
           Scenes whose solution is known stay within a limit of it.
compilers  Every options/*.opts but those of statics: programs of gcc and clang give the same bits alone and on 3 processes, spatial and pool.
lanes      A few scenes of all dimensions, bases, updates and laws: the same bits with vectors of 8, 4 and 2 particles,
           alone and on 2 processes. The digest in docs/results.md is that of the scene there.
levels     The same, and for programs that are compiled with -O3, the default, and with -O2.

usage: test_scenes.py PEBBLE SOURCE MPIEXEC files|compilers|lanes|levels [GCC CLANG]
GCC, CLANG   further programs by these compilers; that by gcc is compiled with -O2
"""
import glob
import math
import os
import re
import sys

import check

EXPECTED = ("bar barx cantilever column column_static dambreak dambreak3d dambreak_block disks disks3d disks_contact drop elastic_column extrusion footing_static friction "
            "gate granular_column hertz hopper impact martin_moyce mms pressure reissner release ring roll shear slope slope_static stl_drop taylor taylor3d taylor_axi tube_static vortex wedge").split()
PARTICLE_STEPS, STEPS = 200000, 200  # of the comparisons: at most so much work, and so many steps
# Largest rms error of the displacement at the end of the run, as a part of its rms; a quarter above what is measured.
ERRORS = {"barx": 2.6e-5, "elastic_column": 8e-5, "mms": 0.0053, "ring": 0.0015, "shear": 1.3e-4, "vortex": 0.0053}
# Of the part lanes: scene, what is different from its file, most steps.
LANES = [
    ("bar", "", 100),
    ("disks", "", 300),  # all of it: they meet late
    ("column", "", 100),
    ("shear", "-method_basis bspline2 -method_update musl -method_transfer flip", 50),
    ("cantilever", "", 50),
    ("cantilever", "-method_preset solid", 50),
    ("mms", "-method_update musl -method_transfer flip", 50),
    ("dambreak", "-method_basis bspline3 -method_update usl -method_transfer apic", 50),
    ("dambreak3d", "-method_basis bspline3 -method_transfer xpic -method_order 3", 10),
    ("disks3d", "-method_basis gimp -method_update usl -body_ball1_velocity 0.3*z,0.1,x*y", 10),
    ("taylor", "", 20),
    ("taylor", "-method_preset solid", 20),
    ("taylor3d", "", 10),
    ("taylor_axi", "", 20),
    ("taylor_axi", "-method_preset solid", 20),
    ("drop", "-method_basis bspline2 -method_update usl -method_transfer apic", 50),
    ("mms", "-method_update usl -method_transfer apic", 30),
]


def compiler_of(program):
    said = check.run([program, "-version"]).said
    return "clang" if "clang" in said else "gcc"


def name_of(scene):
    return os.path.splitext(os.path.basename(scene))[0]


def digest(program, scene, steps, *options, n=1, lanes=8):
    """Of a run, and how many lanes it had."""
    told = check.run([program, "-options_file", scene, "-time_max_steps", steps, "-output_format", "none", "-output_dir",
                      "digests", *options], n, env={"PEBBLE_VECTOR": str(lanes)})
    used = told.find(r"^kernels .* (\d) lanes$")
    if not told.good or not used:
        print(told.said)
    return (told.digest, int(used)) if told.good and used else (f"none, exit status {told.status}", 0)


def check_text(scene, gallery):
    """What a reader finds: the line to look at, the commands, the method, the picture."""
    name = name_of(scene)
    with open(scene) as file:
        text = file.read()
    missing = [f"-method_{option}" for option in ("basis", "update", "transfer") if not re.search(rf"^-method_({option}|preset) ", text, re.M)]
    wanted = ["# Look at: ", f"#   ./pebble -options_file options/{name}.opts\n", f"#   .venv/bin/python tools/plot.py output/{name}.h5"]
    missing += [words for words in wanted if words not in text]
    missing += [words for words in (f"[{name}](#{name})", f"## {name}\n", f"(scene-{name}.png)") if words not in gallery]
    if not os.path.exists(os.path.join(check.source, "docs", f"scene-{name}.png")):
        missing.append("its picture")
    check.that(not missing, f"{name}: comment, method and gallery{', without ' + ', '.join(map(repr, missing)) if missing else ''}")


def check_scene(scene):
    """A dry run and five steps; the number of its particles."""
    name = name_of(scene)
    told = check.pebble("-options_file", scene, "-dry_run", "-output_dir", "dry")
    check.that(told.status == 0 and not glob.glob(f"dry/{name}.*"), f"{name}: -dry_run exits {told.status} and writes no results")
    particles = told.find(r"(\d+) particles")
    if told.status or not particles:
        print(told.said)
    told = check.pebble("-options_file", scene, "-time_max_steps", "5", "-output_dir", ".")
    check.that(told.status == 0, f"{name}: 5 steps, exit status {told.status}")
    if told.status or not os.path.exists(name + ".csv"):
        print(told.said)
        check.that(False, f"{name}: history")
    else:
        rows = check.rows(name + ".csv")
        numbers = [float(value) for row in rows for value in row.values()]
        check.that(rows and all(map(math.isfinite, numbers)), f"{name}: {len(rows)} lines of history, {len(numbers)} finite numbers")
        check.that(rows and int(rows[-1]["step"]) == 5, f"{name}: the last line is of step {rows[-1]['step'] if rows else None}")
    check.that(os.path.exists(name + ".h5"), f"{name}: snapshots")
    return int(particles or 1)


def check_error(scene):
    name = name_of(scene)
    told = check.pebble("-options_file", scene, "-output_format", "none", "-output_dir", "whole")
    part = float(told.find(r"^reference .* relative error is (\S+)$") or math.nan)
    check.that(told.status == 0 and part <= ERRORS[name], f"{name}: rms error {part:.3g} of the displacement, allowed {ERRORS[name]}")


def steps_of(particles):
    return max(20, min(STEPS, PARTICLE_STEPS // particles))


def part_files():
    scenes = sorted(glob.glob(check.scene("*")))
    names = [name_of(scene) for scene in scenes]
    check.that(set(EXPECTED) <= set(names), f"{len(scenes)} scenes{'; missing: ' + ' '.join(set(EXPECTED) - set(names)) if set(EXPECTED) - set(names) else ''}")
    with open(os.path.join(check.source, "docs", "scenes.md")) as file:
        gallery = file.read()
    for scene in scenes:
        name = name_of(scene)
        check_text(scene, gallery)
        check_scene(scene)
        if name in ERRORS:
            check_error(scene)


def part_compilers(gcc, clang):
    own = compiler_of(check.program)
    programs = {"gcc": gcc, "clang": clang, own: check.program}
    for compiler, program in programs.items():
        check.that(compiler_of(program) == compiler, f"a program by {compiler}")
    for k, scene in enumerate(sorted(path for path in glob.glob(check.scene("*")) if not check.is_static(path))):
        name, told = name_of(scene), check.must("-options_file", scene, "-dry_run", "-output_dir", "dry")
        steps = steps_of(int(told.find(r"(\d+) particles")))
        (want, _), (other, _) = (digest(programs[compiler], scene, steps) for compiler in ("gcc", "clang"))
        check.that(not want.startswith("none") and other == want, f"{name}: digest after at most {steps} steps by gcc {want}, by clang {other}")
        # each strategy with each compiler by turns
        for compiler, strategy in zip(("gcc", "clang"), ("spatial", "pool") if k % 2 else ("pool", "spatial")):
            lanes = 8 if compiler == "gcc" else (4, 2)[k // 2 % 2]
            found, _ = digest(programs[compiler], scene, steps, "-parallel_strategy", strategy, n=3, lanes=lanes)
            check.that(found == want, f"{name}: {compiler}, {strategy} on 3 processes, at most {lanes} lanes: digest {found}")


def part_lanes():
    compare_lanes({"-O3": check.program}, lambda k: [("-O3", (8, 4, 2)[k % 3], 2, ("spatial", "pool")[k % 2])])


def part_levels(gcc, clang):
    # -O2 with each width and strategy by turns
    compare_lanes({"-O3": check.program, "-O2": gcc}, lambda k: [("-O3", lanes, 2, "spatial") for lanes in (8, 4, 2)] + [("-O2", (8, 4, 2)[k % 3], 2, ("pool", "spatial")[k % 2])])


def compare_lanes(programs, parallel):
    """Each program alone with each width, and parallel(number of the scene): (program, lanes, processes, strategy) of further
    runs."""
    told = re.search(r"^ *digest ([0-9a-f]{16})$", check.content(os.path.join(check.source, "docs", "results.md")).decode(), re.M).group(1)
    for k, (scene, options, steps) in enumerate(LANES):
        want = most = None  # of the first run; most: the lanes that the processor has
        for level, lanes, n, strategy in [(level, lanes, 1, "spatial") for level in programs for lanes in (8, 4, 2)] + parallel(k):
            found, used = digest(programs[level], check.scene(scene), steps, *options.split(), "-parallel_strategy", strategy, n=n, lanes=lanes)
            if want is None:
                want, most = found, used
                check.that(not want.startswith("none"), f"{scene} {options}".strip() + f": digest {want} with {most} lanes")
                if (scene, options) == ("disks", ""):  # a change of rounding is to be made on purpose, and told
                    check.that(want == told, f"disks: digest {want}, {told} in docs/results.md")
            check.that(found == want and used == min(lanes, most), f"{scene}: {level}, {used} lanes, {strategy} on {n}: digest {found}")


part, *others = check.arguments(__doc__, None) or sys.exit(__doc__)
globals()["part_" + part](*others)
check.end()
