"""What is drawn over a picture: computed in the picture's pixels, painted with Qt."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import cv2
import numpy as np
import pyqtgraph
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QLinearGradient, QPainter, QPainterPath, QPen, QPolygonF

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.mesh import PartMesh
from stereotrack_core.recording.landmarks import LANDMARKS, SKELETON

from ..style.limb_colours import LANDMARK_LIMBS, LIMB_COLOURS
from ..style.line_styles import PEN_STYLES, LineStyle
from .inside_overlay import InsideOverlay, paint_inside

Projection: TypeAlias = Callable[[FloatArray], FloatArray]
"""From world points (..., 3) to pixels (..., 2) of a picture; NaN behind the camera."""

OVERLAYS: dict[str, str] = {
    "outline": "Model silhouette",
    "shading": "Shaded model",
    "wire": "Wireframe model",
    "others": "Silhouettes of other runs",
    "reference": "Reference skeleton",
    "points": "Measured points",
    "correspondences": "Correspondences",
}
"""Overlays that can be switched one by one, with their names."""

_DARK = QColor(0, 0, 0, 170)


@dataclass(frozen=True, eq=False)
class PartShape:
    """One cone of the model as it appears in a picture."""

    limb: str
    outline: FloatArray
    """(K, 2) float64, pixels. Convex silhouette."""
    axis: FloatArray
    """(2, 2) float64, pixels. From the base's to the end's centre."""
    wire: FloatArray
    """(E, 2, 2) float64, pixels. Edges of the surface that face the camera."""
    distance: float
    """Metres. From the camera, to paint the far ones first."""


@dataclass(frozen=True, eq=False)
class GhostOutline:
    """The model of a run beside the active one, as it appears in a picture."""

    style: LineStyle
    paths: tuple[tuple[str, QPainterPath], ...]
    """Outline of each limb."""


@dataclass(frozen=True, eq=False)
class Overlay:
    """Everything that may be drawn over one picture."""

    shapes: tuple[PartShape, ...] = ()
    """The model, the farthest part first."""
    paths: tuple[tuple[str, QPainterPath], ...] = ()
    """Outline of each limb."""
    reference: FloatArray | None = None
    """(9, 2) float64 or None, pixels."""
    ghosts: tuple[GhostOutline, ...] = ()
    """Models of further runs."""
    runs: tuple[tuple[str, LineStyle], ...] = ()
    """All runs that are drawn and their line styles, the active one first."""
    points: FloatArray | None = None
    """(N, 2) float64, pixels."""
    correspondences: FloatArray | None = None
    """(m, 2, 2) float64, pixels. From the measured point to the model's."""
    limbs: IntArray | None = None
    """(m,) int64. Index into ``LIMBS`` of each correspondence."""
    inside: InsideOverlay | None = None
    """What a step inside the frame draws."""

    def person_box(self) -> QRectF | None:
        """Box around model, reference or points, whichever is there first; in pixels."""
        parts = [shape.outline for shape in self.shapes]
        if self.reference is not None:
            parts.append(self.reference)
        if not parts and self.points is not None and len(self.points):
            parts.append(np.nanpercentile(self.points, (2.0, 98.0), axis=0))
        corners = np.concatenate(parts) if parts else np.empty((0, 2))
        corners = corners[np.isfinite(corners).all(axis=1)]
        if len(corners) < 2:
            return None
        (left, top), (right, bottom) = corners.min(axis=0), corners.max(axis=0)
        return QRectF(float(left), float(top), float(right - left), float(bottom - top))


def part_shapes(
    meshes: Sequence[PartMesh], project: Projection, eye: FloatArray, *, wire: bool
) -> tuple[PartShape, ...]:
    """Project the model's cones, the farthest first; parts behind the camera are left out.

    Parameters
    ----------
    meshes : sequence of PartMesh
    project : Projection
    eye : (3,) float64, world
        Centre of the camera.
    wire : bool
        Whether the edges are wanted, which cost most.
    """
    if not meshes:
        return ()
    pixels = project(np.concatenate([mesh.vertices for mesh in meshes]))
    shapes = []
    start = 0
    for mesh in meshes:
        own = pixels[start : start + len(mesh.vertices)]
        start += len(mesh.vertices)
        if not np.isfinite(own).all() or np.abs(own).max() > 1e5:
            continue
        hull = np.asarray(cv2.convexHull(own.astype(np.float32))[:, 0], dtype=np.float64)
        shapes.append(
            PartShape(
                mesh.limb,
                hull,
                own[[0, -1]],
                _facing_edges(mesh, own, eye) if wire else np.empty((0, 2, 2)),
                float(np.linalg.norm(mesh.vertices.mean(axis=0) - eye)),
            )
        )
    return tuple(sorted(shapes, key=lambda shape: -shape.distance))


