"""The files of a run are safe: results never take the place of a file that Pebble did not write, nor of earlier results with
-output_replace false; nothing is written outside of the folder of results; a run that cannot write says so in one line and
leaves what it wrote before as it was; a kill at any moment leaves files that can be read.

usage: test_files.py PEBBLE SOURCE MPIEXEC own|faults|killed
"""
import os
import random
import resource
import shutil
import signal
import sys
import time

import h5py
import numpy as np

import check
import mpi

DISKS = check.write  # set by main
SHORT = ["-time_max_steps", "2", "-output_every", "0"]


def run(*options, folder="out", n=1, **more):
    return check.pebble("-options_file", DISKS, "-output_dir", folder, *options, n=n, **more)


def tree(folder):
    """{path: content} of the files below a folder."""
    return {os.path.relpath(os.path.join(at, name), folder): check.content(os.path.join(at, name)) for at, _, names in os.walk(folder) for name in names}


def refused(what, message, *options, folder="out"):
    """Refused in one line, and every file is as it was."""
    before = tree(folder)
    told = run(*SHORT, *options, folder=folder)
    check.that(told.status == 2 and len(told.lines) == 1 and message in told.err and tree(folder) == before, f"{what}: {told.status} {told.lines}")


# ---- What may be replaced

def part_own():
    foreign = "is there and was not written by Pebble; give another name or folder (-output_dir), or move it away"
    others = {"disks.csv": "mass,colour\n1,red\n", "disks.h5": "a text\n", "disks.xdmf": "<?xml version=\"1.0\"?>\n<Xdmf/>\n",
              "disks.snapshots/step_000000.h5": "a text\n"}
    for name, text in others.items():
        check.folder("out")
        os.makedirs(os.path.dirname("out/" + name), exist_ok=True)
        check.write("out/" + name, text)
        refused(f"a {name} of another program", f"-output_name: out/{name} {foreign}")
    check.folder("out")
    with h5py.File("out/disks.h5", "w") as file:
        file["step_000000"] = 1
    refused("HDF5 of another program", f"-output_name: out/disks.h5 {foreign}")
    check.folder("out")
    check.write("out/disks.snapshots", "a text\n")
    refused("a file where the folder of snapshots goes", "-output_name: out/disks.snapshots is there and is not a folder")

    # The options file itself, by links and by names that only exist while a file is written.
    for name, link in (("disks.csv", os.link), ("disks.h5", os.symlink), ("disks.xdmf.pebble-new", os.link)):
        check.folder("out")
        shutil.copy(DISKS, "out/scene.opts")
        link(os.path.abspath("out/scene.opts"), "out/" + name)
        before = tree("out")
        told = check.pebble("-options_file", "out/scene.opts", "-output_dir", "out", "-output_name", "disks", *SHORT)
        check.that(told.status == 2 and "would overwrite the options file" in told.err and len(told.lines) == 1 and tree("out") == before,
                   f"the options file as {name}, {link.__name__}: {told.lines}")

    # Earlier results.
    check.folder("out")
    first = run("-time_max_steps", "3", "-output_every", "0", "-output_replace", "false")
    check.that(first.good, f"-output_replace false where nothing is: {first.lines}")
    refused("-output_replace false", "-output_replace false: out/disks.csv is there; give another -output_name or -output_dir", "-output_replace", "false")
    os.remove("out/disks.csv")
    refused("the same, the snapshots alone", "-output_replace false: out/disks.h5 is there; give another -output_name or -output_dir", "-output_replace", "false")
    os.remove("out/disks.h5")
    os.remove("out/disks.xdmf")
    os.remove("out/disks.grid.xdmf")
    refused("the same, a snapshot", "-output_replace false: out/disks.snapshots/step_00000", "-output_replace", "false")
    check.that(run("-time_max_steps", "2", "-output_replace", "false", "-output_format", "none").good, "a run without snapshots replaces none")
    os.link("out/disks.csv", "out/kept.csv")
    kept = check.content("out/kept.csv")
    check.write("out/disks.snapshots/notes.txt", "mine\n")
    check.write("out/disks.snapshots/step_7.h5", "mine\n")
    check.write("out/disks.snapshots/step_000009.h5.pebble-new", "what a killed run left\n")
    check.write("out/disks.xdmf", "<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n  <Domain>\n    <Grid Name=\"particles\" GridType=\"Collection\" CollectionType=\"Temporal\">\n")
    again = run("-time_max_steps", "1", "-output_every", "0", "-history_every", "0")
    check.that(again.good and sorted(os.listdir("out/disks.snapshots")) == ["notes.txt", "step_000000.h5", "step_000001.h5", "step_7.h5"],
               f"a run replaces earlier results, and nothing else: {sorted(os.listdir('out/disks.snapshots'))} {again.lines}")
    check.that(check.content("out/kept.csv") == kept and len(check.rows("out/disks.csv")) == 2, "an earlier history by another name stays")
    with h5py.File("out/disks.h5") as file:
        check.that(check.steps(file) == [0, 1], f"the index has the new snapshots: {list(file)}")

    # Nothing elsewhere.
    for name in ("home", "tmp", "here"):
        check.folder(name)
    os.environ.pop("MPLCONFIGDIR", None)  # make sets it
    env = {"HOME": os.path.abspath("home"), "TMPDIR": os.path.abspath("tmp")}
    told = check.run([check.program, "-options_file", DISKS, *SHORT], cwd="here", plain=True, env=env)
    drawn = check.run([sys.executable, os.path.join(check.source, "tools", "plot.py"), "output/disks.h5", "--out", "output/disks.png"], cwd="here", plain=True, env=env)
    check.that(drawn.status == 0 and os.path.exists("here/output/disks.png"), f"plot.py: {drawn.said[-300:]}")
    os.remove("here/output/disks.png")
    left = {name: sorted(tree(name)) for name in ("home", "tmp")} | {"here": sorted(os.listdir("here"))}
    check.that(told.good and left == {"home": [], "tmp": [], "here": ["output"]}, f"nothing is written outside of the folder of results: {left}")
    check.that(sorted(os.listdir("here/output")) == ["disks.csv", "disks.grid.xdmf", "disks.h5", "disks.snapshots", "disks.xdmf"], f"what is in it: {sorted(os.listdir('here/output'))}")


