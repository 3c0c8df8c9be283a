"""A joint angle over frames, left and right, several runs over each other, with its uncertainty."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QEvent, QSize, Qt, Signal
from PySide6.QtGui import QColor, QKeyEvent
from PySide6.QtWidgets import (
    QComboBox,
    QHBoxLayout,
    QLabel,
    QVBoxLayout,
    QWidget,
)

from app.theme import current_theme
from app.views.elided_label import ElidedLabel
from app.views.line_styles import PEN_STYLES
from stereotrack_core.arrays import FloatArray, IntArray

REFERENCE_STYLE = "reference"
"""Line style that no run has."""

_SHADE = 50
_STYLES: dict[str, Qt.PenStyle] = dict(PEN_STYLES.items()) | {
    REFERENCE_STYLE: Qt.PenStyle.DashDotDotLine
}
_SIGNS = {"solid": "━━", "dash": "╌╌", "dot": "┈┈", "dashdot": "╌·╌", REFERENCE_STYLE: "╌··╌"}
_NOTHING = "Joint angles come here when the tracker has run, or where there is a reference."


@dataclass(frozen=True, eq=False)
class AngleCurve:
    """One angle, velocity or acceleration in one run or in the reference.

    Attributes
    ----------
    name : str
        The run, or the reference.
    label : str
        ``left`` or ``right``; empty for what has no side.
    colour : str
    style : str
        A run's, or :data:`REFERENCE_STYLE`.
    frame : (F,) int64
    value, sigma : (F,) float64
        In the plot's unit; NaN leaves a gap, or no band.
    """

    name: str
    label: str
    colour: str
    style: str
    frame: IntArray
    value: FloatArray
    sigma: FloatArray


class AnglePlot(QWidget):
    """Curves with bands of one standard deviation, and a playhead.

    Signals
    -------
    frame_requested : int
        The person clicked at this frame.
    chosen : ()
        Another angle or quantity shall be shown.
    visible_range_changed : float, float
        Borders of the frames that are seen, as in the timeline.
    """

    frame_requested = Signal(int)
    chosen = Signal()
    visible_range_changed = Signal(float, float)

    def __init__(
        self,
        angles: Sequence[tuple[str, str, str]],
        quantities: Sequence[tuple[str, str]],
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self._curves: tuple[AngleCurve, ...] = ()
        self._items: list[pg.GraphicsObject] = []
        self._frame, self._frame_count = 0, 0
        self._quiet = False
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAccessibleName("Plot of a joint angle over frames")
        self.angle = _choice("Joint angle", [(key, words) for key, words, _ in angles], self)
        for i, (_, _, tip) in enumerate(angles):
            self.angle.setItemData(i, tip, Qt.ItemDataRole.ToolTipRole)
        self.quantity = _choice("Angle, velocity or acceleration", quantities, self)
        for box in (self.angle, self.quantity):
            box.currentIndexChanged.connect(lambda _: self.chosen.emit())
        self.legend = QLabel(self)
        self.legend.setProperty("role", "muted")
        self.legend.setTextFormat(Qt.TextFormat.RichText)
        self.words = ElidedLabel(_NOTHING, self)
        self.plot = pg.PlotWidget(self)
        self.plot.setFocusProxy(self)
        self.plot.setMenuEnabled(False)
        self.plot.hideButtons()
        self.plot.setMinimumHeight(60)
        self._box = self.plot.getViewBox()
        self._box.setMouseEnabled(x=True, y=False)
        self._region = pg.LinearRegionItem(movable=False)
        self._region.setZValue(-10)
        self._region.hide()
        self.plot.addItem(self._region, ignoreBounds=True)
        self._playhead = pg.InfiniteLine(0.0, angle=90)
        self._playhead.setZValue(30)
        self.plot.addItem(self._playhead, ignoreBounds=True)
        self._lay_out()
        self._box.sigXRangeChanged.connect(self._on_range_changed)
        self.plot.scene().sigMouseClicked.connect(self._on_clicked)
        self._dress()

    def _lay_out(self) -> None:
        head = QHBoxLayout()
        head.setContentsMargins(8, 2, 8, 0)
        for widget in (self.angle, self.quantity, self.legend):
            head.addWidget(widget)
        head.addStretch(1)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addLayout(head)
        layout.addWidget(self.plot, 1)
        self.words.setContentsMargins(8, 0, 8, 2)
        layout.addWidget(self.words)

    def sizeHint(self) -> QSize:
        return QSize(700, 200)

    def minimumSizeHint(self) -> QSize:
        return QSize(200, 110)

    # ---- what is shown

    @property
    def angle_key(self) -> str:
        """Key of the angle that is chosen."""
        return str(self.angle.currentData())

    @property
    def quantity_key(self) -> str:
        """Key of the quantity that is chosen."""
        return str(self.quantity.currentData())

    @property
    def shown_curves(self) -> tuple[AngleCurve, ...]:
        """What is drawn."""
        return self._curves

    def show_curves(self, curves: Sequence[AngleCurve], unit: str, words: str) -> None:
        """Draw these curves; `words` say how they were made."""
        for item in self._items:
            self.plot.removeItem(item)
        self._curves, self._items = tuple(curves), []
        for curve in curves:
            self._add_band(curve)
        for curve in curves:
            self._add(curve)
        self.plot.setLabel("left", unit, color=current_theme().muted)
        self.words.set_words(words if curves else _NOTHING)
        self._write_legend()
        self._fit_values()

    def set_range(self, frame_count: int) -> None:
        """Let the axis be that of a recording of `frame_count` frames."""
        self._frame_count = frame_count
        last = float(max(frame_count, 1))
        self._quiet = True
        self._box.setLimits(xMin=-0.5, xMax=last - 0.5, minXRange=min(4.0, last))
        self._quiet = False
        self.set_visible_range(0.0, last)

    def set_selection(self, selection: range | None) -> None:
        """Shade the selected frames."""
        self._region.setVisible(bool(selection))
        if selection:
            self._region.setRegion((selection.start - 0.5, selection.stop - 0.5))

    def set_frame(self, frame: int) -> None:
        """Move the playhead."""
        self._frame = frame
        self._playhead.setValue(frame)

    def set_visible_range(self, first: float, last: float) -> None:
        """Zoom to the frames from `first` up to `last` without emitting a signal."""
        self._quiet = True
        self._box.setXRange(first - 0.5, last - 0.5, padding=0)
        self._quiet = False

    # ---- inside

    def _add(self, curve: AngleCurve) -> None:
        pen = pg.mkPen(curve.colour, width=1.4, style=_STYLES[curve.style])
        self._put(pg.PlotCurveItem(curve.frame, curve.value, pen=pen, connect="finite"))

    def _add_band(self, curve: AngleCurve) -> None:
        colour = QColor(curve.colour)
        colour.setAlpha(_SHADE)
        known = np.isfinite(curve.value) & np.isfinite(curve.sigma)
        ends = np.flatnonzero(np.diff(np.concatenate([[0], known.astype(np.int8), [0]])))
        # a band of its own for every stretch: gaps stay open
        for first, end in ends.reshape(-1, 2):
            own = slice(first, end)
            x, y, s = curve.frame[own], curve.value[own], curve.sigma[own]
            sides = [pg.PlotCurveItem(x, y + sign * s, pen=None) for sign in (-1.0, 1.0)]
            for item in (*sides, pg.FillBetweenItem(*sides, brush=colour)):
                self._put(item)

    def _put(self, item: pg.GraphicsObject) -> None:
        self.plot.addItem(item)
        self._items.append(item)

    def _write_legend(self) -> None:
        sides = {c.label: c.colour for c in self._curves if c.label}
        runs = {c.name: c.style for c in self._curves}
        parts = [f'<span style="color:{colour}">━━</span> {side}' for side, colour in sides.items()]
        parts += [f"{_SIGNS[style]} {name}" for name, style in runs.items()]
        self.legend.setText(" &nbsp; ".join(parts))

    def _fit_values(self) -> None:
        values = [c.value[np.isfinite(c.value)] for c in self._curves]
        known = np.concatenate([*values, np.empty(0)])
        if len(known):
            low, high = float(known.min()), float(known.max())
            self._box.setYRange(low, max(high, low + 1.0), padding=0.08)

    def _on_range_changed(self) -> None:
        if not self._quiet:
            first, last = self._box.viewRange()[0]
            self.visible_range_changed.emit(first + 0.5, last + 0.5)

    def _on_clicked(self, event: object) -> None:
        position = event.scenePos()  # type: ignore[attr-defined]
        left = event.button() == Qt.MouseButton.LeftButton  # type: ignore[attr-defined]
        if left and self._curves and self._box.sceneBoundingRect().contains(position):
            self._request(round(self._box.mapSceneToView(position).x()))

    def _request(self, frame: int) -> None:
        frame = min(max(frame, 0), max(self._frame_count - 1, 0))
        if frame != self._frame:
            self.set_frame(frame)
            self.frame_requested.emit(frame)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        ten = 10 if event.modifiers() & Qt.KeyboardModifier.ShiftModifier else 1
        if event.key() == Qt.Key.Key_Left:
            self._request(self._frame - ten)
        elif event.key() == Qt.Key.Key_Right:
            self._request(self._frame + ten)
        else:
            super().keyPressEvent(event)

    def changeEvent(self, event: QEvent) -> None:
        if event.type() == QEvent.Type.PaletteChange:
            self._dress()
        super().changeEvent(event)

    def _dress(self) -> None:
        theme = current_theme()
        self.plot.setBackground(theme.plot_background)
        for name in ("left", "bottom"):
            axis = self.plot.getAxis(name)
            axis.setPen(theme.plot_grid)
            axis.setTextPen(theme.muted)
            axis.setGrid(70)
        self._playhead.setPen(pg.mkPen(theme.playhead, width=1.5))
        shade = QColor(theme.accent)
        shade.setAlpha(_SHADE)
        self._region.setBrush(shade)
        for line in self._region.lines:
            line.setPen(pg.mkPen(theme.accent))


def _choice(name: str, options: Sequence[tuple[str, str]], parent: QWidget) -> QComboBox:
    box = QComboBox(parent)
    box.setAccessibleName(name)
    box.setToolTip(name)
    for key, words in options:
        box.addItem(words, key)
    return box
