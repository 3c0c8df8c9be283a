"""Errors of the runs, pooled over frames and told with their spread over seeds."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.evaluation.errors import LimbErrors, errors_against
from stereotrack_core.evaluation.summary import Summary, summarise
from stereotrack_core.experiments.reproduction.plan import Entry
from stereotrack_core.recording.description import Recording, Segment
from stereotrack_core.tracking.frame import Run

FAST = "-fast"
"""End of the names of segments that are faster than the thesis's people were."""

LOST = "lost"


@dataclass(frozen=True)
class Figure:
    """Mean over frames and seeds, and its standard deviation over seeds (NaN for one)."""

    mean: float = float("nan")
    spread: float = float("nan")


@dataclass(frozen=True, eq=False)
class Outcome:
    """What one run has come to.

    Attributes
    ----------
    recording : str
    entry : Entry
    errors : LimbErrors
    fast_from : int
        First frame of the fast motions at the end of the recording.
    segments : tuple of Segment
    version : str
        Of the program that tracked.
    """

    recording: str
    entry: Entry
    errors: LimbErrors
    fast_from: int
    segments: tuple[Segment, ...]
    version: str

    def slow(self) -> LimbErrors:
        """Errors of the frames at the thesis's pace."""
        return self.errors.between(0, self.fast_from)

    def fast(self) -> LimbErrors:
        """Errors of the frames from the first fast motion on."""
        return self.errors.between(self.fast_from, int(self.errors.frame[-1]) + 1)

    def segment(self, name: str) -> LimbErrors | None:
        """Errors of all segments of that name; None where there is none."""
        found = [self.errors.between(s.first, s.end) for s in self.segments if s.name == name]
        return together(found) if found else None


Part = Callable[[Outcome], LimbErrors | None]
"""Takes the frames that count out of an outcome; None where it has none."""


def outcome_of(recording: Recording, entry: Entry, run: Run) -> Outcome:
    """Measure a run against its recording's reference, which must be there."""
    reference = recording.reference
    if reference is None:
        raise ValueError("the recording has no reference")
    return Outcome(
        recording.name,
        entry,
        errors_against(run.trajectory(), reference),
        fast_from(recording.segments, int(reference.frame[-1]) + 1),
        recording.segments,
        str(run.meta.get("version", "")),
    )


def fast_from(segments: Sequence[Segment], end: int) -> int:
    """First frame of the first fast segment; `end` where there is none."""
    return min((s.first for s in segments if s.name.endswith(FAST)), default=end)


def together(parts: Sequence[LimbErrors]) -> LimbErrors:
    """Several stretches as one."""
    names = [field.name for field in dataclasses.fields(LimbErrors)]
    return LimbErrors(**{n: np.concatenate([getattr(p, n) for p in parts]) for n in names})


def figure(
    outcomes: Sequence[Outcome], way: str, measure: str, part: Part, recordings: Sequence[str]
) -> Figure:
    """One number of a table: pooled over all frames of the recordings, then over seeds.

    Nothing is said (NaN) until all recordings that are asked for have a run of every seed that
    one of them has.
    """
    own = [o for o in outcomes if o.entry.way.name == way and o.recording in recordings]
    seeds = sorted({outcome.entry.seed for outcome in own})
    values = []
    for seed in seeds:
        of_seed = [outcome for outcome in own if outcome.entry.seed == seed]
        if {outcome.recording for outcome in of_seed} != set(recordings):
            return Figure()
        stretches = [stretch for o in of_seed if (stretch := part(o)) is not None]
        if stretches:
            values.append(_value(summarise(together(stretches)), measure))
    if not values:
        return Figure()
    spread = float(np.std(values, ddof=1)) if len(values) > 1 else float("nan")
    return Figure(float(np.mean(values)), spread)


def _value(summary: Summary, measure: str) -> float:
    if measure == LOST:
        return 100.0 * summary.lost
    return summary.measure(measure).statistics.mean
