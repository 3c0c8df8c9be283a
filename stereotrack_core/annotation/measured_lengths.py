"""A subject's proportions, measured from clicks."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TypeAlias

import numpy as np

from stereotrack_core.annotation.click_points import ClickPixels
from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.recording.description import Subject

FEWEST = 3
"""Frames from which on a length is told."""

_NORMAL = 1.4826
"""Standard deviation over median absolute deviation of a normal distribution."""

_Place: TypeAlias = Callable[[str], FloatArray]


@dataclass(frozen=True)
class MeasuredLength:
    """A length of the body, from many frames.

    Attributes
    ----------
    length : float
        Metres.
    sigma : float
        Standard deviation of `length`, metres.
    count : int
        Samples; both arms count.
    """

    length: float
    sigma: float
    count: int


def _middle(place: _Place, landmark: str) -> FloatArray:
    middle: FloatArray = (place(f"left_{landmark}") + place(f"right_{landmark}")) / 2.0
    return middle


def _arms(place: _Place, first: str, second: str) -> FloatArray:
    both = [place(f"{side}_{second}") - place(f"{side}_{first}") for side in ("left", "right")]
    return np.concatenate(both)


_VECTORS: Mapping[str, Callable[[_Place], FloatArray]] = MappingProxyType(
    {
        "shoulder_width": lambda at: at("right_shoulder") - at("left_shoulder"),
        "hip_width": lambda at: at("right_hip") - at("left_hip"),
        "torso_length": lambda at: _middle(at, "shoulder") - _middle(at, "hip"),
        "upper_arm_length": lambda at: _arms(at, "shoulder", "elbow"),
        "elbow_to_hand": lambda at: _arms(at, "elbow", "hand"),
        "shoulder_to_head": lambda at: at("head") - _middle(at, "shoulder"),
    }
)


def measured_lengths(clicks: ClickPixels) -> dict[str, MeasuredLength]:
    """Lengths between landmarks of the nine, as far as they are clicked in enough frames.

    Returns
    -------
    dict
        ``shoulder_width``, ``hip_width``, ``torso_length``, ``upper_arm_length``,
        ``elbow_to_hand`` (the hand landmark lies half way along the hand), ``shoulder_to_head``.
    """
    points = clicks.points()

    def place(name: str) -> FloatArray:
        if name not in clicks.names:
            return np.full((len(points), 3), np.nan)
        found: FloatArray = points[:, clicks.names.index(name)]
        return found

    samples = {name: np.linalg.norm(vector(place), axis=-1) for name, vector in _VECTORS.items()}
    known = {name: values[np.isfinite(values)] for name, values in samples.items()}
    return {name: _measured(values) for name, values in known.items() if len(values) >= FEWEST}


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
    known: dict[str, float] = {key: one.length for key, one in lengths.items()}
    reach = known.pop("elbow_to_hand", None)
    if reach is not None:
        scale = reach / AVERAGE.elbow_to_hand
        known["forearm_length"] = scale * AVERAGE.forearm_length
        known["hand_length"] = scale * AVERAGE.hand_length
    return Subject(name, **known)
