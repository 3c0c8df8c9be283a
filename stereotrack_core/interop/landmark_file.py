"""What landmark files of other programs have in common: units, names, axes, frame rate, gaps.

Axes of files of other programs: what the file states, and whether the person contradicts it.

A documented statement is followed unless head, shoulders, hips and feet, or the spread of all
markers, speak for another axis. People lie and bend, so that nothing is corrected by it: the file
is refused until the axes are stated.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.errors import Finding, InputError
from stereotrack_core.geometry.upright import Z_UP, Upright
from stereotrack_core.interop.calibrations.foreign import METRES_PER_UNIT, unit_named
from stereotrack_core.recording.landmarks import LandmarkTrajectory

_WIDEST_GAP, _MOST_MISSING = 10_000, 100
"""Rows that are filled in at most: so many, and so many for each frame that is known."""

_AXIS = re.compile(r"([+-]?)([xyz])")


@dataclass(frozen=True, eq=False)
class Stated:
    """What a person says about a file of landmarks, which goes before what it says itself."""

    names: Mapping[str, str] = field(default_factory=dict)  # ours of their names of landmarks
    world_from_file: FloatArray | None = None  # (3, 3): its axes that point east, north, up
    up: Upright = Z_UP
    """The recording's world: landmarks of a file are turned into it if its z does not point up."""

    tilted: bool = False
    """Whether the world may be tilted, so that the person cannot contradict the file's axes."""

    @property
    def about_file(self) -> bool:
        """Whether names or axes are stated."""
        return bool(self.names) or self.world_from_file is not None


def world_from_axes(text: str, where: str = "--axes") -> FloatArray:
    """Rotation (3, 3) from a file's axes as a person types them: those of east, north and up.

    InputError for something else, or for axes that make a mirror image.

    Examples
    --------
    >>> world_from_axes("x,-z,y") @ [1.0, 2.0, 3.0]  # y points up, z to the south
    array([ 1., -3.,  2.])
    """
    rows = [axis_in(part) for part in text.split(",")]
    world_from_file = np.array([row for row in rows if row is not None])
    shape = world_from_file.shape if len(rows) == 3 else ()
    handedness = np.linalg.det(world_from_file) if shape == (3, 3) else 0.0
    if handedness == 0.0:
        remedy = "Give the file's axes that point east, north and up, for example z,x,y or x,-z,y."
        raise InputError(f"{text!r} does not name three axes", where, remedy)
    if handedness < 0.0:
        what = f"the axes {text} make a mirror image of the person"
        raise InputError(what, where, "Change the sign of one of them.")
    return world_from_file


def axis_in(text: str) -> FloatArray | None:
    """Direction (3,) of an axis such as ``+X`` or ``-y``; None where it is none."""
    match = _AXIS.fullmatch(text.strip().lower())
    if match is None:
        return None
    sign = -1.0 if match[1] == "-" else 1.0
    return np.asarray(sign * np.eye(3)["xyz".index(match[2])] + 0.0)  # without -0.0


def world_from_up(up: FloatArray, east: FloatArray | None = None) -> FloatArray:
    """Rotation (3, 3) from a file whose axis `up` (3,) points up, and perhaps `east` (3,) east.

    Without the latter the axes keep their cyclic order: with y up, z points east and x north.
    """
    if east is None or abs(east @ up) > 0.0:
        east = np.roll(up, 1)
    return np.stack([east, np.cross(up, east), up])


def contiguous(trajectory: LandmarkTrajectory, where: str) -> tuple[int, FloatArray]:
    """First frame, and landmarks (F, 9, 3) from there, NaN in gaps; InputError if mostly gaps."""
    frame = trajectory.frame
    if not len(frame):
        raise InputError("there are no frames to write", where, "Track at least one frame.")
    first, last = int(frame[0]), int(frame[-1])
    if last - first > _WIDEST_GAP + _MOST_MISSING * len(frame):
        what = f"the frames range from {first} to {last}, but there are only {len(frame)} of them"
        remedy = "Use .csv or .npz, which allow gaps, or export part of the frames."
        raise InputError(what, where, remedy)
    result: FloatArray = np.full((last - first + 1, *trajectory.points.shape[1:]), np.nan)
    result[frame - first] = trajectory.points
    return first, result


def checked_fps(fps: float) -> float:
    """Frame rate in Hz; InputError unless it is a positive number."""
    if not np.isfinite(fps) or fps <= 0:
        what = f"{fps!r} is not a frame rate"
        raise InputError(what, "fps", "Give a number of frames per second.")
    return float(fps)


def metres_per(unit: str, where: str) -> float:
    """Metres in a unit of length; InputError for a unit that is not known."""
    if (known := unit_named(unit)) is None:
        raise InputError(f"unknown unit {unit!r}", where, f"Use {', '.join(METRES_PER_UNIT)}.")
    return METRES_PER_UNIT[known]


_UPRIGHT = 0.5  # cosine between trunk and up from which it is upright: a lean of up to 60 degrees
_ALONG = 0.85  # cosine between trunk (legs) and an axis from which it points along it: 32 degrees
_SHORTEST, _LONGEST = 0.1, 1.2
"""Length of a trunk, a neck or legs, in metres. Other points tell nothing of a person."""

