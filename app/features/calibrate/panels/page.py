"""The page of the calibration: steps, verdict, what a step shows, and a picture or the scene."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

from PySide6.QtCore import Qt, Slot
from PySide6.QtWidgets import QSplitter, QStackedWidget, QWidget

from stereotrack_core.calibrate.align import Alignment
from stereotrack_core.calibrate.report import place_table

from ....widgets.camera.board_picture import BoardPicture, CoverageMap
from ....widgets.forms.form_dialog import ask_to_save, push_button
from ....widgets.forms.step_list import StepList, VerdictBox
from ....widgets.scene.scene_view import SceneView
from ....widgets.style.building import ElidedLabel, hbox, label, scrolled, thin_progress, vbox
from ....widgets.tables.table import PlainTable
from ..aligning import AligningController
from ..controller import CalibrationController
from ..saving import ReadPicture, why_not_into
from ..shown import coverage_shown, scene_shown, shot_shown, steps_shown, verdict_shown
from ..state import STEPS, Calibration, StepName
from .axes import AxesPage, PointsPanel
from .board import BoardPage
from .results import LensesPage, PicturesPage, WorldPage


class SavePage(QWidget):
    """Where the calibration goes."""

    def __init__(self, calibration: CalibrationController) -> None:
        super().__init__()
        self._calibration = calibration
        self.places = PlainTable("The world")
        self.file_button = push_button("&Save calibration …", self.ask, "Write a calibration.toml")
        self.into_button = push_button(
            "Save into the &recording", calibration.save_into_recording,
            "Replace the calibration of the open recording; the one before is kept beside it",
        )  # fmt: skip
        self.why_not = label("", "muted")
        words = "The calibration holds the lens and the place of every camera."
        self.another_world = label("", "muted")
        buttons = hbox(self.file_button, self.into_button, None)
        self.setLayout(
            vbox(self.places, self.another_world, label(words, "muted"),
                 buttons, self.why_not, None, spacing=10)
        )  # fmt: skip

    def show_state(self, state: Calibration) -> None:
        """Show how the world is turned."""
        turned = state.alignment is not None and bool(state.cameras)
        self.places.show_table(place_table(state.base, state.cameras) if turned else None)
        self.another_world.setVisible(turned and state.axes.way != "recording")
        self.another_world.setText(
            "Runs, references and landmarks in space stay in the world before. After saving into "
            "the recording, track again; clicks in the images stay right."
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
        if state.recording is not None and not state.sources:
            start = state.recording.folder.parent
        ask_to_save(
            self, "Save the calibration", start / "calibration.toml", "Calibration (*.toml)",
            self._calibration.save,
        )  # fmt: skip


_DO: dict[StepName, tuple[str, str]] = {
    "board": ("Recognise the board", "Recognise again"),
    "pictures": ("Find the board", "Search again"),
    "lenses": ("Calculate the lenses", "Calculate again"),
    "world": ("Place all cameras", "Calculate again"),
}
_NEXT: dict[StepName, str] = {
    "pictures": "Next: find the board",
    "lenses": "Next: lenses",
    "world": "Next: all cameras",
    "axes": "Next: axes and floor",
    "save": "Next: save",
}


_SCROLLED: frozenset[StepName] = frozenset({"board", "axes", "save"})
"""Steps with more than a small window has room for; the others have lists that scroll."""


class StepPage(Protocol):
    """What a step shows."""

    def show_state(self, state: Calibration) -> None:
        """Show what is known of it."""


class CalibrationPage(QWidget):
    """Shows the state of the calibration, and hands on what a person wants."""

    def __init__(self, calibration: CalibrationController, aligning: AligningController) -> None:
        super().__init__()
        self._calibration = calibration
        self._read: ReadPicture | None = None
        self._world: object = None
        self.setAccessibleName("Calibration")
        self.steps, self.verdict = StepList("Steps of the calibration"), VerdictBox()
        self.picture, self.coverage, self.scene = BoardPicture(), CoverageMap(), SceneView()
        self.board, self.pictures = BoardPage(calibration), PicturesPage(calibration)
        self.lenses = LensesPage(calibration)
        self.world, self.axes, self.save = (
            WorldPage(calibration), AxesPage(calibration, aligning), SavePage(calibration),
        )  # fmt: skip
        self.points = PointsPanel(aligning)
        self.pages: dict[StepName, BoardPage | PicturesPage | LensesPage | WorldPage
                         | AxesPage | SavePage] = {
            "board": self.board, "pictures": self.pictures, "lenses": self.lenses,
            "world": self.world, "axes": self.axes, "save": self.save,
        }  # fmt: skip
        self._lay_out()
        self.steps.chosen.connect(calibration.show)
        calibration.changed.connect(self.show_state)
        calibration.progressed.connect(self._on_progress)
        calibration.reading.read.connect(self._on_read)
        self.show_state()

    def _lay_out(self) -> None:
        self.middle, self.side = QStackedWidget(), QStackedWidget()
        self._places: dict[StepName, QWidget] = {
            name: scrolled(page, f"{STEPS[name]}, step of the calibration")
            if name in _SCROLLED
            else page
            for name, page in self.pages.items()
        }
        for place in self._places.values():
            self.middle.addWidget(place)
        self._pictures = QSplitter(Qt.Orientation.Vertical)
        for part, stretch in ((self.picture, 3), (self.coverage, 2)):
            self._pictures.addWidget(part)
            self._pictures.setStretchFactor(self._pictures.indexOf(part), stretch)
        self.side.addWidget(self._pictures)
        self.side.addWidget(self.scene)
        self.side.addWidget(self.points)
        both = QSplitter(Qt.Orientation.Horizontal)
        for stack in (self.middle, self.side):
            both.addWidget(stack)
            both.setStretchFactor(both.indexOf(stack), 1)
        both.setChildrenCollapsible(False)
        both.setSizes([640, 480])
        right = vbox(self.verdict, (both, 1), self._bar(), spacing=8)
        left = vbox(label("Calibration", "heading"), self.steps, None, self._close_row(), spacing=8)
        self.setLayout(hbox(left, (right, 1), margins=(10, 8, 10, 8), spacing=10))

    def _bar(self) -> QWidget:
        self.do_button = push_button("", self._calibration.calculate)
        self.next_button = push_button("", self._calibration.go_on)
        self.stop_button = push_button("Stop", self._calibration.cancel, "Stop the calculation")
        self.said, self.progress = ElidedLabel(), thin_progress()
        self.progress.setAccessibleName("Progress of the calibration")
        bar = QWidget()
        middle = vbox(self.said, self.progress, spacing=2)
        bar.setLayout(hbox(self.do_button, (middle, 1), self.stop_button, self.next_button))
        return bar

    def _close_row(self) -> QWidget:
        self.close_button = push_button(
            "Close", self._calibration.close_page, "Back to the welcome page"
        )
        return self.close_button

    # ---- following

    @Slot()
    def show_state(self) -> None:
        """Show the state as it is now."""
        state, calibration = self._calibration.state, self._calibration
        self.steps.show_steps(steps_shown(state), state.step)
        self.verdict.show_verdict(*verdict_shown(state))
        page = self.pages[state.step]
        page.show_state(state)
        self.middle.setCurrentWidget(self._places[state.step])
        self._show_side(state)
        self.close_button.setVisible(state.recording is None)
        do, again = _DO.get(state.step, ("", ""))
        made = state.is_done(state.step) or state.is_stale(state.step)
        fresh = state.step == "board" and not state.recognised
        self.do_button.setVisible(bool(do))
        self.do_button.setText(again if made and not fresh else do)
        _enable(self.do_button, calibration.why_not_calculate(), "Calculate this step")
        step = state.next_step()
        self.next_button.setVisible(state.step != "save")
        self.next_button.setText(_NEXT[step] if step is not None else "Next")
        _enable(self.next_button, calibration.why_no_next(), "Go to the next step")
        busy = state.busy is not None
        self.stop_button.setVisible(busy)
        for widget in (self.said, self.progress):
            widget.setVisible(busy)

    def _show_side(self, state: Calibration) -> None:
        in_space = state.step in ("world", "axes", "save") and bool(state.base)
        if in_space and state.step == "axes" and state.axes.way == "points":
            self.side.setCurrentWidget(self.points)
            self.points.show_state(state)
            return
        self.side.setCurrentWidget(self.scene if in_space else self._pictures)
        self.coverage.setVisible(state.step == "lenses")
        if in_space:
            self._show_world(state)
            return
        if state.step == "lenses":
            self.coverage.show_coverage(coverage_shown(state))
        self.picture.show_shot(shot_shown(state, self._read))

    def _show_world(self, state: Calibration) -> None:
        upright = isinstance(state.alignment, Alignment) or state.of_recording
        if self.scene.layer_visible("floor") != upright:
            self.scene.set_layer_visible("floor", upright)
        self.scene.show_scene(scene_shown(state))
        axes = state.axes
        place = state.world, state.recording, axes.way, axes.board_frame, axes.floor
        if place != self._world:
            self._world = place
            self.scene.set_view("home")

    @Slot(object)
    def _on_read(self, read: ReadPicture) -> None:
        self._read = read
        self._show_side(self._calibration.state)

    @Slot(float, str)
    def _on_progress(self, share: float, words: str) -> None:
        self.said.set_words(words)
        self.progress.setMaximum(1000 if share > 0.0 else 0)
        self.progress.setValue(round(1000 * share))


def _enable(button: QWidget, why_not: str, tip: str) -> None:
    button.setEnabled(not why_not)
    button.setToolTip(f"Unavailable: {why_not}" if why_not else tip)
