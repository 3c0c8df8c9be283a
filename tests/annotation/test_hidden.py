"""A landmark is hidden where the body stands between it and the camera."""

from __future__ import annotations

import numpy as np

from stereotrack_core.annotation.click_gains import hidden_landmarks
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.body.model import body_model
from stereotrack_core.body.pose import hanging_pose, t_pose
from stereotrack_core.body.proportions import AVERAGE

FRONT, BACK, LEFT = np.array([[0.0, 3, 1.2], [0, -3, 1.2], [-3, 0, 1.2]])


def landmarks(pose):
    body = body_model(AVERAGE)
    return NINE.places(body, body.frames(pose))


def hidden(nine, places=(FRONT, BACK, LEFT)):
    found = hidden_landmarks(nine[None], NINE.names, nine[None], np.array(places))[0]
    return [{name for name, is_ in zip(NINE.names, row, strict=True) if is_} for row in found]


def test_nothing_is_hidden_of_a_t_pose_from_the_front():
    front, back, _ = hidden(landmarks(t_pose(np.array([0.0, 0, 0.95]))))
    assert not front
    assert not back


def test_a_hand_behind_the_back_is_hidden_from_the_front():
    nine = landmarks(hanging_pose(np.array([0.0, 0, 0.95])))
    nine[NINE.names.index("left_hand")] = [0.0, -0.25, 1.15]
    front, back, _ = hidden(nine)
    assert "left_hand" in front
    assert "left_hand" not in back
