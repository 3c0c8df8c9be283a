"""Where a detector's keypoints lie beside the landmarks of their names, from a few tracked frames.

A detector's shoulders, hips and wrists are those of the people who labelled its training pictures.
The offsets are constant in the frames of the parts and mirrored from side to side. Poses of all
frames and offsets are adjusted together, and each pose is eliminated: what a pose could have done
as well says nothing about an offset, and the prior keeps that as it was.
"""

from collections.abc import Sequence

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.keypoint_places import keypoint_places
from stereotrack_core.body.manifold import jacobian
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.parameters import BodyShape
from stereotrack_core.body.pose import Pose
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.tracking.correction import gathered
from stereotrack_core.tracking.residuals.limits import limit_rows
from stereotrack_core.tracking.residuals.reprojection import (
    KeypointFit,
    KeypointObservation,
    pixel_gradients,
)
from stereotrack_core.tracking.residuals.silhouette import silhouettes_of
from stereotrack_core.tracking.shape_fit import shape_with
from stereotrack_core.tracking.state import Setup

# The offsets among the numbers of a body's shape.
OFFSETS = tuple(row.name for row in BodyShape.rows() if row.name.startswith("keypoint_"))
# Metres by which detectors differ from the present shape; those to the front are held firmly, as
# all of them together cannot be told from a body that leans.
_PRIOR_SIGMA, _FORWARD_SIGMA = 0.02, 0.005
_POSE_SIGMA = 0.5  # metres and radians: poses are hardly held back
_TOGETHER = 3.0  # frames that are one measurement: a detector errs alike in successive pictures


def fitted_offsets(setup: Setup, seen: Sequence[tuple[Pose, Cloud]]) -> BodyShape:
    """The body's shape with the offsets that the keypoints of some frames show.

    `seen`: frames that are tracked with the present shape, and their poses.
    """
    shape = setup.body.shape
    start = np.array([float(shape.values()[name]) for name in OFFSETS])
    moves = _moves(setup.body)
    forward = np.array([name.endswith("_front") for name in OFFSETS])
    prior = 1.0 / np.where(forward, _FORWARD_SIGMA, _PRIOR_SIGMA) ** 2
    A, b = np.diag(prior), np.zeros(len(start))
    for pose, cloud in seen:
        observed = KeypointObservation(cloud.keypoints, setup.parameters.keypoint_sigma)
        fit = observed.fitted(setup.body, pose)
        if fit is not None:
            reduced, right = _frame(setup, pose, cloud, fit, moves)
            A += reduced / _TOGETHER
            b += right / _TOGETHER
    return shape_with(shape, OFFSETS, start + np.linalg.solve(A, b))


def _moves(body: BodyModel) -> dict[str, FloatArray]:
    """Derivatives (3, k) of the keypoints' places in their parts by the offsets."""
    before, step = keypoint_places(body), 0.01
    values = body.shape.values()
    changed = [
        keypoint_places(body.with_shape(body.shape.replaced(**{name: float(values[name]) + step})))
        for name in OFFSETS
    ]
    return {
        name: np.stack([(other[name].point - place.point) / step for other in changed], axis=1)
        for name, place in before.items()
    }


def _frame(
    setup: Setup, pose: Pose, cloud: Cloud, fit: KeypointFit, moves: dict[str, FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """Normal equations (k, k) and (k,) of one frame for the offsets, without its pose."""
    body, n = setup.body, setup.columns.n
    frames, outlines = body.frames(pose), silhouettes_of(cloud, setup.parameters.silhouette_sigma)
    beside = [each.rows(frames) for each in outlines.residuals(body, pose)]
    beside.append(limit_rows(body, pose, setup.parameters, setup.joints))
    others = gathered(beside, frames, setup.columns)
    A, a = others.A + np.eye(n) / _POSE_SIGMA**2, others.b
    B, C, c = np.zeros((n, len(OFFSETS))), np.zeros((len(OFFSETS),) * 2), np.zeros(len(OFFSETS))
    for residual in fit.residuals():
        rows = residual.rows(frames)
        H, nu, R = jacobian(rows, frames, setup.columns), rows["innovation"], rows["variance"]
        along = pixel_gradients(residual.rotation, residual.in_camera(frames), residual.focal)
        turned = along @ frames.rotations[residual.part]
        moved = np.array([moves[fit.seen.names[k]] for k in fit.counted[0].tolist()])
        S = (turned @ moved).reshape(-1, len(OFFSETS))
        weighted = H.T / R
        A, a = A + weighted @ H, a + weighted @ nu
        B, C = B + weighted @ S, C + (S.T / R) @ S
        c = c + (S.T / R) @ nu
    back = np.linalg.solve(A, np.column_stack([B, a]))
    return C - B.T @ back[:, :-1], c - B.T @ back[:, -1]
