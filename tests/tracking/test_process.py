"""How much a body may move between frame sets."""

import numpy as np
import pytest

from stereotrack_core.body.angles import THESIS_JOINTS
from stereotrack_core.body.skeleton import CLAVICLES
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.state import process_noise


def test_sigmas_are_those_of_the_parameters_at_ten_frames_per_second():
    p = TrackingParameters(
        sigma_position=0.1, sigma_rotation=20.0, sigma_joint=40.0, sigma_girdle=2.0
    )
    sigma = np.sqrt(np.diag(process_noise(p, (*THESIS_JOINTS, *CLAVICLES), 10.0)))
    np.testing.assert_allclose(sigma[:3], 0.1)
    np.testing.assert_allclose(sigma[3:6], np.radians(20.0))
    np.testing.assert_allclose(sigma[6:14], np.radians(40.0))
    np.testing.assert_allclose(sigma[14:], np.radians(2.0))


@pytest.mark.parametrize("fps", [1.0, 5.0, 25.0, 120.0])
def test_variances_grow_with_the_time_between_frame_sets(fps):
    p = TrackingParameters()
    expected = process_noise(p, THESIS_JOINTS, 10.0) * 10.0 / fps
    np.testing.assert_allclose(process_noise(p, THESIS_JOINTS, fps), expected)


def test_trackers_use_their_frame_rate(make_tracker):
    for name in ("thesis", "manifold"):
        np.testing.assert_allclose(
            make_tracker(name, fps=5).setup.Q, 2 * make_tracker(name, fps=10).setup.Q
        )
