"""A click's curve in another image goes through every place where its landmark can be."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from stereotrack_core.annotation.predict import (
    epipolar_curve,
    in_image,
    ray_in_volume,
    volume_in_sight,
)
from stereotrack_core.depth.points import Volume
from tests.annotation.scenes import LENSES, VOLUME, cameras

pixels = st.tuples(st.floats(0, 639), st.floats(0, 479)).map(np.array)


def distance_to_line(point, line):
    """Least distance of a point (2,) from a line of points (K, 2)."""
    if len(line) == 1:
        return np.linalg.norm(point - line[0])
    start, step = line[:-1], np.diff(line, axis=0)
    length = np.maximum(np.einsum("ki,ki->k", step, step), 1e-12)
    share = np.clip(np.einsum("ki,ki->k", point - start, step) / length, 0, 1)
    return np.linalg.norm(start + share[:, None] * step - point, axis=1).min()


@pytest.mark.parametrize("lens", LENSES)
@given(pixel=pixels, share=st.floats(0, 1), names=st.permutations("NOSW"))
def test_curve_goes_through_every_point_of_the_ray(lens, pixel, share, names):
    rig = cameras(lens)
    one, two = rig[names[0]], rig[names[1]]
    direction = one.rays_world(pixel)
    near, far = ray_in_volume(one.position_world, direction, VOLUME)
    assume(far > near)
    point = one.position_world + (near + share * (far - near)) * direction
    seen = two.project(point)
    assume(in_image(two, seen))
    curve = epipolar_curve(one, pixel, two, VOLUME).pixels
    assert distance_to_line(seen, curve) < 0.1


@pytest.mark.parametrize("lens", LENSES)
@given(pixel=pixels, names=st.permutations("NOSW"))
def test_curve_stays_in_image_and_volume_and_its_distances_are_those_of_the_ray(lens, pixel, names):
    rig = cameras(lens)
    one, two = rig[names[0]], rig[names[1]]
    curve = epipolar_curve(one, pixel, two, VOLUME)
    size = np.array([two.width, two.height])
    assert (np.abs(curve.pixels - (size - 1) / 2) <= size / 2 + 1e-9).all()
    points = one.position_world + curve.distance[:, None] * one.rays_world(pixel)
    grown = Volume(VOLUME.low - 1e-9, VOLUME.high + 1e-9)
    assert grown.contains(points).all()
    assert np.allclose(two.project(points), curve.pixels, atol=1e-6)
    assert (np.diff(curve.distance) > 0).all()
    assert len(curve.distance) < 400


def test_volume_out_of_sight_is_put_where_the_cameras_look():
    far = Volume(VOLUME.low + 50.0, VOLUME.high + 50.0)
    found = volume_in_sight(far, tuple(cameras().values()))
    assert np.allclose(found.high - found.low, VOLUME.high - VOLUME.low)
    assert np.allclose(0.5 * (found.low + found.high), [0.0, 0.0, 1.1], atol=0.1)
    one = cameras()["N"]
    alone = volume_in_sight(far, (one,))
    assert in_image(one, one.project(0.5 * (alone.low + alone.high)))
