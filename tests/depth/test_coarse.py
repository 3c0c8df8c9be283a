import numpy as np
import pytest

from stereotrack_core.depth.coarse import WIDE, CoarseToFine, matcher_of
from stereotrack_core.depth.match import STEPS, DisparityRange, Matcher, Region
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.tracking.presets import preset
from tests.depth.scenes import pair_with_disparity

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


def test_a_region_is_searched_as_the_whole_image():
    matcher, region = CoarseToFine(DepthParameters(), RANGE), Region(100, 50, 430, 210)
    whole, part = measured(matcher)[region.slices], measured(matcher, region)
    assert part.shape == whole.shape
    same = np.isclose(part, whole, atol=0.1) | (np.isnan(part) & np.isnan(whole))
    assert same.mean() > 0.97


def test_plain_images_are_searched_in_full_and_give_nothing():
    plain = np.full((120, 400), 90, dtype=np.uint8)
    matcher = CoarseToFine(DepthParameters(), RANGE)
    assert (matcher(plain, plain) == RANGE.invalid).all()


def test_negative_ranges_are_kept_within():
    left, right = pair_with_disparity(np.full((100, 400), -7.0))
    matcher = CoarseToFine(DepthParameters(), DisparityRange(-40, 128))
    steps = matcher(left, right)
    found = steps[steps > matcher.disparities.invalid] / STEPS - matcher.bias
    assert len(found) > 0.4 * steps.size
    assert np.percentile(np.abs(found + 7.0), 95) < 0.4


def test_only_wide_ranges_are_searched_so_and_not_by_the_thesis():
    wide = DisparityRange(1, WIDE)
    assert isinstance(matcher_of(DepthParameters(), wide), CoarseToFine)
    assert isinstance(matcher_of(DepthParameters(), DisparityRange(1, WIDE - 16)), Matcher)
    assert isinstance(matcher_of(preset("thesis").depth, wide), Matcher)
