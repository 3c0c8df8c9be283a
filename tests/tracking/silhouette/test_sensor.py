"""Outlines of the model against silhouettes that are cast ray by ray from the same cones."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stereotrack_core.body.angles import ALL_JOINTS
from stereotrack_core.body.manifold import columns_of, displaced
from stereotrack_core.body.model import body_model, placed_cones
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.body.skeleton import LEFT_FOREARM, LEFT_UPPER_ARM
from stereotrack_core.tracking.residuals.silhouette import (
    SilhouetteObservation,
    contours_of,
    edge_maps,
)
from tests.tracking.scenes import POSES, pose_with_arms
from tests.tracking.views import FOCAL, HEIGHT, WIDTH, cloud_of_body, cloud_seen

BODY = body_model(AVERAGE)
SIGMA = 0.02
PIXEL = 3.0 / FOCAL
"""Metres that a pixel shows at the body."""


@pytest.fixture(scope="module")
def clouds():
    return {name: cloud_of_body(BODY, pose) for name, pose in POSES.items()}


@pytest.fixture(scope="module")
def edges(clouds):
    return {name: edge_maps(cloud) for name, cloud in clouds.items()}


def _moved(pose, by):
    return Pose(pose.position + np.asarray(by, dtype=float), pose.rotations)


def _outlines(edges, pose, **farthest):
    return contours_of(edges, BODY, BODY.frames(pose), **farthest)


@pytest.mark.parametrize("name", POSES)
def test_at_the_true_pose_outlines_lie_on_the_edges(edges, name):
    found = _outlines(edges[name], POSES[name])
    assert len(found.distance) > 150
    assert abs(np.median(found.distance)) < 0.3 * PIXEL
    assert np.median(abs(found.distance)) < 0.6 * PIXEL
    assert np.quantile(abs(found.distance), 0.9) < 1.5 * PIXEL


@given(
    angle=st.floats(0.0, 2.0 * np.pi),
    length=st.floats(0.01, 0.03),
    name=st.sampled_from(sorted(POSES)),
)
@settings(max_examples=30)
def test_a_shift_is_seen_along_the_directions(edges, angle, length, name):
    """Who stands aside by b is b . n away from every edge: outside one side, inside the other."""
    by = length * np.array([np.cos(angle), np.sin(angle), 0.0])
    found = _outlines(edges[name], _moved(POSES[name], by))
    expected = -found.direction @ by
    off = abs(found.distance - expected)
    assert np.median(off) < 0.7 * PIXEL
    clear = abs(expected) > 1.5 * PIXEL
    if clear.sum() > 20:
        same = np.sign(found.distance[clear]) == np.sign(expected[clear])
        assert same.mean() > 0.9


def test_the_jacobian_is_how_the_distance_to_the_edge_changes(edges):
    """Whole body: finite differences of the distances, over steps of some pixels."""
    pose = POSES["t"]
    observation = SilhouetteObservation(edges["t"], SIGMA)
    (residual,) = observation.residuals(BODY, pose)
    columns = columns_of(ALL_JOINTS)
    J = residual.jacobian(BODY.frames(pose), columns)
    step = 2.5 * PIXEL
    for k in range(3):
        delta = np.zeros(J.shape[1])
        delta[k] = step
        near, far = (
            _matched(residual, observation, displaced(pose, sign * delta, ALL_JOINTS))
            for sign in (-1.0, 1.0)
        )
        both = np.isfinite(near) & np.isfinite(far)
        assert both.sum() > 100
        change = (near - far)[both] / (2.0 * step)
        off = abs(change - J[both, k])
        assert np.median(off) < 0.12
        assert np.quantile(off, 0.85) < 0.3


def _matched(residual, observation, pose):
    """Distances (m,) of the same outlines at another pose, which turns nothing; else NaN."""
    (there,) = observation.residuals(BODY, pose)
    result = np.full(len(residual.part), np.nan)
    for i, (part, place) in enumerate(zip(residual.part, residual.point_in_part, strict=True)):
        same = (there.part == part) & (abs(there.point_in_part - place).max(axis=1) < 0.003)
        along = there.direction @ residual.direction[i] > 0.97
        chosen = np.flatnonzero(same & along)
        if len(chosen) == 1:
            result[i] = there.distance[chosen[0]]
    return result


def _part_alone(part):
    """The body of one part's cones."""
    return dataclasses.replace(BODY, cones=BODY.cones[BODY.cones.part == part])


def _of_forearm(found, body=BODY):
    return (body.cones.part[found.cone] == LEFT_FOREARM).sum()


def test_outlines_that_another_part_covers_are_left_out():
    """All edges of the forearm are there to be measured, but before the chest they are no edges."""
    arm = _part_alone(LEFT_FOREARM)
    for name, fore, kept in (("before", [1, 0.2, 0.1], False), ("aside", [-1, 0.2, 0.1], True)):
        pose = pose_with_arms([1, 0, 0], [1, 0.05, 0], [-0.2, 0.7, -0.6], fore)
        edges = edge_maps(cloud_of_body(arm, pose, "N"))
        alone = contours_of(edges, arm, arm.frames(pose))
        whole = contours_of(edges, BODY, BODY.frames(pose))
        assert _of_forearm(alone, arm) >= 12, name
        assert _of_forearm(whole) >= 10 if kept else _of_forearm(whole) <= 6, name


