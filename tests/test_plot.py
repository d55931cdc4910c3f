"""tools/plot.py and tools/movie.py: what they draw of runs is right, every option makes a picture, bad ones get one line, a movie has
a frame for each snapshot, and the commands in the comments of options/ are right.

usage: test_plot.py PEBBLE SOURCE MPIEXEC
"""
import contextlib
import glob
import io
import os
import re
import sys

import h5py
import numpy as np
from PIL import Image

import check

check.arguments(__doc__, 0)
sys.path[:0] = [os.path.join(check.source, "tools"), os.path.join(check.source, "lab")]
import drawing  # noqa: E402 (its folder is known only now)
import movie  # noqa: E402
import pebble_mpm  # noqa: E402
import plot  # noqa: E402


def call(program, *words):
    """Exit status and what was printed, standard error last."""
    out, err, kept, status = io.StringIO(), io.StringIO(), sys.argv, 0
    sys.argv, drawing.PROGRAM = [program.__name__ + ".py", *words], program.__name__ + ".py"
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            program.main()
        except SystemExit as end:
            status = end.code if isinstance(end.code, int) else bool(end.code)
            if isinstance(end.code, str):
                err.write(end.code + "\n")
    sys.argv = kept
    plot.plt.close("all")
    return status, out.getvalue(), err.getvalue()


def picture(name, *words):
    """A small picture as an array; None if there is none."""
    if os.path.exists("p.png"):
        os.remove("p.png")
    save, plot.save = plot.save, lambda figure, out: figure.savefig(out, dpi=50)
    status, _, err = call(plot, f"{name}.h5", "-o", "p.png", "--small", *words)
    plot.save = save
    if status or not os.path.exists("p.png"):
        print(err)
        return None
    with Image.open("p.png") as image:
        return np.asarray(image.convert("RGB")).astype(int)


def refused(program, wrong, *words):
    status, _, err = call(program, *words)
    lines = err.strip().splitlines()
    check.that(status == 1 and len(lines) == 1 and wrong in lines[0] and lines[0].startswith(program.__name__ + ".py: "),
               f"{program.__name__} {' '.join(words)}: {lines}")


common = ["-output_dir", "."]
check.must("-options_file", check.scene("disks"), "-output_every", "0.25", "-time_end", "1.5", *common)
check.must("-options_file", check.scene("dambreak"), "-body_column_ppc", "1,2", "-output_every", "0.1", "-time_end", "0.4", *common)
check.must("-options_file", check.scene("dambreak3d"), "-body_column_ppc", "1,1,1", "-output_every", "0.1", "-time_end", "0.2", *common)
check.must("-options_file", check.scene("bar"), "-output_every", "0.5", "-time_end", "1", *common)

# ---- Domains are as large as the particles, in the right place; a fluid's fill the gaps.
for name, allowed in (("disks", 1e-12), ("dambreak", 0.08), ("dambreak3d", 0.3)):
    run = drawing.read_run(f"{name}.h5", "stress", count=None)
    last = run["snapshots"][-1]
    mine, true = np.abs(np.linalg.det(last["domain"])).sum(), (last["size"]**run["dim"]).sum()
    check.that(abs(mine / true - 1) <= allowed, f"{name}: the domains' volume is {mine / true:.4f} of the particles'")
    first = run["snapshots"][0]
    sides = np.array([np.diag(domain) for domain in first["domain"]])
    ppc = {"disks": 4, "dambreak": [1, 2], "dambreak3d": 1}[name]
    check.that(np.allclose(sides, run["h"] / ppc), f"{name}: at the start domains are cells over particles per cell: {sides[0]}")
    check.that([snapshot["round"] for snapshot in run["snapshots"]] == sorted({round(snapshot["round"], 2) for snapshot in run["snapshots"]}),
               f"{name}: times in titles are round: {[snapshot['round'] for snapshot in run['snapshots']]}")

