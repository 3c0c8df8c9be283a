"""Does the reference belong to what the views measure? Its limbs against the points of the person.

A limb lies within the flesh, a few centimetres from a measured surface. Elsewhere other axes and
instants are tried in turn.
"""

from __future__ import annotations  # a window that starts loads no scipy.spatial

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.depth.cloud import ViewDepth
from stereotrack_core.doctor.views import Instants, Places
from stereotrack_core.errors import Finding
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory

_AT = {name: i for i, name in enumerate(LANDMARKS)}
_ENDS = (("shoulder", "elbow"), ("elbow", "hand"), ("hip", "shoulder"))
_PARTS = tuple((f"{side}_{a}", f"{side}_{b}") for side in ("left", "right") for a, b in _ENDS)
_ALONG = np.array([0.0, 1 / 3, 2 / 3, 1.0])  # where on a part its points are
_FARTHEST = 0.3  # metres as which larger distances count
_HIDDEN = 0.2  # metres behind a measured surface from which a point is hidden by it
_FEWEST = 20  # points without which nothing is said
_FITS, _FITS_MOVING, _WRONG = 0.075, 0.1, 0.12
"""Metres from bones to surfaces where a reference may be wrong, the same for limbs that move, which
loose clothes and half a frame of delay bring to 8 cm, and where it plainly is."""

_MENDS = 0.06  # metres that a correction in time may leave; another person leaves more
_MENDED = 0.7  # share of the distance that a correction has to leave at most
_LONGEST_LAG, _LEAST_LAG = 15, 2
_LEAST_MOTION = 0.12  # metres within the lags from which a point says something about time
_LEAST_WORTH = 0.015  # metres by which a shift in time has to bring moving limbs nearer
_BACKWARD = -0.02  # metres of hands and head before the shoulders; less: sides are exchanged


_AXES: Mapping[str, tuple[str, str, str]] = {
    "its y axis points up: z must point up": ("x", "-z", "y"),
    "its y axis points down: z must point up": ("x", "z", "-y"),
    "its x axis points up: z must point up": ("z", "y", "-x"),
    "x and y are exchanged": ("y", "x", "z"),
}
"""Errors of the axes of a reference, and the axes to write as x, y and z instead."""


@dataclass(frozen=True, eq=False)
class Body:
    """The person as measured by the views at one instant."""

    frame: int
    tree: scipy.spatial.cKDTree
    unknown: Callable[[FloatArray], BoolArray]  # which of points (N, 3), world, no view knows


def bodies(instants: Instants, places: Places, frames: Sequence[int]) -> Sequence[Body]:
    """The instants, of these frames, at which any view measured the person."""
    found = []
    for frame, seen in zip(frames, instants, strict=True):
        placed = {name: one for name, one in seen.items() if name in places}
        if not placed:
            continue
        points = np.concatenate([one.placed(places[name]) for name, one in placed.items()])
        depths = [
            replace(one.depth, geometry=replace(one.depth.geometry, world_from_depth=places[name]))
            for name, one in placed.items()
        ]

        def unknown(points: FloatArray, depths: Sequence[ViewDepth] = depths) -> BoolArray:
            missed = [_unknown_to(one, points) for one in depths]
            return np.asarray(np.all(missed, axis=0), dtype=bool)

        found.append(Body(frame, scipy.spatial.cKDTree(points), unknown))
    return found


def _unknown_to(depth: ViewDepth, points: FloatArray) -> BoolArray:
    """Mask of points (N, 3) that a view does not measure: hidden by the person, or no depth."""
    with np.errstate(divide="ignore", invalid="ignore"):
        u, v, z = depth.geometry.project(points)
    height, width = depth.range_z.shape
    inside = (z > 0) & (u >= 0) & (u < width - 0.5) & (v >= 0) & (v < height - 0.5)
    column, row = (np.where(inside, np.rint(np.nan_to_num(a)), 0).astype(int) for a in (u, v))
    measured = depth.range_z[row, column]
    hidden = depth.foreground[row, column] & (measured < z - _HIDDEN)
    if depth.geometry.baseline > 0:  # stereo often fails on plain clothes and walls
        hidden |= np.isnan(measured)
    return np.asarray(inside & hidden, dtype=bool)


def limbs_of(points: FloatArray) -> FloatArray:
    """Points (F, N, 3) along limbs and trunk of landmarks (F, 9, 3)."""
    parts = [
        points[:, None, _AT[a]] * (1 - _ALONG)[:, None] + points[:, None, _AT[b]] * _ALONG[:, None]
        for a, b in _PARTS
    ]
    return np.concatenate(parts, axis=1)


def limb_fit(
    measured: Sequence[Body], limbs: FloatArray, frame: IntArray, late: int = 0
) -> tuple[float, float]:
    """Mean distance of limbs (F, N, 3) at frames (F,) from the surface, taken as late by some
    frames, and the root mean square of points that move, which tells instants apart more sharply.

    Metres, each distance at most 0.3; NaN where there are too few points.
    """
    at = {int(k): i for i, k in enumerate(frame)}
    values, moving = [np.zeros(0)], [np.zeros(0, dtype=bool)]
    for body in measured:
        i = at.get(body.frame + late)
        if i is None:
            continue
        known = np.isfinite(limbs[i]).all(axis=1)
        points = limbs[i, known]
        seen = ~body.unknown(points)
        distance, _ = body.tree.query(points[seen])
        values.append(np.minimum(distance, _FARTHEST))
        moving.append(_moves(limbs, i)[known][seen])
    every = np.concatenate(values)
    some = every[np.concatenate(moving)]
    return (
        float(every.mean()) if len(every) >= _FEWEST else float("nan"),
        float(np.sqrt(np.mean(some**2))) if len(some) >= _FEWEST else float("nan"),
    )


