"""Errors of limbs over the frames, several runs over each other, linked to the timeline."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QEvent, QPointF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QKeyEvent, QResizeEvent

from stereotrack_core.arrays import FloatArray, IntArray

from ..redraw import takes_key
from ..style.building import hbox, label, show_text, vbox
from ..style.colours import EXTRA_COLOURS, limb_words
from ..style.theme import Dressed, current_theme
from .plots import Curve, LimbLegend, dress_plot, label_axis, new_plot, pen_of, shade

_HELP = (
    "Click to go to a frame, drag the threshold line, scroll to zoom, right-drag to scale. "
    "Keys: arrows step, 0 shows all frames."
)
_TITLE = "angular error"
_NAME = "Plot of the {} over frames"
_UNIT = "deg"
_HALF_STROKE = 0.4
_GRID = 70 / 255  # opacity
_BEHIND = 0.12  # opacity of curves behind those that the legend points at


class ErrorPlot(Dressed):
    """Curves per limb with a legend, a threshold that can be dragged, a playhead and a selection.

    `visit` is called with the frame that a person clicked at, `dragged` with the value that the
    line was dragged to, and `zoomed` with the borders of the visible frames, as in
    :meth:`set_visible_range`, when a person zoomed or moved.
    """

    hovered = Signal(object)  # the frame under the mouse, or None; answered by :meth:`set_hover`

    def __init__(
        self,
        visit: Callable[[int], object],
        dragged: Callable[[float], object],
        zoomed: Callable[[float, float], object],
    ) -> None:
        super().__init__()
        self._hovered_at: QPointF | None = None
        self._visit, self._dragged, self._zoomed = visit, dragged, zoomed
        self._frame = 0
        self._quiet = False
        self._curves: tuple[Curve, ...] = ()
        self._items: list[pg.PlotCurveItem] = []
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAccessibleName(_NAME.format(_TITLE))
        self.setAccessibleDescription(_HELP)
        self.setMinimumSize(200, 110)
        self._plot = new_plot(self)
        self._plot.setFocusProxy(self)
        self._plot.setMinimumHeight(80)
        self._box = self._plot.getViewBox()
        self._box.setMouseEnabled(x=True, y=False)
        self._playhead = pg.InfiniteLine(0.0, angle=90)
        self._playhead.setZValue(30)
        self._plot.addItem(self._playhead, ignoreBounds=True)
        self._selection = pg.LinearRegionItem(movable=False)
        self._hover, self._value = pg.InfiniteLine(0.0, angle=90), pg.TextItem()
        for place, item in enumerate((self._selection, self._hover, self._value)):
            item.setZValue(-10 + 25 * place)
            item.hide()
            self._plot.addItem(item, ignoreBounds=True)
        self._plot.scene().sigMouseMoved.connect(self._on_moved)
        self._box.sigXRangeChanged.connect(self._on_range_changed)
        self._box.sigResized.connect(self._thin)
        self._plot.scene().sigMouseClicked.connect(self._on_clicked)
        self.legend = LimbLegend(self._on_toggled, self._point_at)
        self._add_threshold()
        self._headings = _TITLE, ""
        self._heading = label(_TITLE, "heading", wraps=False)
        head = hbox(self._heading, (self.legend, 1), margins=(8, 0, 0, 0))
        self.setLayout(vbox(head, (self._plot, 1), spacing=0))
        self._dress()

    def sizeHint(self) -> QSize:
        return QSize(900, 200)

    @property
    def threshold(self) -> float:
        return float(self._threshold.value())

    def set_heading(self, words: str, brief: str = "", tip: str = "") -> None:
        """Say what is shown; `brief` is what stands there where `words` have no room."""
        if (words, brief, tip) != (*self._headings, self._heading.toolTip()):
            self._headings = words, brief
            self._heading.setToolTip(tip)
            self.setAccessibleName(_NAME.format(words.partition(",")[0]))
            self.setAccessibleDescription(f"{words}. {tip} {_HELP}")
            self._fit_heading()

    @property
    def shown_curves(self) -> tuple[Curve, ...]:
        hidden = self.legend.hidden_limbs
        return tuple(curve for curve in self._curves if curve.limb not in hidden)

    def set_curves(self, curves: Sequence[Curve]) -> None:
        """Show these curves; what a person has zoomed to is kept."""
        first, last = self._box.viewRange()[0]
        low, high = self._extent()
        was_whole = not self._curves or (first <= low + 0.5 and high - 0.5 <= last)
        before, self._curves = self._curves, tuple(curves)
        if [_look(curve) for curve in before] != [_look(curve) for curve in self._curves]:
            for old in self._items:
                self._plot.removeItem(old)
            self._items = [self._new_line(curve) for curve in self._curves]
        self.legend.set_curves(self._curves)
        self._limit()
        if was_whole and self._extent() != (low, high):
            self.show_everything()
        self._on_toggled()
        self._fit_heading()

    def set_frame(self, frame: int) -> None:
        self._frame = frame
        self._playhead.setValue(frame)

    def set_selection(self, frames: range | None) -> None:
        self._selection.setVisible(bool(frames))
        if frames:
            self._selection.setRegion((frames.start - 0.5, frames.stop - 0.5))

    def set_hover(self, frame: int | None) -> None:
        """Mark the frame under the mouse, here or in another panel."""
        self._hover.setVisible(frame is not None)
        self._hover.setValue(frame or 0)
        at = None if frame is None else self._hovered_at
        named = None if at is None else nearest_curve(self.shown_curves, frame or 0, at.y())
        self._value.setVisible(named is not None)
        if at is not None and named is not None:
            (first, last), (_, top) = self._box.viewRange()
            self._value.setText(f"{frame}: {self._words(*named)}", current_theme().text)
            self._value.setAnchor((float(at.x() > 0.5 * (first + last)), float(at.y() < 0.5 * top)))
            self._value.setPos(at)

    def _words(self, curve: Curve, value: float) -> str:
        """``right forearm 23.4°, accurate``, with the run if there are several."""
        unit = "" if curve.limb in EXTRA_COLOURS else "°"
        several = len({one.name for one in self._curves}) > 1
        return f"{limb_words(curve.limb)} {value:.1f}{unit}{f', {curve.name}' if several else ''}"

    def set_visible_range(self, first: float, last: float) -> None:
        """Zoom to the frames from `first` up to `last`, without telling of it.

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
        """Zoom so that all frames are seen, without telling of it."""
        self._limit()
        self.set_visible_range(*self._extent())
        self._fit_values()

    def set_threshold(self, value: float) -> None:
        """Move the threshold's line, without telling of it."""
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

    def _extent(self) -> tuple[float, float]:
        ends = [(c.frame[0], c.frame[-1] + 1) for c in self._curves if len(c.frame)]
        first, last = zip(*ends, strict=True) if ends else ((0,), (1,))
        return float(min(first)), float(max(last))

    def _add_threshold(self) -> None:
        self._threshold = pg.InfiniteLine(
            45.0, angle=0, movable=True, bounds=(0.0, 180.0), label="{value:.0f} " + _UNIT,
            labelOpts={"position": 0.985, "anchors": [(1, 0), (1, 1)]},
        )  # fmt: skip
        told = self._threshold.sigPositionChanged
        told.connect(lambda: self._quiet or self._dragged(self.threshold))
        self._threshold.setToolTip(
            "Threshold for going to the next or previous stretch. Drag to change."
        )
        self._threshold.setZValue(20)
        self._plot.addItem(self._threshold, ignoreBounds=True)

    def _fit_values(self) -> None:
        tops = [np.nanmax(c.value) for c in self.shown_curves if np.isfinite(c.value).any()]
        top = max([1.06 * float(value) for value in tops] + [1.15 * self.threshold, 1e-6])
        self._box.setYRange(0.0, top, padding=0)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit_heading()

    def _fit_heading(self) -> None:
        # the switches come first; where they leave no room the axis has to do
        room = self.width() - self.legend.wanted_width - 24
        for words in (*self._headings, ""):
            show_text(self._heading, words)
            if self._heading.sizeHint().width() <= room:
                return

    def _new_line(self, curve: Curve) -> pg.PlotCurveItem:
        pen, name = pen_of(curve.colour, curve.style, curve.emphasis), limb_words(curve.limb)
        item = pg.PlotCurveItem(pen=pen, connect="finite", name=f"{curve.name}, {name}")
        # the playhead moves over kept pictures of the curves
        item.setCacheMode(pg.PlotCurveItem.CacheMode.DeviceCoordinateCache)
        item.setZValue(1 if curve.emphasis == "front" else 0)
        self._plot.addItem(item)
        return item

    def _thin(self) -> None:
        first, last = self._box.viewRange()[0]
        columns = max(int(self._box.width()), 50)
        hidden = self.legend.hidden_limbs
        for curve, line in zip(self._curves, self._items, strict=True):
            line.setVisible(curve.limb not in hidden)
            if curve.limb not in hidden:
                line.setData(*thinned(curve.frame, curve.value, first, last, columns))

    def _on_toggled(self) -> None:
        self._fit_values()
        self._thin()

    def _limit(self) -> None:
        first, last = self._extent()
        self._quiet = True
        self._box.setLimits(xMin=first - 0.5, xMax=last - 0.5, minXRange=min(4.0, last - first))
        self._quiet = False

    def _dress(self) -> None:
        theme = current_theme()
        dress_plot(self._plot)
        self._plot.showGrid(x=True, y=True, alpha=_GRID)
        self._playhead.setPen(pg.mkPen(theme.playhead, width=1.5))
        self._hover.setPen(pg.mkPen(theme.muted, width=1.0))
        self._value.fill = pg.mkBrush(theme.plot_background)
        self._selection.setBrush(shade(theme.accent))
        for line in self._selection.lines:
            line.setPen(pg.mkPen(theme.accent, width=1.0))
        self.legend.write_runs()
        label_axis(self._plot, "left", _UNIT)
        self._threshold.setPen(pg.mkPen(theme.error, width=1.5, style=Qt.PenStyle.DotLine))
        self._threshold.setHoverPen(pg.mkPen(theme.error, width=3.0))
        self._threshold.label.setColor(QColor(theme.error))
        self._threshold.label.fill = pg.mkBrush(theme.plot_background)

    def _point_at(self, name: str) -> None:
        """Let other curves than those of a run or limb step back; an empty name: none."""
        for curve, item in zip(self._curves, self._items, strict=True):
            item.setOpacity(1.0 if name in ("", curve.name, curve.limb) else _BEHIND)

    def _on_moved(self, position: QPointF) -> None:
        first, last = self._extent()
        at = self._box.mapSceneToView(position)
        inside = bool(self._curves) and self._box.sceneBoundingRect().contains(position)
        self._hovered_at = at if inside and first <= round(at.x()) < last else None
        self.hovered.emit(None if self._hovered_at is None else round(at.x()))

    def leaveEvent(self, event: QEvent) -> None:
        self._hovered_at = None
        self.hovered.emit(None)
        super().leaveEvent(event)

    def _on_range_changed(self) -> None:
        self._thin()
        if not self._quiet:
            first, last = self._box.viewRange()[0]
            self._zoomed(first + 0.5, last + 0.5)

    def _on_clicked(self, event: Any) -> None:
        position, left = event.scenePos(), event.button() == Qt.MouseButton.LeftButton
        if left and self._curves and self._box.sceneBoundingRect().contains(position):
            first, last = self._extent()
            frame = round(self._box.mapSceneToView(position).x())
            self._visit(int(min(max(frame, first), last - 1)))

    def event(self, event: QEvent) -> bool:
        # as in the timeline, what shows a whole image shows all frames here
        return takes_key(event, _shows_all) or super().event(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if _shows_all(event):
            self.show_everything()
            self._zoomed(*self._extent())
        else:
            super().keyPressEvent(event)


def _shows_all(event: QKeyEvent) -> bool:
    modifiers = event.modifiers() & ~Qt.KeyboardModifier.KeypadModifier
    return event.key() == Qt.Key.Key_0 and modifiers == Qt.KeyboardModifier.NoModifier


def _look(curve: Curve) -> tuple[object, ...]:
    """Key of a curve's plot items: a curve with the same key is drawn by the same line."""
    return curve.name, curve.limb, curve.colour, curve.style, curve.emphasis


def nearest_curve(curves: Sequence[Curve], frame: int, value: float) -> tuple[Curve, float] | None:
    """The curve that is nearest to a value in a frame, and its value there; None without one."""
    found = ((one, one.value[one.frame == frame]) for one in curves)
    known = [(one, float(there[0])) for one, there in found if np.isfinite(there).any()]
    return min(known, key=lambda pair: abs(pair[1] - value), default=None)


def thinned(
    frame: IntArray, value: FloatArray, first: float, last: float, columns: int
) -> tuple[FloatArray, FloatArray]:
    """Points to draw for the frames from `first` to `last` on `columns` columns of pixels.

    Each column keeps its smallest and largest value, so that no peak is lost; a column in which
    nothing is known keeps a NaN, which interrupts the line.
    Returns x and y (K,); K is at most about twice the number of columns, or that of the frames.
    """
    start = max(int(np.searchsorted(frame, first)) - 1, 0)
    stop = min(int(np.searchsorted(frame, last, side="right")) + 1, len(frame))
    x = frame[start:stop].astype(np.float64)
    y = np.asarray(value[start:stop], dtype=np.float64)
    size = len(x) // max(columns, 1)
    if size < 4:
        return _seen_alone(x, y)
    starts = np.arange(0, len(x), size)
    low = np.fmin.reduceat(y, starts)
    high = np.fmax.reduceat(y, starts)
    return np.repeat(x[starts], 2), np.stack([low, high], axis=1).ravel()


def _seen_alone(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Make a short stroke of each value without neighbours, of which a line shows nothing."""
    known = np.isfinite(y)
    before, after = np.append(False, known[:-1]), np.append(known[1:], False)
    alone = known & ~before & ~after
    times = 1 + alone
    last = np.cumsum(times)[alone] - 1
    x, y = np.repeat(x, times), np.repeat(y, times)
    x[last] += _HALF_STROKE
    x[last - 1] -= _HALF_STROKE
    return x, y


def next_crossing(
    curves: Sequence[Curve], threshold: float, frame: int, direction: int
) -> int | None:
    """First frame of the next (1) or previous (-1) stretch with any curve above the threshold."""
    above: set[int] = set()
    for curve in curves:
        with np.errstate(invalid="ignore"):
            above.update(curve.frame[curve.value > threshold].tolist())
    begins = sorted(first for first in above if first - 1 not in above)
    if direction > 0:
        return next((one for one in begins if one > frame), None)
    return next((one for one in reversed(begins) if one < frame), None)
