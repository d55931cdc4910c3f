"""Studies of stability (-study_type stability): they find methods that are known to be unstable, at rest and where particles
cross cells, and a method that is known to be stable; they give the same on any number of processes, and say what they leave
out.

usage: test_study_stability.py PEBBLE SOURCE MPIEXEC few|many
few: short runs. many: the slow growth, with as many steps as it needs.
"""
import os

import check

BAR = ["-dim 1", "-grid_lower 0", "-grid_upper 1", "-grid_cells 16", "-materials m", "-material_m_model elastic",
       "-material_m_rho 1", "-material_m_E 1", "-material_m_nu 0", "-bodies b", "-body_b_shape box", "-body_b_lower 0",
       "-body_b_upper 1", "-body_b_material m", "-time_end 1", "-study_type stability"]


def study(name, *arguments, n=1):
    """The run of a study, and the rows of its table. One of many steps takes minutes on a busy computer."""
    folder = check.folder(name)
    path = check.write(os.path.join(folder, "bar.opts"), BAR)
    run = check.pebble("-options_file", path, "-output_dir", folder, *arguments, n=n, timeout=600)
    table = os.path.join(folder, "bar_stability.csv")
    return run, check.rows(table) if os.path.exists(table) else []


def number(row, name):
    return float(row[name]) if row[name] else float("inf")


def printed(run, method):
    """The largest steps in the line of a method."""
    found = run.find(rf"^{method} +([0-9.>=]+ +[0-9.>=]+ +[0-9.>=]+) ")
    return [float(word.lstrip(">=")) for word in found.split()] if found else []


def few():
    methods = ["-study_basis", "gimp,bspline2", "-study_update", "usl", "-study_transfer", "flip", "-study_steps", "1000"]
    run, rows = study("known", *methods)
    check.need(run.status == 0 and len(rows) == 2, f"status {run.status}, {len(rows)} rows: {run.said[-400:]}")
    gimp, spline = rows
    check.that(number(gimp, "rest_unstable") <= 0.8, f"gimp usl flip at rest: unstable from {gimp['rest_unstable']}, not 0.8")
    check.that(number(gimp, "rest") >= 0.4, f"gimp usl flip at rest: stable to {gimp['rest']}")
    for probe in ("rest", "crossing", "block"):
        check.that(0.4 <= number(spline, probe) < 2, f"bspline2 usl flip, {probe}: stable to {spline[probe]}")
        check.that(all(number(r, probe) < number(r, probe + "_unstable") for r in rows), f"{probe}: stable below unstable")
    for row in rows:
        least = min(number(row, probe) for probe in ("rest", "crossing", "block"))
        check.that(abs(number(row, "margin") - least / number(row, "dt_cfl")) < 0.01 * number(row, "margin"),
                   f"{row['basis']}: the margin is the least C over dt_cfl")
        line = printed(run, f"{row['basis']} {row['update']} {row['transfer']}")
        check.that(line == [number(row, p) for p in ("rest", "crossing", "block")], f"{row['basis']}: the line {line}")
    check.that(number(gimp, "steps") == 1000 and number(gimp, "ppc") == 2 and gimp["dim"] == "2", "steps, ppc and dimension")
    check.that(all(number(row, "dt_cfl") <= number(row, "table_crossing") <= number(row, "table_rest") for row in rows),
               "the default -dt_cfl is below the bounds of the table")

    short = ["-study_basis", "linear", "-study_update", "usl", "-study_transfer", "apic", "-study_steps", "100"]
    one, alone = study("one", *short)
    check.that(number(alone[0], "crossing_unstable") <= 0.5, "linear usl apic is unstable where particles cross")
    three = study("three", *short, n=3)[1]
    pool = study("pool", *short, "-parallel_strategy", "pool", n=3)[1]
    for rows in (alone, three, pool):
        rows[0].pop("seconds")
    check.that(alone == three == pool, "3 processes and the pool find the same")

    run, rows = study("dry", "-dry_run", "-study_basis", "linear,bspline3")
    check.that(run.status == 0 and not rows and len(run.out.split(" valid\n")) == 3, "-dry_run lists the methods")
    run, rows = study("none", "-grid_cells", "64", "-study_basis", "bspline2", "-study_steps", "100", n=8)
    check.that(run.status == 2 and not rows and "takes none of these methods" in run.said,
               "8 processes are too many for the study's grids, and the exit status says so")
    run, rows = study("own", "-study_steps", "100", "-method_basis", "gimp", "-method_gimp_update", "stretch", "-method_update",
                      "usl", "-method_transfer", "aflip", "-method_affine_strain", "0.5", "-method_flip", "0.9", "-body_b_ppc", "3")
    check.that([[r[key] for key in ("basis", "update", "transfer", "flip", "damping_rate", "affine_strain", "ppc")] for r in rows] ==
               [["gimp_stretch", "usl", "aflip", "0.9", "", "0.5", "3"]], f"the method of the scene: {rows}")
    run, rows = study("preset", "-study_steps", "100", "-method_preset", "fast", "-study_transfer", "flip:0.9,apic")
    check.that([(r["basis"], r["flip"]) for r in rows] == [("bspline2", "0.9"), ("bspline2", "")], f"a preset's, and one without FLIP: {rows}")


def many():
    steps = ["-study_steps", "40000"]
    run, rows = study("musl", *steps, "-study_basis", "bspline2,gimp_stretch", "-study_update", "musl", "-study_transfer",
                      "flip")
    for row in rows:
        check.that(number(row, "crossing_unstable") <= 0.4,
                   f"{row['basis']} musl flip, crossing: unstable from {row['crossing_unstable']}")
        check.that(number(row, "rest") >= 1, f"{row['basis']} musl flip, at rest: stable to {row['rest']}")
    check.that(len(rows) == 2, "two methods")
    run, rows = study("usl", *steps, "-study_basis", "bspline2", "-study_update", "usl", "-study_transfer", "flip")
    for probe in ("rest", "crossing", "block"):
        check.that(number(rows[0], probe) >= 0.4, f"bspline2 usl flip, {probe}: stable to {rows[0][probe]}")


if __name__ == "__main__":
    {"few": few, "many": many}[check.arguments(__doc__, 1)[0]]()
    check.end()
