import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stereotrack_core.depth.match import STEPS, DisparityRange, Matcher, edge_image
from stereotrack_core.depth.parameters import DepthParameters
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


def test_disparities_have_no_bias_over_the_phases_of_a_pixel():
    """Without the matcher's own bias: StereoBM rounds up by 0.03 px."""
    means = []
    for shift in np.arange(8.0, 9.0, 0.125):
        left, right = pair_with_disparity(np.full((60, 160), shift), seed=int(shift * 8))
        means.append(np.nanmean((measured(left, right) - shift)[10:-10, 10:-40]))
    assert abs(np.mean(means)) < 0.01


def test_a_slope_is_seen_at_the_right_images_own_column():
    truth = np.broadcast_to(6.0 + 0.06 * np.arange(200), (80, 200))
    left, right = pair_with_disparity(truth)
    error = measured(left, right) - truth
    assert np.isfinite(error).mean() > 0.6
    # A disparity booked on the left image's column would be off by 0.06 d: 0.4 px and more.
    assert abs(np.nanmedian(error)) < 0.05


def test_a_step_stands_at_the_right_images_edge():
    truth = np.full((80, 200), 6.0)
    truth[:, 100:] = 20.0  # u + d keeps growing with u
    left, right = pair_with_disparity(truth)
    d = np.nanmedian(measured(left, right)[8:-8, 8:160], axis=0)
    assert np.abs(d[:78] - 6).max() < 0.3  # columns 8 to 85
    assert np.abs(d[102:] - 20).max() < 0.3  # columns 110 to 159


def test_negative_disparities_are_found():
    left, right = pair_with_disparity(np.full((60, 160), -7.0))
    d = measured(left, right, DisparityRange(-16, 16))
    assert abs(np.nanmedian(d) + 7.0) < 0.1
    assert np.isfinite(d).mean() > 0.5


def test_plain_surfaces_are_rejected_by_texture():
    left, right = (np.full((60, 160), 90, dtype=np.uint8) for _ in range(2))
    assert np.isnan(measured(left, right)).all()


def test_what_one_image_does_not_show_is_rejected_by_the_left_right_check():
    left, right = pair_with_disparity(np.full((60, 160), 9.0))
    right[:, 60:90] = pair_with_disparity(np.full((60, 160), 9.0), seed=7)[1][:, 60:90]
    checked = measured(left, right, match_left_right=0, match_uniqueness=0)
    unchecked = measured(left, right, match_left_right=-1, match_uniqueness=0)
    unseen = np.s_[:, 66:84]
    assert np.isfinite(checked[unseen]).mean() < 0.6 * np.isfinite(unchecked[unseen]).mean()


def test_edge_images_do_not_depend_on_brightness():
    left, _ = pair_with_disparity(np.full((40, 60), 5.0))
    darker = (left // 2 + 20).astype(np.uint8)
    brighter = (darker + 60).astype(np.uint8)
    assert np.array_equal(edge_image(darker), edge_image(brighter))


@pytest.mark.parametrize("matcher", ["bm", "sgbm"])
def test_a_gain_difference_does_not_change_the_result_much(matcher):
    left, right = pair_with_disparity(np.full((60, 160), 11.0))
    brighter = (left * 1.15).clip(0, 255).astype(np.uint8)
    d = measured(brighter, right, matcher=matcher)
    assert abs(np.nanmedian(d) - 11.0) < 0.1
    assert np.isfinite(d).mean() > 0.5
