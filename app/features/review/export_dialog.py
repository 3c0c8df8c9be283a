"""What of the episodes is written where."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import Qt, Signal, Slot
from PySide6.QtWidgets import (
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QFormLayout,
    QLineEdit,
    QPushButton,
    QSpinBox,
    QWidget,
)

from ...widgets.style.building import choice, hbox, label, vbox

_FRAMES = 5


@dataclass(frozen=True)
class ExportWish:
    """What a person wants written."""

    video: bool
    """A video; else strips of pictures."""
    only_chosen: bool
    """The chosen episode alone; else all that are listed."""
    view: str | None
    """Of the strips; None takes the one that shows each episode best."""
    count: int
    """Frames of each strip."""
    path: Path
    """The video, or the folder of the strips."""


class ExportDialog(QDialog):
    """Which episodes, as what, to where; says what becomes of files that are there."""

    wished = Signal(object)
    """ExportWish."""

    def __init__(
        self,
        *,
        video: bool,
        views: Sequence[str],
        listed: int,
        chosen: bool,
        proposed: Path,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self._video = video
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(f"Export {'video' if video else 'image strips'} of failures")
        self.setMinimumWidth(460)
        self.which = QComboBox()
        if chosen:
            self.which.addItem("the selected failure", True)
        every = f"all {listed} listed failures" if listed > 1 else "the listed failure"
        self.which.addItem(every, False)
        named = [(name, name) for name in views]
        self.view = choice("View", [("", "best view of each failure"), *named])
        self.count = QSpinBox(minimum=2, maximum=12, value=_FRAMES)
        self.path = QLineEdit(str(proposed.with_suffix(".mp4") if video else proposed))
        self.said = label("", "muted")
        self.buttons = QDialogButtonBox(
            QDialogButtonBox.StandardButton.Save | QDialogButtonBox.StandardButton.Cancel
        )
        self.buttons.accepted.connect(self._on_accepted)
        self.buttons.rejected.connect(self.reject)
        self.path.textChanged.connect(self._check)
        browse = QPushButton("Choose …")
        browse.setAutoDefault(False)
        browse.clicked.connect(self._browse)
        form = QFormLayout()
        form.addRow("Failures", self.which)
        if not video:
            form.addRow("View", self.view)
            form.addRow("Frames per strip", self.count)
        form.addRow("File" if video else "Folder", hbox((self.path, 1), browse))
        self.setLayout(vbox(form, self.said, self.buttons, margins=(9, 9, 9, 9)))
        self._check()

    @Slot()
    def _browse(self) -> None:
        if self._video:
            chosen, _ = QFileDialog.getSaveFileName(
                self, "Export video of failures", self.path.text(), "Video (*.mp4)"
            )
        else:
            chosen = QFileDialog.getExistingDirectory(
                self, "Folder for image strips", str(Path(self.path.text()).parent)
            )
        if chosen:
            self.path.setText(chosen)

    @Slot()
    def _check(self) -> None:
        wrong, note = _about(self.path.text().strip(), self._video)
        self.said.setText(wrong or note)
        self.buttons.button(QDialogButtonBox.StandardButton.Save).setEnabled(not wrong)

    @Slot()
    def _on_accepted(self) -> None:
        self.wished.emit(
            ExportWish(
                video=self._video,
                only_chosen=bool(self.which.currentData()),
                view=str(self.view.currentData()) or None,
                count=self.count.value(),
                path=Path(self.path.text().strip()).expanduser(),
            )
        )
        self.accept()


def _about(text: str, video: bool) -> tuple[str, str]:
    """What is wrong about a place, and what will become of it."""
    path = Path(text).expanduser()
    if not text:
        return "Enter where to write the output.", ""
    if video:
        if path.suffix.lower() != ".mp4":
            return "The name of a video must end in .mp4.", ""
        if path.is_dir() or not path.parent.is_dir():
            return "This folder does not exist.", ""
        note = "The existing video will be replaced." if path.exists() else ""
        return "", note or "All views side by side, with the model outline and the errors."
    if path.is_file():
        return "This is a file. Choose a folder.", ""
    if not path.parent.is_dir():
        return f"The folder {path.parent} does not exist.", ""
    note = "" if path.is_dir() else "The folder will be created. "
    return "", f"{note}One PNG per failure. Strips of the same name will be replaced."
