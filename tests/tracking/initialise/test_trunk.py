"""What speaks for and against a trunk, against the same in plain NumPy, of random poses."""

import numpy as np
import pytest

from stereotrack_core.body.model import body_model, placed_cones
from stereotrack_core.body.pose import Pose, hanging_pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.body.surface import nearest_on_surface
from stereotrack_core.depth.cloud import Cloud, DepthGeometry, ViewDepth
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.tracking.initialise.trunk import (
    away_cost,
    facing_cost,
    feet_ahead,
    lean_cost,
    legs_cost,
    trunk_sight_cost,
    unexplained_by_trunk,
)
from tests.tracking.views import looking

BODY = body_model(AVERAGE)
LENGTH = BODY.skeleton.lengths


def random_pose(rng, turn):
    """Standing about the middle, all joints turned by so many radians about each axis."""
    place = rng.normal(0.0, 0.2, 3) + [0.0, 0.0, 1.0]
    turns = rotation_from_vector(turn * rng.normal(size=(12, 3)))
    return Pose(place, hanging_pose(place).rotations @ turns)


def _forward(frames):
    level = frames.rotations[0, :2, 1]
    return level / np.linalg.norm(level)


def _legs(frames):
    total = 0.0
    for thigh, shank in ((6, 8), (7, 9)):
        down = frames.rotations[[thigh, shank], :, 2] @ frames.rotations[0]
        upper, lower = -down[:, 2] + 1j * down[:, 1]
        total += 10.0 * np.clip((-np.angle(upper / lower) - 0.2) / 0.25, 0.0, 2.0)
        total += 5.0 * np.clip((-np.angle(upper) - 0.5) / 0.3, 0.0, 2.0)
    return total


def _lean(frames):
    up = frames.rotations[0, :, 2]
    lean = np.degrees(np.arctan2(up[:2] @ _forward(frames), max(up[2], 1e-3)))
    back = 8.0 * np.clip((-lean - 12.0) / 12.0, 0.0, 3.0)
    return back + 20.0 * np.clip((-up[2] - 0.15) / 0.3, 0.0, 2.0)


def _away(frames, cameras):
    to = (cameras - frames.origins[0])[:, :2]
    mean = np.mean([one / np.linalg.norm(one) for one in to], axis=0)
    size = np.linalg.norm(mean)
    return 10.0 * size**2 * (1.0 - _forward(frames) @ mean / size)


def _feet(frames, points):
    found = []
    for shank in (8, 9):
        ankle = frames.apply(np.array([shank]), np.array([[0.0, 0.0, LENGTH[shank]]]))[0]
        off = points - ankle
        near = off[(off[:, 2] < 0.06) & (np.linalg.norm(off[:, :2], axis=1) < 0.22)]
        if len(near) >= 8:
            found.append(np.median(near[:, :2] @ _forward(frames)))
    return found


@pytest.mark.parametrize("seed", range(3))
def test_what_bodies_hardly_do_costs_as_the_sum_of_its_parts(seed):
    rng = np.random.default_rng(seed)
    for _ in range(150):
        pose, cameras = random_pose(rng, rng.uniform(0.1, 1.0)), rng.normal(0.0, 2.0, (3, 3))
        frames = BODY.frames(pose)
        ends = frames.origins[[8, 9]] + LENGTH[[8, 9], None] * frames.rotations[[8, 9], :, 2]
        offsets = rng.normal(0.0, rng.choice([0.1, 0.15]), (2, rng.integers(8, 40), 3))
        points = (ends[:, None] + offsets + 0.05 * rng.normal(size=3)).reshape(-1, 3)
        feet, ahead = feet_ahead(BODY, frames, points), _feet(frames, points)
        np.testing.assert_allclose(feet, ahead, atol=1e-9)
        parts = legs_cost(frames), lean_cost(frames), away_cost(frames, cameras)
        expected = _legs(frames), _lean(frames), _away(frames, cameras)
        np.testing.assert_allclose(parts, expected, atol=1e-9)
        toes = sum(2.0 * (1.0 - np.clip(one / 0.04, -1.0, 1.0)) for one in ahead)
        assert facing_cost(BODY, pose, points, cameras) == pytest.approx(sum(expected) + toes)


