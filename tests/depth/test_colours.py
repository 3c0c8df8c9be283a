"""Colours of points."""

import numpy as np

from stereotrack_core.depth.cloud import DepthGeometry, ViewDepth
from stereotrack_core.depth.colours import colours_of
from stereotrack_core.geometry.transform import RigidTransform


def _view(picture):
    geometry = DepthGeometry(
        100.0, 3.5, 2.5, 0.1, 0.0, 8, 6, RigidTransform(np.eye(3), np.zeros(3))
    )
    shape = geometry.height, geometry.width
    return ViewDepth(
        geometry, None, np.ones(shape, np.float32), np.ones(shape, bool), None, None, picture
    )


def test_each_point_has_the_mean_colour_around_its_pixel_in_its_own_view():
    picture = np.zeros((6, 8, 3), np.uint8)
    picture[:, 4:] = (90, 30, 60)
    depths = {"N": _view(picture), "O": _view(np.full_like(picture, 7)), "S": _view(None)}
    pixels = np.array([[6, 2], [4, 3], [1, 1], [2, 2]])
    found = colours_of(("N", "O", "S"), depths, np.array([0, 0, 1, 2]), pixels)
    np.testing.assert_array_equal(found[:3], [[90, 30, 60], [60, 20, 40], [7, 7, 7]])
    assert np.isnan(found[3]).all()
    assert colours_of(("S",), {"S": depths["S"]}, np.array([0]), pixels[:1]) is None
