"""What is computed from the clouds of attempts: one thing at a time, the newest that was wanted."""

from __future__ import annotations

import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from PySide6.QtCore import QObject, Qt, Signal, Slot

from stereotrack_core.body.model import BodyModel
from stereotrack_core.errors import Cancelled
from stereotrack_core.tracking.frame import Origin, TrackedFrame
from stereotrack_core.tracking.tuning.attempt import Attempt, AttemptPipeline
from stereotrack_core.tracking.tuning.clouds import CloudStore

from ...services.tasks.newest import NewestWins
from ...services.tasks.shared import Shared


class Request(ABC):
    """Something to be computed from a store of clouds; may be cancelled from any thread.

    Parameters
    ----------
    store : Shared of CloudStore

    Attributes
    ----------
    over : Event
        Set when nothing more comes of it.
    """

    def __init__(self, store: Shared[CloudStore]) -> None:
        self.store = store
        self.over = threading.Event()
        self._cancelled = threading.Event()

    @property
    def wanted(self) -> bool:
        """Whether nobody has cancelled it."""
        return not self._cancelled.is_set()

    def cancel(self) -> None:
        """Say that it is no longer wanted; returns at once."""
        self._cancelled.set()

    @abstractmethod
    def work(self, store: CloudStore, advanced: Callable[[], None]) -> None:
        """Compute it, in the runner's thread; `advanced` tells that there is more to be taken.

        Raises
        ------
        Cancelled
            Where it is no longer wanted.
        """


@dataclass(frozen=True, eq=False)
class Result:
    """A frame of an attempt, with what was known of the attempt by then.

    Attributes
    ----------
    place : int
        Number of the attempt within its request.
    tracked : TrackedFrame
    body : BodyModel
    origin : Origin
    seconds : float
        Time that the attempt has taken so far.
    """

    place: int
    tracked: TrackedFrame
    body: BodyModel
    origin: Origin
    seconds: float


class Trials(Request):
    """Attempts that are tracked one after the other; results wait until they are taken."""

    def __init__(self, attempts: Sequence[Attempt], store: Shared[CloudStore]) -> None:
        super().__init__(store)
        self._attempts = tuple(attempts)
        self._lock = threading.Lock()
        self._results: list[Result] = []

    def taken(self) -> list[Result]:
        """Results since the last call."""
        with self._lock:
            results, self._results = self._results, []
        return results

    def work(self, store: CloudStore, advanced: Callable[[], None]) -> None:
        """Track all of them; see :meth:`Request.work`."""
        for place, attempt in enumerate(self._attempts):
            begun = time.perf_counter()
            pipeline = AttemptPipeline(attempt, store, self._cancelled.is_set)
            with pipeline:
                pipeline.prepare(attempt.stretch)
                body, origin = pipeline.plain_body, pipeline.origin()
                for tracked in pipeline.tracked():
                    seconds = time.perf_counter() - begun
                    if self._is_first(Result(place, tracked, body, origin, seconds)):
                        advanced()

    def _is_first(self, result: Result) -> bool:
        """Let a result wait; whether it is the only one that waits."""
        with self._lock:
            self._results.append(result)
            return len(self._results) == 1


class TrialRunner(QObject):
    """Owns the thread in which attempts are tracked and clouds are made beforehand.

    A request that begins takes the place of the one before, which ends as soon as it can; until it
    has ended the new one waits, so that two never use a store's clouds at once. Signals are about
    the request that counts: whatever an older one still delivers is told to nobody.

    Signals
    -------
    advanced : Request
        There is more of it to be taken.
    ended : Request, Exception or None
        Nothing more comes of it; why it failed, if it did.
    overtaken : Request
        Another one has taken its place.
    """

    advanced = Signal(object)
    ended = Signal(object, object)
    overtaken = Signal(object)
    _more = Signal(object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._more.connect(self._on_more, Qt.ConnectionType.QueuedConnection)
        self._current: Request | None = None
        self._worker: NewestWins | None = None

    def begin(self, request: Request) -> None:
        """Compute this instead of what is being computed."""
        before = self._current
        if before is not None:
            self.cancel(before)
            self.overtaken.emit(before)
        self._current = request
        if self._worker is None:
            self._worker = NewestWins(self._compute, "trials")
            self._worker.answered.connect(self._on_answered)
            self._worker.failed.connect(self._on_failed)
        self._worker.ask(request)

    def cancel(self, request: Request) -> None:
        """Forget a request; its store is in use until it has noticed that."""
        request.cancel()
        if request is self._current:
            self._leave(request)

    def close(self) -> None:
        """Forget what is being computed, and end the thread; waits for nothing."""
        if self._current is not None:
            self.cancel(self._current)
        if self._worker is not None:
            self._worker.close()
            self._worker = None

    def _compute(self, request: Request) -> None:
        """Called in the thread."""
        if request.wanted:
            with request.store.used() as store:
                request.work(store, lambda: self._more.emit(request))

    def _leave(self, request: Request) -> None:
        self._current = None
        request.over.set()

    @Slot(object)
    def _on_more(self, request: Request) -> None:
        if request is self._current:
            self.advanced.emit(request)

    @Slot(object, object)
    def _on_answered(self, request: Request, _nothing: None) -> None:
        self._on_failed(request, None)

    @Slot(object, object)
    def _on_failed(self, request: Request, error: Exception | None) -> None:
        if request is self._current:
            self._leave(request)
            self.ended.emit(request, None if isinstance(error, Cancelled) else error)
