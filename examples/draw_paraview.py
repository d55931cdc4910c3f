"""A picture and a movie of a run by ParaView, without its window. For its own Python, pvpython:

    pvpython examples/draw_paraview.py output/disks.xdmf                      # output/disks.paraview.png and .avi
    pvpython examples/draw_paraview.py output/disks.xdmf speed mine.png mine.avi

The second word is a field of the particles (von_mises is the default); of a vector its size is shown, and speed is the size
of v. The picture shows the last snapshot, the movie all; the few values beyond the ends of the bar, 1 % at each, have the
colours of its ends. On a computer without a screen write `xvfb-run -a` in front, or use a pvpython that was built for this. In
ParaView's window, open the same files and press Apply.
"""
import os
import sys

import numpy as np

from paraview import simple
from paraview.vtk.vtkRenderingCore import vtkRenderWindow

UNITS = {"von_mises": "Pa", "pressure": "Pa", "stress": "Pa", "v": "m/s", "x": "m", "volume": "m^3", "mass": "kg", "temperature": "K"}


def radius_of(data):
    """Of a particle: half the side of the square, or cube, of its mean volume."""
    low, high = data.GetBounds()[::2], data.GetBounds()[1::2]
    dim = sum(b > a for a, b in zip(low, high))
    volume = data.GetPointData().GetArray("volume")
    sides = volume and [volume.GetValue(k) for k in range(volume.GetNumberOfTuples())]
    return 0.5 * (sum(sides) / len(sides)) ** (1 / max(1, dim)) if sides else 0.01 * max(b - a for a, b in zip(low, high))


def leaf_of(data):
    """The particles, or the first part of what has parts."""
    while data.IsA("vtkCompositeDataSet"):
        parts = data.NewIterator()
        data = parts.GetCurrentDataObject()
    return data


def values_of(data, name):
    """The field, or the sizes of its vectors."""
    array = data.GetPointData().GetArray(name)
    nc = array.GetNumberOfComponents()
    rows = np.array([array.GetTuple(k) for k in range(array.GetNumberOfTuples())])
    return rows[:, 0] if nc == 1 else np.linalg.norm(rows, axis=1)


def main(path, field="von_mises", picture=None, movie=None):
    base = os.path.abspath(path).removesuffix(".xdmf")
    # The readers Xdmf3 of ParaView 5.11 may draw particles of which they have freed the memory.
    particles = simple.XDMFReader(FileNames=[base + ".xdmf"])
    simple.GetAnimationScene().UpdateAnimationUsingDataTimeSteps()
    times = particles.TimestepValues
    particles.UpdatePipeline(times[-1])
    data = leaf_of(simple.servermanager.Fetch(particles))
    name = "v" if field == "speed" else field
    known = [data.GetPointData().GetArrayName(k) for k in range(data.GetPointData().GetNumberOfArrays())]
    if name not in known:
        sys.exit(f"draw_paraview.py: no field {field} in {path}; choose of {', '.join(known)}, speed")
    # At ten times, since a few particles at a few times would have most of the colours.
    chosen = [times[k] for k in sorted({round(k) for k in np.linspace(0, len(times) - 1, 10)})]
    shown = [values_of(leaf_of(simple.servermanager.Fetch(particles)), name) for t in chosen if particles.UpdatePipeline(t) is None]
    low, high = np.nanquantile(np.concatenate(shown), [0.01, 0.99])
    view = simple.GetActiveViewOrCreate("RenderView")
    view.ViewSize, view.Background, view.UseColorPaletteForBackground = [1200, 800], [1, 1, 1], 0
    view.OrientationAxesVisibility = 0
    simple.GetAnimationScene().AnimationTime = times[-1]
    display = simple.Show(particles, view)
    simple.Render(view)
    simple.ResetCamera(view)
    display.Representation, display.ShaderPreset, display.GaussianRadius = "Point Gaussian", "Sphere", radius_of(data)
    simple.ColorBy(display, ("POINTS", name))
    simple.GetColorTransferFunction(name).RescaleTransferFunction(low, high if high > low else low + (abs(low) or 1))
    display.SetScalarBarVisibility(view, True)
    bar = simple.GetScalarBar(simple.GetColorTransferFunction(name), view)
    bar.Title, bar.ComponentTitle = f"{field} [{UNITS[name]}]" if name in UNITS else field, ""
    bar.TitleColor, bar.LabelColor, bar.Orientation, bar.WindowLocation = [0, 0, 0], [0, 0, 0], "Horizontal", "Lower Center"
    if os.path.exists(base + ".rigid.xdmf"):
        rigid = simple.Show(simple.XDMFReader(FileNames=[base + ".rigid.xdmf"]), view)
        rigid.DiffuseColor, rigid.LineWidth = [0.6, 0.6, 0.6], 3
    picture, movie = picture or base + ".paraview.png", movie or base + ".paraview.avi"
    simple.SaveScreenshot(picture, view)
    simple.SaveAnimation(movie, view, FrameRate=max(4, min(25, round(len(times) / 6))))
    print(f"{picture}\n{movie}   {len(times)} frames")


if __name__ == "__main__":
    if not 2 <= len(sys.argv) <= 5:
        sys.exit(__doc__)
    if vtkRenderWindow().GetClassName() == "vtkXOpenGLRenderWindow" and not os.environ.get("DISPLAY"):
        sys.exit("draw_paraview.py: there is no screen (DISPLAY), and this pvpython cannot draw without one; write xvfb-run -a in front")
    main(*sys.argv[1:])
