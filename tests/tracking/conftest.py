"""Bodies and trackers for the tests."""

import numpy as np
import pytest

from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.tracking.manifold_tracker import ManifoldTracker
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.thesis import ThesisTracker
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
        kind = ThesisTracker if name == "thesis" else ManifoldTracker
        return kind(body, settings.tracking, cameras, fps, seed)

    return make
