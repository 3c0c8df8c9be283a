"""What all plots have in common: the theme's colours, bands, the legend of limbs and runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

import pyqtgraph as pg
from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QColor, QIcon, QPainter, QPen, QPixmap, QResizeEvent
from PySide6.QtWidgets import QApplication, QLabel, QSizePolicy, QToolButton, QWidget

from stereotrack_core.arrays import FloatArray, IntArray

from ..style.building import hbox, shortened
from ..style.colours import LineStyle, line_pixmap
from ..style.limb_colours import EXTRA_COLOURS, limb_words
from ..style.theme import current_theme

_GRID = 70
_SHADE = 45


def new_plot(parent: QWidget | None = None) -> pg.PlotWidget:
    """Make a plot without buttons and menu of its own."""
    plot = pg.PlotWidget(parent, enableMenu=False)
    for part in (plot, plot.viewport()):  # no key means anything to them
        part.setFocusPolicy(Qt.FocusPolicy.NoFocus)
    plot.hideButtons()
    plot.getPlotItem().layout.setContentsMargins(6.0, 3.0, 8.0, 0.0)
    return plot


def dress_plot(plot: pg.PlotWidget, *, grid: bool = True) -> None:
    """Give ground, axes and grid the colours of the theme that is shown."""
    theme = current_theme()
    plot.setBackground(theme.plot_background)
    for name in ("left", "bottom"):
        axis = plot.getAxis(name)
        axis.setPen(theme.plot_grid)
        axis.setTextPen(theme.muted)
        if grid:
            axis.setGrid(_GRID)


def label_axis(plot: pg.PlotWidget, side: str, words: str) -> None:
    """Say beside an axis what it counts."""
    plot.setLabel(side, escape(words), color=current_theme().muted)


def shade(colour: str | QColor, alpha: int = _SHADE) -> QColor:
    """Return a colour that what lies behind can be seen through, `alpha` from 0 to 255."""
    result = QColor(colour)
    result.setAlpha(alpha)
    return result


def band(
    x: FloatArray | IntArray, low: FloatArray, high: FloatArray, colour: str
) -> tuple[Any, ...]:
    """Items that shade the stretch between two curves; all have to be added to the plot."""
    sides = [pg.PlotCurveItem(x, y, pen=None) for y in (low, high)]
    return (*sides, pg.FillBetweenItem(*sides, brush=shade(colour)))


_SWATCH = QSize(14, 14)
_GAP = 2
_MOST_LETTERS = 24
_BESIDE = 40
"""Pixels that a switch has beside its words: colour, padding, distance."""


@dataclass(frozen=True, eq=False)
class Curve:
    """A measure of one limb, or of one side of the body, in one run or the reference."""

    name: str
    """The run, as the legend calls it."""
    limb: str
    """The legend's switches work by limb."""
    colour: str
    """#rrggbb, the limb's."""
    style: LineStyle
    """Tells runs apart."""
    frame: IntArray
    """(F,) int64. Ascending."""
    value: FloatArray
    """(F,) float64. NaN leaves a gap."""
    sigma: FloatArray | None = None
    """(F,) float64. Half the height of a band around the curve, NaN where there is none."""


class LimbLegend(QWidget):
    """A switch for each limb; Ctrl and click leaves that limb alone, or shows all again."""

    toggled = Signal()
    """Other limbs are to be shown."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._buttons: dict[str, QToolButton] = {}
        self._runs: tuple[tuple[str, LineStyle], ...] = ()
        self._labels: list[QLabel] = []
        self._row = hbox(None, margins=(4, 2, 8, 2), spacing=_GAP)
        self.setLayout(self._row)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)

    @property
    def hidden_limbs(self) -> frozenset[str]:
        """Limbs that are switched off."""
        return frozenset(limb for limb, b in self._buttons.items() if not b.isChecked())

    def button(self, limb: str) -> QToolButton:
        """Return a limb's switch."""
        return self._buttons[limb]

    def set_curves(self, curves: Sequence[Curve]) -> None:
        """Offer the limbs and runs of these curves; switches keep their place."""
        colours = {curve.limb: curve.colour for curve in curves}
        for limb in [limb for limb in self._buttons if limb not in colours]:
            button = self._buttons.pop(limb)
            self._drop(button)
        for limb, colour in colours.items():
            if limb not in self._buttons:
                self._add_button(limb, colour)
        self._fit_width()
        runs = tuple({(curve.name, curve.style): None for curve in curves})
        if runs != self._runs:
            self._runs = runs
            self._write_runs()

    def refresh(self) -> None:
        """Draw the runs' line styles in the colours of the theme that is shown now."""
        self._write_runs()

    def _drop(self, widget: QWidget) -> None:
        self._row.removeWidget(widget)
        widget.hide()
        widget.deleteLater()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit_width()

    @property
    def wanted_width(self) -> int:
        """Width in pixels at which every switch has its name beside it."""
        metrics = self.fontMetrics()
        limbs = sum(metrics.horizontalAdvance(limb_words(limb)) + _BESIDE for limb in self._buttons)
        return limbs + sum(label.sizeHint().width() + _GAP for label in self._labels) + 12

    def _fit_width(self) -> None:
        # where it gets narrow the names go, and the colours stay with their tooltips
        style = (
            Qt.ToolButtonStyle.ToolButtonTextBesideIcon
            if self.wanted_width <= self.width()
            else Qt.ToolButtonStyle.ToolButtonIconOnly
        )
        for button in self._buttons.values():
            button.setToolButtonStyle(style)

    def _add_button(self, limb: str, colour: str) -> None:
        button = QToolButton(self)
        button.setText(limb_words(limb))
        button.setIcon(_swatch(colour))
        button.setIconSize(_SWATCH)
        button.setCheckable(True)
        button.setChecked(limb not in EXTRA_COLOURS)
        button.setProperty("role", "legend")
        button.setToolTip(
            f"Show or hide the {limb_words(limb)}. Ctrl+click to show only this limb."
        )
        button.clicked.connect(lambda: self._on_clicked(limb))
        self._row.insertWidget(len(self._buttons), button)
        self._buttons[limb] = button

    def _on_clicked(self, limb: str) -> None:
        if QApplication.keyboardModifiers() & Qt.KeyboardModifier.ControlModifier:
            alone = all(other == limb or not b.isChecked() for other, b in self._buttons.items())
            for other, button in self._buttons.items():
                button.setChecked(alone or other == limb)
        self.toggled.emit()

    def _write_runs(self) -> None:
        for label in self._labels:
            self._drop(label)
        self._labels = []
        for name, style in self._runs:
            for label in (QLabel(self), QLabel(shortened(name, _MOST_LETTERS), self)):
                label.setToolTip(name)
                self._labels.append(label)
                self._row.addWidget(label)
            self._labels[-2].setPixmap(
                line_pixmap(style, QColor(current_theme().text), self.devicePixelRatioF())
            )
            self._labels[-1].setProperty("role", "muted")
        self._fit_width()


def _swatch(colour: str) -> QIcon:
    size = 28
    result = QIcon()
    for filled, state in ((True, QIcon.State.On), (False, QIcon.State.Off)):
        pixmap = QPixmap(size, size)
        pixmap.fill(Qt.GlobalColor.transparent)
        painter = QPainter(pixmap)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(QColor(colour), 3.0))
        if filled:
            painter.setBrush(QColor(colour))
        painter.drawRoundedRect(4, 4, size - 8, size - 8, 5, 5)
        painter.end()
        result.addPixmap(pixmap, QIcon.Mode.Normal, state)
    return result