def _facing_edges(mesh: PartMesh, pixels: FloatArray, eye: FloatArray) -> FloatArray:
    """Edges (E, 2, 2) of triangles that face the eye, without the diagonals of quadrangles."""
    corners = mesh.vertices[mesh.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    facing = np.einsum("ij,ij->i", normals, eye - corners[:, 0]) > 0
    triangles, corners = mesh.triangles[facing], corners[facing]
    lengths = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=-1)
    keep = np.arange(3) != lengths.argmax(axis=1)[:, None]
    edges = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=-1)[keep]
    unique = np.unique(np.sort(edges, axis=1), axis=0)
    result: FloatArray = pixels[unique]
    return result


def limb_paths(shapes: Sequence[PartShape]) -> tuple[tuple[str, QPainterPath], ...]:
    """Outline of each limb: the union of its cones' silhouettes."""
    united: dict[str, QPainterPath] = {}
    for shape in shapes:
        path = QPainterPath()
        path.addPolygon(_polygon(shape.outline))
        path.closeSubpath()
        before = united.get(shape.limb)
        united[shape.limb] = path if before is None else before.united(path)
    return tuple(united.items())


def ghost_paths(
    meshes: Sequence[PartMesh], project: Projection
) -> tuple[tuple[str, QPainterPath], ...]:
    """Outline of each limb of a model that is not shaded, so that no part has to be in front."""
    return limb_paths(part_shapes(meshes, project, np.zeros(3), wire=False))


def paint_overlay(
    painter: QPainter, overlay: Overlay, shown: frozenset[str], highlighted: str, scale: float
) -> None:
    """Paint what is switched on; the painter's coordinates are the picture's pixels.

    Parameters
    ----------
    scale : float
        Widget pixels per picture pixel.
    """
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    if "shading" in shown:
        _paint_shading(painter, overlay.shapes)
    if "points" in shown and overlay.points is not None:
        _paint_points(painter, overlay.points, scale)
    if "wire" in shown:
        _paint_wire(painter, overlay.shapes, scale)
    if "others" in shown:
        for ghost in overlay.ghosts:
            _paint_ghost(painter, ghost, scale)
    if "outline" in shown:
        _paint_outlines(painter, overlay.paths, scale)
    _paint_highlight(painter, overlay.paths, highlighted, scale)
    if (
        "correspondences" in shown
        and overlay.correspondences is not None
        and overlay.limbs is not None
    ):
        _paint_correspondences(painter, overlay.correspondences, overlay.limbs, scale)
    if overlay.inside is not None:
        paint_inside(painter, overlay.inside, scale)
    if "reference" in shown and overlay.reference is not None:
        _paint_skeleton(painter, overlay.reference, Qt.PenStyle.DashLine, scale)


def _paint_shading(painter: QPainter, shapes: Sequence[PartShape]) -> None:
    painter.setPen(Qt.PenStyle.NoPen)
    for shape in shapes:
        painter.setBrush(_cone_gradient(shape))
        painter.drawPolygon(_polygon(shape.outline))


def _cone_gradient(shape: PartShape) -> QLinearGradient:
    """Light across the cone's axis, bright left of the middle, dark at the rims."""
    along = shape.axis[1] - shape.axis[0]
    length = float(np.linalg.norm(along))
    across = np.array([-along[1], along[0]]) / length if length > 1e-6 else np.array([1.0, 0.0])
    if across[0] < 0:
        across = -across
    offsets = (shape.outline - shape.axis[0]) @ across
    start, end = (shape.axis[0] + float(value) * across for value in (offsets.min(), offsets.max()))
    gradient = QLinearGradient(QPointF(*start), QPointF(*end))
    colour = QColor(LIMB_COLOURS[shape.limb])
    for place, factor in ((0.0, 150), (0.35, 78), (0.6, 100), (1.0, 190)):
        tone = colour.darker(factor)
        tone.setAlpha(165)
        gradient.setColorAt(place, tone)
    return gradient


def _paint_wire(painter: QPainter, shapes: Sequence[PartShape], scale: float) -> None:
    painter.setBrush(Qt.BrushStyle.NoBrush)
    for shape in shapes:
        if len(shape.wire):
            painter.setPen(_pen(QColor(LIMB_COLOURS[shape.limb]), 1.0, scale))
            painter.drawPath(_segments_path(shape.wire))


def _paint_outlines(
    painter: QPainter, paths: Sequence[tuple[str, QPainterPath]], scale: float
) -> None:
    painter.setBrush(Qt.BrushStyle.NoBrush)
    for limb, path in paths:
        painter.setPen(_pen(_DARK, 3.4, scale))
        painter.drawPath(path)
        painter.setPen(_pen(QColor(LIMB_COLOURS[limb]), 2.0, scale))
        painter.drawPath(path)


