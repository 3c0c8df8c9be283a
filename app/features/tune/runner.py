"""Trials are tracked in a process; clouds are made there ahead, while nobody needs it."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from PySide6.QtCore import QObject, QTimer, Signal, Slot

from stereotrack_core.tracking.tuning.clouds import Holdings
from stereotrack_core.tracking.tuning.process import (
    KeptRecording,
    MakeClouds,
    TrackTrials,
    TrialBegun,
    TrialFrame,
)
from stereotrack_core.tracking.tuning.trial import Trial

from ...services.tasks.task import Task, TaskList
from ...session.runs import RunEntry
from ...session.session import Session

_PAUSE_MS = 400


class Trials(QObject):
    """Trials that are tracked one after the other; their entries get the frames."""

    grown = Signal(object)
    """Mapping from the entries that have more to the numbers of these frames."""
    ended = Signal()
    """Nothing more comes; why they failed, if they did, the window has told."""

    def __init__(self, tried: Sequence[tuple[RunEntry, Trial]], task: Task) -> None:
        super().__init__()
        self._entries = [entry for entry, _ in tried]
        self._count = sum(len(trial.stretch) for _, trial in tried)
        self._task = task
        self._task.told.connect(self._take)
        self._task.ended.connect(self.ended)

    def cancel(self) -> None:
        """Say that they are no longer wanted: nothing more is told of them. Returns at once."""
        self.blockSignals(True)
        self._task.told.disconnect(self._take)
        self._task.cancel()

    @Slot(list)
    def _take(self, words: list[Any]) -> None:
        grown: dict[RunEntry, list[int]] = {}
        place = 0
        for word in words:
            match word:
                case TrialBegun():
                    entry = self._entries[word.place]
                    entry.body, entry.origin = word.body, word.origin
                case TrialFrame():
                    place, entry = word.place, self._entries[word.place]
                    entry.wall_seconds = word.seconds
                    entry.frames[word.frame.frame] = word.frame
                    grown.setdefault(entry, []).append(word.frame.frame)
        if grown:
            done = sum(len(entry.frames) for entry in self._entries)  # some come again
            several = len(self._entries) > 1
            of = f"{place} of {len(self._entries)} values" if several else ""
            self._task.report(done / self._count, of)
            self.grown.emit(grown)


class TrialRunner(QObject):
    """Has trials tracked in the process, and knows what that keeps for the next ones.

    Attributes
    ----------
    kept : Holdings

    Parameters
    ----------
    wanted : callable
        What would be tried now; None where no clouds are to be made ahead.
    """

    changed = Signal()
    """More is kept than before."""

    def __init__(
        self, session: Session, tasks: TaskList, wanted: Callable[[], Trial | None]
    ) -> None:
        super().__init__()
        self._session, self._tasks, self._wanted = session, tasks, wanted
        self._ahead: Task | None = None
        self._pause = QTimer(self, singleShot=True, interval=_PAUSE_MS)
        self._pause.timeout.connect(self._begin)
        self.kept = Holdings()
        session.opened.connect(self._on_opened)

    @Slot()
    def _on_opened(self) -> None:
        recording = self._session.document.recording
        views = recording.views if recording is not None else ()
        deep = any(view.kind != "mono" for view in views)
        self.kept = Holdings(tuple(view.name for view in views if view.kind == "stereo"), deep)

    def track(self, title: str, tried: Sequence[tuple[RunEntry, Trial]]) -> Trials:
        """Have trials tracked, when those before have ended; their entries get the frames."""
        self.cancel()
        kept = self._session.kept
        assert kept is not None  # noqa: S101 - there are no trials without
        todo = TrackTrials(kept, tuple(trial for _, trial in tried))
        process = self._session.processes.trials
        task = self._tasks.begin(title, lambda task: process(todo, task.tell, task.token.cancelled))
        task.told.connect(partial(self._remember, kept))
        return Trials(tried, task)

    @Slot()
    def make_clouds_soon(self, _what: object = None) -> None:
        """Make the clouds when nothing has changed for a moment."""
        self.cancel()
        self._pause.start()

    def cancel(self) -> None:
        """Make no more clouds; what is made is kept."""
        self._pause.stop()
        if self._ahead is not None:
            self._ahead.cancel()
            self._ahead = None

    @Slot()
    def _begin(self) -> None:
        trial, kept = self._wanted(), self._session.kept
        if trial is None or kept is None:
            return
        todo, process = MakeClouds(kept, trial), self._session.processes.trials
        self._ahead = Task("clouds", lambda task: process(todo, task.tell, task.token.cancelled))
        self._ahead.told.connect(partial(self._remember, kept))
        self._ahead.failed.connect(_on_failed)
        self._ahead.start()

    def _remember(self, of: KeptRecording, words: list[Any]) -> None:
        found = [word for word in words if isinstance(word, Holdings)]
        if found and of is self._session.kept:
            self.kept = found[-1]
            self.changed.emit()


def _on_failed(error: Exception) -> None:
    """Whoever tries the stretch meets the same, and tells the person."""
    logging.getLogger(__name__).error("clouds could not be precomputed", exc_info=error)
