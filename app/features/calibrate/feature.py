"""Calibrate: cameras by pictures of a board; checks of the open recording, and corrections."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stereotrack_core.counting import counted
from stereotrack_core.doctor.correcting import Corrected, correct_elsewhere, intended
from stereotrack_core.doctor.diagnose import diagnose_elsewhere
from stereotrack_core.errors import Finding
from stereotrack_core.project.marks import use_camera
from stereotrack_core.worker_processes import ProcessTask, TaskProcess

from ...context import Context
from ...services.actions import Command, Menu
from ...services.docks import Workspace
from ...session.changes import RECORDING, Part
from ...session.jobs import Job, NewestJob, Task
from ...session.messages import Message
from ...session.replacing import open_again
from ...widgets.style.building import holder, named, vbox
from ...widgets.tables.panels import FindingsPanel
from . import person
from .controller import CalibrationController
from .state import why_not_into

if TYPE_CHECKING:
    from .page import CalibrationPage

_GUESSED = "Landmarks can be clicked. 3-D positions, fitting and tracking need a calibration."
_WAYS = (
    ("Attach a calibration …", "attach_calibration"),
    ("Calibrate", "calibrate"),
    ("Calibrate from the person …", "calibrate_person"),
)
"""Buttons of the message that cameras are guessed, and their commands."""

_SURE = (
    "It is tested first. The file is only changed if the problem is gone then, and the one before "
    "is kept beside it."
)


class RecordingChecks:
    """Measures images and makes corrections in another process, one at a time, on request."""

    def __init__(self, context: Context) -> None:
        self._context, self._document = context, context.session.document
        self._process, self.job = TaskProcess(), NewestJob(context.tasks)
        self._asked: Message | None = None
        watch = context.session.changes.watch
        watch(Part.RECORDING_CLOSED, self.job.cancel)
        watch(Part.WINDOW_CLOSING, self._process.close)

    def why_not_measure(self) -> str:
        if self._document.recording is None:
            return self._context.session.no_recording()
        if self._document.recording.guessed:
            return "The cameras are guessed, so their images cannot be compared."
        return "It is under way." if self.job.busy else ""

    def measure(self) -> None:
        recording = self._document.recording
        if recording is None or self.why_not_measure():
            return

        def done(found: tuple[Finding, ...]) -> None:
            if recording is self._document.recording:
                self._document.take_measured(found)
                serious = sum(one.severity != "note" for one in found)
                words = f"Checked thoroughly: {counted(serious, 'problem')} found."
                self._context.notifier.say(f"{words} See {_FINDINGS}.")

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
            if self.job.busy:
                self._asked = Message("warning", "The recording is being checked already.")
            else:
                words, do = intended(folder, correction), partial(self._correct, folder, finding)
                self._asked = Message("note", words, finding.where, _SURE, "Correct", do)
            notifier.show(self._asked)

        notifier.attempt(show)

    def _correct(self, folder: Path, finding: Finding) -> None:
        recording = self._document.recording
        if recording is not None and recording.folder == folder and not self.job.busy:
            work = partial(correct_elsewhere, folder, finding)
            self._begin("testing a correction", work, self._on_corrected)

    def _begin(self, title: str, work: ProcessTask, done: Callable[[Any], None]) -> None:
        def in_process(task: Task) -> Any:
            hear = partial(task.report, 0.0)
            return self._process(work, hear, task.token.cancelled, listens=False)

        self.job.run(Job(title, in_process, done))

    def _on_corrected(self, done: Corrected) -> None:
        recording = self._document.recording
        if recording is None or done.file.parent != recording.folder:
            return
        kept = f"{done.words} The file before is {done.kept.name}."
        said = Message("note", f"{done.file.name} was corrected", remedy=kept)
        open_again(self._context.session, said)


_MENU = "&File/&Calibration"


def _commands(context: Context, calibrate: CalibrateController) -> list[Command]:
    calibration, checks = calibrate.calibration, calibrate.checks

    def in_page() -> str:
        shown = context.docks.workspace == "calibrate"
        return "" if shown else "Open the workspace Calibrate first."

    command = Menu(_MENU).command
    return [
        command("calibrate", "Calibrate cameras", "Calibrate cameras with pictures of a board, "
                "with or without a recording.", partial(context.docks.show_named, "calibrate"),
                icon="calibrate"),
        command("check_thoroughly", "Check thoroughly", "Measure whether images, clocks, cameras "
                "and reference of the open recording fit each other; takes some seconds to "
                "minutes.", checks.measure, why_not=checks.why_not_measure),
        command("calibrate_person", "Calibrate from the person …", "Calculate cameras that are "
                "guessed from clicks of the same landmarks in several views, and one length.",
                partial(person.ask, context), why_not=partial(person.why_not, context.session)),
        command("calibrate_save", "Save calibration …", "Write a calibration.toml.",
                lambda: calibrate.page.axes.ask(), icon="save", section=True,
                why_not=lambda: in_page() or calibration.state.why_not_save()),
        command("calibrate_into", "Save into the recording", "Replace the calibration of the open "
                "recording; the one before is kept beside it.", calibration.save_into_recording,
                why_not=lambda: in_page() or why_not_into(calibration.state)),
    ]  # fmt: skip


_FINDINGS = "Recording checks"


class CalibrateController:
    """Shows the cameras and what looks wrong, be it by the files or by what is clicked."""

    def __init__(self, context: Context) -> None:
        self._context, self._session = context, context.session
        self.calibration = CalibrationController(context)
        self.checks = RecordingChecks(context)
        self.findings = FindingsPanel(self.checks.ask)
        self._column = vbox()
        context.docks.add_page("calibration", named(holder(self._column), "Calibration"))
        self._dock = context.docks.add("findings", _FINDINGS, self.findings)
        self._told: Message | None = None
        self._told_cameras: tuple[str, ...] = ()
        watch = context.session.changes.watch
        watch(RECORDING | Part.FINDINGS | Part.DOUBTS, self._show_findings)
        watch(Part.DOUBTS, self._on_cameras)
        watch(Part.WORKSPACE, self._on_workspace)
        watch(Part.READY, self._on_ready)

    @cached_property
    def page(self) -> CalibrationPage:
        """Made when it is wanted first: it takes a fifth of the time that the window takes."""
        from .page import CalibrationPage

        page = CalibrationPage(self.calibration)
        self._column.addWidget(page)
        return page

    def _on_workspace(self) -> None:
        if self._context.view_state.workspace == "calibrate":
            self.page.show()

    def _on_ready(self) -> None:
        """Say that the cameras are guessed, and what can be done about it."""
        recording, context = self._session.document.recording, self._context
        if recording is not None and recording.guessed:
            what = "the cameras of this recording are guessed from the size of the images"
            ways = [(words, context.actions.action(name).trigger) for words, name in _WAYS]
            message = Message("note", what, recording.name, _GUESSED, *ways[0], tuple(ways[1:]))
            context.notifier.show(message)

    def _show_findings(self) -> None:
        known = self._session.document.findings
        if known is not None:
            known = (*known, *self._session.cameras.findings())
        self.findings.show_findings(known)
        serious = sum(finding.severity != "note" for finding in known or ())
        self._dock.setWindowTitle(f"{_FINDINGS} ({serious})" if serious else _FINDINGS)

    def _on_cameras(self) -> None:
        """Say which camera contradicts the others, before its clicks are blamed."""
        cameras, notifier = self._session.cameras, self._context.notifier
        found, doubtful = cameras.findings(), cameras.doubtful()
        if doubtful != self._told_cameras:  # and not again while more is clicked
            self._told_cameras = doubtful
            if self._told is not None:
                notifier.take_back(self._told)
            self._told = None
            if found:
                told = Message("warning", found[0].what, remedy=found[0].remedy)
                if len(doubtful) == 1:
                    leave_out = partial(self._leave_out, doubtful[0])
                    told = replace(told, button=f"Leave {found[0].where} out", do=leave_out)
                self._told = told
                notifier.show(self._told)

    def _leave_out(self, camera: str) -> None:
        self._session.project.apply(use_camera(camera, used=False))


def register(context: Context) -> CalibrateController:
    """Offer the workspace Calibrate, its page, its panels and its commands."""
    calibrate = CalibrateController(context)
    loading = "The recording is still loading."
    space = Workspace(
        "calibrate", "Calibrate",
        "Calibrate cameras with pictures of a board; inspect problems of the recording.",
        "calibrate", side=(), bottom=("findings",), side_share=0.0, bottom_shares=(0.22,),
        side_heights=(), middle="calibration", no_panels=context.session.no_recording,
        why_not=lambda: loading if context.session.document.opening else "",
    )  # fmt: skip
    context.docks.add_workspace(space)
    context.actions.add(_commands(context, calibrate))
    calibrate.findings.add_action_button(context.actions.action("check_thoroughly"))
    return calibrate
