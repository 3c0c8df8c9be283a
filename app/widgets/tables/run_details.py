"""All that two runs were made with differently, in a window beside the main one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

from PySide6.QtCore import QSignalBlocker, Signal, Slot
from PySide6.QtWidgets import QCheckBox, QDialog, QHeaderView, QLabel, QWidget

from ..style.building import choice, hbox, label, vbox
from .table import Cell, Column, TableModel, new_table, select_cells

Row: TypeAlias = tuple[str, str, str, bool]
"""What, the first run's value, the second's, and whether they differ."""


class RunDetails(QDialog):
    """Two runs to choose, and a row for all that differs between them, or for everything."""

    asked = Signal(int, int, bool)
    """The two runs that are chosen, and whether what is the same is wanted too."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle("Run details")
        self.resize(640, 460)
        self.first, self.second = choice("First run"), choice("Second run")
        self.everything = QCheckBox("Show equal values", self)
        self.words = label("", "muted")
        self.model = TableModel((), self._cells)
        self.table = new_table(self.model, "Run details")
        select_cells(self.table)
        chosen = hbox((self.first, 1), QLabel("and", self), (self.second, 1), self.everything)
        self.setLayout(vbox(chosen, self.words, (self.table, 1), margins=(9, 9, 9, 9)))
        self.first.currentIndexChanged.connect(self._ask)
        self.second.currentIndexChanged.connect(self._ask)
        self.everything.toggled.connect(self._ask)

    def offer(self, names: Sequence[str], first: int, second: int) -> None:
        """Let the person choose among these runs."""
        for box, place in ((self.first, first), (self.second, second)):
            with QSignalBlocker(box):
                box.clear()
                box.addItems(list(names))
                box.setCurrentIndex(place)
        self._ask()

    def show_rows(self, words: str, rows: Sequence[Row]) -> None:
        """Show what the runs were made with."""
        self.words.setText(words)
        headings = ("", self.first.currentText(), self.second.currentText())
        self.model.show(rows, map(Column, headings))
        header = self.table.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.Stretch)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.ResizeToContents)

    def _cells(self, row: Row) -> Sequence[Cell]:
        *texts, differs = row
        bold = differs and self.everything.isChecked()
        return [Cell(text, text, bold=bold and k > 0) for k, text in enumerate(texts)]

    @Slot()
    def _ask(self) -> None:
        if self.first.count():
            chosen = self.first.currentIndex(), self.second.currentIndex()
            self.asked.emit(*chosen, self.everything.isChecked())
