"""Which point of a sweep's table is best."""

from __future__ import annotations

import numpy as np

from stereotrack_core.experiments.sweep.measures import measure_named
from stereotrack_core.experiments.sweep.table import SweepTable

AVERAGED = ("recording", "seed")
"""Columns that a point is averaged over, unless somebody asks for them."""


def best_rows(table: SweepTable, measure: str) -> tuple[int, ...]:
    """Rows of the point with the best mean of a measure; empty where nothing is known."""
    columns = [table.columns.index(name) for name in table.parameters if name not in AVERAGED]
    known, values = measure_named(measure), table.numbers(measure)
    sign = -1.0 if known is not None and known.more_is_better else 1.0
    points: dict[tuple[str, ...], list[int]] = {}
    for row in np.flatnonzero(np.isfinite(values)).tolist():
        points.setdefault(tuple(table.rows[row][i] for i in columns), []).append(row)
    best = min(points.values(), key=lambda rows: sign * float(values[rows].mean()), default=[])
    return tuple(best)
