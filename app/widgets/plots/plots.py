"""Base of all plots, legend of limbs and runs, and the plot of a study."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from html import escape
from typing import Any

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QEvent, QObject, QSize, Qt
from PySide6.QtGui import QColor, QIcon, QPainter, QPen, QResizeEvent
from PySide6.QtWidgets import QApplication, QLabel, QSizePolicy, QToolButton, QWidget

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.study.store import Curve as StudyCurve
from stereotrack_core.study.store import PlotAxis, words_of

from ..style.building import named, shortened, vbox
from ..style.colours import (
    EXTRA_COLOURS,
    PEN_STYLES,
    Emphasis,
    LineStyle,
    brief_limb_words,
    limb_words,
    line_pixmap,
)
from ..style.theme import Dressed, current_theme, drawn_pixmap

_SHADE = 45
_THICK, _FAINT = 2.5, 120


def new_plot(parent: QWidget | None = None) -> pg.PlotWidget:
    """Make a plot without buttons and menu of its own."""
    theme = current_theme()
    pg.setConfigOptions(background=theme.plot_background, foreground=theme.muted, antialias=True)
    plot = pg.PlotWidget(parent, enableMenu=False)
    for part in (plot, plot.viewport()):  # no key means anything to them
        part.setFocusPolicy(Qt.FocusPolicy.NoFocus)
    plot.hideButtons()
    plot.getPlotItem().layout.setContentsMargins(6.0, 3.0, 8.0, 0.0)
    return plot


def dress_plot(plot: pg.PlotWidget) -> None:
    """Give ground and axes the colours of the theme that is shown."""
    theme = current_theme()
    plot.setBackground(theme.plot_background)
    for name in ("left", "bottom"):
        plot.getAxis(name).setPen(theme.plot_grid)
        plot.getAxis(name).setTextPen(theme.muted)


def label_axis(plot: pg.PlotWidget, side: str, words: str) -> None:
    """Say beside an axis what it counts."""
    plot.setLabel(side, escape(words), color=current_theme().muted)


def shade(colour: str | QColor, alpha: int = _SHADE) -> QColor:
    """Return a colour that what lies behind can be seen through, `alpha` from 0 to 255."""
    result = QColor(colour)
    result.setAlpha(alpha)
    return result


_GAP, _LEFT, _RIGHT, _ABOVE = 2, 4, 8, 2
_MOST_LETTERS = 24
_BESIDE = 40  # pixels that a switch has beside its words: colour, padding, distance


def pen_of(colour: str, style: LineStyle, emphasis: Emphasis) -> QPen:
    """Pen of a run's curves: thick and unbroken in front of others, faint behind."""
    front = emphasis == "front"
    pen: QPen = pg.mkPen(
        shade(colour, _FAINT if emphasis == "behind" else 255),
        width=_THICK if front else 1,  # wider lines take Qt ten times as long
        style=PEN_STYLES["solid" if front else style],
    )
    return pen


@dataclass(frozen=True, eq=False)
class Curve:
    """A measure of one limb, or of one side of the body, in one run or the reference."""

    name: str
    limb: str
    colour: str  # #rrggbb, the limb's
    style: LineStyle
    frame: IntArray  # (F,) int64. Ascending.
    value: FloatArray  # (F,) float64. NaN leaves a gap.
    emphasis: Emphasis = "usual"


