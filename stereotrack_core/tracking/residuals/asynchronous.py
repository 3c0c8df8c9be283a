"""One detection corrects the pose by itself, whenever it comes.

Single constraint at a time (Welch & Bishop 1997, DOI 10.1145/258734.258876): a single detection
does not determine the pose, but corrects it as far as it can, with the process noise of the time
that has gone by since the last one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.stats import chi2

from stereotrack_core.body.pose import PartFrames, orthonormal
from stereotrack_core.recording.detections import Detection
from stereotrack_core.tracking.correction import gathered, solved
from stereotrack_core.tracking.residuals.keypoints import (
    distance_from,
    parts_of,
    residual_of,
)
from stereotrack_core.tracking.state import Belief, Setup, State

_ITERATIONS = 3

_PROBABLE = 0.999
"""Share of right detections that lie inside the gate by the pose's own uncertainty."""


def predicted_by_detections(
    setup: Setup, state: State, since: float, time: float, due: Sequence[Detection]
) -> Belief:
    """Predict up to a time; each detection on the way is one correction of its own.

    Parameters
    ----------
    setup : Setup
    state : State
    since : float
        Frame that the state belongs to.
    time : float
        Frame to predict.
    due : sequence of Detection
        All later than the state and before the frame.
    """
    belief: Belief = state
    for detection in sorted(due, key=lambda each: each.time):
        belief = setup.moved(belief, state.movement, since, detection.time)
        belief, since = corrected_by(detection, setup, belief), detection.time
    return setup.moved(belief, state.movement, since, time)


def corrected_by(detection: Detection, setup: Setup, prior: Belief) -> Belief:
    """Correct a pose, predicted for the detection's time, by one detection.

    A hand whose side is not known is the hand that fits better. Farther than the parameters' gate
    from where it could belong, or improbable, a detection changes nothing.
    """
    part = _best_part(detection, setup, prior)
    if part is None:
        return prior
    body, at = setup.body, prior
    for _ in range(_ITERATIONS):
        residual = residual_of(detection, part, body, body.frames(at.pose))
        found = gathered((residual,), body, at.pose, setup.columns)
        at, _ = solved(setup.joints, prior, at.pose, found)
    return Belief(orthonormal(at.pose), at.P)


def _best_part(detection: Detection, setup: Setup, prior: Belief) -> int | None:
    """Part to whose end the detection fits best by the pose's uncertainty; None beyond the gate."""
    body, columns = setup.body, setup.columns
    frames, gate = body.frames(prior.pose), setup.parameters.detection_gate
    stacked = PartFrames(frames.rotations[None], frames.origins[None])
    best, least = None, np.inf
    for part in parts_of(detection):
        if not distance_from(detection, part, body, frames) < gate:
            continue
        residual = residual_of(detection, part, body, frames)
        nu = residual.measured - residual.predicted(stacked)[0]
        J = residual.jacobian(frames, columns)
        S = J @ prior.P @ J.T + np.eye(len(nu)) * _plain_variance(detection)
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
