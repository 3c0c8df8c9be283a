"""Looking inside the frame that is shown: what the tracker does there, step by step."""

from __future__ import annotations

from PySide6.QtCore import QObject, QTimer, Signal, Slot

from stereotrack_core.errors import InputError

from ...services.failures import message_of
from ...services.tasks.newest import NewestWins
from ...session.pictures import StepDrawing
from ...session.session import Session
from ...widgets.plots.inside_panel import StepContent
from .contents import content_of
from .drawing import drawing_of
from .sources import (
    LIVE,
    Inside,
    Question,
    answer,
    asks_the_same,
    live_question,
    run_question,
    settings_of,
)
from .steps import Step, same_step

_SOON_MS = 60


class InsidePresenter(QObject):
    """Looks inside the frame that is shown, and goes through its steps."""

    changed = Signal()
    """Another step is shown, or none."""
    message = Signal(object)
    """Message: why nothing can be shown."""

    def __init__(self, session: Session) -> None:
        super().__init__()
        self._session, self._document = session, session.document
        self._runs, self._track = session.runs, session.track
        self.looking = False
        self.known: Inside | None = None
        self.index = 0
        self._asked: Question | None = None
        self._drawing: StepDrawing | None = None
        self._worker: NewestWins | None = None
        self._soon = QTimer(self, singleShot=True, interval=_SOON_MS)
        self._soon.timeout.connect(self._ask)
        for changed in (
            session.document.frame_changed, session.document.playing_changed,
            session.runs.active_changed, session.track.state_changed,
        ):  # fmt: skip
            changed.connect(self._ask_soon)

    # ---- what is known

    @property
    def step(self) -> Step | None:
        """The step that is shown."""
        return self.known.steps[self.index] if self.known is not None else None

    @property
    def drawing(self) -> StepDrawing | None:
        """What views and scene show of the step."""
        known, step = self.known, self.step
        if known is None or step is None or not self.looking:
            return None
        if self._drawing is None:
            self._drawing = drawing_of(known.trace, step, known.cloud)
        return self._drawing

    def content(self) -> StepContent | None:
        """What the panel shows of the step."""
        known, step = self.known, self.step
        if known is None or step is None:
            return None
        return content_of(known.trace, step, known.compared)

    @property
    def busy(self) -> bool:
        """Whether something is being worked out."""
        return self.looking and not self.settled()

    @property
    def live(self) -> bool:
        """Whether what is shown comes from the tracker in progress."""
        return self.known is not None and self.known.words == LIVE

    @property
    def at_end(self) -> bool:
        """Whether the last step is shown."""
        return self.known is not None and self.index == len(self.known.steps) - 1

    def settled(self) -> bool:
        """Whether what is shown belongs to the frame that is shown."""
        if not self.looking or self._waits():
            return True
        known, frame = self.known, self._document.frame
        if known is None or known.question is not self._asked or known.question.frame != frame:
            return False
        return known.question.source is (self._track.held_before(frame) or self._runs.active)

    # ---- what a person does

    def look(self) -> None:
        """Look inside the frame that is shown, and follow it from now on."""
        self.looking = True
        self._ask()
        self.changed.emit()

    def leave(self) -> None:
        """Show the run again."""
        self.looking = False
        self._asked = None
        self._show(None, 0)

    def go(self, index: int) -> None:
        """Show one of the steps."""
        if self.known is not None and 0 <= index < len(self.known.steps) and index != self.index:
            self._show(self.known, index)

    def move(self, by: int) -> None:
        """Show another step, so many after or before."""
        self.go(self.index + by)

    def close(self) -> None:
        """Forget everything and end the thread."""
        self.looking, self.known, self._drawing, self._asked = False, None, None, None
        if self._worker is not None:
            self._worker.close()
            self._worker = None

    # ---- asking

    @Slot()
    def _ask_soon(self, _what: object = None) -> None:
        # a tracker that is held tells so all the time
        if self.looking and not self._soon.isActive():
            self._soon.start()

    def _waits(self) -> bool:
        return self._document.playing or self._track.running

    @Slot()
    def _ask(self) -> None:
        self._soon.stop()
        if not self.looking or self._document.recording is None:
            return
        if self._waits():
            if self.known is None or self.known.question is not self._asked:
                self._asked = None  # the tracker needs the time
            return
        try:
            question = self._question()
        except InputError as error:
            self.leave()
            self.message.emit(message_of(error))
            return
        if question is None:
            return
        self._asked = question
        if self._worker is None:
            self._worker = NewestWins(answer, "record step trace")
            self._worker.answered.connect(self._on_answered)
            self._worker.failed.connect(self._on_failed)
        self._worker.ask(question)
        self.changed.emit()

    def _question(self) -> Question | None:
        """What is to be worked out about the frame that is shown; None where that is asked."""
        frame = self._document.frame
        live, entry = self._track.held_before(frame), self._runs.active
        settings = self._track.settings
        if live is not None:
            settings = live.settings
        elif entry is not None:
            settings = settings_of(entry)
        if asks_the_same(self._asked, frame, live or entry, settings):
            return None
        if live is not None:
            return live_question(frame, live)
        return run_question(frame, self._session, entry, settings)

    @Slot(object, object)
    def _on_answered(self, question: Question, found: Inside) -> None:
        if question is not self._asked or not self.looking:
            return
        index = same_step(found.steps, self.step) if self.step is not None else 0
        self._show(found, index)

    @Slot(object, object)
    def _on_failed(self, question: Question, error: Exception) -> None:
        if question is self._asked:
            self.leave()
            self.message.emit(message_of(error))

    def _show(self, known: Inside | None, index: int) -> None:
        self.known, self.index, self._drawing = known, index, None
        self.changed.emit()
