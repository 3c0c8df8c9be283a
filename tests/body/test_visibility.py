"""What cameras see, against walking along the sight lines."""

import numpy as np
import pytest

from stereotrack_core.body.model import placed_cones
from stereotrack_core.body.sampling import (
    inside_other_cone,
    random_points,
    segment_blocked,
    visible,
)
from tests.body.poses import SPECIAL_POSES, random_pose
from tests.oracle.cone import depth_inside
from tests.oracle.occlusion import deepest, solids_of

CAMERAS = np.array([[0.0, 3.0, 2.1], [3.0, 0.0, 2.1], [0.0, -3.0, 2.1], [-3.0, 0.0, 2.1]])
GRAZING = 0.003
"""Metres: sight lines that dip into a cone by less are too close to call by steps."""


@pytest.mark.parametrize("name", ["t", "folded", "forward", "random"])
def test_sight_lines_are_blocked_where_they_pass_a_cone(rng, body, name):
    pose = SPECIAL_POSES.get(name) or random_pose(rng)
    placed = placed_cones(body, body.frames(pose))
    solids = solids_of(placed)
    middle = placed.origins.mean(axis=0)
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


def test_a_wall_behind_the_camera_or_the_point_hides_nothing(rng, body):
    placed = placed_cones(body, body.frames(SPECIAL_POSES["hanging"]))
    in_front, behind = np.array([0.0, 0.6, 1.2]), np.array([0.0, -0.6, 1.2])
    assert not segment_blocked(in_front[None], np.array([0.0, 3.0, 1.2]), placed)[0]
    assert segment_blocked(behind[None], np.array([0.0, 3.0, 1.2]), placed)[0]


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


@pytest.mark.parametrize("name", ["t", "folded", "raised"])
def test_surface_points_are_visible_where_a_camera_has_a_free_view(rng, body, name):
    frames = body.frames(SPECIAL_POSES[name])
    placed = placed_cones(body, frames)
    solids = solids_of(placed)
    sampled = random_points(body.cones, 140, rng)
    points = frames.apply(sampled.part, sampled.points)
    normals = np.einsum("nij,nj->ni", frames.rotations[sampled.part], sampled.normals)
    outside = ~inside_other_cone(points, sampled.cone, placed)
    points, normals = points[outside], normals[outside]
    found = visible(points, normals, CAMERAS, placed)
    clear = 0
    for point, normal, seen in zip(points, normals, found, strict=True):
        facing = [camera for camera in CAMERAS if normal @ (camera - point) > 0]
        depths = [deepest(point + 0.001 * normal, camera, solids) for camera in facing]
        free = min(depths, default=1.0)
        if abs(free) < GRAZING and any(abs(d) < GRAZING and d > -0.0005 for d in depths):
            continue
        assert seen == (free < 0)
        clear += 1
    assert clear > 60
    assert found.any()


def test_without_cameras_nothing_is_visible(rng, body):
    frames = body.frames(SPECIAL_POSES["t"])
    sampled = random_points(body.cones, 20, rng)
    points = frames.apply(sampled.part, sampled.points)
    seen = visible(points, points, np.empty((0, 3)), placed_cones(body, frames))
    assert not seen.any()
