"""A wide range of disparities, searched coarse to fine so that it does not cost in proportion.

Images of half or a quarter of the size tell for each tile of the image which disparities there are,
and these alone are searched in full, as in hierarchical stereo since L. H. Quam (1984).
"""

from collections.abc import Iterator
from itertools import pairwise

import cv2
import numpy as np

from stereotrack_core.arrays import ImageArray
from stereotrack_core.depth.match import STEPS, DisparityArray, DisparityRange, Matcher, Region
from stereotrack_core.depth.parameters import DepthParameters

WIDE = 192  # disparities from which it pays; fewer are searched at once
_VERY_WIDE = 256  # disparities from which images of a quarter of the size are used, and not of half
_TILE = 128, 96  # columns and rows
_AROUND = 12  # pixels around a tile whose disparities are searched in it as well
_MARGIN = 3  # disparities searched beyond those that were found
_WINDOW, _UNIQUENESS = 7, 5  # window and uniqueness for the reduced images
_SPECKLES, _ALIKE = 20, STEPS  # pixels of a patch that is no surface, and its largest step


class CoarseToFine:
    """Searches as :class:`Matcher` does; not to be used by two threads at once."""

    def __init__(self, parameters: DepthParameters, disparities: DisparityRange) -> None:
        self.disparities = disparities
        self._p = parameters
        self._shrink = s = 4 if disparities.count >= _VERY_WIDE else 2
        reduced = parameters.replaced(match_window=_WINDOW, match_uniqueness=_UNIQUENESS)
        count = _in_sixteens(disparities.count // s + 2)
        self._coarse = Matcher(reduced, DisparityRange(disparities.minimum // s, count))
        self.bias = self._coarse.bias

    def __call__(
        self, left: ImageArray, right: ImageArray, region: Region | None = None
    ) -> DisparityArray:
        """Disparities of a region; see :meth:`Matcher.__call__`."""
        height, width = right.shape
        region = region or Region.whole(width, height)
        known, part = self._coarsely(left, right, region)
        result = np.empty((region.bottom - region.top, region.right - region.left), dtype=np.int16)
        for tile in _tiles(region):
            near = _reduced(tile.grown(_AROUND), self._shrink) & part
            searched = self._range_of(known[near.slices_in(part)])
            found = Matcher(self._p, searched)(left, right, tile)
            found[found <= searched.invalid] = self.disparities.invalid
            result[tile.slices_in(region)] = found
        return result

    def _coarsely(
        self, left: ImageArray, right: ImageArray, region: Region
    ) -> tuple[DisparityArray, Region]:
        """Disparities around a region in the reduced images, and where in these."""
        s = self._shrink
        width, height = right.shape[1] // s, right.shape[0] // s
        size, cut = (width, height), np.s_[: s * height, : s * width]
        left, right = (
            cv2.resize(image[cut], size, interpolation=cv2.INTER_AREA).astype(np.uint8, copy=False)
            for image in (left, right)
        )
        part = _reduced(region.grown(2 * _AROUND), s) & Region.whole(width, height)
        found = self._coarse(left, right, part)
        cv2.filterSpeckles(found, self._coarse.disparities.invalid, _SPECKLES, _ALIKE)
        return found, part

    def _range_of(self, coarse: DisparityArray) -> DisparityRange:
        """What is to be searched where reduced images show this; everything if nothing is known."""
        here, widest = coarse[coarse > self._coarse.disparities.invalid], self.disparities
        if not here.size:
            return widest
        scale = self._shrink / STEPS
        lowest = max(int(np.floor(here.min() * scale)) - _MARGIN, widest.minimum)
        count = _in_sixteens(int(np.ceil(here.max() * scale)) + _MARGIN + 1 - lowest)
        if lowest + count > widest.minimum + widest.count:
            lowest = max(widest.minimum + widest.count - count, widest.minimum)
        return DisparityRange(lowest, count) if count < widest.count else widest


def _tiles(region: Region) -> Iterator[Region]:
    """The tiles of the whole image, as far as they are in the region."""
    columns = _cuts(region.left, region.right, _TILE[0])
    rows = _cuts(region.top, region.bottom, _TILE[1])
    for top, bottom in pairwise(rows):
        for left, right in pairwise(columns):
            yield Region(left, top, right, bottom)


def _cuts(first: int, end: int, side: int) -> list[int]:
    """Borders of tiles; what would be a narrow strip belongs to the tile beside it."""
    within = range(first // side * side, end, side)
    narrow = side // 2
    return [first, *(cut for cut in within if first + narrow <= cut <= end - narrow), end]


def _reduced(region: Region, shrink: int) -> Region:
    """The region in images reduced by a whole number."""
    s = shrink
    return Region(region.left // s, region.top // s, -(-region.right // s), -(-region.bottom // s))


def _in_sixteens(count: int) -> int:
    return max(-(-count // 16) * 16, 16)


def matcher_of(parameters: DepthParameters, disparities: DisparityRange) -> Matcher | CoarseToFine:
    """What searches a range of disparities as the parameters say."""
    if parameters.match_wide == "coarse_to_fine" and disparities.count >= WIDE:
        return CoarseToFine(parameters, disparities)
    return Matcher(parameters, disparities)