def test_data_near_the_trunk_are_explained_and_those_in_reach_of_arms_half(rng):
    poses = [random_pose(rng, 0.2) for _ in range(3)]
    points = rng.normal(0.0, 0.4, (200, 3)) + [0.0, 0.0, 1.0]
    reach, expected = AVERAGE.upper_arm_length + LENGTH[4], []
    for frames in map(BODY.frames, poses):
        cones = placed_cones(BODY, frames)[~np.isin(BODY.cones["part"], (2, 3, 4, 5))]
        squared = nearest_on_surface(points, cones, 1e3).distance ** 2
        away = np.linalg.norm(points[:, None] - frames.origins[[2, 3]], axis=2).min(axis=1)
        expected.append(np.mean(squared / (squared + 0.06**2) * np.where(away < reach, 0.5, 1.0)))
    np.testing.assert_allclose(unexplained_by_trunk(points, BODY, poses), expected)


def _inner_places(frames):
    """Nine places of the torso, two of the head and of each thigh, one of each shank."""
    half, length = 0.35 * AVERAGE.shoulder_width, LENGTH[0]
    places = [(0, (x, 0.0, z * length)) for z in (0.15, 0.5, 0.85) for x in (-half, 0.0, half)]
    places += [(1, (0.0, 0.0, s * LENGTH[1])) for s in (0.5, 1.0)]
    places += [(part, (0.0, 0.0, s * LENGTH[part])) for part in (6, 7) for s in (0.4, 0.9)]
    places += [(part, (0.0, 0.0, 0.5 * LENGTH[part])) for part in (8, 9)]
    part, local = map(np.array, zip(*places, strict=True))
    return frames.apply(part, local)


def _judged(depth, point):
    """0 where a view looks through a place, 1 to 3 where it may be there, None beside the image."""
    u, v, z = (float(one[0]) for one in depth.geometry.project(point[None]))
    column, row = round(u), round(v)
    if z < 0.1 or not (0 <= row < depth.range_z.shape[0] and 0 <= column < depth.range_z.shape[1]):
        return None
    measured = depth.range_z[row, column]
    if np.isnan(measured):
        known = depth.silhouette is not None
        return (3 if depth.silhouette[row, column] else 0) if known else None
    off = (1.0 / measured - 1.0 / z) * depth.geometry.disparity_scale
    if off < -1.3:
        return 0
    return 1 if abs(off) < 0.9 else 2 if off > 0.0 else None


@pytest.mark.parametrize("outlined", [True, False])
def test_places_cost_by_the_views_that_look_through_them(outlined, rng):
    depths = {}
    for name, eye in {"a": (0.5, 2.5, 1.2), "b": (2.6, -0.4, 1.5), "c": (-0.1, 0.6, 1.2)}.items():
        geometry = DepthGeometry(180.0, 80.0, 60.0, 0.1, 0.0, 160, 120, looking(eye))
        spread = rng.uniform(0.7, 1.4, (120, 160))
        spread[rng.random(spread.shape) < 0.3] = np.nan
        ranges = (np.linalg.norm(np.subtract(eye, (0.0, 0.0, 1.1))) * spread).astype(np.float32)
        mask = rng.random(spread.shape) < 0.5
        depths[name] = ViewDepth(geometry, ranges, mask, mask if outlined else None)
    empty = np.zeros(0, dtype=np.int64)
    cloud = Cloud(0, np.zeros((0, 3)), empty, np.zeros((0, 2), np.int64), tuple(depths), depths)
    poses, expected = [random_pose(rng, 0.3) for _ in range(60)], []
    for pose in poses:
        judged = [
            [_judged(depth, place) for depth in depths.values()]
            for place in _inner_places(BODY.frames(pose))
        ]
        through = np.array([min(views.count(0), 2) for views in judged])
        unseen = np.array([all(view is None for view in views) for views in judged])
        expected.append(2.5 * through.sum() + 1.5 * unseen.sum())
    np.testing.assert_allclose(trunk_sight_cost(cloud, BODY, poses), expected)
