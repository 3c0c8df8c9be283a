"""The failures of a run in the window: their panel, pictures, timeline and playback."""

from __future__ import annotations

from dataclasses import dataclass

from PySide6.QtCore import QObject, Slot
from PySide6.QtGui import QColor

from stereotrack_core.arrays import ImageArray
from stereotrack_core.evaluation.failure_segments.drawing import Paper
from stereotrack_core.evaluation.failure_segments.export import evidence_picture
from stereotrack_core.evaluation.failure_segments.find import FailureSearch
from stereotrack_core.evaluation.failure_segments.segment import (
    CAUSE_WORDS,
    FOUND_WORDS,
    FailureSegment,
)
from stereotrack_core.evaluation.failure_segments.stretches import FailureRules, has_signs
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader

from ...context import Context
from ...services.tasks.newest import LatestOnly, Shared
from ...session.judgement import MEASURED_LIMBS
from ...widgets.style.theme import current_theme
from ...widgets.tables.failures_panel import FailuresPanel
from .failure_list import FailurePresenter, Filter, Found, lanes_of_failures


@dataclass(frozen=True, eq=False)
class _Wanted:
    search: FailureSearch
    recording: Recording
    failure: FailureSegment
    reader: Shared[FrameReader]
    paper: Paper


def _drawn(wanted: _Wanted) -> ImageArray:
    with wanted.reader.used() as reader:
        return evidence_picture(
            wanted.search, wanted.recording, wanted.failure, reader, wanted.paper
        )


def _bgr(colour: str) -> tuple[int, int, int]:
    shown = QColor(colour)
    return shown.blue(), shown.green(), shown.red()


_AROUND = 0.3
"""Seconds before and after a failure that its loop shows as well."""

_NOT_JUDGED = (
    "Without depth, failures are detected against a reference alone. Choose one under Track, "
    "Errors against."
)


