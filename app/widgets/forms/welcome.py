"""What one sees before a recording is open."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFrame, QListWidget, QListWidgetItem, QPushButton, QWidget

from ..style.building import hbox, label, vbox
from ..style.theme import set_icon
from .form_dialog import push_button

_ABOUT = (
    "Track and analyse the movement of a person's upper body in recordings of several stereo or "
    "depth cameras."
)
_HINT = (
    "A recording is a folder with a recording.toml, its calibration and its images. Drop one onto "
    "this window to open it, or drop videos to make one of them."
)
_WAYS = (
    ("open", "Open a recording …", "open", "Open a recording folder."),
    (
        "import_recording", "Make a recording of videos …", "camera",
        "Make a recording folder of videos or images of one or more cameras.",
    ),
    (
        "calibrate", "Calibrate cameras …", "calibrate",
        "Calibrate cameras with pictures of a board.",
    ),
    (
        "demo", "Open and track demo", "run-tracker",
        "Open four stereo views of a simulated person with known ground truth, and track them.",
    ),
)  # fmt: skip


class WelcomePage(QWidget):
    """Ways to begin: a recording of one's own, the demo, or one of the last ones."""

    def __init__(self, do: Callable[[str], object], open_recent: Callable[[Path], object]) -> None:
        super().__init__()
        self.open_button, self.import_button, self.calibrate_button, self.demo_button = (
            _button(text, icon, tip, partial(do, name)) for name, text, icon, tip in _WAYS
        )
        self.recent = QListWidget()
        self.recent.setAccessibleName("Recent recordings")
        self.recent.setFrameShape(QFrame.Shape.NoFrame)
        self.recent.setAlternatingRowColors(False)
        self._none = label("No recent recordings.", "muted")
        self._lay_out()
        for chosen in (self.recent.itemActivated, self.recent.itemClicked):
            chosen.connect(lambda item: open_recent(Path(item.data(Qt.ItemDataRole.UserRole))))

    def set_recent(self, recents: Sequence[Path]) -> None:
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
        ways = (self.open_button, self.import_button, self.calibrate_button, self.demo_button)
        hints = (label(_HINT, "muted"), label("Press Ctrl+K to search all commands.", "muted"))
        column = vbox(
            None, title, label(_ABOUT), hbox(*ways, None, margins=(0, 8, 0, 16)),
            label("Open recent", "heading"), self._none, (self.recent, 4), *hints, None, spacing=12,
        )  # fmt: skip
        self.setLayout(hbox(None, (column, 3), None))


def _button(text: str, icon: str, tip: str, do: Callable[[], object]) -> QPushButton:
    button = push_button(text, do, tip)
    button.setMinimumHeight(36)
    set_icon(button, icon)
    return button
