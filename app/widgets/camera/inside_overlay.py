"""What a step inside a frame draws over pictures and into the scene."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import pyqtgraph
from PySide6.QtCore import QPointF, Qt
from PySide6.QtGui import QColor, QPainter, QPen, QPolygonF

from stereotrack_core.arrays import FloatArray

from ..style.limb_colours import LIMB_COLOURS

_GHOST_ALPHA = 130
_LEAST_MOVE = 0.002
"""Metres by which a part of a ghost differs from the model before it is drawn."""


@dataclass(frozen=True, eq=False)
class Ghosts:
    """One cone of the model in several poses."""

    limb: str
    vertices: FloatArray
    """(S, V, 3) float64, world, metres."""


@dataclass(frozen=True, eq=False)
class Marked:
    """Lines or dots of one colour."""

    colour: str
    """#rrggbb."""
    places: FloatArray
    """(K, 2, 3) or (K, 3) float64, world, metres. Ends of lines, or dots."""


@dataclass(frozen=True, eq=False)
class InsideScene:
    """What one step draws, in the world."""

    ghosts: tuple[Ghosts, ...] = ()
    lines: tuple[Marked, ...] = ()
    dots: tuple[Marked, ...] = ()


@dataclass(frozen=True, eq=False)
class InsideOverlay:
    """The same in a picture's pixels."""

    ghosts: tuple[tuple[str, FloatArray], ...]
    """Tuple of (str, (K, 2) float64). Limb and silhouette of each cone of each ghost."""
    lines: tuple[tuple[str, FloatArray], ...]
    """Tuple of (str, (K, 2, 2) float64)."""
    dots: tuple[tuple[str, FloatArray], ...]
    """Tuple of (str, (K, 2) float64)."""


def inside_overlay(
    scene: InsideScene, project: Callable[[FloatArray], FloatArray]
) -> InsideOverlay:
    """Project what a step draws; see :data:`app.widgets.camera.overlays.Projection`."""
    return InsideOverlay(
        tuple(
            (ghost.limb, outline)
            for ghost in scene.ghosts
            for outline in _silhouettes(project(ghost.vertices))
        ),
        tuple((each.colour, project(each.places)) for each in scene.lines),
        tuple((each.colour, project(each.places)) for each in scene.dots),
    )


def moved_ghosts(ghosts: Sequence[Ghosts], model: Sequence[FloatArray]) -> tuple[Ghosts, ...]:
    """Ghosts without the cones that are where the model (V, 3) of each has them anyway."""
    found = []
    for ghost, vertices in zip(ghosts, model, strict=True):
        off = np.abs(ghost.vertices - vertices).max(axis=(1, 2))
        if (off > _LEAST_MOVE).any():
            found.append(Ghosts(ghost.limb, ghost.vertices[off > _LEAST_MOVE]))
    return tuple(found)


def _silhouettes(pixels: FloatArray) -> list[FloatArray]:
    """Convex hulls of stacked cones (S, V, 2) that lie before the camera."""
    usable = np.isfinite(pixels).all(axis=(1, 2)) & (np.abs(np.nan_to_num(pixels)) < 1e5).all(
        axis=(1, 2)
    )
    hulls = [cv2.convexHull(one.astype(np.float32))[:, 0] for one in pixels[usable]]
    return [np.asarray(hull, dtype=np.float64) for hull in hulls]


def paint_inside(painter: QPainter, overlay: InsideOverlay, scale: float) -> None:
    """Paint ghosts, lines and dots; the painter's coordinates are the picture's pixels."""
    painter.setBrush(Qt.BrushStyle.NoBrush)
    for limb, outline in overlay.ghosts:
        colour = QColor(LIMB_COLOURS.get(limb, "#999999")).lighter(120)
        colour.setAlpha(_GHOST_ALPHA)
        painter.setPen(_pen(colour, 0.8, scale))
        painter.drawPolygon(QPolygonF([QPointF(x, y) for x, y in outline.tolist()]))
    for name, ends in overlay.lines:
        known = np.isfinite(ends).all(axis=(1, 2))
        flat = np.ascontiguousarray(ends[known].reshape(-1, 2))
        path = pyqtgraph.arrayToQPath(flat[:, 0], flat[:, 1], connect="pairs")
        for colour, width in ((QColor(0, 0, 0, 150), 3.0), (QColor(name), 1.6)):
            painter.setPen(_pen(colour, width, scale))
            painter.drawPath(path)
    for name, places in overlay.dots:
        seen = places[np.isfinite(places).all(axis=1)]
        for colour, width in ((QColor(0, 0, 0, 190), 4.6), (QColor(name), 3.0)):
            painter.setPen(_pen(colour, width, scale))
            painter.drawPoints(QPolygonF([QPointF(x, y) for x, y in seen.tolist()]))


def _pen(colour: QColor, width: float, scale: float) -> QPen:
    pen = QPen(colour, width / max(scale, 1e-6))
    pen.setCapStyle(Qt.PenCapStyle.RoundCap)
    pen.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
    return pen
