"""Tables of a page."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from stereotrack_core.report.html import Content, Html, element


@dataclass(frozen=True)
class Row:
    """A line of a table.

    Attributes
    ----------
    cells : sequence of Content
    kind : str
        Class of the style: ``given`` for numbers of somebody else, ``first`` for the first line
        of a group; several are joined by a space.
    """

    cells: Sequence[Content]
    kind: str = ""


def table(columns: Sequence[str], rows: Sequence[Row | Sequence[Content]]) -> Html:
    """A table; a heading that begins with ``>`` stands over right-aligned numbers.

    The first cell of every row is its heading.
    """
    right = [heading.startswith(">") for heading in columns]
    head = element(
        "tr",
        *(
            element("th", name.removeprefix(">"), class_="right" if r else None, scope="col")
            for name, r in zip(columns, right, strict=True)
        ),
    )
    lines = [_line(row if isinstance(row, Row) else Row(row), right) for row in rows]
    drawn = element("table", element("thead", head), element("tbody", *lines))
    return element("div", drawn, class_="wide")


def number(value: float, digits: int = 1) -> str:
    """A number; a dash where it is not known."""
    return f"{value:.{digits}f}" if math.isfinite(value) else "–"


def _line(row: Row, right: Sequence[bool]) -> Html:
    cells = [
        element(
            "th" if i == 0 else "td",
            cell,
            class_="right" if r else None,
            scope="row" if i == 0 else None,
        )
        for i, (cell, r) in enumerate(zip(row.cells, right, strict=True))
    ]
    return element("tr", *cells, class_=row.kind or None)
