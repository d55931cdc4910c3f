"""The performance model: what a calibration writes is what a run predicts by, files that do not fit are not used, and
neither the model nor the measurement of the critical path changes a bit of the results. No time is judged here.

usage: test_model.py PEBBLE SOURCE MPIEXEC BUILD (some | rest)

rest: a scene that is hard to calibrate, alone
"""
import math
import os
import re
import shutil

import check
import mpi

BUILD, EXTENT = check.arguments(__doc__, 2)
calibrate = os.path.join(BUILD, "calibrate")
whole_scene = ["-options_file", check.scene("disks"), "-grid_cells", "64,64"]
scene = whole_scene + ["-time_max_steps", "60", "-report_phases"]


def holds(what, good, detail=""):
    check.that(good, f"{what} {detail}")


def run(*options, n=1, status=0, program=None, scene=scene):
    # A calibration of one round is as good as the usual one of five, where no time is judged.
    done = check.run([program or check.program, *scene, *options], n, timeout=300, env={"PEBBLE_ROUNDS": "1"} if EXTENT == "some" else None)
    check.need(done.status == status, f"{options} on {n}: exit {done.status}, expected {status}\n{done.said}")
    return done.said


def predictions(text):
    """{phase: predicted s/step} of the final table."""
    rows = re.findall(r"^  (\S+) +[\d.]+ +[\d.]+ +[\d.]+ +\S+ +([\d.e+-]+) +[\d.]+$", text, re.M)
    return {name: float(value) for name, value in rows}


def digest(text):
    return re.search(r"^digest (\w+)", text, re.M).group(1)


# ---- A scene whose small body needs more particles than the smallest of the calibration's runs should have
small = ("-grid_cells", "32,32", "-body_disk1_radius", "0.25", "-body_disk1_center", "0.27,0.27", "-body_disk2_radius", "0.006",
         "-body_disk2_center", "0.822,0.822", "-body_disk2_velocity", "0,0")
if EXTENT == "rest":
    holds("a scene that cannot be as coarse as the calibration wants is calibrated nevertheless",
          re.search(r"^check .* ratio", run(*small, "-model_file", "small.model", program=calibrate), re.M))
    staged = {"scene": ["-options_file", check.scene("release"), "-model_file", "staged.model"]}
    run(program=calibrate, **staged)
    holds("of a scene in stages the first one is calibrated", re.search(r"^predict .* \(constants of staged.model\)$", run("-dry_run", **staged), re.M))
    check.end()

shutil.rmtree("output", ignore_errors=True)  # the constants that the last time left
plain = run()
holds("without a calibration the model says that it is rough", "constants rough" in plain)
holds("every phase of usf is predicted", {"P2G_MASS", "P2G_FORCE", "VELOCITY", "ADVANCE", "G2P_MOTION", "G2P_STRESS",
                                          "SORT", "REDUCE", "all"} <= set(predictions(plain)))

# ---- Contact: its search is shared by processes, its impulses are not, and both grow with the surface
def contact(*options, n=1, name="disks_contact"):
    scene = ["-options_file", check.scene(name), "-time_max_steps", "5", "-report_phases", "-output_format", "none"]
    found = predictions(run(*options, n=n, scene=scene))
    return found.get("FORCES", 0), found["ADVANCE"]


touching, apart = contact(), contact("-contact_mu", "0", "-body_disk2_velocity", "0.14,0")
alone = contact(name="disks")
holds("contact is predicted, whatever will happen, and only where it is declared", touching == apart and touching[0] > 0 and alone[0] == 0 and
      touching[1] > 3 * alone[1], f"{touching} {apart} {alone}")
