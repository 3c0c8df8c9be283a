"""References, subjects, sets of landmarks and parameters in a project.

They are saved by edits, and read back as they were.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from math import inf
from typing import Any, ClassVar

from stereotrack_core.annotation.landmark_set import NINE, LandmarkSet, landmark_set_of
from stereotrack_core.annotation.reference import Reference
from stereotrack_core.errors import InputError
from stereotrack_core.interop.reference_npz import reference_bytes, reference_of_bytes
from stereotrack_core.project.database import making_sense
from stereotrack_core.project.edit import Change, Edit, Stamp, State
from stereotrack_core.project.entries import Entries, SaveEntry, facts_as_json
from stereotrack_core.project.schema import (
    CHOICE,
    LANDMARK_SET,
    PARAMETER_SET,
    REFERENCE,
    SUBJECT,
)
from stereotrack_core.recording.description import (
    LENGTHS,
    Subject,
    subject_in,
)


@dataclass(frozen=True)
class ParameterSet:
    """Parameters by name, JSON-serialisable, as they differ from a preset."""

    preset: str
    values: Mapping[str, Any]


_META_SHOWN = ("program", "version", "preset", "seed", "recording", "fingerprint", "views")


def save_reference(name: str, reference: Reference, *, replacing: bool = False) -> SaveEntry:
    """The edit that puts a reference into the project."""
    shown = {key: reference.meta[key] for key in _META_SHOWN if key in reference.meta}
    facts = facts_as_json({"frames": len(reference.frame), **shown})
    return SaveEntry(REFERENCE.name, name, facts, reference_bytes(reference), replacing)


def load_reference(references: Entries, name: str) -> Reference:
    """A reference of the project, bit by bit as it was saved.

    Raises InputError where there is none of that name; ProjectDamaged where its data are not what
    was stored.
    """
    data = references.data(name)
    with making_sense(references.path):
        return reference_of_bytes(data, name)


def save_subject(subject: Subject, *, origin: str = "entered") -> SaveEntry:
    """The edit that keeps a subject's proportions under the subject's name.

    The origin is ``entered``, ``measured from clicks``, ``found by the tracker`` or
    ``personalised``.
    """
    facts = {**asdict(subject), "origin": origin}
    return SaveEntry(SUBJECT.name, subject.name, facts_as_json(facts), replacing=True)


@dataclass(frozen=True, eq=False)
class UseSubject(Edit):
    """Keep a subject under its name, and let the project use it, as one edit."""

    kind: ClassVar[str] = "use subject"
    subject: Subject
    origin: str

    def words(self) -> str:
        """``use subject P2, personalised``."""
        return f"use subject {self.subject.name}, {self.origin}"

    def changes(self, state: State, stamp: Stamp) -> Iterable[Change]:
        """The subject's row, and the choice."""
        yield from save_subject(self.subject, origin=self.origin).changes(state, stamp)
        yield state.change(CHOICE, (SUBJECT.name,), (self.subject.name,))


def load_subject(subjects: Entries, name: str) -> Subject:
    """A subject of the project; InputError where there is none of that name."""
    facts = subjects.get(name).facts
    with making_sense(subjects.path):
        lengths = {key: _length(facts.get(key)) for key in LENGTHS}
        return Subject(name, **lengths, offsets=_offsets(facts.get("offsets") or {}))


def _offsets(values: Any) -> Mapping[str, tuple[float, float, float]]:
    try:
        return subject_in({"offsets": values}, "subject").offsets
    except InputError as error:
        raise ValueError(error.what) from error


def _length(value: Any) -> float | None:
    if value is not None and not (isinstance(value, int | float) and 0 < value < inf):
        raise ValueError(f"{value!r} is not a length")
    return None if value is None else float(value)


def save_landmark_set(landmarks: LandmarkSet) -> SaveEntry:
    """The edit that keeps a set of landmarks under its name."""
    facts = facts_as_json(landmarks.facts())
    return SaveEntry(LANDMARK_SET.name, landmarks.name, facts, replacing=True)


def load_landmark_set(sets: Entries, name: str | None) -> LandmarkSet:
    """A set of landmarks of the project, the nine without a name.

    InputError where there is none of that name.
    """
    if name is None or (name == NINE.name and name not in sets.names()):
        return NINE
    facts = sets.get(name).facts
    with making_sense(sets.path):
        try:
            return landmark_set_of(facts)
        except InputError as error:  # which says how to write one
            raise ValueError(error.what) from error


def save_parameters(name: str, parameters: ParameterSet) -> SaveEntry:
    """The edit that keeps parameters under a name."""
    facts = facts_as_json({"preset": parameters.preset, "values": dict(parameters.values)})
    return SaveEntry(PARAMETER_SET.name, name, facts, replacing=True)


def load_parameters(sets: Entries, name: str) -> ParameterSet:
    """Parameters of the project; InputError where there are none of that name."""
    facts = sets.get(name).facts
    with making_sense(sets.path):
        return ParameterSet(str(facts["preset"]), dict(facts["values"]))
