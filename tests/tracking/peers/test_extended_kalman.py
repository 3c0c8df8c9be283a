"""The extended Kalman filter against its textbook form."""

import numpy as np

from stereotrack_core.body.manifold import difference
from stereotrack_core.tracking.limits import limit_residuals
from tests.tracking.peers.test_peers import make
from tests.tracking.scenes import POSES, cloud_of, surface_points


def test_the_correction_is_the_classic_one():
    rng = np.random.default_rng(5)
    tracker = make("ekf", data_points=200)
    tracker.start(POSES["reaching"])
    cloud = cloud_of(surface_points(tracker.body, POSES["reaching"], 400, rng, 0.01))
    predicted, P0 = tracker.pose, tracker.P.copy()
    surface = tracker.correspond(tracker.choose(cloud), 0)
    tracker.settle(0, tracker.choose(cloud), P0)
    frames = tracker.body.frames(predicted)
    limits = limit_residuals(tracker.body, predicted, tracker.parameters, tracker.joints)
    rows = (surface, *limits)
    H = np.concatenate([row.jacobian(frames, tracker._columns) for row in rows])
    R = np.diag(np.concatenate([row.variance for row in rows]))
    stacked = tracker.body.frames(predicted[None])
    nu = np.concatenate([row.measured - row.predicted(stacked)[0] for row in rows])
    K = P0 @ H.T @ np.linalg.inv(H @ P0 @ H.T + R)
    np.testing.assert_allclose(tracker.P, (np.eye(len(P0)) - K @ H) @ P0, rtol=1e-6, atol=1e-12)
    moved = difference(tracker.pose, predicted, tracker.joints)
    np.testing.assert_allclose(moved, K @ nu, atol=2e-3)
