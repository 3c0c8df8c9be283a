"""Checks of the open recording that take time, and corrections of what is found."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.volume import is_changed
from stereotrack_core.doctor.correcting import Corrected, correct_elsewhere, intended
from stereotrack_core.doctor.diagnose import changed_reach, diagnose_elsewhere
from stereotrack_core.errors import Finding
from stereotrack_core.recording.description import Recording
from stereotrack_core.worker_processes import ProcessTask, TaskProcess

from ...context import Context
from ...services.tasks.task import Task
from ...session.changes import RECORDING, Part
from ...widgets.forms.message import Message
from ...widgets.redraw import later

_PAUSE_MS = 400  # after a change of parameters, before disparities are compared
_SURE = (
    "It is tested first. The file is only changed if the problem is gone then, and the one before "
    "is kept beside it."
)


class RecordingChecks:
    """Measures images and makes corrections in another process, one at a time, on request.

    `changed` is called when :attr:`reach` has changed.
    """

    def __init__(self, context: Context, changed: Callable[[], None]) -> None:
        self._changed = changed
        self._context, self._document = context, context.session.document
        self._process = TaskProcess()
        self._task: Task | None = None
        self._asked: Message | None = None
        self._done: Message | None = None
        self.reach: tuple[Finding, ...] = ()
        """Findings about changed disparities that do not reach the person."""
        self._pause = later(context.session, self._compare_disparities, _PAUSE_MS)
        watch = context.session.changes.watch
        watch(Part.FINDINGS, self._tell)
        watch(RECORDING | Part.SETTINGS, self._pause.start)
        watch(Part.RECORDING_CLOSED, self.stop)
        watch(Part.WINDOW_CLOSING, self._pause.stop)
        watch(Part.WINDOW_CLOSING, self._process.close)

    @property
    def running(self) -> bool:
        return self._task in self._context.tasks.tasks

    def why_not_measure(self) -> str:
        if self._document.recording is None:
            return self._context.session.no_recording()
        if self._document.recording.guessed:
            return "The cameras are guessed, so their images cannot be compared."
        return "It is under way." if self.running else ""

    def measure(self) -> None:
        recording = self._document.recording
        if recording is None or self.why_not_measure():
            return

        def done(found: tuple[Finding, ...]) -> None:
            if recording is self._document.recording:
                self._document.take_measured(found)

        self._begin("checking thoroughly", partial(diagnose_elsewhere, recording), done)

    def ask(self, finding: Finding) -> None:
        """Say what the correction of a finding would change, and offer to do it."""
        recording, notifier = self._document.recording, self._context.notifier
        if recording is None or finding.correction is None:
            return
        correction, folder = finding.correction, recording.folder

        def show() -> None:
            if self._asked is not None:
                notifier.take_back(self._asked)
            if self.running:
                self._asked = Message("warning", "The recording is being checked already.")
            else:
                words, do = intended(folder, correction), partial(self._correct, folder, finding)
                self._asked = Message("note", words, finding.where, _SURE, "Correct", do)
            notifier.show(self._asked)

        notifier.attempt(show)

    def _correct(self, folder: Path, finding: Finding) -> None:
        recording = self._document.recording
        if recording is not None and recording.folder == folder and not self.running:
            work = partial(correct_elsewhere, folder, finding)
            self._begin("testing a correction", work, self._on_corrected)

    def _begin(self, title: str, work: ProcessTask, done: Callable[[Any], None]) -> None:
        def in_process(task: Task) -> Any:
            hear = partial(task.report, 0.0)
            return self._process(work, hear, task.token.cancelled, listens=False)

        self._task = self._context.tasks.begin(title, in_process, done)

    def stop(self) -> None:
        if self._task is not None:
            self._task.cancel()

    def _on_corrected(self, done: Corrected) -> None:
        recording = self._document.recording
        if recording is None or done.file.parent != recording.folder:
            return
        kept = f"{done.words} The file before is {done.kept.name}."
        self._done = Message("note", f"{done.file.name} was corrected", remedy=kept)
        frame, workspace = self._document.frame, self._context.docks.workspace or None
        self._context.session.opening.open(recording.folder, frame=frame, workspace=workspace)

    def _tell(self) -> None:
        """Show the message of a correction once the recording is open again."""
        if self._done is not None and self._document.findings is not None:
            self._context.notifier.show(self._done)
            self._done = None

    def _compare_disparities(self) -> None:
        recording, depth = self._document.recording, self._context.session.track.settings.depth
        if recording is None or not is_changed(depth):
            self._take_reach((recording, depth, ()))
            return
        self._context.tasks.begin(
            "comparing disparities",
            lambda _task: (recording, depth, changed_reach(recording, None, depth)),
            self._take_reach,
        )

    def _take_reach(
        self, answer: tuple[Recording | None, DepthParameters, tuple[Finding, ...]]
    ) -> None:
        recording, depth, found = answer
        same = depth == self._context.session.track.settings.depth
        if same and recording is self._document.recording and found != self.reach:
            self.reach = found
            self._changed()
