"""What is drawn over a picture: computed in the picture's pixels, painted with Qt."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import hypot
from typing import TypeAlias

import cv2
import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import (
    QBrush,
    QColor,
    QLinearGradient,
    QPainter,
    QPainterPath,
    QPen,
    QPolygonF,
    QTransform,
)

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.mesh import PartMesh
from stereotrack_core.recording.landmarks import LANDMARKS, SKELETON

from ...session.view_state import InsideScene, Marked
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

LEADING = frozenset(OVERLAYS) - {"points"}
"""Those of runs and references, which would lead the clicks of somebody who annotates."""

_DARK = QColor(0, 0, 0, 170)
_GHOST_ALPHA = 130


@dataclass(frozen=True, eq=False)
class PartShape:
    """One cone of the model as it appears in a picture."""

    limb: str
    outline: FloatArray  # (K, 2) float64, pixels. Convex silhouette.
    axis: FloatArray  # (2, 2) float64, pixels. From the base's to the end's centre.
    wire: FloatArray  # (E, 2, 2) float64, pixels. Edges of the surface that face the camera.
    distance: float  # Metres. From the camera, to paint the far ones first.


@dataclass(frozen=True, eq=False)
class Overlay:
    """Everything that may be drawn over one picture."""

    shapes: tuple[PartShape, ...] = ()  # the model, the farthest part first
    paths: tuple[tuple[str, QPainterPath], ...] = ()
    reference: FloatArray | None = None  # (9, 2) float64 or None, pixels
    reference_is_old: bool = False
    ghosts: tuple[tuple[LineStyle, tuple[tuple[str, QPainterPath], ...]], ...] = ()
    """Line style and outline of each limb of the models of further runs."""
    points: FloatArray | None = None  # (N, 2) float64, pixels
    correspondences: FloatArray | None = None
    """(m, 2, 2) float64, pixels. From the measured point to the model's."""
    limbs: IntArray | None = None  # (m,) int64. Index into `LIMBS` of each correspondence.
    inside: InsideScene | None = None
    keypoints: InsideScene | None = None

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


def projected(inside: InsideScene, project: Projection) -> InsideScene:
    """What a step draws, in a picture."""
    cones = ((ghost.name, cone) for ghost in inside.ghosts for cone in project(ghost.places))
    silhouettes = tuple(Marked(name, _hull(cone)) for name, cone in cones if _usable(cone))
    lines, dots = (
        tuple(Marked(each.name, project(each.places)) for each in marked)
        for marked in (inside.lines, inside.dots)
    )
    return InsideScene(silhouettes, lines, dots)


def part_shapes(
    meshes: Sequence[PartMesh], project: Projection, eye: FloatArray, *, wire: bool
) -> tuple[PartShape, ...]:
    """Project the model's cones, the farthest first; parts behind the camera are left out.

    `eye` is the camera's centre (3,), world; `wire` asks for the edges, which cost most.
    """
    if not meshes:
        return ()
    pixels = project(np.concatenate([mesh.vertices for mesh in meshes]))
    ends = np.cumsum([len(mesh.vertices) for mesh in meshes])
    shapes = []
    for mesh, own in zip(meshes, np.split(pixels, ends[:-1]), strict=True):
        if _usable(own):
            edges = _facing_edges(mesh, own, eye) if wire else np.empty((0, 2, 2))
            distance = float(np.linalg.norm(mesh.vertices.mean(axis=0) - eye))
            shapes.append(PartShape(mesh.limb, _hull(own), own[[0, -1]], edges, distance))
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
        united[shape.limb] = united.get(shape.limb, QPainterPath()).united(_outline(shape.outline))
    return tuple(united.items())


def stroke(painter: QPainter, path: QPainterPath, *pens: QPen, fill: QColor | None = None) -> None:
    """Draw a path with pens over each other, so that it is seen on any picture."""
    painter.setBrush(QBrush() if fill is None else QBrush(fill))
    for pen in pens:
        painter.setPen(pen)
        painter.drawPath(path)
    painter.setBrush(Qt.BrushStyle.NoBrush)


def paint_overlay(
    painter: QPainter,
    overlay: Overlay,
    shown: frozenset[str],
    highlighted: str,
    to_widget: QTransform,
) -> None:
    """Paint what is switched on; `to_widget` leads from raw pixels to the painter's coordinates."""
    painter.save()
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    scale = hypot(to_widget.m11(), to_widget.m12())
    if "shading" in shown:
        for shape in overlay.shapes:
            tone = QBrush(_cone_gradient(shape))
            tone.setTransform(to_widget)
            painter.fillPath(to_widget.map(_outline(shape.outline)), tone)
    if "points" in shown and overlay.points is not None:
        painter.setRenderHint(QPainter.RenderHint.Antialiasing, False)
        width = min(max(0.8 * scale, 1.5), 4.0)
        _dots(painter, overlay.points, to_widget, _line(QColor(255, 236, 90, 200), width))
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    _paint_models(painter, overlay, shown, highlighted, to_widget)
    if "keypoints" in shown and overlay.keypoints is not None:
        _paint_inside(painter, overlay.keypoints, to_widget)
    if "correspondences" in shown and overlay.correspondences is not None:
        for index, limb in enumerate(LIMBS):
            pairs = overlay.correspondences[overlay.limbs == index]
            line = _line(_colour(limb).lighter(115), 1.2)
            stroke(painter, to_widget.map(_segments_path(pairs)), line)
            width = min(max(scale, 1.2), 3.0)
            _dots(painter, pairs[:, 0], to_widget, _line(QColor("white"), width))
    if overlay.inside is not None:
        _paint_inside(painter, overlay.inside, to_widget)
    if "reference" in shown and overlay.reference is not None:
        painter.setOpacity(OLD if overlay.reference_is_old else 1.0)
        _paint_skeleton(painter, overlay.reference, to_widget)
    painter.restore()


