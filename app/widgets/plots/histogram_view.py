"""How often numbers of each size occur, as bars."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QWidget

from stereotrack_core.arrays import FloatArray

from ..style.building import vbox
from ..style.diverging import FULL_RESIDUAL, shade_colours, shade_of
from ..style.theme import Dressed, current_theme
from .plots import dress_plot, label_axis, new_plot

_HEIGHT = 110


@dataclass(frozen=True, eq=False)
class Histogram:
    """How often residuals of each size occur."""

    title: str
    edges: FloatArray
    """(B + 1,) float64. In the unit."""
    counts: FloatArray
    """(B,) float64."""
    shades: FloatArray
    """(B,) float64. -1 to 1: colour of each bar."""
    unit: str
    words: str
    """What is to be said about all of them."""
    sides: tuple[str, str] = ("", "")
    """What negative and positive numbers mean."""


class HistogramView(Dressed):
    """One :class:`Histogram`; its bars have the colours of the lines in the views."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._shown: Histogram | None = None
        self._plot = new_plot(self)
        self._plot.hideAxis("left")
        self.setLayout(vbox(self._plot))
        self.setFixedHeight(_HEIGHT)
        self.setAccessibleName("Residuals")
        # the page scrolls, not its plot
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)

    def show_histogram(self, shown: Histogram | None) -> None:
        """Show other numbers."""
        self._shown = shown
        self.setAccessibleDescription(shown.words if shown is not None else "")
        self._plot.clear()
        dress_plot(self._plot, grid=False)
        if shown is None or not len(shown.counts):
            return
        colours = np.array(shade_colours())[shade_of(shown.shades * FULL_RESIDUAL)]
        bars = pg.BarGraphItem(
            x0=shown.edges[:-1], x1=shown.edges[1:], height=shown.counts,
            brushes=colours.tolist(), pen=current_theme().border,
        )  # fmt: skip
        self._plot.addItem(bars)
        first, last = float(shown.edges[0]), float(shown.edges[-1])
        signs = ("≤ " if first < 0.0 else "", "", "≥ ")
        values = (first, 0.5 * (first + last), last)
        ticks = [(v, f"{sign}{v:.0f} {shown.unit}") for v, sign in zip(values, signs, strict=True)]
        self._plot.getAxis("bottom").setTicks([ticks])
        below, above = shown.sides
        said = f"←  {below}  ·  {above}  →" if first < 0.0 else ""
        label_axis(self._plot, "bottom", said)
        self._plot.getAxis("bottom").showLabel(bool(said))
        self._plot.setXRange(first, last, padding=0.12)
        self._plot.setYRange(0.0, max(float(shown.counts.max()), 1.0), padding=0.02)

    def _dress(self) -> None:
        self.show_histogram(self._shown)
