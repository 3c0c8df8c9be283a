"""Runs with their circumstances; what each view sees is worked out in the background."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from PySide6.QtCore import QObject, Signal, Slot

from stereotrack_core.arrays import FloatArray
from stereotrack_core.evaluation.circumstances import Circumstances, views_that_see
from stereotrack_core.recording.description import Recording

from ..tasks.task import Task, TaskList
from .explaining import Explained, cameras_of, circumstances, poses
from .judgement import Judgement
from .runs import RunEntry


@dataclass(frozen=True, eq=False)
class _Seen:
    """What was worked out, or asked for, about a run as it was judged."""

    entry: RunEntry
    judgement: Judgement
    views: FloatArray | None

    def fits(self, entry: RunEntry, judgement: Judgement) -> bool:
        """Whether it is about this run with so many frames and against the same truth."""
        before = self.judgement
        same_truth = before.truth is judgement.truth
        return self.entry is entry and same_truth and len(before.frame) == len(judgement.frame)


class SightPresenter(QObject):
    """Circumstances by run.

    Signals
    -------
    changed : ()
        It is known for another run what each view sees.
    """

    changed = Signal()

    def __init__(self, tasks: TaskList, growing: Callable[[], object]) -> None:
        super().__init__()
        self._tasks, self._growing = tasks, growing
        self._circumstances: dict[int, tuple[Judgement, Circumstances]] = {}
        self._views: dict[int, _Seen] = {}
        self._task: Task | None = None
        tasks.changed.connect(self._on_tasks)

    def explained(
        self,
        entries: Sequence[RunEntry],
        judgements: Mapping[int, Judgement],
        recording: Recording,
        *,
        with_views: bool,
    ) -> list[Explained]:
        """Runs with what is known about them; asks for what each view sees where that is wanted."""
        result = []
        for entry in entries:
            judgement = judgements.get(id(entry))
            if judgement is None or not len(judgement.frame):
                continue
            known = self._circumstances.get(id(entry))
            if known is None or known[0] is not judgement:
                known = (judgement, circumstances(entry, judgement, recording))
                self._circumstances[id(entry)] = known
            views = self._views.get(id(entry))
            fits = views is not None and views.fits(entry, judgement)
            if with_views and not fits and entry is not self._growing():
                self._ask(entry, judgement, recording)
            seen = views.views if views is not None and fits else None
            result.append(Explained(entry.name, judgement, known[1], seen))
        return result

    def forget(self, entries: Sequence[RunEntry]) -> None:
        """Forget all but these runs."""
        alive = {id(entry) for entry in entries}
        self._circumstances = {k: v for k, v in self._circumstances.items() if k in alive}
        self._views = {k: v for k, v in self._views.items() if k in alive}

    def _ask(self, entry: RunEntry, judgement: Judgement, recording: Recording) -> None:
        if self._task is not None:
            return
        cameras = cameras_of(entry, recording)
        body, frames = entry.body, poses(entry, judgement)
        # a stop is not asked again by itself
        self._views[id(entry)] = _Seen(entry, judgement, None)

        def work(task: Task) -> FloatArray:
            return views_that_see(
                body, frames, cameras,
                on_progress=lambda done: task.report(done / len(frames)),
                cancelled=task.token.cancelled,
            )  # fmt: skip

        def done(views: FloatArray) -> None:
            self._views[id(entry)] = _Seen(entry, judgement, views)

        self._task = self._tasks.begin("working out what each view sees", work, done)

    @Slot()
    def _on_tasks(self) -> None:
        if self._task is not None and self._task not in self._tasks.tasks:
            self._task = None
            self.changed.emit()
