"""The landmarks with their keys, and how each is seen in every camera at this frame."""

import os
from collections.abc import Callable, Sequence
from typing import Literal, TypeAlias

from PySide6.QtCore import QModelIndex, QPointF, QRect, Qt
from PySide6.QtGui import QColor, QPainter, QPalette, QPen
from PySide6.QtWidgets import QStyle, QStyleOptionViewItem, QWidget

from ..style.building import vbox
from ..style.theme import current_theme
from .table import RIGHT, STRETCH, CellRow, CellTable, Column, Index, RowDelegate

CellState: TypeAlias = Literal["clicked", "guessed", "doubted", "outside", "predicted", "missing"]

CELL_WORDS: dict[CellState, str] = {
    "clicked": "clicked",
    "guessed": "occluded, position estimated",
    "doubted": "clicked, flagged as uncertain",
    "outside": "outside the image",
    "predicted": "not clicked; a prediction is available",
    "missing": "not clicked",
}
"""States of a landmark in one camera, in words."""

_KEY, _LABEL = 0, 1
_NUMBER = 50


class LandmarksPanel(QWidget):
    """Table of the landmarks; `choose` is called with the place of one that is chosen there."""

    def __init__(self, choose: Callable[[int], object]) -> None:
        super().__init__()
        self._choose = choose
        self._chosen = -1
        self.table = CellTable("Landmarks", single=True)
        self.table.setItemDelegate(_Marks(self.table))
        self.table.setAlternatingRowColors(False)
        self.setLayout(vbox(self.table))
        self.table.selectionModel().currentRowChanged.connect(self._on_other_row)
        # also the row that is chosen already
        self.table.pressed.connect(lambda index: choose(index.row()))

    def show_rows(self, cameras: Sequence[str], rows: Sequence[CellRow], chosen: int) -> None:
        """Show the landmarks: key, name, a cell for each of the `cameras`, and two numbers.

        Values of cells: the colour for the key, colour and state in a camera.
        """
        self._chosen = chosen
        self.table.show_rows(rows, _columns(cameras))
        if chosen >= 0 and self.table.currentIndex().row() != chosen:
            self.table.setCurrentIndex(self.table.cells.index(chosen, _LABEL))

    def _on_other_row(self, current: QModelIndex) -> None:
        if current.isValid() and current.row() != self._chosen:
            self._choose(current.row())


def _columns(cameras: Sequence[str]) -> tuple[Column, ...]:
    """Columns of the table; cameras without what all their names begin with."""
    same = os.path.commonprefix(cameras).rstrip("0123456789")  # noqa: RUF071 - letters are meant
    whole = len(cameras) < 2 or any(name == same for name in cameras)
    start = 0 if whole else len(same)
    number = (RIGHT, True, _NUMBER)
    return (
        Column("", "Key that selects the landmark", width=26),
        Column("Landmark", "Select a landmark here to place it with the next click", width=STRETCH),
        *(
            Column(name[start:], f"Visibility in {name}", Qt.AlignmentFlag.AlignCenter)
            for name in cameras
        ),
        Column("px", "Root mean square distance of its clicks from the fitted model", *number),
        Column("mm", "Distance between the triangulated clicks and the model", *number),
    )


class _Marks(RowDelegate):
    """Keys as coloured keycaps, states as the marks in the pictures are drawn."""

    def __init__(self, table: CellTable) -> None:
        super().__init__(table)
        self._table = table

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        cell = self._table.cells.cell(index.row(), index.column())
        if cell.value is None:
            super().paint(painter, option, index)
            return
        option.state &= ~QStyle.StateFlag.State_HasFocus
        panel = QStyle.PrimitiveElement.PE_PanelItemViewItem
        self._table.style().drawPrimitive(panel, option, painter, self._table)
        painter.save()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if index.column() == _KEY:
            _paint_key(painter, option.rect, QColor(cell.value), cell.text)
        else:
            colour, state = cell.value
            if option.state & QStyle.StateFlag.State_Selected:
                # on the selection's own colour some of the limbs' would not be seen
                colour = option.palette.color(QPalette.ColorRole.HighlightedText)
            centre = QPointF(option.rect.center()) + QPointF(0.5, 0.5)
            _paint_state(painter, centre, QColor(colour), state)
        painter.restore()


def _paint_key(painter: QPainter, rect: QRect, colour: QColor, text: str) -> None:
    side = min(rect.width(), rect.height()) - 4
    cap = QRect(0, 0, side, side)
    cap.moveCenter(rect.center())
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(colour)
    painter.drawRoundedRect(cap, 3.0, 3.0)
    painter.setPen(QColor("black" if colour.lightnessF() > 0.5 else "white"))
    painter.drawText(cap, Qt.AlignmentFlag.AlignCenter, text)


def _paint_state(painter: QPainter, centre: QPointF, colour: QColor, state: CellState) -> None:
    theme = current_theme()
    dim = theme.is_dark and 0.05 < colour.lightnessF() < 0.32
    visible = colour.lighter(130) if dim else colour
    painter.translate(centre)
    painter.setBrush(Qt.BrushStyle.NoBrush)
    match state:
        case "clicked":
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(visible)
            painter.drawEllipse(QPointF(), 4.5, 4.5)
        case "guessed" | "doubted":
            pen = QPen(visible, 2.0)
            if state == "doubted":
                pen.setDashPattern([1.2, 1.0])
            painter.setPen(pen)
            painter.drawEllipse(QPointF(), 4.2, 4.2)
        case "predicted":
            painter.setPen(QPen(visible, 1.6))
            painter.drawLine(-4, -4, 4, 4)
            painter.drawLine(-4, 4, 4, -4)
        case "outside":
            painter.setPen(QPen(QColor(theme.muted), 1.4))
            painter.drawRect(-5, -4, 10, 8)
            painter.drawLine(-5, 4, 5, -4)
        case _:
            painter.setPen(QPen(QColor(theme.disabled), 1.4))
            painter.drawLine(-3, 0, 3, 0)
