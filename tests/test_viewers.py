"""Snapshots open in ParaView (its readers Xdmf3, S and T, and Xdmf2, by pvpython of Debian), VTK, pyvista and meshio: every particle
is drawn as a vertex, and names, values and times are those of the HDF5 files; the surfaces of rigid bodies are edges or triangles
where these are. Runs in 2-D and in 3-D.

usage: test_viewers.py PEBBLE SOURCE MPIEXEC
"""
import os
import shutil
import subprocess

import h5py
import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
from vtkmodules.vtkIOXdmf2 import vtkXdmfReader

import check

try:
    import meshio
    import pyvista
except ImportError as error:
    meshio = pyvista = None
    missing = error
# A rigid ball that turns and moves, and a fixed post.
TOOL = ("-bodies", "star,ball,post", "-body_ball_shape", "sphere", "-body_ball_center", "0.05,0.05,0.05", "-body_ball_radius", "0.02", "-body_ball_rigid",
        "moving", "-body_ball_velocity", "0.1,0,0", "-body_ball_spin", "0,3,0", "-body_ball_pivot", "0.05,0.05,0.05", "-body_post_shape", "box", "-body_post_lower", "0.01,0.01,0.01", "-body_post_upper",
        "0.02,0.02,0.03", "-body_post_rigid", "fixed")
FIELDS = ("id", "x", "v", "F", "stress", "volume", "body")


