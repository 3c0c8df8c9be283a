"""Stated standard deviations of joint angles are those that a Monte Carlo finds."""

from __future__ import annotations

import numpy as np
import pytest

from stereotrack_core.annotation.reference import Reference
from stereotrack_core.body.angles import (
    ALL_JOINTS,
    THESIS_JOINTS,
    pose_of_state,
    state_names,
    state_of_pose,
)
from stereotrack_core.body.landmark_pose import pose_of_landmarks
from stereotrack_core.body.manifold import displaced
from stereotrack_core.body.model import body_model, landmarks
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.evaluation.joint_angles.definitions import (
    ANGLES,
    NAMES,
    raw_angles,
    wrapped,
)
from stereotrack_core.evaluation.joint_angles.series import (
    sigma_of_reference,
    sigma_of_run,
)
from stereotrack_core.tracking.estimate import overconfidence
from stereotrack_core.tracking.frame import Run
from tests.evaluation.joint_angles.cases import landmarks as made
from tests.evaluation.joint_angles.cases import torso_of

BODY = body_model(proportions_of(None))
ARMS = ((0.4, 0.9, 0.2, 1.1), (-0.3, 1.6, -0.4, 0.8))
DRAWS = 20_000


def run_with(joints, P, meta, tracked=True):
    pose = pose_of_landmarks(made(ARMS, torso_of(0.4, 0.3, 0.1)))
    x = state_of_pose(pose, joints)
    n = len(x)
    nan = np.full((1,), np.nan)
    return Run(
        frame=np.array([5]), landmarks=landmarks(BODY, pose_of_state(x, joints))[None],
        x=x[None], P=P[None] if P.ndim == 2 else P, state_names=state_names(joints),
        tracked=np.array([tracked]), unexplained_fraction=nan, residual=nan, innovation=nan,
        limb_sigma_deg=np.full((1, 6), np.nan), limb_lost=np.full((1, 6), np.nan),
        seconds=np.zeros((1, 0)), stage_names=(), meta=meta,
    ), n  # fmt: skip


def covariance(n, seed=1, size=0.02):
    root = np.random.default_rng(seed).normal(size=(n, n)) * size / np.sqrt(n)
    return root @ root.T


def factors(joints, views):
    of_limbs = overconfidence(len(views))
    of_parts = [*of_limbs, *[1.0] * 4, *[of_limbs[0]] * 2]
    return np.repeat([of_limbs[0]] * 3 + [of_parts[joint] for joint in joints], 2)


@pytest.mark.parametrize("views", ["N", "NS", "NOSW"])
@pytest.mark.parametrize("joints", [ALL_JOINTS, THESIS_JOINTS], ids=["manifold", "thesis"])
def test_a_runs_standard_deviations_are_those_of_many_drawn_poses(joints, views):
    n = 6 + 2 * len(joints)
    run, _ = run_with(joints, covariance(n), {"views": list(views)})
    stated = sigma_of_run(run)[0]
    rng = np.random.default_rng(0)
    scale = factors(joints, views)
    delta = scale * rng.multivariate_normal(np.zeros(n), run.P[0], DRAWS)
    if joints == THESIS_JOINTS:
        moved = pose_of_state(run.x[0] + delta, joints)
    else:
        moved = displaced(pose_of_state(run.x[0], joints), delta, joints)
    errors = wrapped(raw_angles(landmarks(BODY, moved)) - raw_angles(run.landmarks)[0])
    drawn = np.sqrt(np.mean(errors**2, axis=0))
    has_head = np.array([a.joint != "head" or joints == ALL_JOINTS for a in ANGLES])
    np.testing.assert_allclose(stated[has_head], drawn[has_head], rtol=0.05)
    assert (drawn[has_head] > np.radians(0.5)).all()


def test_landmarks_of_a_reference_are_propagated_as_many_draws_are():
    points = made(ARMS, torso_of(0.4, 0.3, 0.1))
    roots = np.random.default_rng(3).normal(size=(9, 3, 3)) * 0.004
    P = roots @ np.swapaxes(roots, 1, 2)
    reference = Reference(np.array([2]), points[None], P[None])
    stated = sigma_of_reference(reference)[0]
    rng = np.random.default_rng(0)
    noise = np.einsum("lij,slj->sli", roots, rng.normal(size=(DRAWS, 9, 3)))
    errors = wrapped(raw_angles(points + noise) - raw_angles(points))
    np.testing.assert_allclose(stated, np.sqrt(np.mean(errors**2, axis=0)), rtol=0.05)


def test_a_straight_elbow_is_not_taken_for_certain():
    points = made(((0.4, 0.9, 0.2, 0.0),) * 2)
    P = np.broadcast_to(0.01**2 * np.eye(3), (1, 9, 3, 3))
    sigma = sigma_of_reference(Reference(np.array([0]), points[None], P))[0]
    flexion = sigma[NAMES.index("left_elbow_flexion")]
    assert np.radians(2) < flexion < np.radians(8)
