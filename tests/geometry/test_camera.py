"""Cameras project as the pinhole equation says, and rays go back through their pixels."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.geometry.triangulation import nearest_to_rays

LENSES = {
    "none": (np.zeros(5), False),
    "four": (np.array([-0.2, 0.05, 0.001, -0.002]), False),
    "rational": (np.array([0.3, -0.1, 0.001, 0.002, 0.02, 0.2, -0.1, 0.03]), False),
    "fisheye": (np.array([0.05, -0.02, 0.005, -0.001]), True),
}
MATRIX = np.array([[500.0, 0, 322], [0, 510, 238], [0, 0, 1]])

places = st.builds(
    lambda r, t: RigidTransform(rotation_from_vector(r), t),
    hnp.arrays(np.float64, 3, elements=st.floats(-3, 3)),
    hnp.arrays(np.float64, 3, elements=st.floats(-3, 3)),
)


def camera_with(lens, camera_from_world=None):
    distortions, fisheye = LENSES[lens]
    place = RigidTransform.identity() if camera_from_world is None else camera_from_world
    return Camera("C", 640, 480, MATRIX, distortions, fisheye, place)


@given(places, hnp.arrays(np.float64, (5, 2), elements=st.floats(-0.6, 0.6)))
def test_projection_is_the_pinhole_equation(place, slopes):
    in_camera = np.concatenate([slopes, np.ones((5, 1))], axis=1) * [[1], [2], [3], [4], [5]]
    world = place.inverse().apply(in_camera)
    expected = slopes * [500, 510] + [322, 238]
    assert np.allclose(camera_with("none", place).project(world), expected, atol=1e-6)


@pytest.mark.parametrize("lens", LENSES)
def test_rays_go_through_their_pixels(lens):
    place = RigidTransform(rotation_from_vector(np.array([0.3, -1, 2])), np.array([1.0, 2, 3]))
    camera = camera_with(lens, place)
    pixels = np.random.default_rng(2).uniform((20, 20), (620, 460), (7, 3, 2))
    rays = camera.rays_world(pixels)
    assert rays.shape == (7, 3, 3)
    assert np.allclose(np.linalg.norm(rays, axis=-1), 1)
    for distance in (0.5, 4.0):
        found = camera.project(camera.position_world + distance * rays)
        assert np.allclose(found, pixels, rtol=0, atol=1e-4)


@pytest.mark.parametrize("count", [0, 4, 5, 8, 12, 14])
def test_many_points_have_the_pixels_that_opencv_gives_each_of_them(count):
    rng = np.random.default_rng(count)
    lens = rng.uniform(-0.02, 0.02, count)
    camera = Camera("C", 640, 480, MATRIX, lens, False, RigidTransform.identity())
    points = rng.uniform([-0.5, -0.4, 0.9], [0.5, 0.4, 1.1], (300, 3))
    expected, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), MATRIX, lens)
    found = camera.project(points)
    assert np.allclose(found, expected[:, 0], rtol=0, atol=1e-9)
    assert np.allclose(camera.project(points[:3]), found[:3], rtol=0, atol=1e-9)


@pytest.mark.parametrize("lens", LENSES)
def test_points_behind_the_camera_have_no_pixel(lens):
    points = np.array([[0, 0, -1.0], [0, 0, 0], [0.1, 0.1, 2.0], [np.nan, 0, 1]])
    found = camera_with(lens).project(points)
    assert np.isnan(found[[0, 1, 3]]).all()
    assert np.isfinite(found[2]).all()


@pytest.mark.parametrize(
    "distortions",
    [
        [-0.33, 0.046, -0.004, 0.004, 0.067],
        [-0.3, 0.0, 0, 0],
        [0.1, 0.1, 0, 0, 0, 0.9, -0.2, 0.3],
        [0.2, 0.1, 0, 0, 0.05],
    ],
)
def test_points_far_aside_do_not_fold_back_into_the_image(distortions):
    camera = replace(camera_with("none"), distortions=np.array(distortions))
    slopes = np.linspace(0, 5, 2001)
    points = np.stack([slopes, np.zeros_like(slopes), np.ones_like(slopes)], axis=-1)
    x = camera.project(points)[:, 0]
    known = np.isfinite(x)
    assert known[: known.sum()].all()
    assert (np.diff(x[known]) > -1e-9).all()
    straight, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), MATRIX, camera.distortions)
    grows = np.diff(straight[:, 0, 0]) > 0
    until = len(slopes) if grows.all() else int(np.argmin(grows))
    assert abs(known.sum() - until) <= 2


def test_rays_of_several_cameras_meet_in_their_point():
    points = np.random.default_rng(0).normal(size=(6, 3))
    origins = 4 * np.array([[1.0, 0, 0], [0, 1, 0], [-1, -1, 0.5]])
    directions = points[:, None] - origins
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    assert np.allclose(nearest_to_rays(origins, directions), points)
    directions[0, 1:] = np.nan
    directions[1, 2] = np.nan
    found = nearest_to_rays(origins, directions)
    assert np.isnan(found[0]).all()
    assert np.allclose(found[1:], points[1:])