# ---- Without the field volume, sizes come from the spacing at the start
check.must("-options_file", check.scene("disks"), "-output_fields", "stress", "-output_name", "bare", "-output_every", "0.5", "-time_end", "1", *common)
check.must("-options_file", check.scene("bar"), "-output_fields", "stress", "-output_name", "line", "-output_every", "0.5", "-time_end", "1", *common)
with h5py.File("bare.h5") as file:
    there = {field for key in file if key.startswith("step_") for field in file[key]["particles"]}
run = drawing.read_run("bare.h5", "stress", series=["front"])
size = run["h"][0] / 4
check.that("volume" not in there and all(np.allclose(np.append(one["size"], one["domain"][:, 0, 0]), size) for one in run["snapshots"]),
           f"without volume: particles of {run['snapshots'][0]['size'][:1]} m, which are {size} m apart; the file has {sorted(there)}")
check.that(all(picture(name, "--below", "none") is not None for name in ("bare", "line")), "pictures without volume")
check.that(call(movie, "bare.h5", "-o", "bare.gif")[0] == 0, "a movie without volume")


def covered(name, x, y):
    """The part of a strip of places at height y that domains of the last snapshot cover."""
    run = drawing.read_run(f"{name}.h5", "speed", times=[0.4])
    snapshot = run["snapshots"][0]
    there = np.stack([x, np.full(len(x), y)], axis=1)
    local = np.linalg.solve(snapshot["domain"][None], (there[:, None] - snapshot["x"][None])[..., None])[..., 0]
    return (np.abs(local).max(-1) <= 0.505).any(1).mean()


part = covered("dambreak", np.linspace(0.05, 1.8, 200), 0.1)
check.that(part >= 0.98, f"dambreak: {part:.3f} of a line through the water is covered")
for time, step, short in ((0.4973, 0.003, 0.5), (0.4973, 0.0001, 0.4973), (0.6146, 0.0154, 0.6), (0, 1e-3, 0), (2.0499, 1e-3, 2.05)):
    check.that(drawing.round_time(time, step) == short, f"{time} with steps of {step} is {drawing.round_time(time, step)}")
layouts = {aspect: plot.layout_of(6, aspect) for aspect in (0.12, 0.45, 1, 3)}
check.that(layouts == {0.12: (6, 1), 0.45: (3, 2), 1: (2, 3), 3: (1, 6)}, f"wide scenes are stacked, narrow ones side by side: {layouts}")

# ---- The fields of a file, and what it lacks; values that some particles do not have
check.must("-options_file", check.scene("disks"), "-output_fields", "von_mises,pressure", "-output_name", "numbers", "-output_every", "0.5", "-time_end", "1", *common)
for field, label, signed in (("pressure", "pressure [Pa]", True), ("von_mises", "von Mises stress [Pa]", False)):
    run = drawing.read_run("numbers.h5", field)
    check.that((run["label"], run["signed"]) == (label, signed) and picture("numbers", "--field", field) is not None, f"--field {field}: {run['label']}")
with h5py.File("numbers.h5") as index, h5py.File("numbers.snapshots/" + index.get(sorted(key for key in index if key.startswith("step_"))[-1], getlink=True).filename.split("/")[-1], "r+") as file:
    key = next(key for key in file if key.startswith("step_"))
    file[key]["particles/von_mises"][:800] = np.nan
grey = picture("numbers", "--field", "von_mises", "--times", "1", "--below", "none")
check.that(grey is not None and (np.abs(grey - 217).max(-1) <= 4).mean() > 0.02, "particles without a value are grey")

