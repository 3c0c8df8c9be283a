"""Read and write ``subject.toml``: measured lengths of the person."""

from __future__ import annotations

from dataclasses import asdict, fields
from pathlib import Path

import tomli_w

from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError
from stereotrack_core.recording.description import Subject
from stereotrack_core.recording.toml_table import Table, load_toml

LENGTHS = tuple(field.name for field in fields(Subject) if field.name != "name")


def read_subject(path: Path) -> Subject:
    """The subject; lengths in metres, None where not measured.

    Raises
    ------
    InputError
        At the first thing that is wrong.
    """
    complaints: list[InputError] = []
    subject = parse_subject(path, complaints)
    if complaints:
        raise complaints[0]
    assert subject is not None  # noqa: S101 - without a complaint it was read
    return subject


def parse_subject(path: Path, complaints: list[InputError]) -> Subject | None:
    """The subject as far as it is usable; everything wrong is appended to `complaints`."""
    try:
        table = Table(load_toml(path), str(path), complaints)
    except InputError as error:
        complaints.append(error)
        return None
    lengths = {key: table.number(key) for key in LENGTHS}
    for key, length in lengths.items():
        if length is not None and length <= 0:
            table.complain(
                key, f"a length of {length:g} m is not possible", "Give the length in metres."
            )
            lengths[key] = None
    return Subject(name=table.text("name") or "", **lengths)


def write_subject(path: Path, subject: Subject) -> None:
    """Write a subject so that :func:`read_subject` gives it again."""
    known = {key: value for key, value in asdict(subject).items() if value is not None}
    write_file(path, tomli_w.dumps(known))
