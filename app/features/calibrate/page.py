"""The page of the calibration: steps, verdict, what a step shows, and a picture or the scene."""

import numpy as np
from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtWidgets import QHBoxLayout, QStackedWidget, QTabWidget, QWidget

from stereotrack_core.arrays import FloatArray
from stereotrack_core.calibrate.align import Alignment
from stereotrack_core.calibrate.bundle import rms_of
from stereotrack_core.calibrate.lens import LENS_MODELS
from stereotrack_core.calibrate.pictures import Sightings
from stereotrack_core.calibrate.report import lens_table, world_tables
from stereotrack_core.tables import Table, number

from ...session.changes import Part
from ...widgets.camera.board_picture import ENLARGED, BoardPicture, BoardShot
from ...widgets.forms.form_dialog import push_button
from ...widgets.scene.content import SceneContent
from ...widgets.scene.scene_view import SceneView
from ...widgets.style.building import (
    ElidedLabel,
    allow,
    choice,
    hbox,
    holder,
    label,
    label_of,
    named,
    scrolled,
    splitter,
    thin_progress,
    vbox,
)
from ...widgets.tables.table import RIGHT, STRETCH, Cell, Column, PlainTable
from ...widgets.tables.trees import CellTree, TreeRow
from .controller import CalibrationController
from .pages import AxesPage, BoardPage
from .state import STEPS, Calibration, ReadPicture, StepName
from .steps import StepList, VerdictBox

_MOST_EMPTY = 200
"""Pictures without a board that are listed for a camera; of long videos only those with one are."""
_BAD, _BAD_PX = 2.0, 0.3  # times the usual error, and pixels, from which a picture is marked
_MOST_BOARDS = 150


def _rows_of(state: Calibration, seen: Sightings) -> TreeRow:
    calculated = state.step not in ("board", "pictures")
    errors: dict[int, FloatArray] = {}
    if calculated:
        errors = {k: error for (name, k), error in state.errors.items() if name == seen.camera}
    rms = {frame: rms_of(error) for frame, error in errors.items()}
    limit = max(_BAD * float(np.median([*rms.values()])), _BAD_PX) if rms else np.inf
    rows, ticked = {}, 0
    for frame, name, pixels in zip(seen.frames.tolist(), seen.pictures, seen.pixels, strict=True):
        shot, error = (seen.camera, frame), rms.get(frame, np.nan)
        used = shot not in state.unticked
        remark = state.left_out.get(shot, "") if used else "left out by hand"
        ticked, muted = ticked + used, "" if used else "muted"
        rows[frame] = TreeRow((
            Cell(name, name, muted, value=shot, ticked=used),
            Cell(str(int(np.isfinite(pixels[:, 0]).sum())), colour=muted),
            Cell(number(error, 2) if calculated else "",
                 colour="warning" if error > limit else muted),
            Cell(remark, remark, muted),
        ))  # fmt: skip
    for out in seen.left_out if len(seen.left_out) <= _MOST_EMPTY else ():
        picture = Cell(out.picture, out.picture, "muted", value=(seen.camera, out.frame))
        rows[out.frame] = TreeRow((picture, Cell(), Cell(), Cell(out.reason, out.reason, "muted")))
    whole = number(rms_of(np.concatenate([*errors.values()])), 2) if errors else ""
    found = f"{ticked} of {seen.searched} used"
    if not calculated:
        found = f"found in {len(seen)} of {seen.searched}"
    head = (Cell(seen.camera, bold=True), Cell(), Cell(whole), Cell(found))
    return TreeRow(head, tuple(rows[frame] for frame in sorted(rows)))


def shot_shown(state: Calibration, read: ReadPicture | None) -> BoardShot | None:
    """The picture that is chosen, with corners and errors."""
    if read is None or state.shot != (read.source.camera, read.frame):
        return None
    camera, frame = state.shot
    title, corners, errors = f"{camera}, {read.name}", None, None
    for seen in state.found.sightings if state.found is not None else ():
        rows = np.flatnonzero(seen.frames == frame)
        if seen.camera == camera and len(rows):
            corners = seen.pixels[rows[0]]
            errors = None if state.step == "pictures" else state.errors.get(state.shot)
    if errors is not None:
        title += f": {rms_of(errors):.2f} px"
    columns = state.found_board.columns if corners is not None else 0
    size = (0, 0) if read.image is None else (read.image.shape[1], read.image.shape[0])
    return BoardShot(title, size, corners, errors, columns, image=read.image, message=read.problem)


