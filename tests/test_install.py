"""make install copies a program that runs from any folder and tools that draw what it wrote; make uninstall leaves nothing of
them. The version is the same in the program, CITATION.cff and CHANGELOG.md.

usage: test_install.py PEBBLE SOURCE MPIEXEC
"""
import os
import re
import subprocess
import sys

import check

check.arguments(__doc__, 0)
HERE, PROGRAM = os.getcwd(), check.program


def make(*words):
    """make, which takes the program as it is (-o)."""
    done = subprocess.run(["make", "--no-print-directory", "-C", check.source, "-o", PROGRAM, f"PEBBLE={PROGRAM}", *words],
                          capture_output=True, text=True)
    return check.Run(done.returncode, done.stdout, done.stderr)


def below(*folders):
    """Files and folders below folders, by their paths there."""
    return sorted(os.path.relpath(os.path.join(path, name), folder) for folder in folders
                  for path, folders_here, files in os.walk(folder) for name in files + folders_here)


def python(*words, path=os.path.dirname(sys.executable), env_more={}, **more):
    """A program that finds its Python first in this folder."""
    env = os.environ | {"PATH": f"{path}{os.pathsep}{os.environ['PATH']}"} | env_more
    env.pop("PYTHONDONTWRITEBYTECODE", None)  # so that there is a __pycache__ to remove
    done = subprocess.run(words, capture_output=True, text=True, env=env, **more)
    return check.Run(done.returncode, done.stdout, done.stderr)


# ---- Install. The prefix has a blank, and a folder above it is there before.
check.folder("the place")
prefix = os.path.join(HERE, "the place", "prefix")
bin_, share = os.path.join(prefix, "bin"), os.path.join(prefix, "share", "pebble")
run = make("install", f"PREFIX={prefix}")
check.need(run.status == 0, f"make install: {run.said}")
check.that(sorted(os.listdir(bin_)) == ["pebble", "pebble-movie", "pebble-plot", "pebble-study"], f"bin has {sorted(os.listdir(bin_))}")
for name in ("options", "docs"):
    there, here = below(os.path.join(share, name)), below(os.path.join(check.source, name))
    check.that(there == here, f"{len(there)} files and folders in {name}, as in the source")
check.that({"README.md", "LICENSE", "CITATION.cff", "CHANGELOG.md", "CONTRIBUTING.md"} <= set(os.listdir(share)), "documents and the licence")
before = below(prefix)

# ---- Run and draw in another folder.
os.chdir(check.folder("elsewhere"))
check.program = os.path.join(bin_, "pebble")
scenes = os.path.join(share, "options")
run = check.must("-options_file", os.path.join(scenes, "disks.opts"), "-time_end", "0.2")
check.that(run.good and os.path.exists("output/disks.h5") and below(prefix) == before, "a run writes to output of the current folder alone")
run = check.must("-options_file", os.path.join(scenes, "stl_drop.opts"), "-time_max_steps", "1")
check.that(run.good, "a scene finds the file that it names beside itself")
run = python(os.path.join(bin_, "pebble-plot"), "output/disks.h5")
check.that(run.status == 0 and os.path.getsize("output/disks.png") > 10000, f"pebble-plot draws it {run.err}")
run = python(os.path.join(bin_, "pebble-movie"), "output/disks.h5", "-o", "disks.gif")
check.that(run.status == 0 and os.path.getsize("disks.gif") > 10000, f"pebble-movie makes a movie {run.err}")
run = python(os.path.join(bin_, "pebble-study"), "convergence", os.path.join(scenes, "mms.opts"), "-grid_cells", "4,4", "--levels", "2")
check.that(run.status == 0 and os.path.exists("output/mms_study.csv") and os.path.getsize("output/mms_study.png") > 10000, f"pebble-study studies a scene and draws it {run.err}")
run = python(sys.executable, "-c", "import pebble_mpm as pebble; print(pebble.find_program(), pebble.run(dry_run=True, options_file='{}').find('^scene +(.*?)  '))".format(
    os.path.join(scenes, "bar.opts")), env_more={"PYTHONPATH": os.path.join(share, "lab")})
check.that(run.out.strip() == os.path.join(bin_, "pebble") + " vibrating bar", f"the module starts the program that is installed: {run.said}")
run = python(sys.executable, "-S", os.path.join(bin_, "pebble-study"), "convergence", "x.opts")
check.that(run.status == 1 and len(run.err.splitlines()) == 1 and "python3-h5py" in run.err, f"pebble-study without its packages: {run.err.strip()}")
run = python(sys.executable, "-S", os.path.join(bin_, "pebble-plot"), "output/disks.h5")  # -S: a Python without packages
check.that(run.status == 1 and len(run.err.splitlines()) == 1 and "python3-h5py" in run.err and os.path.join(share, "tools", "requirements.txt") in run.err,
           f"without its packages: {run.err.strip()}")
os.chdir(HERE)

# ---- Install again, uninstall; what is another's stays.
check.write(os.path.join(scenes, "own.opts"), "-dim 2\n")
run = make("install", f"PREFIX={prefix}")
check.that(run.status == 0 and below(prefix) == sorted([*before, "share/pebble/options/own.opts"]), f"installed again {run.err}")
run = make("uninstall", f"PREFIX={prefix}")
kept = ["prefix", "prefix/share", "prefix/share/pebble", "prefix/share/pebble/options", "prefix/share/pebble/options/own.opts"]
check.that(run.status == 0 and below("the place") == kept, f"uninstalled, but for another's file: {below('the place')} {run.err}")
check.folder("the place")
for word in ("install", "install", "uninstall"):
    run = make(word, f"PREFIX={prefix}")
check.that(run.status == 0 and not os.listdir("the place"), f"installed twice and uninstalled, nothing is left {run.err}")

# ---- What cannot be: one line. A folder of packagers.
for words, wrong in ((["uninstall", f"PREFIX={prefix}"], f"make uninstall: Pebble is not installed in {prefix}"),
                     (["install", "PREFIX=/dev/null/prefix"], "make install: cannot write to /dev/null/prefix: use sudo make install, or a PREFIX of your own")):
    run = make(*words)
    lines = [line for line in run.err.splitlines() if not line.startswith("make: ***")]
    check.that(run.status and len(lines) == 1 and lines[0].startswith(wrong), f"make {words[0]}: {lines}")
stage = os.path.join(HERE, check.folder("stage"))
run = make("install", "PREFIX=/usr", f"DESTDIR={stage}")
check.that(run.status == 0 and os.listdir(stage) == ["usr"] and check.run([os.path.join(stage, "usr", "bin", "pebble"), "-version"]).status == 0,
           f"DESTDIR: {run.out.strip()}")
run = make("uninstall", "PREFIX=/usr", f"DESTDIR={stage}")
check.that(run.status == 0 and not os.listdir(stage), "DESTDIR is empty again")

# ---- One version, with one date.
check.program = PROGRAM
version = re.match(r"pebble (\S+) ", check.must("-version").out)[1]
cited = dict(re.findall(r'^(version|date-released): "?([^"\n]+)', check.content(os.path.join(check.source, "CITATION.cff")).decode(), re.M))
told = re.search(r"^## \[(\d[^\]]*)\] - (\S+)$", check.content(os.path.join(check.source, "CHANGELOG.md")).decode(), re.M)
check.that(version == cited["version"] == told[1] and cited["date-released"] == told[2],
           f"version {version} of the program, {cited['version']} of {cited['date-released']} in CITATION.cff, {told[1]} of {told[2]} in CHANGELOG.md")
check.end()
