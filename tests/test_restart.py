"""A run that goes on from a checkpoint has the bits of the run without a stop: digest, history (every byte) and snapshots.

    test_restart.py PEBBLE SOURCE MPIEXEC scenes    every scene of options/, once
    test_restart.py PEBBLE SOURCE MPIEXEC counts    every scene on 1, 2, 3 and 4 processes and in the pool, in one chain of restarts
    test_restart.py PEBBLE SOURCE MPIEXEC methods   every basis, update and transfer, and what else has a state of its own
    test_restart.py PEBBLE SOURCE MPIEXEC files     signals, damaged files, options that differ, -rerun, -checkpoint_keep
    test_restart.py PEBBLE SOURCE MPIEXEC large     a million particles: SIGTERM, and the speed of writing (not judged)
"""
import glob
import itertools
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time

import h5py
import numpy as np

import check
import mpi

words = check.arguments(__doc__, 1)
SCENES = sorted(os.path.basename(path)[:-5] for path in glob.glob(check.scene("*")) if not check.is_static(path))  # test_static.py has those of statics
WAYS = {1: [], 2: [], 3: [], 4: [], "pool": ["-parallel_strategy", "pool"]}


def processes(way):
    return 3 if way == "pool" else way


def results(folder):
    """The bytes of the history, and of each snapshot its digest and all its numbers."""
    name = os.path.basename(glob.glob(f"{folder}/*.csv")[0])[:-4]
    snapshots = {}
    with h5py.File(f"{folder}/{name}.h5") as file:
        for step in file:
            group = file[step]
            fields = {f"{part}/{key}": group[part][key][()].tobytes() for part in group for key in group[part]}
            snapshots[step] = (group.attrs["digest"], group.attrs["time"], fields)
    return check.content(f"{folder}/{name}.csv"), snapshots, name


def same(one, other, what):
    """Checks that two folders have the same results; returns whether they have."""
    (history, snapshots, _), (history2, snapshots2, _) = results(one), results(other)
    wrong = None
    if history != history2:
        wrong = "another history"
    elif snapshots.keys() != snapshots2.keys():
        wrong = f"snapshots {sorted(snapshots)} and {sorted(snapshots2)}"
    else:
        for step, (digest, t, fields) in snapshots.items():
            for key in fields:
                if snapshots2[step][:2] != (digest, t) or snapshots2[step][2].get(key) != fields[key]:
                    wrong = wrong or f"{step}: {key} differs"
    return check.that(not wrong, f"{what}: {wrong or 'the same history and snapshots'}")


def stop_and_go(scene, steps, stops, ways, more=()):
    """A run of so many steps with no stop, on one process, and the same run with stops, each part in its own way."""
    where = "-".join([scene, *map(str, stops), *map(str, ways), *(word.strip("-") for word in more)])[:200]
    common = ["-options_file", check.scene(scene), *more, *every(scene, steps, more)]
    whole, parts = check.folder(where + ".whole"), check.folder(where + ".parts")
    first = check.pebble(*common, "-time_max_steps", steps, "-output_dir", whole)
    if first.status == 2 and "dt" not in first.err:
        return None  # such a combination is refused
    last = None
    for k, (stop, way) in enumerate(zip([*stops, steps], ways)):
        last = check.pebble(*common, "-time_max_steps", stop, "-output_dir", parts, "-checkpoint_every", 1e30, *WAYS[way],
                            *(["-restart_file", "latest"] if k else []), n=processes(way))
        if last.status and last.status != first.status:
            check.that(False, f"{where}: exit status {last.status}: {last.said[-500:]}")
            return False
    what = f"{scene} {' '.join(more)} to step {steps}, stopped at {stops}, on {ways}"
    good = check.that(first.digest and first.digest == last.digest, f"{what}: digest {first.digest} and {last.digest}")
    good &= same(whole, parts, what)
    if good:
        shutil.rmtree(whole)
        shutil.rmtree(parts)
    return good


DT = {}


