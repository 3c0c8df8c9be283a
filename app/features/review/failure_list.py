"""The failures of the active run: found when a fact changes, filtered, and as they are listed."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace

from stereotrack_core.evaluation.failure_segments.find import FailureSearch, explained, stretches_of
from stereotrack_core.evaluation.failure_segments.segment import (
    CAUSE_WORDS,
    FailureSegment,
    limbs_words,
)
from stereotrack_core.evaluation.failure_segments.stretches import FailureRules
from stereotrack_core.recording.description import Recording

from ...services.tasks.task import Task
from ...session.judgement import Truth
from ...session.runs import RunEntry
from ...widgets.timeline.lanes import Lane, Span

LANE_NAMES = {"truth": "failures", "signs": "failures (without reference)"}
LANE_COLOURS = {"truth": "#CC79A7", "signs": "#b8860b"}


@dataclass(frozen=True)
class Filter:
    """What is listed; an empty word lists all."""

    limb: str = ""
    """Name in ``LIMBS``."""
    cause: str = ""
    """Key of ``CAUSE_WORDS``."""
    found: str = ""
    """Key of ``FOUND_WORDS``."""

    def takes(self, failure: FailureSegment) -> bool:
        return (
            (not self.limb or self.limb in failure.limbs)
            and (not self.cause or self.cause == failure.verdict.cause)
            and (not self.found or self.found == failure.found)
        )


def lanes_of_failures(failures: Sequence[FailureSegment]) -> tuple[Lane, ...]:
    """A lane of bars for those found with truth and for those found without."""
    lanes = []
    for found, name in LANE_NAMES.items():
        spans: list[Span] = []
        for e in sorted((e for e in failures if e.found == found), key=lambda e: e.first):
            label = f"{limbs_words(e.limbs)}: {CAUSE_WORDS[e.verdict.cause]}"
            if spans and e.first <= spans[-1].last:
                # labels of bars that overlap would stand on each other
                old = spans.pop()
                spans.append(Span(old.first, max(old.last, e.last), f"{old.label}; {label}"))
            else:
                spans.append(Span(e.first, e.last, label))
        if spans:
            lanes.append(Lane(name, LANE_COLOURS[found], "bars", spans))
    return tuple(lanes)


@dataclass(frozen=True, eq=False)
class Found:
    """The failures that were found."""

    state: Hashable
    """Frames, reference and threshold that they belong to."""
    search: FailureSearch | None
    """What the core was asked; None where the run does not say where it comes from."""
    failures: tuple[FailureSegment, ...]
    looked: bool = False
    """Whether causes are judged by pictures as well."""


def beside(
    listed: Sequence[FailureSegment], chosen: FailureSegment | None, frame: int, direction: int
) -> tuple[FailureSegment, bool] | None:
    """The listed failure after (1) or before (-1) the chosen one or a frame, and whether it wraps.

    None if none is listed.
    """
    if not listed:
        return None
    if chosen is not None and chosen in listed and frame in chosen.frames:
        place = listed.index(chosen) + direction
        return listed[place % len(listed)], not 0 <= place < len(listed)
    if direction > 0:
        there = (e for e in listed if e.last >= frame and e.peak_frame > frame)
    else:
        there = (e for e in reversed(listed) if e.peak_frame < frame)
    found = next(there, None)
    return (found, False) if found is not None else (listed[0 if direction > 0 else -1], True)


def found_in(
    now: RunEntry, recording: Recording, truth: Truth | None, threshold: float, state: Hashable
) -> Found:
    """Failures of a run, with causes that need no images."""
    run = now.run()
    if run is None:
        return Found(state, None, ())
    rules = FailureRules().replaced(episode_error=min(max(threshold, 1.0), 180.0))
    reference = truth.trajectory if truth is not None else None
    search = FailureSearch(run, recording.fps, reference, recording, rules)
    failures = explained(replace(search, pictures=False), stretches_of(search))
    return Found(state, search, failures)


def looked_at(known: Found, task: Task) -> Found:
    """Failures with causes that are classified from images as well; takes seconds."""
    assert known.search is not None  # noqa: S101 - there are no failures without
    failures = explained(known.search, known.failures, task.report, task.token.cancelled)
    return replace(known, failures=failures, looked=True)
