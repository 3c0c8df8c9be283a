"""Statistics of every limb, stretch by stretch."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import QEvent, Qt
from PySide6.QtGui import QAction, QColor, QFont
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QToolButton,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

from ..style.limb_colours import LIMB_COLOURS
from ..style.theme import current_theme
from .cells import RIGHT, swatch

_NOTHING = "Run the tracker to see the statistics of each limb."


@dataclass(frozen=True)
class StatisticsRow:
    """Numbers of one limb.

    Attributes
    ----------
    limb : str
        Whose colour stands before it; empty for none.
    label : str
    values : tuple of float
        One for each column; NaN where not known.
    """

    limb: str
    label: str
    values: tuple[float, ...]


@dataclass(frozen=True)
class StatisticsGroup:
    """Numbers of one stretch in one run.

    Attributes
    ----------
    title : str
    hint : str
    summary : tuple of float
        What stands beside the title.
    rows : tuple of StatisticsRow
    open : bool
        Whether its rows are seen at first.
    """

    title: str
    hint: str
    summary: tuple[float, ...]
    rows: tuple[StatisticsRow, ...]
    open: bool


@dataclass(frozen=True)
class StatisticsColumn:
    """A heading with what it means, and how many digits its numbers have."""

    heading: str
    tip: str
    digits: int = 1


class StatisticsPanel(QWidget):
    """A row per limb under a row per stretch; what is open stays open."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.words = QLabel(_NOTHING, self)
        self.words.setProperty("role", "muted")
        self.words.setWordWrap(True)
        self.tree = QTreeWidget(self)
        self.tree.setAccessibleName("Limb statistics")
        self.tree.setFrameShape(QTreeWidget.Shape.NoFrame)
        self.tree.setAlternatingRowColors(True)
        self.tree.setUniformRowHeights(True)
        self.tree.setIndentation(8)
        self.tree.setTextElideMode(Qt.TextElideMode.ElideMiddle)
        self.tree.header().setStyleSheet("QHeaderView::section { padding: 3px 4px; }")
        self.tree.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self._buttons = QHBoxLayout()
        self._buttons.setSpacing(0)
        top = QHBoxLayout()
        top.setContentsMargins(8, 4, 4, 0)
        top.addWidget(self.words, 1)
        top.addLayout(self._buttons)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(2)
        layout.addLayout(top)
        layout.addWidget(self.tree, 1)
        self._digits: tuple[int, ...] = ()
        self._shown: tuple[StatisticsGroup, ...] = ()
        self.tree.hide()

    def add_action_button(self, action: QAction) -> None:
        """Offer a command above the table."""
        button = QToolButton(self)
        button.setDefaultAction(action)
        self._buttons.addWidget(button, 0, Qt.AlignmentFlag.AlignTop)

    def show_statistics(
        self,
        words: str,
        columns: Sequence[StatisticsColumn],
        groups: Sequence[StatisticsGroup],
    ) -> None:
        """Show these stretches; empty `groups` stand for nothing to show."""
        self.words.setText(words if groups else _NOTHING)
        self.tree.setVisible(bool(groups))
        headings = ["all arms; each limb", *(column.heading for column in columns)]
        self._digits = tuple(column.digits for column in columns)
        if headings != [self.tree.headerItem().text(i) for i in range(self.tree.columnCount())]:
            self._write_headings(headings, columns)
        if tuple(groups) != self._shown:
            self._shown = tuple(groups)
            self._write()

    def _write_headings(self, headings: list[str], columns: Sequence[StatisticsColumn]) -> None:
        self.tree.setColumnCount(len(headings))
        self.tree.setHeaderLabels(headings)
        header = self.tree.header()
        header.setStretchLastSection(False)
        header.setMinimumSectionSize(36)
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        for i, column in enumerate(columns, start=1):
            self.tree.headerItem().setToolTip(i, column.tip)
            self.tree.headerItem().setTextAlignment(i, RIGHT)

    def _write(self) -> None:
        heads = [self.tree.topLevelItem(i) for i in range(self.tree.topLevelItemCount())]
        was_open = {head.text(0): head.isExpanded() for head in heads if head is not None}
        self.tree.clear()
        bold = QFont(self.tree.font())
        bold.setBold(True)
        for group in self._shown:
            head = self._item(group.title, "", group.summary)
            head.setToolTip(0, group.hint)
            head.setFont(0, bold)
            for row in group.rows:
                head.addChild(self._item(row.label, row.limb, row.values))
            self.tree.addTopLevelItem(head)
            head.setExpanded(was_open.get(group.title, group.open))

    def _item(self, label: str, limb: str, values: Sequence[float]) -> QTreeWidgetItem:
        texts = [_text(v, d) for v, d in zip(values, self._digits, strict=False)]
        item = QTreeWidgetItem([label, *texts])
        if limb:
            item.setData(0, Qt.ItemDataRole.DecorationRole, swatch(LIMB_COLOURS[limb]))
        for column, value in enumerate(values, start=1):
            item.setTextAlignment(column, RIGHT)
            if math.isnan(value):
                item.setForeground(column, QColor(current_theme().muted))
                item.setToolTip(column, "unknown")
        return item

    def changeEvent(self, event: QEvent) -> None:
        if event.type() == QEvent.Type.PaletteChange and self._shown:
            self._write()
        super().changeEvent(event)


def _text(value: float, digits: int) -> str:
    return "–" if math.isnan(value) else f"{value:.{digits}f}"
