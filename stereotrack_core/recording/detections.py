"""Detections of head and hands, at any time."""

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.description import Recording
from stereotrack_core.tables import finite_number, read_rows

HEAD, LEFT_HAND, RIGHT_HAND, HAND = "head", "left_hand", "right_hand", "hand"

_DETECTION_KINDS: tuple[str, ...] = (HEAD, LEFT_HAND, RIGHT_HAND, HAND)
"""Kinds of detections; ``hand`` if the side is not known."""


@dataclass(frozen=True, eq=False)
class Detection:
    """One detected landmark, in space or in the picture of one camera."""

    time: float  # in frames of the recording: 12.5 is half-way between frames 12 and 13
    kind: str  # one of ``_DETECTION_KINDS``
    position: FloatArray
    """(3,) or (2,) float64; world, metres; or, with a camera, column and row of its raw picture."""
    sigma: float  # standard deviation of each number of `position`, in its unit
    confidence: float = 1.0  # from 0 (exclusive) to 1; the variance is divided by it
    camera: Camera | None = None


class Detections:
    """Detections in the order of their times; `source` is their file, empty where there is none."""

    def __init__(self, detections: Iterable[Detection] = (), source: str = "") -> None:
        self.source = source
        self._all = tuple(sorted(detections, key=lambda detection: detection.time))
        self._times = np.array([detection.time for detection in self._all])

    def __len__(self) -> int:
        return len(self._all)

    def fingerprint(self) -> str:
        """Hash (32 hexadecimal digits) of all that they say."""
        digest = hashlib.blake2b(digest_size=16)
        for d in self._all:
            camera = "" if d.camera is None else d.camera.name
            numbers = [d.time, d.sigma, d.confidence, *d.position.tolist()]
            digest.update(f"{d.kind} {camera} {numbers!r}\n".encode())
        return digest.hexdigest()

    def until(self, frame: int) -> tuple[Detection, ...]:
        """All that came after frame `frame` - 1, up to and with frame `frame`."""
        first, end = np.searchsorted(self._times, [frame - 1, frame], side="right")
        return self._all[first:end]


OWN_FILE = "detections.csv"  # file in a recording's folder that holds what a detector has seen

COLUMNS = ("frame", "view", "kind", "x", "y", "z", "sigma", "confidence")


def read_detections(path: Path, recording: Recording) -> Detections:
    """Detections of a recording.

    Without a view x, y, z are metres in the world; with one x, y are pixels of the raw picture (the
    view's reference picture, or that of a camera by its name) and z is empty. A frame may have a
    fraction. An empty confidence is 1; rows with confidence 0 say nothing and are left out. Raises
    InputError when the file cannot be read or a row makes no sense.
    """
    known = dict(recording.cameras)
    known |= {view.name: recording.reference_camera(view) for view in recording.views}
    found = (_detection(path, line, cells, known) for line, cells in read_rows(path, COLUMNS))
    kept = (detection for detection in found if detection is not None)
    return Detections(kept, source=str(Path(path).resolve()))


def own_detections(recording: Recording) -> Detections | None:
    """Detections beside a recording, None without the file; InputError: :func:`read_detections`."""
    path = recording.folder / OWN_FILE
    return read_detections(path, recording) if path.is_file() else None


def _detection(
    path: Path, line: int, cells: dict[str, str], cameras: dict[str, Camera]
) -> Detection | None:
    view, kind = cells["view"], cells["kind"]
    if kind not in _DETECTION_KINDS:
        remedy = f"Write one of {', '.join(_DETECTION_KINDS)}."
        raise InputError(f"line {line} has {kind!r} as kind", path, remedy)
    if view and view not in cameras:
        what = f"line {line} names the view {view!r}, which the recording does not have"
        remedy = f"Leave it empty for metres, or write one of {', '.join(cameras)}."
        raise InputError(what, path, remedy)
    stated = cells["confidence"] or "1"
    confidence = finite_number(stated, path, line, "confidence")
    sigma = finite_number(cells["sigma"], path, line, "sigma")
    if not sigma > 0.0 or not 0.0 <= confidence <= 1.0:
        what = f"line {line} has sigma {cells['sigma']!r} and confidence {cells['confidence']!r}"
        raise InputError(what, path, "Give a sigma above 0 and a confidence from 0 to 1.")
    if view and cells["z"]:
        remedy = "Positions in pixels have no z; positions in metres have no view."
        raise InputError(f"line {line} has both a view and a z", path, remedy)
    time = finite_number(cells["frame"], path, line, "frame")
    place = [finite_number(cells[axis], path, line, axis) for axis in ("xy" if view else "xyz")]
    if confidence == 0.0:
        return None
    return Detection(time, kind, np.array(place), sigma, confidence, cameras.get(view))
