"""What a reader of ParaView finds in an XDMF file, as a file of numpy; for tests/test_viewers.py.

usage: pvpython view.py Xdmf3ReaderS|Xdmf3ReaderT|XDMFReader FILE.xdmf FOUND.npz

FOUND.npz has the times and, for the first, the middle and the last of them (k), k/points, k/vertices (the point of each
cell), k/array for the arrays of the particles, k/grid/array for those of the nodes, and of the surfaces of rigid bodies
k/rigid/points and k/rigid/faces (the points of each face).
"""
import sys

import numpy as np
from paraview import servermanager, simple
from vtkmodules.util.numpy_support import vtk_to_numpy


def leaves(data):
    """The data sets of what has parts, or the one that has none."""
    if not data.IsA("vtkCompositeDataSet"):
        return [data]
    parts, found = data.NewIterator(), []
    while not parts.IsDoneWithTraversal():
        found.append(parts.GetCurrentDataObject())
        parts.GoToNextItem()
    return found


name, path, out = sys.argv[1:]
reader = getattr(simple, name)(**{"FileNames" if name == "XDMFReader" else "FileName": [path]})
reader.UpdatePipelineInformation()
times = list(reader.TimestepValues)
found = {"times": np.array(times)}
for k in sorted({0, len(times) // 2, len(times) - 1}):
    reader.UpdatePipeline(times[k])
    data = servermanager.Fetch(reader)
    for leaf in leaves(data):
        particles = leaf.IsA("vtkUnstructuredGrid")
        rigid = particles and leaf.GetNumberOfCells() and leaf.GetCell(0).GetNumberOfPoints() > 1
        start = f"{k}/rigid/" if rigid else f"{k}/" if particles else f"{k}/grid/"
        arrays = leaf.GetPointData()
        for a in range(arrays.GetNumberOfArrays()):
            found[start + arrays.GetArrayName(a)] = vtk_to_numpy(arrays.GetArray(a)).copy()
        if rigid:
            found[start + "points"] = vtk_to_numpy(leaf.GetPoints().GetData()).copy()
            found[start + "faces"] = np.array([[leaf.GetCell(c).GetPointId(p) for p in range(leaf.GetCell(c).GetNumberOfPoints())]
                                               for c in range(leaf.GetNumberOfCells())])
            found[start + "body"] = vtk_to_numpy(leaf.GetCellData().GetArray("body")).copy()
        elif particles:
            found[start + "points"] = vtk_to_numpy(leaf.GetPoints().GetData()).copy()
            found[start + "vertices"] = np.array([leaf.GetCell(c).GetPointId(0) for c in range(leaf.GetNumberOfCells()) if leaf.GetCell(c).GetNumberOfPoints() == 1])
        else:
            found[start + "bounds"] = np.array(leaf.GetBounds())
np.savez(out, **found)
