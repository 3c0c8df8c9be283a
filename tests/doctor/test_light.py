"""Light, flicker, shadows, noise and movement, named before tracking."""

import cv2
import numpy as np
import pytest

from stereotrack_core.doctor.light import check_backgrounds, check_light
from stereotrack_core.recording.reader import FrameSet, ViewImages
from tests.depth.recordings import stereo_recording
from tests.depth.scenes import texture

HEIGHT, WIDTH, FRAMES = 240, 320, 60
SMOOTH = cv2.GaussianBlur(texture(HEIGHT, WIDTH, seed=3).astype(np.float64), (0, 0), 2.0)
SCENE = 100.0 + 30.0 * (SMOOTH - SMOOTH.mean()) / SMOOTH.std()


class Pictures:
    frame_count = FRAMES

    def __init__(self, changed):
        self._changed = changed

    def background(self, _view):
        return None, _as_image(SCENE)

    def frame_set(self, k):
        image = _as_image(self._changed(_with_person(SCENE, 100 + k), k))
        return FrameSet(k, {"A": ViewImages(image=image)})


def _as_image(picture):
    return np.clip(np.rint(picture), 0, 255).astype(np.uint8)


def _with_person(scene, left, seed=9):
    shown = scene.copy()
    shown[60:200, left : left + 30] = np.clip(texture(140, 30, seed=seed), 20, 220)
    return shown


def told(changed):
    return list(check_light(stereo_recording(), Pictures(changed)))


def _moved(picture, dx):
    matrix = np.array([[1.0, 0.0, dx], [0.0, 1.0, 0.0]])
    return cv2.warpAffine(picture, matrix, (WIDTH, HEIGHT), borderMode=cv2.BORDER_REPLICATE)


def _shadow(picture, _frame):
    dark = np.ones_like(picture)
    dark[130:230, 20:80] = 0.6
    return picture * dark


def test_the_light_of_the_empty_scene_is_not_told_of():
    assert told(lambda picture, _: picture) == []


@pytest.mark.parametrize(
    ("changed", "severity", "words"),
    [
        (lambda p, _: 0.88 * p, "note", "12 % darker"),
        (lambda p, _: 0.5 * p, "warning", "49 % darker"),
        (lambda p, k: p * (1 + 0.2 * np.sin(k / 10)), "note", "change by 2"),
        (lambda p, k: p + np.random.default_rng(k).normal(0, 8, p.shape), "note", "grey levels"),
        (_shadow, "note", "shadows or reflections cover"),
        (lambda p, _: _moved(p, 3.0), "warning", "the camera has moved by 5.9 px"),
        (lambda p, _: np.clip(3.0 * p, 0, 255), "warning", "white"),
        (lambda p, _: cv2.GaussianBlur(p, (0, 0), 2.0), "note", "blurred by 1.6"),
    ],
    ids=["gain", "dark", "exposure", "noise", "shadow", "moved", "white", "blur"],
)
def test_what_has_changed_is_named_with_its_size(changed, severity, words):
    findings = [one for one in told(changed) if words in one.what]
    assert [one.severity for one in findings] == [severity]
    assert findings[0].where == "view A"
    assert findings[0].remedy


def test_a_camera_that_is_moved_while_recording_is_told_of():
    findings = told(lambda p, k: _moved(p, 4.0 if k > 30 else 0.0))
    assert any("moved while recording" in one.what for one in findings)


def test_lamps_that_flicker_are_told_of():
    findings = told(lambda p, k: p * (1 + 0.06 * np.sin(2 * np.pi * 5.0 * k / 11.5)))
    assert any("flickers" in one.what for one in findings)


def with_person(image):
    shown = image.copy()
    shown[20:50, 30:45] = 90
    return [shown, image]


def test_backgrounds_of_other_views_are_named():
    one, two, three = (texture(60, 80, seed=seed) for seed in (1, 2, 3))
    shown = {"N": with_person(one), "O": with_person(two), "S": with_person(three)}
    assert not list(check_backgrounds(shown, {"N": one, "O": two, "S": three}))
    [copied] = check_backgrounds(shown, {"N": one, "O": one, "S": three})
    assert copied.where == "view O, background"
    assert "it is that of view N" in copied.what
    [exchanged] = check_backgrounds(shown, {"N": two, "O": one, "S": three})
    assert exchanged.where == "view N, background"
    assert "that of view O fits the images better" in exchanged.what
    elsewhere = 255 - three
    [foreign] = check_backgrounds(shown, {"N": one, "O": two, "S": elsewhere})
    assert (foreign.where, foreign.severity) == ("view S, background", "warning")
