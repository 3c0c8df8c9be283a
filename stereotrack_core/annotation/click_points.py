"""Clicked landmarks in space, nothing known of a body, and the proportions that they show."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from stereotrack_core.annotation.click import Click
from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.triangulation import nearest_to_rays
from stereotrack_core.recording.description import Cameras, Subject


@dataclass(frozen=True, eq=False)
class ClickPixels:
    """Positions of clicks as arrays; F frames, L landmarks, V cameras."""

    frame: IntArray  # (F,); frames that have a click, ascending
    names: tuple[str, ...]  # landmarks
    cameras: tuple[Camera, ...]
    pixel: FloatArray  # (F, L, V, 2); raw-image pixels, NaN where nobody gave a position

    def points(self) -> FloatArray:
        """Points (F, L, 3), world, nearest to each landmark's rays; NaN with fewer than two."""
        if not self.pixel.size:
            return np.full((*self.pixel.shape[:2], 3), np.nan)
        origins = np.stack([camera.position_world for camera in self.cameras])
        rays = [camera.rays_world(self.pixel[:, :, v]) for v, camera in enumerate(self.cameras)]
        return nearest_to_rays(origins, np.stack(rays, axis=2))

    def between(self, points: FloatArray, start: Sequence[str], end: Sequence[str]) -> FloatArray:
        """Vectors (F, 3) between middles of landmarks at points (F, L, 3); NaN where not known."""
        if not {*start, *end} <= set(self.names):
            return np.full((len(points), 3), np.nan)
        one, two = (
            points[:, [self.names.index(name) for name in names]].mean(axis=1)
            for names in (start, end)
        )
        return np.asarray(two - one)


def click_pixels(clicks: Iterable[Click], cameras: Cameras, names: Sequence[str]) -> ClickPixels:
    """Clicks as arrays; deleted ones, and other cameras' and landmarks', are left out."""
    places = {name: i for i, name in enumerate(names)}
    views = {name: v for v, name in enumerate(cameras)}
    kept = [
        (click.frame, places[click.landmark], views[click.camera], *click.position)
        for click in clicks
        if click.position is not None
        and not click.deleted
        and click.landmark in places
        and click.camera in views
    ]
    table = np.array(kept, dtype=np.float64).reshape(-1, 5)
    frame, rows = np.unique(table[:, 0].astype(np.int64), return_inverse=True)
    pixel = np.full((len(frame), len(places), len(views), 2), np.nan)
    pixel[rows, table[:, 1].astype(np.int64), table[:, 2].astype(np.int64)] = table[:, 3:]
    return ClickPixels(frame, tuple(names), tuple(cameras.values()), pixel)


_FEWEST = 3  # frames from which on a length is told
_NORMAL = 1.4826  # standard deviation over median absolute deviation of a normal distribution


@dataclass(frozen=True)
class MeasuredLength:
    """A length in metres, its standard deviation, and the samples of both arms behind it."""

    length: float
    sigma: float
    count: int


_SHOULDERS, _HIPS = ("left_shoulder", "right_shoulder"), ("left_hip", "right_hip")

ENDS_OF_LENGTHS: tuple[tuple[str, str, tuple[tuple[str, ...], tuple[str, ...]]], ...] = (
    ("shoulder width", "shoulder_width", (("left_shoulder",), ("right_shoulder",))),
    ("hip width", "hip_width", (("left_hip",), ("right_hip",))),
    ("torso", "torso_length", (_HIPS, _SHOULDERS)),
    ("left upper arm", "upper_arm_length", (("left_shoulder",), ("left_elbow",))),
    ("right upper arm", "upper_arm_length", (("right_shoulder",), ("right_elbow",))),
    ("left elbow to hand", "elbow_to_hand", (("left_elbow",), ("left_hand",))),
    ("right elbow to hand", "elbow_to_hand", (("right_elbow",), ("right_hand",))),
    ("shoulders to head", "shoulder_to_head", (_SHOULDERS, ("head",))),
)
"""Lengths: name, the name that a subject has for it, landmarks at both ends, of two the middle."""


def measured_lengths(clicks: ClickPixels) -> dict[str, MeasuredLength]:
    """Lengths of a subject's names, and ``elbow_to_hand``, that are clicked in enough frames."""
    points = clicks.points()
    samples: dict[str, list[float]] = {}
    for _, name, ends in ENDS_OF_LENGTHS:
        lengths = np.linalg.norm(clicks.between(points, *ends), axis=-1)
        samples.setdefault(name, []).extend(lengths[np.isfinite(lengths)].tolist())
    return {name: _measured(np.array(own)) for name, own in samples.items() if len(own) >= _FEWEST}


def lengths_of_clicks(
    clicks: Iterable[Click], cameras: Cameras, names: Sequence[str], where: str
) -> dict[str, MeasuredLength]:
    """The :func:`measured_lengths` of clicks; InputError where none can be told."""
    lengths = measured_lengths(click_pixels(clicks, cameras, names))
    if not lengths:
        remedy = "Click both ends of a limb in at least two views of three frames."
        raise InputError("too few clicks to measure a length", where, remedy)
    return lengths


def _measured(samples: FloatArray) -> MeasuredLength:
    """Median, less what noise adds: sideways noise of variance s^2 makes L look s^2 / L longer."""
    median = float(np.median(samples))
    spread = _NORMAL * float(np.median(np.abs(samples - median)))
    length = 0.5 * (median + math.sqrt(max(median**2 - 4.0 * spread**2, 0.0)))
    # the median of n samples scatters by sqrt(pi / 2 n) times their standard deviation
    sigma = math.sqrt(math.pi / (2.0 * len(samples))) * spread
    return MeasuredLength(length, sigma, len(samples))


def subject_of(name: str, lengths: Mapping[str, MeasuredLength]) -> Subject:
    """The subject with these lengths; elbow to hand is shared out as in an average arm."""
    known: dict[str, Any] = {key: one.length for key, one in lengths.items()}
    reach = known.pop("elbow_to_hand", None)
    if reach is not None:
        scale = reach / AVERAGE.elbow_to_hand
        known["forearm_length"] = scale * AVERAGE.forearm_length
        known["hand_length"] = scale * AVERAGE.hand_length
    return Subject(name, **known)
