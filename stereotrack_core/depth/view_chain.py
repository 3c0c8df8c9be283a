"""The chain of one view: disparities, background, small patches, points."""

from __future__ import annotations

import functools
import operator
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import cv2
import numpy as np

from stereotrack_core.arrays import BoolArray, Float32Array, FloatArray, IntArray
from stereotrack_core.depth.background import LearnedFrame, ViewBackground
from stereotrack_core.depth.cloud import PointCounts, ViewDepth
from stereotrack_core.depth.match import STEPS, Region, region_of_points, within
from stereotrack_core.depth.outline import Compared
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.points import Volume, thinned_pixels
from stereotrack_core.depth.sources import (
    DepthSource,
    NoDepth,
    OpenedFrame,
    StereoFrame,
    StereoSource,
)
from stereotrack_core.recording.reader import ViewImages


class Stopwatch:
    """Books the time between laps on named stages."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._since = time.perf_counter()

    def lap(self, stage: str) -> None:
        """Book the time since the last lap, or since the start, on a stage."""
        now = time.perf_counter()
        self.seconds[stage] = self.seconds.get(stage, 0.0) + now - self._since
        self._since = now


_SPECKLE_RANGE = 1.0  # pixels of disparity by which neighbours of one patch differ at most
_FEW_INSIDE = 0.1  # share of points inside the volume; below, their median is stated
_NO_STEPS = int(np.iinfo(np.int16).min)


@dataclass(frozen=True, eq=False)
class ViewResult:
    """What one view measured at one instant.

    `problem` says why `depth` is None, or what is suspicious. `points` (N, 3) are in the world,
    metres, of `pixels` (N, 2); `counts` are without outliers, which fusion tells.
    """

    depth: ViewDepth | None
    problem: str
    points: FloatArray
    pixels: IntArray
    seconds: Mapping[str, float]
    counts: PointCounts = field(default_factory=PointCounts)


def _middle(points: FloatArray, inside: int) -> tuple[float, float, float] | None:
    """Where a view's points are, where that is hardly inside the volume."""
    known = points[np.isfinite(points).all(axis=1)]
    if inside >= _FEW_INSIDE * len(points) or not len(known):
        return None
    x, y, z = np.median(known, axis=0).tolist()
    return x, y, z


def _matched(
    frame: OpenedFrame, bands: Sequence[Region], region: Region, out_disparity: Float32Array
) -> int:
    """Match parts of a region (h, w) of an image; returns how many pixels have a disparity."""
    count = 0
    for band in bands:
        found = out_disparity[band.slices_in(region)] = frame.disparity(band)
        count += int(np.count_nonzero(np.isfinite(found)))
    return count


