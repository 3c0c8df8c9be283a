"""Points are found from their pictures, weighed by sigma, and mistakes are left out."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from stereotrack_core.geometry.camera import nearest_on_ray, pixel_jacobian
from stereotrack_core.geometry.triangulation import Sightings, point_of_sightings, segment_distance
from tests.annotation.scenes import LENSES, cameras

WORLD = np.array([0.1, -0.2, 1.3])


def sightings(lens="barrel", offsets=None, sigma=2.0):
    rig = list(cameras(lens).values())
    pixels = np.array([camera.project(WORLD) for camera in rig])
    if offsets is not None:
        pixels = pixels + offsets
    return Sightings.of(rig, pixels, np.full(4, sigma)), rig, pixels


@given(st.integers(0, 10_000))
def test_noise_leads_to_the_point_of_least_squares(seed):
    noise = np.random.default_rng(seed).normal(0, 0.3, (4, 2))
    seen, rig, pixels = sightings(offsets=noise)
    found = point_of_sightings(seen)

    def cost(world):
        return np.sum((pixels - np.array([camera.project(world) for camera in rig])) ** 2)

    for axis in np.eye(3):
        for step in (-1e-3, 1e-3):
            assert cost(found.world + step * axis) > cost(found.world)
    assert not found.outlier.any()


def test_too_few_and_hopeless_sightings_give_nothing():
    seen, rig, pixels = sightings()
    assert point_of_sightings(seen.without(0).without(0).without(0)) is None
    assert point_of_sightings(seen.without(0).without(0)) is not None
    one = rig[0]
    same = Sightings.of([one, one], pixels[[0, 0]], np.full(2, 2.0))
    assert point_of_sightings(same) is None
    # Two cameras side by side, whose rays part: they would meet behind both.
    aside = replace(
        one.camera_from_world, translation=one.camera_from_world.translation + [0.12, 0.0, 0.0]
    )
    pair = [one, replace(one, name="left", camera_from_world=aside)]
    towards = Sightings.of(pair, np.array([[320.0, 240], [380, 240]]), np.full(2, 2.0))
    apart = Sightings.of(pair, np.array([[320.0, 240], [260, 240]]), np.full(2, 2.0))
    assert point_of_sightings(towards) is not None
    assert point_of_sightings(apart) is None


ends = hnp.arrays(np.float64, (4, 3), elements=st.floats(-2, 2))


@given(ends)
@example(np.array([[1.0, 0, 0], [0, 0, 0], [0, 1.2e-38, 0], [0, 0, 0]]))
def test_distance_is_the_least_of_all_pairs_of_points(corners):
    a, b, c, d = corners
    share = np.linspace(0, 1, 201)
    one = a + share[:, None] * (b - a)
    two = c + share[:, None] * (d - c)
    least = np.linalg.norm(one[:, None] - two[None], axis=-1).min()
    found = segment_distance(a, b, c, d)
    assert found <= least + 1e-9
    assert found >= least - 0.02 * max(np.linalg.norm(b - a), np.linalg.norm(d - c)) - 1e-9


def test_points_and_parallels():
    o, x, y = np.zeros(3), np.array([1.0, 0, 0]), np.array([0, 1.0, 0])
    assert segment_distance(o, o, x, x) == 1.0
    assert segment_distance(o, x, y, x + y) == 1.0
    assert segment_distance(o, x, 3 * x, 4 * x) == 2.0
    assert np.isnan(segment_distance(o, x, y, np.full(3, np.nan)))


POINTS = np.array([[0.1, 0.2, 1.2], [-0.3, 0.1, 0.9]])


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
