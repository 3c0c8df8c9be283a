"""Where the person is: the working volume and the disparities to search, from the recording."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.depth.chain import rectification_of
from stereotrack_core.depth.cloud import DepthGeometry
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.points import Volume
from stereotrack_core.depth.seen_person import SeenPerson
from stereotrack_core.depth.sources import NEAREST_RANGE, disparity_range
from stereotrack_core.errors import Finding, InputError
from stereotrack_core.geometry.upright import UP_AXES, Upright
from stereotrack_core.recording.camera_checks import LikelyUp, up_of_cameras
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader

_APART = np.cos(np.radians(30.0))  # between optical axes of cameras that stand around something
_FEW_POINTS = 100
_MOSTLY = 0.6  # share of the points inside the default volume from which that one is taken
_MARGIN = 0.6  # metres around where the person was seen, as arms reach farther later
_ARM = 0.9  # metres that a person in the middle of the volume reaches towards a camera
_USUAL_DISTANCE, _FAR = 3.0, 4.0  # metres for which ``least_focal`` holds; beyond, more is asked
_SEEN_NEARER = 0.8  # share of the least range at which the person is seen that is searched as well
# Metres that a person extends along z, and how many times as far as along the images' up axis, from
# which it is the cameras that lie on their sides.
_TALL, _TALLER = 1.0, 1.5
_SAMPLES = 12  # points along each side of the volume by which it is asked what an image shows of it
_PLACE = ("volume_centre_x", "volume_centre_y", "volume_bottom", "volume_x", "volume_y", "volume_z")


def settled(
    recording: Recording, parameters: DepthParameters, pictures: FrameReader, views: Sequence[str]
) -> DepthParameters:
    """Parameters with an upward axis, a working volume and disparities that fit the recording.

    Up is where it is in the images (:func:`up_of_cameras`), unless the person's shape speaks
    against it. The default volume, around the origin, is taken where cameras stand around it.
    Elsewhere it is put around all places where the person is seen in some frames of reduced images,
    as a mask or as what is nearer than at other times.

    As many disparities are searched as the person's least range asks for. Changed values stay. The
    result does not depend on the frames that are tracked.
    """
    return _settled(recording, parameters, pictures, views)[0] if views else parameters


@dataclass(frozen=True)
class WorkingSpace:
    """Where the person is looked for, and what that rests on, for people to read."""

    up_axis: str  # axis of the world that is taken to point up
    low_m: tuple[float, ...]
    high_m: tuple[float, ...]  # corners of the working volume, (x, y, z), world
    volume_from: str  # why it is there, as words that follow a comma
    disparities_px: Mapping[str, tuple[int, int]]  # least and largest parallax, by view
    searched_m: Mapping[str, tuple[float, float]]  # their ranges; the second may be infinite
    needed_m: Mapping[str, tuple[float, float]]  # where the person is looked for, by view

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
    recording: Recording, parameters: DepthParameters, pictures: FrameReader, views: Sequence[str]
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
    """Ranges of nearly all of a volume that an image shows; its corners may hold a hand."""
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
    recording: Recording, parameters: DepthParameters, pictures: FrameReader, views: Sequence[str]
) -> tuple[DepthParameters, str, Mapping[str, float]]:
    """See :func:`settled`; also what the volume rests on, and the least ranges by view."""
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


_SLACK = 1.03  # by how many times a range may be missed: disparities are whole pixels


def check_reach(space: WorkingSpace) -> Iterator[Finding]:
    """Findings about views that do not search the ranges at which the person is looked for."""
    for view, (near, far) in space.needed_m.items():
        nearest, farthest = space.searched_m[view]
        (low, high), remedies = space.disparities_px[view], []
        if nearest > _SLACK * near:
            needed = math.ceil(nearest * high / near) - low + 1
            remedies.append(f"Set disparity_count to {16 * math.ceil(needed / 16)} or more.")
        if farthest * _SLACK < far:
            least = math.floor(farthest * low / far)
            remedies.append(f"Set disparity_minimum to {least} or less.")
        if remedies:
            to = f" to {farthest:.2f} m" if math.isfinite(farthest) else " m on"
            yield Finding(
                "error" if nearest > far or farthest < near else "warning",
                f"view {view}, disparities",
                f"those of {low} to {high} px show what is {nearest:.2f}{to}, but the person is "
                f"looked for from {near:.2f} to {far:.2f} m",
                f"{' '.join(remedies)} Defaults are adapted to the recording; values that you "
                "have changed are not.",
            )


def is_changed(parameters: DepthParameters) -> bool:
    """Whether somebody has changed which disparities are searched."""
    usual = DepthParameters()
    names = ("disparity_minimum", "disparity_count")
    return any(getattr(parameters, name) != getattr(usual, name) for name in names)


def reach_of(
    recording: Recording, parameters: DepthParameters, pictures: FrameReader, views: Sequence[str]
) -> tuple[Finding, ...]:
    """Findings by some frames; none where no depth can be measured, which other checks tell."""
    try:
        return tuple(check_reach(working_space(recording, parameters, pictures, views)))
    except InputError:
        return ()
