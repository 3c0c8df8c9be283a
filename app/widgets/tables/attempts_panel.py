"""Attempts beside the run: what they changed, and how much better or worse they are."""

from __future__ import annotations

import math
from collections.abc import Sequence

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtGui import QAction, QKeyEvent
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QWidget

from ..style.building import action_button, empty_label, hbox, label, thin_progress, vbox
from .table import RIGHT, Cell, CellRow, Column, TableModel, new_table, selected_rows

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
        self.model: TableModel[CellRow] = TableModel()
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
        self.show_table((), ())

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

    def show_table(self, headings: Sequence[str], rows: Sequence[CellRow]) -> None:
        """Show a name and numbers of the run and its trials; what is selected stays."""
        self.table.setVisible(bool(rows))
        self._nothing.setVisible(not rows)
        keeps = self.row
        numbers = (Column(heading, _TIP, align=RIGHT) for heading in headings)
        with QSignalBlocker(self.table.selectionModel()):
            self.model.show(rows, (Column("Trial", _TIP), *numbers))
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


def number_cell(value: float, change: float, digits: int) -> Cell:
    """A number with its change, NaN where there is none, of which less is better."""
    if abs(change) >= _WORTH_SAYING:
        colour = "good" if change < 0 else "warning"
        return Cell(f"{value:.{digits}f} ({change:+.{digits}f})", _TIP, colour)
    return Cell("…" if math.isnan(value) else f"{value:.{digits}f}", _TIP)
