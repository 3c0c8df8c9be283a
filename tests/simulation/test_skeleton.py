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
    between,
    difference,
    landmarks,
    moved,
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


@settings(max_examples=40, deadline=None)
@given(person, posture, posture, stand)
def test_step_between_two_states_leads_from_one_to_the_other(who, how, then, where):
    a, b = state_of(who, how), state_of(who, then, where)
    np.testing.assert_allclose(difference(moved(a, difference(a, b)), b), 0, atol=1e-7)
    half = between(a, b, 0.5)
    np.testing.assert_allclose(half.position, (a.position + b.position) / 2)
    np.testing.assert_allclose(half.girdle, (a.girdle + b.girdle) / 2)


def test_shoulders_rise_a_little_with_raised_arms():
    who = PEOPLE["P2"]
    up = Arm((0.2, 0.1, 0.95), (1.0, 0.0, 0.0))
    lifted = named(landmarks(who, posed_bones(who, state_of(who, Posture(up, up)))))
    hanging = named(landmarks(who, posed_bones(who, state_of(who, Posture()))))
    rise = lifted["left_shoulder"][2] - hanging["left_shoulder"][2]
    assert 0.02 < rise < 0.08


def test_hand_lies_in_the_middle_between_wrist_and_fingertip():
    who = PEOPLE["P1"]
    bones = posed_bones(who, state_of(who, T_POSE))
    at = named(landmarks(who, bones))
    wrist_to_hand = np.linalg.norm(at["right_hand"] - bones.joint[BONE["hand_right"]])
    assert wrist_to_hand == pytest.approx(who.hand / 2)
