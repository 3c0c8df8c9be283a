"""Tracks attempts one after the other in a thread of its own."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from PySide6.QtCore import QObject, Signal

from stereotrack_core.body.model import BodyModel
from stereotrack_core.errors import Cancelled
from stereotrack_core.tracking.frame import Origin, TrackedFrame
from stereotrack_core.tracking.tuning.attempt import Attempt, AttemptPipeline
from stereotrack_core.tracking.tuning.clouds import CloudStore


@dataclass(eq=False)
class Progress:
    """How far one attempt is; written by the worker's thread, read by the window's.

    Attributes
    ----------
    attempt : Attempt
    body : BodyModel or None
        Known when the attempt has begun.
    origin : Origin or None
    seconds : float
        Time that it has taken so far.
    ended : bool
        Whether all its frames are there.
    """

    attempt: Attempt
    body: BodyModel | None = None
    origin: Origin | None = None
    seconds: float = 0.0
    ended: bool = False


class AttemptWorker(QObject):
    """Tracks attempts; may be told at any time that they are no longer wanted.

    Results wait until :meth:`taken` fetches them.

    Parameters
    ----------
    attempts : sequence of Attempt
    store : CloudStore
    after : AttemptWorker, optional
        A worker that was cancelled, and whose end has to be waited for.

    Signals
    -------
    advanced : ()
        There are results that nobody has been told of.
    ended : ()
        No more results come.
    """

    advanced = Signal()
    ended = Signal()

    def __init__(
        self, attempts: Sequence[Attempt], store: CloudStore, after: AttemptWorker | None = None
    ) -> None:
        super().__init__()
        self.progress = tuple(Progress(attempt) for attempt in attempts)
        self.error: Exception | None = None
        self.done = False
        self._store, self._after = store, after
        self._cancelled = threading.Event()
        self._lock = threading.Lock()
        self._results: list[tuple[int, TrackedFrame]] = []
        self._thread = threading.Thread(target=self._run, name="attempt", daemon=True)

    def start(self) -> None:
        """Begin; to be called once whoever wants to be told is connected."""
        self._thread.start()

    def cancel(self) -> None:
        """Say that the attempts are no longer wanted; returns at once."""
        self._cancelled.set()

    @property
    def wanted(self) -> bool:
        """Whether nobody has cancelled it."""
        return not self._cancelled.is_set()

    def join(self, seconds: float = 15.0) -> None:
        """Wait for the end of the thread."""
        self._thread.join(seconds)

    def wait(self, seconds: float) -> bool:
        """Wait a while; whether the thread has ended by then."""
        self._thread.join(seconds)
        return not self._thread.is_alive()

    def taken(self) -> list[tuple[int, TrackedFrame]]:
        """Frames since the last call, each with the number of its attempt."""
        with self._lock:
            results, self._results = self._results, []
        return results

    def _run(self) -> None:
        after, self._after = self._after, None
        if after is not None:
            after.join()
        try:
            for place, progress in enumerate(self.progress):
                self._follow(place, progress)
        except Cancelled:
            pass  # whoever has cancelled it knows
        except Exception as error:  # noqa: BLE001 - handed to the window, which shows it
            self.error = error
        finally:
            self.done = True
            self.ended.emit()

    def _follow(self, place: int, progress: Progress) -> None:
        begun = time.perf_counter()
        cancelled: Callable[[], bool] = self._cancelled.is_set
        pipeline = AttemptPipeline(progress.attempt, self._store, cancelled)
        with pipeline:
            pipeline.prepare(progress.attempt.stretch)
            progress.body, progress.origin = pipeline.plain_body, pipeline.origin()
            for tracked in pipeline.tracked():
                progress.seconds = time.perf_counter() - begun
                self._put(place, tracked)
        progress.ended = True

    def _put(self, place: int, tracked: TrackedFrame) -> None:
        with self._lock:
            first = not self._results
            self._results.append((place, tracked))
        if first:
            self.advanced.emit()
