"""Numbers of several runs beside each other, with their differences."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import Qt
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QWidget

from ..style.building import label, vbox
from ..style.limb_colours import LIMB_COLOURS
from .table import RIGHT, Cell, Column, TableModel, new_table, select_cells


@dataclass(frozen=True)
class ComparedCell:
    """A value of one run, of which less is better."""

    value: float
    """NaN where not known."""
    difference: float = math.nan
    """From the first run; NaN for that itself."""
    low: float = math.nan
    high: float = math.nan
    """`low` and `high`: 95 % interval of the difference; NaN where the frames are too few."""
    differs: bool = False
    """Whether the interval leaves 0 out."""
    verdict: str = ""
    """What that comes to, in words."""


@dataclass(frozen=True)
class ComparedRow:
    """A measure: its limb (empty for none), its label with the unit, and a cell for each run."""

    limb: str
    label: str
    cells: tuple[ComparedCell, ...]


_NOTHING = "Run the tracker to see run metrics here. Show several runs to compare them."
_COLOURS = (
    "Green is lower than the first run, so better; orange is higher. Without a colour, these "
    "frames do not show a difference: its 95 % interval contains 0, or there are too few frames "
    "for an interval."
)
_WIDEST_NAME, _ROOMY = 96, 560
"""Widest heading with a run's name; from that width of the panel on it may be half wider."""
_NARROWEST_VERDICT = 150
"""With less room the verdict is only in the tips."""


class ComparisonPanel(QWidget):
    """A row per measure and a column per run; the first run is what others are compared with."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.words = label(_NOTHING, "muted", margins=(8, 6, 8, 2))
        self._two = False
        self.model = TableModel((), self._cells)
        self.table = new_table(self.model, "Run comparison", room=4)
        select_cells(self.table)
        header = self.table.horizontalHeader()
        header.setTextElideMode(Qt.TextElideMode.ElideMiddle)
        header.setStretchLastSection(True)
        self._colours = label(_COLOURS, "muted", margins=(8, 2, 8, 4))
        self.setLayout(vbox(self.words, (self.table, 1), self._colours, spacing=2))
        self._colours.hide()
        self.table.hide()

    def show_numbers(
        self, words: str, runs: Sequence[str], rows: Sequence[ComparedRow], how: str = ""
    ) -> None:
        """Show the values of `runs`, or that there are none.

        `words` say what is compared, `how` says how the intervals are made, for the tooltip.
        """
        self.words.setText(words if runs else _NOTHING)
        self.words.setToolTip(how)
        self.table.setVisible(bool(runs and rows))
        self._colours.setVisible(bool(rows) and len(runs) > 1)
        # two runs leave room for words; of more the intervals and verdicts are in the tips
        self._two = len(runs) == 2
        columns = [Column("measure", "measure"), *(Column(run, run, align=RIGHT) for run in runs)]
        if self._two:
            between = "difference (95 %)"
            columns += [Column(between, between, align=RIGHT), Column("conclusion", "conclusion")]
        self.model.show(rows if runs else (), columns)
        self._fit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        """Give numbers the room they need, long names what is left of it."""
        table, header = self.table, self.table.horizontalHeader()
        count = len(self.model.columns)
        verdict, names = (4, 2) if self._two else (-1, count - 1)
        used, widest_name = 0, _WIDEST_NAME * (1.5 if self.width() >= _ROOMY else 1.0)
        for column in range(count):
            if column != verdict:
                widest = round(widest_name) if 0 < column <= names else self.width()
                heading = min(header.sectionSizeHint(column), widest)
                width = max(table.sizeHintForColumn(column), heading)
                table.setColumnWidth(column, width)
                used += width
        if verdict > 0:
            table.setColumnHidden(verdict, self.width() - used < _NARROWEST_VERDICT)

    def _cells(self, row: ComparedRow) -> Sequence[Cell]:
        name = Cell(row.label, swatch=LIMB_COLOURS.get(row.limb, ""))
        values = [_value(cell, alone=self._two) for cell in row.cells]
        if not self._two:
            return (name, *values)
        cell = row.cells[1]
        difference = ""
        if _has_difference(cell):
            difference = f"{cell.difference:+z.1f}"
            known = not math.isnan(cell.low)
            between = f"{cell.low:+z.1f} to {cell.high:+z.1f}" if known else "too few frames"
            difference += f" ({between})"
        colour = _colour(cell)
        return (
            name,
            *values,
            Cell(difference, _sentence(cell.verdict), colour),
            Cell(cell.verdict, cell.verdict, colour),
        )


def _value(cell: ComparedCell, *, alone: bool) -> Cell:
    """A value, `alone` or with its difference in brackets."""
    if math.isnan(cell.value):
        words = "" if math.isnan(cell.difference) and not cell.verdict else "unknown"
    else:
        words = f"{cell.value:.1f}"
    if not alone and _has_difference(cell):
        words += f" ({cell.difference:+z.1f})"
    return Cell(words, _sentence(cell.verdict), _colour(cell))


def _has_difference(cell: ComparedCell) -> bool:
    known = not math.isnan(cell.value) and not math.isnan(cell.difference)
    return known and not cell.low == cell.high == 0.0


def _sentence(words: str) -> str:
    return f"{words[0].upper()}{words[1:]}." if words else ""


def _colour(cell: ComparedCell) -> str:
    """Only what the frames can show is coloured."""
    return "" if not cell.differs else "good" if cell.difference < 0 else "warning"
