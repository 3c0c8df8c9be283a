"""What landmark files of other programs have in common: units, names, frame rate, no gaps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.errors import InputError
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory

_WIDEST_GAP, _MOST_MISSING = 10_000, 100
"""Rows that are filled in at most: so many, and so many for each frame that is known."""

_METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001}


def contiguous(trajectory: LandmarkTrajectory, where: str) -> tuple[int, FloatArray]:
    """First frame, and landmarks (F, 9, 3) of every frame from there on; NaN in the gaps.

    InputError for a trajectory without frames, or with few in a long stretch.
    """
    frame = trajectory.frame
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
    points: FloatArray = np.full((last - first + 1, *trajectory.points.shape[1:]), np.nan)
    points[frame - first] = trajectory.points
    return first, points


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
    metres = _METRES.get(unit)
    if metres is None:
        raise InputError(f"unknown unit {unit!r}", where=where, remedy="Use m or mm.")
    return metres


def landmark_columns(names: Sequence[str], where: str, points: str) -> dict[str, int]:
    """Where each of the nine landmarks stands among a file's names, as far as it does.

    `points` is what the format calls them.

    InputError where none of them does.
    """
    columns = {name: names.index(name) for name in LANDMARKS if name in names}
    if not columns:
        raise InputError(
            "the file contains none of the nine landmarks",
            where=where,
            remedy=f"Name the {points} {', '.join(LANDMARKS)}.",
        )
    return columns