def _paint_models(
    painter: QPainter,
    overlay: Overlay,
    shown: frozenset[str],
    highlighted: str,
    to_widget: QTransform,
) -> None:
    """Lines of the models: edges and outlines of the run's, outlines of those of other runs."""
    if "wire" in shown:
        for shape in overlay.shapes:
            path = to_widget.map(_segments_path(shape.wire))
            stroke(painter, path, _line(_colour(shape.limb), 1.0))
    if "others" in shown:
        for style, paths in overlay.ghosts:
            for limb, path in paths:
                line = _line(_colour(limb).lighter(130), 1.6, PEN_STYLES[style])
                stroke(painter, to_widget.map(path), _line(_DARK, 2.8), line)
    if "outline" in shown:
        for limb, path in overlay.paths:
            stroke(painter, to_widget.map(path), _line(_DARK, 3.4), _line(_colour(limb), 2.0))
    for limb, path in overlay.paths:
        if limb == highlighted:
            pens = _line(QColor("white"), 4.0), _line(_colour(limb), 2.0)
            stroke(painter, to_widget.map(path), *pens)


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


def _paint_inside(painter: QPainter, inside: InsideScene, to_widget: QTransform) -> None:
    for ghost in inside.ghosts:
        colour = QColor(LIMB_COLOURS.get(ghost.name, "#999999")).lighter(120)
        colour.setAlpha(_GHOST_ALPHA)
        stroke(painter, to_widget.map(_outline(ghost.places)), _line(colour, 0.8))
    for line in inside.lines:
        pens = _line(QColor(0, 0, 0, 150), 3.0), _line(QColor(line.name), 1.6)
        stroke(painter, to_widget.map(_segments_path(line.places)), *pens)
    for dot in inside.dots:
        pens = _line(QColor(0, 0, 0, 190), 4.6), _line(QColor(dot.name), 3.0)
        _dots(painter, dot.places, to_widget, *pens)


def _paint_skeleton(painter: QPainter, landmarks: FloatArray, to_widget: QTransform) -> None:
    """The reference: bones in a dash that no run has, and white joints."""
    place = dict(zip(LANDMARKS, landmarks, strict=True))
    neck = 0.5 * (place["left_shoulder"] + place["right_shoulder"])
    bones = {"head": [(neck, place["head"])]}
    for a, b in SKELETON:  # the limb of the outer end; what leads to a shoulder is the torso
        limb = "torso" if "shoulder" in b else LANDMARK_LIMBS[b]
        bones.setdefault(limb, []).append((place[a], place[b]))
    every = np.array([bone for limb in bones.values() for bone in limb])
    stroke(painter, to_widget.map(_segments_path(every)), _line(_DARK, 4.2))
    for limb, own in bones.items():
        line = _line(_colour(limb).lighter(125), 2.2, PEN_STYLES["reference"])
        stroke(painter, to_widget.map(_segments_path(np.array(own))), line)
    joints = QPainterPath()
    for point in landmarks[np.isfinite(landmarks).all(axis=1)]:
        joints.addEllipse(to_widget.map(QPointF(*point)), 3.0, 3.0)
    stroke(painter, joints, _line(QColor(0, 0, 0, 200), 1.0), fill=QColor("white"))


def _colour(limb: str) -> QColor:
    return QColor(LIMB_COLOURS[limb])


def _dots(painter: QPainter, places: FloatArray, to_widget: QTransform, *pens: QPen) -> None:
    """Draw dots (K, 2) with pens over each other where places are known."""
    known = to_widget.map(_polygon(places[np.isfinite(places).all(axis=1)]))
    for pen in pens:
        painter.setPen(pen)
        painter.drawPoints(known)


def _line(colour: QColor, width: float, style: Qt.PenStyle = Qt.PenStyle.SolidLine) -> QPen:
    solid = style == Qt.PenStyle.SolidLine
    cap = Qt.PenCapStyle.RoundCap if solid else Qt.PenCapStyle.FlatCap
    return QPen(colour, width, style, cap, Qt.PenJoinStyle.RoundJoin)


def _polygon(points: FloatArray) -> QPolygonF:
    return QPolygonF([QPointF(x, y) for x, y in points.tolist()])


def _outline(points: FloatArray) -> QPainterPath:
    path = QPainterPath()
    path.addPolygon(_polygon(points))
    path.closeSubpath()
    return path


def _segments_path(segments: FloatArray) -> QPainterPath:
    """Path of the segments (K, 2, 2) whose both ends are known."""
    flat = segments[np.isfinite(segments).all(axis=(1, 2))].reshape(-1, 2)
    import pyqtgraph  # takes a third of a second; the window is there first

    path: QPainterPath = pyqtgraph.arrayToQPath(
        np.ascontiguousarray(flat[:, 0]), np.ascontiguousarray(flat[:, 1]), connect="pairs"
    )
    return path
