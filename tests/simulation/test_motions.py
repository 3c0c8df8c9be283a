import numpy as np
import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.simulation.motions import MOTIONS, T_POSE, motion_names
from stereotrack_core.simulation.postures import state_of
from stereotrack_core.simulation.skeleton import PEOPLE, landmarks, posed_bones
from tests.simulation.scenes import chain

P2 = PEOPLE["P2"]


def points_of(states):
    return np.array([landmarks(P2, posed_bones(P2, state)) for state in states])


def test_chain_begins_with_a_t_pose_and_fills_the_frames():
    made = chain(P2, ("cross-arms",), 150, fps=10)
    assert len(made.states) == 150
    assert [s.name for s in made.segments[:2]] == ["t-pose", "cross-arms"]
    assert made.segments[0].first == 0
    assert made.segments[-1].end <= 150
    assert all(a.end <= b.first for a, b in zip(made.segments, made.segments[1:], strict=False))


@pytest.mark.parametrize("name", MOTIONS)
def test_nothing_jumps_at_full_pace(name):
    frames = int(MOTIONS[name].seconds * 10) + 40
    speed = np.linalg.norm(np.diff(points_of(chain(P2, (name,), frames, fps=10).states), axis=0),
                           axis=2)  # fmt: skip
    assert speed.max() < 0.40


def test_unknown_motion_is_named_with_what_would_be_right():
    with pytest.raises(InputError, match=r"dance.*t-pose"):
        motion_names("t-pose+dance")


@pytest.mark.parametrize("who", PEOPLE.values(), ids=PEOPLE)
def test_t_pose_faces_north_with_the_right_hand_in_the_east(who):
    at = dict(zip(LANDMARKS, landmarks(who, posed_bones(who, state_of(who, T_POSE))), strict=True))
    right = at["right_hand"] - at["left_hand"]
    assert right[0] > 0.85 * who.stature * 0.75
    assert abs(right[1]) < 0.03
    assert abs(right[2]) < 0.03
    width = at["right_shoulder"][0] - at["left_shoulder"][0]
    assert width == pytest.approx(who.shoulder_width, abs=1e-3)
    middle = (at["left_hip"] + at["right_hip"]) / 2
    np.testing.assert_allclose(middle[:2], 0, atol=1e-9)
