"""Clicks whose image patch is another one than around the clicks before and after are doubted."""

import cv2
import numpy as np
import pytest

from stereotrack_core.annotation.click import Click, ClickKey
from stereotrack_core.annotation.doubts import unlike_the_others
from stereotrack_core.recording.writing import write_png
from tests.recording.small import filmless

CLICKED = (0, 2, 4, 6, 8)


@pytest.fixture
def recording(tmp_path):
    """A textured wall that moves to the right, three pixels from frame to frame."""
    made = filmless(tmp_path, "N", size=(240, 160))
    wall = np.random.default_rng(0).integers(0, 255, (160, 320)).astype(np.uint8)
    wall = cv2.GaussianBlur(wall, (0, 0), 2.0)
    (tmp_path / "N").mkdir()
    for frame in range(9):
        write_png(tmp_path / "N" / f"{frame}.png", wall[:, 60 - 3 * frame : 300 - 3 * frame].copy())
    return made


def clicks(*, wrong=()):
    off = dict(wrong)
    return [
        Click(frame, "N", name, (x + 3.0 * frame + off.get((frame, name), 0.0), y))
        for frame in CLICKED
        for name, x, y in (("head", 60.0, 40.0), ("left_hand", 90.0, 100.0))
    ]


def test_a_click_beside_the_others_is_found_and_its_neighbours_are_not(recording):
    assert unlike_the_others(recording, clicks()) == {}
    found = unlike_the_others(recording, clicks(wrong=[((4, "head"), 25.0)]))
    (key,) = found
    assert key == ClickKey(4, "N", "head")
    assert found[key].kind == "appearance"
    assert found[key].words == "the clicks before and after lead to another place, 25 px away"


def test_what_nobody_can_tell_is_not_doubted(recording):
    first = [((0, "head"), 25.0)]
    assert unlike_the_others(recording, clicks(wrong=first)) == {}, "one side alone"
    apart = [one for one in clicks(wrong=[((4, "head"), 25.0)]) if one.frame in (0, 4)]
    assert unlike_the_others(recording, apart) == {}
