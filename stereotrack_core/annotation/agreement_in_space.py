"""How far two readings of the same images differ in space: millimetres and degrees."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TypeAlias

import numpy as np

from stereotrack_core.annotation.agreement import Difference
from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.click_points import ClickPixels, click_pixels
from stereotrack_core.annotation.landmark_set import LandmarkSet
from stereotrack_core.arrays import FloatArray
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.rotation import angle_between

_Place: TypeAlias = Callable[[str], FloatArray]


@dataclass(frozen=True)
class AgreementInSpace:
    """Distances of a landmark, and angles of the limb that it tells, between two readings.

    Attributes
    ----------
    count : int
        Frames in which both readings place it in at least two cameras.
    median_mm, p95_mm : float
        Of the distances; NaN without a frame.
    limb_count : int
        Frames in which both readings give the limb a direction.
    median_deg, p95_deg : float
        Of the angles; NaN without a frame.
    """

    count: int
    median_mm: float
    p95_mm: float
    limb_count: int
    median_deg: float
    p95_deg: float


def _middle(at: _Place, landmark: str) -> FloatArray:
    middle: FloatArray = (at(f"left_{landmark}") + at(f"right_{landmark}")) / 2.0
    return middle


_AXES: Mapping[str, Callable[[_Place], FloatArray]] = MappingProxyType(
    {
        "torso": lambda at: _middle(at, "shoulder") - _middle(at, "hip"),
        "head": lambda at: at("head") - _middle(at, "shoulder"),
        "left_upper_arm": lambda at: at("left_elbow") - at("left_shoulder"),
        "right_upper_arm": lambda at: at("right_elbow") - at("right_shoulder"),
        "left_forearm": lambda at: at("left_hand") - at("left_elbow"),
        "right_forearm": lambda at: at("right_hand") - at("right_elbow"),
    }
)


def agreement_in_space(
    found: Iterable[Difference], cameras: Mapping[str, Camera], landmarks: LandmarkSet
) -> dict[str, AgreementInSpace]:
    """Summary for each landmark.

    Only the images in which both readings give a position are taken, so that both see with the
    same eyes.

    Parameters
    ----------
    found : iterable of Difference
    cameras : mapping from camera name to Camera
    landmarks : LandmarkSet
    """
    pairs = [one for one in found if one.apart is not None]
    first = _points([one.first for one in pairs], cameras, landmarks)
    second = _points([one.second for one in pairs], cameras, landmarks)
    distance = 1000.0 * np.linalg.norm(second.points() - first.points(), axis=-1)
    axes = {
        limb: np.degrees(angle_between(_axis(limb, first), _axis(limb, second))) for limb in _AXES
    }
    result = {}
    for place, landmark in enumerate(landmarks.landmarks):
        count, median, p95 = _statistics(distance[:, place])
        result[landmark.name] = AgreementInSpace(
            count, median, p95, *_statistics(axes[landmark.limb])
        )
    return result


def _points(
    clicks: Iterable[Click | None], cameras: Mapping[str, Camera], landmarks: LandmarkSet
) -> ClickPixels:
    there = [click for click in clicks if click is not None]
    return click_pixels(there, cameras, landmarks.names)


def _axis(limb: str, clicks: ClickPixels) -> FloatArray:
    points = clicks.points()

    def at(name: str) -> FloatArray:
        if name not in clicks.names:
            return np.full((len(points), 3), np.nan)
        place: FloatArray = points[:, clicks.names.index(name)]
        return place

    return _AXES[limb](at)


def _statistics(values: FloatArray) -> tuple[int, float, float]:
    known = values[np.isfinite(values)]
    if not len(known):
        return 0, float("nan"), float("nan")
    median, p95 = (float(value) for value in np.percentile(known, (50, 95)))
    return len(known), median, p95


def common_frames(found: Iterable[Difference]) -> tuple[Difference, ...]:
    """The differences at frames that both readings have annotated.

    A frame that only one of them has touched says nothing about how well they agree.
    """
    all_of_them = tuple(found)

    def frames(side: str) -> set[int]:
        clicks = ((one.key.frame, getattr(one, side)) for one in all_of_them)
        return {frame for frame, click in clicks if click is not None and not click.deleted}

    both = frames("first") & frames("second")
    return tuple(one for one in all_of_them if one.key.frame in both)
