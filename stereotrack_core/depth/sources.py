"""Where a view's disparities come from: a stereo pair, or a measured depth image."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import TypeAlias

import cv2
import numpy as np

from stereotrack_core.arrays import BoolArray, Float32Array, ImageArray, IntArray
from stereotrack_core.depth.cloud import DepthGeometry
from stereotrack_core.depth.coarse import CoarseToFine, matcher_of
from stereotrack_core.depth.light import sensor_noise, shift_of
from stereotrack_core.depth.match import STEPS, DisparityRange, Matcher, Region
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.points import Volume, range_of_disparity
from stereotrack_core.depth.rectify import Rectification
from stereotrack_core.depth.subpixel import refined_disparity
from stereotrack_core.recording.reader import ViewImages

_DARK_BELOW = 16  # of 255
_BRIGHT = 0.01  # share of an image that reaches it unless it is dark
# Grey levels of noise from which a pair is filtered before matching: below, fine texture is worth
# more. With 5 levels block matching finds half of the person's points, with 12 a tenth; filtered,
# nearly all.
_NOISY = 3.0
# Standard deviation, pixels, for noisy pairs. With 1.5 and noise of 12 levels arms were off by 13
# and 12 degrees, with 1 by 7 and 7 (mesh-P4).
NOISE_FILTER = 1.0
NEAREST_RANGE = 0.3  # metres; nothing nearer is looked for even where the volume allows it
_NOMINAL_BASELINE = 0.12  # metres; makes inverse depth comparable with a stereo disparity


class NoDepth(Exception):
    """A view gives no depth at this instant; the message is a clause that says why."""


@dataclass(frozen=True, eq=False)
class StereoFrame:
    """A rectified pair; `picture` is its right image."""

    left: ImageArray
    picture: ImageArray
    outside: BoolArray | None
    matcher: Matcher | CoarseToFine
    window: int
    noise: float  # Grey levels. Standard deviation of the noise, where it was measured.

    @property
    def noisy(self) -> bool:
        """Whether both pictures were filtered (:func:`low_passed`) because of their noise."""
        return self.noise > _NOISY

    def disparity(self, region: Region) -> Float32Array:
        """Disparity (h, w) of a region, pixels, NaN where there is none."""
        steps = self.matcher(self.left, self.picture, region)
        disparity = steps.astype(np.float32)
        disparity *= np.float32(1 / STEPS)
        disparity -= np.float32(self.matcher.bias)
        disparity[steps <= self.matcher.disparities.invalid] = np.nan
        if self.outside is not None:
            disparity[self.outside[region.slices]] = np.nan
        return disparity

    def left_at(self, disparity: Float32Array, region: Region) -> ImageArray:
        """What the left picture (h, w) shows at disparities (h, w) of a region."""
        rows, columns = np.mgrid[region.slices].astype(np.float32)
        border = cv2.BORDER_REPLICATE
        there = cv2.remap(self.left, columns + disparity, rows, cv2.INTER_LINEAR, borderMode=border)
        return there.astype(np.uint8, copy=False)

    def align(
        self, disparity: Float32Array, person: BoolArray, pixels: IntArray, region: Region
    ) -> None:
        """Refine a region's disparities at some pixels, in place; see :func:`refined_disparity`."""
        whole = np.zeros(self.picture.shape, dtype=bool)
        whole[region.slices] = person
        place = pixels[:, 1] - region.top, pixels[:, 0] - region.left
        found = disparity[place].astype(np.float64)
        disparity[place] = refined_disparity(
            self.left, self.picture, whole, pixels, found, self.window
        )


@dataclass(frozen=True, eq=False)
class DepthFrame:
    """A measured depth image as inverse depth, in pixels of a nominal base line."""

    inverse: Float32Array
    picture: ImageArray | None = None

    def disparity(self, region: Region) -> Float32Array:
        """Inverse depth (h, w) of a region, NaN where there is none."""
        return self.inverse[region.slices].copy()


