"""What is computed from the clouds of trials: one thing at a time, the newest that was wanted."""

from __future__ import annotations

import logging
import sys
import threading
import time
from collections.abc import Callable, Sequence

from PySide6.QtCore import QObject, Qt, QTimer, Signal, Slot

from stereotrack_core.body.model import BodyModel
from stereotrack_core.errors import Cancelled
from stereotrack_core.tracking.frame import Origin, TrackedFrame
from stereotrack_core.tracking.tuning.clouds import CloudStore
from stereotrack_core.tracking.tuning.trial import Trial

from ...services.tasks.newest import NewestWins
from ...services.tasks.shared import Shared
from ...session.runs import RunEntry

_PAUSE_MS = 400

_TURN_S = 0.0005
"""How long the thread keeps the interpreter from the window, which paints meanwhile."""


class Request:
    """Something to be computed from a store of clouds; may be cancelled from any thread.

    Parameters
    ----------
    work : callable
        Computes it, in the runner's thread.
    ended : callable
        Told in the window's thread that nothing more comes of it, unless it was cancelled; with
        the reason where it failed.

    Attributes
    ----------
    over : Event
        Set when nothing more comes of it.
    cancelled : callable
        Whether somebody has said that it is no longer wanted.
    """

    def __init__(
        self,
        store: Shared[CloudStore],
        work: Callable[[CloudStore, Request], None],
        ended: Callable[[Exception | None], None],
    ) -> None:
        self.store, self.work, self.ended = store, work, ended
        self.over, self._unwanted = threading.Event(), threading.Event()
        self.cancelled = self._unwanted.is_set
        self.advanced: Callable[[], None] = lambda: None
        self.tell_advance: Callable[[], None] = lambda: None

    def cancel(self) -> None:
        """Say that it is no longer wanted; returns at once."""
        self._unwanted.set()


class Trials(Request):
    """Trials that are tracked one after the other; results wait until they are taken.

    Parameters
    ----------
    tried : sequence of (RunEntry, Trial)
        The entries get the frames, in the window's thread.
    store, ended
        See :class:`Request`.
    advanced : callable
        Told in the window's thread that there is more to be taken.
    """

    def __init__(
        self,
        tried: Sequence[tuple[RunEntry, Trial]],
        store: Shared[CloudStore],
        ended: Callable[[Exception | None], None],
        advanced: Callable[[], None],
    ) -> None:
        super().__init__(store, self._track, ended)
        self.advanced = advanced
        self._tried = tuple(tried)
        self._lock = threading.Lock()
        self._results: list[tuple[RunEntry, TrackedFrame, BodyModel, Origin, float]] = []

    def take(self) -> dict[RunEntry, list[int]]:
        """Let the entries have what is new; which have grown, and by which frames."""
        with self._lock:
            results, self._results = self._results, []
        grown: dict[RunEntry, list[int]] = {}
        for entry, tracked, body, origin, seconds in results:
            entry.body, entry.origin, entry.wall_seconds = body, origin, seconds
            entry.frames[tracked.frame] = tracked.without_cloud()
            grown.setdefault(entry, []).append(tracked.frame)
        return grown

    def _track(self, store: CloudStore, _request: Request) -> None:
        for entry, trial in self._tried:
            begun = time.perf_counter()
            with trial.begun(store, self.cancelled) as pipeline:
                body, origin = pipeline.body, pipeline.origin()
                for tracked in pipeline.frames(trial.stretch):
                    seconds = time.perf_counter() - begun
                    with self._lock:
                        self._results.append((entry, tracked, body, origin, seconds))
                        first = len(self._results) == 1
                    if first:
                        self.tell_advance()


class TrialRunner(QObject):
    """Owns the thread in which trials are tracked and clouds are made beforehand.

    A request that begins takes the place of the one before, which ends as soon as it can; until it
    has ended the new one waits, so that two never use a store's clouds at once. Only the request
    that counts is told of: whatever an older one still delivers is told to nobody.
    """

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
            before.ended(None)
        self._current = request
        request.tell_advance = lambda: self._more.emit(request)
        if self._worker is None:
            self._worker = NewestWins(_compute, "trials")
            self._worker.answered.connect(self._on_answered)
            self._worker.failed.connect(self._on_failed)
        self._worker.ask(request)

    def cancel(self, request: Request) -> None:
        """Forget a request; its store is in use until it has noticed that."""
        request.cancel()
        if request is self._current:
            self._current = None
            request.over.set()

    def close(self) -> None:
        """Forget what is being computed, and end the thread; waits for nothing."""
        if self._current is not None:
            self.cancel(self._current)
        if self._worker is not None:
            self._worker.close()
            self._worker = None

    @Slot(object)
    def _on_more(self, request: Request) -> None:
        if request is self._current:
            request.advanced()

    @Slot(object, object)
    def _on_answered(self, request: Request, _nothing: None) -> None:
        self._on_failed(request, None)

    @Slot(object, object)
    def _on_failed(self, request: Request, error: Exception | None) -> None:
        if request is self._current:
            self._current = None
            request.over.set()
            request.ended(None if isinstance(error, Cancelled) else error)


def _compute(request: Request) -> None:
    if request.cancelled():
        return
    usual = sys.getswitchinterval()
    sys.setswitchinterval(_TURN_S)
    try:
        with request.store.used() as store:
            request.work(store, request)
    finally:
        sys.setswitchinterval(usual)


class CloudWarmer(QObject):
    """Makes clouds while nobody else needs them: whatever is tried takes their place.

    Parameters
    ----------
    store : callable
        The clouds of the open recording; None where nothing gives depth.
    wanted : callable
        What would be tried now; None where nothing is to be made.
    """

    def __init__(
        self,
        runner: TrialRunner,
        store: Callable[[], Shared[CloudStore] | None],
        wanted: Callable[[], Trial | None],
    ) -> None:
        super().__init__()
        self._runner, self._store, self._wanted = runner, store, wanted
        self._request: Request | None = None
        self._pause = QTimer(self, singleShot=True, interval=_PAUSE_MS)
        self._pause.timeout.connect(self._begin)

    @Slot()
    def warm_soon(self, _what: object = None) -> None:
        """Make the clouds when nothing has changed for a moment."""
        self.cancel()
        self._pause.start()

    def cancel(self) -> None:
        """Make no more; what is made is kept."""
        self._pause.stop()
        if self._request is not None:
            self._runner.cancel(self._request)
            self._request = None

    @Slot()
    def _begin(self) -> None:
        trial, store = self._wanted(), self._store()
        if trial is None or store is None:
            return

        def make(kept: CloudStore, request: Request) -> None:
            clouds = kept.clouds(trial.key, trial.stretch, request.cancelled)
            for frame in trial.stretch:
                clouds.take(frame)

        self._request = Request(store, make, self._on_ended)
        self._runner.begin(self._request)

    def _on_ended(self, error: Exception | None) -> None:
        self._request = None
        if error is not None:  # whoever tries the stretch meets the same, and tells the person
            logging.getLogger(__name__).error("clouds could not be precomputed", exc_info=error)
