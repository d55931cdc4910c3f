"""Messages of rare cases, each provoked by a run: stops, warnings, notes and refusals that no other test prints.

usage: test_messages.py PEBBLE SOURCE MPIEXEC
"""
import glob
import os
import pty
import re
import shutil
import subprocess

import h5py
import numpy as np

import check
import mpi

check.arguments(__doc__, 0)
DISKS = ["-options_file", check.scene("disks"), "-check_momentum", "0", "-check_energy", "0", "-report_indicator", "false"]
BAR = ["-options_file", check.scene("bar"), "-report_indicator", "false"]
QUIET = ["-output_format", "none"]
FEW = QUIET + ["-time_max_steps", "2"]
# A box of a material m in the middle of a grid between free faces.
BOX = """\
-dim 2
-grid_lower 0,0
-grid_upper 1,1
-grid_cells 8,8
-materials m
-material_m_model neohookean
-material_m_rho 1000
-material_m_E 1000
-material_m_nu 0.3
-bodies b
-body_b_shape box
-body_b_lower 0.25,0.25
-body_b_upper 0.75,0.75
-body_b_material m
-time_end 1
-report_indicator false
"""

def tell(name, status, pattern, *options, n=1, **more):
    """The run ends with this status, and what it says has the pattern."""
    run = check.pebble(*options, n=n, **more)
    check.that(run.status == status and re.search(pattern, run.said), f"{name}: status {run.status}, {pattern!r}")
    if run.status != status or not re.search(pattern, run.said):
        print(run.said[-2500:])
    return run


def box(name, status, pattern, *options, text=BOX, **more):
    path = check.write("box.opts", text)
    return tell(name, status, pattern, "-options_file", path, "-output_dir", "box", *options, **more)


# ---- Stops

walls = [word for face in ("xmin", "xmax", "ymin", "ymax") for word in (f"-bc_{face}_type", "slip")]
tell("-check_momentum", 3, "momentum changed by .* of sum m.v. = .*; -check_momentum allows 1e-12", *DISKS, *QUIET, *walls, "-check_momentum", "1e-12", "-output_dir", "out",
     "-body_disk1_velocity", "-0.1,0", "-body_disk2_velocity", "0,0")
box("through a wall", 3, r"particle 0 of b left the grid, to \(\S+ \S+\), through its wall xmax \(slip\); .*; use -dt_size auto", *QUIET, *walls, "-body_b_velocity", "1e3,0", "-dt_size", "1")
box("too wide for gimp", 3, r"the domain of particle \d+ of b at \(.*\) is stretched to \S+ cells, gimp allows 1 at most; .*; use a spline", *QUIET,
    "-method_basis", "gimp", "-method_gimp_update", "stretch", "-body_b_velocity", "(x-0.5)*2,0", "-material_m_E", "1e-3", "-grid_lower", "-4,0", "-grid_upper", "4,1",
    "-grid_cells", "64,8")
check.must(*BAR, *QUIET, "-time_end", "0.1", "-checkpoint_every", "0.1", "-output_dir", "tiny")
tell("a time step that vanishes", 3, "the time step, 1e-30 s, is too short to change the time", *BAR, *QUIET, "-output_dir", "tiny", "-time_end", "0.2", "-restart_file", "latest", "-dt_size", "1e-30",
     "-time_max_steps", "2000000000")

# ---- Warnings and notes

box("a stiff body beside a soft one", 0, "loses energy in each step, and the steps are those of the stiffest body", *FEW, "-materials", "m,hard", "-material_hard_model", "neohookean",
    "-material_hard_rho", "1000", "-material_hard_E", "1e9", "-material_hard_nu", "0.3", "-bodies", "b,c", "-body_c_shape", "box", "-body_c_lower", "0,0", "-body_c_upper", "0.2,0.2",
    "-body_c_material", "hard", "-method_transfer", "apic")
box("aflip with strain", 0, "is unstable where particles cross cells; use -method_affine_strain 0", *FEW, "-method_basis", "gimp", "-method_update", "usl", "-method_transfer", "aflip",
    "-method_affine_strain", "1")
