"""One correction of the thesis's tracker, recomputed from its text."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from stereotrack_core.body.angles import THESIS_JOINTS, euler_rotation, joint_rotation
from stereotrack_core.body.sampling import SurfacePoints
from stereotrack_core.body.skeleton import PARENTS
from tests.oracle import unscented
from tests.tracking.scenes import POSES, cloud_of, disturbed, surface_points


def _world(body, x, part, point):
    """World place of a point of a part, chained from the part up to the torso."""
    while part != 0:
        at = 6 + 2 * THESIS_JOINTS.index(part) if part in THESIS_JOINTS else None
        if at is not None:
            point = joint_rotation(part, x[at], x[at + 1]) @ point
        point = point + body.skeleton.joints[part]
        part = PARENTS[part]
    return euler_rotation(*x[3:6]) @ point + x[:3]


def _brute_force_nearest(points, cloud):
    return np.array([cloud[np.argmin(((cloud - point) ** 2).sum(axis=1))] for point in points])


@pytest.fixture
def prepared(make_tracker, rng):
    """A tracker before its first correction, and a cloud that does not fit yet."""
    tracker = make_tracker("thesis", model_points=40)
    tracker.start(disturbed(POSES["pointing"], THESIS_JOINTS, rng))
    tracker.predict(0)
    return tracker, surface_points(tracker.setup.body, POSES["pointing"], 700, rng, 0.005)


def test_pairs_are_nearest_points_and_their_directions(prepared):
    tracker, points = prepared
    sampled = tracker.sample()
    pairs = tracker.closest(sampled, cKDTree(points))
    own = zip(pairs.sampled.part, pairs.sampled.points, strict=True)
    p_zhat = np.array([_world(tracker.setup.body, tracker.x, part, point) for part, point in own])
    p_z = _brute_force_nearest(p_zhat, points)
    joined = p_z - p_zhat
    np.testing.assert_allclose(pairs.predicted, p_zhat, atol=1e-12)
    np.testing.assert_allclose(pairs.measured, p_z, atol=1e-12)
    e = joined / np.linalg.norm(joined, axis=1, keepdims=True)
    np.testing.assert_allclose(pairs.e, e, atol=1e-9)
    np.testing.assert_allclose(pairs.z, (e * p_z).sum(axis=1), atol=1e-12)


def test_a_correction_is_that_of_the_text_with_directions_held_at_x_hat(prepared):
    tracker, points = prepared
    pairs = tracker.closest(tracker.sample(), cKDTree(points))
    x, P, e = tracker.x.copy(), tracker.P.copy(), pairs.e.copy()
    own = list(zip(pairs.sampled.part, pairs.sampled.points, strict=True))

    def h(state):
        return [e[i] @ _world(tracker.setup.body, state, *own[i]) for i in range(len(own))]

    z_hat, P_zz, P_xz = unscented.transformed(h, x, P, 0.1, 2.0, 0.0)
    P_nunu = P_zz + 0.02**2 * np.eye(len(own))
    K = P_xz @ np.linalg.inv(P_nunu)
    nu = np.array([e[i] @ pairs.measured[i] for i in range(len(own))]) - z_hat
    innovation = tracker.correct(pairs)
    np.testing.assert_allclose(tracker.x, x + K @ nu, atol=1e-8)
    np.testing.assert_allclose(tracker.P, P - K @ P_nunu @ K.T, atol=1e-8)
    assert innovation == pytest.approx(np.sqrt(np.mean(nu**2 / np.diag(P_nunu))), rel=1e-8)


def test_the_predicted_measurement_moves_with_the_pose_on_fixed_lines(prepared):
    tracker, points = prepared
    pairs = tracker.closest(tracker.sample(), cKDTree(points))
    moved = tracker.setup.body.frames(POSES["reaching"])
    stacked = type(moved)(moved.rotations[None], moved.origins[None])
    places = moved.apply(pairs.sampled.part, pairs.sampled.points)
    np.testing.assert_allclose(pairs.z_hat(stacked)[0], (pairs.e * places).sum(axis=1), atol=1e-12)


def test_a_model_point_that_lies_on_a_measured_one_has_no_direction(prepared):
    tracker, _ = prepared
    sampled = tracker.sample()
    frames = tracker.setup.body.frames(tracker.lost("").pose)
    places = frames.apply(sampled.part, sampled.points)
    pairs = tracker.closest(sampled, cKDTree(np.concatenate([places[:5], places[5:] + 0.01])))
    assert len(pairs.e) == len(sampled) - 5
    np.testing.assert_allclose(np.linalg.norm(pairs.e, axis=1), 1.0)


def test_every_iteration_draws_new_points(make_tracker, rng):
    tracker = make_tracker("thesis", iterations=4)
    tracker.start(POSES["t"])
    drawn = []
    draw = tracker.sample

    def remembered(trace) -> SurfacePoints:
        drawn.append(draw(trace))
        return drawn[-1]

    tracker.sample = remembered
    tracker.step(cloud_of(surface_points(tracker.setup.body, POSES["t"], 1000, rng)))
    assert [len(points) for points in drawn] == 4 * [64]
    assert len({points.points.tobytes() for points in drawn}) == 4


def test_a_regular_pattern_needs_no_seed(make_tracker, rng):
    cloud = cloud_of(
        surface_points(make_tracker("thesis").setup.body, POSES["t"], 1500, rng, 0.005)
    )
    found = []
    for seed in (1, 2):
        tracker = make_tracker("thesis", sampling="regular", seed=seed)
        tracker.start(POSES["t"])
        found.append(tracker.step(cloud))
    np.testing.assert_array_equal(found[0].x, found[1].x)


def test_without_a_camera_that_sees_the_body_nothing_is_tracked(make_tracker, rng):
    tracker = make_tracker("thesis", cameras=np.empty((0, 3)))
    tracker.start(POSES["t"])
    found = tracker.step(cloud_of(surface_points(tracker.setup.body, POSES["t"], 1000, rng)))
    assert not found.tracked
    assert "camera" in found.reason
