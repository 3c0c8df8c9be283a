"""Last step: what says where up, north and the origin are, and where the calibration goes."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from PySide6.QtCore import QSignalBlocker
from PySide6.QtWidgets import QButtonGroup, QComboBox, QLabel, QRadioButton, QWidget

from stereotrack_core.calibrate.align import Alignment
from stereotrack_core.calibrate.report import place_table

from ....widgets.forms.form_dialog import ask_to_save, push_button
from ....widgets.forms.numbers import WholeNumberField
from ....widgets.style.building import allow, choice, hbox, label, label_of, vbox
from ....widgets.tables.table import PlainTable
from ..controller import CalibrationController
from ..saving import why_not_into
from ..state import AxesWay, Calibration

_WAYS: dict[AxesWay, tuple[str, str]] = {
    "first": (
        "The &first camera",
        "It is taken as level and looking south, and the origin is in it.",
    ),
    "board": (
        "The &board on the floor",
        "In one position the board lies on the floor, seen from above. Its middle is the origin, "
        "and its upper side points north.",
    ),
    "floor": (
        "The &floor in the depth of the recording",
        "The largest plane below the cameras. One camera is in the north.",
    ),
    "recording": (
        "The world of the open &recording",
        "The cameras are laid over those of the recording, so that landmarks and runs stay where "
        "they are.",
    ),
}
_AS_IT_IS = "The world as &it is", "The cameras of the open recording are not turned."
_ANOTHER_WORLD = (
    "Runs, references and landmarks in space stay in the world before. After saving into the "
    "recording, track again; clicks in the images stay right."
)
_INDENT = (24, 0, 0, 8)
_MOST_FRAMES = 10_000_000


class AxesPage(QWidget):
    """The ways to turn the world, each with what is to be chosen for it."""

    def __init__(self, calibration: CalibrationController) -> None:
        super().__init__()
        self._calibration = calibration
        self.ways: dict[AxesWay, QRadioButton] = {}
        self.about: dict[AxesWay, QLabel] = {}
        self.fields: dict[AxesWay, QWidget] = {
            "board": self._board_fields(),
            "floor": self._floor_fields(),
        }
        self.words, self.places = label("", "muted"), PlainTable("The world before and after")
        self.another_world, self.why_not = label(_ANOTHER_WORLD, "muted"), label("", "muted")
        self.file_button = push_button("&Save calibration …", self.ask, "Write a calibration.toml")
        self.into_button = push_button(
            "Save into the &recording", calibration.save_into_recording,
            "Replace the calibration of the open recording; the one before is kept beside it",
        )  # fmt: skip
        self.choices, group, column = QWidget(), QButtonGroup(self), vbox(spacing=6)
        for way, (title, about) in _WAYS.items():
            button = self.ways[way] = QRadioButton(title)
            group.addButton(button)
            button.clicked.connect(lambda _on=False, way=way: calibration.choose_way(way))
            column.addWidget(button)
            self.about[way] = label(about, "muted", margins=_INDENT)
            column.addWidget(self.about[way])
            if fields := self.fields.get(way):
                column.addWidget(fields)
        self.choices.setLayout(column)
        buttons = hbox(self.file_button, self.into_button, None)
        told = (self.places, self.words, self.another_world)
        self.setLayout(vbox(self.choices, *told, buttons, self.why_not, None, spacing=10))

    def _board_fields(self) -> QWidget:
        box = choice("Position of the board on the floor", (), "Position of the board")
        box.activated.connect(lambda: self._calibration.turn(board_frame=int(box.currentData())))
        self.board_frame, fields = box, QWidget()
        fields.setLayout(hbox(label_of(box, "Position"), box, None, margins=_INDENT))
        return fields

    def _floor_fields(self) -> QWidget:
        self.frame = WholeNumberField(
            minimum=0, maximum=_MOST_FRAMES, keyboardTracking=False,
            accessibleName="Frame that shows the floor",
        )  # fmt: skip
        self.frame.valueChanged.connect(lambda frame: self._calibration.turn(frame=frame))
        north = self.north = choice(
            "Camera in the north", (), "The camera that stands in the north"
        )
        north.activated.connect(lambda: self._calibration.turn(north=str(north.currentData())))
        fields = QWidget()
        fields.setLayout(
            hbox(
                label_of(self.frame, "Frame"), self.frame, label_of(north, "In the north"), north,
                None, margins=_INDENT,
            )
        )  # fmt: skip
        return fields

    # ---- showing

    def show_state(self, state: Calibration) -> None:
        self.choices.setVisible(bool(state.base))
        title, about = _AS_IT_IS if state.of_recording else _WAYS["first"]
        self.ways["first"].setText(title)
        self.about["first"].setText(about)
        for way, button in self.ways.items():
            button.setChecked(way == state.axes.way)
            allow(button, _why_no_way(way, state))
        for way, fields in self.fields.items():
            fields.setVisible(way == state.axes.way)
        self.ways["recording"].setVisible(not state.of_recording)
        self.about["recording"].setVisible(not state.of_recording)
        self._show_fields(state)
        turned = isinstance(state.alignment, Alignment)
        self.places.show_table(place_table(state.base, state.cameras) if turned else None)
        self.words.setText(_about(state))
        self.another_world.setVisible(turned and state.axes.way != "recording")
        why_not, there = why_not_into(state), state.recording is not None
        self.file_button.setEnabled(not state.why_not_save())
        self.into_button.setVisible(there)
        self.into_button.setEnabled(not why_not)
        self.why_not.setVisible(there and bool(why_not))
        self.why_not.setText(f"It cannot be saved into the recording. {why_not}")

    def _show_fields(self, state: Calibration) -> None:
        axes = state.axes
        boards = {frame: f"picture {frame}" for frame in state.board_frames}
        _fill(self.board_frame, boards, axes.board_frame)
        cameras = {"": "that of the first view", **{name: name for name in state.recorded}}
        _fill(self.north, cameras, axes.north)
        with QSignalBlocker(self.frame):
            self.frame.setValue(axes.frame)

    def ask(self) -> None:
        state, start = self._calibration.state, Path.home()
        if state.sources:
            start = Path(state.sources[0].place).parent
        elif state.recording is not None:
            start = state.recording.folder.parent
        proposed, files = start / "calibration.toml", "Calibration (*.toml)"
        ask_to_save(self, "Save the calibration", proposed, files, self._calibration.save)


def _fill(box: QComboBox, options: Mapping[Any, str], chosen: object) -> None:
    """Offer options by their keys; the list is rebuilt only if it differs."""
    with QSignalBlocker(box):
        if [(box.itemData(k), box.itemText(k)) for k in range(box.count())] != [*options.items()]:
            box.clear()
            for key, text in options.items():
                box.addItem(text, key)
        box.setCurrentIndex(box.findData(chosen))


def _why_no_way(way: AxesWay, state: Calibration) -> str:
    there = any(name in state.recorded for name in state.base)
    views = () if state.recording is None else state.recording.views
    if way == "recording" and not there:
        return "Open the recording of these cameras."
    if way == "floor" and (not there or all(view.kind == "mono" for view in views)):
        return "Open a recording of these cameras with stereo or depth views."
    if way == "board" and not state.board_frames:
        return "Choose pictures of the board, and find it in them (steps 1 and 2)."
    return ""


def _about(state: Calibration) -> str:
    """Accuracy of the alignment and height of the lowest camera."""
    if not isinstance(state.alignment, Alignment):
        return ""
    found, said = state.alignment, []
    if state.axes.way == "recording":
        said.append(f"The cameras lie {1000 * found.spread_m:.1f} mm beside the recording's.")
    if state.axes.way == "floor":
        spread = 1000.0 * found.spread_m
        said.append(f"{found.points} points lie on the floor, within {spread:.0f} mm.")
    if state.axes.way not in ("first", "recording"):
        low = min(camera.position_world[2] for camera in state.cameras.values())
        said.append(f"The lowest camera stands {low:.2f} m above the floor.")
    return " ".join(said)
