"""Sets of landmarks are data: the nine are one of them, and slips are named."""

import json
from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.annotation.landmark_set import NINE, Landmark, LandmarkSet, landmark_set_of
from stereotrack_core.body.model import body_model, landmarks
from stereotrack_core.body.pose import Pose, hanging_pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.body.skeleton import PARTS
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.recording.landmarks import LANDMARKS

WRIST = Landmark("left_wrist", "#112233", "left_forearm", "left_forearm", along=0.7)


def some_pose() -> Pose:
    torso = rotation_from_vector(np.array([0.2, -0.1, 0.7]))
    pose = hanging_pose(np.array([0.3, 1.2, 0.9]), torso)
    bent = rotation_from_vector(np.linspace(-0.8, 0.9, 3 * len(PARTS)).reshape(-1, 3))
    bent[0] = np.eye(3)
    return replace(pose, rotations=pose.rotations @ bent)


def test_the_nine_are_where_the_body_model_has_them():
    body, pose = body_model(AVERAGE), some_pose()
    assert NINE.names == LANDMARKS
    np.testing.assert_allclose(
        NINE.places(body, body.frames(pose)), landmarks(body, pose), atol=1e-12
    )


def test_another_set_needs_no_code():
    body, pose = body_model(AVERAGE), some_pose()
    facts = json.loads(json.dumps(LandmarkSet("with wrist", (*NINE.landmarks, WRIST)).facts()))
    longer = landmark_set_of(facts)
    assert longer == LandmarkSet("with wrist", (*NINE.landmarks, WRIST))
    places = longer.places(body, body.frames(pose))
    elbow, hand = (places[LANDMARKS.index(name)] for name in ("left_elbow", "left_hand"))
    np.testing.assert_allclose(places[-1], elbow + 0.7 * (hand - elbow), atol=1e-12)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"colour": "red"}, "#rrggbb"),
        ({"limb": "tail"}, "left_forearm"),
        ({"part": "tail"}, "left_thigh"),
        ({"name": "a,b"}, "letters"),
        ({"along": 7.0}, "not on the body"),
        ({"offset": (0.0, float("nan"), 0.0)}, "not on the body"),
        ({"mirror": "right_wrist"}, "does not name it as its mirror"),
        ({"name": "head"}, "2 landmarks"),
    ],
)
def test_slips_are_named(wrong: dict[str, object], said: str):
    with pytest.raises(InputError, match=said):
        LandmarkSet("mine", (*NINE.landmarks, replace(WRIST, **wrong)))


@pytest.mark.parametrize(
    "facts",
    [{}, {"name": "x", "landmarks": 3}, {"name": "x", "landmarks": [4]},
     {"name": "x", "landmarks": [{"place": 1}]}, {"name": "x", "landmarks": []}],
)  # fmt: skip
def test_data_that_are_no_set_are_refused(facts: dict[str, object]):
    with pytest.raises(InputError):
        landmark_set_of(facts)
