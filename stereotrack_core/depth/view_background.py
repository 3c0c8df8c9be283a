"""What one view knows of the scene without anybody in it."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from stereotrack_core.arrays import BoolArray, Float32Array, ImageArray
from stereotrack_core.depth.background import (
    BackgroundModel,
    averaged,
    empty_scene_model,
    foreground,
    percentile_model,
)
from stereotrack_core.depth.outline import sharp_outline
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.region import Region, changed_region
from stereotrack_core.depth.sources import DepthSource, StereoSource

_REGION_MARGIN = 16  # px beyond the matcher's window


class ViewBackground:
    """Background model of one view, and the empty scene's picture where there is one.

    Parameters
    ----------
    source : StereoSource or DepthSource
    parameters : DepthParameters
    """

    def __init__(self, source: StereoSource | DepthSource, parameters: DepthParameters) -> None:
        self.model: BackgroundModel | None = None
        self.learns = parameters.background_mode == "average"
        self._p = parameters
        self._source = source
        self._picture: ImageArray | None = None
        self._limit: Float32Array | None = None
        shape = source.geometry.height, source.geometry.width
        self._outside = (np.full(shape, np.nan, dtype=np.float32),) * 2

    def take_empty_scene(self, picture: ImageArray | None, disparity: Float32Array) -> None:
        """The model from one image without anybody; it is never changed afterwards."""
        self._picture = picture
        self.learns = False
        self._set(empty_scene_model(disparity))

    def take_frames(
        self, pictures: Sequence[ImageArray], disparities: Sequence[Float32Array]
    ) -> None:
        """The model from a recording, by the mode in the parameters."""
        if self._p.background_mode == "percentile":
            self._set(percentile_model(disparities, self._p.background_percentile))
            if pictures:
                self._picture = _median_picture(pictures)
        elif self._p.background_mode == "average":
            whole = Region.whole(self._source.geometry.width, self._source.geometry.height)
            for disparity in disparities:
                self.learn(disparity, whole)

    def learn(self, disparity: Float32Array, region: Region) -> None:
        """One step of the running average; nothing is valid outside the region."""
        shape = self._source.geometry.height, self._source.geometry.width
        image = np.full(shape, np.nan, dtype=np.float32)
        image[region.slices] = disparity
        p = self._p
        self._set(averaged(self.model, image, p.background_rate, p.background_validity_rate))

    def take_over(self, other: ViewBackground) -> None:
        """Know what another one of the same view has learned."""
        self._picture, self.learns = other._picture, other.learns
        if other.model is not None:
            self._set(other.model)

    def _set(self, model: BackgroundModel) -> None:
        p = self._p
        self.model = model
        self._limit = model.limit(p.background_threshold, p.background_valid_above)
        if self._picture is not None:
            known = np.isfinite(self._limit)
            disparity = np.where(known, model.disparity, np.float32(np.nan))
            self._outside = disparity, self._source.ranges(disparity)

    def foreground(self, disparity: Float32Array, region: Region) -> BoolArray:
        """Equation (3.3) in a region; whatever is valid where there is no model."""
        if self._limit is None:
            valid: BoolArray = np.isfinite(disparity)
            return valid
        return foreground(disparity, self._limit[region.slices])

    def outside(self) -> tuple[Float32Array, Float32Array]:
        """Copies of disparity and range (H, W) to fill in where nothing was measured.

        What looks as it does in the empty scene is the empty scene.
        """
        disparity, ranges = self._outside
        return disparity.copy(), ranges.copy()

    @property
    def knows_picture(self) -> bool:
        """Whether there is a picture of the empty scene to compare with."""
        return self._picture is not None

    def changed_region(self, picture: ImageArray | None) -> Region:
        """The part of the image that has to be measured."""
        if self._p.match_region == "whole" or picture is None or self._picture is None:
            return Region.whole(self._source.geometry.width, self._source.geometry.height)
        margin = _REGION_MARGIN + self._p.match_window // 2
        return changed_region(picture, self._picture, margin)

    def changed(self, picture: ImageArray, region: Region) -> BoolArray:
        """Where the picture differs from the empty scene; true everywhere without one.

        Gaps inside, where the person happens to look like the wall, are closed over the
        width of the matcher's window.
        """
        now = picture[region.slices]
        if self._picture is None:
            return np.ones(now.shape, dtype=bool)
        before = self._picture[region.slices]
        difference = cv2.absdiff(
            cv2.GaussianBlur(now, (5, 5), 0), cv2.GaussianBlur(before, (5, 5), 0)
        )
        differs = (difference > self._p.halo_contrast).astype(np.uint8)
        size = (self._p.match_window // 2) | 1
        kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
        closed = cv2.morphologyEx(differs, cv2.MORPH_CLOSE, kernel)
        result: BoolArray = closed.astype(bool)
        return result

    def outline(
        self, picture: ImageArray, foreground: BoolArray, region: Region
    ) -> BoolArray | None:
        """The person's sharp outline in a region; None without a picture of the empty scene."""
        if self._picture is None:
            return None
        return sharp_outline(picture[region.slices], self._picture[region.slices], foreground)


def _median_picture(pictures: Sequence[ImageArray]) -> ImageArray:
    stack = np.stack(pictures, axis=-1)
    stack.sort(axis=-1)
    median: ImageArray = np.ascontiguousarray(stack[..., len(pictures) // 2])
    return median