class LimbLegend(QWidget):
    """A switch for each limb; Ctrl and click leaves that limb alone, or shows all again.

    `toggled` is called when other limbs are to be shown, `point_at` with the name of the limb or
    run under the mouse, empty for none.
    """

    def __init__(self, toggled: Callable[[], object], point_at: Callable[[str], object]) -> None:
        super().__init__()
        self._toggled, self._point_at = toggled, point_at
        self.buttons: dict[str, QToolButton] = {}
        self._runs: tuple[tuple[str, LineStyle, Emphasis], ...] = ()
        self._labels: list[tuple[QLabel, QLabel]] = []
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)

    @property
    def hidden_limbs(self) -> frozenset[str]:
        return frozenset(limb for limb, b in self.buttons.items() if not b.isChecked())

    def set_curves(self, curves: Sequence[Curve]) -> None:
        """Offer the limbs and runs of these curves; switches keep their place."""
        colours = {curve.limb: curve.colour for curve in curves}
        for limb in self.buttons.keys() - colours:
            _drop(self.buttons.pop(limb))
        for limb, colour in colours.items():
            if limb not in self.buttons:
                self._add_button(limb, colour)
        self._arrange()
        runs = tuple({(curve.name, curve.style, curve.emphasis): None for curve in curves})
        if runs != self._runs:
            self._runs = runs
            self.write_runs()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._arrange()

    def eventFilter(self, part: QObject, event: QEvent) -> bool:
        if event.type() in (QEvent.Type.Enter, QEvent.Type.Leave):
            self._point_at(part.objectName() if event.type() == QEvent.Type.Enter else "")
        return False

    def _name(self, part: QWidget, name: str) -> None:
        """Say which curves a part of the legend points at while the mouse is over it."""
        part.setObjectName(name)
        part.installEventFilter(self)

    @property
    def wanted_width(self) -> int:
        """Width in pixels at which every switch has its whole name beside it, in one row."""
        advance = self.fontMetrics().horizontalAdvance
        switches = sum(advance(limb_words(limb)) + _BESIDE for limb in self.buttons)
        return switches + self._runs_width() + _LEFT + _RIGHT

    def _runs_width(self) -> int:
        return sum(part.sizeHint().width() + _GAP for run in self._labels for part in run)

    def _arrange(self) -> None:
        """Put the switches and runs in a row; where it gets narrow, short names in several."""
        words = limb_words if self.wanted_width <= self.width() else brief_limb_words
        for limb, button in self.buttons.items():
            button.setText(words(limb))
        groups: list[tuple[QWidget, ...]] = [(one,) for one in self.buttons.values()]
        groups += self._labels
        height = max((part.sizeHint().height() for group in groups for part in group), default=0)
        right = self.width() - _RIGHT
        x, y = _LEFT, _ABOVE
        for place, group in enumerate(groups):
            widths = [part.sizeHint().width() for part in group]
            if place == len(self.buttons):  # the runs stand at the end of their row
                x = max(x, right - self._runs_width())
            if x > _LEFT and x + sum(widths) + _GAP * len(widths) > right:
                x, y = _LEFT, y + height
            for part, width in zip(group, widths, strict=True):
                part.setGeometry(x, y, min(width, max(right - x, 0)), height)
                part.show()
                x += width + _GAP
        self.setFixedHeight(y + height + _ABOVE)

    def _add_button(self, limb: str, colour: str) -> None:
        words = limb_words(limb)
        tip = f"Show or hide the {words}. Ctrl+click to show only this limb."
        button = named(QToolButton(self), words, tip)
        self._name(button, limb)
        button.setIcon(_swatch(colour))
        button.setIconSize(QSize(14, 14))
        button.setCheckable(True)
        button.setChecked(limb not in EXTRA_COLOURS)
        button.setProperty("role", "legend")
        button.clicked.connect(lambda: self._on_clicked(limb))
        button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.buttons[limb] = button

    def _on_clicked(self, limb: str) -> None:
        if QApplication.keyboardModifiers() & Qt.KeyboardModifier.ControlModifier:
            alone = all(other == limb or not b.isChecked() for other, b in self.buttons.items())
            for other, button in self.buttons.items():
                button.setChecked(alone or other == limb)
        self._toggled()

    def write_runs(self) -> None:
        """Name the runs beside their line styles, in the colours of the theme that is shown."""
        for part in (part for run in self._labels for part in run):
            _drop(part)
        self._labels = []
        for name, style, emphasis in self._runs:
            line, words = QLabel(self), QLabel(shortened(name, _MOST_LETTERS), self)
            pen = pen_of(current_theme().text, style, emphasis)
            line.setPixmap(line_pixmap(pen, self.devicePixelRatioF()))
            words.setProperty("role", "muted")
            for part in (line, words):
                part.setToolTip(name)
                self._name(part, name)
            self._labels.append((line, words))
        self._arrange()


