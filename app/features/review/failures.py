"""The failures of a run in the window: their panel, pictures, timeline and playback."""

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from weakref import WeakKeyDictionary

from PySide6.QtGui import QColor

from stereotrack_core.arrays import ImageArray
from stereotrack_core.counting import counted
from stereotrack_core.evaluation.failure_segments.drawing import Paper, evidence_picture
from stereotrack_core.evaluation.failure_segments.find import FailureSearch, explained, stretches_of
from stereotrack_core.evaluation.failure_segments.segment import (
    CAUSE_WORDS,
    FOUND_WORDS,
    FailureSegment,
    limbs_words,
)
from stereotrack_core.evaluation.failure_segments.stretches import FailureRules, has_signs
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader

from ...context import Context
from ...session.changes import Part
from ...session.document import Shared
from ...session.jobs import Job, NewestJob, Task
from ...session.judgement import MEASURED_LIMBS, Truth
from ...session.newest import LatestOnly
from ...session.runs import RunEntry
from ...widgets.style.theme import current_theme
from ...widgets.tables.failures_panel import FailuresPanel
from ...widgets.timeline.lanes import Lane, Span

LANE_NAMES = {"truth": "failures", "signs": "failures (without reference)"}
LANE_COLOURS = {"truth": "#CC79A7", "signs": "#b8860b"}


@dataclass(frozen=True)
class Filter:
    """Filter of the list; an empty word lists all."""

    limb: str = ""
    cause: str = ""
    found: str = ""

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

    state: Hashable  # frames, reference and threshold that they belong to
    search: FailureSearch | None
    """Question to the core; None if the run does not state its origin."""
    failures: tuple[FailureSegment, ...]
    looked: bool = False  # whether causes are judged by pictures as well


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


_DELAY_MS = 200
_FINDING, _EXPLAINING = "detecting failures", "classifying causes of failures"


@dataclass(frozen=True, eq=False)
class _Wanted:
    """A picture of a failure that is to be drawn."""

    search: FailureSearch
    recording: Recording
    failure: FailureSegment
    reader: Shared[FrameReader]
    paper: Paper

    def drawn(self) -> ImageArray:
        with self.reader.used() as reader:
            return evidence_picture(self.search, self.recording, self.failure, reader, self.paper)


def _bgr(colour: str) -> tuple[int, int, int]:
    shown = QColor(colour)
    return shown.blue(), shown.green(), shown.red()


_AROUND = 0.3  # seconds before and after a failure that its loop shows as well
_NOT_JUDGED = (
    "Without depth, failures are detected against a reference alone. Choose one under Track, "
    "Errors against."
)


