"""The numbers of the frame in a table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction, QGuiApplication, QKeySequence
from PySide6.QtWidgets import QHeaderView, QStackedLayout, QWidget

from ..style.building import label
from ..style.limb_colours import LIMB_COLOURS, limb_words
from .table import RIGHT, Cell, Column, RowDelegate, TableModel, new_table, selected_rows

NumberRow: TypeAlias = tuple[str, str, str, str]
"""Limb (empty for none), label, value with its unit, and a hint in words."""

_VALUE_TIP = (
    "For a limb: its angular error, where there is a reference. After ±: the standard deviation "
    "of its direction as estimated by the filter. This is small also when the filter tracks the "
    "wrong points."
)
_COLUMNS = (
    Column(""),
    Column("Measure"),
    Column("Value", _VALUE_TIP, RIGHT, even=True),
    Column("Remark"),
)


class NumbersPanel(QWidget):
    """Table of numbers, each with its limb's colour; Ctrl+C copies what is selected."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._model = TableModel(_COLUMNS, _cells)
        self.table = new_table(self._model, "Frame metrics")
        self.table.setItemDelegate(RowDelegate(self.table))
        header = self.table.horizontalHeader()
        header.setMinimumSectionSize(28)
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Fixed)
        header.resizeSection(0, 28)
        header.setSectionResizeMode(3, QHeaderView.ResizeMode.Stretch)
        nothing = label("Run the tracker to see metrics of this frame.", "muted")
        nothing.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._stack = QStackedLayout(self)
        self._stack.addWidget(nothing)
        self._stack.addWidget(self.table)
        copy = QAction("Copy metrics", self.table)
        copy.setShortcut(QKeySequence.StandardKey.Copy)
        copy.setShortcutContext(Qt.ShortcutContext.WidgetShortcut)
        copy.triggered.connect(lambda: QGuiApplication.clipboard().setText(self.copied_text()))
        self.table.addAction(copy)
        self.table.setContextMenuPolicy(Qt.ContextMenuPolicy.ActionsContextMenu)

    def show_rows(self, rows: Sequence[NumberRow]) -> None:
        """Show limb, label, value and hint of each row; selection and scroll place stay."""
        self._model.show(tuple(rows))
        self._stack.setCurrentIndex(1 if rows else 0)

    def copied_text(self) -> str:
        """Selected rows, or all, with tabs between the columns."""
        rows = self._model.rows
        chosen = selected_rows(self.table) or range(len(rows))
        return "\n".join("\t".join(rows[place]) for place in chosen)


def _cells(row: NumberRow) -> Sequence[Cell]:
    limb, name, value, hint = row
    tip = hint or (_VALUE_TIP if limb else name)
    return (
        Cell(tip=tip, swatch=LIMB_COLOURS.get(limb), said=limb_words(limb)),
        Cell(name, tip),
        Cell(value, tip),
        Cell(hint, tip, "muted"),
    )
