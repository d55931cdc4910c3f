"""Pebble from Python: what a run returns, errors, files; and the command pebble-study: what it refuses, going on where
it ended, the same on several processes, the finest run in place of a solution, exit statuses.

usage: test_lab.py PEBBLE SOURCE MPIEXEC"""

import os
import re
import subprocess
import sys

import numpy as np

import check
import mpi
import studying

check.arguments(__doc__, 0)
os.environ.update(mpi.ENVIRONMENT | dict(os.environ) | {"PEBBLE": check.program, "MPIEXEC": check.mpiexec})
sys.path.insert(0, os.path.join(check.source, "lab"))
import pebble_mpm as pebble  # noqa: E402 (after the path)

BAR = [
    "-dim 1",
    "-grid_lower 0",
    "-grid_upper 1",
    "-grid_cells 8",
    "-bc_xmin_type fixed",
    "-bc_xmax_type fixed",
    "-materials m",
    "-material_m_model elastic",
    "-material_m_rho 1",
    "-material_m_E 1",
    "-material_m_nu 0",
    "-bodies b",
    "-body_b_shape box",
    "-body_b_lower 0",
    "-body_b_upper 1",
    "-body_b_material m",
    "-method_basis bspline2",
    "-method_update musl",
    "-method_transfer flip",
    "-dt_cfl 0.4",
    "-time_end 0.5",
]
SWINGS = ["-reference_type", "standing", "-reference_amplitude", "0.05"]
bar = check.write("bar.opts", BAR)


# ---- The module
def same(options, **more):
    """The digest that the program alone prints."""
    return check.must(*options, "-output_dir", "alone", **more).digest


result = pebble.run(check.scene("mms"), grid_cells=(8, 8), output_every=0.01, time_end=0.02, history_every=0)
check.that(
    result.status == 0
    and result.digest == same(["-options_file", check.scene("mms"), "-grid_cells", "8,8", "-time_end", "0.02"]),
    f"a run with options of Python: {result.digest}",
)
history, last = result.history, result.snapshots[-1]
check.that(
    result.steps == history["step"][-1] == last.step
    and result.time == last.time == history["time"][-1] == 0.02
    and len(history["time"]) == result.steps + 1,
    f"{result.steps} steps to {result.time} s, in the history and the snapshot",
)
check.that(
    len(result.snapshots) == 3
    and list(result.snapshots.steps) == sorted(result.snapshots.steps)
    and result.snapshots.times[0] == 0
    and last.digest == result.digest,
    f"snapshots at {result.snapshots.times}",
)
mass = 1000 / 256
check.that(
    last.particles["v"].shape == (256, 3)
    and (np.diff(last.particles["id"]) == 1).all()
    and set(last.grid) == {"mass", "v"}
    and "stress" in last.particles
    and abs(0.5 * mass * (last.particles["v"] ** 2).sum() / history["kinetic_energy"][-1] - 1) < 1e-12,
    "fields of particles by their ids, and of the grid: kinetic energy as in the history",
)
folder, snapshot = result.folder, result.snapshots[0]
del result, last
check.that(os.path.isdir(folder) and snapshot.particles["x"].shape == (256, 3), "a snapshot keeps the temporary folder")
del snapshot
check.that(not os.path.exists(folder), "which is removed with the last of them")
words = [word for line in BAR for word in line.split()] + SWINGS
result = pebble.run(words, folder="own", output_name="name", history_walls="all")
known = pebble.load("own/name.h5")
check.that(
    0 < result.error < 0.1 * result.size
    and result.name == "name"
    and "reaction_xmin_x" in known.history
    and (known.history["time"] == result.history["time"]).all()
    and len(known.snapshots) == len(result.snapshots)
    and known.snapshots.attributes["dim"] == 1,
    f"words of a command line, a folder, files that are read again: error {result.error} of {result.size} m",
)
at_zero = pebble.run(words, time_end=1e-9)
check.that(
    at_zero.size == at_zero.size and at_zero.size < 1e-8,
    f"the size of a solution is there where it is next to nothing: {at_zero.size}",
)
one, two = (pebble.run(check.scene("disks"), n, time_max_steps=20, output_format="none") for n in (1, 2))
check.that(
    one.digest == two.digest and one.digest and len(one.snapshots) == 0,
    f"two processes have the bits of one: {two.digest}",
)
warned = pebble.run(check.scene("bar"), dry_run=True)
check.that(
    len(warned.warnings) == 1
    and warned.warnings[0].startswith("linear with musl and flip amplifies noise")
    and warned.folder is None,
    f"warnings: {warned.warnings}",
)
check.that(
    pebble.run(bar, dry_run=True, output_replace=False, gravity=np.array([0.0]), dt_cfl=np.float64(0.3)).status == 0,
    "booleans, arrays, numbers of NumPy",
)
for name, options, status, expected in (
    ("a wrong value", {"dt_cfl": 0}, 2, "-dt_cfl 0 is outside the allowed range 0 < dt_cfl <= 2"),
    ("an unknown option", {"dt_clf": 0.2}, 2, "-dt_clf"),
    ("a run that stops", {"check_energy": 1e-9, "body_b_velocity": "x"}, 3, "stopped at step "),
):
    try:
        pebble.run(bar, **options)
        check.that(False, f"{name} raises an Error")
    except pebble.Error as error:
        check.that(
            error.status == status and str(error).startswith(expected) and "\n" not in str(error), f"{name}: {error}"
        )
        if status == 3:
            check.that(
                error.result.steps > 0
                and len(error.result.history["time"]) > 1
                and error.result.time > 0
                and error.result.reason.startswith("energy changed by"),
                "its history is there",
            )