# ---- What took the energy
for options, loser in (({"bc_ymin_type": "friction"}, "friction"), ({"material_sand_model": "druckerprager"}, "friction"),
                       ({"material_copper_model": "vonmises"}, "plastic flow"), ({"bc_ymin_type": "slip"}, "the method"),
                       ({"bc_ymin_type": "moving"}, ""), ({"body_ram_rigid": "moving"}, ""), ({"body_block_rigid": "fixed"}, "the method"), ({"bc_ymin_type": "piston"}, ""), ({"acceleration": "1, 0"}, ""), ({"material_oil_viscosity": "2"}, "viscosity"), ({"mms_type": "axis"}, "")):
    check.that(plot.loser_of(options) == loser, f"with {options} energy is lost to '{plot.loser_of(options)}'")
run, history = drawing.read_run("dambreak.h5", "speed"), plot.read_history("dambreak.csv", True)
curves = {name: values for name, values, _, _ in plot.energy_curves(run, history)}
rest = curves["work of gravity"] - sum(values for name, values in curves.items() if name != "work of gravity")
check.that(np.abs(rest).max() < 1e-9 * curves["work of gravity"].max() and "lost to damping, and by the method" in curves,
           f"kinetic, strain and lost energy are the work of gravity: {np.abs(rest).max():.1e} J apart; {list(curves)}")

# ---- Every option makes a picture, another one than without it.
plain = {name: picture(name, "--times", "0,0.2") for name in ("disks", "dambreak3d")}
check.that(all(one is not None and (one != 255).mean() > 0.02 for one in plain.values()), "pictures of disks and dambreak3d")
for name, words in (("disks", ("--field", "stress_yy", "--below", "none")), ("disks", ("--no-domains", "--times", "0.5,1.25")),
                    ("disks", ("--xlim", "0.2,0.6", "--ylim", "0.1,0.5", "--below", "front,height")),
                    ("disks", ("--history", "momentum_*,kinetic_energy", "--times", "1")),
                    ("dambreak3d", ("--slice", "y=0.1", "--zlim", "0,1", "--below", "none"))):
    one = picture(name, *words)
    check.that(one is not None and (one.shape != plain[name].shape or (one != plain[name]).any()) and (one != 255).mean() > 0.02,
               f"{name} {' '.join(words)}")
check.that(picture("bar") is not None, "a picture in 1-D")
status, out, err = call(plot, "disks.h5", "-o", "p.png", "--times", "1.13", "--below", "none")
check.that(out == "p.png   1 snapshots\n", f"what was written is told: {out}")
for program, name in ((plot, "p.png"), (movie, "p.gif")):
    status, out, err = call(program, "disks.h5", "-o", name, "--times", "1", "--xlim", "-0.5,0.5", "--ylim", "-.25,1")
    check.that(status == 0 and out.startswith(name), f"limits below 0: {out}{err}")
status, out, err = call(plot, "disks.h5", "-o", "p.png", "--times", "1.13", "--below", "none")
check.that(status == 0 and "--times 1.13: the nearest snapshot is of 1.0" in err, f"a time without a snapshot: {err.strip()}")

with h5py.File("disks.h5") as file:
    for name, column in (("stress_yy", ("stress", 4)), ("v_x", ("v", 0))):
        last = max((key for key in file if key.startswith("step_")), key=lambda key: int(key[5:]))
        run = drawing.read_run("disks.h5", name, times=[1.5])
        same = np.allclose(run["snapshots"][0]["values"], file[f"{last}/particles/{column[0]}"][:, column[1]])
        check.that(same and run["signed"], f"--field {name} is that component: {run['label']}")

# ---- Rigid bodies: loops and cuts of their surfaces enclose them, and they are drawn where they are, filled, with holes.
def area_of(loops):
    return sum(0.5 * abs((x * np.roll(y, -1) - y * np.roll(x, -1)).sum()) for x, y in (loop.T for loop in loops))


def tool_of(name, **options):
    return [word for option, value in options.items() for word in (f"-body_{name}_{option}", value)]


