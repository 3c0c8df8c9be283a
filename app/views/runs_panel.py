"""The runs of the recording: named, shown or hidden, chosen, removed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import QSignalBlocker, QSize, Qt, Signal, Slot
from PySide6.QtGui import QIcon, QPainter, QPen, QPixmap
from PySide6.QtWidgets import (
    QHeaderView,
    QLabel,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)


@dataclass(frozen=True)
class RunRow:
    """What the list says about one run.

    Attributes
    ----------
    name : str
    dashed : bool
        Line style of its curves.
    visible : bool
    active : bool
    frames : str
        Frames it has, in words.
    score : str
        Its median error, or how it stands.
    hint : str
    """

    name: str
    dashed: bool
    visible: bool
    active: bool
    frames: str
    score: str
    hint: str


class RunsPanel(QWidget):
    """A row per run; the tick shows it, a click draws its model, the name can be changed.

    Signals
    -------
    activated : int
    shown : int, bool
    renamed : int, str
    """

    activated = Signal(int)
    shown = Signal(int, bool)
    renamed = Signal(int, str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.tree = QTreeWidget()
        self.tree.setHeaderLabels(["Run", "Frames", "Median arm error"])
        self.tree.setRootIsDecorated(False)
        self.tree.setIconSize(QSize(30, 14))
        self.tree.setEditTriggers(QTreeWidget.EditTrigger.EditKeyPressed)
        self.tree.setAccessibleName("Runs")
        header = self.tree.header()
        header.setStretchLastSection(False)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        header.setSectionResizeMode(1, QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(2, QHeaderView.ResizeMode.ResizeToContents)
        self._none = QLabel("No run yet. Run the tracker, or open a run file.")
        self._none.setProperty("role", "muted")
        self._none.setWordWrap(True)
        self._none.setContentsMargins(10, 10, 10, 10)
        self._none.setAlignment(Qt.AlignmentFlag.AlignTop)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self._none)
        layout.addWidget(self.tree)
        self.tree.itemChanged.connect(self._on_changed)
        self.tree.itemClicked.connect(self._on_clicked)
        self.tree.itemActivated.connect(self._on_clicked)
        self.show_rows(())

    def show_rows(self, rows: Sequence[RunRow]) -> None:
        """Show these runs."""
        self._none.setVisible(not rows)
        self.tree.setVisible(bool(rows))
        with QSignalBlocker(self.tree):
            while self.tree.topLevelItemCount() > len(rows):
                self.tree.takeTopLevelItem(self.tree.topLevelItemCount() - 1)
            while self.tree.topLevelItemCount() < len(rows):
                self.tree.addTopLevelItem(QTreeWidgetItem())
            for place, row in enumerate(rows):
                self._fill(self.tree.topLevelItem(place), row)

    def _fill(self, item: QTreeWidgetItem | None, row: RunRow) -> None:
        if item is None:
            return
        item.setFlags(
            Qt.ItemFlag.ItemIsEnabled
            | Qt.ItemFlag.ItemIsSelectable
            | Qt.ItemFlag.ItemIsUserCheckable
            | Qt.ItemFlag.ItemIsEditable
        )
        for column, text in enumerate((row.name, row.frames, row.score)):
            item.setText(column, text)
            item.setToolTip(column, row.hint)
            font = item.font(column)
            font.setBold(row.active)
            item.setFont(column, font)
        item.setCheckState(0, Qt.CheckState.Checked if row.visible else Qt.CheckState.Unchecked)
        item.setIcon(0, self._line(dashed=row.dashed))
        if row.active:
            self.tree.setCurrentItem(item)

    def _line(self, *, dashed: bool) -> QIcon:
        pixmap = QPixmap(self.tree.iconSize())
        pixmap.fill(Qt.GlobalColor.transparent)
        painter = QPainter(pixmap)
        style = Qt.PenStyle.DashLine if dashed else Qt.PenStyle.SolidLine
        painter.setPen(QPen(self.palette().text(), 2, style))
        painter.drawLine(1, pixmap.height() // 2, pixmap.width() - 1, pixmap.height() // 2)
        painter.end()
        return QIcon(pixmap)

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