tell("PEBBLE_VECTOR=3", 0, "note       PEBBLE_VECTOR=3 is not 8, 4 or 2: [248] lanes", *BAR, *FEW, "-output_dir", "out", lanes=3)
box("bodies that overlap", 0, "warning    16 particles lie in the shape of an earlier body too: matter is there twice", *FEW, "-bodies", "b,c", "-body_c_shape", "box",
    "-body_c_lower", "0.5,0.5", "-body_c_upper", "0.75,0.75", "-body_c_material", "m")
hole = [*FEW, "-bodies", "b,hole", "-body_hole_shape", "sphere", "-body_hole_material", "none", "-body_b_cut", "hole"]
nothing = "warning    -body_b_cut hole removes no particle of b; check where the shapes are, and their sizes"
box("a cut beside the body", 0, nothing, *hole, "-body_hole_center", "0.1,0.1", "-body_hole_radius", "0.1")
box("a cut at its corner that does not reach it", 0, nothing, *hole, "-body_hole_center", "0.1,0.1", "-body_hole_radius", "0.2")
box("a cut between the particles", 0, nothing, *hole, "-body_hole_center", "0.5,0.5", "-body_hole_radius", "0.03")
for what, options in (("reaches the corner", [*hole, "-body_hole_center", "0.1,0.1", "-body_hole_radius", "0.27"]),
                      ("is there twice", [*hole, "-bodies", "b,hole,again", "-body_again_shape", "sphere", "-body_again_material", "none", "-body_b_cut", "hole,again",
                                          *(word for name in ("hole", "again") for word in (f"-body_{name}_center", "0.5,0.5", f"-body_{name}_radius", "0.1"))])):
    run = box(f"a cut that {what}", 0, "digest", *options)
    check.that("removes no particle" not in run.out, f"a cut that {what} gets no warning")
box("one of two cuts", 0, "warning    -body_b_cut again removes no particle of b", *hole, "-body_hole_center", "0.5,0.5", "-body_hole_radius", "0.1", "-bodies", "b,hole,again",
    "-body_again_shape", "sphere", "-body_again_material", "none", "-body_again_center", "0.9,0.9", "-body_again_radius", "0.1", "-body_b_cut", "hole,again", n=2)
box("particles on lines", 0, "particles start exactly on lines of the grid, where the gradient of the linear basis jumps", *FEW, "-method_basis", "linear", "-body_b_offset", "0.03125,0")
gone = ["-bodies", "b,c", "-body_c_shape", "box", "-body_c_lower", "0,0", "-body_c_upper", "0.2,0.2", "-body_c_material", "m", "-body_b_velocity", "1e3,0", "-particles_leave", "delete", *QUIET,
        "-loads", "l", "-load_l_body", "b", "-load_l_type", "pressure", "-load_l_value", "1", "-checkpoint_every", "1", "-dt_cfl", "0.4", "-time_max_steps"]
box("bodies that leave", 0, "lost       64 of 73 particles", *gone, "30")
run = box("a load on nothing", 0, "warning    load l acts on no particle", *gone, "31", "-restart_file", "latest")
check.that("-body_b_shape" not in run.out and "-load_l_value" not in run.out, "nothing else is noted of a body that has left, and of its load")
box("a piston in a body", 0, "warning    16 particles start behind a piston, which moves them along", *FEW, "-bc_xmin_type", "piston", "-bc_xmin_velocity", "0", "-bc_xmin_distance", "0.375")
load = [*FEW, "-loads", "l", "-load_l_body", "b", "-load_l_type", "traction", "-load_l_face", "ymax"]
box("a probe in the air", 0, "note       probe p: no matter was within a cell of it at any line of the history, so that its columns are nan all the time; check -probe_p_at", *QUIET, "-probes", "p", "-probe_p_at", "0.1,0.95", "-time_end", "0.01")
box("a load that is 0", 0, "warning    load l is 0 on all of these particles, at the start and after each hundredth of -time_end; see -load_l_value", *load, "-load_l_value", "0,-(X > 5)")
box("a load's largest force", 0, r"load       l: traction on 8 particles of b, area along each axis \(0, 0.5\) m\^1, in all \(0, -1.5\) N at t=1 s", *load, "-load_l_value", "0,-3*t", "-time_end", "1")
fluid = re.sub(r"-material_m_(E|nu) .*\n", "", BOX).replace("neohookean", "fluid") + "-material_m_K 1e3\n-material_m_viscosity 1e3\n"
box("a step too long for viscosity", 0, r"warning    dt is above the bound of viscosity, h\^2/\(2 dim nu\) = \S+ s: expect the run to blow up", *FEW, "-dt_size", "0.01", text=fluid)
soil = BOX.replace("neohookean", "druckerprager") + "-material_m_friction_angle 60\n"
box("a friction angle without an equal in plane strain", 0, "acts in plane strain like 90 degrees or more, so that it hardly flows; if 60 is meant in plane strain, give", *FEW, text=soil)

