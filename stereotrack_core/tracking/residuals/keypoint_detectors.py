"""Head and hands found in a cloud: as its ends, or as skin in colour pictures.

An end is farthest from the middle along the surface: the farthest point by geodesic distance is
one; with it as a further source the next farthest one is another, and so on (Plagemann et al.
2010, DOI 10.1109/ROBOT.2010.5509559).
"""

from __future__ import annotations

import cv2
import numpy as np
import scipy.sparse as sparse
from scipy.sparse import csgraph
from scipy.spatial import cKDTree

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.recording.detections import HAND, HEAD, Detection

_VOXEL = 0.03
"""Metres; side of the cubes whose data become one node."""

_STEP = 0.075
"""Metres between neighbours: less than between an arm and the torso behind it."""

_BRIDGE = 0.30
"""Metres over which pieces that hide each other are joined."""

_PIECE = 6
"""Nodes without which a piece that stands apart is dirt."""

_ENDS = 7
"""Ends that are looked for: head, hands, feet, and two that may be anything."""

_LEAST_WAY = 0.40
"""Metres along the surface from the middle within which nothing is an end."""

_AROUND = {HEAD: 0.15, HAND: 0.09}
"""Metres around the end whose mean is the landmark."""

_UNDER_CROWN = 0.09
"""Metres from what is seen of the upper half of the head to its landmark."""

_SIGMA = {HEAD: 0.07, HAND: 0.05}
"""Metres; of the landmark that is stated."""

_HEAD_ABOVE, _HEAD_ASIDE = 0.2, 0.45
"""Metres over the middle, and from the middle's vertical, between which a head may be."""

_HAND_WIDTH = 0.043
"""Metres; standard deviation across an end from which it is too broad for a hand."""

_HAND_WAY = 0.5
"""Metres along the surface from the middle nearer to which ends are no hands."""

_FEET = 0.35
"""Metres above the lowest data below which ends are feet, or cannot be told from them."""


def extremities(points: FloatArray, time: float) -> tuple[Detection, ...]:
    """Detect head and hands in the cloud of one person.

    Parameters
    ----------
    points : (N, 3) float64, world
        The z axis points up.
    time : float
        Frame that the detections are stated for.

    Returns
    -------
    tuple of Detection
        Hands without their side; nothing where the cloud is too small.
    """
    nodes, lengths = surface_graph(points)
    if len(nodes) < 10 * _PIECE:
        return ()
    middle = _middle(nodes)
    ends, ways = _geodesic_ends(lengths, middle)
    floor = np.percentile(nodes[:, 2], 1.0)
    head = _head_among(nodes, ends, nodes[middle])
    found = []
    for end, way in zip(ends, ways, strict=True):
        kind = HEAD if end == head else HAND
        hand = way > _HAND_WAY and nodes[end, 2] > floor + _FEET and _slim(nodes, end)
        if kind == HAND and not hand:
            continue
        near = np.linalg.norm(nodes - nodes[end], axis=1) < _AROUND[kind]
        place = nodes[near].mean(axis=0)
        if kind == HEAD:
            up = nodes[end] - nodes[middle]
            place -= _UNDER_CROWN * (up / max(float(np.linalg.norm(up)), 1e-9))
        found.append(Detection(time, kind, place, _SIGMA[kind], 0.5))
    return tuple(found)


def surface_graph(points: FloatArray) -> tuple[FloatArray, sparse.csr_matrix]:
    """Thin a cloud out and join neighbours; pieces that are apart are joined where nearest.

    Returns the nodes (M, 3), world, metres, and the lengths (M, M) between neighbours, metres.
    """
    nodes = _thinned(points)
    if len(nodes) < 2:
        return nodes, sparse.csr_matrix((len(nodes), len(nodes)))
    pairs = cKDTree(nodes).query_pairs(_STEP, output_type="ndarray")
    _, piece = csgraph.connected_components(_lengths(nodes, pairs), directed=False)
    sizes = np.bincount(piece)
    kept = sizes[piece] >= _PIECE
    number = np.cumsum(kept) - 1
    pairs = number[pairs[kept[pairs].all(axis=1)]]
    nodes, piece = nodes[kept], piece[kept]
    bridges = _bridges(nodes, piece)
    return nodes, _lengths(nodes, np.concatenate([pairs, bridges]))


