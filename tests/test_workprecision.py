"""Work-precision studies (-study_type workprecision): errors are those of single runs, what is refused or warned of is
skipped with a line, the front and the cheapest settings of made-up numbers, going on where a study ended, references by a
finer run, several processes, files and the plot.

usage: test_workprecision.py PEBBLE SOURCE MPIEXEC
"""
import csv
import math
import os
import re
import shlex
import subprocess
import sys
from xml.etree import ElementTree

import check

COLUMNS = ("study,basis,gimp_update,update,transfer,flip,order,strain,rate,ppc,cells,cfl,h,particles,steps,seconds,seconds_min,seconds_max,"
           "ns,memory,error,status,front,repeats,key,note")
BAR = ["-dim 1", "-grid_lower 0", "-grid_upper 1", "-grid_cells 8", "-bc_xmin_type fixed", "-bc_xmax_type fixed",
       "-materials m", "-material_m_model elastic", "-material_m_rho 1", "-material_m_E 1", "-material_m_nu 0",
       "-bodies b", "-body_b_shape box", "-body_b_lower 0", "-body_b_upper 1", "-body_b_material m",
       "-method_basis bspline2", "-method_update musl", "-method_transfer flip", "-dt_cfl 0.4", "-time_end 0.5"]
KNOWN = ["-reference_type standing", "-reference_amplitude 0.05"]
STUDY = ["-study_type workprecision", "-study_levels 3", "-study_repeats 1", "-study_basis linear,bspline2,gimp_stretch", "-study_update usl,musl", "-study_transfer flip,apic", "-study_preset none"]
WATER = ["-dim 2", "-grid_lower 0,0", "-grid_upper 1,1", "-grid_cells 8,8", "-bc_xmin_type slip", "-bc_ymin_type slip", "-gravity 0,-1", "-materials w",
         "-material_w_model fluid", "-material_w_rho 1000", "-material_w_K 1e5", "-bodies b", "-body_b_shape box", "-body_b_lower 0,0", "-body_b_upper 0.5,0.5",
         "-body_b_material w", "-time_end 0.2", "-study_type workprecision", "-study_levels 2", "-study_repeats 1", "-study_basis gimp,bspline2,gimp_stretch,bspline3",
         "-study_update usl", "-study_transfer flip", "-study_preset none", "-method_basis bspline2", "-method_update musl", "-method_transfer flip", "-dt_cfl 0.4"]


class Study:
    """A run of a study in its folder: what it printed, and its table."""

    def __init__(self, folder, lines=None, *arguments, n=1):
        self.folder = folder
        self.scene, self.table = os.path.join(folder, "scene.opts"), os.path.join(folder, "scene_workprecision.csv")
        if lines:
            check.write(os.path.join(check.folder(folder), "scene.opts"), lines)
        told = check.pebble("-options_file", self.scene, "-output_dir", folder, *arguments, n=n)
        self.status, self.out, self.lines = told.status, told.out, told.lines
        self.every = check.rows(self.table) if os.path.exists(self.table) else []
        self.rows = [row for row in self.every if row.get("study") == "run"]

    def ended(self, name, rows):
        said = "" if self.status == 0 and len(self.rows) == rows else f"\n{self.out[-1500:]}{self.lines[:5]}"
        return check.that(self.status == 0 and not self.lines and len(self.rows) == rows, f"{name}: exit status {self.status}, {len(self.rows)} runs in the table (0, {rows}){said}")

    def cheapest(self, part):
        """Options and what the scene's own method loses, for 10 %, 1 % or 0.1 %."""
        found = re.search(rf"^for {part} % +(.*)\n(?: +error (\S+) %.*\n)?(?: +(.*)\n)?", self.out, re.M)
        check.need(found, f"the study says what is cheapest for {part} %: {self.out[-800:]}")
        return found[1], found[2] and float(found[2]), found[3]


def method(row):
    return row["basis"], row["gimp_update"], row["update"], row["transfer"], row["flip"], row["order"], row["strain"], row["rate"], row["ppc"], row["cfl"]


def errors(study):
    return {(*method(row), row["cells"]): row["error"] for row in study.every if row["study"] != "other"}