check.must("-options_file", check.scene("disks"), "-bodies", "disk1,disk2,ring,bar", "-output_name", "rigid", "-check_energy", "0", "-check_momentum", "0", "-output_every", "0.25", "-time_end", "0.5", *common,
           *tool_of("ring", shape="annulus", center="0.75,0.25", radius="0.2", inner_radius="0.1", rigid="fixed"),
           *tool_of("bar", shape="box", lower="0.1,0.6", upper="0.3,0.7", rigid="moving", velocity="0.4,0", spin="pi", pivot="0.2,0.65"))
check.must("-options_file", check.scene("dambreak3d"), "-bodies", "column,ball", "-output_name", "rigid3d", "-check_energy", "0", "-time_max_steps", "1", *common,
           *tool_of("ball", shape="sphere", center="1.2,0.1,0.5", radius="0.09", rigid="fixed"))
last = drawing.read_run("rigid.h5", "speed", times=[0.5])["snapshots"][0]
loops = drawing.loops_of(last["rigid"])
with h5py.File("rigid.h5") as file:
    first, end = (sorted(key for key in file if key.startswith("step_"))[k] for k in (0, -1))
    names, place, turn, t = file[end]["rigid"].attrs["names"].decode(), file[end]["rigid/place"][1], file[end]["rigid/turn"][1].reshape(3, 3), file[end].attrs["time"]
    was, now = file[first]["rigid/x"][:], file[end]["rigid/x"][:]
    bar = file[end]["rigid/faces"][:][file[end]["rigid/body"][:] == 1].ravel()
moved = (was[bar] - [0.2, 0.65, 0]) @ turn.T + place
check.that(names == "ring,bar" and np.allclose(place, [0.2 + 0.4 * t, 0.65, 0], atol=1e-12) and abs(turn[1, 0] - np.sin(np.pi * t)) < 1e-6,
           f"rigid bodies {names}: place and turn at {t:g} s: {place} {turn[1, 0]}")
check.that(np.abs(now[bar] - moved).max() < 1e-15, "their surfaces are moved with them")
read = [pebble_mpm.load(name).snapshots[-1].rigid for name in ("rigid", "disks")]
check.that(np.array_equal(read[0]["x"], now) and len(read[1]) == 0, f"pebble_mpm reads {list(read[0])}, and none of a run without")
check.that(len(loops) == 3 and abs(area_of(loops) - np.pi * (0.2**2 + 0.1**2) - 0.02) < 1e-3, f"{len(loops)} loops of a ring and a bar, {area_of(loops)} m2")
ball = drawing.read_run("rigid3d.h5", "speed", times=[0])["snapshots"][0]["rigid"]
volume = abs(np.einsum("ij,ij->i", np.cross(ball[:, 0] - [1.2, 0.1, 0.5], ball[:, 1] - [1.2, 0.1, 0.5]), ball[:, 2] - [1.2, 0.1, 0.5])).sum() / 6
check.that(abs(volume / (4 / 3 * np.pi * 0.09**3) - 1) < 0.2, f"triangles of a ball enclose {volume:.3g} m3")
cut = drawing.loops_of(drawing.cut_triangles(ball, 1, 0.11)[:, :, [0, 2]])
check.that(len(cut) == 1 and abs(area_of(cut) / (np.pi * (0.09**2 - 0.01**2)) - 1) < 0.2, f"a cut of the ball: {len(cut)} loops, {area_of(cut):.3g} m2")
for name, words in (("rigid", ("--times", "0,0.5")), ("rigid3d", ("--times", "0")), ("rigid3d", ("--times", "0", "--slice", "y=0.1"))):
    kept, one = drawing.draw_rigid, picture(name, "--below", "none", *words)
    drawing.draw_rigid = lambda *_: None
    other = picture(name, "--below", "none", *words)
    drawing.draw_rigid = kept
    changed = (one != other).any(-1)
    check.that(changed.sum() > 30 and np.ptp(one[changed], axis=-1).max() < 60, f"{name} {' '.join(words)}: rigid bodies are {changed.sum()} grey pixels")

