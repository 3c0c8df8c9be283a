"""A run once more, from all that it says about itself, in the background."""

from __future__ import annotations

import dataclasses
import time
from functools import partial

from PySide6.QtCore import QObject, Signal, Slot

from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.recording.description import Recording
from stereotrack_core.tracking.frame import Run, TrackedFrame
from stereotrack_core.tracking.repeating import StoredSpec, sameness, stored_spec, what_differs
from stereotrack_core.tracking.run import track

from ...services.tasks.task import Task, TaskList
from ...session.runs import RunEntry, entry_of_run
from ...session.session import Session
from ...widgets.forms.message import Message


class RunRepeater(QObject):
    """Repeats a run and says whether it came out equal."""

    message = Signal(object)
    """Message."""

    def __init__(self, session: Session, tasks: TaskList, parent: QObject) -> None:
        super().__init__(parent)
        self._document, self._runs, self._tasks = session.document, session.runs, tasks
        self._task: Task | None = None

    @property
    def busy(self) -> bool:
        """Whether a run is being repeated."""
        return self._task is not None

    def repeat(self, entry: RunEntry) -> None:
        """Track it again, as it was tracked.

        Raises
        ------
        InputError
            Where it does not say how.
        """
        recording, run = self._document.recording, entry.run()
        if recording is None or run is None or self.busy:
            return
        stored = stored_spec(run)
        if not stored.states_first_pose:
            raise InputError(
                "the run does not state its initial pose",
                where=entry.name,
                remedy="Runs made with this version state it. Track again.",
            )
        self._task = self._tasks.begin(
            f"reproducing {entry.name}",
            lambda task: _repeated(task, run, stored, recording),
            partial(self._on_done, entry, run),
        )
        self._task.ended.connect(self._on_ended)

    def _on_done(self, first: RunEntry, run: Run, found: tuple[Run, tuple[str, ...]]) -> None:
        recording, (again, differs) = self._document.recording, found
        if recording is None or first not in self._runs.entries:
            return
        entry = entry_of_run(again, recording.folder)
        entry.name, entry.path = f"{first.name} again", None
        self._runs.add(entry, active=False)
        same = sameness(run, again)
        severity, why = ("note", "") if same.equal else ("warning", " ".join(differs))
        self.message.emit(Message(severity, same.words.rstrip("."), entry.name, why))

    @Slot()
    def _on_ended(self) -> None:
        self._task = None


def _repeated(
    task: Task, run: Run, stored: StoredSpec, recording: Recording
) -> tuple[Run, tuple[str, ...]]:
    """The run once more, and why it may have come out otherwise."""
    detections, otherwise = stored.detections_in(recording)
    differs = (*what_differs(run, recording), *([otherwise] if otherwise else []))
    begun, done = time.perf_counter(), 0

    def note(_frame: TrackedFrame) -> None:
        nonlocal done
        done += 1
        task.report(done / stored.count, f"frame {done} of {stored.count}")

    again = track(
        stored.applied_to(recording),
        dataclasses.replace(stored.spec, detections=detections),
        on_frame=note,
        cancelled=lambda: task.token.cancelled() or done == stored.count,
    )
    if task.token.cancelled():
        raise Cancelled
    meta = {**again.meta, "wall_seconds": time.perf_counter() - begun}
    return dataclasses.replace(again, meta=meta), differs
