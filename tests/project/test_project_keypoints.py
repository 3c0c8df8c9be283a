"""Keypoints of detectors in a project."""

import numpy as np

from stereotrack_core.project.detectors import removal
from stereotrack_core.project.predictions import DetectorState
from stereotrack_core.recording.keypoints import keypoints_of

ROWS = (
    (2, "S_cam", "left_wrist", 3.5, 4.5, 0.75, "pose", 0),
    (1, "S_cam", "left_wrist", 1.5, 2.5, 0.5, "pose", 0),
    (1, "S_cam", "left_wrist", 9.0, 2.5, 0.5, "pose", 1),
    (1, "S_cam", "nose", 1.0, 2.0, 1.0, "other", 0),
)


def test_keypoints_come_back_and_are_no_edits(project):
    found = keypoints_of(ROWS)
    project.keypoints.put(DetectorState(("other", "pose"), found, ()))
    stored = project.keypoints.all()
    assert stored.fingerprint() != ""
    np.testing.assert_array_equal(stored.frame, [1, 1, 1, 2])
    assert stored.of_frame(2).place.tolist() == [[3.5, 4.5]]
    assert len(project.keypoints.at(1)) == 3
    assert project.keypoints.all("other").keypoint.tolist() == ["nose"]
    before, after = removal(project, "pose")
    project.keypoints.put(after)
    assert project.keypoints.sources() == {"other": 1}
    project.keypoints.put(before)
    assert project.keypoints.all().fingerprint() == stored.fingerprint()
    assert project.undo() is None
