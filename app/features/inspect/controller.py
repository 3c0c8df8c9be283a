"""What the tracker does in the frame that is shown, step by step: asked for, shown, exported."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QObject, QTimer, Slot
from PySide6.QtWidgets import QFileDialog

from stereotrack_core.errors import InputError
from stereotrack_core.interop.trace_file import TRACE_SUFFIXES, write_trace

from ...context import Context
from ...services.actions import ActionRegistry
from ...services.tasks.newest import LatestOnly
from ...session.pictures import StepDrawing
from ...session.runs import RunEntry
from ...session.tracking import LiveRun
from ...widgets.forms.message import StateBar
from ...widgets.plots.inside_panel import InsidePanel, StepName
from .contents import content_of
from .drawing import drawing_of
from .sources import Answer, Question, answer, live_question, run_question, settings_of
from .steps import Step, same_step

_SHARE = 0.68
"""Share of its column that the panel gets while a frame is inspected."""

_SOON_MS = 60
_WAITING = "Measuring the points of this frame and recording the tracker's step …"
_FILTERS = "Cross-covariance of the iteration (*.csv);;All numbers of the step (*.npz)"


class InspectController(QObject):
    """Has the step of the frame that is shown recorded, and goes through its stages.

    Attributes
    ----------
    inspects : bool
        Whether the frame that is shown is inspected.
    known : Answer or None
        What is shown of it.
    index : int
        Which of its stages is shown.
    """

    def __init__(self, context: Context) -> None:
        super().__init__(context.session)
        self._context = context
        session = context.session
        self._document, self._runs, self._track = session.document, session.runs, session.track
        self.panel = InsidePanel()
        context.docks.add("inside", "Inspect step", self.panel)
        self.bar = StateBar("Inspect step", "Close", "Stop inspecting and show the run again")
        self.bar.ended.connect(self.leave)
        context.docks.lay_over_views(self.bar)
        self.inspects = False
        self.known: Answer | None = None
        self.index = 0
        self._in_progress: RunEntry | None = None
        self._asked: Question | None = None
        self._drawing: StepDrawing | None = None
        self._worker = LatestOnly(answer, "record step trace")
        self._worker.answered.connect(self._on_answered)
        self._worker.failed.connect(self._on_failed)
        self._soon = QTimer(self, singleShot=True, interval=_SOON_MS)
        self._soon.timeout.connect(self._ask)
        for changed in (
            session.document.frame_changed, session.document.playing_changed,
            session.track.state_changed,
        ):  # fmt: skip
            changed.connect(self._ask_soon)
        self.panel.step_chosen.connect(self.go)
        session.runs.active_changed.connect(self._leave_if_inspecting)
        context.docks.workspace_changed.connect(self._leave_if_inspecting)
        session.leaving.connect(self.leave)
        session.closing.connect(self.close)
        context.tasks.watch(self.settled)

    def offer(self, actions: ActionRegistry) -> None:
        """Put the commands into the panel."""
        names = ("inside_previous", "inside_next", "inside_export", "look_inside")
        self.panel.set_actions(
            [actions.action(name) for name in names], actions.key_words(names[-1])
        )

    # ---- what is known

    @property
    def step(self) -> Step | None:
        """The stage that is shown."""
        return self.known.steps[self.index] if self.known is not None else None

    @property
    def drawing(self) -> StepDrawing | None:
        """What views and scene show of the stage."""
        known, step = self.known, self.step
        if known is None or step is None or not self.inspects:
            return None
        if self._drawing is None:
            self._drawing = drawing_of(known.done.trace, step, known.done.cloud)
        return self._drawing

    @property
    def live(self) -> bool:
        """Whether what is shown comes from the tracker in progress."""
        return self.known is not None and isinstance(self.known.question.source, LiveRun)

    @property
    def at_end(self) -> bool:
        """Whether the last stage is shown."""
        return self.known is not None and self.index == len(self.known.steps) - 1

    def settled(self) -> bool:
        """Whether what is shown belongs to the frame that is shown."""
        if not self.inspects or self._waits():
            return True
        known, frame = self.known, self._document.frame
        if known is None or known.question is not self._asked or known.question.frame != frame:
            return False
        return known.question.source is (self._track.held_before(frame) or self._runs.active)

    def why_no_step(self, by: int) -> str:
        """Why there is no further stage; empty where there is one."""
        if self.known is None:
            return "No step trace is shown. Choose Inspect step first."
        if 0 <= self.index + by < len(self.known.steps):
            return ""
        return "This is the last stage." if by > 0 else "This is the first stage."

    # ---- what a person does

    def toggle(self) -> None:
        """Inspect the frame that is shown, and follow it from now on; or show the run again."""
        if self.inspects:
            self.leave()
            return
        self._document.pause()
        self._context.docks.bring_up("inside")
        QTimer.singleShot(0, self, self._make_room)
        self._look()

    @Slot()
    def leave(self) -> None:
        """Show the run again."""
        self.inspects = False
        self._asked = None
        self._show(None, 0)

    def go(self, index: int) -> None:
        """Show one of the stages."""
        if self.known is not None and 0 <= index < len(self.known.steps) and index != self.index:
            self._show(self.known, index)

    def iterate(self) -> None:
        """Show the next stage of the frame that comes next; after the last one, track it."""
        frame = self._context.session.tracker.hold_before_next()
        if frame is None:
            return
        if not (self.inspects and self.live and self._document.frame == frame):
            self._document.visit(frame)
            self._look()
        elif self.at_end:
            self._track.go_on(1)
        else:
            self.go(self.index + 1)

    def ask_for_file(self) -> None:
        """Ask where the numbers of the frame shall go."""
        if self.known is None:
            return
        name = f"frame-{self.known.done.trace.frame}-inside.csv"
        chosen, _ = QFileDialog.getSaveFileName(
            self._context.docks.dialog_parent, "Export step trace", name, _FILTERS
        )
        if chosen:
            self.export(Path(chosen))

    def export(self, path: Path) -> None:
        """Write the cross-covariance of the iteration that is shown, or all numbers."""
        known, step = self.known, self.step
        if known is None or step is None:
            return
        path = path if path.suffix.lower() in TRACE_SUFFIXES else path.with_name(f"{path.name}.csv")
        try:
            write_trace(path, known.done.trace, max(step.correction, 0))
        except InputError as error:
            self._context.notifier.error(error)
        else:
            self._context.notifier.say(f"Saved to {path}.", 6000)

    @Slot()
    def close(self) -> None:
        """Forget everything and end the thread."""
        self.inspects, self.known, self._drawing, self._asked = False, None, None, None
        self._worker.close()

    # ---- asking

    def _look(self) -> None:
        self.inspects, self._in_progress = True, self._track.entry
        self._ask()
        self._show(self.known, self.index)

    @Slot()
    def _ask_soon(self, _what: object = None) -> None:
        # a tracker that is held tells so all the time
        if self.inspects and not self._soon.isActive():
            self._soon.start()

    def _waits(self) -> bool:
        return self._document.playing or self._track.running

    @Slot()
    def _ask(self) -> None:
        self._soon.stop()
        if not self.inspects or self._document.recording is None:
            return
        if self._in_progress is not None and self._track.entry is not self._in_progress:
            self.leave()  # the run that was inspected has ended
            return
        if self._waits():
            if self.known is None or self.known.question is not self._asked:
                self._asked = None  # the tracker needs the time
            return
        try:
            question = self._question()
        except InputError as error:
            self.leave()
            self._context.notifier.error(error)
            return
        if question is None:
            return
        self._asked = question
        self._worker.ask(question)
        self._show(self.known, self.index)

    def _question(self) -> Question | None:
        """What is to be asked about the frame that is shown; None where that was asked."""
        frame = self._document.frame
        live, entry = self._track.held_before(frame), self._runs.active
        settings = self._track.settings
        if live is not None:
            settings = live.settings
        elif entry is not None:
            settings = settings_of(entry)
        if self._asked is not None and self._asked.asks(frame, live or entry, settings):
            return None
        if live is not None:
            return live_question(frame, live)
        return run_question(frame, self._context.session, entry, settings)

    @Slot(object, object)
    def _on_answered(self, question: Question, found: Answer) -> None:
        if question is self._asked and self.inspects:
            step = self.step
            self._show(found, same_step(found.steps, step) if step is not None else 0)

    @Slot(object, object)
    def _on_failed(self, question: Question, error: Exception) -> None:
        if question is self._asked:
            self.leave()
            self._context.notifier.error(error)

    # ---- showing

    def _show(self, known: Answer | None, index: int) -> None:
        """Show one stage of a step, or none."""
        if known is not self.known or index != self.index:
            self.known, self.index, self._drawing = known, index, None
        context, panel, step = self._context, self.panel, self.step
        context.view_state.draw(self.drawing)
        if known is None or step is None:
            panel.show_nothing(_WAITING if self.inspects else "")
        else:
            names = tuple(StepName(one.title, one.heading) for one in known.steps)
            panel.show_steps(names, index)
            elsewhere = known.question.frame != self._document.frame
            busy = elsewhere and self.inspects and not self.settled()
            content = content_of(known.done.trace, step, known.compared)
            panel.show_content(content, known.done.words, busy=busy)
        self.bar.show_words(self._words())
        if not self.inspects:
            context.docks.give_room_back()
        context.actions.refresh_soon()

    def _words(self) -> str:
        """What the bar says; nothing hides it."""
        if not self.inspects:
            return ""
        run = self._runs.active
        name = f" of run “{run.name}”" if run is not None else ""
        frame = self._document.frame if self.known is None else self.known.question.frame
        return f"Inspecting the tracker's step in frame {frame}{name}. The views show its stages."

    @Slot()
    def _make_room(self) -> None:
        if self.inspects:
            self._context.docks.make_room("inside", _SHARE)

    @Slot()
    def _leave_if_inspecting(self) -> None:
        if self.inspects:
            self.leave()
