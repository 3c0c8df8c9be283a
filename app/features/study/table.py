"""The table of a study: factors can be edited in place, everything else is read."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import Any

from PySide6.QtCore import (
    QItemSelection,
    QItemSelectionModel,
    QModelIndex,
    QPersistentModelIndex,
    Qt,
    Signal,
    Slot,
)
from PySide6.QtGui import QPainter, QPalette
from PySide6.QtWidgets import (
    QAbstractItemView,
    QCompleter,
    QLineEdit,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QTableView,
    QWidget,
)

from stereotrack_core.study.editing import values_of
from stereotrack_core.study.file import Study
from stereotrack_core.study.status import RowStatus

from ...widgets.tables.table import Index, TableModel, new_table, selected_rows
from .rows import cells_of, factor_at

_EDITING = QAbstractItemView.State.EditingState
_NO_UPDATE = QItemSelectionModel.SelectionFlag.NoUpdate


class StudyModel(TableModel[RowStatus]):
    """Rows of a study; what a person writes into a cell is told, and not kept here."""

    edited = Signal(str, str)
    """A factor, and what was written into one of its cells."""

    def __init__(self) -> None:
        super().__init__(cells=lambda row: cells_of(self.study, row))
        self.study = Study(Path())

    def flags(self, index: Index) -> Qt.ItemFlag:
        own = factor_at(self.study, index.column())
        editable = Qt.ItemFlag.ItemIsEditable if own else Qt.ItemFlag.NoItemFlags
        return super().flags(index) | editable

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        if role == Qt.ItemDataRole.EditRole:
            return self.cell(index.row(), index.column()).text
        return super().data(index, role)

    def setData(self, index: Index, value: Any, role: int = Qt.ItemDataRole.EditRole) -> bool:
        text = str(value).strip()
        if role == Qt.ItemDataRole.EditRole and text != self.data(index, role):
            self.edited.emit(factor_at(self.study, index.column()), text)
        return True


class _Cells(QStyledItemDelegate):
    """Lets a factor be typed, and proposes what other recordings say."""

    opened = Signal(int)
    """A cell of this row is about to be edited."""

    def createEditor(self, parent: QWidget, _option: QStyleOptionViewItem, index: Index) -> QWidget:
        editor, model = QLineEdit(parent), index.model()
        if isinstance(model, StudyModel):
            name = factor_at(model.study, index.column())
            editor.setAccessibleName(name)
            completer = QCompleter(list(values_of(model.study, name)), editor)
            completer.setCaseSensitivity(Qt.CaseSensitivity.CaseInsensitive)
            editor.setCompleter(completer)
        self.opened.emit(index.row())
        return editor

    def setEditorData(self, editor: QWidget, index: Index) -> None:
        """Show what the cell says; rows that are read meanwhile do not undo what is typed."""
        text = str(index.data(Qt.ItemDataRole.EditRole))
        if isinstance(editor, QLineEdit) and not editor.isModified() and editor.text() != text:
            editor.setText(text)

    def paint(
        self,
        painter: QPainter,
        option: QStyleOptionViewItem,
        index: QModelIndex | QPersistentModelIndex,
    ) -> None:
        """Frame the cell that F2 edits, which a selected row would hide."""
        super().paint(painter, option, index)
        state = QStyle.StateFlag
        model = index.model()
        own = isinstance(model, StudyModel) and factor_at(model.study, index.column())
        if own and state.State_HasFocus in option.state:
            selected = state.State_Selected in option.state
            role = QPalette.ColorRole
            colour = option.palette.color(role.HighlightedText if selected else role.Highlight)
            painter.setPen(colour)
            painter.drawRect(option.rect.adjusted(0, 0, -1, -1))


class StudyTable(QTableView):
    """Rows of a study with the cells that can be edited."""

    written = Signal(object, str, str)
    """Tuple of the names of recordings, a factor, and its value in all of them."""
    wide = Signal(int)
    """What is typed now goes into so many recordings."""
    selected = Signal()
    """A person has selected other rows."""
    closed = Signal()
    """A cell is no longer edited."""

    def __init__(self) -> None:
        super().__init__()
        self.rows = StudyModel()
        self._arranging = False
        self._recordings: tuple[str, ...] = ()
        new_table(self.rows, "Recordings of the study", view=self)
        self.setEditTriggers(QAbstractItemView.EditTrigger.DoubleClicked)
        self._cells = _Cells(self)
        self._cells.opened.connect(self._on_opened)
        self._cells.closeEditor.connect(self._on_closed, Qt.ConnectionType.QueuedConnection)
        self.setItemDelegate(self._cells)
        self.rows.edited.connect(self._on_edited)
        self.selectionModel().selectionChanged.connect(self._on_selected)

    def show_rows(self, shown: list[RowStatus], kept: Collection[str]) -> None:
        """Show these with some of them selected; the cursor stays with its recording.

        While a cell is edited rows stay where they are.
        """
        if self.state() == _EDITING:
            shown = self._in_place(shown)
        current, model = self.currentIndex(), self.selectionModel()
        at = self.rows.rows[current.row()].row.recording if current.isValid() else ""
        self._arranging = True
        self.rows.show(shown)
        selection = QItemSelection()
        for k, row in enumerate(shown):
            index = self.rows.index(k, 0)
            if row.row.recording in kept:
                selection.select(index, index)
            if row.row.recording == at:
                model.setCurrentIndex(index.siblingAtColumn(current.column()), _NO_UPDATE)
        flags = QItemSelectionModel.SelectionFlag
        model.select(selection, flags.ClearAndSelect | flags.Rows)
        self._arranging = False

    def _in_place(self, shown: list[RowStatus]) -> list[RowStatus]:
        news = {row.row.recording: row for row in shown}
        before = [row.row.recording for row in self.rows.rows]
        return [news[name] for name in before] if set(before) == set(news) else shown

    def selected_statuses(self) -> list[RowStatus]:
        """Rows that are selected."""
        return [self.rows.rows[k] for k in selected_rows(self)]

    def current_factor(self) -> str:
        """The factor of the cell under the cursor, else the first; empty where there is none."""
        factors = self.rows.study.factors
        found = factor_at(self.rows.study, self.currentIndex().column())
        return found or next(iter(factors), "")

    def edit_current(self) -> None:
        """Let the cell under the cursor be typed, or that of the first factor in its row."""
        selected, current = selected_rows(self), self.currentIndex()
        column = 1 + self.rows.study.factors.index(self.current_factor())
        row = current.row() if current.row() in selected else selected[0]
        index = self.rows.index(row, column)
        self.selectionModel().setCurrentIndex(index, _NO_UPDATE)
        self.edit(index)

    def put_cursor(self, column: int) -> None:
        """Move the cursor to a column; what is selected stays."""
        index = self.rows.index(max(self.currentIndex().row(), 0), column)
        self.selectionModel().setCurrentIndex(index, _NO_UPDATE)

    @Slot()
    def _on_selected(self) -> None:
        if not self._arranging:
            self.selected.emit()

    @Slot(int)
    def _on_opened(self, place: int) -> None:
        """Remember which recordings are written to: those that are selected with this one."""
        row, selected = self.rows.rows[place], self.selected_statuses()
        chosen = selected if row in selected else [row]
        self._recordings = tuple(one.row.recording for one in chosen)
        self.wide.emit(len(chosen))

    @Slot(str, str)
    def _on_edited(self, factor: str, value: str) -> None:
        self.written.emit(self._recordings, factor, value)

    @Slot()
    def _on_closed(self) -> None:
        self.closed.emit()