stopped = pebble.run(bar, check=False, check_energy=1e-9, body_b_velocity="x")
check.that(stopped.status == pebble.STOPPED and stopped.steps > 0, "check=False: it returns its result")
for what, wrong in (
    (lambda: pebble.run(bar, timeout=0.01), subprocess.TimeoutExpired),
    (lambda: pebble.load("nowhere"), FileNotFoundError),
    (lambda: pebble.run(bar, program="/nowhere"), FileNotFoundError),
):
    try:
        what()
        check.that(False, f"{wrong.__name__} is raised")
    except wrong as error:
        check.that(True, f"{wrong.__name__}: {str(error)[:80]}")


# ---- The command
studying.prepare()
study = studying.study


def command(kind, scene, *words):
    """The command as it is started."""
    words = [os.path.join(check.source, "pebble-study"), kind, scene, *words]
    done = subprocess.run(words, capture_output=True, text=True, timeout=300)
    return check.Run(done.returncode, done.stdout, done.stderr)


def rows(folder, end, name="bar"):
    return check.rows(os.path.join(folder, f"{name}_{end}.csv"))


REFUSED = [
    (["convergence", "--levels", "13"], "--levels 13 is outside the allowed range 2 <= levels <= 12"),
    (["stability", "--levels", "3"], "--levels is of another study than stability"),
    (["stability", "--steps", "10"], "--steps 10 is outside the allowed range"),
    (["convergence", "--value", "1"], "--value does not apply: it is that of --quantity"),
    (
        ["convergence", "--quantity", "front"],
        "--quantity front is no column of the history: choose one of step|time|dt|",
    ),
    (["convergence", "--quantity", "mass:mean"], "--quantity mass:mean: choose :max, :min or :end"),
    (
        ["convergence", "--vary", "ppc"],
        "--vary ppc does not apply: comparison with the finest run takes other grids or time steps",
    ),
    (["convergence", "--levels", "2", "--order-min", "1"], "--levels 2 leaves no order for --order-min"),
    (
        ["convergence", "-time_max_steps", "5"],
        "-time_max_steps does not apply: the runs of a study end at the same time",
    ),
    (["convergence", "-checkpoint_every", "1"], "-checkpoint_every does not apply"),
    (["convergence", "-study_levels", "3"], "-study_levels is no option: it is --levels of pebble-study"),
    (["convergence", "-dt_clf", "0.2"], "-dt_clf"),
    (["convergence", "-levels", "3"], "-levels is an option of the study: write it with two dashes, --levels"),
    (["convergence", "--program", "/nonexistent/pebble"], "--program /nonexistent/pebble: there is no such program"),
    (["convergence", "-output_dir", f"{bar}/inside"], f"-output_dir {bar}/inside: Not a directory"),
    (
        ["convergence", "--vary", "ppc", "-body_b_ppc", "40", "--levels", "2", *SWINGS],
        "run 2 of the study: -body_b_ppc",
    ),
    (
        ["trade", "--basis", "gimp,spline"],
        "--basis spline: choose a list of linear gimp bspline2 bspline3 gimp_stretch",
    ),
    (
        ["trade", "--transfer", "apic:0.9"],
        "--transfer apic:0.9: this transfer takes neither -method_flip nor -method_order",
    ),
    (["trade", "--transfer", "flip:most"], "--transfer flip:most: no number stands after the colon"),
    (["trade", "--ppc", "2,2.5"], "--ppc 2,2.5: the numbers must be whole"),
    (["stability", "-method_preset", "solid", "--update", "usl"], "--update does not apply: the scene is in the total frame, which has none"),
    (["trade", "--ppc", "65"], "--ppc 65: choose a list of numbers > 0, at most 64"),
    (["trade", "--cfl", "0.2", "-dt_size", "1e-3"], "--cfl does not apply: -dt_size is fixed"),
    (["trade", "--coarser", "4"], "--coarser 4: the 8 cells on axis x are no multiple of 16"),
    (["trade", "--basis", "gimp", "--preset", "none"], "--basis: without a known solution two bases are needed"),
    (
        ["convergence", "-probes", "p", "-probe_p_particle", "3", "--quantity", "probe_p_velocity_x"],
        "--quantity probe_p_velocity_x does not apply: on each grid another particle",
    ),
]
for (kind, *words), line in REFUSED:
    told = study(kind, bar, *words)
    last = told.err.strip().splitlines()[-1:] or [""]
    check.that(told.status == 2 and line in last[0], f"{kind} {' '.join(words)}: {last[0]}")
