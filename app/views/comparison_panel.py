"""Numbers of several runs beside each other, with their differences."""

from __future__ import annotations

import math
from collections.abc import Sequence

from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QPixmap
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

_WORTH_A_COLOUR = 0.05
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
        self.table.setAccessibleName("Runs beside each other")
        self.table.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.table.setSelectionMode(QAbstractItemView.SelectionMode.ContiguousSelection)
        self.table.setShowGrid(False)
        self.table.setAlternatingRowColors(True)
        self.table.verticalHeader().hide()
        self.table.verticalHeader().setDefaultSectionSize(20)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(2)
        layout.addWidget(self.words)
        layout.addWidget(self.table, 1)
        self.table.hide()

    def show_numbers(
        self,
        words: str,
        runs: Sequence[str],
        rows: Sequence[tuple[str, str, tuple[float, ...]]],
    ) -> None:
        """Show the values of `runs`; empty `runs` stand for nothing to show.

        Parameters
        ----------
        words : str
            What is compared.
        runs : sequence of str
        rows : sequence of (str, str, tuple of float)
            Limb (empty for none), label, and a value for each run, of which less is better.
        """
        self.words.setText(words if runs else _NOTHING)
        self.table.setVisible(bool(runs))
        self.table.setColumnCount(1 + len(runs))
        self.table.setRowCount(len(rows) if runs else 0)
        for column, heading in enumerate(("Measure", *runs)):
            side = Qt.AlignmentFlag.AlignRight if column else Qt.AlignmentFlag.AlignLeft
            item = QTableWidgetItem(heading)
            item.setTextAlignment(side | Qt.AlignmentFlag.AlignVCenter)
            self.table.setHorizontalHeaderItem(column, item)
        header = self.table.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.Stretch)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.ResizeToContents)
        header.setMinimumSectionSize(60)
        for place, (limb, label, values) in enumerate(rows if runs else ()):
            self.table.setItem(place, 0, _label_item(limb, label))
            for column, value in enumerate(values, start=1):
                self.table.setItem(place, column, _value_item(value, values[0], column > 1))


def _label_item(limb: str, label: str) -> QTableWidgetItem:
    item = QTableWidgetItem(label)
    swatch = QPixmap(10, 10)
    swatch.fill(QColor(LIMB_COLOURS[limb]) if limb else Qt.GlobalColor.transparent)
    item.setData(Qt.ItemDataRole.DecorationRole, swatch)
    return item


def _value_item(value: float, base: float, differs: bool) -> QTableWidgetItem:
    item = QTableWidgetItem("not known" if math.isnan(value) else f"{value:.1f}")
    item.setTextAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
    change = value - base
    if differs and not math.isnan(change):
        item.setText(f"{value:.1f}   ({change:+.1f})")
        if abs(change) >= _WORTH_A_COLOUR:
            theme = current_theme()
            item.setForeground(QColor(theme.good if change < 0 else theme.warning))
        item.setToolTip("In brackets: the difference from the active run; less is better.")
    return item
