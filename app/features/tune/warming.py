"""Makes the clouds of the stretch before anything is tried, so that the first attempt has them."""

from __future__ import annotations

import logging
from collections.abc import Callable

from PySide6.QtCore import QObject, QTimer, Slot

from stereotrack_core.tracking.tuning.attempt import Attempt, colours
from stereotrack_core.tracking.tuning.clouds import CloudStore

from ...services.tasks.shared import Shared
from .runner import Request, TrialRunner
from .stores import StoreKeeper

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
                logging.getLogger(__name__).error(
                    "clouds could not be made beforehand", exc_info=error
                )
