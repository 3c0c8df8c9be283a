"""The extended Kalman filter against its textbook form."""

import numpy as np

from stereotrack_core.body.manifold import difference
from tests.experiments.baselines.test_baselines import make
from tests.tracking.scenes import POSES, cloud_of, surface_points


def test_the_correction_is_the_classic_one():
    rng = np.random.default_rng(5)
    tracker = make("ekf", data_points=200)
    tracker.start(POSES["reaching"])
    cloud = cloud_of(surface_points(tracker.setup.body, POSES["reaching"], 400, rng, 0.01))
    leader, setup = tracker.leader, tracker.setup
    predicted, measured = leader.predicted(cloud), leader.measured(cloud)
    P0, found = predicted.P, leader.estimator.settle(measured, predicted)
    frames = setup.body.frames(predicted.pose)
    rows = (measured.surface(predicted.pose, wide=True), *measured.limits(predicted.pose))
    H = np.concatenate([row.jacobian(frames, setup.columns) for row in rows])
    R = np.diag(np.concatenate([row.variance for row in rows]))
    stacked = setup.body.frames(predicted.pose[None])
    nu = np.concatenate([row.measured - row.predicted(stacked)[0] for row in rows])
    K = P0 @ H.T @ np.linalg.inv(H @ P0 @ H.T + R)
    np.testing.assert_allclose(found.P, (np.eye(len(P0)) - K @ H) @ P0, rtol=1e-6, atol=1e-12)
    moved = difference(found.pose, predicted.pose, setup.joints)
    np.testing.assert_allclose(moved, K @ nu, atol=2e-3)
