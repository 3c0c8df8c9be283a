"""A click's curve in another image goes through every place where its landmark can be."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
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
@settings(max_examples=30)
@given(pixel=pixels, share=st.floats(0, 1), names=st.permutations("NOSW"))
def test_curve_goes_through_every_point_of_the_ray(lens, pixel, share, names):
    rig = cameras(lens)
    one, two = rig[names[0]], rig[names[1]]
    direction = one.rays_world(pixel)
    near, far = ray_in_volume(one.position_world, direction, VOLUME)
    assume(far > near)
    point = one.position_world + (near + share * (far - near)) * direction
    seen = two.project(point)
    assume(in_image(two, seen) and min(*seen, *(two.width, two.height) - seen) > 3)
    curve = epipolar_curve(one, pixel, two, VOLUME)
    assert distance_to_line(seen, curve) < 0.1
    assert in_image(two, curve)[1:-1].all()


def test_volume_out_of_sight_is_put_where_the_cameras_look():
    far = Volume(VOLUME.low + 50.0, VOLUME.high + 50.0)
    found = volume_in_sight(far, tuple(cameras().values()))
    assert np.allclose(found.high - found.low, VOLUME.high - VOLUME.low)
    assert np.allclose(0.5 * (found.low + found.high), [0.0, 0.0, 1.1], atol=0.1)
    one = cameras()["N"]
    alone = volume_in_sight(far, (one,))
    assert in_image(one, one.project(0.5 * (alone.low + alone.high)))
