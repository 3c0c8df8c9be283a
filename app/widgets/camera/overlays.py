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

from ..style.colours import LANDMARK_LIMBS, LIMB_COLOURS, OLD, PEN_STYLES, LineStyle

Projection: TypeAlias = Callable[[FloatArray], FloatArray]
"""From world points (..., 3) to pixels (..., 2) of a picture; NaN behind the camera."""

OVERLAYS: dict[str, str] = {
    "outline": "Model silhouette",
    "shading": "Shaded model",
    "wire": "Wireframe model",
    "others": "Silhouettes of other runs",
    "reference": "Reference skeleton",
    "points": "Measured points",
    "keypoints": "Keypoints of detectors",
    "correspondences": "Correspondences",
}
"""Overlays that can be switched one by one, with their names."""

LEADING = frozenset(OVERLAYS) - {"points"}
"""Those of runs and references, which would lead the clicks of somebody who annotates."""

_DARK = QColor(0, 0, 0, 170)
_GHOST_ALPHA = 130


@dataclass(frozen=True, eq=False)
class Marked:
    """What is drawn in one colour."""

    name: str
    """#rrggbb; of ghosts the limb."""
    places: FloatArray
    """Ghosts: the vertices (S, V, 3) of one cone of the model in several poses; lines: their ends
    (K, 2, 3); dots: (K, 3)."""


@dataclass(frozen=True, eq=False)
class InsideScene:
    """What a step inside a frame draws.

    In the world, metres; or in a picture, where all places are pixels, with two numbers for three,
    and ghosts are silhouettes (K, 2).
    """

    ghosts: tuple[Marked, ...] = ()
    lines: tuple[Marked, ...] = ()
    dots: tuple[Marked, ...] = ()

    def projected(self, project: Projection) -> InsideScene:
        """The same in a picture."""
        silhouettes = tuple(
            Marked(ghost.name, _hull(cone))
            for ghost in self.ghosts
            for cone in project(ghost.places)
            if _usable(cone)
        )
        lines, dots = (
            tuple(Marked(each.name, project(each.places)) for each in marked)
            for marked in (self.lines, self.dots)
        )
        return InsideScene(silhouettes, lines, dots)


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
class Overlay:
    """Everything that may be drawn over one picture."""

    shapes: tuple[PartShape, ...] = ()
    """The model, the farthest part first."""
    paths: tuple[tuple[str, QPainterPath], ...] = ()
    """Outline of each limb."""
    reference: FloatArray | None = None
    """(9, 2) float64 or None, pixels."""
    reference_is_old: bool = False
    """Whether it was fitted before the last click."""
    ghosts: tuple[tuple[LineStyle, tuple[tuple[str, QPainterPath], ...]], ...] = ()
    """Line style and outline of each limb of the models of further runs."""
    runs: tuple[tuple[str, LineStyle], ...] = ()
    """All runs that are drawn and their line styles, the active one first."""
    points: FloatArray | None = None
    """(N, 2) float64, pixels."""
    correspondences: FloatArray | None = None
    """(m, 2, 2) float64, pixels. From the measured point to the model's."""
    limbs: IntArray | None = None
    """(m,) int64. Index into ``LIMBS`` of each correspondence."""
    inside: InsideScene | None = None
    """What a step inside the frame draws."""
    keypoints: InsideScene | None = None
    """What detectors have predicted in this picture."""

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

    `eye` is the camera's centre (3,), world; `wire` asks for the edges, which cost most.
    """
    if not meshes:
        return ()
    pixels = project(np.concatenate([mesh.vertices for mesh in meshes]))
    shapes = []
    start = 0
    for mesh in meshes:
        own = pixels[start : start + len(mesh.vertices)]
        start += len(mesh.vertices)
        if not _usable(own):
            continue
        shapes.append(
            PartShape(
                mesh.limb,
                _hull(own),
                own[[0, -1]],
                _facing_edges(mesh, own, eye) if wire else np.empty((0, 2, 2)),
                float(np.linalg.norm(mesh.vertices.mean(axis=0) - eye)),
            )
        )
    return tuple(sorted(shapes, key=lambda shape: -shape.distance))


def _usable(pixels: FloatArray) -> bool:
    """Whether all of a cone lies before the camera."""
    return bool(np.isfinite(pixels).all() and np.abs(pixels).max() <= 1e5)


def _hull(pixels: FloatArray) -> FloatArray:
    return np.asarray(cv2.convexHull(pixels.astype(np.float32))[:, 0], dtype=np.float64)


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
    """Paint what is switched on, in the picture's pixels, each `scale` pixels of the widget."""
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    if "shading" in shown:
        _paint_shading(painter, overlay.shapes)
    if "points" in shown and overlay.points is not None:
        _paint_points(painter, overlay.points, scale)
    painter.setBrush(Qt.BrushStyle.NoBrush)
    _paint_models(painter, overlay, shown, highlighted, scale)
    if "keypoints" in shown and overlay.keypoints is not None:
        _paint_inside(painter, overlay.keypoints, scale)
    if "correspondences" in shown:
        _paint_correspondences(painter, overlay, scale)
    if overlay.inside is not None:
        _paint_inside(painter, overlay.inside, scale)
    if "reference" in shown and overlay.reference is not None:
        painter.setOpacity(OLD if overlay.reference_is_old else 1.0)
        _paint_skeleton(painter, overlay.reference, scale)
        painter.setOpacity(1.0)


