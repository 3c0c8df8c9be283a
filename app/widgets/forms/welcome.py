"""What one sees before a recording is open."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QFrame, QListWidget, QListWidgetItem, QPushButton, QWidget

from ..style.building import hbox, label, vbox
from ..style.theme import set_icon

_ABOUT = (
    "Track and analyse the movement of a person's upper body in recordings of several stereo or "
    "depth cameras."
)
_HINT = (
    "A recording is a folder with a recording.toml, its calibration and its images. Drop one onto "
    "this window to open it, or drop videos to make one of them."
)


class WelcomePage(QWidget):
    """Ways to begin: a recording of one's own, the demo, or one of the last ones."""

    open_wanted = Signal()
    demo_wanted = Signal()
    import_wanted = Signal()
    calibration_wanted = Signal()
    recent_chosen = Signal(object)
    """Its folder."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.open_button = _button("Open a recording …", "open")
        self.open_button.setToolTip("Open a recording folder.")
        self.demo_button = _button("Open and track demo", "run-tracker")
        self.demo_button.setToolTip(
            "Open four stereo views of a simulated person with known ground truth, and track them."
        )
        self.import_button = _button("Make a recording of videos …", "camera")
        self.import_button.setToolTip(
            "Make a recording folder of videos or images of one or more cameras."
        )
        self.calibrate_button = _button("Calibrate cameras …", "calibrate")
        self.calibrate_button.setToolTip("Calibrate cameras with pictures of a board.")
        self.recent = QListWidget()
        self.recent.setAccessibleName("Recent recordings")
        self.recent.setFrameShape(QFrame.Shape.NoFrame)
        self.recent.setAlternatingRowColors(False)
        self._none = label("No recent recordings.", "muted")
        self._lay_out()
        self.open_button.clicked.connect(self.open_wanted)
        self.demo_button.clicked.connect(self.demo_wanted)
        self.import_button.clicked.connect(self.import_wanted)
        self.calibrate_button.clicked.connect(self.calibration_wanted)
        self.recent.itemActivated.connect(self._on_recent)
        self.recent.itemClicked.connect(self._on_recent)

    def set_recent(self, recents: Sequence[Path]) -> None:
        """List what was opened last, the newest first."""
        self.recent.clear()
        for folder in recents:
            item = QListWidgetItem(f"{folder.name}    {folder.parent}")
            item.setData(Qt.ItemDataRole.UserRole, str(folder))
            item.setToolTip(str(folder))
            self.recent.addItem(item)
        self.recent.setVisible(bool(recents))
        self._none.setVisible(not recents)

    def _lay_out(self) -> None:
        title = label("stereotrack")
        font = title.font()
        font.setPointSizeF(font.pointSizeF() * 2.4)
        font.setWeight(font.Weight.DemiBold)
        title.setFont(font)
        self.recent.setMaximumHeight(240)
        column = vbox(
            None,
            title,
            label(_ABOUT),
            hbox(
                self.open_button,
                self.import_button,
                self.calibrate_button,
                self.demo_button,
                None,
                margins=(0, 8, 0, 16),
            ),
            label("Open recent", "heading"),
            self._none,
            (self.recent, 4),
            label(_HINT, "muted"),
            label("Press Ctrl+K to search all commands.", "muted"),
            None,
            spacing=12,
        )
        self.setLayout(hbox(None, (column, 3), None))

    def _on_recent(self, item: QListWidgetItem) -> None:
        self.recent_chosen.emit(Path(item.data(Qt.ItemDataRole.UserRole)))


def _button(text: str, icon_name: str) -> QPushButton:
    button = QPushButton(text)
    button.setMinimumHeight(36)
    set_icon(button, icon_name)
    return button
