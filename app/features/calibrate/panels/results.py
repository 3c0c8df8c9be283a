"""Steps whose results are tables: pictures, lenses, all cameras."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker
from PySide6.QtWidgets import QTabWidget, QWidget

from stereotrack_core.calibrate.lens import LENS_MODELS
from stereotrack_core.calibrate.report import world_tables

from ....widgets.style.building import choice, hbox, label_of, scrolled, vbox
from ....widgets.tables.table import RIGHT, STRETCH, Column, PlainTable
from ....widgets.tables.trees import CellTree
from ..controller import CalibrationController
from ..shown import camera_rows, short_lens_table
from ..state import Calibration

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
        super().__init__("Pictures of the board", _PICTURES)
        self.setAlternatingRowColors(True)
        self.changed.connect(lambda key, on, _name: calibration.tick(key, on=on))
        self.chosen.connect(lambda key: calibration.choose(*key))

    def show_state(self, state: Calibration) -> None:
        self.show_rows(camera_rows(state))
        if state.shot is not None and state.busy != "pictures":
            with QSignalBlocker(self):
                self.choose(state.shot)


class LensesPage(QWidget):
    """A row per lens above the pictures."""

    def __init__(self, calibration: CalibrationController) -> None:
        super().__init__()
        self._calibration = calibration
        self.table = PlainTable("Lenses")
        self.tree = PicturesPage(calibration)
        models = [("auto", "automatic"), *((name, name) for name in LENS_MODELS)]
        self.model = choice("Lens model", models, _ABOUT_MODEL)
        self.model.activated.connect(lambda: calibration.set_model(self.model.currentData()))
        self.table.chosen.connect(self._on_camera)
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
        errors = QWidget()
        errors.setLayout(vbox(self.cameras, self.whole, None, margins=(0, 6, 0, 0)))
        self.tabs = QTabWidget()
        self.tabs.setDocumentMode(True)
        self.tabs.addTab(scrolled(errors, "Errors of the cameras"), "Cameras")
        self.tabs.addTab(self.tree, "Pictures")
        self.setLayout(vbox((self.tabs, 1)))

    def show_state(self, state: Calibration) -> None:
        tables = world_tables(state.world.result)[-2:] if state.world is not None else [None, None]
        for widget, table in zip((self.cameras, self.whole), tables, strict=True):
            widget.show_table(table)
        self.tree.show_state(state)
