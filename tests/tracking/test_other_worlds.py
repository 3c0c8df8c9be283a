"""In worlds whose z does not point up a person is tracked as in others, and stays in that world."""

import dataclasses

import numpy as np
import pytest

from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.calibrate.align import aligned
from stereotrack_core.evaluation.joint_angles import angles_of_run
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.geometry.upright import Upright
from stereotrack_core.tracking.run import track
from stereotrack_core.tracking.run_spec import RunSpec
from stereotrack_core.tracking.stored import upright_run
from tests.tracking.recordings import SMALL, write_depth_recording
from tests.tracking.running import tracked_frames
from tests.tracking.scenes import pose_with_arms

BODY = body_model(AVERAGE, SMALL.body)
POSE = pose_with_arms([1, 0, 0], [1, 0, 0], [-1, 0, 0], [-1, 0, 0], place=(0, 0, 0.95))


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """Two frames of four depth views with masks."""
    folder = tmp_path_factory.mktemp("worlds") / "cones"
    return write_depth_recording(folder, BODY, [POSE] * 2)


def landmarks_in(recording, axis, init):
    world = RigidTransform(Upright(axis).rotation.T, np.zeros(3))
    turned = dataclasses.replace(recording, cameras=aligned(recording.cameras, world))
    frames, done = tracked_frames(turned, RunSpec(SMALL, init=init), range(2))
    meta = done.origin().meta
    assert all(frame.tracked for frame in frames)
    return np.array([world.inverse().apply(frame.landmarks) for frame in frames]), meta


def test_the_same_person_is_tracked_in_its_own_world(recording):
    usual, meta = landmarks_in(recording, "z", "tpose")
    assert meta["from_recording"] == {}
    for axis in ("y", "-y"):
        found, meta = landmarks_in(recording, axis, "tpose")
        assert meta["from_recording"] == {"up_axis": axis}
        assert np.abs(found - usual).max() < 1e-3
    looked_for, _ = landmarks_in(recording, "y", "auto")
    assert np.abs(looked_for - usual).max() < 0.08


def test_a_run_of_another_world_is_turned_upright_for_what_counts_on_that(recording):
    (usual, _), runs = landmarks_in(recording, "z", "tpose"), {}
    for axis in ("z", "y"):
        world = RigidTransform(Upright(axis).rotation.T, np.zeros(3))
        turned = dataclasses.replace(recording, cameras=aligned(recording.cameras, world))
        runs[axis] = track(turned, RunSpec(SMALL, init="tpose"))
    assert upright_run(runs["z"]) is runs["z"]
    found = upright_run(runs["y"])
    assert np.abs(found.landmarks - usual).max() < 1e-3
    assert np.abs(found.x - runs["z"].x).max() < 1e-2
    assert np.allclose(found.P, runs["z"].P, atol=1e-6)
    angles = {axis: angles_of_run(run) for axis, run in runs.items()}
    assert np.allclose(angles["y"].angle, angles["z"].angle, atol=0.02, equal_nan=True)
