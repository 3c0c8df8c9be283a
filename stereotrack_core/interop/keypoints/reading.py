"""Predicted keypoints from any file or folder that is understood, by what it holds."""

from __future__ import annotations

from collections.abc import Iterator

from stereotrack_core.errors import InputError
from stereotrack_core.interop.deeplabcut import is_deeplabcut
from stereotrack_core.interop.keypoints import (
    arrays,
    coco,
    deeplabcut,
    mmpose,
    openpose,
    sleap,
    table,
)
from stereotrack_core.interop.keypoints.source import FoundKeypoints, KeypointSource, found_in
from stereotrack_core.reading import TABLE_BYTES, read_json
from stereotrack_core.recording.keypoints import Row
from stereotrack_core.tables import read_cells

_UNDERSTOOD = (
    "Supported: a folder of OpenPose, COCO results or annotations (.json), MMPose and RTMPose "
    "(.json), FreeMoCap and MediaPipe (.npy, .csv), DeepLabCut (.csv, .h5), SLEAP (.slp), and "
    f"tables (.csv) with {', '.join(table.COLUMNS[:6])}."
)


def read_keypoints(source: KeypointSource, frames: int | None = None) -> FoundKeypoints:
    """Read what a detector has predicted, and count what is not used.

    Raises InputError where the file cannot be read, is of a kind that is not understood, or names
    no camera of the recording.

    Parameters
    ----------
    frames : int, optional
        Number of frames of the recording, where it is known.

    Examples
    --------
    >>> found = read_keypoints(KeypointSource(Path("openpose"), recording), 200)
    >>> len(found.keypoints), found.summary()
    (13600, '6400 of keypoints that are no part of the body')
    """
    return found_in(source, _rows(source), frames)


def _rows(source: KeypointSource) -> Iterator[Row]:
    path = source.path
    if path.is_dir():
        if not openpose.is_openpose(path):
            raise InputError(
                "the folder holds no *_keypoints.json", where=str(path), remedy=_UNDERSTOOD
            )
        return openpose.read_openpose(source)
    suffix = path.suffix.lower()
    if suffix == ".json":
        return _of_json(source)
    if suffix == ".csv":
        return _of_csv(source)
    read = {".npy": arrays.read_array, ".h5": deeplabcut.read_h5, ".slp": sleap.read_slp}.get(
        suffix
    )
    if read is None:
        raise InputError(
            f"keypoints cannot be read from {suffix or 'files without a suffix'}",
            where=str(path),
            remedy=_UNDERSTOOD,
        )
    return read(source)


def _of_json(source: KeypointSource) -> Iterator[Row]:
    content = read_json(source.path, TABLE_BYTES, _UNDERSTOOD)
    if mmpose.is_mmpose(content):
        return mmpose.read_mmpose(source, content)
    if coco.is_results(content):
        return coco.read_results(source, content)
    return coco.read_annotations(source)


def _of_csv(source: KeypointSource) -> Iterator[Row]:
    lines = read_cells(source.path)
    if is_deeplabcut(lines):
        return deeplabcut.read_csv(source)
    header = lines[0] if lines else []
    if table.is_table(header):
        return table.read_table(source)
    if arrays.is_wide(header):
        return arrays.read_wide(source)
    raise InputError(
        "no keypoints are recognised in the first line",
        where=str(source.path),
        remedy=_UNDERSTOOD,
    )
