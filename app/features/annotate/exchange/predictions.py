"""Keypoints of a 2-D detector come from files into the project and go from it; both are edits."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject, QSignalBlocker, Qt, QTimer, Signal, Slot
from PySide6.QtWidgets import (
    QAbstractItemView,
    QCheckBox,
    QComboBox,
    QFormLayout,
    QHeaderView,
    QInputDialog,
    QTableWidget,
    QTableWidgetItem,
    QWidget,
)

from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.interop.keypoints.reading import KEYPOINT_SUFFIXES
from stereotrack_core.interop.keypoints.source import KeypointSource
from stereotrack_core.interop.label_source import stated_names
from stereotrack_core.project.detectors import DetectorImport, plan_import
from stereotrack_core.project.project import Project
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.keypoint_names import LAYOUTS

from ....context import Context
from ....services.actions import Command, Menu
from ....services.tasks.newest import LatestOnly
from ....widgets.forms.form_dialog import (
    FormDialog,
    ask_for_folder,
    ask_to_open_several,
    files_of,
    line_edit,
    push_button,
)
from ....widgets.style.building import choice, hbox, label
from ..panels import AnnotationPanels

_FILES = (
    f"{files_of('Predictions', KEYPOINT_SUFFIXES)};;COCO, MMPose, RTMPose (*.json);;"
    "DeepLabCut (*.csv *.h5);;SLEAP (*.slp);;FreeMoCap, MediaPipe (*.npy *.csv)"
)
_WORDS = (
    "Files of OpenPose (a folder), COCO, MMPose, RTMPose, MediaPipe, FreeMoCap, DeepLabCut, SLEAP, "
    "or a table. Predictions are kept apart from clicks and never change them."
)
_SOON_MS = 250


@dataclass(frozen=True, eq=False)
class _Question:
    """What is to be imported, and how."""

    project: Project
    sources: tuple[KeypointSource, ...]
    frames: int | None
    person: str | None
    all_people: bool
    propose: bool


def _plan(question: _Question) -> DetectorImport:
    """Read the files; called in a thread of its own."""
    return plan_import(
        question.project,
        question.sources,
        question.frames,
        person=question.person,
        all_people=question.all_people,
        propose=question.propose,
    )


class PredictionsDialog(FormDialog):
    """Files of one detector, read at once; says what is taken of them before anything is done.

    Parameters
    ----------
    frames : int or None
        Number of frames of the recording.
    """

    import_requested = Signal(object, object)
    """The project, and what is to be written to it."""

    def __init__(
        self,
        project: Project,
        recording: Recording,
        frames: int | None,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__("Import predictions", "Import", self._write, parent)
        self._project, self._recording, self._frames = project, recording, frames
        self._paths: list[Path] = []
        self._plan: DetectorImport | None = None
        self._asked: _Question | None = None
        self._reading = LatestOnly(_plan, "read predictions")
        self._reading.answered.connect(self._on_read)
        self._reading.failed.connect(self._on_failed)
        self.finished.connect(self._reading.close)
        self._soon = QTimer(self, singleShot=True, interval=_SOON_MS)
        self._soon.timeout.connect(self._read)
        self._make_fields()
        self._lay_out()
        self.read_again()

    def _make_fields(self) -> None:
        self.files = QTableWidget(0, 2)
        self.files.setHorizontalHeaderLabels(["File", "Camera"])
        self.files.setAccessibleName("Files of predictions")
        self.files.verticalHeader().hide()
        self.files.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.files.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.files.horizontalHeader().setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        self.files.setColumnWidth(1, 190)
        self.detector = line_edit(
            "Detector",
            placeholder="name of the file",
            tip="Files of single cameras belong together by the name of their detector",
        )
        self.layout_box = choice(
            "Point order",
            [("", "by names or proportions"), *((name, name) for name in LAYOUTS)],
            "Order of the points in a file that does not name them. Layouts of equally many points "
            "are told apart by a body's proportions.",
        )
        self.person = choice(
            "Person",
            [("", "the surest of all frames")],
            "Of several people, the one who is kept over all frames.",
        )
        self.person.setEnabled(False)
        self.names = line_edit(
            "Names",
            placeholder="hand_l=left_wrist, snout=nose",
            tip="Keypoint names in the file and their names here, where they are unusual",
        )
        self.propose = QCheckBox("Propose landmarks as clicks")
        self.propose.setToolTip("Show them as predictions in Annotate, to be accepted as clicks.")
        self.propose.setChecked(True)
        self.all_people = QCheckBox("Keep all people")
        self.all_people.setToolTip("Otherwise one person is kept over all frames.")
        self.preview = label()
        for changed in (
            self.detector.textChanged, self.names.textChanged, self.propose.toggled,
            self.all_people.toggled, self.layout_box.currentIndexChanged,
            self.person.currentIndexChanged,
        ):  # fmt: skip
            changed.connect(self.read_again)

    def _lay_out(self) -> None:
        buttons = hbox(
            push_button("Add &files …", self._ask_for_files),
            push_button("Add f&older …", self._ask_for_folder, "Of OpenPose's JSON files"),
            push_button("&Remove from list", self._drop),
            None,
        )
        form = QFormLayout()
        form.addRow("Detector", self.detector)
        form.addRow("Point order", self.layout_box)
        form.addRow("Person", self.person)
        form.addRow("Names", self.names)
        checks = hbox(self.propose, self.all_people, None)
        self.lay_out(
            label(_WORDS, "muted"), (self.files, 1), buttons, form, checks, self.preview,
            size=(640, 520),
        )  # fmt: skip

    # ---- files

    def _ask_for_files(self) -> None:
        folder = str(self._project.path.parent)
        ask_to_open_several(self, "Import predictions", folder, _FILES, self.add)

    def _ask_for_folder(self) -> None:
        folder = str(self._project.path.parent)
        ask_for_folder(self, "Folder of OpenPose", folder, lambda chosen: self.add([chosen]))

    def add(self, paths: Sequence[Path]) -> None:
        """Add files or folders to the list."""
        recording = self._recording
        views = {view.image.camera: view.name for view in recording.views}
        known = [(views.get(name, name), name) for name in recording.cameras]
        names = [(name, shown) for shown, name in sorted(known)]
        for path in paths:
            row = self.files.rowCount()
            self._paths.append(path)
            self.files.insertRow(row)
            item = QTableWidgetItem(path.name)
            item.setToolTip(str(path))
            self.files.setItem(row, 0, item)
            box = choice("Camera", [("", "as stated in the file"), *names])
            box.currentIndexChanged.connect(self.read_again)
            self.files.setCellWidget(row, 1, box)
        self.read_again()

    def _drop(self) -> None:
        rows = {index.row() for index in self.files.selectedIndexes()}
        for row in sorted(rows, reverse=True):
            self.files.removeRow(row)
            del self._paths[row]
        self.read_again()

    # ---- reading

    @Slot()
    def read_again(self, _what: object = None) -> None:
        """Read the files with what the form says now, when it has stood for a moment."""
        self._plan = self._asked = None
        self.accept_button.setEnabled(False)
        self.say("")
        if self.files.rowCount():
            self.preview.setText("Reading …")
            self._soon.start()
        else:
            self._soon.stop()
            self.preview.setText("Add the files of a detector to see what they contain.")

    @Slot()
    def _read(self) -> None:
        def ask() -> None:
            self._asked = self._question()
            self._reading.ask(self._asked)

        if not self.attempt(ask):
            self.preview.setText("")

    def _question(self) -> _Question:
        names = stated_names(self.names.text().split(","))
        detector = self.detector.text().strip()
        if self.files.rowCount() > 1 and not detector:
            raise InputError(
                "several files need the name of their detector",
                remedy="Enter a name under Detector. The cameras belong together by it.",
            )
        sources = []
        for row, path in enumerate(self._paths):
            box = self.files.cellWidget(row, 1)
            camera = box.currentData() if isinstance(box, QComboBox) else None
            layout = self.layout_box.currentData() or None
            sources.append(
                KeypointSource(path, self._recording, camera or None, layout, names, detector)
            )
        person = self.person.currentData() or None
        if self.all_people.isChecked():
            person = None
        how = person, self.all_people.isChecked(), self.propose.isChecked()
        return _Question(self._project, tuple(sources), self._frames, *how)

    @Slot(object, object)
    def _on_read(self, question: _Question, plan: DetectorImport) -> None:
        if question is self._asked:
            self._plan = plan
            self._offer(plan.people)
            self.preview.setText(_told(plan, propose=question.propose))
            self.accept_button.setEnabled(True)

    @Slot(object, object)
    def _on_failed(self, question: _Question, error: Exception) -> None:
        if question is self._asked:
            self.preview.setText("")
            self.say(str(error), error=True)

    def _offer(self, people: Sequence[str]) -> None:
        """Let the person choose among the people of the files."""
        chosen = self.person.currentData()
        offered = [("", "the surest of all frames")]
        if len(people) > 1:
            offered += [(name, f"person {name}" if name.isdecimal() else name) for name in people]
        with QSignalBlocker(self.person):
            self.person.clear()
            for name, shown in offered:
                self.person.addItem(shown, name)
            self.person.setCurrentIndex(max(self.person.findData(chosen), 0))
        self.person.setEnabled(len(people) > 1 and not self.all_people.isChecked())

    def settled(self) -> bool:
        """Whether what is shown was read with what the form says."""
        return not self._soon.isActive() and self._reading.settled()

    # ---- writing

    def _write(self) -> None:
        if self._plan is not None:
            self.import_requested.emit(self._project, self._plan)
            self.accept()


def _told(plan: DetectorImport, *, propose: bool) -> str:
    """What an import does, in short paragraphs."""
    facts = plan.facts()
    frames, kept = counted(facts["frames"], "frame"), counted(facts["keypoints"], "keypoint")
    lines = [
        f"Will be imported: {kept} in {frames} of {facts['cameras']}, detector "
        f"{facts['detectors']}. Those of landmarks: {counted(facts['of_landmarks'], 'keypoint')}.",
        f"Left out: {plan.left_out_words()}.",
    ]
    if propose:
        lines.append(f"Will be proposed as clicks: {counted(plan.proposed, 'landmark')}.")
    lines += [f"{note[0].upper()}{note[1:]}." for note in plan.notes]
    if plan.replaced:
        lines.append(f"{counted(plan.replaced, 'keypoint')} of the project will be replaced.")
    return "\n".join(lines)


class PredictionExchange(QObject):
    """Asks which files, or which detector."""

    def __init__(
        self, context: Context, panels: AnnotationPanels, export: Callable[[], None]
    ) -> None:
        super().__init__(panels)
        self._context, self._panels, self._export = context, panels, export
        self._keypoints = context.session.keypoints
        self._keypoints.changed.connect(panels.read_kept)
        self._keypoints.changed.connect(panels.repeat_changed)
        panels.leaving.connect(self._close)
        context.tasks.watch(self._settled)

    def commands(self) -> list[Command]:
        """Commands of the menu File."""
        panels = self._panels
        command = Menu("&File", panels.no_edit).command
        return [
            command("annotate-import-predictions", "Import predictions …", "Import the keypoints "
                    "of a 2-D detector. What is taken and what is left out is shown before "
                    "anything is written.", self.ask_to_import, icon="prediction"),
            command("annotate-export-predictions", "Export predictions …", "Write the keypoints "
                    "of all detectors as a table or as COCO results.", self._export,
                    icon="export", why_not=self.why_none),
            command("annotate-remove-predictions", "Remove predictions …", "Remove the keypoints "
                    "and proposals of a detector. You can undo this.", self.ask_to_remove,
                    icon="delete", why_not=self.why_none),
        ]  # fmt: skip

    def why_none(self) -> str:
        """Why nothing can be removed or exported, as a sentence."""
        none = "The project has no predictions of a detector."
        return self._panels.no_edit() or ("" if self._keypoints.sources else none)

    def ask_to_import(self) -> None:
        """Let the person choose files, and show what they contain."""
        panels = self._panels
        if panels.project is None or panels.recording is None:
            return
        dialog = PredictionsDialog(
            panels.project, panels.recording, panels.frame_count or None, panels.window
        )
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.import_requested.connect(self._on_requested)
        self._keypoints.changed.connect(dialog.read_again)
        dialog.show()

    @Slot(object, object)
    def _on_requested(self, project: Project, plan: DetectorImport) -> None:
        kept = counted(len(plan.keypoints), "keypoint")
        said = f"{kept} of {', '.join(plan.after.sources)} imported."
        self._keypoints.bring(project, plan, partial(self._panels.said.emit, said))

    def ask_to_remove(self) -> None:
        """Let the person choose a detector."""
        known = {
            f"{name} ({counted(count, 'keypoint')})": name
            for name, count in self._keypoints.sources.items()
        }
        dialog = QInputDialog(self._panels.window)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.setWindowTitle("Remove predictions")
        dialog.setLabelText("Detector whose keypoints and proposals are removed:")
        dialog.setComboBoxItems(list(known))
        dialog.setOkButtonText("Remove")
        dialog.textValueSelected.connect(lambda words: self.remove(known[words]))
        dialog.open()

    def remove(self, detector: str) -> None:
        """Remove what a detector has predicted."""
        said = f"Predictions of {detector} removed. Undo brings them back."
        self._keypoints.remove(detector, partial(self._panels.said.emit, said))

    def _settled(self) -> bool:
        return all(one.settled() for one in self._panels.window.findChildren(PredictionsDialog))

    @Slot()
    def _close(self) -> None:
        for dialog in self._panels.window.findChildren(PredictionsDialog):
            dialog.close()
