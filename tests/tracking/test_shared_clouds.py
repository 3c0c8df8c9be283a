"""Clouds that several runs share."""

import numpy as np
import pytest

from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.tracking.pipeline import Pipeline
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run_spec import RunSpec
from stereotrack_core.tracking.shared_clouds import SharedClouds
from tests.tracking.recordings import write_depth_recording
from tests.tracking.scenes import POSES

FRAMES = 4
SETTINGS = preset("fast").replaced(
    pixel_step=1, speckle_size=0, search_arms=False, data_points=300, fit_shape=False
)


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    body = body_model(AVERAGE, SETTINGS.body)
    folder = tmp_path_factory.mktemp("shared") / "cones"
    return write_depth_recording(folder, body, [POSES["t"]] * FRAMES)


@pytest.fixture
def first(recording):
    with Pipeline(recording, RunSpec(SETTINGS, init="tpose")) as pipeline:
        yield pipeline


def test_a_run_with_shared_clouds_is_the_run_alone(recording, first):
    clouds = SharedClouds(first.chain, first.reader)
    takers = [clouds.taker() for _ in range(2)]
    runs = [
        Pipeline(recording, RunSpec(SETTINGS, seed=seed, init="tpose"), clouds=taker)
        for seed, taker in enumerate(takers)
    ]
    together = list(zip(*(run.frames(range(FRAMES)) for run in runs), strict=True))
    for run in runs:
        run.close()
    for seed in (0, 1):
        with Pipeline(recording, RunSpec(SETTINGS, seed=seed, init="tpose")) as alone:
            for k, frame in enumerate(alone.frames(range(FRAMES))):
                np.testing.assert_array_equal(together[k][seed].x, frame.x)
    assert first.reader.frame_set(0).views.keys() == set("NOSW")
    assert len(clouds) == 0
