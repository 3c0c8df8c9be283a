"""Where the person is: the working volume and the disparities to search, from the recording."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.depth.chain import rectification_of
from stereotrack_core.depth.cloud import DepthGeometry
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.points import Volume
from stereotrack_core.depth.seen_person import AllPictures, SeenPerson
from stereotrack_core.depth.sources import NEAREST_RANGE, disparity_range
from stereotrack_core.geometry.upright import UP_AXES, Upright
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.upright import LikelyUp, up_of_cameras

_APART = np.cos(np.radians(30.0))
"""Cosine of the angle between optical axes from which cameras stand around what they look at."""

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

_SAMPLES = 12
"""Points along each side of the volume by which it is asked what an image shows of it."""

_PLACE = ("volume_centre_x", "volume_centre_y", "volume_bottom", "volume_x", "volume_y", "volume_z")


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
    searched_m: Mapping[str, tuple[float, float]]
    """Ranges of the highest and the lowest one, by stereo view; the second may be infinite."""
    needed_m: Mapping[str, tuple[float, float]]
    """From which range on to which the person is looked for, by stereo view."""

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
        return f"{low} to {high} px, from {self.searched_m[view][0]:.2f} m on"


def working_space(
    recording: Recording, parameters: DepthParameters, pictures: AllPictures, views: Sequence[str]
) -> WorkingSpace:
    """What :func:`settled` finds for a recording; raises InputError as that does."""
    found, why, nearest = _settled(recording, parameters, pictures, views)
    volume, pairs = Volume.of(found), dict[str, tuple[int, int]]()
    reached, needed = dict[str, tuple[float, float]](), dict[str, tuple[float, float]]()
    for view in map(recording.view, views):
        if view.left is None:
            continue
        geometry = rectification_of(recording, view, found).geometry
        searched = disparity_range(geometry, found)
        lowest = round(searched.minimum - geometry.disparity_offset)
        low_px, high_px = pairs[view.name] = lowest, lowest + searched.count - 1
        scale = geometry.focal * geometry.baseline
        reached[view.name] = scale / max(high_px, 1), scale / low_px if low_px > 0 else np.inf
        if (ranges := _ranges_shown(volume, geometry)) is not None:
            needed[view.name] = max(nearest.get(view.name, 0.0), ranges[0]), ranges[1]
    low, high = (tuple(np.round(end, 2).tolist()) for end in (volume.low, volume.high))
    return WorkingSpace(found.upright.axis, low, high, why, pairs, reached, needed)


def _ranges_shown(volume: Volume, geometry: DepthGeometry) -> tuple[float, float] | None:
    """Ranges between which nearly all of a volume lies that an image shows; None where none does.

    The least part of it, in its nearest corner, may hold a hand now and then.
    """
    axes = (
        np.linspace(low, high, _SAMPLES) for low, high in zip(volume.low, volume.high, strict=True)
    )
    points = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 3)
    with np.errstate(divide="ignore", invalid="ignore"):
        u, v, z = geometry.project(points)
    shown = (z > NEAREST_RANGE) & (u >= 0) & (u < geometry.width)
    shown &= (v >= 0) & (v < geometry.height)
    if not shown.any():
        return None
    near, far = np.percentile(z[shown], [5, 95])
    return float(near), float(far)


_GIVEN = "as the parameters say"
_AROUND = "around the origin, where cameras look from several sides"
_ABOUT_ORIGIN = "around the origin, where the person was seen"
_ABOUT_PERSON = "around all places where the person was seen"
_NOBODY = "around the origin, as no person was found"


def _settled(
    recording: Recording, parameters: DepthParameters, pictures: AllPictures, views: Sequence[str]
) -> tuple[DepthParameters, str, Mapping[str, float]]:
    """See :func:`settled`; what the volume rests on; the least ranges searched, by view."""
    person = SeenPerson(recording, parameters, pictures, views)
    parameters = _upright(recording, parameters, person, views)
    volume, usual = Volume.of(parameters), DepthParameters()
    given = any(getattr(parameters, name) != getattr(usual, name) for name in _PLACE)
    if given or not parameters.volume_from_recording:
        return parameters, _GIVEN, {}
    geometry = _geometry(recording, parameters, views)
    if _stand_around(volume, geometry, parameters.upright.up):
        middle = volume.corners().mean(axis=0)
        away = [float(view.project(middle[None])[2][0]) for view in geometry]
        parameters = _enlarged(parameters, geometry, away)
        geometry = _geometry(recording, parameters, views)
        nearest = [z - _ARM for z in away]
        return (
            _searched(parameters, geometry, nearest),
            _AROUND,
            dict(zip(views, nearest, strict=True)),
        )
    seen = [np.concatenate([np.zeros((0, 3)), *frames]) for frames in person.seen]
    points, why = np.concatenate(seen), _ABOUT_ORIGIN
    if len(points) < _FEW_POINTS:
        seen = person.still(parameters.upright.up)
        points = np.concatenate(seen)
    if len(points) < _FEW_POINTS:
        return parameters, _NOBODY, {}
    if volume.contains(points).mean() < _MOSTLY:
        parameters, why = _placed(parameters, points), _ABOUT_PERSON
    known = [name for name, own in zip(views, seen, strict=True) if len(own)]
    ranges = [view.project(own)[2] for view, own in zip(geometry, seen, strict=True) if len(own)]
    away = [float(np.median(z)) for z in ranges]
    parameters = _enlarged(parameters, _geometry(recording, parameters, known), away)
    nearest = [_SEEN_NEARER * float(np.percentile(z, 5)) for z in ranges]
    parameters = _searched(parameters, _geometry(recording, parameters, known), nearest)
    return parameters, why, dict(zip(known, nearest, strict=True))


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
    recording: Recording, parameters: DepthParameters, person: SeenPerson, views: Sequence[str]
) -> DepthParameters:
    """Parameters that say which axis of the world points up."""
    if parameters.up_axis != "auto":
        return parameters
    likely = up_of_cameras(recording, views)
    usual = UP_AXES[0]
    if not likely.sure and _stands_along_z(person, Upright(likely.axis)):
        likely = LikelyUp(usual, True)
    return parameters.replaced(up_axis=likely.axis) if likely.axis != usual else parameters


def _stands_along_z(person: SeenPerson, other: Upright) -> bool:
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