fine, shared, block = contact("-grid_cells", "80,80"), contact(n=4), contact(name="dambreak_block")
nodes = [contact("-grid_cells", cells, name="disks")[1] for cells in ("40,40", "80,80")]  # without contact, four times as long
holds("twice the cells along a surface take twice the time", 1.8 < (fine[1] - nodes[1]) / (touching[1] - nodes[0]) < 2.3 and 1.8 < fine[0] / touching[0] < 2.6, f"{fine} {touching}")
holds("four processes share the search in 2-D by halves, and each finds the impulses", 0.35 < shared[0] / touching[0] < 0.55 and
      shared[1] > 0.9 * touching[1], f"{shared} {touching}")
holds("a rigid body counts too", block[0] > 0 and block[1] > 0, f"{block}")

# ---- A calibration, and a run by it
calibrated = run(n=2, program=calibrate)
holds("the calibration names its file", "output/disks.model" in calibrated and os.path.exists("output/disks.model"))
holds("a calibration runs no scene", "digest" not in calibrated)
holds("but first steps of it, to check itself", len(re.findall(r"^check .* on [12] process.* s a step, predicted \S+, ratio \d+\.\d+$", calibrated, re.M)) == 2)
constants = {}
for line in open("output/disks.model"):
    rate = re.match(r"rate (\w+) (.*)", line)
    if rate:
        constants[rate[1]] = [float(v) for v in rate[2].split()]  # call, then sizes and how much each
numbers = dict(re.findall(r"^([a-z]\S*) ([\d.e+-]+)$", open("output/disks.model").read(), re.M))
numbers.pop("within", None)  # there if the machine was disturbed
holds("all kinds of constants are there", {"exchange", "message", "post", "wire", "copy", "kept", "reduction", "job", "pool",
                                           "migration[0].call", "migration[1].particle", "flop", "byte"} <= set(numbers))
holds("no constant is negative or not finite",
      all(0 <= v < math.inf for rate in constants.values() for v in rate) and
      all(0 <= float(v) < 1 for v in numbers.values()))
fitted = run()
holds("the run says where its constants are from", "constants calibrated on 2 processes" in fitted)
LIMITS = r"^speed .* GB/s a process: [\d.e-]+ of ([\d.e+]+) GFlop/s and [\d.e-]+ of ([\d.e+]+) GB/s that a core can$"
limits = re.search(LIMITS, fitted, re.M)
holds("the line of the speed has the limits of the file", limits and all(
    abs(float(shown) * 1e9 * float(numbers[name]) - 1) < 0.01 for shown, name in zip(limits.groups(), ("flop", "byte"))))
with open("output/disks.model") as full, open("old.model", "w") as old:
    old.writelines(line for line in full if not line.startswith(("flop ", "byte ")))
without = run("-model_file", "old.model")
holds("a file without limits is used, and none are shown", "constants calibrated" in without and
      re.search(r"^speed .* a process$", without, re.M))
particles = int(re.search(r"(\d+) particles", fitted).group(1))
for phase in ("G2P_MOTION", "G2P_STRESS"):
    call, *pairs = constants[phase]
    sizes, each = pairs[::2], pairs[1::2]
    part = [min(1, max(0, math.log(particles / n0) / math.log(n1 / n0))) for n0, n1 in zip(sizes, sizes[1:])]
    expected = call + particles * (each[0] + sum(p * (e1 - e0) for p, e0, e1 in zip(part, each, each[1:])))
    shown = predictions(fitted)[phase]
    holds(f"{phase} is predicted by the formula", abs(shown - expected) <= 0.01 * expected, f"{shown:g} {expected:g}")
holds("the sum of the phases is the prediction of the step",
      abs(predictions(fitted)["all"] - sum(v for k, v in predictions(fitted).items() if k != "all"))
      < 0.01 * predictions(fitted)["all"])

# ---- A file written by hand, for a cluster that is not there, may name any method, but has to have all phases
with open("output/disks.model") as file, open("any.model", "w") as by_hand:
    by_hand.write(re.sub(r"\nmethod .*\nfrom .*", "\nmethod any\nfrom a guess", file.read()))
