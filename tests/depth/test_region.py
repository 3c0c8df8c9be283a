import functools
import operator

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stereotrack_core.depth.cloud import DepthGeometry
from stereotrack_core.depth.coarse import WIDE, CoarseToFine, matcher_of
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
from stereotrack_core.tracking.presets import preset
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


def test_patches_far_apart_are_matched_apart_and_specks_not_at_all():
    empty = texture(240, 320, seed=1).astype(np.uint8)
    image = empty.copy()
    for left in (20, 260):
        image[100:140, left : left + 40] = 255 - image[100:140, left : left + 40]
    image[8:12, 160:164] = 255
    bands = bands_of(image, empty, 8)
    assert {band.right < 160 for band in bands} == {True, False}
    assert all(band.right < 100 or band.left > 220 for band in bands)
    assert bands_of(empty, empty, 8) == ()


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


RANGE = DisparityRange(1, 256)
TRUTH = np.full((240, 700), 20.0)

TRUTH[60:200, 300:] = 170.0  # something near, before a wall

LEFT, RIGHT = pair_with_disparity(TRUTH)


def measured(matcher, region=None):
    steps = matcher(LEFT, RIGHT, region)
    known = steps > matcher.disparities.invalid
    return np.where(known, steps / STEPS - matcher.bias, np.nan)


@pytest.mark.parametrize("kind", ["bm", "sgbm"])
def test_near_and_far_surfaces_are_found_as_in_the_full_range(kind):
    p = DepthParameters().replaced(matcher=kind)
    coarse, full = measured(CoarseToFine(p, RANGE)), measured(Matcher(p, RANGE))
    for found in (coarse, full):
        error = np.abs(found - TRUTH)
        near = error[70:190, 310:500]
        wall = error[20:220, 20:280]
        assert np.nanmax(near) < 1.0
        assert np.nanmax(wall) < 1.0
        assert np.isfinite(near).mean() > 0.9
        assert np.isfinite(wall).mean() > 0.9


def test_only_wide_ranges_are_searched_so_and_not_by_the_thesis():
    wide = DisparityRange(1, WIDE)
    assert isinstance(matcher_of(DepthParameters(), wide), CoarseToFine)
    assert isinstance(matcher_of(DepthParameters(), DisparityRange(1, WIDE - 16)), Matcher)
    assert isinstance(matcher_of(preset("thesis").depth, wide), Matcher)
