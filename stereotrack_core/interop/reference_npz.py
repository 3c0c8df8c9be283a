"""References with their uncertainty as NumPy's ``.npz``: files, and what projects keep."""

import io
import json
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from stereotrack_core.annotation.fit.results import INTERPOLATED
from stereotrack_core.annotation.provenance import FITTED, Provenance
from stereotrack_core.annotation.reference import Reference
from stereotrack_core.arrays import FloatArray
from stereotrack_core.atomic import write_file
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.errors import InputError
from stereotrack_core.interop.npz import ArchiveFormat, ArrayLayout, archive_bytes, array_names
from stereotrack_core.plain_data import Kind, check_kind
from stereotrack_core.reading import MB, open_file, parsed_json
from stereotrack_core.recording import landmarks
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.tables import LARGEST as LAST_FRAME

_LAYOUT: dict[str, ArrayLayout] = {
    "frame": ArrayLayout("i", ("F",)),
    "points": ArrayLayout("f", ("F", "n", 3)),
    "landmark_names": ArrayLayout("U", ("n",)),
    "meta": ArrayLayout("U", ()),
    "covariance": ArrayLayout("f", ("F", "n", 3, 3), optional=True),
    "limb_sigma_deg": ArrayLayout("f", ("F", len(LIMBS)), optional=True),
    "filled": ArrayLayout("b", ("F",), optional=True),
    **{name: ArrayLayout("U", ("F", "n"), optional=True) for name in landmarks.TEXT_COLUMNS},
    **{name: ArrayLayout("f", ("F", "n"), optional=True) for name in landmarks.NUMBER_COLUMNS},
}
"""The last five are the provenance of landmarks."""

_META: Kind = {"fps": float, "sigma_factor": float, "recording_folder": str}
_META["outliers"] = [[int, str, str, float]]

_REMEDY = "Use an .npz file written by `stereotrack fit` or the workbench."
_FILE = ArchiveFormat("reference of this program", _REMEDY, _LAYOUT)
_MOST_BYTES = 4096 * MB
_FARTHEST = 1e6  # metres


def write_reference(path: Path, reference: Reference) -> None:
    """Write a reference with everything that it states; InputError where that cannot be done."""
    write_file(path, reference_bytes(reference))


def write_reference_table(path: Path, reference: Reference) -> None:
    """Write the nine landmarks as ``.csv``, with sigmas and provenance; see :func:`write_file`."""
    sigma, provenance = None, reference.provenance
    if reference.covariance is not None:
        variances = np.diagonal(reference.covariance, axis1=2, axis2=3)
        sigma = reference.of_the_nine(np.sqrt(np.maximum(variances, 0.0)))
    texts, numbers = dict[str, NDArray[np.str_]](), dict[str, FloatArray]()
    if provenance is not None:
        own = provenance.of(reference.landmark_names, LANDMARKS).arrays()
        texts = {name: own[name].astype(np.str_) for name in landmarks.TEXT_COLUMNS}
        numbers = {name: own[name].astype(np.float64) for name in landmarks.NUMBER_COLUMNS}
    elif reference.filled is not None:
        source = np.where(reference.filled, INTERPOLATED, FITTED)
        texts = {"source": np.repeat(source[:, None], len(LANDMARKS), axis=1)}
    trajectory = reference.trajectory(np.inf)
    landmarks.write_landmark_table(path, landmarks.LandmarkTable(trajectory, sigma, texts, numbers))


def read_reference_table(path: Path) -> Reference:
    """The reference of a ``.csv``, its covariances diagonal; InputError where it cannot be read."""
    table = landmarks.read_landmark_table(path)
    covariance = None if table.sigma is None else table.sigma[..., None] ** 2 * np.eye(3)
    filled = provenance = None
    if "source" in table.texts:
        filled = np.asarray((table.texts["source"] == INTERPOLATED).any(axis=1))
        stated: dict[str, Any] = {**table.texts, **table.numbers}
        nothing = Provenance.unknown(*table.trajectory.points.shape[:2])
        provenance = Provenance(**{**nothing.arrays(), **stated})
    trajectory, meta = table.trajectory, dict[str, Any](imported_from=path.name)
    if trajectory.fps is not None:
        meta["fps"] = trajectory.fps
    return Reference(
        trajectory.frame, trajectory.points, covariance, filled=filled, meta=meta,
        notes=trajectory.notes, provenance=provenance,
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
    for key in ("covariance", "limb_sigma_deg", "filled"):
        if (array := getattr(reference, key)) is not None:
            arrays[key] = array
    if reference.provenance is not None:
        arrays |= reference.provenance.arrays()
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
        told = (*landmarks.TEXT_COLUMNS, *landmarks.NUMBER_COLUMNS)
        known = set(told) <= arrays.keys()
        return Reference(
            frame=frame.astype(np.int64),
            points=points,
            covariance=arrays.get("covariance"),
            limb_sigma_deg=arrays.get("limb_sigma_deg"),
            filled=arrays.get("filled"),
            landmark_names=tuple(str(one) for one in arrays["landmark_names"]),
            meta=meta,
            provenance=Provenance(*(arrays[name] for name in told)) if known else None,
        )
