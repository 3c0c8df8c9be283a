"""The last steps: the axes of the world, and where the calibration goes."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QSignalBlocker, Slot
from PySide6.QtWidgets import QButtonGroup, QRadioButton, QWidget

from stereotrack_core.calibrate.align import Alignment
from stereotrack_core.calibrate.changes import change_table

from ....widgets.forms.form_dialog import ask_to_save, push_button
from ....widgets.style.building import choice, hbox, label, vbox
from ....widgets.tables.plain import PlainTable
from ..controller import CalibrationController
from ..saving import why_not_into
from ..state import AxesWay, Calibration

_WAYS: dict[AxesWay, tuple[str, str]] = {
    "first": (
        "The &first camera",
        "It is taken as level and looking south, and the origin is in it. The command stereotrack "
        "calibrate align can turn the calibration later, also by three points or a person.",
    ),
    "board": (
        "The &board on the floor",
        "In one position the board lies on the floor, seen from above. Its middle is the origin, "
        "and its upper side points north.",
    ),
    "floor": (
        "The &floor in the depth of the recording",
        "The largest plane below the cameras in the frame that is shown. The camera of the first "
        "view is in the north.",
    ),
    "recording": (
        "The world of the open &recording",
        "The cameras are laid over those of the recording, so that landmarks and runs stay where "
        "they are.",
    ),
}


class AxesPage(QWidget):
    """What says where up and north are."""

    def __init__(self, calibration: CalibrationController) -> None:
        super().__init__()
        self._calibration = calibration
        self.ways: dict[AxesWay, QRadioButton] = {}
        self.frame = choice("Position of the board on the floor", (), "Position of the board")
        self.words = label("", "muted")
        group, column = QButtonGroup(self), vbox(spacing=6)
        for way, (title, about) in _WAYS.items():
            button = self.ways[way] = QRadioButton(title)
            group.addButton(button)
            button.clicked.connect(self._on_chosen)
            column.addWidget(button)
            column.addWidget(label(about, "muted", margins=(24, 0, 0, 4)))
            if way == "board":
                row = hbox(label("Position", wraps=False), self.frame, None, margins=(24, 0, 0, 8))
                column.addLayout(row)
        self.frame.activated.connect(self._on_frame)
        self.setLayout(vbox(column, self.words, None, spacing=12))

    def show_state(self, state: Calibration) -> None:
        """Show what is chosen, and what it comes to."""
        for way, button in self.ways.items():
            button.setChecked(way == state.axes)
        there = state.recording is not None and any(
            name in state.recording.cameras for name in state.cameras
        )
        deep = there and state.recording is not None and state.recording.has_depth
        for way, can, needed in (
            ("recording", there, "the recording of these cameras"),
            ("floor", deep, "a recording of these cameras with stereo or depth views"),
        ):
            self.ways[way].setEnabled(can)
            self.ways[way].setToolTip("" if can else f"Unavailable: open {needed}.")
        boards = {} if state.world is None else state.world.result.boards
        with QSignalBlocker(self.frame):
            if [self.frame.itemData(k) for k in range(self.frame.count())] != list(boards):
                self.frame.clear()
                for frame in boards:
                    self.frame.addItem(f"picture {frame}", frame)
            self.frame.setCurrentIndex(self.frame.findData(state.floor_frame))
        self.words.setText(_about(state))

    @Slot()
    def _on_chosen(self) -> None:
        way = next(way for way, button in self.ways.items() if button.isChecked())
        self._calibration.set_axes(way, self._calibration.state.floor_frame)

    @Slot()
    def _on_frame(self) -> None:
        self._calibration.set_axes("board", int(self.frame.currentData()))


def _about(state: Calibration) -> str:
    """By how much the world is turned, and where the cameras come to stand."""
    said, turned = [], isinstance(state.alignment, Alignment)
    if isinstance(state.alignment, Alignment):
        said.append(f"The upward axis was turned by {state.alignment.tilt_deg:.1f} degrees.")
        if state.axes == "recording":
            apart = 1000.0 * state.alignment.spread_m
            said.append(f"The cameras lie {apart:.1f} mm beside those of the recording.")
    if state.axes == "floor" and state.floor is not None:
        spread = 1000.0 * state.floor.spread_m
        said.append(f"{state.floor.points} points lie on the floor, within {spread:.0f} mm.")
    if state.axes in ("board", "floor") and turned and state.cameras:
        low = min(camera.position_world[2] for camera in state.cameras.values())
        said.append(
            f"The lowest camera stands {low:.2f} m above the floor."
            if low > 0.0
            else "A camera stands below the floor. Choose another position of the board."
        )
    return " ".join(said)


class SavePage(QWidget):
    """Before and after, and where the calibration goes."""

    def __init__(self, calibration: CalibrationController) -> None:
        super().__init__()
        self._calibration = calibration
        self.changes = PlainTable("Before and after")
        self.about = label("", "muted")
        self.file_button = push_button(
            "&Save calibration …", self.ask, "Write a calibration.toml, and a report beside it"
        )
        self.into_button = push_button(
            "Save into the &recording", calibration.save_into_recording,
            "Replace the calibration of the open recording; the one before is kept beside it",
        )  # fmt: skip
        self.why_not = label("", "muted")
        words = (
            "The calibration holds the lens and the place of every camera. The report beside it is "
            "a page with the verdict and all tables."
        )
        buttons = hbox(self.file_button, self.into_button, None)
        self.setLayout(
            vbox(self.changes, self.about, label(words, "muted"), buttons, self.why_not, None,
                 spacing=10)
        )  # fmt: skip

    def show_state(self, state: Calibration) -> None:
        """Show what the new calibration changes."""
        self.changes.show_table(change_table(state.changes) if state.changes else None)
        self.about.setVisible(bool(state.changes))
        self.about.setText(
            "Before: the cameras of the open recording, with the boards placed as well as they "
            "allow. The two calibrations are laid over each other by all cameras."
        )
        why_not = why_not_into(state)
        self.into_button.setVisible(state.recording is not None)
        self.into_button.setEnabled(not why_not)
        self.why_not.setVisible(state.recording is not None and bool(why_not))
        self.why_not.setText(f"It cannot be saved into the recording. {why_not}")

    def ask(self) -> None:
        """Ask for a file, and write it."""
        state = self._calibration.state
        start = Path(state.sources[0].place).parent if state.sources else Path.home()
        ask_to_save(
            self, "Save the calibration", start / "calibration.toml", "Calibration (*.toml)",
            self._calibration.save,
        )  # fmt: skip
