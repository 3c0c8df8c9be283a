"""Landmarks of a set as an editable table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QAbstractItemView,
    QComboBox,
    QHeaderView,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QTableView,
    QWidget,
)

from stereotrack_core.annotation.landmark_set import Landmark
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.skeleton import PARTS

from ..forms.numbers import NumberField
from .table import LEFT, RIGHT, Cell, Column, Index, TableModel, dress_table

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
_NUMBERS = ("along", "across", *_OFFSETS)


class LandmarkModel(TableModel[Landmark]):
    """Landmarks in the order of their keys; who edits is told, and keeps them."""

    edited = Signal(int, str, object)
    """Row, field of the landmark, and its new value."""

    def __init__(self) -> None:
        columns = (
            Column(heading, tip, RIGHT if field in _NUMBERS else LEFT)
            for field, heading, tip in _COLUMNS
        )
        super().__init__(columns, _cells)
        self._wrong = -1
        self.editable = True

    def show_landmarks(self, rows: Sequence[Landmark], wrong: int = -1) -> None:
        """Show these; something is wrong about that row."""
        self._wrong = wrong
        self.show(tuple(rows))
        if rows:
            self.headerDataChanged.emit(Qt.Orientation.Vertical, 0, len(rows) - 1)

    def flags(self, index: Index) -> Qt.ItemFlag:
        editable = Qt.ItemFlag.ItemIsEditable if self.editable else Qt.ItemFlag.NoItemFlags
        return super().flags(index) | editable

    def headerData(
        self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole
    ) -> Any:
        if orientation == Qt.Orientation.Horizontal:
            return super().headerData(section, orientation, role)
        if role == Qt.ItemDataRole.DisplayRole:
            return f"{section + 1}" + (" !" if section == self._wrong else "")
        if role == Qt.ItemDataRole.ToolTipRole:
            return "Key that selects it" if section < 9 else "It has no key"
        return None

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        if role == Qt.ItemDataRole.EditRole:
            return _value(self.rows[index.row()], _FIELDS[index.column()])
        return super().data(index, role)

    def setData(self, index: Index, value: Any, role: int = Qt.ItemDataRole.EditRole) -> bool:
        if role != Qt.ItemDataRole.EditRole:
            return False
        row, field = index.row(), _FIELDS[index.column()]
        if value == _value(self.rows[row], field):
            return True  # the cell was opened and left as it was
        if field in _OFFSETS:
            offset = list(self.rows[row].offset)
            offset[_OFFSETS.index(field)] = float(value) / 1000.0
            self.edited.emit(row, "offset", tuple(offset))
        else:
            given = float(value) if field in _NUMBERS else str(value).strip()
            self.edited.emit(row, field, given)
        return True


def _value(one: Landmark, field: str) -> str | float:
    """Value of a field as it is edited; offsets in millimetres."""
    if field in _OFFSETS:
        return 1000.0 * one.offset[_OFFSETS.index(field)]
    value: str | float = getattr(one, field)
    return value


def _cells(one: Landmark) -> Sequence[Cell]:
    cells = []
    for field, _, tip in _COLUMNS:
        value = _value(one, field)
        if isinstance(value, float):
            value = f"{value:.0f}" if field in _OFFSETS else f"{value:.2f}"
        elif field in ("limb", "part", "mirror"):
            value = value.replace("_", " ")
        cells.append(Cell(value, tip, swatch=one.colour if field == "colour" else None))
    return cells


class _Editors(QStyledItemDelegate):
    """Lists for what is one of several words, fields for numbers."""

    def createEditor(self, parent: QWidget, option: QStyleOptionViewItem, index: Index) -> QWidget:
        field, model = _FIELDS[index.column()], index.model()
        words: tuple[str, ...] = {"limb": LIMBS, "part": PARTS}.get(field, ())
        if field == "mirror" and isinstance(model, LandmarkModel):
            own = index.row()
            words = ("", *(one.name for k, one in enumerate(model.rows) if k != own))
        if words:
            box = QComboBox(parent)
            for word in words:
                box.addItem(word.replace("_", " ") or "none", word)
            return box
        if field in _NUMBERS:
            if field in _OFFSETS:
                return NumberField(parent, minimum=-1000.0, maximum=1000.0)
            return NumberField(parent, digits=3, minimum=-1.0, maximum=1.0, singleStep=0.05)
        return super().createEditor(parent, option, index)

    def setEditorData(self, editor: QWidget, index: Index) -> None:
        if isinstance(editor, QComboBox):
            editor.setCurrentIndex(editor.findData(index.data(Qt.ItemDataRole.EditRole)))
        elif isinstance(editor, NumberField):
            editor.show_stored(index.data(Qt.ItemDataRole.EditRole))
        else:
            super().setEditorData(editor, index)

    def setModelData(self, editor: QWidget, model: Any, index: Index) -> None:
        if isinstance(editor, QComboBox):
            model.setData(index, editor.currentData())
        elif isinstance(editor, NumberField):
            editor.interpretText()
            model.setData(index, editor.stored())
        else:
            super().setModelData(editor, model, index)


class LandmarkTable(QTableView):
    """A row per landmark; a double click, F2 or typing edits a cell."""

    colour_requested = Signal(int)
    """The person wants to choose the colour of this row."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.rows_model = LandmarkModel()
        self.setModel(self.rows_model)
        self.setItemDelegate(_Editors(self))
        dress_table(self, "Landmarks", room=10)
        edit = QAbstractItemView.EditTrigger
        self.setEditTriggers(edit.DoubleClicked | edit.EditKeyPressed | edit.AnyKeyPressed)
        self.setTabKeyNavigation(True)
        self.verticalHeader().show()
        self.verticalHeader().setSectionResizeMode(QHeaderView.ResizeMode.Fixed)
        header = self.horizontalHeader()
        header.setStretchLastSection(True)
        metrics = self.fontMetrics()
        widest = ("right shoulder 0", "#000000 ", "right upper arm", "right upper arm")
        widest_too = ("right shoulder", "Along", "Across", "x [mm]", "y [mm]")
        for column, text in enumerate((*widest, *widest_too)):
            extra = 40 if column == 1 else 26
            header.resizeSection(column, metrics.horizontalAdvance(text) + extra)

    def mouseDoubleClickEvent(self, event: Any) -> None:
        index = self.indexAt(event.position().toPoint())
        if index.isValid() and _FIELDS[index.column()] == "colour" and self.rows_model.editable:
            self.colour_requested.emit(index.row())
        else:
            super().mouseDoubleClickEvent(event)
