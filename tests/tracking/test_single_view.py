"""Tracking with one view: what it does not see keeps still and is known to be uncertain."""

import numpy as np
import pytest

from stereotrack_core.body.model import placed_cones
from stereotrack_core.body.skeleton import LEFT_FOREARM, LEFT_UPPER_ARM
from stereotrack_core.body.surface import nearest_on_surface, parts_of_cones
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.tracker import tracker_for
from tests.tracking.keypoints.cases import BODY
from tests.tracking.recordings import camera_towards_the_middle, rendered_depth
from tests.tracking.scenes import CAMERAS, POSES, angle_errors, cloud_of

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
    tracker = tracker_for(BODY, preset("accurate"), CAMERAS[:1], 10.0, 0)
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
