"""Corrects what a recording check has found, in a process of its own, if a person wants it."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject, Slot

from stereotrack_core.doctor.correcting import Corrected, correct_elsewhere, intended
from stereotrack_core.errors import Finding
from stereotrack_core.task_process import TaskProcess

from ...context import Context
from ...services.tasks.task import Task
from ...widgets.forms.message import Message

_SURE = (
    "It is tested first. The file is only changed if the problem is gone then, and the one before "
    "is kept beside it."
)


class CorrectionMaker(QObject):
    """Says what would be changed, changes it on request, and opens the recording again."""

    def __init__(self, context: Context) -> None:
        super().__init__(context.session)
        self._context, self._document = context, context.session.document
        self._process = TaskProcess()
        self._task: Task | None = None
        self._asked: Message | None = None
        self._done: Message | None = None
        self._document.findings_changed.connect(self._tell)
        context.session.closed.connect(self.stop)
        context.session.opened.connect(self.stop)
        context.session.closing.connect(self._process.close)

    @property
    def running(self) -> bool:
        """Whether a correction is under way."""
        return self._task is not None

    @Slot(object)
    def ask(self, finding: Finding) -> None:
        """Say what the correction of a finding would change, and offer to do it."""
        recording, notifier = self._document.recording, self._context.notifier
        if recording is None or finding.correction is None:
            return
        correction, folder = finding.correction, recording.folder

        def show() -> None:
            if self._asked is not None:
                notifier.take_back(self._asked)
            reason = self.why_not()
            self._asked = Message(
                "warning" if reason else "note",
                reason or intended(folder, correction),
                "" if reason else finding.where,
                "" if reason else _SURE,
                "" if reason else "Correct",
                partial(self.start, folder, finding),
            )
            notifier.show(self._asked)

        notifier.attempt(show)

    def why_not(self) -> str:
        """Why nothing can be corrected now, as a sentence; empty where it can."""
        if self.running:
            return "Another correction is under way."
        if self._document.corrections is not None:
            return (
                "The recording is shown with the corrections of its project, so that it is not "
                "known whether its files are wrong. Check the recording without the project."
            )
        return ""

    def start(self, folder: Path, finding: Finding) -> None:
        """Test the correction and make it."""
        recording = self._document.recording
        if recording is None or recording.folder != folder or self.why_not():
            return
        task = Task("testing a correction", partial(_corrected, self._process, folder, finding))
        task.finished.connect(self._on_finished)
        task.failed.connect(self._context.notifier.error)
        task.ended.connect(self._on_ended)
        self._task = task
        self._context.tasks.start(task)

    @Slot()
    def stop(self) -> None:
        """Stop it where it is under way; then nothing is changed."""
        if self._task is not None:
            self._task.cancel()

    @Slot(object)
    def _on_finished(self, done: Corrected | None) -> None:
        recording = self._document.recording
        if done is None or recording is None or done.file.parent != recording.folder:
            return
        self._done = Message(
            "note",
            f"{done.file.name} was corrected",
            remedy=f"{done.words} The file before is {done.kept.name}.",
        )
        frame, workspace = self._document.frame, self._context.docks.workspace or None
        self._context.session.opening.open(recording.folder, frame=frame, workspace=workspace)

    @Slot()
    def _tell(self) -> None:
        """Say what was corrected; opening the recording takes older messages away."""
        if self._done is not None and self._document.findings is not None:
            self._context.notifier.show(self._done)
            self._done = None

    @Slot()
    def _on_ended(self) -> None:
        if self._task is self.sender():
            self._task = None


def _corrected(
    process: TaskProcess, folder: Path, finding: Finding, task: Task
) -> Corrected | None:
    """What was corrected, by another process; None where it was stopped."""
    work = partial(correct_elsewhere, folder, finding)
    hear = partial(task.report, 0.0)
    done: Corrected | None = process(work, hear, task.token.cancelled, listens=False)
    return done
