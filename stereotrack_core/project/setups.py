"""Subjects, sets of landmarks and parameters in a project."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from math import inf
from typing import Any

from stereotrack_core.annotation.landmark_set import NINE, LandmarkSet, landmark_set_of
from stereotrack_core.errors import InputError
from stereotrack_core.project.entries import Entries, SaveEntry, facts_as_json
from stereotrack_core.project.schema import LANDMARK_SET, PARAMETER_SET, SUBJECT
from stereotrack_core.recording.description import Subject
from stereotrack_core.recording.subject_file import LENGTHS


@dataclass(frozen=True)
class ParameterSet:
    """Parameters by name, as they differ from a preset.

    Attributes
    ----------
    preset : str
    values : mapping
        From a parameter's name to its value; JSON-serialisable.
    """

    preset: str
    values: Mapping[str, Any]


def save_subject(subject: Subject, *, origin: str = "entered") -> SaveEntry:
    """The edit that keeps a subject's proportions under the subject's name.

    Parameters
    ----------
    subject : Subject
    origin : str
        How they are known: ``entered``, ``measured from clicks``, ``found by the tracker``.
    """
    facts = {**asdict(subject), "origin": origin}
    return SaveEntry(SUBJECT.name, subject.name, facts_as_json(facts), replacing=True)


def load_subject(subjects: Entries, name: str) -> Subject:
    """A subject of the project; InputError where there is none of that name."""
    facts = subjects.get(name).facts
    with subjects.making_sense():
        return Subject(name, **{key: _length(facts.get(key)) for key in LENGTHS})


def _length(value: Any) -> float | None:
    if value is not None and not (isinstance(value, int | float) and 0 < value < inf):
        raise ValueError(f"{value!r} is no length")
    return None if value is None else float(value)


def save_landmark_set(landmarks: LandmarkSet) -> SaveEntry:
    """The edit that keeps a set of landmarks under its name."""
    facts = facts_as_json(landmarks.facts())
    return SaveEntry(LANDMARK_SET.name, landmarks.name, facts, replacing=True)


def load_landmark_set(sets: Entries, name: str | None) -> LandmarkSet:
    """A set of landmarks of the project, the nine without a name.

    Raises
    ------
    InputError
        Where there is none of that name.
    """
    if name is None or (name == NINE.name and name not in sets.names()):
        return NINE
    facts = sets.get(name).facts
    with sets.making_sense():
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
    with sets.making_sense():
        return ParameterSet(str(facts["preset"]), dict(facts["values"]))
