"""What a table says about the errors of each limb in a stretch of frames."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray
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
