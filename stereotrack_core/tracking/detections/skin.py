"""Head and hands as patches of skin in the colours of the cloud."""

from __future__ import annotations

import cv2
import numpy as np
from scipy.sparse import coo_matrix, csgraph
from scipy.spatial import cKDTree

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.recording.detections import HAND, HEAD, Detection

_RED = (136, 173)
_BLUE = (77, 126)
"""Chrominances Cr and Cb of skin of all shades (Chai & Ngan 1999, DOI 10.1109/76.767122); Cr begins
a little higher, where grey things end."""

_DARKEST = 35
"""Grey level below which colours say nothing."""

_STEP = 0.035
"""Metres between neighbours in a patch."""

_LEAST = 15
"""Data without which a patch is noise."""

_HAND = 0.20
"""Metres from a patch's far end that belong to the hand, where the forearm is bare."""

_SIGMA = {HEAD: 0.07, HAND: 0.05}


def skin_detections(cloud: Cloud) -> tuple[Detection, ...]:
    """Detect head and hands in a cloud with colours; nothing where it has none.

    The patch that is highest over the trunk and least aside of it is the face, others are hands;
    of a long one, a bare arm, the end that is farther from the trunk counts.
    """
    if cloud.colours is None or len(cloud.colours) != len(cloud.points):
        return ()
    skin = is_skin(cloud.colours)
    points = cloud.points[skin]
    if len(points) < _LEAST:
        return ()
    label = _patches(points)
    sizes = np.bincount(label)
    patches = [points[label == k] for k in np.flatnonzero(sizes >= _LEAST)]
    if not patches:
        return ()
    trunk = np.median(cloud.points, axis=0)
    over = [_over(patch, trunk) for patch in patches]
    face = int(np.argmax(over)) if max(over) > 0.0 else -1
    found = []
    for i, patch in enumerate(patches):
        kind = HEAD if i == face else HAND
        place = patch.mean(axis=0) if kind == HEAD else _far_end(patch, trunk)
        found.append(Detection(cloud.frame, kind, place, _SIGMA[kind], 0.5))
    return tuple(found)


def is_skin(colours: FloatArray) -> BoolArray:
    """Which colours (N, 3), BGR from 0 to 255, may be skin (N,)."""
    bgr = np.clip(np.rint(colours), 0, 255).astype(np.uint8)[None]
    y, red, blue = np.moveaxis(cv2.cvtColor(bgr, cv2.COLOR_BGR2YCrCb)[0], -1, 0)
    in_red = (red >= _RED[0]) & (red <= _RED[1])
    result: BoolArray = (y >= _DARKEST) & in_red & (blue >= _BLUE[0]) & (blue <= _BLUE[1])
    return result


def _patches(points: FloatArray) -> IntArray:
    pairs = cKDTree(points).query_pairs(_STEP, output_type="ndarray")
    graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), (len(points),) * 2)
    _, label = csgraph.connected_components(graph, directed=False)
    result: IntArray = label.astype(np.int64)
    return result


def _over(patch: FloatArray, trunk: FloatArray) -> float:
    off = patch.mean(axis=0) - trunk
    return float(off[2] - np.hypot(off[0], off[1]))


def _far_end(patch: FloatArray, trunk: FloatArray) -> FloatArray:
    far = np.linalg.norm(patch - trunk, axis=1)
    result: FloatArray = patch[far > far.max() - _HAND].mean(axis=0)
    return result
