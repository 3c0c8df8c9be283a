"""A person in a few lines, with dots where landmarks are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import QWidget

from ..plots.plots import new_plot
from ..style.building import hbox, label, vbox
from ..style.theme import Dressed, current_theme

_DOT = 10


@dataclass(frozen=True)
class Sketch:
    """What is drawn; metres to the right and down."""

    lines: tuple[tuple[tuple[float, float], tuple[float, float]], ...] = ()
    """Tuple of ((x, y), (x, y)). The body."""
    dots: tuple[tuple[float, float, str, str], ...] = ()
    """Tuple of (x, y, colour, label)."""


class BodySketch(Dressed):
    """The sketch as large as there is room."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._shown: tuple[Sketch, str] = Sketch(), ""
        self._plot = new_plot(self)
        self._plot.getPlotItem().setMouseEnabled(False, False)
        self._plot.hideAxis("left")
        self._plot.hideAxis("bottom")
        box = self._plot.getViewBox()
        box.invertY()
        box.setAspectLocked()
        box.setDefaultPadding(0.05)
        self.dots = pg.ScatterPlotItem(hoverable=True, tip="{data}".format)
        """Landmarks, each with its label as data."""
        sides = hbox(label("right", "muted"), None, label("left", "muted"), margins=(8, 0, 8, 4))
        self.setLayout(vbox((self._plot, 1), sides, spacing=0))
        self.setMinimumSize(180, 260)
        self.setAccessibleName("Positions of the landmarks on the body")
        self.setToolTip("Front view: the person's left side is on the right.")

    def sizeHint(self) -> QSize:
        return QSize(220, 340)

    def show_sketch(self, sketch: Sketch, selected: str = "") -> None:
        """Draw this; the dot of that label stands out."""
        self._shown = sketch, selected
        self._dress()

    def _dress(self) -> None:
        (sketch, selected), theme = self._shown, current_theme()
        self._plot.clear()
        self._plot.setBackground(theme.base)
        round_cap = pg.mkPen(theme.disabled, width=7)
        round_cap.setCapStyle(Qt.PenCapStyle.RoundCap)
        x, y = np.array(sketch.lines, dtype=np.float64).reshape(-1, 2).T
        self._plot.addItem(pg.PlotCurveItem(x, y, connect="pairs", pen=round_cap))
        rims = {True: pg.mkPen(theme.text, width=2), False: pg.mkPen(theme.base, width=2)}
        self.dots.setData(
            [
                {
                    "pos": (across, down), "brush": colour, "data": name,
                    "pen": rims[name == selected], "size": _DOT + 5 * (name == selected),
                }
                for across, down, colour, name in sketch.dots
            ]
        )  # fmt: skip
        self._plot.addItem(self.dots)
