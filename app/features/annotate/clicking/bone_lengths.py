"""Lengths between clicked landmarks of one frame, beside those of the subject."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.annotation.predict import PredictedPoint
from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.proportions import Proportions

_ENDS: tuple[tuple[str, str, tuple[str, ...], tuple[str, ...]], ...] = (
    ("shoulder width", "shoulder_width", ("left_shoulder",), ("right_shoulder",)),
    ("hip width", "hip_width", ("left_hip",), ("right_hip",)),
    (
        "torso",
        "torso_length",
        ("left_hip", "right_hip"),
        ("left_shoulder", "right_shoulder"),
    ),
    ("left upper arm", "upper_arm_length", ("left_shoulder",), ("left_elbow",)),
    ("right upper arm", "upper_arm_length", ("right_shoulder",), ("right_elbow",)),
    ("left elbow to hand", "elbow_to_hand", ("left_elbow",), ("left_hand",)),
    ("right elbow to hand", "elbow_to_hand", ("right_elbow",), ("right_hand",)),
    ("shoulders to head", "shoulder_to_head", ("left_shoulder", "right_shoulder"), ("head",)),
)
_DOUBTFUL = 3.0
_LEAST_SIGMA = 0.008
"""Metres that joints wander on a real body."""


@dataclass(frozen=True)
class BoneLength:
    """A length as clicked, and as the subject has it; metres.

    Attributes
    ----------
    name : str
    clicked : float
    sigma : float
        Standard deviation of it, from the clicks.
    subject : float
    """

    name: str
    clicked: float
    sigma: float
    subject: float

    @property
    def doubtful(self) -> bool:
        """Whether the difference is more than the clicks' uncertainty can explain."""
        sigma = float(np.hypot(self.sigma, _LEAST_SIGMA))
        return abs(self.clicked - self.subject) > _DOUBTFUL * sigma


def bone_lengths(
    points: Mapping[str, PredictedPoint], proportions: Proportions
) -> tuple[BoneLength, ...]:
    """Lengths whose ends have all been clicked in two views or more."""
    found = []
    for name, key, start, end in _ENDS:
        if all(landmark in points for landmark in (*start, *end)):
            first, first_covariance = _middle(points, start)
            second, second_covariance = _middle(points, end)
            between = second - first
            length = float(np.linalg.norm(between))
            unit = between / max(length, 1e-9)
            variance = float(unit @ (first_covariance + second_covariance) @ unit)
            found.append(
                BoneLength(name, length, float(np.sqrt(variance)), getattr(proportions, key))
            )
    return tuple(found)


def _middle(
    points: Mapping[str, PredictedPoint], names: Sequence[str]
) -> tuple[FloatArray, FloatArray]:
    """Mean (3,) of points and its covariance (3, 3)."""
    places = np.mean([points[name].world for name in names], axis=0)
    covariance = np.sum([points[name].covariance for name in names], axis=0) / len(names) ** 2
    return places, covariance
