"""Convergence studies (-study_type convergence): errors and orders of every basis on a manufactured solution, of the time
step and of the particles per cell on a bar with an exact one, the finest run as reference, a quantity of interest, what
does not converge, the files of a study, the exit status, and the same numbers on several processes.

usage: test_study.py PEBBLE SOURCE MPIEXEC
"""
import math
import os
import re
import subprocess
import sys
from xml.etree import ElementTree

import check

TOLERANCE = 2e-3  # relative, of errors that were found with 4 or 5 digits
# rms errors at 8, 16 and 32 cells of an independent implementation, update musl
AXIS = {
    "linear": (["-method_basis", "linear"], [9.298e-3, 7.913e-3, 1.324e-2]),
    "gimp": (["-method_basis", "gimp", "-method_gimp_update", "none"], [4.709e-3, 2.221e-3, 1.2209e-3]),
    "gimp stretch": (["-method_basis", "gimp", "-method_gimp_update", "stretch"], [3.4727e-3, 9.9198e-4, 2.6202e-4]),
    "bspline2": (["-method_basis", "bspline2"], [4.1513e-3, 1.6562e-3, 1.0061e-3]),
}


METHOD = ["-method_basis bspline2", "-method_update musl", "-method_transfer flip", "-dt_cfl 0.4"]


def square(amplitude=0.05):
    """A neo-Hookean square between slip walls that swings along its axes."""
    lines = ["-dim 2", "-grid_lower 0,0", "-grid_upper 1,1", "-grid_cells 8,8",
             *[f"-bc_{face}_type slip" for face in ("xmin", "xmax", "ymin", "ymax")],
             "-materials m", "-material_m_model neohookean", "-material_m_rho 1000", "-material_m_E 1e7", "-material_m_nu 0.3",
             "-bodies b", "-body_b_shape box", "-body_b_lower 0,0", "-body_b_upper 1,1", "-body_b_material m",
             "-mms_type axis", f"-mms_amplitude {amplitude}", "-dt_size 0.00025", "-time_end 0.005", *METHOD[:3],
             "-study_type convergence", "-study_levels 3"]
    return lines


def bar(*more, cells=32):
    """An elastic bar of unit length, density and stiffness between walls, in its first mode."""
    return ["-dim 1", "-grid_lower 0", "-grid_upper 1", f"-grid_cells {cells}", "-bc_xmin_type fixed", "-bc_xmax_type fixed",
            "-materials m", "-material_m_model elastic", "-material_m_rho 1", "-material_m_E 1", "-material_m_nu 0",
            "-bodies b", "-body_b_shape box", "-body_b_lower 0", "-body_b_upper 1", "-body_b_material m",
            "-time_end 0.5", "-study_type convergence", *more,
            *[line for line in METHOD[:3] if not any(other.startswith(line.split()[0]) for other in more)]]


class Study:
    """A run of a study: exit status, what it printed, its folder and the rows of its CSV file."""

    def __init__(self, name, lines, *arguments, n=1):
        self.folder = check.folder(name.replace(" ", "_"))
        path = check.write(os.path.join(self.folder, "scene.opts"), lines)
        told = check.pebble("-options_file", path, "-output_dir", self.folder, *arguments, n=n)
        self.status, self.out, self.err, self.lines = told.status, told.out, told.err, told.lines
        table = os.path.join(self.folder, "scene_study.csv")
        there = os.path.exists(table)
        self.rows, self.text = (check.rows(table), check.content(table).decode()) if there else ([], "")

    def column(self, name):
        return [float(row[name]) if row[name] else math.nan for row in self.rows]

    def ended(self, name, rows):
        said = "" if self.status == 0 and len(self.rows) == rows else f"\n{self.out[-1500:]}{self.err[-1500:]}"
        return check.that(self.status == 0 and not self.lines and len(self.rows) == rows, f"{name}: exit status {self.status}, {len(self.rows)} runs in the file{said}")


