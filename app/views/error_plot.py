"""Error of each limb over the frames, several runs over each other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QEvent, QSize, Qt, Signal
from PySide6.QtGui import QColor, QKeyEvent, QResizeEvent
from PySide6.QtWidgets import QHBoxLayout, QLabel, QVBoxLayout, QWidget

from app.limb_colours import EXTRA_COLOURS, limb_words
from app.theme import current_theme
from app.views.error_curves import Curve, next_crossing, thinned
from app.views.limb_legend import LimbLegend
from app.views.line_styles import PEN_STYLES

_HELP = (
    "Click to go to a frame, drag the threshold line, wheel to zoom, right drag to scale. "
    "Keys: arrows step, A shows everything."
)


class ErrorPlot(QWidget):
    """Curves per limb with a threshold that can be dragged and a playhead.

    Signals
    -------
    frame_requested : int
        The person clicked at this frame.
    threshold_changed : float
        The line was dragged to this value.
    visible_range_changed : float, float
        The person zoomed or moved; borders of the visible frames as in
        :meth:`set_visible_range`.
    """

    frame_requested = Signal(int)
    threshold_changed = Signal(float)
    visible_range_changed = Signal(float, float)

    def __init__(
        self,
        parent: QWidget | None = None,
        *,
        title: str = "angular error",
        unit: str = "deg",
    ) -> None:
        super().__init__(parent)
        self._unit = unit
        self._headings = title, ""
        self._curves: tuple[Curve, ...] = ()
        self._items: list[pg.PlotCurveItem] = []
        self._frame = 0
        self._frame_count = 0
        self._quiet = False
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAccessibleName(f"Plot of the {title} over frames")
        self.setAccessibleDescription(_HELP)
        self._legend = LimbLegend(self)
        self._legend.toggled.connect(self._on_toggled)
        self._plot = pg.PlotWidget(self)
        self._plot.setFocusProxy(self)
        self._plot.setMenuEnabled(False)
        self._plot.hideButtons()
        self._plot.setMinimumHeight(80)
        self._box = self._plot.getViewBox()
        self._box.setMouseEnabled(x=True, y=False)
        self._add_lines()
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        head = QHBoxLayout()
        head.setContentsMargins(8, 0, 0, 0)
        self._heading = QLabel(title, self)
        self._heading.setProperty("role", "heading")
        head.addWidget(self._heading)
        head.addWidget(self._legend, 1)
        layout.addLayout(head)
        layout.addWidget(self._plot, 1)
        self._box.sigXRangeChanged.connect(self._on_range_changed)
        self._box.sigResized.connect(self._thin)
        self._plot.scene().sigMouseClicked.connect(self._on_clicked)
        self._dress()

    def sizeHint(self) -> QSize:
        return QSize(900, 200)

    def minimumSizeHint(self) -> QSize:
        return QSize(200, 110)

    # ---- what is shown

    @property
    def legend(self) -> LimbLegend:
        """Switches of the limbs."""
        return self._legend

    @property
    def threshold(self) -> float:
        """Value of the line."""
        return float(self._threshold.value())

    @property
    def shown_curves(self) -> tuple[Curve, ...]:
        """Curves of limbs that are not switched off."""
        hidden = self._legend.hidden_limbs
        return tuple(curve for curve in self._curves if curve.limb not in hidden)

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

    def set_range(self, frame_count: int) -> None:
        """Let the axis be that of a recording of `frame_count` frames."""
        self._frame_count = frame_count
        self.show_everything()

    def set_curves(self, curves: Sequence[Curve]) -> None:
        """Show these curves; what a person has zoomed to is kept."""
        first, last = self._box.viewRange()[0]
        low, high = self._extent()
        was_whole = not self._curves or (first <= low + 0.5 and high - 0.5 <= last)
        self._curves = tuple(curves)
        for item in self._items:
            self._plot.removeItem(item)
        self._items = [self._new_item(curve) for curve in self._curves]
        self._legend.set_curves(self._curves)
        self._fit_heading()
        self._limit()
        if was_whole and self._extent() != (low, high):
            self.show_everything()
        self._on_toggled()

    def set_frame(self, frame: int) -> None:
        """Move the playhead."""
        self._frame = frame
        self._playhead.setValue(frame)

    def set_threshold(self, value: float) -> None:
        """Move the threshold's line without emitting a signal."""
        # the line's own label listens to its signal
        self._quiet = True
        self._threshold.setValue(value)
        self._quiet = False

    def set_visible_range(self, first: float, last: float) -> None:
        """Zoom to the frames from `first` up to `last` without emitting a signal.

        As in the timeline, frame k covers the stretch from k to k + 1 and is drawn in its middle.
        """
        self._quiet = True
        self._box.setXRange(first - 0.5, last - 0.5, padding=0)
        self._quiet = False

    def set_margins(self, left: float, right: float) -> None:
        """Leave so many pixels beside the frames, so that they stand over a timeline's.

        The timeline has the frame numbers then, and the plot leaves them out.
        """
        self._plot.getAxis("left").setWidth(left)
        self._plot.getPlotItem().layout.setContentsMargins(0.0, 0.0, right, 0.0)
        self._plot.getAxis("bottom").setStyle(showValues=False)
        self._plot.getAxis("bottom").setHeight(6)

    def show_everything(self) -> None:
        """Zoom so that all frames are seen, without emitting a signal."""
        self._limit()
        self.set_visible_range(*self._extent())
        self._fit_values()

    def crossing(self, direction: int) -> int | None:
        """Frame of the next (1) or previous (-1) stretch above the threshold, if any."""
        angles = [curve for curve in self.shown_curves if curve.limb not in EXTRA_COLOURS]
        return next_crossing(angles, self.threshold, self._frame, direction)

    # ---- inside

    def _add_lines(self) -> None:
        self._threshold = pg.InfiniteLine(
            45.0,
            angle=0,
            movable=True,
            bounds=(0.0, 180.0 if self._unit == "deg" else None),
            label="{value:.0f} " + self._unit,
            labelOpts={"position": 0.985, "anchors": [(1, 0), (1, 1)]},
        )
        self._threshold.sigPositionChanged.connect(self._on_threshold)
        self._threshold.setToolTip("Threshold for next and previous; drag it")
        self._threshold.setZValue(20)
        self._playhead = pg.InfiniteLine(0.0, angle=90)
        self._playhead.setZValue(30)
        for line in (self._threshold, self._playhead):
            self._plot.addItem(line, ignoreBounds=True)

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

    def _extent(self) -> tuple[float, float]:
        """Borders of all frames."""
        if self._frame_count:
            return 0.0, float(self._frame_count)
        ends = [(c.frame[0], c.frame[-1] + 1) for c in self._curves if len(c.frame)]
        if not ends:
            return 0.0, 1.0
        return float(min(a for a, _ in ends)), float(max(b for _, b in ends))

    def _limit(self) -> None:
        first, last = self._extent()
        self._quiet = True
        self._box.setLimits(xMin=first - 0.5, xMax=last - 0.5, minXRange=min(4.0, last - first))
        self._quiet = False

    def _fit_values(self) -> None:
        tops = [np.nanmax(c.value) for c in self.shown_curves if np.isfinite(c.value).any()]
        top = max([1.06 * float(value) for value in tops] + [1.15 * self.threshold, 1e-6])
        self._box.setYRange(0.0, top, padding=0)

    def _thin(self) -> None:
        first, last = self._box.viewRange()[0]
        columns = max(int(self._box.width()), 50)
        hidden = self._legend.hidden_limbs
        for curve, item in zip(self._curves, self._items, strict=True):
            item.setVisible(curve.limb not in hidden)
            if curve.limb not in hidden:
                item.setData(*thinned(curve.frame, curve.value, first, last, columns))

    def _on_toggled(self) -> None:
        self._fit_values()
        self._thin()

    def _on_range_changed(self) -> None:
        self._thin()
        if not self._quiet:
            first, last = self._box.viewRange()[0]
            self.visible_range_changed.emit(first + 0.5, last + 0.5)

    def _on_threshold(self) -> None:
        if not self._quiet:
            self.threshold_changed.emit(self.threshold)

    def _on_clicked(self, event: object) -> None:
        position = event.scenePos()  # type: ignore[attr-defined]
        left = event.button() == Qt.MouseButton.LeftButton  # type: ignore[attr-defined]
        if left and self._curves and self._box.sceneBoundingRect().contains(position):
            self._request(round(self._box.mapSceneToView(position).x()))

    def _request(self, frame: int) -> None:
        first, last = self._extent()
        frame = int(min(max(frame, first), last - 1))
        if frame != self._frame:
            self.set_frame(frame)
            self.frame_requested.emit(frame)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        ten = 10 if event.modifiers() & Qt.KeyboardModifier.ShiftModifier else 1
        if event.key() == Qt.Key.Key_Left:
            self._request(self._frame - ten)
        elif event.key() == Qt.Key.Key_Right:
            self._request(self._frame + ten)
        elif event.key() == Qt.Key.Key_A and not event.modifiers():
            self.show_everything()
            self.visible_range_changed.emit(*self._extent())
        else:
            super().keyPressEvent(event)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit_heading()

    def _fit_heading(self) -> None:
        # the switches come first; where they leave no room the axis has to do
        room = self.width() - self._legend.wanted_width - 24
        for words in self._headings:
            self._heading.setText(words)
            fits = bool(words) and self._heading.sizeHint().width() <= room
            self._heading.setVisible(fits)
            if fits:
                return

    def changeEvent(self, event: QEvent) -> None:
        if event.type() == QEvent.Type.PaletteChange:
            self._dress()
        super().changeEvent(event)

    def _dress(self) -> None:
        theme = current_theme()
        self._plot.setBackground(theme.plot_background)
        for name in ("left", "bottom"):
            axis = self._plot.getAxis(name)
            axis.setPen(theme.plot_grid)
            axis.setTextPen(theme.muted)
            axis.setGrid(70)
        self._plot.setLabel("left", self._unit, color=theme.muted)
        self._threshold.setPen(pg.mkPen(theme.error, width=1.5, style=Qt.PenStyle.DotLine))
        self._threshold.setHoverPen(pg.mkPen(theme.error, width=3.0))
        self._threshold.label.setColor(QColor(theme.error))
        self._threshold.label.fill = pg.mkBrush(theme.plot_background)
        self._playhead.setPen(pg.mkPen(theme.playhead, width=1.5))
        self._legend.refresh()