old = check.write("old.opts", BAR + ["-reference_type finest"])
told = command("convergence", old)
check.that(
    told.status == 2 and len(told.err.splitlines()) == 1 and "-reference_type finest" in told.err,
    f"-reference_type finest: {told.err.strip()}",
)

check.write("points.csv", "x,volume\n0.25,0.5\n0.75,0.5\n")
loose = [line for line in BAR if not re.match("-body_b_(lower|upper|shape)", line)]
told = study("convergence", check.write("points.opts", [*loose, "-body_b_shape file", "-body_b_file points.csv"]))
line = "a study does not apply: the particles of b come from a file, and cannot be made finer"
check.that(told.status == 2 and told.err.strip() == line, f"particles of a file: {told.err.strip()}")
check.folder("other")
check.write("other/bar_study.csv", "of,another\n1,2\n")
told = study("convergence", bar, "-output_dir", "other", *SWINGS)
check.that(
    told.status == 2
    and told.err.strip() == "other/bar_study.csv is not the table of a study; move the file away"
    and check.content("other/bar_study.csv").startswith(b"of,"),
    f"another file of that name: {told.err.strip()}",
)
leaves = [
    "-bc_xmax_type free",
    "-particles_leave delete",
    '-body_b_velocity "1+0.1*x"',
    "-time_end 0.2",
    "-body_b_upper 0.9",
]
kept = [line for line in BAR if line.split()[0] not in [option.split()[0] for option in leaves] + ["-bc_xmin_type"]]
told = study("convergence", check.write("leaves.opts", kept + leaves), "-output_dir", "leaves", "--levels", "3")
errors = [float(row["error"] or 0) for row in rows("leaves", "study", "leaves")] if told.status == 0 else []
check.that(
    told.status == 0
    and len(errors) == 3
    and 0 < errors[0] < 1e-2
    and max(pebble.load("leaves/leaves-3").history["lost_mass"]) > 0,
    f"particles that leave are not compared: {errors} {told.err}",
)

disk = ["-dim 2", "-grid_lower -0.5,-0.5", "-grid_upper 0.5,0.5", "-grid_cells 8,8", "-materials m", "-material_m_model neohookean", "-material_m_rho 1000", "-material_m_E 1e4",
        "-material_m_nu 0.3", "-bodies b", "-body_b_shape sphere", "-body_b_center 0,0", "-body_b_radius 0.3", "-body_b_material m", '-body_b_velocity "0.3*x,0-0.3*y"', "-time_end 0.1"]  # fmt: skip
