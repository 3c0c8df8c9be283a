"""Opens the dialogs of annotation; none of them blocks the window."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

from stereotrack_core.annotation.agreement import click_sigmas, differences
from stereotrack_core.annotation.click import USUAL_SIGMA, Click
from stereotrack_core.annotation.reference import MAX_SIGMA, Reference
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.upright import Z_UP, Upright
from stereotrack_core.interop.label_source import LabelSource
from stereotrack_core.interop.labels import is_trajectory, read_labels
from stereotrack_core.interop.landmark_file import AxesContradicted, Stated, world_from_axes
from stereotrack_core.interop.run_file import at_recording, reference_in
from stereotrack_core.project.detectors import DetectorImport
from stereotrack_core.project.entries import choose, save_reference
from stereotrack_core.project.exporting import (
    ClickedRecording,
    Exported,
    ExportFormat,
    Kind,
    export_clicks,
    export_reference,
    formats_of,
    writer,
)
from stereotrack_core.project.merging import Incoming, clicks_of_project, incoming
from stereotrack_core.project.project import Project
from stereotrack_core.project.schema import REFERENCE
from stereotrack_core.recording.camera_checks import up_of_cameras
from stereotrack_core.recording.description import Recording

from ...session.changes import Part
from ...session.jobs import Job
from ...session.project import message_of_finding
from ...session.session import unless
from ...widgets.forms.form_dialog import ask_for_number, ask_for_text, ask_to_export, ask_to_open
from ...widgets.forms.numbers import NumberField
from .exchange.agreement import AgreementDialog, AgreementReport, agreement_report
from .exchange.merging import ImportDialog, TakeInDialog
from .exchange.predictions import PredictionsDialog
from .panels import AnnotationPanels
from .subject_dialog import SubjectDialog

_MAX_SIGMA = "export_max_sigma"  # view setting: metres
_PROJECTS = "Projects (*.stereotrack)"
_EXPORTED: dict[Kind, str] = {
    "clicks": "clicks", "reference": "the reference", "keypoints": "predictions",
}  # fmt: skip
_Elsewhere: TypeAlias = tuple[tuple[Click, ...], tuple[InputError, ...], tuple[str, ...]]
"""Clicks from elsewhere, what is wrong with them, and what their source cannot say of them."""
_Compared: TypeAlias = tuple[Callable[[], Incoming], Incoming, tuple[InputError, ...]]
"""A function that compares again, the clicks compared, and the errors of reading."""


class AnnotationDialogs:
    """The dialogs of the project that is open; what takes long is prepared in the background."""

    def __init__(self, panels: AnnotationPanels) -> None:
        self._panels, self._notifier = panels, panels.context.notifier
        self._agreement: AgreementDialog | None = None
        self._keypoints = panels.context.session.keypoints
        panels.context.tasks.watch(self._predictions_read)

    def _begin(
        self,
        title: str,
        work: Callable[[Project, Recording], Any],
        then: Callable[[Project, Recording, Any], None],
        failed: Callable[[Exception], None] | None = None,
        *,
        promised: bool = False,
    ) -> None:
        """Work in the background; go on with the result if that project is open still."""
        project, recording = self._panels.project, self._panels.recording
        if project is None or recording is None:
            return

        def done(found: Any) -> None:
            if project is self._panels.project:
                self._notifier.attempt(lambda: then(project, recording, found))

        job = Job(title, lambda _task: work(project, recording), done, failed)
        self._panels.context.tasks.run(job, promised=promised)

    # ---- clicks in and out

    def ask_to_import(self, source: LabelSource | None = None, complaint: str = "") -> None:
        """Let the person choose a file; again if there is a `complaint` about the `source`."""
        project, recording = self._panels.project, self._panels.recording
        if project is not None and recording is not None:
            names = project.landmark_set().names
            parent, folder = self._panels.window, self._folder()
            dialog = ImportDialog(recording, names, folder, self.import_labels, parent)
            self._panels.show_dialog(dialog)
            if source is not None:
                dialog.ask_again(source, complaint)

    def import_labels(self, source: LabelSource) -> None:
        """Compare a file with the project, and show that before anything is written."""
        count, path = self._panels.frame_count, source.path

        def read(_project: Project, recording: Recording) -> Reference:
            found = _reference_of(source)
            return at_recording(found, recording.fps, count, path.name) if count else found

        def keep(project: Project, _recording: Recording, reference: Reference) -> None:
            for note in reference.notes:
                self._notifier.show(message_of_finding(note))
            project.apply(save_reference(path.stem, reference))
            project.apply(choose(REFERENCE, path.stem))

        def again(error: Exception) -> None:
            if isinstance(error, AxesContradicted):
                choices = f"{error.upright} for an upright person, or {error.as_stated}"
                words = f"Choose the axes: {choices} for a person who lies or bends."
                self.ask_to_import(source, f"{error.where}: {error.what}. {words}")
            else:
                self._notifier.error(error)

        def begin() -> None:
            if is_trajectory(path):
                self._begin("reading the reference", read, keep, again)
            else:
                self._take_in(lambda *_: _labels_of(source, count or None), path.name)

        self._notifier.attempt(begin)

    def ask_to_merge(self) -> None:
        self._ask_for_project("Merge with another project", self.merge)

    def merge(self, path: Path) -> None:
        self._take_in(lambda project, _recording: _clicks_of(path, project), path.name)

    def _take_in(self, read: Callable[[Project, Recording], _Elsewhere], source: str) -> None:
        def work(project: Project, recording: Recording) -> _Compared:
            theirs, problems, unstated = read(project, recording)

            def compare() -> Incoming:
                mine = project.clicks.all(with_deleted=True)
                return incoming(mine, theirs, source, unstated=unstated)

            return compare, compare(), problems

        def show(project: Project, _recording: Recording, found: _Compared) -> None:
            context, parent = self._panels.context, self._panels.window
            self._panels.show_dialog(TakeInDialog(project, *found, context, parent))

        self._begin(f"comparing clicks with {source}", work, show)

    def ask_to_export(self, kind: Kind) -> None:
        """Let the person choose where something is written to, and in which format."""
        project, title = self._panels.project, f"Export {_EXPORTED[kind]}"
        name = f"{project.path.stem}-{kind}.csv" if project is not None else f"{kind}.csv"
        proposed, parent = Path(self._folder()) / name, self._panels.window

        def ask(limit: float) -> None:
            use = partial(self._export, kind, limit)
            ask_to_export(parent, title, proposed, formats_of(kind), use)

        if kind == "reference" and project is not None:
            self._ask_for_limit(project, title, ask)
        else:
            ask(MAX_SIGMA)

    def _ask_for_limit(self, project: Project, title: str, use: Callable[[float], None]) -> None:
        """Ask which landmarks are left out; the answer is proposed the next time."""
        field = NumberField(
            per_unit=1000.0, minimum=1.0, maximum=1000.0, suffix=" mm", singleStep=10.0
        )
        field.show_stored(float(project.view_settings.get(_MAX_SIGMA, MAX_SIGMA)))

        def take(limit: float) -> None:
            if not project.read_only:
                project.view_settings.set(_MAX_SIGMA, limit)
            use(limit)

        def about(limit: float) -> str:
            now = self._panels.reference.now
            return "" if now is None else now.reference.left_out(limit) or "Nothing is left out."

        text = "Leave out landmarks with a standard deviation above:"
        ask_for_number(self._panels.window, title, text, field, take, about)

    def _export(self, kind: Kind, limit: float, path: Path, form: ExportFormat) -> None:
        """Write in the background; says when it is done, and what the format cannot store."""
        now = self._panels.reference.now

        def write(project: Project, recording: Recording) -> Exported:
            if kind == "keypoints":
                return writer(form, "keypoints")(path, project.keypoints.all(), recording)
            if kind == "reference" and now is not None:
                return export_reference(path, now.reference, form, recording.fps, limit)
            return export_clicks(path, ClickedRecording.of(project, recording), form)

        def say(_project: Project, _recording: Recording, written: Exported) -> None:
            self._notifier.exported(written)

        if kind != "reference" or now is not None:
            self._begin(f"exporting {_EXPORTED[kind]}", write, say, promised=True)

    # ---- predictions of detectors

    def why_no_predictions(self) -> str:
        none = "The project has no predictions of a detector."
        return self._panels.no_edit() or unless(self._keypoints.sources, none)

    def ask_to_import_predictions(self) -> None:
        panels, project, recording = self._panels, self._panels.project, self._panels.recording
        if project is not None and recording is not None:
            count, tasks = panels.frame_count or None, panels.context.tasks
            dialog = PredictionsDialog(project, recording, count, self._bring, tasks, panels.window)
            panels.context.session.changes.watch(Part.KEYPOINTS, dialog.read_again)
            panels.show_dialog(dialog)

    def _bring(self, project: Project, plan: DetectorImport) -> None:
        kept = counted(len(plan.keypoints), "keypoint")
        said = f"{kept} of {', '.join(plan.after.sources)} imported."
        self._keypoints.bring(project, plan, partial(self._panels.say, said))

    def ask_to_remove_predictions(self) -> None:
        known = {
            f"{name} ({counted(count, 'keypoint')})": name
            for name, count in self._keypoints.sources.items()
        }
        words = "Detector whose keypoints and predictions are removed:"
        remove = lambda chosen: self.remove_predictions(known[chosen])  # noqa: E731
        dialog = ask_for_text(self._panels.window, "Remove predictions", words, remove)
        dialog.setComboBoxItems(list(known))
        dialog.setOkButtonText("Remove")

    def remove_predictions(self, detector: str) -> None:
        said = f"Predictions of {detector} removed. Undo brings them back."
        self._keypoints.remove(detector, partial(self._panels.say, said))

    def _predictions_read(self) -> bool:
        return all(one.settled() for one in self._panels.window.findChildren(PredictionsDialog))

    # ---- trust

    def show_agreement(self) -> None:
        if self._agreement is None:
            again, title = partial(self.compare_with, None), "Compare with another project"
            other = partial(self._ask_for_project, title, self.compare_with)
            dialog = AgreementDialog(again, other, self._panels.window)
            dialog.destroyed.connect(self._on_agreement_closed)
            self._agreement = dialog
            self._panels.show_dialog(dialog)
        self.compare_with(None)

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

    def _on_agreement_closed(self) -> None:
        self._agreement = None

    # ---- subject

    def show_subjects(self) -> None:
        panels, recording = self._panels, self._panels.recording
        if panels.project is not None and recording is not None:
            known = (panels.project, recording.cameras, recording.subject)
            panels.show_dialog(SubjectDialog(*known, panels.context.tasks, panels.window))

    def _ask_for_project(self, title: str, use: Callable[[Path], None]) -> None:
        ask_to_open(self._panels.window, title, self._folder(), _PROJECTS, use)

    def _folder(self) -> str:
        project = self._panels.project
        return str(project.path.parent) if project is not None else ""


def _reference_of(source: LabelSource) -> Reference:
    axes = world_from_axes(source.axes) if source.axes else None
    likely = up_of_cameras(source.recording)
    up = Upright(likely.axis) if likely.sure else Z_UP
    return reference_in(source.path, Stated(source.names or {}, axes, up))


def _labels_of(source: LabelSource, frames: int | None) -> _Elsewhere:
    found = read_labels(source, frames)
    left_out = []
    for name in found.left_out:
        what = f"all labels of {name!r}: no landmark of this project corresponds to it"
        remedy = f"To import them, give {name}=... under the names."
        left_out.append(InputError(what, where=source.path.name, remedy=remedy))
    return found.clicks, (*left_out, *found.problems), found.unstated


def _clicks_of(path: Path, project: Project) -> _Elsewhere:
    clicks, notes = clicks_of_project(path, project)
    doubtful = [note for note in notes if note.severity == "warning"]
    problems = (InputError(one.what, where=one.where, remedy=one.remedy) for one in doubtful)
    return clicks, tuple(problems), ()