OpenedFrame: TypeAlias = StereoFrame | DepthFrame  # one view at one instant, ready to be measured


class StereoSource:
    """Rectifies and matches a stereo pair."""

    def __init__(self, rectification: Rectification, parameters: DepthParameters) -> None:
        self.geometry = rectification.geometry
        self.rectification = rectification
        self._low_pass = parameters.low_pass
        self._by_noise = parameters.low_pass == 0.0
        self._window = parameters.match_window | 1
        self.disparity_range = disparity_range(self.geometry, parameters)
        self._matcher = matcher_of(parameters, self.disparity_range)
        self._outside: BoolArray | None = None
        if rectification.image_map is not None:
            # Windows that reach where the raw right image shows nothing; bilinear resampling and
            # the derivative reach one pixel farther each.
            side = parameters.match_window + 4
            outside = rectification.image_map.outside.astype(np.uint8)
            reached = cv2.dilate(outside, np.ones((side, side), dtype=np.uint8))
            self._outside = reached.astype(bool)
        self.rows = 0.0
        """Pixels by which left images lie too low, and are moved up."""

    def align_rows(self, images: Sequence[ViewImages]) -> None:
        """Measure :attr:`rows` on some pairs."""
        offsets = []
        for one in images:
            with suppress(NoDepth):
                offsets.append(row_offset(partial(self.opened, one)))
        self.rows = float(np.median(offsets)) if offsets else 0.0

    def open(self, images: ViewImages) -> StereoFrame:
        """Low-pass and rectify; raises :class:`NoDepth` for a dark or missing image."""
        return self.opened(images, self.rows)

    def opened(self, images: ViewImages, rows: float) -> StereoFrame:
        """Open images whose left one lies too low by so many rows."""
        if images.left is None:
            raise NoDepth("its left image is missing")
        left, right = grey(images.left), grey(images.image)
        refuse_dark(left, "left image")
        refuse_dark(right, "right image")
        noise = sensor_noise(right) if self._by_noise else 0.0
        low_pass = NOISE_FILTER if noise > _NOISY else self._low_pass  # 2.1.3
        if low_pass > 0:
            left, right = low_passed(left, low_pass), low_passed(right, low_pass)
        if (left_map := self.rectification.left_map) is not None:
            left = left_map.apply(left)
        if rows:
            left = moved_up(left, rows)
        right = self.rectification.rectified(right)
        return StereoFrame(left, right, self._outside, self._matcher, self._window, noise)

    def ranges(self, disparity: Float32Array) -> Float32Array:
        """Range z = f b / (d - offset), metres."""
        return range_of_disparity(self.geometry, disparity)

    def disparity_of(self, ranges: Float32Array) -> Float32Array:
        """Disparity, pixels, of ranges z, metres."""
        return self.geometry.disparity_at(ranges)


class DepthSource:
    """Takes a measured depth image; stands in the chain where matching does for a pair."""

    def __init__(self, rectification: Rectification) -> None:
        self.geometry = rectification.geometry
        self.rectification = rectification
        self._map = rectification.image_map
        self._scale = np.float32(self.geometry.focal * _NOMINAL_BASELINE)

    def open(self, images: ViewImages) -> DepthFrame:
        """Resample if the lens distorts, and invert; raises :class:`NoDepth` without an image."""
        if images.depth is None:
            raise NoDepth("its depth image is missing")
        depth = images.depth if self._map is None else self._map.apply_nearest(images.depth)
        with np.errstate(divide="ignore"):
            inverse = self._scale / depth
        inverse[~(depth > 0)] = np.nan
        return DepthFrame(inverse)

    def ranges(self, disparity: Float32Array) -> Float32Array:
        """Range z, metres, of inverse depth."""
        return self._scale / disparity

    def disparity_of(self, ranges: Float32Array) -> Float32Array:
        """Inverse depth, pixels of the nominal base line, of ranges z, metres."""
        return self._scale / ranges

    def person_mask(self, images: ViewImages) -> BoolArray | None:
        """Rectified mask (H, W) of the person, or None."""
        if images.mask is None or self._map is None:
            return images.mask
        return self._map.apply_nearest(images.mask.astype(np.float32)) > 0.5


