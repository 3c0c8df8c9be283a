"""Tables as text: written, and read with sentences about what is wrong in them.

A spreadsheet computes a cell that begins with one of ``= + - @``, a tabulator or a line break,
whoever has named a recording, run or segment so. Such a text is written with an apostrophe before
it, which is taken away when it is read.
"""

import csv
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from io import StringIO, TextIOWrapper
from itertools import chain
from pathlib import Path
from typing import Literal

from stereotrack_core.counting import typed_number
from stereotrack_core.errors import InputError
from stereotrack_core.reading import TABLE_BYTES, decoding, open_file

LARGEST = 2**31 - 1  # frame numbers beyond this are slips
_WHOLE = "Write a whole number."
_COMPUTED = re.compile(r"'*[=+\-@\t\r\n]")


def guarded(cell: str) -> str:
    """A text as a spreadsheet shows it without computing it; numbers stay as they are."""
    return f"'{cell}" if _is_computed(cell) else cell


def unguarded(cell: str) -> str:
    """The text that :func:`guarded` was given."""
    return cell[1:] if cell.startswith("'") and _is_computed(cell) else cell


def _is_computed(cell: str) -> bool:
    """Whether it would be computed, now or without apostrophes before it."""
    if not _COMPUTED.match(cell):
        return False
    try:
        float(cell.lstrip("'"))
    except ValueError:
        return True
    return False


@dataclass(frozen=True)
class Table:
    """A table to read; a heading that begins with ``>`` stands over right-aligned numbers.

    `kinds` are the rows' classes of style on a page; ``given`` sets a row apart.
    """

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    kinds: Sequence[str] = ()


def number(value: float, digits: int = 1) -> str:
    """Number for a table; a dash where there is none."""
    return f"{value:.{digits}f}" if math.isfinite(value) else "-"


def csv_text(columns: Sequence[str], rows: Iterable[Sequence[str | float | int]]) -> str:
    """A table as CSV; numbers in full, texts guarded."""
    buffer = StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    for row in (columns, *rows):
        writer.writerow([guarded(cell) if isinstance(cell, str) else cell for cell in row])
    return buffer.getvalue()


def read_cells(
    path: Path,
    *,
    delimiter: str = ",",
    quoting: Literal[0, 3] = csv.QUOTE_MINIMAL,
    headers: int = 0,
) -> list[list[str]]:
    """All cells of a text file, stripped and unguarded, line by line.

    A table whose first line has semicolons instead of commas is read as spreadsheets write it where
    the comma is the decimal sign. Raises InputError where it cannot be read, or where a line is
    longer than all of the first `headers`: decimal commas between commas make two values of one.
    """
    sign = "tabulators" if delimiter == "\t" else "commas"
    remedy = f"It must be a UTF-8 text file with {sign} between values."
    with open_file(path, TABLE_BYTES) as file, decoding(path, "the file cannot be read", remedy):
        text = TextIOWrapper(file, encoding="utf-8-sig", newline="")
        first = text.readline()
        if delimiter == "," and ";" in first and "," not in first:
            delimiter = ";"
        lines = csv.reader(chain([first], text), delimiter=delimiter, quoting=quoting)
        cells = [[unguarded(cell.strip()) for cell in line] for line in lines]
    if headers:
        _check_lengths(path, cells, headers)
    return cells


def _check_lengths(path: Path, cells: list[list[str]], headers: int) -> None:
    """Refuse lines that are longer than the first ones, but for one comma at the end of each."""
    header, rest = max(cells[:headers], key=len, default=[]), cells[headers:]
    if all(len(line) == len(header) + 1 and not line[-1] for line in rest if any(line)):
        return
    for number, line in enumerate(rest, start=headers + 1):
        if len(line) > len(header):
            raise _wrong_length(path, number, line, header)


def read_rows(
    path: Path,
    columns: Sequence[str],
    complaints: list[InputError] | None = None,
    optional: Iterable[str] = (),
) -> list[tuple[int, dict[str, str]]]:
    """Line number and cells by column of every row that is not empty.

    Columns may stand in any order; others are ignored unless they are `optional`. Raises InputError
    when the file is missing or unreadable, or a column is missing. Rows that are wrong are left out
    and appended to `complaints`; without such a list that is raised as well.
    """
    lines = read_cells(path)
    header = lines[0] if lines else []
    foreign = any(sign in name for name in header for sign in ";\t")
    missing = [name for name in columns if name not in header]
    if missing:
        remedy = f"Write the first line as {','.join(columns)}" + (
            ", with commas between the values and decimal points." if foreign else "."
        )
        raise InputError(f"the column {missing[0]!r} is missing in the first line", path, remedy)
    there = [*columns, *(name for name in optional if name in header)]
    place = {name: header.index(name) for name in there}
    rows = []
    for number, line in enumerate(lines[1:], start=2):
        if not any(line):
            continue
        if len(line) <= max(place.values()) or any(line[len(header) :]):
            complaint = _wrong_length(path, number, line, header)
            if complaints is None:
                raise complaint
            complaints.append(complaint)
            continue
        rows.append((number, {name: line[i] for name, i in place.items()}))
    return rows


def _wrong_length(path: Path, number: int, line: list[str], header: list[str]) -> InputError:
    what = f"line {number} has {len(line)} values, expected {len(header)}"
    if len(line) < len(header):
        return InputError(what, path, "Add the missing values or delete the line.")
    return InputError(what, path, "Use decimal points, and commas only between values.")


def finite_number(
    text: str, path: Path, line: int, column: str, remedy: str = "Write a number."
) -> float:
    """Finite number in a cell; InputError where it is none, or larger than anybody writes."""
    try:
        value = typed_number(text)
        if math.isfinite(value) and abs(value) <= LARGEST:
            return value
    except ValueError:
        pass
    raise InputError(f"line {line} has {text!r} as {column}", path, remedy)


def number_or_nan(text: str, path: Path, line: int, column: str) -> float:
    """Finite number in a cell, NaN if it is empty or says so; InputError for anything else."""
    return math.nan if text.lower() in ("", "nan") else finite_number(text, path, line, column)


def whole_number(text: str, path: Path, line: int, column: str) -> int:
    """Whole number in a cell (``3`` or ``3.0``); InputError where it is none."""
    value = finite_number(text, path, line, column, _WHOLE)
    if value != int(value):
        raise InputError(f"line {line} has {text!r} as {column}", path, _WHOLE)
    return int(value)


def markdown_text(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table as Markdown; a heading that begins with ``>`` stands over a right-aligned column."""
    headings = [heading.removeprefix(">") for heading in columns]
    rule = ["---:" if heading.startswith(">") else "---" for heading in columns]
    lines = [headings, rule, *([cell.replace("|", "\\|") for cell in row] for row in rows)]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def read_csv_table(path: Path) -> tuple[tuple[str, ...], tuple[tuple[str, ...], ...]]:
    """Headings and rows of a CSV file; empty lines are left out.

    Raises InputError when the file cannot be read, has no heading, a heading twice, or a row of
    another length.
    """
    filled = [(number, line) for number, line in enumerate(read_cells(path), start=1) if any(line)]
    if not filled or not all(filled[0][1]) or len(set(filled[0][1])) < len(filled[0][1]):
        what = "the first line must name every column exactly once"
        raise InputError(what, path, "Write the column names, separated by commas.")
    headings = filled[0][1]
    for number, line in filled[1:]:
        if len(line) != len(headings):
            what = f"line {number} has {len(line)} values, expected {len(headings)}"
            raise InputError(what, path, "Write one value per column.")
    return tuple(headings), tuple(tuple(line) for _, line in filled[1:])
