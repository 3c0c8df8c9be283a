"""The run file: a complete run as NumPy's ``.npz``."""

from __future__ import annotations

import io
import json
import os
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from stereotrack_core.atomic import write_file
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.errors import InputError
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.tracking.run import Run

_SHAPES: dict[str, tuple[str, tuple[str | int, ...]]] = {
    "frame": ("i", ("F",)),
    "landmarks": ("f", ("F", len(LANDMARKS), 3)),
    "landmark_names": ("U", (len(LANDMARKS),)),
    "x": ("f", ("F", "n")),
    "P": ("f", ("F", "n", "n")),
    "state_names": ("U", ("n",)),
    "tracked": ("b", ("F",)),
    "coverage": ("f", ("F",)),
    "residual": ("f", ("F",)),
    "innovation": ("f", ("F",)),
    "limb_sigma_deg": ("f", ("F", len(LIMBS))),
    "limb_lost": ("f", ("F", len(LIMBS))),
    "seconds": ("f", ("F", "stages")),
    "stage_names": ("U", ("stages",)),
    "meta": ("U", ()),
}
"""Kind and shape of every array; a letter stands for the same length wherever it appears."""

_ADDED = ("limb_lost",)
"""Arrays that files of older versions lack; NaN then."""

_FOLDER = "recording_folder"
_FOLDER_FROM_RUN = "recording_folder_from_run"


def write_npz(path: Path, run: Run) -> None:
    """Write a complete run; an interrupted write leaves the old file.

    The recording's folder is stored both absolute and relative to the run file, so that both
    can be moved together.
    """
    file = io.BytesIO()
    arrays = _arrays_of(run, _meta_to_store(path, run.meta))
    np.savez_compressed(file, allow_pickle=False, **arrays)
    write_file(path, file.getvalue())


def run_bytes(run: Run) -> bytes:
    """A complete run as it is kept in a project: a run file that is not compressed.

    Most of it is covariances, which compressing makes a tenth smaller in twenty times the time.
    """
    file = io.BytesIO()
    np.savez(file, allow_pickle=False, **_arrays_of(run, dict(run.meta)))
    return file.getvalue()


def run_of_bytes(data: bytes, where: str) -> Run:
    """The run of :func:`run_bytes`, or of a run file's content.

    Raises
    ------
    InputError
        Where it is none.
    """
    return _run_of(Path(where), _arrays_in(Path(where), io.BytesIO(data)), None)


def read_npz(path: Path) -> Run:
    """Read a run file.

    Raises
    ------
    InputError
        For a file that is missing, damaged, or not a run of this program.
    """
    return _run_of(path, _arrays(path), path.absolute().parent)


def _run_of(path: Path, arrays: Mapping[str, NDArray[Any]], beside: Path | None) -> Run:
    _check(path, arrays)
    if tuple(arrays["landmark_names"]) != LANDMARKS:
        raise _foreign(path, "its landmarks are not the nine of this program, in their order")
    return Run(
        frame=arrays["frame"].astype(np.int64),
        landmarks=arrays["landmarks"].astype(np.float64),
        x=arrays["x"].astype(np.float64),
        P=arrays["P"].astype(np.float64),
        state_names=tuple(str(name) for name in arrays["state_names"]),
        tracked=arrays["tracked"],
        coverage=arrays["coverage"].astype(np.float64),
        residual=arrays["residual"].astype(np.float64),
        innovation=arrays["innovation"].astype(np.float64),
        limb_sigma_deg=arrays["limb_sigma_deg"].astype(np.float64),
        limb_lost=arrays["limb_lost"].astype(np.float64),
        seconds=arrays["seconds"].astype(np.float64),
        stage_names=tuple(str(name) for name in arrays["stage_names"]),
        meta=_meta_from_store(path, str(arrays["meta"]), beside),
    )


