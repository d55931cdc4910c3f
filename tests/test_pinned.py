"""The digests of the first steps of every scene are those of tests/reference/digests.txt: on one process, in spatial
decomposition on 3 processes, and with a pool of 3.

    test_pinned.py PEBBLE SOURCE MPIEXEC [--write]

--write renews the file: only when the results are meant to change, for all scenes in one commit that says why.
"""
import pathlib
import re
import sys

import mpi

STEPS = 25
WAYS = {"serial": (1, []), "spatial": (3, ["-parallel_strategy", "spatial"]), "pool": (3, ["-parallel_strategy", "pool"])}


def digest(pebble, mpiexec, scene, way):
    """The digest that a run prints at its end, or what went wrong with it."""
    processes, options = WAYS[way]
    status, out, err = mpi.run(processes, [pebble, "-options_file", scene, "-time_max_steps", STEPS, "-output_every", 1e9,
                                           "-output_dir", ".", "-output_name", f"{scene.stem}_{way}", *options],
                               mpiexec=mpiexec)
    found = re.search(r"^digest (\w{16})$", out, re.M)
    return found[1] if status == 0 and found else f"status {status}: {err.strip()[-300:]}"


def main():
    pebble, source, mpiexec = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
    reference = source / "tests/reference/digests.txt"
    scenes = sorted((source / "options").glob("*.opts"))
    found = {(scene.stem, way): digest(pebble, mpiexec, scene, way) for scene in scenes for way in WAYS}
    for scene in scenes:
        if len({found[scene.stem, way] for way in WAYS}) > 1:
            sys.exit(f"{scene.stem}: the ways to run differ: " + ", ".join(f"{w} {found[scene.stem, w]}" for w in WAYS))
    if "--write" in sys.argv:
        reference.write_text(f"# Digests after {STEPS} steps of each scene, by any way to run; see tests/test_pinned.py.\n" +
                             "".join(f"{scene.stem} {found[scene.stem, 'serial']}\n" for scene in scenes))
        return
    pinned = dict(line.split() for line in reference.read_text().splitlines() if line and line[0] != "#")
    wrong = [f"{name}: {found[name, 'serial']}, pinned {pinned.get(name, 'nowhere')}"
             for name in sorted({s.stem for s in scenes} | set(pinned))
             if (name, "serial") not in found or pinned.get(name) != found[name, "serial"]]
    print("\n".join(wrong) if wrong else f"{len(scenes)} scenes, {len(WAYS)} ways to run: digests as pinned")
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
