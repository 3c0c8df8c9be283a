"""What a table says about the errors of each limb in a stretch of frames."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.evaluation.summary import statistics

ALL_ARMS = "all_arm_segments"
"""Name of the row that pools both upper arms and both forearms."""


@dataclass(frozen=True)
class LimbStatistics:
    """Numbers of one limb; NaN where nothing is known. In the unit of the values.

    Attributes
    ----------
    limb : str
        A limb, or :data:`ALL_ARMS`.
    count : int
        Values that are known.
    mean, median, p95, maximum : float
    above : float
        Share (0 to 1) of them above the threshold.
    lost : float
        Share (0 to 1) of them in which the limb is lost; NaN where that is not known.
    """

    limb: str
    count: int
    mean: float
    median: float
    p95: float
    maximum: float
    above: float
    lost: float


def limb_statistics(
    values: Mapping[str, FloatArray], lost: Mapping[str, FloatArray], threshold: float
) -> tuple[LimbStatistics, ...]:
    """Statistics of every limb, and of all arm segments together as the last row.

    Parameters
    ----------
    values : mapping from limb to (F,) float64
        Errors, or standard deviations; NaN where not known.
    lost : mapping from limb to (F,) float64
        1 where the limb is lost, 0 where not, NaN where that is not known; limbs may be missing.
    threshold : float
    """
    rows = [_row(limb, own, lost.get(limb), threshold) for limb, own in values.items()]
    arms = [limb for limb in values if limb.endswith(("upper_arm", "forearm"))]
    if arms:
        gone = [lost[limb] for limb in arms if limb in lost]
        pooled = np.concatenate(gone) if len(gone) == len(arms) else None
        rows.append(_row(ALL_ARMS, np.concatenate([values[a] for a in arms]), pooled, threshold))
    return tuple(rows)


def _row(
    limb: str, values: FloatArray, lost: FloatArray | None, threshold: float
) -> LimbStatistics:
    known = values[np.isfinite(values)]
    figures = statistics(known)
    nan = float("nan")
    gone = np.empty(0) if lost is None else lost[np.isfinite(lost)]
    return LimbStatistics(
        limb,
        figures.count,
        figures.mean,
        figures.median,
        figures.p95,
        maximum=float(known.max()) if len(known) else nan,
        above=float(np.mean(known > threshold)) if len(known) else nan,
        lost=float(np.mean(gone)) if len(gone) else nan,
    )


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
