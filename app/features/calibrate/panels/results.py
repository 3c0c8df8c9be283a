"""Steps whose results are tables: pictures, lenses, all cameras."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QSignalBlocker
from PySide6.QtWidgets import QTabWidget, QWidget

from stereotrack_core.calibrate.lens import LENS_MODELS
from stereotrack_core.calibrate.report import world_tables

from ....widgets.forms.form_dialog import ask_to_open
from ....widgets.style.building import choice, hbox, label, label_of, scrolled, vbox
from ....widgets.tables.table import PlainTable
from ....widgets.tables.trees import PictureTree
from ..controller import CalibrationController
from ..shown import camera_rows, short_lens_table
from ..state import Calibration

_ABOUT_MODEL = (
    "Automatic: all models are fitted, and the simplest is taken that none of the others clearly "
    "improves on"
)


_ABOUT_ORIGIN = (
    "Lenses of a camera that was calibrated before can be kept, as long as its zoom and focus were "
    "not touched; then only the places are calculated"
)
_CALCULATED, _FILE = "calculated", "another file"


class _Pictures(PictureTree):
    """The pictures with their ticks."""

    def __init__(self, calibration: CalibrationController) -> None:
        super().__init__()
        self.ticked.connect(lambda camera, frame, on: calibration.tick((camera, frame), on=on))
        self.chosen.connect(calibration.choose)

    def show_state(self, state: Calibration) -> None:
        """Show the pictures as they are known."""
        self.show_pictures(camera_rows(state))
        if state.shot is not None and state.busy != "pictures":
            with QSignalBlocker(self):
                self.choose(*state.shot)


class PicturesPage(QWidget):
    """In which pictures the board was found."""

    def __init__(self, calibration: CalibrationController) -> None:
        super().__init__()
        self.tree = _Pictures(calibration)
        self.setLayout(vbox((self.tree, 1)))

    def show_state(self, state: Calibration) -> None:
        """Show it."""
        self.tree.show_state(state)


class LensesPage(QWidget):
    """A row per lens above the pictures."""

    def __init__(self, calibration: CalibrationController) -> None:
        super().__init__()
        self._calibration = calibration
        self.table = PlainTable("Lenses")
        self.tree = _Pictures(calibration)
        models = [("auto", "automatic"), *((name, name) for name in LENS_MODELS)]
        self.model = choice("Lens model", models, _ABOUT_MODEL)
        self.model.activated.connect(lambda: calibration.set_model(self.model.currentData()))
        self.table.chosen.connect(self._on_camera)
        self.origin = choice("Where the lenses come from", (), _ABOUT_ORIGIN)
        self.origin.activated.connect(self._on_origin)
        self.kept = label("", "muted")
        row = hbox(
            label_of(self.origin, "Lenses"), self.origin,
            label_of(self.model, "Lens model"), self.model, None,
        )  # fmt: skip
        self.setLayout(vbox(row, self.kept, self.table, (self.tree, 1)))

    def show_state(self, state: Calibration) -> None:
        """Show the lenses and the errors of their pictures."""
        self._show_origin(state)
        self.model.setCurrentIndex(self.model.findData(state.model))
        self.table.show_table(short_lens_table(state))
        self.tree.show_state(state)

    def _show_origin(self, state: Calibration) -> None:
        file = "" if state.kept is None else state.kept.file.name
        options = [(_CALCULATED, "calculate"), *([(file, f"keep those of {file}")] if file else [])]
        self.origin.clear()
        for key, text in [*options, (_FILE, "keep those of a calibration file …")]:
            self.origin.addItem(text, key)
        self.origin.setCurrentIndex(1 if file else 0)
        given = state.given
        others = [one.camera for one in state.sources if one.camera not in given]
        words = f"Kept as they are: {', '.join(given)}."
        words += f" Calculated from the pictures: {', '.join(others)}." if others else ""
        self.kept.setText(words)
        self.kept.setVisible(bool(file))
        self.model.setEnabled(bool(others))
        self.model.setToolTip(_ABOUT_MODEL if others else "Unavailable: all lenses are kept.")

    def _on_origin(self) -> None:
        key, state = str(self.origin.currentData()), self._calibration.state
        if key == _CALCULATED:
            self._calibration.keep_lenses(None)
            return
        self._show_origin(state)  # as it was, until a file is chosen
        if key == _FILE:
            start = state.kept.file if state.kept is not None else Path.home()
            ask_to_open(
                self, "Lenses that were calibrated before", start, "Calibration (*.toml)",
                self._calibration.keep_lenses,
            )  # fmt: skip

    def _on_camera(self, camera: str) -> None:
        fit = self._calibration.state.fits.get(camera)
        if fit is not None and len(fit.sightings):
            self._calibration.choose(camera, int(fit.sightings.frames[0]))


class WorldPage(QWidget):
    """Cameras, distances between them, and the pictures."""

    def __init__(self, calibration: CalibrationController) -> None:
        super().__init__()
        self.cameras, self.whole = PlainTable("Cameras"), PlainTable("All together", most=24)
        self.tree = _Pictures(calibration)
        errors = QWidget()
        errors.setLayout(vbox(self.cameras, self.whole, None, margins=(0, 6, 0, 0)))
        self.tabs = QTabWidget()
        self.tabs.setDocumentMode(True)
        self.tabs.addTab(scrolled(errors, "Errors of the cameras"), "Cameras")
        self.tabs.addTab(self.tree, "Pictures")
        self.setLayout(vbox((self.tabs, 1)))

    def show_state(self, state: Calibration) -> None:
        """Show the errors of every camera."""
        tables = world_tables(state.world.result)[-2:] if state.world is not None else [None, None]
        for widget, table in zip((self.cameras, self.whole), tables, strict=True):
            widget.show_table(table)
        self.tree.show_state(state)
