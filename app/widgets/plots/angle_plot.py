"""A joint angle over frames, left and right, several runs over each other, with its uncertainty."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QWidget

from stereotrack_core.arrays import FloatArray, IntArray

from ..style.building import choice, hbox, label, vbox
from ..style.elided_label import ElidedLabel, shortened
from ..style.line_styles import PEN_STYLES
from ..style.theme import current_theme
from .frame_plot import FRAME_KEYS, FramePlot
from .plots import band, label_axis, shade

REFERENCE_STYLE = "reference"
"""Line style that no run has."""

_STYLES: dict[str, Qt.PenStyle] = dict(PEN_STYLES.items()) | {
    REFERENCE_STYLE: Qt.PenStyle.DashDotDotLine
}
_SIGNS = {"solid": "━━", "dash": "╌╌", "dot": "┈┈", "dashdot": "╌·╌", REFERENCE_STYLE: "╌··╌"}
_NOTHING = "Run the tracker, or open a recording with a reference, to see joint angles."


@dataclass(frozen=True, eq=False)
class AngleCurve:
    """One angle, velocity or acceleration in one run or in the reference."""

    name: str
    """The run, or the reference."""
    label: str
    """``left`` or ``right``; empty for what has no side."""
    colour: str
    style: str
    """A run's, or :data:`REFERENCE_STYLE`."""
    frame: IntArray
    """(F,) int64."""
    value: FloatArray
    sigma: FloatArray
    """`value` and `sigma`: (F,) float64. In the plot's unit; NaN leaves a gap, or no band."""


_MOST_LETTERS = 24


class AnglePlot(FramePlot):
    """Curves with bands of one standard deviation, and a playhead."""

    chosen = Signal()
    """Another angle or quantity shall be shown; beside those of :class:`FramePlot`."""

    def __init__(
        self,
        angles: Sequence[tuple[str, str, str]],
        quantities: Sequence[tuple[str, str]],
        parent: QWidget | None = None,
    ) -> None:
        super().__init__("Plot of a joint angle over frames", parent)
        self.shown_curves: tuple[AngleCurve, ...] = ()
        """What is drawn."""
        self._items: list[pg.GraphicsObject] = []
        self.setAccessibleDescription(f"Click to go to a frame, scroll to zoom. {FRAME_KEYS}")
        self.angle = choice("Joint angle", [a[:2] for a in angles], "Joint angle")
        for i, (_, _, tip) in enumerate(angles):
            self.angle.setItemData(i, tip, Qt.ItemDataRole.ToolTipRole)
        name = "Angle, velocity or acceleration"
        self.quantity = choice(name, quantities, name)
        for box in (self.angle, self.quantity):
            box.currentIndexChanged.connect(lambda _: self.chosen.emit())
        self.legend = label("", "muted", wraps=False)
        self.legend.setTextFormat(Qt.TextFormat.RichText)
        self.words = ElidedLabel(_NOTHING, self)
        self._region = pg.LinearRegionItem(movable=False)
        self._region.setZValue(-10)
        self._region.hide()
        self._plot.addItem(self._region, ignoreBounds=True)
        self.words.setContentsMargins(8, 0, 8, 2)
        head = hbox(self.angle, self.quantity, self.legend, None, margins=(8, 2, 8, 0))
        self.setLayout(vbox(head, (self._plot, 1), self.words, spacing=0))
        self._dress()

    # ---- what is shown

    @property
    def angle_key(self) -> str:
        """Key of the angle that is chosen."""
        return str(self.angle.currentData())

    @property
    def quantity_key(self) -> str:
        """Key of the quantity that is chosen."""
        return str(self.quantity.currentData())

    def show_curves(self, curves: Sequence[AngleCurve], unit: str, words: str) -> None:
        """Draw these curves; `words` say how they were made."""
        for item in self._items:
            self._plot.removeItem(item)
        self.shown_curves, self._items = tuple(curves), []
        for curve in curves:
            self._add_band(curve)
        for curve in curves:
            self._add(curve)
        label_axis(self._plot, "left", unit)
        self.words.set_words(words if curves else _NOTHING)
        self._write_legend()
        self._fit_values()

    def set_selection(self, selection: range | None) -> None:
        """Shade the selected frames."""
        self._region.setVisible(bool(selection))
        if selection:
            self._region.setRegion((selection.start - 0.5, selection.stop - 0.5))

    # ---- inside

    def _add(self, curve: AngleCurve) -> None:
        pen = pg.mkPen(curve.colour, width=1.4, style=_STYLES[curve.style])
        self._put(pg.PlotCurveItem(curve.frame, curve.value, pen=pen, connect="finite"))

    def _add_band(self, curve: AngleCurve) -> None:
        known = np.isfinite(curve.value) & np.isfinite(curve.sigma)
        ends = np.flatnonzero(np.diff(np.concatenate([[0], known.astype(np.int8), [0]])))
        # a band of its own for every stretch: gaps stay open
        for first, end in ends.reshape(-1, 2):
            own = slice(first, end)
            value, sigma = curve.value[own], curve.sigma[own]
            for item in band(curve.frame[own], value - sigma, value + sigma, curve.colour):
                self._put(item)

    def _is_empty(self) -> bool:
        return not self.shown_curves

    def _put(self, item: pg.GraphicsObject) -> None:
        self._plot.addItem(item)
        self._items.append(item)

    def _write_legend(self) -> None:
        sides = {c.label: c.colour for c in self.shown_curves if c.label}
        runs = {c.name: c.style for c in self.shown_curves}
        parts = [f'<span style="color:{colour}">━━</span> {side}' for side, colour in sides.items()]
        names = {name: escape(shortened(name, _MOST_LETTERS)) for name in runs}
        parts += [f"{_SIGNS[style]} {names[name]}" for name, style in runs.items()]
        self.legend.setText(" &nbsp; ".join(parts))

    def _fit_values(self) -> None:
        values = [c.value[np.isfinite(c.value)] for c in self.shown_curves]
        known = np.concatenate([*values, np.empty(0)])
        if len(known):
            low, high = float(known.min()), float(known.max())
            self._box.setYRange(low, max(high, low + 1.0), padding=0.08)

    def _dress(self) -> None:
        super()._dress()
        accent = current_theme().accent
        self._region.setBrush(shade(accent))
        for line in self._region.lines:
            line.setPen(pg.mkPen(accent))
