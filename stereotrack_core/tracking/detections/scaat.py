"""One detection corrects the pose by itself, whenever it comes.

Single constraint at a time (Welch & Bishop 1997, DOI 10.1145/258734.258876): a single detection
does not determine the pose, but corrects it as far as it can, with the process noise of the time
that has gone by since the last one.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg
from scipy.stats import chi2

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.jacobian import columns_of
from stereotrack_core.body.manifold import difference, displaced
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import PartFrames, Pose, orthonormal
from stereotrack_core.filtering.linearisation import posterior
from stereotrack_core.recording.detections import Detection
from stereotrack_core.tracking.detections.residual import (
    distance_from,
    parts_of,
    residual_of,
)
from stereotrack_core.tracking.residuals import gathered

_ITERATIONS = 3

_STEP_LIMIT = 0.5
"""Radians and metres by which one iteration may move a number of the error state."""

_PROBABLE = 0.999
"""Share of right detections that lie inside the gate by the pose's own uncertainty."""


def corrected_by(
    detection: Detection,
    body: BodyModel,
    pose: Pose,
    P: FloatArray,
    joints: tuple[int, ...],
    gate: float,
) -> tuple[Pose, FloatArray]:
    """Correct a pose by one detection.

    Parameters
    ----------
    detection : Detection
        A hand whose side is not known is the hand that fits better.
    body : BodyModel
    pose : Pose
        Predicted for the detection's time.
    P : (n, n) float64
        Covariance of the pose's error state.
    joints : tuple of int
        Parts whose joints are in the state.
    gate : float, metres
        Farther from where it could belong, a detection changes nothing.

    Returns
    -------
    pose : Pose
    P : (n, n) float64
    """
    part = _best_part(detection, body, pose, P, joints, gate)
    if part is None:
        return pose, P
    columns, prior = columns_of(joints), pose
    P0_inverse: FloatArray = scipy.linalg.inv(P)
    for _ in range(_ITERATIONS):
        residual = residual_of(detection, part, body, body.frames(pose))
        found = gathered((residual,), body, pose, columns)
        dx, P = posterior(P0_inverse, difference(prior, pose, joints), found)
        pose = displaced(pose, np.clip(dx, -_STEP_LIMIT, _STEP_LIMIT), joints)
    return orthonormal(pose), P


def _best_part(
    detection: Detection,
    body: BodyModel,
    pose: Pose,
    P: FloatArray,
    joints: tuple[int, ...],
    gate: float,
) -> int | None:
    """Part to whose end the detection fits best by the pose's uncertainty; None beyond the gate."""
    frames, columns = body.frames(pose), columns_of(joints)
    stacked = PartFrames(frames.rotations[None], frames.origins[None])
    best, least = None, np.inf
    for part in parts_of(detection):
        if not distance_from(detection, part, body, frames) < gate:
            continue
        residual = residual_of(detection, part, body, frames)
        nu = residual.measured - residual.predicted(stacked)[0]
        J = residual.jacobian(frames, columns)
        S = J @ P @ J.T + np.eye(len(nu)) * _plain_variance(detection)
        squared = float(nu @ np.linalg.solve(S, nu))
        if squared < min(least, float(chi2.ppf(_PROBABLE, len(nu)))):
            best, least = part, squared
    return best


def _plain_variance(detection: Detection) -> float:
    """Variance before the robust weight, in the residual's unit."""
    if detection.camera is None:
        return detection.sigma**2 / detection.confidence
    scale = float(detection.camera.matrix[0, 0] / np.mean(np.diagonal(detection.camera.matrix)[:2]))
    return (scale * detection.sigma) ** 2 / detection.confidence
