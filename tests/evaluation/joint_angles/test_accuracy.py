"""Joint angles of a tracked run against those of its reference, on rendered human meshes."""

from __future__ import annotations

import numpy as np
import pytest

from stereotrack_core.evaluation.joint_angles.motion import angle_errors
from stereotrack_core.evaluation.joint_angles.series import angles_of_run, angles_of_trajectory
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run import track
from stereotrack_core.tracking.run_spec import RunSpec


@pytest.mark.slow
def test_angles_of_an_accurate_run_are_as_good_as_they_say(shared_recording):
    recording = open_recording(shared_recording("mesh-P2"))
    run = track(recording, RunSpec(preset("accurate"), preset="accurate", frames=range(60), seed=0))
    errors = angle_errors(angles_of_run(run), angles_of_trajectory(recording.reference))
    known = {
        error.angle.name.removeprefix("right_"): error
        for error in errors
        if error.angle.side != "left"
    }
    median = {kind: np.degrees(error.median) for kind, error in known.items()}
    assert median["torso_turn"] < 4.0
    assert median["torso_forward"] < 4.0
    assert median["shoulder_elevation"] < 6.0
    assert median["elbow_flexion"] < 8.0
    assert median["shoulder_plane"] < 12.0
    for error in errors:
        assert error.frames > 30, error.angle.name
        assert error.within_two_sigma > 0.8, error.angle.name
