"""What several tests of the checks share."""

import pytest

from tests.depth.recordings import stereo_recording


@pytest.fixture
def stereo_view():
    """A recording of one stereo view, A."""
    return stereo_recording()
