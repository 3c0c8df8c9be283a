"""The runs of the recording: named, shown or hidden, chosen, removed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

from PySide6.QtCore import QSignalBlocker, QSize, Qt, Signal, Slot
from PySide6.QtGui import QIcon, QPen, QResizeEvent
from PySide6.QtWidgets import (
    QCheckBox,
    QDialog,
    QHeaderView,
    QLabel,
    QLineEdit,
    QTreeWidget,
    QTreeWidgetItem,
    QWidget,
)

from ..style.building import choice, empty_label, hbox, label, tool_button, vbox
from ..style.colours import PEN_STYLES, LineStyle, line_pixmap
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


_HEADINGS = ("Run", "Frames", "Arm error", "Time", "Seed", "Date")
_NARROWEST_NAME = 170


@dataclass(frozen=True)
class RunRow:
    """What the list says about one run, in words."""

    name: str
    style: LineStyle
    """Of its curves and outlines."""
    visible: bool
    active: bool
    frames: str
    """Those it has."""
    score: str
    """Its median error, or how it stands."""
    hint: str
    time: str = ""
    """How long tracking took."""
    seed: str = ""
    when: str = ""
    """When it was tracked, short."""
    made: str = ""
    """Preset and changed parameters."""
    note: str = ""
    """What a person has written about it."""
    noted: bool = False
    """Whether a note can be written: the project keeps the run."""


class RunsPanel(QWidget):
    """A row per run; the tick shows it, a click draws its model, the name can be changed."""

    activated = Signal(int)
    shown = Signal(int, bool)
    renamed = Signal(int, str)
    noted = Signal(int, str)
    details_wanted = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.tree = QTreeWidget()
        self.tree.setHeaderLabels(list(_HEADINGS))
        self.tree.setRootIsDecorated(False)
        self.tree.setIconSize(QSize(30, 14))
        self.tree.setEditTriggers(QTreeWidget.EditTrigger.EditKeyPressed)
        self.tree.setAccessibleName("Runs")
        header = self.tree.header()
        header.setStretchLastSection(False)
        for column in range(1, len(_HEADINGS)):
            header.setSectionResizeMode(column, QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Fixed)
        self.tree.setTextElideMode(Qt.TextElideMode.ElideMiddle)
        self._rows: tuple[RunRow, ...] = ()
        self._noted_row = -1
        self._none = empty_label("Run the tracker or open a run to see it listed here.")
        self.setLayout(vbox(self._none, (self.tree, 1), self._make_foot()))
        self.tree.itemChanged.connect(self._on_changed)
        self.tree.itemClicked.connect(self._on_clicked)
        # a run that is not shown is shown, and read from the project where it has to be
        self.tree.activated.connect(lambda index: self.activated.emit(index.row()))
        self.show_rows(())

    def _make_foot(self) -> QWidget:
        """What the active run was made with, and room for a note."""
        self.foot = QWidget(self)
        self.made = label("", "muted")
        self.made.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.note = QLineEdit(self.foot)
        self.note.setPlaceholderText("Note on this run")
        self.note.setAccessibleName("Note on the active run")
        self.note.setToolTip("Note on the active run")
        self.note.editingFinished.connect(self._on_noted)
        self.details = tool_button("Compare the settings of two runs", text="Details …")
        self.details.setAutoRaise(False)
        self.details.clicked.connect(self.details_wanted)
        lower = hbox((self.note, 1), self.details)
        self.foot.setLayout(vbox(self.made, lower, margins=(8, 2, 8, 6), spacing=4))
        return self.foot

    def show_rows(self, rows: Sequence[RunRow]) -> None:
        """Show these runs."""
        self._rows = tuple(rows)
        self._none.setVisible(not rows)
        self.foot.setVisible(bool(rows))
        self._show_foot()
        self.tree.setVisible(bool(rows))
        with QSignalBlocker(self.tree):
            while self.tree.topLevelItemCount() > len(rows):
                self.tree.takeTopLevelItem(self.tree.topLevelItemCount() - 1)
            while self.tree.topLevelItemCount() < len(rows):
                self.tree.addTopLevelItem(QTreeWidgetItem())
            for place, row in enumerate(rows):
                self._fill(self.tree.topLevelItem(place), row)
        for column, heading in enumerate(("time", "seed", "when"), start=3):
            self.tree.setColumnHidden(column, not any(getattr(row, heading) for row in rows))
        self._fit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        """Give names the room that numbers leave."""
        tree, header = self.tree, self.tree.header()
        others = sum(
            max(tree.sizeHintForColumn(column), header.sectionSizeHint(column))
            for column in range(1, len(_HEADINGS))
            if not tree.isColumnHidden(column)
        )
        bar = tree.verticalScrollBar()
        room = self.width() - 2 * tree.frameWidth() - (bar.width() if bar.isVisible() else 0)
        header.resizeSection(0, max(_NARROWEST_NAME, room - others))

    def _fill(self, item: QTreeWidgetItem | None, row: RunRow) -> None:
        if item is None:
            return
        item.setFlags(
            Qt.ItemFlag.ItemIsEnabled
            | Qt.ItemFlag.ItemIsSelectable
            | Qt.ItemFlag.ItemIsUserCheckable
            | Qt.ItemFlag.ItemIsEditable
        )
        cells = (row.name, row.frames, row.score, row.time, row.seed, row.when)
        for column, text in enumerate(cells):
            item.setText(column, text)
            item.setToolTip(column, row.hint)
            font = item.font(column)
            font.setBold(row.active)
            item.setFont(column, font)
        item.setCheckState(0, Qt.CheckState.Checked if row.visible else Qt.CheckState.Unchecked)
        ratio = self.devicePixelRatioF()
        pen = QPen(self.palette().text().color(), 1.6, PEN_STYLES[row.style])
        item.setIcon(0, QIcon(line_pixmap(pen, ratio)))
        if row.active:
            self.tree.setCurrentItem(item)

    def _show_foot(self) -> None:
        place = next((k for k, row in enumerate(self._rows) if row.active), -1)
        row = self._rows[place] if place >= 0 else None
        self.made.setText(row.made if row is not None else "No run is active.")
        self.note.setEnabled(row is not None and row.noted)
        typing = self.note.hasFocus() and place == self._noted_row and self.note.isModified()
        if not typing:
            self.note.setText(row.note if row is not None else "")
        self._noted_row = place

    @Slot()
    def _on_noted(self) -> None:
        if self._noted_row >= 0 and self.note.isModified():
            self.note.setModified(False)
            self.noted.emit(self._noted_row, self.note.text())

    @Slot(QTreeWidgetItem, int)
    def _on_changed(self, item: QTreeWidgetItem, column: int) -> None:
        place = self.tree.indexOfTopLevelItem(item)
        if column == 0 and place >= 0:
            self.shown.emit(place, item.checkState(0) == Qt.CheckState.Checked)
            self.renamed.emit(place, item.text(0))

    @Slot(QTreeWidgetItem, int)
    def _on_clicked(self, item: QTreeWidgetItem, _column: int) -> None:
        if item.checkState(0) == Qt.CheckState.Checked:
            self.activated.emit(self.tree.indexOfTopLevelItem(item))
