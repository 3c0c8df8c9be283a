"""References with their uncertainty as NumPy's ``.npz``: files, and what projects keep."""

from __future__ import annotations

import io
import json
import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from stereotrack_core.annotation.reference import Reference
from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError

_NEEDED = ("frame", "points", "landmark_names", "meta")
_OPTIONAL = ("covariance", "limb_sigma_deg", "filled")


def write_reference(path: Path, reference: Reference) -> None:
    """Write a reference with everything that it states; an interrupted write leaves the old file.

    Raises
    ------
    InputError
        Where the file cannot be written.
    """
    write_file(path, reference_bytes(reference))


def read_reference(path: Path) -> Reference:
    """Read a reference.

    Raises
    ------
    InputError
        For a file that is missing, damaged or no reference.
    """
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        raise InputError(
            "there is no such file", where=str(path), remedy="Check the path."
        ) from None
    except OSError as error:
        raise InputError(
            f"the file cannot be read ({error.strerror})",
            where=str(path),
            remedy="Give the .npz file that `stereotrack fit` or the workbench wrote.",
        ) from error
    return reference_of_bytes(data, str(path))


def is_reference(path: Path) -> bool:
    """Whether an ``.npz`` file holds a reference (a run has other arrays); False for no file."""
    try:
        with zipfile.ZipFile(path) as archive:
            names = set(archive.namelist())
    except (OSError, zipfile.BadZipFile):
        return False
    return {f"{name}.npy" for name in _NEEDED} <= names


def reference_bytes(reference: Reference) -> bytes:
    """The content of a reference's file."""
    arrays: dict[str, Any] = {
        "frame": reference.frame,
        "points": reference.points,
        "landmark_names": np.array(reference.landmark_names, dtype=np.str_),
        "meta": np.array(json.dumps(dict(reference.meta))),
    }
    for key in _OPTIONAL:
        if (array := getattr(reference, key)) is not None:
            arrays[key] = array
    file = io.BytesIO()
    np.savez_compressed(file, allow_pickle=False, **arrays)
    return file.getvalue()


def reference_of_bytes(data: bytes, where: str) -> Reference:
    """The reference that is the content of a file.

    Raises
    ------
    InputError
        Where it is none.
    """
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as stored:
            meta = json.loads(str(stored["meta"]))
            if stored["frame"].dtype.kind != "i" or not isinstance(meta, dict):
                raise ValueError("its frames or its meta are no reference's")
            return Reference(
                frame=stored["frame"],
                points=stored["points"],
                covariance=stored.get("covariance"),
                limb_sigma_deg=stored.get("limb_sigma_deg"),
                filled=stored.get("filled"),
                landmark_names=tuple(str(one) for one in stored["landmark_names"]),
                meta=meta,
            )
    except (ValueError, KeyError, EOFError, TypeError, zipfile.BadZipFile, zlib.error) as error:
        raise InputError(
            f"the data of the reference are of another kind ({error})",
            where=where,
            remedy="Give a reference that `stereotrack fit` or the workbench wrote.",
        ) from error


def fps_of_reference(reference: Reference) -> float | None:
    """Frames per second that the reference's meta states; None where it states none."""
    fps = reference.meta.get("fps")
    return float(fps) if isinstance(fps, int | float) and fps > 0 else None
