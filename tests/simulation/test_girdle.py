"""Shoulders that move on their own: what is asked of them, and nothing else."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stereotrack_core.simulation.actor import actor
from stereotrack_core.simulation.motions import MOTIONS
from stereotrack_core.simulation.people import PEOPLE
from stereotrack_core.simulation.postures import Arm, Posture, state_of
from stereotrack_core.simulation.skeleton import BONE, SIDES, SIGN, landmarks, posed_bones
from tests.simulation.scenes import chain

P2 = PEOPLE["P2"]
ON_THEIR_OWN = ("shrug", "reach")


@pytest.fixture(scope="module")
def dressed():
    return actor(P2, "plain")


def clavicle_angles(person, states):
    """Elevation and protraction against the chest at rest, (frames, 2, 2) degrees."""
    rows = []
    for state in states:
        bones = posed_bones(person, state)
        for name, s in zip(SIDES, SIGN, strict=True):
            axis = bones.rotation[BONE["chest"]].T @ bones.rotation[BONE[f"clavicle_{name}"]][:, 0]
            rows.append((np.arcsin(s * axis[2]), np.arctan2(s * axis[1], axis[0])))
    return np.degrees(rows).reshape(-1, 2, 2)


def shoulders_in_chest(person, state):
    bones = posed_bones(person, state)
    chest = BONE["chest"]
    return (landmarks(person, bones)[:2] - bones.joint[chest]) @ bones.rotation[chest]


@pytest.mark.parametrize("who", PEOPLE.values(), ids=PEOPLE)
def test_lifted_shoulders_rise_by_some_centimetres_and_take_the_hands_along(who):
    resting, lifted = (state_of(who, Posture(lifted=(up, up))) for up in (0.0, 27.0))
    before, after = (landmarks(who, posed_bones(who, state)) for state in (resting, lifted))
    rise = after[:, 2] - before[:, 2]
    assert (rise[:2] > 0.06).all()
    assert (rise[:2] < 0.09).all()
    np.testing.assert_allclose(rise[2:6], rise[[0, 1, 0, 1]], atol=0.012)
    np.testing.assert_allclose(after[6:], before[6:], atol=1e-12)


def test_either_shoulder_moves_alone():
    resting, lifted = (
        shoulders_in_chest(P2, state_of(P2, Posture(lifted=(left, 0.0), forward=(0.0, right))))
        for left, right in ((0.0, 0.0), (25.0, 15.0))
    )
    left, right = lifted - resting
    assert left[2] > 0.06
    assert abs(left[1]) < 0.005
    assert right[1] > 0.035
    assert abs(right[2]) < 0.005


@pytest.mark.parametrize(
    ("asked", "got"),
    [
        ({"lifted": (20.0, 20.0)}, (20.0, 0.0)),
        ({"lifted": (-6.0, -6.0)}, (-6.0, 0.0)),
        ({"forward": (15.0, 15.0)}, (0.0, 15.0)),
        ({"forward": (-12.0, -12.0)}, (0.0, -12.0)),
    ],
)
def test_clavicles_turn_against_the_chest_by_what_was_asked(asked, got):
    sideways = Arm((0.97, 0.0, 0.0), (0.0, 0.0, -1.0))
    states = [
        state_of(P2, Posture(sideways, sideways, (5.0, 5.0, 5.0), twist=20.0, **how))
        for how in ({}, asked)
    ]
    before, after = clavicle_angles(P2, states)
    np.testing.assert_allclose(after - before, [got, got], atol=1.0)


degrees = st.tuples(st.floats(-5, 27), st.floats(-5, 27))
ahead = st.tuples(st.floats(-14, 16), st.floats(-14, 16))
within_reach = st.tuples(st.floats(0.0, 0.6), st.floats(0.3, 0.6), st.floats(-0.5, 0.5))


@settings(max_examples=40, deadline=None)
@given(st.sampled_from(list(PEOPLE.values())), within_reach, degrees, ahead)
def test_wrists_are_as_far_from_the_moved_shoulders_as_told(who, wrist, lifted, forward):
    """The target moves with the shoulder; what the girdle does for the arm is made up for."""
    arm = Arm(wrist, (0.6, -0.2, -1.0))
    state = state_of(who, Posture(arm, arm, lifted=lifted, forward=forward))
    still = state_of(who, Posture(Arm((1.0, 0.0, 0.0)), Arm((1.0, 0.0, 0.0)), lifted=lifted,
                                  forward=forward))  # fmt: skip
    at = posed_bones(who, state)
    chest = BONE["chest"]
    told = shoulders_in_chest(who, still)
    for side, s in enumerate(SIGN):
        hand = at.joint[BONE[f"hand_{SIDES[side]}"]] - at.joint[chest]
        got = hand @ at.rotation[chest] - told[side]
        np.testing.assert_allclose(got, np.array(wrist) * [s, 1, 1] * who.arm, atol=2e-3)


@settings(max_examples=20, deadline=None)
@given(degrees, ahead)
def test_hands_at_the_feet_stay_there_whatever_the_shoulders_do(lifted, forward):
    lace = Arm((0.0, 0.28, 0.13), (1.0, 0.1, 0.3), at_foot=True)
    low = {"lean": (50.0, 26.0, 18.0), "drop": 0.46, "back": 0.17}
    asked = state_of(P2, Posture(lace, lace, **low, lifted=lifted, forward=forward))
    resting = state_of(P2, Posture(lace, lace, **low))
    wrists = [BONE["hand_left"], BONE["hand_right"]]
    a, b = (posed_bones(P2, state).joint[wrists] for state in (asked, resting))
    np.testing.assert_allclose(a, b, atol=3e-3)


@pytest.mark.parametrize("name", [name for name in MOTIONS if name not in ON_THEIR_OWN])
def test_nobody_moves_the_shoulders_unasked(name):
    states = MOTIONS[name].states(P2, 25)
    assert not any(state.girdle.any() for state in states)
    elevation, protraction = np.moveaxis(clavicle_angles(P2, states), -1, 0)
    assert elevation.min() > -6.1
    assert elevation.max() < 10.1
    assert np.abs(protraction).max() < 9.1


@pytest.mark.parametrize("name", ON_THEIR_OWN)
@pytest.mark.parametrize("who", PEOPLE.values(), ids=PEOPLE)
def test_shoulders_stay_within_what_people_can(who, name):
    angles = clavicle_angles(who, MOTIONS[name].states(who, 80))
    assert angles[..., 0].max() < 35
    assert angles[..., 0].min() > -12
    assert angles[..., 1].max() < 26
    assert angles[..., 1].min() > -20


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


def test_reaching_pushes_lifts_and_draws_back():
    states = MOTIONS["reach"].states(P2, 96)
    points = np.array([landmarks(P2, posed_bones(P2, state)) for state in states])
    angles = clavicle_angles(P2, states)
    both_ahead = points[20]
    assert (both_ahead[4:6, 1] - both_ahead[6, 1] > 0.5).all()
    assert (angles[20, :, 1] > 20).all()
    for side, frame in ((0, 37), (1, 60)):
        assert points[frame, 4 + side, 2] > points[frame, 6, 2] + 0.4
        assert angles[frame, side, 0] > 30
        assert angles[frame, 1 - side, 0] < 0
    assert (points[84, 2:4, 1] < points[84, :2, 1] - 0.1).all()
    assert (angles[84, :, 1] < -13).all()


def test_the_skin_goes_along_with_arm_and_shoulder_and_leaves_head_and_hips(dressed):
    resting, lifted = (
        dressed.posed(posed_bones(P2, state_of(P2, Posture(lifted=(up, 0.0)))))[0]
        for up in (0.0, 27.0)
    )
    states = (state_of(P2, Posture(lifted=(up, 0.0))) for up in (0.0, 27.0))
    before, after = (landmarks(P2, posed_bones(P2, state)) for state in states)
    moved = lifted - resting

    def share(*names):
        return dressed.weights[:, [BONE[name] for name in names]].sum(axis=1)

    arm = share("upper_arm_left", "forearm_left", "hand_left") > 0.99
    rise = (after - before)[0, 2]
    np.testing.assert_allclose(moved[arm, 2], rise, atol=0.02)
    others = share("head") > 0.99
    others |= share("pelvis", "thigh_left", "thigh_right", "shank_left", "foot_left") > 0.99
    others |= share("upper_arm_right", "forearm_right", "hand_right") > 0.99
    np.testing.assert_allclose(moved[others], 0, atol=1e-4)


@pytest.mark.parametrize(
    ("name", "frames"), [("shrug", range(0, 105, 7)), ("reach", (20, 37, 60, 84))]
)
def test_the_skin_neither_folds_nor_tears(dressed, name, frames):
    """Triangles against those that only follow the arms, where these are themselves in order."""
    states = MOTIONS[name].states(P2, int(MOTIONS[name].seconds * 10))
    a, b, c = dressed.triangles.T

    def normals_of(vertices):
        return np.cross(vertices[b] - vertices[a], vertices[c] - vertices[a])

    at_rest = np.linalg.norm(normals_of(dressed.vertices), axis=1)
    for frame in frames:
        state = states[frame]
        normals = [
            normals_of(dressed.posed(posed_bones(P2, one))[0])
            for one in (replace(state, girdle=np.zeros((2, 2))), state)
        ]
        area = [np.linalg.norm(n, axis=1) for n in normals]
        well = (at_rest > 2e-5) & (area[0] > 0.5 * at_rest) & (area[0] < 2 * at_rest)
        assert well.mean() > 0.5
        ratio = area[1][well] / area[0][well]
        cosine = np.einsum("ij,ij->i", *normals)[well] / (area[0] * area[1])[well]
        assert cosine.min() > 0.6
        assert ratio.min() > 0.4
        assert ratio.max() < 2.5


def test_everything_between_the_motions_is_smooth():
    states = chain(P2, ("shrug", "reach"), 260, fps=10).states
    steps = np.diff([state.girdle for state in states], axis=0)
    assert np.degrees(np.abs(steps).max()) < 8
