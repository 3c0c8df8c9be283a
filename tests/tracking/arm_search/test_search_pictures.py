"""The search for arms asks what all views should see of a pair of arms."""

import numpy as np
import pytest

from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.tracking.arm_search import search
from stereotrack_core.tracking.arm_search.arms import LEFT, RIGHT, arm_of_pose, with_arm
from stereotrack_core.tracking.arm_search.picture import outline_table, seen_pictures
from stereotrack_core.tracking.arm_search.search import ArmSearch
from stereotrack_core.tracking.parameters import TrackingParameters
from tests.tracking.arm_search.test_picture import unlike
from tests.tracking.scenes import POSES, pose_with_arms
from tests.tracking.views import cloud_of_body, cloud_seen

BODY = body_model(AVERAGE)
TRUE = POSES["t"]
LIFTED = pose_with_arms([1, 0, 0.5], [1, 0.05, 0.5], [-1, 0, 0], [-1, 0.05, 0])
BENT = pose_with_arms([1, 0, 0], [0.2, 1, 0.2], [-1, 0, 0], [-1, 0.05, 0])


@pytest.fixture(scope="module")
def cloud():
    return cloud_of_body(BODY, TRUE)


def _cost(cloud, pose, **changes):
    searching = ArmSearch(BODY, TrackingParameters().replaced(**changes))
    evidence = searching.evidence(cloud, TRUE, np.random.default_rng(0))
    return searching.cost(evidence, pose, pose)


def _of_pictures(cloud, pose, **changes):
    """What the pictures alone say against a pose."""
    with_pictures = _cost(cloud, pose, **changes)
    return with_pictures - _cost(cloud, pose, **changes, picture_cost=0.0)


@pytest.mark.parametrize("wrong", [LIFTED, BENT])
def test_pictures_speak_against_an_arm_that_is_elsewhere(cloud, wrong):
    assert _of_pictures(cloud, wrong) > _of_pictures(cloud, TRUE) + 20.0


def test_what_pictures_say_is_in_square_metres_of_all_views(cloud):
    """The same as counting pixels view by view, each by the area that it shows at the body."""
    p = TrackingParameters()
    frames = BODY.frames(BENT)
    arms = [np.isin(BODY.cones.part, parts) for parts in ([2, 4], [3, 5])]
    chosen = ~(arms[0] | arms[1]), *arms
    tables = [outline_table(BODY.cones[which], frames) for which in chosen]
    total, step = 0.0, 3
    for seen in seen_pictures(cloud, step):
        R = seen.camera_from_world[2, :3]
        depth = R @ (BENT.position - seen.eye)
        pixels = unlike((0.5, 0.1), seen, *(seen.drawn(table) for table in tables))
        total += pixels * (step * depth / seen.pinhole[0]) ** 2
    assert _of_pictures(cloud, BENT) == pytest.approx(p.picture_cost * total, rel=1e-6)


def test_the_cost_hardly_depends_on_how_coarsely_pictures_are_compared(cloud, monkeypatch):
    found = []
    for step in (1, 4):
        monkeypatch.setattr(search, "_PICTURE_STEP", step)
        found.append(_of_pictures(cloud, BENT))
    assert found[1] == pytest.approx(found[0], rel=0.1)


def test_without_anybody_in_the_pictures_they_say_nothing():
    assert _of_pictures(cloud_seen([]), BENT) == pytest.approx(0.0, abs=1e-9)


def test_pairs_cost_what_their_poses_cost(cloud):
    searching = ArmSearch(BODY, TrackingParameters())
    evidence = searching.evidence(cloud, TRUE, np.random.default_rng(0))
    arms = [
        [arm_of_pose(BODY.frames(pose), side) for pose in (TRUE, LIFTED, BENT)]
        for side in (LEFT, RIGHT)
    ]
    left = arms[LEFT][0]
    for right, pose in zip(arms[RIGHT], (TRUE, LIFTED, BENT), strict=True):
        cost = searching._unlike_pairs(evidence, TRUE, left, right)
        moved = with_arm(
            with_arm(TRUE, LEFT, left.upper[0], left.fore[0]), RIGHT, right.upper[0], right.fore[0]
        )
        assert cost.shape == (1, 1)
        assert cost[0, 0] == pytest.approx(_of_pictures(cloud, moved), rel=1e-6, abs=1e-6)
        assert cost[0, 0] == pytest.approx(_of_pictures(cloud, pose), rel=0.05)


def test_without_a_weight_pictures_are_not_drawn(cloud):
    searching = ArmSearch(BODY, TrackingParameters().replaced(picture_cost=0.0))
    evidence = searching.evidence(cloud, TRUE, np.random.default_rng(0))
    arms = [arm_of_pose(BODY.frames(TRUE), side) for side in (LEFT, RIGHT)]
    np.testing.assert_array_equal(searching._unlike_pairs(evidence, TRUE, *arms), [[0.0]])
