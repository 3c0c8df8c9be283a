"""The measures that runs are compared in, frame by frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.evaluation.comparison.paired import Series
from stereotrack_core.evaluation.errors import LimbErrors
from stereotrack_core.evaluation.summary import ERROR_MEASURES, LOST_ANGLE, values_of


@dataclass(frozen=True, eq=False)
class MeasuredSeries:
    """A measure of one run; less is better.

    Attributes
    ----------
    name : str
        As :class:`evaluation.summary.Measure` has it; ``lost``, ``unexplained`` or
        ``not_tracked`` besides.
    label : str
        Name for people.
    unit : str
        ``mm``, ``deg`` or ``%``.
    series : Series
        In `unit`.
    """

    name: str
    label: str
    unit: str
    series: Series


def measures_of_errors(errors: LimbErrors) -> tuple[MeasuredSeries, ...]:
    """Everything that ``evaluate`` prints: its means are the means of these series."""
    values = values_of(errors)
    segments = errors.arm_segments
    lost: FloatArray = np.where(np.isnan(segments), np.nan, 100.0 * (segments > LOST_ANGLE))
    return (
        *(MeasuredSeries(*measure, Series.of(values[measure[0]])) for measure in ERROR_MEASURES),
        MeasuredSeries("lost", "arm segments lost", "%", Series.of(lost)),
    )


def measures_of_signs(
    unexplained_fraction: FloatArray | None, tracked: FloatArray
) -> tuple[MeasuredSeries, ...]:
    """What a run says about itself.

    Parameters
    ----------
    unexplained_fraction : (F,) float64 or None
        Share of the cloud that the model does not explain; NaN where not known.
    tracked : (F,) float64
        1 where the run has a pose, else 0.
    """
    missing = MeasuredSeries(
        "not_tracked", "frames not tracked", "%", Series.of(100.0 * (1.0 - tracked))
    )
    if unexplained_fraction is None:
        return (missing,)
    unexplained = Series.of(100.0 * unexplained_fraction)
    return (MeasuredSeries("unexplained", "unexplained fraction", "%", unexplained), missing)