def verdict(study):
    """What the study says of convergence."""
    found = re.search(r"^verdict +(.*)$", study.out, re.M)
    return found[1] if found else "no verdict"


def words(values):
    return " ".join(f"{value:.5g}" for value in values)


def plot(study, *words):
    """The command that the study prints to draw its table, run with this Python."""
    command = re.search(r"^ +drawn by: \.venv/bin/python (tools/plot\.py) (\S+)$", study.out, re.M)
    check.need(command, f"the study prints how to draw it: {study.out[-300:]}")
    return subprocess.run([sys.executable, os.path.join(check.source, command[1]), command[2], *words], capture_output=True, text=True, timeout=60)


def check_plot(study, orders):
    """The plot of a study: its points, its slope, its orders."""
    drawn = plot(study)
    picture = os.path.join(study.folder, "scene_study.png")
    check.that(drawn.returncode == 0 and not drawn.stderr and os.path.exists(picture) and check.content(picture).startswith(b"\x89PNG"),
               f"tools/plot.py draws a PNG beside the table: {drawn.stderr.strip()}")
    vectors = os.path.join(study.folder, "plot.svg")
    plot(study, "--out", vectors)
    root = ElementTree.parse(vectors).getroot()
    said = [" ".join("".join(element.itertext()).split()) for element in root.iter() if element.tag.endswith("}text")]
    check.that({f"{order:.2f}" for order in orders if not math.isnan(order)} <= set(said) and "slope 2" in said and "error [m]" in said and "scene" in said,
               f"the plot names its title, axes, slope and orders: {' | '.join(said)}")

    def places(gid):
        """The corners of the line of this name, in the plane of the page."""
        group = next(element for element in root.iter() if element.get("id") == gid)
        path = next(element for element in group.iter() if element.tag.endswith("}path")).get("d")
        return [tuple(map(float, pair)) for pair in re.findall(r"[ML] (\S+) (\S+)", path)]
    line, slope = places("errors"), places("slope")
    check.need(len(line) == 3 and len(slope) in (2, 3), f"a line of {len(line)} points, a slope of {len(slope)}")
    unit = [abs(b - a) for a, b in zip(slope[0], slope[-1])]  # y falls by 2 where x falls by 1
    drawn = [2 * (b[1] - a[1]) / unit[1] / ((a[0] - b[0]) / unit[0]) for a, b in zip(line, line[1:])]
    errors = study.column("error")
    check.that(all(abs(s - math.log2(a / b)) < 1e-3 for s, a, b in zip(drawn, errors, errors[1:])), f"its points are those of the table: slopes {words(drawn)}")


def check_files(study):
    """CSV of a study, in its form, and its plot; results of each run beside them."""
    check.that(study.text.splitlines()[0] == "run,h,particles,steps,error,order,seconds,relative,difference", f"columns: {study.text.splitlines()[:1]}")
    check.that(study.column("run") == [1, 2, 3] and study.column("h") == [1 / 8, 1 / 16, 1 / 32], f"runs {study.column('run')} with h {study.column('h')}")
    check.that(study.column("particles") == [256, 1024, 4096] and study.column("steps") == [20, 40, 80], f"particles {study.column('particles')}, steps {study.column('steps')}")
    errors, orders = study.column("error"), study.column("order")
    check.that(math.isnan(orders[0]) and math.isnan(orders[1]) and abs(orders[2] - math.log2(errors[1] / errors[2])) < 1e-4,
               f"orders {words(orders)}: that of the errors of the last runs, where three agree")
    size = {a / b for a, b in zip(errors, study.column("relative"))}
    check.that(max(size) - min(size) < 0.02 * max(size) < 0.01, f"errors as parts of the solution's size, {words(size)} m on the three grids")
    differences = study.column("difference")
    check.that(math.isnan(differences[2]) and all(a - b < d < a + b for a, b, d in zip(errors, errors[1:], differences)),
               f"differences of successive runs {words(differences)}: between the difference and the sum of their errors")
    check.that(all(s > 0 for s in study.column("seconds")), "seconds are positive")
    check_plot(study, orders)
    check.that(all(os.path.exists(os.path.join(study.folder, f"scene-{k}.{kind}")) for k in (1, 2, 3) for kind in ("csv", "h5", "xdmf")), "each run has its own results, scene-1 to scene-3")


