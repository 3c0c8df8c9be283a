"""Predicted keypoints from any file or folder that is understood, by what it holds."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from stereotrack_core.errors import InputError
from stereotrack_core.interop import deeplabcut
from stereotrack_core.interop.hdf5 import read_hdf5
from stereotrack_core.interop.keypoints import arrays, json_files, label_tools, table
from stereotrack_core.interop.keypoints.source import (
    FileRow,
    FoundKeypoints,
    KeypointSource,
    found_in,
)
from stereotrack_core.reading import TABLE_BYTES, decoding, read_json
from stereotrack_core.tables import read_cells

_NO_HDF5 = "this is not a DeepLabCut file or an analysis of SLEAP"
_UNDERSTOOD = (
    "Supported: a folder of OpenPose, COCO results or annotations (.json), MMPose and RTMPose "
    "(.json), FreeMoCap and MediaPipe (.npy, .csv, .json), DeepLabCut (.csv, .h5), SLEAP (.slp, "
    f"analysis .h5), and tables (.csv) with {', '.join(table.COLUMNS[:6])}."
)

KEYPOINT_SUFFIXES = (".csv", ".h5", ".json", ".npy", ".slp")  # files that `read_keypoints` reads


def read_keypoints(source: KeypointSource, frames: int | None = None) -> FoundKeypoints:
    """Read what a detector has predicted, and count what is not used.

    `frames` is their number in the recording, where it is known. Raises InputError where the file
    cannot be read, is of a kind that is not understood, or names no camera of the recording.

    Examples
    --------
    >>> found = read_keypoints(KeypointSource(Path("openpose"), recording), 200)
    >>> len(found.keypoints), found.summary()
    (13600, '6400 of keypoints that are no part of the body')
    """
    rows, notes = table.at_stated_times(_rows(source), source.path, source.recording.fps)
    found = found_in(source, rows, frames)
    return replace(found, notes=(*notes, *found.notes))


def _rows(source: KeypointSource) -> Iterator[FileRow]:
    path = source.path
    if path.is_dir():
        return json_files.read_openpose(source)
    suffix = path.suffix.lower()
    read = {
        ".json": _of_json,
        ".csv": _of_csv,
        ".npy": arrays.read_array,
        ".h5": _of_hdf5,
        ".slp": label_tools.read_slp,
    }.get(suffix)
    if read is None:
        what = f"keypoints cannot be read from {suffix or 'files without a suffix'}"
        raise InputError(what, where=str(path), remedy=_UNDERSTOOD)
    return read(source)


def _of_json(source: KeypointSource) -> Iterator[FileRow]:
    content = read_json(source.path, TABLE_BYTES, _UNDERSTOOD)
    if json_files.is_openpose(content):
        return json_files.read_openpose(source)
    if json_files.is_mediapipe(content):
        return json_files.read_mediapipe(source, content)
    if json_files.is_mmpose(content):
        return json_files.read_mmpose(source, content)
    if json_files.is_results(content):
        return json_files.read_results(source, content)
    return json_files.read_annotations(source)


def _of_hdf5(source: KeypointSource) -> Iterator[FileRow]:
    deeplabcut.check_h5py(source.path)
    found = read_hdf5(source.path, _stored_hdf5, _NO_HDF5, _UNDERSTOOD)
    if isinstance(found, deeplabcut.StoredTable):
        return label_tools.read_deeplabcut(source, deeplabcut.table_of_stored(source.path, found))
    return label_tools.rows_of_analysis(found, source)


def _stored_hdf5(path: Path) -> deeplabcut.StoredTable | label_tools.Analysis:
    """What an HDF5 file holds; called in a process of its own."""
    import h5py

    with decoding(path, _NO_HDF5, _UNDERSTOOD), h5py.File(path) as stored:
        if {"tracks", "node_names", "track_names"} <= set(stored):
            return label_tools.stored_analysis(stored, path)
        return deeplabcut.table_in(stored)


def _of_csv(source: KeypointSource) -> Iterator[FileRow]:
    lines = read_cells(source.path)
    if deeplabcut.is_deeplabcut(lines):
        stored = deeplabcut.read_table(source.path, label_tools.DEEPLABCUT_REMEDY)
        return label_tools.read_deeplabcut(source, stored)
    header = lines[0] if lines else []
    if table.is_table(header):
        return table.read_table(source)
    if arrays.wide_columns(header):
        return arrays.read_wide(source)
    what = "no keypoints are recognised in the first line"
    raise InputError(what, where=str(source.path), remedy=_UNDERSTOOD)
