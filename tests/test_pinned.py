"""The digests of the first steps of every scene are those of tests/reference/digests.txt: on one process, in spatial
decomposition on 3 processes, and with a pool of 3. Scenes of statics, whose bits depend on the build of PETSc, are not
pinned: they give the same bits twice on one process.

usage: test_pinned.py PEBBLE SOURCE MPIEXEC some|rest|--write

some     each scene on one process, and every other one in one of the other ways, by turns; rest: in all other ways
--write renews the file: only when the results are meant to change, for all scenes in one commit that says why.
"""
import pathlib
import re

import check

STEPS = 25
WAYS = {"serial": (1, []), "spatial": (3, ["-parallel_strategy", "spatial"]), "pool": (3, ["-parallel_strategy", "pool"])}


def digest(scene, way, steps=STEPS):
    """The digest that a run prints at its end, or what went wrong with it."""
    processes, options = WAYS[way]
    told = check.pebble("-options_file", scene, "-time_max_steps", steps, "-output_every", 1e9, "-output_dir", ".", "-output_name",
                        f"{scene.stem}_{way}", *options, n=processes)
    return told.digest if told.good else f"status {told.status}: {told.err.strip()[-300:]}"


words = check.arguments(__doc__, 1)
reference = pathlib.Path(check.source, "tests/reference/digests.txt")
every = sorted(pathlib.Path(check.source, "options").glob("*.opts"))
scenes = [scene for scene in every if not check.is_static(scene)]
pinned = dict(line.split() for line in reference.read_text().splitlines() if line and line[0] != "#")
check.that("--write" in words or set(pinned) == {scene.stem for scene in scenes}, f"{len(pinned)} scenes are pinned, {len(scenes)} there")
found = {}
for k, scene in enumerate(scenes):
    turn = {0: "spatial", 2: "pool"}.get(k % 4)
    ways = {way: digest(scene, way) for way in WAYS if "--write" in words or (way in ("serial", turn)) == ("some" in words)}
    found[scene.stem] = ways.get("serial")
    want = ways["serial"] if "--write" in words else pinned.get(scene.stem)
    check.that(all(value == want for value in ways.values()), f"{scene.stem}: pinned {want}, found {' '.join(ways.values())}")
for scene in set(every) - set(scenes):
    two = [digest(scene, "serial", 6) for _ in range(2)]
    check.that(re.fullmatch(r"[0-9a-f]{16}", two[0]) and two[0] == two[1], f"{scene.stem}: twice {' '.join(two)}")
if "--write" in words and not check.failures:
    reference.write_text(f"# Digests after {STEPS} steps of each scene, by any way to run; see tests/test_pinned.py.\n" +
                         "".join(f"{name} {value}\n" for name, value in found.items()))
check.end()
