"""What clouds and edges are made of, against plain NumPy and SciPy."""

import numpy as np
import pytest
from scipy.ndimage import binary_dilation, distance_transform_edt, uniform_filter

from stereotrack_core.depth.cloud import (
    Cloud,
    DepthGeometry,
    ViewDepth,
    colours_of,
    contradicted_share,
    edge_map,
    seen_through,
)
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.transform import RigidTransform

PLACE = RigidTransform(
    rotation_from_vector(np.array([0.1, -0.2, 0.05])), np.array([0.2, -0.1, 0.3])
)
GEOMETRY = DepthGeometry(300.0, 310.0, 180.0, 0.2, 5.0, 640, 360, PLACE)


def _view(rng, wide=1):
    ranges = rng.uniform(1.5, 3.0, (360, 640)).astype(np.float32)
    ranges[rng.random(ranges.shape) < 0.3] = np.nan
    person = rng.random(ranges.shape) < 0.001 * wide
    return ViewDepth(GEOMETRY, ranges, person, person)


def _points(rng, count):
    local = rng.uniform([-1.2, -0.9, 0.3], [1.2, 0.9, 2.5], (count, 3)) * [2.0, 2.0, 1.0]
    local[::7, 2] *= -1.0
    return local @ PLACE.rotation.T + PLACE.translation


def _through(view, points):
    local = (points - PLACE.translation) @ PLACE.rotation
    local = local[local[:, 2] > 0.0]
    column = np.rint(300.0 * local[:, 0] / local[:, 2] + 310.0)
    row = np.rint(300.0 * local[:, 1] / local[:, 2] + 180.0)
    inside = (column >= 0) & (column < 640) & (row >= 0) & (row < 360)
    at, z = (row[inside].astype(int), column[inside].astype(int)), local[inside, 2]
    person = binary_dilation(view.person, np.ones((19, 19)))[at]
    seen = view.range_z[at]
    asked = person | ~np.isnan(seen)
    return np.mean((~person & (seen > z + 0.15))[asked]) if asked.sum() >= 20 else None


def test_points_are_seen_through_where_a_view_sees_what_is_clearly_behind(rng):
    views, points = [_view(rng) for _ in range(3)], [_points(rng, 1200) for _ in range(3)]
    for view, own in zip(views, points, strict=True):
        assert seen_through(view, own) == pytest.approx(_through(view, own))
    assert seen_through(views[0], points[0][:20]) is None
    every, of = np.concatenate(points), np.repeat([0, 1, 2], 1200)
    depths = dict(zip("ac", (views[0], views[2]), strict=True))
    cloud = Cloud(0, every, of, np.zeros((3600, 2), int), ("a", "b", "c"), depths)
    shares = [_through(views[k], every[of != k][::7]) for k in (0, 2)]
    assert contradicted_share(cloud) == pytest.approx(np.mean(shares))
    assert np.isnan(contradicted_share(cloud.part(of == 0)))


def test_pixels_and_ranges_give_the_points_that_are_projected_there(rng):
    points = _points(rng, 50)
    u, v, z = GEOMETRY.project(points)
    np.testing.assert_allclose(GEOMETRY.points(u, v, z), points)
    d = GEOMETRY.disparity_at(np.float32([2.0, 3.0]))
    np.testing.assert_allclose(d, [300.0 * 0.2 / 2.0 + 5.0, 300.0 * 0.2 / 3.0 + 5.0])
    assert GEOMETRY.disparity_scale == pytest.approx(60.0)
    alone = DepthGeometry(300.0, 310.0, 180.0, 0.0, 0.0, 640, 360, PLACE)
    assert alone.disparity_scale == 75.0
    assert (
        ViewDepth(alone, np.ones((360, 640), np.float32), np.zeros((360, 640), bool)).disparity
        is None
    )


def test_colours_are_means_of_three_by_three_pixels(rng):
    picture = rng.integers(0, 255, (40, 50, 3), dtype=np.uint8)
    depths = {"b": ViewDepth(GEOMETRY, picture[..., 0], picture[..., 0] > 0, picture=picture)}
    view, pixels = rng.integers(0, 2, 30), rng.integers(1, 39, (30, 2))
    found = colours_of(("a", "b"), depths, view, pixels)
    mean = uniform_filter(picture.astype(float), (3, 3, 0))[pixels[:, 1], pixels[:, 0]]
    np.testing.assert_allclose(found[view == 1], mean[view == 1], atol=0.51)
    assert np.isnan(found[view == 0]).all()


@pytest.mark.parametrize(("left", "top", "width"), [(5, 60, 40), (100, 3, 30), (150, 110, 45)])
def test_edges_are_measured_from_the_outline_without_specks(left, top, width, rng):
    outline = np.zeros((150, 200), dtype=bool)
    outline[top : top + 35, left : left + width] = True
    outline[top + 5 : top + 30, left + 10 : left + 14] = False
    person = outline.copy()
    outline[140:150, :14] |= top < 100  # 140 pixels are noise
    ranges = rng.uniform(1.0, 2.0, outline.shape).astype(np.float32)
    found = edge_map(outline, ranges, (300.0, 90.0, 70.0), np.eye(4)[:3])
    x0, y0 = max(left - 32, 0), max(top - 32, 0)
    x1, y1 = min(left + width + 32, 200), min(top + 67, 150)
    np.testing.assert_array_equal(found.pinhole, [300.0, 90.0, 70.0, x0, y0])
    np.testing.assert_array_equal(found.range_z, ranges[y0:y1, x0:x1])
    inside = person[y0:y1, x0:x1]
    signed = np.where(
        inside, 0.5 - distance_transform_edt(inside), distance_transform_edt(~inside) - 0.5
    )
    np.testing.assert_allclose(found.distance, signed, rtol=0.03, atol=0.02)
    person[:] = False
    person[10:20, 10:24] = True
    assert edge_map(person, ranges, (300.0, 90.0, 70.0), np.eye(4)[:3]) is None
