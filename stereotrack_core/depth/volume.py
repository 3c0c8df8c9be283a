"""Where the person is: the working volume and the disparities to search, from the recording."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import cv2
import numpy as np

from stereotrack_core.arrays import BoolArray, Float32Array, FloatArray, ImageArray
from stereotrack_core.depth.background import (
    BackgroundModel,
    empty_scene_model,
    percentile_model,
)
from stereotrack_core.depth.chain import Pictures, rectification_of, source_of
from stereotrack_core.depth.cloud import DepthGeometry
from stereotrack_core.depth.match import Region
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.points import Volume
from stereotrack_core.depth.sources import NEAREST_RANGE, DepthSource, NoDepth, disparity_range
from stereotrack_core.depth.standing import still_person
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.upright import UP_AXES, Upright
from stereotrack_core.recording.description import Recording, View
from stereotrack_core.recording.reader import ViewImages
from stereotrack_core.recording.upright import LikelyUp, up_of_cameras

_FRAMES = 10
"""Frames, spread over the recording, in which the person is looked for."""

_COLUMNS = 320
"""Width that images are reduced to, so that a wide range of disparities costs little."""

_APART = np.cos(np.radians(30.0))
"""Cosine of the angle between optical axes from which cameras stand around what they look at."""

_NEARER = 1.0
"""Pixels of disparity, in the reduced images, from which something stands in front of what is there
at other times."""

_USUAL = 20.0
"""Percentile of a pixel's disparities that is taken for what is there at other times."""

_OPENED = np.ones((3, 3), np.uint8)
_FEW_POINTS = 100
_MOSTLY = 0.6
"""Share of the points inside the default volume from which that one is taken."""

_MARGIN = 0.6
"""Metres around the places where the person was seen: arms reach farther at other times."""

_ARM = 0.9
"""Metres that a person in the middle of the volume reaches towards a camera."""

_USUAL_DISTANCE, _FAR = 3.0, 4.0
"""Metres from the camera for which ``least_focal`` is stated, and from which more is asked for."""

_SEEN_NEARER = 0.8
"""Share of the least range at which the person is seen that is searched as well."""

_TALL, _TALLER = 1.0, 1.5
"""Metres that a person extends along z, and how many times as far as along the axis that is up in
the images, from which it is the cameras that lie on their sides."""

_ANYWHERE = Volume(np.full(3, -np.inf), np.full(3, np.inf))

_PLACE = ("volume_centre_x", "volume_centre_y", "volume_bottom", "volume_x", "volume_y", "volume_z")


class AllPictures(Pictures, Protocol):
    """Where the images of a whole recording come from; see :class:`FrameReader`."""

    @property
    def frame_count(self) -> int:
        """Number of frame sets."""


def settled(
    recording: Recording, parameters: DepthParameters, pictures: AllPictures, views: Sequence[str]
) -> DepthParameters:
    """Parameters with an upward axis, a working volume and disparities that fit the recording.

    Up is where it is in the images (:func:`up_of_cameras`), unless the person's shape speaks
    against that.

    The volume's default, around the world's origin, is taken where cameras stand around it.
    Elsewhere the person is looked for, in some frames of reduced images with depths from 0.3 m on,
    as what a mask shows or what is nearer than at other times; the volume is put around all places
    where that was. As many disparities are searched as the person's least range asks for. Values
    that somebody has changed stay as they are. What is found does not depend on the frames that are
    tracked.
    """
    return _settled(recording, parameters, pictures, views)[0] if views else parameters


@dataclass(frozen=True)
class WorkingSpace:
    """Where the person is looked for, and what that rests on, for people to read."""

    up_axis: str
    """Axis of the world that is taken to point up."""
    low_m: tuple[float, ...]
    high_m: tuple[float, ...]
    """`low_m` and `high_m`: (x, y, z), world. Corners of the working volume."""
    volume_from: str
    """Why it is there, as words that follow a comma."""
    disparities_px: Mapping[str, tuple[int, int]]
    """Lowest and highest parallax searched, by stereo view."""
    nearest_m: Mapping[str, float]
    """Range of the highest one, by stereo view."""

    @property
    def volume(self) -> str:
        """Where the working volume is, in words."""
        spans = (
            f"{axis} {low:.2f} to {high:.2f}"
            for axis, low, high in zip("xyz", self.low_m, self.high_m, strict=True)
        )
        return f"{', '.join(spans)} m, {self.volume_from}"

    def searched(self, view: str) -> str:
        """Which disparities of a stereo view are searched, in words."""
        low, high = self.disparities_px[view]
        return f"{low} to {high} px, from {self.nearest_m[view]:.2f} m on"


