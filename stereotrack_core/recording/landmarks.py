"""The nine landmarks and trajectories of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.atomic import write_file
from stereotrack_core.errors import Finding, InputError
from stereotrack_core.recording.frame_times import (
    TIME_COLUMNS,
    at_rate,
    on_frames,
    resampled_note,
    row_times,
    same_rate,
    stated_time,
)
from stereotrack_core.recording.toml_table import LARGEST
from stereotrack_core.tables import csv_text, read_cells, read_rows, whole_number

LANDMARKS: tuple[str, ...] = (
    *("left_shoulder", "right_shoulder", "left_elbow", "right_elbow", "left_hand", "right_hand"),
    *("head", "left_hip", "right_hip"),
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

    frame: IntArray  # (F,), frames since time 0, ascending; need not be contiguous
    points: FloatArray
    """(F, 9, 3), world, metres, in the order of :data:`LANDMARKS`; NaN where not known."""
    fps: float | None = None  # frames per second; without it, frames are the recording's
    notes: tuple[Finding, ...] = ()  # decisions made while reading that the user should know

    def by_name(self) -> dict[str, FloatArray]:
        """Points (F, 3) of each landmark."""
        return {name: self.points[:, i] for i, name in enumerate(LANDMARKS)}

    def at_rate(self, fps: float, where: str) -> LandmarkTrajectory:
        """The trajectory at the frames of a recording of another rate, by time, with a note.

        Unchanged if it states no rate. Landmarks are interpolated linearly, but neither over gaps
        nor beyond the ends. InputError if the rates are too different; `where` names the source.
        """
        if self.fps is None or same_rate(self.fps, fps, self.frame):
            return self
        frame, points = at_rate(self.frame, self.points, self.fps, fps, where)
        notes = (*self.notes, resampled_note(self.fps, fps, where))
        return LandmarkTrajectory(frame, points, fps, notes)


COLUMNS = ("frame", "landmark", "x", "y", "z")
SIGMA_COLUMNS = ("sigma_x", "sigma_y", "sigma_z")  # optional: standard deviations in metres
TEXT_COLUMNS = ("source", "annotator")  # optional: provenance of a place
NUMBER_COLUMNS = ("visibility", "views", "residual_px")  # optional as well


@dataclass(frozen=True, eq=False)
class LandmarkTable:
    """A trajectory, and what its file states about it."""

    trajectory: LandmarkTrajectory
    sigma: FloatArray | None = None  # (F, 9, 3), metres, along the axes; also of unknown landmarks
    texts: Mapping[str, NDArray[np.str_]] = field(default_factory=dict)
    """(F, 9) of those of :data:`TEXT_COLUMNS` that there are; empty where not known."""
    numbers: Mapping[str, FloatArray] = field(default_factory=dict)
    """(F, 9) of those of :data:`NUMBER_COLUMNS` that there are; NaN where not known."""


def read_landmarks(path: Path) -> LandmarkTrajectory:
    """The trajectory of :func:`read_landmark_table` alone."""
    return read_landmark_table(path).trajectory


def read_landmark_table(path: Path) -> LandmarkTable:
    """Trajectory in metres, world; values that are missing, empty or NaN are NaN.

    A column ``time`` in seconds may follow, which goes before the frame numbers; see
    :func:`.frame_times.row_times`. Landmarks besides the nine are ignored
    (:func:`unknown_landmarks` names them). Raises InputError when the file cannot be read, a value
    is no number, a landmark stands twice in a frame, or none of its landmarks is one of the nine.
    """
    header = next(iter(read_cells(path)), [])
    stated = set(SIGMA_COLUMNS) <= set(header)
    texts = [name for name in TEXT_COLUMNS if name in header]
    numbers = [name for name in NUMBER_COLUMNS if name in header]
    values = ["x", "y", "z", *(SIGMA_COLUMNS if stated else ()), *numbers]
    found: dict[int, dict[str, list[float]]] = {}
    said: dict[tuple[int, str], list[str]] = {}
    times: dict[int, float] = {}
    others = set()
    for line, cells in read_rows(path, COLUMNS, optional=(*values, *texts, *TIME_COLUMNS)):
        frame = whole_number(cells["frame"], path, line, "frame")
        name = cells["landmark"]
        if name not in LANDMARKS:
            others.add(name)
            continue
        at_frame = found.setdefault(frame, {})
        if name in at_frame:
            what = f"line {line} repeats {name} of frame {frame}"
            raise InputError(what, path, "Delete one of the two lines.")
        at_frame[name] = [_coordinate(cells[column], path, line, column) for column in values]
        said[frame, name] = [cells.get(column, "") for column in texts]
        times.setdefault(frame, stated_time(cells, path, line))
    if others and not found:
        what = f"none of its landmarks is known (the first is {min(others)!r})"
        raise InputError(what, path, f"The landmarks are {', '.join(LANDMARKS)}.")
    frames = sorted(found)
    table = np.full((len(frames), len(LANDMARKS), len(values)), np.nan)
    for i, frame in enumerate(frames):
        for name, position in found[frame].items():
            table[i, LANDMARKS.index(name)] = position
    number, time = np.array(frames, dtype=np.int64), np.array([times[one] for one in frames])
    rows, where = row_times(number, time, None, str(path)), str(path)
    taken, points = on_frames(rows, table[..., :3], where)
    nearest = rows.nearest(taken) if frames else []
    at = [frames[k] for k in nearest]
    return LandmarkTable(
        LandmarkTrajectory(taken, points, rows.fps, rows.notes),
        on_frames(rows, table[..., 3:6], where)[1] if stated else None,
        {name: _texts(said, i, at) for i, name in enumerate(texts)},
        {name: table[nearest, :, i - len(numbers)] for i, name in enumerate(numbers)},
    )


def _texts(
    said: Mapping[tuple[int, str], Sequence[str]], column: int, frames: Sequence[int]
) -> NDArray[np.str_]:
    """Texts (F, 9) of a column; empty where the file has no line."""
    cells = [said[k, n][column] if (k, n) in said else "" for k in frames for n in LANDMARKS]
    return np.array(cells, dtype=np.str_).reshape(-1, len(LANDMARKS))


def unknown_landmarks(path: Path) -> tuple[str, ...]:
    """Names in the file that are none of the nine landmarks."""
    names = {cells["landmark"] for _, cells in read_rows(path, COLUMNS)}
    return tuple(sorted(names - set(LANDMARKS)))


def _coordinate(text: str, path: Path, line: int, axis: str) -> float:
    if not text:
        return float("nan")
    try:
        value = float(text.replace(",", "."))
        if np.isfinite(value) and abs(value) > LARGEST:
            raise ValueError
    except ValueError:
        remedy = "Write metres as a number, or leave the value empty if it is not known."
        raise InputError(f"line {line} has {text!r} as {axis}", path, remedy) from None
    return value if np.isfinite(value) else float("nan")


def write_landmarks(path: Path, trajectory: LandmarkTrajectory) -> None:
    """Write what is known, to a micrometre; a frame of which nothing is known gets an empty row."""
    write_landmark_table(path, LandmarkTable(trajectory))


def write_landmark_table(path: Path, table: LandmarkTable) -> None:
    """Write a trajectory and what is stated; with sigmas, unknown landmarks have empty places."""
    columns = list(COLUMNS)
    if table.sigma is not None:
        columns += SIGMA_COLUMNS
    columns += [*table.texts, *table.numbers]
    write_file(path, csv_text(columns, _rows(table)))


def _rows(table: LandmarkTable) -> Iterator[list[str | int]]:
    known = np.asarray(np.isfinite(table.trajectory.points).all(axis=2))
    whole = table.sigma is not None or "annotator" in table.texts
    for row, frame in enumerate(table.trajectory.frame):
        written = range(len(LANDMARKS)) if whole else np.flatnonzero(known[row])
        for i in written if len(written) else (0,):
            place = table.trajectory.points[row, i]
            numbers = [place if known[row, i] else np.full(3, np.nan)]
            numbers += [] if table.sigma is None else [table.sigma[row, i]]
            cells = ["" if np.isnan(value) else f"{value:.6f}" for value in np.concatenate(numbers)]
            said = [str(array[row, i]) for array in table.texts.values()]
            more = [array[row, i] for array in table.numbers.values()]
            said += ["" if np.isnan(value) else f"{round(value, 3):g}" for value in more]
            yield [int(frame), LANDMARKS[i], *cells, *said]
