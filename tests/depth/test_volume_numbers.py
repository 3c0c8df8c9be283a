"""Numbers of the working volume: each step against its statement, without pictures."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from stereotrack_core.depth import volume
from stereotrack_core.depth.cloud import DepthGeometry
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.points import Volume, range_of_disparity
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.geometry.upright import Upright

USUAL = DepthParameters()
UP = np.array([0.0, 0.0, 1.0])


def _view(degrees=0.0, away=2.5, baseline=0.1, height=1.2, size=(320, 240)):
    """Camera of focal length 400 px that looks at the axis of z from a side."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    axes = np.array([[c, 0.0, -s], [s, 0.0, c], [0.0, -1.0, 0.0]])
    place = RigidTransform(axes, -away * axes[:, 2] + [0.0, 0.0, height])
    middle = (size[0] - 1) / 2, (size[1] - 1) / 2
    return DepthGeometry(400.0, *middle, baseline, 3.0, *size, place)


@pytest.mark.parametrize("axis", ["z", "y"])
def test_the_volume_is_a_box_around_its_centre(axis):
    size = {"volume_x": 3.0, "volume_y": 2.0, "volume_z": 1.0, "volume_bottom": -0.2}
    p = USUAL.replaced(up_axis=axis, volume_centre_x=1.0, volume_centre_y=-0.4, **size)
    ends = np.array([[-0.5, -1.4, -0.2], [2.5, 0.6, 0.8]]) @ Upright(axis).rotation
    found = Volume.of(p)
    np.testing.assert_allclose([found.low, found.high], [ends.min(axis=0), ends.max(axis=0)])
    corners = found.corners()
    assert len(np.unique(corners, axis=0)) == 8
    assert found.contains(corners).all()
    assert not found.contains(corners + 1e-6 * np.sign(corners - corners.mean(axis=0))).any()


def test_ranges_follow_from_disparities():
    disparity = np.array([[2.0, 3.0, 5.0, 43.0]], dtype=np.float32)
    expected = [[np.nan, np.nan, 400.0 * 0.1 / 2.0, 1.0]]
    np.testing.assert_allclose(range_of_disparity(_view(), disparity), expected, rtol=1e-6)


@pytest.mark.parametrize("axis", ["z", "-y"])
@pytest.mark.parametrize("scale", [0.3, 2.0])
def test_the_volume_is_put_around_points_with_a_margin(axis, scale, rng):
    p = USUAL.replaced(up_axis=axis)
    points = scale * rng.normal(size=(500, 3)) + [3.0, -1.0, 2.0]
    low, high = np.percentile(points, [2, 98], axis=0)
    size = np.maximum(high - low + 1.2, [p.volume_x, p.volume_y, p.volume_z])
    found = volume._placed(p, points @ Upright(axis).rotation)
    assert [found.volume_x, found.volume_y, found.volume_z] == pytest.approx(size, abs=0.006)
    middle = found.volume_centre_x, found.volume_centre_y, found.volume_bottom + 0.5 * size[2]
    assert middle == pytest.approx(0.5 * (low + high), abs=0.011)


@pytest.mark.parametrize(("near", "needed"), [(1.9, 64), (0.9, 112), (0.01, None)])
def test_so_many_disparities_are_searched_as_the_nearest_place_needs(near, needed):
    views, near = [_view(baseline=0.05), _view(baseline=0.24)], [near, near]
    needed = needed or 16 * int(np.ceil((400 * 0.24 / volume.NEAREST_RANGE + 2.0) / 16))
    found = volume._searched(USUAL, views, near).disparity_count
    assert found == max(needed, USUAL.disparity_count)
    own = USUAL.replaced(disparity_count=48)
    assert volume._searched(own, views, near) == own


@pytest.mark.parametrize(("away", "factor"), [(3.9, 1.0), (4.1, 4.1 / 3.0), (6.0, 2.0)])
def test_images_of_people_far_away_are_enlarged_as_they_need(away, factor):
    views = [_view(), _view(baseline=0.0), _view()]
    found = volume._enlarged(USUAL, views, [1.0, 50.0, away]).least_focal
    [row] = [row for row in USUAL.rows() if row.name == "least_focal"]
    assert found == min(round(factor * USUAL.least_focal), row.maximum)
    own = USUAL.replaced(least_focal=USUAL.least_focal + 1.0)
    assert volume._enlarged(own, views, [1.0, 50.0, away]) == own