def check_axis():
    for name, (options, expected) in AXIS.items():
        study = Study(f"axis {name}", square(), *options)
        if not study.ended(f"axis, {name}", 3):
            continue
        errors = study.column("error")
        worst = max(abs(a / b - 1) for a, b in zip(errors, expected))
        check.that(worst <= TOLERANCE, f"axis, {name}: errors {words(errors)}, expected {words(expected)}, difference {worst:.1e} (allowed {TOLERANCE})")
        note = re.findall("^note +the error grew from run (\\d) to run (\\d): ", study.out, re.M)
        check.that(note == ([("2", "3")] if errors[2] > errors[1] else []), f"axis, {name}: a note where the last error is larger: {note}")
        if name == "gimp stretch":
            check_files(study)
            check.that(study.column("order")[2] > 1.8, f"axis, {name}: order {study.column('order')[2]:.3f} (above 1.8)")
    # little motion, no crossing of cells: all of second order
    for basis in ("linear", "gimp", "bspline2", "bspline3"):
        study = Study(f"small {basis}", square(1e-5), "-method_basis", basis, "-study_order_min", "1.8", "-output_format", "none")
        if study.ended(f"axis, {basis}, little motion, order at least 1.8", 3):
            errors = study.column("error")
            check.that(errors[1] > 2 ** 1.8 * errors[2], f"axis, {basis}, little motion: errors {words(errors)}, order above 1.8")


def check_status():
    study = Study("order", square(), "-method_basis", "linear", "-study_levels", "2", "-study_order_min", "1.5")
    check.that(study.status == 3 and len(study.lines) == 1 and study.lines[0].startswith("the order of the last pair of errors, 0.233, is below -study_order_min 1.5"),
          f"order below -study_order_min: exit status {study.status}, {study.lines}")
    check.that(len(study.rows) == 2 and os.path.exists(os.path.join(study.folder, "scene_study.csv")) and plot(study).returncode == 0, "its table is there all the same, and is drawn")
    study = Study("order two", square(), "-method_basis", "linear", "-study_levels", "2", "-study_order_min", "1.5", n=2)
    check.that(study.status == 3 and len(study.lines) == 1, f"the same on 2 processes: exit status {study.status}, {study.lines}")
    # a run that stops ends the study; its error does not count
    study = Study("stopped", square(), "-dt_size", "0.005", "-time_end", "0.1", "-method_update", "usl", "-method_basis", "linear")
    check.that(study.status == 3 and len(study.lines) == 1 and len(study.rows) < 3, f"a run that stops: exit status {study.status}, {len(study.rows)} runs in the file, {study.lines}")
    # a run that is refused ends the study with one line
    study = Study("refused", square(), "-study_vary", "ppc", "-body_b_ppc", "40,40", "-study_levels", "2")
    check.that(study.status == 2 and len(study.lines) == 1 and "-body_b_ppc" in study.lines[0], f"a run that is refused: exit status {study.status}, {study.lines[:3]}")
    # -dry_run computes nothing
    study = Study("dry", square(), "-dry_run")
    left = sorted(os.listdir(study.folder))
    check.that(study.status == 0 and not study.lines and left == ["scene.opts"], f"-dry_run: exit status {study.status}, {study.lines[:2]}, files {left}")


