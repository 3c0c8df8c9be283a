"""Joint angles mean what their definitions say."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from stereotrack_core.evaluation.joint_angles import NAMES, angles_of_landmarks
from stereotrack_core.recording.landmarks import LANDMARKS

# the recommendation's X (forwards), Y (up), Z (right) in the torso's frame (right, forwards, up)
TORSO_FROM_ISB = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
MIRROR = np.diag([-1.0, 1.0, 1.0])


def humerus(plane, elevation, rotation):
    """thorax_from_humerus by the recommendation's own formula, Y-X'-Y'' with beta = -elevation."""
    return Rotation.from_euler("YXY", [plane, -elevation, rotation]).as_matrix()


def landmarks(arms=None, torso=None, head=(0.0, 0.0, 1.0)):
    """Nine landmarks (9, 3) of a body.

    `arms` are (plane, elevation, rotation, flexion) of the left and the right one, in radians; the
    forearm is bent about the humerus' own Z. `torso` is world_from_torso, `head` its direction.
    """
    torso = np.eye(3) if torso is None else torso
    arms = ((0.3, 0.4, 0.1, 0.5),) * 2 if arms is None else arms
    points = {
        "left_hip": [-0.12, 0, 0], "right_hip": [0.12, 0, 0],
        "left_shoulder": [-0.19, 0, 0.46], "right_shoulder": [0.19, 0, 0.46],
        "head": np.array([0, 0, 0.46]) + 0.2 * np.asarray(head, float),
    }  # fmt: skip
    for side, (plane, elevation, rotation, flexion) in zip(("left", "right"), arms, strict=True):
        own = humerus(plane, elevation, rotation)
        upper = TORSO_FROM_ISB @ own @ [0.0, -1.0, 0.0]
        bend = Rotation.from_euler("Z", flexion).as_matrix()
        fore = TORSO_FROM_ISB @ own @ bend @ [0.0, -1.0, 0.0]
        if side == "left":
            upper, fore = MIRROR @ upper, MIRROR @ fore
        points[f"{side}_elbow"] = points[f"{side}_shoulder"] + 0.27 * upper
        points[f"{side}_hand"] = points[f"{side}_elbow"] + 0.36 * fore
    return np.array([points[name] for name in LANDMARKS]) @ torso.T + [1.0, 2.0, 0.9]


def torso_of(turn, forward, sideways):
    """world_from_torso by the recommendation's Y, X and Z axes one after the other."""
    isb = Rotation.from_euler("YXZ", [turn, sideways, -forward]).as_matrix()
    return TORSO_FROM_ISB @ isb @ TORSO_FROM_ISB.T


def degrees(points):
    return dict(zip(NAMES, np.degrees(angles_of_landmarks(points)), strict=True))


def angle(low, high):
    return st.floats(np.radians(low), np.radians(high))


arm = st.tuples(angle(-130, 170), angle(12, 168), angle(-170, 170), angle(22, 158))


@given(arm, arm, angle(-175, 175), angle(-170, 170), angle(-75, 75))
def test_angles_that_a_body_was_made_with_are_found_again(left, right, turn, forward, sideways):
    found = angles_of_landmarks(landmarks((left, right), torso_of(turn, forward, sideways)))
    parts = dict(zip(NAMES, found, strict=True))
    expected = {"torso_turn": turn, "torso_forward": forward, "torso_sideways": sideways}
    for side, values in (("left", left), ("right", right)):
        kinds = ("shoulder_plane", "shoulder_elevation", "shoulder_rotation", "elbow_flexion")
        expected |= {f"{side}_{k}": v for k, v in zip(kinds, values, strict=True)}
    for name, value in expected.items():
        away = np.arctan2(np.sin(parts[name] - value), np.cos(parts[name] - value))
        assert abs(away) < 1e-7, name


