"""A worker that answers the newest question and forgets those that were overtaken."""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable
from typing import Any, Generic, Protocol, TypeVar

from PySide6.QtCore import QObject, Qt, Signal, Slot

from .task import Threaded


class _Worker(Threaded):
    """The thread of :class:`LatestOnly`."""

    over = Signal(bool, object, object)
    """Whether a question has an answer, the question, and the answer or why there is none."""

    def __init__(self, answer: Callable[[Any], Any], name: str) -> None:
        super().__init__(self._run, name)
        self._answer = answer
        self._condition = threading.Condition()
        self._waiting: list[Hashable] = []
        self._busy_with: Hashable | None = None
        self._closed = False
        self._begin()

    def ask(self, question: Hashable) -> None:
        """Ask; overtakes a question that waits."""
        with self._condition:
            if self._busy_with == question:
                self._waiting = []
                return
            self._waiting = [question]
            self._condition.notify()

    def close(self) -> None:
        """Forget what waits, and end; returns at once."""
        with self._condition:
            self._closed = True
            self._waiting = []
            self._condition.notify()

    def _run(self) -> None:
        while self._wait():
            self._answer_one()

    def _wait(self) -> bool:
        """Wait for a question; False when there are no more."""
        with self._condition:
            self._busy_with = None
            self._condition.wait_for(lambda: self._waiting or self._closed)
            if self._closed:
                return False
            self._busy_with = self._waiting.pop()
            return True

    def _answer_one(self) -> None:
        question = self._busy_with
        try:
            result = self._answer(question)
        except Exception as error:  # noqa: BLE001 - handed to the window, which shows it
            self.over.emit(False, question, error)
        else:
            self.over.emit(True, question, result)


class LatestOnly(QObject):
    """Answers questions in a thread of its own, begun when it is needed; only the newest waits.

    A question that is overtaken while it is being answered is answered all the same. Asking twice
    for the same is asking once.

    Parameters
    ----------
    answer : callable
        From a question to its answer; called in the thread.
    name : str
        Name of the thread.
    """

    answered = Signal(object, object)
    """A question and its answer."""
    failed = Signal(object, object)
    """A question and why it has no answer."""

    def __init__(self, answer: Callable[[Any], Any], name: str) -> None:
        super().__init__()
        self._answer, self._name = answer, name
        self._asked: Hashable | None = None
        self._worker: _Worker | None = None

    def settled(self) -> bool:
        """Whether the newest question is answered."""
        return self._asked is None

    def ask(self, question: Hashable) -> None:
        """Ask; a question that waits is not answered any more."""
        if self._worker is None:
            self._worker = _Worker(self._answer, self._name)
            self._worker.over.connect(self._tell, Qt.ConnectionType.QueuedConnection)
        self._asked = question
        self._worker.ask(question)

    def close(self) -> None:
        """Forget what was asked, and end the thread; returns at once. The next question begins
        another one.
        """
        self._asked = None
        if self._worker is not None:
            self._worker.close()
            self._worker = None

    @Slot(bool, object, object)
    def _tell(self, well: bool, question: Hashable, what: object) -> None:
        if self._worker is None or self.sender() is not self._worker:
            return  # it was closed when the answer was on its way
        if question == self._asked:
            self._asked = None
        (self.answered if well else self.failed).emit(question, what)


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
        self._question = question
        self._asked: Question | None = None
        self._known: A | None = None
        self._worker = LatestOnly(answer, name)
        self._worker.answered.connect(self._on_answered)
        self._worker.failed.connect(self._on_failed)

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
        self._worker.ask(self._asked)

    def close(self) -> None:
        """Forget everything, also what is still to be answered; the next question begins anew."""
        self._asked = self._known = None
        self._worker.close()

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
