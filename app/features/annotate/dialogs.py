"""Opens the dialogs of annotation; none of them blocks the window."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

from PySide6.QtCore import QObject, Qt, Slot
from PySide6.QtWidgets import QDialog

from stereotrack_core.annotation.agreement import click_sigmas, differences
from stereotrack_core.annotation.click import USUAL_SIGMA, Click
from stereotrack_core.annotation.reference import Reference
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.upright import Z_UP, Upright
from stereotrack_core.interop.label_source import LabelSource
from stereotrack_core.interop.labels import is_trajectory, read_labels
from stereotrack_core.interop.landmark_file import AxesContradicted, Stated, world_from_axes
from stereotrack_core.interop.run_file import at_recording, reference_in
from stereotrack_core.project.entries import Choose, save_reference
from stereotrack_core.project.exporting.formats import ExportFormat, Kind, formats_of
from stereotrack_core.project.exporting.runs import (
    Exported,
    export_clicks,
    export_keypoints,
    export_reference,
)
from stereotrack_core.project.merging import Incoming, clicks_of_project, incoming
from stereotrack_core.project.project import Project
from stereotrack_core.project.schema import REFERENCE
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.upright import up_of_cameras

from ...services.failures import message_of
from ...session.project import message_of_finding
from ...widgets.forms.form_dialog import ask_to_export, ask_to_open
from .exchange.agreement import AgreementDialog, AgreementReport, agreement_report
from .exchange.click_files import ImportDialog
from .exchange.merging import TakeInDialog
from .panels import AnnotationPanels
from .setup.subject_dialog import SubjectDialog

_PROJECTS = "Projects (*.stereotrack)"
_Elsewhere: TypeAlias = tuple[tuple[Click, ...], tuple[InputError, ...], tuple[str, ...]]
"""Clicks from elsewhere, what is wrong with them, and what their source cannot say of them."""
_Compared: TypeAlias = tuple[Callable[[], Incoming], Incoming, tuple[InputError, ...]]
"""A function that compares again, the clicks compared, and the errors of reading."""


class AnnotationDialogs(QObject):
    """The dialogs of the project that is open; what takes long is prepared in the background."""

    def __init__(self, panels: AnnotationPanels) -> None:
        super().__init__(panels)
        self._panels = panels
        panels.leaving.connect(self._close_all)
        self._agreement: AgreementDialog | None = None

    def _show(self, dialog: QDialog) -> None:
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        # not modal: the person looks at clicks in the views meanwhile
        dialog.show()
        dialog.raise_()
        dialog.activateWindow()

    def _begin(
        self,
        title: str,
        work: Callable[[Project, Recording], Any],
        then: Callable[[Project, Recording, Any], None],
        failed: Callable[[Exception], None] | None = None,
        *,
        promised: bool = False,
    ) -> None:
        """Work in the background; go on with the result if that project is open still.

        `failed` tells of an error instead of the list of tasks.
        """
        project, recording = self._panels.project, self._panels.recording
        if project is None or recording is None:
            return

        def done(found: Any) -> None:
            if project is self._panels.project:
                self._attempt(lambda: then(project, recording, found))

        self._panels.tasks.begin(
            title, lambda _task: work(project, recording), done, failed, promised=promised
        )

    def _attempt(self, do: Callable[[], object]) -> bool:
        """Do something; where it cannot be done, say so."""
        try:
            do()
        except InputError as error:
            self._panels.message.emit(message_of(error))
            return False
        return True

    # ---- clicks in and out

    def ask_to_import(self) -> None:
        """Let the person choose a file of labels, or of a reference."""
        self._ask_for_labels()

    def _ask_for_labels(self, source: LabelSource | None = None, complaint: str = "") -> None:
        """The same, where something is wrong with what was chosen before."""
        project, recording = self._panels.project, self._panels.recording
        if project is not None and recording is not None:
            names = project.landmark_set().names
            dialog = ImportDialog(recording, names, self._folder(), self._panels.window)
            dialog.chosen.connect(self.import_labels)
            self._show(dialog)
            if source is not None:
                dialog.ask_again(source, complaint)

    @Slot(object)
    def import_labels(self, source: LabelSource) -> None:
        """Compare a file with the project, and show that before anything is written."""
        count, path = self._panels.frame_count, source.path

        def read(_project: Project, recording: Recording) -> Reference:
            found = _reference_of(source)
            return at_recording(found, recording.fps, count, path.name) if count else found

        def keep(project: Project, _recording: Recording, reference: Reference) -> None:
            for note in reference.notes:
                self._panels.message.emit(message_of_finding(note))
            project.apply(save_reference(path.stem, reference))
            project.apply(Choose(REFERENCE.name, path.stem))

        def again(error: Exception) -> None:
            if isinstance(error, AxesContradicted):
                self._ask_for_labels(source, _axes_asked_for(error))
            else:
                self._panels.message.emit(message_of(error))

        def begin() -> None:
            if is_trajectory(path):
                self._begin("reading the reference", read, keep, again)
                return
            self._take_in(lambda *_: _labels_of(source, count or None), path.name)

        self._attempt(begin)

    def ask_to_merge(self) -> None:
        """Let the person choose another project of this recording."""
        self._ask_for_project("Merge with another project", self.merge)

    def merge(self, path: Path) -> None:
        """Compare another project's clicks with these, and let the person decide."""
        self._take_in(lambda project, _recording: _clicks_of(path, project), path.name)

    def _take_in(self, read: Callable[[Project, Recording], _Elsewhere], source: str) -> None:
        def work(project: Project, recording: Recording) -> _Compared:
            theirs, problems, unstated = read(project, recording)

            def compare() -> Incoming:
                mine = project.clicks.all(with_deleted=True)
                return incoming(mine, theirs, source, unstated=unstated)

            return compare, compare(), problems

        def show(project: Project, _recording: Recording, found: _Compared) -> None:
            dialog = TakeInDialog(project, *found, self._panels.tasks, self._panels.window)
            dialog.taken_in.connect(self._panels.said)
            self._show(dialog)

        self._begin(f"comparing clicks with {source}", work, show)

    def ask_to_export(self) -> None:
        """Let the person choose where clicks are written to."""
        self._ask_where("Export clicks", "clicks", self.export)

    def export(self, path: Path, form: ExportFormat) -> None:
        """Write clicks to a file; says so when it is done, and what the format cannot store."""

        def write(project: Project, recording: Recording) -> Exported:
            clicks = project.clicks.all()
            return export_clicks(path, clicks, recording, project.landmark_set(), form)

        self._write("exporting clicks", write)

    def ask_to_export_reference(self) -> None:
        """Let the person choose where the reference is written to."""
        self._ask_where("Export the reference", "reference", self.export_reference)

    def export_reference(self, path: Path, form: ExportFormat) -> None:
        """Write the reference as far as it is certain; says so when it is done."""
        now = self._panels.reference.now
        if now is not None:
            known = now.reference
            self._write(
                "exporting the reference",
                lambda _project, recording: export_reference(path, known, form, recording.fps),
            )

    def ask_to_export_predictions(self) -> None:
        """Let the person choose where the keypoints of all detectors are written to."""
        self._ask_where("Export predictions", "keypoints", self.export_predictions)

    def export_predictions(self, path: Path, form: ExportFormat) -> None:
        """Write the keypoints of all detectors; says so when it is done."""

        def write(project: Project, recording: Recording) -> Exported:
            return export_keypoints(path, project.keypoints.all(), recording, form)

        self._write("exporting predictions", write)

    def _ask_where(self, title: str, kind: Kind, use: Callable[[Path, ExportFormat], None]) -> None:
        proposed = Path(self._folder()) / f"{kind}.csv"
        ask_to_export(self._panels.window, title, proposed, formats_of(kind), use)

    def _write(self, title: str, write: Callable[[Project, Recording], Exported]) -> None:
        def say(_project: Project, _recording: Recording, written: Exported) -> None:
            self._panels.said.emit(written.words())

        self._begin(title, write, say, promised=True)

    # ---- trust

    def show_agreement(self) -> None:
        """Show how well clicks agree: first with the frames that were annotated again."""
        if self._agreement is None:
            dialog = self._agreement = AgreementDialog(self._panels.window)
            dialog.again_requested.connect(partial(self.compare_with, None))
            dialog.other_project_requested.connect(self._ask_for_other)
            dialog.destroyed.connect(self._on_agreement_closed)
            self._show(dialog)
        self.compare_with(None)

    @Slot()
    def _ask_for_other(self) -> None:
        self._ask_for_project("Compare with another project", self.compare_with)

    def compare_with(self, path: Path | None) -> None:
        """Compare with another person's project; None: both readings of blind repeats."""

        def work(project: Project, recording: Recording) -> tuple[str, AgreementReport]:
            landmarks, cameras = project.landmark_set(), recording.cameras
            if path is None:
                words = "Blind repeats: first and second passes"
                found = project.clicks.repeat_differences()
                sigmas = click_sigmas(found, landmarks.names, USUAL_SIGMA)
                return words, agreement_report(found, cameras, landmarks, sigmas)
            words = f"This project and {path.name}"
            found = differences(project.clicks.all(), _clicks_of(path, project)[0])
            return words, agreement_report(found, cameras, landmarks)

        def show(_project: Project, _recording: Recording, found: tuple[Any, Any]) -> None:
            if self._agreement is not None:
                self._agreement.show_report(*found)

        self._begin("comparing annotations", work, show)

    @Slot()
    def _on_agreement_closed(self) -> None:
        self._agreement = None

    # ---- subject

    def show_subjects(self) -> None:
        """Enter or measure the subject's lengths."""
        panels, recording = self._panels, self._panels.recording
        if panels.project is not None and recording is not None:
            known = (panels.project, recording.cameras, recording.subject)
            self._show(SubjectDialog(*known, panels.tasks, panels.window))

    @Slot()
    def _close_all(self) -> None:
        """Close what belongs to a project that is being closed."""
        for kind in (TakeInDialog, AgreementDialog, ImportDialog, SubjectDialog):
            for dialog in self._panels.window.findChildren(kind):
                dialog.close()

    def _ask_for_project(self, title: str, use: Callable[[Path], None]) -> None:
        ask_to_open(self._panels.window, title, self._folder(), _PROJECTS, use)

    def _folder(self) -> str:
        project = self._panels.project
        return str(project.path.parent) if project is not None else ""


