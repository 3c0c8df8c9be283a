"""Stereo matching with the right image as reference (2.1.2, 2.1.4), where it has to be done."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from stereotrack_core.arrays import BoolArray, FloatArray, ImageArray
from stereotrack_core.depth.cloud import DepthGeometry
from stereotrack_core.depth.light import SHRINK, Light
from stereotrack_core.depth.parameters import DepthParameters

_NOISES = 5.0  # standard deviations of the measured noise
_CHANGE = 8.0  # grey levels, over 4 x 4 pixels; sensor noise leaves about one
_LARGEST_SHARE = 0.8
_SPECK = 2  # pixels of the shrunken picture; a patch of no more is noise, and far from others
_BAND = 48  # rows; in fewer, the rows that windows reach beyond a band cost more than is saved


@dataclass(frozen=True)
class Region:
    """Columns ``left`` to ``right`` and rows ``top`` to ``bottom``, half-open."""

    left: int
    top: int
    right: int
    bottom: int

    @staticmethod
    def whole(width: int, height: int) -> Region:
        """A whole image."""
        return Region(0, 0, width, height)

    @property
    def slices(self) -> tuple[slice, slice]:
        """Index of the region in an image."""
        return slice(self.top, self.bottom), slice(self.left, self.right)

    def slices_in(self, part: Region) -> tuple[slice, slice]:
        """Index of the region in a part that was cut out of an image."""
        left, top = part.left, part.top
        return slice(self.top - top, self.bottom - top), slice(self.left - left, self.right - left)

    @property
    def is_empty(self) -> bool:
        """Whether there is no pixel inside."""
        return self.left >= self.right or self.top >= self.bottom

    def grown(self, margin: int) -> Region:
        """The region with a margin on all sides; may reach beyond the image."""
        return Region(
            self.left - margin, self.top - margin, self.right + margin, self.bottom + margin
        )

    def __or__(self, other: Region) -> Region:
        return Region(
            min(self.left, other.left),
            min(self.top, other.top),
            max(self.right, other.right),
            max(self.bottom, other.bottom),
        )

    def __and__(self, other: Region) -> Region:
        return Region(
            max(self.left, other.left),
            max(self.top, other.top),
            min(self.right, other.right),
            min(self.bottom, other.bottom),
        )


def region_of_points(geometry: DepthGeometry, corners_world: FloatArray) -> Region:
    """Where a convex body with these corners can appear; the whole image if it is too near."""
    whole = Region.whole(geometry.width, geometry.height)
    with np.errstate(divide="ignore", invalid="ignore"):
        u, v, z = geometry.project(corners_world)
    if z.min() < 0.1:
        return whole
    seen = Region(
        int(np.floor(u.min())), int(np.floor(v.min())), int(u.max()) + 2, int(v.max()) + 2
    )
    return seen & whole


def changed_bands(light: Light, whole: Region, margin: int) -> tuple[Region, ...]:
    """Bands of rows, `margin` pixels wider, around all that differs from the empty scene.

    Patches farther than two margins apart have bands of their own, which may overlap and are
    narrower than the box around a patch. The whole image if nearly everything differs, which proves
    nothing.
    """
    changed = np.abs(light.small - light.empty_small) > max(_CHANGE, _NOISES * light.noise)
    if changed.mean() > _LARGEST_SHARE:
        return (whole,)
    around = -(-margin // SHRINK)
    near = cv2.dilate(changed.view(np.uint8), np.ones((2 * around + 1,) * 2, np.uint8))
    count, patches = cv2.connectedComponents(near)
    bands: list[Region] = []
    for number in range(1, count):
        patch = changed & (patches == number)
        if np.count_nonzero(patch) > _SPECK:
            bands += _bands_of(patch, margin)
    return within(bands, whole)


def within(regions: Iterable[Region], whole: Region) -> tuple[Region, ...]:
    """The parts of regions in another, without empty ones."""
    inside = (region & whole for region in regions)
    return tuple(region for region in inside if not region.is_empty)


def _bands_of(patch: BoolArray, margin: int) -> Iterator[Region]:
    """Bands one below the other that cover a patch (h, w) of the shrunken picture."""
    rows, around = np.flatnonzero(patch.any(axis=1)), -(-margin // SHRINK)
    first, end = int(rows[0]) * SHRINK - margin, (int(rows[-1]) + 2) * SHRINK + margin
    cuts = np.linspace(first, end, max(1, round((end - first) / _BAND)) + 1).astype(int).tolist()
    for top, bottom in pairwise(cuts):
        near = patch[max(top // SHRINK - around - 1, 0) : max(bottom // SHRINK + around, 0)]
        columns = np.flatnonzero(near.any(axis=0))
        if len(columns):
            left, right = int(columns[0]) * SHRINK, (int(columns[-1]) + 2) * SHRINK
            yield Region(left - margin, top, right + margin, bottom)


DisparityArray: TypeAlias = NDArray[np.int16]

STEPS = 16  # disparities are whole numbers of sixteenths of a pixel until they become points
_PREFILTER_CAP = 31
_TEXTURE = 10  # least sum over the prefiltered pixels of a window; less is noise

# StereoBM takes its parabola's vertex in 1/256 px and adds 15 before it drops the last four
# bits: it rounds up. 7.5/256 px is what that adds on average, 8 mm at 3.6 m.
_BLOCK_MATCHER_ROUNDS_UP = 7.5 / 256


@dataclass(frozen=True)
class DisparityRange:
    """Disparities d with ``minimum`` <= d < ``minimum + count``, in pixels of the pair."""

    minimum: int
    count: int

    @property
    def invalid(self) -> int:
        """What the matcher writes where it found nothing, in sixteenths."""
        return (self.minimum - 1) * STEPS


class Matcher:
    """StereoBM or StereoSGBM, for one thread; disparities are `bias` pixels too large."""

    def __init__(self, parameters: DepthParameters, disparities: DisparityRange) -> None:
        self.disparities = disparities
        self.bias = _BLOCK_MATCHER_ROUNDS_UP if parameters.matcher == "bm" else 0.0
        self._half_window = parameters.match_window // 2
        self._edges_first = parameters.edge_images and parameters.matcher == "sgbm"
        make = _block_matcher if parameters.matcher == "bm" else _semi_global_matcher
        self._matcher = make(parameters, disparities)

    def __call__(
        self, left: ImageArray, right: ImageArray, region: Region | None = None
    ) -> DisparityArray:
        """Disparities (h, w), sixteenths of a pixel, of a region of the right image (H, W) or all
        of it.

        Left shows at column u + d what right shows at u. OpenCV refers to the left image: seen in a
        mirror, the right image is a left one. ``disparities.invalid`` where there is none.
        """
        height, width = right.shape
        region = region or Region.whole(width, height)
        crop = self._needed(region, width, height)
        left, right = _cut(left, crop), _cut(right, crop)
        if self._edges_first:
            left, right = edge_image(left), edge_image(right)
        mirrored = self._matcher.compute(cv2.flip(right, 1), cv2.flip(left, 1))
        found = np.asarray(cv2.flip(mirrored, 1), dtype=np.int16)
        disparity = np.ascontiguousarray(found[region.slices_in(crop)])
        # Windows that would reach beyond the left image's border show nothing.
        reach = self.disparities.minimum + self.disparities.count + self._half_window
        first = min(max(width - max(reach, 0), region.left), region.right)
        room = (width - 1 - self._half_window - np.arange(first, region.right)) * STEPS
        border = disparity[:, first - region.left :]
        border[border > room.astype(np.int16)] = self.disparities.invalid
        return disparity

    def _needed(self, region: Region, width: int, height: int) -> Region:
        """What the matcher has to see of both images; beyond the right border if need be.

        OpenCV leaves out pixels from which the largest disparity would lead out of the image, so
        that these columns have to be there even where they show nothing.
        """
        reach = self.disparities.minimum + self.disparities.count
        grown = region.grown(self._half_window + 1)
        wide = Region(
            min(grown.left, grown.left + self.disparities.minimum),
            grown.top,
            grown.right + max(reach, 0),
            grown.bottom,
        )
        there = wide & Region(0, 0, width + self._half_window + 1 + max(reach, 0), height)
        # OpenCV filters rows in pairs: those of the part have to be those of the whole image.
        alone = (there.bottom - there.top - height) % 2 == 1 and there.top > 0
        return Region(there.left, there.top - 1, there.right, there.bottom) if alone else there


def _cut(image: ImageArray, crop: Region) -> ImageArray:
    beyond = crop.right - image.shape[1]
    part = image[crop.slices]
    if beyond <= 0:
        return part
    padded = cv2.copyMakeBorder(part, 0, 0, 0, beyond, cv2.BORDER_REPLICATE)
    return padded.astype(np.uint8, copy=False)


def edge_image(image: ImageArray) -> ImageArray:
    """Horizontal derivative around grey 128, which does not depend on the image's brightness."""
    return cv2.Sobel(image, cv2.CV_8U, 1, 0, ksize=3, scale=0.5, delta=128).astype(
        np.uint8, copy=False
    )


