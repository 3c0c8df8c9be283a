"""Statistics of every limb, stretch by stretch."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import QEvent, Qt
from PySide6.QtGui import QAction, QColor
from PySide6.QtWidgets import QHeaderView, QTreeWidget, QTreeWidgetItem, QWidget

from ..style.building import action_button, hbox, label, vbox
from ..style.limb_colours import LIMB_COLOURS
from ..style.theme import current_theme
from .table import RIGHT, Column, dress_list, swatch

_NOTHING = "Run the tracker to see the statistics of each limb."


@dataclass(frozen=True)
class StatisticsRow:
    """Numbers of one limb, one for each column; NaN where not known."""

    limb: str
    label: str
    values: tuple[float, ...]


@dataclass(frozen=True)
class StatisticsGroup:
    """Numbers of one stretch in one run."""

    title: str
    hint: str
    summary: tuple[float, ...]
    """What stands beside the title."""
    rows: tuple[StatisticsRow, ...]
    open: bool
    """Whether its rows are seen at first."""


class StatisticsPanel(QWidget):
    """A row per limb under a row per stretch; what is open stays open."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.words = label(_NOTHING, "muted")
        self.tree = QTreeWidget(self)
        dress_list(self.tree, "Limb statistics", ())
        self.tree.setRootIsDecorated(True)
        self.tree.setFrameShape(QTreeWidget.Shape.NoFrame)
        self.tree.setAlternatingRowColors(True)
        self.tree.setIndentation(8)
        self.tree.setTextElideMode(Qt.TextElideMode.ElideMiddle)
        self.tree.header().setStyleSheet("QHeaderView::section { padding: 3px 4px; }")
        self._buttons = hbox(spacing=0)
        top = hbox((self.words, 1), self._buttons, margins=(8, 4, 4, 0))
        self.setLayout(vbox(top, (self.tree, 1), spacing=2))
        self._columns: tuple[Column, ...] = ()
        self._shown: tuple[StatisticsGroup, ...] = ()
        self.tree.hide()

    def add_action_button(self, action: QAction) -> None:
        """Offer a command above the table."""
        self._buttons.addWidget(action_button(action), 0, Qt.AlignmentFlag.AlignTop)

    def show_statistics(
        self, words: str, columns: Sequence[Column], groups: Sequence[StatisticsGroup]
    ) -> None:
        """Show these stretches; empty `groups` stand for nothing to show."""
        self.words.setText(words if groups else _NOTHING)
        self.tree.setVisible(bool(groups))
        if tuple(columns) != self._columns:
            self._columns = tuple(columns)
            self._write_headings()
        if tuple(groups) != self._shown:
            self._shown = tuple(groups)
            self._write()

    def _write_headings(self) -> None:
        headings = ["all arms; each limb", *(column.heading for column in self._columns)]
        self.tree.setColumnCount(len(headings))
        self.tree.setHeaderLabels(headings)
        header = self.tree.header()
        header.setMinimumSectionSize(36)
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        for i, column in enumerate(self._columns, start=1):
            self.tree.headerItem().setToolTip(i, column.tip)
            self.tree.headerItem().setTextAlignment(i, RIGHT)

    def _write(self) -> None:
        heads = [self.tree.topLevelItem(i) for i in range(self.tree.topLevelItemCount())]
        was_open = {head.text(0): head.isExpanded() for head in heads if head is not None}
        self.tree.clear()
        bold = self.tree.font()
        bold.setBold(True)
        for group in self._shown:
            head = _item(group.title, "", group.summary)
            head.setToolTip(0, group.hint)
            head.setFont(0, bold)
            head.addChildren([_item(row.label, row.limb, row.values) for row in group.rows])
            self.tree.addTopLevelItem(head)
            head.setExpanded(was_open.get(group.title, group.open))

    def changeEvent(self, event: QEvent) -> None:
        if event.type() == QEvent.Type.PaletteChange and self._shown:
            self._write()
        super().changeEvent(event)


def _item(name: str, limb: str, values: Sequence[float]) -> QTreeWidgetItem:
    item = QTreeWidgetItem([name, *("–" if math.isnan(v) else f"{v:.1f}" for v in values)])
    if limb:
        item.setData(0, Qt.ItemDataRole.DecorationRole, swatch(LIMB_COLOURS[limb]))
    for column, value in enumerate(values, start=1):
        item.setTextAlignment(column, RIGHT)
        if math.isnan(value):
            item.setForeground(column, QColor(current_theme().muted))
            item.setToolTip(column, "unknown")
    return item
