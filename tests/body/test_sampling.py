"""Model points, and which of them a camera sees."""

import numpy as np
import pytest

from stereotrack_core.body.model import placed_cones
from stereotrack_core.body.sampling import (
    inside_other_cone,
    random_points,
    segment_blocked,
    visible_points,
)
from stereotrack_core.body.surface import nearest_on_surface
from tests.body.poses import SPECIAL_POSES, random_pose
from tests.oracle.cone import depth_inside
from tests.oracle.occlusion import deepest, solids_of
from tests.tracking.scenes import CAMERAS


def _world(body, pose, sampled):
    frames = body.frames(pose)
    points = frames.apply(sampled.part, sampled.points)
    normals = np.einsum("nij,nj->ni", frames.rotations[sampled.part], sampled.normals)
    return points, normals, placed_cones(body, frames)


def test_points_lie_on_their_cones_with_outward_normals(rng, body):
    pose = random_pose(rng)
    sampled = random_points(body.cones, 600, rng)
    points, normals, placed = _world(body, pose, sampled)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0)
    for c in range(len(body.cones)):
        own = sampled.cone == c
        closest = nearest_on_surface(points[own], placed[c : c + 1], 1.0)
        np.testing.assert_allclose(closest.distance, 0.0, atol=1e-12)
        np.testing.assert_allclose(closest.direction, normals[own], atol=1e-9)


@pytest.mark.parametrize("name", SPECIAL_POSES)
@pytest.mark.parametrize("drawn", ["random", "regular"])
def test_what_remains_is_on_the_surface_free_and_seen(rng, body, name, drawn):
    pose = SPECIAL_POSES[name]
    generator = rng if drawn == "random" else None
    sampled = visible_points(body, body.frames(pose), CAMERAS, 64, generator)
    assert len(sampled) == 64
    points, normals, placed = _world(body, pose, sampled)
    assert not inside_other_cone(points, sampled.cone, placed).any()
    closest = nearest_on_surface(points, placed, 1.0)
    assert np.abs(closest.distance).max() < 1e-3
    solids = solids_of(placed)
    for point, normal in zip(points[:16], normals[:16], strict=True):
        facing = [camera for camera in CAMERAS if normal @ (camera - point) > 0]
        assert min(deepest(point + 0.001 * normal, camera, solids) for camera in facing) < 0.001


GRAZING = 0.003
"""Metres: sight lines that dip into a cone by less are too close to call by steps."""


@pytest.mark.parametrize("name", ["t", "folded", "forward", "random"])
def test_sight_lines_are_blocked_where_they_pass_a_cone(rng, body, name):
    pose = SPECIAL_POSES.get(name) or random_pose(rng)
    placed = placed_cones(body, body.frames(pose))
    solids = solids_of(placed)
    middle = placed["origin"].mean(axis=0)
    cameras = middle + [[0.0, 3.0, 1.0], [3.0, 0.0, 1.0]]
    starts = middle + rng.uniform(-0.6, 0.6, (90, 3))
    free = [deepest(p, p + 1e-9, solids) < -GRAZING for p in starts]
    starts, clear = starts[free], 0
    for camera in cameras:
        blocked = segment_blocked(starts, camera, placed)
        for start, found in zip(starts, blocked, strict=True):
            depth = deepest(start, camera, solids)
            if abs(depth) > GRAZING:
                assert found == (depth > 0)
                clear += 1
    assert clear > 100


@pytest.mark.parametrize("name", ["t", "folded", "random"])
def test_points_inside_other_cones_are_found(rng, body, name):
    pose = SPECIAL_POSES.get(name) or random_pose(rng)
    frames = body.frames(pose)
    placed = placed_cones(body, frames)
    sampled = random_points(body.cones, 300, rng)
    points = frames.apply(sampled.part, sampled.points)
    found = inside_other_cone(points, sampled.cone, placed)
    assert 0 < found.sum() < 300
    for point, own, inside in zip(points, sampled.cone, found, strict=True):
        depths = [
            depth_inside(r1, r2, height, s, (point - origin) @ turn)
            for c, (turn, origin, r1, r2, height, s) in enumerate(solids_of(placed))
            if c != own
        ]
        if abs(max(depths)) > 0.002:
            assert inside == (max(depths) > 0)
