"""Two or more runs over the frames they share: against the reference, or against each other.

Whether two series of frames differ is asked although neighbouring frames are alike: an arm that is
lost stays lost for a while. The standard error of a mean difference is therefore that of a block
bootstrap (Kuensch 1989, doi:10.1214/aos/1176347265; with blocks that go on at the beginning where
the series ends, Politis and Romano 1992), which for a mean needs no drawing: it is known what
infinitely many draws give. The frames are cut into eight blocks, or into fewer and longer ones
where the difference changes so slowly that a block would be no longer than two of its correlation
times. So few blocks give a standard error that is itself uncertain, so the interval is Student's
with one degree of freedom less than there are blocks, as for a mean of so many independent values.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import reduce
from typing import TypeAlias

import numpy as np
import scipy

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation import summary
from stereotrack_core.recording.description import Segment
from stereotrack_core.recording.landmarks import LandmarkTrajectory

Frames: TypeAlias = range | IntArray | None
"""Frames that count; all where none are named."""

MOST_BLOCKS = 8.0  # into no more blocks than these the frames are cut
LEAST_BLOCKS = 5.0
TIMES = 2.0  # a block is as long as so many independent frames, if possible
LEAST_INDEPENDENT = 6.0  # fewer independent frames than these show nothing that could be relied on
LEVEL = 0.95
_LEAST_FRAMES = 16
_SEARCHED = 5.0
"""Correlations are summed up to so many correlation times (Sokal 1997,
doi:10.1007/978-1-4899-0319-8_6)."""


@dataclass(frozen=True)
class Measured:
    """A measure: its key, its name for people, and its unit ``mm``, ``deg`` or ``%``."""

    name: str = ""
    label: str = ""
    unit: str = ""


@dataclass(frozen=True, eq=False)
class Series:
    """A measure of which less is better, frame by frame; its mean is `total` by `weight`."""

    total: FloatArray  # (F,). Sum of what was measured in the frame: of two arms, for example.
    weight: FloatArray  # (F,). How many values that are; 0 where nothing was measured.
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
    difference: float = math.nan  # `second_mean` - `first_mean`
    low: float = math.nan
    high: float = math.nan  # `low` and `high`: 95 % interval; NaN with too few independent frames
    equal: bool = False  # whether both are the same in every frame
    frames: int = 0  # in which both are known
    block_frames: int = 0  # length of a block

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
    difference, equal = means[1] - means[0], not each.any()
    return Paired(first.measure, *means, difference, low, high, equal, frames, block)


def correlation_time(values: FloatArray) -> float:
    """Frames that are worth one independent frame, at least 1.

    One and twice the sum of the autocorrelations, but not less than for a series whose share of the
    frame before is corrected for its bias (Kendall 1954, doi:10.1093/biomet/41.3-4.403).
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
    # sums of the blocks that begin at each frame; after the last frame comes the first
    summed = np.concatenate([[0.0], np.cumsum(np.concatenate([away, away[: block - 1]]))])
    variance = float(np.mean((summed[block:] - summed[:-block]) ** 2)) / (block * n)
    blocks = n / block
    student = float(scipy.special.stdtrit(blocks - 1.0, 0.5 * (1.0 + LEVEL)))
    half = student * math.sqrt(variance * blocks / (blocks - 1.0))
    return mean - half, mean + half


@dataclass(frozen=True, eq=False)
class Candidate:
    """A run, or landmarks alone, to be compared."""

    name: str
    trajectory: LandmarkTrajectory
    unexplained_fraction: FloatArray | None = None  # (F,), where the run says it


@dataclass(frozen=True)
class Pair:
    """A run beside the first one."""

    first: str
    second: str  # `first` and `second`: names of the runs
    measures: tuple[Paired, ...]  # errors if there is a reference, then the runs' own signs
    apart: summary.Summary  # how far the runs are from each other, over what both know

    def measure(self, name: str) -> Paired:
        """The measure of that name; KeyError where there is none."""
        return {one.measure.name: one for one in self.measures}[name]


@dataclass(frozen=True, eq=False)
class Comparison:
    """Runs beside the first one."""

    frames: IntArray  # (F,). That all of them have and, where there is a reference, it knows.
    against_reference: bool
    pairs: tuple[Pair, ...]  # the first run with each of the others

    @property
    def blocks(self) -> tuple[int, int]:
        """Length of the shortest and of the longest blocks that an interval was made from."""
        lengths = [one.block_frames for pair in self.pairs for one in pair.measures if one.enough]
        return (min(lengths), max(lengths)) if lengths else (0, 0)


def compare(
    candidates: Sequence[Candidate], reference: LandmarkTrajectory | None, frames: Frames = None
) -> Comparison:
    """Compare the first run with each of the others over common frames. Raises InputError."""
    if len(candidates) < 2:
        raise InputError("there is only one run to compare", remedy="Give at least two runs.")
    shared = shared_frames(candidates, reference, frames)
    if not len(shared):
        known = " and the reference" if reference is not None else ""
        remedy = "Compare runs of the same recording over frames that all of them have."
        raise InputError(f"the runs{known} have no frame in common", remedy=remedy)
    chosen = [_at(candidate, shared) for candidate in candidates]
    truth = _truth_at(reference, shared)
    measured = [_measures(candidate, truth) for candidate in chosen]
    first, *others = zip(chosen, measured, strict=True)
    pairs = []
    for other, measures in others:
        theirs = {one.measure.name: one for one in measures}
        own = [one for one in first[1] if one.measure.name in theirs]
        differences = tuple(paired(one, theirs[one.measure.name]) for one in own)
        apart = _apart(first[0].trajectory, other.trajectory)
        pairs.append(Pair(first[0].name, other.name, differences, apart))
    return Comparison(shared, truth is not None, tuple(pairs))