def _paint_ghost(painter: QPainter, ghost: GhostOutline, scale: float) -> None:
    painter.setBrush(Qt.BrushStyle.NoBrush)
    for limb, path in ghost.paths:
        painter.setPen(_pen(_DARK, 2.8, scale))
        painter.drawPath(path)
        colour = QColor(LIMB_COLOURS[limb]).lighter(130)
        painter.setPen(_pen(colour, 1.6, scale, PEN_STYLES[ghost.style]))
        painter.drawPath(path)


def _paint_highlight(
    painter: QPainter, paths: Sequence[tuple[str, QPainterPath]], highlighted: str, scale: float
) -> None:
    painter.setBrush(Qt.BrushStyle.NoBrush)
    for limb, path in paths:
        if limb == highlighted:
            painter.setPen(_pen(QColor("white"), 4.0, scale))
            painter.drawPath(path)
            painter.setPen(_pen(QColor(LIMB_COLOURS[limb]), 2.0, scale))
            painter.drawPath(path)


def _paint_points(painter: QPainter, points: FloatArray, scale: float) -> None:
    finite = points[np.isfinite(points).all(axis=1)]
    pen = _pen(QColor(255, 236, 90, 200), float(np.clip(0.8 * scale, 1.5, 4.0)), scale)
    painter.setPen(pen)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing, False)
    painter.drawPoints(_polygon(finite))
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)


def _paint_correspondences(
    painter: QPainter, correspondences: FloatArray, limbs: IntArray, scale: float
) -> None:
    for index, limb in enumerate(LIMBS):
        pairs = correspondences[limbs == index]
        pairs = pairs[np.isfinite(pairs).all(axis=(1, 2))]
        if len(pairs) == 0:
            continue
        colour = QColor(LIMB_COLOURS[limb])
        painter.setPen(_pen(colour.lighter(115), 1.2, scale))
        painter.drawPath(_segments_path(pairs))
        painter.setPen(_pen(QColor("white"), float(np.clip(scale, 1.2, 3.0)), scale))
        painter.drawPoints(_polygon(pairs[:, 0]))


def _paint_skeleton(
    painter: QPainter, landmarks: FloatArray, style: Qt.PenStyle, scale: float
) -> None:
    index = {name: i for i, name in enumerate(LANDMARKS)}
    lines = [(landmarks[index[a]], landmarks[index[b]], _limb_of(a, b)) for a, b in SKELETON]
    neck = 0.5 * (landmarks[index["left_shoulder"]] + landmarks[index["right_shoulder"]])
    lines.append((neck, landmarks[index["head"]], "head"))
    painter.setBrush(Qt.BrushStyle.NoBrush)
    for a, b, limb in lines:
        if not np.isfinite([a, b]).all():
            continue
        painter.setPen(_pen(_DARK, 4.2, scale))
        painter.drawLine(QPointF(*a), QPointF(*b))
        painter.setPen(_pen(QColor(LIMB_COLOURS[limb]).lighter(125), 2.2, scale, style))
        painter.drawLine(QPointF(*a), QPointF(*b))
    radius = 3.0 / max(scale, 1e-6)
    painter.setBrush(QColor("white"))
    painter.setPen(_pen(QColor(0, 0, 0, 200), 1.0, scale))
    for point in landmarks[np.isfinite(landmarks).all(axis=1)]:
        painter.drawEllipse(QPointF(*point), radius, radius)


def _limb_of(a: str, b: str) -> str:
    """The limb that a line of the skeleton belongs to: that of its outer end."""
    limbs = {LANDMARK_LIMBS[a], LANDMARK_LIMBS[b]}
    if "hip" in a or (a, b) == ("left_shoulder", "right_shoulder"):
        return "torso"
    return LANDMARK_LIMBS[b] if len(limbs) > 1 or "elbow" in b else LANDMARK_LIMBS[a]


def _pen(
    colour: QColor, width: float, scale: float, style: Qt.PenStyle = Qt.PenStyle.SolidLine
) -> QPen:
    """Pen of a width in widget pixels, whatever the zoom and the scaling of the screen."""
    # a cosmetic pen would be as wide in the screen's pixels, so half as wide at 2x
    picture_width = width / max(scale, 1e-6)
    pen = QPen(colour, picture_width, style, Qt.PenCapStyle.RoundCap, Qt.PenJoinStyle.RoundJoin)
    if style != Qt.PenStyle.SolidLine:
        pen.setCapStyle(Qt.PenCapStyle.FlatCap)
    return pen


def _polygon(points: FloatArray) -> QPolygonF:
    return QPolygonF([QPointF(x, y) for x, y in np.asarray(points, dtype=np.float64).tolist()])


def _segments_path(segments: FloatArray) -> QPainterPath:
    flat = segments.reshape(-1, 2)
    path: QPainterPath = pyqtgraph.arrayToQPath(
        np.ascontiguousarray(flat[:, 0]), np.ascontiguousarray(flat[:, 1]), connect="pairs"
    )
    return path