def same(a, b):
    """Readers may give a tensor as [3, 3], and numbers as other types."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    return a.size == b.size and np.array_equal(a.reshape(b.shape), b)


def compare(what, found, path):
    """found: {times, k/points ...} as view.py describes it, of the first, the middle and the last snapshot."""
    with h5py.File(path) as file:
        steps = [file[f"step_{step:06d}"] for step in check.steps(file)]
        check.that(same(found["times"], [step.attrs["time"] for step in steps]), f"{what}: {len(found['times'])} times")
        for k in sorted({0, len(steps) // 2, len(steps) - 1}):
            particles, grid = steps[k]["particles"], steps[k]["grid"]
            n = len(particles["id"])
            wrong = [name for name in FIELDS if f"{k}/{name}" not in found or not same(found[f"{k}/{name}"], particles[name][:])]
            wrong += [f"grid/{name}" for name in ("mass", "v") if f"{k}/grid/{name}" in found and not same(found[f"{k}/grid/{name}"].ravel(), grid[name][:].ravel())]
            wrong += ["points"] * (not same(found[f"{k}/points"], particles["x"][:])) + ["vertices"] * (not same(found[f"{k}/vertices"], np.arange(n)))
            if f"{k}/grid/bounds" in found:
                low, high = np.array(found[f"{k}/grid/bounds"]).reshape(3, 2).T
                wrong += ["bounds"] * (not (np.allclose(low, file.attrs["grid_lower"]) and np.allclose(high, file.attrs["grid_upper"])))
            if "rigid" in steps[k] and f"{k}/rigid/points" in found:
                rigid = steps[k]["rigid"]
                wrong += [f"rigid/{name}" for name, ours in (("points", "x"), ("faces", "faces"), ("body", "body"))
                          if not same(found[f"{k}/rigid/{name}"], rigid[ours][:])]
            elif "rigid" in steps[k] and "meshio" not in what:
                wrong += ["no rigid bodies"]
            check.that(not wrong, f"{what}: snapshot {k}, {n} particles drawn, names and values; wrong: {wrong}")


def paraview(reader, path):
    out = os.path.abspath("found.npz")
    env = dict(os.environ)
    env.pop("PYTHONPATH", None)
    told = subprocess.run(["pvpython", os.path.join(check.source, "tests", "view.py"), reader, path, out], capture_output=True, text=True, timeout=300, env=env)
    check.need(told.returncode == 0 and os.path.exists(out), f"pvpython with {reader}: {told.returncode} {told.stderr[-1500:]}")
    with np.load(out) as found:
        result = dict(found)
    os.remove(out)
    return result


def blocks(found, k, leaf, grid):
    """Adds a data set as pyvista or VTK gives it."""
    leaf = pyvista.wrap(leaf)
    rigid = not grid and leaf.n_cells and leaf.get_cell(0).n_points > 1
    start = f"{k}/grid/" if grid else f"{k}/rigid/" if rigid else f"{k}/"
    for name in leaf.point_data:
        found[start + name] = np.array(leaf.point_data[name])
    if grid:
        found[start + "bounds"] = np.array(leaf.bounds)
    elif rigid:
        found[start + "points"], found[start + "body"] = np.array(leaf.points), np.array(leaf.cell_data["body"])
        found[start + "faces"] = np.array([leaf.get_cell(c).point_ids for c in range(leaf.n_cells)])
    else:
        found[start + "points"] = np.array(leaf.points)
        found[start + "vertices"] = np.array([leaf.get_cell(c).point_ids[0] for c in range(leaf.n_cells) if leaf.get_cell(c).n_points == 1])


def with_parts(read, path, *words):
    """What a reader finds in the file of the particles, which opens alone, and in those of the nodes and of rigid bodies."""
    parts = [path.replace(".xdmf", end) for end in (".xdmf", ".grid.xdmf", ".rigid.xdmf")]
    found = [read(*words, part) for part in parts if os.path.exists(part)]
    alone = {key.split("/")[1] for key in found[0] if "/" in key}
    check.that(not alone & {"grid", "rigid"}, f"{os.path.basename(path)} has particles alone")
    check.that(all(same(other["times"], found[0]["times"]) for other in found), "and the others have its times")
    return {key: value for one in reversed(found) for key, value in one.items()}


def vtk(path):
    reader = vtkXdmfReader()
    reader.SetFileName(path)
    reader.UpdateInformation()
    times = reader.GetOutputInformation(0).Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS())
    found = {"times": times}
    for k in {0, len(times) // 2, len(times) - 1}:
        reader.UpdateTimeStep(times[k])
        data = reader.GetOutputDataObject(0)
        for leaf in [data.GetBlock(b) for b in range(data.GetNumberOfBlocks())] if data.IsA("vtkMultiBlockDataSet") else [data]:
            blocks(found, k, leaf, not leaf.IsA("vtkUnstructuredGrid"))
    return found


def by_pyvista(path):
    reader = pyvista.get_reader(path)
    found = {"times": reader.time_values}
    for k in {0, len(reader.time_values) // 2, len(reader.time_values) - 1}:
        reader.set_active_time_value(reader.time_values[k])
        data = reader.read()
        for leaf in data if isinstance(data, pyvista.MultiBlock) else [data]:
            blocks(found, k, leaf, not isinstance(leaf, pyvista.UnstructuredGrid))
    return found


def by_meshio(path):
    """It has the points of the first snapshot; those of others are the array x."""
    found = {"times": []}
    with meshio.xdmf.TimeSeriesReader(path) as reader:
        points, cells = reader.read_points_cells()
        check.that(len(cells) == 1 and cells[0].type == "vertex" and same(points, reader.read_data(0)[1]["x"]), "meshio: vertices, and the first positions")
        for k in range(reader.num_steps):
            time, data, _ = reader.read_data(k)
            found["times"].append(time)
            found |= {f"{k}/{name}": value for name, value in data.items()}
            found[f"{k}/points"], found[f"{k}/vertices"] = data["x"], cells[0].data
    return found


def draws():
    """examples/draw_paraview.py draws particles, in their colours, and rigid bodies: a picture and a movie of all snapshots."""
    from PIL import Image

    script = os.path.join(check.source, "examples", "draw_paraview.py")
    env = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    command = [*(["xvfb-run", "-a"] if shutil.which("xvfb-run") else []), "pvpython", script]

    def draw(*words):
        for _ in range(3):  # a screen that did not start in time is not the script's
            told = subprocess.run([*command, *words], capture_output=True, text=True, timeout=300, env=env)
            if told.returncode == 0 or not any(word in told.stderr for word in ("X server", "X Error", "vtkXOpenGLRenderWindow", "Signal: SIGABRT")):
                break
        return told

    for name, field in (("disks", []), ("stl_drop", ["speed"])):
        told = draw(f"{name}/{name}.xdmf", *field)
        picture, movie = (f"{name}/{name}.paraview{end}" for end in (".png", ".avi"))
        if not check.that(told.returncode == 0 and os.path.exists(picture) and os.path.getsize(movie) > 10000, f"{name} is drawn: {told.stdout} {told.stderr[-500:]}"):
            continue
        pixels = np.asarray(Image.open(picture).convert("RGB")).astype(int)
        coloured = (np.ptp(pixels, axis=-1) > 40).mean()
        check.that(0.02 < coloured < 0.9, f"{100 * coloured:.1f} % of its picture is coloured")
        above = pixels[:650, :, 0] - pixels[:650, :, 2]  # the bar is below
        ends = (above > 40).mean(), (above < -40).mean()  # red, blue
        check.that(field or min(ends) > 0.001, f"{100 * ends[0]:.2f} % of it is red, {100 * ends[1]:.2f} % blue: both ends of the bar are there")
        check.that((pixels[0].min(), pixels[-1].min(), pixels[:, 0].min(), pixels[:, -1].min()) == (255,) * 4, "nothing reaches its edge")
    env.pop("DISPLAY", None)
    blind = subprocess.run(["pvpython", script, "disks/disks.xdmf"], capture_output=True, text=True, timeout=300, env=env)
    told = "draw_paraview.py: there is no screen (DISPLAY), and this pvpython cannot draw without one; write xvfb-run -a in front\n"
    check.that(blind.returncode == 0 or blind.stderr == told, f"without a screen: {blind.stderr[-300:]}")
    wrong = draw("disks/disks.xdmf", "colour")
    check.that(wrong.returncode and "no field colour in disks/disks.xdmf; choose of mass, " in wrong.stderr, f"a field that is not there: {wrong.stderr[-300:]}")


def main():
    check.need(pyvista and meshio, f"{'' if pyvista else missing}: tools/install.sh viewers installs what tools/requirements-viewers.txt lists")
    check.need(shutil.which("pvpython"), "pvpython is missing: tools/install.sh viewers installs Debian's packages paraview and python3-paraview")
    print(subprocess.run(["pvpython", "--version"], capture_output=True, text=True).stdout.strip(), "pyvista", pyvista.__version__, "meshio", meshio.__version__)
    for name, options in (("disks", ("-time_end", "0.3", "-output_every", "0.05")), ("disks3d", ("-time_max_steps", "4", "-output_every", "0")),
                          ("extrusion", ("-time_end", "0.001", "-output_every", "0.0001")), ("stl_drop", (*TOOL, "-time_max_steps", "4", "-output_every", "0"))):
        folder = os.path.abspath(name)
        check.must("-options_file", check.scene(name), "-output_dir", folder, *options)
        path, truth = f"{folder}/{name}.xdmf", f"{folder}/{name}.h5"
        for reader in ("Xdmf3ReaderS", "Xdmf3ReaderT", "XDMFReader"):
            compare(f"{name}, ParaView {reader}", with_parts(paraview, path, reader), truth)
        compare(f"{name}, VTK", with_parts(vtk, path), truth)
        compare(f"{name}, pyvista", with_parts(by_pyvista, path), truth)
        compare(f"{name}, meshio", by_meshio(path), truth)
    draws()


check.arguments(__doc__, 0)
main()
check.end()