class ViewChain:
    """Depth, foreground and points of one view; not to be used by two threads at once."""

    def __init__(
        self,
        name: str,
        source: StereoSource | DepthSource,
        parameters: DepthParameters,
        *,
        colour: bool = False,
    ) -> None:
        self.name = name
        self.source = source
        self.background = ViewBackground(source, parameters)
        self._p = parameters
        self._colour = colour
        self._volume = Volume.of(parameters)
        self._volume_region = region_of_points(source.geometry, self._volume.corners())

    def align_rows(self, images: Sequence[ViewImages]) -> None:
        """Measure on some pairs by how many rows left images lie too low, and take that off."""
        if isinstance(self.source, StereoSource) and self._p.align_rows:
            self.source.align_rows(images)

    def learn_empty_scene(self, images: ViewImages) -> bool:
        """Take the model from the empty scene, for good; False where nothing can be matched."""
        self.align_rows([images])
        try:
            frame = self.source.open(images)
        except NoDepth:
            return False
        self.background.take_empty_scene(frame.picture, self._whole(frame))
        return True

    def take_over(self, other: ViewChain) -> None:
        """Know what another chain of the same view has learned."""
        self.background.take_over(other.background)
        if isinstance(self.source, StereoSource) and isinstance(other.source, StereoSource):
            self.source.rows = other.source.rows

    def learn_frame(self, images: ViewImages) -> LearnedFrame | None:
        """Disparity and grey picture of a frame; raw images in colour would take gigabytes."""
        try:
            frame = self.source.open(images)
        except NoDepth:
            return None
        disparity = self._whole(frame)
        if self.background.learns:
            geometry = self.source.geometry
            self.background.learn(disparity, Region.whole(geometry.width, geometry.height))
            return None
        return disparity, frame.picture

    def _whole(self, frame: OpenedFrame) -> Float32Array:
        """Disparity of all that the working volume can project to, NaN around it."""
        geometry = self.source.geometry
        disparity = np.full((geometry.height, geometry.width), np.nan, dtype=np.float32)
        if not self._volume_region.is_empty:
            part = frame.disparity(self._volume_region)
            disparity[self._volume_region.slices] = part
        return disparity

    def process(self, images: ViewImages) -> ViewResult:
        """Measure one instant."""
        watch = Stopwatch()
        try:
            frame = self.source.open(images)
        except NoDepth as reason:
            return self._without_depth(str(reason), watch)
        light = self.background.light(frame.picture)
        bands = within(self.background.changed_bands(light), self._volume_region)
        watch.lap("rectify")
        if self._volume_region.is_empty:
            return self._without_depth("it does not see the working volume", watch)
        if not bands:
            return self._with_nobody(images, watch)
        region, (behind, ranges) = functools.reduce(operator.or_, bands), self.background.outside
        disparity, ranges = behind[region.slices].copy(), ranges.copy()
        measured = _matched(frame, bands, region, disparity)
        watch.lap("match")
        if not measured:
            return self._without_depth("no pixel has a valid disparity", watch)
        compared = self.background.compared(frame, light, disparity, region)
        chosen, silhouette, outline = self._person(images, disparity, region, compared)
        if silhouette is not None:
            disparity[silhouette & ~chosen] = np.nan
        watch.lap("background")
        self._drop_patches(disparity, chosen)
        watch.lap("patches")
        trims = self._p.halo_trim == "silhouette"
        shown = chosen & outline if trims and outline is not None else chosen
        pixels = thinned_pixels(shown, self._p.pixel_step, (region.left, region.top))
        if self._p.subpixel == "aligned" and isinstance(frame, StereoFrame):
            frame.align(disparity, chosen if outline is None else outline, pixels, region)
            watch.lap("subpixel")
        ranges[region.slices] = self.source.ranges(disparity)
        range_z = ranges[pixels[:, 1], pixels[:, 0]]
        points = self.source.geometry.points(pixels[:, 0], pixels[:, 1], range_z.astype(np.float64))
        inside = self._volume.contains(points)
        kept = points[inside]
        depth = self._view_depth(images, ranges, (chosen, silhouette, outline), region)
        watch.lap("points")
        if depth.edges is not None:  # measured in this thread, for all who ask for them later
            watch.lap("edges")
        person, middle = int(np.count_nonzero(chosen)), _middle(points, len(kept))
        noise = frame.noise if isinstance(frame, StereoFrame) else 0.0
        blur = 0.0 if compared is None else compared.empty.blur
        counts = PointCounts(measured, person, len(pixels), len(kept), 0, middle, noise, blur)
        return ViewResult(depth, "", kept, pixels[inside], watch.seconds, counts)

    def _with_nobody(self, images: ViewImages, watch: Stopwatch) -> ViewResult:
        """The empty scene, if the picture does not differ from it."""
        (_, ranges), nobody = self.background.outside, np.zeros((0, 0), dtype=bool)
        sharp = nobody if self._p.silhouettes else None
        depth = self._view_depth(images, ranges, (nobody, sharp, sharp), Region(0, 0, 0, 0))
        counts = PointCounts(measured=int(np.count_nonzero(np.isfinite(ranges))))
        return replace(self._without_depth("", watch), depth=depth, problem="", counts=counts)

    def _person(
        self, images: ViewImages, disparity: Float32Array, region: Region, compared: Compared | None
    ) -> tuple[BoolArray, BoolArray | None, BoolArray | None]:
        """Foreground, silhouette and sharp outline in a region; None where not known.

        Background disparities are wrong in the silhouette: in front of a wall with a strong pattern
        a thin limb with a weak one is given the wall's disparity, which looks like free space.
        """
        p, background = self._p, self.background
        mask = self.source.person_mask(images) if isinstance(self.source, DepthSource) else None
        if mask is not None:
            mask = mask[region.slices]
            chosen = mask & np.isfinite(disparity)
        else:
            if background.learns:
                background.learn(disparity, region)
            chosen = background.foreground(disparity, region)
            if p.halo_trim == "picture" and compared is not None:
                chosen &= compared.changed()
        silhouette, outline = None, mask if p.silhouettes else None
        if compared is not None and p.silhouettes:
            silhouette, outline = compared.changed(), compared.outline(chosen)
        return chosen, silhouette, outline

    def _view_depth(
        self,
        images: ViewImages,
        ranges: Float32Array,
        masks: Sequence[BoolArray | None],
        region: Region,
    ) -> ViewDepth:
        """Ranges (H, W) with the masks of a region, and colours if they are wanted."""
        placed = [None if mask is None else np.zeros(ranges.shape, dtype=bool) for mask in masks]
        for image, mask in zip(placed, masks, strict=True):
            if image is not None and mask is not None:
                image[region.slices] = mask
        chosen, silhouette, outline = placed
        assert chosen is not None  # noqa: S101 - only the others may be unknown
        coloured = self._colour and images.image.ndim == 3
        picture = self.source.rectification.rectified(images.image) if coloured else None
        geometry = self.source.geometry
        return ViewDepth(geometry, ranges, chosen, silhouette, outline, picture)

    def _drop_patches(self, disparity: Float32Array, chosen: BoolArray) -> None:
        """Drop small patches in place (2.1.4), last: only the foreground is searched."""
        left, top, width, height = cv2.boundingRect(chosen.view(np.uint8))
        if self._p.speckle_size == 0 or not width:
            return
        box = slice(top, top + height), slice(left, left + width)
        disparity, chosen = disparity[box], chosen[box]
        steps = np.where(chosen, disparity * np.float32(STEPS), np.float32(_NO_STEPS))
        patches = np.minimum(steps, np.float32(np.iinfo(np.int16).max)).astype(np.int16)
        allowed = round(_SPECKLE_RANGE * STEPS)
        cv2.filterSpeckles(patches, _NO_STEPS, self._p.speckle_size, allowed)
        dropped = chosen & (patches == _NO_STEPS)
        disparity[dropped] = np.nan
        chosen[dropped] = False

    def _without_depth(self, reason: str, watch: Stopwatch) -> ViewResult:
        return ViewResult(
            depth=None,
            problem=f"View {self.name} provides no depth: {reason}.",
            points=np.zeros((0, 3)),
            pixels=np.zeros((0, 2), dtype=np.int64),
            seconds=watch.seconds,
        )
