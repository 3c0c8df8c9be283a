"""The numbers of the frame in a table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

from PySide6.QtCore import (
    QAbstractTableModel,
    QEvent,
    QModelIndex,
    QPersistentModelIndex,
    Qt,
    Signal,
)
from PySide6.QtGui import QAction, QColor, QFontDatabase, QGuiApplication, QKeyEvent, QKeySequence
from PySide6.QtWidgets import (
    QHeaderView,
    QLabel,
    QStackedLayout,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QTableView,
    QWidget,
)

from ..style.limb_colours import LIMB_COLOURS, limb_words
from ..style.theme import current_theme
from .cells import LEFT, RIGHT, dress_table

NumberRow: TypeAlias = tuple[str, str, str, str]
"""Limb (empty for none), label, value with its unit, and a hint in words."""

_Index: TypeAlias = QModelIndex | QPersistentModelIndex
_HEADINGS = ("", "Measure", "Value", "Remark")
_VALUE_TIP = (
    "For a limb: its angular error, where there is a reference. After ±: the standard deviation "
    "of its direction as estimated by the filter. This is small also when the filter tracks the "
    "wrong points."
)
_LIMB, _LABEL, _VALUE, _HINT = range(4)


class _NumbersModel(QAbstractTableModel):
    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self._rows: tuple[NumberRow, ...] = ()
        self._digits = QFontDatabase.systemFont(QFontDatabase.SystemFont.FixedFont)

    def rowCount(self, parent: _Index | None = None) -> int:
        return 0 if parent is not None and parent.isValid() else len(self._rows)

    def columnCount(self, parent: _Index | None = None) -> int:
        return 0 if parent is not None and parent.isValid() else len(_HEADINGS)

    def set_rows(self, rows: tuple[NumberRow, ...]) -> None:
        if len(rows) != len(self._rows):
            self.beginResetModel()
            self._rows = rows
            self.endResetModel()
        elif rows:
            self._rows = rows
            last = self.index(len(rows) - 1, len(_HEADINGS) - 1)
            self.dataChanged.emit(self.index(0, 0), last)

    def row(self, index: int) -> NumberRow:
        return self._rows[index]

    def headerData(
        self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole
    ) -> Any:
        if orientation == Qt.Orientation.Horizontal and role == Qt.ItemDataRole.DisplayRole:
            return _HEADINGS[section]
        if role == Qt.ItemDataRole.ToolTipRole and section == _VALUE:
            return _VALUE_TIP
        if role == Qt.ItemDataRole.TextAlignmentRole and section == _VALUE:
            return RIGHT
        return None

    def data(self, index: _Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        row, column = self._rows[index.row()], index.column()
        limb, text = row[0], row[column]
        match role:
            case Qt.ItemDataRole.DisplayRole if column != _LIMB:
                return text
            case Qt.ItemDataRole.DecorationRole if column == _LIMB and limb in LIMB_COLOURS:
                return QColor(LIMB_COLOURS[limb])
            case Qt.ItemDataRole.TextAlignmentRole if column == _VALUE:
                return RIGHT
            case Qt.ItemDataRole.FontRole if column == _VALUE:
                return self._digits
            case Qt.ItemDataRole.ForegroundRole if column == _HINT:
                return QColor(current_theme().muted)
            case Qt.ItemDataRole.ToolTipRole:
                return row[_HINT] or (_VALUE_TIP if limb else row[_LABEL])
            case Qt.ItemDataRole.AccessibleTextRole if column == _LIMB:
                return limb_words(limb)
        return None


class _RowDelegate(QStyledItemDelegate):
    """Rows are chosen as a whole, so no single cell is framed."""

    def initStyleOption(self, option: QStyleOptionViewItem, index: _Index) -> None:
        super().initStyleOption(option, index)
        option.state &= ~QStyle.StateFlag.State_HasFocus


class _Table(QTableView):
    """Copies whole rows where the table of Qt copies one cell."""

    copy_asked = Signal()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.matches(QKeySequence.StandardKey.Copy):
            self.copy_asked.emit()
        else:
            super().keyPressEvent(event)


class NumbersPanel(QWidget):
    """Table of numbers, each with its limb's colour; Ctrl+C copies what is selected."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._model = _NumbersModel(self)
        self._table = _Table(self)
        self._table.setModel(self._model)
        self._table.setItemDelegate(_RowDelegate(self._table))
        dress_table(self._table, "Frame metrics")
        header = self._table.horizontalHeader()
        header.setDefaultAlignment(LEFT)
        header.setMinimumSectionSize(28)
        header.setSectionResizeMode(_LIMB, QHeaderView.ResizeMode.Fixed)
        header.resizeSection(_LIMB, 28)
        header.setSectionResizeMode(_LABEL, QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(_VALUE, QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(_HINT, QHeaderView.ResizeMode.Stretch)
        self._nothing = QLabel("Run the tracker to see metrics of this frame.", self)
        self._nothing.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._nothing.setWordWrap(True)
        self._nothing.setProperty("role", "muted")
        self._stack = QStackedLayout(self)
        self._stack.addWidget(self._nothing)
        self._stack.addWidget(self._table)
        self._add_copy()

    @property
    def table(self) -> QTableView:
        """The table."""
        return self._table

    def show_rows(self, rows: Sequence[NumberRow]) -> None:
        """Show limb, label, value and hint of each row; selection and scroll place stay."""
        self._model.set_rows(tuple(rows))
        self._stack.setCurrentIndex(1 if rows else 0)

    def copied_text(self) -> str:
        """Selected rows, or all, with tabs between the columns."""
        chosen = sorted({index.row() for index in self._table.selectedIndexes()})
        rows = [self._model.row(i) for i in chosen or range(self._model.rowCount())]
        return "\n".join("\t".join(row) for row in rows)

    def _add_copy(self) -> None:
        copy = QAction("Copy metrics", self._table)
        copy.triggered.connect(self._copy)
        self._table.copy_asked.connect(self._copy)
        self._table.addAction(copy)
        self._table.setContextMenuPolicy(Qt.ContextMenuPolicy.ActionsContextMenu)

    def _copy(self) -> None:
        QGuiApplication.clipboard().setText(self.copied_text())

    def changeEvent(self, event: QEvent) -> None:
        if event.type() == QEvent.Type.PaletteChange:
            self._table.viewport().update()
        super().changeEvent(event)
