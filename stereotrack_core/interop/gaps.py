"""Trajectories for formats that know no gaps between frames."""

from __future__ import annotations

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.errors import InputError
from stereotrack_core.recording.landmarks import LandmarkTrajectory

_WIDEST_GAP, _MOST_MISSING = 10_000, 100
"""Rows that are filled in at most: so many, and so many for each frame that is known."""


def contiguous(trajectory: LandmarkTrajectory, where: str) -> tuple[int, FloatArray]:
    """First frame, and landmarks (F, 9, 3) of every frame from there on; NaN in the gaps.

    Raises
    ------
    InputError
        For a trajectory without frames, or with few in a long stretch.
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
    """Frame rate in Hz.

    Raises
    ------
    InputError
        Unless it is a positive number.
    """
    if not np.isfinite(fps) or fps <= 0:
        raise InputError(
            f"{fps!r} is not a frame rate",
            where="fps",
            remedy="Give a number of frames per second.",
        )
    return float(fps)