def _axes_asked_for(error: AxesContradicted) -> str:
    return (
        f"{error.where}: {error.what}. Choose the axes: {error.upright} for an upright person, or "
        f"{error.as_stated} for a person who lies or bends."
    )


def _reference_of(source: LabelSource) -> Reference:
    """The trajectory of a file, turned into the recording's world."""
    axes = world_from_axes(source.axes) if source.axes else None
    likely = up_of_cameras(source.recording)
    up = Upright(likely.axis) if likely.sure else Z_UP
    return reference_in(source.path, Stated(source.names or {}, axes, up))


def _labels_of(source: LabelSource, frames: int | None) -> _Elsewhere:
    """Clicks of a file, and everything that is left out of it."""
    found = read_labels(source, frames)
    left_out = tuple(
        InputError(
            f"all labels of {name!r}: no landmark of this project corresponds to it",
            where=source.path.name,
            remedy=f"To import them, give {name}=... under the names.",
        )
        for name in found.left_out
    )
    return found.clicks, (*left_out, *found.problems), found.unstated


def _clicks_of(path: Path, project: Project) -> _Elsewhere:
    """Clicks of another project, and what may be wrong with them."""
    clicks, notes = clicks_of_project(path, project)
    doubtful = [note for note in notes if note.severity == "warning"]
    problems = (InputError(one.what, where=one.where, remedy=one.remedy) for one in doubtful)
    return clicks, tuple(problems), ()
