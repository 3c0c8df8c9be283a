"""References with their uncertainty as NumPy's ``.npz``: files, and what projects keep."""

import io
import json
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from stereotrack_core.annotation.reference import Reference
from stereotrack_core.atomic import write_file
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.errors import InputError
from stereotrack_core.interop.npz import ArchiveFormat, ArrayLayout, archive_bytes, array_names
from stereotrack_core.plain_data import Kind, check_kind
from stereotrack_core.reading import MB, open_file, parsed_json
from stereotrack_core.recording import landmarks
from stereotrack_core.tables import LARGEST as LAST_FRAME

_LAYOUT: dict[str, ArrayLayout] = {
    "frame": ArrayLayout("i", ("F",)),
    "points": ArrayLayout("f", ("F", "n", 3)),
    "landmark_names": ArrayLayout("U", ("n",)),
    "meta": ArrayLayout("U", ()),
    "covariance": ArrayLayout("f", ("F", "n", 3, 3), optional=True),
    "limb_sigma_deg": ArrayLayout("f", ("F", len(LIMBS)), optional=True),
    "filled": ArrayLayout("b", ("F",), optional=True),
}

_META: Kind = {
    "fps": float,
    "sigma_factor": float,
    "recording_folder": str,
    "outliers": [[int, str, str, float]],
}

_FILE = ArchiveFormat(
    "reference of this program",
    "Use an .npz file written by `stereotrack fit` or the workbench.",
    _LAYOUT,
)
_MOST_BYTES = 4096 * MB
_FARTHEST = 1e6  # metres


def write_reference(path: Path, reference: Reference) -> None:
    """Write a reference with everything that it states; InputError where that cannot be done."""
    write_file(path, reference_bytes(reference))


def write_reference_table(path: Path, reference: Reference) -> None:
    """Write the nine landmarks as ``.csv``, with sigmas and sources; see :func:`write_file`."""
    sigma = source = None
    if reference.covariance is not None:
        variances = np.diagonal(reference.covariance, axis1=2, axis2=3)
        sigma = reference.of_the_nine(np.sqrt(np.maximum(variances, 0.0)))
    if reference.filled is not None:
        source = tuple("interpolated" if one else "fit" for one in reference.filled)
    trajectory = reference.trajectory(np.inf)
    landmarks.write_landmark_table(path, landmarks.LandmarkTable(trajectory, sigma, source))


def read_reference_table(path: Path) -> Reference:
    """The reference of a ``.csv``, its covariances diagonal; InputError where it cannot be read."""
    table = landmarks.read_landmark_table(path)
    covariance = None if table.sigma is None else table.sigma[..., None] ** 2 * np.eye(3)
    filled = None
    if table.source is not None:
        filled = np.array([one == "interpolated" for one in table.source], dtype=np.bool_)
    trajectory, meta = table.trajectory, dict[str, Any](imported_from=path.name)
    if trajectory.fps is not None:
        meta["fps"] = trajectory.fps
    return Reference(
        trajectory.frame, trajectory.points, covariance, filled=filled, meta=meta,
        notes=trajectory.notes,
    )  # fmt: skip


def read_reference(path: Path) -> Reference:
    """Read a reference; InputError for a file that is missing, damaged or no reference."""
    with open_file(path, _MOST_BYTES) as file:
        return _reference_in(file, str(path))


def is_reference(path: Path) -> bool:
    """Whether an ``.npz`` file holds a reference (a run has other arrays); False for no file."""
    needed = {name for name, own in _LAYOUT.items() if not own.optional}
    try:
        with open_file(path, _MOST_BYTES) as file:
            return needed <= array_names(file)
    except InputError:
        return False


def reference_bytes(reference: Reference) -> bytes:
    """The content of a reference's file."""
    arrays: dict[str, Any] = {
        "frame": reference.frame,
        "points": reference.points,
        "landmark_names": np.array(reference.landmark_names, dtype=np.str_),
        "meta": np.array(json.dumps(dict(reference.meta))),
    }
    for key, own in _LAYOUT.items():
        if own.optional and (array := getattr(reference, key)) is not None:
            arrays[key] = array
    return archive_bytes(arrays)


def reference_of_bytes(data: bytes, where: str) -> Reference:
    """The reference that is the content of a file; InputError where it is none."""
    return _reference_in(io.BytesIO(data), where)


def _reference_in(file: BinaryIO, where: str) -> Reference:
    arrays = _FILE.read(file, where)
    frame, points = arrays["frame"], arrays["points"]
    if len(frame) and (frame[0] < 0 or frame[-1] > LAST_FRAME or (abs(points) > _FARTHEST).any()):
        raise _FILE.refusal(where, "numbers are too large")
    with _FILE.decoding(where):
        meta: dict[str, Any] = parsed_json(str(arrays["meta"]), f"{where}, meta")
        check_kind(meta, _META, f"{where}, meta", _FILE.remedy)
        return Reference(
            frame=frame.astype(np.int64),
            points=points,
            covariance=arrays.get("covariance"),
            limb_sigma_deg=arrays.get("limb_sigma_deg"),
            filled=arrays.get("filled"),
            landmark_names=tuple(str(one) for one in arrays["landmark_names"]),
            meta=meta,
        )
