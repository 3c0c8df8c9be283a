"""The extended Kalman filter against its textbook form."""

import numpy as np

from stereotrack_core.body.manifold import difference, jacobian
from stereotrack_core.experiments.baselines.estimators import extended_kalman
from tests.experiments.baselines.test_baselines import make
from tests.tracking.scenes import POSES, cloud_of, surface_points


def test_the_correction_is_the_classic_one():
    rng = np.random.default_rng(5)
    tracker = make("ekf", data_points=200)
    tracker.start(POSES["reaching"])
    cloud = cloud_of(surface_points(tracker.setup.body, POSES["reaching"], 400, rng, 0.01))
    follower, setup, state = tracker.model.follower, tracker.setup, tracker.state.leader
    predicted, measured = follower.predicted(state, cloud), follower.measured(state, cloud)
    P0, found = predicted.P, extended_kalman(measured, predicted, state)[0]
    frames = setup.body.frames(predicted.pose)
    surface = measured.surface(predicted.pose, wide=True).rows(frames)
    rows = np.concatenate([surface, measured.limits(predicted.pose)])
    H, nu, R = jacobian(rows, frames, setup.columns), rows["innovation"], np.diag(rows["variance"])
    K = P0 @ H.T @ np.linalg.inv(H @ P0 @ H.T + R)
    np.testing.assert_allclose(found.P, (np.eye(len(P0)) - K @ H) @ P0, rtol=1e-6, atol=1e-12)
    moved = difference(found.pose, predicted.pose, setup.joints)
    np.testing.assert_allclose(moved, K @ nu, atol=2e-3)
