"""Trackers for the tests."""

import numpy as np
import pytest

from tests.tracking.running import tracker_of


@pytest.fixture
def rng():
    return np.random.default_rng(3215)


@pytest.fixture
def make_tracker():
    """Function from the name of a tracker to a new one; further parameters by name."""
    return tracker_of