told = study("convergence", check.write("cut.opts", disk), "-output_dir", "cut", "--levels", "4")
errors = [float(row["error"] or 0) for row in rows("cut", "study", "cut")] if told.status == 0 else []
check.that(
    told.status == 0 and len(errors) == 4 and errors[0] > 2.5 * errors[1] > 5 * errors[2] > 0,
    f"a disk whose particles start beside their lattice (-method_rim cut): {errors} {told.err}",
)

words = ["-output_dir", "known", "--levels", "3", *SWINGS]
first = command("convergence", bar, *words)
before = check.content("known/bar_study.csv")
again = study("convergence", bar, *words)
check.that(
    first.status == again.status == 0
    and len(re.findall("^run  ", first.out, re.M)) == len(re.findall("^known  ", again.out, re.M)) == 3
    and check.content("known/bar_study.csv") == before,
    f"the same study again: no run is made, the table is the same {first.err}{again.err}",
)
check.that(check.content("known/bar_study.png").startswith(b"\x89PNG"), "it is drawn")
other = study("convergence", bar, *words, "-time_end", "0.25")
check.that(len(re.findall("^run  ", other.out, re.M)) == 3, "another time_end: all runs anew")
least = study("convergence", bar, *words, "-time_end", "0.25", "--order-min", "9")
check.that(
    least.status == 3 and len(least.err.splitlines()) == 1 and "is below --order-min 9" in least.err,
    f"--order-min: {least.err.strip()}",
)
finest = ["--levels", "3", "-body_b_velocity", "1e-2*pi*sin(pi*x)"]
plain = [
    {key: value for key, value in row.items() if key not in ("seconds", "key")}
    for n in ("1", "2")
    for row in (
        study("convergence", bar, *finest, "--processes", n, "-output_dir", f"finest{n}"),
        rows(f"finest{n}", "study"),
    )[1]
]
check.that(
    plain[:3] == plain[3:]
    and len(plain) == 6
    and plain[2]["error"] == ""
    and 0 < float(plain[1]["error"]) < float(plain[0]["error"]),
    f"against the finest run, on 1 and 2 processes: {[row['error'] for row in plain]}",
)
dry = study("trade", bar, "--dry-run", *SWINGS, "-output_dir", "dry")
check.that(
    dry.status == 0
    and len(re.findall(r"^runs +.* 4 of 4 grids, about \S+ \w+$", dry.out, re.M)) > 5
    and not os.path.exists("dry"),
    f"--dry-run lists settings and leaves no file {dry.err}",
)
words = ["--basis", "linear,bspline2", "--update", "usl,musl", "--transfer", "flip,pic,xpic:3", "--preset", "none"]
skipped = re.findall(r"^skipped +(\S+ \S+ \S+): (.*)$", study("trade", bar, "--dry-run", *words, *SWINGS).out, re.M)
for name, why in (
    ("linear usl flip", "is unstable where"),
    ("bspline2 usl pic", "stops all motion"),
    ("bspline2 musl xpic:3", "was wrong by"),
):
    check.that(dict(skipped).get(name, "").startswith(why), f"{name} is skipped: {dict(skipped).get(name)}")
