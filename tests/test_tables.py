"""Tables over time in formulas: table(file.csv) gives what a formula would, on any number of processes, after a restart, in a
stage and with -rerun; bad files are refused in one line.

usage: test_tables.py PEBBLE SOURCE MPIEXEC
"""
import os

import check

check.arguments(__doc__, 0)

os.makedirs("scene", exist_ok=True)
SCENE = check.write("scene/block.opts", """\
-dim 2
-grid_lower 0,0
-grid_upper 1.5,1.5
-grid_h 0.1,0.1
-bc_ymin_type fixed
-materials rubber
-material_rubber_model neohookean
-material_rubber_rho 1000
-material_rubber_E 1e6
-material_rubber_nu 0.3
-bodies block
-body_block_shape box
-body_block_lower 0.2,0
-body_block_upper 1.2,0.8
-body_block_material rubber
-loads push
-load_push_body block
-load_push_type traction
-load_push_face ymax
-load_push_value "0, -table(ramp.csv)"
-acceleration "2*table(shake.csv)*(x > 0.5), 0"
-time_end 0.05
-output_every 0.05
""")
check.write("scene/ramp.csv", "t,value\n# a ramp of 0.02 s, then 0.02 s at 1 kPa\n0.01, 0\r\n0.03,1e3\n\n0.05,1000\n0.06,-5\n")
check.write("scene/shake.csv", "0,0\n0.025,1.5\n0.05,-1\n")
RAMP = "(t < 0.01 ? 0 : t < 0.03 ? (t - 0.01)/0.02*1000 : 1000)"
SHAKE = "(t < 0.025 ? 1.5*(t/0.025) : 1.5 + (-2.5)*((t - 0.025)/(0.05 - 0.025)))"


def run(folder, *more, n=1, scene=SCENE):
    return check.pebble("-options_file", scene, "-output_dir", folder, *more, n=n)


def values():
    whole = run("table")
    check.need(whole.good, whole.said[-500:])
    check.need((formula := run("formula", "-load_push_value", f"0, -{RAMP}", "-acceleration", f"2*{SHAKE}*(x > 0.5), 0")).good, formula.said[-500:])
    one, other = check.history("table/block.csv"), check.history("formula/block.csv")
    differ = abs(one["kinetic_energy"] - other["kinetic_energy"]).max() / other["kinetic_energy"].max()
    check.that(differ < 1e-9 and other["kinetic_energy"].max() > 0, f"tables do what formulas do: energies differ by {differ:.1e}")
    for n, more in ((2, []), (3, []), (2, ["-parallel_strategy", "pool"])):
        check.that(run("many", *more, n=n).digest == whole.digest, f"the same digest on {n} processes {' '.join(more)}")
    run("parts", "-time_max_steps", 30, "-checkpoint_every", 1e30)
    check.that(run("parts", "-restart_file", "latest").digest == whole.digest, "and after a restart")
    os.makedirs("elsewhere", exist_ok=True)
    again = check.pebble("-rerun", os.path.abspath("table/block.h5"), "-output_dir", "again", cwd="elsewhere")
    check.that(again.digest == whole.digest, f"-rerun finds the tables from another folder {again.err.strip()}")
    text = "".join(line for line in open(SCENE) if not line.startswith(("-time_end", "-load_push_value", "-acceleration")))
    check.write("scene/staged.opts", text + '-load_push_value "0,0"\n-stages rest,push\n-stage_rest_time 0.01\n-stage_push_time 0.04\n-stage_push_load_push_value "0, -table(ramp.csv)"\n')
    staged = run("staged", scene="scene/staged.opts")
    check.that(staged.good and check.history("staged/staged.csv")["load_work"][-1] > 0, f"a table of a stage {staged.err.strip()}")
    again = check.pebble("-rerun", os.path.abspath("staged/staged.h5"), "-output_dir", "again", cwd="elsewhere")
    check.that(again.digest == staged.digest, f"-rerun finds the table of a stage too {again.err.strip()}")
    late = run("late", "-acceleration", "0,0", "-load_push_value", "0, -table(scene/ramp.csv) - table(scene/ramp.csv)*t", "-time_end", 0.002)
    check.that(late.good and check.history("late/block.csv")["kinetic_energy"][-1] == 0, "two tables in one formula; before its first line a table has the value of that line")


def refused():
    for text, words in (("", "has no line t,value"), ("t,value\n", "has no line t,value"), ("0,1\n0,2\n", ":2: the line is not later than the one before"),
                        ("0,1\n-1,2\n", ":2: the line is not later than the one before"), ("0;1\n1;2\n", ":1: the line has a ; where a comma should be"), ("0,1\n1,2,3\n", ":2: the line has more than two numbers"),
                        ("0,1\n1\n", ":2: the line is not t,value, two numbers"), ("0,1\nx,2\n", ":2: the line is not t,value, two numbers"), ("0,1\n1,\n", ":2: the line has no value after its comma"),
                        ("0,1\n1,nan\n", ":2: the line is not finite"), ("0,inf\n", ":1: the line is not finite"), ("t,value\nt,value\n0,1\n", ":2: the line is not t,value, two numbers")):
        check.write("scene/bad.csv", text)
        told = run("bad", "-load_push_value", "0,table(scene/bad.csv)")
        check.that(told.status == 2 and len(told.lines) == 1 and words in told.err, f"{text!r}: {told.err.strip()}")
    for value, words in (("0,table(nowhere.csv)", "cannot read nowhere.csv: No such file or directory"), ("0,table(.)", "cannot read .: Is a directory"), ("0,table()", "write table(file.csv), with the name of a file"),
                         ("0,table(ramp.csv", "write table(file.csv), with the name of a file")):
        told = run("bad", "-load_push_value", value)
        check.that(told.status == 2 and len(told.lines) == 1 and words in told.err, f"{value}: {told.err.strip()}")
    told = run("bad", "-body_block_velocity", "table(scene/ramp.csv),0")
    check.that(told.status == 2 and len(told.lines) == 1 and "a table is one over time, and this formula does not depend on t" in told.err, told.err.strip())


values()
refused()
check.end()
