"""The trace's numbers against dense computations made here, step by step as in the text."""

import numpy as np
import pytest

from stereotrack_core.body.angles import THESIS_JOINTS, pose_of_state, state_of_pose
from stereotrack_core.body.manifold import difference, displaced
from stereotrack_core.body.skeleton import LEFT_UPPER_ARM, RIGHT_UPPER_ARM
from stereotrack_core.tracking.arm_search.search import ArmSearch
from stereotrack_core.tracking.inspection import look_inside
from stereotrack_core.tracking.trace import HIDDEN, INSIDE, SURPLUS, TOO_FAR, movement
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
    found = look_inside(tracker, cloud).corrections[iteration]
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


def test_the_cross_covariance_on_the_manifold_is_that_of_finite_differences():
    """P_xz = P H' (2.11) with H by central differences of the closest points on their normals."""
    tracker, cloud = followed("accurate")
    found = look_inside(tracker, cloud).corrections[1]
    body, points, P = tracker.setup.body, found.points, found.before.P
    normal = points.direction
    local = in_part(body, found.before.pose, points.part, points.model)
    h, H = 1e-6, np.empty((len(points.part), len(P)))
    for k in range(len(P)):
        ends = []
        for sign in (1.0, -1.0):
            delta = np.zeros(len(P))
            delta[k] = sign * h
            pose = displaced(found.before.pose, delta, tracker.setup.joints)
            ends.append(np.einsum("mi,mi->m", normal, world_of(body, pose, points.part, local)))
        H[:, k] = (ends[0] - ends[1]) / (2 * h)
    P_xz = P @ H.T
    np.testing.assert_allclose(found.P_xz, P_xz, rtol=0.0, atol=1e-8 * np.abs(P_xz).max())
    P_zz = np.einsum("mn,nm->m", H, P_xz)
    np.testing.assert_allclose(found.P_zz, P_zz, atol=1e-8 * P_zz.max())
    apart = np.einsum("mi,mi->m", normal, points.data - points.model)
    np.testing.assert_allclose(points.residual, apart, atol=1e-9)


@pytest.mark.parametrize("kind", ["accurate", "ekf"])
def test_points_rows_and_prior_together_are_the_correction(kind):
    tracker, cloud = followed(kind)
    trace = look_inside(tracker, cloud)
    for found in trace.corrections:
        rows = sum((row.dx for row in found.rows), np.zeros(len(found.dx)))
        total = found.from_prior + found.gain @ found.points.residual + rows
        np.testing.assert_allclose(total, found.dx, atol=1e-9)
        moved = difference(found.after.pose, found.before.pose, tracker.setup.joints)
        inside = np.abs(found.dx) < 0.4  # longer steps are cut
        np.testing.assert_allclose(moved[inside], found.dx[inside], atol=1e-9)
    assert trace.corrections[0].from_prior == pytest.approx(0.0)


def test_points_that_the_thesis_does_not_use_say_why():
    tracker, cloud = followed("thesis")
    found = look_inside(tracker, cloud).corrections[0]
    assert len(found.points.part) == tracker.setup.parameters.model_points
    assert set(found.unused.why.tolist()) <= {HIDDEN, INSIDE, SURPLUS}
    assert np.count_nonzero(found.unused.why == HIDDEN) > 0
    assert np.count_nonzero(found.unused.why == INSIDE) > 0
    assert np.all(np.diff(found.points.part) >= 0)
    distance = np.linalg.norm(found.points.data - found.points.model, axis=1)
    nearest = np.linalg.norm(cloud.points[:, None] - found.points.model, axis=2).min(axis=0)
    np.testing.assert_allclose(distance, nearest)


def test_data_beyond_the_reach_are_left_out_and_shown():
    tracker, cloud = followed("short reach")
    stray = np.array([[0.05, 0.25, 1.2], [0.10, 0.25, 1.2], [0.0, 0.26, 1.1]])  # in front of it
    trace = look_inside(tracker, cloud_of(np.concatenate([cloud.points[:400], stray]), 9))
    last = [c for c in trace.corrections if c.stage == "follow"][-1]
    assert np.all(last.unused.why == TOO_FAR)
    assert {tuple(p) for p in stray.tolist()} <= {tuple(p) for p in last.unused.place.tolist()}
    assert len(last.unused.place) + len(last.points.part) == 403
    assert len(last.points.part) > 300


def test_terms_of_the_search_add_up_to_its_costs(monkeypatch):
    told = []
    own = ArmSearch.cost

    def cost(self, evidence, predicted, pose):
        told.append((pose, own(self, evidence, predicted, pose)))
        return told[-1][1]

    monkeypatch.setattr(ArmSearch, "cost", cost)
    tracker, cloud = followed("accurate")
    told.clear()
    search = look_inside(tracker, cloud).search
    assert len(search.pairs) == tracker.setup.parameters.search_refined
    for pair in (search.followed, *search.pairs):
        (cost,) = [each for pose, each in told if pose is pair.pose]
        assert pair.cost == pytest.approx(cost, rel=1e-9)
    assert [pair.chosen for pair in (search.followed, *search.pairs)].count(True) == 1
    assert [one.side for one in search.proposals] == [0, 1]
    for one in search.proposals:
        assert len(one.cost) == len(one.upper) == len(one.kept)
        assert 1 <= one.kept.sum() < len(one.kept)
        assert one.cost[one.kept].min() == pytest.approx(one.cost.min())


def test_a_lost_arm_is_found_by_a_pair_that_costs_less():
    tracker, _ = followed("accurate")
    lost = pose_with_arms([0.1, 0.1, -1], [0.1, 0.2, -1], [-0.9, 0.5, 0.4], [-0.3, 0.6, 1])
    tracker.start(lost)
    points = surface_points(tracker.setup.body, POSES["pointing"], 1500, np.random.default_rng(0))
    trace = look_inside(tracker, cloud_of(points, 4))
    (chosen,) = [pair for pair in trace.search.pairs if pair.chosen]
    assert chosen.cost < trace.search.followed.cost - trace.search.gain


def test_collision_avoidance_says_what_was_too_near():
    tracker, _ = followed("thesis")
    hanging = pose_with_arms([1, 0, 0], [1, 0.05, 0], [-0.05, 0, -1], [-0.05, 0.02, -1])
    tracker.start(hanging)
    points = surface_points(tracker.setup.body, hanging, 1500, np.random.default_rng(0))
    trace = look_inside(tracker, cloud_of(points, 4))
    left, right = trace.jump.arms
    assert left.elbow_missing > 0.02
    assert right.elbow_missing == right.hand_missing == right.bend_missing == 0.0
    moved = movement(tracker.setup.body, trace.jump.before, trace.jump.after)
    assert moved.limbs[LEFT_UPPER_ARM] > np.radians(3.0)
    assert moved.limbs[RIGHT_UPPER_ARM] == pytest.approx(0.0, abs=1e-6)
    assert moved.shift == 0.0
