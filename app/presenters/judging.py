"""Keeps the judgement of every run, computed when it has grown, a few times a second."""

from __future__ import annotations

from PySide6.QtCore import QObject, QTimer, Signal, Slot

from app.presenters.document import DocumentPresenter
from app.presenters.judgement import Judgement, judged
from app.presenters.runs import RunEntry, RunList

_INTERVAL_MS = 250


class JudgementPresenter(QObject):
    """Judgements by run.

    Signals
    -------
    judged : ()
        Some judgement is new, or a run is shown in another way.
    """

    judged = Signal()

    def __init__(self, document: DocumentPresenter, runs: RunList) -> None:
        super().__init__()
        self._document, self._runs = document, runs
        self._known: dict[int, tuple[int, Judgement]] = {}
        self._timer = QTimer(self, singleShot=True, interval=_INTERVAL_MS)
        self._timer.timeout.connect(self.judge)
        runs.grew.connect(self._on_grew)
        runs.changed.connect(self.judge)
        runs.active_changed.connect(self.judge)

    def of(self, entry: RunEntry | None) -> Judgement | None:
        """Judgement of a run, None where it has no frames yet."""
        known = self._known.get(id(entry))
        return known[1] if known is not None else None

    def all(self) -> dict[int, Judgement]:
        """Judgements by the id of their run."""
        return {key: judgement for key, (_, judgement) in self._known.items()}

    def settled(self) -> bool:
        """Whether every run is judged as it is now."""
        return not self._timer.isActive()

    @Slot()
    def judge(self) -> None:
        """Judge what has grown."""
        self._timer.stop()
        recording = self._document.recording
        reference = recording.reference if recording is not None else None
        alive = {id(entry) for entry in self._runs.entries}
        self._known = {key: value for key, value in self._known.items() if key in alive}
        for entry in self._runs.entries:
            count = len(entry.frames)
            known = self._known.get(id(entry))
            if count and (known is None or known[0] != count):
                self._known[id(entry)] = (count, judged(entry, reference))
        self.judged.emit()

    @Slot()
    def _on_grew(self) -> None:
        if not self._timer.isActive():
            self._timer.start()
