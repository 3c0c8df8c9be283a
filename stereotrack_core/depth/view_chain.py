"""The chain of one view: disparities, background, small patches, points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from stereotrack_core.arrays import BoolArray, Float32Array, FloatArray, IntArray
from stereotrack_core.depth.background import (
    BackgroundModel,
    averaged,
    empty_scene_model,
    foreground,
    percentile_model,
)
from stereotrack_core.depth.cloud import ViewDepth
from stereotrack_core.depth.match import STEPS
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.points import Volume, world_points
from stereotrack_core.depth.sources import DepthSource, NoDepth, StereoSource
from stereotrack_core.depth.stopwatch import Stopwatch
from stereotrack_core.recording.frames import ViewImages

_NO_STEPS = int(np.iinfo(np.int16).min)


@dataclass(frozen=True, eq=False)
class ViewResult:
    """What one view measured at one instant.

    Attributes
    ----------
    depth : ViewDepth or None
    problem : str
        Why `depth` is None, or what is suspicious; empty if nothing is.
    points : (N, 3) float64, world, metres
    pixels : (N, 2) int64
    seconds : mapping from stage to seconds
    """

    depth: ViewDepth | None
    problem: str
    points: FloatArray
    pixels: IntArray
    seconds: Mapping[str, float]


class ViewChain:
    """Depth, foreground and points of one view; not to be used by two threads at once.

    Parameters
    ----------
    name : str
    source : StereoSource or DepthSource
    parameters : DepthParameters
    """

    def __init__(
        self, name: str, source: StereoSource | DepthSource, parameters: DepthParameters
    ) -> None:
        self.name = name
        self.source = source
        self._p = parameters
        self._volume = Volume.of(parameters)
        self._model: BackgroundModel | None = None
        self._limit: Float32Array | None = None
        self._learns = parameters.background_mode == "average"

    @property
    def background(self) -> BackgroundModel | None:
        """The model as it stands."""
        return self._model

    def learn_empty_scene(self, images: ViewImages) -> bool:
        """Take the model from the empty scene; nothing is learned afterwards.

        Returns
        -------
        bool
            False where the images show nothing that can be matched.
        """
        try:
            disparity = self.source.disparities(images, Stopwatch())
        except NoDepth:
            return False
        self._set_model(empty_scene_model(disparity))
        self._learns = False
        return True

    def learn_frames(self, frames: Sequence[ViewImages]) -> None:
        """Take the model from a recording in which somebody moves, as the parameters say."""
        disparities = []
        for images in frames:
            try:
                disparities.append(self.source.disparities(images, Stopwatch()))
            except NoDepth:
                continue
        if self._p.background_mode == "none" or not disparities:
            return
        if self._p.background_mode == "percentile":
            self._set_model(percentile_model(disparities, self._p.background_percentile))
            return
        for disparity in disparities:
            self._learn(disparity)

    def process(self, images: ViewImages) -> ViewResult:
        """Measure one instant."""
        watch = Stopwatch()
        try:
            disparity = self.source.disparities(images, watch)
        except NoDepth as reason:
            return self._without_depth(str(reason), watch)
        if not np.isfinite(disparity).any():
            return self._without_depth("no pixel has a valid disparity", watch)
        chosen = self._foreground(images, disparity)
        watch.lap("background")
        self._drop_patches(disparity, chosen)
        watch.lap("patches")
        return self._result(disparity, chosen, watch)

    def _result(self, disparity: Float32Array, chosen: BoolArray, watch: Stopwatch) -> ViewResult:
        geometry = self.source.geometry
        ranges = self.source.ranges(disparity)
        points, pixels = world_points(geometry, ranges, chosen, self._p.pixel_step)
        inside = self._volume.contains(points)
        stereo = isinstance(self.source, StereoSource)
        depth = ViewDepth(geometry, disparity if stereo else None, ranges, chosen)
        watch.lap("points")
        return ViewResult(depth, "", points[inside], pixels[inside], watch.seconds)

    def _foreground(self, images: ViewImages, disparity: Float32Array) -> BoolArray:
        if isinstance(self.source, DepthSource):
            mask = self.source.person_mask(images)
            if mask is not None:
                return mask & np.isfinite(disparity)
        if self._learns:
            self._learn(disparity)
        if self._limit is None:
            valid: BoolArray = np.isfinite(disparity)
            return valid
        return foreground(disparity, self._limit)

    def _drop_patches(self, disparity: Float32Array, chosen: BoolArray) -> None:
        """Drop small patches of the foreground, in place (2.1.4).

        After the background, because then only the foreground has to be searched.
        """
        if self._p.speckle_size == 0:
            return
        steps = np.where(chosen, disparity * np.float32(STEPS), np.float32(_NO_STEPS))
        patches = np.minimum(steps, np.float32(np.iinfo(np.int16).max)).astype(np.int16)
        allowed = round(self._p.speckle_range * STEPS)
        cv2.filterSpeckles(patches, _NO_STEPS, self._p.speckle_size, allowed)
        dropped = chosen & (patches == _NO_STEPS)
        disparity[dropped] = np.nan
        chosen[dropped] = False

    def _learn(self, disparity: Float32Array) -> None:
        p = self._p
        self._set_model(
            averaged(self._model, disparity, p.background_rate, p.background_validity_rate)
        )

    def _set_model(self, model: BackgroundModel) -> None:
        self._model = model
        self._limit = model.limit(self._p.background_threshold, self._p.background_valid_above)

    def _without_depth(self, reason: str, watch: Stopwatch) -> ViewResult:
        return ViewResult(
            depth=None,
            problem=f"View {self.name} gives no depth: {reason}.",
            points=np.zeros((0, 3)),
            pixels=np.zeros((0, 2), dtype=np.int64),
            seconds=watch.seconds,
        )
