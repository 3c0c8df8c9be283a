"""Points are found from their pictures, weighed by sigma, and mistakes are left out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stereotrack_core.geometry.triangulation import Sightings, point_of_sightings
from tests.annotation.scenes import LENSES, cameras

WORLD = np.array([0.1, -0.2, 1.3])


def sightings(lens="barrel", offsets=None, sigma=2.0):
    rig = list(cameras(lens).values())
    pixels = np.array([camera.project(WORLD) for camera in rig])
    if offsets is not None:
        pixels = pixels + offsets
    return Sightings.of(rig, pixels, np.full(4, sigma)), rig, pixels


@pytest.mark.parametrize("lens", LENSES)
def test_residuals_are_those_of_the_lens_for_small_errors(lens):
    seen, rig, pixels = sightings(lens)
    assert np.allclose(seen.residuals(WORLD), 0, atol=1e-4)
    near = WORLD + [0.004, -0.003, 0.005]
    exact = pixels - np.array([camera.project(near) for camera in rig])
    assert np.allclose(seen.residuals(near), exact, atol=0.02)
    both = seen.residuals(np.stack([WORLD, near]))
    assert np.allclose(both[1], seen.residuals(near))


def test_jacobian_is_the_derivative_of_the_residuals():
    seen, _, _ = sightings()
    step = 1e-6
    for axis in range(3):
        moved = WORLD + step * np.eye(3)[axis]
        slope = -(seen.residuals(moved) - seen.residuals(WORLD)) / step
        assert np.allclose(seen.jacobian(WORLD)[..., axis], slope, rtol=1e-3, atol=1e-2)


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


def test_one_mistake_of_four_is_told():
    offsets = np.zeros((4, 2))
    offsets[2] = [-45.0, 30.0]
    seen, _, _ = sightings(offsets=offsets)
    found = point_of_sightings(seen)
    assert found.outlier.tolist() == [False, False, True, False]
    assert np.allclose(found.world, WORLD, atol=1e-6)


def test_contradiction_makes_the_point_less_sure():
    calm = point_of_sightings(sightings()[0])
    offsets = np.array([[6.0, 0], [0, 6], [-6, 0], [0, -6]])
    torn = point_of_sightings(sightings(offsets=offsets)[0])
    assert np.trace(torn.covariance) > 3 * np.trace(calm.covariance)
    sure = point_of_sightings(sightings(sigma=1.0)[0])
    assert np.trace(sure.covariance) == pytest.approx(np.trace(calm.covariance) / 4, rel=1e-6)


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
