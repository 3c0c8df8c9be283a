"""A table that says, landmark by landmark, how far two readings are apart."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtWidgets import QHeaderView, QTableView, QWidget

from .table import LEFT, RIGHT, Cell, Column, TableModel, dress_table

_HEADINGS = (
    ("Landmark", ""),
    ("Pairs", "Images in which both annotations have a position"),
    ("σ [px]", "Standard deviation of one click per axis, estimated from the median distance"),
    ("Median [px]", "Median distance, pixels"),
    ("95 %", "95th percentile of the distances, pixels"),
    ("Largest", "Largest distance, pixels"),
    ("Bias", "Mean of second minus first: pixels to the right, and down"),
    ("Median [mm]", "Median distance in 3-D, where both have the landmark in two cameras"),
    ("95 %", "95th percentile of the distances in 3-D, millimetres"),
    ("Limb [°]", "Median angle between the limb directions of both annotations"),
    ("95 %", "95th percentile of the angles, degrees"),
    ("Only one", "Images in which only one of the two sees the landmark"),
)


@dataclass(frozen=True)
class AgreementRow:
    """Numbers of one landmark, NaN where they are not known: in pixels but for the last four."""

    name: str
    colour: str
    """``#rrggbb``; empty for all landmarks together."""
    count: int
    sigma: float
    median: float
    p95: float
    largest: float
    bias: tuple[float, float]
    """To the right and down."""
    disputed: int
    median_mm: float
    p95_mm: float
    median_deg: float
    """Of the limb that it tells."""
    p95_deg: float


class AgreementTable(QTableView):
    """A row per landmark; the first one is all of them together."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        columns = (
            Column(text, tip, align=RIGHT if k else LEFT) for k, (text, tip) in enumerate(_HEADINGS)
        )
        self._rows = TableModel(columns, _cells)
        self.setModel(self._rows)
        dress_table(self, "Agreement by landmark")
        self.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)

    def show_rows(self, rows: Sequence[AgreementRow]) -> None:
        """Show these landmarks."""
        self._rows.show(rows)

    def as_text(self) -> str:
        """The table with tabs, for a paper or a spreadsheet."""
        headings = "\t".join(heading for heading, _ in _HEADINGS)
        return f"{headings}\n{self._rows.as_text(range(len(self._rows.rows)))}"


def _cells(row: AgreementRow) -> Sequence[Cell]:
    x, y = row.bias
    bias = "–" if math.isnan(x) else f"{x:+.1f}, {y:+.1f}"
    pixels = (row.sigma, row.median, row.p95, row.largest)
    space = (row.median_mm, row.p95_mm, row.median_deg, row.p95_deg)
    texts = (str(row.count), *map(_number, pixels), bias, *map(_number, space), str(row.disputed))
    bold = not row.colour
    name = Cell(row.name, swatch=row.colour, bold=bold)
    return (name, *(Cell(text, bold=bold) for text in texts))


def _number(value: float) -> str:
    return "–" if math.isnan(value) else f"{value:.1f}"
