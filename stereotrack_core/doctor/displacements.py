"""How one view's points lie to those of the other views: by how much they would have to be moved.

Iterated closest points, point to plane, over several instants at once, of surfaces that face the
same way.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np
import scipy

from stereotrack_core.arrays import FloatArray
from stereotrack_core.errors import Finding
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.description import Recording

_REACHES = (0.35, 0.35, 0.3, 0.25, 0.2, 0.15, 0.12, 0.1, 0.08, 0.06, 0.06, 0.06, 0.06, 0.06)
"""Metres within which points are laid onto each other, round by round."""

_SAME_WAY = 0.6  # cosine between normals from which two surfaces may be the same
_NEIGHBOURS = 12
_CLOSE = 0.02  # metres from a surface within which a point fits it
_FEWEST = 150


@dataclass(frozen=True, eq=False)
class Surface:
    """Points (N, 3) and normals (N, 3) at one instant, world, metres."""

    points: FloatArray
    normals: FloatArray


Surfaces: TypeAlias = Sequence[Mapping[str, Surface]]  # in the world, instant by instant, by view

Places: TypeAlias = Mapping[str, RigidTransform]  # where the rectified cameras are, by view name


@dataclass(frozen=True)
class CloudFit:
    """How a view's points would have to be moved to lie on those of the others."""

    shift: float  # metres by which points move, median
    before: float  # share of the points near another view's surface that lie close to it
    after: float  # the same share after the move

    @property
    def gain(self) -> float:
        """By how much the share rises."""
        return self.after - self.before


def surface_of(points: FloatArray, eye: FloatArray) -> Surface:
    """Points (N, 3) with normals that look at a camera at `eye` (3,)."""
    if len(points) <= _NEIGHBOURS:
        return Surface(np.zeros((0, 3)), np.zeros((0, 3)))
    _, near = scipy.spatial.cKDTree(points).query(points, _NEIGHBOURS)
    patch = points[near] - points[near].mean(axis=1, keepdims=True)
    _, vectors = np.linalg.eigh(np.einsum("nki,nkj->nij", patch, patch))
    normals = vectors[:, :, 0]
    away = np.einsum("ij,ij->i", normals, points - eye) > 0
    normals[away] *= -1.0
    return Surface(points, normals)


class _Pair(NamedTuple):
    """A view's surface and those of the others at one instant."""

    own: Surface
    others: Surface
    tree: scipy.spatial.cKDTree  # of the others' points


def fit_view(surfaces: Surfaces, view: str) -> CloudFit | None:
    """The movement that lays a view's surfaces onto those of the others; None if none are near."""
    pairs = []
    for seen in surfaces:
        rest = [surface for name, surface in seen.items() if name != view]
        if view in seen and len(seen[view].points) and any(len(one.points) for one in rest):
            own = Surface(seen[view].points[::2], seen[view].normals[::2])
            points = np.concatenate([one.points for one in rest])
            others = Surface(points, np.concatenate([one.normals for one in rest]))
            pairs.append(_Pair(own, others, scipy.spatial.cKDTree(points)))
    if not pairs:
        return None
    every = np.concatenate([pair.own.points for pair in pairs])
    about, moved = every.mean(axis=0), RigidTransform.identity()
    for reach in _REACHES:
        laid = [_laid(pair, moved, reach) for pair in pairs]
        points, normal, distances = (np.concatenate(one) for one in zip(*laid, strict=True))
        if len(points) < _FEWEST:
            return None
        design = np.hstack([np.cross(points - about, normal), normal])
        step = _step(design, distances, 0.3 * reach)
        turn = rotation_from_vector(step[:3])
        moved = RigidTransform(turn, about - turn @ about + step[3:]) @ moved
    close, count = _close(pairs, moved)
    if count < _FEWEST:
        return None
    before, _ = _close(pairs, RigidTransform.identity())
    shift = float(np.median(np.linalg.norm(moved.apply(every) - every, axis=1)))
    return CloudFit(shift, before / count, close / count)


