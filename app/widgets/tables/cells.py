"""What tables of the workbench have in common: rows chosen as a whole, swatches, sides, bold."""

from __future__ import annotations

from typing import Protocol

from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QFont, QPixmap
from PySide6.QtWidgets import QAbstractItemView, QTableView

RIGHT = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
LEFT = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter


class _Cell(Protocol):
    def font(self) -> QFont: ...

    def setFont(self, font: QFont, /) -> None: ...


def dress_table(table: QTableView, name: str, room: int = 8) -> None:
    """Make a table of rows that are read: no grid, no row numbers, `room` pixels beside words."""
    table.setAccessibleName(name)
    table.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
    table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
    table.setFrameShape(QTableView.Shape.NoFrame)
    table.setShowGrid(False)
    table.setAlternatingRowColors(True)
    table.setWordWrap(False)
    table.setTabKeyNavigation(False)
    table.verticalHeader().hide()
    table.verticalHeader().setDefaultSectionSize(table.fontMetrics().height() + room)
    table.horizontalHeader().setHighlightSections(False)


def swatch(colour: str | None, size: int = 10) -> QPixmap:
    """Return a square of that colour; a transparent one for none keeps words in line."""
    result = QPixmap(size, size)
    result.fill(QColor(colour) if colour else Qt.GlobalColor.transparent)
    return result


def make_bold(cell: _Cell) -> None:
    """Write a cell in bold."""
    font = cell.font()
    font.setBold(True)
    cell.setFont(font)
