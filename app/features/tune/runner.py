"""Trials are tracked in tasks, one after the other; clouds are made while nobody needs them."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Sequence

from PySide6.QtCore import QObject, QTimer, Signal, Slot

from stereotrack_core.body.model import BodyModel
from stereotrack_core.errors import Cancelled
from stereotrack_core.tracking.frame import Origin, TrackedFrame
from stereotrack_core.tracking.tuning.clouds import CloudStore
from stereotrack_core.tracking.tuning.trial import Trial

from ...services.tasks.newest import NewestWins
from ...services.tasks.shared import Shared
from ...services.tasks.task import Task, TaskList
from ...session.runs import RunEntry

_PAUSE_MS = 400


class Trials(QObject):
    """Trials that are tracked one after the other; their entries get the frames.

    Parameters
    ----------
    tasks : TaskList
    store : Shared of CloudStore
    turn : Lock
        Held while they are tracked, so that two never use the clouds at once: those that were
        cancelled end first.
    title : str
        What is being done, for the status line.
    tried : sequence of (RunEntry, Trial)
        The entries are changed in the window's thread alone.
    """

    grown = Signal(object)
    """Mapping from the entries that have more to the numbers of these frames."""
    ended = Signal()
    """Nothing more comes; why they failed, if they did, the window has told."""

    def __init__(
        self,
        tasks: TaskList,
        store: Shared[CloudStore],
        turn: threading.Lock,
        title: str,
        tried: Sequence[tuple[RunEntry, Trial]],
    ) -> None:
        super().__init__()
        self._store, self._turn, self._tried = store, turn, tuple(tried)
        self._wanted = True
        self._lock = threading.Lock()
        self._results: list[tuple[RunEntry, TrackedFrame, BodyModel, Origin, float]] = []
        self._task = tasks.begin(title, self._track)
        self._task.progressed.connect(self._take)
        self._task.ended.connect(self._on_ended)

    def cancel(self) -> None:
        """Say that they are no longer wanted: nothing more is told of them. Returns at once."""
        self._wanted = False
        self._task.cancel()

    def _track(self, task: Task) -> None:
        done, count = 0, sum(len(trial.stretch) for _, trial in self._tried)
        with self._turn, self._store.used() as store:
            for place, (entry, trial) in enumerate(self._tried):
                begun = time.perf_counter()
                words = f"{place} of {len(self._tried)} values" if len(self._tried) > 1 else ""
                with trial.begun(store, task.token.cancelled) as pipeline:
                    body, origin = pipeline.body, pipeline.origin()
                    for tracked in pipeline.frames(trial.stretch):
                        seconds, done = time.perf_counter() - begun, done + 1
                        with self._lock:
                            self._results.append((entry, tracked, body, origin, seconds))
                        task.report(done / count, words)

    @Slot(float, str)
    def _take(self, _share: float = 0.0, _words: str = "") -> None:
        with self._lock:
            results, self._results = self._results, []
        if not results or not self._wanted:
            return
        grown: dict[RunEntry, list[int]] = {}
        for entry, tracked, body, origin, seconds in results:
            entry.body, entry.origin, entry.wall_seconds = body, origin, seconds
            entry.frames[tracked.frame] = tracked.without_cloud()
            grown.setdefault(entry, []).append(tracked.frame)
        self.grown.emit(grown)

    @Slot()
    def _on_ended(self) -> None:
        self._take()
        if self._wanted:
            self.ended.emit()


class CloudWarmer(QObject):
    """Makes clouds while nobody else needs them.

    Parameters
    ----------
    store : callable
        The clouds of the open recording; None where nothing gives depth.
    wanted : callable
        What would be tried now; None where nothing is to be made.
    """

    def __init__(
        self,
        store: Callable[[], Shared[CloudStore] | None],
        wanted: Callable[[], Trial | None],
    ) -> None:
        super().__init__()
        self._store, self._wanted = store, wanted
        self._cancelled = threading.Event()
        self._worker: NewestWins | None = None
        self._pause = QTimer(self, singleShot=True, interval=_PAUSE_MS)
        self._pause.timeout.connect(self._begin)

    @Slot()
    def warm_soon(self, _what: object = None) -> None:
        """Make the clouds when nothing has changed for a moment."""
        self.cancel()
        self._pause.start()

    @Slot()
    def cancel(self) -> None:
        """Make no more; what is made is kept."""
        self._pause.stop()
        self._cancelled.set()

    def close(self) -> None:
        """End the thread; waits for nothing."""
        self.cancel()
        if self._worker is not None:
            self._worker.close()
            self._worker = None

    @Slot()
    def _begin(self) -> None:
        trial, store, cancelled = self._wanted(), self._store(), threading.Event()
        if trial is None or store is None:
            return
        self._cancelled = cancelled
        if self._worker is None:
            self._worker = NewestWins(_warm, "clouds")
            self._worker.failed.connect(self._on_failed)
        self._worker.ask((store, trial, cancelled))

    @Slot(object, object)
    def _on_failed(self, _question: object, error: Exception) -> None:
        if not isinstance(error, Cancelled):
            # whoever tries the stretch meets the same, and tells the person
            logging.getLogger(__name__).error("clouds could not be precomputed", exc_info=error)


def _warm(question: tuple[Shared[CloudStore], Trial, threading.Event]) -> None:
    shared, trial, cancelled = question
    with shared.used() as store:
        clouds = store.clouds(trial.key, trial.stretch, cancelled.is_set)
        for frame in trial.stretch:
            clouds.take(frame)
