"""Bodies and trackers for the tests."""

import numpy as np
import pytest

from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.tracking.correspondences import DataToModel
from stereotrack_core.tracking.iekf import IteratedEstimator, PoseFilter
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.state import Setup
from stereotrack_core.tracking.ukf import ThesisTracker
from tests.tracking.scenes import CAMERAS


@pytest.fixture
def rng():
    return np.random.default_rng(3215)


@pytest.fixture
def make_tracker():
    """Function from the name of a tracker to a new one; further parameters by name."""

    def make(name, *, fps=10.0, seed=0, cameras=CAMERAS, **changes):
        if name == "manifold":
            changes = {"search_arms": False, "data_points": 400, "iterations": 4} | changes
        settings = preset("thesis" if name == "thesis" else "accurate").replaced(**changes)
        body = body_model(AVERAGE, settings.body)
        setup = Setup(body, settings.tracking, cameras, fps, seed)
        if name == "thesis":
            return ThesisTracker(setup)
        return PoseFilter(setup, IteratedEstimator(setup), DataToModel(setup))

    return make
