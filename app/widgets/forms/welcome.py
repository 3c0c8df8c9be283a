"""What one sees before a recording is open."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QFrame,
    QHBoxLayout,
    QLabel,
    QListWidget,
    QListWidgetItem,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from ..style.icons import set_icon

_ABOUT = (
    "Track and analyse the movement of a person's upper body in recordings of several stereo or "
    "depth cameras."
)
_HINT = (
    "A recording is a folder with a recording.toml, its calibration and its images. Drop one onto "
    "this window to open it."
)


class WelcomePage(QWidget):
    """Ways to begin: a recording of one's own, the demo, or one of the last ones.

    Signals
    -------
    open_wanted : ()
    demo_wanted : ()
    recent_chosen : Path
    """

    open_wanted = Signal()
    demo_wanted = Signal()
    recent_chosen = Signal(object)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.open_button = _button("Open a recording …", "open")
        self.demo_button = _button("Create and track demo", "run-tracker")
        self.demo_button.setToolTip(
            "Render four stereo views of a moving person with known ground truth, then track them."
        )
        self.recent = QListWidget()
        self.recent.setAccessibleName("Recent recordings")
        self.recent.setFrameShape(QFrame.Shape.NoFrame)
        self.recent.setAlternatingRowColors(False)
        self._none = QLabel("No recent recordings.")
        self._none.setProperty("role", "muted")
        self._lay_out()
        self.open_button.clicked.connect(self.open_wanted)
        self.demo_button.clicked.connect(self.demo_wanted)
        self.recent.itemActivated.connect(self._on_recent)
        self.recent.itemClicked.connect(self._on_recent)

    def set_recent(self, folders: Sequence[Path]) -> None:
        """List the recordings opened last, the newest first."""
        self.recent.clear()
        for folder in folders:
            item = QListWidgetItem(f"{folder.name}    {folder.parent}")
            item.setData(Qt.ItemDataRole.UserRole, str(folder))
            item.setToolTip(str(folder))
            self.recent.addItem(item)
        self.recent.setVisible(bool(folders))
        self._none.setVisible(not folders)

    def _lay_out(self) -> None:
        title = QLabel("stereotrack")
        font = title.font()
        font.setPointSizeF(font.pointSizeF() * 2.4)
        font.setWeight(font.Weight.DemiBold)
        title.setFont(font)
        buttons = QHBoxLayout()
        buttons.addWidget(self.open_button)
        buttons.addWidget(self.demo_button)
        buttons.addStretch(1)
        column = QVBoxLayout()
        column.setSpacing(12)
        column.addStretch(1)
        column.addWidget(title)
        column.addWidget(_words(_ABOUT))
        column.addSpacing(8)
        column.addLayout(buttons)
        column.addSpacing(16)
        column.addWidget(_heading("Open recent"))
        column.addWidget(self._none)
        self.recent.setMaximumHeight(240)
        column.addWidget(self.recent, 4)
        column.addWidget(_words(_HINT, muted=True))
        column.addWidget(_words("Press Ctrl+K to search all commands.", muted=True))
        column.addStretch(1)
        row = QHBoxLayout(self)
        row.addStretch(1)
        row.addLayout(column, 3)
        row.addStretch(1)

    def _on_recent(self, item: QListWidgetItem) -> None:
        self.recent_chosen.emit(Path(item.data(Qt.ItemDataRole.UserRole)))


def _button(text: str, icon_name: str) -> QPushButton:
    button = QPushButton(text)
    button.setMinimumHeight(36)
    set_icon(button, icon_name)
    return button


def _words(text: str, *, muted: bool = False) -> QLabel:
    label = QLabel(text)
    label.setWordWrap(True)
    if muted:
        label.setProperty("role", "muted")
    return label


def _heading(text: str) -> QLabel:
    label = QLabel(text)
    label.setProperty("role", "heading")
    return label
