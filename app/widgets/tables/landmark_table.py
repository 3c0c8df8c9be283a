"""Landmarks of a set as an editable table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

from PySide6.QtCore import QAbstractTableModel, QModelIndex, QPersistentModelIndex, Qt, Signal
from PySide6.QtWidgets import (
    QAbstractItemView,
    QComboBox,
    QDoubleSpinBox,
    QHeaderView,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QTableView,
    QWidget,
)

from stereotrack_core.annotation.landmark_set import Landmark
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.skeleton import PARTS

from .cells import RIGHT, swatch

_Index: TypeAlias = QModelIndex | QPersistentModelIndex
_NOWHERE = QModelIndex()
_COLUMNS: tuple[tuple[str, str, str], ...] = (
    ("name", "Name", "Name in clicks and files; left and right are those of the person"),
    ("colour", "Colour", "#rrggbb; double-click to choose a colour"),
    ("limb", "Limb", "Limb under which it is listed and whose direction it defines"),
    ("part", "Fixed to", "Body part it is attached to"),
    ("mirror", "Mirror", "Landmark of the other side with which it can be swapped"),
    ("along", "Along", "Fraction of the part's length from its joint"),
    ("across", "Across", "Fraction of the hip width; on the torso, to the person's right"),
    ("x", "x [mm]", "Offset in the part's frame; on the torso, to the person's right"),
    ("y", "y [mm]", "Offset in the part's frame; on the torso, forwards"),
    ("z", "z [mm]", "Offset along the part"),
)
_FIELDS = tuple(field for field, _, _ in _COLUMNS)
_OFFSETS = ("x", "y", "z")


class LandmarkModel(QAbstractTableModel):
    """Landmarks in the order of their keys; who edits is told, and keeps them.

    Signals
    -------
    edited : int, str, object
        Row, field of the landmark, and its new value.
    """

    edited = Signal(int, str, object)

    def __init__(self) -> None:
        super().__init__()
        self._rows: tuple[Landmark, ...] = ()
        self._wrong = -1
        self.editable = True

    def show(self, rows: Sequence[Landmark], wrong: int = -1) -> None:
        """Show these; something is wrong about that row."""
        same = len(rows) == len(self._rows)
        if not same:
            self.beginResetModel()
        self._rows, self._wrong = tuple(rows), wrong
        if not same:
            self.endResetModel()
        elif rows:
            self.dataChanged.emit(
                self.index(0, 0), self.index(len(self._rows) - 1, len(_COLUMNS) - 1)
            )
            self.headerDataChanged.emit(Qt.Orientation.Vertical, 0, len(self._rows) - 1)

    def landmark(self, row: int) -> Landmark:
        """Landmark of a row."""
        return self._rows[row]

    def names(self) -> tuple[str, ...]:
        """Names of all landmarks."""
        return tuple(one.name for one in self._rows)

    def rowCount(self, parent: _Index = _NOWHERE) -> int:
        return 0 if parent.isValid() else len(self._rows)

    def columnCount(self, parent: _Index = _NOWHERE) -> int:
        return 0 if parent.isValid() else len(_COLUMNS)

    def flags(self, _index: _Index) -> Qt.ItemFlag:
        shown = Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable
        return shown | Qt.ItemFlag.ItemIsEditable if self.editable else shown

    def headerData(
        self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole
    ) -> Any:
        if orientation == Qt.Orientation.Vertical:
            if role == Qt.ItemDataRole.DisplayRole:
                return f"{section + 1}" + (" !" if section == self._wrong else "")
            if role == Qt.ItemDataRole.ToolTipRole:
                return "Key that selects it" if section < 9 else "It has no key"
            return None
        if role == Qt.ItemDataRole.DisplayRole:
            return _COLUMNS[section][1]
        return _COLUMNS[section][2] if role == Qt.ItemDataRole.ToolTipRole else None

    def data(self, index: _Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        one, field = self._rows[index.row()], _FIELDS[index.column()]
        if role == Qt.ItemDataRole.EditRole:
            return self.value(one, field)
        if role == Qt.ItemDataRole.DisplayRole:
            value = self.value(one, field)
            if isinstance(value, float):
                return f"{value:.0f}" if field in _OFFSETS else f"{value:.2f}"
            return value.replace("_", " ") if field in ("limb", "part", "mirror") else value
        if role == Qt.ItemDataRole.TextAlignmentRole and isinstance(self.value(one, field), float):
            return RIGHT
        if role == Qt.ItemDataRole.DecorationRole and field == "colour":
            return swatch(one.colour, 14)
        return _COLUMNS[index.column()][2] if role == Qt.ItemDataRole.ToolTipRole else None

    @staticmethod
    def value(one: Landmark, field: str) -> str | float:
        """Value of a field as it is edited; offsets in millimetres."""
        if field in _OFFSETS:
            return 1000.0 * one.offset[_OFFSETS.index(field)]
        value: str | float = getattr(one, field)
        return value

    def setData(self, index: _Index, value: Any, role: int = Qt.ItemDataRole.EditRole) -> bool:
        if role != Qt.ItemDataRole.EditRole:
            return False
        row, field = index.row(), _FIELDS[index.column()]
        if field in _OFFSETS:
            offset = list(self._rows[row].offset)
            offset[_OFFSETS.index(field)] = float(value) / 1000.0
            self.edited.emit(row, "offset", tuple(offset))
        elif field in ("along", "across"):
            self.edited.emit(row, field, float(value))
        else:
            self.edited.emit(row, field, str(value).strip())
        return True


class _Editors(QStyledItemDelegate):
    """Lists for what is one of several words, fields for numbers."""

    def createEditor(self, parent: QWidget, option: QStyleOptionViewItem, index: _Index) -> QWidget:
        field, model = _FIELDS[index.column()], index.model()
        words: tuple[str, ...] = {"limb": LIMBS, "part": PARTS}.get(field, ())
        if field == "mirror" and isinstance(model, LandmarkModel):
            own = model.landmark(index.row()).name
            words = ("", *(name for name in model.names() if name != own))
        if words:
            box = QComboBox(parent)
            for word in words:
                box.addItem(word.replace("_", " ") or "none", word)
            return box
        if field in ("along", "across", *_OFFSETS):
            number = QDoubleSpinBox(parent)
            largest = 1000.0 if field in _OFFSETS else 1.0
            number.setRange(-largest, largest)
            number.setDecimals(0 if field in _OFFSETS else 3)
            number.setSingleStep(1.0 if field in _OFFSETS else 0.05)
            return number
        return super().createEditor(parent, option, index)

    def setEditorData(self, editor: QWidget, index: _Index) -> None:
        if isinstance(editor, QComboBox):
            editor.setCurrentIndex(editor.findData(index.data(Qt.ItemDataRole.EditRole)))
        else:
            super().setEditorData(editor, index)

    def setModelData(self, editor: QWidget, model: Any, index: _Index) -> None:
        if isinstance(editor, QComboBox):
            model.setData(index, editor.currentData())
        else:
            super().setModelData(editor, model, index)


class LandmarkTable(QTableView):
    """A row per landmark; a double click, F2 or typing edits a cell.

    Signals
    -------
    colour_requested : int
        The person wants to choose the colour of this row.
    """

    colour_requested = Signal(int)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.rows_model = LandmarkModel()
        self.setModel(self.rows_model)
        self.setItemDelegate(_Editors(self))
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setShowGrid(False)
        self.setAlternatingRowColors(True)
        self.setAccessibleName("Landmarks")
        row = self.fontMetrics().height() + 10
        self.verticalHeader().setDefaultSectionSize(row)
        self.verticalHeader().setSectionResizeMode(QHeaderView.ResizeMode.Fixed)
        header = self.horizontalHeader()
        header.setHighlightSections(False)
        header.setStretchLastSection(True)
        metrics = self.fontMetrics()
        widest = ("right shoulder 0", "#000000 ", "right upper arm", "right upper arm")
        widest_too = ("right shoulder", "Along", "Across", "x [mm]", "y [mm]")
        for column, text in enumerate((*widest, *widest_too)):
            extra = 40 if column == 1 else 26
            header.resizeSection(column, metrics.horizontalAdvance(text) + extra)

    def selected_rows(self) -> list[int]:
        """Rows that are selected, ascending."""
        return sorted(index.row() for index in self.selectionModel().selectedRows())

    def mouseDoubleClickEvent(self, event: Any) -> None:
        index = self.indexAt(event.position().toPoint())
        if index.isValid() and _FIELDS[index.column()] == "colour" and self.rows_model.editable:
            self.colour_requested.emit(index.row())
        else:
            super().mouseDoubleClickEvent(event)
