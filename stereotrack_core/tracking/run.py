"""A tracked trajectory with everything needed to judge and to repeat it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory


@dataclass(frozen=True, eq=False)
class Run:
    """What tracking gave, frame by frame; F frames, n states, S stages.

    Attributes
    ----------
    frame : (F,) int64
        Frame numbers of the recording.
    landmarks : (F, 9, 3) float64, world, metres
        NaN where not tracked; in the order of ``LANDMARKS``.
    x : (F, n) float64
        State; NaN where not tracked. Metres and radians, see `state_names`.
    P : (F, n, n) float64
        Covariance of the error state.
    state_names : tuple of str
    tracked : (F,) bool
    unexplained_fraction : (F,) float64
        Of the cloud, 0 is best: mean of d^2 / (d^2 + 50 mm^2); the run file's ``coverage``.
    residual : (F,) float64, metres
        Weighted root mean square of the residuals after the last correction.
    innovation : (F,) float64
        Normalised, see :class:`Estimate`: of the points of the frame's first correction, over the
        standard deviations predicted of them.
    limb_sigma_deg : (F, 6) float64
        Standard deviation of each limb's direction, in the order of ``LIMBS``.
    limb_lost : (F, 6) float64
        Probability that the limb's direction is more than 45 deg off, in the order of ``LIMBS``;
        NaN where not known: for torso and head, and in runs of older versions.
    seconds : (F, S) float64
        Wall time of each stage.
    stage_names : tuple of str
    meta : mapping
        Program version, preset, parameters, seed, recording and its fingerprint, subject;
        JSON-serialisable.
    """

    frame: IntArray
    landmarks: FloatArray
    x: FloatArray
    P: FloatArray
    state_names: tuple[str, ...]
    tracked: BoolArray
    unexplained_fraction: FloatArray
    residual: FloatArray
    innovation: FloatArray
    limb_sigma_deg: FloatArray
    limb_lost: FloatArray
    seconds: FloatArray
    stage_names: tuple[str, ...]
    meta: Mapping[str, Any]
    landmark_names: tuple[str, ...] = LANDMARKS

    def trajectory(self) -> LandmarkTrajectory:
        """The landmarks alone."""
        return LandmarkTrajectory(self.frame, self.landmarks)
