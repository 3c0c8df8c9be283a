"""Runs with their circumstances; what each view sees is worked out in the background."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from weakref import WeakKeyDictionary

from PySide6.QtCore import QObject, Signal, Slot

from stereotrack_core.arrays import FloatArray
from stereotrack_core.evaluation.circumstances import Circumstances, views_that_see
from stereotrack_core.recording.description import Recording

from ...services.tasks.task import Task, TaskList
from ...session.judgement import Judgement
from ...session.runs import RunEntry
from .explaining import Explained, cameras_of, circumstances, poses


@dataclass(frozen=True, eq=False)
class _Seen:
    """What was worked out, or asked for, about a run as it was judged."""

    judgement: Judgement
    views: FloatArray | None

    def fits(self, judgement: Judgement) -> bool:
        """Whether it is about the run with so many frames and against the same truth."""
        before = self.judgement
        return before.truth is judgement.truth and len(before.frame) == len(judgement.frame)


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
        self._circumstances: WeakKeyDictionary[RunEntry, tuple[Judgement, Circumstances]]
        self._circumstances = WeakKeyDictionary()
        self._views: WeakKeyDictionary[RunEntry, _Seen] = WeakKeyDictionary()
        self._task: Task | None = None
        tasks.changed.connect(self._on_tasks)

    def explained(
        self,
        entries: Sequence[RunEntry],
        judgements: Mapping[RunEntry, Judgement],
        recording: Recording,
        *,
        with_views: bool,
    ) -> list[Explained]:
        """Runs with what is known about them; asks for what each view sees where that is wanted."""
        result = []
        for entry in entries:
            judgement = judgements.get(entry)
            if judgement is None or not len(judgement.frame):
                continue
            known = self._circumstances.get(entry)
            if known is None or known[0] is not judgement:
                known = (judgement, circumstances(entry, judgement, recording))
                self._circumstances[entry] = known
            views = self._views.get(entry)
            fits = views is not None and views.fits(judgement)
            if with_views and not fits and entry is not self._growing():
                self._ask(entry, judgement, recording)
            seen = views.views if views is not None and fits else None
            result.append(Explained(entry.name, judgement, known[1], seen))
        return result

    def _ask(self, entry: RunEntry, judgement: Judgement, recording: Recording) -> None:
        if self._task is not None:
            return
        cameras = cameras_of(entry, recording)
        body, frames = entry.body, poses(entry, judgement)
        # a stop is not asked again by itself
        self._views[entry] = _Seen(judgement, None)

        def work(task: Task) -> FloatArray:
            return views_that_see(
                body, frames, cameras,
                on_progress=lambda done: task.report(done / len(frames)),
                cancelled=task.token.cancelled,
            )  # fmt: skip

        def done(views: FloatArray) -> None:
            self._views[entry] = _Seen(judgement, views)

        self._task = self._tasks.begin("computing visibility", work, done)

    @Slot()
    def _on_tasks(self) -> None:
        if self._task is not None and self._task not in self._tasks.tasks:
            self._task = None
            self.changed.emit()
