"""Model points."""

import numpy as np
import pytest

from stereotrack_core.body.model import placed_cones
from stereotrack_core.body.sampling import (
    inside_other_cone,
    points_on_cones,
    random_points,
    regular_points,
    visible_points,
)
from stereotrack_core.body.surface import nearest_on_surface
from tests.body.poses import SPECIAL_POSES, random_pose
from tests.oracle.occlusion import deepest, solids_of

CAMERAS = np.array([[0.0, 3.0, 2.1], [3.0, 0.0, 2.1], [0.0, -3.0, 2.1], [-3.0, 0.0, 2.1]])


def _world(body, pose, sampled):
    frames = body.frames(pose)
    points = frames.apply(sampled.part, sampled.points)
    normals = np.einsum("nij,nj->ni", frames.rotations[sampled.part], sampled.normals)
    return points, normals, placed_cones(body, frames)


@pytest.mark.parametrize("count", [4, 64, 1000])
def test_every_cone_has_an_equal_share(rng, legless, count):
    for sampled in (random_points(legless.cones, count, rng), regular_points(legless.cones, count)):
        share = np.bincount(sampled.cone, minlength=11)
        assert len(sampled) == count == share.sum()
        assert share.max() - share.min() <= 1
        np.testing.assert_array_equal(sampled.part, legless.cones.part[sampled.cone])


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


def test_height_and_angle_are_those_of_the_text(body):
    cone = np.zeros(3, dtype=np.int64)
    sampled = points_on_cones(
        body.cones, cone, np.array([0.0, 0.5, 1.0]), np.array([0.0, np.pi / 2, np.pi])
    )
    c = body.cones
    local = (sampled.points - c.origins[0]) @ c.rotations[0]
    middle = 0.5 * (c.r1[0] + c.r2[0])
    expected = [[c.r1[0], 0, 0], [0, 0.62 * middle, 0.5 * c.height[0]], [-c.r2[0], 0, c.height[0]]]
    np.testing.assert_allclose(local, expected, atol=1e-12)


def test_random_points_are_uniform_over_height_and_angle(rng, body):
    sampled = random_points(body.cones, 30000, rng)
    own = sampled.cone == 5
    local = sampled.points[own]
    h = np.histogram(local[:, 2] / body.cones.height[5], 5, (0, 1))[0] / own.sum()
    a = np.histogram(np.arctan2(local[:, 1], local[:, 0]), 5, (-np.pi, np.pi))[0] / own.sum()
    np.testing.assert_allclose(h, 0.2, atol=0.04)
    np.testing.assert_allclose(a, 0.2, atol=0.04)


def test_the_regular_pattern_is_a_spiral(body):
    sampled = regular_points(body.cones, 15 * 40)
    own = sampled.points[sampled.cone == 5]
    np.testing.assert_allclose(np.diff(own[:, 2]), body.cones.height[5] / 40, atol=1e-12)
    steps = np.diff(np.unwrap(np.arctan2(own[:, 1], own[:, 0])))
    golden = np.pi * (3 - np.sqrt(5))
    np.testing.assert_allclose(np.angle(np.exp(1j * (steps - golden))), 0.0, atol=1e-9)


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


def test_the_same_seed_draws_the_same_points(body):
    frames = body.frames(SPECIAL_POSES["t"])
    draws = [
        visible_points(body, frames, CAMERAS, 64, np.random.default_rng(seed)) for seed in (3, 3, 4)
    ]
    np.testing.assert_array_equal(draws[0].points, draws[1].points)
    assert (draws[0].points != draws[2].points).any()


def test_the_regular_pattern_is_always_the_same(body):
    frames = body.frames(SPECIAL_POSES["folded"])
    first, second = (visible_points(body, frames, CAMERAS, 100, None) for _ in range(2))
    np.testing.assert_array_equal(first.points, second.points)


@pytest.mark.parametrize("drawn", ["random", "regular"])
def test_where_no_camera_looks_there_are_no_points(rng, body, drawn):
    frames = body.frames(SPECIAL_POSES["hanging"])
    generator = rng if drawn == "random" else None
    assert len(visible_points(body, frames, np.empty((0, 3)), 64, generator)) == 0


def test_a_camera_in_front_sees_no_back(body, rng):
    frames = body.frames(SPECIAL_POSES["t"])
    sampled = visible_points(body, frames, CAMERAS[:1], 64, rng)
    normals = np.einsum("nij,nj->ni", frames.rotations[sampled.part], sampled.normals)
    points = frames.apply(sampled.part, sampled.points)
    assert (np.einsum("ni,ni->n", normals, CAMERAS[0] - points) > 0).all()


def test_points_can_be_chosen(rng, body):
    sampled = random_points(body.cones, 50, rng)
    assert len(sampled[:7]) == 7
    np.testing.assert_array_equal(sampled[np.array([3, 1])].points, sampled.points[[3, 1]])
