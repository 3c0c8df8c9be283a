"""Joint angles of a tracked run against those of its reference, on rendered human meshes."""

from __future__ import annotations

import pytest

from stereotrack_core.evaluation.joint_angles import (
    angle_errors,
    angles_of_run,
    angles_of_trajectory,
)
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run import track
from stereotrack_core.tracking.run_spec import RunSpec


@pytest.mark.slow
def test_angles_of_an_accurate_run_are_as_good_as_documented(shared_recording):
    recording = open_recording(shared_recording("mesh-P2"))
    run = track(recording, RunSpec(preset("accurate"), preset="accurate", frames=range(60), seed=0))
    errors = angle_errors(angles_of_run(run), angles_of_trajectory(recording.reference))
    median = {name.removeprefix("right_"): one["median"] for name, one in errors.items()}
    assert median["torso_turn"] < 4.0
    assert median["torso_forward"] < 4.0
    assert median["shoulder_elevation"] < 6.0
    assert median["elbow_flexion"] < 8.0
    assert median["shoulder_plane"] < 12.0
    assert all(one["frames"] > 30 for one in errors.values())
