"""Numbers of several runs beside each other, with their differences."""

from __future__ import annotations

import math
from collections.abc import Sequence

from PySide6.QtCore import Qt
from PySide6.QtGui import QColor
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QLabel,
    QTableWidget,
    QTableWidgetItem,
    QVBoxLayout,
    QWidget,
)

from app.limb_colours import LIMB_COLOURS
from app.theme import current_theme
from app.views.cells import RIGHT, dress_table, swatch
from app.views.comparison_rows import ComparedCell, ComparedRow

_NOTHING = "Numbers come here when there is a run; with several, how much they differ."


class ComparisonPanel(QWidget):
    """A row per measure and a column per run; the first run is what others are compared with."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.words = QLabel(_NOTHING, self)
        self.words.setProperty("role", "muted")
        self.words.setWordWrap(True)
        self.words.setContentsMargins(8, 6, 8, 2)
        self.table = QTableWidget(self)
        dress_table(self.table, "Runs beside each other", room=4)
        self.table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectItems)
        self.table.setSelectionMode(QAbstractItemView.SelectionMode.ContiguousSelection)
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
        # of two runs the verdict has room beside the numbers; of more it is in the tooltips
        verdicts = ("What these frames show",) if len(runs) == 2 else ()
        headings = ("Measure", *runs, *verdicts)
        self.table.setColumnCount(len(headings))
        self.table.setRowCount(len(rows))
        for column, heading in enumerate(headings):
            right = 0 < column <= len(runs)
            side = Qt.AlignmentFlag.AlignRight if right else Qt.AlignmentFlag.AlignLeft
            item = QTableWidgetItem(heading)
            item.setToolTip(heading)
            item.setTextAlignment(side | Qt.AlignmentFlag.AlignVCenter)
            self.table.setHorizontalHeaderItem(column, item)
        header = self.table.horizontalHeader()
        header.setMinimumSectionSize(60)
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setStretchLastSection(True)
        for place, row in enumerate(rows if runs else ()):
            self.table.setItem(place, 0, _label_item(row.limb, row.label))
            for column, cell in enumerate(row.cells, start=1):
                self.table.setItem(place, column, _value_item(cell))
            if verdicts:
                self.table.setItem(place, len(runs) + 1, _verdict_item(row.cells[1]))


def _label_item(limb: str, label: str) -> QTableWidgetItem:
    item = QTableWidgetItem(label)
    item.setData(Qt.ItemDataRole.DecorationRole, swatch(LIMB_COLOURS.get(limb)))
    return item


def _value_item(cell: ComparedCell) -> QTableWidgetItem:
    item = QTableWidgetItem(_words_of(cell))
    item.setTextAlignment(RIGHT)
    _colour(item, cell)
    if cell.verdict:
        item.setToolTip(f"{cell.verdict[0].upper()}{cell.verdict[1:]}.")
    return item


def _verdict_item(cell: ComparedCell) -> QTableWidgetItem:
    item = QTableWidgetItem(cell.verdict)
    item.setToolTip(cell.verdict)
    _colour(item, cell)
    return item


def _words_of(cell: ComparedCell) -> str:
    if math.isnan(cell.value):
        return "" if math.isnan(cell.difference) and not cell.verdict else "not known"
    if math.isnan(cell.difference) or cell.low == cell.high == 0.0:
        return f"{cell.value:.1f}"
    if math.isnan(cell.low):
        return f"{cell.value:.1f}   ({cell.difference:+.1f})"
    return f"{cell.value:.1f}   ({cell.difference:+.1f}; {cell.low:+.1f} to {cell.high:+.1f})"


def _colour(item: QTableWidgetItem, cell: ComparedCell) -> None:
    """Only what the frames can show is coloured."""
    if cell.differs:
        theme = current_theme()
        item.setForeground(QColor(theme.good if cell.difference < 0 else theme.warning))
