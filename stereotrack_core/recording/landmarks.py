"""The nine landmarks and trajectories of them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError
from stereotrack_core.recording.toml_table import LARGEST
from stereotrack_core.tables import csv_text, read_rows, whole_number

LANDMARKS: tuple[str, ...] = (
    "left_shoulder",
    "right_shoulder",
    "left_elbow",
    "right_elbow",
    "left_hand",
    "right_hand",
    "head",
    "left_hip",
    "right_hip",
)
"""Left and right are the person's own. Every array of landmarks has this order."""

SKELETON: tuple[tuple[str, str], ...] = (
    ("left_hip", "right_hip"),
    ("left_hip", "left_shoulder"),
    ("right_hip", "right_shoulder"),
    ("left_shoulder", "right_shoulder"),
    ("left_shoulder", "left_elbow"),
    ("left_elbow", "left_hand"),
    ("right_shoulder", "right_elbow"),
    ("right_elbow", "right_hand"),
)
"""Lines to draw between landmarks (the head is drawn from the shoulder midpoint)."""


@dataclass(frozen=True, eq=False)
class LandmarkTrajectory:
    """Landmarks over frames: a reference, or what a run found."""

    frame: IntArray  # (F,), frame numbers of the recording, ascending; need not be contiguous
    points: FloatArray
    """(F, 9, 3), world, metres, in the order of :data:`LANDMARKS`; NaN where not known."""


COLUMNS = ("frame", "landmark", "x", "y", "z")


def read_landmarks(path: Path) -> LandmarkTrajectory:
    """Trajectory in metres, world; values that are missing, empty or NaN are NaN.

    Landmarks besides the nine are ignored (:func:`unknown_landmarks` names them). Raises InputError
    when the file cannot be read, a value is no number, a landmark stands twice in a frame, or none
    of its landmarks is one of the nine.
    """
    found: dict[int, dict[str, list[float]]] = {}
    others = set()
    for line, cells in read_rows(path, COLUMNS):
        frame = whole_number(cells["frame"], path, line, "frame")
        name = cells["landmark"]
        if name not in LANDMARKS:
            others.add(name)
            continue
        at_frame = found.setdefault(frame, {})
        if name in at_frame:
            raise InputError(
                f"line {line} repeats {name} of frame {frame}",
                where=str(path),
                remedy="Delete one of the two lines.",
            )
        at_frame[name] = [_coordinate(cells[axis], path, line, axis) for axis in "xyz"]
    if others and not found:
        raise InputError(
            f"none of its landmarks is known (the first is {min(others)!r})",
            where=str(path),
            remedy=f"The landmarks are {', '.join(LANDMARKS)}.",
        )
    frames = sorted(found)
    points = np.full((len(frames), len(LANDMARKS), 3), np.nan)
    for i, frame in enumerate(frames):
        for name, position in found[frame].items():
            points[i, LANDMARKS.index(name)] = position
    return LandmarkTrajectory(np.array(frames, dtype=np.int64), points)


def unknown_landmarks(path: Path) -> tuple[str, ...]:
    """Names in the file that are none of the nine landmarks."""
    names = {cells["landmark"] for _, cells in read_rows(path, COLUMNS)}
    return tuple(sorted(names - set(LANDMARKS)))


def _coordinate(text: str, path: Path, line: int, axis: str) -> float:
    if not text:
        return float("nan")
    try:
        value = float(text)
        if np.isfinite(value) and abs(value) > LARGEST:
            raise ValueError
    except ValueError:
        raise InputError(
            f"line {line} has {text!r} as {axis}",
            where=str(path),
            remedy="Write metres as a number, or leave the value empty if it is not known.",
        ) from None
    return value if np.isfinite(value) else float("nan")


def write_landmarks(path: Path, trajectory: LandmarkTrajectory) -> None:
    """Write what is known of a trajectory, in micrometres' precision; unknown landmarks get no row.

    A frame of which nothing is known is written as one row with empty values, so that reading
    gives the same frames again.
    """
    write_file(path, csv_text(COLUMNS, _rows(trajectory)))


def _rows(trajectory: LandmarkTrajectory) -> Iterator[list[str | int]]:
    for frame, points in zip(trajectory.frame, trajectory.points, strict=True):
        known = np.isfinite(points).all(axis=1)
        if not known.any():
            yield [int(frame), LANDMARKS[0], "", "", ""]
        for i in np.flatnonzero(known):
            yield [int(frame), LANDMARKS[i], *(f"{value:.6f}" for value in points[i])]
