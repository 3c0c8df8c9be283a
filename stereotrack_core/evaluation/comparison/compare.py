"""Two or more runs over the frames they share: against the reference, or against each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import reduce

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.comparison.paired import Paired, Series, paired
from stereotrack_core.evaluation.errors import (
    errors_against,
    knows_something,
    points_at,
)
from stereotrack_core.evaluation.summary import (
    ERROR_MEASURES,
    LOST_ANGLE,
    Summary,
    summarise,
    values_of,
)
from stereotrack_core.recording.description import Segment
from stereotrack_core.recording.landmarks import LandmarkTrajectory


@dataclass(frozen=True, eq=False)
class Candidate:
    """What is compared: a run, or landmarks alone."""

    name: str
    trajectory: LandmarkTrajectory
    unexplained_fraction: FloatArray | None = None
    """(F,). Share of the cloud that the model does not explain, where the run says it."""


@dataclass(frozen=True)
class Pair:
    """A run beside the first one."""

    first: str
    second: str
    """`first` and `second`: names of the runs."""
    measures: tuple[Paired, ...]
    """Errors, where there is a reference; then what the runs say about themselves."""
    apart: Summary
    """How far the runs are from each other, over what both know."""

    def measure(self, name: str) -> Paired:
        """The measure of that name; KeyError where there is none."""
        return {one.measure.name: one for one in self.measures}[name]


@dataclass(frozen=True, eq=False)
class Comparison:
    """Runs beside the first one."""

    names: tuple[str, ...]
    frames: IntArray
    """(F,). That all of them have and, where there is a reference, it knows."""
    against_reference: bool
    pairs: tuple[Pair, ...]
    """The first run with each of the others."""

    @property
    def blocks(self) -> tuple[int, int]:
        """Length of the shortest and of the longest blocks that an interval was made from."""
        lengths = [one.block_frames for pair in self.pairs for one in pair.measures if one.enough]
        return (min(lengths), max(lengths)) if lengths else (0, 0)


def compare(
    candidates: Sequence[Candidate],
    reference: LandmarkTrajectory | None,
    frames: range | None = None,
) -> Comparison:
    """Compare the first run with each of the others over the frames that all of them have.

    Without a reference, which is taken as truth, they are compared with each other alone. Raises
    InputError where there is but one run, or no frame that all of them have.
    """
    if len(candidates) < 2:
        raise InputError("there is only one run to compare", remedy="Give at least two runs.")
    shared = shared_frames(candidates, reference, frames)
    if not len(shared):
        known = " and the reference" if reference is not None else ""
        raise InputError(
            f"the runs{known} have no frame in common",
            remedy="Compare runs of the same recording over frames that all of them have.",
        )
    chosen = [_at(candidate, shared) for candidate in candidates]
    truth = _truth_at(reference, shared)
    measured = [_measures(candidate, truth) for candidate in chosen]
    first = chosen[0]
    pairs = (
        Pair(
            first.name,
            other.name,
            _differences(measured[0], measures),
            _apart(first.trajectory, other.trajectory),
        )
        for other, measures in zip(chosen[1:], measured[1:], strict=True)
    )
    names = tuple(candidate.name for candidate in candidates)
    return Comparison(names, shared, truth is not None, tuple(pairs))


def compare_segments(
    candidates: Sequence[Candidate],
    reference: LandmarkTrajectory | None,
    segments: Sequence[Segment],
    frames: range | None = None,
) -> tuple[tuple[str, Comparison | None], ...]:
    """The same for each named stretch; None where no frame of it is left."""
    found = []
    for segment in segments:
        part = range(segment.first, segment.end)
        if frames is not None:
            part = range(max(part.start, frames.start), min(part.stop, frames.stop))
        some = len(part) and len(shared_frames(candidates, reference, part))
        found.append((segment.name, compare(candidates, reference, part) if some else None))
    return tuple(found)


def measured(
    candidate: Candidate, reference: LandmarkTrajectory | None, frames: range | None = None
) -> tuple[Series, ...]:
    """The measures of one run alone, frame by frame; empty where no frame is left."""
    shared = shared_frames((candidate,), reference, frames)
    if not len(shared):
        return ()
    return _measures(_at(candidate, shared), _truth_at(reference, shared))


def shared_frames(
    candidates: Sequence[Candidate],
    reference: LandmarkTrajectory | None,
    frames: range | None = None,
) -> IntArray:
    """Frames that all of them have and, where there is a reference, it knows."""
    several = [candidate.trajectory.frame for candidate in candidates]
    if reference is not None:
        several.append(reference.frame[knows_something(reference)])
    shared: IntArray = reduce(np.intersect1d, several)
    if frames is not None:
        shared = shared[(shared >= frames.start) & (shared < frames.stop)]
    return shared


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
    return LandmarkTrajectory(frames, points_at(reference, frames))


def _measures(candidate: Candidate, truth: LandmarkTrajectory | None) -> tuple[Series, ...]:
    """Errors as ``evaluate`` prints them, where there is truth; then what the run itself says."""
    rows: list[tuple[str, str, str, FloatArray]] = []
    if truth is not None:
        errors = errors_against(candidate.trajectory, truth)
        values, arms = values_of(errors), errors.arm_segments
        lost = np.where(np.isnan(arms), np.nan, 100.0 * (arms > LOST_ANGLE))
        rows = [(*measure, values[measure[0]]) for measure in ERROR_MEASURES]
        rows.append(("lost", "arm segments lost", "%", lost))
    if candidate.unexplained_fraction is not None:
        unexplained = 100.0 * candidate.unexplained_fraction
        rows.append(("unexplained", "unexplained fraction", "%", unexplained))
    known = np.isfinite(candidate.trajectory.points).any(axis=(1, 2))
    rows.append(("not_tracked", "frames not tracked", "%", np.where(known, 0.0, 100.0)))
    return tuple(Series.of(values, *measure) for *measure, values in rows)


def _differences(first: Sequence[Series], second: Sequence[Series]) -> tuple[Paired, ...]:
    others = {one.measure.name: one for one in second}
    own = [one for one in first if one.measure.name in others]
    return tuple(paired(one, others[one.measure.name]) for one in own)


def _apart(first: LandmarkTrajectory, second: LandmarkTrajectory) -> Summary:
    """How far a trajectory is from another, over the landmarks that both know."""
    both: BoolArray = np.asarray(np.isfinite(first.points + second.points).all(axis=-1))
    points: FloatArray = np.where(both[..., None], first.points, np.nan)
    known = LandmarkTrajectory(first.frame, points)
    return summarise(errors_against(second, known), "apart")


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
    """What intervals and verdicts rest on."""
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
