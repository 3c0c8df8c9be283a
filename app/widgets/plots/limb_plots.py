"""Errors of limbs over the frames, several runs over each other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QColor, QResizeEvent
from PySide6.QtWidgets import QWidget

from ..style.building import hbox, label, vbox
from ..style.limb_colours import EXTRA_COLOURS
from ..style.theme import current_theme
from .frame_plot import FRAME_KEYS, FramePlot
from .plots import Curve, label_axis

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
        self.setAccessibleDescription(_HELP)
        self._add_threshold()
        self._heading = label(title, "heading", wraps=False)
        head = hbox(self._heading, (self.legend, 1), margins=(8, 0, 0, 0))
        self.setLayout(vbox(head, (self._plot, 1), spacing=0))
        self._dress()

    # ---- what is shown

    @property
    def threshold(self) -> float:
        """Value of the line."""
        return float(self._threshold.value())

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
        super().set_curves(curves)
        self._fit_heading()

    def set_threshold(self, value: float) -> None:
        """Move the threshold's line without emitting a signal."""
        # the line's own label listens to its signal
        self._quiet = True
        self._threshold.setValue(value)
        self._quiet = False

    def crossing(self, direction: int) -> int | None:
        """Frame of the next (1) or previous (-1) stretch above the threshold, if any.

        After the last one comes the first, and the other way around.
        """
        angles = [curve for curve in self.shown_curves if curve.limb not in EXTRA_COLOURS]
        found = next_crossing(angles, self.threshold, self._frame, direction)
        if found is not None:
            return found
        first, last = self._extent()
        end = first - 1 if direction > 0 else last
        return next_crossing(angles, self.threshold, int(end), direction)

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

    def _fit_values(self) -> None:
        tops = [np.nanmax(c.value) for c in self.shown_curves if np.isfinite(c.value).any()]
        top = max([1.06 * float(value) for value in tops] + [1.15 * self.threshold, 1e-6])
        self._box.setYRange(0.0, top, padding=0)

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


def _name(title: str) -> str:
    return f"Plot of the {title} over frames"


def next_crossing(
    curves: Sequence[Curve], threshold: float, frame: int, direction: int
) -> int | None:
    """First frame of the next or previous stretch in which any curve is above the threshold.

    `frame` is where to start looking, `direction` 1 for forwards, -1 for backwards; None where
    there is no such stretch.
    """
    above: set[int] = set()
    for curve in curves:
        with np.errstate(invalid="ignore"):
            above.update(curve.frame[curve.value > threshold].tolist())
    frames = np.array(sorted(above), dtype=np.int64)
    if not len(frames):
        return None
    begins = frames[np.concatenate([[True], np.diff(frames) > 1])]
    wanted = begins[begins > frame] if direction > 0 else begins[begins < frame]
    if not len(wanted):
        return None
    return int(wanted[0] if direction > 0 else wanted[-1])
