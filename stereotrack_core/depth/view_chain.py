"""The chain of one view: disparities, background, small patches, points."""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import cv2
import numpy as np

from stereotrack_core.arrays import BoolArray, Float32Array, FloatArray, IntArray
from stereotrack_core.depth.background import ViewBackground
from stereotrack_core.depth.cloud import PointCounts, ViewDepth
from stereotrack_core.depth.match import STEPS, Region, region_of_points
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.points import Volume, thinned_pixels, world_points
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


def summed(watches: Iterable[Mapping[str, float]]) -> dict[str, float]:
    """Seconds per stage over several stopwatches."""
    total: dict[str, float] = {}
    for seconds in watches:
        for stage, value in seconds.items():
            total[stage] = total.get(stage, 0.0) + value
    return total


_FEW_INSIDE = 0.1
"""Share of the points inside the working volume below which it is of interest where they are."""

_NO_STEPS = int(np.iinfo(np.int16).min)


@dataclass(frozen=True, eq=False)
class ViewResult:
    """What one view measured at one instant.

    Attributes
    ----------
    problem : str
        Why `depth` is None, or what is suspicious; empty if nothing is.
    points : (N, 3) float64, world, metres
    pixels : (N, 2) int64
    seconds : mapping from stage to seconds
    counts : PointCounts
        As far as one view goes: outliers are told apart when the views are fused.
    """

    depth: ViewDepth | None
    problem: str
    points: FloatArray
    pixels: IntArray
    seconds: Mapping[str, float]
    counts: PointCounts = field(default_factory=PointCounts)


@dataclass(frozen=True, eq=False)
class Seen:
    """What the picture alone says about the person.

    Attributes
    ----------
    silhouette, outline : (H, W) bool or None
        See :class:`ViewDepth`.
    """

    silhouette: BoolArray | None
    outline: BoolArray | None

    def placed(self, region: Region, shape: tuple[int, int]) -> Seen:
        """Images of full size with nothing around the region."""
        images = self.silhouette, self.outline
        return Seen(*(None if i is None else _placed(i, region, shape) for i in images))


def _placed(image: BoolArray, region: Region, shape: tuple[int, int]) -> BoolArray:
    around = np.zeros(shape, dtype=bool)
    around[region.slices] = image
    return around


def _middle(points: FloatArray, inside: int) -> tuple[float, float, float] | None:
    """Where a view's points are, where that is hardly inside the volume."""
    known = points[np.isfinite(points).all(axis=1)]
    if inside >= _FEW_INSIDE * len(points) or not len(known):
        return None
    x, y, z = np.median(known, axis=0).tolist()
    return x, y, z


