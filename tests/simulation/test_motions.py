import numpy as np
import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.simulation.motions import MOTIONS, Part, motion_names, scheduled
from stereotrack_core.simulation.people import PEOPLE
from stereotrack_core.simulation.skeleton import BONE, SIDES, SIGN, landmarks, posed_bones
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


def test_arms_really_cross():
    made = chain(P2, ("cross-arms",), 80, fps=10)
    hands = points_of(made.states)[:, [LANDMARKS.index("left_hand"), LANDMARKS.index("right_hand")]]
    across = hands[:, 0, 0] - hands[:, 1, 0]
    assert across.max() > 0.25
    assert across.min() < -1.2


def test_hands_reach_the_shoes():
    made = chain(P2, ("tie-shoes",), 71, fps=10)
    low = points_of(made.states)[:, LANDMARKS.index("left_hand"), 2].min()
    assert low < 0.3


def test_leaving_leads_out_of_the_volume_and_back():
    made = chain(P2, ("leave-and-return",), 118, fps=10)
    hips = points_of(made.states)[:, LANDMARKS.index("left_hip"), :2]
    assert np.linalg.norm(hips, axis=1).max() > 2.5
    assert np.linalg.norm(hips[-3]) < 0.5


def test_planted_feet_do_not_slide():
    states = MOTIONS["walk"].states(P2, 100)
    ankles = np.array([state.ankles for state in states])
    steps = np.linalg.norm(np.diff(ankles, axis=0), axis=2)
    planted = steps.min(axis=1)
    assert (planted < 1e-9).mean() > 0.9
    assert planted.max() < 0.02


def test_unknown_motion_is_named_with_what_would_be_right():
    with pytest.raises(InputError, match=r"dance.*t-pose"):
        motion_names("t-pose+dance")


def test_arms_are_crossed_for_fifty_frames():
    part = Part("cross-arms", "hold-arms-crossed", 0, 130)
    points = points_of(scheduled(P2, (part,), 130).states)
    left, right = points[:, 4], points[:, 5]  # hands
    crossed = left[:, 0] > right[:, 0]
    assert 40 <= crossed.sum() <= 70
    assert crossed[70:110].all()


def clavicle_angles(person, states):
    """Elevation and protraction against the chest at rest, (frames, 2, 2) degrees."""
    rows = []
    for state in states:
        bones = posed_bones(person, state)
        for name, s in zip(SIDES, SIGN, strict=True):
            axis = bones.rotation[BONE["chest"]].T @ bones.rotation[BONE[f"clavicle_{name}"]][:, 0]
            rows.append((np.arcsin(s * axis[2]), np.arctan2(s * axis[1], axis[0])))
    return np.degrees(rows).reshape(-1, 2, 2)


def test_a_shrug_lifts_both_then_one_then_the_other_and_goes_round():
    angles = clavicle_angles(P2, MOTIONS["shrug"].states(P2, 105))
    rise = angles[..., 0] - angles[0, :, 0]
    assert rise[14].min() > 25
    assert rise[35, 0] > 25 > 0 > rise[35, 1]
    assert rise[58, 1] > 25 > 0 > rise[58, 0]
    forward = angles[70:, :, 1] - angles[0, :, 1]
    assert (forward.min(axis=0) < -11).all()
    assert (forward.max(axis=0) > 14).all()
    assert (forward.argmin(axis=0) < forward.argmax(axis=0)).all()
    assert (rise[70:].min(axis=0) < -4).all()
