"""Whether two series of frames differ, when neighbouring frames are alike.

The frames of a recording are no independent draws: an arm that is lost stays lost for a while.
The standard error of a mean difference is therefore that of a block bootstrap (Kuensch 1989,
doi:10.1214/aos/1176347265; with blocks that go on at the beginning where the series ends, Politis
and Romano 1992), which for a mean needs no drawing: it is known what infinitely many draws give.
The frames are cut into eight blocks, or into fewer and longer ones where the difference changes
so slowly that a block would be no longer than two of its correlation times. So few blocks
give a standard error that is itself uncertain, so the interval is Student's with one degree of
freedom less than there are blocks, as for a mean of so many independent values.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy

from stereotrack_core.arrays import BoolArray, FloatArray

MOST_BLOCKS = 8.0
"""Into no more blocks than these the frames are cut."""

LEAST_BLOCKS = 5.0

TIMES = 2.0
"""A block is as long as so many frames that are worth an independent one, if that is possible."""

LEAST_INDEPENDENT = 6.0
"""Fewer independent frames than these show nothing that could be relied on."""

LEVEL = 0.95

_LEAST_FRAMES = 16
_SEARCHED = 5.0
"""Correlations are summed up to so many correlation times (Sokal 1997,
doi:10.1007/978-1-4899-0319-8_6)."""


@dataclass(frozen=True)
class Measured:
    """What is measured: its key, its name for people, and its unit ``mm``, ``deg`` or ``%``."""

    name: str = ""
    label: str = ""
    unit: str = ""


@dataclass(frozen=True, eq=False)
class Series:
    """A measure of which less is better, frame by frame; its mean is `total` by `weight`."""

    total: FloatArray
    """(F,). Sum of what was measured in the frame: of two arms, for example."""
    weight: FloatArray
    """(F,). How many values that are; 0 where nothing was measured."""
    measure: Measured = Measured()

    @staticmethod
    def of(values: FloatArray, *measure: str) -> Series:
        """From values (F,) or (F, k), NaN where not known, and name, label and unit."""
        columns = values.reshape(len(values), -1)
        known = ~np.isnan(columns)
        total, weight = np.where(known, columns, 0.0).sum(axis=1), known.sum(axis=1)
        return Series(total, weight.astype(np.float64), Measured(*measure))

    def mean(self, frames: BoolArray) -> float:
        """Mean over some frames; NaN where nothing was measured in any."""
        weight = float(self.weight[frames].sum())
        return float(self.total[frames].sum()) / weight if weight else math.nan


@dataclass(frozen=True)
class Paired:
    """How a second series differs from a first one over the frames in which both are known."""

    measure: Measured
    first_mean: float = math.nan
    second_mean: float = math.nan
    difference: float = math.nan
    """`second_mean` - `first_mean`."""
    low: float = math.nan
    high: float = math.nan
    """`low` and `high`: 95 % interval of the difference; NaN where there are too few independent
    frames."""
    equal: bool = False
    """Whether both are the same in every frame."""
    frames: int = 0
    """In which both are known."""
    block_frames: int = 0
    """Length of a block."""
    independent_frames: float = 0.0
    """So many independent frames would be as good as these."""

    @property
    def enough(self) -> bool:
        """Whether there are frames enough to say something."""
        return not math.isnan(self.low)

    @property
    def differs(self) -> bool:
        """Whether the interval leaves 0 out."""
        return self.enough and not self.low <= 0.0 <= self.high


def paired(first: Series, second: Series) -> Paired:
    """Compare two series frame by frame; both are of the same frames, in their order."""
    known: BoolArray = (first.weight > 0) & (second.weight > 0)
    frames = int(known.sum())
    if not frames:
        return Paired(first.measure)
    means = first.mean(known), second.mean(known)
    each = second.total[known] / second.weight[known] - first.total[known] / first.weight[known]
    weight = (first.weight[known] + second.weight[known]) / 2.0
    independent = frames / correlation_time(each)
    block = math.ceil(frames / float(np.clip(independent / TIMES, LEAST_BLOCKS, MOST_BLOCKS)))
    low = high = math.nan
    if independent >= LEAST_INDEPENDENT and frames >= _LEAST_FRAMES:
        low, high = interval(each, weight, block)
    return Paired(
        first.measure,
        first_mean=means[0],
        second_mean=means[1],
        difference=means[1] - means[0],
        low=low,
        high=high,
        equal=not each.any(),
        frames=frames,
        block_frames=block,
        independent_frames=independent,
    )


def correlation_time(values: FloatArray) -> float:
    """Frames that are worth one independent frame, at least 1.

    One and twice the sum of the autocorrelations, up to five times itself; but not less than for
    a series in which each frame is a share of the one before, whose share is known to come out
    too small from few frames (Kendall 1954, doi:10.1093/biomet/41.3-4.403).
    """
    n = len(values)
    centred = values - values.mean()
    variance = float(centred @ centred)
    if n < 3 or variance <= 1e-30 * n:
        return 1.0
    spectrum = np.abs(np.fft.rfft(centred, 2 * n)) ** 2
    correlation = np.fft.irfft(spectrum)[:n] / variance
    times = 2.0 * np.cumsum(correlation) - 1.0
    settled = np.flatnonzero(np.arange(n) >= _SEARCHED * times)
    summed = float(times[settled[0]] if len(settled) else times[-1])
    share = float(correlation[1])
    share = min(share + (1.0 + 4.0 * share) / n, 0.999)
    return max(1.0, summed, (1.0 + share) / (1.0 - share))


def interval(values: FloatArray, weight: FloatArray, block: int) -> tuple[float, float]:
    """95 % interval of the weighted mean of a series, from blocks of so many frames."""
    n = len(values)
    mean = float(np.average(values, weights=weight))
    away = (values - mean) * weight / weight.mean()
    variance = float(np.mean(_block_sums(away, block) ** 2)) / (block * n)
    blocks = n / block
    student = float(scipy.special.stdtrit(blocks - 1.0, 0.5 * (1.0 + LEVEL)))
    half = student * math.sqrt(variance * blocks / (blocks - 1.0))
    return mean - half, mean + half


def _block_sums(values: FloatArray, block: int) -> FloatArray:
    """Sum (n,) of the block that begins at each frame; after the last frame comes the first."""
    summed = np.concatenate([[0.0], np.cumsum(np.concatenate([values, values[: block - 1]]))])
    result: FloatArray = summed[block:] - summed[:-block]
    return result
