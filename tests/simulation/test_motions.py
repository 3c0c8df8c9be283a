import numpy as np
import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.simulation.keyed import KeyedWay
from stereotrack_core.simulation.motions import MOTIONS, T_POSE, motion_names
from stereotrack_core.simulation.people import PEOPLE
from stereotrack_core.simulation.postures import Posture, state_of
from stereotrack_core.simulation.skeleton import difference, landmarks, minimum_jerk, posed_bones
from tests.simulation.scenes import chain

P2 = PEOPLE["P2"]


def points_of(states):
    return np.array([landmarks(P2, posed_bones(P2, state)) for state in states])


def test_required_motions_are_there():
    assert set(MOTIONS) >= {
        "t-pose", "whip", "travolta", "tie-shoes", "cross-arms", "arms-at-sides", "walk", "point",
        "shrug", "reach",
    }  # fmt: skip


def test_chain_begins_with_a_t_pose_and_fills_the_frames():
    made = chain(P2, ("cross-arms",), 150, fps=10)
    assert len(made.states) == 150
    assert [s.name for s in made.segments[:2]] == ["t-pose", "cross-arms"]
    assert made.segments[0].first == 0
    assert made.segments[-1].end <= 150
    assert all(a.end <= b.first for a, b in zip(made.segments, made.segments[1:], strict=False))


def test_chain_without_t_pose_begins_with_the_motion():
    made = chain(P2, ("point",), 20, fps=10, t_pose_first=False)
    assert [s.name for s in made.segments] == ["point"]


@pytest.mark.parametrize("name", MOTIONS)
def test_nothing_jumps_at_full_pace(name):
    frames = int(MOTIONS[name].seconds * 10) + 40
    speed = np.linalg.norm(np.diff(points_of(chain(P2, (name,), frames, fps=10).states), axis=0),
                           axis=2)  # fmt: skip
    assert speed.max() < 0.40


def test_slower_pace_moves_less_from_frame_to_frame():
    fast = points_of(chain(P2, ("travolta",), 60, fps=10).states)
    slow = points_of(chain(P2, ("travolta",), 180, fps=10, pace=1 / 3).states)
    fastest = [np.linalg.norm(np.diff(p, axis=0), axis=2).max() for p in (fast, slow)]
    assert fastest[1] < 0.5 * fastest[0]


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


def test_keyed_way_passes_its_keys_and_does_not_overshoot():
    keys = [state_of(P2, posture) for posture in (T_POSE, Posture(drop=0.2), Posture(drop=0.05))]
    way = KeyedWay(np.array([0.0, 1.0, 1.5]), keys)
    for time, key in zip((0.0, 1.0, 1.5), keys, strict=True):
        np.testing.assert_allclose(difference(way.at(time), key), 0, atol=1e-7)
    heights = [way.at(t).position[2] for t in np.linspace(0, 1.5, 60)]
    assert min(heights) >= keys[1].position[2] - 1e-9


def test_minimum_jerk_starts_and_ends_at_rest():
    assert minimum_jerk(0.0) == 0.0
    assert minimum_jerk(1.0) == 1.0
    assert minimum_jerk(1e-3) < 1e-7
