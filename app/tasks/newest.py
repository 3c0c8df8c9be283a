"""A worker that answers the newest question and forgets those that were overtaken."""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable
from typing import Any

from PySide6.QtCore import QObject, Signal


class NewestWins(QObject):
    """Answers questions in a thread of its own; only the newest waiting one is kept.

    Parameters
    ----------
    answer : callable
        From a question to its answer; called in the worker's thread.
    name : str
        Name of the thread.
    """

    answered = Signal(object, object)
    failed = Signal(object, object)

    def __init__(self, answer: Callable[[Any], Any], name: str) -> None:
        super().__init__()
        self._answer = answer
        self._condition = threading.Condition()
        self._waiting: list[Hashable] = []
        self._busy_with: Hashable | None = None
        self._closed = False
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def ask(self, question: Hashable) -> None:
        """Ask; overtakes a question that waits. Asking twice for the same is asking once."""
        with self._condition:
            if self._busy_with == question:
                self._waiting = []
                return
            self._waiting = [question]
            self._condition.notify()

    def idle(self) -> bool:
        """Whether nothing is being answered and nothing waits."""
        with self._condition:
            return self._busy_with is None and not self._waiting

    def close(self, seconds: float = 10.0) -> None:
        """Forget what waits and end the thread."""
        with self._condition:
            self._closed = True
            self._waiting = []
            self._condition.notify()
        self._thread.join(seconds)

    def _run(self) -> None:
        while True:
            with self._condition:
                self._busy_with = None
                while not self._waiting and not self._closed:
                    self._condition.wait()
                if self._closed:
                    return
                question = self._busy_with = self._waiting.pop()
            try:
                result = self._answer(question)
            except Exception as error:  # noqa: BLE001 - handed to the window, which shows it
                self._tell(self.failed, question, error)
            else:
                self._tell(self.answered, question, result)

    def _tell(self, signal: Any, question: Hashable, what: object) -> None:
        if not self._closed:
            signal.emit(question, what)
