"""Range of motion of every joint angle in a table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QWidget

from ..style.building import action_button, hbox, number_box, vbox
from ..style.elided_label import ElidedLabel
from ..style.limb_colours import LIMB_COLOURS
from .table import RIGHT, Cell, Column, TableModel, new_table

_NOTHING = "No joint angles are known for these frames."


@dataclass(frozen=True)
class MotionRow:
    """One angle, called `key` when its row is clicked, in the colour of its limb."""

    key: str
    limb: str
    label: str
    cells: tuple[str, ...]
    hint: str


class MotionTable(QWidget):
    """A row per angle; a click shows that angle."""

    angle_chosen = Signal(str)
    cut_off_changed = Signal()
    """Another low-pass shall be used."""

    def __init__(self, cut_off: float, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.words = ElidedLabel(_NOTHING, self)
        self.model = TableModel((), _cells)
        self.table = new_table(self.model, "Range of motion of each joint angle", room=4)
        self.table.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.table.clicked.connect(
            lambda index: self.angle_chosen.emit(self.model.rows[index.row()].key)
        )
        self.cut_off = number_box(
            "Low-pass cut-off frequency",
            (0.1, 50.0),
            cut_off,
            "Cut-off frequency of the low-pass filter for velocities, accelerations and ranges; "
            "at most 0.4 of the frame rate",
            prefix="low-pass ",
            suffix=" Hz",
        )
        self.cut_off.valueChanged.connect(lambda _: self.cut_off_changed.emit())
        self._top = hbox((self.words, 1), self.cut_off, margins=(8, 2, 4, 0))
        self.setLayout(vbox(self._top, (self.table, 1), spacing=0))
        self.table.hide()

    def add_action_button(self, action: QAction) -> None:
        """Offer a command above the table."""
        self._top.addWidget(action_button(action))

    def set_highest_cut_off(self, usual: float, highest: float) -> None:
        """Allow a low-pass up to `highest`, and begin with the usual one, hertz."""
        self.cut_off.setMaximum(max(highest, self.cut_off.minimum()))
        self.cut_off.setValue(min(usual, highest))

    def show_rows(
        self, words: str, columns: Sequence[tuple[str, str]], rows: Sequence[MotionRow]
    ) -> None:
        """Show rows under columns (heading, tip); no rows stand for nothing to show."""
        self.words.set_words(words if rows else _NOTHING)
        self.table.setVisible(bool(rows))
        numbers = (Column(heading, tip, align=RIGHT) for heading, tip in columns)
        self.model.show(rows, (Column("Angle"), *numbers))
        header = self.table.horizontalHeader()
        header.setMinimumSectionSize(40)
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)


def _cells(row: MotionRow) -> Sequence[Cell]:
    name = Cell(row.label, row.hint, swatch=LIMB_COLOURS[row.limb])
    return (name, *(Cell(text, row.hint) for text in row.cells))
