"""Somebody who holds a T pose stands upright: what the surface alone cannot tell.

A trunk that leans and a trunk whose middle lies farther in front of its joints look the same.
Motion capture settles this by a static trial; here the first frames are one where they show a
T pose.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.body.skeleton import TORSO, UPPER_ARMS

_LEAN, _LEAN_SIGMA = np.radians(2.0), np.radians(1.0)
"""Radians by which the line from the hips to the shoulders leans forward in people who stand, and
their spread: shoulder joints lie a little in front of hip joints."""

_LEVEL = np.cos(np.radians(30.0))
_ERECT = np.cos(np.radians(12.0))
"""Cosines of the largest angles of arms from sideways and of the trunk from vertical."""


@dataclass(frozen=True, eq=False)
class UprightResidual:
    """Components of the trunk's long axis along two horizontal directions.

    Attributes
    ----------
    across : (2, 3) float64, world
        Unit vectors to the person's right and forward.
    measured, variance : (2,) float64
    """

    across: FloatArray
    measured: FloatArray
    variance: FloatArray

    def predicted(self, frames: PartFrames) -> FloatArray:
        """Components (S, 2) for stacked poses."""
        result: FloatArray = frames.rotations[:, TORSO, :, 2] @ self.across.T
        return result


def upright(pose: Pose, frames: int) -> tuple[UprightResidual, ...]:
    """One row pair for a pose that is a T pose, none for any other.

    Parameters
    ----------
    pose : Pose
    frames : int
        Of the same person standing; all of them together count as one measurement.
    """
    torso = pose.rotations[TORSO]
    sideways = np.abs([pose.rotations[part, 0, 2] for part in UPPER_ARMS])
    if torso[2, 2] < _ERECT or sideways.min() < _LEVEL:
        return ()
    right = np.array([torso[0, 0], torso[1, 0], 0.0])
    right /= np.linalg.norm(right)
    forward = np.cross([0.0, 0.0, 1.0], right)
    measured = np.array([0.0, np.sin(_LEAN)])
    variance = np.full(2, frames * _LEAN_SIGMA**2)
    return (UprightResidual(np.stack([right, forward]), measured, variance),)
