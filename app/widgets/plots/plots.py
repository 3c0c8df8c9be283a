"""Base of all plots: colours of the theme, legend of limbs and runs."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from html import escape
from typing import Literal, TypeAlias

import pyqtgraph as pg
from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QColor, QIcon, QPainter, QPen, QResizeEvent
from PySide6.QtWidgets import QApplication, QLabel, QSizePolicy, QToolButton, QWidget

from stereotrack_core.arrays import FloatArray, IntArray

from ..style.building import shortened
from ..style.colours import (
    EXTRA_COLOURS,
    PEN_STYLES,
    LineStyle,
    brief_limb_words,
    limb_words,
    line_pixmap,
)
from ..style.theme import current_theme, drawn_pixmap

_SHADE = 45
_THICK, _FAINT = 2.5, 120


def new_plot(parent: QWidget | None = None) -> pg.PlotWidget:
    """Make a plot without buttons and menu of its own."""
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


_SWATCH = QSize(14, 14)
_GAP, _LEFT, _RIGHT, _ABOVE = 2, 4, 8, 2
_MOST_LETTERS = 24
_BESIDE = 40  # pixels that a switch has beside its words: colour, padding, distance


Emphasis: TypeAlias = Literal["usual", "front", "behind"]
"""Whether curves stand out before others, which then step back."""


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

    `toggled` is called when other limbs are to be shown.
    """

    def __init__(self, toggled: Callable[[], object]) -> None:
        super().__init__()
        self._toggled = toggled
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
        button = QToolButton(self)
        button.setAccessibleName(limb_words(limb))
        button.setIcon(_swatch(colour))
        button.setIconSize(_SWATCH)
        button.setCheckable(True)
        button.setChecked(limb not in EXTRA_COLOURS)
        button.setProperty("role", "legend")
        button.setToolTip(
            f"Show or hide the {limb_words(limb)}. Ctrl+click to show only this limb."
        )
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
