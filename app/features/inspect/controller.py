"""What the tracker does in the frame that is shown, step by step: asked for and shown."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from stereotrack_core.body.model import body_of_subject
from stereotrack_core.errors import InputError
from stereotrack_core.recording.keypoints import Keypoints
from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.inspection import RecordedStep
from stereotrack_core.tracking.model import TrackModel, cameras_of, model_for
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.repeating import stored_spec
from stereotrack_core.tracking.trace import StepTrace, movement
from stereotrack_core.tracking.tuning.process import KeptRecording, RecordStep

from ...context import Context
from ...services.actions import Command, Menu
from ...session.changes import Part
from ...session.drawn import StepDrawing
from ...session.newest import LatestOnly
from ...session.runs import RunEntry
from ...session.session import Session
from ...widgets.forms.message import StateBar
from ...widgets.plots.inside_panel import InsidePanel, StepName
from .contents import content_of
from .drawing import drawing_of
from .steps import Step, same_step, steps_of

_SHARE = 0.68  # share of its column that the panel gets while a frame is inspected
_SOON_MS = 60
_WAITING = "Measuring the points of this frame and recording the tracker's step …"


def register(context: Context) -> InspectController:
    """Offer the panel and its commands."""
    inspect = InspectController(context)
    context.actions.add(_commands(context.session, inspect))
    names = ("inside_previous", "inside_next", "look_inside")
    actions = [context.actions.action(name) for name in names]
    inspect.panel.set_actions(actions, context.actions.key_words(names[-1]))
    return inspect


def _commands(session: Session, inspect: InspectController) -> list[Command]:
    command = Menu("&Track").command
    return [
        command("look_inside", "Inspect step", "Show step by step how the tracker processes this "
                "frame: prediction, points, correspondences, sigma points, cross-covariance, "
                "correction.", inspect.toggle, "F12", "search", section=True,
                why_not=lambda: session.not_tried() or session.tracker_works(),
                checked=lambda: inspect.inspects),
        command("inside_next", "Next stage of the step", "Show the next stage of the tracker's "
                "step.", lambda: inspect.go(inspect.index + 1), "F7", "step-forward",
                why_not=lambda: inspect.why_no_step(1)),
        command("inside_previous", "Previous stage of the step", "Show the previous stage of the "
                "tracker's step.", lambda: inspect.go(inspect.index - 1), "Shift+F7", "step-back",
                why_not=lambda: inspect.why_no_step(-1)),
    ]  # fmt: skip


_SMOOTHED = " The run was smoothed, so its poses also depend on later frames."
_LOOKED_AGAIN = " A second look changed the frame; its arms then come from other random numbers."
_SAME_METRES, _SAME_RADIANS = 1e-4, np.radians(0.01)


@dataclass(frozen=True, eq=False)
class Question:
    """Frame, run and settings of a step that is to be recorded."""

    frame: int
    work: Callable[[], RecordedStep]
    found: Estimate | None  # estimate of the run in this frame, to be compared with
    source: RunEntry | None
    settings: Settings


@dataclass(frozen=True, eq=False)
class Answer:
    """The recorded step, its stages, and its difference from the run."""

    question: Question
    done: RecordedStep
    steps: tuple[Step, ...]
    compared: str


def answer(question: Question) -> Answer:
    """Have the step done; called in a thread of its own."""
    done = question.work()
    return Answer(question, done, steps_of(done.trace), _compared(done.trace, question.found))


def question_of(
    frame: int, session: Session, entry: RunEntry | None, settings: Settings
) -> Question:
    """About a frame of a run, or about one that no run knows."""
    kept, process = session.kept, session.processes.trials
    assert kept is not None  # noqa: S101 - there are no frames without
    seen = (entry.at(k) if entry is not None else None for k in (frame - 1, frame))
    before, here = (one.estimate if one is not None else None for one in seen)
    make = _maker(kept, entry, settings)
    keypoints = _keypoints(session, entry, settings, frame)
    meta = entry.stored.meta if entry is not None and entry.stored is not None else {}
    of_frame = None if entry is None else entry.at(frame)
    looked = None if of_frame is None else of_frame.keypoints
    task = RecordStep(kept, frame, settings, make, before, here, keypoints, looked)
    more = _SMOOTHED if meta.get("smoothed") else ""
    if entry is not None and any(a <= frame <= b for a, b in entry.looked_again):
        more += _LOOKED_AGAIN

    def work() -> RecordedStep:
        done: RecordedStep = process(task)
        return replace(done, words=done.words + more)

    return Question(frame, work, here, entry, settings)


def _keypoints(
    session: Session, entry: RunEntry | None, settings: Settings, frame: int
) -> Keypoints | None:
    if entry is not None and (spec := entry.spec()) is not None:
        return spec.keypoints
    return session.keypoints.for_trial(settings, range(frame, frame + 1))


def _maker(
    of: KeptRecording, entry: RunEntry | None, settings: Settings
) -> Callable[[], TrackModel]:
    """Function that makes the model of a run, or of the next run if there is none."""
    recording, usable = of.recording, of.views
    if entry is None:
        body, views, seed = body_of_subject(recording.subject, settings.body), usable, 0
    else:
        spec = entry.spec()
        kept = tuple(name for name in (spec and spec.views) or () if name in usable)
        body, views, seed = entry.body, kept or usable, spec.seed if spec else 0
    cameras, clouds = cameras_of(recording, views), not of.mono
    return partial(model_for, body, settings, cameras, recording.fps, seed, clouds=clouds)


def _settings_of(entry: RunEntry) -> Settings:
    """Settings of a run. Raises InputError where a stored run does not say how it was made."""
    if entry.settings is not None or entry.stored is None:
        return entry.settings or Settings()
    return stored_spec(entry.stored).spec.settings


def _compared(trace: StepTrace, found: Estimate | None) -> str:
    if found is None or not (found.tracked and trace.estimate.tracked):
        return ""
    off = movement(trace.body, found.pose, trace.after.pose)
    angle = max(off.turn, float(np.nanmax(off.limbs)))
    if off.shift < _SAME_METRES and angle < _SAME_RADIANS:
        return "The result equals the pose of the run."
    by = f"{1000.0 * off.shift:.1f} mm and up to {np.degrees(angle):.1f}°"
    return f"The result differs from the pose of the run by {by}."


class InspectController:
    """Has the step of the frame that is shown recorded, and goes through its stages."""

    def __init__(self, context: Context) -> None:
        self._context = context
        session = context.session
        self._document, self._runs, self._track = session.document, session.runs, session.track
        self.panel = InsidePanel(self.go)
        context.docks.add("inside", "Inspect step", self.panel)
        self.bar = StateBar("Inspect step", "Close", "Stop inspecting and show the run again")
        self.bar.button.clicked.connect(self.leave)
        context.docks.lay_over_views(self.bar)
        self.inspects = False
        self.known: Answer | None = None
        """The step whose stage number `index` is shown."""
        self.index = 0
        self._asked: Question | None = None
        self._drawing: StepDrawing | None = None
        self._worker = LatestOnly(
            context.tasks, answer, "record step trace", self._on_answered, self._on_failed
        )
        self._soon = context.session.later(self._ask, _SOON_MS)
        watch = session.changes.watch
        watch(Part.FRAME | Part.PLAYING | Part.TRACKING, self._ask_soon)
        watch(Part.ACTIVE_RUN | Part.WORKSPACE, self._leave_if_inspecting)
        watch(Part.LEAVING, self.leave)
        watch(Part.WINDOW_CLOSING, self.close)
        context.tasks.watch(self.settled)

    # ---- what is known

    @property
    def step(self) -> Step | None:
        return self.known.steps[self.index] if self.known is not None else None

    @property
    def drawing(self) -> StepDrawing | None:
        known, step = self.known, self.step
        if known is None or step is None or not self.inspects:
            return None
        if self._drawing is None:
            self._drawing = drawing_of(known.done.trace, step, known.done.cloud)
        return self._drawing

    def settled(self) -> bool:
        if not self.inspects or self._waits():
            return True
        known, frame = self.known, self._document.frame
        if known is None or known.question is not self._asked or known.question.frame != frame:
            return False
        return known.question.source is self._runs.active

    def why_no_step(self, by: int) -> str:
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
        self._context.session.changes.loop.post(self._make_room)
        self.inspects = True
        self._ask()
        self._show(self.known, self.index)

    def leave(self) -> None:
        self.inspects = False
        self._ask_nothing()
        self._show(None, 0)

    def go(self, index: int) -> None:
        if self.known is not None and 0 <= index < len(self.known.steps) and index != self.index:
            self._show(self.known, index)

    def close(self) -> None:
        self.inspects, self.known, self._drawing = False, None, None

    def _ask_nothing(self) -> None:
        self._asked = None
        self._worker.close()

    # ---- asking

    def _ask_soon(self) -> None:
        # a tracker that is held tells so all the time
        if self.inspects and not self._soon.isActive():
            self._soon.start()

    def _waits(self) -> bool:
        return self._document.playing or self._track.running

    def _ask(self) -> None:
        self._soon.stop()
        if not self.inspects or self._document.recording is None:
            return
        if self._waits():
            if self.known is None or self.known.question is not self._asked:
                self._ask_nothing()  # the tracker needs the time
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
        frame = self._document.frame
        entry = self._runs.active
        settings = self._track.settings if entry is None else _settings_of(entry)
        asked = self._asked
        same = asked is not None and asked.source is entry
        if asked is not None and same and (asked.frame, asked.settings) == (frame, settings):
            return None
        return question_of(frame, self._context.session, entry, settings)

    def _on_answered(self, _question: Question, found: Answer) -> None:
        step = self.step
        self._show(found, same_step(found.steps, step) if step is not None else 0)

    def _on_failed(self, _question: Question, error: Exception) -> None:
        self.leave()
        self._context.notifier.error(error)

    # ---- showing

    def _show(self, known: Answer | None, index: int) -> None:
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
        if not self.inspects:
            return ""
        run = self._runs.active
        name = f" of run “{run.name}”" if run is not None else ""
        frame = self._document.frame if self.known is None else self.known.question.frame
        return f"Inspecting the tracker's step in frame {frame}{name}. The views show its stages."

    def _make_room(self) -> None:
        if self.inspects:
            self._context.docks.make_room("inside", _SHARE)

    def _leave_if_inspecting(self) -> None:
        if self.inspects:
            self.leave()
