"""What speaks for and against a pair of arms: keypoints, anatomy, and arms that cross."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.body.angles import ALL_JOINTS
from stereotrack_core.body.manifold import ARMS, ROW, columns_of, difference, displaced
from stereotrack_core.body.pose import hanging_pose
from stereotrack_core.body.surface import nearest_on_surface
from stereotrack_core.filtering.linearisation import posterior
from stereotrack_core.geometry.rotation import angle_between
from stereotrack_core.geometry.triangulation import segment_distance
from stereotrack_core.tracking.arm_search.arms import (
    LEFT,
    RIGHT,
    Arms,
    _hands_at,
    arm_of_pose,
    arm_shape,
    arms_around,
    directions,
    proposals,
)
from stereotrack_core.tracking.arm_search.keypoints import _on_sphere, arm_keypoints
from stereotrack_core.tracking.arm_search.score import (
    anatomy_cost,
    arm_distances,
    change_cost,
    crossing_cost,
    pair_sums,
)
from stereotrack_core.tracking.arm_search.search import ArmSearch
from stereotrack_core.tracking.correction import gathered
from stereotrack_core.tracking.failure.features import disagreement
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.residuals.limits import PAIRS, ROOM, _part_arms, limit_rows
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


@pytest.mark.parametrize(("depth", "possible"), [(0.02, True), (0.045, False)])
def test_a_belly_gives_way_to_an_arm_by_some_two_centimetres(depth, possible):
    place = np.array([0.0, 0.15, 0.25])
    place[1] -= nearest_on_surface(place[None], BODY.cones[:1], np.inf).distance[0] + depth
    short = {f"{part}_length": 0.001 for part in ("upper", "fore", "hand")}
    at_belly = replace(arm_shape(BODY, LEFT), shoulder=place, **short)
    down = np.array([[0.0, 0.0, -1.0]])
    assert (anatomy_cost(BODY, at_belly, Arms(down, down))[0] == 0.0) == possible


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


@pytest.mark.parametrize("side", [LEFT, RIGHT])
def test_usual_forearms_beside_the_body_lead_ahead_or_across_it(side):
    arm, outwards = arm_of_pose(BODY.frames(POSES["t"]), side), -1.0 if side == LEFT else 1.0
    shape, rng = shapes(POSES["t"])[side], np.random.default_rng(0)
    usual = proposals(shape, arm, arm, np.zeros((0, 3)), 0, rng)
    fore = usual.fore[usual.upper[:, 2] < -0.9]
    assert len(fore) >= 6
    assert (outwards * fore[:, 0]).max() < 1e-9


@pytest.mark.parametrize(("count", "picked"), [(1200, 150), (4, 1)])
def test_an_eighth_of_the_proposals_reach_for_what_is_unexplained_and_one_at_least(count, picked):
    shape, arm = shapes(POSES["t"])[LEFT], arm_of_pose(BODY.frames(POSES["t"]), LEFT)
    without, found = (
        proposals(shape, arm, arm, np.array(data), count, np.random.default_rng(0))
        for data in (np.zeros((0, 3)), [shape.shoulder + 0.2, shape.shoulder + 9.0])
    )
    assert len(found) - len(without) == 3 * picked  # two with the hand there, one pointing


@pytest.mark.parametrize("about", [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.6, -0.5, 0.4]])
@pytest.mark.parametrize(("degrees", "cost"), [(130.0, 0.0), (147.5, 6.0)])
def test_elbows_that_fold_too_far_cost_in_whatever_plane_they_bend(about, degrees, cost):
    upper = np.array([0.5, 0.4, 0.7]) / np.linalg.norm([0.5, 0.4, 0.7])
    aside = np.cross(upper, about) / np.linalg.norm(np.cross(upper, about))
    fore = np.cos(np.radians(degrees)) * upper + np.sin(np.radians(degrees)) * aside
    found = anatomy_cost(BODY, arm_shape(BODY, RIGHT), Arms(upper[None], fore[None]))[0]
    assert found == pytest.approx(cost)


def some_arms(side, count, rng):
    return arms_around(arm_of_pose(BODY.frames(POSES["t"]), side), count, 0.8, 0.8, rng)


def test_a_datum_is_as_far_from_an_arm_as_from_its_nearest_tapered_segment(rng):
    shape, points = arm_shape(BODY, RIGHT), rng.normal(0.0, 0.4, (40, 3))
    nodes = shape.nodes(some_arms(RIGHT, 5, rng))
    a, b = nodes[:, :-1, None], nodes[:, 1:, None]
    share = np.clip(((points - a) * (b - a)).sum(-1) / ((b - a) ** 2).sum(-1), 0.0, 1.0)
    axis = np.linalg.norm(points - a - share[..., None] * (b - a), axis=-1)
    radius = (1.0 - share) * shape.radii[:, :1] + share * shape.radii[:, 1:]
    expected = np.abs(axis - radius).min(axis=1)
    np.testing.assert_allclose(arm_distances(points.T.copy(), nodes, shape.radii), expected)


def test_a_datum_counts_by_the_nearest_of_trunk_and_both_arms(rng):
    others, left, right = (rng.uniform(0.0, 0.2, shape) for shape in ((9,), (4, 9), (3, 9)))
    squared = np.minimum(np.minimum(left[:, None], right), others) ** 2
    expected = (squared / (squared + 0.03**2)).sum(axis=2)
    np.testing.assert_allclose(pair_sums(others, left, right, 0.03**2), expected)


def test_an_arm_costs_by_how_far_it_has_turned(rng):
    was, now = some_arms(LEFT, 1, rng), some_arms(LEFT, 6, rng)
    turns = [angle_between(now.upper, was.upper), angle_between(now.fore, was.fore)]
    expected = 2.0 * np.log1p((np.degrees(turns) / [[30.0], [40.0]]) ** 2).sum(axis=0)
    np.testing.assert_allclose(change_cost(was.upper, was.fore, now.upper, now.fore), expected)


def test_pairs_cost_by_how_near_their_limbs_come(rng):
    nodes = [arm_shape(BODY, s).nodes(some_arms(s, 12, rng)) for s in (LEFT, RIGHT)]
    ends = (((1, 3), (1, 3)), ((0, 1), (1, 3)), ((1, 3), (0, 1)))
    expected = 0.0
    for ((a, b), (c, d)), room in zip(ends, ROOM, strict=True):
        left, right = nodes[LEFT][:, None], nodes[RIGHT][None]
        apart = segment_distance(left[:, :, a], left[:, :, b], right[:, :, c], right[:, :, d])
        expected = expected + 3.0 * np.clip((0.2 * room - apart) / 0.03, 0.0, 2.0)
    assert 0.0 < np.mean(expected) < 18.0
    np.testing.assert_allclose(crossing_cost(*nodes, 0.2), expected)


@pytest.mark.parametrize("share", [0.4, 0.8, 0.99, 1.5])
def test_hands_are_put_where_data_are_unexplained(share, rng):
    shape = arm_shape(BODY, LEFT)
    reach = shape.upper_length + shape.fore_length + 0.5 * shape.hand_length
    targets = shape.shoulder + share * reach * directions(rng.normal(size=(3, 3)))
    arms = _hands_at(shape, targets, 4, rng)
    np.testing.assert_allclose(np.linalg.norm([arms.upper, arms.fore], axis=2), 1.0)
    off = shape.nodes(arms)[:, 2:].mean(axis=1) - np.repeat(targets, 4, axis=0)
    expected = max(0.0, share - 1.0) * reach
    np.testing.assert_allclose(np.linalg.norm(off, axis=1), expected, atol=1.1e-3)


# Degrees by which the upper arms of usual places are raised, and by which their elbows are bent.
RAISED = [-90, -79, -90, -90, -73, -73, -56, 0, 0, -30, 0, 0, -17, 45, 79, 56, -65]
BENT = [0, 20, 90, 102, 83, 111, 104, 0, 73, 110, 0, 90, 125, 0, 6, 103, 93]


@pytest.mark.parametrize("side", [LEFT, RIGHT])
def test_usual_places_of_arms_are_natural_and_spread_over_what_people_do(side, rng):
    arm, shape = arm_of_pose(BODY.frames(POSES["t"]), side), arm_shape(BODY, side)
    found = proposals(shape, arm, arm, np.zeros((0, 3)), 0, rng)[2:]
    np.testing.assert_allclose(np.degrees(np.arcsin(found.upper[:, 2])), RAISED, atol=0.6)
    np.testing.assert_allclose(np.degrees(angle_between(found.upper, found.fore)), BENT, atol=0.6)
    assert (anatomy_cost(BODY, shape, found) < 2.0).all()
    assert (found.fore[:, 1] >= 0.0).all(), "no forearm points backward"


@pytest.mark.parametrize(
    ("apart", "asked"), [(0.00008, False), (0.00012, True), (0.044, True), (0.046, False)]
)
def test_forearms_are_parted_unless_their_axes_meet(apart, asked):
    rotations, origins = np.zeros((6, 3, 3)), np.zeros((6, 3))
    rotations[4, :, 2], rotations[5, :, 2] = [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]
    origins[4], origins[5] = [-0.1, 0.0, apart], [0.0, -0.2, 0.0]
    rows = np.zeros(1, dtype=ROW)
    count = _part_arms(PAIRS[0], (rotations, origins), np.full(6, 0.4), LEAST, 0, rows)
    assert count == int(asked)
    if asked:
        np.testing.assert_allclose(rows["direction"][0], [0.0, 0.0, 1.0])
        np.testing.assert_allclose(rows["innovation"], LEAST - apart)


@pytest.mark.parametrize("crossed", [False, True])
@pytest.mark.parametrize("side", [LEFT, RIGHT])
def test_arms_cost_by_how_far_their_joints_are_from_the_rays(side, crossed, rng):
    pose, name = POSES["pointing"], ("left", "right")[side]
    shown = replace(seen(pose, {("S", f"{name}_wrist"): 25.0}), crossed=crossed)
    keypoints = arm_keypoints(of_view(shown, "N") if crossed else shown, SIGMA, BODY, pose)[side]
    torso, middle = pose.torso, pose.position
    shape, arms = shapes(pose)[side], some_arms(side, 12, rng)
    nodes = shape.nodes(arms) @ torso.T + middle
    expected = np.zeros(len(arms))
    (centres, rays), names = shown.rays, shown.names
    rows = [names.index(f"{name}_{joint}") for joint in ("elbow", "wrist")]
    rows.append(names.index(f"{('right', 'left')[side]}_elbow"))
    for v, camera in enumerate(shown.cameras):
        costs, joints = [], (nodes[:, 1], nodes[:, 2], nodes[:, 2:].mean(axis=1))
        for row, joint in zip(rows, joints, strict=True):
            off = np.linalg.norm(np.cross(joint - centres[v], rays[row, v]), axis=1)
            scale = 0.15 if crossed else 0.25
            costs.append(shown.confidence[row, v] * off**4 / (off**4 + scale**4))
        if crossed and camera == "N":
            expected += 2.0 * np.minimum(costs[0] + costs[1], costs[2])
        elif not crossed:
            expected += costs[0] + costs[1]
    np.testing.assert_allclose(keypoints.cost(shape, arms), expected, rtol=1e-6)
    ray, eye = keypoints.ray[2, 0], keypoints.eye[0]
    aside = np.cross(ray, [0.0, 0.0, 1.0]) / np.linalg.norm(np.cross(ray, [0.0, 0.0, 1.0]))
    points = eye + 2.0 * ray + np.array([[0.049], [0.051]]) * aside
    near = keypoints.near_hand(points) if crossed else points[:0]
    assert len(near) == int(crossed)


def test_elbows_and_wrists_are_proposed_where_rays_meet_spheres():
    eye, ray, centre = np.array([0.0, -3.0, 0.2]), np.array([0.0, 1.0, 0.0]), np.zeros(3)
    near, far = _on_sphere(eye, ray, centre, 0.3)
    np.testing.assert_allclose([near, far], [[0, -(0.05**0.5), 0.2], [0, 0.05**0.5, 0.2]])
    [beside] = _on_sphere(eye, ray, centre, 0.15)
    np.testing.assert_allclose(beside, [0.0, 0.0, 0.15])
