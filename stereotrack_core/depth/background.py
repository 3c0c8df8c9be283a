"""The background of one view, learned on disparities, and what stands in front of it (3.1.1)."""

from __future__ import annotations

import functools
import operator
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from stereotrack_core.arrays import BoolArray, Float32Array, ImageArray
from stereotrack_core.depth.light import EmptyScene, Light, empty_scene, light_of, relit
from stereotrack_core.depth.match import Region, changed_bands
from stereotrack_core.depth.outline import (
    Compared,
    beside,
    difference_of,
    new_pixels,
    same_structure,
    seen_at,
)
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.points import Volume
from stereotrack_core.depth.sources import (
    NOISE_FILTER,
    DepthSource,
    OpenedFrame,
    StereoFrame,
    StereoSource,
    low_passed,
)
from stereotrack_core.depth.standing import moves, standing_person, still_person

_VALID_ABOVE = 0.5  # how often a disparity must be valid for a known background


@dataclass(frozen=True, eq=False)
class BackgroundModel:
    """What a pixel shows when nobody is there."""

    disparity: Float32Array  # (H, W), pixels. d_M; meaningless where `frequency` is low
    frequency: Float32Array  # (H, W). g_M: how often the disparity was valid, 0 to 1

    def limit(self, threshold: float) -> Float32Array:
        """Disparity (H, W) above which d is foreground: d_M + s, -inf where unknown (3.3)."""
        known = self.frequency > _VALID_ABOVE
        limit: Float32Array = np.where(known, self.disparity + np.float32(threshold), -np.inf)
        return limit.astype(np.float32, copy=False)


def empty_scene_model(disparity: Float32Array) -> BackgroundModel:
    """Model from one image of the empty scene, NaN where it has no disparity."""
    valid = np.isfinite(disparity)
    return BackgroundModel(np.where(valid, disparity, np.float32(0)), valid.astype(np.float32))


def averaged(
    model: BackgroundModel | None, disparity: Float32Array, rate: float, validity_rate: float
) -> BackgroundModel:
    """One step of the exponential averages of 3.1.1; `model` is None before the first image.

    d_M = (1 - alpha_d) d_M + alpha_d d where d (H, W), pixels, is valid; g_M = (1 - alpha_g) g_M +
    alpha_g g with g = 1 where d is valid, else 0. A pixel's first disparity is taken as it is. The
    rates are alpha_d and alpha_g.
    """
    if model is None:
        return empty_scene_model(disparity)
    valid = np.isfinite(disparity)
    never_seen = model.frequency == 0
    step = np.where(never_seen, np.float32(1), np.float32(rate))
    change = np.where(valid, step * (disparity - model.disparity), np.float32(0))
    frequency = model.frequency + np.float32(validity_rate) * (valid - model.frequency)
    return BackgroundModel(model.disparity + change, frequency.astype(np.float32))


def percentile_model(disparities: Sequence[Float32Array], percentile: float) -> BackgroundModel:
    """Nearest rank below a percentile, 0 to 100, of each pixel's valid disparities (H, W)."""
    model = np.zeros(disparities[0].shape, np.float32), np.empty(disparities[0].shape, np.float32)
    for rows, stack in _sorted_rows(disparities):  # NaN comes last
        count = np.isfinite(stack).sum(axis=-1)
        rank = np.floor((percentile / 100.0) * np.maximum(count - 1, 0)).astype(np.int64)
        chosen = np.take_along_axis(stack, rank[..., None], axis=-1)[..., 0]
        model[0][rows] = np.where(count > 0, chosen, np.float32(0))
        model[1][rows] = count / len(disparities)
    return BackgroundModel(*model)


_ROWS = 32  # of an image, sorted at once: a stack of large images takes gigabytes


def _sorted_rows(images: Sequence[NDArray[Any]]) -> Iterator[tuple[slice, NDArray[Any]]]:
    """Values of each pixel in all images (H, W), sorted, row block by row block (h, W, N)."""
    for first in range(0, len(images[0]), _ROWS):
        rows = slice(first, first + _ROWS)
        # Sorting is much quicker along the last axis.
        yield rows, np.sort(np.stack([image[rows] for image in images], axis=-1), axis=-1)


