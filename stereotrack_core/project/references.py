"""References and runs in a project: saved by edits, read back bit by bit."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from stereotrack_core.annotation.reference import Reference
from stereotrack_core.interop.reference_npz import reference_bytes, reference_of_bytes
from stereotrack_core.interop.run_npz import read_npz, write_npz
from stereotrack_core.project.entries import Entries, SaveEntry, facts_as_json
from stereotrack_core.project.schema import REFERENCE, RUN
from stereotrack_core.tracking.run import Run

__all__ = ["Reference", "load_reference", "load_run", "save_reference", "save_run"]

_META_SHOWN = ("program", "version", "preset", "seed", "recording", "fingerprint", "views")


def save_reference(name: str, reference: Reference, *, replacing: bool = False) -> SaveEntry:
    """The edit that puts a reference into the project."""
    facts = {"frames": len(reference.frame), **_shown(reference.meta)}
    return SaveEntry(
        REFERENCE.name, name, facts_as_json(facts), reference_bytes(reference), replacing
    )


def load_reference(references: Entries, name: str) -> Reference:
    """A reference of the project.

    Raises
    ------
    InputError
        Where there is none of that name.
    ProjectDamaged
        Where its data are not what was stored.
    """
    return reference_of_bytes(references.data(name), name)


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
