"""Points of a whole scene, by which a calibration is turned to the floor."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.depth.floor import scene_points
from stereotrack_core.depth.parameters import DepthParameters
from tests.depth.recordings import WALL_Y, depth_recording, frame_set, stereo_recording


def points_of(recording, images):
    views = [view.name for view in recording.views]
    return scene_points(recording, images, DepthParameters(), views)


@pytest.mark.parametrize(
    "recording", [stereo_recording(), depth_recording()], ids=["stereo", "depth"]
)
def test_all_that_is_seen_gives_points(recording):
    points = points_of(recording, frame_set(recording, 0, box=False))
    assert len(points) > 2000
    assert np.mean(np.abs(points[:, 1] - WALL_Y) < 0.05) > 0.9


def test_pixels_without_range_and_far_ones_give_none():
    recording = depth_recording()
    images = frame_set(recording, 0, box=False)
    depth = images.views["K"].depth.copy()
    depth[:, ::2], depth[:, 1::2] = 0.0, 9.0
    (view,) = images.views.values()
    blind = replace(images, views={"K": replace(view, depth=depth)})
    assert not len(points_of(recording, blind))