guessed = run("-model_file", "any.model", "-body_disk1_ppc", "4,2")
holds("a file for any method is used", "constants a guess" in guessed and "note " not in guessed)
holds("but not without a phase of the scene", "any.model is damaged" in run("-model_file", "any.model", "-method_update", "usl"))

# ---- Files that do not fit, or are not there
for what, options in (("with another update, transfer or material, or more or fewer particles a cell", ("-method_update", "usl")),
                      ("with another basis", ("-method_basis", "bspline2")), ("with other fields of particles", ("-method_transfer", "apic")),
                      ("with another update, transfer or material, or more or fewer particles a cell", ("-body_disk1_ppc", "3,3", "-body_disk2_ppc", "3,3"))):
    other = run(*options)
    note = re.search(rf"^note       output/disks.model was measured {what}, so rough constants predict times; "
                     r"make calibrate SCENE=<options file> measures those of this scene$", other, re.M)
    holds(f"a file measured {what} is not used, and the run says so at the start", note and note.start() < other.find("\npredict ") < other.find("\ndone ") and
          "(rough constants;" in other and "constants rough" in other)
bar = run("-model_file", "output/disks.model", scene=["-options_file", check.scene("bar"), "-time_max_steps", "2"])
holds("or in another dimension", "disks.model was measured in another dimension, so" in bar)
holds("one line says so", other.count("disks.model") == 1)
with open("output/disks.model") as file:
    lanes = re.sub(r"\n(method \S+?:\S+?:\S+?:)\d+", r"\n\g<1>3", file.read())
with open("lanes.model", "w") as file:
    file.write(lanes)
holds("or of another number of lanes", "was measured with another number of lanes" in run("-model_file", "lanes.model"))

# ---- A run of another name finds the file again: that of its own name first, else the newest that fits
predicted = r"^predict .* give or take a factor of \S+ \(constants of (\S+)\)$"
holds("a run by its file says which", re.search(predicted, fitted, re.M) and re.search(predicted, fitted, re.M)[1] == "output/disks.model")
ratios = [float(ratio) for ratio in re.findall(r"^check .* ratio (\S+)$", calibrated, re.M)]
most = [max(max(ratio + off, 1 / max(1e-9, ratio - off)) for ratio in ratios) for off in (-0.005, 0.005)]  # they have two digits after the point
promised = float(re.search(r"factor of (\S+) \(", fitted)[1].replace("two", "2"))
holds("it promises 1.3, and no less than its own check of the scene missed", promised == 1.3 and most[0] < 1.31 or most[0] - 0.01 < promised < most[1] + 0.11,
      f"{promised}, ratios {ratios}")
with open("output/disks.model") as file:
    missed = re.sub(r"\nwithin .*", "", file.read()).replace("\nfrom ", "\nwithin 4.5\nfrom ")
for factor in ("4.5", "0.5"):
    with open("missed.model", "w") as file:
        file.write(missed.replace("within 4.5", f"within {factor}"))
    said = run("-model_file", "missed.model")
    holds(f"a file that says {factor}", "give or take a factor of 4.5 (constants of missed.model)" in said if factor == "4.5" else "missed.model is damaged" in said)
renamed = run("-output_name", "renamed")
holds("a run of another name uses it", re.search(predicted, renamed, re.M) and predictions(renamed) == predictions(fitted) and "note " not in renamed)
os.utime("output/disks.model", (2e9, 2e9))
shutil.copy("output/disks.model", "output/older.model")
os.utime("output/older.model", (1e9, 1e9))
shutil.copy("lanes.model", "output/newest.model")  # and does not fit
os.utime("output/newest.model", (3e9, 3e9))
os.makedirs("output/folder.model", exist_ok=True)
holds("of those that fit the newest", re.search(predicted, run("-output_name", "renamed"), re.M)[1] == "output/disks.model")
holds("that of its own name first", re.search(predicted, run("-output_name", "older"), re.M)[1] == "output/older.model")
found = run("-output_name", "newest")
holds("and another where that does not fit, without a word", re.search(predicted, found, re.M)[1] == "output/disks.model" and "note " not in found)
holds("on several processes too", re.search(predicted, run("-output_name", "renamed", n=2), re.M)[1] == "output/disks.model")
other = run("-output_name", "renamed", "-method_update", "usl")
holds("files of other methods and names are passed over", "(rough constants;" in other and "note " not in other)
holds("a file that is named is the only one", "lanes.model was measured" in run("-model_file", "lanes.model") and "(rough constants;" in run("-model_file", "lanes.model"))
with open("single.model", "w") as file, open("output/disks.model") as whole:
    file.write(re.sub(r"\nfrom .*", r"\nfrom calibrated on 1 process (messages rough), today", re.sub(r"\nwithin .*", "", whole.read())))