# ---- Reading what is there

def readable(folder, name):
    """How many snapshots index, text and folder have; all can be read, or the test says why not."""
    steps, at = set(), f"{folder}/{name}.snapshots"
    for file in sorted(os.listdir(at)):
        if not file.endswith(".h5"):
            continue
        try:
            with h5py.File(f"{at}/{file}") as snapshot:
                group = snapshot[file[:-3]]
                if all(np.isfinite(group["particles"][field][:]).all() for field in group["particles"]) and snapshot.attrs["version"].startswith(b"pebble"):
                    steps.add(int(file[5:-3]))
        except (OSError, KeyError) as error:
            check.that(False, f"{at}/{file}: {error}")
    joined = set()
    if os.path.exists(f"{folder}/{name}.h5"):
        try:
            with h5py.File(f"{folder}/{name}.h5") as file:
                joined = set(check.steps(file))
                for step in joined & steps:
                    file[f"step_{step:06d}/particles/x"][0]
        except (OSError, KeyError) as error:
            check.that(False, f"{folder}/{name}.h5: {error}")
    if joined - steps:
        check.that(False, f"{folder}/{name}.h5 has {sorted(joined - steps)}, which are no snapshots")
    if os.path.exists(f"{folder}/{name}.xdmf"):
        check.fault(None if check.content(f"{folder}/{name}.xdmf").endswith(b"</Xdmf>\n") else "the XDMF file is not complete")
    lines = check.content(f"{folder}/{name}.csv").decode().split("\n") if os.path.exists(f"{folder}/{name}.csv") else [""]
    check.fault(None if lines[-1] == "" and len({line.count(",") for line in lines[:-1]}) <= 1 else f"the history's last line is {lines[-1]!r}")
    return len(steps), len(joined)


# ---- Faults in writing

def endless():
    """Options of a run that ends by a fault only, with something to write in each step."""
    with open(check.scene("disks")) as file:
        text = "".join(line for line in file if not line.startswith(("-dt_", "-output_", "-history_")))
    check.write("disks.opts", text)
    return ["-time_end", "1e6", "-body_disk1_velocity", "0,0", "-body_disk2_velocity", "0,0", "-dt_size", "1e-3", "-check_energy", "1e9",
            "-check_momentum", "1e9", "-report_indicator", "false"]


def snapshots(folder):
    try:
        return sum(name.endswith(".h5") for name in os.listdir(folder + "/disks.snapshots"))
    except OSError:
        return 0


