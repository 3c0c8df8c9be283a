"""The fields of a sweep: what is varied, on what, where it is computed, where it goes."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from PySide6.QtCore import Qt, Signal, Slot
from PySide6.QtWidgets import (
    QButtonGroup,
    QFormLayout,
    QGroupBox,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QListWidget,
    QListWidgetItem,
    QRadioButton,
    QWidget,
)

from stereotrack_core.errors import InputError
from stereotrack_core.experiments.sweep.points import SweepRequest
from stereotrack_core.interop.keypoints.reading import KEYPOINT_SUFFIXES
from stereotrack_core.project.whereabouts import SUFFIX as PROJECT_SUFFIX
from stereotrack_core.worker_processes import usable_cores

from ...widgets.forms.form_dialog import (
    ask_for_folder,
    ask_to_open,
    ask_to_save,
    files_of,
    line_edit,
    push_button,
)
from ...widgets.forms.numbers import WholeNumberField
from ...widgets.style.building import hbox, vbox
from .points import SweepPoints

_CERTIFICATES = {
    "tls_ca": ("Authority", "Certificate of the authority that the cluster trusts"),
    "tls_cert": ("Certificate", "Certificate for this program, signed by the authority"),
    "tls_key": ("Key", "Key of the certificate, without a password"),
}
"""Files of an encrypted cluster: their names, and what they are."""

_KEYPOINTS = files_of("Projects and predictions", (PROJECT_SUFFIX, *KEYPOINT_SUFFIXES))


class SweepForm(QWidget):
    """What a person asks a sweep for."""

    changed = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._preset, self._changes = "accurate", tuple[str, ...]()
        self._keypoints: dict[str, Path] = {}
        self.points = SweepPoints()
        self.points.changed.connect(self.changed)
        right = vbox(self._on_what(), self._where(), None)
        fields = hbox((self.points, 3), (right, 2))
        self.setLayout(vbox((fields, 1), self._file()))

    def show_base(self, preset: str, changes: Sequence[str]) -> None:
        """Say what all runs begin with: a preset, and ``NAME=VALUE`` for what differs from it."""
        self._preset, self._changes = preset, tuple(changes)
        self.points.show_base(preset, changes)

    def add_recording(self, folder: Path) -> None:
        """Add a recording to those that are tracked."""
        if str(folder) not in self.recordings():
            item = QListWidgetItem(folder.name)
            item.setToolTip(str(folder))
            item.setData(Qt.ItemDataRole.UserRole, str(folder))
            self.list.addItem(item)
            self.changed.emit()

    def set_keypoints(self, folder: str, path: Path) -> None:
        """Track a recording of the list with keypoints of a project, or of a detector's file."""
        self._keypoints[folder] = path
        for row in range(self.list.count()):
            item = self.list.item(row)
            if item.data(Qt.ItemDataRole.UserRole) == folder:
                item.setText(f"{Path(folder).name}, keypoints of {path.name}")
                item.setToolTip(f"{folder}\nKeypoints: {path}")
        self.changed.emit()

    def _keypoints_of(self, recordings: Sequence[str]) -> tuple[Path, ...]:
        """Keypoints of each recording, or none; InputError where only some have any."""
        found = [self._keypoints[one] for one in recordings if one in self._keypoints]
        if found and len(found) < len(recordings):
            raise InputError(
                f"{len(found)} of {len(recordings)} recordings have keypoints",
                remedy="Choose keypoints for the others as well, or remove them from the list.",
            )
        return tuple(found)

    def recordings(self) -> tuple[str, ...]:
        """Folders of the recordings."""
        items = (self.list.item(row) for row in range(self.list.count()))
        return tuple(str(item.data(Qt.ItemDataRole.UserRole)) for item in items)

    def request(self) -> SweepRequest:
        """The sweep that the fields ask for.

        Raises
        ------
        InputError
            Where something is missing.
        """
        recordings, table = self.recordings(), self.table.text().strip()
        if not recordings:
            raise InputError("no recording is chosen", remedy="Add a recording.")
        if not table:
            raise InputError("the results table has no file name", remedy="Choose a file.")
        scheduler = self.address.text().strip() if self.cluster.isChecked() else ""
        return SweepRequest(
            recordings=tuple(map(Path, recordings)),
            table=Path(table),
            preset=self._preset,
            changes=self._changes,
            seeds=self.seeds.text().strip() or "0",
            frames=self.frames.text().strip() or None,
            keypoints=self._keypoints_of(recordings),
            workers=None if scheduler else self.processes.value(),
            scheduler=scheduler or None,
            tls_ca=self._certificate("tls_ca"),
            tls_cert=self._certificate("tls_cert"),
            tls_key=self._certificate("tls_key"),
            **self.points.fields(),
        )

    # ---- making

    def _on_what(self) -> QGroupBox:
        self.list = QListWidget()
        self.list.setAccessibleName("Recordings")
        self.list.setMaximumHeight(72)
        about = "Each point is tracked once per recording with each random seed"
        self.seeds = line_edit("Seeds", "0,1,2", tip=about)
        about = "Only frames A up to but not including B"
        self.frames = line_edit("Frames", placeholder="all, or A:B", tip=about)
        for field in (self.seeds, self.frames):
            field.textEdited.connect(self.changed)
        box = QGroupBox("Input")
        form = QFormLayout(box)
        form.addRow("Recordings", self.list)
        add = push_button("A&dd …", self._ask_recording)
        remove = push_button("Re&move", self._remove_recording)
        about = (
            "Track the selected recording with keypoints of a 2-D detector; mono views need them"
        )
        keypoints = push_button("&Keypoints …", self._ask_keypoints, about)
        form.addRow("", hbox(add, remove, keypoints, None))
        form.addRow("Seeds", self.seeds)
        form.addRow("Frames", self.frames)
        return box

    def _where(self) -> QGroupBox:
        self.here = QRadioButton("This computer, processes")
        self.cluster = QRadioButton("Dask scheduler at")
        self.here.setChecked(True)
        group = QButtonGroup(self)
        group.addButton(self.here)
        group.addButton(self.cluster)
        self.processes = WholeNumberField(minimum=1, maximum=256, value=usable_cores())
        self.processes.setAccessibleName("Processes")
        self.processes.valueChanged.connect(self.changed)
        self.address = line_edit(
            "Address of the scheduler",
            placeholder="tcp://host:8786 or tls://host:8786",
            tip="The workers must see the recordings under the same paths; see docs/sweeps.md",
        )
        self.address.textEdited.connect(self.changed)
        self.address.textEdited.connect(lambda: self.cluster.setChecked(True))
        self.cluster.toggled.connect(self.changed)
        box = QGroupBox("Run on")
        form = QFormLayout(box)
        form.addRow(self.here, self.processes)
        form.addRow(self.cluster, self.address)
        self.files = {
            name: self._file_of_cluster(form, *words) for name, words in _CERTIFICATES.items()
        }
        self._run_on = form
        self.cluster.toggled.connect(self._show_certificates)
        self.address.textChanged.connect(self._show_certificates)
        self._show_certificates()
        return box

    def _file_of_cluster(self, form: QFormLayout, name: str, about: str) -> QLineEdit:
        """A row for a file by which an encrypted cluster and this program know each other."""
        field = line_edit(name, placeholder="as Dask is configured", tip=about)
        field.textChanged.connect(self.changed)

        def ask() -> None:
            kinds = files_of("PEM", (".pem", ".crt", ".cer", ".key"))
            ask_to_open(self, name, field.text(), kinds, lambda path: field.setText(str(path)))

        choose = push_button("…", ask, f"{about}: choose the file")
        choose.setAccessibleName(f"Choose the file: {name}")
        choose.setMaximumWidth(5 * choose.fontMetrics().averageCharWidth())
        form.addRow(name, hbox((field, 1), choose))
        return field

    @Slot()
    def _show_certificates(self) -> None:
        """Ask for certificates where the address may be encrypted."""
        address = self.address.text().strip()
        encrypted = address.startswith("tls:") or address.endswith(".json")
        wanted = self.cluster.isChecked() and encrypted
        first = self._run_on.rowCount() - len(self.files)
        for row in range(first, self._run_on.rowCount()):
            self._run_on.setRowVisible(row, wanted)

    def _certificate(self, name: str) -> Path | None:
        """A file that is given and asked for."""
        field = self.files[name]
        return None if field.isHidden() or not field.text().strip() else Path(field.text().strip())

    def _file(self) -> QHBoxLayout:
        name, self.table = QLabel("&Table"), line_edit("Table")
        self.table.textEdited.connect(self.changed)
        name.setBuddy(self.table)
        name.setMinimumWidth(name.sizeHint().width() + self.fontMetrics().averageCharWidth())
        return hbox(name, (self.table, 1), push_button("C&hoose …", self._ask_table))

    @Slot()
    def _ask_recording(self) -> None:
        start = str(Path(self.recordings()[-1]).parent) if self.recordings() else ""
        ask_for_folder(self, "Add a recording", start, self.add_recording)

    @Slot()
    def _ask_keypoints(self) -> None:
        chosen = [item.data(Qt.ItemDataRole.UserRole) for item in self.list.selectedItems()]
        folders = chosen or self.recordings()[-1:]
        for folder in folders[:1]:
            title, start = f"Keypoints of {Path(folder).name}", str(Path(folder).parent)
            ask_to_open(self, title, start, _KEYPOINTS, partial(self.set_keypoints, folder))

    @Slot()
    def _remove_recording(self) -> None:
        for item in self.list.selectedItems():
            self._keypoints.pop(item.data(Qt.ItemDataRole.UserRole), None)
            self.list.takeItem(self.list.row(item))
        self.changed.emit()

    @Slot()
    def _ask_table(self) -> None:
        title, start = "Results table of the sweep", self.table.text()
        ask_to_save(self, title, start, "Table (*.csv)", self._take_table, goes_on=True)

    def _take_table(self, path: Path) -> None:
        self.table.setText(str(path if path.suffix else path.with_suffix(".csv")))
        self.changed.emit()
