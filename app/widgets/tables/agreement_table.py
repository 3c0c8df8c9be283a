"""A table that says, landmark by landmark, how far two readings are apart."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtWidgets import QHeaderView, QTableView, QWidget

from stereotrack_core.annotation.agreement import Agreement, AgreementInSpace

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
    """How far both are apart at one landmark."""

    name: str
    colour: str
    """``#rrggbb``; empty for all landmarks together."""
    own: Agreement
    """In pixels."""
    space: AgreementInSpace | None = None
    """In 3-D; None where it is not told."""


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
    own, space = row.own, row.space
    bias = "–" if math.isnan(own.bias[0]) else "{:+.1f}, {:+.1f}".format(*own.bias)
    pixels = (own.robust_sigma, own.median, own.p95, own.largest)
    known = (space.median_mm, space.p95_mm, space.median_deg, space.p95_deg) if space else ()
    solid = (*map(_number, known),) or ("–",) * 4
    texts = (str(own.count), *map(_number, pixels), bias, *solid, str(own.disputed))
    bold = not row.colour
    name = Cell(row.name, swatch=row.colour, bold=bold)
    return (name, *(Cell(text, bold=bold) for text in texts))


def _number(value: float) -> str:
    return "–" if math.isnan(value) else f"{value:.1f}"
