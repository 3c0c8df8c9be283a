"""The landmarks with their keys, and how each is seen in every camera at this frame."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any, TypeAlias

from PySide6.QtCore import (
    QAbstractTableModel,
    QItemSelectionModel,
    QModelIndex,
    QPersistentModelIndex,
    QPointF,
    QRect,
    QSignalBlocker,
    QSize,
    Qt,
    Signal,
)
from PySide6.QtGui import QColor, QFontDatabase, QPainter, QPalette, QPen
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QTableView,
    QVBoxLayout,
    QWidget,
)

from ..style.theme import current_theme
from .cells import RIGHT, dress_table
from .landmark_rows import CELL_WORDS, CellState, LandmarkRow

_Index: TypeAlias = QModelIndex | QPersistentModelIndex
_KEY, _LABEL = 0, 1
_FIRST_CAMERA = 2
_STATE = Qt.ItemDataRole.UserRole
_COLOUR = Qt.ItemDataRole.UserRole + 1


class _Model(QAbstractTableModel):
    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.rows: tuple[LandmarkRow, ...] = ()
        self.cameras: tuple[str, ...] = ()
        self._digits = QFontDatabase.systemFont(QFontDatabase.SystemFont.FixedFont)

    @property
    def headings(self) -> tuple[str, ...]:
        """Names of the cameras without what all of them begin with."""
        same = os.path.commonprefix(self.cameras).rstrip("0123456789")  # noqa: RUF071 - letters are meant
        whole = len(self.cameras) < 2 or any(name == same for name in self.cameras)
        return self.cameras if whole else tuple(name[len(same) :] for name in self.cameras)

    def rowCount(self, parent: _Index | None = None) -> int:
        return 0 if parent is not None and parent.isValid() else len(self.rows)

    def columnCount(self, parent: _Index | None = None) -> int:
        inside = parent is not None and parent.isValid()
        return 0 if inside else _FIRST_CAMERA + len(self.cameras) + 2

    def set_rows(self, cameras: tuple[str, ...], rows: tuple[LandmarkRow, ...]) -> bool:
        """Whether the table had to be made anew."""
        names = tuple(row.landmark for row in rows)
        same = cameras == self.cameras and names == tuple(row.landmark for row in self.rows)
        if same and rows:
            self.rows = rows
            last = self.index(len(rows) - 1, self.columnCount() - 1)
            self.dataChanged.emit(self.index(0, 0), last)
            return False
        self.beginResetModel()
        self.cameras, self.rows = cameras, rows
        self.endResetModel()
        return True

    def headerData(
        self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole
    ) -> Any:
        if orientation != Qt.Orientation.Horizontal:
            return None
        headings = ("", "Landmark", *self.headings, "px", "mm")
        tips = (
            "Key that selects the landmark",
            "Select a landmark here to place it with the next click",
            *(f"Visibility in {camera}" for camera in self.cameras),
            "Root mean square distance of its clicks from the fitted model",
            "Distance between the triangulated clicks and the model",
        )
        if role == Qt.ItemDataRole.DisplayRole:
            return headings[section]
        if role == Qt.ItemDataRole.ToolTipRole:
            return tips[section]
        if role == Qt.ItemDataRole.TextAlignmentRole:
            left = section == _LABEL
            side = Qt.AlignmentFlag.AlignLeft if left else Qt.AlignmentFlag.AlignHCenter
            return side | Qt.AlignmentFlag.AlignVCenter
        return None

    def data(self, index: _Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        row, column = self.rows[index.row()], index.column()
        camera = column - _FIRST_CAMERA
        if 0 <= camera < len(self.cameras):
            return self._cell(row, camera, role)
        texts = {
            _KEY: row.key,
            _LABEL: row.label,
            _FIRST_CAMERA + len(self.cameras): row.residual,
            _FIRST_CAMERA + len(self.cameras) + 1: f"{row.distance} ",
        }
        number = column > _LABEL
        match role:
            case Qt.ItemDataRole.DisplayRole:
                return texts[column]
            case Qt.ItemDataRole.FontRole if number:
                return self._digits
            case Qt.ItemDataRole.TextAlignmentRole if number:
                return RIGHT
            case Qt.ItemDataRole.TextAlignmentRole if column == _KEY:
                return Qt.AlignmentFlag.AlignCenter
            case Qt.ItemDataRole.ForegroundRole if number and row.bad:
                return QColor(current_theme().warning)
            case Qt.ItemDataRole.ToolTipRole if number and row.bad:
                return "The fit treats a click of this landmark as an outlier."
            case _ if role == _COLOUR:
                return row.colour
        return None

    def _cell(self, row: LandmarkRow, camera: int, role: int) -> Any:
        state = row.cells[camera]
        if role == _STATE:
            return state
        if role == _COLOUR:
            return row.colour
        if role in {Qt.ItemDataRole.ToolTipRole, Qt.ItemDataRole.AccessibleTextRole}:
            return f"{row.label} in {self.cameras[camera]}: {CELL_WORDS[state]}"
        return None


class _Delegate(QStyledItemDelegate):
    """Keys as coloured keycaps, states as the marks in the pictures are drawn."""

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: _Index) -> None:
        option.state &= ~QStyle.StateFlag.State_HasFocus
        state = index.data(_STATE)
        if index.column() != _KEY and state is None:
            super().paint(painter, option, index)
            return
        widget = option.widget
        style = widget.style() if widget is not None else None
        if style is not None:
            panel = QStyle.PrimitiveElement.PE_PanelItemViewItem
            style.drawPrimitive(panel, option, painter, widget)
        painter.save()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        colour = QColor(index.data(_COLOUR))
        if state is None:
            _paint_key(painter, option.rect, colour, index.data() or "")
        elif option.state & QStyle.StateFlag.State_Selected:
            # on the selection's own colour some of the limbs' would not be seen
            text = option.palette.color(QPalette.ColorRole.HighlightedText)
            _paint_state(painter, QPointF(option.rect.center()) + QPointF(0.5, 0.5), text, state)
        else:
            _paint_state(painter, QPointF(option.rect.center()) + QPointF(0.5, 0.5), colour, state)
        painter.restore()

    def sizeHint(self, option: QStyleOptionViewItem, index: _Index) -> QSize:
        hint = super().sizeHint(option, index)
        return QSize(26, hint.height()) if index.column() == _KEY else hint


def _paint_key(painter: QPainter, rect: QRect, colour: QColor, text: str) -> None:
    side = min(rect.width(), rect.height()) - 4
    cap = QRect(0, 0, side, side)
    cap.moveCenter(rect.center())
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(colour)
    painter.drawRoundedRect(cap, 3.0, 3.0)
    light = colour.lightnessF() > 0.5
    painter.setPen(QColor("black") if light else QColor("white"))
    painter.drawText(cap, Qt.AlignmentFlag.AlignCenter, text)


def _paint_state(painter: QPainter, centre: QPointF, colour: QColor, state: CellState) -> None:
    theme = current_theme()
    dim = theme.is_dark and 0.05 < colour.lightnessF() < 0.32
    visible = colour.lighter(130) if dim else colour
    painter.setBrush(Qt.BrushStyle.NoBrush)
    match state:
        case "clicked":
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(visible)
            painter.drawEllipse(centre, 4.5, 4.5)
        case "guessed":
            painter.setPen(QPen(visible, 2.0))
            painter.drawEllipse(centre, 4.2, 4.2)
        case "doubted":
            pen = QPen(visible, 2.0)
            pen.setDashPattern([1.2, 1.0])
            painter.setPen(pen)
            painter.drawEllipse(centre, 4.2, 4.2)
        case "predicted":
            painter.setPen(QPen(visible, 1.6))
            painter.drawLine(centre + QPointF(-4, -4), centre + QPointF(4, 4))
            painter.drawLine(centre + QPointF(-4, 4), centre + QPointF(4, -4))
        case "outside":
            painter.setPen(QPen(QColor(theme.muted), 1.4))
            painter.drawRect(int(centre.x() - 5), int(centre.y() - 4), 10, 8)
            painter.drawLine(centre + QPointF(-5, 4), centre + QPointF(5, -4))
        case _:
            painter.setPen(QPen(QColor(theme.disabled), 1.4))
            painter.drawLine(centre + QPointF(-3, 0), centre + QPointF(3, 0))


class LandmarksPanel(QWidget):
    """Table of the landmarks; choosing one there chooses what a click places.

    Signals
    -------
    chosen : str
        Name of the landmark.
    """

    chosen = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._model = _Model(self)
        self.table = QTableView(self)
        self.table.setModel(self._model)
        self.table.setItemDelegate(_Delegate(self.table))
        dress_table(self.table, "Landmarks", room=5)
        self.table.setAlternatingRowColors(False)
        self.table.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        header = self.table.horizontalHeader()
        header.setMinimumSectionSize(24)
        header.setStyleSheet("QHeaderView::section { padding: 3px 4px; }")
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self.table)
        self.table.selectionModel().currentRowChanged.connect(self._on_row)
        self.table.pressed.connect(self._on_row)  # also the row that is chosen already

    def show_rows(self, cameras: Sequence[str], rows: Sequence[LandmarkRow]) -> None:
        """Show the landmarks; `cameras` are the headings of their cells."""
        with QSignalBlocker(self.table.selectionModel()):
            if self._model.set_rows(tuple(cameras), tuple(rows)):
                self._size_columns()
            place = next((i for i, row in enumerate(rows) if row.chosen), -1)
            if place >= 0 and self.table.currentIndex().row() != place:
                flags = QItemSelectionModel.SelectionFlag
                self.table.selectionModel().setCurrentIndex(
                    self._model.index(place, _LABEL), flags.ClearAndSelect | flags.Rows
                )
        self.table.viewport().update()

    def _size_columns(self) -> None:
        header = self.table.horizontalHeader()
        mode = QHeaderView.ResizeMode
        for column in range(self._model.columnCount()):
            header.setSectionResizeMode(column, mode.Fixed)
        header.setSectionResizeMode(_LABEL, mode.Stretch)
        header.resizeSection(_KEY, 26)
        metrics = self.fontMetrics()
        for column, name in enumerate(self._model.headings, start=_FIRST_CAMERA):
            header.resizeSection(column, max(26, metrics.horizontalAdvance(name) + 12))
        numbers = metrics.horizontalAdvance("888.8") + 14
        for column in range(_FIRST_CAMERA + len(self._model.cameras), self._model.columnCount()):
            header.resizeSection(column, numbers)

    def _on_row(self, current: QModelIndex, _previous: QModelIndex | None = None) -> None:
        if current.isValid():
            self.chosen.emit(self._model.rows[current.row()].landmark)
