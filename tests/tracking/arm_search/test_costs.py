"""What speaks for and against a pair of arms: keypoints, anatomy, and arms that cross."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.body.angles import ALL_JOINTS
from stereotrack_core.body.manifold import ARMS, columns_of, difference, displaced
from stereotrack_core.body.pose import hanging_pose
from stereotrack_core.filtering.linearisation import posterior
from stereotrack_core.geometry.rotation import angle_between
from stereotrack_core.geometry.triangulation import segment_distance
from stereotrack_core.tracking.arm_search.arms import (
    LEFT,
    RIGHT,
    Arms,
    arm_of_pose,
    arm_shape,
    arms_around,
    proposals,
)
from stereotrack_core.tracking.arm_search.keypoints import arm_keypoints
from stereotrack_core.tracking.arm_search.score import anatomy_cost, crossing_cost
from stereotrack_core.tracking.arm_search.search import ArmSearch
from stereotrack_core.tracking.correction import gathered
from stereotrack_core.tracking.failure.features import disagreement
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.residuals.limits import PAIRS, ROOM, limit_rows
from stereotrack_core.tracking.residuals.reprojection import KeypointObservation
from tests.tracking.keypoints.cases import BODY
from tests.tracking.keypoints.test_reprojection import seen
from tests.tracking.scenes import POSES, pose_with_arms

SIGMA = 0.04
# Forearms that meet in front of the belly.
CROSSED = pose_with_arms([0.1, 0.5, -1], [-1, 0.32, 0.3], [-0.1, 0.5, -1], [1, 0.30, 0.3])


def shapes(pose):
    return ArmSearch(BODY, TrackingParameters()).placed_shapes(BODY.frames(pose))


def of_view(keypoints, name):
    """What one view alone shows."""
    v = [camera == name for camera in keypoints.cameras]
    return replace(
        keypoints,
        pixel=np.where(np.array(v)[:, None], keypoints.pixel, np.nan),
        confidence=np.where(v, keypoints.confidence, 0.0),
    )


def with_crossed_arms(pose):
    """What a detector sees of crossed arms: hands taken for elbows, wrists where forearms cross."""
    right, other = seen(pose), {"left": "right", "right": "left"}
    pixel, at = right.pixel.copy(), right.names.index
    for side in other:
        pixel[at(f"{side}_elbow")] = right.pixel[at(f"{other[side]}_wrist")]
        pixel[at(f"{side}_wrist")] = right.pixel[[at(f"{one}_wrist") for one in other]].mean(axis=0)
    return replace(right, pixel=pixel, crossed=True)


def test_elbows_of_crossed_arms_may_be_hands():
    pose, lowered = CROSSED, pose_with_arms([0, 0, -1], [0, 0, -1], [0, 0, -1], [0, 0, -1])
    shown = with_crossed_arms(pose)
    for side in (LEFT, RIGHT):
        true, other = (arm_of_pose(BODY.frames(one), side) for one in (pose, lowered))
        for keypoints in (shown, replace(seen(pose), crossed=True)):
            found = arm_keypoints(keypoints, SIGMA, BODY, pose)[side]
            costs = [found.cost(shapes(pose)[side], arm)[0] for arm in (true, other)]
            assert costs[0] < 0.25 * costs[1]
    one = of_view(shown, "N")
    assert not disagreement(one, BODY, lowered).any()
    fit = KeypointObservation(one, SIGMA).fitted(BODY, pose)
    assert not fit.weight[one.names.index("left_elbow")].any()
    found = arm_keypoints(one, SIGMA, BODY, pose)[LEFT]
    [hand] = shapes(pose)[LEFT].nodes(arm_of_pose(BODY.frames(pose), LEFT))[:, 2]
    assert found.near_hand(np.array([hand, hand + 0.2])).tolist() == [hand.tolist()]


@pytest.mark.parametrize("name", POSES)
@pytest.mark.parametrize("side", [LEFT, RIGHT])
@pytest.mark.parametrize(("guesses", "most"), [(False, 0.1), (True, 2.0)])
def test_the_true_arm_costs_least_also_if_a_view_guesses(name, side, guesses, most, rng):
    pose, joints = POSES[name], itertools.product(("left", "right"), ("elbow", "wrist"))
    off = {("S", f"{own}_{joint}"): rng.normal(0, 80, 2) for own, joint in joints}
    shown = arm_keypoints(seen(pose, off if guesses else None), SIGMA, BODY, pose)[side]
    true = arm_of_pose(BODY.frames(pose), side)
    others = arms_around(true, 50, 0.8, 0.8, rng)
    least = shown.cost(shapes(pose)[side], true)[0]
    assert least < most
    assert least < shown.cost(shapes(pose)[side], others).min()


@pytest.mark.parametrize("view", ["", "N", "O"])
def test_the_true_arm_is_proposed_by_all_views_and_by_one(view):
    pose, elsewhere = POSES["pointing"], hanging_pose(POSES["pointing"].position)
    trunk = replace(elsewhere, rotations=elsewhere.rotations.copy())
    trunk.rotations[0] = pose.rotations[0]
    keypoints = of_view(seen(pose), view) if view else seen(pose)
    for side, shown in enumerate(arm_keypoints(keypoints, SIGMA, BODY, trunk)):
        proposed = shown.proposals(shapes(pose)[side])
        true = arm_of_pose(BODY.frames(pose), side)
        off = np.maximum(
            angle_between(proposed.upper, true.upper), angle_between(proposed.fore, true.fore)
        )
        assert np.degrees(off.min()) < 12.0


def cost(side, upper, fore):
    """Cost of one arm, given as a right arm's directions in the torso's frame."""
    outwards = np.array([-1.0 if side == LEFT else 1.0, 1.0, 1.0])
    units = [np.array(v, float) * outwards / np.linalg.norm(v) for v in (upper, fore)]
    arms = Arms(units[0][None], units[1][None])
    return float(anatomy_cost(BODY, arm_shape(BODY, side), arms)[0])


@pytest.mark.parametrize("side", [LEFT, RIGHT])
@pytest.mark.parametrize(
    ("upper", "fore", "possible"),
    [
        pytest.param((1, 0, 0), (1, 0, 0), True, id="sideways"),
        pytest.param((0.2, 0, -1), (0, 1, 0), True, id="elbow bent forward"),
        pytest.param((0, 1, 0), (-0.3, 1, 0), True, id="reaching"),
        pytest.param((1, 0, 0), (-1, 0.1, 0), False, id="folded"),
        pytest.param((0, -1, 0), (0, -1, 0), False, id="behind"),
        pytest.param((1, 0, 0), (0, -1, 0), False, id="bent backward"),
        pytest.param((0.1, 0.1, -1), (-1, -0.2, 0), False, id="through the trunk"),
    ],
)
def test_arms_that_nobody_can_hold_cost_and_others_do_not(side, upper, fore, possible):
    found = cost(side, upper, fore)
    assert found == 0.0 if possible else found > 1.0


LEAST = 0.045


def rows(pose):
    found = limit_rows(BODY, pose, TrackingParameters(arms_apart=LEAST), ALL_JOINTS)
    return found[found["kind"] == ARMS]


def distances(pose):
    """Of the axes of all pairs of parts, metres."""
    frames = BODY.frames(pose)
    ends = frames.origins + BODY.skeleton.lengths[:, None] * frames.rotations[:, :, 2]
    return np.array(
        [segment_distance(frames.origins[a], ends[a], frames.origins[b], ends[b]) for a, b in PAIRS]
    )


@pytest.mark.parametrize("name", POSES)
def test_arms_that_are_apart_are_left_alone(name):
    assert not len(rows(POSES[name]))


def test_a_few_corrections_part_the_arms():
    n = 6 + 2 * len(ALL_JOINTS)
    P0, pose = np.diag(np.r_[np.full(6, 1e-6), np.full(n - 6, 0.5)]), CROSSED
    for _ in range(6):
        found = gathered((rows(pose),), BODY.frames(pose), columns_of(ALL_JOINTS))
        dx, _ = posterior(np.linalg.inv(P0), difference(CROSSED, pose, ALL_JOINTS), found)
        pose = displaced(pose, np.clip(dx, -0.5, 0.5), ALL_JOINTS)
    assert (distances(pose) > 0.9 * LEAST * np.array(ROOM)).all()


def test_pairs_that_go_through_each_other_cost_more():
    shapes = [arm_shape(BODY, side) for side in (LEFT, RIGHT)]
    costs = {}
    for name, pose in {"crossed": CROSSED, **POSES}.items():
        arms = [arm_of_pose(BODY.frames(pose), side) for side in (LEFT, RIGHT)]
        left, right = (shape.nodes(arm) for shape, arm in zip(shapes, arms, strict=True))
        costs[name] = crossing_cost(left, right, LEAST)[0, 0]
        assert crossing_cost(left, right, 0.0)[0, 0] == 0.0
    assert costs.pop("crossed") > 2.0
    assert not any(costs.values())


def test_proposals_around_the_present_arm_are_nearer_than_those_around_the_predicted_one():
    pose, rng = POSES["pointing"], np.random.default_rng(0)
    shape, arm = shapes(pose)[LEFT], arm_of_pose(BODY.frames(pose), LEFT)
    found = proposals(shape, arm, arm, np.zeros((0, 3)), 1200, rng)
    away = np.degrees(angle_between(found.fore, arm.fore[0]))
    around = len(found) - 300 - 2 * 200
    near, wide = (
        np.median(away[part]) for part in (slice(around, around + 300), slice(-200, None))
    )
    assert 20.0 < near < 40.0, "turned by 18 degrees about each axis, with the upper arm and alone"
    assert wide > 1.5 * near
