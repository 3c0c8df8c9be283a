"""How much a body may move between frame sets."""

import numpy as np
import pytest

from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.state import Setup


def setup_with(parameters, fps):
    """Of a whole body, whose shoulders come last in the state."""
    return Setup(body_model(AVERAGE), parameters, np.zeros((1, 3)), fps, 0)


def test_sigmas_are_those_of_the_parameters_at_ten_frames_per_second():
    p = TrackingParameters(sigma_position=0.1, sigma_rotation=20.0, sigma_joint=40.0)
    sigma = np.sqrt(np.diag(setup_with(p, 10.0).Q))
    np.testing.assert_allclose(sigma[:3], 0.1)
    np.testing.assert_allclose(sigma[3:6], np.radians(20.0))
    np.testing.assert_allclose(sigma[6:-4], np.radians(40.0))
    np.testing.assert_allclose(sigma[-4:], np.radians(3.0))


@pytest.mark.parametrize("fps", [1.0, 5.0, 25.0, 120.0])
def test_variances_grow_with_the_time_between_frame_sets(fps):
    p = TrackingParameters()
    np.testing.assert_allclose(setup_with(p, fps).Q, setup_with(p, 10.0).Q * 10.0 / fps)


def test_trackers_use_their_frame_rate(make_tracker):
    for name in ("thesis", "manifold"):
        np.testing.assert_allclose(
            make_tracker(name, fps=5).setup.Q, 2 * make_tracker(name, fps=10).setup.Q
        )