_LEAST_EXTENT, _LARGEST_EXTENT = 1.0, 2.5
_FLAT, _SLENDER = 0.5, 0.7
"""The markers of a whole body are so long, in metres; along the axis that is stated as up they have
less than `_FLAT` of that, along the third axis less than `_SLENDER`: arms are not spread."""

_MOST_FRAMES = 500


@dataclass(frozen=True, eq=False)
class FileAxes:
    """Rotation (3, 3) from a file's axes to east, north, up, its source, if it is certain."""

    world_from_file: FloatArray
    source: str
    is_certain: bool = False


class AxesContradicted(InputError):
    """The person in a file contradicts what it states about its axes.

    `upright` are the axes if the person is upright, `as_stated` those that the file states.
    """

    def __init__(self, what: str, where: str, upright: str, as_stated: str) -> None:
        self.upright, self.as_stated = upright, as_stated
        super().__init__(
            what,
            where=where,
            remedy="State the axes that point east, north and up: "
            f"--axes {upright} for an upright person, or --axes {as_stated} for a person who lies "
            "or bends. Where a command has no such option, use the .csv that `stereotrack export "
            "--axes` writes.",
        )


def axes_text(world_from_file: FloatArray) -> str:
    """The file's axes that point east, north and up, such as ``x,-z,y``."""
    return ",".join(axis_text(row) for row in world_from_file)


def axis_text(direction: FloatArray) -> str:
    """Name of the axis next to a direction (3,), such as ``-z``."""
    k = int(np.argmax(np.abs(direction)))
    return ("-" if direction[k] < 0.0 else "") + "xyz"[k]


def check_axes(
    axes: FileAxes, directions: Mapping[str, FloatArray], points: FloatArray, where: str
) -> Finding:
    """What is taken for the axes of a file, as a note.

    `directions`: ``trunk`` (F, 3) from the pelvis to the neck and ``legs`` from the feet to the
    pelvis, NaN where not known; `points` (F, N, 3) are all markers; all in the file's axes.

    AxesContradicted where the person contradicts what the file states.
    """
    up = axes.world_from_file[2]
    usual = {name: _usual(vectors) for name, vectors in directions.items()}
    known = {name: one for name, one in usual.items() if one is not None}
    off = {n: np.degrees(np.arccos(np.clip(one @ up, -1.0, 1.0))) for n, one in known.items()}
    seen = [f"{name} {angle:.0f}° from up" for name, angle in off.items()]
    text = f"axes {axes_text(axes.world_from_file)} (east, north, up) {axes.source}"
    found = None if axes.is_certain else _contradiction(up, usual, points)
    if found is None:
        return Finding("note", where, ", ".join([text, *seen]), "")
    what, other = found
    upright = world_from_up(other, axes.world_from_file[0])
    what = f"{axis_text(up)} points up {axes.source}, but {what}"
    raise AxesContradicted(what, where, axes_text(upright), axes_text(axes.world_from_file))


def _usual(vectors: FloatArray) -> FloatArray | None:
    """Unit vector (3,) that vectors (F, 3) usually have; None if it is not a person's."""
    known = vectors[np.isfinite(vectors).all(axis=-1)]
    length = np.linalg.norm(known, axis=-1, keepdims=True)
    if not len(known) or not _SHORTEST < np.median(length) < _LONGEST:
        return None
    median = np.median(known / np.maximum(length, 1e-9), axis=0)
    size = float(np.linalg.norm(median))
    return median / size if size > _UPRIGHT else None


def _contradiction(
    up: FloatArray, usual: Mapping[str, FloatArray | None], points: FloatArray
) -> tuple[str, FloatArray] | None:
    """What speaks against an axis `up`, and the axis (3,) that it speaks for; None if nothing."""
    trunk, legs = usual["trunk"], usual["legs"]
    if trunk is None and legs is None:
        return _by_extents(up, points)
    if legs is not None and legs @ up >= _ALONG:  # who stands may bend
        return None
    direction, what = (trunk, "trunk points") if trunk is not None else (legs, "legs point")
    assert direction is not None  # noqa: S101 - one of them is known
    k = int(np.argmax(np.abs(direction)))
    other = np.sign(direction[k]) * np.eye(3)[k] + 0.0  # without -0.0
    upright = float(direction @ up)
    if upright >= _UPRIGHT or (upright > -_UPRIGHT and direction @ other < _ALONG):
        return None
    return f"the person's {what} along {axis_text(other)}", other


def _by_extents(up: FloatArray, points: FloatArray) -> tuple[str, FloatArray] | None:
    """The same by the extents of all markers, which do not tell up from down."""
    some = points[:: max(1, len(points) // _MOST_FRAMES)]
    some = some[np.isfinite(some).all(axis=-1).any(axis=-1)]
    if not len(some):
        return None
    extents = np.median(np.nanmax(some, axis=1) - np.nanmin(some, axis=1), axis=0)
    longest, vertical = int(np.argmax(extents)), int(np.argmax(np.abs(up)))
    size = extents[longest]
    if longest == vertical or not _LEAST_EXTENT < size < _LARGEST_EXTENT:
        return None
    if extents[vertical] > _FLAT * size or extents[3 - longest - vertical] > _SLENDER * size:
        return None
    return f"the markers extend {size:.1f} m along {'xyz'[longest]}", np.eye(3)[longest]
