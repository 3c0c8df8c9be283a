"""How the body moved is seen in the images, although joints hide under skin that turns."""

import numpy as np
import pytest

from stereotrack_core.annotation.follow_body import FollowedBody, follow_body, told_by
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.recording.reader import FrameReader
from tests.annotation.scenes import clicks_of, one_camera_off


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
