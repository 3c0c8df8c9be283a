"""Silhouettes of views that give no depth."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stereotrack_core.depth.mono_silhouettes import MonoSilhouettes
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.recording.description import Recording, Stream, View
from stereotrack_core.recording.reader import FrameSet, ViewImages
from tests.tracking.recordings import camera_towards_the_middle

CAMERAS = {
    name: camera_towards_the_middle(name, np.array(at))
    for name, at in {"N": (0.0, 3.0, 1.5), "S": (0.0, -3.0, 1.5)}.items()
}
EMPTY = np.full((CAMERAS["N"].height, CAMERAS["N"].width), 60, np.uint8)


@pytest.fixture
def silhouettes():
    streams = Stream("N", "N.mp4", "N.png"), Stream("S", "S.mp4")
    views = tuple(View(stream.camera, "mono", stream) for stream in streams)
    recording = Recording(Path("mono"), "mono", 10.0, views, CAMERAS)
    made = MonoSilhouettes(recording, DepthParameters(), ("N", "S"))
    made.learn(lambda _: (None, EMPTY))
    return made


def shown(picture):
    return FrameSet(0, dict.fromkeys("NS", ViewImages(image=picture)))


def test_what_differs_from_the_empty_scene_is_the_person(silhouettes):
    picture = EMPTY.copy()
    picture[20:90, 40:80] = 180
    found = silhouettes.of(shown(picture))
    assert set(found) == {"N"}  # S has no picture of the empty scene
    view = found["N"]
    np.testing.assert_array_equal(view.outline[22:88, 42:78], True)
    assert abs(int(view.outline.sum()) - 70 * 40) < 200
    assert not np.isfinite(view.range_z).any()
    assert not view.foreground.any()
    assert view.disparity is None


def test_a_picture_that_has_changed_everywhere_says_nothing(silhouettes):
    assert not silhouettes.of(shown(EMPTY + 80))
    assert not silhouettes.of(FrameSet(0, {}))


def test_silhouettes_can_be_switched_off(silhouettes):
    recording = Recording(
        Path("mono"), "mono", 10.0, (View("N", "mono", Stream("N", "N.mp4", "N.png")),), CAMERAS
    )
    assert silhouettes
    for name in ("silhouettes", "background_empty_scene"):
        off = replace(DepthParameters(), **{name: False})
        assert not MonoSilhouettes(recording, off, ("N",))
