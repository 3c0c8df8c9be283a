"""How one view's points lie to those of the other views: by how much they would have to be moved.

Iterated closest points, point to plane, over several instants at once. Only surfaces that face the
same way are laid onto each other, so that views of the front and of the back do not attract.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
import scipy

from stereotrack_core.arrays import FloatArray
from stereotrack_core.errors import Finding, Severity
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.description import Recording

_REACHES = (0.35, 0.35, 0.3, 0.25, 0.2, 0.15, 0.12, 0.1, 0.08, 0.06, 0.06, 0.06, 0.06, 0.06)
"""Metres within which points are laid onto each other, round by round."""

_SAME_WAY = 0.6
"""Cosine between normals from which two surfaces may be the same."""

_NEIGHBOURS = 12
_CLOSE = 0.02
"""Metres from a surface within which a point fits it."""

_STARTS = (0.0, -0.1, 0.1)
"""Logarithms of factors from which they are searched: points then lie within reach."""

_FEWEST = 150


@dataclass(frozen=True, eq=False)
class Surface:
    """Points (N, 3) and normals (N, 3) at one instant, world, metres."""

    points: FloatArray
    normals: FloatArray


Way: TypeAlias = Literal["range", "any"]
"""Error of a view: a factor on all its distances (range), or a rigid displacement (any)."""


@dataclass(frozen=True)
class CloudFit:
    """How a view's points would have to be moved to lie on those of the others."""

    way: Way
    amount: float
    """Factor of the distances, or metres for any other movement."""
    shift: float
    """Metres by which points move, median."""
    before: float
    """Share of the points that lie close to a surface of another view, of those near one after the
    move."""
    after: float
    """The same share after the move."""

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


def joined(surfaces: Sequence[Surface]) -> Surface:
    """All of them as one."""
    none = np.zeros((0, 3))
    return Surface(
        np.concatenate([none, *(one.points for one in surfaces)]),
        np.concatenate([none, *(one.normals for one in surfaces)]),
    )


def fit_clouds(
    own: Sequence[Surface], others: Sequence[Surface], eye: FloatArray, way: Way = "any"
) -> CloudFit | None:
    """The movement that lays a view's surfaces onto those of the others, instant by instant.

    `eye` (3,) is the view's camera. None where too little of both is near each other.
    """
    pairs = [(a, b) for a, b in zip(own, others, strict=True) if len(a.points) and len(b.points)]
    if not pairs:
        return None
    trees = [scipy.spatial.cKDTree(other.points) for _, other in pairs]
    starts = _STARTS if way == "range" else (0.0,)
    found = [_fitted(pairs, trees, eye, way, start) for start in starts]
    known = [one for one in found if one is not None]
    return max(known, key=lambda one: one[1])[0] if known else None


def _fitted(
    pairs: Sequence[tuple[Surface, Surface]],
    trees: Sequence[scipy.spatial.cKDTree],
    eye: FloatArray,
    way: Way,
    start: float,
) -> tuple[CloudFit, int] | None:
    """The fit that a search from a start ends with, and the points that lie close then."""
    every = np.concatenate([one.points for one, _ in pairs])
    about = every.mean(axis=0) if way == "any" else eye
    amount = np.full(1 if way == "range" else 6, start)
    moved = _affine(amount, about, way)
    for reach in _REACHES:
        rows, values = [], []
        for (one, other), tree in zip(pairs, trees, strict=True):
            points, normal, distance = _laid(one, other, tree, moved, reach)
            rows.append(_design(points - about, normal, way))
            values.append(distance)
        design, distances = np.concatenate(rows), np.concatenate(values)
        if len(design) < _FEWEST:
            return None
        step = _step(design, distances, 0.3 * reach)
        moved, amount = _affine(step, about, way) @ moved, amount + step
    close, count = _close(pairs, trees, moved)
    before, _ = _close(pairs, trees, _Affine(np.eye(3), np.zeros(3)))
    if count < _FEWEST:
        return None
    shift = float(np.median(np.linalg.norm(moved.apply(every) - every, axis=1)))
    size = float(np.exp(amount[0])) if way == "range" else shift
    return CloudFit(way, size, shift, before / count, close / count), close