def check_runs():
    study = Study("runs", BAR + KNOWN + STUDY)
    skipped = re.findall(r"^skipped +(\S+ \S+ \S+): (.*)$", study.out, re.M)
    if not study.ended("bar", 3 * (12 - len(skipped))):
        return
    check.that({"linear usl flip", "linear usl apic", "linear musl apic"} <= {name for name, _ in skipped} and all("unstable where particles cross cells" in why for _, why in skipped),
               f"what the program warns of is skipped with a line: {skipped}")
    with open(study.table, encoding="utf-8") as file:
        check.that(file.readline().strip() == COLUMNS, "the columns of the table")
    check.that(sorted(os.listdir("runs")) == ["scene.opts", "scene_workprecision.csv"], f"its runs leave no files: {sorted(os.listdir('runs'))}")
    for row in (study.rows[0], study.rows[-1]):
        options = ["-method_basis", row["basis"], *(["-method_gimp_update", row["gimp_update"]] if row["gimp_update"] else []), "-method_update", row["update"],
                   "-method_transfer", row["transfer"], "-grid_cells", row["cells"]]
        alone = single(study, options)
        part, steps = float(alone.find(r"relative error is (\S+)$")), int(alone.find(r"^done +(\d+) steps"))
        check.that(abs(part / float(row["error"]) - 1) < 1e-3 and steps == int(row["steps"]), f"{row['basis']} with {row['cells']} cells: error {row['error']}, {row['steps']} steps; alone {part}, {steps}")
        check.that(float(row["seconds_min"]) <= float(row["seconds"]) <= float(row["seconds_max"]) and row["repeats"] == "1" and float(row["memory"]) > 0, "its times and memory")
        check.that(abs(float(row["ns"]) / (1e9 * float(row["seconds_min"]) / float(row["particles"]) / steps) - 1) < 1e-3, "its time a particle and step")
    options, error, _ = study.cheapest("1")
    alone = single(study, shlex.split(options))
    check.that(abs(100 * float(alone.find(r"relative error is (\S+)$")) / error - 1) < 0.06, f"the options for 1 % give its error, {error} %: {options}")
    check_resume(study)
    check_made_up(study)


def single(study, options):
    """One run of the scene with these options, without the study."""
    plain = check.write(os.path.join(study.folder, "plain.opts"), [line for line in open(study.scene, encoding="utf-8").read().splitlines() if not line.startswith("-study")])
    return check.must("-options_file", plain, "-output_dir", os.path.join(study.folder, "alone"), "-output_format", "none", *options)


