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
    MEASURED_PARTS,
    SilhouetteObservation,
    contours_of,
    edge_maps,
)
from tests.tracking.scenes import POSES, pose_with_arms
from tests.tracking.views import FOCAL, cloud_of_body, cloud_seen

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


@pytest.mark.parametrize("name", POSES)
def test_views_do_not_see_the_true_pose_shifted(edges, name):
    """The shift along the images' axes that explains the distances best, on average."""
    shifts = []
    for edge in edges[name]:
        found = _outlines((edge,), POSES[name])
        close = abs(found.distance) < 1.5 * PIXEL
        A = found.direction[close] @ edge.camera_from_world[:2, :3].T
        shifts.append(np.linalg.lstsq(A, found.distance[close], rcond=None)[0])
    assert abs(np.mean(shifts, axis=0)).max() < 0.25 * PIXEL


@pytest.mark.parametrize("name", POSES)
def test_every_measured_part_is_seen_and_legs_are_not(edges, name):
    parts = set(BODY.cones.part[_outlines(edges[name], POSES[name]).cone].tolist())
    assert parts == set(MEASURED_PARTS)


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


def test_who_is_too_wide_is_outside_of_every_edge(edges):
    cones = dataclasses.replace(BODY.cones, r1=BODY.cones.r1 + 0.02, r2=BODY.cones.r2 + 0.02)
    wide = dataclasses.replace(BODY, cones=cones)
    found = contours_of(edges["t"], wide, wide.frames(POSES["t"]))
    assert np.median(found.distance) == pytest.approx(-0.02, abs=0.5 * PIXEL)
    assert (found.distance < 0.0).mean() > 0.95


def test_directions_are_unit_vectors_across_the_line_of_sight(clouds, edges):
    for edge in edges["pointing"]:
        found = _outlines((edge,), POSES["pointing"])
        np.testing.assert_allclose(np.linalg.norm(found.direction, axis=1), 1.0, atol=1e-12)
        R, t = edge.camera_from_world[:, :3], edge.camera_from_world[:, 3]
        sight = found.point + R.T @ t
        sight /= np.linalg.norm(sight, axis=1, keepdims=True)
        np.testing.assert_allclose(np.einsum("mi,mi->m", sight, found.direction), 0.0, atol=1e-9)


def test_feet_lie_on_the_surface(edges):
    frames = BODY.frames(POSES["reaching"])
    found, placed = _outlines(edges["reaching"], POSES["reaching"]), placed_cones(BODY, frames)
    local = np.einsum(
        "mji,mj->mi", placed.rotations[found.cone], found.point - placed.origins[found.cone]
    )
    c = BODY.cones
    share = local[:, 2] / c.height[found.cone]
    radius = c.r1[found.cone] + share * (c.r2 - c.r1)[found.cone]
    across = np.hypot(local[:, 0], local[:, 1] / c.flatness[found.cone])
    np.testing.assert_allclose(across, radius, atol=1e-12)
    np.testing.assert_allclose(sorted(set(share.round(9))), [0.1, 0.3, 0.5, 0.7, 0.9], atol=1e-9)


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


def test_residuals_are_sorted_weighed_and_reach_their_data(edges):
    (residual,) = SilhouetteObservation(edges["pointing"], SIGMA).residuals(BODY, POSES["pointing"])
    frames = BODY.frames(POSES["pointing"])
    assert (np.diff(residual.part) >= 0).all()
    e = residual.distance
    np.testing.assert_allclose(
        np.einsum("mi,mi->m", residual.direction, residual.data - residual.point), e, atol=1e-12
    )
    again = (
        np.einsum("mij,mj->mi", frames.rotations[residual.part], residual.point_in_part)
        + frames.origins[residual.part]
    )
    np.testing.assert_allclose(again, residual.point, atol=1e-12)
    w = (0.06**2 / (0.06**2 + e**2)) ** 2
    np.testing.assert_allclose(residual.weight, w)
    np.testing.assert_allclose(residual.variance, 0.02**2 * (len(e) / 120.0) / w)


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


def test_edges_of_another_depth_are_left_out(edges):
    """An edge whose range nobody knows may be the part's own."""
    for farther, kept in ((0.05, True), (np.nan, True), (1.5, False), (-1.5, False)):
        there = tuple(dataclasses.replace(e, range_z=e.range_z + farther) for e in edges["t"])
        count = len(_outlines(there, POSES["t"]).distance)
        assert count > 150 if kept else count == 0


def test_an_edge_out_of_reach_is_not_measured(edges):
    moved = _moved(POSES["t"], [0.0, 0.0, 0.1])
    assert abs(_outlines(edges["t"], moved, farthest=0.05).distance).max() < 0.05
    assert abs(_outlines(edges["t"], moved).distance).max() > 0.08


def test_a_body_behind_the_camera_or_out_of_sight_has_no_outlines(edges):
    for by in ([0.0, 0.0, 30.0], [0.0, 200.0, 0.0]):
        assert len(_outlines(edges["t"][:1], _moved(POSES["t"], by)).distance) == 0


def test_a_person_cut_by_the_image_has_no_edge_at_its_border():
    pose = _moved(POSES["t"], [1.3, 0.0, 0.0])
    (edge,) = edge_maps(cloud_of_body(BODY, pose, "N"))
    assert edge.distance[:, 0].min() < -1.0 or edge.distance[:, -1].min() < -1.0
    found = _outlines((edge,), pose)
    assert len(found.distance) > 10
    assert abs(np.median(found.distance)) < 0.3 * PIXEL
    assert np.quantile(abs(found.distance), 0.9) < 1.5 * PIXEL


def test_margins_shift_the_edge_that_is_expected(edges):
    body = dataclasses.replace(
        BODY, cones=dataclasses.replace(BODY.cones, outline=BODY.cones.outline + 0.01)
    )
    plain = _outlines(edges["t"], POSES["t"])
    wider = contours_of(edges["t"], body, body.frames(POSES["t"]))
    np.testing.assert_allclose(wider.distance, plain.distance - 0.01, atol=1e-12)


def test_clouds_without_silhouettes_give_no_residuals(clouds):
    depths = {n: dataclasses.replace(d, outline=None) for n, d in clouds["t"].depths.items()}
    cloud = dataclasses.replace(clouds["t"], depths=depths)
    assert SilhouetteObservation(edge_maps(cloud), SIGMA).residuals(BODY, POSES["t"]) == ()
    (full,) = SilhouetteObservation(edge_maps(clouds["t"]), SIGMA).residuals(BODY, POSES["t"])
    assert len(full.distance) > 150


def test_an_empty_room_gives_no_residuals():
    assert SilhouetteObservation(edge_maps(cloud_seen([])), SIGMA).residuals(BODY, POSES["t"]) == ()
    post = [(np.eye(3), np.array([1.2, 0.0, 0.2]), 0.1, 0.1, 1.0, 1.0, False)]
    (residual,) = SilhouetteObservation(edge_maps(cloud_seen(post)), SIGMA).residuals(
        BODY, POSES["t"]
    )
    assert len(residual.distance) < 10
