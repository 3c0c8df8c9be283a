"""The page of the calibration: steps, verdict, what a step shows, and a picture or the scene."""

from __future__ import annotations

from PySide6.QtCore import Qt, Slot
from PySide6.QtWidgets import QSplitter, QStackedWidget, QWidget

from stereotrack_core.calibrate.align import Alignment

from ....widgets.camera.board_picture import ENLARGED, BoardPicture
from ....widgets.forms.form_dialog import push_button
from ....widgets.forms.step_list import StepList, VerdictBox
from ....widgets.scene.scene_view import SceneView
from ....widgets.style.building import ElidedLabel, hbox, label, scrolled, thin_progress, vbox
from ..controller import CalibrationController
from ..shown import coverage_shown, scene_shown, shot_shown, steps_shown, verdict_shown
from ..state import STEPS, Calibration, StepName
from .axes import AxesPage
from .board import BoardPage
from .results import LensesPage, PicturesPage, WorldPage

_DO: dict[StepName, tuple[str, str]] = {
    "pictures": ("Find the board", "Search again"),
    "lenses": ("Calculate the lenses", "Calculate again"),
    "world": ("Place all cameras", "Calculate again"),
}
_SCROLLED: frozenset[StepName] = frozenset({"board", "axes"})
"""Steps with more than a small window has room for; the others have lists that scroll."""


class CalibrationPage(QWidget):
    """Shows the state of the calibration, and hands on what a person wants."""

    def __init__(self, calibration: CalibrationController) -> None:
        super().__init__()
        self._calibration = calibration
        self._world: object = None
        self.setAccessibleName("Calibration")
        self.steps = StepList("Steps of the calibration", calibration.show)
        self.verdict = VerdictBox()
        self.picture = BoardPicture(
            "Picture of the board",
            "Green: corners that were found, in their order. Orange: their errors, "
            f"{ENLARGED:.0f} times enlarged.",
            "Choose a picture in the list to see it here.",
        )
        self.coverage = BoardPicture(
            "Coverage of the image",
            "Dots: all corners of the board in this camera's pictures. Cells without a colour: "
            "the board was never there, so that the distortion is a guess.",
            "Calculate the lenses to see where in the image the board was.",
        )
        self.scene = SceneView()
        self.board, self.pictures = BoardPage(calibration), PicturesPage(calibration)
        self.lenses = LensesPage(calibration)
        self.world, self.axes = WorldPage(calibration), AxesPage(calibration)
        self.pages: dict[StepName, BoardPage | PicturesPage | LensesPage | WorldPage | AxesPage] = {
            "board": self.board, "pictures": self.pictures, "lenses": self.lenses,
            "world": self.world, "axes": self.axes,
        }  # fmt: skip
        self._lay_out()
        calibration.changed.connect(self.show_state)
        calibration.progressed.connect(self._on_progress)
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
        both = QSplitter(Qt.Orientation.Horizontal)
        for stack in (self.middle, self.side):
            both.addWidget(stack)
            both.setStretchFactor(both.indexOf(stack), 1)
        both.setChildrenCollapsible(False)
        both.setSizes([640, 480])
        right = vbox(self.verdict, (both, 1), self._bar(), spacing=8)
        close, tip = self._calibration.close_page, "Back to the welcome page"
        self.close_button = push_button("Close", close, tip)
        left = vbox(label("Calibration", "heading"), self.steps, None, self.close_button, spacing=8)
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

    # ---- following

    @Slot()
    def show_state(self) -> None:
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
        self.do_button.setVisible(bool(do))
        self.do_button.setText(again if made else do)
        _enable(self.do_button, calibration.why_not_calculate(), "Calculate this step")
        step = state.next_step()
        self.next_button.setVisible(state.step != "axes")
        self.next_button.setText("Next" if step is None else f"Next: {STEPS[step].lower()}")
        _enable(self.next_button, calibration.why_no_next(), "Go to the next step")
        busy = state.busy is not None
        self.stop_button.setVisible(busy)
        for widget in (self.said, self.progress):
            widget.setVisible(busy)

    def _show_side(self, state: Calibration) -> None:
        in_space = state.step in ("world", "axes") and bool(state.base)
        self.side.setCurrentWidget(self.scene if in_space else self._pictures)
        self.coverage.setVisible(state.step == "lenses")
        if in_space:
            self._show_world(state)
            return
        if state.step == "lenses":
            self.coverage.show_shot(coverage_shown(state))
        self.picture.show_shot(shot_shown(state, self._calibration.picture))

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

    @Slot(float, str)
    def _on_progress(self, share: float, words: str) -> None:
        self.said.set_words(words)
        self.progress.setMaximum(1000 if share > 0.0 else 0)
        self.progress.setValue(round(1000 * share))


def _enable(button: QWidget, why_not: str, tip: str) -> None:
    button.setEnabled(not why_not)
    button.setToolTip(f"Unavailable: {why_not}" if why_not else tip)