def every(scene, steps, more):
    """Options by which some lines and some snapshots fall into so many steps."""
    key = (scene, *more)
    if key not in DT:
        dry = check.pebble("-options_file", check.scene(scene), *more, "-dry_run", "-output_dir", "dry")
        found = dry.find(r"dt=(\S+) s")
        DT[key] = float(found) if found else 1
    dt = DT[key]
    return ["-history_every", f"{0.13 * steps * dt:.3g}", "-output_every", f"{0.29 * steps * dt:.3g}"]


def scenes():
    """Each scene, and every other one by two ways to run, which differ from scene to scene; counts has all with all."""
    pairs = [(1, 2), (3, 1), (2, 3), (1, "pool"), (2, 1), ("pool", "pool"), ("pool", 2), (3, "pool")]
    ways = itertools.cycle(way for pair in pairs for way in (pair, (1, 1)))
    jobs = [(scene, 12 if scene.endswith("3d") else 30, [7 if scene.endswith("3d") else 13], way)
            for scene, way in zip(SCENES, ways)]
    check.at_once(lambda job: stop_and_go(*job), jobs)


def counts():
    """Each scene through all ways to run and back to the first, in five restarts, so that each way is gone on from and gone on
    with once. Scenes go round in steps of 1 to 4, so that any four of them have all 20 pairs of ways. disks: any three ways."""
    ways = [1, 2, 3, 4, "pool"]
    jobs = [(scene, *((12, [2, 4, 6, 8, 10]) if scene.endswith("3d") else (30, [4, 9, 14, 19, 25])),
             [ways[(k // 4 + (1 + k % 4) * part) % 5] for part in range(6)]) for k, scene in enumerate(SCENES)]
    jobs += [("disks", 60, [20, 40], three) for three in itertools.product(ways, repeat=3) if len(set(three)) == 3]
    check.at_once(lambda job: stop_and_go(*job), jobs)


def methods():
    jobs = []
    for basis, update, transfer in itertools.product(
            ("linear", "gimp", "gimp stretch", "bspline2", "bspline3"), ("usf", "usl", "musl"),
            ("flip", "pic", "xpic", "apic", "aflip", "afmpm")):
        words = ["-method_basis", basis.split()[0], "-method_update", update, "-method_transfer", transfer]
        if basis.startswith("gimp"):
            words += ["-method_gimp_update", "stretch" if "stretch" in basis else "none"]
        jobs.append(("vortex", 14, [6], (1, 2), ("-mms_type", "vortex", *words)))
    jobs += [(scene, 20, [9], (2, 3), more) for scene, more in (
        ("disks", ("-history_energy", "true")), ("friction", ("-history_energy", "true")),
        ("column", ("-method_carry", "all")), ("cantilever", ("-history_energy", "true", "-method_carry", "all")),
        ("impact", ("-method_locking", "fbar")), ("disks3d", ("-method_locking", "fbar")),
        ("dambreak", ("-parallel_migrate", "direct")), ("disks", ("-parallel_balance", "auto")),
        ("drop", ("-parallel_balance", "equal")), ("gate", ("-bc_xmin_velocity", "5*sin(30*t)^2", "-damping_time", "0.1")))]
    jobs += [("gate", 160, [90], (2, 3), ("-bc_xmin_velocity", "5*sin(100*t)^2", "-damping_kinetic"))]
    done = check.at_once(lambda job: stop_and_go(*job), jobs)
    check.that(sum(d is True for d in done) >= 60, f"{sum(d is True for d in done)} of {len(jobs)} methods were not refused")


# ---- Files

BAR = None


def bar(folder, *more, n=1):
    return check.pebble("-options_file", check.scene("bar"), "-output_dir", folder, *more, n=n)


def ranks(process):
    """The processes of a run that take part in its steps."""
    found = []
    for pid in mpi.members(process.pid):
        try:
            with open(f"/proc/{pid}/comm") as file:
                name = file.read().strip()
        except OSError:
            continue
        if name == os.path.basename(check.program)[:15]:
            found.append(pid)
    return found


LONG = ["-time_end", "4000", "-history_every", "0.05", "-output_every", "1"]


def lines_of(history):
    return check.content(history).count(b"\n") if os.path.exists(history) else 0


def signalled(folder, which, n, only=None, more=()):
    """Starts a long run, signals its processes, or only that of one rank, when it runs, and returns its exit status and what
    it said."""
    command = [check.program, "-options_file", check.scene("bar"), *LONG, "-output_dir", folder, *more]
    if n > 1:
        command = [check.mpiexec, "-n", str(n), *command]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
                               env=os.environ | mpi.ENVIRONMENT)
    going = lambda: process.poll() is None
    mpi.until(lambda: lines_of(f"{folder}/bar.csv") > 4, going)
    for number in which:
        for pid in ranks(process):
            if only is None or mpi.rank_of(pid) == only:
                os.kill(pid, number)
        if number == signal.SIGUSR1:
            mpi.until(lambda: glob.glob(f"{folder}/bar-checkpoint-*.h5"), going)
    try:
        out, err = process.communicate(timeout=check.TIMEOUT)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        out, err = process.communicate()
    return process.returncode, *mpi.keep(out, err)


def signals():
    status, out, err = signalled(check.folder("worker"), [signal.SIGUSR1, signal.SIGTERM], 2, 1, ["-parallel_strategy", "pool"])
    check.that(status == 3 and len(re.findall("^checkpoint step", out, re.M)) >= 2 and "go on with" in err,
               f"signals to a worker of the pool alone: status {status} {err.strip()[-200:]}")
    for n, number in ((1, signal.SIGTERM), (1, signal.SIGINT), (2, signal.SIGTERM)):
        folder = check.folder(f"signal{n}{number}")
        status, out, err = signalled(folder, [signal.SIGUSR1, number], n)
        what = f"{signal.Signals(number).name} on {n}"
        written = re.findall(r"^checkpoint step (\d+)", out, re.M)
        check.that(status == 3 and len(written) >= 2, f"{what}: status {status}, checkpoints at steps {written}")
        line = re.search(r"go on with: (.*)", err)
        if not check.that(line and "-restart_file" in line.group(1), f"{what}: {err.strip()[-300:]}"):
            continue
        step = int(written[-1])
        more = line.group(1).split()[1:]
        on = check.pebble(*more, "-time_max_steps", step + 300, n=2)
        whole = check.pebble("-options_file", check.scene("bar"), *LONG, "-output_dir", check.folder("whole"), "-time_max_steps", step + 300)
        check.that(on.digest == whole.digest and on.digest, f"{what}: the line leads on to digest {on.digest}, {whole.digest}")
        same("whole", folder, what)


def damage():
    """A file that is cut off, or has one other byte, is refused, or passed over for the one before."""
    check.folder("damage")
    bar("damage", "-time_end", "0.5", "-checkpoint_every", "0.2")
    files = sorted(glob.glob("damage/bar-checkpoint-*.h5"), key=lambda path: int(path.split("-")[-1][:-3]))
    check.need(len(files) == 2, f"{files}: two checkpoints are kept")
    good = check.content(files[-1])
    rng = random.Random(20)
    cuts = [("cut", n) for n in (0, 1, 17, 511, 512, 2000, len(good) // 2, len(good) - 8, len(good) - 1)]
    flips = [("flip", rng.randrange(len(good))) for _ in range(25)] + [("more", 1)]
    for how, at in cuts + flips:
        bad = good[:at] if how == "cut" else good + b"\0" if how == "more" else \
            good[:at] + bytes([good[at] ^ (1 << rng.randrange(8))]) + good[at + 1:]
        with open(files[-1], "wb") as file:
            file.write(bad)
        named = bar("damage", "-time_end", "0.5", "-restart_file", files[-1], "-dry_run")
        last = bar("damage", "-time_end", "0.5", "-restart_file", "latest", "-dry_run")
        check.fault(None if named.status == 2 and len(named.lines) == 1 and files[-1] in named.err
                    else f"{how} {at}: status {named.status}: {named.said[-300:]}")
        check.fault(None if last.status == 0 and "warning" in last.out and files[0] in last.out
                    else f"{how} {at}: latest: status {last.status}: {last.said[-300:]}")
    check.that(True, f"{len(cuts + flips)} damaged files: each is refused in one line, and latest takes the one before")
    with open(files[0], "r+b") as file:
        file.truncate(3000)
    none = bar("damage", "-time_end", "0.5", "-restart_file", "latest")
    check.that(none.status == 2 and len(none.lines) == 1, f"no whole one: {none.err.strip()}")


def options():
    check.folder("one")
    bar("one", "-time_end", "0.5", "-checkpoint_every", "0.2")
    go = ["-time_end", "0.5", "-restart_file", "latest"]
    for more, words in ((("-grid_cells", "66"), ("-grid_cells", "33", "66")),
                        (("-material_spring_rho", "1.1"), ("-material_spring_rho", "1.1")),
                        (("-method_preset", "fast"), ("-method_preset", "not given", "fast"))):
        run = bar("one", *go, *more)
        check.that(run.status == 2 and len(run.lines) == 1 and all(word in run.err for word in words),
                   f"{' '.join(more)} may not change: {run.err.strip()}")
    run = bar("one", "-time_end", "0.2", "-restart_file", "latest")
    check.that(run.status == 2 and "-time_end" in run.err, f"-time_end before the checkpoint: {run.err.strip()}")
    run = bar("one", "-time_end", "1", "-dt_cfl", "0.1", "-restart_file", "latest")
    check.that(run.status == 0 and "-time_end 1, was 0.5" in run.out and "-dt_cfl 0.1, was 0.2" in run.out,
               "options that differ are listed: " + (run.find(r"^(restart +changed.*)$") or run.err))
    steps = [int(row["step"]) for row in check.rows("one/bar.csv")]
    check.that(steps == sorted(set(steps)) and float(check.rows("one/bar.csv")[-1]["time"]) == 1,
               f"a finished run goes on to a later -time_end: {len(steps)} lines of the history, none twice")
    run = bar("one", "-restart_file", "one/bar.h5")
    check.that(run.status == 2 and len(run.lines) == 1, f"not a checkpoint: {run.err.strip()}")
    first = bar(check.folder("keep"), "-time_end", "0.5", "-checkpoint_every", "0.05", "-checkpoint_keep", "4")
    kept = sorted(int(path.split("-")[-1][:-3]) for path in glob.glob("keep/bar-checkpoint-*.h5"))
    check.that(len(kept) == 4 and kept[-1] - kept[0] == 3, f"-checkpoint_keep 4: {kept}")
    again = bar("keep", "-time_end", "0.5")
    check.that("-restart_file latest" in again.out, "a run that starts anew tells of the checkpoints that are there")
    shutil.copy(check.scene("bar"), "keep/bar-checkpoint-1.h5")
    bar("keep", "-time_end", "0.2", "-checkpoint_every", "0.05")
    check.that(check.content("keep/bar-checkpoint-1.h5") == check.content(check.scene("bar")),
               "another file with the name of an old checkpoint is left")
    kept = sorted(int(path.split("-")[-1][:-3]) for path in glob.glob("keep/bar-checkpoint-*.h5"))
    for path in glob.glob("keep/bar.csv") + glob.glob("keep/bar.h5") + glob.glob("keep/bar*.xdmf"):
        os.rename(path, path + ".moved")
    os.rename("keep/bar.snapshots", "keep/moved.snapshots")
    run = bar("keep", "-output_replace", "false")
    check.that(run.status == 2 and len(run.lines) == 1 and "checkpoint" in run.err, f"checkpoints alone: {run.err.strip()}")
    run = bar("keep", "-output_name", "bar-checkpoint-3")
    check.that(run.status == 2 and len(run.lines) == 1, f"the name of a checkpoint: {run.err.strip()}")
    first = bar("keep", "-time_end", "0.5", "-checkpoint_every", "0.05")
    kept = sorted(int(path.split("-")[-1][:-3]) for path in glob.glob("keep/bar-checkpoint-*.h5"))
    for path in ("keep/bar.h5", f"keep/bar-checkpoint-{kept[-1]}.h5"):
        run = check.pebble("-rerun", path, "-output_dir", check.folder("again"))
        check.that(run.digest == first.digest and os.path.exists("again/bar.csv"), f"-rerun {path}: digest {run.digest}")
    run = check.pebble("-rerun", "keep/bar.h5")
    check.that(run.status == 2 and len(run.lines) == 1 and "-output_dir" in run.err, f"-rerun onto itself: {run.err.strip()}")
    run = check.pebble("-rerun", check.scene("bar"))
    check.that(run.status == 2 and len(run.lines) == 1, f"-rerun of a text: {run.err.strip()}")
    # Files of versions that had -pool_particles, which is no option any more.
    for path in ("keep/bar.h5", f"keep/bar-checkpoint-{kept[-1]}.h5"):
        with h5py.File(path, "r+") as file:
            file.attrs["options"] = np.bytes_(file.attrs["options"] + b"-pool_particles workers\n")
        run = check.pebble("-rerun", path, "-output_dir", check.folder("again"))
        check.that(run.digest == first.digest and f"note       {path} is of a run with -pool_particles workers, which is no option any more" in run.out,
                   f"-rerun {path} of a pool whose workers kept the particles: digest {run.digest} {run.err.strip()}")


def others():
    """A run goes on with its own results, and with no other's."""
    go = ["-dt_size", "5e-4", "-time_end", "0.4", "-restart_file"]
    bar(check.folder("mine"), "-dt_size", "5e-4", "-time_end", "0.3", "-checkpoint_every", "0.1")
    other = check.folder("other")
    soft = ["-options_file", check.scene("bar"), "-material_spring_E", "200", "-dt_size", "5e-4", "-output_dir", other]
    check.must(*soft, "-time_end", "0.3")
    run = bar(other, *go, "mine/bar-checkpoint-2.h5", "-output_replace", "false")
    check.that(run.status == 2 and "-output_replace false" in run.err, f"another run's results are kept: {run.err.strip()}")
    run = bar(other, *go, "mine/bar-checkpoint-2.h5")
    said = [line for line in run.out.splitlines() if line.startswith("warning") and other in line]
    times = [float(row["time"]) for row in check.rows(other + "/bar.csv")]
    check.that(run.status == 0 and len(said) == 2 and min(times) > 0.2,
               f"another run's results are not taken for those of this one, which {len(said)} warnings say")
    shutil.rmtree("gap", ignore_errors=True)
    shutil.copytree("mine", "gap")
    lines = check.content("gap/bar.csv").decode().splitlines(True)
    check.write("gap/bar.csv", "".join(lines[:5] + lines[9:]))
    run = bar("gap", *go, "latest")
    check.that(run.status == 0 and any("bar.csv" in line for line in run.out.splitlines() if line.startswith("warning")),
               "a history with a gap is told")
    run = bar("mine", *go, "latest", "-material_spring_E", "1e2", "-grid_lower", "0.0", "-output_format", "hdf5")
    check.that(run.status == 0, f"the same values in other words: {run.err.strip()}")
    # The line that goes on, with -rerun and with quotes.
    title = ["-scene_title", "it's a bar", "-time_end", "400", "-history_every", "0.05"]
    bar(check.folder("first"), "-time_end", "0.1")
    command = [check.program, "-rerun", "first/bar.h5", "-output_dir", check.folder("again"), *title]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=os.environ | mpi.ENVIRONMENT)
    mpi.until(lambda: lines_of("again/bar.csv") > 4, lambda: process.poll() is None)
    process.send_signal(signal.SIGHUP)
    _, err = mpi.keep(*process.communicate(timeout=check.TIMEOUT))
    line = err.partition("go on with: ")[2].strip()
    run = check.run(["bash", "-c", line + " -time_max_steps 100"])
    check.that(process.returncode == 3 and run.status == 0 and "\nrestart " in run.out,
               f"SIGHUP, -rerun and quotes: {line}: status {run.status} {run.err.strip()}")
    run = check.pebble("-rerun", "again/bar.h5", "-output_dir", check.folder("twice"), "-time_end", "0.1")
    check.that(run.status == 0 and "\nnote " in "\n" + run.out and "continued from a checkpoint" in run.out,
               "-rerun of a run that went on says so")


def full_disk():
    """A checkpoint that does not fit ends the run; the one before stays whole."""
    for limit in (40, 70):  # KiB: too little for the checkpoint, or for the history that comes first
        folder = check.folder(f"full{limit}")
        bar(folder, "-time_end", "0.2", "-checkpoint_every", "0.1")
        before = {path: check.content(path) for path in glob.glob(f"{folder}/bar-checkpoint-*.h5")}
        run = check.run(["bash", "-c", f"ulimit -f {limit}; trap '' XFSZ; exec \"$@\"", "bash", check.program,
                         "-options_file", check.scene("bar"), "-output_dir", folder, "-time_end", "0.5",
                         "-body_bar_ppc", "64", "-checkpoint_every", "0.1", "-output_format", "none"])
        now = {path: check.content(path) for path in before if os.path.exists(path)}
        check.that(run.status == 3 and len(run.lines) == 1 and "File too large" in run.err and "checkpoint" in run.err,
                   f"at most {limit} KiB: status {run.status}: {run.err.strip()}")
        check.that(now == before, f"{len(now)} of {len(before)} checkpoints are as they were")
        check.that(not glob.glob(f"{folder}/*pebble-new*"), "nothing unfinished is left")
    folder = check.folder("gone")
    run = check.run(["bash", "-c", f"(while [ ! -s {folder}/bar.csv ]; do sleep 0.01; done; rm -rf {folder}) & exec \"$@\"",
                     "bash", check.program, "-options_file", check.scene("bar"), "-output_dir", folder, "-time_end", "400",
                     "-history_every", "100", "-output_format", "none", "-checkpoint_wall", "0.2"])
    check.that(run.status == 3 and len(run.lines) == 1 and "No such file" in run.err,
               f"a folder that vanishes: status {run.status}: {run.err.strip()}")


def files():
    signals()
    damage()
    options()
    others()
    full_disk()


def plain(path):
    """Seconds in which as many bytes as a file has are written to the same folder, by one process, and are on the disk."""
    data, to = check.content(path), path + ".plain"
    began = time.monotonic()
    with open(to, "wb", buffering=0) as file:
        for at in range(0, len(data), 1 << 26):
            file.write(data[at:at + (1 << 26)])
        os.fsync(file.fileno())
    seconds = time.monotonic() - began
    os.remove(to)
    return seconds


def large():
    folder = check.folder("large")
    disks = ["-options_file", check.scene("disks"), "-grid_cells", "500,500", "-output_format", "none", "-output_dir", folder]
    ratios, size = [], 0
    for _ in range(5):
        run = check.must(*disks, "-time_max_steps", "1", "-checkpoint_every", "1e30")
        path, size, seconds = re.search(r"^checkpoint .*: (\S+), (\S+) MB in (\S+) s$", run.out, re.M).groups()
        ratios.append(plain(path) / float(seconds))
    ratios.sort()
    command = [check.mpiexec, "-n", "2", check.program, *disks, "-history_every", "0"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
                               env=os.environ | mpi.ENVIRONMENT)
    mpi.until(lambda: lines_of(f"{folder}/disks.csv") > 4, lambda: process.poll() is None)
    began = time.monotonic()
    for pid in ranks(process):
        os.kill(pid, signal.SIGTERM)
    out, err = process.communicate(timeout=check.TIMEOUT)
    seconds = time.monotonic() - began
    check.that(process.returncode == 3 and "go on with" in err and re.search("^checkpoint", out, re.M),
               f"SIGTERM on 2 processes: status {process.returncode}: {err.strip()[-200:]}")
    print(f"figures    checkpoint: 1,005,304 particles, {size} MB, on one process {ratios[2]:.2f} ({ratios[0]:.2f} to "
          f"{ratios[-1]:.2f}) times as fast as a plain write; {seconds:.1f} s from SIGTERM to the end of 2 processes")
    shutil.rmtree(folder)


{"large": large, "scenes": scenes, "counts": counts, "methods": methods, "files": files}[words[0]]()
print(f"figures    restarts: {check.checks} checks of {words[0]}, {check.failures} failed")
check.end()