class FailureController:
    """The failures of the active run: found when a fact changes, listed, shown and gone to."""

    def __init__(self, context: Context) -> None:
        self._context, self._session = context, context.session
        self.panel = FailuresPanel(
            lambda place: self._choose(self._at(place)),
            lambda place: self._jump(self._at(place)),
            self._on_filtered,
        )
        self._dock = context.docks.add("failures", "Failures", self.panel)
        self._lanes: tuple[FailureSegment, ...] = ()
        self._known: WeakKeyDictionary[RunEntry, Found] = WeakKeyDictionary()
        self._asked: WeakKeyDictionary[RunEntry, Hashable] = WeakKeyDictionary()
        self._job = NewestJob(context.tasks)
        self._entry: RunEntry | None = None
        """The run whose failures are being found."""
        self.chosen: FailureSegment | None = None
        self._filter = Filter()
        self._told: tuple[Found | None, bool] = None, False
        self._timer = context.session.later(self._look, _DELAY_MS)
        self._pictures = LatestOnly(
            context.tasks, _Wanted.drawn, "draw failures", self._on_picture, self._on_no_picture
        )
        self._pictured: _Wanted | None = None
        self._connect()
        self.show()

    def _connect(self) -> None:
        context, session, panel = self._context, self._session, self.panel
        causes = {str(cause): words for cause, words in CAUSE_WORDS.items()}
        found = {str(how): words for how, words in FOUND_WORDS.items()}
        panel.set_choices(MEASURED_LIMBS, causes, found)
        watch = session.changes.watch
        facts = Part.JUDGEMENT | Part.ACTIVE_RUN | Part.RUN_ENDED | Part.THRESHOLD
        watch(facts, self._timer.start)
        watch(Part.WORKSPACE, self.show)
        watch(Part.RECORDING_CLOSED, self._forget_pictures)
        self._dock.visibilityChanged.connect(self._on_seen)
        context.tasks.watch(lambda: not self._working() and self._pictures.settled())

    # ---- facts

    @property
    def found(self) -> Found | None:
        active = self._session.runs.active
        return self._known.get(active) if active is not None else None

    @property
    def listed(self) -> tuple[FailureSegment, ...]:
        every = self.found.failures if self.found is not None else ()
        return tuple(failure for failure in every if self._filter.takes(failure))

    def _working(self) -> bool:
        return self._job.busy or self._timer.isActive()

    def none_listed(self) -> str:
        if self._session.runs.active is None:
            return "There is no run yet. Run the tracker or open a run."
        if self._working() and self.found is None:
            return "Failures are still being detected. Wait for the list."
        return "" if self.listed else "No failure is listed."

    def looping(self) -> bool:
        return self._session.document.loop is not None

    # ---- what commands do

    def go(self, direction: int) -> None:
        """Go to the worst frame of the next (1) or previous (-1) listed failure."""
        listed = self.listed
        there = beside(listed, self.chosen, self._session.document.frame, direction)
        if there is None:
            return
        found, wrapped = there
        self._jump(found)
        place = f"Failure {listed.index(found) + 1} of {len(listed)}"
        ends = "the last one" if direction > 0 else "the first one"
        around = f", coming round from {ends}" if wrapped else ""
        self._context.notifier.say(f"{place}{around}.", 4000)

    def toggle_loop(self) -> None:
        """Play the chosen failure, or the one at the playhead, again and again; or stop that."""
        context, document = self._context, self._session.document
        if document.loop is not None:
            document.set_loop(None)
            document.pause()
            return
        if self.chosen is None:
            at = [e for e in self.listed if document.frame in e.frames]
            if not at:
                context.notifier.say("Select a failure, or go to a frame inside one.", 4000)
                return
            self._choose(at[0])
        document.set_loop(self._stretch())
        document.play()

    # ---- finding

    def _look(self) -> None:
        """Find the failures again if a fact has changed, and show what is known."""
        session, entry = self._session, self._session.runs.active
        recording, truth = session.document.recording, session.judging.truth
        grows = entry is session.track.entry and session.track.running
        if recording is not None and entry is not None and entry.frames and not grows:
            threshold = self._threshold()
            state = len(entry.frames), truth, threshold, recording
            known = self._known.get(entry)
            if known is None or known.state != state:
                find = partial(found_in, entry.now(), recording, truth, threshold, state)
                self._begin(entry, (state, False), _FINDING, lambda _: find())
            elif (
                known.search and known.failures and not known.looked
                and self._context.docks.is_seen("failures")  # images take seconds
            ):  # fmt: skip
                self._begin(entry, (state, True), _EXPLAINING, partial(looked_at, known))
        told = self.found, self._looking()
        if told != self._told:
            self._told = told
            self._keep_choice()

    def _looking(self) -> bool:
        task = self._job.task
        return task is not None and not task.over and task.title == _EXPLAINING

    def _threshold(self) -> float:
        """Error in degrees from which a failure begins."""
        judgement = self._session.judging.of(self._session.runs.active)
        if judgement is not None and judgement.measure == "error":
            return self._context.view_state.threshold
        return FailureRules().episode_error

    def _begin(
        self, entry: RunEntry, what: Hashable, title: str, work: Callable[[Task], Found]
    ) -> None:
        """Begin a task unless one runs; a task stopped by the person is not repeated."""
        if self._asked.get(entry) == what:
            return
        if self._job.busy:
            if self._entry is entry:
                self._job.cancel()  # what comes of it holds no longer
            return
        self._asked[entry], self._entry = what, entry
        done = partial(self._known.__setitem__, entry)
        self._job.run(Job(title, work, done, ended=self._on_ended))

    def _on_ended(self) -> None:
        self._entry = None
        self._look()

    def _keep_choice(self) -> None:
        """Choose the same failure among those that are listed now, and show them."""
        old = self.chosen
        if old is not None:
            same = [e for e in self.listed if e.found == old.found and e.overlaps(old)]
            self.chosen = same[0] if same else None
        self.show()

    # ---- showing

    def show(self) -> None:
        listed, chosen, docks = self.listed, self.chosen, self._context.docks
        place = listed.index(chosen) if chosen in listed else -1
        self.panel.show_rows(listed, self._fps(), place, self._words(self.found))
        self._ask_for_picture(chosen if docks.is_seen("failures") else None)
        lanes = () if docks.workspace == "annotate" else listed
        if lanes != self._lanes:
            self._lanes = lanes
            docks.timeline.set_lanes(lanes_of_failures(lanes), "failures")
        if self.looping():
            self._session.document.set_loop(self._stretch())
        self._context.actions.refresh_soon()

    def _ask_for_picture(self, failure: FailureSegment | None) -> None:
        reader, found = self._session.document.reader, self.found
        search = found.search if found is not None else None
        recording = search.recording if search is not None else None
        if search is None or failure is None or reader is None or recording is None:
            self._forget_pictures()
            self.panel.evidence.show_picture(None)
            return
        theme, before = current_theme(), self._pictured
        paper = Paper(_bgr(theme.base), _bgr(theme.text), _bgr(theme.muted))
        if before is None or before.failure is not failure or before.paper != paper:
            self._pictured = _Wanted(search, recording, failure, reader, paper)
            self._pictures.ask(self._pictured)

    def _on_picture(self, _wanted: _Wanted, pixels: ImageArray) -> None:
        self.panel.evidence.show_picture(pixels)

    def _on_no_picture(self, _wanted: _Wanted, error: Exception) -> None:
        self.panel.evidence.show_picture(None)
        self._context.notifier.error(error)

    def _forget_pictures(self) -> None:
        self._pictures.close()
        self._pictured = None

    def _words(self, found: Found | None) -> str:
        if self._session.runs.active is None:
            return "Run the tracker to see the failures of a run."
        if found is None:
            return "Detecting failures …"
        every, listed = found.failures, self.listed
        if found.search is None:
            return "The source recording of the run is not known, so failures cannot be detected."
        if not every:
            judged = found.search.reference is not None or has_signs(found.search.run)
            return "No failure was detected." if judged else _NOT_JUDGED
        words = counted(len(every), "failure")
        if len(listed) < len(every):
            words = f"{len(listed)} of {len(every)} failures"
        if self._looking():
            words += "; images are being analysed for causes"
        return f"{words}."

    def _fps(self) -> float:
        recording = self._session.document.recording
        return recording.fps if recording is not None else 1.0

    def _stretch(self) -> range | None:
        chosen = self.chosen
        if chosen is None:
            return None
        around = round(_AROUND * self._fps())
        last = min(chosen.last + around, self._session.document.frame_count - 1)
        return range(max(0, chosen.first - around), last + 1)

    def _on_seen(self, seen: bool) -> None:
        if seen:
            self._timer.start()
            self.show()

    # ---- what a person does in the panel

    def _at(self, place: int) -> FailureSegment | None:
        listed = self.listed
        return listed[place] if 0 <= place < len(listed) else None

    def _choose(self, failure: FailureSegment | None) -> None:
        if failure is not self.chosen:
            self.chosen = failure
            self.show()

    def _on_filtered(self, limb: str, cause: str, found: str) -> None:
        self._filter = Filter(limb, cause, found)
        self._keep_choice()

    def _jump(self, failure: FailureSegment | None) -> None:
        if failure is None:
            return
        self._choose(failure)
        self.panel.choose(self.listed.index(failure))  # whatever is selected there
        if not self.looping():
            self._session.document.pause()
        self._session.document.go_to(failure.peak_frame)
