"""First and last step: pictures and board; where up and north are, and saving."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtWidgets import (
    QButtonGroup,
    QComboBox,
    QFormLayout,
    QGroupBox,
    QLabel,
    QRadioButton,
    QWidget,
)

from stereotrack_core.calibrate.align import Alignment
from stereotrack_core.calibrate.board import DICTIONARIES, Board, charuco, chessboard
from stereotrack_core.calibrate.report import place_table
from stereotrack_core.errors import InputError
from stereotrack_core.recording.stream_files import VIDEO_SUFFIXES

from ...widgets.forms.form_dialog import (
    ask_for_folder,
    ask_to_open,
    ask_to_save,
    files_of,
    push_button,
    say_in,
)
from ...widgets.forms.numbers import NumberField, WholeNumberField
from ...widgets.style.building import allow, choice, hbox, holder, label, label_of, vbox
from ...widgets.tables.table import STRETCH, Cell, Column, PlainTable
from ...widgets.tables.trees import CellTree, TreeRow
from .controller import CalibrationController
from .state import AxesWay, Calibration, why_not_into

_KINDS = (("chessboard", "Chessboard"), ("charuco", "ChArUco board"))
_COUNTS = {
    "chessboard": ("Inner corners", "Corners between four squares, along each side: one number "
                   "should be even and the other odd"),
    "charuco": ("Squares", "Squares along each side"),
}  # fmt: skip

_SOURCES = (
    Column("Camera", "Double-click a name to change it", width=120),
    Column("Pictures", width=STRETCH),
)


class BoardPage(QWidget):
    """Sources of the pictures above, the board below."""

    def __init__(self, calibration: CalibrationController) -> None:
        super().__init__()
        self._calibration = calibration
        self.sources = CellTree(
            "Pictures of each camera",
            _SOURCES,
            lambda camera, _ticked, name: calibration.rename(camera, name),
            lambda camera: calibration.choose(camera, 0),
        )
        self.sources.setRootIsDecorated(False)
        triggers = CellTree.EditTrigger
        self.sources.setEditTriggers(triggers.DoubleClicked | triggers.EditKeyPressed)
        self.sources.setMinimumHeight(80)
        self.sources.setTextElideMode(Qt.TextElideMode.ElideMiddle)
        self.setLayout(vbox((self._pictures(), 1), self._board(), spacing=8))

    def show_state(self, state: Calibration) -> None:
        self.sources.show_rows([
            TreeRow((Cell(one.camera, value=one.camera, editable=True), Cell(one.place, one.place)))
            for one in state.sources
        ])  # fmt: skip
        self.recording_button.setVisible(state.recording is not None)
        if state.recording is not None:
            self.recording_button.setText(f"Cameras of “{state.recording.name}”")
        self.remove_button.setEnabled(bool(state.sources))
        say_in(self.problem, state.board_problem, error=bool(state.board_problem))
        if not state.board_problem:
            self._write(state.board)
        with QSignalBlocker(self.every):
            self.every.setValue(state.every)

    def _pictures(self) -> QGroupBox:
        box = QGroupBox("Pictures of the board")
        add = self._calibration
        self.folder_button = push_button(
            "Add all &cameras …", lambda: ask_for_folder(
                self, "Folder of all cameras", self._start(), add.add_folder),
            "A recording, or a folder with one video or folder of images per camera, named as the "
            "camera",
        )  # fmt: skip
        self.images_button = push_button(
            "Add &images …", lambda: ask_for_folder(
                self, "Images of one camera", self._start(), add.add_camera),
            "A folder with the images of one camera",
        )  # fmt: skip
        files = files_of("Videos", sorted(VIDEO_SUFFIXES))
        self.video_button = push_button(
            "Add &video …", lambda: ask_to_open(
                self, "Video of one camera", self._start(), files, add.add_camera),
            "A video of one camera",
        )  # fmt: skip
        self.recording_button = push_button(
            "", self._calibration.add_recording,
            "Search the images of the open recording for the board",
        )  # fmt: skip
        self.remove_button = push_button("&Remove", self._remove, "Leave the chosen camera out")
        self.every = WholeNumberField(
            minimum=1, maximum=1000, prefix="one of ", suffix=" pictures",
            specialValueText="all pictures", keyboardTracking=False,
            accessibleName="Pictures that are used",
            toolTip="One of so many pictures is used, which makes long videos quick",
        )  # fmt: skip
        self.every.changed.connect(self._calibration.set_every)
        first = hbox(self.folder_button, self.images_button, self.video_button, None, spacing=6)
        second = hbox(self.recording_button, self.remove_button, None, self.every, spacing=6)
        box.setLayout(vbox((self.sources, 1), first, second, margins=(9, 9, 9, 9)))
        return box

    def _board(self) -> QGroupBox:
        self.kind = choice("Kind of board", _KINDS, "ChArUco boards have markers in their squares")
        self.columns, self.rows = (
            WholeNumberField(
                minimum=3, maximum=100, value=value, accessibleName=f"{what} of the board"
            )
            for what, value in (("Columns", 9), ("Rows", 6))
        )
        self.square = _millimetres("Side of a square", "Measure it over the whole board")
        self.dictionary = choice("Dictionary", [(one, one) for one in DICTIONARIES],
                                 "Set of markers, by its name in OpenCV")  # fmt: skip
        self.marker = _millimetres("Side of a marker", "The black square with the pattern")
        self.counts = label("", wraps=False)
        self.problem = label("", "error")
        box = QGroupBox("Board")
        self._form = form = QFormLayout(box)
        form.addRow("Kind", self.kind)
        size = hbox(self.columns, label("×", wraps=False), self.rows, None)
        form.addRow(self.counts, size)
        form.addRow("Side of a square", hbox(self.square, None))
        form.addRow("Dictionary", self.dictionary)
        form.addRow("Side of a marker", hbox(self.marker, None))
        form.addRow(self.problem)
        for choice_box in (self.kind, self.dictionary):
            choice_box.activated.connect(self._on_board)
        for field in (self.columns, self.rows, self.square, self.marker):
            field.setKeyboardTracking(False)
            field.valueChanged.connect(self._on_board)
        return box

    def _write(self, board: Board) -> None:
        fields = (self.kind, self.columns, self.rows, self.square, self.dictionary, self.marker)
        blockers = [QSignalBlocker(one) for one in fields]
        kind = "charuco" if board.dictionary else "chessboard"
        more = 1 if board.dictionary else 0
        self.kind.setCurrentIndex(self.kind.findData(kind))
        self.columns.setValue(board.columns + more)
        self.rows.setValue(board.rows + more)
        self.square.show_stored(board.square)
        if board.dictionary:
            self.dictionary.setCurrentIndex(self.dictionary.findData(board.dictionary))
            self.marker.show_stored(board.marker)
        self._show_fields(kind)
        del blockers

    def _show_fields(self, kind: str) -> None:
        words, tip = _COUNTS[kind]
        self.counts.setText(words)
        for field in (self.columns, self.rows):
            field.setToolTip(tip)
        self._form.setRowVisible(self.dictionary, kind == "charuco")
        self._form.setRowVisible(4, kind == "charuco")

    def _on_board(self) -> None:
        kind = str(self.kind.currentData())
        self._show_fields(kind)
        square = self.square.stored()
        size = f"{self.columns.value()}x{self.rows.value()}"
        try:
            if kind == "chessboard":
                board = chessboard(size, square)
            else:
                marker = self.marker.stored() or 0.75 * square
                board = charuco(f"{size}:{self.dictionary.currentData()}:{marker!r}", square)
        except InputError as error:
            self._calibration.set_board(None, f"{error.what[:1].upper()}{error.what[1:]}. "
                                        f"{error.remedy}")  # fmt: skip
            return
        self._calibration.set_board(board)

    def _start(self) -> Path:
        sources = self._calibration.state.sources
        return Path(sources[-1].place).parent if sources else Path.home()

    def _remove(self) -> None:
        item = self.sources.currentItem() or self.sources.topLevelItem(0)
        if item is not None:
            self._calibration.remove(item.text(0))


def _millimetres(name: str, tip: str) -> NumberField:
    return NumberField(
        digits=2, per_unit=1000.0, maximum=500.0, singleStep=0.5, suffix=" mm",
        accessibleName=name, toolTip=tip,
    )  # fmt: skip


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
        group, column = QButtonGroup(self), vbox(spacing=6)
        for way, (title, about) in _WAYS.items():
            button = self.ways[way] = QRadioButton(title)
            group.addButton(button)
            button.clicked.connect(lambda _on=False, way=way: calibration.choose_way(way))
            column.addWidget(button)
            self.about[way] = label(about, "muted", margins=_INDENT)
            column.addWidget(self.about[way])
            if fields := self.fields.get(way):
                column.addWidget(fields)
        self.choices = holder(column)
        buttons = hbox(self.file_button, self.into_button, None)
        told = (self.places, self.words, self.another_world)
        self.setLayout(vbox(self.choices, *told, buttons, self.why_not, None, spacing=10))

    def _board_fields(self) -> QWidget:
        box = self.board_frame = choice(
            "Position of the board on the floor", (), "Position of the board",
            lambda frame: self._calibration.turn(board_frame=frame),
        )  # fmt: skip
        return holder(hbox(label_of(box, "Position"), box, None, margins=_INDENT))

    def _floor_fields(self) -> QWidget:
        self.frame = WholeNumberField(
            minimum=0, maximum=_MOST_FRAMES, keyboardTracking=False,
            accessibleName="Frame that shows the floor",
        )  # fmt: skip
        self.frame.changed.connect(lambda frame: self._calibration.turn(frame=frame))
        north = self.north = choice(
            "Camera in the north", (), "The camera that stands in the north",
            lambda name: self._calibration.turn(north=name),
        )  # fmt: skip
        frame = (label_of(self.frame, "Frame"), self.frame)
        named = (label_of(north, "In the north"), north)
        return holder(hbox(*frame, *named, None, margins=_INDENT))

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
        for part in (self.ways["recording"], self.about["recording"]):
            part.setVisible(not state.of_recording)
        boards = {frame: f"picture {frame}" for frame in state.board_frames}
        _fill(self.board_frame, boards, state.axes.board_frame)
        cameras = {"": "that of the first view", **{name: name for name in state.recorded}}
        _fill(self.north, cameras, state.axes.north)
        with QSignalBlocker(self.frame):
            self.frame.setValue(state.axes.frame)
        turned = isinstance(state.alignment, Alignment)
        self.places.show_table(place_table(state.base, state.cameras) if turned else None)
        self.words.setText(_about(state))
        why_not, there = why_not_into(state), state.recording is not None
        placed = there and state.world is not None
        self.another_world.setVisible((turned or placed) and state.axes.way != "recording")
        self.file_button.setEnabled(not state.why_not_save())
        self.into_button.setVisible(there)
        self.into_button.setEnabled(not why_not)
        self.why_not.setVisible(there and bool(why_not))
        self.why_not.setText(f"It cannot be saved into the recording. {why_not}")

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
