"""Clouds that several runs share."""

from contextlib import ExitStack

import numpy as np
import pytest

from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.tracking.clouds import Clouds, SharedClouds
from stereotrack_core.tracking.prepare import prepare
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run import advances
from stereotrack_core.tracking.run_spec import RunSpec
from tests.tracking.recordings import write_depth_recording
from tests.tracking.running import tracked_frames
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
    with Clouds(recording, RunSpec(SETTINGS, init="tpose")) as clouds:
        yield clouds


def test_a_run_with_shared_clouds_is_the_run_alone(recording, first):
    clouds = SharedClouds(first.chain, first.reader)
    specs = [RunSpec(SETTINGS, seed=seed, init="tpose") for seed in (0, 1)]
    with ExitStack() as stack:
        own = [Clouds(recording, spec, clouds) for spec in specs]
        runs = [advances(prepare(stack.enter_context(each)), range(FRAMES)) for each in own]
        together = list(zip(*runs, strict=True))
    for seed, spec in enumerate(specs):
        for k, frame in enumerate(tracked_frames(recording, spec)[0]):
            np.testing.assert_array_equal(together[k][seed].gained.frames[0].x, frame.x)
    assert first.reader.frame_set(0).views.keys() == set("NOSW")
