"""Points and bodies are followed through the images, and it is known when they are lost."""

import cv2
import numpy as np
import pytest

from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.follow import follow_clicks, follow_points, pictures_of
from stereotrack_core.annotation.follow_body import FollowedBody, follow_body, told_by
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.description import Recording, Stream, View
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.writing import write_png, write_recording_description
from tests.annotation.scenes import clicks_of, one_camera_off

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


def last(pictures, *start, **how):
    *_, (pixels, spreads) = follow_points(pictures, np.array(start, dtype=float), **how)
    return pixels, spreads


def test_points_are_followed_to_a_tenth_of_a_pixel():
    starts = np.array([[150.25, 140.5], [90.0, 60.0]])
    found = list(follow_points(moving(25), starts))
    assert len(found) == 24
    for k, (pixels, _) in enumerate(found, start=1):
        assert np.abs(pixels - starts - k * RATE).max() < 0.15
    spreads = np.array([spread for _, spread in found])
    assert (np.diff(spreads, axis=0) > 0).all(), "the farther it goes, the less certain it is"


def test_what_leaves_the_image_or_is_covered_is_lost():
    pixels, spreads = last(moving(25, np.array([9.0, 0.0])), (250.0, 120.0), (20.0, 120.0))
    assert np.isnan([pixels[0, 0], spreads[0]]).all()
    assert np.allclose(pixels[1], [20.0 + 24 * 9.0, 120.0], atol=0.5)
    pictures = list(moving(10))
    pictures[6:] = [texture(seed=9)] * 4
    assert np.isnan(last(pictures, (150.0, 140.0))[0]).all()


def test_it_ends_where_it_is_stopped_and_at_damaged_pictures():
    start = np.array([[150.0, 140.0]])
    asked = iter([False, False, True])
    assert len(list(follow_points(moving(20), start, cancelled=lambda: next(asked)))) == 2
    assert len(list(follow_points([*moving(3), None, *moving(3)], start))) == 2
    assert list(follow_points([], start)) == []


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
def test_a_click_is_followed_in_its_own_camera_both_ways(recording, colour, camera, sign):
    click = Click(4, camera, "left_elbow", (150.0, 120.0))
    with FrameReader(recording, colour=colour) as reader:
        found = {one.frame: one for one in follow_clicks(reader, [click], range(8))}
    assert sorted(found) == [0, 1, 2, 3, 5, 6, 7]
    for frame, one in found.items():
        assert (one.camera, one.landmark) == (camera, "left_elbow")
        assert np.allclose(one.position, [150, 120] + (frame - 4) * sign * RATE, atol=0.2)
        assert one.sigma > 3.0, "the click's own error is in it"


def test_each_landmark_is_followed_up_to_its_next_click(recording):
    clicks = [
        Click(1, "N_right", "head", (150.0, 120.0)),
        Click(1, "N_right", "left_hip", (90.0, 100.0)),
        Click(4, "N_right", "head", (157.0, 116.5)),
        Click(1, "elsewhere", "head", (1.0, 1.0)),
    ]
    with FrameReader(recording, colour=False) as reader:
        found = follow_clicks(reader, clicks, (2, 3, 4, 5))
    frames = [(one.landmark, one.frame) for one in found]
    assert frames.count(("head", 3)) == 2, "from both sides"
    assert ("head", 4) not in frames
    assert frames.count(("head", 5)) == frames.count(("left_hip", 5)) == 1


def test_damaged_frames_and_foreign_cameras_are_told(recording):
    (recording.folder / "N_right" / "005.png").write_bytes(b"no picture")
    click = Click(4, "N_right", "left_elbow", (150.0, 120.0))
    with FrameReader(recording, colour=False) as reader:
        assert follow_clicks(reader, [click], (5, 6)) == ()
        with pytest.raises(InputError, match="no stream of the recording uses the camera 'X'"):
            list(pictures_of(reader, "X", [0]))


@pytest.fixture(scope="module")
def rig(clip):
    return {view.image.camera: clip.cameras[view.image.camera] for view in clip.views}


@pytest.fixture(scope="module")
def clicks(clip, rig):
    return clicks_of(clip.reference.points, rig)


@pytest.fixture(scope="module")
def reader(clip):
    with FrameReader(clip, colour=False) as reader:
        yield reader


def follow(reader, clicks, start, frame, rig, **how):
    known = proportions_of(reader.recording.subject)
    return follow_body(reader, clicks, start, frame, FollowedBody(rig, known), **how)


def test_the_body_is_seen_to_move(clip, rig, clicks, reader):
    points, off, way = clip.reference.points, [], []
    for frame in range(1, 7):
        known = [one for one in clicks if one.frame <= frame]
        step = follow(reader, known, frame, frame + 1, rig)
        assert (step.start, step.end, step.names) == (frame, frame + 1, NINE.names)
        assert told_by([step], frame + 1) == set(NINE.names)
        assert told_by([step], frame) == frozenset()
        moved = points[frame + 1] - points[frame]
        off.append(np.linalg.norm(step.shift - moved, axis=1))
        way.append(np.linalg.norm(moved, axis=1))
    assert np.median(off) < 0.5 * np.median(way)
    assert np.mean(off) < 0.6 * np.mean(way)


def test_a_camera_that_is_clicked_beside_its_calibration_is_followed_there(rig, clicks, reader):
    start = [one for one in clicks if one.frame == 3]
    moved = one_camera_off(start, next(iter(rig)), (3.0, 2.0))
    right, beside = (follow(reader, given, 3, 4, rig) for given in (start, moved))
    assert np.median(np.linalg.norm(right.shift - beside.shift, axis=1)) < 0.015


def test_without_a_trunk_far_away_or_stopped_nothing_is_known(rig, clicks, reader):
    start = [one for one in clicks if one.frame == 3]
    arms = [one for one in start if "shoulder" not in one.landmark and "hip" not in one.landmark]
    assert follow(reader, arms, 3, 4, rig) is None
    assert follow(reader, (), 3, 4, rig) is None
    assert follow(reader, start, 3, 3, rig) is None
    assert follow(reader, start, 3, 300, rig) is None
    assert follow(reader, start, 3, 4, rig, cancelled=lambda: True) is None
