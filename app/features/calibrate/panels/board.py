"""First step: where the pictures of each camera are, and what board they show."""

from pathlib import Path

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtWidgets import QFormLayout, QGroupBox, QTreeWidget, QTreeWidgetItem, QWidget

from stereotrack_core.calibrate.board import DICTIONARIES, Board, charuco, chessboard
from stereotrack_core.errors import InputError
from stereotrack_core.recording.stream_files import VIDEO_SUFFIXES

from ....widgets.forms.form_dialog import ask_for_folder, ask_to_open, files_of, push_button, say_in
from ....widgets.forms.numbers import NumberField, WholeNumberField
from ....widgets.style.building import choice, hbox, label, vbox
from ....widgets.tables.table import dress_list
from ..controller import CalibrationController
from ..state import Calibration

_KINDS = (("chessboard", "Chessboard"), ("charuco", "ChArUco board"))
_COUNTS = {
    "chessboard": ("Inner corners", "Corners between four squares, along each side: one number "
                   "should be even and the other odd"),
    "charuco": ("Squares", "Squares along each side"),
}  # fmt: skip


class BoardPage(QWidget):
    """Sources of the pictures above, the board below."""

    def __init__(self, calibration: CalibrationController) -> None:
        super().__init__()
        self._calibration = calibration
        self.sources = _source_list()
        self.sources.itemChanged.connect(self._on_renamed)
        self.sources.currentItemChanged.connect(self._on_current)
        self.setLayout(vbox((self._pictures(), 1), self._board(), spacing=8))

    def show_state(self, state: Calibration) -> None:
        with QSignalBlocker(self.sources):
            known = [self.sources.topLevelItem(k) for k in range(self.sources.topLevelItemCount())]
            shown = [(one.text(0), one.text(1)) for one in known if one is not None]
            wanted = [(one.camera, one.place) for one in state.sources]
            if shown != wanted:
                self.sources.clear()
                for camera, place in wanted:
                    item = QTreeWidgetItem(self.sources, [camera, place])
                    item.setFlags(item.flags() | Qt.ItemFlag.ItemIsEditable)
                    item.setToolTip(1, place)
        self.recording_button.setVisible(state.recording is not None)
        if state.recording is not None:
            self.recording_button.setText(f"Cameras of “{state.recording.name}”")
        self.remove_button.setEnabled(bool(state.sources))
        if state.board_problem:
            say_in(self.problem, state.board_problem, error=True)
        else:
            say_in(self.problem, "")
            self._write(state.board)
        with QSignalBlocker(self.every):
            self.every.setValue(state.every)

    # ---- making

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
        self.every.valueChanged.connect(self._calibration.set_every)
        first = hbox(self.folder_button, self.images_button, self.video_button, None, spacing=6)
        second = hbox(self.recording_button, self.remove_button, None, self.every, spacing=6)
        box.setLayout(vbox((self.sources, 1), first, second, margins=(9, 9, 9, 9)))
        return box

    def _board(self) -> QGroupBox:
        self.kind = choice("Kind of board", _KINDS, "ChArUco boards have markers in their squares")
        self.columns, self.rows = (
            WholeNumberField(minimum=3, maximum=100, value=value) for value in (9, 6)
        )
        self.columns.setAccessibleName("Columns of the board")
        self.rows.setAccessibleName("Rows of the board")
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

    # ---- the board

    def _write(self, board: Board) -> None:
        self._squares = board
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

    # ---- the pictures

    def _start(self) -> Path:
        sources = self._calibration.state.sources
        return Path(sources[-1].place).parent if sources else Path.home()

    def _remove(self) -> None:
        item = self.sources.currentItem() or self.sources.topLevelItem(0)
        if item is not None:
            self._calibration.remove(item.text(0))

    def _on_renamed(self, item: QTreeWidgetItem, _column: int) -> None:
        place = self.sources.indexOfTopLevelItem(item)
        self._calibration.rename(self._calibration.state.sources[place].camera, item.text(0))

    def _on_current(self, item: QTreeWidgetItem | None, _before: object) -> None:
        if item is not None:
            self._calibration.choose(item.text(0), 0)


def _source_list() -> QTreeWidget:
    tree = QTreeWidget()
    tree.setColumnCount(2)
    tree.setHeaderLabels(["Camera", "Pictures"])
    dress_list(tree, "Pictures of each camera", (120, 0))
    tree.setEditTriggers(
        QTreeWidget.EditTrigger.DoubleClicked | QTreeWidget.EditTrigger.EditKeyPressed
    )
    tree.header().setStretchLastSection(True)
    tree.setMinimumHeight(80)
    tree.setTextElideMode(Qt.TextElideMode.ElideMiddle)
    tree.headerItem().setToolTip(0, "Double-click a name to change it")
    return tree


def _millimetres(name: str, tip: str) -> NumberField:
    return NumberField(
        digits=2, per_unit=1000.0, maximum=500.0, singleStep=0.5, suffix=" mm",
        accessibleName=name, toolTip=tip,
    )  # fmt: skip