metal = ["-material_m_model", "vonmises", "-material_m_rho", "7850", "-material_m_E", "2.1e11", "-material_m_yield"]
box("a yield stress in MPa", 0, "note       -material_m_yield 235 Pa is 1.12e-09 times -material_m_E; usual is 0.0001 to 0.05 times it; if MPa are meant, write 2.35e.08", *FEW, *metal, "235")
box("a modulus in MPa", 0, "note       -material_m_E 2.1e5 Pa: metals have 1e.10 to 5e.11; if MPa are meant, write 2.1e.11", *FEW, *metal, "235", "-material_m_E", "2.1e5")
run = box("both in Pa", 0, "digest", *FEW, *metal, "2.35e8", "-output_name", "metal", "-body_b_velocity", "1,0")
check.that("note " not in run.out, "a metal in SI units gets no note")
hot = re.sub(r"-material_m_(E|nu) .*\n", "", BOX).replace("neohookean", "johnsoncook").replace("1000", "8960", 1) + \
    "".join(f"-material_m_{name}\n" for name in ("G 4.7e10", "c0 3933", "hugoniot_slope 1.489", "gruneisen 1.99", "yield 9e7", "specific_heat 383"))
box("degrees Celsius", 0, "note       -material_m_temperature 25 is in K, as -material_m_melting is; if degrees Celsius are meant, write 298.15 and 1356.15", *FEW,
    "-material_m_temperature", "25", "-material_m_melting", "1083", text=hot)
box("a shear modulus in GPa", 0, "note       -material_m_G 47 Pa: metals have 4e.09 to 3e.11; if GPa are meant, write 4.7e.10", *FEW, "-material_m_G", "47", text=hot)
box("few steps", 0, r"note       the run makes only \d+ steps until -time_end 0.2 s, in which waves cross few cells; check it, and the units of moduli and densities", *QUIET, "-time_end", "0.2")
run = box("no other notes", 0, "digest", *QUIET, "-output_name", "plain", "-dt_cfl", "0.4", "-body_b_velocity", "0.1,0")
check.that("note " not in run.out, f"a run of more steps gets no note: {run.find('^(note .*)$')}")

run = box("a large set-up", 0, r"(?s)set-up +2097152 particles are counted and checked; they are being made\n.*they are being put in order\n.*are in order\n", "-dry_run", "-grid_cells", "1024,1024",
          "-body_b_lower", "0,0", "-body_b_upper", "0.5,1", "-body_b_velocity", "1,0", *QUIET)
check.that(not re.search("^set-up", box("a small one", 0, "valid", "-dry_run").out, re.M), "a small one says nothing of it")

# ---- Bodies

run = box("a body", 0, r"body       b: box of m, 64 particles, 250 kg, 0.25 m\^3 for a thickness of 1 m", *FEW)
many = [f"b{k}" for k in range(10)]
rows = [word for k, name in enumerate(many) for word in (f"-body_{name}_shape", "box", f"-body_{name}_lower", f"{k / 10},0.25", f"-body_{name}_upper", f"{k / 10 + 0.1},0.75", f"-body_{name}_material", "m")]
runs = [box(f"ten bodies, {n} processes", 0, r"(?s)(body       b\d: box .*?\n){8}body       and 2 more bodies with \d+ particles together", *FEW, "-bodies", ",".join(many), *rows, n=n,
            text=re.sub(r"-bodies b\n(-body_b_.*\n)*", "", BOX)) for n in (1, 2)]
bodies = [[line for line in run.out.splitlines() if line.startswith("body ")] for run in runs]
check.that(bodies[0] == bodies[1] and len(bodies[0]) == 9, f"bodies are told alike on 1 and 2 processes: {bodies}")
check.write("points.csv", "x,y,volume\n0.5,0.5,0.01\n0.6,0.5,0.02\n0.7,0.3,0.03\n")
points = re.sub(r"-body_b_.*\n", "", BOX) + "-body_b_shape file\n-body_b_file points.csv\n-body_b_material m\n"
for n in (1, 2):
    box(f"particles of a file, {n} processes", 0, r"body       b: file of m, 3 particles, 60 kg, 0.06 m\^3 for a thickness of 1 m", *FEW, text=points, n=n)

