"""Attempts beside the run: what they changed, and how much better or worse they are."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtGui import QAction, QColor, QKeyEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QProgressBar,
    QTableWidget,
    QTableWidgetItem,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from ..style.theme import current_theme
from .cells import RIGHT, dress_table

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
    """The run or an attempt.

    Attributes
    ----------
    name, changed : str
        What it is called, and what it changed.
    values, changes : tuple of float
        In the order of the table's headings, the last of which counts; NaN where not known.
    is_run : bool
    is_base : bool
        Whether it is what the others are compared with.
    """

    name: str
    changed: str
    values: tuple[float, ...]
    changes: tuple[float, ...]
    is_run: bool
    is_base: bool


@dataclass(frozen=True)
class AttemptTable:
    """Rows of :class:`AttemptRow` and the headings of their values."""

    headings: tuple[str, ...] = ()
    rows: tuple[AttemptRow, ...] = ()


class AttemptsPanel(QWidget):
    """A row for the run and for each attempt.

    Signals
    -------
    chosen : int
        Row that a person has selected; -1 for none.
    base_chosen : int
        Row that the others shall be compared with.
    dismissed : int
        Row that shall go, by Del.
    """

    chosen = Signal(int)
    base_chosen = Signal(int)
    dismissed = Signal(int)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.words = QLabel(self)
        self.words.setWordWrap(True)
        self.words.setContentsMargins(8, 6, 8, 0)
        self.stretch_words = QLabel(self)
        self.stretch_words.setWordWrap(True)
        self.stretch_words.setProperty("role", "muted")
        self.stretch_words.setContentsMargins(8, 0, 8, 2)
        self.progress = QProgressBar(self)
        self.progress.setTextVisible(False)
        self.progress.setMaximumHeight(4)
        self.table = QTableWidget(self)
        dress_table(self.table, "Trials")
        self.table.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.table.verticalHeader().setDefaultSectionSize(38)
        self.table.itemSelectionChanged.connect(lambda: self.chosen.emit(self.row))
        self.table.cellDoubleClicked.connect(lambda row, _column: self.base_chosen.emit(row))
        self._nothing = QLabel(_NOTHING, self)
        self._nothing.setProperty("role", "muted")
        self._nothing.setWordWrap(True)
        self._nothing.setContentsMargins(8, 8, 8, 8)
        self._nothing.setAlignment(Qt.AlignmentFlag.AlignTop)
        self._buttons = QHBoxLayout()
        self._buttons.setContentsMargins(6, 0, 6, 0)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 4)
        layout.setSpacing(2)
        layout.addWidget(self.words)
        layout.addWidget(self.stretch_words)
        layout.addWidget(self.progress)
        layout.addWidget(self._nothing, 1)
        layout.addWidget(self.table, 1)
        layout.addLayout(self._buttons)
        self.show_progress(0, 0)
        self.show_table(AttemptTable())

    @property
    def row(self) -> int:
        """Row that is selected; -1 for none."""
        rows = self.table.selectionModel().selectedRows()
        return rows[0].row() if rows else -1

    def set_actions(self, actions: Sequence[QAction]) -> None:
        """Offer commands beside the table."""
        for action in actions:
            button = QToolButton(self)
            button.setDefaultAction(action)
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextOnly)
            self._buttons.addWidget(button)
        self._buttons.addStretch(1)

    def show_words(self, words: str, stretch: str) -> None:
        """Say what is being done or would be, and on which frames."""
        self.words.setText(words)
        self.words.setVisible(bool(words))
        self.stretch_words.setText(stretch)
        self.stretch_words.setVisible(bool(stretch))

    def show_progress(self, done: int, count: int) -> None:
        """Show how many of `count` frames are done; nothing where `count` is 0."""
        self.progress.setRange(0, max(count, 1))
        self.progress.setValue(done if count else 0)

    def show_table(self, table: AttemptTable) -> None:
        """Show the run and its attempts; what is selected stays."""
        attempts = any(not row.is_run for row in table.rows)
        self.table.setVisible(attempts)
        self._nothing.setVisible(not attempts)
        keeps = self.row
        with QSignalBlocker(self.table):
            headings = ("Trial", *table.headings)
            self.table.setColumnCount(len(headings))
            self.table.setHorizontalHeaderLabels(headings)
            self.table.setRowCount(len(table.rows) if attempts else 0)
            for place, row in enumerate(table.rows if attempts else ()):
                self._fill(place, row)
            if 0 <= keeps < self.table.rowCount():
                self.table.selectRow(keeps)
        header = self.table.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Interactive)
        if attempts:
            self.table.setColumnWidth(0, min(self.table.sizeHintForColumn(0) + 8, _NAME_WIDTH))
        header.setToolTip(_TIP)

    def _fill(self, place: int, row: AttemptRow) -> None:
        text = f"{'◆ ' if row.is_base else ''}{row.name}\n{row.changed}"
        item = QTableWidgetItem(text)
        item.setToolTip(text)
        font = item.font()
        font.setBold(row.is_run)
        item.setFont(font)
        self.table.setItem(place, 0, item)
        for column, (value, change) in enumerate(
            zip(row.values, row.changes, strict=True), start=1
        ):
            counted = column == len(row.values)
            item = _value_item(value, change, row.is_base, 0 if counted else 1)
            self.table.setItem(place, column, item)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Delete and self.row >= 0:
            self.dismissed.emit(self.row)
        else:
            super().keyPressEvent(event)


def _value_item(value: float, change: float, is_base: bool, digits: int) -> QTableWidgetItem:
    item = QTableWidgetItem("…" if math.isnan(value) else f"{value:.{digits}f}")
    item.setTextAlignment(RIGHT)
    item.setToolTip(_TIP)
    if not is_base and abs(change) >= _WORTH_SAYING:
        item.setText(f"{value:.{digits}f} ({change:+.{digits}f})")
        theme = current_theme()
        item.setForeground(QColor(theme.good if change < 0 else theme.warning))
    return item