def working_space(
    recording: Recording, parameters: DepthParameters, pictures: AllPictures, views: Sequence[str]
) -> WorkingSpace:
    """What :func:`settled` finds for a recording; raises InputError as that does."""
    found, why = _settled(recording, parameters, pictures, views)
    volume, pairs = Volume.of(found), dict[str, tuple[int, int]]()
    nearest = {}
    for view in map(recording.view, views):
        if view.left is None:
            continue
        geometry = rectification_of(recording, view, found).geometry
        searched = disparity_range(geometry, found)
        lowest = round(searched.minimum - geometry.disparity_offset)
        pairs[view.name] = lowest, lowest + searched.count - 1
        nearest[view.name] = geometry.focal * geometry.baseline / max(pairs[view.name][1], 1)
    low, high = (tuple(np.round(end, 2).tolist()) for end in (volume.low, volume.high))
    return WorkingSpace(found.upright.axis, low, high, why, pairs, nearest)


_GIVEN = "as the parameters say"
_AROUND = "around the origin, where cameras look from several sides"
_ABOUT_ORIGIN = "around the origin, where the person was seen"
_ABOUT_PERSON = "around all places where the person was seen"
_NOBODY = "around the origin, as no person was found"


def _settled(
    recording: Recording, parameters: DepthParameters, pictures: AllPictures, views: Sequence[str]
) -> tuple[DepthParameters, str]:
    """See :func:`settled`; and what the volume rests on."""
    person = _Person(recording, parameters, pictures, views)
    parameters = _upright(recording, parameters, person, views)
    volume, usual = Volume.of(parameters), DepthParameters()
    given = any(getattr(parameters, name) != getattr(usual, name) for name in _PLACE)
    if given or not parameters.volume_from_recording:
        return parameters, _GIVEN
    geometry = _geometry(recording, parameters, views)
    if _stand_around(volume, geometry, parameters.upright.up):
        middle = volume.corners().mean(axis=0)
        away = [float(view.project(middle[None])[2][0]) for view in geometry]
        parameters = _enlarged(parameters, geometry, away)
        geometry = _geometry(recording, parameters, views)
        return _searched(parameters, geometry, [z - _ARM for z in away]), _AROUND
    seen = [np.concatenate([np.zeros((0, 3)), *frames]) for frames in person.seen]
    points, why = np.concatenate(seen), _ABOUT_ORIGIN
    if len(points) < _FEW_POINTS and parameters.background_standing:
        seen = person.still(parameters.upright.up)
        points = np.concatenate(seen)
    if len(points) < _FEW_POINTS:
        return parameters, _NOBODY
    if volume.contains(points).mean() < _MOSTLY:
        parameters, why = _placed(parameters, points), _ABOUT_PERSON
    known = [name for name, own in zip(views, seen, strict=True) if len(own)]
    ranges = [view.project(own)[2] for view, own in zip(geometry, seen, strict=True) if len(own)]
    away = [float(np.median(z)) for z in ranges]
    parameters = _enlarged(parameters, _geometry(recording, parameters, known), away)
    nearest = [_SEEN_NEARER * float(np.percentile(z, 5)) for z in ranges]
    return _searched(parameters, _geometry(recording, parameters, known), nearest), why


def _geometry(
    recording: Recording, parameters: DepthParameters, views: Sequence[str]
) -> list[DepthGeometry]:
    return [rectification_of(recording, recording.view(n), parameters).geometry for n in views]


def _enlarged(
    parameters: DepthParameters, geometry: Sequence[DepthGeometry], away: Sequence[float]
) -> DepthParameters:
    """Images of people who are far away, in metres, enlarged as those of wide lenses are."""
    row = next(row for row in parameters.rows() if row.name == "least_focal")
    pairs = [z for view, z in zip(geometry, away, strict=True) if view.baseline > 0.0]
    farthest = max(pairs, default=0.0)
    if parameters.least_focal != row.default or farthest < _FAR:
        return parameters
    needed = float(round(parameters.least_focal * farthest / _USUAL_DISTANCE))
    return parameters.replaced(least_focal=min(needed, float(row.maximum or needed)))


