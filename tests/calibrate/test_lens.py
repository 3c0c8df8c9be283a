"""Lens models: the same pixels as the camera of a recording, and derivatives that are right."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stereotrack_core.calibrate.lens import LENS_MODELS, Lens, lens_of, projected
from stereotrack_core.geometry.transform import RigidTransform
from tests.calibrate.scenes import BENT, HERE, ROUND, SIZE, WIDE

_STEP = 1e-6


@pytest.mark.parametrize("model", LENS_MODELS.values(), ids=LENS_MODELS)
@given(seed=st.integers(0, 10_000))
def test_derivatives_agree_with_finite_differences(model, seed):
    rng = np.random.default_rng(seed)
    values = np.zeros(model.free.size)
    values[:4] = (400, 410, 320, 240)
    values[4:] = rng.normal(0, 0.05, values.size - 4)
    lens = Lens(model, values * model.free)
    points = rng.normal(size=(8, 3)) * (0.5, 0.5, 0.2) + (0, 0, 2)
    points[0, :2] = 0  # on the axis
    pixels, by_point, by_lens = projected(lens, points)
    camera = lens.camera("a", SIZE, HERE)
    if np.isinf(camera.widest_slope):
        np.testing.assert_allclose(camera.project(points), pixels, atol=1e-9)
    for axis in range(3):
        step = _STEP * np.eye(3)[axis]
        change = projected(lens, points + step)[0] - projected(lens, points - step)[0]
        np.testing.assert_allclose(by_point[:, :, axis], change / (2 * _STEP), atol=1e-5)
    for i in range(values.size):
        step = _STEP * np.eye(values.size)[i]
        more, less = (Lens(model, lens.values + sign * step) for sign in (1, -1))
        change = projected(more, points)[0] - projected(less, points)[0]
        np.testing.assert_allclose(by_lens[:, :, i], change / (2 * _STEP), atol=1e-5)


@pytest.mark.parametrize("lens", [BENT, WIDE, ROUND])
def test_a_camera_gives_its_lens_again(lens):
    again = lens_of(lens.camera("a", SIZE, RigidTransform.identity()))
    assert again.model is lens.model
    np.testing.assert_array_equal(again.values, lens.values)
