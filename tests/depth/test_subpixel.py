"""Alignment of the pictures around single pixels against disparities that are known."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stereotrack_core.depth.match import STEPS, DisparityRange, Matcher
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.subpixel import refined_disparity
from tests.depth.scenes import texture

SHAPE = 60, 160
ALL = np.ones(SHAPE, dtype=bool)
_ROWS, _COLUMNS = np.mgrid[10:50:3, 10:110:3]
PIXELS = np.stack([_COLUMNS.ravel(), _ROWS.ravel()], axis=1)


def exact_pair(shift, seed=0):
    """Left and right image of a sum of plane waves, without any interpolation."""
    rng = np.random.default_rng(seed)
    rows, columns = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)
    turn, phase = rng.uniform(0.0, 2 * np.pi, (2, 80))
    wave = 2 * np.pi / rng.uniform(4.0, 16.0, 80)
    images = []
    for by in (0.0, shift):
        along = np.multiply.outer(columns + by, wave * np.cos(turn))
        across = np.multiply.outer(rows, wave * np.sin(turn))
        grey = 127 + 8.0 * np.sin(along + across + phase).sum(axis=-1)
        images.append(np.rint(grey.clip(0, 255)).astype(np.uint8))
    return tuple(images)


def start(value, seed=0):
    """Disparities as a matcher might give them, up to a third of a pixel off."""
    return value + np.random.default_rng(seed).uniform(-0.33, 0.33, len(PIXELS))


@given(st.floats(2.0, 24.0))
@settings(max_examples=15, deadline=None)
def test_fractions_of_a_pixel_are_found(shift):
    left, right = exact_pair(shift)
    error = refined_disparity(left, right, ALL, PIXELS, start(shift), 11) - shift
    assert abs(np.mean(error)) < 0.05
    assert np.quantile(np.abs(error), 0.95) < 0.08


def test_errors_are_a_fraction_of_the_block_matchers():
    shift = 12.37
    left, right = exact_pair(shift)
    matcher = Matcher(DepthParameters(), DisparityRange(1, 32))
    steps = matcher(left, right)[PIXELS[:, 1], PIXELS[:, 0]]
    known = steps > matcher.disparities.invalid
    matched = steps[known] / STEPS - matcher.bias
    error = refined_disparity(left, right, ALL, PIXELS[known], matched, 11) - shift
    assert known.sum() > 200
    assert np.std(error) < 0.5 * np.std(matched - shift)


@pytest.mark.parametrize(("gain", "offset"), [(1.15, 0.0), (0.9, 12.0), (1.0, -15.0)])
def test_cameras_may_differ_in_gain_and_offset(gain, offset):
    left, right = exact_pair(9.6)
    brighter = np.clip(gain * left.astype(float) + offset, 0, 255).astype(np.uint8)
    error = refined_disparity(brighter, right, ALL, PIXELS, start(9.6), 11) - 9.6
    assert np.quantile(np.abs(error), 0.9) < 0.08


def test_the_wall_beside_a_thin_limb_is_kept_out():
    """A limb eight pixels wide in front of a strong pattern: only its own pixels are looked at."""
    limb = np.zeros(SHAPE, dtype=bool)
    limb[26:34] = True
    near, far = exact_pair(14.4, seed=1), texture(*SHAPE, seed=9)
    left, right = (np.where(limb, image, far).astype(np.uint8) for image in near)
    on_limb = PIXELS[limb[PIXELS[:, 1], PIXELS[:, 0]]]
    begun = np.full(len(on_limb), 14.1)
    alone = refined_disparity(left, right, limb, on_limb, begun, 11) - 14.4
    mixed = refined_disparity(left, right, ALL, on_limb, begun, 11) - 14.4
    assert np.quantile(np.abs(alone), 0.9) < 0.05
    assert np.std(alone) < 0.7 * np.std(mixed)


def test_what_cannot_be_aligned_stays_as_it_was():
    flat = np.full(SHAPE, 90, dtype=np.uint8)
    begun = start(8.0)
    assert np.array_equal(refined_disparity(flat, flat, ALL, PIXELS, begun, 11), begun)
    left, right = exact_pair(8.0)
    nobody = np.zeros(SHAPE, dtype=bool)
    assert np.array_equal(refined_disparity(left, right, nobody, PIXELS, begun, 11), begun)
    unlike = texture(*SHAPE, seed=77).astype(np.uint8)
    moved = refined_disparity(left, unlike, ALL, PIXELS, begun, 11) - begun
    assert np.abs(moved).max() <= 1.0


def test_the_images_borders_are_respected():
    left, right = exact_pair(20.3)
    corners = np.array([[0, 0], [159, 0], [0, 59], [159, 59], [138, 30]])
    found = refined_disparity(left, right, ALL, corners, np.full(5, 20.3), 11)
    assert np.isfinite(found).all()
    assert np.abs(found - 20.3).max() <= 1.0