# ---- Every column of a history has a unit; curves and their axis have names
check.must("-options_file", check.scene("taylor3d"), "-time_max_steps", "1", "-output_format", "none", "-output_name", "columns", "-history_bodies", "all", "-history_body_quantities", "all", "-history_walls", "all",
           "-history_energy", "-probes", "p,q", "-probe_p_particle", "3", "-probe_p_fields", "all,error_indicator", "-probe_q_at", "0,0,0", "-probe_q_fields", "all", *common)
check.must("-options_file", check.scene("roll"), "-time_max_steps", "1", "-output_format", "none", "-output_name", "rolls", *common)
names = {name for file in ("columns", "rolls") for name in check.history(f"{file}.csv")}
check.that(len(names) > 90 and all(map(plot.unit_of, names)), f"{len(names)} columns have units; without: {[name for name in names if not plot.unit_of(name)]}")
for columns, label, curves in ((["reaction_ymin_y"], "reaction ymin y [N]", ["reaction ymin y"]), (["mass"], "mass [kg]", ["mass"]), (["momentum_x", "momentum_y"], "[kg m/s]", ["momentum x", "momentum y"]),
                               (["mass", "momentum_x"], "value, in the unit of its name", ["mass [kg]", "momentum x [kg m/s]"])):
    figure, axes = plot.plt.subplots()
    plot.draw_curves(axes, drawing.read_run("disks.h5", "speed"), {name: np.ones(3) for name in ("time", *columns)}, columns, None)
    check.that(axes.get_ylabel() == label and [line.get_label() for line in axes.lines if line.get_label()[0] != "_"] == curves, f"{columns}: axis {axes.get_ylabel()}")
    plot.plt.close(figure)

# ---- Flowing soil is not drawn as needles, solids as they are
run = {"options": {"bodies": "a,b", "body_a_material": "s", "body_b_material": "r", "material_s_model": "druckerprager", "material_r_model": "neohookean"}}
needles = np.array([[[9.0, 0], [0, 1 / 9]], [[2, 1], [0, 1]]])
drawn = drawing.rounded(needles, 3)
check.that(drawing.flows(run, 0) and not drawing.flows(run, 1) and np.allclose(np.linalg.det(drawn), np.linalg.det(needles)) and
           np.allclose(np.linalg.svd(drawn)[1][0], [3**0.5, 3**-0.5]) and np.allclose(drawn[1], needles[1]), "needles are drawn 3 times as long as wide, with their area")

# ---- Known curves: units, places, and a picture with points in their colour
check.write("known.csv", "# source: a book\n# front: x in 0.5 s, y in 2 m\nwhere,style,label,x,y\nfront,points,measured,1,0.25\nfront,points,measured,2,0.3\nt=0.75,line,surface,0.1,0.1\nt=0.75,line,surface,0.9,0.9\n")
known = plot.read_curves("known.csv")
front = next(curve for curve in known["curves"] if curve["where"] == "front")
check.that(np.allclose(front["x"], [0.5, 1]) and np.allclose(front["y"], [0.5, 0.6]) and known["sources"] == ["a book"], f"known curves: {front}")
crimson = (220, 20, 60)
one, other = picture("disks", "--below", "front", "--curves", "known.csv", "--times", "0,0.75"), picture("disks", "--below", "front", "--times", "0,0.75")
check.that(one is not None and (one == crimson).all(-1).sum() > 30 > (other == crimson).all(-1).sum(), "known curves are drawn")

