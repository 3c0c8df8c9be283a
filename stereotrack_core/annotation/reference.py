"""A trajectory taken as truth that states how good it is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory


@dataclass(frozen=True, eq=False)
class Reference:
    """A trajectory taken as truth, and how good it is; F frames, n landmarks.

    Attributes
    ----------
    frame : (F,) int64
        Ascending.
    points : (F, n, 3) float64, world, metres
        NaN where not known.
    covariance : (F, n, 3, 3) float64, square metres, or None
        Of each landmark's position.
    limb_sigma_deg : (F, 6) float64 or None
        Root mean square angle by which each limb may be off, in the order of ``LIMBS``.
    filled : (F,) bool or None
        Frames that nobody annotated, filled in between annotated ones.
    landmark_names : tuple of str
    meta : mapping
        How it was made; JSON-serialisable.
    """

    frame: IntArray
    points: FloatArray
    covariance: FloatArray | None = None
    limb_sigma_deg: FloatArray | None = None
    filled: BoolArray | None = None
    landmark_names: tuple[str, ...] = LANDMARKS
    meta: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        frames, landmarks = len(self.frame), len(self.landmark_names)
        shapes: dict[str, tuple[Any, tuple[int, ...]]] = {
            "points": (self.points, (frames, landmarks, 3)),
            "covariance": (self.covariance, (frames, landmarks, 3, 3)),
            "limb_sigma_deg": (self.limb_sigma_deg, (frames, 6)),
            "filled": (self.filled, (frames,)),
        }
        for name, (array, shape) in shapes.items():
            if array is not None and array.shape != shape:
                raise ValueError(f"{name} has the shape {array.shape}, expected {shape}")
        if (self.frame[1:] <= self.frame[:-1]).any():
            raise ValueError("the frames are not in ascending order")

    def trajectory(self) -> LandmarkTrajectory:
        """The nine landmarks alone, NaN where the reference does not have one of them."""
        points = np.full((len(self.frame), len(LANDMARKS), 3), np.nan)
        for i, name in enumerate(LANDMARKS):
            if name in self.landmark_names:
                points[:, i] = self.points[:, self.landmark_names.index(name)]
        return LandmarkTrajectory(self.frame, points)
