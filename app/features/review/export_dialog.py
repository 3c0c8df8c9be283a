"""What of the failures is written where."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from PySide6.QtCore import Qt, Slot
from PySide6.QtWidgets import QComboBox, QFormLayout, QWidget

from ...widgets.forms.form_dialog import (
    FormDialog,
    ask_for_folder,
    line_edit,
    push_button,
)
from ...widgets.forms.numbers import WholeNumberField
from ...widgets.style.building import choice, hbox

_FRAMES = 5


class ExportDialog(FormDialog):
    """Which failures, as what, to where; says what becomes of files that are there."""

    def __init__(
        self,
        *,
        views: Sequence[str],
        listed: int,
        chosen: bool,
        proposed: Path,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__("Export image strips of failures", "Save", self.accept, parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.which = QComboBox()
        if chosen:
            self.which.addItem("the selected failure", True)
        every = f"all {listed} listed failures" if listed > 1 else "the listed failure"
        self.which.addItem(every, False)
        named = [(name, name) for name in views]
        self.view = choice("View", [("", "best view of each failure"), *named])
        self.count = WholeNumberField(minimum=2, maximum=12, value=_FRAMES)
        self.path = line_edit("Path", str(proposed))
        self.path.textChanged.connect(self._check)
        form = QFormLayout()
        form.addRow("Failures", self.which)
        form.addRow("View", self.view)
        form.addRow("Frames per strip", self.count)
        where = hbox((self.path, 1), push_button("Choose …", self._ask))
        form.addRow("Folder", where)
        self.lay_out(form, size=(460, 160))
        self._check()

    @property
    def target(self) -> Path:
        """The folder of the strips."""
        return Path(self.path.text().strip()).expanduser()

    def _ask(self) -> None:
        def take(path: Path) -> None:
            self.path.setText(str(path))

        ask_for_folder(self, "Folder for image strips", self.target.parent, take)

    @Slot()
    def _check(self) -> None:
        wrong, note = _about(self.path.text().strip())
        self.say(wrong or note)
        self.accept_button.setEnabled(not wrong)


def _about(text: str) -> tuple[str, str]:
    """What is wrong about a place, and what will become of it."""
    path = Path(text).expanduser()
    if not text:
        return "Enter where to write the output.", ""
    if path.is_file():
        return "This is a file. Choose a folder.", ""
    if not path.parent.is_dir():
        return f"The folder {path.parent} does not exist.", ""
    note = "" if path.is_dir() else "The folder will be created. "
    return "", f"{note}One PNG per failure. Strips of the same name will be replaced."
