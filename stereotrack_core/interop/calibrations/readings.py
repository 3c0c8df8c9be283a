"""Ways to read a calibration, and how well each of them fits what is known.

Written down wrongly are mostly: the rotation transposed, the transform inverted, the place of the
camera instead of the translation, and the unit of length.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.geometry.triangulation import nearest_to_rays
from stereotrack_core.interop.calibrations.evidence import (
    Evidence,
    SeenPoints,
    bones_of,
    cameras_seen,
)
from stereotrack_core.recording.camera_checks import at_one_place, common_centre
from stereotrack_core.recording.findings import PLAUSIBLE_LENGTHS_M

CONVENTIONS: Mapping[str, Callable[[FloatArray, FloatArray], RigidTransform]] = {
    "world-to-camera": RigidTransform,
    "transposed": lambda rotation, translation: RigidTransform(rotation.T, translation),
    "camera-to-world": lambda rotation, translation: RigidTransform(
        rotation, translation
    ).inverse(),
    "centre": lambda rotation, place: RigidTransform(rotation, -rotation @ place),
}
"""camera_from_world of what a file says, by the name of the convention."""

MEANINGS: Mapping[str, str] = {
    "world-to-camera": "x_camera = R x_world + t",
    "transposed": "x_camera = R^T x_world + t",
    "camera-to-world": "x_world = R x_camera + t",
    "centre": "x_camera = R (x_world - t)",
}

_PARALLEL = np.cos(np.radians(20.0))
_FACING = np.cos(np.radians(30.0))  # from the axis to what the cameras look at, at most
_NEAR = 0.2  # of the rig's width, within which two cameras count as one place
_SIDE_BY_SIDE = 0.5
_WIDEST_ERROR = 0.04  # of the image's diagonal; a reading that is farther off is wrong
_AS_GOOD, _AS_GOOD_PX = 1.3, 0.3  # of the best one's error, and pixels, that count as equal
_LEAST_IN_FRONT = 0.8
_TOLERANCE = (0.8, 1.25)  # by which clicked segments may lie outside the range of human ones

CAMERA_DISTANCE_M = (0.4, 15.0)
BASELINE_M = (0.015, 0.7)
SQUARE_M = (0.004, 0.12)


@dataclass(frozen=True)
class Fit:
    """How a convention fits: by points that were seen, and by how the cameras stand."""

    convention: str
    error_px: float  # median distance of sightings from their point; NaN where none was seen
    in_front: float  # share of the sightings that lie before their camera; NaN where none was seen
    in_order: bool | None
    """Whether the cameras look at one place, and left ones stand left; None where nobody can say"""


def fit_of(convention: str, cameras: Mapping[str, Camera], evidence: Evidence) -> Fit:
    """Try a convention, whose cameras are given, on everything that is known."""
    errors, front = [], []
    for seen in evidence.seen:
        points = triangulated(seen, cameras)
        for camera, pixels in zip(cameras_seen(seen, cameras), seen.pixels, strict=True):
            known = np.isfinite(pixels).all(axis=-1) & np.isfinite(points).all(axis=-1)
            depth = camera.camera_from_world.apply(points[known])[:, 2]
            front.append(depth > 0)
            away = np.linalg.norm(camera.project(points[known]) - pixels[known], axis=-1)
            errors.append(np.where(np.isfinite(away), away, np.inf))
    error, ahead = (np.concatenate(one) if one else np.empty(0) for one in (errors, front))
    return Fit(
        convention,
        float(np.median(error)) if error.size else float("nan"),
        float(ahead.mean()) if ahead.size else float("nan"),
        _in_order(cameras, evidence.pairs),
    )


def triangulated(seen: SeenPoints, cameras: Mapping[str, Camera]) -> FloatArray:
    """Points (N, 3) in the world of cameras; NaN where their rays are parallel."""
    chosen = cameras_seen(seen, cameras)
    origins = np.array([camera.position_world for camera in chosen])
    rays = [camera.rays_world(own) for camera, own in zip(chosen, seen.pixels, strict=True)]
    return nearest_to_rays(origins, np.stack(rays, axis=1))


def fits(one: Fit, best_px: float, diagonal: float) -> bool:
    """Whether the points that were seen allow a convention."""
    limit = min(_AS_GOOD * best_px + _AS_GOOD_PX, _WIDEST_ERROR * diagonal)
    return one.error_px <= limit and one.in_front >= _LEAST_IN_FRONT


def viewpoints(cameras: Mapping[str, Camera]) -> dict[str, Camera]:
    """One camera of each place: of two beside each other that look the same way, the first."""
    spans = [_apart(a, b) for a, b in combinations(cameras.values(), 2)]
    width = max(spans, default=0.0)
    kept: dict[str, Camera] = {}
    for name, camera in cameras.items():
        if not any(
            _apart(camera, other) < _NEAR * width and _same_way(camera, other)
            for other in kept.values()
        ):
            kept[name] = camera
    return kept


def _apart(a: Camera, b: Camera) -> float:
    return float(np.linalg.norm(a.position_world - b.position_world))


def _faces(camera: Camera, point: FloatArray) -> bool:
    way = camera.camera_from_world.apply(point)
    return bool(way[2] > _FACING * float(np.linalg.norm(way)))


def _same_way(a: Camera, b: Camera) -> bool:
    axes = a.camera_from_world.rotation[2], b.camera_from_world.rotation[2]
    return bool(axes[0] @ axes[1] > _PARALLEL)


def _in_order(cameras: Mapping[str, Camera], pairs: Sequence[tuple[str, str]]) -> bool | None:
    for left, right in pairs:
        offset = cameras[right].camera_from_world.apply(cameras[left].position_world)
        if not -offset[0] > _SIDE_BY_SIDE * float(np.linalg.norm(offset)):
            return False
    apart = viewpoints(cameras)
    if len(apart) < 2 or (len(apart) == 2 and _same_way(*apart.values())):
        return True if pairs else None
    if at_one_place(apart):
        return False
    centre = common_centre(apart)
    if not all(_faces(camera, centre) for camera in apart.values()):
        return False
    # two cameras alone look at one place in other conventions as well
    return True if len(apart) > 2 or pairs else None


@dataclass(frozen=True)
class Scale:
    """What a rig measures in a unit: lengths in metres, and whether all of them are possible."""

    unit: str
    lengths: tuple[tuple[str, float], ...]
    possible: bool | None  # None where nothing could be measured
    measured: bool  # whether a person's segments are among them


def lengths_of(
    cameras: Mapping[str, Camera], evidence: Evidence, square: float | None
) -> dict[str, float]:
    """Lengths of a rig, in its own unit, that people know the size of."""
    bones: dict[str, list[float]] = {}
    for seen in evidence.seen:
        for name, length in bones_of(seen, triangulated(seen, cameras)).items():
            bones.setdefault(name, []).append(length)
    if len(bones) > 1:
        return {name: float(np.median(found)) for name, found in bones.items()}
    lengths: dict[str, float] = {}
    if square is not None:
        lengths["square of the board"] = square
    apart = viewpoints(cameras)
    if len(apart) >= 2 and not (len(apart) == 2 and _same_way(*apart.values())):
        centre = common_centre(apart)
        away = [float(np.linalg.norm(one.position_world - centre)) for one in apart.values()]
        lengths["distance of the cameras"] = float(np.median(away))
    elif len(apart) == 2:
        lengths["base line"] = _apart(*apart.values())
    base = [_apart(cameras[left], cameras[right]) for left, right in evidence.pairs]
    if base:
        lengths["base line"] = float(np.median(base))
    return {name: length for name, length in lengths.items() if np.isfinite(length)}


def scale_of(unit: str, metres: float, lengths: Mapping[str, float]) -> Scale:
    """Try a unit of so many metres on lengths of a rig."""
    found, possible, measured = [], [], False
    for name, length in lengths.items():
        low, high = _KNOWN_M.get(name, (0.0, np.inf))
        if name in PLAUSIBLE_LENGTHS_M:
            measured = True
            low, high = PLAUSIBLE_LENGTHS_M[name]
            low, high = low * _TOLERANCE[0], high * _TOLERANCE[1]
        found.append((name.replace("_", " "), length * metres))
        possible.append(low <= length * metres <= high)
    return Scale(unit, tuple(found), all(possible) if possible else None, measured)


_KNOWN_M = {
    "square of the board": SQUARE_M,
    "distance of the cameras": CAMERA_DISTANCE_M,
    "base line": BASELINE_M,
}


def moved(cameras: Mapping[str, Camera], metres: float) -> dict[str, Camera]:
    """The same cameras with the lengths of their places multiplied."""
    return {
        name: replace(
            camera,
            camera_from_world=RigidTransform(
                camera.camera_from_world.rotation, camera.camera_from_world.translation * metres
            ),
        )
        for name, camera in cameras.items()
    }
