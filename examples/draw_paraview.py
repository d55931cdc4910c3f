"""A picture and a movie of a run by ParaView, without its window. For its own Python, pvpython:

    pvpython examples/draw_paraview.py output/disks.xdmf                      # output/disks.paraview.png and .avi
    pvpython examples/draw_paraview.py output/disks.xdmf speed mine.png mine.avi

The second word is a field of the particles (von_mises is the default); of a vector its size is shown, and speed is the size
of v. The picture shows the last snapshot, the movie all. On a computer without a screen write `xvfb-run -a` in front, or
use a pvpython that was built for this. In ParaView's window, open the same files and press Apply.
"""
import os
import sys

from paraview import simple


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
    view = simple.GetActiveViewOrCreate("RenderView")
    view.ViewSize, view.Background, view.UseColorPaletteForBackground = [1200, 800], [1, 1, 1], 0
    view.OrientationAxesVisibility = 0
    simple.GetAnimationScene().AnimationTime = times[-1]
    display = simple.Show(particles, view)
    simple.Render(view)
    simple.ResetCamera(view)
    display.Representation, display.ShaderPreset, display.GaussianRadius = "Point Gaussian", "Sphere", radius_of(data)
    simple.ColorBy(display, ("POINTS", name))
    display.RescaleTransferFunctionToDataRangeOverTime()
    display.SetScalarBarVisibility(view, True)
    bar = simple.GetScalarBar(simple.GetColorTransferFunction(name), view)
    bar.Title, bar.ComponentTitle, bar.TitleColor, bar.LabelColor = field, "", [0, 0, 0], [0, 0, 0]
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
    main(*sys.argv[1:])
