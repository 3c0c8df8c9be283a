"""A picture of a calibration board with its corners, or the corners of all pictures of a camera."""

from dataclasses import dataclass

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QRectF, QSize, Qt
from PySide6.QtGui import QColor

from stereotrack_core.arrays import BoolArray, FloatArray, ImageArray

from ..plots.plots import dress_plot, new_plot, shade
from ..style.building import label, named, vbox
from ..style.theme import Dressed, current_theme

ENLARGED = 20.0  # how much longer errors are drawn than they are
_FOUND, _ERROR = QColor("#56d364"), QColor("#ff8a2b")
"""Bright on any picture."""


@dataclass(frozen=True, eq=False)
class BoardShot:
    """An image of `size` (width, height) with corners (n, 2) and their errors (n, 2), pixels.

    Corners are NaN where unseen. `columns` is the number of corners in a row; 0: they are dots.
    """

    title: str
    size: tuple[int, int] = (0, 0)
    corners: FloatArray | None = None
    errors: FloatArray | None = None
    columns: int = 0
    image: ImageArray | None = None  # (H, W) uint8, or None. Grey.
    cells: BoolArray | None = None  # (r, c) bool, or None. Cells of the image that hold corners.
    message: str = ""


class BoardPicture(Dressed):
    """Shows one :class:`BoardShot`, which can be enlarged; `nothing` is said without one."""

    def __init__(self, name: str, tip: str, nothing: str) -> None:
        super().__init__()
        self._nothing = nothing
        self.shot: BoardShot | None = None
        named(self, name, tip).setMinimumSize(160, 100)
        self.words = label("", "muted", align=Qt.AlignmentFlag.AlignCenter)
        self._plot = new_plot(self)
        for side in ("left", "bottom"):
            self._plot.hideAxis(side)
        self._plot.setAspectLocked()
        self._plot.invertY()
        self._image = pg.ImageItem(axisOrder="row-major", levels=(0, 255), autoDownsample=True)
        self._cells = pg.ImageItem(axisOrder="row-major", levels=(0, 255))
        self._lines = pg.PlotCurveItem(pen=pg.mkPen(_FOUND), connect="finite")
        self._errors = pg.PlotCurveItem(pen=pg.mkPen(_ERROR, width=1.5), connect="pairs")
        self._dots = pg.ScatterPlotItem(pen=None)
        for item in (self._image, self._cells, self._lines, self._dots, self._errors):
            self._plot.addItem(item)
        self.setLayout(vbox(self.words, (self._plot, 1), spacing=2))
        self.show_shot(None)
        self._dress()

    def sizeHint(self) -> QSize:
        return QSize(480, 360)

    def show_shot(self, shot: BoardShot | None) -> None:
        before, self.shot = self.shot, shot
        said = self._nothing if shot is None else shot.message or shot.title
        self.words.setText(said)
        self.setAccessibleDescription(said)
        there = shot is not None and all(shot.size)
        self._plot.setVisible(there)
        if shot is None or not there:
            return
        box = QRectF(0.0, 0.0, *shot.size)
        if before is None or before.size != shot.size:
            self._plot.setRange(box, padding=0.01)
        _show_image(self._image, shot.image, box)
        _show_image(self._cells, None if shot.cells is None else _tinted(shot.cells), box)
        self._show_corners(shot)

    def _show_corners(self, shot: BoardShot) -> None:
        at = np.empty((0, 2)) if shot.corners is None else shot.corners + 0.5
        rows = at.reshape(-1, shot.columns or 1, 2)
        apart = np.pad(rows, ((0, 0), (0, 1), (0, 0)), constant_values=np.nan).reshape(-1, 2)
        self._lines.setData(*(apart.T if shot.columns else np.empty((2, 0))))
        sizes = np.full(len(at), 5.0 if shot.columns else 2.0)
        sizes[:1] *= 1.8 if shot.columns else 1.0  # where the board begins
        colour = _FOUND if shot.columns else QColor(current_theme().text)
        known = np.isfinite(at).all(axis=1)
        self._dots.setData(*at[known].T, size=sizes[known], brush=colour)
        errors = np.full_like(at, np.nan) if shot.errors is None else shot.errors
        ends = np.stack([at, at + ENLARGED * errors], axis=1)
        self._errors.setData(*ends[np.isfinite(ends).all(axis=(1, 2))].reshape(-1, 2).T)

    def _dress(self) -> None:
        dress_plot(self._plot)
        self.show_shot(self.shot)


def _show_image(item: pg.ImageItem, image: ImageArray | None, box: QRectF) -> None:
    item.setVisible(image is not None)
    if image is not None:
        item.setImage(image, autoLevels=False)
        item.setRect(box)


def _tinted(cells: BoolArray) -> ImageArray:
    """The theme's green where a cell is reached, else hardly any colour (r, c, 4)."""
    tints = shade(current_theme().text, 20), shade(current_theme().good, 90)
    return np.array([one.getRgb() for one in tints], np.uint8)[cells.astype(np.intp)]
