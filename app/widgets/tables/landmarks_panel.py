"""The landmarks with their keys and how each camera sees them, and what to click next."""

import os
from collections.abc import Callable, Mapping, Sequence
from typing import Literal, TypeAlias

from PySide6.QtCore import QModelIndex, QPointF, QRect, QSignalBlocker, Qt
from PySide6.QtGui import QColor, QPainter, QPalette, QPen, QResizeEvent
from PySide6.QtWidgets import QCheckBox, QPushButton, QStyle, QStyleOptionViewItem, QWidget

from stereotrack_core.annotation.click import ClickKey
from stereotrack_core.annotation.next_clicks import StopSign, Suggestion

from ..forms.numbers import NumberField
from ..style.building import hbox, label, vbox
from ..style.theme import current_theme, set_look
from .table import RIGHT, STRETCH, Cell, CellRow, CellTable, Column, Index, RowDelegate

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


_COLUMNS = (
    Column("Frame", align=RIGHT),
    Column("View"),
    Column("Landmark"),
    Column(
        "Gain [°]",
        "Expected reduction of the angular uncertainty of the limbs, over all frames that benefit. "
        "The list is sorted by this; occluded landmarks and views that disagree with the others "
        "come last.",
        RIGHT,
    ),
    Column("Reason", width=STRETCH),
)
_REASON = len(_COLUMNS) - 1
_NONE = "Fit the whole recording to see suggested clicks. The most useful ones come first."
_NARROW = 460
_KEPT = 1000