def stops(what, pattern, action, *options, n=1, ready=lambda folder: snapshots(folder) > 2):
    """A run in which action(session, folder) makes writing fail, once it is ready: one line, status 3."""
    folder = check.folder("fault_" + "".join(c if c.isalnum() else "_" for c in what))

    def during(session):
        mpi.until(lambda: ready(folder), lambda: mpi.members(session))
        action(session, folder)

    told = run(*endless(), *options, folder=folder, n=n, during=during)
    good = told.status == 3 and len(told.lines) == 1 and told.lines[0].startswith("stopped at step") and "ERROR" not in told.said
    check.that(good and pattern(folder) in told.err, f"{what}: {told.status} {told.lines[:3]}")
    return folder


def limit(size):
    """Files of the run's processes must not be longer. (It is set late, since MPI makes long ones as it starts.)"""
    def set_limit(session, folder):
        for pid in mpi.members(session):
            try:
                resource.prlimit(pid, resource.RLIMIT_FSIZE, (size, size))
            except ProcessLookupError:
                pass
    return set_limit


def vanish(session, folder):
    while os.path.exists(folder):
        shutil.rmtree(folder, ignore_errors=True)


def part_faults():
    always = ["-output_every", "0", "-history_every", "1e9"]
    large = lambda folder: f"cannot write {folder}/disks.snapshots/step_"
    for n, more in ((1, []), (3, []), (3, ["-parallel_strategy", "pool"])):
        name = f"a snapshot that is too long, {n} {' '.join(more[1:])}"
        folder = stops(name, large, limit(100000), *always, *more, n=n)
        found = readable(folder, "disks")
        check.that(found[0] > 2 and found[0] == found[1] and not [f for f in os.listdir(folder + "/disks.snapshots") if "new" in f],
                   f"{name}: {found[0]} earlier snapshots are there, {found[1]} in the index, none in part")
    small = ["-output_fields", "body", "-output_every", "0", "-history_every", "1e9"]
    folder = stops("an index or text that is too long", lambda folder: f"cannot write {folder}/disks.xdmf: File too large", limit(130000), *small)
    check.that(readable(folder, "disks")[0] > 2, "the earlier text is there")
    rows = lambda count: lambda folder: os.path.exists(folder + "/disks.csv") and check.content(folder + "/disks.csv").count(b"\n") > count
    history = ["-output_format", "none", "-history_every", "0"]
    for n in (1, 3):
        folder = stops(f"a history that is too long, {n}", lambda folder: f"cannot write {folder}/disks.csv: File too large", limit(50001), *history, n=n, ready=rows(3))
        lines = check.content(folder + "/disks.csv").decode().split("\n")
        check.that(lines[-1] == "" and len({line.count(",") for line in lines[:-1]}) == 1 and len(lines) > 50, f"its {len(lines) - 1} lines are whole")
    gone = lambda name: lambda folder: f"cannot write {folder}/{name}"
    stops("the folder vanishes, 1", gone("disks."), vanish, *always)
    stops("the folder vanishes, 3", gone("disks."), vanish, *always, n=3)
    stops("the folder vanishes, history", gone("disks.csv: No such file"), vanish, *history, ready=rows(3))


# ---- Kills

def part_killed(count=3):
    rng, found = random.Random(5), []
    endless()
    for k in range(count):
        folder = check.folder(f"kill_{k}")
        n = (1, 4)[k % 3 == 2]

        def during(session):
            mpi.until(lambda: snapshots(folder) > 1, lambda: mpi.members(session))
            time.sleep(rng.uniform(0, 0.1))
            pid = mpi.process(session, rng.randrange(n)) if n > 1 else session
            os.kill(pid, signal.SIGKILL)

        told = run(*endless(), "-output_every", "0", "-history_every", "0", folder=folder, n=n, during=during)
        check.fault(None if told.status not in (0, mpi.TIMED_OUT, mpi.LEFT_BEHIND) else f"kill {k}: {told.status}")
        found.append(readable(folder, "disks"))
        shutil.rmtree(folder)
    check.that(all(steps >= 2 and steps - joined <= 1 + steps // 100 for steps, joined in found), f"{count} kills: snapshots that can be read, and those in the index: {found}")


part, *rest = check.arguments(__doc__, None)
DISKS = check.scene("disks") if part == "own" else "disks.opts"
globals()["part_" + part](*map(int, rest))
check.end()
