"""References in a project: saved by edits, read back bit by bit."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from stereotrack_core.annotation.reference import Reference
from stereotrack_core.interop.reference_npz import reference_bytes, reference_of_bytes
from stereotrack_core.project.entries import Entries, SaveEntry, facts_as_json
from stereotrack_core.project.schema import REFERENCE

__all__ = ["Reference", "load_reference", "save_reference"]

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
    data = references.data(name)
    with references.making_sense():
        return reference_of_bytes(data, name)


def _shown(meta: Mapping[str, Any]) -> dict[str, Any]:
    return {key: meta[key] for key in _META_SHOWN if key in meta}
