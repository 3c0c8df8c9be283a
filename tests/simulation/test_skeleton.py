import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.simulation.motions import T_POSE
from stereotrack_core.simulation.people import PEOPLE
from stereotrack_core.simulation.postures import Arm, Posture, Stand, state_of
from stereotrack_core.simulation.skeleton import (
    BONE,
    landmarks,
    posed_bones,
)

angle = st.floats(-30, 30)
wrist = st.tuples(st.floats(-0.5, 0.9), st.floats(0.1, 0.9), st.floats(-0.9, 0.9))
posture = st.builds(
    Posture,
    left=st.builds(Arm, wrist, bend=angle),
    right=st.builds(Arm, wrist, turn=angle),
    lean=st.tuples(angle, angle, angle),
    twist=angle,
    look=angle,
    drop=st.floats(0.0, 0.4),
    lifted=st.tuples(st.floats(-5, 27), st.floats(-5, 27)),
    forward=st.tuples(st.floats(-14, 16), st.floats(-14, 16)),
)
stand = st.builds(
    Stand,
    st.tuples(st.floats(-2, 2), st.floats(-2, 2)).map(np.array),
    st.floats(-3, 3),
)
person = st.sampled_from(list(PEOPLE.values()))


def named(points):
    return dict(zip(LANDMARKS, points, strict=True))


@pytest.mark.parametrize("who", PEOPLE.values(), ids=PEOPLE)
def test_t_pose_faces_north_with_the_right_hand_in_the_east(who):
    at = named(landmarks(who, posed_bones(who, state_of(who, T_POSE))))
    right = at["right_hand"] - at["left_hand"]
    assert right[0] > 0.85 * who.stature * 0.75
    assert abs(right[1]) < 0.03
    assert abs(right[2]) < 0.03
    assert at["right_shoulder"][0] - at["left_shoulder"][0] == pytest.approx(
        who.shoulder_width, abs=1e-3
    )
    middle = (at["left_hip"] + at["right_hip"]) / 2
    np.testing.assert_allclose(middle[:2], 0, atol=1e-9)


@settings(max_examples=40, deadline=None)
@given(person, posture, stand)
def test_bones_keep_their_lengths_in_every_posture(who, how, where):
    bones = posed_bones(who, state_of(who, how, where))
    at = {name: bones.joint[index] for name, index in BONE.items()}
    for side in ("left", "right"):
        for first, second, length in (
            ("upper_arm", "forearm", who.upper_arm),
            ("forearm", "hand", who.forearm),
            ("thigh", "shank", who.thigh),
        ):
            got = np.linalg.norm(at[f"{first}_{side}"] - at[f"{second}_{side}"])
            assert got == pytest.approx(length, rel=1e-9)


@settings(max_examples=40, deadline=None)
@given(person, posture, stand)
def test_ankles_are_where_they_are_to_be(who, how, where):
    state = state_of(who, how, where)
    bones = posed_bones(who, state)
    feet = bones.joint[[BONE["foot_left"], BONE["foot_right"]]]
    np.testing.assert_allclose(feet, state.ankles, atol=1e-6)
