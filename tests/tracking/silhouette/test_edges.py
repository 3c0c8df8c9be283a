"""Distances from the edges of silhouettes."""

import dataclasses

import numpy as np
import pytest

from stereotrack_core.tracking.residuals.silhouette import edge_maps
from tests.tracking.views import HEIGHT, WIDTH, cloud_seen, looking, view_of


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


def test_distances_grow_by_one_per_pixel_across_the_edge(nobody):
    (edge,) = edge_maps(_with_outline(nobody, _box(100, 200, 150, 250)))
    steps = [_at(edge, 150, column) - _at(edge, 150, column + 1) for column in range(140, 160)]
    np.testing.assert_allclose(steps, 1.0, atol=0.05)


def test_the_map_reaches_around_the_person_alone(nobody):
    (edge,) = edge_maps(_with_outline(nobody, _box(100, 200, 150, 250)))
    assert edge.distance.shape == (164, 164)
    np.testing.assert_array_equal(edge.pinhole[3:], [118, 68])
    assert edge.range_z.shape == edge.distance.shape


def test_ranges_are_those_of_the_same_pixels(nobody):
    numbered = np.arange(HEIGHT * WIDTH, dtype=np.float32).reshape(HEIGHT, WIDTH)
    depth = dataclasses.replace(nobody.depths["N"], range_z=numbered)
    cloud = dataclasses.replace(nobody, depths={"N": depth})
    (edge,) = edge_maps(_with_outline(cloud, _box(100, 200, 150, 250)))
    np.testing.assert_array_equal(edge.range_z, numbered[68:232, 118:282])


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


@pytest.mark.parametrize("outline", [None, _box(0, 0, 0, 0), _box(10, 22, 10, 22)])
def test_without_a_silhouette_there_is_no_map(nobody, outline):
    assert edge_maps(_with_outline(nobody, outline)) == ()


def test_maps_know_where_their_camera_is(nobody):
    place = looking((1.0, 2.5, 1.8))
    depth = dataclasses.replace(view_of([], place), outline=_box(100, 200, 150, 250))
    (edge,) = edge_maps(dataclasses.replace(nobody, depths={"N": depth}))
    point = place.apply(np.array([0.2, -0.3, 2.0]))
    there = edge.camera_from_world @ [*point, 1.0]
    np.testing.assert_allclose(there, [0.2, -0.3, 2.0], atol=1e-12)
    g = depth.geometry
    np.testing.assert_array_equal(edge.pinhole[:3], [g.focal, g.c_x, g.c_y])
