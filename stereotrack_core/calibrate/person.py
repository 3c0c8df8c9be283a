"""Cameras from clicks of a person: the same landmarks in several views, and one known length.

Two views give each other a place (essential matrix; Nistér, 2004), the landmarks that these place
give the other views theirs, and all are adjusted together. All lenses have one focal length, which
is found or given, and no distortion. How far the result can be believed is measured: by what each
half of the frames says alone, and by how well the clicks tell the focal length.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import TypeAlias

import cv2
import numpy as np
import scipy

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.calibrate.align import aligned, from_person
from stereotrack_core.calibrate.bundle import Bundle, BundleCamera, adjusted
from stereotrack_core.calibrate.lens import BROWN, Lens
from stereotrack_core.calibrate.world import FIRST_FROM_WORLD
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.geometry.triangulation import nearest_to_rays
from stereotrack_core.recording.description import Cameras
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.work import NO_WORK, Work

FEWEST = 24  # landmarks over the frames that a view has to share with another one
_FEWEST_FRAMES = 4
_SHARES = (0.55, 0.8, 1.15)  # focal lengths over the longer side to begin with
_SEARCHED = 1.45  # factor around the best of them
_STEP = 0.03  # share of the focal length by which it is changed to measure how well it is known
_LOSS_PX, _INLIER_PX = 3.0, 4.0
_ROUNDS_AT_FIRST, _ROUNDS = 10, 40
_USUAL_M = 3.0  # distance to the person while the scale is not known
_MOST_TURN_DEG, _MOST_SHIFT = 1.0, 0.03
"""Standard deviations up to which it is a calibration: rotations; places over the distance."""

_MOST_RMS = 5.0  # pixels at 480 lines


Clicks: TypeAlias = Mapping[tuple[int, str], Mapping[str, tuple[float, float]]]
"""Pixels by frame and landmark, and by camera."""


@dataclass(frozen=True)
class KnownLength:
    """Distance between two landmarks in metres."""

    first: str
    second: str
    metres: float


@dataclass(frozen=True, eq=False)
class PersonCalibration:
    """Cameras, and how far they can be believed."""

    cameras: Cameras
    rms_px: float
    clicks: int
    turn_deg: float  # standard deviation of rotations
    shift: float  # that of places, over the distance to the person

    def words(self) -> str:
        """The residual and the accuracy."""
        return (
            f"{self.clicks} clicks are met within {self.rms_px:.1f} px. The cameras are known "
            f"within {self.turn_deg:.1f}° and {100.0 * self.shift:.1f} % of their distance."
        )


@dataclass(frozen=True, eq=False)
class _Seen:
    """Landmarks clicked in two views or more: frame (P,), name, pixels (P, V, 2) or NaN; sizes."""

    frame: IntArray
    names: tuple[str, ...]
    pixels: FloatArray
    sizes: tuple[tuple[int, int], ...]


@dataclass(frozen=True, eq=False)
class _Adjusted:
    """Views and points (P, 3), NaN where unknown, by a focal length over the longer side."""

    seen: _Seen
    share: float
    bundle: Bundle
    points: FloatArray

    @property
    def cost(self) -> float:
        """Sum of squared errors in pixels, large ones counted linearly."""
        squares = np.concatenate([np.square(e).sum(axis=-1).ravel() for e in self.bundle.errors])
        far = squares > _LOSS_PX**2
        return float(np.where(far, 2 * _LOSS_PX * np.sqrt(squares) - _LOSS_PX**2, squares).sum())

    def poses(self) -> list[RigidTransform]:
        return [one.camera_from_world for one in self.bundle.cameras]

    def places(self) -> FloatArray:
        """Optical centres (V, 3)."""
        return np.array([pose.inverse().translation for pose in self.poses()])

    def only(self, rows: BoolArray) -> _Adjusted:
        seen = self.seen
        names = tuple(np.array(seen.names)[rows].tolist())
        seen = replace(seen, frame=seen.frame[rows], names=names, pixels=seen.pixels[rows])
        return replace(self, seen=seen, points=self.points[rows])

    def landmarks(self, names: Sequence[str]) -> FloatArray:
        """Points (F, n, 3) of landmarks by frame, NaN where they are unknown."""
        frames, place = np.unique(self.seen.frame, return_inverse=True)
        found = np.full((len(frames), len(names), 3), np.nan)
        for row, name in enumerate(self.seen.names):
            if name in names:
                found[place[row], names.index(name)] = self.points[row]
        return found

    def metres(self, length: KnownLength) -> float:
        """Metres of a unit of length; NaN where the length is not seen."""
        both = self.landmarks((length.first, length.second))
        apart = np.linalg.norm(both[:, 0] - both[:, 1], axis=1)
        known = apart[np.isfinite(apart)]
        return length.metres / float(np.median(known)) if len(known) else float("nan")

    def distance(self, length: KnownLength) -> float:
        """Mean distance of the views from the person, metres."""
        centre = np.nanmedian(self.points, axis=0)
        away = np.linalg.norm(self.places() - centre, axis=1).mean()
        return float(self.metres(length) * away)


def calibrate_from_person(
    clicks: Clicks,
    sizes: Mapping[str, tuple[int, int]],
    length: KnownLength,
    share: float | None = None,
    work: Work = NO_WORK,
) -> PersonCalibration:
    """Cameras of all images, whose `sizes` are width and height; upright if the person stands.

    `share` is the focal length over the longer side of an image, None to find it. Raises InputError
    that says what is missing, and Cancelled.
    """
    seen = _seen(clicks, sizes)
    _check(seen, tuple(sizes))
    best = _first(seen, (share,) if share else _SHARES, work)
    work.step(0.6, "adjusting all views")
    if not share:
        limits = best.share / _SEARCHED, best.share * _SEARCHED
        found = scipy.optimize.minimize_scalar(
            lambda own: _again(best, own).cost, bounds=limits, method="bounded",
            options={"xatol": 0.002},
        )  # fmt: skip
        best = _again(best, float(found.x))
    best = _again(best, best.share)
    work.step(0.9, "comparing halves")
    if not np.isfinite(best.metres(length)):
        what = f"no frame has the {length.first} and the {length.second} in two views"
        raise InputError(what.replace("_", " "), remedy="Click both, or choose other landmarks.")
    turn, shift = _sigmas(best, length, finds_focal=not share)
    used = int(np.isfinite(seen.pixels[..., 0]).sum())
    _refuse(best.bundle.rms * 480.0 / min(seen.sizes[0]), turn, shift, used, finds_focal=not share)
    cameras = _upright(best, tuple(sizes), best.metres(length))
    metres = shift * best.distance(length)
    cameras = {name: replace(one, place_sigma=metres) for name, one in cameras.items()}
    return PersonCalibration(cameras, best.bundle.rms, used, turn, shift)


def _seen(clicks: Clicks, sizes: Mapping[str, tuple[int, int]]) -> _Seen:
    kept = sorted((key, own) for key, own in clicks.items() if len(own.keys() & sizes.keys()) > 1)
    nowhere = (np.nan, np.nan)
    pixels = np.array([[own.get(name, nowhere) for name in sizes] for _, own in kept])
    frame = np.array([key[0] for key, _ in kept], dtype=np.int64)
    names = tuple(key[1] for key, _ in kept)
    return _Seen(frame, names, pixels.reshape(-1, len(sizes), 2), tuple(sizes.values()))


def _check(seen: _Seen, names: Sequence[str]) -> None:
    """Raise InputError that says which clicks are missing."""
    known = np.isfinite(seen.pixels[..., 0]).astype(np.int64)
    shared = known.T @ known * (1 - np.eye(len(names), dtype=np.int64))
    most = shared.max(axis=1, initial=0).tolist()
    lacks = [f"{FEWEST - n} more in {name}" for name, n in zip(names, most, strict=True)
             if n < FEWEST]  # fmt: skip
    frames = _FEWEST_FRAMES - len(np.unique(seen.frame))
    if frames > 0:
        lacks.append(f"{frames} more frames")
    if lacks:
        raise InputError(
            f"there are too few clicks: {', '.join(lacks)}",
            remedy=f"Each view needs {FEWEST} clicks of landmarks that another view has in the "
            f"same frame, over {_FEWEST_FRAMES} frames in which the person reaches differently.",
        )


def _lens(size: tuple[int, int], share: float) -> Lens:
    values = np.zeros(BROWN.free.size)
    values[:4] = (*[share * max(size)] * 2, (size[0] - 1) / 2, (size[1] - 1) / 2)
    return Lens(BROWN, values)


def _first(seen: _Seen, shares: Sequence[float], work: Work) -> _Adjusted:
    """The best of some focal lengths and all pairs of views to begin with."""
    found: list[_Adjusted] = []
    for k, share in enumerate(shares):
        lenses = [_lens(size, share).values for size in seen.sizes]
        centre, focal = (
            np.array([one[part] for one in lenses]) for part in (np.s_[2:4], np.s_[:2])
        )
        rays = (seen.pixels - centre) / focal
        for pair in combinations(range(len(seen.sizes)), 2):
            work.step(0.6 * k / len(shares), "placing the views")
            poses = _placed(rays, pair, _INLIER_PX / float(focal.mean()))
            if poses is not None:
                points = _points(rays, dict(enumerate(poses)))
                found.append(_adjusted(seen, share, poses, points, _ROUNDS_AT_FIRST))
    if not found:
        remedy = "Check that left and right are the same in all views, and click more frames."
        raise InputError("the views cannot be placed by these clicks", remedy=remedy)
    return min(found, key=lambda one: one.cost)


def _placed(rays: FloatArray, pair: tuple[int, int], limit: float) -> list[RigidTransform] | None:
    """Poses camera_from_first from undistorted places (P, V, 2), a pair of views first."""
    known = np.isfinite(rays[..., 0])
    both = known[:, pair[0]] & known[:, pair[1]]
    if both.sum() < FEWEST // 2:
        return None
    a, b = (np.ascontiguousarray(rays[both, view]) for view in pair)
    essential, inlier = cv2.findEssentialMat(a, b, np.eye(3), cv2.RANSAC, 0.9999, limit)
    if essential is None or essential.shape != (3, 3):
        return None
    _, rotation, shift, _ = cv2.recoverPose(essential, a, b, np.eye(3), mask=inlier)
    poses = {pair[0]: RigidTransform.identity(), pair[1]: _transform(rotation, shift)}
    while len(poses) < rays.shape[1]:
        points = _points(rays, poses)
        there = known & np.isfinite(points[:, :1])
        view = max(set(range(rays.shape[1])) - poses.keys(), key=lambda v: int(there[:, v].sum()))
        rows = there[:, view]
        if rows.sum() < FEWEST // 4:
            return None
        done, turn, shift, _ = cv2.solvePnPRansac(
            points[rows], np.ascontiguousarray(rays[rows, view]), np.eye(3), None,
            flags=cv2.SOLVEPNP_SQPNP, reprojectionError=2.0 * limit,
        )  # fmt: skip
        if not done:
            return None
        poses[view] = _transform(cv2.Rodrigues(turn)[0], shift)
    placed = {view: poses[view] @ poses[0].inverse() for view in range(len(poses))}
    unit = _USUAL_M / np.nanmedian(np.linalg.norm(_points(rays, placed), axis=1))
    return [RigidTransform(one.rotation, one.translation * unit) for one in placed.values()]


def _transform(rotation: object, shift: object) -> RigidTransform:
    return RigidTransform(np.array(rotation, np.float64), np.array(shift, np.float64).ravel())


def _points(rays: FloatArray, poses: Mapping[int, RigidTransform]) -> FloatArray:
    """Points (P, 3) by the views that are placed."""
    ahead = np.concatenate([rays, np.ones_like(rays[..., :1])], axis=2)
    directions = np.stack([ahead[:, view] @ own.rotation for view, own in poses.items()], axis=1)
    directions /= np.linalg.norm(directions, axis=2, keepdims=True)
    return nearest_to_rays(np.array([p.inverse().translation for p in poses.values()]), directions)


def _again(start: _Adjusted, share: float) -> _Adjusted:
    return _adjusted(start.seen, share, start.poses(), start.points, _ROUNDS)


def _adjusted(
    seen: _Seen, share: float, poses: Sequence[RigidTransform], points: FloatArray, rounds: int
) -> _Adjusted:
    """Adjust views and points; a point is a board of one corner, whose rotation stays."""
    rows = np.flatnonzero(np.isfinite(points).all(axis=1))
    cameras = []
    for view, (size, pose) in enumerate(zip(seen.sizes, poses, strict=True)):
        pixels, lens = seen.pixels[rows, view], _lens(size, share)
        own = np.flatnonzero(np.isfinite(pixels[:, 0]))
        fixed = np.zeros(lens.values.size, dtype=np.bool_)
        cameras.append(BundleCamera(lens, pose, own, pixels[own][:, None], fixed, view > 0))
    boards = [RigidTransform(np.eye(3), point) for point in points[rows]]
    bundle = adjusted(cameras, boards, np.zeros((1, 3)), loss_scale=_LOSS_PX, rounds=rounds)
    found = np.full_like(points, np.nan)
    found[rows] = [board.translation for board in bundle.boards]
    return _Adjusted(seen, share, bundle, found)


def _sigmas(best: _Adjusted, length: KnownLength, *, finds_focal: bool) -> tuple[float, float]:
    """Standard deviations of rotations in degrees, and of places over the distance."""
    frames = np.unique(best.seen.frame)
    parts = (np.isin(best.seen.frame, half) for half in (frames[::2], frames[1::2]))
    one, two = (_again(best.only(part), best.share) for part in parts)
    off = _apart(one, two, length)
    if finds_focal:
        less, more = (_again(best, best.share * factor) for factor in (1.0 - _STEP, 1.0 + _STEP))
        unknowns = 3 * len(best.points) + 6 * (len(best.seen.sizes) - 1)
        variance = best.cost / max(int(np.isfinite(best.seen.pixels).sum()) - unknowns, 1)
        curvature = max(less.cost + more.cost - 2.0 * best.cost, 1e-9)
        off = np.hypot(off, np.sqrt(2.0 * variance / curvature) * _apart(less, more, length))
    turn, shift = off.tolist()
    return turn, shift


def _apart(one: _Adjusted, two: _Adjusted, length: KnownLength) -> FloatArray:
    """Half of what two results differ by; of two halves of the data, the deviation of all."""
    places = one.metres(length) * one.places(), two.metres(length) * two.places()
    shift = np.linalg.norm(places[0] - places[1], axis=1)[1:] / one.distance(length)
    pairs = zip(one.poses()[1:], two.poses()[1:], strict=True)
    cosines = [(np.trace(a.rotation.T @ b.rotation) - 1.0) / 2.0 for a, b in pairs]
    turn = np.degrees(np.arccos(np.clip(cosines, -1.0, 1.0)))
    return np.array([np.sqrt(np.mean(np.square(off))) / 2.0 for off in (turn, shift)])


def _refuse(rms: float, turn: float, shift: float, clicks: int, *, finds_focal: bool) -> None:
    """Raise InputError where the clicks do not make a calibration; `rms` at 480 lines."""
    if rms > _MOST_RMS:
        raise InputError(
            f"the clicks contradict each other: they are missed by {rms:.1f} px of 480 lines",
            remedy="Check that left and right are the same in all views, that frames of all views "
            "are of the same instant, and that all cameras have the same zoom.",
        )
    worst = max(turn / _MOST_TURN_DEG, shift / _MOST_SHIFT)
    if not worst <= 1.0:
        more = (
            f"About {clicks * (worst**2 - 1.0):.0f} more clicks" if worst < 5.0 else "More clicks"
        )
        focal = "; or give the focal length" if finds_focal else ""
        raise InputError(
            f"{clicks} clicks tell the cameras within {turn:.1f}° and {100.0 * shift:.1f} % only",
            remedy=f"{more} are needed for {_MOST_TURN_DEG:g}° and {100.0 * _MOST_SHIFT:g} %, "
            f"best where the person stands elsewhere or reaches far{focal}.",
        )


def _upright(best: _Adjusted, names: Sequence[str], metres: float) -> dict[str, Camera]:
    """The cameras in metres; z is up as the person stands, or else as in the first image."""
    cameras = {
        name: one.lens.camera(name, size, RigidTransform(pose.rotation, metres * pose.translation))
        for name, size, one, pose in zip(
            names, best.seen.sizes, best.bundle.cameras, best.poses(), strict=True
        )
    }
    try:
        world = from_person(metres * best.landmarks(LANDMARKS)).new_from_old
    except InputError:  # hips or shoulders are missing, or the person lies
        world = FIRST_FROM_WORLD.inverse()
    return aligned(cameras, world)