def _drop(widget: QWidget) -> None:
    widget.hide()
    widget.deleteLater()


def _swatch(colour: str) -> QIcon:
    def draw(painter: QPainter, *, filled: bool) -> None:
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(QColor(colour), 3.0))
        if filled:
            painter.setBrush(QColor(colour))
        painter.drawRoundedRect(4, 4, 20, 20, 5, 5)

    result = QIcon()
    for filled, state in ((True, QIcon.State.On), (False, QIcon.State.Off)):
        pixmap = drawn_pixmap(28, 28, partial(draw, filled=filled))
        result.addPixmap(pixmap, QIcon.Mode.Normal, state)
    return result


_MOST_TICKS = 12
_LONGEST_TICK = 18
_ASIDE = 0.06  # share of the distance between values that one curve is drawn aside of the next
_SHADES = {True: (0.42, 0.95), False: (0.05, 0.75)}
"""Part of the colour map that can be seen on a dark and on a bright ground."""


class StudyPlot(Dressed):
    """Draws curves with their points and spread.

    `choose` is called with a tuple of the rows of the table behind what was clicked.
    """

    def __init__(self, choose: Callable[[tuple[int, ...]], object]) -> None:
        super().__init__()
        self._choose = choose
        self._shown: tuple[PlotAxis, str, tuple[StudyCurve, ...]] | None = None
        self._lines = "", float("nan")
        self._plot = new_plot()
        self._legend = self._plot.addLegend(offset=(-10, 10))
        self._marks: list[pg.ScatterPlotItem] = []
        self._plot.getAxis("bottom").enableAutoSIPrefix(False)
        self._plot.getPlotItem().layout.setContentsMargins(6.0, 3.0, 8.0, 6.0)
        self._plot.scene().sigMouseClicked.connect(self._on_clicked)
        self.setLayout(vbox(self._plot))
        self.setAccessibleName("Plot of a study")
        self.setMinimumSize(220, 110)

    def sizeHint(self) -> QSize:
        return QSize(720, 440)

    def show_curves(
        self,
        axis: PlotAxis,
        measure: str,
        curves: Sequence[StudyCurve],
        present: str = "",
        baseline: float = float("nan"),
    ) -> None:
        """Show curves, with lines at the `present` value of the axis and at the active run's."""
        self._shown = axis, measure, tuple(curves)
        self._lines = present, baseline
        self._dress()

    def clear(self) -> None:
        self._shown = None
        self._dress()

    def _dress(self) -> None:
        dress_plot(self._plot)
        self._plot.clear()
        self._legend.clear()
        self._marks.clear()
        self._legend.setVisible(False)
        if self._shown is None:
            return
        axis, measure, curves = self._shown
        label_axis(self._plot, "bottom", words_of(axis.name))
        label_axis(self._plot, "left", words_of(measure))
        self._plot.showGrid(y=True, alpha=0.25)
        asides = _asides(axis, len(curves))
        for curve, colour, aside in zip(curves, _shades(len(curves)), asides, strict=True):
            self._draw_curve(axis, curve, colour, aside)
        present, baseline = self._lines
        self._draw_line(place_on(axis, present), 90, f"now {_short(present)}")
        self._draw_line(baseline, 0, f"active run {baseline:.1f}")
        self._legend.setVisible(len(curves) > 1)
        self._legend.setLabelTextColor(current_theme().text)
        ticks = _ticks(axis)
        self._plot.getAxis("bottom").setLogMode(axis.log and ticks is None, False)
        self._plot.getAxis("bottom").setTicks(ticks)
        self._plot.autoRange(padding=0.06)

    def _draw_line(self, place: float | None, angle: int, words: str) -> None:
        """A dashed line across the plot at a place, unless that is unknown."""
        if place is not None and np.isfinite(place):
            colour = current_theme().text
            style = {"color": colour, "position": 0.94 if angle else 0.06, "movable": False}
            pen = pg.mkPen(colour, width=1.2, style=Qt.PenStyle.DashLine)
            line = pg.InfiniteLine(place, angle=angle, pen=pen, label=words, labelOpts=style)
            line.label.fill = pg.mkBrush(current_theme().plot_background)
            self._plot.addItem(line)

    def _draw_curve(self, axis: PlotAxis, curve: StudyCurve, colour: QColor, aside: float) -> None:
        at = np.array([_place(axis, place) + aside for place in curve.at])
        half = np.nan_to_num(curve.spread)
        wide = float(np.ptp([_place(axis, place) for place in axis.places.values()])) or 1.0
        bars = pg.ErrorBarItem(
            x=at, y=curve.mean, top=half, bottom=half, pen=pg.mkPen(colour, width=1.2),
            beam=0.012 * wide,
        )  # fmt: skip
        points = pg.ScatterPlotItem(
            x=[_place(axis, place) + aside for place in curve.x], y=curve.y,
            data=curve.row.tolist(), size=7, pen=None, brush=shade(colour, 115), hoverable=True,
            tip=None,
        )  # fmt: skip
        line = pg.PlotDataItem(at, curve.mean, pen=pg.mkPen(colour, width=2))
        means = pg.ScatterPlotItem(
            x=at, y=curve.mean, data=[curve.row[curve.x == place].tolist() for place in curve.at],
            size=10, brush=colour, pen=current_theme().plot_background,
        )  # fmt: skip
        # a search tries other values each time: no line leads from one to the next
        joined = axis.words or len(curve.at) <= 2 * _MOST_TICKS
        for item in (bars, points, *([line] if joined else []), means):
            self._plot.addItem(item)
        if curve.label:
            self._legend.addItem(line, escape(_short(curve.label, 2 * _LONGEST_TICK)))
        self._marks += [means, points]

    def _on_clicked(self, event: Any) -> None:
        if event.button() == Qt.MouseButton.LeftButton:
            at = (marks.pointsAt(marks.mapFromScene(event.scenePos())) for marks in self._marks)
            if found := next((points[0] for points in at if len(points)), None):
                rows = found.data()
                self._choose(tuple(rows) if isinstance(rows, list) else (int(rows),))


