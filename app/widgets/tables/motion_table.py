"""Range of motion of every joint angle in a table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import QEvent, Qt, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QAbstractItemView,
    QDoubleSpinBox,
    QHBoxLayout,
    QHeaderView,
    QTableWidget,
    QTableWidgetItem,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from ..style.elided_label import ElidedLabel
from ..style.limb_colours import LIMB_COLOURS
from .cells import LEFT, RIGHT, dress_table, swatch

_NOTHING = "No joint angles are known for these frames."


@dataclass(frozen=True)
class MotionRow:
    """One angle.

    Attributes
    ----------
    key : str
        What is shown when the row is clicked.
    limb : str
        Whose colour it has.
    label : str
    cells : tuple of str
    hint : str
    """

    key: str
    limb: str
    label: str
    cells: tuple[str, ...]
    hint: str


class MotionTable(QWidget):
    """A row per angle; a click shows that angle.

    Signals
    -------
    angle_chosen : str
    cut_off_changed : ()
        Another low-pass shall be used.
    """

    angle_chosen = Signal(str)
    cut_off_changed = Signal()

    def __init__(self, cut_off: float, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.words = ElidedLabel(_NOTHING, self)
        self.table = QTableWidget(self)
        dress_table(self.table, "Range of motion of each joint angle", room=4)
        self.table.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.table.cellClicked.connect(self._on_clicked)
        self.cut_off = QDoubleSpinBox(self)
        self.cut_off.setRange(0.1, 50.0)
        self.cut_off.setSingleStep(0.5)
        self.cut_off.setDecimals(1)
        self.cut_off.setValue(cut_off)
        self.cut_off.setPrefix("low-pass ")
        self.cut_off.setSuffix(" Hz")
        self.cut_off.setKeyboardTracking(False)
        self.cut_off.setAccessibleName("Low-pass cut-off frequency")
        self.cut_off.setToolTip(
            "Cut-off frequency of the low-pass filter for velocities, accelerations and ranges; "
            "at most 0.4 of the frame rate"
        )
        self.cut_off.valueChanged.connect(lambda _: self.cut_off_changed.emit())
        self._buttons = QHBoxLayout()
        self._buttons.addWidget(self.cut_off)
        top = QHBoxLayout()
        top.setContentsMargins(8, 2, 4, 0)
        top.addWidget(self.words, 1)
        top.addLayout(self._buttons)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addLayout(top)
        layout.addWidget(self.table, 1)
        self._rows: tuple[MotionRow, ...] = ()
        self.table.hide()

    def add_action_button(self, action: QAction) -> None:
        """Offer a command above the table."""
        button = QToolButton(self)
        button.setDefaultAction(action)
        self._buttons.addWidget(button)

    def set_highest_cut_off(self, usual: float, highest: float) -> None:
        """Allow a low-pass up to `highest`, and begin with the usual one, hertz."""
        self.cut_off.setMaximum(max(highest, self.cut_off.minimum()))
        self.cut_off.setValue(min(usual, highest))

    def show_rows(
        self, words: str, columns: Sequence[tuple[str, str]], rows: Sequence[MotionRow]
    ) -> None:
        """Show rows under columns (heading, tip); no rows stand for nothing to show."""
        self._rows = tuple(rows)
        self.words.set_words(words if rows else _NOTHING)
        self.table.setVisible(bool(rows))
        self.table.setColumnCount(1 + len(columns))
        self.table.setRowCount(len(rows))
        for column, (heading, tip) in enumerate([("Angle", ""), *columns]):
            item = QTableWidgetItem(heading)
            item.setToolTip(tip)
            item.setTextAlignment(RIGHT if column else LEFT)
            self.table.setHorizontalHeaderItem(column, item)
        header = self.table.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        header.setMinimumSectionSize(40)
        for place, row in enumerate(rows):
            self._write(place, row)

    def _write(self, place: int, row: MotionRow) -> None:
        first = QTableWidgetItem(row.label)
        first.setData(Qt.ItemDataRole.DecorationRole, swatch(LIMB_COLOURS[row.limb]))
        items = [first, *(QTableWidgetItem(cell) for cell in row.cells)]
        for column, item in enumerate(items):
            item.setToolTip(row.hint)
            if column:
                item.setTextAlignment(RIGHT)
            self.table.setItem(place, column, item)

    def _on_clicked(self, row: int, _column: int) -> None:
        self.angle_chosen.emit(self._rows[row].key)

    def changeEvent(self, event: QEvent) -> None:
        if event.type() == QEvent.Type.PaletteChange:
            self.table.viewport().update()
        super().changeEvent(event)
