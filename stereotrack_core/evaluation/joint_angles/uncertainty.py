"""How uncertain joint angles are, by the covariance of a pose or of landmarks.

With columns l_i of a square root of the covariance the variance of an angle is

    v = 1/2 sum over i of (a(x + l_i) - a(x))^2 + (a(x - l_i) - a(x))^2,

the unscented transform with points one standard deviation away (n + lambda = 1), about the stated
angle instead of the mean. Where an angle is linear that is the first-order propagation J P J^T; at
a fold, as of an elbow that is straight, it is still the mean square by which the angle is off.
"""

from __future__ import annotations

import numpy as np

from stereotrack_core.annotation.reference import Reference
from stereotrack_core.arrays import BoolArray, FloatArray
from stereotrack_core.body.angles import THESIS_JOINTS, pose_of_state
from stereotrack_core.body.manifold import displaced
from stereotrack_core.body.model import BodyModel, landmarks
from stereotrack_core.body.skeleton import CLAVICLES, HEAD, LIMB_OF_PART
from stereotrack_core.evaluation.joint_angles.definitions import NAMES
from stereotrack_core.evaluation.joint_angles.geometry import raw_angles, wrapped
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.tracking.estimate import OVERCONFIDENCE
from stereotrack_core.tracking.frame import Run, joints_named
from stereotrack_core.tracking.stored import body_of_run

_OF_INTEREST = (*THESIS_JOINTS, HEAD, *CLAVICLES)


def sigma_of_run(run: Run) -> FloatArray:
    """Standard deviations (F, A) in radians of the joint angles of a run.

    From its covariances times the squares of :data:`OVERCONFIDENCE`, as the limbs' own standard
    deviations are stated. NaN in frames that are not tracked, and throughout where the states are
    not those of a body.
    """
    result: FloatArray = np.full((len(run.frame), len(NAMES)), np.nan)
    joints = joints_named(run.state_names)
    if joints is None:
        return result
    body = body_of_run(run)
    columns, kept = _columns(joints)
    factors = np.concatenate(
        [np.full(6, OVERCONFIDENCE[0]), np.repeat(OVERCONFIDENCE[LIMB_OF_PART[kept]], 2)]
    )
    for i in np.flatnonzero(run.tracked):
        P = run.P[i][np.ix_(columns, columns)] * np.outer(factors, factors)
        if np.isfinite(P).all() and np.isfinite(run.x[i]).all():
            result[i] = _sigma(body, run.x[i], joints, P, columns, kept)
    return result


def sigma_of_reference(reference: Reference) -> FloatArray | None:
    """Standard deviations (F, A) in radians by the covariances of a reference's landmarks.

    The errors of different landmarks are taken for independent. Those of a body that was fitted
    as a whole are alike, so that angles are rather better than is said. None where the reference
    does not say how good it is.
    """
    if reference.covariance is None:
        return None
    points = reference.trajectory().points
    total: FloatArray = np.zeros((len(points), len(NAMES)))
    at = raw_angles(points)
    for place, name in enumerate(LANDMARKS):
        if name not in reference.landmark_names:
            continue
        known = reference.covariance[:, reference.landmark_names.index(name)]
        for column in np.moveaxis(_roots(known), -1, 0):
            for sign in (1.0, -1.0):
                moved = points.copy()
                moved[:, place] += sign * column
                total += 0.5 * wrapped(raw_angles(moved) - at) ** 2
    result: FloatArray = np.sqrt(total)
    return result


def _sigma(
    body: BodyModel,
    x: FloatArray,
    joints: tuple[int, ...],
    P: FloatArray,
    columns: list[int],
    kept: list[int],
) -> FloatArray:
    """Standard deviations (A,) of one pose."""
    steps = _roots(P[None])[0].T
    steps = np.concatenate([steps, -steps])
    pose = pose_of_state(x, joints)
    if joints == THESIS_JOINTS:  # its errors are added to the numbers of the state
        delta = np.zeros((len(steps), len(x)))
        delta[:, columns] = steps
        moved = pose_of_state(x + delta, joints)
    else:
        moved = displaced(pose, steps, tuple(kept))
    change = wrapped(raw_angles(landmarks(body, moved)) - raw_angles(landmarks(body, pose)))
    result: FloatArray = np.sqrt(0.5 * np.sum(change**2, axis=0))
    return result


def _columns(joints: tuple[int, ...]) -> tuple[list[int], list[int]]:
    """Numbers of the state that angles depend on, and the parts whose joints are among them."""
    kept = [part for part in joints if part in _OF_INTEREST]
    columns = list(range(6))
    for part in kept:
        first = 6 + 2 * joints.index(part)
        columns += [first, first + 1]
    return columns, kept


def _roots(covariances: FloatArray) -> FloatArray:
    """Matrices L (..., n, n) with L L' = P; NaN for covariances that are not known."""
    known: BoolArray = np.asarray(np.isfinite(covariances).all(axis=(-2, -1)))
    values, vectors = np.linalg.eigh(np.where(known[..., None, None], covariances, 0.0))
    result: FloatArray = vectors * np.sqrt(np.maximum(values, 0.0))[..., None, :]
    result[~known] = np.nan
    return result