# Share of the image from which changed pixels at the empty scene's disparity may be a shadow; fewer
# are feet on the floor or a limb that the matcher missed.
_SHADOW = 0.002
_EDGES = np.ones((7, 7), np.uint8)  # edges of shadows that are filled
_BEHIND = 0.5  # metres behind somebody who stood still from which the scene begins
_REGION_MARGIN = 16  # px beyond the matcher's window


LearnedFrame: TypeAlias = tuple[Float32Array, ImageArray | None]  # disparity (H, W), grey picture


class ViewBackground:
    """Background of one view; `motionless`: nothing moved in the frames that it is learned from."""

    def __init__(self, source: StereoSource | DepthSource, parameters: DepthParameters) -> None:
        self.model: BackgroundModel | None = None
        self.learns = parameters.background_mode == "average"
        self._p = parameters
        self._source = source
        self._scene: EmptyScene | None = None
        self._filtered: ImageArray | None = None
        self._limit: Float32Array | None = None
        self.motionless = False
        shape = source.geometry.height, source.geometry.width
        # Disparity and range (H, W) of the empty scene, which is shown where nothing differs
        self.outside = (np.full(shape, np.nan, dtype=np.float32),) * 2

    def take_empty_scene(self, picture: ImageArray | None, disparity: Float32Array) -> None:
        """The model from one image without anybody; it is never changed afterwards."""
        self._scene = None if picture is None else empty_scene(picture)
        if picture is not None:
            self._filtered = low_passed(picture, NOISE_FILTER)
        self.learns = False
        self._set(empty_scene_model(disparity))

    def take_frames(self, frames: Sequence[LearnedFrame]) -> None:
        """The model from frames of a recording in which somebody moves, if there are any."""
        if not frames:
            return
        disparities = [disparity for disparity, _ in frames]
        pictures = [picture for _, picture in frames if picture is not None]
        self._set(percentile_model(disparities, self._p.background_percentile))
        if self._forget_standing(disparities):
            return  # the pictures show the person too
        if pictures:
            middle = len(pictures) // 2
            rows = [stack[..., middle] for _, stack in _sorted_rows(pictures)]
            self._scene = empty_scene(np.concatenate(rows))

    def _forget_standing(self, disparities: Sequence[Float32Array]) -> bool:
        """Take a person who stood still out of the model; whether there was one."""
        if self._limit is None:
            return False
        learned, source, limit = self._learned_ranges(), self._source, self._limit
        volume, frames = Volume.of(self._p), [(d, d > limit) for d in disparities]
        in_front = [front for _, front in frames]

        def ranges(where: BoolArray) -> Iterator[Float32Array]:
            for disparity, front in frames:
                shown = source.ranges(disparity[where])
                yield np.where(front[where], shown, np.float32(np.nan))

        self.motionless = not moves(source.geometry, volume, in_front, ranges)
        standing = standing_person(source.geometry, volume, learned, in_front, ranges)
        return self._forget(standing, learned)

    def forget_still(self) -> None:
        """Take a person out of the model who has not moved at all, if there is one."""
        if self._limit is None:
            return
        learned, volume = self._learned_ranges(), Volume.of(self._p)
        up = self._p.upright.up
        if self._forget(still_person(self._source.geometry, volume, learned, up), learned):
            self._scene = None  # it shows the person too

    def _learned_ranges(self) -> Float32Array:
        """Ranges (H, W) of the model, metres, NaN where it does not know any."""
        assert self.model is not None  # noqa: S101 - the callers have asked
        known = np.isfinite(self.model.limit(self._p.background_threshold))
        return self._source.ranges(np.where(known, self.model.disparity, np.float32(np.nan)))

    def _forget(self, person: BoolArray, learned: Float32Array) -> bool:
        """Begin the scene half a metre behind a person's pixels; whether there are any."""
        if self.model is None or not person.any():
            return False
        behind = self._source.disparity_of(learned + np.float32(_BEHIND))
        disparity = np.where(person, behind, self.model.disparity)
        self._set(BackgroundModel(disparity.astype(np.float32), self.model.frequency))
        return True

    def learn(self, disparity: Float32Array, region: Region) -> None:
        """One step of the running average; nothing is valid outside the region."""
        shape = self._source.geometry.height, self._source.geometry.width
        image = np.full(shape, np.nan, dtype=np.float32)
        image[region.slices] = disparity
        p = self._p
        self._set(averaged(self.model, image, p.background_rate, p.background_validity_rate))

    def take_over(self, other: ViewBackground) -> None:
        """Know what another one of the same view has learned."""
        self._scene, self._filtered, self.learns = other._scene, other._filtered, other.learns
        if other.model is not None:
            self._set(other.model)

    def _set(self, model: BackgroundModel) -> None:
        p = self._p
        self.model = model
        self._limit = model.limit(p.background_threshold)
        if self._scene is not None:
            known = np.isfinite(self._limit)
            disparity = np.where(known, model.disparity, np.float32(np.nan))
            self.outside = disparity, self._source.ranges(disparity)

    def foreground(self, disparity: Float32Array, region: Region) -> BoolArray:
        """Equation (3.3) in a region; whatever is valid where there is no model."""
        if self._limit is None:
            return np.isfinite(disparity)
        return disparity > self._limit[region.slices]

    def light(self, picture: ImageArray | None) -> Light | None:
        """Light of a picture against the empty scene's; None where one of them is missing."""
        if picture is None or self._scene is None:
            return None
        return light_of(picture, self._scene)

    def changed_bands(self, light: Light | None) -> tuple[Region, ...]:
        """Parts of the image that have to be measured; one if the matcher needs them all."""
        whole = Region.whole(self._source.geometry.width, self._source.geometry.height)
        if self._p.match_region == "whole" or light is None:
            return (whole,)
        margin = _REGION_MARGIN + self._p.match_window // 2
        bands = changed_bands(light, whole, margin)
        if not bands and self._filtered is None:
            return (whole,)  # pictures of frames may show somebody who stands still
        several = len(bands) > 1 and self._p.matcher != "bm"
        return (functools.reduce(operator.or_, bands),) if several else bands

    def compared(
        self, frame: OpenedFrame, light: Light | None, disparity: Float32Array, region: Region
    ) -> Compared | None:
        """Compare a region of the picture with the empty scene in its light, if that is known."""
        if light is None or self._scene is None or frame.picture is None:
            return None
        beside_person, scene = beside(self.foreground(disparity, region)), self._scene
        if isinstance(frame, StereoFrame) and frame.noisy and self._filtered is not None:
            scene = replace(scene, picture=self._filtered)
        empty = relit(frame.picture, scene, light, beside_person, region.slices)
        now, before, noise = frame.picture[region.slices], empty.picture, empty.noise
        difference, shadow = difference_of(now, before), np.zeros(now.shape, dtype=bool)
        new = new_pixels(difference, noise) & beside_person
        if isinstance(frame, StereoFrame) and self._is_large(new):
            assert self.model is not None  # noqa: S101 - what has learned the scene has both
            assert self._limit is not None  # noqa: S101
            empty_disparity = self.model.disparity[region.slices]
            apart = np.abs(disparity - empty_disparity)
            known = beside_person & np.isfinite(self._limit[region.slices])
            behind = known & (apart <= np.float32(self._p.background_threshold))
            if self._is_large(new & behind):
                changed_grey = behind & same_structure(now, before, noise)
                if self._is_large(new & changed_grey):
                    seen = changed_grey & seen_at(frame, empty_disparity, region)
                    if self._is_large(new & seen):  # both pictures show the scene; edges are filled
                        filled = cv2.morphologyEx(seen.astype(np.uint8), cv2.MORPH_CLOSE, _EDGES)
                        shadow = filled.astype(bool) & behind
        return Compared(now, before, difference, empty, self._p.match_window, shadow)

    def _is_large(self, part: BoolArray) -> bool:
        """Whether pixels (h, w) are more than a limb that the matcher has missed."""
        image = self._source.geometry.width * self._source.geometry.height
        return bool(np.count_nonzero(part) > _SHADOW * image)
