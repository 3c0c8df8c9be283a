"""References and runs in a project: saved by edits, read back bit by bit."""

from __future__ import annotations

import io
import json
import tempfile
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.errors import InputError
from stereotrack_core.interop.run_npz import read_npz, write_npz
from stereotrack_core.project.entries import Entries, SaveEntry, facts_as_json
from stereotrack_core.project.schema import REFERENCE, RUN
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory
from stereotrack_core.tracking.run import Run

_META_SHOWN = ("program", "version", "preset", "seed", "recording", "fingerprint", "views")


@dataclass(frozen=True, eq=False)
class Reference:
    """A trajectory taken as truth, and how good it is; F frames, n landmarks.

    Attributes
    ----------
    frame : (F,) int64
        Ascending.
    points : (F, n, 3) float64, world, metres
        NaN where not known.
    covariance : (F, n, 3, 3) float64, square metres, or None
        Of each landmark's position.
    limb_sigma_deg : (F, 6) float64 or None
        Standard deviation of each limb's direction, in the order of ``LIMBS``.
    filled : (F,) bool or None
        Frames that nobody annotated, filled in between annotated ones.
    landmark_names : tuple of str
    meta : mapping
        How it was made; JSON-serialisable.
    """

    frame: IntArray
    points: FloatArray
    covariance: FloatArray | None = None
    limb_sigma_deg: FloatArray | None = None
    filled: BoolArray | None = None
    landmark_names: tuple[str, ...] = LANDMARKS
    meta: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        frames, landmarks = len(self.frame), len(self.landmark_names)
        shapes: dict[str, tuple[Any, tuple[int, ...]]] = {
            "points": (self.points, (frames, landmarks, 3)),
            "covariance": (self.covariance, (frames, landmarks, 3, 3)),
            "limb_sigma_deg": (self.limb_sigma_deg, (frames, 6)),
            "filled": (self.filled, (frames,)),
        }
        for name, (array, shape) in shapes.items():
            if array is not None and array.shape != shape:
                raise ValueError(f"{name} has the shape {array.shape} instead of {shape}")
        if (np.diff(self.frame) <= 0).any():
            raise ValueError("the frames do not ascend")

    def trajectory(self) -> LandmarkTrajectory:
        """The nine landmarks alone, NaN where the reference does not have one of them."""
        points = np.full((len(self.frame), len(LANDMARKS), 3), np.nan)
        for i, name in enumerate(LANDMARKS):
            if name in self.landmark_names:
                points[:, i] = self.points[:, self.landmark_names.index(name)]
        return LandmarkTrajectory(self.frame, points)


def save_reference(name: str, reference: Reference, *, replacing: bool = False) -> SaveEntry:
    """The edit that puts a reference into the project."""
    arrays: dict[str, Any] = {
        "frame": reference.frame,
        "points": reference.points,
        "landmark_names": np.array(reference.landmark_names, dtype=np.str_),
        "meta": np.array(json.dumps(dict(reference.meta))),
    }
    for key in ("covariance", "limb_sigma_deg", "filled"):
        if (array := getattr(reference, key)) is not None:
            arrays[key] = array
    file = io.BytesIO()
    np.savez_compressed(file, allow_pickle=False, **arrays)
    facts = {"frames": len(reference.frame), **_shown(reference.meta)}
    return SaveEntry(REFERENCE.name, name, facts_as_json(facts), file.getvalue(), replacing)


def load_reference(references: Entries, name: str) -> Reference:
    """A reference of the project.

    Raises
    ------
    InputError
        Where there is none of that name.
    ProjectDamaged
        Where its data are not what was stored.
    """
    try:
        with np.load(io.BytesIO(references.data(name)), allow_pickle=False) as stored:
            return Reference(
                frame=stored["frame"],
                points=stored["points"],
                covariance=stored.get("covariance"),
                limb_sigma_deg=stored.get("limb_sigma_deg"),
                filled=stored.get("filled"),
                landmark_names=tuple(str(one) for one in stored["landmark_names"]),
                meta=json.loads(str(stored["meta"])),
            )
    except (ValueError, KeyError, zipfile.BadZipFile) as error:
        raise InputError(
            f"the data of the reference are of another kind ({error})", where=name
        ) from error


def save_run(name: str, run: Run, *, replacing: bool = False) -> SaveEntry:
    """The edit that puts a run, as its file, into the project."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.npz"
        write_npz(path, run)
        data = path.read_bytes()
    facts = {
        "frames": len(run.frame),
        "tracked": int(run.tracked.sum()),
        **_shown(run.meta),
    }
    return SaveEntry(RUN.name, name, facts_as_json(facts), data, replacing)


def load_run(runs: Entries, name: str) -> Run:
    """A run of the project.

    Raises
    ------
    InputError
        Where there is none of that name, or its data are no run.
    """
    data = runs.data(name)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.npz"
        path.write_bytes(data)
        return read_npz(path)


def _shown(meta: Mapping[str, Any]) -> dict[str, Any]:
    return {key: meta[key] for key in _META_SHOWN if key in meta}
