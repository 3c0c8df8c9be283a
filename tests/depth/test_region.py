from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import binary_dilation, label

from stereotrack_core.depth.cloud import DepthGeometry
from stereotrack_core.depth.coarse import WIDE, CoarseToFine, matcher_of
from stereotrack_core.depth.light import Light
from stereotrack_core.depth.match import (
    DisparityRange,
    Matcher,
    Region,
    changed_bands,
    region_of_points,
    within,
)
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.tracking.presets import preset
from tests.depth.scenes import pair_with_disparity

WHOLE = Region.whole(320, 240)


@given(st.integers(0, 90), st.integers(0, 40), st.integers(12, 60), st.integers(12, 19))
@settings(max_examples=25, deadline=None)
def test_a_region_is_matched_as_in_the_whole_image(left_edge, top, width, height):
    left, right = pair_with_disparity(np.full((60, 160), 9.3))
    region = Region(left_edge, top, min(left_edge + width, 160), top + height)
    matcher = Matcher(DepthParameters().replaced(match_left_right=-1), DisparityRange(1, 32))
    whole, part = matcher(left, right), matcher(left, right, region)
    assert np.array_equal(part, whole[region.slices])


def test_only_wide_ranges_are_searched_so_and_not_by_the_thesis():
    wide = DisparityRange(1, WIDE)
    assert isinstance(matcher_of(DepthParameters(), wide), CoarseToFine)
    assert isinstance(matcher_of(DepthParameters(), DisparityRange(1, WIDE - 16)), Matcher)
    assert isinstance(matcher_of(preset("thesis").depth, wide), Matcher)


def test_regions_are_cut_grown_and_joined():
    one, other = Region(2, 3, 10, 20), Region(5, 1, 12, 15)
    assert one | other == other | one == Region(2, 1, 12, 20)
    assert one & other == other & one == Region(5, 3, 10, 15)
    assert one.grown(2) == Region(0, 1, 12, 22)
    assert one.slices == np.s_[3:20, 2:10]
    assert one.slices_in(Region(1, 2, 30, 30)) == np.s_[1:18, 1:9]
    for empty in (Region(4, 1, 4, 9), Region(5, 1, 4, 9), Region(1, 9, 4, 9)):
        assert empty.is_empty
    assert not Region(4, 1, 5, 2).is_empty
    assert within([one, Region(40, 1, 50, 2)], Region(0, 0, 6, 9)) == (Region(2, 3, 6, 9),)


def test_a_body_appears_where_its_corners_do(rng):
    still = RigidTransform(np.eye(3), np.zeros(3))
    geometry = DepthGeometry(200.0, 160.0, 120.0, 0.1, 0.0, 320, 240, still)
    for _ in range(20):
        corners = rng.normal(0.0, 0.4, (8, 3)) + [0.0, 0.0, 2.0]
        pixels = np.floor(corners[:, :2] / corners[:, 2:] * 200.0 + [160.0, 120.0])
        (left, top), (right, bottom) = pixels.min(axis=0), pixels.max(axis=0) + 2
        expected = max(left, 0), max(top, 0), min(right, 320), min(bottom, 240)
        found = region_of_points(geometry, corners)
        assert (found.left, found.top, found.right, found.bottom) == expected
    for z, whole in ((0.09, True), (0.11, False)):
        corners = np.array([[0.0, 0.0, 2.0], [0.0, 0.0, z]])
        assert (region_of_points(geometry, corners) == WHOLE) == whole


def _light(apart, noise=0.0):
    """Shrunken pictures (60, 80) that differ by so many grey levels."""
    plain = np.full((60, 80), 100.0, np.float32)
    return Light(np.zeros(256), plain, plain + apart.astype(np.float32), plain, noise)


@pytest.mark.parametrize("seed", range(6))
def test_bands_cover_what_differs_and_little_more(seed):
    rng, margin, levels = np.random.default_rng(seed), 10, np.zeros((60, 80))
    for _ in range(4):
        top, left = rng.integers(0, 50), rng.integers(0, 70)
        height, width = rng.integers(1, 30), rng.integers(3, 20)
        levels[top : top + height, left : left + width] = rng.choice([-9, 9])
    levels[np.arange(60), np.arange(60) + seed] = 9  # slanted: every band has columns of its own
    changed = levels != 0.0
    near = binary_dilation(changed, np.ones((7, 7)))
    patches, count = label(near, np.ones((3, 3)))
    expected = []
    for number in range(1, count + 1):
        rows, columns = np.nonzero(changed & (patches == number))
        first, end = 4 * rows.min() - margin, 4 * (rows.max() + 2) + margin
        cuts = np.linspace(first, end, max(1, round((end - first) / 48)) + 1).astype(int)
        for top, bottom in pairwise(cuts):
            own = (rows >= top // 4 - 4) & (rows < bottom // 4 + 3)
            if own.any():
                left, right = 4 * columns[own].min(), 4 * (columns[own].max() + 2)
                expected.append(Region(left - margin, top, right + margin, bottom) & WHOLE)
    assert set(changed_bands(_light(levels), WHOLE, margin)) == set(expected)


@pytest.mark.parametrize(
    ("share", "level", "noise", "found"),
    [
        (0.78, 9.0, 0.0, "bands"),
        (0.82, 9.0, 0.0, "whole"),
        (0.2, 7.9, 0.0, "nothing"),
        (0.2, 9.9, 2.0, "nothing"),
        (0.2, 10.1, 2.0, "bands"),
    ],
)
def test_what_differs_more_than_noise_is_matched(share, level, noise, found):
    levels = np.where(np.arange(4800).reshape(60, 80) < 4800 * share, -level, 0.0)
    bands = changed_bands(_light(levels, noise), WHOLE, 8)
    assert ("nothing" if not bands else "whole" if bands == (WHOLE,) else "bands") == found