def check_dt():
    """usf is of first order in dt: its error is pi dt; that of musl is the grid's, whatever dt."""
    small = bar("-study_vary dt", "-study_levels 4", "-reference_type standing", "-reference_amplitude 1e-5", "-dt_size 0.0125", "-method_basis linear")
    for update in ("usf", "musl"):
        study = Study(f"dt {update}", small, "-method_update", update)
        if not study.ended(f"dt, {update}", 4):
            continue
        dt, errors, orders = study.column("dt"), study.column("error"), study.column("order")
        check.that(dt == [0.0125 / 2 ** k for k in range(4)] and study.column("particles") == [64] * 4, f"dt, {update}: dt {words(dt)}")
        if update == "usf":
            check.that(math.isnan(orders[1]) and all(abs(o - 1) < 0.1 for o in orders[2:]), f"dt, usf: errors {words(errors)}, orders {words(orders[1:])} (1 +- 0.1)")
            check.that(all(abs(e / (math.pi * d * 1e-5 / math.sqrt(2)) - 1) < 0.15 for e, d in zip(errors, dt)), "dt, usf: errors are pi dt of the amplitude (15 %)")
        else:
            check.that(max(errors) < 1.5 * min(errors), f"dt, musl: errors {words(errors)} are those of the grid (within 1.5 of each other)")
            check.that(verdict(study).startswith("does not converge to the known solution: the runs lead to another") and "does not come from dt" in study.out,
                       f"dt, musl: the study says that they do not come from dt: {verdict(study)}")
    # From run to run the grid's error cancels, which leaves the order in time; the first differences give it, without the bias
    # of the finest run's own error: errors c dt^p against the last of 5 runs fall by log2((16^p - 1)/(8^p - 1)), 1.10 and 2.02.
    for update, p in (("usf", 1), ("musl", 2), ("usl", 2)):
        study = Study(f"dt finest {update}", [line for line in small if not line.startswith("-reference")], "-reference_type", "finest",
                      "-body_b_velocity", "1e-5*pi*sin(pi*x)", "-method_update", update, "-study_levels", "5", "-dt_size", "0.03", "-time_end", "0.3")
        if study.ended(f"dt, {update} against the finest", 4):
            orders, errors = study.column("order"), study.column("error")
            check.that(math.isnan(orders[1]) and abs(orders[2] - p) < 0.15 and verdict(study).startswith("converges"),
                       f"dt, {update} against the finest: differences {words(study.column('difference'))}, orders {words(orders)} ({p} +- 0.15), {verdict(study)}")
            found, expected = math.log2(errors[0] / errors[1]), math.log2((16 ** p - 1) / (8 ** p - 1))
            check.that(abs(found - expected) < 0.15 and "errors are against the finest run: they lack its own error" in study.out,
                       f"dt, {update}: errors against the finest {words(errors)} fall by {found:.3f} ({expected:.3f} +- 0.15), and the study says their bias")
    # without -dt_size the CFL number is halved
    study = Study("cfl", [line for line in small if not line.startswith("-dt_size")], "-method_update", "usf", "-dt_cfl", "0.4")
    if study.ended("cfl, usf", 4):
        check.that(study.column("cfl") == [0.4, 0.2, 0.1, 0.05] and abs(study.column("order")[3] - 1) < 0.15, f"cfl, usf: {words(study.column('cfl'))}, errors {words(study.column('error'))}, order {study.column('order')[3]:.3f}")


def check_ppc():
    """Same cells with 2, 4 and 8 particles each: the error of the quadrature falls."""
    lines = bar("-study_vary ppc", "-study_levels 3", "-reference_type standing", "-reference_amplitude 0.05", "-dt_size 0.0015625", "-body_b_ppc 2")
    study = Study("ppc", lines)
    if study.ended("ppc", 3):
        errors = study.column("error")
        check.that(study.column("1/ppc") == [1 / 2, 1 / 4, 1 / 8] and study.column("particles") == [64, 128, 256] and len(set(study.column("steps"))) == 1, f"ppc: {study.column('1/ppc')}, particles {study.column('particles')}")
        check.that(errors[0] > 1.5 * errors[1], f"ppc: errors {words(errors)} fall")


