"""What is known about the frame that is shown, worked out again whenever its facts change."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any, Generic, Protocol, TypeVar

from PySide6.QtCore import QObject, Signal, Slot

from .newest import NewestWins


class Question(Hashable, Protocol):
    """Facts of one frame from which something is worked out; known by its identity."""

    @property
    def frame(self) -> int:
        """The frame."""


class Answer(Protocol):
    """What was worked out."""

    @property
    def question(self) -> Any:
        """The question that it answers."""


A = TypeVar("A", bound=Answer)


class NewestAnswer(QObject, Generic[A]):
    """Asks in a thread of its own; the newest question wins.

    Until the new answer is there, the one before of the same frame holds, so that nothing flickers.

    Parameters
    ----------
    question : callable
        What is to be asked now; None where there is nothing to ask.
    answer : callable
        From a question to its answer; called in the thread.
    name : str
        Name of the thread.

    Signals
    -------
    changed : ()
        Another answer holds now, or none.
    failed : Exception
    """

    changed = Signal()
    failed = Signal(object)

    def __init__(
        self, question: Callable[[], Question | None], answer: Callable[[Any], A], name: str
    ) -> None:
        super().__init__()
        self._question, self._answer, self._name = question, answer, name
        self._asked: Question | None = None
        self._known: A | None = None
        self._worker: NewestWins | None = None

    def at(self, frame: int) -> A | None:
        """The answer about a frame, be it to the question before the newest; None without one."""
        known = self._known
        return known if known is not None and known.question.frame == frame else None

    def settled(self) -> bool:
        """Whether what holds answers the newest question."""
        asked = self._asked
        return asked is None or (self._known is not None and self._known.question is asked)

    @Slot()
    def ask(self) -> None:
        """Ask about what is shown now."""
        self._asked = self._question()
        if self._asked is None:
            if self._known is not None:
                self._known = None
                self.changed.emit()
            return
        if self._worker is None:
            self._worker = NewestWins(self._answer, self._name)
            self._worker.answered.connect(self._on_answered)
            self._worker.failed.connect(self._on_failed)
        self._worker.ask(self._asked)

    def close(self) -> None:
        """Forget everything, also what is still to be answered; the next question begins anew."""
        self._asked = self._known = None
        if self._worker is not None:
            self._worker.close()
            self._worker = None

    @Slot(object, object)
    def _on_answered(self, question: Question, answer: A) -> None:
        if self._asked is not None and question.frame == self._asked.frame:
            self._known = answer
            self.changed.emit()

    @Slot(object, object)
    def _on_failed(self, question: Question, error: Exception) -> None:
        if question is self._asked:
            self._asked = self._known = None
            self.changed.emit()
        self.failed.emit(error)