def _upright(
    recording: Recording, parameters: DepthParameters, person: _Person, views: Sequence[str]
) -> DepthParameters:
    """Parameters that say which axis of the world points up."""
    if parameters.up_axis != "auto":
        return parameters
    likely = up_of_cameras(recording, views)
    usual = UP_AXES[0]
    if not likely.sure and _stands_along_z(person, Upright(likely.axis)):
        likely = LikelyUp(usual, True)
    return parameters.replaced(up_axis=likely.axis) if likely.axis != usual else parameters


def _stands_along_z(person: _Person, other: Upright) -> bool:
    """Whether the person's points speak for z against the axis that is up in the images."""
    frames = [points for view in person.seen for points in view if len(points) >= _FEW_POINTS]
    if other.axis == "-z":
        heights = np.concatenate([np.zeros(0), *(points[:, 2] for points in frames)])
        usual = Volume.of(DepthParameters())
        inside = (heights > usual.low[2]) & (heights < usual.high[2])
        return not len(heights) or float(np.mean(inside)) > _MOSTLY
    if not frames:
        return False
    ends = np.array([np.percentile(points, [2, 98], axis=0) for points in frames])
    extent = np.median(ends[:, 1] - ends[:, 0], axis=0)
    height = float(np.abs(other.up) @ extent)
    return bool(extent[2] > max(_TALL, _TALLER * height))


def _stand_around(volume: Volume, geometry: Sequence[DepthGeometry], up: FloatArray) -> bool:
    """Whether views from clearly different sides see the middle of the volume, low and high."""
    middle = volume.corners().mean(axis=0)
    column = middle + np.linspace(-0.4, 0.4, 3)[:, None] * up
    axes = []
    for view in geometry:
        with np.errstate(divide="ignore", invalid="ignore"):
            u, v, z = view.project(column)
        inside = (z > NEAREST_RANGE) & (u >= 0) & (u < view.width) & (v >= 0) & (v < view.height)
        if inside.all():
            axes.append(view.world_from_depth.rotation[:, 2])
    return len(axes) > 1 and bool((np.array(axes) @ np.array(axes).T).min() < _APART)


def _placed(parameters: DepthParameters, points: FloatArray) -> DepthParameters:
    """The volume around points (N, 3), world, metres; nowhere smaller than the default."""
    low, high = np.percentile(parameters.upright.points(points), [2, 98], axis=0)
    centre, size = 0.5 * (low + high), high - low + 2.0 * _MARGIN
    least = np.array([parameters.volume_x, parameters.volume_y, parameters.volume_z])
    size = np.maximum(size, least)
    x, y, z = np.round(centre, 2).tolist()
    width, depth, height = np.round(size, 2).tolist()
    return parameters.replaced(
        volume_centre_x=x,
        volume_centre_y=y,
        volume_bottom=round(z - 0.5 * height, 2),
        volume_x=width,
        volume_y=depth,
        volume_z=height,
    )


def _searched(
    parameters: DepthParameters, geometry: Sequence[DepthGeometry], nearest: Sequence[float]
) -> DepthParameters:
    """At least as many disparities as the views need to see what is so near, in metres."""
    needed = [
        view.focal * view.baseline / max(near, NEAREST_RANGE) + 2.0
        for view, near in zip(geometry, nearest, strict=True)
    ]
    row = next(row for row in parameters.rows() if row.name == "disparity_count")
    count = 16 * int(np.ceil(max(needed) / 16.0))
    if parameters.disparity_count != row.default or count <= row.default:
        return parameters
    return parameters.replaced(disparity_count=min(count, int(row.maximum or count)))


@dataclass(frozen=True, eq=False)
class _Person:
    """Where the person is seen over the whole recording; looked for when that is asked."""

    recording: Recording
    parameters: DepthParameters
    pictures: AllPictures
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
        """Points (N, 3), world, metres, of what a mask shows or what is nearer than usually.

        Frame by frame.
        """
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
