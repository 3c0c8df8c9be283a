"""Recordings that have colours, and those that only store grey as colour."""

import numpy as np
import pytest

from stereotrack_core.recording.reader import FrameSet, ViewImages, shows_colours


def _set(*pictures):
    return FrameSet(0, {str(k): ViewImages(picture) for k, picture in enumerate(pictures)})


@pytest.fixture
def grey():
    return np.random.default_rng(5).integers(0, 256, (60, 80), dtype=np.uint8)


def test_grey_pictures_have_no_colours_however_they_are_stored(grey):
    rounding = np.random.default_rng(6).integers(0, 3, (60, 80, 3))
    stored = np.clip(grey[..., None].astype(int) + rounding, 0, 255).astype(np.uint8)
    assert not shows_colours(_set(grey))
    assert not shows_colours(_set(stored, grey))
    assert not shows_colours(_set())


def test_one_view_with_a_coloured_thing_is_enough(grey):
    coloured = np.repeat(grey[..., None], 3, axis=2)
    coloured[20:30, 20:40, 2] = 255 - coloured[20:30, 20:40, 2]
    assert shows_colours(_set(grey, coloured))
