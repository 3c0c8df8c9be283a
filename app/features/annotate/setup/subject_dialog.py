"""Enter a subject's lengths, measure them from clicks, keep and reuse them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from PySide6.QtCore import QSignalBlocker, Qt, Slot
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QDoubleSpinBox,
    QFileDialog,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QListWidget,
    QListWidgetItem,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from stereotrack_core.errors import InputError
from stereotrack_core.recording.description import Subject, write_subject

from ....services.tasks.task import Task, TaskList
from .subjects import LENGTH_WORDS, Measured, Subjects, average_of, doubts_about, read_subject_file

_RECORDED = "as in the recording"
_FILES = "Subject (*.toml)"


class SubjectDialog(QDialog):
    """The project's subjects at the left, the lengths of one of them at the right."""

    def __init__(self, subjects: Subjects, tasks: TaskList, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle("Subjects")
        self._subjects, self._tasks = subjects, tasks
        self._measured: Measured | None = None
        self.list = QListWidget()
        self.list.setAccessibleName("Subjects")
        self.list.setMaximumWidth(190)
        self.name = QLineEdit()
        self.name.setPlaceholderText("Name of the subject")
        self.name.setAccessibleName("Name")
        self.lengths: dict[str, QDoubleSpinBox] = {}
        self._averages: dict[str, QLabel] = {}
        self._found: dict[str, QLabel] = {}
        self.words = QLabel()
        self.words.setWordWrap(True)
        self._lay_out()
        self.list.currentRowChanged.connect(self._on_chosen)
        self.name.textChanged.connect(self._check)
        self._fill_list(subjects.used())

    # ---- parts

    def _lay_out(self) -> None:
        self.measure_button = self._button("&Measure from clicks", self._measure)
        self.take_button = self._button("Use &measured lengths", self._take_measured)
        self.take_button.setEnabled(False)
        self.load_button = self._button("&Load …", self._ask_to_load)
        self.store_button = self._button("Save as &file …", self._ask_to_store)
        self.delete_button = self._button("&Delete", self._delete)
        right = QVBoxLayout()
        named = QHBoxLayout()
        label = QLabel("&Name")
        label.setBuddy(self.name)
        named.addWidget(label)
        named.addWidget(self.name)
        right.addLayout(named)
        right.addLayout(self._form())
        row = QHBoxLayout()
        row.addWidget(self.measure_button)
        row.addWidget(self.take_button)
        row.addStretch(1)
        right.addLayout(row)
        right.addWidget(self.words)
        right.addStretch(1)
        left = QVBoxLayout()
        left.addWidget(self.list, 1)
        files = QHBoxLayout()
        files.addWidget(self.load_button)
        files.addWidget(self.store_button)
        left.addLayout(files)
        left.addWidget(self.delete_button)
        both = QHBoxLayout()
        both.addLayout(left)
        both.addSpacing(12)
        both.addLayout(right, 1)
        self.buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        self.use_button = self.buttons.addButton("&Use", QDialogButtonBox.ButtonRole.AcceptRole)
        self.buttons.accepted.connect(self._use)
        self.buttons.rejected.connect(self.reject)
        layout = QVBoxLayout(self)
        layout.addLayout(both, 1)
        layout.addWidget(self.buttons)
        self.resize(760, 440)

    def _button(self, text: str, do: Callable[[], None]) -> QPushButton:
        button = QPushButton(text)
        button.setAutoDefault(False)
        button.clicked.connect(lambda _checked=False: do())
        return button

    def _form(self) -> QGridLayout:
        grid = QGridLayout()
        grid.setHorizontalSpacing(14)
        for column, heading in enumerate(("", "Length", "Average", "Measured from clicks")):
            label = QLabel(heading)
            label.setProperty("role", "muted")
            grid.addWidget(label, 0, column)
        for row, (key, (name, between)) in enumerate(LENGTH_WORDS.items(), start=1):
            label = QLabel(name)
            label.setToolTip(between)
            box = QDoubleSpinBox()
            box.setRange(0.0, 1500.0)
            box.setDecimals(0)
            box.setSuffix(" mm")
            box.setSpecialValueText("not measured")
            box.setToolTip(f"In millimetres, {between}; 0: not measured")
            box.setAccessibleName(name)
            box.setMinimumWidth(box.fontMetrics().horizontalAdvance("not measured") + 44)
            box.valueChanged.connect(self._check)
            label.setBuddy(box)
            average, found = QLabel(), QLabel()
            average.setProperty("role", "muted")
            for column, widget in enumerate((label, box, average, found)):
                grid.addWidget(widget, row, column)
            self.lengths[key], self._averages[key], self._found[key] = box, average, found
        grid.setColumnStretch(3, 1)
        return grid

    def _fill_list(self, chosen: str | None) -> None:
        with QSignalBlocker(self.list):
            self.list.clear()
            used = self._subjects.used()
            for name in (None, *self._subjects.names()):
                item = QListWidgetItem(_RECORDED if name is None else name)
                item.setData(Qt.ItemDataRole.UserRole, name)
                font = item.font()
                font.setBold(name == used)
                font.setItalic(name is None)
                item.setFont(font)
                item.setToolTip("This project uses this subject." if name == used else "")
                self.list.addItem(item)
                if name == chosen:
                    self.list.setCurrentItem(item)
        self._on_chosen()

    # ---- what is shown

    def chosen(self) -> str | None:
        """The project's subject that is chosen in the list; None: the recording's."""
        item = self.list.currentItem()
        name: str | None = None if item is None else item.data(Qt.ItemDataRole.UserRole)
        return name

    def draft(self) -> Subject:
        """The subject as it is written in the form."""
        lengths = {key: box.value() / 1000.0 or None for key, box in self.lengths.items()}
        return Subject(self.name.text().strip(), **lengths)

    def show_subject(self, subject: Subject) -> None:
        """Write a subject into the form."""
        self.name.setText(subject.name)
        for key, box in self.lengths.items():
            box.setValue(1000.0 * (getattr(subject, key) or 0.0))
        self._check()

    @Slot()
    def _on_chosen(self) -> None:
        name = self.chosen()
        if name is None:
            self.show_subject(self._subjects.recorded or Subject())
        else:
            self.show_subject(self._subjects.get(name))
        self.delete_button.setEnabled(name is not None and not self._subjects.read_only)

    @Slot()
    def _check(self) -> None:
        draft = self.draft()
        average = average_of(draft)
        for key, label in self._averages.items():
            label.setText(f"{1000 * average[key]:.0f} mm")
        doubts = doubts_about(draft)
        self._say("\n".join(doubts), error=bool(doubts))
        unnamed = not draft.name and self._differs(draft)
        if unnamed and not doubts:
            self._say("Name the subject to keep these lengths.")
        self.use_button.setEnabled(not self._subjects.read_only and not unnamed)
        self.store_button.setEnabled(bool(draft.name))

    def _differs(self, draft: Subject) -> bool:
        """Whether the form says something else than the recording does."""
        recorded = self._subjects.recorded or Subject()
        return self.chosen() is not None or replace(draft, name="") != replace(recorded, name="")

    def _say(self, words: str, *, error: bool = False) -> None:
        self.words.setText(words)
        self.words.setProperty("role", "error" if error else "muted")
        self.words.style().unpolish(self.words)
        self.words.style().polish(self.words)

    # ---- what is done

    def _measure(self) -> None:
        """Measure beside the window's thread: there may be many clicks."""
        self.measure_button.setEnabled(False)
        self._tasks.begin("measuring segment lengths", self._measured_or_not, self._on_measured)

    def _measured_or_not(self, _task: Task) -> Measured | InputError:
        try:
            return self._subjects.measure()
        except InputError as error:
            return error

    @Slot(object)
    def _on_measured(self, found: Measured | InputError) -> None:
        self.measure_button.setEnabled(True)
        if isinstance(found, InputError):
            self._say(str(found), error=True)
            return
        self._measured = found
        for key, label in self._found.items():
            label.setText(found.words(key))
        self.take_button.setEnabled(True)
        self._say(
            "The distance from elbow to hand is divided between forearm and hand as in an average "
            "arm."
        )

    def _take_measured(self) -> None:
        if self._measured is not None:
            known = {key: getattr(self._measured.subject, key) for key in self.lengths}
            taken = {key: value for key, value in known.items() if value is not None}
            self.show_subject(replace(self.draft(), **taken))

    def _use(self) -> None:
        draft = self.draft()
        try:
            if not draft.name or (self.chosen() is None and not self._differs(draft)):
                self._subjects.use(None)
            else:
                self._subjects.save_and_use(draft, origin=self._origin(draft))
        except InputError as error:
            self._say(str(error), error=True)
            return
        self.accept()

    def _origin(self, draft: Subject) -> str:
        if self._measured is None:
            return "entered"
        found = [getattr(self._measured.subject, key) for key in self.lengths]
        own = [getattr(draft, key) for key in self.lengths]
        same = all(
            a is not None and b is not None and abs(a - b) < 0.001
            for a, b in zip(own, found, strict=True)
            if a is not None
        )
        return "measured from clicks" if same else "entered"

    def _delete(self) -> None:
        name = self.chosen()
        if name is None:
            return
        try:
            self._subjects.delete(name)
        except InputError as error:
            self._say(str(error), error=True)
            return
        self._fill_list(self._subjects.used())

    def _ask_to_load(self) -> None:
        chosen, _ = QFileDialog.getOpenFileName(self, "Load a subject", "", _FILES)
        if chosen:
            self.load(Path(chosen))

    def load(self, path: Path) -> None:
        """Write the subject of a file into the form."""
        try:
            self.show_subject(read_subject_file(path))
        except InputError as error:
            self._say(str(error), error=True)

    def _ask_to_store(self) -> None:
        name = f"{self.draft().name or 'subject'}.toml"
        chosen, _ = QFileDialog.getSaveFileName(self, "Save the subject", name, _FILES)
        if chosen:
            self.store(Path(chosen))

    def store(self, path: Path) -> None:
        """Write the subject of the form to a file."""
        path = path if path.suffix else path.with_suffix(".toml")
        try:
            write_subject(path, self.draft())
        except InputError as error:
            self._say(str(error), error=True)
            return
        self._say(f"Saved to {path}.")
