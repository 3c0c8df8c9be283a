"""Ways to read a calibration, and whether the cameras then stand as cameras of a rig do.

Written down wrongly are mostly: the rotation transposed, the transform inverted, the place of the
camera instead of the translation, and the unit of length.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import TypeAlias

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.camera_checks import at_one_place, common_centre

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

_POSSIBLE_M = {
    "square of the board": (0.004, 0.12),
    "distance of the cameras": (0.4, 15.0),
    "base line": (0.015, 0.7),
}
"""Lengths of a rig that people know the size of: smallest and largest, in metres."""

Pairs: TypeAlias = Sequence[tuple[str, str]]
"""Names of the left and right cameras of stereo views."""


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


def in_order(cameras: Mapping[str, Camera], pairs: Pairs) -> bool | None:
    """Whether the cameras look at one place, and left ones stand left; None if it is open."""
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


def lengths_of(
    cameras: Mapping[str, Camera], pairs: Pairs, square: float | None
) -> dict[str, float]:
    """Lengths of a rig, in its own unit, that people know the size of."""
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
    base = [_apart(cameras[left], cameras[right]) for left, right in pairs]
    if base:
        lengths["base line"] = float(np.median(base))
    return {name: length for name, length in lengths.items() if np.isfinite(length)}


def scale_of(unit: str, metres: float, lengths: Mapping[str, float]) -> Scale:
    """Try a unit of so many metres on lengths of a rig."""
    found = tuple((name, length * metres) for name, length in lengths.items())
    possible = [_POSSIBLE_M[name][0] <= size <= _POSSIBLE_M[name][1] for name, size in found]
    return Scale(unit, found, all(possible) if possible else None)


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