def check_finest():
    """A smooth problem whose solution is not given: the finest run in its place, and the order of the differences of runs."""
    lines = bar("-study_levels 5", "-reference_type finest", "-dt_size 0.0125", '-body_b_velocity "1e-4*pi*sin(pi*x)"', cells=8)
    for basis in ("linear", "gimp"):
        study = Study(f"finest {basis}", lines, "-method_basis", basis)
        if study.ended(f"finest, {basis}", 4):
            orders = study.column("order")
            check.that(all(abs(o - 2) < 0.15 for o in orders[2:]), f"finest, {basis}: differences {words(study.column('difference'))}, orders {words(orders[2:])} (2 +- 0.15)")
            check_limit(study)
    # two bodies with lattices of their own and curved edges
    disks = ["-dim 2", "-grid_lower 0,0", "-grid_upper 1,1", "-grid_cells 8,8", "-materials m", "-material_m_model neohookean", "-material_m_rho 1000", "-material_m_E 1e4",
             "-material_m_nu 0.3", "-bodies a,b", "-body_a_shape sphere", "-body_a_center 0.3,0.3", "-body_a_radius 0.2", "-body_a_material m", '-body_a_velocity "0.1*(x-0.3)+0.2,-0.1*(y-0.3)"',
             "-body_b_shape box", "-body_b_lower 0.6,0.6", "-body_b_upper 0.8,0.8", "-body_b_offset 0.01,0.02", "-body_b_material m", '-body_b_velocity "-0.2*(y-0.7),0.2*(x-0.7)"',
             *METHOD, "-time_end 0.05", "-study_type convergence", "-study_levels 4", "-reference_type finest"]
    study = Study("finest disks", disks)
    if study.ended("finest, two bodies", 3):
        errors = study.column("error")
        check.that(errors[0] > errors[1] > errors[2] and errors[2] < 0.01 * 0.05, f"finest, two bodies: differences {words(errors)} fall")
    # a body that moves through a periodic face: its displacement counts on across it
    box = ["-dim 1", "-grid_lower 0", "-grid_upper 1", "-grid_cells 8", "-bc_xmin_type periodic", "-bc_xmax_type periodic", "-materials m", "-material_m_model elastic", "-material_m_rho 1",
           "-material_m_E 1", "-material_m_nu 0", "-bodies b", "-body_b_shape box", "-body_b_lower 0", "-body_b_upper 1", "-body_b_material m", '-body_b_velocity "0.5+1e-4*sin(2*pi*x)"',
           *METHOD[:3], "-time_end 0.3", "-dt_size 0.0125", "-study_type convergence", "-study_levels 4", "-reference_type finest"]
    study = Study("finest periodic", box)
    if study.ended("finest, through a periodic face", 3):
        check.that(max(study.column("error")) < 1e-4, f"finest, through a periodic face: differences {words(study.column('error'))} (below the amplitude, 1e-4)")
    # without -study_order_min any order will do; of two runs there is one difference and no order
    study = Study("finest two", lines, "-study_levels", "2")
    study.ended("finest, two runs", 1)


def check_limit(study):
    """How far the last run is from the limit: of c h^2, a third of the last difference."""
    found = re.search(r"^limit +the last run is (\S+) \+- (\S+) m from", study.out, re.M)
    rest, uncertainty = map(float, found.groups()) if found else (math.nan, math.nan)
    third = study.column("difference")[-1] / 3
    check.that(abs(rest / third - 1) < 0.15 and uncertainty < 0.2 * rest, f"the limit is {rest} +- {uncertainty} m off, a third of the last difference is {third:.3g}")


