"""Clicks from files, clicks and references to files: which file, and what becomes of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from PySide6.QtCore import Signal, Slot
from PySide6.QtWidgets import QFormLayout, QWidget

from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.landmark_set import LandmarkSet
from stereotrack_core.annotation.reference import MAX_SIGMA, Reference
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.interop.label_source import LabelSource, stated_names
from stereotrack_core.interop.labels import LABEL_SUFFIXES, read_clicks
from stereotrack_core.interop.landmark_file import world_from_axes
from stereotrack_core.interop.run_file import TRAJECTORY_SUFFIXES
from stereotrack_core.project.exporting.formats import (
    ExportFormat,
    format_named,
    formats_of,
    lost_of_clicks,
)
from stereotrack_core.project.exporting.runs import export_clicks, export_reference
from stereotrack_core.project.selection import Selection
from stereotrack_core.recording.description import Recording

from ....services.tasks.task import Task, TaskList
from ....widgets.forms.form_dialog import (
    FormDialog,
    ask_to_open,
    ask_to_save,
    file_filter,
    files_of,
    line_edit,
    push_button,
)
from ....widgets.forms.numbers import NumberField
from ....widgets.style.building import choice, hbox, label

_FILES = ";;".join(
    (
        files_of("Labels and references", (*LABEL_SUFFIXES, *TRAJECTORY_SUFFIXES)),
        files_of("Labels", LABEL_SUFFIXES),
        files_of("Trajectories", TRAJECTORY_SUFFIXES),
    )
)
_WORDS = (
    "Clicks, DeepLabCut labels and COCO keypoints are compared with the project before anything "
    "is written. A trajectory is added as a reference of the project."
)
_AS_STATED = "as stated in the file"
_AXES = ("x,y,z", "-x,-y,z", "z,x,y", "x,-z,y", "x,z,-y")


class ImportDialog(FormDialog):
    """A file, the camera that it is of, and what its landmarks are called here."""

    chosen = Signal(object)

    def __init__(
        self,
        recording: Recording,
        landmarks: Sequence[str],
        folder: str,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__("Import clicks", "Compare …", self._on_accepted, parent)
        self._recording, self._landmarks, self._folder = recording, landmarks, folder
        cameras = dict.fromkeys((*(view.name for view in recording.views), *recording.cameras))
        self.path = line_edit("File")
        self.camera = choice(
            "Camera",
            [("", "as stated in the file"), *((name, name) for name in cameras)],
            "DeepLabCut and COCO files often hold a single camera.",
        )
        self.names = line_edit(
            "Names",
            placeholder="left_wrist=left_hand, nose=head",
            tip="Landmark names in the file and their names here, where they differ",
        )
        self.axes = choice(
            "Axes",
            [("", _AS_STATED), *((axes, axes) for axes in _AXES)],
            "Of a trajectory: the file's axes that point east, north and up, such as x,-z,y.",
        )
        self.axes.setEditable(True)
        self.path.textChanged.connect(self._check)
        self.names.textChanged.connect(self._check)
        form = QFormLayout()
        form.addRow("File", hbox((self.path, 1), push_button("&Choose …", self._ask)))
        form.addRow("Camera", self.camera)
        form.addRow("Names", self.names)
        form.addRow("Axes", self.axes)
        self.lay_out(label(_WORDS, "muted"), form, None, size=(560, 280))
        self._check()

    def ask_again(self, source: LabelSource, complaint: str) -> None:
        """Show what was chosen before, and what is wrong with it."""
        self.path.setText(str(source.path))
        self.names.setText(", ".join(f"{one}={two}" for one, two in (source.names or {}).items()))
        self.axes.setCurrentText(source.axes or _AS_STATED)
        self.axes.setFocus()
        self.say(complaint, error=True)

    def _ask(self) -> None:
        def take(path: Path) -> None:
            self.path.setText(str(path))

        ask_to_open(self, "Import clicks", self._folder, _FILES, take)

    @Slot()
    def _check(self) -> None:
        self.say("")
        self.accept_button.setEnabled(bool(self.path.text().strip()))

    def _on_accepted(self) -> None:
        path = Path(self.path.text().strip())

        def take() -> None:
            names = stated_names(self.names.text().split(","))
            if not path.is_file():
                raise InputError(
                    "there is no such file", where=str(path), remedy="Choose another file."
                )
            camera = self.camera.currentData() or None
            axes = self.axes.currentText().strip()
            if axes in ("", _AS_STATED):
                axes = ""
            else:
                world_from_axes(axes, "Axes")
            source = LabelSource(
                path, self._recording, self._landmarks, camera, names or None, axes
            )
            self.chosen.emit(source)

        if self.attempt(take):
            self.accept()


class ExportFileDialog(FormDialog):
    """A format, a file, and what becomes of it."""

    written = Signal(str)
    """What was done, in words."""

    def __init__(
        self,
        title: str,
        formats: Sequence[ExportFormat],
        path: Path,
        tasks: TaskList,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(title, "Export", self._write, parent)
        self._tasks = tasks
        named = [(one.name, f"{one.label} ({', '.join(one.suffixes)})") for one in formats]
        self.format_box = choice("Format", named)
        self.path = line_edit("File", str(path))
        self.path_row = hbox((self.path, 1), push_button("&Choose …", self._ask))
        self.preview = label()
        self.path.editingFinished.connect(self._look)
        self.format_box.activated.connect(self._on_format)

    @property
    def form(self) -> ExportFormat:
        """The format that is chosen."""
        return format_named(self.format_box.currentData())

    def target(self) -> Path:
        """The file that would be written."""
        path = Path(self.path.text().strip())
        return path if path.suffix or not path.name else self.form.named(path)

    @Slot()
    def _on_format(self) -> None:
        """Let the file have a suffix of the format."""
        path = Path(self.path.text().strip())
        if path.name and path.suffix.lower() not in self.form.suffixes:
            self.path.setText(str(path.with_suffix(self.form.suffixes[0])))
        self._look()

    @Slot()
    def _look(self) -> None:
        """Say what would be written and what not."""

    def _write(self) -> None:
        """Begin to write."""

    def _say_what_is_wrong(self, warning: str, *, something: bool) -> None:
        """Say what is wrong with the file or the format, else the warning."""
        fits = self.target().suffix.lower() in self.form.suffixes
        if not fits:
            warning = f"The name of the file must end in {' or '.join(self.form.suffixes)}."
        self.say(self.form.missing or warning, error=True)
        self.accept_button.setEnabled(something and fits and not self.form.missing)

    def _ask(self) -> None:
        files = file_filter(self.form)
        ask_to_save(self, self.windowTitle(), self.path.text(), files, self._take, goes_on=True)

    def _take(self, path: Path) -> None:
        self.path.setText(str(path))
        self._look()

    def _begin(self, title: str, write: Callable[[Task], str]) -> None:
        """Write in the background, and close when it is done."""
        self.accept_button.setEnabled(False)
        task = self._tasks.begin(title, write, self._on_written, promised=True)
        task.failed.connect(self._on_failed)

    @Slot(object)
    def _on_written(self, words: str) -> None:
        self.written.emit(words)
        self.accept()

    @Slot(object)
    def _on_failed(self, error: Exception) -> None:
        self.say(str(error), error=True)
        self.accept_button.setEnabled(True)


class ExportDialog(ExportFileDialog):
    """Which clicks, as what, to which file, and what becomes of that file.

    Parameters
    ----------
    clicks : tuple
        All of the project.
    """

    def __init__(
        self,
        clicks: tuple[Click, ...],
        landmarks: LandmarkSet,
        recording: Recording,
        selection: Selection | None,
        path: Path,
        tasks: TaskList,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__("Export clicks", formats_of("clicks"), path, tasks, parent)
        self._clicks, self._landmarks = clicks, landmarks
        self._recording, self._selection = recording, selection
        self.choice = choice("Which clicks", [("", "All clicks of the project")])
        if selection is not None:
            self.choice.addItem(f"Only {selection.words()}")
            self.choice.setCurrentIndex(1)
        self.lost = label("", "muted")
        form = QFormLayout()
        form.addRow("Clicks", self.choice)
        form.addRow("Format", self.format_box)
        form.addRow("File", self.path_row)
        self.lay_out(form, self.preview, self.lost, None, size=(600, 280))
        self.choice.currentIndexChanged.connect(self._look)
        self._look()

    def clicks(self) -> Sequence[Click]:
        """The clicks that would be written."""
        chosen = self._selection
        if self.choice.currentIndex() != 1 or chosen is None:
            return self._clicks
        return [c for c in self._clicks if c.frame in chosen.frames and chosen.has(c.landmark)]

    @Slot()
    def _look(self) -> None:
        clicks, form, path = self.clicks(), self.form, self.target()
        names = tuple(
            dict.fromkeys((*self._landmarks.names, *(click.landmark for click in clicks)))
        )
        if form.name == "csv":
            words, warning = _preview(clicks, path, self._recording, names)
        else:
            words, warning = _counted(clicks), ""
            if path.exists():
                warning = "The existing file will be replaced."
        self.preview.setText(words if clicks else "There are no clicks to export.")
        self.lost.setText(lost_of_clicks(form, clicks) or f"{form.label} stores all of them.")
        self._say_what_is_wrong(warning, something=bool(clicks))

    def _write(self) -> None:
        clicks, path, recording, form = self.clicks(), self.target(), self._recording, self.form
        landmarks = self._landmarks

        def write(_task: Task) -> str:
            written = export_clicks(path, clicks, recording, landmarks, form)
            if form.name == "csv":
                _check_back(clicks, path, recording)
            return written.words()

        self._begin("writing clicks", write)


class ReferenceExportDialog(ExportFileDialog):
    """A reference, as what, to which file, and which landmarks are certain enough."""

    def __init__(
        self,
        reference: Reference,
        fps: float,
        path: Path,
        tasks: TaskList,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__("Export the reference", formats_of("reference"), path, tasks, parent)
        self._reference, self._fps = reference, fps
        tip = (
            "Largest standard deviation of a landmark in its worst direction. Landmarks that are "
            "less certain are left empty."
        )
        self.limit = NumberField(
            minimum=0.1, maximum=10_000.0, singleStep=10.0, prefix="± ", suffix=" mm",
            keyboardTracking=False, accessibleName="Limit of sigma", toolTip=tip,
        )  # fmt: skip
        self.limit.setValue(1000.0 * MAX_SIGMA)
        self.limit.valueChanged.connect(self._look)
        form = QFormLayout()
        form.addRow("Format", self.format_box)
        form.addRow("File", self.path_row)
        form.addRow("Leave out beyond", hbox(self.limit, None))
        self.lay_out(form, self.preview, None, size=(560, 260))
        self._look()

    @Slot()
    def _look(self) -> None:
        left_out = self._reference.left_out(self.limit.value() / 1000.0)
        said = [left_out or "All landmarks are within the limit.", self.form.lost(self._reference)]
        self.preview.setText("\n".join(filter(None, said)))
        there = self.target().exists()
        warning = "The existing file will be replaced." if there else ""
        self._say_what_is_wrong(warning, something=True)

    def _write(self) -> None:
        path, form, limit = self.target(), self.form, self.limit.value() / 1000.0
        reference, fps = self._reference, self._fps

        def write(_task: Task) -> str:
            return f"Reference: {export_reference(path, reference, form, fps, limit).words()}"

        self._begin("exporting the reference", write)


def _counted(clicks: Sequence[Click]) -> str:
    frames = len({click.frame for click in clicks})
    return f"{counted(len(clicks), 'click')} in {counted(frames, 'frame')} will be written."


def _preview(
    clicks: Sequence[Click], path: Path, recording: Recording, landmarks: Sequence[str]
) -> tuple[str, str]:
    """What writing would do, and what would be lost of the file that would be replaced."""
    words = _counted(clicks)
    if not path.exists():
        return words, ""
    try:
        there = read_clicks(path, recording, landmarks=landmarks)
    except InputError as error:
        return words, f"The existing file will be replaced. It holds no clicks: {error.what}."
    old = {click.key: (click.position, click.visibility) for click in there.clicks}
    new = {click.key: (click.position, click.visibility) for click in clicks}
    both = old.keys() & new.keys()
    same = sum(old[key] == new[key] for key in both)
    lost = len(old) - len(both) + len(there.problems)
    words += (
        f" Of the {counted(len(old), 'click')} in the existing file, {same} stay the same and "
        f"{len(both) - same} change; {len(new) - len(both)} are new."
    )
    return words, f"{counted(lost, 'line')} of the existing file will be lost." if lost else ""


def _check_back(clicks: Sequence[Click], path: Path, recording: Recording) -> None:
    """Read clicks that were written, and compare their number."""
    names = tuple(dict.fromkeys(click.landmark for click in clicks))
    again = read_clicks(path, recording, landmarks=names).checked()
    if len(again) != len(clicks):
        raise InputError(
            f"{len(again)} of {len(clicks)} clicks could be read back from the file",
            where=str(path),
            remedy="Export to a different drive.",
        )
