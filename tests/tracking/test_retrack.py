"""A stretch of a run is tracked again around clicks, and the rest of the run stays."""

import dataclasses

import numpy as np
import pytest

from stereotrack_core.annotation.click import Click, click_detections
from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.errors import Cancelled
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.tracking.frame import assembled
from stereotrack_core.tracking.prepare import Start
from stereotrack_core.tracking.repeating import stored_spec
from stereotrack_core.tracking.retrack import Retrack
from stereotrack_core.tracking.run_spec import RunSpec
from stereotrack_core.tracking.stored import shape_of_meta
from tests.tracking.recordings import SMALL, write_depth_recording
from tests.tracking.running import tracked_frames
from tests.tracking.scenes import pose_with_arms

STRETCH = range(2, 6)


def _pose(k):
    return pose_with_arms(
        [1, 0.1 * k, 0], [1, 0.2 * k, 0], [-1, 0.1 * k, 0], [-1, 0.1 * k, 0.1], place=(0, 0, 0.95)
    )


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    body = body_model(AVERAGE, SMALL.body)
    folder = tmp_path_factory.mktemp("recording") / "cones"
    return write_depth_recording(folder, body, [_pose(k) for k in range(7)])


@pytest.fixture(scope="module")
def tracked(recording):
    """All frames and the run, whose left hand is somewhere else in frames 3 and 4."""
    unaided = dataclasses.replace(recording, reference=None)
    found, done = tracked_frames(unaided, RunSpec(SMALL, "fast", frames=range(7)))
    frames, origin = [one.without_cloud() for one in found], done.origin()
    for k in (3, 4):
        points = frames[k].landmarks + np.eye(9)[LANDMARKS.index("left_hand")][:, None] * 0.4
        frames[k] = dataclasses.replace(frames[k], landmarks=points)
    return frames, assembled(frames, origin.state_names, origin.meta)


@pytest.fixture
def task(recording, tracked):
    frames, run = tracked
    clicks = [
        Click(4, name, landmark, tuple(camera.project(recording.reference.points[4, k])))
        for name, camera in recording.cameras.items()
        for k, landmark in enumerate(LANDMARKS)
    ]
    used = click_detections(clicks, recording.cameras, 2.0, "my.stereotrack")
    before = frames[STRETCH.start - 1]
    spec = dataclasses.replace(stored_spec(run).spec, frames=STRETCH, clicks=used)
    unaided = dataclasses.replace(recording, reference=None)
    start = Start(before.pose, before.P, shape_of_meta(run.meta))
    return Retrack(unaided, spec, range(7), start)


def test_the_stretch_is_tracked_again_and_the_rest_stays(recording, tracked, task):
    frames, run = tracked
    told = []
    found = task.tracked(told.append)
    assert told == [one.frame for one in found.frames] == list(STRETCH)
    new = found.into(run, frames)
    truth = recording.reference.points
    away = np.linalg.norm(new.landmarks - truth, axis=-1)
    assert np.linalg.norm(run.landmarks - truth, axis=-1)[3:5].max() > 0.3
    assert away.max() < 0.08
    assert away[4].max() < 0.04
    for k in (0, 1, 6):
        np.testing.assert_array_equal(new.landmarks[k], run.landmarks[k])
        np.testing.assert_array_equal(new.P[k], run.P[k])
    assert new.meta["retracked"] == [[2, 5]]
    assert new.meta["clicks"]["count"] == 36
    assert new.meta["preset"] == "fast"
    assert (stored_spec(run).retracked, stored_spec(new).retracked) == (False, True)
    again = found.into(new, frames)
    assert again.meta["retracked"] == [[2, 5], [2, 5]]


def test_it_can_be_stopped(task):
    with pytest.raises(Cancelled):
        task.tracked(cancelled=lambda: True)
