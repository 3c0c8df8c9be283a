"""Derivatives of projections, and the point of a ray that is nearest to a pixel."""

from __future__ import annotations

import numpy as np
import pytest

from stereotrack_core.geometry.camera import nearest_on_ray, pixel_jacobian
from tests.annotation.scenes import LENSES, MATRIX, cameras

POINTS = np.array([[0.1, 0.2, 1.2], [-0.3, 0.1, 0.9]])


def test_jacobian_of_a_lens_without_distortion_is_that_of_the_pinhole():
    camera = cameras("plain")["N"]
    x, y, z = camera.camera_from_world.apply(POINTS).T
    slope = np.zeros((2, 2, 3))
    slope[:, 0, 0], slope[:, 1, 1] = MATRIX[0, 0] / z, MATRIX[1, 1] / z
    slope[:, 0, 2], slope[:, 1, 2] = -MATRIX[0, 0] * x / z**2, -MATRIX[1, 1] * y / z**2
    expected = slope @ camera.camera_from_world.rotation
    assert np.allclose(pixel_jacobian(camera, POINTS), expected, rtol=1e-6)


@pytest.mark.parametrize("lens", LENSES)
def test_jacobian_tells_small_steps(lens):
    camera = cameras(lens)["O"]
    step = np.array([0.002, -0.001, 0.003])
    moved = camera.project(POINTS + step) - camera.project(POINTS)
    assert np.allclose(pixel_jacobian(camera, POINTS) @ step, moved, atol=5e-3)


def test_jacobian_of_what_cannot_be_seen_is_not_known():
    camera = cameras()["N"]
    behind = camera.position_world - 2 * camera.camera_from_world.rotation[2]
    assert np.isnan(pixel_jacobian(camera, behind)).all()


@pytest.mark.parametrize("lens", LENSES)
def test_nearest_point_of_a_ray_is_nearer_than_its_neighbours(lens):
    rig = cameras(lens)
    origin = rig["N"].position_world
    direction = rig["N"].rays_world(np.array([330.0, 250.0]))
    pixel = rig["O"].project(origin + 2.8 * direction) + [3.0, 9.0]
    found = nearest_on_ray(rig["O"], pixel, origin, direction, 2.5)
    away = np.linalg.norm(rig["O"].project(found) - pixel)
    assert np.allclose(np.cross(found - origin, direction), 0, atol=1e-9)
    for step in (-0.01, 0.01):
        assert np.linalg.norm(rig["O"].project(found + step * direction) - pixel) > away
