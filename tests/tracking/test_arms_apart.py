"""Arms that go through each other are held apart; others are left alone."""

import numpy as np
import pytest

from stereotrack_core.body.angles import ALL_JOINTS
from stereotrack_core.body.manifold import columns_of, difference, displaced
from stereotrack_core.body.model import body_model
from stereotrack_core.body.pose import PartFrames
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.filtering.linearisation import posterior
from stereotrack_core.geometry.triangulation import segment_distance
from stereotrack_core.tracking.arm_search.arms import LEFT, RIGHT, arm_of_pose, arm_shape
from stereotrack_core.tracking.arm_search.score import crossing_cost
from stereotrack_core.tracking.correction import gathered
from stereotrack_core.tracking.residuals.limits import PAIRS, ROOM, arms_apart
from tests.tracking.scenes import POSES, pose_with_arms

BODY = body_model(AVERAGE)
LEAST = 0.045
CROSSED = pose_with_arms([0.1, 0.5, -1], [-1, 0.32, 0.3], [-0.1, 0.5, -1], [1, 0.30, 0.3])
"""Forearms that meet in front of the belly."""


def rows(pose, least=LEAST):
    return arms_apart(BODY, BODY.frames(pose), least)


def distances(pose):
    """Of the axes of all pairs of parts, metres."""
    frames = BODY.frames(pose)
    ends = frames.origins + BODY.skeleton.lengths[:, None] * frames.rotations[:, :, 2]
    return np.array(
        [segment_distance(frames.origins[a], ends[a], frames.origins[b], ends[b]) for a, b in PAIRS]
    )


def test_the_scene_is_one_in_which_arms_meet():
    assert distances(CROSSED)[0] < 0.5 * LEAST


@pytest.mark.parametrize("name", POSES)
def test_arms_that_are_apart_are_left_alone(name):
    assert rows(POSES[name]) == []


def test_what_is_predicted_is_the_distance_of_the_axes():
    (row,) = rows(CROSSED)
    frames = BODY.frames(CROSSED)
    here = row.predicted(PartFrames(frames.rotations[None], frames.origins[None]))[0]
    near = distances(CROSSED) < LEAST * ROOM
    np.testing.assert_allclose(here, distances(CROSSED)[near], atol=1e-9)
    np.testing.assert_allclose(row.measured, (LEAST * ROOM)[near])


def test_the_jacobian_is_the_change_of_the_distance():
    (row,) = rows(CROSSED)
    columns, n = columns_of(ALL_JOINTS), 6 + 2 * len(ALL_JOINTS)
    near = np.concatenate([1e-5 * np.eye(n), -1e-5 * np.eye(n)])
    both = row.predicted(BODY.frames(displaced(CROSSED, near, ALL_JOINTS)))
    found = row.jacobian(BODY.frames(CROSSED), columns)
    np.testing.assert_allclose(found, (both[:n] - both[n:]).T / 2e-5, atol=1e-6)
    np.testing.assert_allclose(found[:, :6], 0.0, atol=1e-9)


def test_a_few_corrections_part_the_arms():
    n = 6 + 2 * len(ALL_JOINTS)
    P0, pose = np.diag(np.r_[np.full(6, 1e-6), np.full(n - 6, 0.5)]), CROSSED
    for _ in range(6):
        found = gathered(tuple(rows(pose)), BODY, pose, columns_of(ALL_JOINTS))
        dx, _ = posterior(np.linalg.inv(P0), difference(CROSSED, pose, ALL_JOINTS), found)
        pose = displaced(pose, np.clip(dx, -0.5, 0.5), ALL_JOINTS)
    assert (distances(pose) > 0.9 * LEAST * ROOM).all()


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


def test_every_pair_of_proposals_has_its_own_cost():
    shapes = [arm_shape(BODY, side) for side in (LEFT, RIGHT)]
    poses = [CROSSED, POSES["t"], POSES["pointing"]]
    nodes = [
        np.concatenate([shape.nodes(arm_of_pose(BODY.frames(p), shape.side)) for p in poses])
        for shape in shapes
    ]
    table = crossing_cost(*nodes, LEAST)
    assert table.shape == (3, 3)
    for k in range(3):
        for m in range(3):
            alone = crossing_cost(nodes[0][k : k + 1], nodes[1][m : m + 1], LEAST)
            assert table[k, m] == alone[0, 0]
