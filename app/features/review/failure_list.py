"""The failures of the active run: found when a fact changes, filtered, and as they are listed."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from weakref import WeakKeyDictionary

from PySide6.QtCore import QObject, QTimer, Signal, Slot

from stereotrack_core.evaluation.failure_segments.find import FailureSearch, explained, stretches_of
from stereotrack_core.evaluation.failure_segments.segment import (
    CAUSE_WORDS,
    FailureSegment,
    limbs_words,
)
from stereotrack_core.evaluation.failure_segments.stretches import FailureRules
from stereotrack_core.recording.description import Recording

from ...services.tasks.task import Task, TaskList
from ...session.judgement import Truth
from ...session.runs import RunEntry
from ...session.session import Session
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
        """Whether a failure is listed."""
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


_DELAY_MS = 200
_FINDING, _EXPLAINING = "detecting failures", "classifying causes of failures"


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


class FailurePresenter(QObject):
    """The failures of the active run, those that are listed, and the one that is chosen.

    Parameters
    ----------
    wants_pictures : callable
        Whether causes shall be judged by pictures as well, which takes seconds.
    threshold : callable
        Error in degrees from which a failure begins.
    """

    changed = Signal()
    """Other failures are known, listed or chosen, or more is known about them."""

    def __init__(
        self,
        session: Session,
        tasks: TaskList,
        *,
        wants_pictures: Callable[[], bool],
        threshold: Callable[[], float],
    ) -> None:
        super().__init__()
        self._session, self._tasks = session, tasks
        self._wants_pictures, self._threshold = wants_pictures, threshold
        self._known: WeakKeyDictionary[RunEntry, Found] = WeakKeyDictionary()
        self._asked: WeakKeyDictionary[RunEntry, Hashable] = WeakKeyDictionary()
        self._work: tuple[RunEntry, Task] | None = None
        self.chosen: FailureSegment | None = None
        """The failure that is chosen, if it is listed."""
        self.filter = Filter()
        self._told: tuple[Found | None, bool] = None, False
        self._timer = QTimer(self, singleShot=True, interval=_DELAY_MS)
        self._timer.timeout.connect(self._ask)
        for signal in (
            session.judging.judged, session.runs.active_changed, session.track.finished,
        ):  # fmt: skip
            signal.connect(self.ask_soon)

    # ---- facts

    @property
    def found(self) -> Found | None:
        """What was found last in the active run; None while nothing is known."""
        active = self._session.runs.active
        return self._known.get(active) if active is not None else None

    @property
    def looking(self) -> bool:
        """Whether pictures are being looked at."""
        return self._work is not None and self._work[1].title == _EXPLAINING

    @property
    def working(self) -> bool:
        """Whether failures are being found."""
        return self._work is not None or self._timer.isActive()

    @property
    def listed(self) -> tuple[FailureSegment, ...]:
        """Failures that the filter takes, in their order."""
        every = self.found.failures if self.found is not None else ()
        return tuple(failure for failure in every if self.filter.takes(failure))

    # ---- what a person does

    def set_filter(self, wanted: Filter) -> None:
        """List others."""
        if wanted != self.filter:
            self.filter = wanted
            self._keep_choice()
            self.changed.emit()

    def choose(self, failure: FailureSegment | None) -> None:
        """Choose a failure."""
        if failure is not self.chosen:
            self.chosen = failure
            self.changed.emit()

    def beside(self, frame: int, direction: int) -> tuple[FailureSegment, bool] | None:
        """The listed failure after (1) or before (-1) the chosen one, or else a frame.

        After the last one comes the first, and the other way around: whether that is so comes with
        it. None where none is listed.
        """
        listed = list(self.listed)
        if not listed:
            return None
        if self.chosen in listed and frame in self.chosen.frames:
            place = listed.index(self.chosen) + direction
            return listed[place % len(listed)], not 0 <= place < len(listed)
        if direction > 0:
            there = (e for e in listed if e.last >= frame and e.peak_frame > frame)
        else:
            there = (e for e in reversed(listed) if e.peak_frame < frame)
        found = next(there, None)
        return (found, False) if found is not None else (listed[0 if direction > 0 else -1], True)

    # ---- finding

    @Slot()
    def ask_soon(self, _what: object = None) -> None:
        """Look whether anything has changed, when things have come to rest."""
        self._timer.start()

    @Slot()
    def _ask(self) -> None:
        session, entry = self._session, self._session.runs.active
        recording, truth = session.document.recording, session.judging.truth
        grows = entry is session.track.entry and session.track.running
        if recording is not None and entry is not None and entry.frames and not grows:
            threshold = self._threshold()
            state = len(entry.frames), truth, threshold, recording
            known = self._known.get(entry)
            if known is None or known.state != state:
                find = partial(_found, entry.now(), recording, truth, threshold)
                self._begin(entry, (state, False), _FINDING, lambda _: Found(state, *find()))
            elif known.search and known.failures and not known.looked and self._wants_pictures():
                self._begin(entry, (state, True), _EXPLAINING, partial(_looked_at, known))
        told = self.found, self.looking
        if told != self._told:
            self._told = told
            self._keep_choice()
            self.changed.emit()

    def _begin(
        self, entry: RunEntry, what: Hashable, title: str, work: Callable[[Task], Found]
    ) -> None:
        """Work something out, once, one after the other; what a person stops is not asked again."""
        if self._asked.get(entry) == what:
            return
        if self._work is not None:
            if self._work[0] is entry:
                self._work[1].cancel()  # what comes of it holds no longer
            return

        def done(found: Found) -> None:
            self._known[entry] = found

        task = self._tasks.begin(title, work, done)
        self._asked[entry], self._work = what, (entry, task)
        task.ended.connect(self._on_ended)

    @Slot()
    def _on_ended(self) -> None:
        self._work = None
        self._ask()

    def _keep_choice(self) -> None:
        """Choose what has become of the chosen failure."""
        old = self.chosen
        if old is not None:
            same = [e for e in self.listed if e.found == old.found and e.overlaps(old)]
            self.chosen = same[0] if same else None


def _found(
    now: RunEntry, recording: Recording, truth: Truth | None, threshold: float
) -> tuple[FailureSearch | None, tuple[FailureSegment, ...]]:
    run = now.run()
    if run is None:
        return None, ()
    rules = FailureRules().replaced(episode_error=min(max(threshold, 1.0), 180.0))
    reference = truth.trajectory if truth is not None else None
    search = FailureSearch(run, recording.fps, reference, recording, rules)
    return search, explained(replace(search, pictures=False), stretches_of(search))


def _looked_at(known: Found, task: Task) -> Found:
    """The same with causes that are judged by pictures as well, which takes seconds."""
    assert known.search is not None  # noqa: S101 - there are no failures without
    failures = explained(known.search, known.failures, task.report, task.token.cancelled)
    return replace(known, failures=failures, looked=True)
