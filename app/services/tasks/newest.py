"""Questions of which only the newest is answered, and what several threads share meanwhile."""

import threading
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any, Generic, Protocol, TypeVar

from stereotrack_core.errors import Cancelled

from .task import CancelToken, Task


class LatestOnly:
    """Answers questions in the background, one at a time; of those that wait only the newest.

    A question that is overtaken while it is being answered is answered all the same. Asking twice
    for the same is asking once.

    `answer` leads from a question to its answer, in another thread, which has the `name`;
    `answered` and `failed` are called in this thread with a question and its answer or error.
    """

    def __init__(
        self,
        answer: Callable[[Any], Any],
        name: str,
        answered: Callable[[Any, Any], object],
        failed: Callable[[Any, Exception], object],
    ) -> None:
        self._answer, self._name = answer, name
        self._answered, self._failed = answered, failed
        self._asked: Hashable | None = None
        self._task: Task | None = None

    def settled(self) -> bool:
        """Whether the newest question is answered."""
        return self._asked is None

    def ask(self, question: Hashable) -> None:
        """Ask; a question that waits is not answered any more."""
        self._asked = question
        if self._task is None:
            self._begin(question)

    def close(self) -> None:
        """Forget what was asked, and what is being answered; returns at once."""
        self._asked = self._task = None

    def _begin(self, question: Hashable) -> None:
        answer = self._answer
        task = self._task = Task(self._name, lambda _task: answer(question))
        task.ended.connect(partial(self._on_ended, task.token, question))
        task.start()

    def _on_ended(self, token: CancelToken, question: Hashable) -> None:
        task = self._task
        if task is None or task.token is not token:
            return  # it was closed meanwhile
        self._task = None
        if question == self._asked:
            self._asked = None
        else:
            self._begin(self._asked)
        if task.error is None:
            self._answered(question, task.result)
        else:
            self._failed(question, task.error)


class Answer(Protocol):
    """Answer to a question: facts of one ``frame``, compared by identity."""

    @property
    def question(self) -> Any:
        """The question that it answers."""


A = TypeVar("A", bound=Answer)


class NewestAnswer(Generic[A]):
    """Asks in a thread of its own; the newest question wins.

    Until the new answer is there, the one before of the same frame holds, so that nothing flickers.
    `question` says what is to be asked now, or None; `answer` and `name` are those of
    :class:`LatestOnly`; `changed` is called when another answer holds, or none, and `failed` with
    the error.
    """

    def __init__(
        self,
        question: Callable[[], Any],
        answer: Callable[[Any], A],
        name: str,
        changed: Callable[[], object],
        failed: Callable[[Exception], object],
    ) -> None:
        self._question, self._changed, self._tell = question, changed, failed
        self._asked: Any = None
        self._known: A | None = None
        self._worker = LatestOnly(answer, name, self._on_answered, self._on_failed)

    def at(self, frame: int) -> A | None:
        """The answer about a frame, be it to the question before the newest; None without one."""
        known = self._known
        return known if known is not None and known.question.frame == frame else None

    def settled(self) -> bool:
        """Whether what holds answers the newest question."""
        asked = self._asked
        return asked is None or (self._known is not None and self._known.question is asked)

    def ask(self) -> None:
        self._asked = self._question()
        if self._asked is not None:
            self._worker.ask(self._asked)
        elif self._known is not None:
            self._known = None
            self._changed()

    def close(self) -> None:
        """Forget everything, also what is still to be answered; the next question begins anew."""
        self._asked = self._known = None
        self._worker.close()

    def _on_answered(self, question: Any, answer: A) -> None:
        if self._asked is not None and question.frame == self._asked.frame:
            self._known = answer
            self._changed()

    def _on_failed(self, question: Any, error: Exception) -> None:
        if question is self._asked:
            self._asked = self._known = None
            self._changed()
        self._tell(error)


R = TypeVar("R")


class Shared(Generic[R]):
    """A resource with an owner, and users in other threads.

    The owner closes it without waiting: where somebody still uses it, the last user closes it when
    leaving; `close` is called once, in whichever thread is the last. Only the owner, who knows
    whether it is closed, looks at the `resource` itself.
    """

    def __init__(self, resource: R, close: Callable[[], object]) -> None:
        self.resource = resource
        self._close = close
        self._lock = threading.Lock()
        self._users = 0
        self._unwanted = False

    @property
    def wanted(self) -> bool:
        return not self._unwanted

    @contextmanager
    def used(self) -> Iterator[R]:
        """The resource, which stays open meanwhile; Cancelled if its owner has closed it."""
        resource = self.enter()
        try:
            yield resource
        finally:
            self.leave()

    def enter(self) -> R:
        with self._lock:
            if self._unwanted:
                raise Cancelled
            self._users += 1
        return self.resource

    def leave(self) -> None:
        """No longer use it; once for every :meth:`enter`."""
        with self._lock:
            self._users -= 1
            last = self._unwanted and not self._users
        if last:
            self._close()

    def close(self) -> None:
        """Let nobody else begin to use it, and have it closed; a second time does nothing."""
        with self._lock:
            last = not self._unwanted and not self._users
            self._unwanted = True
        if last:
            self._close()
