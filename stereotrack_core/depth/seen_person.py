"""Where the person is seen over a whole recording, in reduced images that cost little."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import cv2
import numpy as np

from stereotrack_core.arrays import BoolArray, Float32Array, FloatArray, ImageArray
from stereotrack_core.depth.background import BackgroundModel, empty_scene_model, percentile_model
from stereotrack_core.depth.chain import rectification_of, source_of
from stereotrack_core.depth.match import Region
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.points import Volume
from stereotrack_core.depth.sources import NEAREST_RANGE, DepthSource, NoDepth
from stereotrack_core.depth.standing import still_person
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.description import Recording, View
from stereotrack_core.recording.reader import FrameReader, ViewImages

_FRAMES = 10  # frames, spread over the recording, in which the person is looked for
_COLUMNS = 320  # width that images are reduced to, so that a wide range of disparities costs little
_NEARER = 1.0  # pixels of disparity, reduced images, in front of what is usually there
_USUAL = 20.0  # percentile of a pixel's disparities that is taken for what is there at other times
_OPENED = np.ones((3, 3), np.uint8)
_ANYWHERE = Volume(np.full(3, -np.inf), np.full(3, np.inf))


@dataclass(frozen=True, eq=False)
class SeenPerson:
    """Where the person is seen over the whole recording; looked for when that is asked."""

    recording: Recording
    parameters: DepthParameters
    pictures: FrameReader
    views: Sequence[str]

    @cached_property
    def seen(self) -> list[list[FloatArray]]:
        """Points (N, 3), world, metres, of the person, by view and frame."""
        return [view.person() for view in self._reduced]

    def still(self, up: FloatArray) -> list[FloatArray]:
        """Points (N, 3), world, metres, of a person who does not move at all, by view."""
        return [view.still_person(up) for view in self._reduced]

    @cached_property
    def _reduced(self) -> list[_ReducedView]:
        """The views, which have looked at some frames."""
        p, pictures = self.parameters, self.pictures
        reduced = [_ReducedView(self.recording, self.recording.view(n), p) for n in self.views]
        if p.background_empty_scene:
            for view in reduced:
                view.look_at_empty_scene(pictures.background(view.name))
        frames = range(pictures.frame_count)
        most = min(_FRAMES, len(frames))
        for place in np.unique(np.linspace(0, len(frames) - 1, most).astype(int)):
            images = pictures.frame_set(frames[place]).views
            for view in reduced:
                if view.name in images:
                    view.look(images[view.name])
        return reduced


class _ReducedView:
    """Looks for the person in reduced images of one view."""

    def __init__(self, recording: Recording, view: View, p: DepthParameters) -> None:
        self.name = view.name
        self._shrink = max(1, round(recording.reference_camera(view).width / _COLUMNS))
        cameras = {n: _reduced(camera, self._shrink) for n, camera in recording.cameras.items()}
        small = replace(recording, cameras=cameras)
        coarse = p.replaced(
            matcher="bm", disparity_minimum=0, disparity_from_volume=False, least_focal=0.0
        )
        geometry = rectification_of(small, view, coarse).geometry
        count = int(np.clip(geometry.focal * geometry.baseline / NEAREST_RANGE, 16, 512))
        self._source = source_of(small, view, coarse.replaced(disparity_count=count))
        self._empty: Float32Array | None = None
        self._seen: list[tuple[Float32Array, BoolArray | None]] = []

    def look_at_empty_scene(self, images: tuple[ImageArray | None, ImageArray] | None) -> None:
        """Measure what is there when nobody is."""
        if images is not None and images[0] is not None:
            found = self._measured(ViewImages(image=images[1], left=images[0]))
            self._empty = None if found is None else found[0]

    def look(self, images: ViewImages) -> None:
        """Measure one frame."""
        found = self._measured(images)
        if found is not None:
            self._seen.append(found)

    def _measured(self, images: ViewImages) -> tuple[Float32Array, BoolArray | None] | None:
        """Disparities and mask (h, w); None without depth."""
        s, geometry = self._shrink, self._source.geometry
        sampled = slice(s // 2, s * geometry.height, s), slice(s // 2, s * geometry.width, s)
        small = ViewImages(
            image=self._small(images.image),
            left=None if images.left is None else self._small(images.left),
            depth=None if images.depth is None else images.depth[sampled],
            mask=None if images.mask is None else images.mask[sampled],
        )
        try:
            frame = self._source.open(small)
        except NoDepth:
            return None
        depth = self._source if isinstance(self._source, DepthSource) else None
        mask = None if depth is None else depth.person_mask(small)
        return frame.disparity(Region.whole(geometry.width, geometry.height)), mask

    def _small(self, image: ImageArray) -> ImageArray:
        geometry, s = self._source.geometry, self._shrink
        cut = image[: s * geometry.height, : s * geometry.width]
        size = geometry.width, geometry.height
        return cv2.resize(cut, size, interpolation=cv2.INTER_AREA).astype(np.uint8, copy=False)

    def person(self) -> list[FloatArray]:
        """Points (N, 3), world, metres, by frame, of a mask or of what is nearer than usually."""
        found: list[FloatArray] = []
        if not self._seen:
            return found
        limit = self._usual().limit(_NEARER)
        for disparity, mask in self._seen:
            shown = np.isfinite(limit) & (disparity > limit) if mask is None else mask
            opened = cv2.morphologyEx(shown.astype(np.uint8), cv2.MORPH_OPEN, _OPENED)
            found.append(self._points(opened.astype(bool), self._source.ranges(disparity)))
        return found

    def still_person(self, up: FloatArray) -> FloatArray:
        """Points (N, 3), world, metres, of a person who does not move at all."""
        if not self._seen or self._empty is not None:
            return np.zeros((0, 3))
        usual = self._usual()
        known = np.isfinite(usual.limit(_NEARER))
        ranges = self._source.ranges(np.where(known, usual.disparity, np.float32(np.nan)))
        return self._points(still_person(self._source.geometry, _ANYWHERE, ranges, up), ranges)

    def _usual(self) -> BackgroundModel:
        """What is there at other times, or when nobody is."""
        if self._empty is not None:
            return empty_scene_model(self._empty)
        return percentile_model([disparity for disparity, _ in self._seen], _USUAL)

    def _points(self, shown: BoolArray, ranges: Float32Array) -> FloatArray:
        v, u = np.nonzero(shown & np.isfinite(ranges))
        return self._source.geometry.points(u, v, ranges[v, u].astype(np.float64))


def _reduced(camera: Camera, shrink: int) -> Camera:
    """The camera as its images are reduced by a whole number."""
    matrix = camera.matrix.copy()
    matrix[:2] /= shrink
    matrix[:2, 2] += 0.5 / shrink - 0.5  # the centre of the first pixel is (0, 0)
    width, height = camera.width // shrink, camera.height // shrink
    return replace(camera, matrix=matrix, width=width, height=height)
