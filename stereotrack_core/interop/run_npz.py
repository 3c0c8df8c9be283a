"""The run file: a complete run as NumPy's ``.npz``."""

import io
import json
import os
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from stereotrack_core.atomic import write_file
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.errors import InputError
from stereotrack_core.interop.npz import ArchiveFormat, ArrayLayout, archive_bytes
from stereotrack_core.reading import MB, open_file, parsed_json
from stereotrack_core.recording.keypoints import Keypoints, columns_of, keypoints_of_columns
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.tables import LARGEST as LAST_FRAME
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.stored import check_meta

_LAYOUT: dict[str, ArrayLayout] = {
    "frame": ArrayLayout("i", ("F",)),
    "landmarks": ArrayLayout("f", ("F", len(LANDMARKS), 3)),
    "landmark_names": ArrayLayout("U", (len(LANDMARKS),)),
    "x": ArrayLayout("f", ("F", "n")),
    "P": ArrayLayout("f", ("F", "n", "n")),
    "state_names": ArrayLayout("U", ("n",)),
    "tracked": ArrayLayout("b", ("F",)),
    "coverage": ArrayLayout("f", ("F",)),
    "residual": ArrayLayout("f", ("F",)),
    "innovation": ArrayLayout("f", ("F",)),
    "limb_sigma_deg": ArrayLayout("f", ("F", len(LIMBS))),
    "limb_lost": ArrayLayout("f", ("F", len(LIMBS)), optional=True),
    "seconds": ArrayLayout("f", ("F", "stages")),
    "stage_names": ArrayLayout("U", ("stages",)),
    "meta": ArrayLayout("U", ()),
}

_KEYPOINTS: dict[str, ArrayLayout] = {
    f"keypoint_{name}": ArrayLayout(kind, shape, optional=True)
    for name, kind, shape in (
        *((name, "i", ("K",)) for name in ("frame", "camera", "point", "source")),
        ("place", "f", ("K", 2)),
        ("confidence", "f", ("K",)),
        *((f"{name}_names", "U", (name,)) for name in ("camera", "point", "source")),
    )
}
"""Keypoints that the run used, all of these or none; see :func:`columns_of`."""

_NAMES = ("landmark_names", "state_names", "stage_names")

_FIELDS = MappingProxyType({"coverage": "unexplained_fraction"})
"""Fields of a run that are named otherwise than their arrays in the file."""

FORMAT = 1  # version of the layout; kept in the meta as ``format``

_REMEDY = "Use a run written by `stereotrack track`, or track the recording again."
_FILE = ArchiveFormat("run file of this program", _REMEDY, {**_LAYOUT, **_KEYPOINTS})

_MOST_BYTES = 4096 * MB

_LARGEST: Mapping[str, float] = MappingProxyType({"landmarks": 1e6, "x": 1e6, "P": 1e12})
"""Metres, radians and their squares; beyond it, they are no person's."""

_FOLDER = "recording_folder"
_FOLDER_FROM_RUN = "recording_folder_from_run"


def write_npz(path: Path, run: Run) -> None:
    """Write a complete run, its recording's folder absolute and relative: both can be moved."""
    write_file(path, archive_bytes(_arrays_of(run, _meta_to_store(path, run.meta))))


def run_bytes(run: Run) -> bytes:
    """A complete run as it is kept in a project: a run file that is not compressed.

    Most of it is covariances, which compressing makes a tenth smaller in twenty times the time.
    """
    return archive_bytes(_arrays_of(run, {**run.meta, "format": FORMAT}), compressed=False)


def run_of_bytes(data: bytes, where: str) -> Run:
    """The run of :func:`run_bytes`, or of a run file's content; InputError where it is none."""
    return _run_of(Path(where), io.BytesIO(data), None)


def read_npz(path: Path) -> Run:
    """Read a run file; InputError for one that is missing, damaged, or not of this program."""
    with open_file(path, _MOST_BYTES) as file:
        return _run_of(path, file, path.absolute().parent)


def read_meta(path: Path) -> dict[str, Any]:
    """What a run file says of how it was tracked, without its numbers; InputError for no run."""
    with open_file(path, _MOST_BYTES) as file:
        arrays = _FILE.read(file, str(path), ["meta"])
        with _FILE.decoding(path):
            text = str(arrays["meta"])
    return _meta_from_store(path, text, path.absolute().parent)


