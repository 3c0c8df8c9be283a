"""A table that says, landmark by landmark, how far two readings are apart."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QHeaderView, QTableWidget, QTableWidgetItem, QWidget

from .cells import LEFT, RIGHT, dress_table, make_bold, swatch

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
    """Numbers of one landmark; NaN where they are not known.

    Attributes
    ----------
    name : str
    colour : str
        ``#rrggbb``; empty for all landmarks together.
    count : int
    sigma, median, p95, largest : float
        Pixels.
    bias : (float, float)
        Pixels, to the right and down.
    disputed : int
    median_mm, p95_mm : float
    median_deg, p95_deg : float
        Of the limb that it tells.
    """

    name: str
    colour: str
    count: int
    sigma: float
    median: float
    p95: float
    largest: float
    bias: tuple[float, float]
    disputed: int
    median_mm: float
    p95_mm: float
    median_deg: float
    p95_deg: float


class AgreementTable(QTableWidget):
    """A row per landmark; the first one is all of them together."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(0, len(_HEADINGS), parent)
        for column, (heading, tip) in enumerate(_HEADINGS):
            item = QTableWidgetItem(heading)
            item.setToolTip(tip)
            item.setTextAlignment(RIGHT if column else LEFT)
            self.setHorizontalHeaderItem(column, item)
        dress_table(self, "Agreement by landmark")
        self.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)

    def show_rows(self, rows: Sequence[AgreementRow]) -> None:
        """Show these landmarks."""
        self.setRowCount(len(rows))
        for place, row in enumerate(rows):
            texts = _texts(row)
            for column, text in enumerate(texts):
                item = QTableWidgetItem(text)
                item.setTextAlignment(RIGHT if column else LEFT)
                if not row.colour:
                    make_bold(item)
                if not column:
                    item.setData(Qt.ItemDataRole.DecorationRole, swatch(row.colour))
                self.setItem(place, column, item)

    def as_text(self) -> str:
        """The table with tabs, for a paper or a spreadsheet."""
        lines = ["\t".join(heading for heading, _ in _HEADINGS)]
        for row in range(self.rowCount()):
            cells = (self.item(row, column) for column in range(self.columnCount()))
            lines.append("\t".join(cell.text() if cell is not None else "" for cell in cells))
        return "\n".join(lines)


def _texts(row: AgreementRow) -> tuple[str, ...]:
    x, y = row.bias
    bias = "–" if math.isnan(x) else f"{x:+.1f}, {y:+.1f}"
    pixels = (row.sigma, row.median, row.p95, row.largest)
    space = (row.median_mm, row.p95_mm, row.median_deg, row.p95_deg)
    return (
        row.name, str(row.count), *map(_number, pixels), bias, *map(_number, space),
        str(row.disputed),
    )  # fmt: skip


def _number(value: float) -> str:
    return "–" if math.isnan(value) else f"{value:.1f}"
