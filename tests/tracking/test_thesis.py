"""One correction of the thesis's tracker, recomputed from its text."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from stereotrack_core.body.angles import THESIS_JOINTS, euler_rotation, joint_rotation
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


@pytest.fixture
def prepared(make_tracker, rng):
    """A tracker before its first correction, and a cloud that does not fit yet."""
    tracker = make_tracker("thesis", model_points=40)
    tracker.start(disturbed(POSES["pointing"], THESIS_JOINTS, rng))
    tracker.state = tracker.model.predict(tracker.state, 0)
    return tracker, surface_points(tracker.setup.body, POSES["pointing"], 700, rng, 0.005)


def test_a_correction_is_that_of_the_text_with_directions_held_at_x_hat(prepared):
    tracker, points = prepared
    model, before = tracker.model, tracker.state
    drawn = model.sample(before, np.random.default_rng(0))
    pairs = model.closest(before, drawn, cKDTree(points))
    x, P, e = before.x.copy(), before.P.copy(), pairs.e.copy()
    own = list(zip(pairs.sampled.part, pairs.sampled.points, strict=True))

    def h(state):
        return [e[i] @ _world(tracker.setup.body, state, *own[i]) for i in range(len(own))]

    z_hat, P_zz, P_xz = unscented.transformed(h, x, P, 0.1, 2.0, 0.0)
    P_nunu = P_zz + 0.02**2 * np.eye(len(own))
    K = P_xz @ np.linalg.inv(P_nunu)
    nu = np.array([e[i] @ pairs.measured[i] for i in range(len(own))]) - z_hat
    after, innovation = model.correct(before, pairs)
    np.testing.assert_allclose(after.x, x + K @ nu, atol=1e-8)
    np.testing.assert_allclose(after.P, P - K @ P_nunu @ K.T, atol=1e-8)
    assert innovation == pytest.approx(np.sqrt(np.mean(nu**2 / np.diag(P_nunu))), rel=1e-8)


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
