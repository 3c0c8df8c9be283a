"""A plot over the frames of a recording, with a playhead, linked to the timeline."""

from __future__ import annotations

import pyqtgraph as pg
from PySide6.QtCore import QEvent, QSize, Qt, Signal
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QWidget

from ..style.theme import current_theme
from .plots import dress_plot, new_plot

FRAME_KEYS = "Keys: arrows step, A shows all frames."
"""What the keys of a plot over frames do."""


class FramePlot(QWidget):
    """What plots over frames have in common; what is drawn is up to those who derive from it."""

    frame_requested = Signal(int)
    """The person clicked at this frame."""
    visible_range_changed = Signal(float, float)
    """The person zoomed or moved; borders of the visible frames as in :meth:`set_visible_range`."""

    def __init__(self, name: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._frame = 0
        self._frame_count = 0
        self._quiet = False
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAccessibleName(name)
        self._plot = new_plot(self)
        self._plot.setFocusProxy(self)
        self._plot.setMinimumHeight(80)
        self._box = self._plot.getViewBox()
        self._box.setMouseEnabled(x=True, y=False)
        self._playhead = pg.InfiniteLine(0.0, angle=90)
        self._playhead.setZValue(30)
        self._plot.addItem(self._playhead, ignoreBounds=True)
        self._box.sigXRangeChanged.connect(self._on_range_changed)
        self._plot.scene().sigMouseClicked.connect(self._on_clicked)

    def sizeHint(self) -> QSize:
        return QSize(900, 200)

    def minimumSizeHint(self) -> QSize:
        return QSize(200, 110)

    # ---- what is shown

    def set_range(self, frame_count: int) -> None:
        """Let the axis be that of a recording of `frame_count` frames."""
        self._frame_count = frame_count
        self.show_everything()

    def set_frame(self, frame: int) -> None:
        """Move the playhead."""
        self._frame = frame
        self._playhead.setValue(frame)

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

    # ---- for those who derive from it

    def _is_empty(self) -> bool:
        """Whether nothing is drawn, so that a click means nothing."""
        return False

    def _extent(self) -> tuple[float, float]:
        """Borders of all frames."""
        return 0.0, float(max(self._frame_count, 1))

    def _fit_values(self) -> None:
        """Let the curves be seen in their whole height."""

    def _limit(self) -> None:
        first, last = self._extent()
        self._quiet = True
        self._box.setLimits(xMin=first - 0.5, xMax=last - 0.5, minXRange=min(4.0, last - first))
        self._quiet = False

    def _dress(self) -> None:
        dress_plot(self._plot)
        self._playhead.setPen(pg.mkPen(current_theme().playhead, width=1.5))

    # ---- what a person does

    def _on_range_changed(self) -> None:
        if not self._quiet:
            first, last = self._box.viewRange()[0]
            self.visible_range_changed.emit(first + 0.5, last + 0.5)

    def _on_clicked(self, event: object) -> None:
        position = event.scenePos()  # type: ignore[attr-defined]
        left = event.button() == Qt.MouseButton.LeftButton  # type: ignore[attr-defined]
        if left and not self._is_empty() and self._box.sceneBoundingRect().contains(position):
            self._request(round(self._box.mapSceneToView(position).x()))

    def _request(self, frame: int) -> None:
        first, last = self._extent()
        frame = int(min(max(frame, first), last - 1))
        if frame != self._frame:
            self.set_frame(frame)
            self.frame_requested.emit(frame)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        step = 10 if event.modifiers() & Qt.KeyboardModifier.ShiftModifier else 1
        if event.key() == Qt.Key.Key_Left:
            self._request(self._frame - step)
        elif event.key() == Qt.Key.Key_Right:
            self._request(self._frame + step)
        elif event.key() == Qt.Key.Key_A and not event.modifiers():
            self.show_everything()
            self.visible_range_changed.emit(*self._extent())
        else:
            super().keyPressEvent(event)

    def changeEvent(self, event: QEvent) -> None:
        if event.type() == QEvent.Type.PaletteChange:
            self._dress()
        super().changeEvent(event)