def _geodesic_ends(lengths: sparse.csr_matrix, middle: int) -> tuple[list[int], list[float]]:
    """Nodes farthest from the middle and each other, the farthest first; ways to the middle."""
    from_middle = csgraph.dijkstra(lengths, directed=False, indices=middle)
    from_middle[~np.isfinite(from_middle)] = 0.0
    way: FloatArray = from_middle.copy()
    ends: list[int] = []
    for _ in range(_ENDS):
        end = int(np.argmax(way))
        if way[end] < _LEAST_WAY * (0.5 if ends else 1.0):
            break
        if from_middle[end] >= _LEAST_WAY:
            ends.append(end)
        from_end = csgraph.dijkstra(lengths, directed=False, indices=end)
        way = np.minimum(way, from_end)
    return ends, [float(from_middle[end]) for end in ends]


def _middle(nodes: FloatArray) -> int:
    """Node nearest to the middle of the trunk: the median of what stands above the legs."""
    upper = nodes[nodes[:, 2] > np.median(nodes[:, 2])]
    place = np.median(upper, axis=0)
    place[2] = np.median(nodes[:, 2])
    return int(np.argmin(np.linalg.norm(nodes - place, axis=1)))


def _head_among(nodes: FloatArray, ends: list[int], middle: FloatArray) -> int:
    """The end that is highest over the middle and least aside of it; -1 where none is high."""
    best, highest = -1, 0.0
    for end in ends:
        off = nodes[end] - middle
        aside = float(np.hypot(off[0], off[1]))
        if off[2] > _HEAD_ABOVE and aside < _HEAD_ASIDE and off[2] - aside > highest:
            best, highest = end, off[2] - aside
    return best


def _slim(nodes: FloatArray, end: int) -> bool:
    """Whether an end is narrow across, as hands are and hips, elbows and knees are not."""
    around = nodes[np.linalg.norm(nodes - nodes[end], axis=1) < _AROUND[HEAD]]
    if len(around) < 4:
        return True
    spread = np.linalg.eigvalsh(np.cov(around.T))
    return float(np.sqrt(max(spread[1], 0.0))) < _HAND_WIDTH


def _thinned(points: FloatArray) -> FloatArray:
    """Means (M, 3) of the data in cubes."""
    if not len(points):
        return np.zeros((0, 3))
    cube = np.floor(points / _VOXEL).astype(np.int64)
    _, index, count = np.unique(cube, axis=0, return_inverse=True, return_counts=True)
    sums = np.stack([np.bincount(index.ravel(), points[:, k]) for k in range(3)], axis=1)
    return sums / count[:, None]


def _lengths(nodes: FloatArray, pairs: IntArray) -> sparse.csr_matrix:
    length = np.linalg.norm(nodes[pairs[:, 0]] - nodes[pairs[:, 1]], axis=1)
    shape = len(nodes), len(nodes)
    return sparse.coo_matrix((np.maximum(length, 1e-9), (pairs[:, 0], pairs[:, 1])), shape).tocsr()


def _bridges(nodes: FloatArray, piece: IntArray) -> IntArray:
    """Pairs (B, 2) that join every piece to the nearest larger one."""
    labels, sizes = np.unique(piece, return_counts=True)
    order = labels[np.argsort(-sizes, kind="stable")]
    pairs = []
    joined = piece == order[0] if len(order) else np.zeros(0, dtype=np.bool_)
    for label in order[1:]:
        own, others = np.flatnonzero(piece == label), np.flatnonzero(joined)
        distance, nearest = cKDTree(nodes[others]).query(nodes[own])
        k = int(np.argmin(distance))
        if distance[k] < _BRIDGE:
            pairs.append((own[k], others[nearest[k]]))
            joined = joined | (piece == label)
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)


_RED = (136, 173)
_BLUE = (77, 126)
"""Chrominances Cr and Cb of skin of all shades (Chai & Ngan 1999, DOI 10.1109/76.767122); Cr begins
a little higher, where grey things end."""

_DARKEST = 35
"""Grey level below which colours say nothing."""

_SKIN_STEP = 0.035
"""Metres between neighbours in a patch."""

_LEAST = 15
"""Data without which a patch is noise."""

_HAND = 0.20
"""Metres from a patch's far end that belong to the hand, where the forearm is bare."""


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
    pairs = cKDTree(points).query_pairs(_SKIN_STEP, output_type="ndarray")
    _, label = csgraph.connected_components(_lengths(points, pairs), directed=False)
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


def _over(patch: FloatArray, trunk: FloatArray) -> float:
    off = patch.mean(axis=0) - trunk
    return float(off[2] - np.hypot(off[0], off[1]))


def _far_end(patch: FloatArray, trunk: FloatArray) -> FloatArray:
    far = np.linalg.norm(patch - trunk, axis=1)
    result: FloatArray = patch[far > far.max() - _HAND].mean(axis=0)
    return result
