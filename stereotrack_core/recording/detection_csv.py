"""Read and write detections as ``frame,view,kind,x,y,z,sigma,confidence``."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.csv_table import LARGEST, csv_text, read_rows
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.detections import DETECTION_KINDS, Detection, Detections

OWN_FILE = "detections.csv"
"""File in a recording's folder that holds what a detector has seen."""

COLUMNS = ("frame", "view", "kind", "x", "y", "z", "sigma", "confidence")


def read_detections(path: Path, recording: Recording) -> Detections:
    """Detections of a recording.

    Without a view x, y, z are metres in the world; with one x, y are pixels of the raw picture
    (the view's reference picture, or that of a camera by its name) and z is empty. A frame may
    have a fraction. An empty confidence is 1; rows with confidence 0 say nothing and are left out.

    Raises
    ------
    InputError
        When the file cannot be read or a row makes no sense.
    """
    known = dict(recording.cameras)
    known |= {view.name: recording.reference_camera(view) for view in recording.views}
    found = (_detection(path, line, cells, known) for line, cells in read_rows(path, COLUMNS))
    kept = (detection for detection in found if detection is not None)
    return Detections(kept, source=str(Path(path).resolve()))


def own_detections(recording: Recording) -> Detections | None:
    """What lies beside a recording as :data:`OWN_FILE`; None where there is nothing.

    Raises
    ------
    InputError
        See :func:`read_detections`.
    """
    path = recording.folder / OWN_FILE
    return read_detections(path, recording) if path.is_file() else None


def _detection(
    path: Path, line: int, cells: dict[str, str], cameras: dict[str, Camera]
) -> Detection | None:
    view, kind = cells["view"], cells["kind"]
    if kind not in DETECTION_KINDS:
        raise InputError(
            f"line {line} has {kind!r} as kind",
            where=str(path),
            remedy=f"Write one of {', '.join(DETECTION_KINDS)}.",
        )
    if view and view not in cameras:
        raise InputError(
            f"line {line} names the view {view!r}, which the recording does not have",
            where=str(path),
            remedy=f"Leave it empty for metres, or write one of {', '.join(cameras)}.",
        )
    confidence = _number(cells, "confidence", path, line) if cells["confidence"] else 1.0
    sigma = _number(cells, "sigma", path, line)
    if not sigma > 0.0 or not 0.0 <= confidence <= 1.0:
        raise InputError(
            f"line {line} has sigma {cells['sigma']!r} and confidence {cells['confidence']!r}",
            where=str(path),
            remedy="Give a sigma above 0 and a confidence from 0 to 1.",
        )
    if view and cells["z"]:
        raise InputError(
            f"line {line} has a view and a z",
            where=str(path),
            remedy="Pixels of a view have no z; metres in the world have no view.",
        )
    time = _number(cells, "frame", path, line)
    place = [_number(cells, axis, path, line) for axis in ("xy" if view else "xyz")]
    if confidence == 0.0:
        return None
    return Detection(time, kind, np.array(place), sigma, confidence, cameras.get(view))


def _number(cells: dict[str, str], column: str, path: Path, line: int) -> float:
    try:
        value = float(cells[column])
        if math.isfinite(value) and abs(value) <= LARGEST:
            return value
    except ValueError:
        pass
    raise InputError(
        f"line {line} has {cells[column]!r} as {column}", where=str(path), remedy="Write a number."
    )


def write_detections(path: Path, detections: Iterable[Detection]) -> None:
    """Write detections, in micrometres' and thousandths of pixels' precision; cameras by name."""
    write_file(path, csv_text(COLUMNS, _rows(detections)))


def _rows(detections: Iterable[Detection]) -> Iterator[list[str | float]]:
    for d in detections:
        place = [f"{value:.6f}" for value in d.position]
        place += [""] * (3 - len(place))
        view = "" if d.camera is None else d.camera.name
        yield [f"{d.time:.6g}", view, d.kind, *place, f"{d.sigma:.6g}", d.confidence]