# movements that a person would name: arm directions in the torso's frame (right, forwards, up)
@pytest.mark.parametrize(
    ("upper", "fore", "plane", "elevation", "rotation", "flexion"),
    [
        ((1, 0, 0), (1, 0, 0), 0, 90, np.nan, 0),  # T pose
        ((0, 1, 0), (0, 1, 0), 90, 90, np.nan, 0),  # raised forwards
        ((0, -1, -1), (0, -1, -1), -90, 45, np.nan, 0),  # pulled backwards
        ((0, 0, -1), (0, 1, 0), np.nan, 0, np.nan, 90),  # hanging, forearm forwards
        ((1, 0, 0), (0, 1, 0), 0, 90, 0, 90),  # scarecrow, forearm forwards
        ((1, 0, 0), (0, 0, -1), 0, 90, 90, 90),  # scarecrow, forearm down: internal
        ((1, 0, 0), (0, 0, 1), 0, 90, -90, 90),  # scarecrow, forearm up: external
    ],
)
@pytest.mark.parametrize("side", ["left", "right"])
def test_movements_have_the_numbers_that_a_laboratory_gives(
    side, upper, fore, plane, elevation, rotation, flexion
):
    points = landmarks()
    at = {name: i for i, name in enumerate(LANDMARKS)}
    mirror = np.array([-1.0 if side == "left" else 1.0, 1, 1])
    unit = [np.asarray(v, float) / np.linalg.norm(v) * mirror for v in (upper, fore)]
    points[at[f"{side}_elbow"]] = points[at[f"{side}_shoulder"]] + 0.27 * unit[0]
    points[at[f"{side}_hand"]] = points[at[f"{side}_elbow"]] + 0.36 * unit[1]
    found = degrees(points)
    values = (plane, elevation, rotation, flexion)
    kinds = ("shoulder_plane", "shoulder_elevation", "shoulder_rotation", "elbow_flexion")
    for kind, value in zip(kinds, values, strict=True):
        np.testing.assert_allclose(found[f"{side}_{kind}"], value, atol=1e-9, err_msg=kind)


def test_the_torso_turns_left_bends_forwards_and_leans_right_positively():
    assert degrees(landmarks(torso=np.eye(3)))["torso_turn"] == pytest.approx(0)
    west = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])  # its y axis points west
    assert degrees(landmarks(torso=west))["torso_turn"] == pytest.approx(90)
    bowed = degrees(landmarks(torso=np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])))
    assert bowed["torso_forward"] == pytest.approx(90)
    s = np.sin(np.radians(20))
    c = np.cos(np.radians(20))
    leaning = degrees(landmarks(torso=np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])))
    assert leaning["torso_sideways"] == pytest.approx(20)
    lying = degrees(landmarks(torso=torso_of(0.2, 0.1, np.radians(85))))
    assert np.isnan([lying["torso_turn"], lying["torso_forward"]]).all()
    assert lying["torso_sideways"] == pytest.approx(85)


def test_near_singular_places_nothing_is_said():
    arm_at = lambda elevation, flexion: degrees(  # noqa: E731
        landmarks(((0.3, np.radians(elevation), 0.2, np.radians(flexion)),) * 2)
    )
    assert np.isnan(arm_at(9.9, 60)["left_shoulder_plane"])
    assert np.isnan(arm_at(170.1, 60)["left_shoulder_plane"])
    assert np.isfinite(arm_at(10.1, 60)["left_shoulder_plane"])
    assert np.isnan(arm_at(60, 19.9)["right_shoulder_rotation"])
    assert np.isnan(arm_at(9.9, 60)["right_shoulder_rotation"])
    assert np.isfinite(arm_at(60, 20.1)["right_shoulder_rotation"])
    assert np.isfinite(arm_at(9.9, 10)["right_shoulder_elevation"])


def test_what_is_not_known_blanks_only_what_needs_it():
    points = landmarks()
    points[LANDMARKS.index("left_hand")] = np.nan
    points[LANDMARKS.index("head")] = np.nan
    known = {n for n, v in degrees(points).items() if np.isfinite(v)}
    blank = {"head_forward", "head_sideways", "left_shoulder_rotation", "left_elbow_flexion"}
    assert known == set(NAMES) - blank
    assert np.isnan(angles_of_landmarks(np.full((9, 3), np.nan))).all()
    assert np.isnan(angles_of_landmarks(np.zeros((2, 9, 3)))).all()
