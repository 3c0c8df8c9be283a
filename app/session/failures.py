"""The failures of the active run: found when a fact changes, listed, chosen and looped."""

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from weakref import WeakKeyDictionary

from stereotrack_core.evaluation.failure_segments.find import FailureSearch, explained, stretches_of
from stereotrack_core.evaluation.failure_segments.reasons import reason_of
from stereotrack_core.evaluation.failure_segments.segment import (
    CAUSE_WORDS,
    FOUND_WORDS,
    FailureRules,
    FailureSegment,
    limbs_words,
)
from stereotrack_core.recording.description import Recording

from .base import Base
from .changes import Part
from .inspection import Question, question_of
from .jobs import Job, NewestJob, Task
from .judgement import JudgementPresenter, Truth, reference_at
from .runs import RunEntry
from .tracking import TrackPresenter


@dataclass(frozen=True, eq=False)
class Found:
    """The failures that were found."""

    state: Hashable  # frames, reference and threshold that they belong to
    search: FailureSearch | None  # question to the core; None if the run does not state its origin
    failures: tuple[FailureSegment, ...]
    looked: bool = False  # whether causes are judged by pictures as well


def _words(failure: FailureSegment) -> str:
    cause, found = CAUSE_WORDS[failure.verdict.cause], FOUND_WORDS[failure.found]
    return f"{limbs_words(failure.limbs)} {cause} {found}".lower()


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
    failures = explained(known.search, known.failures, task.work)
    return replace(known, failures=failures, looked=True)


def reasoned(known: Found, asked: Sequence[Question | None], task: Task) -> Found:
    """Failures with the reasons that their recorded first steps give."""
    failures = list(known.failures)
    for i, question in enumerate(asked):
        task.work.step(i / len(asked), f"failure {i + 1} of {len(asked)}")
        search = None if question is None else question.work().trace.search
        if search is not None:
            failures[i] = replace(failures[i], reason=reason_of(search))
    return replace(known, failures=tuple(failures))


_DELAY_MS = 200
_FINDING, _EXPLAINING = "detecting failures", "classifying causes of failures"
_REASONING = "finding out why failures begin"
_AROUND = 0.3  # seconds before and after a failure that its loop shows as well


