"""Left images that lie some part of a pixel too low."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from stereotrack_core.depth.chain import source_of
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.rows import row_offset
from stereotrack_core.depth.sources import moved_up
from tests.depth.recordings import frame_set, stereo_recording
from tests.depth.test_chain import assert_is_the_box, chain_with_background

RECORDING = stereo_recording()


def lowered(rows, frame=0, *, box=True):
    """A frame set whose left images are too low, those of view B twice as much."""
    seen = frame_set(RECORDING, frame, box=box)
    views = {
        name: replace(one, left=moved_up(one.left, -rows * (1 + (name == "B"))))
        for name, one in seen.views.items()
    }
    return replace(seen, views=views)


def offsets(seen):
    """What is measured on a frame set, by view."""
    sources = {v.name: source_of(RECORDING, v, DepthParameters()) for v in RECORDING.views}
    return [row_offset(partial(sources[name].opened, one)) for name, one in seen.views.items()]


@pytest.mark.parametrize("rows", [-0.6, 0.7])
def test_the_offset_of_each_view_is_measured_and_taken_off(rows):
    np.testing.assert_allclose(offsets(lowered(rows)), [rows, 2 * rows], atol=0.11)
    chain = chain_with_background(RECORDING, sets=[lowered(rows, k) for k in range(3)])
    cloud, kept = chain.process(lowered(rows)), chain_with_background(RECORDING, align_rows=False)
    for i in range(2):
        assert_is_the_box(cloud.points[cloud.view == i])
    assert len(cloud.points) > 1.02 * len(kept.process(lowered(rows)).points)


@pytest.mark.parametrize("rows", [0.0, 0.05])
def test_what_is_hardly_off_stays_as_it_is(rows):
    aligned, kept = (
        chain_with_background(RECORDING, sets=[lowered(rows)], align_rows=on).process(lowered(rows))
        for on in (True, False)
    )
    np.testing.assert_array_equal(aligned.points, kept.points)


def test_images_that_cannot_be_matched_are_not_moved():
    dark = lowered(0.0)
    noise = np.random.default_rng(0).integers(0, 255, (240, 320), dtype=np.uint8)
    views = {n: replace(one, left=noise[::-1], image=noise) for n, one in dark.views.items()}
    assert offsets(replace(dark, views=views)) == [0.0, 0.0]
