"""Errors against something else, point by point, or how often each error occurs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QSize, Signal
from PySide6.QtGui import QColor, QPen, QResizeEvent
from PySide6.QtWidgets import QBoxLayout, QWidget

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray

from ..style.building import ElidedLabel, choice, hbox, vbox
from ..style.colours import PEN_STYLES, LineStyle
from ..style.limb_colours import limb_words
from ..style.theme import Dressed, current_theme
from .histograms import Histograms, Steps
from .plots import Curve, LimbLegend, band, dress_plot, new_plot, shade

_OTHERS: tuple[LineStyle, ...] = ("dash", "dot", "dashdot")
_SYMBOLS = ("o", "x", "t", "s", "d")
_FADED = 45
_LEGEND_WIDTH = 400
"""Pixels that the legend has to have beside the choice; with less it stands below."""
_NOTHING = "Run the tracker to see what the errors depend on."


@dataclass(frozen=True, eq=False)
class PointCloud:
    """Points of one limb in one run, and the curve through them."""

    name: str
    """The run."""
    place: int
    """0 for the active run; others have other symbols and line styles."""
    limb: str
    colour: str
    frame: IntArray
    """(N,) int64."""
    x: FloatArray
    y: FloatArray
    """`x` and `y`: (N,) float64. NaN is not drawn."""
    chosen: BoolArray
    """(N,) bool. Points of the selected stretch; all where nothing is selected."""
    curve_x: FloatArray
    curve: FloatArray
    low: FloatArray
    high: FloatArray
    """`curve_x`, `curve`, `low` and `high`: (K,) float64. Running median and quartiles."""


@dataclass(frozen=True, eq=False)
class CloudContent:
    """All that is drawn at once."""

    words: str
    """What is seen, in sentences."""
    counts: bool = False
    """Whether x is counted in whole numbers."""
    clouds: tuple[PointCloud, ...] = ()
    steps: tuple[Steps, ...] = ()


class CloudPlot(Dressed):
    """A plot with a choice of what it shows; a click on a point goes to its frame."""

    frame_requested = Signal(int)
    kind_chosen = Signal(str)
    """The key of what shall be shown."""

    def __init__(self, kinds: Sequence[tuple[str, str]], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._content: CloudContent | None = None
        self._items: list[tuple[str, pg.GraphicsObject]] = []
        self.kind = choice("Plot type", kinds)
        self.kind.currentIndexChanged.connect(lambda _: self.kind_chosen.emit(self.kind_key))
        self.legend = LimbLegend(self)
        self.legend.toggled.connect(self._show_limbs)
        self.plot = new_plot(self)
        self.setMinimumSize(200, 150)
        self.plot.setAccessibleName("Errors against possible causes")
        self.plot.scene().sigMouseClicked.connect(self._on_plot_clicked)
        self.words = ElidedLabel(_NOTHING, self)
        self.words.setContentsMargins(8, 0, 8, 2)
        self._head = hbox(self.kind, (self.legend, 1), margins=(4, 2, 0, 0), spacing=2)
        self.histograms = Histograms()
        self.histograms.hide()
        both = ((self.plot, 1), (self.histograms, 1))
        self.setLayout(vbox(self._head, *both, self.words, spacing=0))
        self._dress()

    def sizeHint(self) -> QSize:
        return QSize(420, 300)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        beside = self.width() - self.kind.sizeHint().width() >= _LEGEND_WIDTH
        way = QBoxLayout.Direction.LeftToRight if beside else QBoxLayout.Direction.TopToBottom
        self._head.setDirection(way)

    @property
    def kind_key(self) -> str:
        """Key of what is chosen."""
        return str(self.kind.currentData())

    def show_content(self, content: CloudContent | None) -> None:
        """Draw this, or nothing."""
        self._content = content
        for _, item in self._items:
            self.plot.removeItem(item)
        self._items = []
        if content is not None:
            self._add(content)
        drawn: list[PointCloud | Steps] = []
        if content is not None:
            drawn = [*content.clouds, *content.steps]
        none = np.empty(0, np.int64), np.empty(0)
        self.legend.set_curves(
            [Curve(one.name, one.limb, one.colour, style_at(one.place), *none) for one in drawn]
        )
        self.words.set_words(_NOTHING if content is None else content.words)
        self._write_ticks()
        self._show_limbs()

    def _add(self, content: CloudContent) -> None:
        for cloud in content.clouds:
            self._add_points(cloud)
        for cloud in content.clouds:
            self._add_curve(cloud)

    def _add_points(self, cloud: PointCloud) -> None:
        known = np.isfinite(cloud.x) & np.isfinite(cloud.y)
        some = not bool(cloud.chosen.all())
        for chosen in (False, True):
            own = known & (cloud.chosen == chosen)
            if not own.any():
                continue
            colour = shade(cloud.colour, (210 if some else 130) if chosen else _FADED)
            item = pg.ScatterPlotItem(
                x=cloud.x[own], y=cloud.y[own], data=cloud.frame[own],
                size=6 if chosen and some else 4, symbol=_SYMBOLS[cloud.place % len(_SYMBOLS)],
                brush=colour, pen=None if cloud.place == 0 else pg.mkPen(colour), hoverable=True,
                hoverSize=9, tip=_tip(cloud),
            )  # fmt: skip
            item.sigClicked.connect(self._on_clicked)
            self._put(cloud.limb, item)

    def _add_curve(self, cloud: PointCloud) -> None:
        if len(cloud.curve_x) == 0:
            return
        if len(cloud.curve_x) > 1 and cloud.place == 0:
            for item in band(cloud.curve_x, cloud.low, cloud.high, cloud.colour):
                self._put(cloud.limb, item)
        under = pg.mkPen(current_theme().plot_background, width=5)
        for pen in (under, _pen(cloud.colour, cloud.place, 2.5)):
            self._put(cloud.limb, pg.PlotCurveItem(cloud.curve_x, cloud.curve, pen=pen))
        if len(cloud.curve_x) <= 6:  # places one by one
            marks = pg.ScatterPlotItem(
                x=cloud.curve_x, y=cloud.curve, size=10, symbol="s", brush=QColor(cloud.colour),
                pen=pg.mkPen(current_theme().plot_background, width=1.5),
            )  # fmt: skip
            self._put(cloud.limb, marks)

    def _put(self, limb: str, item: pg.GraphicsObject) -> None:
        self.plot.addItem(item)
        self._items.append((limb, item))

    def _show_limbs(self) -> None:
        hidden = self.legend.hidden_limbs
        for limb, item in self._items:
            item.setVisible(limb not in hidden)
        steps = self._content.steps if self._content is not None else ()
        self.plot.setVisible(not steps)
        self.histograms.setVisible(bool(steps))
        self.histograms.show_steps(steps, hidden)
        self._fit()

    def show_everything(self) -> None:
        """Zoom out so far that all values are seen."""
        self._fit(everything=True)

    def _fit(self, *, everything: bool = False) -> None:
        """Hold what most points and all curves of the limbs that are seen need; y from zero."""
        if self._content is None:
            return
        hidden = self.legend.hidden_limbs
        box = self.plot.getViewBox()
        clouds = [cloud for cloud in self._content.clouds if cloud.limb not in hidden]
        points = _known([cloud.y for cloud in clouds])
        usual = points if everything else _most(_known([c.y for c in clouds if c.place == 0]))
        curves = _known([v for c in clouds for v in (c.curve, c.high)])
        x = _known([cloud.x for cloud in clouds])
        y = np.concatenate([usual, curves])
        if len(x) and len(y):
            left, right = float(x.min()), float(x.max())
            box.setXRange(left, max(right, left + 1e-3), padding=0.04)
            box.setYRange(0.0, max(1.05 * float(y.max()), 1e-3), padding=0)

    def _on_clicked(self, _item: object, points: Sequence[Any], _event: object = None) -> None:
        if len(points):
            self.frame_requested.emit(int(points[0].data()))

    def _on_plot_clicked(self, event: Any) -> None:
        if event.double():
            self.show_everything()

    def _write_ticks(self) -> None:
        counts = self._content is not None and self._content.counts
        ticks = [[(float(n), str(n)) for n in range(32)], []] if counts else None
        self.plot.getAxis("bottom").setTicks(ticks)

    def _dress(self) -> None:
        dress_plot(self.plot)
        self.legend.refresh()
        self.show_content(self._content)


def style_at(place: int) -> LineStyle:
    """Line style of a run, the same as in the plot of errors."""
    return "solid" if place == 0 else _OTHERS[(place - 1) % len(_OTHERS)]


def _pen(colour: str, place: int, width: float) -> QPen:
    pen: QPen = pg.mkPen(colour, width=width, style=PEN_STYLES[style_at(place)])
    return pen


def _known(values: Sequence[FloatArray]) -> FloatArray:
    joined = np.concatenate([*values, np.empty(0)])
    result: FloatArray = joined[np.isfinite(joined)]
    return result


def _most(values: FloatArray) -> FloatArray:
    """Values without the wildest two in a hundred."""
    if not len(values):
        return values
    result: FloatArray = values[values <= np.percentile(values, 98)]
    return result


def _tip(cloud: PointCloud) -> Any:
    def words(x: float, y: float, data: int) -> str:
        return f"frame {data}, {limb_words(cloud.limb)}, {cloud.name}: {y:.1f}° at {x:.2f}"

    return words
