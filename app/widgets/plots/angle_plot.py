"""A joint angle over frames, left and right, several runs over each other, with its uncertainty."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QWidget

from ..style.building import ElidedLabel, choice, hbox, vbox
from ..style.theme import current_theme
from .frame_plot import FRAME_KEYS, FramePlot
from .plots import Curve, label_axis, shade

_NOTHING = "Run the tracker, or open a recording with a reference, to see joint angles."


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
        self.setAccessibleDescription(f"Click to go to a frame, scroll to zoom. {FRAME_KEYS}")
        self.angle = choice("Joint angle", [a[:2] for a in angles], "Joint angle")
        for i, (_, _, tip) in enumerate(angles):
            self.angle.setItemData(i, tip, Qt.ItemDataRole.ToolTipRole)
        name = "Angle, velocity or acceleration"
        self.quantity = choice(name, quantities, name)
        for box in (self.angle, self.quantity):
            box.currentIndexChanged.connect(lambda _: self.chosen.emit())
        self.words = ElidedLabel(_NOTHING, self)
        self._region = pg.LinearRegionItem(movable=False)
        self._region.setZValue(-10)
        self._region.hide()
        self._plot.addItem(self._region, ignoreBounds=True)
        self.words.setContentsMargins(8, 0, 8, 2)
        head = hbox(self.angle, self.quantity, (self.legend, 1), margins=(8, 2, 0, 0))
        self.setLayout(vbox(head, (self._plot, 1), self.words, spacing=0))
        self._dress()

    @property
    def angle_key(self) -> str:
        """Key of the angle that is chosen."""
        return str(self.angle.currentData())

    @property
    def quantity_key(self) -> str:
        """Key of the quantity that is chosen."""
        return str(self.quantity.currentData())

    def show_curves(self, curves: Sequence[Curve], unit: str, words: str) -> None:
        """Draw these curves; `words` say how they were made."""
        self.set_curves(curves)
        label_axis(self._plot, "left", unit)
        self.words.set_words(words if curves else _NOTHING)

    def set_selection(self, selection: range | None) -> None:
        """Shade the selected frames."""
        self._region.setVisible(bool(selection))
        if selection:
            self._region.setRegion((selection.start - 0.5, selection.stop - 0.5))

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
