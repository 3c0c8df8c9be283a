"""Patches are followed while they can be told again, and it is said why not further."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.follow import (
    follow_click,
    follow_patch,
    pictures_of,
)
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.description import Recording, Stream, View
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.writing import write_png, write_recording_description

RATE = np.array([2.3, -1.1])


def texture(seed: int = 0, height: int = 240, width: int = 320) -> np.ndarray:
    noise = np.random.default_rng(seed).uniform(0, 255, (height, width))
    smooth = cv2.GaussianBlur(noise, (0, 0), 2.0)
    return cv2.normalize(smooth, None, 0, 255, cv2.NORM_MINMAX).astype(np.uint8)


def moving(frames: int, rate: np.ndarray = RATE, picture: np.ndarray | None = None):
    """Pictures of a scene that moves by `rate` pixels per frame."""
    picture = texture() if picture is None else picture
    height, width = picture.shape
    for k in range(frames):
        matrix = np.array([[1.0, 0, k * rate[0]], [0, 1.0, k * rate[1]]])
        yield cv2.warpAffine(picture, matrix, (width, height), borderMode=cv2.BORDER_REFLECT)


def test_patch_is_followed_to_a_tenth_of_a_pixel():
    found = follow_patch(moving(25), np.array([150.25, 140.5]))
    assert found.reliable_until == 25
    assert found.reason == "the images end"
    expected = np.array([150.25, 140.5]) + np.arange(25)[:, None] * RATE
    assert np.abs(found.pixels - expected).max() < 0.15
    assert found.score[1:].min() > 0.95
    assert found.forward_backward_px.max() < 0.1
    assert found.sigma_px[0] == 0
    assert (np.diff(found.sigma_px) > 0).all()


def test_going_back_comes_home():
    pictures = list(moving(20))
    there = follow_patch(pictures, np.array([150.0, 140.0]))
    back = follow_patch(pictures[::-1], there.pixels[-1])
    assert np.allclose(back.pixels[-1], [150.0, 140.0], atol=0.2)


def test_it_ends_where_the_patch_leaves_the_image():
    found = follow_patch(moving(25, np.array([9.0, 0.0])), np.array([250.0, 120.0]))
    assert 5 < found.reliable_until < 9
    inside = found.pixels[: found.reliable_until]
    assert (inside[:, 0] <= 319.5).all()
    assert found.reason


def test_it_ends_where_something_else_comes_before_it():
    pictures = list(moving(10))
    pictures[6] = texture(seed=9)
    found = follow_patch(pictures, np.array([150.0, 140.0]))
    assert found.reliable_until == 6
    assert len(found.pixels) == 7
    assert found.reason.startswith(("the patch has changed too much", "following backwards"))


def test_nothing_to_hold_on_to_is_said():
    grey = np.full((100, 100), 90, dtype=np.uint8)
    found = follow_patch([grey] * 5, np.array([50.0, 50.0]))
    assert found.reliable_until == 1
    assert found.reason == "the image has no texture here"


def test_it_stops_when_asked_at_the_limit_and_at_damaged_pictures():
    found = follow_patch(moving(40), np.array([150.0, 140]))
    assert (found.reliable_until, found.reason) == (31, "the limit of 30 frames was reached")
    asked = iter([False, False, True])
    found = follow_patch(moving(20), np.array([150.0, 140]), cancelled=lambda: next(asked))
    assert (found.reliable_until, found.reason) == (3, "stopped")
    damaged = [*moving(3), None, *moving(3)]
    found = follow_patch(damaged, np.array([150.0, 140]))
    assert (found.reliable_until, found.reason) == (3, "the image cannot be read")
    with pytest.raises(ValueError, match="first image"):
        follow_patch([], np.array([1.0, 1.0]))


def test_large_pictures_have_larger_patches():
    large = [cv2.resize(picture, (1280, 960)) for picture in moving(6)]
    found = follow_patch(large, np.array([600.0, 560.0]))
    assert found.reliable_until == 6
    assert np.allclose(found.pixels[-1], [600 + 5 * 4 * RATE[0], 560 + 5 * 4 * RATE[1]], atol=0.5)


@pytest.fixture
def recording(tmp_path):
    """A stereo view whose left and right scenes move in different directions; colour pictures."""
    matrix = np.array([[300.0, 0, 159.5], [0, 300, 119.5], [0, 0, 1]])
    cameras = {
        name: Camera(name, 320, 240, matrix, np.zeros(5), False, place)
        for name, place in (
            ("N_left", RigidTransform(np.eye(3), np.array([0.1, 0, 0]))),
            ("N_right", RigidTransform.identity()),
        )
    }
    for name, sign in (("N_left", -1.0), ("N_right", 1.0)):
        (tmp_path / name).mkdir()
        for k, picture in enumerate(moving(8, sign * RATE)):
            write_png(tmp_path / name / f"{k:03d}.png", cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR))
    left, right = (Stream(name, f"{name}/%03d.png") for name in ("N_left", "N_right"))
    views = (View("N", "stereo", right, left=left),)
    recording = Recording(tmp_path, "moving", 10.0, views, cameras)
    write_recording_description(recording)
    return recording


@pytest.mark.parametrize("colour", [False, True])
@pytest.mark.parametrize(("camera", "sign"), [("N_right", 1.0), ("N_left", -1.0)])
def test_click_is_followed_in_its_own_camera_both_ways(recording, colour, camera, sign):
    click = Click(4, camera, "left_elbow", (150.0, 120.0))
    with FrameReader(recording, colour=colour) as reader:
        after = follow_click(reader, click, range(4, 8))
        before = follow_click(reader, click, range(4, -1, -1))
    assert after.frame.tolist() == [4, 5, 6, 7]
    assert before.frame.tolist() == [4, 3, 2, 1, 0]
    assert np.allclose(after.followed.pixels[-1], [150, 120] + 3 * sign * RATE, atol=0.2)
    assert np.allclose(before.followed.pixels[-1], [150, 120] - 4 * sign * RATE, atol=0.2)
    assert (
        after.words()
        == f"left elbow in {camera}: followed to frame 7; stopped because the images end"
    )


def test_damaged_frames_and_foreign_cameras_are_told(recording):
    (recording.folder / "N_right" / "005.png").write_bytes(b"no picture")
    click = Click(4, "N_right", "left_elbow", (150.0, 120.0))
    with FrameReader(recording, colour=False) as reader:
        found = follow_click(reader, click, range(4, 8))
        assert found.followed.reason == "the image cannot be read"
        assert found.followed.reliable_until == 1
        with pytest.raises(InputError, match="cannot be read"):
            follow_click(reader, replace(click, frame=5), range(5, 8))
        with pytest.raises(InputError, match="no stream of the recording uses the camera 'X'"):
            list(pictures_of(reader, "X", [0]))