def _laid(
    pair: _Pair, moved: RigidTransform, reach: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Moved points, the normals of what they are laid onto, and the distances along them."""
    points = moved.apply(pair.own.points)
    far, near = pair.tree.query(points, distance_upper_bound=reach)
    found = np.flatnonzero(np.isfinite(far))
    normal = pair.others.normals[near[found]]
    turned = pair.own.normals[found] @ moved.rotation.T
    same = np.einsum("ij,ij->i", turned, normal) > _SAME_WAY
    found, normal = found[same], normal[same]
    gap = pair.others.points[near[found]] - points[found]
    return points[found], normal, np.einsum("ij,ij->i", gap, normal)


def _step(design: FloatArray, distances: FloatArray, scale: float) -> FloatArray:
    """Small change (6,) that takes the distances away, robustly (Geman-McClure)."""
    weight = 1.0 / np.square(1.0 + np.square(distances / scale))
    weighted = design * weight[:, None]
    normal = weighted.T @ design + 1e-6 * len(design) * np.eye(6)
    return np.asarray(np.linalg.solve(normal, weighted.T @ distances), dtype=np.float64)


def _close(pairs: Sequence[_Pair], moved: RigidTransform) -> tuple[int, int]:
    """Points that lie close to a surface, and those that are near one."""
    distance = np.concatenate([_laid(pair, moved, _REACHES[-1])[2] for pair in pairs])
    return int(np.count_nonzero(np.abs(distance) < _CLOSE)), len(distance)


_LEAST_GAIN, _CLEAR_GAIN = 0.15, 1.5
"""Rise of the share of points that fit, from which a view is off, and how much larger than that of
any other view it is where this one is to blame."""

_LEAST_SHIFT, _WRONG_SHIFT = 0.03, 0.06
"""Metres by which points have to move where a view is doubtful, and plainly wrong. Stereo matching
alone moves surfaces of plain clothes by up to 5 cm."""

_MOST_NAMED = 2  # views that are told where it is not clear which is wrong


def check_displacements(
    recording: Recording, surfaces: Surfaces, places: Places
) -> Iterator[Finding]:
    """The view whose points lie beside those of the others, and by how much."""
    fits = {name: one for name in places if (one := fit_view(surfaces, name)) is not None}
    accurate = len(places) > 2 and all(recording.view(name).kind == "depth" for name in places)
    least = _LEAST_SHIFT if accurate else _WRONG_SHIFT
    off = [name for name, one in fits.items() if one.gain > _LEAST_GAIN and one.shift > least]
    if not off:
        return
    off.sort(key=lambda name: -fits[name].gain)
    first = off[0]
    clear = len(places) > 2 and all(
        fits[first].gain > _CLEAR_GAIN * one.gain for name, one in fits.items() if name != first
    )
    named = [first] if clear else off[:_MOST_NAMED]
    told = [f"the camera is turned, or displaced by {100 * fits[n].shift:.0f} cm" for n in named]
    what = told[0]
    if not clear:
        each = " or ".join(f"of view {n} {words}" for n, words in zip(named, told, strict=True))
        what = f"their depths do not fit, and it cannot be told which view is wrong: {each}"
    grave = max(fits[name].shift for name in named) > _WRONG_SHIFT
    where = named if len(places) > 2 else list(places)  # either of two may be wrong
    where.sort(key=list(places).index)
    yield Finding(
        "error" if grave else "warning",
        f"view{'s' if len(where) > 1 else ''} {', '.join(where)}",
        f"{what}: {100 * fits[first].before:.0f} % of the points lie within 2 cm of the other "
        f"views' surfaces, {100 * fits[first].after:.0f} % with this corrected",
        " ".join(
            f"Calibrate the place of view {name} again, and check that it is synchronised."
            for name in named
        ),
    )