@pytest.mark.parametrize(
    ("turns", "around"),
    [((0.0, 29.0), False), ((0.0, 31.0), True), ((0.0, 10.0, -25.0), True), ((40.0,), False)],
)
def test_cameras_stand_around_what_they_see_from_30_degrees_apart(turns, around):
    box = Volume(np.array([-1.0, -1.0, 0.0]), np.array([1.0, 1.0, 2.4]))
    assert volume._stand_around(box, [_view(turn) for turn in turns], UP) == around


@pytest.mark.parametrize(
    ("size", "height", "sees"),
    [
        ((320, 240), 1.2, True),
        ((320, 122), 1.2, False),
        ((320, 134), 1.2, True),
        ((320, 240), 1.56, False),
        ((320, 240), 1.53, True),
        ((320, 240), 0.84, False),
        ((320, 240), 0.87, True),
    ],
)
def test_a_camera_sees_the_middle_if_it_sees_40_cm_over_and_under_it(size, height, sees):
    box = Volume(np.array([-1.0, -1.0, 0.0]), np.array([1.0, 1.0, 2.4]))
    views = [_view(turn, size=size, height=height) for turn in (0.0, 90.0)]
    assert volume._stand_around(box, views, UP) == sees


def test_nearly_all_ranges_of_a_volume_that_an_image_shows_are_needed():
    box = Volume(np.array([-1.0, -1.0, 0.0]), np.array([1.2, 1.0, 2.4]))
    for view in (_view(20.0), _view(0.0, away=0.6), _view(10.0, size=(80, 60))):
        ends = zip(box.low, box.high, strict=True)
        x, y, z = (low + (high - low) * np.arange(12) / 11 for low, high in ends)
        points = np.stack(np.meshgrid(x, y, z), axis=-1).reshape(-1, 3)
        local = (points - view.world_from_depth.translation) @ view.world_from_depth.rotation
        z = local[:, 2]
        ahead = z > volume.NEAREST_RANGE
        u, v = np.full((2, len(z)), -1.0)
        u[ahead], v[ahead] = (400.0 * local[ahead, :2] / z[ahead, None] + [view.c_x, view.c_y]).T
        shown = z[ahead & (u >= 0) & (u < view.width) & (v >= 0) & (v < view.height)]
        expected = tuple(np.percentile(shown, [5, 95]))
        assert volume._ranges_shown(box, view) == pytest.approx(expected)
    behind = replace(box, low=box.low - [0.0, 9.0, 0.0], high=box.high - [0.0, 9.0, 0.0])
    assert volume._ranges_shown(behind, _view()) is None


@pytest.mark.parametrize(
    ("depth", "height", "along_z"),
    [(0.6, 1.05, True), (0.6, 0.95, False), (0.9, 1.33, False), (0.9, 1.38, True)],
)
def test_who_is_tall_along_z_stands_along_it(depth, height, along_z, rng):
    box = rng.uniform(-0.5, 0.5, (4000, 3)) / 0.96 * [0.4, depth, height]
    person = SimpleNamespace(seen=[[box, box + 1.0, box[:99]], [box + 2.0]])
    assert volume._stands_along_z(person, Upright("y")) == along_z
    assert not volume._stands_along_z(SimpleNamespace(seen=[[box[:99]]]), Upright("y"))


@pytest.mark.parametrize(("share", "along_z"), [(0.57, False), (0.63, True)])
def test_z_points_up_and_not_down_if_most_of_the_person_is_in_the_usual_heights(share, along_z):
    usual = Volume.of(USUAL)
    height = np.where(np.arange(200) < 200 * share, usual.low[2] + 0.01, usual.low[2] - 0.01)
    height[:20] = usual.high[2] - 0.01
    person = SimpleNamespace(seen=[[np.stack([0 * height, 0 * height, height], axis=1)]])
    assert volume._stands_along_z(person, Upright("-z")) == along_z
    assert volume._stands_along_z(SimpleNamespace(seen=[[]]), Upright("-z"))
