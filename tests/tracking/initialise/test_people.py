"""Groups of points that stand apart, and which of them are the body's own."""

import numpy as np
import pytest
from scipy.sparse.csgraph import connected_components

from stereotrack_core.body.model import body_model, placed_cones
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.body.skeleton import LIMB_OF_PART
from stereotrack_core.body.surface import nearest_on_surface
from stereotrack_core.depth.points import Volume
from stereotrack_core.geometry.upright import Upright
from stereotrack_core.tracking.initialise.people import (
    depth_inside,
    own_points,
    people_in,
    share_at_sides,
    trunk_support,
)
from stereotrack_core.tracking.initialise.seeds import seeds_in, t_pose_in_cloud
from stereotrack_core.tracking.residuals.surface import surface_distances
from tests.tracking.scenes import CAMERAS, POSES, surface_points, turned

BODY = body_model(AVERAGE)
POSE = POSES["t"]


def _body(shift, count, rng):
    return surface_points(BODY, POSE, count, rng) + shift


def test_two_people_are_two_groups_and_strays_are_none(rng):
    near, far = _body([0, 0, 0], 2000, rng), _body([0, 1.5, 0], 900, rng)
    stray = np.array([[1.7, -1.7, 0.3]])
    groups = people_in(np.concatenate([far, near, stray]), 150)
    assert [int(members.sum()) > 850 for members in groups] == [True, True]
    assert groups[0][900:-1].mean() > 0.98
    assert groups[1][:900].mean() > 0.98
    assert not any(members[-1] for members in groups)


def test_support_falls_with_what_is_cut_away(rng):
    points = surface_points(BODY, POSE, 4000, rng)
    whole = trunk_support(BODY, POSE, points, CAMERAS)
    half = trunk_support(BODY, POSE, points[points[:, 0] < POSE.position[0]], CAMERAS)
    assert whole > 0.9
    assert 0.3 < half < 0.7
    assert trunk_support(BODY, POSE, np.empty((0, 3)), CAMERAS) == 0.0


def _groups(points):
    """Groups of points whose cells of 10 cm touch, -1 for what is alone in its cell."""
    cell = np.floor((points - points.min(axis=0)) / 0.10).astype(int)
    near = np.abs(cell[:, None] - cell).max(axis=2)
    joins = (near == 0).sum(axis=1) >= 2
    group = connected_components((near <= 1) & joins[:, None] & joins)[1]
    return np.where(joins, group, -1)


def _scattered(rng, sizes):
    """Groups of points of these sizes, about the body's place, with strays."""
    middles = POSE.position + rng.uniform(-1.6, 1.6, (len(sizes), 3)) * [1.0, 1.0, 0.4]
    groups = [m + rng.normal(0.0, 0.08, (n, 3)) for m, n in zip(middles, sizes, strict=True)]
    return np.concatenate([*groups, rng.uniform(-1.5, 2.0, (20, 3))])


@pytest.mark.parametrize("seed", range(12))
def test_groups_are_found_and_foreign_ones_left_out(seed):
    rng = np.random.default_rng(seed)
    points = np.concatenate([_scattered(rng, (150, 60, 30, 15)), _body([0, 0, 0], 90, rng)])
    floor = _groups(points[:, :2])
    counts = {k: np.count_nonzero(floor == k) for k in np.unique(floor[floor >= 0])}
    largest = [k for k in sorted(counts, key=lambda k: -counts[k])[:3] if counts[k] >= 25]
    found = people_in(points, 25)
    assert {m.tobytes() for m in found} == {(floor == k).tobytes() for k in largest}
    assert [m.sum() for m in found] == [counts[k] for k in largest]
    group, few = _groups(points), np.arange(len(points)) % 4 == 0
    away = np.abs(surface_distances(points, BODY, POSE))
    names = np.unique(group[group >= 0])
    nearest = {k: min(away[few & (group == k)], default=np.inf) for k in names}
    size = {k: np.count_nonzero(group == k) for k in names}
    main = max((size[k] for k in names if nearest[k] < 0.35), default=0)
    foreign = [k for k in names if nearest[k] >= 0.35 and size[k] > 0.2 * main]
    reach = np.linalg.norm(points[:, :2] - POSE.position[:2], axis=1) < 1.3
    np.testing.assert_array_equal(own_points(points, BODY, POSE), reach & ~np.isin(group, foreign))


