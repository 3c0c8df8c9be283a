"""Silhouettes: edges at half the height of the difference, and those of ordinary cameras."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stereotrack_core.depth import mono_silhouettes
from stereotrack_core.depth.cloud import edge_map
from stereotrack_core.depth.match import Region
from stereotrack_core.depth.mono_silhouettes import MonoSilhouettes, clean_plate
from stereotrack_core.depth.outline import difference_of, same_structure, seen_at, sharp_outline
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.sources import StereoFrame
from stereotrack_core.pose_model.detect import Whereabouts
from stereotrack_core.pose_model.detector import DetectedPose, PersonBox
from stereotrack_core.recording.description import Recording, Stream, View
from stereotrack_core.recording.reader import FrameSet, ViewImages
from tests.depth.scenes import pair_with_disparity, texture
from tests.tracking.recordings import camera_towards_the_middle

HEIGHT, WIDTH = 120, 160
NOTHING = np.zeros((HEIGHT, WIDTH), dtype=bool)


def _wall(seed=1):
    """Textured, of middling grey."""
    return 90.0 + 0.25 * (texture(HEIGHT, WIDTH, seed=seed) - 127.0)


def _picture(body, grey, *, blur=1.2, wall=None, times=8):
    """Body given by a function of (column, row), as a lens that blurs shows it before a wall."""
    at = (np.arange(-0.5 + 0.5 / times, max(HEIGHT, WIDTH), 1.0 / times),) * 2
    u, v = np.meshgrid(at[0][: WIDTH * times], at[1][: HEIGHT * times])
    share = body(u, v).astype(float).reshape(HEIGHT, times, WIDTH, times).mean(axis=(1, 3))
    share = cv2.GaussianBlur(share, (0, 0), blur)
    mixed = share * grey + (1.0 - share) * (_wall() if wall is None else wall)
    return np.rint(mixed).clip(0, 255).astype(np.uint8)


def _empty():
    return np.rint(_wall()).astype(np.uint8)


def _disc(radius, middle=(80.3, 60.7)):
    return lambda u, v: np.hypot(u - middle[0], v - middle[1]) < radius


def _mean_radius(found):
    return float(np.sqrt(found.sum() / np.pi))


def _found(picture, foreground=NOTHING):
    return sharp_outline(difference_of(picture, _empty()), foreground)


@settings(max_examples=20)
@given(
    radius=st.floats(12.0, 45.0),
    grey=st.sampled_from([20.0, 160.0, 200.0, 250.0]),
    blur=st.floats(0.6, 1.8),
)
def test_the_edge_of_a_blurred_body_is_where_the_body_ends(radius, grey, blur):
    found = _found(_picture(_disc(radius), grey, blur=blur))
    assert _mean_radius(found) == pytest.approx(radius, abs=0.7)


@settings(max_examples=20)
@given(edge=st.floats(60.0, 100.0), slope=st.floats(0.1, 0.4), leans=st.sampled_from([-1, 1]))
def test_a_straight_edge_is_right_in_every_row(edge, slope, leans):
    slope *= leans
    found = _found(_picture(lambda u, v: u < edge + slope * (v - 60.0), 210.0))
    rows = np.arange(5, HEIGHT - 5)
    off = found[rows].sum(axis=1) - 0.5 - (edge + slope * (rows - 60.0))
    assert abs(off.mean()) < 0.7
    assert abs(off).max() < 1.7


def test_a_place_where_the_body_looks_like_the_wall_is_closed():
    picture = _picture(_disc(30.0), 200.0)
    like_wall = _disc(4.0)(*np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT)))
    picture[like_wall] = _empty()[like_wall]
    found = _found(picture)
    assert found[like_wall].all()
    assert _mean_radius(found) == pytest.approx(30.0, abs=0.7)


def test_the_edge_runs_between_the_last_pixel_inside_and_the_first_outside():
    outline, lens = NOTHING.copy(), (400.0, 80.0, 60.0)
    outline[40:80, 60:100] = True
    found = edge_map(outline, np.ones(outline.shape, np.float32), lens, np.eye(3, 4))
    middle = found.distance[60 - int(found.pinhole[4])]
    left = 60 - int(found.pinhole[3])
    np.testing.assert_allclose(middle[left - 3 : left + 3], [2.5, 1.5, 0.5, -0.5, -1.5, -2.5])


@pytest.mark.parametrize("noise", [0.0, 12.0])
def test_both_pictures_show_one_surface_however_noisy_they_are(noise):
    disparity, rng = np.full((HEIGHT, WIDTH), np.float32(9.0)), np.random.default_rng(0)
    left, right = pair_with_disparity(disparity)
    right[40:80, 50:90] = 255 - right[40:80, 50:90]
    noisy = [one + rng.normal(0.0, noise, one.shape) for one in (left, right)]
    left, right = (one.clip(0, 255).astype(np.uint8) for one in noisy)
    frame = StereoFrame(left, right, None, None, 11, noise)
    same = seen_at(frame, disparity, Region.whole(WIDTH, HEIGHT))
    assert same[5:30, 5:-20].mean() > 0.95
    assert same[45:75, 55:85].mean() < 0.1


CAMERAS = {
    name: replace(camera_towards_the_middle(name, np.array(at)), width=384, height=312)
    for name, at in {"N": (0.0, 3.0, 1.5), "S": (0.0, -3.0, 1.5)}.items()
}

EMPTY = np.full((CAMERAS["N"].height, CAMERAS["N"].width), 60, np.uint8)


class Pictures:
    """Pictures of the empty scene of some views; S has none."""

    def __init__(self, empty, frames=()):
        self.empty, self.frames = empty, frames

    def background(self, view):
        return None if view == "S" else (None, self.empty)

    def frame_set(self, k):
        return FrameSet(k, dict.fromkeys("NS", ViewImages(image=self.frames[k])))


@pytest.fixture
def silhouettes(monkeypatch):
    monkeypatch.setattr(mono_silhouettes, "load_detector", lambda: None)
    streams = Stream("N", "N.mp4", "N.png"), Stream("S", "S.mp4")
    views = tuple(View(stream.camera, "mono", stream) for stream in streams)
    recording = Recording(Path("mono"), "mono", 10.0, views, CAMERAS)
    made = MonoSilhouettes(recording, DepthParameters(), ("N", "S"))
    made.learn(Pictures(EMPTY), range(1))
    return made


def shown(picture):
    return FrameSet(0, dict.fromkeys("NS", ViewImages(image=picture)))


def test_what_differs_from_the_empty_scene_is_the_person(silhouettes):
    picture = EMPTY.copy()
    picture[20:90, 40:80] = 180
    found, problems = silhouettes.of(shown(picture))
    assert not problems
    assert set(found) == {"N"}  # S has no picture of the empty scene
    view = found["N"]
    np.testing.assert_array_equal(view.outline[22:88, 42:78], True)
    assert abs(int(view.outline.sum()) - 70 * 40) < 200
    assert not np.isfinite(view.range_z).any()
    assert not view.foreground.any()
    assert view.disparity is None


def structured(seed):
    return texture(*EMPTY.shape, seed=seed, blur=4.0).astype(np.uint8)


def test_a_picture_that_has_changed_everywhere_is_told(silhouettes):
    silhouettes.learn(Pictures(structured(1)), range(1))
    found, problems = silhouettes.of(shown(structured(2)))
    assert not found
    assert set(problems) == {"N"}
    assert "View N provides no silhouette: more than half" in problems["N"]
    assert silhouettes.of(FrameSet(0, {})) == ({}, {})
    unread = silhouettes.of(FrameSet(0, {}, {"N": "View N, frame 0: it is damaged."}))
    assert unread == ({}, {"N": "View N, frame 0: it is damaged."})


@pytest.mark.parametrize(
    "light",
    [
        lambda grey: 0.7 * grey,
        lambda grey: 1.3 * grey,
        lambda grey: 255 * (grey / 255) ** 0.6,
        lambda grey: grey * np.linspace(0.85, 1.05, grey.shape[1]),
        lambda grey: cv2.warpAffine(
            grey, np.float32([[1, 0, 1], [0, 1, 0]]), grey.shape[::-1], borderMode=1
        ),
    ],
    ids=["darker", "brighter", "gamma", "window", "moved"],
)
def test_other_light_and_a_camera_that_was_touched_leave_the_silhouette(silhouettes, light):
    empty = structured(1)
    silhouettes.learn(Pictures(empty), range(1))
    picture = empty.copy()
    picture[60:270, 120:240] = structured(5)[60:270, 120:240] // 4
    found, problems = silhouettes.of(shown(light(picture.astype(float)).clip(0, 255).astype("u1")))
    assert not problems
    person = np.zeros(EMPTY.shape, dtype=bool)
    person[60:270, 120:240] = True
    outline = found["N"].outline
    assert (outline & person).sum() > 0.9 * (outline | person).sum()


def test_silhouettes_can_be_switched_off(silhouettes):
    recording = Recording(
        Path("mono"), "mono", 10.0, (View("N", "mono", Stream("N", "N.mp4", "N.png")),), CAMERAS
    )
    assert silhouettes
    for name in ("silhouettes", "background_empty_scene"):
        off = replace(DepthParameters(), **{name: False})
        assert not MonoSilhouettes(recording, off, ("N",))


class BrightPerson:
    """Detector of one person, the only thing that is brighter than 200."""

    def landmarks(self, picture, crop, *, mask=False):
        bright = picture > 200
        middle = np.argwhere(bright).mean(axis=0)[::-1]
        sure, circle = np.ones(33), np.array([middle, middle - [0.0, 60.0]])
        points = np.tile(middle, (33, 1))
        seen = bright.astype(np.float32) if mask else None
        return DetectedPose(points, sure, sure, 1.0, circle, seen)

    def find_people(self, picture, **_):
        middle = np.argwhere(picture > 200).mean(axis=0)[::-1]
        return [PersonBox(middle, middle - [0.0, 60.0], 1.0)]


def test_a_scene_that_nobody_recorded_empty_is_what_is_seen_beside_the_person(monkeypatch):
    monkeypatch.setattr(mono_silhouettes, "load_detector", BrightPerson)
    monkeypatch.setattr(mono_silhouettes, "person_boxes", lambda _recording: {})
    view = View("S", "mono", Stream("S", "S.mp4"))
    recording = Recording(Path("mono"), "mono", 10.0, (view,), CAMERAS)
    empty = structured(1) // 2
    frames = [empty.copy() for _ in range(20)]
    for k, frame in enumerate(frames):  # sways: most of its place is never seen
        frame[100:250, 150 + k : 220 + k] = 255
    made = MonoSilhouettes(recording, DepthParameters(), ("S",))
    made.learn(Pictures(None, frames), range(20))
    found, problems = made.of(shown(frames[10]))
    assert not problems
    person = frames[10] == 255
    outline = found["S"].outline
    assert (outline & person).sum() > 0.95 * (outline | person).sum()
    assert made.made == ("S",)


@pytest.mark.parametrize("gain", [0.5, 0.8, 1.4])
def test_a_shadow_shows_the_structure_of_the_empty_scene_and_a_person_does_not(gain):
    before = (0.5 * texture(HEIGHT, WIDTH, seed=1)).astype(np.uint8)
    now = np.rint(gain * before).astype(np.uint8)
    now[40:80, 50:110] = (0.5 * texture(HEIGHT, WIDTH, seed=2)).astype(np.uint8)[40:80, 50:110]
    same = same_structure(now, before, noise=1.0)
    assert same[:, :40].all()
    assert same[45:75, 55:105].mean() < 0.4


def test_what_the_detector_leaves_of_the_person_s_edge_is_not_in_the_scene():
    empty = structured(1) // 2
    frames = [empty.copy() for _ in range(12)]
    for k, frame in enumerate(frames):
        left = 40 + 48 * (k // 6)  # half of the time the person is elsewhere
        frame[100:200, left - 2 : left + 22] = 190  # a blurred edge
        frame[100:200, left : left + 20] = 255
    where = Whereabouts(np.array([50.0, 150.0]))
    plate = clean_plate(BrightPerson(), frames, where)
    np.testing.assert_array_equal(plate, empty)