def _moves(limbs: FloatArray, i: int) -> BoolArray:
    """Mask of points (N,) that are elsewhere some frames before or after."""
    near = limbs[max(0, i - 8) : i + 9 : 2]
    away = np.linalg.norm(near - limbs[i], axis=2)
    with np.errstate(invalid="ignore"):
        return np.asarray((away > _LEAST_MOTION).any(axis=0))


def check_reference(recording: Recording, measured: Sequence[Body]) -> Iterator[Finding]:
    """Findings about the reference, by what the views measured."""
    reference = recording.reference
    if reference is None or not np.isfinite(reference.points).any():
        return
    found = _misplaced(reference, measured, recording.fps)
    yield from check_sides(reference) if found is None else (found,)


def _misplaced(
    reference: LandmarkTrajectory, measured: Sequence[Body], fps: float
) -> Finding | None:
    """The finding about place and time, by how far the limbs lie from the measured person."""
    frame, limbs = reference.frame, limbs_of(reference.points)
    mean, moving = limb_fit(measured, limbs, frame)
    if (late := _late(measured, limbs, frame)) is not None:
        _, then = limb_fit(measured, limbs, frame, late)
        frames = f"{abs(late)} frames ({1000 * abs(late) / fps:.0f} ms)"
        return Finding(
            "error" if abs(late) > _LEAST_LAG else "warning",
            "reference.csv",
            f"it is {frames} {'late' if late > 0 else 'early'}: limbs that move lie "
            f"{_cm(moving)} from the measured person",
            f"Make its frame numbers {'smaller' if late > 0 else 'larger'} by about {abs(late)} "
            f"(tested: then they lie {_cm(then)} from it).",
        )
    if not (mean > _FITS or moving > _FITS_MOVING) or np.isnan(mean):
        return None
    beside = f"its limbs lie {_cm(mean)} from the measured person"
    for axis, axes in _AXES.items():
        changed, _ = limb_fit(measured, limbs_of(_turned(reference.points, axes)), frame)
        if changed < min(_FITS, _MENDED * mean):
            tested = f"tested: then they lie {_cm(changed)} from it"
            remedy = f"Write {', '.join(axes)} for x, y, z ({tested})."
            return Finding("error", "reference.csv", f"{axis}; {beside}", remedy)
    if np.isfinite(moving):
        beside = f"{beside}, and those that move {_cm(moving)}"
    return Finding(
        "error" if np.fmax(mean, moving) > _WRONG else "warning",
        "reference.csv",
        f"{beside} (less than 5 cm usually)",
        "It may belong to another recording or another world frame: no usual slip explains it.",
    )


def _turned(points: FloatArray, axes: tuple[str, str, str]) -> FloatArray:
    """Points (..., 3) with these coordinates, such as ``-z``, for x, y and z."""
    return np.stack(
        [points[..., "xyz".index(axis[-1])] * (1 - 2 * axis.startswith("-")) for axis in axes], -1
    )


def _cm(metres: float) -> str:
    return f"{100 * metres:.0f} cm"


def _late(measured: Sequence[Body], limbs: FloatArray, frame: IntArray) -> int | None:
    """Frames by which the reference is late where it fits clearly better then; None elsewhere."""
    lags = range(-_LONGEST_LAG, _LONGEST_LAG + 1)
    moving = {late: limb_fit(measured, limbs, frame, late)[1] for late in lags}
    fits = {late: one for late, one in moving.items() if np.isfinite(one)}
    if 0 not in fits:
        return None
    best = min(fits, key=lambda late: (fits[late], abs(late)))
    clear = fits[best] < min(_MENDS, _MENDED * fits[0]) and fits[0] - fits[best] > _LEAST_WORTH
    return best if abs(best) >= _LEAST_LAG and clear else None


def check_sides(reference: LandmarkTrajectory) -> Iterator[Finding]:
    """Whether the person would look backward: hands and head are before the shoulders usually."""
    at = reference.by_name()
    across = at["right_shoulder"] - at["left_shoulder"]
    forward = np.cross([0.0, 0.0, 1.0], across)
    forward /= np.maximum(np.linalg.norm(forward, axis=1, keepdims=True), 1e-9)
    middle = (at["right_shoulder"] + at["left_shoulder"]) / 2
    before = [at["head"] - middle]
    for side in ("left", "right"):
        hand = at[f"{side}_hand"]
        before += [(hand - at[f"{side}_shoulder"]) / 2, (hand - at[f"{side}_elbow"]) / 2]
    ahead = [np.einsum("ij,ij->i", forward, one) for one in before]
    means = [float(np.nanmean(one)) for one in ahead if np.isfinite(one).any()]
    if means and sum(means) < _BACKWARD:
        behind = f"hands and head would be behind the shoulders, by {_cm(-float(np.mean(means)))}"
        what = f"left and right are exchanged: {behind} on average"
        tested = "(tested: then they are before the shoulders)"
        remedy = f"Exchange the names of left and right {tested}."
        yield Finding("error", "reference.csv", what, remedy)
