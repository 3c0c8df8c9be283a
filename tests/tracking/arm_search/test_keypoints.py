"""Keypoints in the search for arms."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.body.pose import hanging_pose
from stereotrack_core.geometry.rotation import angle_between
from stereotrack_core.tracking.arm_search.arms import LEFT, RIGHT, arm_of_pose, arms_around
from stereotrack_core.tracking.arm_search.keypoints import arm_keypoints
from stereotrack_core.tracking.arm_search.search import ArmSearch
from stereotrack_core.tracking.parameters import TrackingParameters
from tests.tracking.keypoints.cases import BODY
from tests.tracking.keypoints.test_reprojection import seen
from tests.tracking.scenes import POSES

SIGMA = 0.04


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


@pytest.mark.parametrize("name", POSES)
@pytest.mark.parametrize("side", [LEFT, RIGHT])
def test_the_true_arm_costs_least(name, side, rng):
    pose = POSES[name]
    shown = arm_keypoints(seen(pose), SIGMA, BODY, pose)[side]
    true = arm_of_pose(BODY.frames(pose), side)
    others = arms_around(true, 50, 0.8, 0.8, rng)
    least = shown.cost(shapes(pose)[side], true)[0]
    assert least < 0.1
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


def test_a_view_that_guesses_does_not_outweigh_the_others(rng):
    pose = POSES["pointing"]
    guessed = {("S", f"{s}_{j}"): rng.normal(0, 80, 2) for s in ("left", "right")
               for j in ("elbow", "wrist")}  # fmt: skip
    for side, shown in enumerate(arm_keypoints(seen(pose, guessed), SIGMA, BODY, pose)):
        true = arm_of_pose(BODY.frames(pose), side)
        others = arms_around(true, 50, 0.8, 0.8, rng)
        shape = shapes(pose)[side]
        assert shown.cost(shape, true)[0] <= 2.0
        assert shown.cost(shape, true)[0] < shown.cost(shape, others).min()


def test_without_keypoints_there_is_nothing():
    assert arm_keypoints(None, SIGMA, BODY, POSES["pointing"]) is None
    nobody = of_view(seen(POSES["pointing"]), "nowhere")
    assert arm_keypoints(nobody, SIGMA, BODY, POSES["pointing"]) is None
