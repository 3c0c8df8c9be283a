"""What the table of a study shows: its columns, its cells, and which rows are wanted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from stereotrack_core.errors import InputError
from stereotrack_core.study.file import Study, StudyRow, selected
from stereotrack_core.study.places import Place
from stereotrack_core.study.shown import COLUMNS, messages_of, text_of
from stereotrack_core.study.status import RowStatus

from ...widgets.tables.table import LEFT, RIGHT, Cell, Column

FACTOR_TIP = (
    "Double-click a cell to edit it, or press F2: with several recordings selected, what you write "
    "goes into all of them."
)
_UNKNOWN = float("-inf")
"""What is not known comes first where rows are sorted by a number."""


def columns_of(study: Study) -> list[Column]:
    """Columns of the table: the recording, factors, what is known, the first message."""
    return [
        Column("recording", "Folder of the recording, relative to the study file."),
        *(Column(name, FACTOR_TIP) for name in study.factors),
        *(Column(one.label, one.help, align=RIGHT if one.is_number else LEFT) for one in COLUMNS),
        Column("message", "The gravest problem. Select the row to see all of them."),
    ]


def factor_at(study: Study, column: int) -> str:
    """The factor that a column of the table shows; empty where it shows something else."""
    return study.factors[column - 1] if 1 <= column <= len(study.factors) else ""


def statuses(study: Study, known: Mapping[str, RowStatus]) -> list[RowStatus]:
    """What is known of each row of a study, by recording; rows say what the study says."""
    return [_status(study, row, known.get(row.recording)) for row in study.rows]


def _status(study: Study, row: StudyRow, known: RowStatus | None) -> RowStatus:
    if known is not None and known.row.project == row.project:
        return replace(known, row=row)
    project = study.place(row.project) if row.project else None
    return RowStatus(row, Place(study.place(row.recording), project))


def is_unread(row: RowStatus) -> bool:
    """Whether nothing was read of a row yet."""
    return row.recording is None and not row.findings


def cells_of(study: Study, row: RowStatus) -> list[Cell]:
    """Cells of a row."""
    messages = messages_of(row)
    unread = is_unread(row)
    missing = row.place.folder is None
    last = "not read yet" if unread else messages[0] if messages else ""
    return [
        Cell(row.row.recording, str(row.place.folder or ""), "error" if missing else ""),
        *(Cell(row.row.factors.get(name, "")) for name in study.factors),
        *(Cell(text_of(one, row), value=_sorted(one.value(row))) for one in COLUMNS),
        Cell(last, "\n".join(messages), "muted" if unread else ""),
    ]


def _sorted(value: float | str | None) -> float | str:
    return _UNKNOWN if value is None else value


@dataclass(frozen=True)
class Order:
    """How rows are sorted: by a column, or as in the study file."""

    column: int = -1
    ascending: bool = True


def arranged(study: Study, rows: Sequence[RowStatus], wanted: str, order: Order) -> list[RowStatus]:
    """Rows that a filter lets through, in their order."""
    let_through = _wanted(study, rows, wanted)
    shown = [row for row in rows if row.row.recording in let_through]
    if order.column < 0:
        return shown
    keys = {row.row.recording: cells_of(study, row)[order.column] for row in shown}

    def key(row: RowStatus) -> tuple[bool, float, str]:
        cell = keys[row.row.recording]
        value = cell.text if cell.value is None else cell.value
        is_text = isinstance(value, str)
        return is_text, 0.0 if is_text else float(value), value.lower() if is_text else ""

    return sorted(shown, key=key, reverse=not order.ascending)


def _wanted(study: Study, rows: Sequence[RowStatus], text: str) -> set[str]:
    """Recordings that agree with every word: ``column=value``, or anything that a row shows."""
    found = {row.row.recording for row in rows}
    for word in text.split():
        if word.endswith("="):  # the value is still to be typed
            continue
        try:
            if "=" not in word:
                raise InputError(word, remedy=word)
            found &= {row.recording for row in selected(study, [word])}
        except InputError:  # no column, so it is looked for
            found &= {row.row.recording for row in rows if _shows(study, row, word.lower())}
    return found


def _shows(study: Study, row: RowStatus, word: str) -> bool:
    return any(word in cell.text.lower() for cell in cells_of(study, row))