def _run_of(path: Path, file: BinaryIO, beside: Path | None) -> Run:
    arrays = _FILE.read(file, str(path))
    unknown = np.full((len(arrays["frame"]), len(LIMBS)), np.nan)
    arrays.setdefault("limb_lost", unknown)
    with _FILE.decoding(path):
        text = str(arrays["meta"])  # letters that are none show only now
        values: dict[str, Any] = {"meta": _meta_from_store(path, text, beside)}
        for name, own in _LAYOUT.items():
            if own.kind == "f":
                values[_FIELDS.get(name, name)] = arrays[name].astype(np.float64)
            elif name in _NAMES:
                values[name] = tuple(str(one) for one in arrays[name])
        values |= {"frame": arrays["frame"].astype(np.int64), "tracked": arrays["tracked"]}
        run = Run(**values, keypoints=_keypoints_in(path, arrays))
    check_run(path, run)
    return run


def _keypoints_in(path: Path, arrays: Mapping[str, NDArray[Any]]) -> Keypoints | None:
    stored = {name: arrays[name] for name in _KEYPOINTS if name in arrays}
    if not stored:
        return None
    if missing := [name for name in _KEYPOINTS if name not in stored]:
        raise _FILE.refusal(str(path), f"it lacks {', '.join(missing)}")
    try:
        return keypoints_of_columns({n.removeprefix("keypoint_"): a for n, a in stored.items()})
    except ValueError as error:
        raise _FILE.refusal(str(path), str(error)) from None


def _arrays_of(run: Run, meta: Mapping[str, Any]) -> dict[str, NDArray[Any]]:
    arrays: dict[str, NDArray[Any]] = {
        "frame": np.asarray(run.frame, dtype=np.int64),
        **{name: np.array(getattr(run, name), dtype=np.str_) for name in _NAMES},
        "tracked": np.asarray(run.tracked, dtype=np.bool_),
        "meta": np.array(json.dumps(meta, ensure_ascii=False)),
    }
    for name, own in _LAYOUT.items():
        if own.kind == "f":
            values = getattr(run, _FIELDS.get(name, name))
            arrays[name] = np.asarray(values, dtype=np.float64)
    if run.keypoints is not None:
        for name, column in columns_of(run.keypoints).items():
            short = np.int32 if name == "frame" else np.int16 if column.dtype.kind == "i" else None
            arrays[f"keypoint_{name}"] = column.astype(short or column.dtype)
    return arrays


def check_run(path: Path, run: Run) -> None:
    """Refuse numbers that no run has; InputError where it has some."""
    frame = run.frame
    in_order = bool((frame[1:] > frame[:-1]).all())
    possible = not len(frame) or (frame[0] >= 0 and frame[-1] <= LAST_FRAME)
    posed = np.isfinite(run.x).all(axis=1) & np.isfinite(run.landmarks).all(axis=(1, 2))
    large = [name for name, most in _LARGEST.items() if (abs(getattr(run, name)) > most).any()]
    wrong = {
        "its landmarks are not the nine landmarks of this program in their order": (
            run.landmark_names != LANDMARKS
        ),
        "its frames are not in ascending order": not in_order,
        f"its frames are not between 0 and {LAST_FRAME}": not possible,
        f"{', '.join(large)} contain numbers that are too large": bool(large),
        "a tracked frame has no pose": bool((run.tracked & ~posed).any()),
    }
    for reason, true in wrong.items():
        if true:
            raise _FILE.refusal(str(path), reason)


def _meta_to_store(path: Path, meta: Mapping[str, Any]) -> dict[str, Any]:
    stored = {**meta, "format": FORMAT}
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
    where = f"{path}, meta"
    meta: dict[str, Any] = parsed_json(text, where)
    check_meta(meta, where, _FILE.remedy)
    if (version := meta.pop("format", FORMAT)) != FORMAT:
        what = f"it is a run file of format {version}, and this program reads format {FORMAT}"
        remedy = "Track the recording again, or use the version that wrote it."
        raise InputError(what, where, remedy)
    from_run = meta.pop(_FOLDER_FROM_RUN, None)
    if isinstance(from_run, str) and folder is not None:
        beside = Path(os.path.normpath(folder / from_run))
        if beside.is_dir():
            meta[_FOLDER] = str(beside)
    return meta