class FailureController(QObject):
    """What the window does with failures."""

    def __init__(self, context: Context) -> None:
        super().__init__(context.session)
        self._context, self._session = context, context.session
        session = context.session
        self.panel = FailuresPanel()
        context.docks.add("failures", "Failures", self.panel)
        self._lanes: tuple[FailureSegment, ...] = ()
        self.presenter = FailurePresenter(
            session, context.tasks, wants_pictures=self._is_seen, threshold=self._threshold
        )
        self._pictures = LatestOnly(_drawn, "draw failures")
        self._pictured: _Wanted | None = None
        causes = {str(cause): words for cause, words in CAUSE_WORDS.items()}
        found = {str(how): words for how, words in FOUND_WORDS.items()}
        self.panel.set_choices(MEASURED_LIMBS, causes, found)
        self.panel.chosen.connect(self._on_chosen)
        self.panel.activated.connect(self._on_activated)
        self.panel.filtered.connect(self._on_filtered)
        self.presenter.changed.connect(self.show)
        self._pictures.answered.connect(self._on_picture)
        self._pictures.failed.connect(self._on_no_picture)
        context.docks.dock("failures").visibilityChanged.connect(self._on_seen)
        context.view_state.threshold_changed.connect(self.presenter.ask_soon)
        context.docks.workspace_changed.connect(self.show)
        context.session.closed.connect(self._forget_pictures)
        context.session.closing.connect(self._forget_pictures)
        context.tasks.watch(lambda: not self.presenter.working and self._pictures.settled())
        self.show()

    # ---- facts

    def _search(self) -> FailureSearch | None:
        """What the failures belong to."""
        found = self.presenter.found
        return found.search if found is not None else None

    def _is_seen(self) -> bool:
        return self._context.docks.is_seen("failures")

    def none_listed(self) -> str:
        """Why there is no failure to do something with."""
        if self._session.runs.active is None:
            return "There is no run yet. Run the tracker or open a run."
        if self.presenter.working and self.presenter.found is None:
            return "Failures are still being detected. Wait for the list."
        return "" if self.presenter.listed else "No failure is listed."

    def looping(self) -> bool:
        """Whether a failure is played again and again."""
        return self._session.document.loop is not None

    # ---- what commands do

    def go(self, direction: int) -> None:
        """Go to the worst frame of the next (1) or previous (-1) listed failure."""
        listed, frame = self.presenter.listed, self._session.document.frame
        beside = self.presenter.beside(frame, direction)
        if beside is None:
            return
        found, wrapped = beside
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
        if self.presenter.chosen is None:
            at = [e for e in self.presenter.listed if document.frame in e.frames]
            if not at:
                context.notifier.say("Select a failure, or go to a frame inside one.", 4000)
                return
            self.presenter.choose(at[0])
        document.set_loop(self._stretch())
        document.play()

    # ---- following

    @Slot()
    def show(self) -> None:
        """Show what is known in the panel and on the timeline."""
        presenter = self.presenter
        listed = presenter.listed
        place = listed.index(presenter.chosen) if presenter.chosen in listed else -1
        self.panel.show_rows(listed, self._fps(), place, self._words(presenter.found))
        self._ask_for_picture(presenter.chosen if self._is_seen() else None)
        self._show_lanes()
        if self.looping():
            if presenter.chosen is None:
                self._session.document.set_loop(None)
            else:
                self._session.document.set_loop(self._stretch())
        self._context.actions.refresh_soon()

    def _ask_for_picture(self, failure: FailureSegment | None) -> None:
        """Draw a failure, unless that is drawn; None shows nothing."""
        reader, search = self._session.document.reader, self._search()
        recording = search.recording if search is not None else None
        if search is None or failure is None or reader is None or recording is None:
            self._pictured = None
            self.panel.evidence.show_picture(None)
            return
        theme, before = current_theme(), self._pictured
        paper = Paper(_bgr(theme.base), _bgr(theme.text), _bgr(theme.muted))
        if before is None or before.failure is not failure or before.paper != paper:
            self._pictured = _Wanted(search, recording, failure, reader, paper)
            self._pictures.ask(self._pictured)

    @Slot(object, object)
    def _on_picture(self, wanted: _Wanted, pixels: ImageArray) -> None:
        if wanted is self._pictured:
            self.panel.evidence.show_picture(pixels)

    @Slot(object, object)
    def _on_no_picture(self, wanted: _Wanted, error: Exception) -> None:
        if wanted is self._pictured:
            self.panel.evidence.show_picture(None)
            self._context.notifier.error(error)

    @Slot()
    def _forget_pictures(self) -> None:
        self._pictures.close()
        self._pictured = None

    def _show_lanes(self) -> None:
        listed = () if self._context.docks.workspace == "annotate" else self.presenter.listed
        if listed != self._lanes:
            self._lanes = listed
            self._context.docks.timeline.set_lanes(lanes_of_failures(listed), "failures")

    def _words(self, found: Found | None) -> str:
        if self._session.runs.active is None:
            return "Run the tracker to see the failures of a run."
        if found is None:
            return "Detecting failures …"
        every, listed = found.failures, self.presenter.listed
        if found.search is None:
            return "The source recording of the run is not known, so failures cannot be detected."
        if not every:
            judged = found.search.reference is not None or has_signs(found.search.run)
            return "No failure was detected." if judged else _NOT_JUDGED
        words = (
            f"{len(listed)} of {len(every)} failures"
            if len(listed) < len(every)
            else (f"{len(every)} failure{'s' if len(every) != 1 else ''}")
        )
        if self.presenter.looking:
            words += "; images are being analysed for causes"
        return f"{words}."

    def _fps(self) -> float:
        recording = self._session.document.recording
        return recording.fps if recording is not None else 1.0

    def _stretch(self) -> range | None:
        chosen = self.presenter.chosen
        if chosen is None:
            return None
        around = round(_AROUND * self._fps())
        last = min(chosen.last + around, self._session.document.frame_count - 1)
        return range(max(0, chosen.first - around), last + 1)

    def _threshold(self) -> float:
        judgement = self._session.judging.of(self._session.runs.active)
        if judgement is not None and judgement.measure == "error":
            return self._context.view_state.threshold
        return FailureRules().episode_error

    @Slot(bool)
    def _on_seen(self, seen: bool) -> None:
        if seen:
            self.presenter.ask_soon()
            self.show()

    # ---- what a person does in the panel

    @Slot(int)
    def _on_chosen(self, place: int) -> None:
        listed = self.presenter.listed
        self.presenter.choose(listed[place] if 0 <= place < len(listed) else None)

    @Slot(int)
    def _on_activated(self, place: int) -> None:
        listed = self.presenter.listed
        if 0 <= place < len(listed):
            self._jump(listed[place])

    @Slot(str, str, str)
    def _on_filtered(self, limb: str, cause: str, found: str) -> None:
        self.presenter.set_filter(Filter(limb, cause, found))

    def _jump(self, failure: FailureSegment) -> None:
        self.presenter.choose(failure)
        self.panel.choose(self.presenter.listed.index(failure))  # whatever is selected there
        if not self.looping():
            self._session.document.pause()
        self._session.document.go_to(failure.peak_frame)
