"""Whether disparities that a person has changed still reach the person; worked out beside it."""

from __future__ import annotations

from PySide6.QtCore import QObject, QTimer, Signal, Slot

from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.reach import is_changed
from stereotrack_core.doctor.before_tracking import changed_reach
from stereotrack_core.errors import Finding
from stereotrack_core.recording.description import Recording

from ...context import Context
from ...services.tasks.newest import LatestOnly

_PAUSE_MS = 400


class ReachCheck(QObject):
    """Follows the open recording and the parameters that it is tracked with."""

    changed = Signal()
    """Something else is found."""

    def __init__(self, context: Context) -> None:
        super().__init__(context.session)
        self._session, self._notifier = context.session, context.notifier
        self.findings: tuple[Finding, ...] = ()
        self._worker = LatestOnly(_answer, "compare disparities")
        self._worker.answered.connect(self._on_answered)
        self._worker.failed.connect(self._on_failed)
        self._pause = QTimer(self, singleShot=True, interval=_PAUSE_MS)
        self._pause.timeout.connect(self._ask)
        session = context.session
        for signal in (session.opened, session.closed, session.track.settings_changed):
            signal.connect(self._pause.start)
        session.closing.connect(self._on_closing)

    @Slot()
    def _ask(self) -> None:
        recording, depth = self._session.document.recording, self._session.track.settings.depth
        if recording is None or not is_changed(depth):
            self._take(())
        else:
            self._worker.ask((recording, depth))

    @Slot(object, object)
    def _on_answered(
        self, question: tuple[Recording, DepthParameters], found: tuple[Finding, ...]
    ) -> None:
        recording, depth = question
        known = self._session.document.recording, self._session.track.settings.depth
        if recording is known[0] and depth == known[1]:
            self._take(found)

    @Slot(object, object)
    def _on_failed(self, _question: object, error: Exception) -> None:
        self._notifier.error(error)

    def _take(self, found: tuple[Finding, ...]) -> None:
        if found != self.findings:
            self.findings = found
            self.changed.emit()

    @Slot()
    def _on_closing(self) -> None:
        self._pause.stop()
        self._worker.close()


def _answer(question: tuple[Recording, DepthParameters]) -> tuple[Finding, ...]:
    recording, depth = question
    return changed_reach(recording, None, depth)