def coverage_shown(state: Calibration) -> BoardShot | None:
    """Coverage of the camera whose picture is shown, or of the first one."""
    name = state.shot[0] if state.shot is not None else ""
    fit = state.fits.get(name) or next(iter(state.fits.values()), None)
    if fit is None:
        return None
    coverage, pixels = fit.coverage, fit.sightings.pixels
    title = (
        f"{fit.camera.name}: {100 * coverage.share:.0f} % covered, tilted up to "
        f"{coverage.tilt_deg:.0f}°, {coverage.nearest_m:.1f} to {coverage.farthest_m:.1f} m"
    )
    corners = pixels[np.isfinite(pixels[..., 0])]
    return BoardShot(title, fit.sightings.size, corners, cells=coverage.cells)


def short_lens_table(state: Calibration) -> Table | None:
    """Errors of the lenses, without what does not help to judge them."""
    if not state.fits:
        return None
    whole = lens_table(list(state.fits.values()))
    kept = [k for k, name in enumerate(whole.columns) if name != ">principal point"]
    rows = [[row[k] for k in kept] for row in whole.rows]
    return Table(whole.title, [whole.columns[k] for k in kept], rows)


def scene_shown(state: Calibration) -> SceneContent:
    """Cameras and boards in the chosen world; on the last step also the cameras as they were."""
    if not state.base:
        return SceneContent()
    board = state.found_board
    right, low, start = board.columns * board.square, board.rows * board.square, -board.square
    outline = np.array([[start, start, 0], [right, start, 0], [right, low, 0], [start, low, 0]])
    boards = state.boards[:: max(1, len(state.boards) // _MOST_BOARDS)]
    if state.step == "axes" and state.axes.way == "board":
        boards = state.boards
    same_world = state.of_recording or (state.step == "axes" and state.axes.way == "recording")
    before = tuple(one for name, one in state.recorded.items() if name in state.cameras)
    return SceneContent(
        cameras=tuple((state.cameras or state.base).values()),
        cameras_before=before if same_world else (),
        boards=tuple(one.apply(outline) for one in boards),
    )


_ABOUT_MODEL = (
    "Automatic: all models are fitted, and the simplest is taken that none of the others clearly "
    "improves on"
)


_PICTURES = (
    Column("Picture", "Untick a picture to calculate without it", width=150),
    Column("Corners", align=RIGHT, width=64),
    Column("Error (px)", "Root mean square error of its corners in pixels", RIGHT, width=80),
    Column("Remark", width=STRETCH),
)


class PicturesPage(CellTree):
    """A row with a tick for each picture, under a row for each camera."""

    def __init__(self, calibration: CalibrationController) -> None:
        super().__init__(
            "Pictures of the board",
            _PICTURES,
            lambda key, on, _name: calibration.tick(key, on=on),
            lambda key: calibration.choose(*key),
        )
        self.setAlternatingRowColors(True)

    def show_state(self, state: Calibration) -> None:
        seen = state.found.sightings if state.found is not None else ()
        self.show_rows([_rows_of(state, one) for one in seen])
        if state.shot is not None and state.busy != "pictures":
            with QSignalBlocker(self):
                self.choose(state.shot)


class LensesPage(QWidget):
    """A row per lens above the pictures."""

    def __init__(self, calibration: CalibrationController) -> None:
        super().__init__()
        self._calibration = calibration
        self.table = PlainTable("Lenses", choose=self._on_camera)
        self.tree = PicturesPage(calibration)
        models = [("auto", "automatic"), *((name, name) for name in LENS_MODELS)]
        self.model = choice(
            "Lens model", models, _ABOUT_MODEL,
            lambda model: calibration.change(model=model, saved=""),
        )  # fmt: skip
        row = hbox(label_of(self.model, "Lens model"), self.model, None)
        self.setLayout(vbox(row, self.table, (self.tree, 1)))

    def show_state(self, state: Calibration) -> None:
        self.model.setCurrentIndex(self.model.findData(state.model))
        self.table.show_table(short_lens_table(state))
        self.tree.show_state(state)

    def _on_camera(self, camera: str) -> None:
        fit = self._calibration.state.fits.get(camera)
        if fit is not None and len(fit.sightings):
            self._calibration.choose(camera, int(fit.sightings.frames[0]))


class WorldPage(QWidget):
    """Cameras, distances between them, and the pictures."""

    def __init__(self, calibration: CalibrationController) -> None:
        super().__init__()
        self.cameras, self.whole = PlainTable("Cameras"), PlainTable("All together", most=24)
        self.tree = PicturesPage(calibration)
        errors = holder(vbox(self.cameras, self.whole, None, margins=(0, 6, 0, 0)))
        self.tabs = QTabWidget(documentMode=True)
        self.tabs.addTab(scrolled(errors, "Errors of the cameras"), "Cameras")
        self.tabs.addTab(self.tree, "Pictures")
        self.setLayout(vbox((self.tabs, 1)))

    def show_state(self, state: Calibration) -> None:
        tables = world_tables(state.world.result)[-2:] if state.world is not None else [None, None]
        for widget, table in zip((self.cameras, self.whole), tables, strict=True):
            widget.show_table(table)
        self.tree.show_state(state)


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
        self.steps, self.verdict = StepList(calibration.show), VerdictBox()
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
        self.scene = SceneView(lambda _limb: None)
        self.board, self.pictures = BoardPage(calibration), PicturesPage(calibration)
        self.lenses = LensesPage(calibration)
        self.world, self.axes = WorldPage(calibration), AxesPage(calibration)
        self.pages: dict[StepName, BoardPage | PicturesPage | LensesPage | WorldPage | AxesPage] = {
            "board": self.board, "pictures": self.pictures, "lenses": self.lenses,
            "world": self.world, "axes": self.axes,
        }  # fmt: skip
        self._lay_out()
        calibration.changes.watch(Part.CALIBRATION, self.show_state)
        calibration.changes.watch(Part.TASKS, self._show_progress)
        self.show_state()

    def _lay_out(self) -> None:
        self.middle, self.side = QStackedWidget(), QStackedWidget()
        for name, page in self.pages.items():
            scrolls = name in _SCROLLED
            title = f"{STEPS[name]}, step of the calibration"
            self.middle.addWidget(scrolled(page, title) if scrolls else page)
        self._pictures = splitter(Qt.Orientation.Vertical, (self.picture, 3), (self.coverage, 2))
        self.side.addWidget(self._pictures)
        self.side.addWidget(self.scene)
        both = splitter(Qt.Orientation.Horizontal, (self.middle, 1), (self.side, 1))
        both.setSizes([640, 480])
        right = vbox(self.verdict, (both, 1), self._bar(), spacing=8)
        close, tip = self._calibration.close_page, "Back to the welcome page"
        self.close_button = push_button("Close", close, tip)
        left = vbox(label("Calibration", "heading"), self.steps, None, self.close_button, spacing=8)
        self.setLayout(hbox(left, (right, 1), margins=(10, 8, 10, 8), spacing=10))

    def _bar(self) -> QHBoxLayout:
        self.do_button = push_button("", self._calibration.calculate)
        self.next_button = push_button("", self._calibration.go_on)
        self.stop_button = push_button("Stop", self._calibration.cancel, "Stop the calculation")
        self.said = ElidedLabel()
        self.progress = named(thin_progress(), "Progress of the calibration")
        middle = vbox(self.said, self.progress, spacing=2)
        return hbox(self.do_button, (middle, 1), self.stop_button, self.next_button)

    def show_state(self) -> None:
        state, calibration = self._calibration.state, self._calibration
        self.steps.show_state(state)
        self.verdict.show_state(state)
        self.pages[state.step].show_state(state)
        self.middle.setCurrentIndex(list(STEPS).index(state.step))
        self._show_side(state)
        self.close_button.setVisible(state.recording is None)
        do, again = _DO.get(state.step, ("", ""))
        made = state.is_done(state.step) or state.is_stale(state.step)
        self.do_button.setVisible(bool(do))
        self.do_button.setText(again if made else do)
        allow(self.do_button, calibration.why_not_calculate(), "Calculate this step")
        step = state.next_step() if state.busy is None else None
        self.next_button.setVisible(state.step != "axes")
        self.next_button.setText("Next" if step is None else f"Next: {STEPS[step].lower()}")
        allow(self.next_button, calibration.why_no_next(), "Go to the next step")
        for widget in (self.stop_button, self.said, self.progress):
            widget.setVisible(state.busy is not None)

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

    def _show_progress(self) -> None:
        task = self._calibration.job.task
        if task is not None and not task.over:
            self.said.set_words(": ".join(filter(None, (task.title, task.words))))
            self.progress.setMaximum(1000 if task.share > 0.0 else 0)
            self.progress.setValue(round(1000 * task.share))
