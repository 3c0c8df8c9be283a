"""Trials are tracked in a process; clouds are made there ahead, while nobody needs it."""

import logging
from collections.abc import Callable
from typing import Any

from stereotrack_core.tracking.tuning.process import MakeClouds, TrackTrial, TrialBegun, TrialFrame
from stereotrack_core.tracking.tuning.trial import Trial

from ...services.tasks.task import Task, TaskList
from ...session.runs import RunEntry
from ...session.session import Session
from ...widgets.redraw import later

_PAUSE_MS = 400


class TrialRunner:
    """Has trials tracked in the process.

    `wanted`: the next trial, or None if no clouds are to be made ahead.
    """

    def __init__(
        self, session: Session, tasks: TaskList, wanted: Callable[[], Trial | None]
    ) -> None:
        self._session, self._tasks, self._wanted = session, tasks, wanted
        self._ahead: Task | None = None
        self._pause = later(session, self._begin, _PAUSE_MS)

    def track(
        self,
        title: str,
        entry: RunEntry,
        trial: Trial,
        grown: Callable[[RunEntry, list[int]], object],
        ended: Callable[[RunEntry], object],
    ) -> Task:
        """Have a trial tracked, when the one before has ended; its entry gets the frames.

        `grown` is told the numbers of the frames that have come, some of them again, and `ended`
        that nothing more comes; neither is called once the task is cancelled.
        """
        self.cancel()
        kept = self._session.kept
        assert kept is not None  # noqa: S101 - there are no trials without
        todo, process = TrackTrial(kept, trial), self._session.processes.trials
        task = self._tasks.begin(title, lambda task: process(todo, task.tell, task.token.cancelled))

        def take(words: list[Any]) -> None:
            if task.token.cancelled():
                return
            for begun in (word for word in words if isinstance(word, TrialBegun)):
                entry.body, entry.origin = begun.body, begun.origin
            frames = [word for word in words if isinstance(word, TrialFrame)]
            for word in frames:
                entry.wall_seconds = word.seconds
                entry.frames[word.frame.frame] = word.frame
            if frames:
                task.report(len(entry.frames) / len(entry.wanted))
                grown(entry, [word.frame.frame for word in frames])

        task.told.connect(take)
        task.ended.connect(lambda: None if task.token.cancelled() else ended(entry))
        return task

    def make_clouds_soon(self) -> None:
        self.cancel()
        self._pause.start()

    def cancel(self) -> None:
        """Make no more clouds; what is made is kept."""
        self._pause.stop()
        if self._ahead is not None:
            self._ahead.cancel()
            self._ahead = None

    def _begin(self) -> None:
        trial, kept = self._wanted(), self._session.kept
        if trial is None or kept is None:
            return
        todo, process = MakeClouds(kept, trial), self._session.processes.trials
        self._ahead = Task("clouds", lambda task: process(todo, task.tell, task.token.cancelled))
        self._ahead.failed.connect(_on_failed)
        self._ahead.start()


def _on_failed(error: Exception) -> None:
    """Log the error; a trial of the same stretch shows it to the person."""
    logging.getLogger(__name__).error("clouds could not be precomputed", exc_info=error)