@dataclass(frozen=True, eq=False)
class _Affine:
    """A matrix (3, 3) followed by a translation (3,)."""

    matrix: FloatArray
    translation: FloatArray

    def apply(self, points: FloatArray) -> FloatArray:
        return np.asarray(points @ self.matrix.T + self.translation)

    def __matmul__(self, other: _Affine) -> _Affine:
        return _Affine(self.matrix @ other.matrix, self.apply(other.translation))


def _design(arms: FloatArray, normal: FloatArray, way: Way) -> FloatArray:
    """Derivatives (N, K) of distances along normals; `arms` (N, 3) are points from the centre."""
    if way == "range":
        return np.asarray(np.einsum("ij,ij->i", arms, normal)[:, None])
    return np.hstack([np.cross(arms, normal), normal])


def _affine(step: FloatArray, about: FloatArray, way: Way) -> _Affine:
    """The movement of a step: a common factor, or a rigid one."""
    if way == "range":
        matrix, shift = np.exp(step[0]) * np.eye(3), np.zeros(3)
    else:
        matrix, shift = rotation_from_vector(step[:3]), step[3:]
    return _Affine(matrix, about - matrix @ about + shift)


def _laid(
    one: Surface,
    other: Surface,
    tree: scipy.spatial.cKDTree,
    moved: _Affine,
    reach: float,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Moved points, the normals of what they are laid onto, and the distances along them."""
    points = moved.apply(one.points)
    far, near = tree.query(points, distance_upper_bound=reach)
    found = np.flatnonzero(np.isfinite(far))
    normal = other.normals[near[found]]
    same = np.einsum("ij,ij->i", one.normals[found] @ moved.matrix.T, normal) > _SAME_WAY
    found, normal = found[same], normal[same]
    gap = other.points[near[found]] - points[found]
    return points[found], normal, np.einsum("ij,ij->i", gap, normal)


def _step(design: FloatArray, distances: FloatArray, scale: float) -> FloatArray:
    """Small change (K,) that takes the distances away, robustly (Geman-McClure)."""
    weight = 1.0 / np.square(1.0 + np.square(distances / scale))
    weighted = design * weight[:, None]
    normal = weighted.T @ design + 1e-6 * len(design) * np.eye(design.shape[1])
    return np.asarray(np.linalg.solve(normal, weighted.T @ distances), dtype=np.float64)


def _close(
    pairs: Sequence[tuple[Surface, Surface]],
    trees: Sequence[scipy.spatial.cKDTree],
    moved: _Affine,
) -> tuple[int, int]:
    """Points that lie close to a surface, and those that are near one."""
    close = near = 0
    for (one, other), tree in zip(pairs, trees, strict=True):
        _, _, distance = _laid(one, other, tree, moved, _REACHES[-1])
        close += int(np.count_nonzero(np.abs(distance) < _CLOSE))
        near += len(distance)
    return close, near


_LEAST_GAIN, _CLEAR_GAIN = 0.15, 1.5
"""Rise of the share of points that fit, from which a view is off, and how much larger than that of
any other view it is where this one is to blame."""

_FITS = 0.85
"""Share of points close to the others' surfaces from which a view is where it should be."""

_WORTH = 0.2
"""Share of that rise for which a movement is worth more freedom than a factor."""

_LEAST_SHIFT, _WRONG_SHIFT = 0.03, 0.06
"""Metres by which points have to move where a view is doubtful, and plainly wrong. Stereo matching
alone moves surfaces of plain clothes by up to 5 cm."""

_MOST_NAMED = 2
"""Views that are told where it is not clear which is wrong."""

Surfaces: TypeAlias = Sequence[Mapping[str, Surface]]
"""Measured surfaces in the world, instant by instant, by view name."""

Places: TypeAlias = Mapping[str, RigidTransform]
"""Where the rectified cameras are, by view name."""

Explanation: TypeAlias = tuple[float, str, str]
"""Metres by which the points of a view move, what is wrong about it, what to do."""


def check_displacements(
    recording: Recording, surfaces: Surfaces, places: Places
) -> Iterator[Finding]:
    """The view whose points lie beside those of the others, and how."""
    fits = {name: one for name in places if (one := _best_fit(surfaces, places, name)) is not None}
    accurate = len(places) > 2 and all(recording.view(name).kind == "depth" for name in places)
    least = _LEAST_SHIFT if accurate else _WRONG_SHIFT
    off = [name for name, one in fits.items() if _is_off(one) and one.shift > least]
    if not off:
        return
    off.sort(key=lambda name: -fits[name].gain)
    first = off[0]
    clear = len(places) > 2 and all(
        fits[first].gain > _CLEAR_GAIN * one.gain for name, one in fits.items() if name != first
    )
    named = [first] if clear else off[:_MOST_NAMED]
    told = {name: _explanation(recording, surfaces, places, name, fits[name]) for name in named}
    what = told[first][1] if clear else _either({name: one[1] for name, one in told.items()})
    shift = max(one[0] for one in told.values())
    if clear and shift < least:
        return
    severity: Severity = "error" if shift > _WRONG_SHIFT else "warning"
    where = named if len(places) > 2 else list(places)  # either of two may be wrong
    where.sort(key=list(places).index)
    yield Finding(
        severity,
        f"view{'s' if len(where) > 1 else ''} {', '.join(where)}",
        f"{what}: {100 * fits[first].before:.0f} % of the points lie within 2 cm of the other "
        f"views' surfaces, {100 * fits[first].after:.0f} % with this corrected",
        " ".join(one[2] for one in told.values()),
    )


def _either(told: Mapping[str, str]) -> str:
    """One sentence of what may be wrong about several views."""
    each = " or ".join(f"of view {name} {what}" for name, what in told.items())
    return f"their depths do not fit, and it cannot be told which view is wrong: {each}"


def _is_off(fit: CloudFit) -> bool:
    return fit.gain > _LEAST_GAIN and fit.shift > _LEAST_SHIFT


def _best_fit(surfaces: Surfaces, places: Places, view: str) -> CloudFit | None:
    """The better of a free movement and a factor, which is found from farther away."""
    free = fit_view(surfaces, places, view)
    if free is not None and free.before > _FITS and free.gain < _LEAST_GAIN:
        return free  # what lies there already need not be searched for
    factor = fit_view(surfaces, places, view, "range")
    known = [one for one in (free, factor) if one is not None]
    return max(known, key=lambda one: one.gain, default=None)


def fit_view(surfaces: Surfaces, places: Places, view: str, way: Way = "any") -> CloudFit | None:
    """How a view's points would have to be moved to lie on those of the other views."""
    seen = [one for one in surfaces if view in one]
    own = [Surface(one[view].points[::2], one[view].normals[::2]) for one in seen]
    rest = [joined([s for name, s in one.items() if name != view]) for one in seen]
    return fit_clouds(own, rest, places[view].translation, way)


def _explanation(
    recording: Recording, surfaces: Surfaces, places: Places, view: str, fit: CloudFit
) -> Explanation:
    """Possible fault of a view whose points lie beside those of the others."""
    factor = fit_view(surfaces, places, view, "range")
    if factor is None or factor.after < fit.after - _WORTH * fit.gain:
        return (
            fit.shift,
            f"the camera is turned, or displaced by {100 * fit.shift:.0f} cm",
            f"Calibrate the place of view {view} again, and check that it is synchronised.",
        )
    stereo = recording.view(view).kind == "stereo"
    part = "focal length or base line" if stereo else "depth_unit or focal length"
    size = "large" if factor.amount < 1 else "small"
    return (
        factor.shift,
        f"the distances are too {size} by {abs(100 * (1 / factor.amount - 1)):.0f} %",
        f"The {part} of view {view} is probably wrong by this factor: multiply it by "
        f"{factor.amount:.3f}.",
    )
