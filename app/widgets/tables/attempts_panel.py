"""Attempts beside the run: what they changed, and how much better or worse they are."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtGui import QAction, QKeyEvent
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QWidget

from ..style.building import action_button, empty_label, hbox, label, thin_progress, vbox
from .table import RIGHT, Cell, Column, TableModel, new_table, selected_rows

_WORTH_SAYING = 0.05
_NAME_WIDTH = 172
_NOTHING = (
    "Change a parameter to run a trial: the selected frames are tracked again, and the trial is "
    "drawn dashed beside the run until you discard it."
)
_TIP = (
    "Mean over the frames of the trial; in brackets the difference from the baseline row, marked "
    "◆. Lower is better. Double-click a row to make it the baseline."
)


@dataclass(frozen=True)
class AttemptRow:
    """The run or an attempt: what it is called, what it changed, and what that comes to."""

    name: str
    changed: str
    values: tuple[float, ...]
    """In the order of the table's headings, the last of which counts; NaN where not known."""
    changes: tuple[float, ...]
    """The same less those of the base."""
    is_run: bool
    is_base: bool
    """Whether it is what the others are compared with."""


@dataclass(frozen=True)
class AttemptTable:
    """Rows of :class:`AttemptRow` and the headings of their values."""

    headings: tuple[str, ...] = ()
    rows: tuple[AttemptRow, ...] = ()


class AttemptsPanel(QWidget):
    """A row for the run and for each attempt."""

    chosen = Signal(int)
    """Row that a person has selected; -1 for none."""
    base_chosen = Signal(int)
    """Row that the others shall be compared with."""
    dismissed = Signal(int)
    """Row that shall go, by Del."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.words = label(margins=(8, 6, 8, 0))
        self.stretch_words = label("", "muted", margins=(8, 0, 8, 2))
        self.progress = thin_progress()
        self.model = TableModel((), _cells)
        self.table = new_table(self.model, "Trials")
        self.table.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.table.verticalHeader().setDefaultSectionSize(38)
        self.table.selectionModel().selectionChanged.connect(lambda: self.chosen.emit(self.row))
        self.table.doubleClicked.connect(lambda index: self.base_chosen.emit(index.row()))
        self._nothing = empty_label(_NOTHING)
        self._buttons = hbox(margins=(6, 0, 6, 0))
        below = ((self._nothing, 1), (self.table, 1), self._buttons)
        head = (self.words, self.stretch_words, self.progress)
        self.setLayout(vbox(*head, *below, margins=(0, 0, 0, 4), spacing=2))
        self.show_progress(0, 0)
        self.show_table(AttemptTable())

    @property
    def row(self) -> int:
        """Row that is selected; -1 for none."""
        return next(iter(selected_rows(self.table)), -1)

    def set_actions(self, actions: Sequence[QAction]) -> None:
        """Offer commands beside the table."""
        for action in actions:
            button = action_button(action)
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextOnly)
            self._buttons.addWidget(button)
        self._buttons.addStretch(1)

    def show_words(self, words: str, stretch: str) -> None:
        """Say what is being done or would be, and on which frames."""
        for shown, text in ((self.words, words), (self.stretch_words, stretch)):
            shown.setText(text)
            shown.setVisible(bool(text))

    def show_progress(self, done: int, count: int) -> None:
        """Show how many of `count` frames are done; nothing where `count` is 0."""
        self.progress.setRange(0, max(count, 1))
        self.progress.setValue(done if count else 0)

    def show_table(self, table: AttemptTable) -> None:
        """Show the run and its attempts; what is selected stays."""
        rows = table.rows if any(not row.is_run for row in table.rows) else ()
        self.table.setVisible(bool(rows))
        self._nothing.setVisible(not rows)
        keeps = self.row
        headings = (Column(heading, _TIP, align=RIGHT) for heading in table.headings)
        with QSignalBlocker(self.table.selectionModel()):
            self.model.show(rows, (Column("Trial", _TIP), *headings))
            if 0 <= keeps < len(rows):
                self.table.selectRow(keeps)
        if rows:
            header = self.table.horizontalHeader()
            header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
            header.setSectionResizeMode(0, QHeaderView.ResizeMode.Interactive)
            self.table.setColumnWidth(0, min(self.table.sizeHintForColumn(0) + 8, _NAME_WIDTH))

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Delete and self.row >= 0:
            self.dismissed.emit(self.row)
        else:
            super().keyPressEvent(event)


def _cells(row: AttemptRow) -> Sequence[Cell]:
    name = f"{'◆ ' if row.is_base else ''}{row.name}\n{row.changed}"
    digits = [1] * (len(row.values) - 1) + [0]
    numbers = zip(row.values, row.changes, digits, strict=True)
    return (Cell(name, name, bold=row.is_run), *(_number(*one, row.is_base) for one in numbers))


def _number(value: float, change: float, digits: int, is_base: bool) -> Cell:
    if not is_base and abs(change) >= _WORTH_SAYING:
        colour = "good" if change < 0 else "warning"
        return Cell(f"{value:.{digits}f} ({change:+.{digits}f})", _TIP, colour)
    return Cell("…" if math.isnan(value) else f"{value:.{digits}f}", _TIP)
