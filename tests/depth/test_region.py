import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from stereotrack_core.depth.coarse import WIDE, CoarseToFine, matcher_of
from stereotrack_core.depth.light import empty_scene, light_of
from stereotrack_core.depth.match import DisparityRange, Matcher, Region, changed_bands
from stereotrack_core.depth.parameters import DepthParameters
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


def test_what_differs_by_no_more_than_noise_is_not_matched():
    empty = texture(240, 320, seed=1).astype(np.uint8)
    noise = np.random.default_rng(3).normal(0.0, 30.0, empty.shape)
    assert bands_of((empty + noise).clip(0, 255).astype(np.uint8), empty, 8) == ()


def test_only_wide_ranges_are_searched_so_and_not_by_the_thesis():
    wide = DisparityRange(1, WIDE)
    assert isinstance(matcher_of(DepthParameters(), wide), CoarseToFine)
    assert isinstance(matcher_of(DepthParameters(), DisparityRange(1, WIDE - 16)), Matcher)
    assert isinstance(matcher_of(preset("thesis").depth, wide), Matcher)