# ---- Refusals

tell("sums to rounding in the pool", 2, "-parallel_sums roundoff does not apply: the pool always gives bitwise sums", *DISKS, "-parallel_strategy", "pool", "-parallel_sums", "roundoff", n=2)

# ---- Files

os.makedirs(check.folder("folder") + "/disks.csv")
tell("a folder where the history goes", 2, "-output_name: folder/disks.csv is there and is not a file", *DISKS, "-output_dir", "folder")
with h5py.File("none.h5", "w") as file:
    file["x"] = 1
tell("-rerun of other HDF5", 2, "-rerun: cannot repeat none.h5: it has no options of a run of pebble", "-rerun", "none.h5", "-output_dir", "out")


# Checkpoints of another program, whole all the same.
def mix(x):
    x ^= x >> np.uint64(30)
    x *= np.uint64(0xbf58476d1ce4e5b9)
    x ^= x >> np.uint64(27)
    x *= np.uint64(0x94d049bb133111eb)
    return x ^ (x >> np.uint64(31))


def another(name, change, status, pattern):
    """A restart from a checkpoint whose HDF5 part is changed, with its checksum."""
    folder = check.folder("another")
    path = f"{folder}/bar-checkpoint-1.h5"
    shutil.copy("tiny/bar-checkpoint-1.h5", path)
    with h5py.File(path, "r+") as file:
        change(file)
    data = check.content(path)
    body = data[512:]
    words = np.frombuffer(body + bytes(-len(body) % 8), dtype="<u8")
    with np.errstate(over="ignore"):
        places = np.arange(64, 64 + len(words), dtype=np.uint64) * np.uint64(0x9e3779b97f4a7c15)
        total = int(mix(words + mix(places)).sum(dtype=np.uint64))
    head = b"pebble checkpoint 1\nbytes %020d\nchecksum %016x\n" % (len(data), total)
    with open(path, "wb") as file:
        file.write(head.ljust(512, b"\0") + body)
    tell(name, status, pattern, *BAR, *FEW, "-output_dir", folder, "-restart_file", path)


def without(file):
    del file["run/dt"]


def totals(file):
    text = file["run/totals"][0].replace(b"step", b"pets")
    file["run/totals"][...] = np.array([text], file["run/totals"].dtype)


def fields(file):
    file["particles"].move("F", "deformation")


def commit(file):
    file.attrs["git"] = np.bytes_("v0")


def pool(file):
    file.attrs["options"] = np.bytes_(file.attrs["options"] + b"-pool_particles workers\n")


another("a checkpoint that lacks a number", without, 3, "cannot go on from another/bar-checkpoint-1.h5: it has no dt, or another one: another version of pebble wrote it")
another("a checkpoint of other columns", totals, 3, "cannot go on from another/bar-checkpoint-1.h5: another version of pebble wrote it")
another("a checkpoint of other fields", fields, 3, r"-restart_file another/bar-checkpoint-1.h5: its particles have no F \(deformation gradient, row-major\), which this run needs; let the run before have it too, by the options that differ or by -output_fields")
another("a checkpoint of another commit", commit, 0, r"note       v0 wrote the checkpoint, and this is \S+: the bits may differ from those of a run without a restart")
another("a checkpoint of a pool whose workers kept the particles", pool, 0, "restart    changed options: .*-pool_particles not given, was workers")
data = check.content("tiny/bar-checkpoint-1.h5")
with open("another/bar-checkpoint-2.h5", "wb") as file:
    file.write(data.replace(b"pebble checkpoint 1", b"pebble checkpoint 0", 1))
tell("a checkpoint of another form", 2, "cannot go on from another/bar-checkpoint-2.h5: it is a checkpoint of another version of pebble", *BAR, *FEW, "-output_dir", "another",
     "-restart_file", "another/bar-checkpoint-2.h5")
