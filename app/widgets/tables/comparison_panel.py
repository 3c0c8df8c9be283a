"""Numbers of several runs beside each other, with their differences."""

from __future__ import annotations

import math
from collections.abc import Sequence

from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QResizeEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QLabel,
    QTableWidget,
    QTableWidgetItem,
    QVBoxLayout,
    QWidget,
)

from ..style.limb_colours import LIMB_COLOURS
from ..style.theme import current_theme
from .cells import RIGHT, dress_table, swatch
from .comparison_rows import ComparedCell, ComparedRow

_NOTHING = "Run the tracker to see run metrics here. Show several runs to compare them."
_DIFFERENCE, _VERDICT = "difference (95 %)", "conclusion"
_WIDEST_NAME = 96
_NARROWEST_VERDICT = 150
"""With less room the verdict is only in the tips."""


class ComparisonPanel(QWidget):
    """A row per measure and a column per run; the first run is what others are compared with."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.words = QLabel(_NOTHING, self)
        self.words.setProperty("role", "muted")
        self.words.setWordWrap(True)
        self.words.setContentsMargins(8, 6, 8, 2)
        self._two = False
        self.table = QTableWidget(self)
        dress_table(self.table, "Run comparison", room=4)
        self.table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectItems)
        self.table.setSelectionMode(QAbstractItemView.SelectionMode.ContiguousSelection)
        header = self.table.horizontalHeader()
        header.setTextElideMode(Qt.TextElideMode.ElideMiddle)
        header.setStretchLastSection(True)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(2)
        layout.addWidget(self.words)
        layout.addWidget(self.table, 1)
        self.table.hide()

    def show_numbers(
        self, words: str, runs: Sequence[str], rows: Sequence[ComparedRow], how: str = ""
    ) -> None:
        """Show the values of `runs`; empty `runs` stand for nothing to show.

        Parameters
        ----------
        words : str
            What is compared.
        runs : sequence of str
        rows : sequence of ComparedRow
        how : str
            How the intervals are made, for the tooltip.
        """
        self.words.setText(words if runs else _NOTHING)
        self.words.setToolTip(how)
        self.table.setVisible(bool(runs and rows))
        # two runs leave room for words; of more the intervals and verdicts are in the tips
        self._two = two = len(runs) == 2
        headings = ("measure", *runs, *((_DIFFERENCE, _VERDICT) if two else ()))
        self.table.setColumnCount(len(headings))
        self.table.setRowCount(len(rows))
        for column, heading in enumerate(headings):
            right = column > 0 and heading != _VERDICT
            side = Qt.AlignmentFlag.AlignRight if right else Qt.AlignmentFlag.AlignLeft
            item = QTableWidgetItem(heading)
            item.setToolTip(heading)
            item.setTextAlignment(side | Qt.AlignmentFlag.AlignVCenter)
            self.table.setHorizontalHeaderItem(column, item)
        for place, row in enumerate(rows if runs else ()):
            self.table.setItem(place, 0, _label_item(row.limb, row.label))
            for column, cell in enumerate(row.cells, start=1):
                self.table.setItem(place, column, _value_item(cell, alone=two))
            if two:
                self.table.setItem(place, 3, _difference_item(row.cells[1]))
                self.table.setItem(place, 4, _verdict_item(row.cells[1]))
        self._fit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        """Give numbers the room they need, long names what is left of it."""
        table, header = self.table, self.table.horizontalHeader()
        count = table.columnCount()
        verdict, names = (4, 2) if self._two else (-1, count - 1)
        used = 0
        for column in range(count):
            if column != verdict:
                widest = _WIDEST_NAME if 0 < column <= names else self.width()
                heading = min(header.sectionSizeHint(column), widest)
                width = max(table.sizeHintForColumn(column), heading)
                table.setColumnWidth(column, width)
                used += width
        if verdict > 0:
            table.setColumnHidden(verdict, self.width() - used < _NARROWEST_VERDICT)


def _label_item(limb: str, label: str) -> QTableWidgetItem:
    item = QTableWidgetItem(label)
    item.setData(Qt.ItemDataRole.DecorationRole, swatch(LIMB_COLOURS.get(limb)))
    return item


def _value_item(cell: ComparedCell, *, alone: bool) -> QTableWidgetItem:
    """A value, `alone` or with its difference in brackets."""
    if math.isnan(cell.value):
        words = "" if math.isnan(cell.difference) and not cell.verdict else "unknown"
    else:
        words = f"{cell.value:.1f}"
    if not alone and _has_difference(cell):
        words += f" ({cell.difference:+.1f})"
    item = QTableWidgetItem(words)
    item.setTextAlignment(RIGHT)
    _colour(item, cell)
    item.setToolTip(_sentence(cell.verdict))
    return item


def _difference_item(cell: ComparedCell) -> QTableWidgetItem:
    """How much the second run differs, and the interval where the frames give one."""
    words = ""
    if _has_difference(cell):
        words = f"{cell.difference:+.1f}"
        if not math.isnan(cell.low):
            words += f" ({cell.low:+.1f} to {cell.high:+.1f})"
    item = QTableWidgetItem(words)
    item.setTextAlignment(RIGHT)
    item.setToolTip(_sentence(cell.verdict))
    _colour(item, cell)
    return item


def _verdict_item(cell: ComparedCell) -> QTableWidgetItem:
    item = QTableWidgetItem(cell.verdict)
    item.setToolTip(cell.verdict)
    _colour(item, cell)
    return item


def _has_difference(cell: ComparedCell) -> bool:
    known = not math.isnan(cell.value) and not math.isnan(cell.difference)
    return known and not cell.low == cell.high == 0.0


def _sentence(words: str) -> str:
    return f"{words[0].upper()}{words[1:]}." if words else ""


def _colour(item: QTableWidgetItem, cell: ComparedCell) -> None:
    """Only what the frames can show is coloured."""
    if cell.differs:
        theme = current_theme()
        item.setForeground(QColor(theme.good if cell.difference < 0 else theme.warning))