class NextPanel(QWidget):
    """A stop sign in words, the wanted accuracy, and the suggestions below.

    `visit` is called with the frame, camera and landmark to go to; `nothing_left` if no click is
    suggested that one could go to.
    """

    def __init__(
        self, visit: Callable[[int, str, str], object], nothing_left: Callable[[], object]
    ) -> None:
        super().__init__()
        self._visit, self._nothing_left = visit, nothing_left
        self._colours: Mapping[str, str] = {}
        self._views: Mapping[str, str] = {}
        self._visited: set[ClickKey] = set()
        self.sign = label()
        tip = "Target uncertainty. Suggestions stop when all limbs are within this angle."
        self.wanted = NumberField(
            minimum=0.1, maximum=45.0, value=3.0, singleStep=0.5, prefix="± ", suffix="°",
            keyboardTracking=False, accessibleName="Target uncertainty", toolTip=tip,
        )  # fmt: skip
        self.limit = QCheckBox("Selected frames only")
        self.limit.setToolTip("Suggest clicks only in the frames selected in the timeline")
        self.next_button = QPushButton("Go to next")
        self.next_button.clicked.connect(self.go_to_next)
        self.fit_button = QPushButton("Fit whole recording")
        self.fit_button.setToolTip("Fit the body model to all clicks")
        self.reason = label("", "muted", margins=(8, 3, 8, 4))
        self.tree = CellTable("Suggested clicks", _COLUMNS, self._cells, single=True)
        for chosen in (self.tree.clicked, self.tree.activated):
            chosen.connect(lambda index: self._go_to(index.row()))
        self.tree.selectionModel().currentRowChanged.connect(self._show_reason)
        self._lay_out()
        self._sign: StopSign | None = None
        self.awaited = False
        """Whether to go to the best place as soon as one is known."""
        self.show_ranking((), None, {})

    def _lay_out(self) -> None:
        tools = hbox(self.next_button, self.limit, None, self.wanted)
        self._head, self._unfitted = QWidget(), QWidget()
        self._head.setLayout(vbox(self.sign, tools, margins=(8, 4, 8, 4), spacing=4))
        fit = hbox(self.fit_button, None)
        self._unfitted.setLayout(vbox(label(_NONE, "muted"), fit, None, margins=(10, 10, 10, 10)))
        parts = (self._unfitted, 1), self._head, (self.tree, 1), self.reason
        self.setLayout(vbox(*parts, spacing=0))

    def show_wanted(self, degrees: float) -> None:
        with QSignalBlocker(self.wanted):
            self.wanted.setValue(degrees)

    def show_ranking(
        self,
        rows: Sequence[Suggestion],
        sign: StopSign | None,
        colours: Mapping[str, str],
        views: Mapping[str, str] | None = None,
    ) -> None:
        """Show what to click next; without a stop sign nothing is fitted yet."""
        self._sign = sign
        self._unfitted.setVisible(sign is None)
        self._head.setVisible(sign is not None)
        self.tree.setVisible(sign is not None)
        current = self.tree.currentIndex()
        key = self.tree.cells.rows[current.row()].key if current.isValid() else None
        self._colours, self._views = colours, views or {}
        self.tree.show_rows(rows)
        places = (place for place, one in enumerate(rows[:_KEPT]) if one.key == key)
        self.tree.setCurrentIndex(self.tree.cells.index(next(places, -1), 0))
        self._show_reason()
        self.reason.setVisible(sign is not None and bool(rows))
        self.next_button.setEnabled(bool(rows))
        if sign is not None:
            words, doubted = sign.words(), sign.reached and any(one.click_there for one in rows)
            doubt = ", once the outlying clicks are corrected" if doubted else ""
            self.sign.setText(f"{words[:1].upper()}{words[1:]}{doubt}.")
            role = "doubted" if doubted else "reached" if sign.reached else "heading"
            set_look(self.sign, "role", role)
            if self.awaited and rows:
                self.go_to_next()

    def go_to_next(self) -> None:
        """Go to the best place that nobody went to yet; where none is known, fit to find one."""
        row = self._first_unvisited()
        self.awaited = row is None
        if row is not None:
            self._go_to(row)
        elif self._sign is None:
            self.fit_button.click()
        else:
            self._nothing_left()

    def _first_unvisited(self) -> int | None:
        """The best row that nobody went to yet; the best one where all were; None without rows."""
        rows: Sequence[Suggestion] = self.tree.cells.rows
        if all(one.key in self._visited for one in rows):
            self._visited.clear()
        return next((k for k, one in enumerate(rows) if one.key not in self._visited), None)

    def _cells(self, one: Suggestion) -> Sequence[Cell]:
        tip = (
            f"{one.reason}\nExpected gain of a click here: {one.gain_deg:.2f}° in this frame, "
            f"{one.over_frames_deg:.1f}° over all frames."
        )
        colour = "muted" if one.key in self._visited or not one.clear else ""
        doubt = colour or ("warning" if one.click_there else "")
        swatch = self._colours.get(one.landmark, "#808080")
        return (
            Cell(str(one.frame), tip, colour),
            Cell(self._views.get(one.camera, one.camera), tip, colour),
            Cell(one.landmark.replace("_", " "), tip, colour, swatch),
            Cell(f"{one.over_frames_deg:.1f}", tip, colour),
            Cell(f"check: {one.reason}" if one.click_there else one.reason, tip, doubt),
        )

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        # what is left out is said below the list
        self.tree.setColumnHidden(_REASON, self.width() < _NARROW)

    def _show_reason(self) -> None:
        """Write the reason of the chosen row, or of the best one, where there is room for it."""
        row = max(self.tree.currentIndex().row(), 0)
        if row < len(self.tree.cells.rows):
            cells = (self.tree.cells.cell(row, column).text for column in range(len(_COLUMNS)))
            frame, view, landmark, _, reason = cells
            self.reason.setText(f"{frame}, {landmark} in {view}: {reason}.")

    def _go_to(self, row: int) -> None:
        one = self.tree.cells.rows[row]
        self.tree.setCurrentIndex(self.tree.cells.index(row, 0))
        self._visited.add(one.key)
        self.tree.cells.look_again()
        self._visit(one.frame, one.camera, one.landmark)
