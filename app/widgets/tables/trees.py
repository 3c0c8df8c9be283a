"""Rows under rows, such as the pictures of cameras."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from PySide6.QtCore import QEvent, QSignalBlocker, Qt
from PySide6.QtGui import QColor, QResizeEvent
from PySide6.QtWidgets import QTreeWidget, QTreeWidgetItem

from ..style.theme import current_theme
from .table import VALUE, Cell, CellRow, Column, dress_list, fit_list, swatch


@dataclass(frozen=True)
class TreeRow:
    """A row and those under it."""

    cells: CellRow
    rows: tuple[TreeRow, ...] = ()


class CellTree(QTreeWidget):
    """Rows under rows; what a person has opened or closed stays so.

    The key of a row is the value of its first cell; None for a row that the program never asks
    about. `change` is called with the key of a row that a person has ticked or renamed, whether it
    is ticked, and its text; `chosen` with the key of the row that has become the current one.
    """

    def __init__(
        self,
        name: str,
        columns: Sequence[Column],
        change: Callable[[Any, bool, str], object],
        chosen: Callable[[Any], object] = lambda _key: None,
        least: int = 72,
    ) -> None:
        super().__init__()
        self._change, self._chosen = change, chosen
        self._columns, self._least = tuple(columns), least
        self._rows: tuple[TreeRow, ...] = ()
        self.setHeaderLabels([column.heading for column in columns])
        for place, column in enumerate(columns):
            self.headerItem().setToolTip(place, column.tip)
            self.headerItem().setTextAlignment(place, column.align)
        dress_list(self, name, [column.width for column in columns])
        self.setRootIsDecorated(True)
        self.setIndentation(14)
        self.itemChanged.connect(self._on_changed)
        self.currentItemChanged.connect(self._on_current)

    def show_rows(self, rows: Sequence[TreeRow]) -> None:
        """Show these; items stay where they are, so that the current one does."""
        if tuple(rows) != self._rows:
            self._rows = tuple(rows)
            self._write()

    def item_of(self, key: object) -> QTreeWidgetItem | None:
        every = self.findItems("", Qt.MatchFlag.MatchContains | Qt.MatchFlag.MatchRecursive)
        return next((one for one in every if one.data(0, VALUE) == key), None)

    def choose(self, key: object) -> None:
        if item := self.item_of(key):
            self.setCurrentItem(item)

    def _write(self) -> None:
        with QSignalBlocker(self):
            self._fill(self.invisibleRootItem(), self._rows)
        self._fit()

    def _fill(self, parent: QTreeWidgetItem, rows: Sequence[TreeRow]) -> None:
        while parent.childCount() > len(rows):
            parent.takeChild(parent.childCount() - 1)
        known = parent.childCount()
        parent.addChildren([QTreeWidgetItem() for _ in range(len(rows) - known)])
        items = [item for place in range(len(rows)) if (item := parent.child(place)) is not None]
        for place, (item, row) in enumerate(zip(items, rows, strict=True)):
            for column, cell in enumerate(row.cells):
                _write_cell(item, column, cell, self._columns[column].align)
            self._fill(item, row.rows)
            if place >= known:
                item.setExpanded(True)

    def _fit(self) -> None:
        fit_list(self, [column.width for column in self._columns], self._least)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def changeEvent(self, event: QEvent) -> None:
        if event.type() == QEvent.Type.PaletteChange:
            self._write()
        super().changeEvent(event)

    def _on_changed(self, item: QTreeWidgetItem, column: int) -> None:
        key = item.data(0, VALUE)
        if column == 0 and key is not None:
            self._rows = ()  # what is shown now may be refused
            self._change(key, item.checkState(0) == Qt.CheckState.Checked, item.text(0))

    def _on_current(self, item: QTreeWidgetItem | None, _before: object) -> None:
        key = None if item is None else item.data(0, VALUE)
        if key is not None:
            self._chosen(key)


def _write_cell(item: QTreeWidgetItem, place: int, cell: Cell, align: Qt.AlignmentFlag) -> None:
    item.setText(place, cell.text)
    item.setToolTip(place, cell.tip)
    item.setTextAlignment(place, align)
    item.setData(place, VALUE, cell.value)
    picture = None if cell.swatch is None else swatch(cell.swatch)
    item.setData(place, Qt.ItemDataRole.DecorationRole, picture)
    colour = QColor(getattr(current_theme(), cell.colour)) if cell.colour else None
    item.setData(place, Qt.ItemDataRole.ForegroundRole, colour)
    font = item.font(place)
    font.setBold(cell.bold)
    item.setFont(place, font)
    if place == 0:
        flags, ticks = Qt.ItemFlag, cell.ticked is not None
        may = flags.ItemIsUserCheckable if ticks else flags.NoItemFlags
        may |= flags.ItemIsEditable if cell.editable else flags.NoItemFlags
        item.setFlags(flags.ItemIsEnabled | flags.ItemIsSelectable | may)
        on = Qt.CheckState.Checked if cell.ticked else Qt.CheckState.Unchecked
        item.setData(0, Qt.ItemDataRole.CheckStateRole, on if ticks else None)
