"""What landmark files of other programs have in common: units, names, axes, frame rate, gaps."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.upright import Z_UP, Upright
from stereotrack_core.recording.landmarks import LandmarkTrajectory

_WIDEST_GAP, _MOST_MISSING = 10_000, 100
"""Rows that are filled in at most: so many, and so many for each frame that is known."""

_METRES = {
    **dict.fromkeys(("m", "meter", "meters", "metre", "metres"), 1.0),
    "cm": 0.01,
    **dict.fromkeys(("mm", "millimeter", "millimeters", "millimetre", "millimetres"), 0.001),
}

_AXIS = re.compile(r"([+-]?)([xyz])")


@dataclass(frozen=True, eq=False)
class Stated:
    """What a person says about a file of landmarks, which goes before what it says itself."""

    names: Mapping[str, str] = field(default_factory=dict)
    """Ours of their names of landmarks."""
    world_from_file: FloatArray | None = None
    """(3, 3): which of the file's axes point east, north and up."""
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
        raise InputError(
            f"{text!r} does not name three axes",
            where=where,
            remedy="Give the file's axes that point east, north and up, for example z,x,y or "
            "x,-z,y.",
        )
    if handedness < 0.0:
        raise InputError(
            f"the axes {text} make a mirror image of the person",
            where=where,
            remedy="Change the sign of one of them.",
        )
    return world_from_file


def axis_in(text: str) -> FloatArray | None:
    """Direction (3,) of an axis such as ``+X`` or ``-y``; None where it is none."""
    match = _AXIS.fullmatch(text.strip().lower())
    if match is None:
        return None
    axis: FloatArray = np.zeros(3)
    axis["xyz".index(match[2])] = -1.0 if match[1] == "-" else 1.0
    return axis


def world_from_up(up: FloatArray, east: FloatArray | None = None) -> FloatArray:
    """Rotation (3, 3) from a file whose axis `up` (3,) points up, and perhaps `east` (3,) east.

    Without the latter the axes keep their cyclic order: with y up, z points east and x north.
    """
    if east is None or abs(east @ up) > 0.0:
        east = np.roll(up, 1)
    return np.stack([east, np.cross(up, east), up])


def contiguous(trajectory: LandmarkTrajectory, where: str) -> tuple[int, FloatArray]:
    """First frame, and landmarks (F, 9, 3) of every frame from there on; NaN in the gaps.

    InputError for a trajectory without frames, or with few in a long stretch.
    """
    return every_frame(trajectory.frame, trajectory.points, where)


def every_frame(frame: IntArray, values: FloatArray, where: str) -> tuple[int, FloatArray]:
    """The same for values (F, ...) of any kind."""
    if not len(frame):
        raise InputError(
            "there are no frames to write", where=where, remedy="Track at least one frame."
        )
    first, last = int(frame[0]), int(frame[-1])
    if last - first > _WIDEST_GAP + _MOST_MISSING * len(frame):
        raise InputError(
            f"the frames range from {first} to {last}, but there are only {len(frame)} of them",
            where=where,
            remedy="Use .csv or .npz, which allow gaps, or export part of the frames.",
        )
    result: FloatArray = np.full((last - first + 1, *values.shape[1:]), np.nan)
    result[frame - first] = values
    return first, result


def held(values: FloatArray, unknown: BoolArray) -> FloatArray:
    """Values (F, K, ...) of which unknown ones (F, K) are as they were last (or first) known.

    For formats that cannot leave a value out. What is never known stays as it is.
    """
    result = values.copy()
    for k in range(unknown.shape[1]):
        known = np.flatnonzero(~unknown[:, k])
        if len(known):
            last = np.searchsorted(known, np.arange(len(values)), side="right") - 1
            result[:, k] = values[known[np.maximum(last, 0)], k]
    return result


def checked_fps(fps: float) -> float:
    """Frame rate in Hz; InputError unless it is a positive number."""
    if not np.isfinite(fps) or fps <= 0:
        raise InputError(
            f"{fps!r} is not a frame rate",
            where="fps",
            remedy="Give a number of frames per second.",
        )
    return float(fps)


def metres_per(unit: str, where: str) -> float:
    """Metres in a unit of length; InputError for a unit that is not known."""
    metres = _METRES.get(unit.lower())
    if metres is None:
        raise InputError(f"unknown unit {unit!r}", where=where, remedy="Use m, cm or mm.")
    return metres
