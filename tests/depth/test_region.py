import functools
import operator

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stereotrack_core.depth.cloud import DepthGeometry
from stereotrack_core.depth.light import empty_scene, light_of
from stereotrack_core.depth.match import (
    STEPS,
    DisparityRange,
    Matcher,
    Region,
    changed_bands,
    region_of_points,
)
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.geometry.transform import RigidTransform
from tests.depth.scenes import pair_with_disparity, texture

WHOLE = Region.whole(320, 240)


@given(st.integers(0, 90), st.integers(0, 40), st.integers(12, 60), st.integers(12, 19))
@settings(max_examples=25, deadline=None)
def test_a_region_is_matched_as_in_the_whole_image(left_edge, top, width, height):
    left, right = pair_with_disparity(np.full((60, 160), 9.3))
    region = Region(left_edge, top, min(left_edge + width, 160), top + height)
    matcher = Matcher(DepthParameters().replaced(match_left_right=-1), DisparityRange(1, 32))
    whole, part = matcher(left, right), matcher(left, right, region)
    assert np.array_equal(part, whole[region.slices])


def test_columns_up_to_the_right_border_are_measured():
    left, right = pair_with_disparity(np.full((60, 160), 9.0))
    disparities = DisparityRange(1, 64)
    steps = Matcher(DepthParameters(), disparities)(left, right)
    seen = np.flatnonzero((steps > disparities.invalid).mean(axis=0) > 0.5)
    # OpenCV alone stops 64 columns and half a window before the border.
    assert seen[-1] >= 160 - 1 - 9 - 5 - 3
    assert np.abs(steps[8:-8, 130:144] / STEPS - 9.0).max() < 0.3


def bands_of(image, empty, margin):
    return changed_bands(light_of(image, empty_scene(empty)), WHOLE, margin)


def test_what_changed_is_inside_the_region():
    empty = texture(240, 320, seed=1).astype(np.uint8)
    image = empty.copy()
    image[60:180, 100:140] = texture(240, 320, seed=2)[60:180, 100:140].astype(np.uint8)
    noise = np.random.default_rng(3).normal(0, 2.5, image.shape)
    bands = bands_of((image + noise).clip(0, 255).astype(np.uint8), empty, 8)
    region = functools.reduce(operator.or_, bands)
    assert region.left <= 100 - 4
    assert region.top <= 60 - 4
    assert 140 + 4 <= region.right <= 160
    assert 180 + 4 <= region.bottom <= 200


def test_bands_are_narrower_than_the_box_and_hold_all_that_changed():
    empty = (texture(240, 320, seed=1) * 0.7).astype(np.uint8)
    image, shape = empty.copy(), np.zeros(empty.shape, dtype=bool)
    shape[20:220, 150:170] = shape[60:70, 40:280] = True  # arms spread
    image[shape] = 255 - image[shape] // 2
    bands = bands_of(image, empty, 8)
    held = np.zeros(empty.shape, dtype=int)
    for band in bands:
        held[band.slices] += 1
    assert held.max() == 1
    around = cv2.dilate(shape.astype(np.uint8), np.ones((17, 17), np.uint8)).astype(bool)
    assert held[around].all()
    box = functools.reduce(operator.or_, bands)
    assert held.sum() < 0.5 * (box.right - box.left) * (box.bottom - box.top)


@pytest.mark.parametrize("gain", [0.8, 1.2])
def test_a_change_of_brightness_alone_is_not_taken_for_the_person(gain):
    empty = (texture(240, 320, seed=1) * 0.7).astype(np.uint8)
    image = (empty * gain).astype(np.uint8)
    image[100:140, 200:240] = 250
    region = functools.reduce(operator.or_, bands_of(image, empty, 0))
    assert region.right - region.left < 60
    assert region.bottom - region.top < 60


def test_where_the_comparison_proves_nothing_the_whole_image_is_taken():
    empty = texture(240, 320, seed=1).astype(np.uint8)
    assert bands_of(empty, empty, 8) == (WHOLE,)
    assert bands_of(texture(240, 320, seed=5).astype(np.uint8), empty, 8) == (WHOLE,)


def test_a_body_appears_inside_its_corners_region():
    g = DepthGeometry(400, 159.5, 119.5, 0.12, 0.0, 320, 240, RigidTransform.identity())
    corners = np.array([[x, y, z] for x in (-0.2, 0.3) for y in (-0.1, 0.1) for z in (2.0, 3.0)])
    region = region_of_points(g, corners)
    u, v = 400 * corners[:, 0] / corners[:, 2] + 159.5, 400 * corners[:, 1] / corners[:, 2] + 119.5
    assert region.left <= u.min()
    assert u.max() < region.right
    assert region.top <= v.min()
    assert v.max() < region.bottom
    assert region.right - region.left < 120
    assert region_of_points(g, corners - [0, 0, 2.5]) == WHOLE
    assert region_of_points(g, corners + [10.0, 0, 0]).is_empty