@pytest.mark.parametrize("seed", range(8))
def test_support_is_the_share_of_patches_facing_a_camera_that_have_points(seed):
    rng, hit, faced = np.random.default_rng(seed), 0, 0
    pose, cameras = turned(POSE, rng.uniform(0.0, 360.0)), rng.normal(0.0, 2.0, (2, 3))
    points, frames = surface_points(BODY, pose, 60, rng, 0.08), BODY.frames(pose)
    closest = nearest_on_surface(points, placed_cones(BODY, frames), 0.10)
    part = np.where(closest.cone >= 0, LIMB_OF_PART[BODY.cones["part"][closest.cone]], -1)
    for k, rows, columns in ((0, 3, 6), (1, 1, 4)):
        R, origin, length = frames.rotations[k], frames.origins[k], BODY.skeleton.lengths[k]
        x, y, z = ((closest.point[part == k] - origin) @ R).T
        row = np.clip(np.floor(rows * z / length), 0, rows - 1)
        share = (np.arctan2(y, x) + np.pi) / (2.0 * np.pi)
        column = np.minimum(np.floor(share * columns), columns - 1)
        for i, j in np.ndindex(rows, columns):
            angle = 2.0 * np.pi * (j + 0.5) / columns - np.pi
            normal = R @ [np.cos(angle), np.sin(angle), 0.0]
            sight = cameras - (origin + R[:, 2] * length * (i + 0.5) / rows)
            if (sight @ normal / np.linalg.norm(sight, axis=1)).max() > 0.25:
                faced += 1
                hit += bool(((row == i) & (column == j)).any())
    assert 0 < hit < faced
    assert trunk_support(BODY, pose, points, cameras) == pytest.approx(hit / faced)


def test_who_is_cut_by_a_side_has_many_points_there(rng):
    volume, points = (
        Volume(np.array([-1.0, -2.0, 0.0]), np.array([1.5, 1.0, 2.0])),
        rng.normal(0.0, 1.0, (300, 3)),
    )
    for axis, level in (("z", [0, 1]), ("y", [0, 2])):
        to_low, to_high = points - volume.low, volume.high - points
        depth = np.minimum(to_low, to_high)[:, level].min(axis=1)
        np.testing.assert_allclose(depth_inside(points, volume, Upright(axis)), depth)
        assert share_at_sides(points, volume, Upright(axis)) == np.mean(depth < 0.05)
    assert share_at_sides(points[:0], volume) == 0.0


def _crown_and_sole(frames):
    """Ends of trunk, head and legs, and the middle of their areas, of the hips at the origin."""
    placed = placed_cones(BODY, frames)[~np.isin(BODY.cones["part"], (2, 3, 4, 5))]
    ends = placed["origin"] + placed["height"][:, None] * placed["rotation"][:, :, 2]
    tops = [*placed["origin"][:, 2], *(ends[:, 2] + placed["r2"] * placed["round_end"])]
    area = placed["height"] * (placed["r1"] + placed["r2"])
    middle = area @ (placed["origin"] + ends) / (2.0 * area.sum())
    return max(tops), ends[:, 2].min() - 0.06, middle


@pytest.mark.parametrize("axis", ["z", "y"])
def test_seeds_are_postures_in_all_headings_that_reach_from_the_floor_or_to_the_top(axis, rng):
    upright, points = Upright(axis), rng.normal(0.0, [0.3, 0.3, 0.5], (800, 3)) + [0.3, -0.2, 1.0]
    seeds = seeds_in(BODY, points @ upright.rotation, upright)
    middle = np.median(points[:, :2], axis=0)
    near = np.linalg.norm(points[:, :2] - middle, axis=1) < 0.35
    top, bottom = np.percentile(points[near, 2], [98.5, 1.0])
    postures = [(0, 0, 0), (35, 5, 5), (75, 10, 5), (25, 70, 35), (75, 60, 30)]
    assert len(seeds) == 5 * 12 * 2
    for k, seed in enumerate(seeds):
        lean, thigh, shank = np.radians(postures[k // 24])
        turn, pose = 2.0 * np.pi * (k // 2 % 12) / 12, seed.turned(upright.rotation)
        c, s = np.cos(turn), np.sin(turn)
        back = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        frames = BODY.frames(Pose(np.zeros(3), pose.rotations))
        north = frames.rotations[:, :, 2] @ back.T
        angles = np.array([lean, np.pi - thigh, np.pi + shank, np.pi])
        expected = np.stack([0.0 * angles, np.sin(angles), np.cos(angles)], axis=1)
        np.testing.assert_allclose(north[[0, 6, 8, 2]], expected, atol=1e-9)
        np.testing.assert_allclose(north[[7, 9, 3]], expected[1:], atol=1e-9)
        high, low, centre = _crown_and_sole(frames)
        height = sorted([top - high, bottom - low])[k % 2]
        np.testing.assert_allclose(pose.position, [*(middle - centre[:2]), height], atol=0.0051)
        np.testing.assert_allclose(pose.position[:2], middle - centre[:2], atol=1e-9)


def test_a_t_pose_has_its_crown_at_the_top_of_the_cloud(rng):
    points = rng.normal(0.0, [0.25, 0.25, 0.5], (800, 3)) + [0.3, -0.2, 1.0]
    pose, middle = t_pose_in_cloud(BODY, points), np.median(points[:, :2], axis=0)
    near = np.linalg.norm(points[:, :2] - middle, axis=1) < 0.3
    crown, _, _ = _crown_and_sole(BODY.frames(pose))
    np.testing.assert_allclose(
        [*pose.position[:2], crown], [*middle, np.percentile(points[near, 2], 98.5)]
    )