def rewrite(study, rows):
    with open(study.table, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS.split(","), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def check_resume(first):
    before, every = check.content(first.table), len(first.rows)
    again = Study(first.folder)
    check.that(again.status == 0 and check.content(first.table) == before and f"note       {every} runs are in" in again.out and not re.search(r"^\d+/\d+ ", again.out, re.M),
               "the same study again: no run is made, a line says so, and the table is the same")
    rewrite(first, first.rows[:10])
    rest = Study(first.folder)
    check.that(len(re.findall(rf"^\d+/{every - 10} ", rest.out, re.M)) == every - 10 and "note       10 runs are in" in rest.out and errors(rest) == errors(first), "with 10 runs in the table the others are made, with the same errors")
    more = Study(first.folder, None, "-study_repeats", "3", "-study_basis", "gimp_stretch", "-study_levels", "2")
    check.that(len(more.rows) > 2 and all(row["repeats"] == "3" for row in more.rows), f"more repeats: two more of each run, {[row['repeats'] for row in more.rows]}")
    check.that({row["key"] for row in more.every} == {row["key"] for row in rest.every} and sum(row["study"] == "other" for row in more.every) == every - len(more.rows), "rows that a smaller study has not are kept as `other`")
    other = Study(first.folder, None, "-time_end", "0.25")
    check.that("not made again" not in other.out and len(other.rows) == every and len(other.every) == 2 * every, f"another time_end: all runs anew, {len(other.rows)} of {len(other.every)} rows")
    check.write(first.table, "study,basis,gimp_update,update,more\n1,2\n")
    foreign = Study(first.folder)
    check.that(foreign.status == 2 and len(foreign.lines) == 1 and foreign.lines[0].endswith("is not of a work-precision study; move the file away"), f"another file of that name: {foreign.lines}")
    rewrite(first, first.rows)


def check_made_up(first):
    """Times and errors of our own in the table, on which the study has only to report."""
    rows = [dict(row) for row in first.rows]
    made = {"linear": (2.0, 0.9, 1.0), "gimp": (1.0, 0.4, 2.0)}  # seconds and error on the first grid, order
    for row in rows:
        level = {"8": 0, "16": 1, "32": 2}[row["cells"]]
        seconds, error, order = made.get(row["basis"], (0.5, 0.3, 1.0))
        seconds *= 4 ** level * (1.5 if row["update"] == "musl" else 1) * (1.25 if row["transfer"] == "apic" else 1)
        error *= 2 ** (-order * level) * (0.8 if row["transfer"] == "apic" else 1)
        row.update(seconds=f"{1.02 * seconds:.6g}", seconds_min=f"{seconds:.6g}", seconds_max=f"{1.1 * seconds:.6g}", error=f"{error:.17g}", front="0")
    rewrite(first, rows)
    study = Study(first.folder)
    check.that(f"note       {len(rows)} runs are in" in study.out, "made-up numbers: no run is made")
    # a run whose steps are too long where particles cross cells is neither on the front nor recommended
    unstable = [row["note"].startswith("steps too long") for row in rows]
    check.that(0 < sum(unstable) < len(rows) and all(row["transfer"] != "flip" or row["update"] != "musl" or long for row, long in zip(rows, unstable)), f"{sum(unstable)} runs have steps that are too long")
    place = [(float(row["seconds_min"]), float(row["error"])) for row, long in zip(rows, unstable) if not long]
    front = [not long and not any(t <= float(row["seconds_min"]) and e <= float(row["error"]) and (t, e) != (float(row["seconds_min"]), float(row["error"])) for t, e in place)
             for row, long in zip(rows, unstable)]
    check.that([row["front"] == "1" for row in study.rows] == front and 0 < sum(front) < len(front), f"made-up numbers: {sum(front)} runs are on the front")
    options, error, loss = study.cheapest("10")
    cheap = min((row for row, long in zip(rows, unstable) if float(row["error"]) <= 0.1 and not long), key=lambda row: float(row["seconds_min"]))
    check.that(f"-method_basis {cheap['basis']}" in options and f"-method_transfer {cheap['transfer']}" in options and f"-grid_cells {cheap['cells']}" in options and abs(error - 100 * float(cheap["error"])) < 0.1,
               f"made-up numbers, for 10 %: {options}, error {error} %")

    def time(basis, update, transfer):
        """The time for an error of 10 %, between two grids."""
        points = [(float(row["seconds_min"]), float(row["error"])) for row in rows if (row["basis"], row["update"], row["transfer"]) == (basis, update, transfer)]
        for (t, e), (later, smaller) in zip(points, points[1:]):
            if e > 0.1 >= smaller:
                return t * (later / t) ** (math.log(e / 0.1) / math.log(e / smaller))
        return math.inf
    best = min(time(*key) for key in {(row["basis"], row["update"], row["transfer"]) for row, long in zip(rows, unstable) if not long})
    ratio, low, high = map(float, re.match(r"the scene's own method takes (\S+) \((\S+) to (\S+)\) times as long for this error", loss).groups())
    expected = time("bspline2", "musl", "flip") / best
    check.that(abs(ratio / expected - 1) < 0.01 and abs(low - ratio / 1.1) < 0.02 and abs(high - ratio * 1.1) < 0.02, f"made-up numbers: the scene's own method takes {ratio} times as long ({low} to {high}), expected {expected:.3f}")
    check.that(study.cheapest("0.1")[0].startswith("no run reached it"), f"made-up numbers, for 0.1 %: {study.cheapest('0.1')[0]}")
    check_plot(study, rows)


def check_plot(study, rows):
    command = re.search(r"^ +drawn by: \.venv/bin/python (tools/plot\.py) (\S+)$", study.out, re.M)
    check.need(command, "the study prints how to draw it")
    script = os.path.join(check.source, command[1])
    drawn = subprocess.run([sys.executable, script, command[2]], capture_output=True, text=True, timeout=60)
    check.that(drawn.returncode == 0 and not drawn.stderr and check.content(study.table[:-4] + ".png").startswith(b"\x89PNG"), f"tools/plot.py draws a PNG beside the table: {drawn.stderr[-300:]}")
    subprocess.run([sys.executable, script, command[2], "--out", "plot.svg"], check=True, timeout=60)
    root = ElementTree.parse("plot.svg").getroot()
    curves = [e.get("id") for e in root.iter() if (e.get("id") or "").startswith("curve ")]
    check.that(len(curves) == len({method(row) for row in rows}) > 5, f"a curve for each method: {curves}")
    ring = next(e for e in root.iter() if e.get("id") == "front")
    check.that(sum(e.tag.endswith("}use") for e in ring.iter()) == sum(row["front"] == "1" for row in study.rows), "a ring for each run on the front")


def check_finest():
    """No known solution: a reference, and a second one; a fluid has no gimp_stretch."""
    study = Study("finest", WATER + ["-reference_type finest"])
    if not study.ended("finest", 8):
        return
    check.that(re.search(r"^skipped +gimp_stretch usl flip: .*no deformation gradient$", study.out, re.M), "gimp_stretch is skipped, with the reason")
    reference, confirm = ([row for row in study.every if row["study"] == word] for word in ("reference", "confirm"))
    check.that([(row["basis"], row["cells"]) for row in reference + confirm] == [("bspline3", "32x32"), ("bspline2", "32x32")], "the references are of the last two bases that the scene takes, on a grid beyond the finest")
    check.need(confirm and confirm[0]["error"], "the second reference has a difference")
    floor = float(confirm[0]["error"])
    check.that(0 < floor < min(float(row["error"]) for row in study.rows), f"the references differ by {floor:.4f}, less than the errors")
    check.that(f"differ by {100 * floor:.2g} %" in study.out and study.cheapest("0.1")[0].startswith("nothing is said: the two references differ"), "nothing is said of 0.1 %")
    by = {(row["basis"], row["cells"]): float(row["error"]) for row in study.rows}
    check.that(all(by[basis, "16x16"] < 0.6 * by[basis, "8x8"] for basis in ("bspline2", "bspline3")), f"errors fall: {by}")
    for n, strategy in ((2, "spatial"), (3, "pool")):
        shared = Study(f"finest {n}".replace(" ", "_"), WATER + ["-reference_type finest"], "-parallel_strategy", strategy, n=n)
        check.that(shared.status == 0 and errors(shared) == errors(study), f"{strategy} on {n} processes: the same errors, to the bit; exit status {shared.status} {shared.lines[:3]}")
    # the errors of the table are zeroed below the floor: of two runs below it the faster one counts
    for row in study.every:
        if row["study"] == "run":
            row["error"] = repr(0.5 * floor / (1 + (row["cells"] == "16x16")))
    rewrite(study, study.every)
    below = Study("finest")
    check.that(sum(row["front"] == "1" for row in below.rows) == 1, "of runs with errors below the references' difference one is on the front, the fastest")


def check_against_known():
    """The bar in its first mode, once with its solution and once with the finer run in its place: the same errors."""
    known = Study("known", BAR + KNOWN + STUDY, "-study_basis", "bspline3,gimp_stretch", "-study_update", "usl")
    guess = Study("guess", BAR + ["-reference_type finest", '-body_b_velocity "0.05*pi*sin(pi*x)"'] + STUDY, "-study_basis", "bspline3,gimp_stretch", "-study_update", "usl")
    floor = [float(row["error"]) for row in guess.every if row["study"] == "confirm"]
    check.need(known.status == 0 and guess.status == 0 and floor, f"both studies end: {known.lines} {guess.lines}")
    one, other = errors(known), errors(guess)
    off = {key: abs(float(other[key]) - float(one[key])) for key in one}
    check.that(max(off.values()) < 2 * floor[0] < 5e-4, f"errors against a finer run are off those against the solution by {max(off.values()):.1e}, the references by {floor[0]:.1e}")


def check_quantity():
    study = Study("quantity", WATER + ["-study_quantity kinetic_energy:max"])
    if study.ended("quantity", 8):
        rows = {row["study"] + row["basis"] + row["cells"]: row for row in study.every}
        value = quantity_values(study)
        error = abs(value[16] / value[32] - 1)
        check.that(abs(float(rows["runbspline316x16"]["error"]) / error - 1) < 1e-6, f"quantity: error {rows['runbspline316x16']['error']}, of single runs {error}")
    known = Study("value", WATER + ["-study_quantity kinetic_energy:max", "-study_value 1", "-study_levels 2"])
    check.that(known.status == 0 and {row["study"] for row in known.every} == {"run"}, "with a known value there are no references")


def quantity_values(study):
    """The largest kinetic energy of single runs with bspline3 on two grids."""
    plain = check.write(os.path.join(study.folder, "plain.opts"), [line for line in WATER if not line.startswith("-study")])
    values = {}
    for cells in (16, 32):
        check.must("-options_file", plain, *"-method_basis bspline3 -method_update usl -method_transfer flip -output_format none -output_dir quantity".split(), "-output_name", f"alone{cells}", "-grid_cells", f"{cells},{cells}")
        values[cells] = check.history(os.path.join("quantity", f"alone{cells}.csv"))["kinetic_energy"].max()
    return values


def check_more():
    # what is asked for in other ways
    study = Study("lists", BAR + KNOWN + STUDY, "-study_basis", "bspline2", "-study_update", "usl", "-study_transfer", "flip:0.95,flip:1,xpic:3", "-study_ppc", "2,3", "-study_cfl", "0.2,0.4", "-study_levels", "2")
    found = {(row["transfer"], row["flip"], row["order"], row["ppc"], row["cfl"]) for row in study.rows}
    wanted = {(*transfer, ppc, cfl) for transfer in (("flip", "0.95", ""), ("flip", "1", ""), ("xpic", "", "3")) for ppc in "23" for cfl in ("0.2", "0.4")}
    check.that(study.status == 0 and found == wanted and len(study.rows) == 26, f"lists of shares, orders, ppc and cfl: {len(study.rows)} runs, {found ^ wanted}")
    options = study.cheapest("1")[0]
    check.that("-body_b_ppc" in options and single(study, shlex.split(options)).status == 0, f"its options run: {options}")
    # presets, with their particles and steps
    study = Study("presets", BAR + KNOWN + STUDY, "-study_basis", "bspline2", "-study_update", "musl", "-study_transfer", "flip", "-study_preset", "accurate", "-study_levels", "2")
    rows = [row for row in study.rows if row["ppc"] == "3"]
    plain = check.write(os.path.join("presets", "plain.opts"), [line for line in BAR + KNOWN if not line.startswith(("-method", "-dt_cfl"))])
    alone = check.must("-options_file", plain, "-output_dir", "presets", "-output_format", "none", "-method_preset", "accurate")
    check.that(study.status == 0 and len(study.rows) == 4 and len(rows) == 2 and abs(float(alone.find(r"relative error is (\S+)$")) / float(rows[0]["error"]) - 1) < 1e-3,
               f"preset accurate: {rows[:1]}")
    options = study.cheapest("0.1" if any(float(row["error"]) < 1e-3 for row in rows) else "1")[0]
    check.that(single(study, shlex.split(options)).status == 0, f"its options run: {options}")
    # a scene that gives the size of its cells gets that back
    study = Study("size", [line.replace("-grid_cells 8", "-grid_h 0.125") for line in BAR] + KNOWN + STUDY, "-study_basis", "bspline2", "-study_levels", "2")
    options = study.cheapest("1")[0]
    check.that("-grid_h" in options and single(study, shlex.split(options)).status == 0, f"by -grid_h: {options}")
    # a series that begins with a coarser grid
    study = Study("coarser", BAR + KNOWN + STUDY, "-grid_cells", "16", "-study_coarser", "1", "-study_basis", "bspline2", "-study_levels", "2")
    plain = Study("plain", BAR + KNOWN + STUDY, "-study_basis", "bspline2", "-study_levels", "2")
    check.that(study.status == 0 and len(study.rows) == 8 and errors(study) == errors(plain), f"-study_coarser 1 of 16 cells begins with 8: {[row['cells'] for row in study.rows]}")
    # a run that stops is a result: of the steps that are too long some are unstable
    study = Study("stops", WATER + ["-study_quantity kinetic_energy", "-study_value 100"], "-study_cfl", "0.4,2", "-time_end", "2", "-bc_xmax_type", "slip",
                  "-grid_upper", "1,2", "-grid_cells", "8,16")  # higher than water splashes
    stopped = [row for row in study.rows if row["status"] == "stopped"]
    check.that(study.status == 0 and stopped and all(row["note"] and not row["error"] and row["front"] == "0" for row in stopped) and len(stopped) < len(study.rows),
               f"runs that stop: {len(stopped)} of {len(study.rows)}, the reason is in the table")
    # -dry_run
    study = Study("dry", BAR + KNOWN + STUDY, "-dry_run")
    check.that(study.status == 0 and os.listdir("dry") == ["scene.opts"] and len(re.findall(r"^runs +.* 3 of 3 grids, about \S+ \w+$", study.out, re.M)) > 5 and "by the model about" in study.out,
               "-dry_run lists settings and their predicted times, and leaves no file")


check.arguments(__doc__, 0)
for part in (check_runs, check_finest, check_against_known, check_quantity, check_more):
    part()
check.end()