def test_an_edge_that_the_trunk_explains_says_nothing_about_an_arm():
    """An arm held too far back is not drawn to the back of the trunk, where no arm is."""
    truth = pose_with_arms([0.15, 0, -1], [0.15, 0, -1], [-0.15, 0.0, -1], [-0.15, 0.0, -1])
    back = pose_with_arms([0.15, 0, -1], [0.15, 0, -1], [-0.15, -0.28, -1], [-0.15, -0.1, -1])
    edges = edge_maps(cloud_of_body(BODY, truth, "EW"))
    found = contours_of(edges, BODY, BODY.frames(back))
    trunk = placed_cones(BODY, BODY.frames(back))
    of_arm = BODY.cones.part[found.cone] == LEFT_UPPER_ARM
    edge = found.point + found.distance[:, None] * found.direction
    local = (edge[of_arm] - trunk.origins[0]) @ trunk.rotations[0]
    height = local[:, 2] / BODY.cones.height[0]
    radius = BODY.cones.r1[0] + height * (BODY.cones.r2[0] - BODY.cones.r1[0])
    behind = np.abs(np.abs(local[:, 1]) - radius * BODY.cones.flatness[0])
    assert (behind[(height > 0.0) & (height < 1.0)] > 1.5 * PIXEL).all()


def test_a_person_cut_by_the_image_has_no_edge_at_its_border():
    pose = _moved(POSES["t"], [1.3, 0.0, 0.0])
    (edge,) = edge_maps(cloud_of_body(BODY, pose, "N"))
    assert edge.distance[:, 0].min() < -1.0 or edge.distance[:, -1].min() < -1.0
    found = _outlines((edge,), pose)
    assert len(found.distance) > 10
    assert abs(np.median(found.distance)) < 0.3 * PIXEL
    assert np.quantile(abs(found.distance), 0.9) < 1.5 * PIXEL


def test_an_empty_room_gives_no_residuals():
    assert SilhouetteObservation(edge_maps(cloud_seen([])), SIGMA).residuals(BODY, POSES["t"]) == ()
    post = [(np.eye(3), np.array([1.2, 0.0, 0.2]), 0.1, 0.1, 1.0, 1.0, False)]
    (residual,) = SilhouetteObservation(edge_maps(cloud_seen(post)), SIGMA).residuals(
        BODY, POSES["t"]
    )
    assert len(residual.distance) < 10


@pytest.fixture(scope="module")
def nobody():
    return cloud_seen([], "N")


def _with_outline(cloud, outline):
    depths = {
        name: dataclasses.replace(depth, outline=outline) for name, depth in cloud.depths.items()
    }
    return dataclasses.replace(cloud, depths=depths)


def _box(top, bottom, left, right):
    outline = np.zeros((HEIGHT, WIDTH), dtype=bool)
    outline[top:bottom, left:right] = True
    return outline


def _at(edge, row, column):
    left, top = edge.pinhole[3:].astype(int)
    return edge.distance[row - top, column - left]


def test_distances_are_pixels_from_the_edge_positive_outside(nobody):
    (edge,) = edge_maps(_with_outline(nobody, _box(100, 200, 150, 250)))
    # The edge runs half way between the last pixel inside and the first one outside.
    for column, expected in ((140, 9.5), (148, 1.5), (149, 0.5), (150, -0.5), (160, -10.5)):
        assert _at(edge, 150, column) == pytest.approx(expected, abs=0.02 * abs(expected) + 1e-6)
    for row, expected in ((90, 9.5), (99, 0.5), (199, -0.5), (200, 0.5), (210, 10.5)):
        assert _at(edge, row, 200) == pytest.approx(expected, abs=0.02 * abs(expected) + 1e-6)
    assert _at(edge, 90, 140) == pytest.approx(np.hypot(10, 10) - 0.5, rel=0.05)


def test_the_border_of_the_image_is_no_edge(nobody):
    (edge,) = edge_maps(_with_outline(nobody, _box(0, 200, 300, WIDTH)))
    np.testing.assert_array_equal(edge.pinhole[3:], [268, 0])
    assert edge.distance.shape == (232, WIDTH - 268)
    assert _at(edge, 0, WIDTH - 1) == pytest.approx(-99.5, rel=0.02)
    assert _at(edge, 150, WIDTH - 1) == pytest.approx(-49.5, rel=0.02)


def test_small_patches_make_no_edges(nobody):
    speckled = _box(100, 200, 150, 250)
    speckled[20:30, 20:30] = speckled[130:132, 260:264] = True
    (clean,) = edge_maps(_with_outline(nobody, _box(100, 200, 150, 250)))
    (edge,) = edge_maps(_with_outline(nobody, speckled))
    np.testing.assert_array_equal(edge.distance, clean.distance)
    np.testing.assert_array_equal(edge.pinhole, clean.pinhole)
