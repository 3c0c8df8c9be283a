"""Meshes that are made once and given new arrays for each frame."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TypeVar

import numpy as np
import pyvista as pv

from stereotrack_core.arrays import FloatArray, ImageArray, IntArray

_Thing = TypeVar("_Thing")


class Shape:
    """Points with cells over them, drawn by one actor.

    Parameters
    ----------
    renderer : pyvista.Renderer
        The layer that the actor is added to.
    mesh : pyvista.PolyData, optional
        What it draws unless it is given something else; may be shared.
    lit : bool
        Whether light falls on it; else it shows its plain colour.
    """

    def __init__(
        self, renderer: pv.Renderer, mesh: pv.PolyData | None = None, *, lit: bool = False
    ) -> None:
        self.mesh = pv.PolyData() if mesh is None else mesh
        self.actor = pv.Actor(mapper=pv.DataSetMapper(self.mesh))
        self.actor.pickable = False
        self.prop = self.actor.prop
        self.prop.lighting = lit
        renderer.add_actor(self.actor, render=False)

    def set_colour(self, colour: str, opacity: float = 1.0) -> None:
        """Colour of the whole shape as #rrggbb."""
        self.prop.color = colour
        self.prop.opacity = opacity

    def set_point_colours(self, colours: ImageArray) -> None:
        """Colour each point by a row of (K, 3) uint8."""
        self.mesh.point_data.set_scalars(colours, "colour")
        self.actor.mapper.color_mode = "direct"
        self.actor.mapper.scalar_visibility = True

    def set_dots(self, points: FloatArray) -> None:
        """Place the points (K, 3) and draw each as a dot."""
        self.mesh.points = points
        self.mesh.verts = pv.CellArray.from_regular_cells(np.arange(len(points))[:, None])

    def set_lines(self, points: FloatArray) -> None:
        """Draw a line between each two of the points (2 L, 3)."""
        self.mesh.points = points
        self.mesh.lines = pv.CellArray.from_regular_cells(np.arange(len(points)).reshape(-1, 2))

    def set_triangles(self, points: FloatArray, triangles: IntArray) -> None:
        """Draw a surface; the cells are made anew only if `triangles` has changed."""
        self.mesh.points = points
        if not np.array_equal(self.mesh.regular_faces, triangles):
            self.mesh.regular_faces = triangles


class Shapes:
    """Shapes that look alike, made as they are needed; `look` are properties of each."""

    def __init__(
        self,
        renderer: pv.Renderer,
        mesh: pv.PolyData | None = None,
        *,
        lit: bool = False,
        **look: object,
    ) -> None:
        self._renderer, self._mesh, self._lit, self._look = renderer, mesh, lit, look
        self._made: list[Shape] = []

    def drawn(self, things: Sequence[_Thing]) -> Iterator[tuple[Shape, _Thing]]:
        """Go through the things with a shape for each; shapes beyond them are not drawn."""
        while len(self._made) < len(things):
            self._made.append(Shape(self._renderer, self._mesh, lit=self._lit))
            for name, value in self._look.items():
                setattr(self._made[-1].prop, name, value)
        for index, shape in enumerate(self._made):
            shape.actor.visibility = index < len(things)
        return zip(self._made, things, strict=False)


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
