"""Tables of the reproduction as text: for files, and for the page."""

from __future__ import annotations

import math
from collections.abc import Sequence

from stereotrack_core.experiments.reproduction.outcomes import Figure
from stereotrack_core.experiments.reproduction.tables import OF_THESIS, ComparedTable, Line
from stereotrack_core.report.pages import Row, Table


def shown(figure: Figure, unit: str) -> str:
    """``32.1 ± 0.8``; millimetres without decimals; a dash where nothing is known."""
    if not math.isfinite(figure.mean):
        return "–"
    digits = 0 if unit == "mm" else 1
    text = f"{figure.mean:.{digits}f}"
    return f"{text} ± {figure.spread:.{digits}f}" if math.isfinite(figure.spread) else text


def columns_of(compared: ComparedTable) -> tuple[str, ...]:
    """Headings for reading."""
    return ("", "", *(f">{name}" for name in compared.columns))


def rows_of(compared: ComparedTable) -> list[tuple[str, ...]]:
    """Rows for reading; a measure is named once."""
    rows: list[tuple[str, ...]] = []
    before = ""
    for line in compared.lines:
        label = "" if line.label == before else _named(line)
        before = line.label
        rows.append((label, line.source, *(shown(f, line.unit) for f in line.figures)))
    return rows


def page_table(compared: ComparedTable) -> Table:
    """The table for the page, the thesis's own numbers set apart."""
    rows = []
    for cells, line in zip(rows_of(compared), compared.lines, strict=True):
        kinds = ["first"] if cells[0] else []
        kinds += ["given"] if line.source == OF_THESIS else []
        rows.append(Row(cells, " ".join(kinds)))
    return Table(columns_of(compared), rows)


def in_full(compared: ComparedTable) -> tuple[list[str], list[list[str | float | int]]]:
    """Columns and rows with every number in full, for CSV."""
    columns = ["measure", "unit", "source"]
    for name in compared.columns:
        columns += [name, f"{name} (standard deviation over seeds)"]
    rows: list[list[str | float | int]] = []
    for line in compared.lines:
        row: list[str | float | int] = [line.label, line.unit, line.source]
        for figure in line.figures:
            row += [_known(figure.mean), _known(figure.spread)]
        rows.append(row)
    return columns, rows


def facts(tables: Sequence[ComparedTable]) -> list[dict[str, object]]:
    """The tables for JSON."""
    return [
        {
            "table": compared.key,
            "title": compared.title,
            "columns": list(compared.columns),
            "rows": [
                {
                    "measure": line.measure,
                    "label": line.label,
                    "unit": line.unit,
                    "source": line.source,
                    "mean": [figure.mean for figure in line.figures],
                    "standard_deviation": [figure.spread for figure in line.figures],
                }
                for line in compared.lines
            ],
        }
        for compared in tables
    ]


def _named(line: Line) -> str:
    return f"{line.label} [{line.unit}]" if line.unit else line.label


def _known(value: float) -> str | float:
    return value if math.isfinite(value) else ""
