"""Predicted keypoints from any file or folder that is understood, by what it holds; tables of ours.

A table of this program is ``frame,view,keypoint,x,y,confidence``. Columns ``person`` (number or
name) and ``source`` may follow; a column ``landmark`` may stand for ``keypoint`` and ``camera`` for
``view``. A view means its reference picture. Pixels are those of raw pictures. Times that rows
state go before frame numbers.
"""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from stereotrack_core import tables
from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError
from stereotrack_core.interop import deeplabcut, sleap
from stereotrack_core.interop.keypoints import arrays, json_files
from stereotrack_core.interop.keypoints.source import (
    FileRow,
    FoundKeypoints,
    KeypointSource,
    Who,
    found_in,
)
from stereotrack_core.interop.label_source import PicturePlaces, checked_frame
from stereotrack_core.limited_process import read_apart
from stereotrack_core.reading import TABLE_BYTES, decoding, read_json
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.frame_times import TIME_COLUMNS, row_times, same_rate, stated_time
from stereotrack_core.recording.keypoints import Keypoints, rows_of
from stereotrack_core.tables import read_cells

COLUMNS = ("frame", "view", "keypoint", "x", "y", "confidence", "person", "source")
_NEEDED = (("frame",), ("view", "camera"), ("keypoint", "landmark"), ("x",), ("y",))


def read_table(source: KeypointSource) -> Iterator[FileRow]:
    """Rows of a table; InputError where it cannot be read or names no camera of the recording."""
    path, header = source.path, tables.read_cells(source.path)[0]
    there = ([name for name in names if name in header] for names in _NEEDED)
    frame, view, keypoint, x, y = (names[0] for names in there)
    others = [name for name in COLUMNS[5:] if name in header]
    lines = list(tables.read_rows(path, (frame, view, keypoint, x, y, *others)))
    places = PicturePlaces(source, [f"{cells[view]}/*" for _, cells in lines])
    cameras: dict[str, str | None] = {}
    for line, cells in lines:
        if (name := cells[view]) not in cameras:
            cameras[name] = places.camera(f"{name}/*", f"{path}, line {line}")
        if (camera := cameras[name]) is None:
            continue
        sure, person, told = (cells.get(name, "") for name in COLUMNS[5:])
        yield (
            checked_frame(
                tables.whole_number(cells[frame], path, line, frame), where=f"{path}, line {line}"
            ),
            camera,
            cells[keypoint],
            tables.number_or_nan(cells[x], path, line, x),
            tables.number_or_nan(cells[y], path, line, y),
            tables.finite_number(sure, path, line, "confidence") if sure else 1.0,
            source.detector or told or source.name,
            Who(0, person.strip()),
        )


def write_table(path: Path, keypoints: Keypoints, recording: Recording) -> None:
    """Write keypoints so that :func:`read_table` gives them again, to a thousandth of a pixel."""
    views = {view.image.camera: view.name for view in recording.views}
    rows = (
        (frame, views.get(camera, camera), name, f"{x:.3f}", f"{y:.3f}", sure, person, told)
        for frame, camera, name, x, y, sure, told, person in rows_of(keypoints)
    )
    write_file(path, tables.csv_text(COLUMNS, rows))


_ROUNDED = 1e-3  # frames by which times may be rounded


def at_stated_times(
    rows: Iterable[FileRow], path: Path, fps: float
) -> tuple[Iterator[FileRow], tuple[str, ...]]:
    """Rows of a file at the frames of a recording of that rate, and decisions, as clauses.

    The times of a table (.csv) go before its frame numbers. Of a table of another rate, each frame
    has the nearest row, at most half a frame of either rate away; others are left out.
    """
    times = _times(path) if path.suffix.lower() == ".csv" else {}
    number = np.array(sorted(times), dtype=np.int64)
    stated = row_times(number, np.array([times[one] for one in number.tolist()]), None, str(path))
    notes = tuple(f"{note.what}. {note.remedy.rstrip('.')}" for note in stated.notes)
    if stated.fps is None or len(number) < 2:
        return iter(rows), notes
    position = stated.position
    if not same_rate(stated.fps, fps, number):
        position = position * (fps / stated.fps)
        notes += (
            f"it has {stated.fps:.6g} frames per second, the recording {fps:.6g}: each frame has "
            "the row that is nearest in time",
        )
    frame = np.rint(position).astype(np.int64)
    away = abs(position - frame)
    nearest: dict[int, int] = {}
    for k in np.argsort(away, kind="stable").tolist():
        if away[k] <= 0.5 * min(1.0, fps / stated.fps) + _ROUNDED:
            nearest.setdefault(int(frame[k]), k)
    kept = {int(number[k]): at for at, k in nearest.items()}
    placed = ((kept.get(row[0], row[0]), *row[1:]) for row in rows
              if row[0] in kept or row[0] not in times)  # fmt: skip
    return placed, notes