class ViewChain:
    """Depth, foreground and points of one view; not to be used by two threads at once.

    Parameters
    ----------
    colour : bool
        Whether to keep the picture's colours, where it has any.
    """

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

    def learn_empty_scene(self, images: ViewImages) -> bool:
        """Take the model from the empty scene; nothing is learned afterwards.

        Returns
        -------
        bool
            False where the images show nothing that can be matched.
        """
        try:
            frame = self.source.open(images)
        except NoDepth:
            return False
        self.background.take_empty_scene(frame.picture, self._whole(frame))
        return True

    def learn_frames(self, frames: Sequence[ViewImages]) -> None:
        """Take the model from a recording in which somebody moves, as the parameters say."""
        disparities, pictures = [], []
        for images in frames:
            try:
                frame = self.source.open(images)
            except NoDepth:
                continue
            disparities.append(self._whole(frame))
            if frame.picture is not None:
                pictures.append(frame.picture)
        if disparities:
            self.background.take_frames(pictures, disparities)

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
        region = self.background.changed_region(frame.picture) & self._volume_region
        watch.lap("rectify")
        if region.is_empty:
            return self._without_depth("it does not see the working volume", watch)
        disparity = frame.disparity(region)
        watch.lap("match")
        measured = int(np.count_nonzero(np.isfinite(disparity)))
        if not measured:
            return self._without_depth("no pixel has a valid disparity", watch)
        chosen = self._foreground(images, frame, disparity, region)
        silhouette = self._silhouette(frame, region)
        if silhouette is not None:
            disparity[silhouette & ~chosen] = np.nan
        outline = self._outline(images, frame, chosen, region)
        watch.lap("background")
        self._drop_patches(disparity, chosen)
        watch.lap("patches")
        seen = Seen(silhouette, outline)
        pixels = self._pixels(chosen, seen, region)
        if self._p.subpixel == "aligned" and isinstance(frame, StereoFrame):
            self._align(frame, disparity, chosen if outline is None else outline, pixels, region)
            watch.lap("subpixel")
        counts = PointCounts(measured, int(np.count_nonzero(chosen)), len(pixels))
        result = self._result(disparity, chosen, pixels, seen, region, counts, watch)
        return self._with_picture(result, images, watch) if self._colour else result

    def _with_picture(self, result: ViewResult, images: ViewImages, watch: Stopwatch) -> ViewResult:
        if images.image.ndim < 3 or result.depth is None:
            return result
        picture = self.source.rectified(images.image)
        watch.lap("colours")
        depth = replace(result.depth, picture=picture)
        return replace(result, depth=depth, seconds=watch.seconds)

    def _pixels(self, chosen: BoolArray, seen: Seen, region: Region) -> IntArray:
        """Pixels (N, 2) of the view's depth image that become points."""
        if self._p.halo_trim == "outline" and seen.outline is not None:
            chosen = chosen & seen.outline
        return thinned_pixels(chosen, self._p.pixel_step, (region.left, region.top))

    def _align(
        self,
        frame: StereoFrame,
        disparity: Float32Array,
        person: BoolArray,
        pixels: IntArray,
        region: Region,
    ) -> None:
        """Refine the disparities of some pixels, in place."""
        whole = _placed(person, region, frame.picture.shape)
        columns, rows = pixels[:, 0] - region.left, pixels[:, 1] - region.top
        found = disparity[rows, columns].astype(np.float64)
        disparity[rows, columns] = frame.aligned(whole, pixels, found)

    def _result(
        self,
        disparity: Float32Array,
        chosen: BoolArray,
        pixels: IntArray,
        seen: Seen,
        region: Region,
        counts: PointCounts,
        watch: Stopwatch,
    ) -> ViewResult:
        geometry = self.source.geometry
        ranges = self.source.ranges(disparity)
        range_z = ranges[pixels[:, 1] - region.top, pixels[:, 0] - region.left]
        points = world_points(geometry, range_z.astype(np.float64), pixels)
        inside = self._volume.contains(points)
        depth = self._view_depth(disparity, ranges, chosen, seen, region)
        kept = points[inside]
        counts = replace(counts, inside=len(kept), middle=_middle(points, len(kept)))
        watch.lap("points")
        return ViewResult(depth, "", kept, pixels[inside], watch.seconds, counts)

    def _view_depth(
        self,
        disparity: Float32Array,
        ranges: Float32Array,
        chosen: BoolArray,
        seen: Seen,
        region: Region,
    ) -> ViewDepth:
        """Images of full size, with the empty scene around the region."""
        geometry = self.source.geometry
        stereo = isinstance(self.source, StereoSource)
        if region != Region.whole(geometry.width, geometry.height):
            part = disparity, ranges, chosen
            disparity, ranges = self.background.outside()
            chosen = np.zeros((geometry.height, geometry.width), dtype=bool)
            disparity[region.slices], ranges[region.slices], chosen[region.slices] = part
            seen = seen.placed(region, (geometry.height, geometry.width))
        given = disparity if stereo else None
        return ViewDepth(geometry, given, ranges, chosen, seen.silhouette, seen.outline)

    def _foreground(
        self, images: ViewImages, frame: OpenedFrame, disparity: Float32Array, region: Region
    ) -> BoolArray:
        if isinstance(self.source, DepthSource):
            mask = self.source.person_mask(images)
            if mask is not None:
                return mask[region.slices] & np.isfinite(disparity)
        if self.background.learns:
            self.background.learn(disparity, region)
        chosen = self.background.foreground(disparity, region)
        if self._p.halo_trim == "picture" and frame.picture is not None:
            chosen &= self.background.changed(frame.picture, region)
        return chosen

    def _silhouette(self, frame: OpenedFrame, region: Region) -> BoolArray | None:
        """Where the picture is not the empty scene's; background disparities are wrong there.

        In front of a wall with a strong pattern a thin limb with a weak one is given the wall's
        disparity: that looks like free space, and is not.
        """
        if not self._p.background_doubt or frame.picture is None:
            return None
        if not self.background.knows_picture:
            return None
        return self.background.changed(frame.picture, region)

    def _outline(
        self, images: ViewImages, frame: OpenedFrame, chosen: BoolArray, region: Region
    ) -> BoolArray | None:
        if not self._p.outlines:
            return None
        if isinstance(self.source, DepthSource):
            mask = self.source.person_mask(images)
            return None if mask is None else mask[region.slices]
        if frame.picture is None:
            return None
        return self.background.outline(frame.picture, chosen, region)

    def _drop_patches(self, disparity: Float32Array, chosen: BoolArray) -> None:
        """Drop small patches of the foreground, in place (2.1.4).

        After the background, because then only the foreground has to be searched.
        """
        left, top, width, height = cv2.boundingRect(chosen.view(np.uint8))
        if self._p.speckle_size == 0 or not width:
            return
        box = slice(top, top + height), slice(left, left + width)
        disparity, chosen = disparity[box], chosen[box]
        steps = np.where(chosen, disparity * np.float32(STEPS), np.float32(_NO_STEPS))
        patches = np.minimum(steps, np.float32(np.iinfo(np.int16).max)).astype(np.int16)
        allowed = round(self._p.speckle_range * STEPS)
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