def _block_matcher(p: DepthParameters, disparities: DisparityRange) -> cv2.StereoBM:
    matcher = cv2.StereoBM.create(disparities.count, p.match_window | 1)
    matcher.setMinDisparity(disparities.minimum)
    # XSOBEL is 1, NORMALIZED_RESPONSE 0; their names differ between versions of OpenCV.
    matcher.setPreFilterType(1 if p.edge_images else 0)
    matcher.setPreFilterCap(_PREFILTER_CAP)
    matcher.setTextureThreshold(_TEXTURE)
    matcher.setUniquenessRatio(p.match_uniqueness)
    matcher.setDisp12MaxDiff(p.match_left_right)
    return matcher


def _semi_global_matcher(p: DepthParameters, disparities: DisparityRange) -> cv2.StereoSGBM:
    # Large windows blur what the smoothness term keeps sharp: half of the block matcher's.
    window = p.match_window // 2 | 1
    return cv2.StereoSGBM.create(
        minDisparity=disparities.minimum,
        numDisparities=disparities.count,
        blockSize=window,
        P1=8 * window * window,
        P2=32 * window * window,
        disp12MaxDiff=p.match_left_right,
        preFilterCap=_PREFILTER_CAP,
        uniquenessRatio=p.match_uniqueness,
        mode=cv2.StereoSGBM_MODE_SGBM_3WAY,
    )
