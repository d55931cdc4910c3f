"""A run ends when its bodies are at rest (-time_rest), and its history and a line say how near they are to it.

usage: test_rest.py PEBBLE SOURCE MPIEXEC
"""
import re

import check

check.arguments(__doc__, 0)

BLOCK = check.write("block.opts", """\
-dim 2
-gravity 0,-9.81
-grid_lower 0,0
-grid_upper 1,1
-grid_h 0.0625,0.0625
-bc_xmin_type slip
-bc_xmax_type slip
-bc_ymin_type fixed
-materials rubber
-material_rubber_model neohookean
-material_rubber_rho 1000
-material_rubber_E 1e6
-material_rubber_nu 0.3
-bodies block
-body_block_shape box
-body_block_lower 0,0
-body_block_upper 1,0.8
-body_block_material rubber
-time_end 3
-history_every 0.01
-output_format none
""")
REST = ["-history_rest", "-time_rest", 1e-6]


def block(folder, *more, n=1):
    return check.pebble("-options_file", BLOCK, "-output_dir", folder, *more, n=n)


def last(folder):
    rows = check.history(f"{folder}/block.csv")
    return {name: rows[name][-1] for name in rows}, rows


def ends():
    """It ends where both ratios have been below the limit for as long as is asked for, and the state is in equilibrium."""
    run = block("ends", "-damping_kinetic", *REST)
    end, rows = last("ends")
    since = float(run.find(r"rest +at rest since t=(\S+) s") or "nan")
    c = float(run.find(r"c=(\S+) m/s"))
    check.that(run.good and "(-time_rest)" in run.out and end["time"] < 3, f"a damped block comes to rest at {end['time']:g} s")
    check.that(0.9 < (end["time"] - since) / (2 / c) < 2.5, f"it has been at rest for {end['time'] - since:.3g} s; a wave needs {2 / c:.3g} s")
    quiet = rows["time"] >= since
    check.that(quiet.sum() >= 2 and end["unbalanced"] < 1e-6 and (rows["kinetic_share"][quiet] < 1e-6).all(), f"the last {quiet.sum()} lines are at rest")
    check.that(rows["unbalanced"][1] > 0.1 and rows["unbalanced"][0] != rows["unbalanced"][0], f"at the start the weight is out of balance: {rows['unbalanced'][1]:.3g}")
    # a block held at its sides sinks by rho g H^2/(2 M), with the confined modulus M = E (1 - nu)/((1 + nu) (1 - 2 nu))
    sinks = 1000 * 9.81 * 0.8 ** 2 / 2 / (1e6 * 0.7 / (1.3 * 0.4))
    run = block("depth", "-damping_kinetic", *REST, "-probes", "top", "-probe_top_follow", "0.5,0.8")
    check.that(abs((rows := last("depth")[1])["probe_top_y"][0] - rows["probe_top_y"][-1] - sinks) < 0.03 * sinks, "the block at rest has sunk as it should")
    went = re.search(r"^moved +since the start, at the most: block by (\S+) m; a cell is 0.0625 m$", run.out, re.M)
    check.that(went and abs(float(went[1]) / sinks - 1) < 0.03, f"how far it has moved is told: {went and went[0]}")
    many = ["-bodies", "block,two,three,four,five,six,seven", "-body_block_upper", "0.125,0.8"]
    for k, name in enumerate(("two", "three", "four", "five", "six", "seven"), 1):
        many += [f"-body_{name}_shape", "box", f"-body_{name}_lower", f"{k / 8},0", f"-body_{name}_upper", f"{(k + 1) / 8},0.8", f"-body_{name}_material", "rubber"]
    run = block("many", "-history_rest", *many, "-time_end", 0.05, n=2)
    check.that(re.search(r"^moved .*: block by \S+ m, two by .*, six by \S+ m, 1 others by \S+ m; a cell", run.out, re.M), f"of many bodies some: {run.find('moved +(.*)')}")
    run = block("falls", "-history_rest", "-body_block_lower", "0.2,0.5", "-bc_ymin_type", "separate", "-time_end", 0.1)
    check.that("kinetic energy without strain energy" in run.out, f"what falls: {run.find('rest +(.*)')}")


def same():
    """The same bits on any number of processes and after a restart; the columns change no bit."""
    whole = block("one", "-damping_time", 0.05, *REST)
    csv = check.content("one/block.csv")
    plain = block("plain", "-damping_time", 0.05, "-time_max_steps", whole.find(r"done +(\d+) steps"))
    check.that(whole.digest and whole.digest == plain.digest, "-time_rest and -history_rest change no bit")
    check.that(b"unbalanced" not in check.content("plain/block.csv"), "no columns unless they are asked for")
    for n, more in ((2, []), (3, []), (2, ["-parallel_strategy", "pool"])):
        run = block("many", "-damping_time", 0.05, *REST, *more, n=n)
        check.that(run.digest == whole.digest and check.content("many/block.csv") == csv, f"the same end on {n} processes {' '.join(more)}")
    steps = int(whole.find(r"done +(\d+) steps"))
    for stop in (steps - 10, 40):
        block("parts", "-damping_time", 0.05, *REST, "-time_max_steps", stop, "-checkpoint_every", 1e30)
        run = block("parts", "-damping_time", 0.05, *REST, "-restart_file", "latest", n=2)
        check.that(run.digest == whole.digest and check.content("parts/block.csv") == csv, f"the same end after a restart at step {stop}")


def others():
    """Other frames and shapes, loads in balance with each other, and a run that does not come to rest."""
    for more in (["-method_frame", "total", "-damping_kinetic", "-time_rest", 1e-4], ["-method_basis", "linear", "-damping_kinetic"],
                 ["-geometry", "axisymmetric", "-damping_kinetic", "-time_rest", 1e-5],
                 ["-gravity", "0,0", "-bc_ymin_type", "slip", "-loads", "p", "-load_p_body", "block", "-load_p_type", "traction", "-load_p_face", "ymax",
                  "-load_p_value", "0,-1e3", "-damping_kinetic"],
                 ["-gravity", "0,0", "-bc_ymin_type", "slip", "-acceleration", "0,-4", "-damping_kinetic"],
                 ["-gravity", "0,0", "-bc_xmin_type", "free", "-bc_xmax_type", "free", "-bc_ymin_type", "free", "-grid_lower", "-1,-1", "-grid_upper", "2,2",
                  "-loads", "p", "-load_p_body", "block", "-load_p_type", "pressure", "-load_p_value", "1e3", "-damping_kinetic", "-time_rest", 1e-3]):
        run = block("others", "-time_rest", 1e-6, *more)
        check.that(run.good and "(-time_rest)" in run.out, f"comes to rest: {' '.join(map(str, more))}: {run.find('^(rest.*)')}")
    run = block("short", "-damping_time", 0.05, *REST, "-time_end", 0.1)
    check.that(run.good and "the bodies are not at rest at -time_end" in run.said and "at rest since" not in run.out, "a run that is too short says so")
    run = block("free", *REST, "-bc_ymin_type", "free", "-body_block_lower", "0,0.6", "-time_end", 0.05, "-particles_leave", "delete")
    check.that(last("free")[0]["unbalanced"] > 0.99, "all of the weight of a falling block is out of balance")
    held = block("held", "-damping_kinetic", *REST, "-time_rest_hold", 0.5)
    check.that(0.5 <= last("held")[0]["time"] - float(held.find(r"at rest since t=(\S+) s")) < 0.6, "-time_rest_hold is how long it has to be at rest")


ends()
same()
others()
check.end()
