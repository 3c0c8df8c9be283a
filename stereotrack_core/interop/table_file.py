"""Tables as files: CSV for programs, Markdown for people."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from io import StringIO
from pathlib import Path

from stereotrack_core.errors import InputError
from stereotrack_core.interop.atomic import replacing

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


def write_text_table(path: Path, text: str) -> None:
    """Write the text of a table."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="")


def csv_text(columns: Sequence[str], rows: Sequence[Sequence[str | float | int]]) -> str:
    """A table as CSV; numbers in full."""
    buffer = StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(rows)
    return buffer.getvalue()


def markdown_text(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table as Markdown; a heading that begins with ``>`` stands over a right-aligned column."""
    headings = [heading.removeprefix(">") for heading in columns]
    rule = ["---:" if heading.startswith(">") else "---" for heading in columns]
    lines = [headings, rule, *([cell.replace("|", "\\|") for cell in row] for row in rows)]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)
