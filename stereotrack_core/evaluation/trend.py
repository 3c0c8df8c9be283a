"""How errors go with something else: a running median that a few wild values do not bend."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray

LEAST = 15
"""Values that stand together for one point of the curve, at least."""

LEAST_OF_A_PLACE = 5
"""Values of which a median is stated where places are taken one by one."""

_SHARE = 0.15
"""Of all values, that stand together for one point of the curve where that is more."""

_POINTS = 40
_FEW = 6
"""So many different places or fewer are taken one by one."""


@dataclass(frozen=True, eq=False)
class Trend:
    """A curve through a cloud of points; K places.

    Attributes
    ----------
    x : (K,) float64
        Ascending.
    median, low, high : (K,) float64
        Median and quartiles of what stands around each place.
    count : (K,) int64
        How many values that were.
    """

    x: FloatArray
    median: FloatArray
    low: FloatArray
    high: FloatArray
    count: IntArray


def trend(x: FloatArray, y: FloatArray) -> Trend:
    """Running median of y (N,) over x (N,); pairs that are not known are left out.

    Around each place the same number of values counts: 15 % of all, at least :data:`LEAST`.
    Where x has only a few different values, as the number of views, each has a median of its own.
    """
    known = np.isfinite(x) & np.isfinite(y)
    order = np.argsort(x[known], kind="stable")
    x, y = x[known][order], y[known][order]
    places = np.unique(x)
    if len(places) <= _FEW:
        groups = {float(place): y[x == place] for place in places}
        enough = {place: own for place, own in groups.items() if len(own) >= LEAST_OF_A_PLACE}
        return _stated(list(enough), list(enough.values()))
    size = max(LEAST, round(_SHARE * len(x)))
    if len(x) < size:
        return _stated([], [])
    begins = np.unique(np.linspace(0, len(x) - size, _POINTS).round().astype(np.int64))
    windows = [slice(int(begin), int(begin) + size) for begin in begins]
    return _stated([float(np.median(x[own])) for own in windows], [y[own] for own in windows])


def _stated(places: list[float], groups: list[FloatArray]) -> Trend:
    quartiles = np.array([np.percentile(own, [25, 50, 75]) for own in groups]).reshape(-1, 3)
    counts = np.array([len(own) for own in groups], dtype=np.int64)
    low, median, high = quartiles.T
    return Trend(np.array(places), median, low, high, counts)
