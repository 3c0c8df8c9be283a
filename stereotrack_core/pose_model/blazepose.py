"""Numbers of BlazePose's networks: anchors, decoding and non-maximum suppression.

As MediaPipe 0.10.21 does it (Apache-2.0): the graphs pose_detection_cpu and pose_landmark_cpu with
SsdAnchorsCalculator, TensorsToDetectionsCalculator, NonMaxSuppressionCalculator.
Bazarevsky et al. 2020, DOI 10.48550/arXiv.2006.10204.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
import numpy.typing as npt

from stereotrack_core.arrays import Float32Array, FloatArray

FINDER_SIDE = 224  # pixels of the person finder's square input
LANDMARK_SIDE = 256  # pixels of the landmark network's square input
_GRIDS = ((8, 2), (16, 2), (32, 6))  # pixels of a cell, and anchors in each
LEAST_SCORE = 0.5  # score of the finder from which it is MediaPipe's person

_SAME_PERSON = 0.3  # overlap of boxes (intersection over union) from which they are of one person
_MOST_LOGIT = 100.0

_REACH = 3  # cells of a heat map on each side of a landmark in which its place is refined
_SHOWN = 0.5  # probability in one of these cells without which the landmark stays


@dataclass(frozen=True, eq=False)
class Candidates:
    """Detections of the person finder, the surest first, in its pixels or a picture's."""

    boxes: FloatArray  # (N, 4). Left, top, right and bottom of the head.
    points: FloatArray
    """(N, 4, 2). Middle of the hips, a point on the circle around the body, middle of the
    shoulders, a point on the circle around the upper body."""
    scores: FloatArray  # (N,). From 0 to 1.

    def __len__(self) -> int:
        return len(self.scores)


def sigmoid(logits: npt.ArrayLike) -> FloatArray:
    """1 / (1 + exp(-x)), without overflow."""
    x = np.clip(np.asarray(logits, dtype=np.float64), -_MOST_LOGIT, _MOST_LOGIT)
    return np.asarray(1.0 / (1.0 + np.exp(-x)))


@cache
def anchors() -> FloatArray:
    """Centres (2254, 2) of the finder's anchors, column and row in pixels of its input.

    MediaPipe counts from the corner, with which mirrored pictures give places that are 0.43 (0.09)
    pixels apart on average; with the same numbers counted from the first pixel's centre they agree.
    """
    centres = []
    for cell, count in _GRIDS:
        axis = (np.arange(FINDER_SIDE // cell) + 0.5) * cell
        rows, columns = np.meshgrid(axis, axis, indexing="ij")
        grid = np.stack([columns, rows], axis=2).reshape(-1, 2)
        centres.append(np.repeat(grid, count, axis=0))
    result = np.concatenate(centres)
    result.flags.writeable = False
    return result


def decode(raw: Float32Array, logits: Float32Array, least_score: float = LEAST_SCORE) -> Candidates:
    """Detections of the finder's outputs (2254, 12) and (2254,), in pixels of its input."""
    scores = sigmoid(logits)
    kept = np.flatnonzero(scores >= least_score)
    kept = kept[np.argsort(-scores[kept], kind="stable")]
    values = raw[kept].astype(np.float64).reshape(-1, 6, 2)  # centre, size and four points
    centres = anchors()[kept]
    middle, half = values[:, 0] + centres, values[:, 1] / 2.0
    boxes = np.concatenate([middle - half, middle + half], axis=1)
    return Candidates(boxes, values[:, 2:] + centres[:, None], scores[kept])


def suppress(found: Candidates) -> Candidates:
    """Weighted non-maximum suppression: one detection per person, the mean of those that overlap.

    Boxes and points are means weighted by the scores; the score is that of the surest.
    """
    left = np.arange(len(found))
    boxes, points, scores = [], [], []
    while len(left):
        same = _overlaps(found.boxes[left[0]], found.boxes[left]) > _SAME_PERSON
        same[0] = True
        own, left = left[same], left[~same]
        weights = found.scores[own] / found.scores[own].sum()
        boxes.append(weights @ found.boxes[own])
        points.append(np.einsum("n,nij->ij", weights, found.points[own]))
        scores.append(found.scores[own[0]])
    return Candidates(
        np.reshape(boxes, (-1, 4)), np.reshape(points, (-1, 4, 2)), np.array(scores, dtype=float)
    )


def refined(places: FloatArray, heat: Float32Array) -> FloatArray:
    """Landmarks (N, 2) moved to the middle of what heat maps (H, W, M), logits, show around them.

    As RefineLandmarksFromHeatmapCalculator does it; places are pixels of the input from its corner.
    Joints of recordings with truth are 6 to 27 % nearer then, in the median.
    """
    height, width = heat.shape[:2]
    scale = np.array([width, height]) / LANDMARK_SIDE
    result = places.copy()
    for k, (column, row) in enumerate(np.floor(places * scale).astype(int)):
        if not (0 <= column < width and 0 <= row < height):
            continue
        left, top = max(column - _REACH, 0), max(row - _REACH, 0)
        shown = sigmoid(heat[top : row + _REACH + 1, left : column + _REACH + 1, k])
        if shown.max() >= _SHOWN:
            total = shown.sum()
            x = left + shown.sum(axis=0) @ np.arange(shown.shape[1]) / total
            y = top + shown.sum(axis=1) @ np.arange(shown.shape[0]) / total
            result[k] = np.array([x, y]) / scale
    return result


def _overlaps(box: FloatArray, boxes: FloatArray) -> FloatArray:
    """Intersection over union of a box (4,) with boxes (N, 4)."""
    size = np.minimum(box[2:], boxes[:, 2:]) - np.maximum(box[:2], boxes[:, :2])
    common = np.prod(np.maximum(size, 0.0), axis=1)
    areas = np.prod(np.maximum(boxes[:, 2:] - boxes[:, :2], 0.0), axis=1)
    union = areas + float(np.prod(np.maximum(box[2:] - box[:2], 0.0))) - common
    return np.asarray(common / np.maximum(union, 1e-9))
