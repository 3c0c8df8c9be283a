"""Fifth step: what says where up, north and the origin are."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from PySide6.QtCore import QSignalBlocker, QSize, Slot
from PySide6.QtWidgets import QButtonGroup, QComboBox, QLabel, QRadioButton, QTabBar, QWidget

from stereotrack_core.calibrate.align import POINTS, Alignment
from stereotrack_core.calibrate.report import place_table
from stereotrack_core.geometry.camera import Camera

from ....widgets.camera.camera_view import CameraView
from ....widgets.camera.click_marks import (
    ClickAct,
    ClickMark,
    ClickMarks,
    CurveMark,
    Offer,
    PredictionMark,
)
from ....widgets.camera.picture import Display, Picture
from ....widgets.forms.form_dialog import push_button
from ....widgets.forms.numbers import WholeNumberField
from ....widgets.redraw import RedrawQueue
from ....widgets.style.building import Item, choice, hbox, label, label_of, vbox
from ....widgets.tables.table import PlainTable
from ..aligning import AligningController
from ..axes import Axes, AxesWay, points_in
from ..controller import CalibrationController
from ..state import Calibration

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
    "points": (
        "Three clicked &points of the floor",
        "The origin, any point north of it, and a third one beside that line. Click each in two "
        "cameras or more, in the pictures on the right.",
    ),
    "recording": (
        "The world of the open &recording",
        "The cameras are laid over those of the recording, so that landmarks and runs stay where "
        "they are.",
    ),
}
_AS_IT_IS = "The world as &it is", "The cameras of the open recording are not turned."
_INDENT = (24, 0, 0, 8)
_MOST_FRAMES = 10_000_000


class AxesPage(QWidget):
    """The ways to turn the world, each with what is to be chosen for it."""

    def __init__(self, calibration: CalibrationController, aligning: AligningController) -> None:
        super().__init__()
        self._calibration, self._aligning = calibration, aligning
        self.ways: dict[AxesWay, QRadioButton] = {}
        self.about: dict[AxesWay, QLabel] = {}
        self.fields: dict[AxesWay, QWidget] = {}
        self._make_fields()
        self.words, self.places = label("", "muted"), PlainTable("The world before and after")
        group, column = QButtonGroup(self), vbox(spacing=6)
        for way, (title, about) in _WAYS.items():
            button = self.ways[way] = QRadioButton(title)
            group.addButton(button)
            button.clicked.connect(self._on_chosen)
            column.addWidget(button)
            self.about[way] = label(about, "muted", margins=_INDENT)
            column.addWidget(self.about[way])
            if fields := self._fields(way):
                self.fields[way] = QWidget()
                self.fields[way].setLayout(vbox(*fields, margins=_INDENT, spacing=6))
                column.addWidget(self.fields[way])
        self.setLayout(vbox(column, self.places, self.words, None, spacing=12))

    def _make_fields(self) -> None:
        aligning = self._aligning
        self.board_frame = choice("Position of the board on the floor", (), "Position of the board")
        self.board_frame.activated.connect(
            lambda: aligning.choose_board(int(self.board_frame.currentData()))
        )
        self.floor_frame, self.points_frame = (
            _frame_box(name, aligning.choose_frame)
            for name in ("Frame that shows the floor", "Frame for clicking points")
        )
        self.north = choice("Camera in the north", (), "The camera that stands in the north")
        self.north.activated.connect(lambda: aligning.choose_north(str(self.north.currentData())))
        self.points: dict[str, QRadioButton] = {}
        group = QButtonGroup(self)
        for point in POINTS:
            self.points[point] = button = QRadioButton(point)
            group.addButton(button)
            button.clicked.connect(lambda _on=False, one=point: aligning.choose_point(one))
        self.remove_button = push_button(
            "Remove click", lambda: aligning.remove(self._calibration.state.axes.point),
            "Take the click of the chosen point away from the picture that is shown",
        )  # fmt: skip
        self.clear_button = push_button("Remove all", aligning.clear, "Take all clicks away")

    def _fields(self, way: AxesWay) -> tuple[Item, ...]:
        match way:
            case "board":
                return (hbox(label_of(self.board_frame, "Position"), self.board_frame, None),)
            case "floor":
                frame = label_of(self.floor_frame, "Frame"), self.floor_frame
                return (hbox(*frame, label_of(self.north, "In the north"), self.north, None),)
            case "points":
                frame = label_of(self.points_frame, "Frame"), self.points_frame
                return (
                    *self.points.values(),
                    hbox(*frame, self.remove_button, self.clear_button, None, spacing=6),
                )
            case _:
                return ()

    # ---- showing

    def show_state(self, state: Calibration) -> None:
        """Show what is chosen, and what it comes to."""
        title, about = _AS_IT_IS if state.of_recording else _WAYS["first"]
        self.ways["first"].setText(title)
        self.about["first"].setText(about)
        for way, button in self.ways.items():
            button.setChecked(way == state.axes.way)
            why_not = _why_no_way(way, state)
            button.setEnabled(not why_not)
            button.setToolTip(f"Unavailable: {why_not}" if why_not else "")
        for way, fields in self.fields.items():
            fields.setVisible(way == state.axes.way)
        self.ways["recording"].setVisible(not state.of_recording)
        self.about["recording"].setVisible(not state.of_recording)
        self._show_fields(state)
        turned = isinstance(state.alignment, Alignment)
        self.places.show_table(place_table(state.base, state.cameras) if turned else None)
        self.words.setText(_about(state))

    def _show_fields(self, state: Calibration) -> None:
        axes, recording = state.axes, state.recording
        boards = {frame: f"picture {frame}" for frame in state.board_frames}
        _fill(self.board_frame, boards, axes.board_frame)
        cameras = {"": "that of the first view"}
        if recording is not None:
            cameras |= {name: name for name in recording.cameras}
        _fill(self.north, cameras, axes.north)
        for box in (self.floor_frame, self.points_frame):
            _put(box, axes.frame)
        for point, button in self.points.items():
            seen = axes.clicked_in(point)
            button.setText(f"{point}: {', '.join(seen) or 'not clicked yet'}")
            button.setChecked(point == axes.point)
        here = axes.camera in axes.clicked_in(axes.point)
        self.remove_button.setEnabled(here)
        self.remove_button.setToolTip(
            f"Take the click of {axes.point} away from {axes.camera}" if here
            else f"Unavailable: {axes.point} is not clicked in {axes.camera}."
        )  # fmt: skip
        self.clear_button.setEnabled(any(axes.clicks.values()))

    # ---- choosing

    @Slot()
    def _on_chosen(self) -> None:
        way = next(way for way, button in self.ways.items() if button.isChecked())
        self._aligning.choose(way)


def _frame_box(name: str, on_changed: Callable[[int], None]) -> WholeNumberField:
    box = WholeNumberField(minimum=0, maximum=_MOST_FRAMES)
    box.setAccessibleName(name)
    box.setKeyboardTracking(False)
    box.valueChanged.connect(on_changed)
    return box


def _put(box: WholeNumberField, value: int) -> None:
    with QSignalBlocker(box):
        box.setValue(value)


def _fill(box: QComboBox, options: Mapping[Any, str], chosen: object) -> None:
    """Offer these, by their keys; the list is made again only where it is another one."""
    with QSignalBlocker(box):
        if [(box.itemData(k), box.itemText(k)) for k in range(box.count())] != [*options.items()]:
            box.clear()
            for key, text in options.items():
                box.addItem(text, key)
        box.setCurrentIndex(box.findData(chosen))


def _why_no_way(way: AxesWay, state: Calibration) -> str:
    """Why the world cannot be turned so; empty where it can."""
    recorded = {} if state.recording is None else state.recording.cameras
    there = any(name in recorded for name in state.base)
    match way:
        case "recording" if not there:
            return "Open the recording of these cameras."
        case "floor" if not there or state.recording is None or not state.recording.has_depth:
            return "Open a recording of these cameras with stereo or depth views."
        case "board" if not state.board_frames:
            return "Choose pictures of the board, and find it in them (steps 1 and 2)."
        case _:
            return ""


def _about(state: Calibration) -> str:
    """What the world rests on now, and where the cameras come to stand."""
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


COLOURS: Mapping[str, str] = {"origin": "#f0e442", "north": "#56b4e9", "floor": "#e69f00"}
"""Colours of the three points; bright on any picture."""


class _Tabs(QTabBar):
    """High enough for the underscores in names of cameras."""

    def tabSizeHint(self, place: int) -> QSize:
        return super().tabSizeHint(place) + QSize(0, 4)


class PointsPanel(QWidget):
    """A tab per camera above its picture, which takes the clicks."""

    def __init__(self, aligning: AligningController) -> None:
        super().__init__()
        self._aligning = aligning
        self._cameras: Mapping[str, Camera] = {}
        self._axes = Axes()
        self.tabs = _Tabs()
        self.tabs.setAccessibleName("Cameras for clicking")
        self.tabs.setExpanding(False)
        self.tabs.setDocumentMode(True)
        self.tabs.currentChanged.connect(self._on_tab)
        self.view = CameraView(RedrawQueue(self), self)
        self.view.setAccessibleName("Picture for clicking points of the floor")
        self.view.setToolTip(
            "Click to place a point, drag to move it. Wheel: zoom. Middle button and drag: move "
            "the picture. Crosses and lines: where clicks in other cameras put a point."
        )
        self.view.set_display(Display(loupe=True, loupe_in_corner=True))
        self.view.set_clicking(True)
        self.view.clicked.connect(self._on_click)
        self.setLayout(vbox(self.tabs, (self.view, 1), spacing=2))
        aligning.read.connect(self._show_picture)

    def show_state(self, state: Calibration) -> None:
        """Show the clicks and what follows from them."""
        self._cameras, self._axes = state.base, state.axes
        with QSignalBlocker(self.tabs):
            names = [self.tabs.tabData(k) for k in range(self.tabs.count())]
            if names != list(state.base):
                while self.tabs.count():
                    self.tabs.removeTab(0)
                for k, name in enumerate(state.base):
                    self.tabs.addTab(name)
                    self.tabs.setTabData(k, name)
            for k, name in enumerate(state.base):
                count = sum(name in own for own in state.axes.clicks.values())
                self.tabs.setTabText(k, f"{name}  {count}/{len(POINTS)}" if count else name)
                if name == state.axes.camera:
                    self.tabs.setCurrentIndex(k)
        self._show_picture()

    @Slot()
    def _show_picture(self) -> None:
        axes, read = self._axes, self._aligning.picture
        source = self._aligning.source_of(axes.camera)
        wanted = read is not None and (read.source, read.frame) == (source, axes.frame)
        image = read.image if read is not None and wanted else None
        message = read.problem if read is not None and wanted else "Loading image …"
        self.view.show_picture(
            Picture(axes.camera, "image", axes.frame, image, message, camera=axes.camera)
        )
        self.view.set_marks(_marks(axes, self._cameras))

    @Slot(int)
    def _on_tab(self, place: int) -> None:
        self._aligning.show_camera(str(self.tabs.tabData(place)))

    @Slot(object)
    def _on_click(self, act: ClickAct) -> None:
        if act.what == "pick":
            self._aligning.choose_point(act.key.landmark)
        else:
            self._aligning.click(act.key.landmark, *act.pixel)


def _marks(axes: Axes, cameras: Mapping[str, Camera]) -> ClickMarks:
    clicks, predictions, curves = [], [], []
    for point in POINTS:
        own, colour = axes.clicks.get(point, {}), COLOURS[point]
        places = points_in(cameras, own, axes.camera)
        if axes.camera in own:
            x, y = own[axes.camera]
            chosen = point == axes.point
            clicks.append(ClickMark(point, point, colour, x, y, chosen=chosen, held=chosen))
        if len(places) > 1:
            other = next(name for name in own if name != axes.camera)
            curves.append(CurveMark(colour, other, places))
        elif len(places):
            x, y = places[0].tolist()
            off = float(np.hypot(*(places[0] - own[axes.camera]))) if axes.camera in own else np.nan
            predictions.append(
                PredictionMark(point, point, colour, x, y, off, chosen=point == axes.point)
            )
    moves = axes.camera in axes.clicks.get(axes.point, {})
    words = f"{axes.point}: click to move it" if moves else f"{axes.point}: click to place it"
    return ClickMarks(
        axes.frame, axes.camera, tuple(clicks), tuple(predictions), tuple(curves),
        offer=Offer(axes.point, words, COLOURS[axes.point], moves),
    )  # fmt: skip
