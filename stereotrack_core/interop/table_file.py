"""Tables as files: CSV for programs, Markdown for people."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from stereotrack_core.errors import InputError
from stereotrack_core.recording.csv_table import unguarded
from stereotrack_core.recording.toml_table import readable, reason

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


def text_cells(
    path: Path, *, delimiter: str = ",", quoting: Literal[0, 3] = csv.QUOTE_MINIMAL
) -> list[list[str]]:
    """All cells of a text file, stripped and unguarded, line by line.

    Raises
    ------
    InputError
        Where it cannot be read.
    """
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            lines = csv.reader(file, delimiter=delimiter, quoting=quoting)
            return [[unguarded(cell.strip()) for cell in line] for line in lines]
    except FileNotFoundError:
        raise InputError(
            "the file does not exist", where=str(path), remedy="Correct its path."
        ) from None
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        sign = "tabulators" if delimiter == "\t" else "commas"
        raise InputError(
            f"the file cannot be read ({reason(error, str(error))})",
            where=str(path),
            remedy=readable(error, f"It has to be a UTF-8 text file with {sign} between values."),
        ) from None


def read_csv_table(path: Path) -> tuple[tuple[str, ...], tuple[tuple[str, ...], ...]]:
    """Headings and rows of a CSV file; empty lines are left out.

    Raises
    ------
    InputError
        When the file cannot be read, has no heading, a heading twice, or a row of another length.
    """
    filled = [(number, line) for number, line in enumerate(text_cells(path), start=1) if any(line)]
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