def _paint_models(
    painter: QPainter, overlay: Overlay, shown: frozenset[str], highlighted: str, scale: float
) -> None:
    """Lines of the models: edges and outlines of the run's, outlines of those of other runs."""
    if "wire" in shown:
        for shape in overlay.shapes:
            _trace(painter, _segments_path(shape.wire), scale, (_colour(shape.limb), 1.0))
    if "others" in shown:
        for style, paths in overlay.ghosts:
            for limb, path in paths:
                line = (_colour(limb).lighter(130), 1.6)
                _trace(painter, path, scale, (_DARK, 2.8), line, style=PEN_STYLES[style])
    if "outline" in shown:
        for limb, path in overlay.paths:
            _trace(painter, path, scale, (_DARK, 3.4), (_colour(limb), 2.0))
    for limb, path in overlay.paths:
        if limb == highlighted:
            _trace(painter, path, scale, (QColor("white"), 4.0), (_colour(limb), 2.0))


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
    for place, factor in ((0.0, 150), (0.35, 78), (0.6, 100), (1.0, 190)):
        tone = _colour(shape.limb).darker(factor)
        tone.setAlpha(165)
        gradient.setColorAt(place, tone)
    return gradient


def _paint_points(painter: QPainter, points: FloatArray, scale: float) -> None:
    painter.setRenderHint(QPainter.RenderHint.Antialiasing, False)
    width = float(np.clip(0.8 * scale, 1.5, 4.0))
    _dot(painter, points, scale, (QColor(255, 236, 90, 200), width))
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)


def _paint_correspondences(painter: QPainter, overlay: Overlay, scale: float) -> None:
    if overlay.correspondences is None or overlay.limbs is None:
        return
    for index, limb in enumerate(LIMBS):
        pairs = overlay.correspondences[overlay.limbs == index]
        line = (_colour(limb).lighter(115), 1.2)
        _trace(painter, _segments_path(pairs), scale, line)
        _dot(painter, pairs[:, 0], scale, (QColor("white"), float(np.clip(scale, 1.2, 3.0))))


def _paint_inside(painter: QPainter, inside: InsideScene, scale: float) -> None:
    """Ghosts, lines and dots of one step inside a frame."""
    for ghost in inside.ghosts:
        colour = QColor(LIMB_COLOURS.get(ghost.name, "#999999")).lighter(120)
        colour.setAlpha(_GHOST_ALPHA)
        painter.setPen(_pen(colour, 0.8, scale))
        painter.drawPolygon(_polygon(ghost.places))
    for line in inside.lines:
        lines = (QColor(0, 0, 0, 150), 3.0), (QColor(line.name), 1.6)
        _trace(painter, _segments_path(line.places), scale, *lines)
    for dot in inside.dots:
        dots = (QColor(0, 0, 0, 190), 4.6), (QColor(dot.name), 3.0)
        _dot(painter, dot.places, scale, *dots)


def _paint_skeleton(painter: QPainter, landmarks: FloatArray, scale: float) -> None:
    """The reference: dashed bones and white joints."""
    place = dict(zip(LANDMARKS, landmarks, strict=True))
    neck = 0.5 * (place["left_shoulder"] + place["right_shoulder"])
    bones = {"head": [(neck, place["head"])]}
    for a, b in SKELETON:
        bones.setdefault(_limb_of(a, b), []).append((place[a], place[b]))
    every = [bone for limb in bones.values() for bone in limb]
    _trace(painter, _segments_path(np.array(every)), scale, (_DARK, 4.2))
    for limb, own in bones.items():
        line = (_colour(limb).lighter(125), 2.2)
        _trace(painter, _segments_path(np.array(own)), scale, line, style=Qt.PenStyle.DashLine)
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


def _colour(limb: str) -> QColor:
    return QColor(LIMB_COLOURS[limb])


def _trace(
    painter: QPainter,
    path: QPainterPath,
    scale: float,
    *lines: tuple[QColor, float],
    style: Qt.PenStyle = Qt.PenStyle.SolidLine,
) -> None:
    """Draw a path with lines over each other; the last one in a style."""
    for place, (colour, width) in enumerate(lines, start=1):
        own = style if place == len(lines) else Qt.PenStyle.SolidLine
        painter.setPen(_pen(colour, width, scale, own))
        painter.drawPath(path)


def _dot(painter: QPainter, places: FloatArray, scale: float, *dots: tuple[QColor, float]) -> None:
    """Draw dots (K, 2) over each other where places are known."""
    known = _polygon(places[np.isfinite(places).all(axis=1)])
    for colour, width in dots:
        painter.setPen(_pen(colour, width, scale))
        painter.drawPoints(known)


def _pen(
    colour: QColor, width: float, scale: float, style: Qt.PenStyle = Qt.PenStyle.SolidLine
) -> QPen:
    """Pen of a width in widget pixels, whatever the zoom and the scaling of the screen."""
    # a cosmetic pen would be as wide in the screen's pixels, so half as wide at 2x
    solid = style == Qt.PenStyle.SolidLine
    cap = Qt.PenCapStyle.RoundCap if solid else Qt.PenCapStyle.FlatCap
    return QPen(colour, width / max(scale, 1e-6), style, cap, Qt.PenJoinStyle.RoundJoin)


def _polygon(points: FloatArray) -> QPolygonF:
    return QPolygonF([QPointF(x, y) for x, y in points.tolist()])


def _segments_path(segments: FloatArray) -> QPainterPath:
    """Path of the segments (K, 2, 2) whose both ends are known."""
    flat = segments[np.isfinite(segments).all(axis=(1, 2))].reshape(-1, 2)
    path: QPainterPath = pyqtgraph.arrayToQPath(
        np.ascontiguousarray(flat[:, 0]), np.ascontiguousarray(flat[:, 1]), connect="pairs"
    )
    return path
