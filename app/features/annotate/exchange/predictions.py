"""Keypoints of a 2-D detector come from files into the project and go from it; both are edits."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from PySide6.QtCore import QSignalBlocker
from PySide6.QtWidgets import (
    QAbstractItemView,
    QComboBox,
    QFormLayout,
    QHeaderView,
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

from ....session.jobs import LatestOnly, TaskList
from ....widgets.forms.form_dialog import (
    FormDialog,
    ask_for_folder,
    ask_to_open_several,
    files_of,
    line_edit,
    push_button,
)
from ....widgets.redraw import later
from ....widgets.style.building import choice, hbox, label

_FILES = (
    f"{files_of('Predictions', KEYPOINT_SUFFIXES)};;COCO, MMPose, RTMPose (*.json);;"
    "DeepLabCut (*.csv *.h5);;SLEAP (*.slp);;FreeMoCap, MediaPipe (*.npy *.csv)"
)
_WORDS = (
    "Files of OpenPose (a folder), COCO, MMPose, RTMPose, MediaPipe, FreeMoCap, DeepLabCut, SLEAP, "
    "or a table. Predictions are kept apart from clicks and never change them."
)
_SUREST = "the surest of all frames"
_SOON_MS = 250


class PredictionsDialog(FormDialog):
    """Files of one detector, read at once; says what is taken of them before anything is done.

    `frames`: number of frames of the recording, if known; `write` imports into the project.
    """

    def __init__(
        self,
        project: Project,
        recording: Recording,
        frames: int | None,
        write: Callable[[Project, DetectorImport], object],
        tasks: TaskList,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__("Import predictions", "Import", self._on_accepted, parent)
        self._write = write
        self._project, self._recording, self._frames = project, recording, frames
        self._paths: list[Path] = []
        self._plan: DetectorImport | None = None
        self._reading = LatestOnly(
            tasks, lambda plan: plan(), "read predictions", self._on_read, self._on_failed
        )
        self.finished.connect(self._reading.close)
        self._soon = later(self, self._read, _SOON_MS)
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
            "Person", [("", _SUREST)], "Of several people, the one who is kept over all frames."
        )
        self.person.setEnabled(False)
        self.names = line_edit(
            "Names",
            placeholder="hand_l=left_wrist, snout=nose",
            tip="Keypoint names in the file and their names here, where they are unusual",
        )
        self.preview = label()
        for typed in (self.detector, self.names):
            typed.textChanged.connect(self.read_again)
        for chosen in (self.layout_box, self.person):
            chosen.currentIndexChanged.connect(self.read_again)

    def _lay_out(self) -> None:
        folder = self._project.path.parent
        files = partial(ask_to_open_several, self, "Import predictions", folder, _FILES, self.add)
        one = partial(
            ask_for_folder, self, "Folder of OpenPose", folder, lambda path: self.add([path])
        )
        buttons = hbox(
            push_button("Add &files …", files),
            push_button("Add f&older …", one, "Of OpenPose's JSON files"),
            push_button("&Remove from list", self._drop), None,
        )  # fmt: skip
        form = QFormLayout()
        for field in (self.detector, self.layout_box, self.person, self.names):
            form.addRow(field.accessibleName(), field)
        words = label(_WORDS, "muted")
        self.lay_out(words, (self.files, 1), buttons, form, self.preview, size=(640, 520))

    # ---- files

    def add(self, paths: Sequence[Path]) -> None:
        views = {view.image.camera: view.name for view in self._recording.views}
        known = [(name, views.get(name, name)) for name in self._recording.cameras]
        names = sorted(known, key=lambda pair: pair[::-1])
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

    def read_again(self) -> None:
        """Read the files with what the form says now, when it has stood for a moment."""
        self._plan = None
        self._reading.close()
        self.accept_button.setEnabled(False)
        self.say("")
        if self.files.rowCount():
            self.preview.setText("Reading …")
            self._soon.start()
        else:
            self._soon.stop()
            self.preview.setText("Add the files of a detector to see what they contain.")

    def _read(self) -> None:
        if not self.attempt(lambda: self._reading.ask(self._to_plan())):
            self.preview.setText("")

    def _to_plan(self) -> partial[DetectorImport]:
        """Function that reads the files as the form says; called in another thread."""
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
            said = path, self._recording, (), camera or None, names
            sources.append(KeypointSource(*said, layout=layout, detector=detector))
        person = self.person.currentData() or None
        known = self._project, tuple(sources), self._frames
        return partial(plan_import, *known, person=person, propose=True)

    def _on_read(self, _asked: object, plan: DetectorImport) -> None:
        self._plan = plan
        self._offer(plan.people)
        self.preview.setText(_told(plan))
        self.accept_button.setEnabled(True)

    def _on_failed(self, _asked: object, error: Exception) -> None:
        self.preview.setText("")
        self.say(str(error), error=True)

    def _offer(self, people: Sequence[str]) -> None:
        chosen = self.person.currentData()
        with QSignalBlocker(self.person):
            self.person.clear()
            self.person.addItem(_SUREST, "")
            for name in people if len(people) > 1 else ():
                self.person.addItem(f"person {name}" if name.isdecimal() else name, name)
            self.person.setCurrentIndex(max(self.person.findData(chosen), 0))
        self.person.setEnabled(len(people) > 1)

    def settled(self) -> bool:
        return not self._soon.isActive() and self._reading.settled()

    # ---- writing

    def _on_accepted(self) -> None:
        if self._plan is not None:
            self._write(self._project, self._plan)
            self.accept()


def _told(plan: DetectorImport) -> str:
    facts = plan.facts()
    frames, kept = counted(facts["frames"], "frame"), counted(facts["keypoints"], "keypoint")
    lines = [
        f"Will be imported: {kept} in {frames} of {facts['cameras']}, detector "
        f"{facts['detectors']}. Those of landmarks: {counted(facts['of_landmarks'], 'keypoint')}.",
        f"Left out: {plan.left_out_words()}.",
        f"Will be predicted: {counted(plan.proposed, 'landmark')}.",
    ]
    lines += [f"{note[0].upper()}{note[1:]}." for note in plan.notes]
    if plan.replaced:
        lines.append(f"{counted(plan.replaced, 'keypoint')} of the project will be replaced.")
    return "\n".join(lines)
