"""Last step: the name and the folder of the recording, and making it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from PySide6.QtCore import Slot
from PySide6.QtWidgets import QFormLayout, QProgressBar, QWizardPage

from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.recording.importing.choices import Choices, doubts_about
from stereotrack_core.recording.importing.files import files_of
from stereotrack_core.recording.importing.making import calibration_notes, check_place

from ....widgets.forms.form_dialog import ask_for_folder, line_edit, push_button, say_in
from ....widgets.style.building import hbox, label, label_of, vbox
from .looking import Looked

_MB = 1e6


class PlacePage(QWizardPage):
    """Name, folder, what will be written, and the progress of that."""

    def __init__(self, looked: Looked) -> None:
        super().__init__()
        self.setTitle("Folder")
        self._choices = looked.proposed
        self.name = line_edit("Name", looked.proposed.name, tip="Name of the recording")
        self.folder = line_edit("Folder", str(looked.place), tip="Folder of the recording")
        browse = push_button("&Choose …", self._ask, "Choose another folder")
        self.summary = label("", "muted")
        self.words = label()
        self.progress = QProgressBar()
        self.progress.setAccessibleName("Progress")
        self.progress.hide()
        form = QFormLayout()
        form.addRow("&Name", self.name)
        form.addRow(label_of(self.folder, "&Folder"), hbox((self.folder, 1), browse))
        self.setLayout(vbox(form, self.summary, self.progress, self.words, None))
        self.name.textChanged.connect(self._on_changed)
        self.folder.textChanged.connect(self._on_changed)

    def begin(self, choices: Choices) -> None:
        """Say what will be made of these choices."""
        self._choices = choices
        self._on_changed()

    def place(self) -> Path:
        """The folder that is written here."""
        return Path(self.folder.text().strip()).expanduser()

    def chosen(self, choices: Choices) -> Choices:
        """The choices with what is written here."""
        return replace(choices, name=self.name.text().strip())

    def isComplete(self) -> bool:
        return not self._problem()

    def _problem(self) -> str:
        if not self.name.text().strip() or not self.folder.text().strip():
            return "Enter a name and a folder."
        try:
            check_place(self._choices, self.place())
        except (InputError, OSError) as error:
            return str(error)
        return ""

    def _ask(self) -> None:
        start = self.place().parent
        ask_for_folder(self, "Folder of the recording", start, lambda path: (
            self.folder.setText(str(path))))  # fmt: skip

    @Slot()
    def _on_changed(self) -> None:
        problem = self._problem()
        say_in(self.words, problem, error=True)
        self.summary.setText("" if problem else self._what_is_written())
        self.completeChanged.emit()

    def _what_is_written(self) -> str:
        files = files_of(self._choices.used(), self.place())
        stay = sum(one.how == "stay" for one in files)
        copied = {path for one in files if one.how == "copy"
                  for path in (one.use.source.images or (one.use.source.path,))}  # fmt: skip
        converted = [one for one in files if one.how == "convert"]
        views = len({use.view for use in self._choices.used()})
        parts = [f"The recording has {counted(views, 'view')}."]
        if stay:
            parts.append(f"{counted(stay, 'stream')} stay where they are.")
        if copied:
            size = sum(path.stat().st_size for path in copied) / _MB
            parts.append(f"{counted(len(copied), 'file')} will be copied ({size:.0f} MB).")
        if converted:
            names = ", ".join(one.frames for one in converted)
            parts.append(f"Written again: {names}.")
        parts += [f"{one[0].upper()}{one[1:]}." for one in calibration_notes(self._choices)]
        parts += doubts_about(self._choices)
        return " ".join(parts)
