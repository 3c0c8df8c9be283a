"""Opens the dialogs of annotation; none of them blocks the window."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QObject, Qt, Slot
from PySide6.QtWidgets import QDialog, QFileDialog

from stereotrack_core.annotation.agreement import click_sigmas, differences
from stereotrack_core.annotation.click import USUAL_SIGMA, Click
from stereotrack_core.annotation.reference import Reference
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.interop.labels import is_trajectory
from stereotrack_core.interop.reference_npz import export_reference
from stereotrack_core.interop.run_file import reference_in
from stereotrack_core.project.entries import Choose
from stereotrack_core.project.merging import clicks_of_project, incoming
from stereotrack_core.project.project import Project
from stereotrack_core.project.schema import REFERENCE
from stereotrack_core.project.selection import Selection
from stereotrack_core.project.setups import save_reference

from ...services.failures import message_of
from .exchange.agreement import AgreementReport, agreement_report
from .exchange.agreement_dialog import AgreementDialog
from .exchange.export_dialog import ExportDialog
from .exchange.import_dialog import ImportDialog, LabelFile
from .exchange.take_in_dialog import TakeInDialog
from .exchange.taking_in import TakeIn
from .panels import AnnotationPanels
from .setup.landmark_set_dialog import LandmarkSetDialog
from .setup.subject_dialog import SubjectDialog

_PROJECTS = "Projects (*.stereotrack)"
_REFERENCE_FILES = ("As in a recording (*.csv)", "With its uncertainty (*.npz)")


class AnnotationDialogs(QObject):
    """The dialogs of the project that is open; what takes long is prepared in the background."""

    def __init__(self, panels: AnnotationPanels) -> None:
        super().__init__(panels)
        self._panels = panels
        panels.leaving.connect(self.close_all)
        self._agreement: AgreementDialog | None = None
        self._other: Path | None = None

    def _show(self, dialog: QDialog) -> None:
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        # not modal: the person looks at clicks in the views meanwhile
        dialog.show()
        dialog.raise_()
        dialog.activateWindow()

    # ---- clicks in and out

    def ask_to_import(self) -> None:
        """Let the person choose a file of labels, or of a reference."""
        recording = self._panels.recording
        if recording is not None:
            cameras = [view.name for view in recording.views]
            cameras += [name for name in recording.cameras if name not in cameras]
            dialog = ImportDialog(cameras, self._folder(), self._panels.window)
            dialog.chosen.connect(self.import_labels)
            self._show(dialog)

    @Slot(object)
    def import_labels(self, file: LabelFile) -> None:
        """Compare a file with the project, and show that before anything is written."""
        project, recording = self._panels.project, self._panels.recording
        if project is None or recording is None:
            return
        try:
            trajectory = is_trajectory(file.path)
        except InputError as error:
            self._panels.message.emit(message_of(error))
            return
        if trajectory:
            self._panels.tasks.begin(
                "reading the reference",
                lambda _task: (project, file.path.stem, reference_in(file.path)),
                self._on_reference_read,
            )
            return
        frames = self._panels.frame_count or None
        self._take_in(project, lambda: file.clicks(project, recording, frames), file.path.name)

    @Slot(object)
    def _on_reference_read(self, found: tuple[Project, str, Reference]) -> None:
        project, name, reference = found
        if project is not self._panels.project:
            return
        try:
            project.apply(save_reference(name, reference))
            project.apply(Choose(REFERENCE.name, name))
        except InputError as error:
            self._panels.message.emit(message_of(error))

    def ask_to_merge(self) -> None:
        """Let the person choose another project of this recording."""
        chosen, _ = QFileDialog.getOpenFileName(
            self._panels.window, "Merge with another project", self._folder(), _PROJECTS
        )
        if chosen:
            self.merge(Path(chosen))

    def merge(self, path: Path) -> None:
        """Compare another project's clicks with these, and let the person decide."""
        project = self._panels.project
        if project is not None:
            self._take_in(project, lambda: _clicks_of(path, project), path.name)

    def merge_repeats(self) -> None:
        """Let the person decide where the second reading differs from the first one."""
        project = self._panels.project
        if project is None:
            return

        def read() -> tuple[tuple[Click, ...], tuple[InputError, ...]]:
            return project.clicks.again(), ()

        self._take_in(project, read, "blind repeats")

    def _take_in(
        self,
        project: Project,
        read: Callable[[], tuple[tuple[Click, ...], tuple[InputError, ...]]],
        source: str,
    ) -> None:
        def work(_task: object) -> tuple[Project, Callable[[], TakeIn], TakeIn]:
            theirs, problems = read()
            complete = source.endswith(".stereotrack")

            def compare() -> TakeIn:
                mine = project.clicks.all(with_deleted=True)
                return TakeIn(incoming(mine, theirs, source, complete=complete), problems)

            return project, compare, compare()

        self._panels.tasks.begin(f"comparing clicks with {source}", work, self._open_take_in)

    @Slot(object)
    def _open_take_in(self, found: tuple[Project, Callable[[], TakeIn], TakeIn]) -> None:
        project, compare, shown = found
        if project is not self._panels.project:
            return
        dialog = TakeInDialog(project, compare, shown, self._panels.tasks, self._panels.window)
        dialog.visit_requested.connect(self._panels.click_requested)
        dialog.taken_in.connect(self._panels.said)
        self._show(dialog)

    def export(self, selection: Selection | None) -> None:
        """Write clicks to a file, all of them or those that are selected."""
        project, recording = self._panels.project, self._panels.recording
        if project is None or recording is None:
            return

        def work(_task: object) -> tuple[Project, Selection | None, tuple[Click, ...]]:
            return project, selection, project.clicks.all()

        self._panels.tasks.begin("reading clicks", work, self._open_export)

    @Slot(object)
    def _open_export(self, found: tuple[Project, Selection | None, tuple[Click, ...]]) -> None:
        project, selection, clicks = found
        recording = self._panels.recording
        if project is not self._panels.project or recording is None:
            return
        path = Path(self._folder()) / "clicks.csv"
        names = project.landmark_set().names
        tasks, window = self._panels.tasks, self._panels.window
        dialog = ExportDialog(clicks, names, recording, selection, path, tasks, window)
        dialog.written.connect(self._panels.said)
        self._show(dialog)

    def ask_to_export_reference(self) -> None:
        """Let the person choose where the reference is written to."""
        now = self._panels.reference.now
        if now is None:
            return
        path = Path(self._folder()) / "reference.csv"
        dialog = QFileDialog(self._panels.window, "Export the reference", str(path.parent))
        dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
        dialog.setNameFilters(list(_REFERENCE_FILES))
        dialog.selectFile(path.name)
        dialog.fileSelected.connect(lambda chosen: self.export_reference(Path(chosen)))
        self._show(dialog)

    def export_reference(self, path: Path) -> None:
        """Write the reference that is shown; says so when it is done."""
        now = self._panels.reference.now
        if now is None:
            return
        path = path if path.suffix else path.with_suffix(".csv")
        try:
            export_reference(path, now.reference)
        except InputError as error:
            self._panels.message.emit(message_of(error))
            return
        kept = ", with uncertainty" if path.suffix.lower() == ".npz" else ""
        frames = counted(len(now.reference.frame), "frame")
        self._panels.said.emit(f"{frames} of the reference saved to {path}{kept}.")

    # ---- trust

    def show_agreement(self) -> None:
        """Show how well clicks agree: first with the frames that were annotated again."""
        if self._agreement is None:
            dialog = self._agreement = AgreementDialog(self._panels.window)
            dialog.again_requested.connect(self.compare_repeats)
            dialog.other_project_requested.connect(self._ask_for_other)
            dialog.differences_requested.connect(self._look_at_differences)
            dialog.destroyed.connect(self._on_agreement_closed)
            self._show(dialog)
        self.compare_repeats()

    @Slot()
    def compare_repeats(self) -> None:
        """Compare first and second readings of the frames that were annotated again."""
        self._other = None
        self._compare(None)

    @Slot()
    def _ask_for_other(self) -> None:
        chosen, _ = QFileDialog.getOpenFileName(
            self._panels.window, "Compare with another project", self._folder(), _PROJECTS
        )
        if chosen:
            self.compare_with(Path(chosen))

    def compare_with(self, path: Path) -> None:
        """Compare with another person's project of this recording."""
        self._other = path
        self._compare(path)

    def _compare(self, path: Path | None) -> None:
        project, recording = self._panels.project, self._panels.recording
        if project is None or recording is None:
            return

        def work(_task: object) -> tuple[str, AgreementReport]:
            landmarks = project.landmark_set()
            if path is None:
                words = "Blind repeats: first and second passes"
                found = project.clicks.repeat_differences()
                sigmas = click_sigmas(found, landmarks.names, USUAL_SIGMA)
                return words, agreement_report(found, recording.cameras, landmarks, sigmas)
            words = f"This project and {path.name}"
            found = differences(project.clicks.all(), _clicks_of(path, project)[0])
            return words, agreement_report(found, recording.cameras, landmarks)

        self._panels.tasks.begin("comparing annotations", work, self._on_compared)

    @Slot(object)
    def _on_compared(self, found: tuple[str, AgreementReport]) -> None:
        if self._agreement is not None:
            self._agreement.show_report(*found)

    @Slot()
    def _on_agreement_closed(self) -> None:
        self._agreement = None

    @Slot()
    def _look_at_differences(self) -> None:
        if self._other is None:
            self.merge_repeats()
        else:
            self.merge(self._other)

    # ---- subject and landmarks

    def show_subjects(self) -> None:
        """Enter or measure the subject's lengths."""
        project, recording = self._panels.project, self._panels.recording
        if project is not None and recording is not None:
            cameras, subject, panels = recording.cameras, recording.subject, self._panels
            self._show(SubjectDialog(project, cameras, subject, panels.tasks, panels.window))

    def show_landmarks(self) -> None:
        """Edit which landmarks are clicked."""
        project = self._panels.project
        if project is not None:
            self._show(LandmarkSetDialog(project, self._panels.window))

    def close_all(self) -> None:
        """Close what belongs to a project that is being closed."""
        kinds = (
            *(TakeInDialog, AgreementDialog, ExportDialog, ImportDialog),
            *(SubjectDialog, LandmarkSetDialog),
        )
        for kind in kinds:
            for dialog in self._panels.window.findChildren(kind):
                dialog.close()

    def _folder(self) -> str:
        project = self._panels.project
        return str(project.path.parent) if project is not None else ""


def _clicks_of(path: Path, project: Project) -> tuple[tuple[Click, ...], tuple[InputError, ...]]:
    """Clicks of another project, and what may be wrong with them."""
    clicks, notes = clicks_of_project(path, project)
    doubtful = [note for note in notes if note.severity == "warning"]
    return clicks, tuple(
        InputError(note.what, where=note.where, remedy=note.remedy) for note in doubtful
    )
