"""How sure a pose is: its spread, what the data leave unexplained, and what nobody sees."""

from types import SimpleNamespace

import numpy as np
import pytest

from stereotrack_core.body.angles import ALL_JOINTS, pose_of_state, state_of_pose
from stereotrack_core.body.manifold import displaced
from stereotrack_core.body.model import body_model, landmarks, placed_cones
from stereotrack_core.body.pose import t_pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.body.skeleton import LEFT_FOREARM, LEFT_UPPER_ARM
from stereotrack_core.body.surface import nearest_on_surface, parts_of_cones
from stereotrack_core.filtering.sigma_points import scaled_weights, sigma_deviations
from stereotrack_core.tracking.estimate import limb_directions, limb_sigma_deg
from stereotrack_core.tracking.frame import in_chain_axes
from stereotrack_core.tracking.model import model_for
from stereotrack_core.tracking.presets import preset
from tests.tracking.recordings import camera_towards_the_middle, rendered_depth
from tests.tracking.running import Stepping
from tests.tracking.scenes import CAMERAS, POSES, angle_errors, cloud_of

BODY = body_model(AVERAGE)


def test_the_spread_of_limbs_is_that_of_their_directions(rng):
    """Against directions of drawn poses; the forearm moves with its upper arm."""
    n = 6 + 2 * len(ALL_JOINTS)
    sigma = np.r_[np.full(3, 0.01), np.full(3, 0.02), np.full(n - 6, 0.04)]
    weights = scaled_weights(n, 0.1, 2.0, 0.0)
    dX = sigma_deviations(np.diag(sigma**2), weights)
    frames = BODY.frames(displaced(POSES["pointing"], dX, ALL_JOINTS))
    found = limb_sigma_deg(frames, weights.covariance)
    drawn = displaced(POSES["pointing"], sigma * rng.normal(size=(4000, n)), ALL_JOINTS)
    true = limb_directions(BODY.frames(POSES["pointing"]))
    apart = np.linalg.norm(limb_directions(BODY.frames(drawn)) - true, axis=-1)
    np.testing.assert_allclose(found, np.degrees(np.sqrt((apart**2).mean(axis=0))), rtol=0.05)
    assert (found[4:] > found[2:4]).all()


HIDDEN, SEEN = [LEFT_UPPER_ARM, LEFT_FOREARM], [0, 3, 5]


def _points_of_one_view(pose):
    camera = camera_towards_the_middle("N", CAMERAS[0])
    depth = rendered_depth(BODY, pose, camera)
    v, u = np.nonzero(np.isfinite(depth))
    rays = np.stack([u - camera.matrix[0, 2], v - camera.matrix[1, 2]], axis=1)
    local = np.column_stack([rays / camera.matrix[0, 0], np.ones(len(u))]) * depth[v, u, None]
    return camera.world_from_camera.apply(local)


@pytest.mark.parametrize("name", ["t", "pointing"])
def test_a_limb_that_no_data_see_keeps_still_and_becomes_uncertain(name, rng):
    pose = POSES[name]
    points = _points_of_one_view(pose)
    feet = nearest_on_surface(points, placed_cones(BODY, BODY.frames(pose)), np.inf)
    hidden = np.isin(parts_of_cones(BODY, feet.cone), HIDDEN)
    tracker = Stepping(model_for(BODY, preset("accurate"), CAMERAS[:1], 10.0, 0))
    tracker.start(pose)
    sigma = []
    for frame in range(7):
        seen = points if frame < 2 else points[~hidden]
        estimate = tracker.step(cloud_of(seen + rng.normal(0, 0.004, seen.shape), frame))
        assert estimate.tracked
        assert angle_errors(BODY, estimate.pose, pose).max() < 5.0
        sigma.append(estimate.limb_sigma_deg)
    sigma = np.array(sigma)
    assert sigma[1].max() < 20.0
    assert (np.diff(sigma[1:, HIDDEN], axis=0) > 0).all()
    assert sigma[-1, HIDDEN].min() > 60.0
    assert sigma[-1, SEEN].max() < 20.0


def turned_pose(rng):
    """A pose whose limbs have been turned about their own axes on their way."""
    pose = t_pose(np.zeros(3))
    for _ in range(30):
        pose = displaced(pose, 0.3 * rng.normal(size=6 + 2 * len(ALL_JOINTS)), ALL_JOINTS)
    return pose


def spread(pose, P):
    """Covariance (27, 27) of all landmarks to first order."""
    step = 1e-5
    steps = step * np.eye(len(P))
    ahead, behind = (landmarks(BODY, displaced(pose, s * steps, ALL_JOINTS)) for s in (1, -1))
    J = ((ahead - behind) / (2 * step)).reshape(len(P), -1).T
    return J @ P @ J.T


@pytest.mark.parametrize("seed", range(4))
def test_landmarks_are_as_uncertain_about_the_states_pose_as_about_the_trackers(seed):
    rng = np.random.default_rng(seed)
    pose = turned_pose(rng)
    x = state_of_pose(pose, ALL_JOINTS)
    root = rng.normal(size=(len(x), len(x)))
    P = 1e-3 * root @ root.T
    frame, again = SimpleNamespace(pose=pose, x=x, P=P), pose_of_state(x, ALL_JOINTS)
    stored = in_chain_axes(frame, ALL_JOINTS)
    expected = spread(pose, P)
    np.testing.assert_allclose(spread(again, stored), expected, atol=1e-8)
    assert np.abs(spread(again, P) - expected).max() > 1e-3  # it does make a difference
