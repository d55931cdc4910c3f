"""Runs of every scene that look for defects: the first steps give the pinned digests (tests/reference/digests.txt); scenes of
statics, which have none, run on one process only

traps        with floating-point traps of PETSc: nothing is divided by zero, overflows or is no number on the way
poison       with the program of make DEBUG=poison, in which memory that nobody may read is filled with a pattern
sanitizers   with the program of make DEBUG=1, without a word of the address or the undefined-behaviour sanitizer
valgrind     on 2 processes under memcheck, without an error; only some small scenes, since it is 50 times slower

usage: test_debug.py PEBBLE SOURCE MPIEXEC traps|poison|sanitizers|valgrind [some|all]
"""
import pathlib
import re
import shutil
import sys

import check

STEPS = 25
SERIAL, SPATIAL, POOL = (1, []), (3, ["-parallel_strategy", "spatial"]), (3, ["-parallel_strategy", "pool"])
DIRECT = (3, ["-parallel_strategy", "spatial", "-parallel_migrate", "direct"])
TWO, TWO_POOL = (2, ["-parallel_strategy", "spatial", "-parallel_migrate", "direct"]), (2, ["-parallel_strategy", "pool"])
# ways to run, more options, environment, scenes (none: all), seconds a run, steps
HOW = {
    "traps": ([SERIAL, SPATIAL, POOL], ["-fp_trap"], {}, None, 120, STEPS),
    "poison": ([SERIAL, SPATIAL, DIRECT, POOL], [], {"MALLOC_PERTURB_": "128"}, None, 120, STEPS),
    "sanitizers": ([SERIAL, SPATIAL, POOL], [], {"ASAN_OPTIONS": "detect_leaks=0", "UBSAN_OPTIONS": "print_stacktrace=1"},
                   None, 300, STEPS),
    # The vectors of valgrind's processor are those of AVX2.
    "valgrind": ([TWO, TWO_POOL], [], {}, ["bar", "disks"], 900, 10),
}
FAST = ["-body_disk1_velocity", "20,20", "-body_disk1_center", "0.2,0.29"]  # so that particles change process
WORDS = r"ERROR: AddressSanitizer|runtime error:|PETSC ERROR|^==\d+== "


def fault(what, scene, way, pinned, more, env, patience, steps):
    """What is wrong with a run; None if nothing is."""
    processes, options = way
    command = [check.program]
    if what == "valgrind":
        command = ["valgrind", "-q", "--error-exitcode=99", "--num-callers=40", "--leak-check=full", "--show-leak-kinds=definite",
                   "--errors-for-leak-kinds=definite", f"--suppressions={check.source}/tests/valgrind.supp", *command]
    told = check.run([*command, "-options_file", scene, "-time_max_steps", steps, "-output_every", 1e9, "-output_dir", ".",
                      "-output_name", f"{scene.stem}_{processes}", *options, *more, *(FAST if what == "valgrind" and scene.stem == "disks" else [])], processes, patience, env=env)
    if what == "valgrind" and scene.stem == "disks" and "spatial" in options and not told.find(r"^migration .* changed process (\d+)"):
        return "no particle changed process"
    word = re.search(WORDS, told.said, re.M)
    if not told.good or word:
        return f"status {told.status}: {told.said[word.start() if word else -1500:][:1500]}"
    return None if steps != STEPS or pinned is None or told.digest == pinned else f"digest {told.digest}, pinned {pinned}"


words = check.arguments(__doc__, None)
if words[0] == "valgrind" and not shutil.which("valgrind"):
    print("valgrind is not installed")
    sys.exit(77)
ways, more, env, names, patience, steps = HOW[words[0]]
pinned = dict(line.split() for line in pathlib.Path(check.source, "tests/reference/digests.txt").read_text().splitlines()
              if line and line[0] != "#")
for scene in sorted(pathlib.Path(check.source, "options").glob("*.opts")):
    if names and scene.stem not in names:
        continue
    wrong = [f"{way[0]} {way[1][1:]}: {text}" for way in (ways[:1] if "some" in words or scene.stem not in pinned else ways)
             if (text := fault(words[0], scene, way, pinned.get(scene.stem), more, env, patience, steps))]
    check.that(not wrong, f"{words[0]}, {scene.stem}, {steps} steps" + "".join("\n" + text for text in wrong))
check.end()