full = check.run(["bash", "-c", "ulimit -f 100; exec \"$@\"", "bash", check.program, *BAR, *QUIET, "-output_dir", "full", "-history_every", "0", "-time_end", "400"])
check.that(full.status == 3 and re.search(r"cannot write full/bar.csv: File too large; go on with: .* -restart_file full/bar-checkpoint-1.h5", full.err),
           f"a history that is full leaves a checkpoint: {full.status} {full.err[-300:]}")

check.must(*BAR, *QUIET, "-time_end", "0.3", "-checkpoint_every", "0.1", "-output_dir", "later")
tell("a restart from an older checkpoint", 0, r"warning    there are later checkpoints, to later/bar-checkpoint-3.h5: -restart_file latest takes that one until this run has written its own",
     *BAR, *QUIET, "-time_end", "0.4", "-output_dir", "later", "-restart_file", "later/bar-checkpoint-2.h5")
tell("intervals that follow -time_end", 0, r"restart    history every 0.01 s, was 0.004 s; snapshots every 0.04 s, were 0.04 s", *BAR, *QUIET, "-time_end", "0.5", "-history_every", "0.01",
     "-output_dir", "later", "-restart_file", "latest")
many = check.write("many.opts", ["-dim 2"] + [f"-x{k} 1" for k in range(3000)])
tell("more options than PETSc takes, or unknown ones", 2, r"^3002 options are given, and this PETSc takes \d+: a polygon|-x0 is not an option of this scene", "-options_file", many, "-x1", "2", "-x3000", "1")

check.that("results    full/bar.csv\n" in full.out, "the files of results are named")
vanished = check.run(["bash", "-c", "(while [ ! -s vanished/bar.csv ]; do sleep 0.01; done; mv vanished moved) & exec \"$@\"", "bash", check.program, *BAR, "-output_dir", "vanished",
                      "-time_end", "400"])
check.that(vanished.status == 3 and "results " not in vanished.out, f"files that are not there are not: {vanished.find('^(results .*)$')}")

# The files of a run are as large as a dry run says.
more = ["-checkpoint_every", "0.5", "-checkpoint_keep", "5", "-output_dir", "sizes"]
dry = check.must(*DISKS, "-dry_run", *more)
check.must(*DISKS, *more)
said = re.search(r"^files +(\S+) snapshots of (\S+) MB, 6 checkpoints of (\S+) MB at a time, history of (\S+) MB: about (\S+) MB; the disk of sizes has \S+ MB free$", dry.out, re.M)
check.need(said, f"-dry_run says how large the files are: {dry.out}")
said = [float(number) for number in said.groups()]
sizes = [[os.path.getsize(path) / 1e6 for path in glob.glob(f"sizes/disks{kind}")] for kind in (".snapshots/*", "-checkpoint-*.h5", ".csv")]
found = [len(sizes[0]), max(sizes[0]), max(sizes[1]), sizes[2][0]]
check.that(all(0.9 * there < told < 1.2 * there for told, there in zip(said, found)), f"number and sizes of snapshots, checkpoints and history: predicted {said}, are {found}")
tell("more than the disk holds", 0, "warning    the files of this run need about .* MB, and the disk of out has .* MB free; choose a larger -output_every", *DISKS, "-dry_run", "-output_dir", "out",
     "-output_every", "0", "-time_end", "2e7")


def on_terminal():
    """A long run whose standard output is a terminal, ended after its first line of progress: what it prints."""
    leader, follower = pty.openpty()
    process = subprocess.Popen([check.program, *BAR, *QUIET, "-check_energy", "0", "-history_every", "1e9", "-time_end", "1e6", "-output_dir", "out"], stdin=subprocess.DEVNULL, stdout=follower,
                               stderr=subprocess.DEVNULL, env=os.environ | mpi.ENVIRONMENT | mpi.ALONE)
    os.close(follower)
    text, told = b"", False
    try:
        while part := os.read(leader, 65536):
            text += part
            if not told and (told := b" left" in text):
                process.terminate()
    except OSError:  # the other end is closed
        pass
    os.close(leader)
    return process.wait(check.TIMEOUT), *mpi.keep(text.decode())


status, said = on_terminal()
check.that(status == 3 and re.search(r"\rstep \d+  t=\S+ of 1e\+06 s  \d+ %  \S+ (second|minute|hour|day|year)s? left", said), f"the line of progress on a terminal: status {status} {said[-200:]!r}")
check.end()