def _arrays_of(run: Run, meta: Mapping[str, Any]) -> dict[str, NDArray[Any]]:
    arrays: dict[str, NDArray[Any]] = {
        "frame": np.asarray(run.frame, dtype=np.int64),
        "landmark_names": _texts(run.landmark_names),
        "state_names": _texts(run.state_names),
        "stage_names": _texts(run.stage_names),
        "tracked": np.asarray(run.tracked, dtype=np.bool_),
        "meta": np.array(json.dumps(meta, ensure_ascii=False)),
    }
    for name, (kind, _) in _SHAPES.items():
        if kind == "f":
            arrays[name] = np.asarray(getattr(run, name), dtype=np.float64)
    return arrays


def _texts(names: tuple[str, ...]) -> NDArray[Any]:
    return np.array(names, dtype=np.str_)


def _arrays(path: Path) -> dict[str, NDArray[Any]]:
    if not path.is_file():
        raise InputError("there is no such file", where=str(path), remedy="Check the path.")
    try:
        with path.open("rb") as file:
            return _arrays_in(path, file)
    except OSError as error:
        raise InputError(
            f"the file cannot be read ({error.strerror})",
            where=str(path),
            remedy="Take another copy of the file.",
        ) from error


def _arrays_in(path: Path, file: BinaryIO) -> dict[str, NDArray[Any]]:
    try:
        stored = np.load(file, allow_pickle=False)
        if not isinstance(stored, np.lib.npyio.NpzFile):
            raise _foreign(path, "it holds a single array")
        missing = [name for name in _SHAPES if name not in (*stored.files, *_ADDED)]
        if missing:
            raise _foreign(path, f"it lacks {', '.join(missing)}")
        arrays = {name: stored[name] for name in _SHAPES if name in stored.files}
    except (OSError, ValueError, EOFError, KeyError, zipfile.BadZipFile, zlib.error) as error:
        raise InputError(
            "the file is damaged or is not a run file",
            where=str(path),
            remedy="Track the recording again, or take another copy of the file.",
        ) from error
    for name in _ADDED:
        arrays.setdefault(name, np.full((arrays["frame"].size, len(LIMBS)), np.nan))
    return arrays


def _check(path: Path, arrays: Mapping[str, NDArray[Any]]) -> None:
    """Kinds and shapes, each length the same wherever its letter appears."""
    lengths: dict[str, int] = {}
    for name, (kind, shape) in _SHAPES.items():
        array = arrays[name]
        if array.dtype.kind != kind:
            raise _foreign(path, f"the values of {name} are of the wrong kind ({array.dtype})")
        if array.ndim != len(shape):
            raise _foreign(path, f"{name} has {array.ndim} dimensions instead of {len(shape)}")
        for length, wanted in zip(array.shape, shape, strict=True):
            right = lengths.setdefault(wanted, length) if isinstance(wanted, str) else wanted
            if length != right:
                raise _foreign(path, f"{name} has the length {length} where {right} is expected")
    if (np.diff(arrays["frame"]) <= 0).any():
        raise _foreign(path, "its frames do not ascend")


def _foreign(path: Path, reason: str) -> InputError:
    return InputError(
        f"this is not a run file of this program: {reason}",
        where=str(path),
        remedy="Give a run that `stereotrack track` wrote.",
    )


def _meta_to_store(path: Path, meta: Mapping[str, Any]) -> dict[str, Any]:
    stored = dict(meta)
    if stored.get(_FOLDER):
        folder = Path(str(stored[_FOLDER])).absolute()
        stored[_FOLDER] = str(folder)
        try:
            relative = os.path.relpath(folder, path.absolute().parent)
        except ValueError:  # another drive of Windows: only the absolute path exists
            return stored
        stored[_FOLDER_FROM_RUN] = Path(relative).as_posix()
    return stored


def _meta_from_store(path: Path, text: str, folder: Path | None) -> dict[str, Any]:
    """The meta; where it lies in a folder, the recording may have moved together with it."""
    try:
        meta = json.loads(text)
    except json.JSONDecodeError as error:
        raise _foreign(path, "its meta is not JSON") from error
    if not isinstance(meta, dict):
        raise _foreign(path, "its meta is not a JSON object")
    from_run = meta.pop(_FOLDER_FROM_RUN, None)
    if isinstance(from_run, str) and folder is not None:
        beside = Path(os.path.normpath(folder / from_run))
        if beside.is_dir():
            meta[_FOLDER] = str(beside)
    return meta
