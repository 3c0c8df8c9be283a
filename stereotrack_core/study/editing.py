"""Edits of a study: each gives another study, and touches no file."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TypeAlias

from stereotrack_core.errors import InputError, did_you_mean
from stereotrack_core.study.create import Pattern
from stereotrack_core.study.file import OWN_COLUMNS, RESULT_COLUMNS, Study, StudyRow

_Factors: TypeAlias = Callable[[StudyRow], Mapping[str, str]]


def with_recordings(study: Study, rows: Iterable[StudyRow]) -> Study:
    """List further recordings, behind those that are there.

    A recording that is listed already keeps its row and what a person wrote: it takes the project,
    where one is named, and the fingerprint where it had none.
    """
    by_place = {study.place(row.recording): row for row in study.rows}
    for row in rows:
        place = study.place(row.recording)
        known = by_place.get(place)
        if known is None:
            factors = {name: row.factors.get(name, "") for name in study.factors}
            by_place[place] = replace(row, factors=factors)
        else:
            by_place[place] = replace(
                known,
                project=row.project or known.project,
                fingerprint=known.fingerprint or row.fingerprint,
            )
    return replace(study, rows=tuple(by_place.values()))


def without(study: Study, recordings: Collection[str]) -> Study:
    """Take recordings out of the list; their files, projects and runs stay where they are."""
    return replace(study, rows=tuple(row for row in study.rows if row.recording not in recordings))


def with_value(study: Study, recordings: Collection[str], column: str, value: str) -> Study:
    """Write a value into a column of some recordings.

    Raises InputError for a column that the study does not have, or that is the program's own.
    """
    _check_there(study, column)
    text = _plain(value)
    return _rewritten(study, recordings, lambda row: {**row.factors, column: text})


def values_of(study: Study, column: str) -> tuple[str, ...]:
    """What recordings say in a column, each once, in the order of the letters."""
    found = {row.factors.get(column, "") for row in study.rows}
    return tuple(sorted(found - {""}, key=str.casefold))


def with_column(study: Study, name: str) -> Study:
    """Add an empty column behind the others. Raises InputError for a name that cannot be used."""
    name = checked_name(study, name)
    added = replace(
        study,
        factors=(*study.factors, name),
        order=(*study.order, name) if study.order else (),
    )
    return _rewritten(added, None, lambda row: {**row.factors, name: ""})


def with_column_renamed(study: Study, old: str, new: str) -> Study:
    """Call a column something else; its values stay.

    Raises InputError for a column that is not there, or a name that cannot be used.
    """
    _check_there(study, old)
    if _plain(new) == old:
        return study
    new = checked_name(study, new)

    def called(names: Sequence[str]) -> tuple[str, ...]:
        return tuple(new if name == old else name for name in names)

    renamed = replace(study, factors=called(study.factors), order=called(study.order))
    return _rewritten(
        renamed,
        None,
        lambda row: {new if name == old else name: text for name, text in row.factors.items()},
    )


def without_column(study: Study, name: str) -> Study:
    """Remove a column with its values. Raises InputError for a column that is not there."""
    _check_there(study, name)
    return _rewritten(
        replace(
            study,
            factors=tuple(one for one in study.factors if one != name),
            order=tuple(one for one in study.order if one != name),
        ),
        None,
        lambda row: {one: text for one, text in row.factors.items() if one != name},
    )


def with_names_of_folders(study: Study, recordings: Collection[str], pattern: Pattern) -> Study:
    """Fill empty cells from the last folders of the recordings' paths; columns are added.

    A recording that does not fit the pattern stays as it is. Raises InputError where none fits.
    """
    found = {
        row.recording: known
        for row in study.rows
        if row.recording in recordings
        and (known := pattern.factors_of_end(row.recording)) is not None
    }
    if not found:
        raise InputError(
            "no recording fits this pattern",
            where=pattern.text,
            remedy="Name the last folders of a recording, for example subject/condition.",
        )
    for name in pattern.names:
        study = study if name in study.factors else with_column(study, name)
    return _rewritten(
        study,
        found,
        lambda row: {
            name: text or found[row.recording].get(name, "") for name, text in row.factors.items()
        },
    )


def checked_name(study: Study, name: str) -> str:
    """The name of a new column, without space around it. Raises InputError where it is unusable."""
    name = _plain(name)
    remedy = "Use a short name, such as subject or session."
    if not name:
        what = "the column has no name"
    elif name in OWN_COLUMNS or name in RESULT_COLUMNS:
        what = f"{name!r} is a column that the program writes"
    elif name in study.factors:
        what = f"the study has a column {name!r} already"
    elif re.search(r"[=,;*\"']", name):
        what = f"{name!r} contains one of the signs = , ; * \" '"
    else:
        return name
    raise InputError(what, where="name of the column", remedy=remedy)


def _check_there(study: Study, column: str) -> None:
    if column not in study.factors:
        own = column in OWN_COLUMNS
        raise InputError(
            f"{column!r} is written by the program" if own else f"there is no column {column!r}",
            where=str(study.path),
            remedy=f"{did_you_mean(column, study.factors)}"
            f"These can be edited: {', '.join(study.factors) or 'none'}.",
        )


def _plain(text: str) -> str:
    """As a cell is read again: one line, without space around it."""
    return " ".join(text.split())


def _rewritten(study: Study, recordings: Collection[str] | None, factors: _Factors) -> Study:
    """Other factors of some rows, or of all where None is given."""
    rows = tuple(
        replace(row, factors=factors(row))
        if recordings is None or row.recording in recordings
        else row
        for row in study.rows
    )
    return replace(study, rows=rows)