def check_honest():
    """A method that loses energy with every step: the more steps, the more. Halving dt doubles the loss, so the differences of
    runs grow; errors against the finest run fall all the same, the faster the closer to it (7, 6, 4 of 8 parts)."""
    lines = bar("-study_vary dt", "-study_levels 4", "-dt_size 0.0125", "-method_basis linear", "-method_update musl", "-method_flip 0.9", "-reference_type finest",
                '-body_b_velocity "1e-5*pi*sin(pi*x)"')
    study = Study("honest", lines)
    if study.ended("honest", 3):
        errors, differences = study.column("error"), study.column("difference")
        check.that(errors[0] > errors[1] > errors[2] and math.log2(errors[1] / errors[2]) > 0.4 and differences[2] > 1.5 * differences[1] > 2 * differences[0],
                   f"honest: errors against the finest {words(errors)} fall while differences {words(differences)} grow")
        check.that(all(math.isnan(o) for o in study.column("order")) and verdict(study).startswith("does not converge: ") and "limit      none" in study.out,
                   f"honest: no order {study.column('order')}, no limit, {verdict(study)}")
    study = Study("honest min", lines, "-study_order_min", "0.1")
    check.that(study.status == 3 and len(study.lines) == 1 and study.lines[0].startswith("the order of the last pair of differences, -"),
               f"honest: -study_order_min 0.1 is refused: exit status {study.status}, {study.lines}")


def check_quantity():
    """A column of the history in place of the displacement: its limit is that of the bar, whose energy is known."""
    energy = 1e-10 * math.pi ** 2 / 4  # kinetic at the start: 1/2 int (1e-5 pi sin(pi x))^2 dx
    lines = bar("-study_vary dt", "-study_levels 4", "-dt_size 0.0125", "-method_basis linear", "-study_quantity strain_energy:max",
                '-body_b_velocity "1e-5*pi*sin(pi*x)"')
    study = Study("quantity", lines)
    if study.ended("quantity", 3):
        limit = float(re.search(r"^limit +strain_energy:max goes to (\S+) ", study.out, re.M)[1])
        check.that(abs(study.column("order")[2] - 2) < 0.1 and abs(limit / energy - 1) < 1e-2, f"quantity: order {study.column('order')[2]:.3f}, limit {limit} J, the energy is {energy:.6g} J")
        values = [check.history(os.path.join(study.folder, f"scene-{k}.csv"))["strain_energy"].max() for k in (1, 2, 3)]
        check.that(study.column("quantity") == values, f"quantity: {words(study.column('quantity'))}, in the histories {words(values)}")
        check.that(plot(study).returncode == 0, "quantity: it is drawn")
    study = Study("value", lines, "-study_value", repr(energy))
    if study.ended("a known value", 4):
        check.that(all(abs(e - abs(q - energy)) < 1e-9 * energy for e, q in zip(study.column("error"), study.column("quantity"))), f"a known value: errors {words(study.column('error'))}")


def check_parallel():
    """The file is the same, but for the seconds, on any number of processes."""
    without = lambda study: [{key: value for key, value in row.items() if key != "seconds"} for row in study.rows]
    small = ["-study_levels", "2"]
    finest = bar("-study_levels 3", "-reference_type finest", "-dt_size 0.0125", '-body_b_velocity "1e-2*pi*sin(pi*x)"', cells=8)
    for name, lines, arguments in (("axis", square(), small), ("axis stretch", square(), small + AXIS["gimp stretch"][0]), ("finest", finest, [])):
        serial = Study(f"{name} serial", lines, *arguments)
        for n, strategy in ((2, "spatial"), (3, "pool")):
            study = Study(f"{name} {strategy} {n}", lines, *arguments, "-parallel_strategy", strategy, n=n)
            check.that(study.status == 0 and len(study.rows) >= 2 and without(study) == without(serial), f"{name}: {strategy} on {n} processes, exit status {study.status}: errors {words(study.column('error'))}" + ("" if without(study) == without(serial) else f", serial {words(serial.column('error'))}\n{study.err[-1500:]}"))


check.arguments(__doc__, 0)
for part in (check_axis, check_status, check_dt, check_ppc, check_finest, check_honest, check_quantity, check_parallel):
    part()
check.end()
