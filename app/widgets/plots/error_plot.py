"""Error of each limb over the frames, several runs over each other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QColor, QResizeEvent
from PySide6.QtWidgets import QWidget

from ..style.building import hbox, label, vbox
from ..style.limb_colours import EXTRA_COLOURS, limb_words
from ..style.line_styles import PEN_STYLES
from ..style.theme import current_theme
from .error_curves import Curve, next_crossing, thinned
from .frame_plot import FRAME_KEYS, FramePlot
from .limb_legend import LimbLegend
from .plots import label_axis

_HELP = (
    "Click to go to a frame, drag the threshold line, scroll to zoom, right-drag to scale. "
    f"{FRAME_KEYS}"
)


class ErrorPlot(FramePlot):
    """Curves per limb with a threshold that can be dragged and a playhead."""

    threshold_changed = Signal(float)
    """The line was dragged to this value; beside those of :class:`FramePlot`."""

    def __init__(
        self,
        parent: QWidget | None = None,
        *,
        title: str = "angular error",
        unit: str = "deg",
    ) -> None:
        super().__init__(_name(title), parent)
        self._unit = unit
        self._headings = title, ""
        self._curves: tuple[Curve, ...] = ()
        self._items: list[pg.PlotCurveItem] = []
        self.setAccessibleDescription(_HELP)
        self.legend = LimbLegend(self)
        """Switches of the limbs."""
        self.legend.toggled.connect(self._on_toggled)
        self._add_threshold()
        self._heading = label(title, "heading", wraps=False)
        head = hbox(self._heading, (self.legend, 1), margins=(8, 0, 0, 0))
        self.setLayout(vbox(head, (self._plot, 1), spacing=0))
        self._box.sigResized.connect(self._thin)
        self._dress()

    # ---- what is shown

    @property
    def threshold(self) -> float:
        """Value of the line."""
        return float(self._threshold.value())

    @property
    def shown_curves(self) -> tuple[Curve, ...]:
        """Curves of limbs that are not switched off."""
        hidden = self.legend.hidden_limbs
        return tuple(curve for curve in self._curves if curve.limb not in hidden)

    def set_title(self, title: str) -> None:
        """Show another measure."""
        self.setAccessibleName(_name(title))

    def set_heading(self, words: str, brief: str = "", tip: str = "") -> None:
        """Say what is shown; `brief` is what stands there where `words` have no room."""
        if (words, brief, tip) != (*self._headings, self._heading.toolTip()):
            self._headings = words, brief
            self._heading.setToolTip(tip)
            self.setAccessibleDescription(f"{words}. {tip} {_HELP}")
            self._fit_heading()

    @property
    def heading(self) -> str:
        """What is said over the curves; empty where there is no room for it."""
        return "" if self._heading.isHidden() else self._heading.text()

    def set_curves(self, curves: Sequence[Curve]) -> None:
        """Show these curves; what a person has zoomed to is kept."""
        first, last = self._box.viewRange()[0]
        low, high = self._extent()
        was_whole = not self._curves or (first <= low + 0.5 and high - 0.5 <= last)
        self._curves = tuple(curves)
        for item in self._items:
            self._plot.removeItem(item)
        self._items = [self._new_item(curve) for curve in self._curves]
        self.legend.set_curves(self._curves)
        self._fit_heading()
        self._limit()
        if was_whole and self._extent() != (low, high):
            self.show_everything()
        self._on_toggled()

    def set_threshold(self, value: float) -> None:
        """Move the threshold's line without emitting a signal."""
        # the line's own label listens to its signal
        self._quiet = True
        self._threshold.setValue(value)
        self._quiet = False

    def crossing(self, direction: int) -> int | None:
        """Frame of the next (1) or previous (-1) stretch above the threshold, if any."""
        angles = [curve for curve in self.shown_curves if curve.limb not in EXTRA_COLOURS]
        return next_crossing(angles, self.threshold, self._frame, direction)

    # ---- inside

    def _add_threshold(self) -> None:
        self._threshold = pg.InfiniteLine(
            45.0,
            angle=0,
            movable=True,
            bounds=(0.0, 180.0 if self._unit == "deg" else None),
            label="{value:.0f} " + self._unit,
            labelOpts={"position": 0.985, "anchors": [(1, 0), (1, 1)]},
        )
        self._threshold.sigPositionChanged.connect(self._on_threshold)
        self._threshold.setToolTip(
            "Threshold for going to the next or previous stretch. Drag to change."
        )
        self._threshold.setZValue(20)
        self._plot.addItem(self._threshold, ignoreBounds=True)

    def _new_item(self, curve: Curve) -> pg.PlotCurveItem:
        style = PEN_STYLES[curve.style]
        item = pg.PlotCurveItem(
            # wider lines take Qt ten times as long
            pen=pg.mkPen(curve.colour, width=1, style=style),
            connect="finite",
            name=f"{curve.name}, {limb_words(curve.limb)}",
        )
        # the playhead moves over kept pictures of the curves
        item.setCacheMode(pg.PlotCurveItem.CacheMode.DeviceCoordinateCache)
        self._plot.addItem(item)
        return item

    def _is_empty(self) -> bool:
        return not self._curves

    def _extent(self) -> tuple[float, float]:
        if self._frame_count:
            return super()._extent()
        ends = [(c.frame[0], c.frame[-1] + 1) for c in self._curves if len(c.frame)]
        if not ends:
            return 0.0, 1.0
        return float(min(a for a, _ in ends)), float(max(b for _, b in ends))

    def _fit_values(self) -> None:
        tops = [np.nanmax(c.value) for c in self.shown_curves if np.isfinite(c.value).any()]
        top = max([1.06 * float(value) for value in tops] + [1.15 * self.threshold, 1e-6])
        self._box.setYRange(0.0, top, padding=0)

    def _thin(self) -> None:
        first, last = self._box.viewRange()[0]
        columns = max(int(self._box.width()), 50)
        hidden = self.legend.hidden_limbs
        for curve, item in zip(self._curves, self._items, strict=True):
            item.setVisible(curve.limb not in hidden)
            if curve.limb not in hidden:
                item.setData(*thinned(curve.frame, curve.value, first, last, columns))

    def _on_toggled(self) -> None:
        self._fit_values()
        self._thin()

    def _on_range_changed(self) -> None:
        self._thin()
        super()._on_range_changed()

    def _on_threshold(self) -> None:
        if not self._quiet:
            self.threshold_changed.emit(self.threshold)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit_heading()

    def _fit_heading(self) -> None:
        # the switches come first; where they leave no room the axis has to do
        room = self.width() - self.legend.wanted_width - 24
        for words in self._headings:
            self._heading.setText(words)
            fits = bool(words) and self._heading.sizeHint().width() <= room
            self._heading.setVisible(fits)
            if fits:
                return

    def _dress(self) -> None:
        super()._dress()
        theme = current_theme()
        label_axis(self._plot, "left", self._unit)
        self._threshold.setPen(pg.mkPen(theme.error, width=1.5, style=Qt.PenStyle.DotLine))
        self._threshold.setHoverPen(pg.mkPen(theme.error, width=3.0))
        self._threshold.label.setColor(QColor(theme.error))
        self._threshold.label.fill = pg.mkBrush(theme.plot_background)
        self.legend.refresh()


def _name(title: str) -> str:
    return f"Plot of the {title} over frames"