class FailurePresenter:
    """Finds the failures of the active run, and knows which of them are listed and chosen."""

    def __init__(self, base: Base, track: TrackPresenter, judging: JudgementPresenter) -> None:
        self._base, self._document, self._runs = base, base.document, base.runs
        self._track, self._judging = track, judging
        self._known: WeakKeyDictionary[RunEntry, Found] = WeakKeyDictionary()
        self._asked: object = None
        """Run, facts, and whether by pictures: a task that the person stopped is not repeated."""
        self._job = NewestJob(base.tasks)
        self._filter = ""
        self._chosen: FailureSegment | None = None
        self._timer = base.later(self._look, _DELAY_MS)
        facts = Part.JUDGEMENT | Part.ACTIVE_RUN | Part.RUN_ENDED | Part.THRESHOLD
        base.changes.watch(facts, self._timer.start)

    # ---- facts

    @property
    def found(self) -> Found | None:
        active = self._runs.active
        return self._known.get(active) if active is not None else None

    @property
    def listed(self) -> tuple[FailureSegment, ...]:
        every = self.found.failures if self.found is not None else ()
        wanted = self._filter.lower().split()
        return tuple(one for one in every if all(word in _words(one) for word in wanted))

    @property
    def chosen(self) -> FailureSegment | None:
        """The listed failure that was chosen, also where it was found again by other facts."""
        old, listed = self._chosen, self.listed
        if old is None or old in listed:
            return old
        same = (one for one in listed if one.found == old.found and one.overlaps(old))
        return next(same, None)

    @property
    def explaining(self) -> bool:
        """Whether images are being analysed for causes."""
        task = self._job.task
        return task is not None and not task.over and task.title == _EXPLAINING

    @property
    def looping(self) -> bool:
        return self._document.loop is not None

    def settled(self) -> bool:
        return not self._job.busy and not self._timer.isActive()

    def none_listed(self) -> str:
        if self._runs.active is None:
            return "There is no run yet. Run the tracker or open a run."
        if self.found is None and not self.settled():
            return "Failures are still being detected. Wait for the list."
        return "" if self.listed else "No failure is listed."

    # ---- what a person does

    def filter(self, words: str) -> None:
        """List only failures whose limbs, cause and way of detection have these words."""
        self._filter = words
        self._tell()

    def choose(self, failure: FailureSegment | None) -> None:
        if failure is not self.chosen:
            self._chosen = failure
            self._tell()

    def jump(self, failure: FailureSegment) -> None:
        """Choose a failure and go to its worst frame."""
        self.choose(failure)
        if not self.looping:
            self._document.pause()
        self._document.go_to(failure.peak_frame)

    def go(self, direction: int) -> None:
        """Go to the worst frame of the next (1) or previous (-1) listed failure."""
        listed = self.listed
        there = beside(listed, self.chosen, self._document.frame, direction)
        if there is None:
            return
        found, wrapped = there
        self.jump(found)
        ends = "the last one" if direction > 0 else "the first one"
        around = f", coming round from {ends}" if wrapped else ""
        words = f"Failure {listed.index(found) + 1} of {len(listed)}{around}."
        self._base.changes.tell(Part.SAID, words)

    def toggle_loop(self) -> None:
        """Play the chosen failure, or the one at the playhead, again and again; or stop that."""
        document = self._document
        if self.looping:
            document.loop = None
            document.pause()
            return
        self.choose(self.at_hand())
        if self.chosen is None:
            words = "Select a failure, or go to a frame inside one."
            self._base.changes.tell(Part.SAID, words)
            return
        document.loop = self.stretch_of(self.chosen)
        document.play()

    def at_hand(self) -> FailureSegment | None:
        """The chosen failure, or the one at the playhead."""
        here = (one for one in self.listed if self._document.frame in one.frames)
        return self.chosen or next(here, None)

    def stretch_of(self, failure: FailureSegment | None) -> range | None:
        """Frames of a failure, and a few before and after it."""
        recording = self._document.recording
        if failure is None or recording is None:
            return None
        around = round(_AROUND * recording.fps)
        last = min(failure.last + around, self._document.frame_count - 1)
        return range(max(0, failure.first - around), last + 1)

    def begin_of(self, failure: FailureSegment) -> None:
        """Choose a failure and go to the frame in which it begins."""
        self.choose(failure)
        self._document.pause()
        self._document.go_to(failure.first)

    # ---- finding

    def _look(self) -> None:
        """Find the failures again if a fact has changed."""
        entry, known = self._runs.active, self.found
        recording, truth = self._document.recording, self._judging.truth
        grows = entry is self._track.entry and self._track.running
        if recording is not None and entry is not None and entry.frames and not grows:
            threshold = self._threshold()
            state = len(entry.frames), truth, threshold, recording
            if known is None or known.state != state:
                find = partial(found_in, entry.now(), recording, truth, threshold, state)
                self._begin(entry, (state, False), _FINDING, lambda _: find())

    def explain(self) -> None:
        """Judge causes by pictures as well, for who sees the list: it takes seconds."""
        entry, known = self._runs.active, self.found
        if entry is None or known is None or known.looked or not self.settled():
            return
        if known.search is not None and known.failures:
            self._begin(entry, (known.state, True), _EXPLAINING, partial(looked_at, known))

    def why_no_reasons(self) -> str:
        """Why it cannot be found out why the failures begin, as a sentence."""
        if none := self.none_listed():
            return none
        found, entry = self.found, self._runs.active
        if entry is None or entry.made_with() is None:
            return "The run does not state its settings. Run the tracker first."
        if found is None or found.search is None or found.search.reference is None:
            return "There is no reference. Choose one under Track, Errors against."
        return "" if self.settled() else "Failures are still being detected or classified."

    def find_reasons(self) -> None:
        """Have the step in which each failure begins done again, beside the true arms' cost."""
        entry, known, settings = self._runs.active, self.found, None
        if entry is not None:
            settings = entry.made_with()
        if entry is None or known is None or settings is None or self.why_no_reasons():
            return
        reference = None if known.search is None else known.search.reference
        process, asked = self._base.processes.trials, list[Question | None]()
        for one in known.failures:
            truth = reference_at(reference, one.first)
            there = truth is not None and entry.at(one.first) is not None
            about = (one.first, self._track, process, entry, settings, truth)
            asked.append(question_of(*about) if there else None)
        work = partial(reasoned, known, asked)
        self._begin(entry, (known.state, len(asked), "why"), _REASONING, work)

    def _threshold(self) -> float:
        """Error in degrees from which a failure begins."""
        judgement = self._judging.of(self._runs.active)
        if judgement is not None and judgement.measure == "error":
            return self._base.view_state.threshold
        return FailureRules().episode_error

    def _begin(
        self, entry: RunEntry, what: Hashable, title: str, work: Callable[[Task], Found]
    ) -> None:
        if self._asked != (entry, what):
            self._asked = entry, what
            done = partial(self._known.__setitem__, entry)
            self._job.run(Job(title, work, done, ended=self._tell))
            self._tell()

    def _tell(self) -> None:
        if self.looping and (stretch := self.stretch_of(self.chosen)):
            self._document.loop = stretch
        self._base.changes.tell(Part.FAILURES)
