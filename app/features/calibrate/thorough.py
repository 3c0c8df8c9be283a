"""Checks of the open recording that measure its images, in a process of their own."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import QObject, Slot

from stereotrack_core.doctor.diagnose import diagnose_elsewhere
from stereotrack_core.errors import Finding
from stereotrack_core.recording.description import Recording
from stereotrack_core.task_process import TaskProcess

from ...context import Context
from ...services.tasks.task import Task


class ThoroughCheck(QObject):
    """Asks the images when a person wants it; what it finds joins the recording's findings."""

    def __init__(self, context: Context) -> None:
        super().__init__(context.session)
        self._context, self._document = context, context.session.document
        self._process = TaskProcess()
        self._task: Task | None = None
        context.session.closed.connect(self.stop)
        context.session.opened.connect(self.stop)
        context.session.closing.connect(self._process.close)

    @property
    def running(self) -> bool:
        """Whether it is under way."""
        return self._task is not None

    def why_not(self) -> str:
        """Why it cannot begin, as a sentence; empty where it can."""
        if self._document.recording is None:
            return self._context.session.no_recording()
        if self._document.recording.guessed:
            return "The cameras are guessed, so their images cannot be compared."
        return "It is under way." if self.running else ""

    def start(self) -> None:
        """Measure pictures, pairs, clocks, views and the reference."""
        recording = self._document.recording
        if recording is None or self.why_not():
            return
        task = Task("checking thoroughly", partial(_measured, self._process, recording))
        task.finished.connect(self._on_finished)
        task.failed.connect(self._context.notifier.error)
        task.ended.connect(self._on_ended)
        self._task = task
        self._context.tasks.start(task)
        self._context.actions.refresh_soon()

    @Slot()
    def stop(self) -> None:
        """Stop it where it is under way."""
        if self._task is not None:
            self._task.cancel()

    @Slot(object)
    def _on_finished(self, result: tuple[Recording, tuple[Finding, ...]]) -> None:
        recording, found = result
        if recording is self._document.recording:
            self._document.take_measured(found)

    @Slot()
    def _on_ended(self) -> None:
        if self._task is self.sender():
            self._task = None
            self._context.actions.refresh_soon()


def _measured(
    process: TaskProcess, recording: Recording, task: Task
) -> tuple[Recording, tuple[Finding, ...]]:
    """What the images say, from another process."""
    work = partial(diagnose_elsewhere, recording)
    hear = partial(task.report, 0.0)
    found: tuple[Finding, ...] | None = process(work, hear, task.token.cancelled, listens=False)
    return recording, found or ()
