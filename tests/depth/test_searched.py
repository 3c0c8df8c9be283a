"""Which disparities are searched, where pictures differ, and what is refused, by plain numbers."""

from contextlib import nullcontext

import cv2
import numpy as np
import pytest
from scipy.ndimage import maximum_filter, uniform_filter

from stereotrack_core.depth.cloud import DepthGeometry
from stereotrack_core.depth.coarse import CoarseToFine, _cuts, _reduced
from stereotrack_core.depth.light import Relit
from stereotrack_core.depth.match import STEPS, DisparityRange, Region
from stereotrack_core.depth.outline import (
    Compared,
    beside,
    new_pixels,
    same_structure,
    sharp_outline,
)
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.sources import NoDepth, disparity_range, moved_up, refuse_dark
from stereotrack_core.geometry.transform import RigidTransform
from tests.depth.scenes import texture

USUAL = DepthParameters()


@pytest.mark.parametrize("width", [640, 120])
@pytest.mark.parametrize("offset", [-3.4, 0.0, 7.6])
@pytest.mark.parametrize("away", [3.0, 2.0, 0.5])
@pytest.mark.parametrize("count", [64, 200])
def test_disparities_reach_from_the_stated_one_to_the_volume_s_nearest_corner(
    width, offset, away, count
):
    axes = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
    facing = RigidTransform(axes, np.array([0.0, -away, 1.0]))
    geometry = DepthGeometry(500.0, width / 2, 120.0, 0.15, offset, width, 240, facing)
    p = USUAL.replaced(disparity_count=count, disparity_minimum=2)
    nearest = max(away - 0.5 * p.volume_y, 0.3)
    everywhere = p.replaced(disparity_from_volume=False)
    for given, highest in ((p, 500.0 * 0.15 / nearest + 1.0), (everywhere, 1e3)):
        top = min(2.0 + count - 1, highest)
        first, last = int(np.floor(2.0 + offset)), int(np.ceil(top + offset))
        needed = 16 * int(np.ceil((last - first + 1) / 16))
        room = max(16 * ((width - abs(first) - 1) // 16) - 16, 16)
        assert disparity_range(geometry, given) == DisparityRange(first, min(needed, room))


@pytest.mark.parametrize(("minimum", "count", "shrink"), [(3, 208, 2), (-9, 256, 4), (5, 400, 4)])
def test_around_what_reduced_images_show_few_disparities_are_searched(minimum, count, shrink, rng):
    every = DisparityRange(minimum, count)
    search = CoarseToFine(USUAL, every)
    coarse = search._coarse.disparities
    assert coarse.minimum == minimum // shrink
    assert coarse.count == 16 * int(np.ceil((count // shrink + 2) / 16))
    nothing = np.full((4, 5), coarse.invalid, np.int16)
    assert search._range_of(nothing) == every
    for _ in range(40):
        shown = nothing.copy()
        low, high = np.sort(rng.uniform(coarse.minimum, coarse.minimum + count / shrink, 2))
        shown[0, 0], shown[2, 3] = int(STEPS * low), int(STEPS * high)
        first = max(int(np.floor(shown[0, 0] / STEPS * shrink)) - 3, minimum)
        last = int(np.ceil(shown[2, 3] / STEPS * shrink)) + 3
        needed = max(16 * int(np.ceil((last + 1 - first) / 16)), 16)
        first = min(first, max(minimum + count - needed, minimum))
        expected = DisparityRange(first, needed) if needed < count else every
        assert search._range_of(shown) == expected


def test_tiles_of_an_image_are_no_narrow_strips():
    assert _cuts(0, 640, 128) == [0, 128, 256, 384, 512, 640]
    assert _cuts(64, 640, 128) == [64, 128, 256, 384, 512, 640]
    assert _cuts(65, 575, 128) == [65, 256, 384, 575]
    assert _cuts(130, 150, 128) == [130, 150]
    assert _reduced(Region(5, 9, 21, 30), 4) == Region(1, 2, 6, 8)


def test_images_are_moved_up_by_parts_of_rows():
    image = texture(60, 80, seed=2).astype(np.uint8)
    np.testing.assert_array_equal(moved_up(image, 3.0)[:-3], image[3:])
    half = moved_up(image, 0.5)[10:-10].astype(float)
    between = 0.5 * (image[10:-10].astype(float) + image[11:-9])
    assert np.abs(half - between).mean() < 0.3 * np.abs(half - image[10:-10]).mean()


def _outline(difference, foreground, noise, behind):
    """The same by definition; closing and opening are OpenCV's."""
    strongest = maximum_filter(difference, 7)
    limit = np.floor(np.clip(np.maximum(0.4 * strongest, max(10.0, 4.0 * noise)), 0, 255))
    new = (difference > limit) & ~behind
    new |= cv2.erode(foreground.astype(np.uint8), np.ones((9, 9), np.uint8)) > 0
    round_five = np.ones((5, 5), np.uint8)
    round_five[[0, 0, 0, 0, 4, 4, 4, 4], [0, 1, 3, 4, 0, 1, 3, 4]] = 0
    closed = cv2.morphologyEx(new.astype(np.uint8), cv2.MORPH_CLOSE, round_five)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(1 - closed, connectivity=4)
    for hole in range(1, count):
        if stats[hole, cv2.CC_STAT_AREA] < 60:
            closed[labels == hole] = 1
    cross = np.uint8([[0, 1, 0], [1, 1, 1], [0, 1, 0]])
    return cv2.morphologyEx(closed, cv2.MORPH_OPEN, cross) > 0


@pytest.mark.parametrize("noise", [0.0, 4.0])
@pytest.mark.parametrize("seed", range(3))
def test_outlines_are_where_half_of_the_strongest_difference_is(seed, noise):
    rng = np.random.default_rng(seed)
    levels = np.kron(rng.choice([0, 9, 11, 15, 17, 39, 41, 100, 240], (20, 26)), np.ones((6, 6)))
    difference = levels.astype(np.uint8)
    foreground = np.kron(rng.random((6, 8)) < 0.3, np.ones((20, 20)))[:, :156] > 0
    behind = np.kron(rng.random((12, 16)) < 0.3, np.ones((10, 10)))[:, :156] > 0
    found = sharp_outline(difference, foreground, noise, behind)
    np.testing.assert_array_equal(found, _outline(difference, foreground, noise, behind))
    assert 0.1 < found.mean() < 0.9


def test_pixels_are_new_or_beside_by_plain_limits(rng):
    difference = rng.integers(0, 40, (30, 40)).astype(np.uint8)
    np.testing.assert_array_equal(new_pixels(difference, 1.0), difference > 10)
    np.testing.assert_array_equal(new_pixels(difference, 5.0), difference > 20)
    foreground = rng.random((60, 80)) < 0.004
    np.testing.assert_array_equal(beside(foreground), maximum_filter(foreground, 9) == 0)


def _mean(image, size):
    return uniform_filter(np.asarray(image, dtype=float), size, mode="mirror")


@pytest.mark.parametrize("noise", [0.0, 3.5])
def test_shadows_keep_the_structure_but_for_a_gain(noise, rng):
    before = (0.7 * texture(60, 80, seed=4)).astype(np.uint8)
    grain = rng.normal(0.0, np.linspace(0, 60, 60)[:, None], (60, 80))
    now = before * np.linspace(0.4, 1.3, 80) + grain
    now = now.clip(0, 255).astype(np.uint8)
    a, b = (np.rint(_mean(one, 3)) for one in (now, before))
    gain = (_mean(a, 5) + 1.0) / (_mean(b, 5) + 1.0)
    apart = _mean(np.abs(a - gain * b), 5)
    limit = max(4.0, 2.0 * noise)
    unclear = np.abs(apart - limit) < 0.02  # blurred levels are rounded
    same = same_structure(now, before, noise)
    np.testing.assert_array_equal(same[~unclear], (apart < limit)[~unclear])
    assert 0.1 < same.mean() < 0.95


@pytest.mark.parametrize(("noise", "limit"), [(0.0, 6), (9.0, 27)])
def test_a_picture_changes_by_more_than_a_halo_and_gaps_are_closed(noise, limit):
    before = np.full((60, 80), 100, np.uint8)
    for level, changed, closed in ((limit, 0, 0), (limit + 1, 1, 0), (4 * limit, 1, 1)):
        now = before.copy()
        now[10:30, 10:30] = now[10:30, 34:50] = 100 + level
        same = np.zeros(now.shape, dtype=bool)
        same[:, 44:] = True
        empty = Relit(before, noise, 0.0)
        found = Compared(now, before, now - before, empty, 11, same).changed()
        assert [found[20, 20], found[20, 31], found[20, 46]] == [changed, closed, 0]


@pytest.mark.parametrize(
    ("bright", "level", "dark"), [(1, 16, True), (2, 16, False), (2, 15, True)]
)
def test_pictures_of_which_less_than_a_hundredth_is_bright_are_dark(bright, level, dark):
    image = np.zeros((80, 160), np.uint8)  # 200 pixels are looked at
    image[4, 4 : 8 * bright : 8] = level
    with pytest.raises(NoDepth, match="left") if dark else nullcontext():
        refuse_dark(image, "left image")
