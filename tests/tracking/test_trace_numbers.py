"""The trace's numbers against dense computations made here, step by step as in the text."""

import numpy as np
import pytest

from stereotrack_core.body.angles import THESIS_JOINTS, pose_of_state, state_of_pose
from stereotrack_core.body.manifold import difference
from tests.tracking.scenes import POSES, cloud_of, pose_with_arms, surface_points
from tests.tracking.test_trace import followed


def in_part(body, pose, part, places):
    frames = body.frames(pose)
    shifted = places - frames.origins[part]
    return np.einsum("mji,mj->mi", frames.rotations[part], shifted)


def world_of(body, pose, part, local):
    frames = body.frames(pose)
    return np.einsum("mij,mj->mi", frames.rotations[part], local) + frames.origins[part]


@pytest.mark.parametrize("iteration", [0, 3])
def test_the_thesis_cross_covariance_is_the_weighted_sum_over_its_sigma_points(iteration):
    """(2.12) to (2.18) and (3.5) to (3.11), one sigma point after the other."""
    tracker, cloud = followed("thesis")
    found = tracker.explain(cloud).corrections[iteration]
    body, points, P = tracker.setup.body, found.points, found.before.P
    n, alpha, beta = len(P), tracker.setup.parameters.ut_alpha, 2.0
    spread = alpha**2 * n  # n + lambda with kappa 0
    root = np.linalg.cholesky(spread * P)
    e = points.data - points.model
    e /= np.linalg.norm(e, axis=1, keepdims=True)
    local = in_part(body, found.before.pose, points.part, points.model)
    x = state_of_pose(found.before.pose, THESIS_JOINTS)
    shifts = [np.zeros(n), *root.T, *-root.T]
    Y = []
    for shift in shifts:
        pose = pose_of_state(x + shift, THESIS_JOINTS)
        Y.append(np.einsum("mi,mi->m", e, world_of(body, pose, points.part, local)))
    mean = [1.0 - n / spread] + [0.5 / spread] * (2 * n)
    Wc = [mean[0] + 1.0 - alpha**2 + beta, *mean[1:]]
    z_hat = sum(w * y for w, y in zip(mean, Y, strict=True))
    P_xz, P_zz = np.zeros((n, len(e))), np.zeros((len(e), len(e)))
    for w, shift, y in zip(Wc, shifts, Y, strict=True):
        P_xz += w * np.outer(shift, y - z_hat)
        P_zz += w * np.outer(y - z_hat, y - z_hat)
    nu = np.einsum("mi,mi->m", e, points.data) - z_hat
    K = P_xz @ np.linalg.inv(P_zz + np.diag(points.sigma**2))
    scale = np.abs(P_xz).max()
    np.testing.assert_allclose(found.P_xz, P_xz, atol=1e-8 * scale)
    np.testing.assert_allclose(found.P_zz, np.diagonal(P_zz), rtol=1e-6)
    np.testing.assert_allclose(points.residual, nu, atol=1e-9)
    np.testing.assert_allclose(found.gain, K, atol=1e-6 * np.abs(K).max())
    np.testing.assert_allclose(found.dx, K @ nu, atol=1e-8)
    after = P - K @ (P_zz + np.diag(points.sigma**2)) @ K.T
    np.testing.assert_allclose(found.after.P, after, atol=1e-8)
    np.testing.assert_allclose(found.gain_norm, np.sqrt((K**2).sum()), rtol=1e-6)


@pytest.mark.parametrize("kind", ["accurate", "ekf"])
def test_points_rows_and_prior_together_are_the_correction(kind):
    tracker, cloud = followed(kind)
    trace = tracker.explain(cloud)
    for found in trace.corrections:
        rows = sum((row.dx for row in found.rows), np.zeros(len(found.dx)))
        total = found.from_prior + found.gain @ found.points.residual + rows
        np.testing.assert_allclose(total, found.dx, atol=1e-9)
        moved = difference(found.after.pose, found.before.pose, tracker.setup.joints)
        inside = np.abs(found.dx) < 0.4  # longer steps are cut
        np.testing.assert_allclose(moved[inside], found.dx[inside], atol=1e-9)
    assert trace.corrections[0].from_prior == pytest.approx(0.0)


def test_a_lost_arm_is_found_by_a_pair_that_costs_less():
    tracker, _ = followed("accurate")
    lost = pose_with_arms([0.1, 0.1, -1], [0.1, 0.2, -1], [-0.9, 0.5, 0.4], [-0.3, 0.6, 1])
    tracker.start(lost)
    points = surface_points(tracker.setup.body, POSES["pointing"], 1500, np.random.default_rng(0))
    trace = tracker.explain(cloud_of(points, 4))
    (chosen,) = [pair for pair in trace.search.pairs if pair.chosen]
    assert chosen.cost < trace.search.followed.cost - trace.search.gain
