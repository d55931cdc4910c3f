"""The files of a short run of the disks: their layout, units and numbers, and that VTK (hence ParaView) opens them.

usage: test_output.py PEBBLE SOURCE MPIEXEC
"""
import re

import h5py
import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkOutputWindow
from vtkmodules.vtkCommonDataModel import VTK_POLY_VERTEX, VTK_VERTEX
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
from vtkmodules.vtkIOXdmf2 import vtkXdmfReader

import check

TIME_END, OUTPUT_EVERY = 0.1, 0.05
ROOT = "title scene dim git petsc_version hdf5_version mpi compiler flags ranks host date options " \
       "grid_lower grid_upper grid_cells".split()
PARTICLES = {"id": (), "x": (3,), "v": (3,), "F": (9,), "stress": (9,), "volume": (), "body": ()}  # name: row's shape


def text(value):
    return value.decode() if isinstance(value, bytes) else str(value)


def close(a, b, tolerance=1e-12, scale=None):
    """Normwise: largest difference over the largest value."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    return a.shape == b.shape and np.abs(a - b).max() <= tolerance * (scale or max(np.abs(b).max(), 1e-300))


def check_snapshot(name, step, cells):
    """One group of the HDF5 file."""
    for key in ("time", "step", "dt", "digest"):
        check.need(key in step.attrs, f"{name} has no attribute {key}")
    check.need(name == f"step_{int(step.attrs['step']):06d}", f"{name} holds step {step.attrs['step']}")
    check.need(re.fullmatch("[0-9a-f]{16}", text(step.attrs["digest"])), f"{name}: digest {step.attrs['digest']}")
    particles, grid = step["particles"], step["grid"]
    count = len(particles["id"])
    nodes = grid["mass"].shape
    check.need(len(nodes) == 3 and grid["v"].shape == nodes + (3,), f"{name}: grid arrays {nodes}, {grid['v'].shape}")
    check.need(all(n >= c + 1 for n, c in zip(nodes[::-1], cells) if c > 1), f"{name}: {nodes} nodes, {cells} cells")
    for key, shape in PARTICLES.items():
        check.need(key in particles, f"{name} has no particles/{key}")
        check.need(particles[key].shape == (count,) + shape, f"{name}: particles/{key} is {particles[key].shape}")
    for data in [*particles.values(), *grid.values()]:
        check.need("units" in data.attrs, f"{data.name} has no units")
        check.need(data.ndim in (1, 3) or "components" in data.attrs, f"{data.name} does not name its components")
        check.need(np.isfinite(data[...]).all(), f"{data.name} is not finite")
    check.need(particles["id"].dtype == np.int64, "ids are not 64-bit integers")
    check.need((particles["id"][:] == np.arange(count)).all(), f"{name}: ids are not 0, 1, ..., {count - 1}")
    check.need((particles["volume"][:] > 0).all(), f"{name}: a volume is not positive")


def check_h5(file):
    for key in ROOT:
        check.need(key in file.attrs, f"the file has no attribute {key}")
    check.need(int(file.attrs["dim"]) == 2 and text(file.attrs["scene"]) == "disks", "dim or scene is wrong")
    check.need(int(file.attrs["ranks"]) == 1, f"ranks {file.attrs['ranks']}")
    check.need("grid_cells" in text(file.attrs["options"]), "the attribute options is not the option set")
    for key in ("grid_lower", "grid_upper", "grid_cells"):
        check.need(np.shape(file.attrs[key]) == (3,), f"{key} has not 3 numbers")
    steps = [file[name] for name in sorted(file) if name.startswith("step_")]
    for step in steps:
        check_snapshot(step.name[1:], step, file.attrs["grid_cells"])
    times = np.array([step.attrs["time"] for step in steps])
    check.need(len(times) == 3 and times[0] == 0 and close(times[-1], TIME_END), f"the snapshots' times are {times}")
    late = times[1] - OUTPUT_EVERY
    check.need(0 <= late <= steps[1].attrs["dt"] * (1 + 1e-9), f"the second snapshot's time is {times[1]}")
    return steps, times


def check_csv(path, steps):
    """History against the snapshots of the same step. All particles of this scene have one mass."""
    rows = check.rows(path)
    columns = "step,time,dt,kinetic_energy,strain_energy,total_energy,external_work,energy_residual," \
              "momentum_x,momentum_y,angular_momentum_z,mass,particles"
    check.need(rows and ",".join(rows[0]) == columns, f"the columns are {','.join(rows[0]) if rows else 'missing'}")
    history = {int(row["step"]): {key: float(value) for key, value in row.items()} for row in rows}
    check.need(len(history) == len(rows) and np.isfinite([list(row.values()) for row in history.values()]).all(),
          "a step stands twice in the history, or a number is not finite")
    check.need(list(history) == sorted(history), "the history's steps do not increase")
    for step in (steps[0], steps[-1]):
        number, particles = int(step.attrs["step"]), step["particles"]
        check.need(number in history, f"step {number} is a snapshot but not in the history")
        row, v, count = history[number], particles["v"][:], len(particles["id"])
        mass = row["mass"] / count
        check.need(close(row["time"], step.attrs["time"], 1e-14), f"step {number}: time")
        check.need(row["particles"] == count, f"step {number}: number of particles")
        check.need(close(row["kinetic_energy"], 0.5 * mass * (v ** 2).sum()), f"step {number}: kinetic energy")
        check.need(close(row["total_energy"], row["kinetic_energy"] + row["strain_energy"]), f"step {number}: total energy")
        momentum = [row["momentum_x"], row["momentum_y"]]
        check.need(close(momentum, mass * v[:, :2].sum(0), scale=mass * np.abs(v).sum()), f"step {number}: momentum")
        check.need(close(step["grid"]["mass"][:].sum(), row["mass"]), f"step {number}: the grid's mass")
    check.need(history[0]["strain_energy"] == 0, "the first strain energy is not 0")
    return history


def leaves(data):
    """The data sets in a tree of blocks."""
    if data is None:
        return []
    if not data.IsA("vtkMultiBlockDataSet"):
        return [data]
    return [leaf for k in range(data.GetNumberOfBlocks()) for leaf in leaves(data.GetBlock(k))]


def check_xdmf(path, steps, times, history):
    vtkOutputWindow.SetInstance(None)
    reader = vtkXdmfReader()
    reader.SetFileName(path)
    reader.UpdateInformation()
    info = reader.GetOutputInformation(0)
    found = info.Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS()) or ()
    check.need(close(found, times, 1e-15), f"VTK finds the times {found}, not {times}")
    nodes = vtkXdmfReader()
    nodes.SetFileName(path.replace(".xdmf", ".grid.xdmf"))
    nodes.UpdateInformation()
    for step, time in zip(steps, times):
        reader.UpdateTimeStep(time)
        nodes.UpdateTimeStep(time)
        points, grids = leaves(reader.GetOutputDataObject(0)), leaves(nodes.GetOutputDataObject(0))
        check.need(len(points) == 1 and len(grids) == 1, f"VTK finds {len(points)} sets of points, {len(grids)} grids")
        particles, data = step["particles"], points[0].GetPointData()
        check.need(points[0].GetNumberOfPoints() == len(particles["id"]), "VTK finds another number of points")
        check.need(points[0].GetNumberOfCells() > 0 and points[0].GetCellType(0) in (VTK_VERTEX, VTK_POLY_VERTEX),
              "the points have no vertex cells: nothing would be drawn")
        check.need(close(vtk_to_numpy(points[0].GetPoints().GetData()), particles["x"][:], 1e-15), "VTK's points are not x")
        stress = data.GetArray("stress")
        check.need(stress and stress.GetNumberOfComponents() in (6, 9), "VTK finds no stress of 6 or 9 components")
        first = vtk_to_numpy(stress)[:, 0]
        check.need(close(first, particles["stress"][:, 0], 1e-15), "VTK's stress is not the file's")
        mass = grids[0].GetPointData().GetArray("mass")
        check.need(mass, "VTK finds no mass at the nodes")
        check.need(close(vtk_to_numpy(mass).sum(), history[0]["mass"]), "VTK's nodes do not sum to the mass")
        low, high = np.array(grids[0].GetBounds()).reshape(3, 2).T
        x = particles["x"][:]
        check.need((low - 1e-12 <= x.min(0)).all() and (x.max(0) <= high + 1e-12).all(), "particles outside of VTK's grid")


def main():
    # As a user starts it: the one process that this is, without what makes tests start faster.
    run = lambda *options: check.must("-options_file", check.scene("disks"), "-time_end", TIME_END, "-output_dir", ".", *options, plain=True)
    full = ["-output_every", OUTPUT_EVERY, "-report_phases"]
    for files, options in ((".csv .h5 .xdmf", full), (".csv (replaced)", ["-output_format", "none"]),
                           (".csv .h5 .xdmf (replaced)", full)):
        said = run(*options).out
        check.that(f"\nresults    ./disks{files}\n" in said, f"the results are told as {files}: {re.findall('^results.*', said, re.M)}")
    check.that(re.search(r"^output +[\d.e-]+ s for history and snapshots$", said, re.M), "the time of the output is told")
    with h5py.File("disks.h5") as file:
        steps, times = check_h5(file)
        history = check_csv("disks.csv", steps)
        check_xdmf("disks.xdmf", steps, times, history)


check.arguments(__doc__, 0)
main()
# A program alone makes no folder for temporary files, in which others that start at the same time would be in its way.
alone = check.run([check.program, "-options_file", check.scene("disks"), "-dry_run"], env={"TMPDIR": "/proc/nowhere"})
check.that(alone.status == 0, f"a program alone needs no folder for temporary files: exit status {alone.status} {alone.err[:200]}")
check.end()
