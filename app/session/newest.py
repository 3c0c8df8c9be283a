"""Questions of which only the newest is answered."""

from collections.abc import Callable, Hashable
from functools import partial
from typing import Any, Generic, Protocol, TypeVar

from .jobs import Job, NewestJob, TaskList


class LatestOnly:
    """Answers questions in the background, one at a time; of those that wait only the newest.

    Asking twice for the same is asking once.

    `answer` leads from a question to its answer, in another thread, which has the `name`;
    `answered` and `failed` are called in this thread with a question and its answer or error.
    Those of a question that was overtaken while it was being answered are dropped, unless they
    are welcome all the same.
    """

    def __init__(
        self,
        tasks: TaskList,
        answer: Callable[[Any], Any],
        name: str,
        answered: Callable[[Any, Any], object],
        failed: Callable[[Any, Exception], object] | None = None,
        *,
        late_is_welcome: bool = False,
    ) -> None:
        self._late_is_welcome = late_is_welcome
        self._answer, self._name, self._answered = answer, name, answered
        self._failed = failed or (lambda _question, error: tasks.failed(error))
        self._asked: Hashable | None = None
        self._job = NewestJob(tasks, quiet=True)

    def settled(self) -> bool:
        """Whether the newest question is answered."""
        return self._asked is None

    def ask(self, question: Hashable) -> None:
        """Ask; a question that waits is not answered any more."""
        self._asked = question
        if not self._job.busy:
            self._begin(question)

    def close(self) -> None:
        """Forget what was asked, and what is being answered; returns at once."""
        self._asked = None
        self._job.give_up()

    def _begin(self, question: Hashable) -> None:
        answer, take = self._answer, partial(self._take, question)
        done, failed = partial(take, self._answered), partial(take, self._failed)
        stopped = partial(take, lambda *_: None, None)
        self._job.run(Job(self._name, lambda _task: answer(question), done, failed, stopped))

    def _take(self, question: Hashable, tell: Callable[..., object], found: Any) -> None:
        overtaken = question != self._asked
        if overtaken:
            self._begin(self._asked)
        else:
            self._asked = None
        if not overtaken or self._late_is_welcome:
            tell(question, found)


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
    :class:`LatestOnly`; `changed` is called when another answer holds, or none. Errors are shown.
    """

    def __init__(
        self,
        tasks: TaskList,
        question: Callable[[], Any],
        answer: Callable[[Any], A],
        name: str,
        changed: Callable[[], object],
    ) -> None:
        self._question, self._changed, self._tell = question, changed, tasks.failed
        self._asked: Any = None
        self._known: A | None = None
        answers = self._on_answered, self._on_failed
        self._worker = LatestOnly(tasks, answer, name, *answers, late_is_welcome=True)

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
