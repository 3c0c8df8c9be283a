"""All that two runs were made with differently, in a window beside the main one."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import Qt, Signal, Slot
from PySide6.QtWidgets import (
    QAbstractItemView,
    QCheckBox,
    QComboBox,
    QDialog,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QTableWidget,
    QTableWidgetItem,
    QVBoxLayout,
    QWidget,
)

from .cells import dress_table

Rows = Sequence[tuple[str, str, str, bool]]


class RunDetails(QDialog):
    """Two runs to choose, and a row for all that differs between them, or for everything.

    Signals
    -------
    asked : int, int, bool
        The two runs that are chosen, and whether what is the same is wanted too.
    """

    asked = Signal(int, int, bool)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle("Run details")
        self.resize(640, 460)
        self.first, self.second = QComboBox(self), QComboBox(self)
        self.first.setAccessibleName("First run")
        self.second.setAccessibleName("Second run")
        self.everything = QCheckBox("Show equal values", self)
        self.words = QLabel(self)
        self.words.setWordWrap(True)
        self.words.setProperty("role", "muted")
        self.table = QTableWidget(0, 3, self)
        dress_table(self.table, "Run details")
        self.table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectItems)
        self.table.setSelectionMode(QAbstractItemView.SelectionMode.ContiguousSelection)
        self._lay_out()
        self.first.currentIndexChanged.connect(self._ask)
        self.second.currentIndexChanged.connect(self._ask)
        self.everything.toggled.connect(self._ask)

    def _lay_out(self) -> None:
        choice = QHBoxLayout()
        choice.addWidget(self.first, 1)
        choice.addWidget(QLabel("and", self))
        choice.addWidget(self.second, 1)
        choice.addWidget(self.everything)
        column = QVBoxLayout(self)
        column.addLayout(choice)
        column.addWidget(self.words)
        column.addWidget(self.table, 1)

    def offer(self, names: Sequence[str], first: int, second: int) -> None:
        """Let the person choose among these runs."""
        for box, place in ((self.first, first), (self.second, second)):
            box.blockSignals(True)
            box.clear()
            box.addItems(list(names))
            box.setCurrentIndex(place)
            box.blockSignals(False)
        self._ask()

    def show_rows(self, words: str, rows: Rows) -> None:
        """Show rows: what, the first run's value, the second's, and whether they differ."""
        self.words.setText(words)
        self.table.setHorizontalHeaderLabels(
            ["", self.first.currentText(), self.second.currentText()]
        )
        self.table.setRowCount(len(rows))
        for place, (what, first, second, differs) in enumerate(rows):
            for column, text in enumerate((what, first, second)):
                item = QTableWidgetItem(text)
                font = item.font()
                font.setBold(differs and column > 0 and self.everything.isChecked())
                item.setFont(font)
                item.setToolTip(text)
                self.table.setItem(place, column, item)
        header = self.table.horizontalHeader()
        header.setDefaultAlignment(Qt.AlignmentFlag.AlignLeft)
        header.setSectionResizeMode(QHeaderView.ResizeMode.Stretch)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.ResizeToContents)

    @Slot()
    def _ask(self) -> None:
        if self.first.count():
            chosen = self.first.currentIndex(), self.second.currentIndex()
            self.asked.emit(*chosen, self.everything.isChecked())