def _times(path: Path) -> dict[int, float]:
    """Seconds by frame number, or by row if there are no numbers; empty without times."""
    lines = tables.read_cells(path)
    header = lines[0] if lines else []
    if not any(name in header for name in TIME_COLUMNS):
        return {}
    found: dict[int, float] = {}
    filled = [(line, cells) for line, cells in enumerate(lines[1:], start=2) if any(cells)]
    for row, (line, values) in enumerate(filled):
        cells = dict(zip(header, values, strict=False))
        frame = (
            tables.whole_number(cells["frame"], path, line, "frame") if "frame" in cells else row
        )
        found.setdefault(frame, stated_time(cells, path, line))
    return found


_DEEPLABCUT = "Use a .csv file written by DeepLabCut's analyze_videos; write a damaged one again."
_NO_HDF5 = "this is not a DeepLabCut file or an analysis of SLEAP"
_UNDERSTOOD = (
    "Supported: a folder of OpenPose, COCO results or annotations (.json), MMPose and RTMPose "
    "(.json), FreeMoCap and MediaPipe (.npy, .csv, .json), DeepLabCut (.csv, .h5), SLEAP (.slp, "
    f"analysis .h5), and tables (.csv) with {', '.join(COLUMNS[:6])}."
)

KEYPOINT_SUFFIXES = (".csv", ".h5", ".json", ".npy", ".slp")  # files that `read_keypoints` reads


def read_keypoints(source: KeypointSource, frames: int | None = None) -> FoundKeypoints:
    """Read what a detector has predicted, and count what is not used.

    `frames` is their number in the recording, where it is known. Raises InputError where the file
    cannot be read, is of a kind that is not understood, or names no camera of the recording.
    """
    rows, notes = at_stated_times(_rows(source), source.path, source.recording.fps)
    found = found_in(source, rows, frames)
    return replace(found, notes=(*notes, *found.notes))


def _rows(source: KeypointSource) -> Iterator[FileRow]:
    path = source.path
    if path.is_dir():
        return json_files.read_openpose(source)
    suffix = path.suffix.lower()
    if suffix == ".json":
        return json_files.read_json_rows(source, read_json(path, TABLE_BYTES, _UNDERSTOOD))
    read = {
        ".csv": _of_csv,
        ".npy": arrays.read_array,
        ".h5": _of_hdf5,
        ".slp": sleap.read_predictions,
    }.get(suffix)
    if read is None:
        what = f"keypoints cannot be read from {suffix or 'files without a suffix'}"
        raise InputError(what, path, _UNDERSTOOD)
    return read(source)


def _of_hdf5(source: KeypointSource) -> Iterator[FileRow]:
    deeplabcut.check_hdf5(source.path)
    found = read_apart(_stored_hdf5, source.path, _UNDERSTOOD)
    if isinstance(found, deeplabcut.DeepLabCutTable):
        return deeplabcut.predictions_of(source, found)
    return sleap.rows_of_analysis(found, source)


def _stored_hdf5(path: Path) -> deeplabcut.DeepLabCutTable | sleap.Analysis:
    """What an HDF5 file holds; called in a process of its own."""
    import h5py

    with decoding(path, _NO_HDF5, _UNDERSTOOD), h5py.File(path) as stored:
        if {"tracks", "node_names", "track_names"} <= set(stored):
            return sleap.stored_analysis(stored, path)
        return deeplabcut.table_in(stored, path)


def _of_csv(source: KeypointSource) -> Iterator[FileRow]:
    lines = read_cells(source.path)
    if deeplabcut.is_deeplabcut(lines):
        stored = deeplabcut.read_table(source.path, _DEEPLABCUT)
        return deeplabcut.predictions_of(source, stored)
    header = lines[0] if lines else []
    if all(any(name in header for name in names) for names in _NEEDED):
        return read_table(source)
    if arrays.wide_columns(header):
        return arrays.read_wide(source)
    raise InputError("no keypoints are recognised in the first line", source.path, _UNDERSTOOD)
