"""Ghosts, pairs and dots of a step inside a frame, in the 3-D scene."""

from __future__ import annotations

import numpy as np
import pyvista as pv

from stereotrack_core.arrays import FloatArray

from ..camera.inside_overlay import Ghosts, InsideScene
from ..style.limb_colours import LIMB_COLOURS
from ..style.theme import Theme
from .geometry import Shape

_DOT = 4.0
_RING = 8
"""Vertices of a cone's ring, as ghosts are made."""


class InsideLayer:
    """Ghosts as wires, pairs as lines, points as dots; seen through the model.

    Parameters
    ----------
    renderer : pyvista.Renderer
    """

    def __init__(self, renderer: pv.Renderer) -> None:
        self._renderer = renderer
        self._wires: list[Shape] = []
        self._lines: list[Shape] = []
        self._dots: list[Shape] = []
        self._shown: InsideScene | None = None

    def show(self, scene: InsideScene | None, theme: Theme, scale: float) -> None:
        """Take over another step, or none."""
        found = scene or InsideScene()
        for shapes, count in (
            (self._wires, len(found.ghosts)),
            (self._lines, len(found.lines)),
            (self._dots, len(found.dots)),
        ):
            while len(shapes) < count:
                shapes.append(Shape(self._renderer))
            for index, shape in enumerate(shapes):
                shape.actor.visibility = index < count
        if scene is self._shown:
            return
        self._shown = scene
        for shape, ghost in zip(self._wires, found.ghosts, strict=False):
            shape.set_lines(wire_of(ghost))
            shape.set_colour(LIMB_COLOURS.get(ghost.limb, theme.disabled), 0.55)
            shape.prop.line_width = scale
        for shape, line in zip(self._lines, found.lines, strict=False):
            shape.set_lines(line.places.reshape(-1, 3))
            shape.set_colour(line.colour)
            shape.prop.line_width = 1.6 * scale
        for shape, dot in zip(self._dots, found.dots, strict=False):
            shape.set_dots(dot.places)
            shape.set_colour(dot.colour)
            shape.prop.point_size = _DOT * scale
            shape.prop.render_points_as_spheres = True


def wire_of(ghost: Ghosts) -> FloatArray:
    """End points (2 L, 3) of rings and of four lines along the cone, for all poses."""
    rings = ghost.vertices.reshape(len(ghost.vertices), -1, _RING, 3)[:, 1:-1]
    beside = np.roll(rings, -1, axis=2)
    around = np.stack([rings[:, [0, -1]], beside[:, [0, -1]]], axis=-2).reshape(-1, 3)
    quarter = rings[:, :, :: _RING // 4]
    along = np.stack([quarter[:, :-1], quarter[:, 1:]], axis=-2).reshape(-1, 3)
    return np.concatenate([around, along])
