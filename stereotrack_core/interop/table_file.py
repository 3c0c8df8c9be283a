"""Tables as files: CSV for programs, Markdown for people."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from stereotrack_core.errors import InputError
from stereotrack_core.recording.csv_table import read_cells

SUFFIXES = (".csv", ".md")


def table_suffix(path: Path) -> str:
    """Suffix of a table file, checked.

    Raises
    ------
    InputError
        For a suffix that no table has.
    """
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise InputError(
            "a table cannot be written to this kind of file",
            where=str(path),
            remedy=f"Name a file that ends in {' or '.join(SUFFIXES)}.",
        )
    return suffix


def markdown_text(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table as Markdown; a heading that begins with ``>`` stands over a right-aligned column."""
    headings = [heading.removeprefix(">") for heading in columns]
    rule = ["---:" if heading.startswith(">") else "---" for heading in columns]
    lines = [headings, rule, *([cell.replace("|", "\\|") for cell in row] for row in rows)]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def read_csv_table(path: Path) -> tuple[tuple[str, ...], tuple[tuple[str, ...], ...]]:
    """Headings and rows of a CSV file; empty lines are left out.

    Raises
    ------
    InputError
        When the file cannot be read, has no heading, a heading twice, or a row of another length.
    """
    filled = [(number, line) for number, line in enumerate(read_cells(path), start=1) if any(line)]
    if not filled or not all(filled[0][1]) or len(set(filled[0][1])) < len(filled[0][1]):
        raise InputError(
            "the first line does not name every column once",
            where=str(path),
            remedy="Write the names of the columns, with commas between them.",
        )
    headings = filled[0][1]
    for number, line in filled[1:]:
        if len(line) != len(headings):
            raise InputError(
                f"line {number} has {len(line)} values instead of {len(headings)}",
                where=str(path),
                remedy="Write as many values as there are columns.",
            )
    return tuple(headings), tuple(tuple(line) for _, line in filled[1:])