def _place(axis: PlotAxis, value: float) -> float:
    return float(np.log10(value)) if axis.log else float(value)


def place_on(axis: PlotAxis, value: str) -> float | None:
    """Where a value that need not be one of the axis's stands; None if nowhere."""
    if axis.words:
        return axis.places.get(value)
    try:
        number = float(value)
    except ValueError:
        return None
    return _place(axis, number) if number > 0.0 or not axis.log else None


def _asides(axis: PlotAxis, count: int) -> list[float]:
    """Sideways offset of each curve, so that points of several do not hide each other."""
    places = sorted(_place(axis, value) for value in axis.places.values())
    gap = min(np.diff(places), default=1.0)
    step = min(_ASIDE * gap, 0.3 * gap / max(1, count))
    return [step * (i - (count - 1) / 2.0) for i in range(count)]


def _ticks(axis: PlotAxis) -> list[list[tuple[float, str]]] | None:
    """A tick at each value if they are few or words; else None, for the plot's own."""
    ticks = [(_place(axis, place), _short(value)) for value, place in axis.places.items()]
    few = axis.words or len(ticks) <= 2 * _MOST_TICKS
    return [ticks[:: max(1, len(ticks) // _MOST_TICKS)]] if few else None


def _short(value: str, longest: int = _LONGEST_TICK) -> str:
    return shortened(value, longest) or "–"


def _shades(count: int) -> list[QColor]:
    """Colours of curves, in the order of the values; no limb has them."""
    low, high = _SHADES[current_theme().is_dark]
    places = np.linspace(low, high, count) if count > 1 else [0.5 * (low + high)]
    colours = pg.colormap.get("viridis")
    return [colours.map(place, mode="qcolor") for place in places]
