"""What the fit says: of one frame, and of a whole trajectory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stereotrack_core.annotation.click import ClickKey
from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.pose import Pose
from stereotrack_core.recording.landmarks import LandmarkTrajectory

CLICKED, INTERPOLATED, GAP = "clicked", "interpolated", "gap"
"""Kinds of frames: with clicks of their own, filled between them, nothing known."""

MISTAKEN = 0.5
"""A click is flagged where it is more probably a gross mistake than not."""


@dataclass(frozen=True, eq=False)
class FrameFit:
    """The body fitted to the clicks of one frame.

    Attributes
    ----------
    pose : Pose
    covariance : (n, n) float64
        Of the error state: the pose's numbers first (see :mod:`body.manifold`), then the
        freedom of the joints and landmarks.
    landmarks_world : (L, 3) float64, metres
        In the order of the set of landmarks.
    landmark_covariance : (L, 3, 3) float64, square metres, world
    residual_px : (M, 2) float64
        Click minus fitted place, raw pixels, in the order of the measurements.
    leverage : (M,) float64
        0: the rest decides where the landmark is in this picture; 1: this click alone does.
    mistake : (M,) float64
        Probability that the click is a gross mistake.
    limb_sigma_deg : (6,) float64
        Root mean square angle by which each limb may be off, in the order of ``LIMBS``.
    used_cameras : (L,) int64
        Cameras in which a landmark has a click that is probably no mistake.
    words : tuple of str
        What a person should know, most important first.
    sigma_factor : float
        By which factor the clicks are taken to scatter more than their sigma; 1 where they do not.
    """

    pose: Pose
    covariance: FloatArray
    landmarks_world: FloatArray
    landmark_covariance: FloatArray
    residual_px: FloatArray
    leverage: FloatArray
    mistake: FloatArray
    limb_sigma_deg: FloatArray
    used_cameras: IntArray
    words: tuple[str, ...] = ()
    sigma_factor: float = 1.0


@dataclass(frozen=True, eq=False)
class TrajectoryFit:
    """The body fitted to clicks over frames, forward and backward.

    Attributes
    ----------
    names : tuple of str
        Landmarks, in the order of the arrays.
    frame : (F,) int64
    landmarks : (F, L, 3) float64, world, metres
        NaN where nothing is known.
    covariance : (F, L, 3, 3) float64, square metres, world
    limb_sigma_deg : (F, 6) float64
        In the order of ``LIMBS``.
    kind : (F,) str
        ``clicked``, ``interpolated`` or ``gap``.
    nine : (F, 9, 3) float64, world, metres
        The landmarks of every reference, whatever set was clicked.
    residual_px : mapping from ClickKey to (2,) float64
        Click minus fitted place, raw pixels.
    mistake : mapping from ClickKey to float
        Probability that the click is a gross mistake.
    sigma_factor : float
        By what the clicks scatter more than their sigmas say.
    """

    names: tuple[str, ...]
    frame: IntArray
    landmarks: FloatArray
    covariance: FloatArray
    limb_sigma_deg: FloatArray
    kind: NDArray[np.str_]
    nine: FloatArray
    residual_px: Mapping[ClickKey, FloatArray]
    mistake: Mapping[ClickKey, float]
    sigma_factor: float = 1.0

    def trajectory(self) -> LandmarkTrajectory:
        """The nine landmarks, as a reference holds them."""
        return LandmarkTrajectory(self.frame, self.nine)

    def flagged(self) -> tuple[ClickKey, ...]:
        """Clicks that are more probably gross mistakes than not, in their order."""
        return tuple(sorted(key for key, p in self.mistake.items() if p > MISTAKEN))