def disparity_range(geometry: DepthGeometry, p: DepthParameters) -> DisparityRange:
    """Disparities to look for, in pixels of the rectified pair.

    The parameters state parallaxes; a pair with different principal points shows them shifted by
    ``disparity_offset``. The volume never cuts the far end: a wall whose own disparity is left out
    would be matched with a wrong, nearer one.
    """
    lowest = float(p.disparity_minimum)
    highest = lowest + p.disparity_count - 1
    if p.disparity_from_volume:
        corners = geometry.world_from_depth.inverse().apply(Volume.of(p).corners())
        nearest = max(float(corners[:, 2].min()), NEAREST_RANGE)
        highest = min(highest, geometry.focal * geometry.baseline / nearest + 1.0)
    minimum = int(np.floor(lowest + geometry.disparity_offset))
    maximum = int(np.ceil(highest + geometry.disparity_offset))
    count = max(maximum - minimum + 1, 1)
    most = max((geometry.width - abs(minimum) - 1) // 16 * 16 - 16, 16)
    return DisparityRange(minimum, min(-(-count // 16) * 16, most))


def moved_up(image: ImageArray, rows: float) -> ImageArray:
    """The image moved up by a part of a pixel or some."""
    up, size = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, -rows]]), image.shape[1::-1]
    moved = cv2.warpAffine(image, up, size, flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
    return moved.astype(np.uint8, copy=False)


def low_passed(image: ImageArray, sigma: float) -> ImageArray:
    """The image after a Gaussian filter with this standard deviation, pixels."""
    return cv2.GaussianBlur(image, (0, 0), sigma).astype(np.uint8, copy=False)


def grey(image: ImageArray) -> ImageArray:
    """Grey image (H, W) of a grey or BGR one."""
    if image.ndim == 2:
        return image
    return cv2.cvtColor(image, cv2.COLOR_BGR2GRAY).astype(np.uint8, copy=False)


def refuse_dark(image: ImageArray, name: str) -> None:
    """Raise :class:`NoDepth` for an image in which nothing can be seen."""
    few = image[4::8, 4::8]
    if np.count_nonzero(few >= _DARK_BELOW) < _BRIGHT * few.size:
        raise NoDepth(f"the {name} is dark")


_STEPS = 3  # steps of least squares; each finds two thirds of what is left
# Rows that are worth a resampling (sound pairs have up to 0.02), and beyond which blocks are no
# longer matched.
_LEAST, _MOST = 0.2, 2.5
_FEW = 0.2  # share of the image that has to be matched
_AROUND = (31, 31)  # neighbourhood, pixels, over which both pictures are brought to one brightness


def row_offset(opened: Callable[[float], StereoFrame]) -> float:
    """Pixels, in tenths, that left images lie too low; `opened`: the pair with them moved up."""
    offset = 0.0
    for _ in range(_STEPS):
        frame = opened(offset)
        height, width = frame.picture.shape
        disparity = frame.disparity(Region.whole(width, height))
        matched = np.isfinite(disparity)
        if np.mean(matched) < _FEW:
            return 0.0
        there = frame.left_at(np.where(matched, disparity, 0), Region.whole(width, height))
        a, b = (cv2.blur(one.astype(np.float32), _AROUND) for one in (frame.picture, there))
        even = np.asarray(np.clip(there * ((a + 1) / (b + 1)), 0, 255), dtype=np.uint8)
        step = shift_of(even, frame.picture, matched)[1]
        offset += step
        if abs(step) < _LEAST / 4:
            break
    return round(offset, 1) if _LEAST < abs(offset) < _MOST else 0.0
