"""VTK objects that are made once and given new arrays for each frame."""

from __future__ import annotations

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper, vtkRenderer

from stereotrack_core.arrays import FloatArray, ImageArray, IntArray

from .window import unit_rgb


class Shape:
    """Points with cells over them, drawn by one actor.

    Parameters
    ----------
    renderer : vtkRenderer
        The layer that the actor is added to.
    lit : bool
        Whether light falls on it; else it shows its plain colour.
    """

    def __init__(self, renderer: vtkRenderer, *, lit: bool = False) -> None:
        self.data = vtkPolyData()
        self._cells: IntArray | None = None
        self._renderer = renderer
        mapper = vtkPolyDataMapper()
        mapper.SetInputData(self.data)
        self.actor = vtkActor()
        self.actor.SetMapper(mapper)
        self.actor.PickableOff()
        properties = self.actor.GetProperty()
        properties.SetLighting(lit)
        renderer.AddActor(self.actor)

    def set_colour(self, colour: str, opacity: float = 1.0) -> None:
        """Colour of the whole shape as #rrggbb."""
        self.actor.GetProperty().SetColor(*unit_rgb(colour))
        self.actor.GetProperty().SetOpacity(opacity)

    def set_visible(self, visible: bool) -> None:
        """Draw it or leave it out."""
        self.actor.SetVisibility(visible)

    def set_points(self, points: FloatArray) -> None:
        """Place the points (K, 3)."""
        array = numpy_to_vtk(np.ascontiguousarray(points, dtype=np.float32), deep=True)
        holder = vtkPoints()
        holder.SetData(array)
        self.data.SetPoints(holder)

    def set_point_colours(self, colours: ImageArray) -> None:
        """Colour each point by a row of (K, 3) uint8."""
        array = numpy_to_vtk(np.ascontiguousarray(colours, dtype=np.uint8), deep=True)
        array.SetName("colour")
        self.data.GetPointData().SetScalars(array)

    def set_dots(self, points: FloatArray) -> None:
        """Place the points (K, 3) and draw each as a dot."""
        self.set_points(points)
        self.data.SetVerts(cells(np.arange(len(points))[:, None]))

    def set_lines(self, points: FloatArray) -> None:
        """Draw a line between each two of the points (2 L, 3)."""
        self.set_points(points)
        self.data.SetLines(cells(np.arange(len(points)).reshape(-1, 2)))

    def set_triangles(self, points: FloatArray, triangles: IntArray) -> None:
        """Draw a surface; the cells are made anew only if `triangles` has changed."""
        self.set_points(points)
        if self._cells is None or not np.array_equal(self._cells, triangles):
            self.data.SetPolys(cells(triangles))
            self._cells = np.array(triangles)

    def remove(self) -> None:
        """Take the actor out of its layer."""
        self._renderer.RemoveActor(self.actor)


def cells(indices: IntArray) -> vtkCellArray:
    """Cells of VTK from (C, k) indices of points."""
    count, size = indices.shape
    result = vtkCellArray()
    offsets = numpy_to_vtkIdTypeArray(np.arange(count + 1, dtype=np.int64) * size, deep=True)
    members = numpy_to_vtkIdTypeArray(np.asarray(indices, dtype=np.int64).ravel(), deep=True)
    result.SetData(offsets, members)
    return result


def dashes(starts: FloatArray, ends: FloatArray, length: float = 0.025) -> FloatArray:
    """End points (2 D, 3) of dashes of `length` metres along each line; OpenGL has none.

    Parameters
    ----------
    starts, ends : (L, 3) float64
        Lines with a NaN are left out.
    length : float, metres
        Of a dash and of the gap after it.
    """
    pieces = []
    for start, end in zip(starts, ends, strict=True):
        distance = float(np.linalg.norm(end - start))
        if not np.isfinite(distance) or distance == 0.0:
            continue
        count = max(1, round(distance / (2 * length)))
        shares = ((np.arange(count)[:, None] + (0.0, 0.55)) / count).ravel()
        pieces.append(start + shares[:, None] * (end - start))
    return np.concatenate(pieces) if pieces else np.empty((0, 3))
