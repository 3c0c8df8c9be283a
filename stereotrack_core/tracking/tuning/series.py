"""Values of one parameter to be tried one after the other."""

from __future__ import annotations

import numpy as np

from stereotrack_core.errors import InputError
from stereotrack_core.parameters import ParameterRow, Value

MOST = 24
"""More values than this are a sweep, which has its own command."""

_DIGITS = 3
_FACTOR = 4.0


def spread_values(
    row: ParameterRow, low: float, high: float, count: int, *, by_factors: bool = False
) -> tuple[Value, ...]:
    """Values of a number from `low` to `high`, in even steps or by even factors.

    There are `count`, 2 to :data:`MOST`; whole numbers may give fewer.

    Raises
    ------
    InputError
        Where the parameter does not accept these values.
    """
    where = row.name
    if not 2 <= count <= MOST:
        raise InputError(
            f"{count} values cannot be tried", where=where, remedy=f"Choose 2 to {MOST} values."
        )
    if not low < high:
        raise InputError(
            f"{low:g} to {high:g} is not a range",
            where=where,
            remedy="The end must be larger than the start.",
        )
    for end in (low, high):
        row.checked(_plain(row, end))
    if by_factors and low <= 0:
        raise InputError(
            "a logarithmic scale needs numbers above 0",
            where=where,
            remedy="Start above 0, or use a linear scale.",
        )
    spaced = np.geomspace(low, high, count) if by_factors else np.linspace(low, high, count)
    spaced[0], spaced[-1] = low, high
    found = [row.checked(_plain(row, float(value))) for value in spaced]
    return tuple(dict.fromkeys(found))


def all_values(row: ParameterRow) -> tuple[Value, ...]:
    """Every value of a word or of a switch; none of a number."""
    if row.type is bool:
        return False, True
    return tuple(row.choices)


def usual_range(row: ParameterRow, value: Value) -> tuple[float, float]:
    """A range around a number in which trying makes sense, inside of what is accepted."""
    here = float(value)
    low, high = (here / _FACTOR, here * _FACTOR) if here > 0 else (here - 1.0, here + 1.0)
    if row.type is int:
        low, high = np.floor(low), np.ceil(high)
    low = low if row.minimum is None else max(low, row.minimum)
    high = high if row.maximum is None else min(high, row.maximum)
    return float(low), float(high)


def _plain(row: ParameterRow, value: float) -> Value:
    """A value as somebody would type it."""
    return round(value) if row.type is int else float(f"{value:.{_DIGITS}g}")
