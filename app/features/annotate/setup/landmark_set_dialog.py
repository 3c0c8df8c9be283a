"""Edit which landmarks are clicked."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QSignalBlocker, Slot
from PySide6.QtGui import QColor
from PySide6.QtWidgets import (
    QColorDialog,
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from stereotrack_core.annotation.landmark_set import read_landmark_set, write_landmark_set
from stereotrack_core.errors import InputError

from ....widgets.forms.body_sketch import BodySketch
from ....widgets.tables.landmark_table import LandmarkTable
from ....widgets.tables.table import selected_rows
from .landmark_sets import Draft, LandmarkSets, sketch_of

_FILES = "Set of landmarks (*.toml)"


class LandmarkSetDialog(QDialog):
    """A table of the landmarks beside a body that shows where they are."""

    def __init__(self, sets: LandmarkSets, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle("Landmark set")
        self._sets = sets
        self.choice = QComboBox()
        self.choice.setAccessibleName("Landmark sets of the project")
        self.name = QLineEdit()
        self.name.setAccessibleName("Name of the landmark set")
        self.name.setToolTip("A new name creates a new set; the old one is kept.")
        self.table = LandmarkTable()
        self.table.rows_model.editable = not sets.read_only
        self.sketch = BodySketch()
        self.words = QLabel()
        self.words.setWordWrap(True)
        self.warning = QLabel()
        self.warning.setWordWrap(True)
        self.warning.setProperty("role", "muted")
        self._draft = sets.draft(sets.used().name)
        self._lay_out()
        with QSignalBlocker(self.choice):
            self.choice.addItems(list(sets.names()))
            self.choice.setCurrentText(self._draft.name)
        self.choice.currentTextChanged.connect(self._on_chosen)
        self.name.textEdited.connect(self._on_named)
        self.table.rows_model.edited.connect(self._on_edited)
        self.table.colour_requested.connect(self._ask_for_colour)
        self.table.selectionModel().selectionChanged.connect(lambda *_: self._draw())
        self.show_draft(self._draft)

    def _lay_out(self) -> None:
        self.add_button = self._button("&Add", lambda: self._change(self._draft.added()))
        self.remove_button = self._button("&Remove", self._remove)
        self.up_button = self._button("&Up", lambda: self._move(-1))
        self.down_button = self._button("D&own", lambda: self._move(1))
        self.load_button = self._button("&Import …", self._ask_to_load)
        self.store_button = self._button("&Export …", self._ask_to_store)
        top = QHBoxLayout()
        top.addWidget(QLabel("Set"))
        top.addWidget(self.choice)
        top.addSpacing(12)
        top.addWidget(QLabel("Name"))
        top.addWidget(self.name, 1)
        top.addWidget(self.load_button)
        top.addWidget(self.store_button)
        row = QHBoxLayout()
        for button in (self.add_button, self.remove_button, self.up_button, self.down_button):
            row.addWidget(button)
            button.setEnabled(not self._sets.read_only)
        row.addStretch(1)
        middle = QHBoxLayout()
        left = QVBoxLayout()
        left.addWidget(self.table, 1)
        left.addLayout(row)
        middle.addLayout(left, 1)
        middle.addWidget(self.sketch)
        self.buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Cancel)
        self.use_button = self.buttons.addButton("Use", QDialogButtonBox.ButtonRole.AcceptRole)
        self.buttons.accepted.connect(self._use)
        self.buttons.rejected.connect(self.reject)
        layout = QVBoxLayout(self)
        layout.addLayout(top)
        layout.addLayout(middle, 1)
        layout.addWidget(self.words)
        layout.addWidget(self.warning)
        layout.addWidget(self.buttons)
        self.resize(1230, 520)

    def _button(self, text: str, do: Callable[[], None]) -> QPushButton:
        button = QPushButton(text)
        button.setAutoDefault(False)
        button.clicked.connect(lambda _checked=False: do())
        return button

    @property
    def draft(self) -> Draft:
        """The set as it is written in the table."""
        return self._draft

    def show_draft(self, draft: Draft) -> None:
        """Show a set, and say what is wrong about it."""
        self._draft = draft
        problem = draft.problem()
        wrong = -1 if problem is None else self._row_of(problem)
        self.table.rows_model.show_landmarks(draft.landmarks, wrong)
        if self.name.text() != draft.name:
            self.name.setText(draft.name)
        count = len(draft.landmarks)
        self._say("" if problem is None else str(problem), error=problem is not None)
        if problem is None and count > 9:
            self._say(f"The keys 1 to 9 choose the first nine of {count} landmarks.")
        self.warning.setText(self._sets.warning(draft))
        self.warning.setVisible(bool(self.warning.text()))
        self.use_button.setEnabled(problem is None and not self._sets.read_only)
        self.store_button.setEnabled(problem is None)
        self._draw()

    def _row_of(self, problem: InputError) -> int:
        names = [one.name for one in self._draft.landmarks]
        named = problem.where.rpartition(", ")[2]
        if named in names:
            return names.index(named)
        twice = [name for name in names if names.count(name) > 1]
        return names.index(twice[0]) if twice else -1

    def _draw(self) -> None:
        rows = selected_rows(self.table)
        chosen = self._draft.landmarks[rows[0]].label if rows else ""
        self.sketch.show_sketch(sketch_of(self._draft.landmarks), chosen)
        self.remove_button.setEnabled(bool(rows) and not self._sets.read_only)

    def _say(self, words: str, *, error: bool = False) -> None:
        self.words.setText(words)
        self.words.setVisible(bool(words))
        self.words.setProperty("role", "error" if error else "muted")
        self.words.style().unpolish(self.words)
        self.words.style().polish(self.words)

    # ---- what is done

    @Slot(str)
    def _on_chosen(self, name: str) -> None:
        self._change(self._sets.draft(name))

    @Slot(str)
    def _on_named(self, name: str) -> None:
        self._change(Draft(name, self._draft.landmarks))

    @Slot(int, str, object)
    def _on_edited(self, row: int, field: str, value: object) -> None:
        self._change(self._draft.changed(row, **{field: value}))

    def _change(self, draft: Draft) -> None:
        self.show_draft(draft)

    def _remove(self) -> None:
        self._change(self._draft.without(selected_rows(self.table)))

    def _move(self, by: int) -> None:
        rows = selected_rows(self.table)
        if len(rows) == 1:
            self._change(self._draft.moved(rows[0], by))
            self.table.selectRow(min(max(rows[0] + by, 0), len(self._draft.landmarks) - 1))

    @Slot(int)
    def _ask_for_colour(self, row: int) -> None:
        dialog = QColorDialog(QColor(self._draft.landmarks[row].colour), self)
        dialog.colorSelected.connect(lambda colour: self._on_edited(row, "colour", colour.name()))
        dialog.open()

    def _use(self) -> None:
        try:
            self._sets.save_and_use(self._draft)
        except InputError as error:
            self._say(str(error), error=True)
            return
        self.accept()

    def _ask_to_load(self) -> None:
        chosen, _ = QFileDialog.getOpenFileName(self, "Import landmark set", "", _FILES)
        if chosen:
            self.load(Path(chosen))

    def load(self, path: Path) -> None:
        """Show the set of a file; nothing is kept before it is used."""
        try:
            landmarks = read_landmark_set(path)
        except InputError as error:
            self._say(str(error), error=True)
            return
        self._change(Draft(landmarks.name, landmarks.landmarks))

    def _ask_to_store(self) -> None:
        name = f"{self._draft.name or 'landmarks'}.toml"
        chosen, _ = QFileDialog.getSaveFileName(self, "Export landmark set", name, _FILES)
        if chosen:
            self.store(Path(chosen))

    def store(self, path: Path) -> None:
        """Write the set to a file."""
        path = path if path.suffix else path.with_suffix(".toml")
        try:
            write_landmark_set(path, self._draft.checked())
        except InputError as error:
            self._say(str(error), error=True)
            return
        self._say(f"Saved to {path}.")
