"""A correction by everything that a frame measures, against dense sums of plain residuals."""

from dataclasses import replace

import numpy as np

from stereotrack_core.body.angles import ALL_JOINTS
from stereotrack_core.body.manifold import difference
from stereotrack_core.tracking.measurements import Measurements, observations
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.state import Belief, Setup
from tests.oracle.limits import limits
from tests.tracking.keypoints.cases import BODY
from tests.tracking.keypoints.test_detections import seen as detected
from tests.tracking.keypoints.test_reprojection import seen as keypoints
from tests.tracking.scenes import (
    CAMERAS,
    POSES,
    disturbed,
    numerical_information,
    pose_with_arms,
    surface_points,
)
from tests.tracking.test_clicks import clicks_on
from tests.tracking.views import cloud_of_body

CROSSED = pose_with_arms([0.1, 0.5, -1], [-1, 0.32, 0.3], [-0.1, 0.5, -1], [1, 0.30, 0.3])
N = 6 + 2 * len(ALL_JOINTS)


def _measured(pose, rng):
    """All kinds of measurements of a pose."""
    setup = Setup(BODY, preset("accurate").tracking, CAMERAS, 10.0, 0)
    detections = tuple(detected(name, pose, sigma=0.1) for name in ("head", "left_hand"))
    cloud = replace(
        cloud_of_body(BODY, pose),
        detections=detections,
        keypoints=keypoints(pose),
        clicks=clicks_on(BODY, pose, sigma=1.0),
    )
    data = surface_points(BODY, pose, 500, rng, 0.02)
    return Measurements(setup, cloud, data, observed=observations(setup.parameters, cloud))


def test_a_correction_is_that_of_dense_sums_over_plain_residuals(rng):
    for true in (POSES["pointing"], CROSSED):
        measured, at = _measured(true, rng), disturbed(true, ALL_JOINTS, rng, 0.02)
        prior = Belief(disturbed(at, ALL_JOINTS, rng, 0.02), np.diag(rng.uniform(1e-3, 0.1, N)))
        surface, parameters = measured.surface(at, wide=True), measured.setup.parameters
        plain = [surface, *measured.beside(at), *limits(BODY, at, parameters, ALL_JOINTS)]
        assert len({type(residual) for residual in plain}) == 4
        A, b = numerical_information(plain, BODY, at, ALL_JOINTS)
        inverse = np.linalg.inv(prior.P)
        P = np.linalg.inv(inverse + A)
        dx = P @ (inverse @ difference(prior.pose, at, ALL_JOINTS) + b)
        found = measured.corrected(prior, Belief(at, prior.P), surface)
        np.testing.assert_allclose(found.P, P, rtol=1e-3, atol=1e-4 * abs(P).max())
        moved = difference(found.pose, at, ALL_JOINTS)
        assert abs(dx).max() < 0.5
        np.testing.assert_allclose(moved, dx, rtol=1e-3, atol=1e-4)