# ---- Bad arguments
refused(plot, "no such file", "missing.h5")
refused(plot, "no field 'colour'", "disks.h5", "--field", "colour")
refused(plot, "give numbers", "disks.h5", "--times", "0,soon")
refused(plot, "the snapshots are from 0 to", "disks.h5", "--times", "7")
refused(plot, "give two numbers", "disks.h5", "--xlim", "0")
refused(plot, "first number must be below", "disks.h5", "--ylim", "1,0")
refused(plot, "nothing of the grid", "disks.h5", "--xlim", "3,4")
refused(plot, "--zlim: the run has only x y", "disks.h5", "--zlim", "0,1")
refused(plot, "--slice is for runs in 3-D", "disks.h5", "--slice", "y=0")
refused(plot, "give an axis and a place", "dambreak3d.h5", "--slice", "0.5")
refused(plot, "outside of the grid", "dambreak3d.h5", "--slice", "y=50")
refused(plot, "--below heat", "disks.h5", "--below", "heat")
refused(plot, "disks.csv is a history: draw it by", "disks.csv")
refused(plot, "no field 'stress_ab'", "disks.h5", "--field", "stress_ab")
refused(plot, "no such column; there are: step time", "disks.h5", "--history", "heat_*")
check.write("style.csv", "where,style,label,x,y\nfront,thick,a,1,2\n")
refused(plot, "choose line or points", "disks.h5", "--curves", "style.csv")
check.write("columns.csv", "x,y\n1,2\n")
refused(plot, "its columns must be", "disks.h5", "--curves", "columns.csv")
refused(plot, "cannot read nothing.csv", "disks.h5", "--curves", "nothing.csv")
refused(plot, "has curves for front t=0.75: draw one of these", "disks.h5", "--curves", "known.csv", "--times", "0")
refused(plot, "cannot write", "disks.h5", "-o", "no/folder.png")
refused(movie, "no such file", "missing.h5")
refused(movie, "must end in .mp4, .gif, .webp", "disks.h5", "-o", "disks.avi")
refused(movie, "above 0, at most 60", "disks.h5", "--fps", "0")
refused(movie, "cannot write", "disks.h5", "-o", "no/folder.gif")

# ---- A movie has a frame for each snapshot; without ffmpeg MP4 is refused with the remedy, and GIF is the default.
path, os.environ["PATH"] = os.environ["PATH"], os.path.abspath(".")
refused(movie, "there is no ffmpeg; install it (apt-get install ffmpeg) or give a name that ends in .gif", "disks.h5", "-o", "disks.mp4")
status, out, err = call(movie, "disks.h5", "--dpi", "50", "--fps", "10")
os.environ["PATH"] = path
with Image.open("disks.gif") as gif:
    frames = gif.n_frames
    check.that(status == 0 and frames == 7 and out.startswith("disks.gif   7 frames, 0.7 s; there is no ffmpeg"), f"{frames} frames of 7 snapshots: {out}{err}")
    shots = []
    for k in range(frames):
        gif.seek(k)
        shots.append(np.asarray(gif.convert("RGB")).astype(int))
check.that(all(shot.shape == shots[0].shape for shot in shots) and all((a != b).any() for a, b in zip(shots, shots[1:])), "all of one size, each another")
status, out, err = call(movie, "dambreak3d.h5", "--dpi", "40", "-o", "part.webp", "--times", "0,0.2", "--slice", "x=0.1", "--field", "speed")
with Image.open("part.webp") as webp:
    check.that(status == 0 and webp.n_frames == 2, f"two frames of a cut: {webp.n_frames} {err}")

# ---- The commands in the comments of the scenes
for scene in sorted(glob.glob(check.scene("*"))):
    with open(scene) as file:
        words = re.search(r"^#   \.venv/bin/python tools/plot\.py (.*)$", file.read(), re.M)
    try:
        arguments = plot.parser_of().parse_args(words.group(1).split())
        if arguments.curves:
            plot.read_curves(os.path.join(check.source, arguments.curves))
        drawing.view_of(arguments)
        wrong = None
    except (SystemExit, AttributeError) as error:
        wrong = f"{os.path.basename(scene)}: its command of tools/plot.py: {error}"
    check.fault(wrong)
check.end()
