"""The clouds that attempts share, for the recording that is open."""

from __future__ import annotations

import dataclasses
import logging
from collections.abc import Callable

from PySide6.QtCore import QObject, QTimer, Slot

from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.tracking.tuning.attempt import Attempt, colours
from stereotrack_core.tracking.tuning.clouds import CloudStore

from ...services.tasks.shared import Shared
from ...session.clouds import CloudPresenter
from ...session.document import DocumentPresenter
from .runner import Request, TrialRunner


class StoreKeeper:
    """Makes the store of the open recording when it is first asked for."""

    def __init__(self, document: DocumentPresenter, clouds: CloudPresenter) -> None:
        self._document, self._clouds = document, clouds
        self._store: Shared[CloudStore] | None = None
        self._of: Recording | None = None

    def store(self) -> Shared[CloudStore] | None:
        """Clouds of the open recording; None where nothing gives depth."""
        recording, reader = self._document.recording, self._clouds.reader
        if recording is None or reader is None:
            return None
        if self._store is None or self._of is not recording:
            self.close()
            self._store, self._of = _store_of(recording, reader), recording
        return self._store

    def close(self) -> None:
        """Forget all clouds; who still uses them forgets them in the end."""
        if self._store is not None:
            self._store.close()
        self._store = self._of = None


def _store_of(recording: Recording, reader: Shared[FrameReader]) -> Shared[CloudStore]:
    # the tracker never sees the truth
    store = CloudStore(dataclasses.replace(recording, reference=None), reader.enter())

    def close() -> None:
        store.close()
        reader.leave()

    return Shared(store, close)


_PAUSE_MS = 400


class WarmUp(Request):
    """The clouds of an attempt, without the attempt."""

    def __init__(self, attempt: Attempt, store: Shared[CloudStore]) -> None:
        super().__init__(store)
        self._attempt = attempt

    def work(self, store: CloudStore, advanced: Callable[[], None]) -> None:  # noqa: ARG002 - none
        """Make them; see :meth:`Request.work`."""
        attempt, cancelled = self._attempt, self._cancelled.is_set
        key = attempt.key(colour=colours(attempt, store))
        clouds = store.clouds(key, attempt.stretch, cancelled)
        for frame in attempt.stretch:
            clouds.take(frame)


class CloudWarmer(QObject):
    """Makes clouds while nobody else needs them: whatever is tried takes their place.

    Parameters
    ----------
    runner : TrialRunner
    stores : StoreKeeper
    wanted : callable
        What would be tried now; None where nothing is to be made.
    """

    def __init__(
        self, runner: TrialRunner, stores: StoreKeeper, wanted: Callable[[], Attempt | None]
    ) -> None:
        super().__init__()
        self._runner, self._stores, self._wanted = runner, stores, wanted
        self._request: WarmUp | None = None
        self._pause = QTimer(self, singleShot=True, interval=_PAUSE_MS)
        self._pause.timeout.connect(self._begin)
        runner.ended.connect(self._on_ended)

    @Slot()
    def warm_soon(self, _what: object = None) -> None:
        """Make the clouds when nothing has changed for a moment."""
        self.cancel()
        self._pause.start()

    def cancel(self) -> None:
        """Make no more; what is made is kept."""
        self._pause.stop()
        request, self._request = self._request, None
        if request is not None:
            self._runner.cancel(request)

    @Slot()
    def _begin(self) -> None:
        attempt, store = self._wanted(), self._stores.store()
        if attempt is not None and store is not None:
            self._request = WarmUp(attempt, store)
            self._runner.begin(self._request)

    @Slot(object, object)
    def _on_ended(self, request: Request, error: Exception | None) -> None:
        if request is self._request:
            self._request = None
            if error is not None:  # whoever tries the stretch meets the same, and tells the person
                logging.getLogger(__name__).error("clouds could not be precomputed", exc_info=error)
