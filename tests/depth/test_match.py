from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stereotrack_core.depth.match import STEPS, DisparityRange, Matcher, Region
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.subpixel import refined_disparity
from tests.depth.scenes import pair_with_disparity

RANGE = DisparityRange(1, 32)


def measured(left, right, disparities=RANGE, **values):
    matcher = Matcher(DepthParameters().replaced(**values), disparities)
    steps = matcher(left, right)
    return np.where(steps > disparities.invalid, steps / STEPS - matcher.bias, np.nan)


@pytest.mark.parametrize("matcher", ["bm", "sgbm"])
@pytest.mark.parametrize("edges", [True, False])
@pytest.mark.parametrize("shift", [3, 8, 17, 25])
def test_a_pixel_of_the_right_image_appears_on_the_left_at_u_plus_d(matcher, edges, shift):
    left, right = pair_with_disparity(np.full((60, 160), float(shift)))
    d = measured(left, right, matcher=matcher, edge_images=edges)
    # Near the border the windows are cut off and may be wrong; not by a shift, though.
    inner = np.zeros_like(d, dtype=bool)
    inner[8:-8, 8 : -8 - shift] = True
    rows, columns = np.nonzero(np.isfinite(d) & inner)
    assert len(rows) > 3500
    assert np.abs(d[rows, columns] - shift).max() <= 0.25
    # Directly on the images: the grey found at u + d in the left one is the right one's own.
    assert np.array_equal(left[rows, columns + shift], right[rows, columns])


@given(st.floats(2.0, 24.0))
@settings(max_examples=15, deadline=None)
def test_fractions_of_a_pixel_are_measured_without_bias(shift):
    left, right = pair_with_disparity(np.full((60, 160), shift))
    error = (measured(left, right) - shift)[10:-10, 10:-40]
    assert abs(np.nanmean(error)) < 0.04
    assert np.nanstd(error) < 0.1


def test_negative_disparities_are_found():
    left, right = pair_with_disparity(np.full((60, 160), -7.0))
    d = measured(left, right, DisparityRange(-16, 16))
    assert abs(np.nanmedian(d) + 7.0) < 0.1
    assert np.isfinite(d).mean() > 0.5


def test_what_one_image_does_not_show_is_rejected_by_the_left_right_check():
    left, right = pair_with_disparity(np.full((60, 160), 9.0))
    right[:, 60:90] = pair_with_disparity(np.full((60, 160), 9.0), seed=7)[1][:, 60:90]
    checked = measured(left, right, match_left_right=0, match_uniqueness=0)
    unchecked = measured(left, right, match_left_right=-1, match_uniqueness=0)
    unseen = np.s_[:, 66:84]
    assert np.isfinite(checked[unseen]).mean() < 0.6 * np.isfinite(unchecked[unseen]).mean()


@pytest.mark.parametrize("left", [30, 130])
def test_beside_a_part_only_what_its_windows_and_disparities_reach_is_matched(left):
    matcher, columns = Matcher(DepthParameters().replaced(match_window=11), RANGE), []
    compute = matcher._matcher.compute

    def counted(one, other):
        columns.append(one.shape[1])
        return compute(one, other)

    matcher._matcher = SimpleNamespace(compute=counted)
    matcher(*pair_with_disparity(np.full((60, 160), 9.0)), Region(left, 10, left + 30, 40))
    window, most = 11 // 2 + 1, RANGE.minimum + RANGE.count
    assert columns == [window + 30 + window + most]


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


@pytest.mark.parametrize("nothing", [np.nan, np.inf])
def test_a_pixel_without_a_disparity_keeps_none_and_spoils_no_other(nothing):
    left, right = exact_pair(5.3)
    known = start(5.3)
    given_less = known.copy()
    given_less[::7] = nothing
    found = refined_disparity(left, right, ALL, PIXELS, given_less, 11)
    expected = refined_disparity(left, right, ALL, PIXELS, known, 11)
    expected[::7] = nothing
    np.testing.assert_array_equal(found, expected)


def test_the_beginning_of_other_rows_says_nothing_about_the_end_of_one():
    left, right = exact_pair(-7.3)  # what is beyond the right one's border is seen on the left
    pixels = np.stack([np.full(20, SHAPE[1] - 3), np.arange(20, 40)], axis=1)
    found = refined_disparity(left, right, ALL, pixels, np.full(20, -7.1), 11)
    np.testing.assert_allclose(found, -7.3, atol=0.1)
    right[:, :10] = 255 - right[:, :10]
    again = refined_disparity(left, right, ALL, pixels, np.full(20, -7.1), 11)
    np.testing.assert_array_equal(again, found)