def compare_segments(
    candidates: Sequence[Candidate],
    reference: LandmarkTrajectory | None,
    segments: Sequence[Segment],
    frames: range | None = None,
) -> tuple[tuple[str, Comparison | None], ...]:
    """The same for each name, over all of its stretches; None where no frame of it is left."""
    shared, found = shared_frames(candidates, reference, frames), []
    for name in dict.fromkeys(segment.name for segment in segments):
        part = shared[summary.within([one for one in segments if one.name == name], shared)]
        found.append((name, compare(candidates, reference, part) if len(part) else None))
    return tuple(found)


def measured(
    candidate: Candidate, reference: LandmarkTrajectory | None, frames: Frames = None
) -> tuple[Series, ...]:
    """The measures of one run alone, frame by frame; empty where no frame is left."""
    shared = shared_frames((candidate,), reference, frames)
    if not len(shared):
        return ()
    return _measures(_at(candidate, shared), _truth_at(reference, shared))


def shared_frames(
    candidates: Sequence[Candidate], reference: LandmarkTrajectory | None, frames: Frames
) -> IntArray:
    """Frames that all of them have and, where there is a reference, it knows."""
    several = [candidate.trajectory.frame for candidate in candidates]
    if reference is not None:
        several.append(reference.frame[summary.knows_something(reference)])
    shared: IntArray = reduce(np.intersect1d, several)
    if isinstance(frames, range):
        return shared[(shared >= frames.start) & (shared < frames.stop)]
    return shared if frames is None else shared[np.isin(shared, frames)]


def _at(candidate: Candidate, frames: IntArray) -> Candidate:
    rows = np.searchsorted(candidate.trajectory.frame, frames)
    unexplained_fraction = candidate.unexplained_fraction
    return replace(
        candidate,
        trajectory=LandmarkTrajectory(frames, candidate.trajectory.points[rows]),
        unexplained_fraction=None if unexplained_fraction is None else unexplained_fraction[rows],
    )


def _truth_at(reference: LandmarkTrajectory | None, frames: IntArray) -> LandmarkTrajectory | None:
    if reference is None:
        return None
    return LandmarkTrajectory(frames, summary.points_at(reference, frames))


def _measures(candidate: Candidate, truth: LandmarkTrajectory | None) -> tuple[Series, ...]:
    """Errors as ``evaluate`` prints them, where there is truth; then what the run itself says."""
    rows: list[tuple[str, str, str, FloatArray]] = []
    if truth is not None:
        errors = summary.errors_against(candidate.trajectory, truth)
        values, arms = summary.values_of(errors), errors.arm_segments
        lost = np.where(np.isnan(arms), np.nan, 100.0 * (arms > summary.LOST_ANGLE))
        rows = [("arms", "arms", "deg", np.rad2deg(arms))]
        rows += [(*measure, values[measure[0]]) for measure in summary.ERROR_MEASURES]
        rows.append(("lost", "arm segments lost", "%", lost))
    if candidate.unexplained_fraction is not None:
        unexplained = 100.0 * candidate.unexplained_fraction
        rows.append(("unexplained", "unexplained fraction", "%", unexplained))
    known = np.isfinite(candidate.trajectory.points).any(axis=(1, 2))
    rows.append(("not_tracked", "frames not tracked", "%", np.where(known, 0.0, 100.0)))
    return tuple(Series.of(values, *measure) for *measure, values in rows)


def _apart(first: LandmarkTrajectory, second: LandmarkTrajectory) -> summary.Summary:
    """How far a trajectory is from another, over the landmarks that both know."""
    both: BoolArray = np.asarray(np.isfinite(first.points + second.points).all(axis=-1))
    points: FloatArray = np.where(both[..., None], first.points, np.nan)
    known = LandmarkTrajectory(first.frame, points)
    return summary.summarise(summary.errors_against(second, known), "apart")


_UNITS = {"%": "percentage points"}
_DIGITS = 1


def verdict(found: Paired, first: str, second: str) -> str:
    """``B is better by 1.2 deg (0.8 to 1.6)``, or why nothing can be said."""
    if not found.frames:
        return "not known for both"
    if found.equal:
        return "equal in every frame"
    unit = _UNITS.get(found.measure.unit, found.measure.unit)
    winner = second if found.difference < 0 else first
    by = magnitude(abs(found.difference))
    if not found.enough:
        return f"{winner} is lower by {by} {unit}; too few independent frames for an interval"
    if not found.differs:
        return "no significant difference"
    near, far = sorted((abs(found.low), abs(found.high)))
    return f"{winner} is better by {by} {unit} ({magnitude(near)} to {magnitude(far)})"


def magnitude(value: float) -> str:
    """A number with one digit after the point, or with more where it would read 0.0."""
    digits = _DIGITS
    while digits < 6 and 0.0 < abs(value) < 0.95 * 10.0**-digits:
        digits += 1
    return f"{value:.{digits}f}"


def how_it_is_made(comparison: Comparison) -> str:
    """Sentences on how intervals and verdicts are made."""
    count, (shortest, longest) = len(comparison.frames), comparison.blocks
    frames = counted(count, "frame")
    if not longest:
        return f"Differences are paired over {frames}, too few for intervals."
    blocks = f"{shortest}" if shortest == longest else f"{shortest} to {longest}"
    return (
        f"Differences are paired over {frames} that all runs share. The 95 % intervals use blocks "
        f"of {blocks} consecutive frames, because neighbouring frames are correlated. Of twenty "
        "comparisons of equal runs, one shows a significant difference by chance."
    )