holds("messages that were not measured count where there are any", "a factor of 1.3 " in run("-model_file", "single.model") and "a factor of two " in run("-model_file", "single.model", n=2))
for name in ("older", "newest"):
    os.remove(f"output/{name}.model")
os.rmdir("output/folder.model")
whole = open("output/disks.model").read()
for what, damaged in (("a number that is none", whole.replace("\nmessage ", "\nmessage x")), ("an infinite one", re.sub(r"\nwire .*", "\nwire inf", whole)),
                      ("a negative one", re.sub(r"\nmessage .*", "\nmessage -5", whole)), ("a rate that is none", re.sub(r"\nrate (\w+) \S+", r"\nrate \1 xyz", whole, count=1)),
                      ("a rate of two sizes", re.sub(r"\nrate (\w+)( \S+){3}", r"\nrate \1 1e-6", whole, count=1)),
                      ("a rate of no part", re.sub(r"\nrate (\w+)", r"\nrate \1X", whole, count=1)),
                      ("a rate less", re.sub(r"\nrate .*", "", whole, count=1)), ("no end", whole[:len(whole) // 2])):
    with open("damaged.model", "w") as file:
        file.write(damaged)
    text = run("-model_file", "damaged.model", n=2)
    holds(f"a file with {what} is not used, and the run says so", damaged != whole and "is damaged" in text and "constants rough" in text)
with open("output/cut.model", "w") as file:
    file.write(whole[:100])
holds("nor is one that ends before its first number", "output/cut.model is damaged" in run("-output_name", "cut", "-method_update", "usl"))
os.remove("output/cut.model")
holds("nor by a dry run, which says so", "is damaged" in run("-model_file", "damaged.model", "-dry_run"))

def given(path, call):
    """A model whose constants are all given here, so that what it says does not hang on the machine; of each message, `call`."""
    text = re.sub(r"\n(rate \w+) .*", r"\n\1 1e-6 1e3 1e-8 1e4 1e-8 1e5 1e-8", whole)
    for name in numbers:
        value = call if name in ("reduction", "post", "migration[0].call") else 1e-9 if name in ("wire", "copy", "kept", "pool") else 1e-6
        text = re.sub(rf"\n{re.escape(name)} .*", f"\n{name} {value:g}", text)
    return check.write(path, text)


given("slow.model", 0.9)
text = run("-model_file", "slow.model", "-dry_run", "-report_processes")
holds("where messages take a second, no number of particles keeps many processes efficient, and spatial is never ahead",
      "spatial is never ahead" in text and ", no number on 32768" in text, text[text.find("  pool:"):])
with open("scene.opts", "w") as file:
    file.write("-dim 2\n")
kept = open("scene.opts").read()
for what, options, expected in (
        ("overwrites no other file", ("-model_file", "scene.opts"),
         "-model_file: scene.opts has no constants of the model; make calibrate does not overwrite it"),
        ("names a folder that is not there", ("-model_file", "nowhere/x.model"),
         "-model_file: cannot write nowhere/x.model: No such file or directory"),
        ("has no dry run", ("-dry_run",), "make calibrate does not go with -dry_run: it times short runs"),
        ("refuses what a run refuses", ("-dt_cfl", "x"), None),
        ("knows no option of that name", ("-model_calibrate",), "-model_calibrate is no option: make calibrate "
         "SCENE=<options file> measures the constants of the model")):
    said = run(*options, status=2, program=calibrate, scene=whole_scene).strip()
    holds(f"a calibration {what}", said == expected if expected else "\n" not in said, said)
said = run(status=2, program=calibrate, scene=["-options_file", check.scene("reissner")]).strip()
holds("a calibration times explicit steps alone", said == "make calibrate times explicit steps, not those of -method_time static, euler or newmark: "
      "their time is predicted from the first iterations of Newton's method", said)
holds("and has left that file as it was", open("scene.opts").read() == kept)
holds("a file that is not there is refused", "-model_file" in run("-model_file", "nowhere.model", status=2))

# ---- Same bits with everything
work = []  # of each run: ns a particle and step, GFlop/s and GB/s of a process
for n, strategy in ((1, "spatial"), (3, "spatial"), (3, "pool")):
    text = run("-parallel_strategy", strategy, "-report_path", n=n)
    work.append([float(v) for v in re.search(r"^speed +(\S+) ns.*, (\S+) GFlop/s, (\S+) GB/s", text, re.M).groups()])
    for k, what in ((1, "operations"), (2, "bytes")):
        ratio = work[-1][0] * work[-1][k] * n / (work[0][0] * work[0][k])
        # nodes beside a cut are visited by the processes on both sides
        holds(f"{strategy} on {n}: {what} of all processes", abs(ratio - 1) < (0.1 if strategy == "spatial" else 0.03), f"{ratio:.3f}")
    rows = re.findall(r"^  (\S+) {10,}(\S+) +(\S+) +(\S+)", text.split("\npath")[1], re.M)
    holds(f"{strategy} on {n}: same digest", digest(text) == digest(plain))
    holds(f"{strategy} on {n}: the slowest work is no less than the mean, and on one process the same",
          rows and all(float(slowest) >= 0.999 * float(mean) and (n > 1 or slowest == mean)
                       for _, mean, slowest, _ in rows))
    holds(f"{strategy} on {n}: the phases are there", {"P2G_MASS", "G2P_STRESS", "all"} <= {row[0] for row in rows})

# ---- The table of a dry run
dry_run = ["-dry_run", "-report_processes", "-parallel_migrate", "direct", "-model_file", given("quick.model", 1e-6)]
dry = run(*dry_run)
ROW = re.compile(r"^ +(\d+) +([\d.e+-]+) +(\S+ \w+) +([\d.]+) +([\d.]+) +([\d.]+)(?: +([\d.e+-]+) +(\S+ \w+) +[\d.]+)?$", re.M)
table = ROW.findall(dry)  # processes, s/step, in all, speed-up, efficiency, imbalance, pool's s/step, in all
holds("a dry run predicts 1, 2, 4, ... processes", [int(row[0]) for row in table][:5] == [1, 2, 4, 8, 16])
for row in table:
    holds(f"{row[0]}: speed-up, efficiency and imbalance agree",
          abs(float(row[3]) / int(row[0]) - float(row[4])) < 0.01 and
          float(row[3]) <= 1.05 * int(row[0]) / float(row[5]) * 1.3)
for n in (3, 5):  # which count the particles in parts
    rows = ROW.findall(run(*dry_run, n=n))
    holds(f"{n} processes predict the same steps and imbalances", [(row[0], row[1], row[5]) for row in rows[1:]] == [(row[0], row[1], row[5]) for row in table[1:]])
for n in (2, 4):
    shown = re.search(r"max/mean ([\d.]+)", run("-dry_run", "-model_file", "quick.model", n=n)).group(1)
    holds(f"the imbalance predicted for {n} is that on {n}", float(table[int(math.log2(n))][5]) == float(shown))
holds("it names the pool's bound and its best patches", re.search(r"exceeds a speed-up of [\d.]+; best patches", dry))

check.end()
