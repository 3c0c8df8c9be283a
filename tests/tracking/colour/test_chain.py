"""From colour pictures to a cloud with colours, and to a run."""

import numpy as np
import pytest

from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.depth.chain import DepthChain
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.writing import write_png
from stereotrack_core.tracking.pipeline import Pipeline
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run import track
from stereotrack_core.tracking.run_spec import RunSpec
from tests.tracking.recordings import VIEWS, rendered_depth, write_depth_recording
from tests.tracking.scenes import POSES

BODY = body_model(AVERAGE)
TINTS = {"N": (1.0, 1.0, 1.0), "O": (1.15, 0.9, 1.0), "S": (0.9, 1.0, 1.1), "W": (1.0, 1.1, 0.9)}
FRAMES = 3
TINY = {"pixel_step": 1, "speckle_size": 0}
"""For pictures as small as these."""


@pytest.fixture
def coloured(tmp_path):
    """Four depth views of a body in a blue shirt; every camera sees it in its own tint."""
    recording = write_depth_recording(tmp_path, BODY, [POSES["t"]] * FRAMES)
    for name in VIEWS:
        seen = np.isfinite(rendered_depth(BODY, POSES["t"], recording.cameras[name]))
        picture = np.where(seen[..., None], (150.0, 90.0, 60.0), (90.0, 90.0, 90.0)) / TINTS[name]
        for k in range(FRAMES):
            write_png(tmp_path / name / f"{k:04d}.png", picture.astype(np.uint8))
    return recording


def _cloud(recording, *, colour):
    chain = DepthChain(recording, DepthParameters(**TINY), colour=colour)
    with FrameReader(recording, colour=colour) as reader:
        chain.learn_background(reader, range(FRAMES))
        cloud = chain.process(reader.frame_set(1))
    chain.close()
    return cloud


def test_points_get_the_colours_of_the_first_view(coloured):
    cloud = _cloud(coloured, colour=True)
    trunk = np.linalg.norm(cloud.points - [0.05, -0.1, 1.2], axis=1) < 0.3
    for view in range(len(VIEWS)):
        own = cloud.colours[trunk & (cloud.view == view)]
        np.testing.assert_allclose(np.median(own, axis=0), (150, 90, 60), rtol=0.03)


def test_grey_is_the_same_with_and_without_the_choice(coloured):
    with_colours, without = _cloud(coloured, colour=True), _cloud(coloured, colour=False)
    assert without.colours is None
    assert all(depth.picture is None for depth in without.depths.values())
    np.testing.assert_array_equal(with_colours.points, without.points)


def test_a_part_of_a_cloud_keeps_what_belongs_together(coloured):
    cloud = _cloud(coloured, colour=True)
    chosen = cloud.points[:, 2] > 1.0
    part = cloud.part(chosen)
    for name in ("points", "view", "pixels", "colours"):
        np.testing.assert_array_equal(getattr(part, name), getattr(cloud, name)[chosen])


def test_recordings_are_looked_at_for_colours(coloured, tmp_path_factory):
    settings = preset("accurate").replaced(**TINY, fit_shape=False, search_arms=False)
    run = track(coloured, RunSpec(settings, frames=range(FRAMES), init="tpose"))
    assert run.tracked.all()
    with Pipeline(coloured, RunSpec(settings, init="tpose")) as pipeline:
        (first, *_) = pipeline.frames(range(FRAMES))
        assert first.cloud.colours is not None
    grey = write_depth_recording(tmp_path_factory.mktemp("grey"), BODY, [POSES["t"]] * FRAMES)
    found = {}
    for weight in (0.0, 0.06):
        spec = RunSpec(settings.replaced(colour_weight=weight), init="tpose")
        with Pipeline(grey, spec) as pipeline:
            frames = list(pipeline.frames(range(FRAMES)))
            assert frames[0].cloud.colours is None
            found[weight] = np.array([frame.x for frame in frames])
    np.testing.assert_array_equal(found[0.0], found[0.06])