words = ["--preset", "balanced", "--cfl", "0.4,0.8"]
dry = study("trade", bar, "--dry-run", *words, *SWINGS, "-output_dir", "dry")
names = re.findall(r"^runs +(.*?) +\d of \d grids", dry.out, re.M)
check.that(
    {"bspline3 usl aflip, cfl 0.4", "bspline3 usl aflip, cfl 0.8", "preset balanced, cfl 0.4", "preset balanced, cfl 0.8"} <= set(names) and len(names) <= 7,
    f"--cfl is for methods and presets, and presets alone are few settings: {names} {dry.err}",
)
few = [
    "--levels",
    "2",
    "--repeats",
    "1",
    "--basis",
    "bspline2,gimp_stretch",
    "--update",
    "usl,musl",
    "--transfer",
    "flip",
    "--preset",
    "none",
    *SWINGS,
    "-output_dir",
    "trade",
]
made = study("trade", bar, *few, draws=True)
table = rows("trade", "workprecision")
check.that(
    made.status == 0 and len(table) == 4 * 2 and sum(row["front"] == "1" for row in table) >= 1,
    f"trade: {len(table)} runs {made.err}",
)
check.that(check.content("trade/bar_workprecision.png").startswith(b"\x89PNG"), "trade: it is drawn")
touching = study("trade", check.scene("disks_contact"), "--levels", "2", "--coarser", "1", "--repeats", "1", "--basis", "bspline2,gimp", "--update", "usl",
                 "--transfer", "aflip", "--preset", "none", "-time_end", "1.2", "-output_dir", "touch")  # fmt: skip
errors = {(row["basis"], row["cells"]): float(row["error"]) for row in check.rows("touch/disks_contact_workprecision.csv") if row["study"] == "run"}
check.that(
    touching.status == 0 and all(0 < errors[basis, "40x40"] < 0.7 * errors[basis, "20x20"] < 0.1 for basis in ("bspline2", "gimp")),
    f"trade of bodies that meet: errors {errors} {touching.err}",
)
lines = check.content("trade/bar_workprecision.csv").decode().splitlines()
check.write("trade/bar_workprecision.csv", lines[:4])
rest = study("trade", bar, *few)
check.that(
    len(re.findall(r"^\d+/5 ", rest.out, re.M)) == 5
    and "note       3 runs are in" in rest.out
    and [row["error"] for row in rows("trade", "workprecision")] == [row["error"] for row in table],
    "with three runs in the table the others are made, with the same errors",
)
more = study("trade", bar, *few, "--repeats", "2", "--basis", "gimp_stretch", "--update", "musl")
table = rows("trade", "workprecision")
check.that(
    [row["repeats"] for row in table if row["study"] == "run"] == ["2"] * 4
    and sum(row["study"] == "other" for row in table) == 4,
    "more repeats of a smaller study; the other rows are kept",
)
check.write("trade/bar_workprecision.csv", "study,basis\n1,2\n")
foreign = study("trade", bar, *few)
check.that(
    foreign.status == 2
    and foreign.err.strip().endswith(
        "line 1 of trade/bar_workprecision.csv is not of a work-precision study; move the file away"
    ),
    f"another file of that name: {foreign.err.strip()}",
)
steps = ["--steps", "100", "--basis", "linear", "--update", "usl", "--transfer", "apic", "-output_dir", "stable"]
found = study("stability", bar, *steps)
row = rows("stable", "stability")[0]
check.that(
    found.status == 0 and float(row["crossing_unstable"]) <= 0.5 and float(row["rest"]) > 0,
    f"linear usl apic is unstable where particles cross: {row['crossing']} {found.err}",
)
check.that(
    float(row["crossing_growth"]) > 10 and f"crossing {row['crossing_growth']} at {row['crossing_unstable']}" in found.out,
    f"its strain energy grows e-fold {row['crossing_growth']} times in 1,000 steps",
)
again = study("stability", bar, *steps)
check.that(rows("stable", "stability")[0] == row and again.status == 0, "it goes on from its table")
listed = study("stability", bar, "--dry-run", "--basis", "linear,bspline3")
check.that(listed.status == 0 and len(listed.out.split(" valid\n")) == 3, "--dry-run lists the methods")
still = study("stability", bar, "-output_dir", "still", "--steps", "400", "--basis", "linear,bspline2", "-method_preset", "solid")
table = check.rows("still/bar_stability.csv")
check.that(
    still.status == 0
    and [(row["basis"], row["order"], row["table_rest"], row["crossing"]) for row in table] == [("linear", "2", "0.25", ""), ("bspline2", "2", "0.83", "")]
    and all(abs(float(row[probe]) - float(row["table_rest"])) < 0.1 for row in table for probe in ("block", "disk")),
    f"in the total frame: bounds at rest of bars, blocks and disks {[[row[probe] for probe in ('rest', 'block', 'disk')] for row in table]} {still.err}",
)
check.end()
