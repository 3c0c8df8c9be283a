"""The timeline: a lane per landmark and limb over the recording's frames, and the scrubber."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

from PySide6 import QtGui
from PySide6.QtCore import QEvent, QPointF, QRect, QRectF, QSignalBlocker, QSize, Qt, Signal
from PySide6.QtWidgets import QAbstractScrollArea, QToolTip

from ..redraw import takes_key
from ..style.theme import current_theme
from .lanes import Lane, TimelineScale
from .painting import LEAST_LANE, MOST_LANE, RULER_HEIGHT, TimelinePainter, time_text

HELP = (
    "Drag to scrub, Shift+drag or drag in the ruler to select frames, scroll to zoom. Keys: "
    "arrows step, Shift+arrows step by ten, Page Up and Page Down by a second, Home and End, + - "
    "0 zoom, [ and ] set the ends of the selection, Esc clears it. Ctrl+click on names, or up and "
    "down, to select lanes; Shift adds."
)
_ZOOMS = {Qt.Key.Key_Plus: 1.5, Qt.Key.Key_Equal: 1.5, Qt.Key.Key_Minus: 1 / 1.5, Qt.Key.Key_0: 0.0}
"""Factors by keys; 0 shows all frames."""
_NAMES_NARROWEST, _NAMES_WIDEST = 120, 190
_STEPS_PER_PAGE = 1000


class TimelineView(QAbstractScrollArea):
    """Lanes over frames with a playhead.

    The lanes are kept as a picture that depends on the lanes, the visible frames and the size;
    moving the playhead paints that picture again and reads no data.
    """

    frame_requested = Signal(int)
    """The person went to this frame; the caller answers with :meth:`set_frame`."""
    selection_changed = Signal(object)
    lane_clicked = Signal(str)  # the name of a lane was clicked; what the program calls the lane
    lanes_selected = Signal(object)  # the person selected lanes by Ctrl and a click on their names
    visible_range_changed = Signal(float, float)
    """The person zoomed or moved, or a page was turned; borders of the visible frames, where frame
    k covers the stretch from k to k + 1."""
    hovered = Signal(object)  # the frame under the mouse, or None
    margins_changed = Signal(float, float)
    """Pixels beside the frames at the left and right: names, and a scroll bar."""

    def __init__(self) -> None:
        super().__init__()
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setFrameShape(QAbstractScrollArea.Shape.NoFrame)
        self.setMinimumHeight(RULER_HEIGHT + 3 * LEAST_LANE)
        self.setAccessibleName("Timeline")
        self.setAccessibleDescription(HELP)
        self.viewport().setMouseTracking(True)
        self.lanes: tuple[Lane, ...] = ()
        self._groups: dict[str, tuple[Lane, ...]] = {}
        self.selected_lanes: frozenset[str] = frozenset()
        self.lane_height = MOST_LANE  # height of a lane: what there is room for, within limits
        self._hint = ""
        self.scale = TimelineScale()
        self._fps = 1.0
        self.frame = 0
        self.selection: range | None = None
        self._hover: int | None = None
        self._drag: Literal["scrub", "select", "pan"] | None = None
        self._drag_start = 0
        self._drag_from = QPointF()
        self._picture: QtGui.QPixmap | None = None
        self.horizontalScrollBar().valueChanged.connect(self._on_scrolled)
        self.verticalScrollBar().valueChanged.connect(self._forget_picture)

    def sizeHint(self) -> QSize:
        return QSize(900, RULER_HEIGHT + MOST_LANE * max(len(self.lanes), 8))

    def set_range(self, frame_count: int, fps: float) -> None:
        self._fps = fps
        self.frame = min(self.frame, max(frame_count - 1, 0))
        self.selection = None
        self._show_scale(replace(self.scale, frame_count=frame_count).whole())

    @property
    def margins(self) -> tuple[float, float]:
        return self.scale.left, self.width() - self.scale.left - self.scale.width

    def set_hint(self, words: str) -> None:
        if words != self._hint:
            self._hint = words
            self._forget_picture()

    def set_lanes(self, lanes: Sequence[Lane], group: str = "runs") -> None:
        """Show these lanes; those handed on before keep what was computed for them.

        Lanes of other groups stay; groups stand in the order of their names.
        """
        self._groups[group] = tuple(lanes)
        shown = tuple(lane for name in sorted(self._groups) for lane in self._groups[name])
        if shown == self.lanes:
            return
        names, before = ([(one.name, one.colour) for one in each] for each in (shown, self.lanes))
        self.lanes = shown
        if names != before:
            self._select_lanes(self.selected_lanes & {lane.id for lane in shown})
            self._place_lanes()
            # a scroll bar that comes or goes makes this widget place the lanes again
            self._set_scroll_bars()
        self._forget_picture()

    def set_frame(self, frame: int) -> None:
        """Move the playhead, and turn the page where it would not be seen."""
        frame = max(0, min(frame, self.scale.frame_count - 1))
        if frame == self.frame:
            return
        old = self._area_of(self.frame)
        self.frame = frame
        if not self._drag:
            self._set_scale(self.scale.showing(frame))
        self.viewport().update(old)
        self.viewport().update(self._area_of(self.frame))

    def set_selection(self, selection: range | None) -> None:
        """Select frames without emitting a signal."""
        self.selection = selection if selection else None
        self.viewport().update()

    def set_hover(self, frame: int | None) -> None:
        """Mark the frame under the mouse, here or in another panel."""
        if frame != self._hover:
            for one in (self._hover, frame):
                self.viewport().update(self._area_of(one or 0))
            self._hover = frame

    def set_visible_range(self, first: float, last: float) -> None:
        """Zoom to the frames from `first` up to `last` without emitting a signal."""
        scale = self.scale.zoomed(self.scale.visible / max(last - first, 1.0), self.scale.left)
        self._show_scale(scale.moved(first - scale.first))

    def lane_at(self, y: float) -> Lane | None:
        if y < RULER_HEIGHT:
            return None
        index = int((y - RULER_HEIGHT + self.verticalScrollBar().value()) // self.lane_height)
        return self.lanes[index] if 0 <= index < len(self.lanes) else None

    def _set_scale(self, scale: TimelineScale) -> None:
        if scale != self.scale:
            self._show_scale(scale)
            self.visible_range_changed.emit(scale.first, scale.last)

    def _show_scale(self, scale: TimelineScale) -> None:
        self.scale = scale
        self._set_scroll_bars()
        self._forget_picture()

    def _set_scroll_bars(self) -> None:
        rows, scale = len(self.lanes) * self.lane_height, self.scale
        space = max(self.viewport().height() - RULER_HEIGHT, 1)
        self.verticalScrollBar().setRange(0, max(0, rows - space))
        self.verticalScrollBar().setPageStep(space)
        self.verticalScrollBar().setSingleStep(self.lane_height)
        with QSignalBlocker(self.horizontalScrollBar()):
            bar, step = self.horizontalScrollBar(), scale.visible / _STEPS_PER_PAGE
            bar.setRange(0, max(round((scale.frame_count - scale.visible) / step), 0))
            bar.setPageStep(_STEPS_PER_PAGE)
            bar.setSingleStep(_STEPS_PER_PAGE // 10)
            bar.setValue(round(scale.first / step))

    def _on_scrolled(self, value: int) -> None:
        first = value * self.scale.visible / _STEPS_PER_PAGE
        self._set_scale(self.scale.moved(first - self.scale.first))

    def _forget_picture(self) -> None:
        self._picture = None
        self.viewport().update()

    def resizeEvent(self, event: QtGui.QResizeEvent) -> None:
        super().resizeEvent(event)
        self._place_lanes()
        self._show_scale(self.scale)

    def _place_lanes(self) -> None:
        metrics = self.fontMetrics()
        longest = max((metrics.horizontalAdvance(lane.name) for lane in self.lanes), default=0)
        left = min(max(longest + 28, _NAMES_NARROWEST), _NAMES_WIDEST)
        width = max(self.viewport().width() - left, 1)
        space = (self.viewport().height() - RULER_HEIGHT) // max(len(self.lanes), 1)
        self.lane_height = min(max(space, LEAST_LANE), MOST_LANE)
        self.scale = replace(self.scale, left=float(left), width=float(width))
        self.margins_changed.emit(*self.margins)

    def changeEvent(self, event: QEvent) -> None:
        if event.type() in (QEvent.Type.PaletteChange, QEvent.Type.DevicePixelRatioChange):
            self._forget_picture()
        super().changeEvent(event)

    def paintEvent(self, _event: QtGui.QPaintEvent) -> None:
        painter = QtGui.QPainter(self.viewport())
        painter.drawPixmap(0, 0, self._painted())
        if self.scale.frame_count:
            over = TimelinePainter(painter, self.scale, self.viewport().size())
            if self.selection is not None:
                over.selection(self.selection)
            if self._hover is not None:
                over.hover(self._hover)
            over.playhead(self.frame)
        painter.end()

    def _painted(self) -> QtGui.QPixmap:
        """The picture of the lanes, which is kept until something of it changes."""
        if self._picture is not None:
            return self._picture
        ratio, size = self.devicePixelRatioF(), self.viewport().size()
        picture = QtGui.QPixmap(round(size.width() * ratio), round(size.height() * ratio))
        picture.setDevicePixelRatio(ratio)
        picture.fill(current_theme().window)
        self._picture, painter = picture, QtGui.QPainter(picture)
        font = QtGui.QFont(self.font())  # letters that fit a lane
        font.setPixelSize(min(QtGui.QFontInfo(font).pixelSize(), self.lane_height - 2))
        painter.setFont(font)
        parts = TimelinePainter(painter, self.scale, size, self.verticalScrollBar().value())
        parts.strips(self.lanes, self.lane_height, ratio)
        parts.names(self.lanes, self.lane_height, self.selected_lanes)
        painter.setFont(self.font())
        parts.ruler(self._fps)
        if self._hint and not self.lanes:
            parts.hint(self._hint)
        painter.end()
        return picture

    def _area_of(self, frame: int) -> QRect:
        left, right = self.scale.x_of(frame), self.scale.x_of(frame + 1)
        area = QRectF(left - 40.0, 0.0, right - left + 80.0, self.viewport().height())
        return area.toAlignedRect()

    def mousePressEvent(self, event: QtGui.QMouseEvent) -> None:
        position = event.position()
        if not self.scale.frame_count:
            return
        if position.x() < self.scale.left:
            lane = self.lane_at(position.y())
            if lane and event.modifiers() & Qt.KeyboardModifier.ControlModifier:
                self._select_lanes(self.selected_lanes ^ {lane.id})
            elif lane and event.button() == Qt.MouseButton.LeftButton:
                self.lane_clicked.emit(lane.id)
            return
        self._drag_from = position
        self._drag_start = self.scale.frame_at(position.x())
        shift = event.modifiers() & Qt.KeyboardModifier.ShiftModifier
        if event.button() == Qt.MouseButton.MiddleButton:
            self._drag = "pan"
        elif event.button() == Qt.MouseButton.LeftButton:
            in_ruler = position.y() < RULER_HEIGHT
            self._drag = "select" if shift or in_ruler else "scrub"
            if not shift:
                self._request(self._drag_start)

    def mouseMoveEvent(self, event: QtGui.QMouseEvent) -> None:
        x = event.position().x()
        frame = self.scale.frame_at(x)
        self.hovered.emit(frame if x >= self.scale.left and self.scale.frame_count else None)
        if self._drag == "scrub":
            self._request(frame)
        elif self._drag == "select":
            low, high = sorted((self._drag_start, frame))
            if self.selection is not None or low != high:
                self._select(range(low, high + 1))
        elif self._drag == "pan":
            step = (self._drag_from.x() - x) / self.scale.width * self.scale.visible
            self._drag_from = event.position()
            self._set_scale(self.scale.moved(step))

    def mouseReleaseEvent(self, event: QtGui.QMouseEvent) -> None:
        moved = (event.position() - self._drag_from).manhattanLength() > 3
        if self._drag == "select" and not moved:
            self._select(None)
        self._drag = None

    def wheelEvent(self, event: QtGui.QWheelEvent) -> None:
        turn = event.angleDelta()
        modifiers = event.modifiers()
        if modifiers & Qt.KeyboardModifier.ControlModifier:
            bar = self.verticalScrollBar()
            bar.setValue(bar.value() - turn.y() // 4)
        elif modifiers & Qt.KeyboardModifier.ShiftModifier or abs(turn.x()) > abs(turn.y()):
            turned = turn.x() or turn.y()
            self._set_scale(self.scale.moved(-turned / 1200 * self.scale.visible))
        elif self.scale.frame_count:
            self._set_scale(self.scale.zoomed(1.0015 ** turn.y(), event.position().x()))
        event.accept()

    def viewportEvent(self, event: QEvent) -> bool:
        if event.type() == QEvent.Type.ToolTip and isinstance(event, QtGui.QHelpEvent):
            text = self.tooltip_at(QPointF(event.pos()))
            QToolTip.showText(event.globalPos(), text, self.viewport())
            return True
        if event.type() == QEvent.Type.Leave:
            self.hovered.emit(None)
        return super().viewportEvent(event)

    def tooltip_at(self, position: QPointF) -> str:
        """Frame, time and value at a position of the viewport; the help over the names."""
        if not self.scale.frame_count or position.x() < self.scale.left:
            return HELP
        frame = self.scale.frame_at(position.x())
        text = f"frame {frame}   {time_text(frame, self._fps)}"
        lane = self.lane_at(position.y())
        value = lane.value_text(frame) if lane is not None else ""
        return f"{text}\n{lane.name}: {value}" if lane is not None and value else text

    def event(self, event: QEvent) -> bool:
        # what zooms the active view zooms the timeline while that has the focus
        return takes_key(event, lambda key: key.key() in _ZOOMS) or super().event(event)

    def keyPressEvent(self, event: QtGui.QKeyEvent) -> None:
        second, every = max(1, round(self._fps)), self.scale.frame_count
        key, old, here = Qt.Key(event.key()), self.selection, self.frame
        if not self.scale.frame_count:
            super().keyPressEvent(event)
        elif key in (Qt.Key.Key_PageUp, Qt.Key.Key_PageDown):
            self._request(here + (second if key == Qt.Key.Key_PageDown else -second))
        elif factor := _ZOOMS.get(key):
            self._set_scale(self.scale.zoomed(factor, self.scale.x_of(here + 0.5)))
        elif key == Qt.Key.Key_0:
            self._set_scale(self.scale.whole())
        elif key == Qt.Key.Key_Escape and (self.selection or self.selected_lanes):
            self._select(None)
            self._select_lanes(frozenset())
        elif key == Qt.Key.Key_BracketLeft:
            self._select(range(here, max(old.stop, here + 1) if old else every))
        elif key == Qt.Key.Key_BracketRight:
            self._select(range(min(old.start, here) if old else 0, here + 1))
        elif key in (Qt.Key.Key_Up, Qt.Key.Key_Down) and self.lanes:
            shift = bool(event.modifiers() & Qt.KeyboardModifier.ShiftModifier)
            self._select_next_lane(down=key == Qt.Key.Key_Down, adds=shift)
        else:
            super().keyPressEvent(event)

    def _select_next_lane(self, *, down: bool, adds: bool) -> None:
        names = [lane.id for lane in self.lanes]
        places = [place for place, name in enumerate(names) if name in self.selected_lanes]
        last = len(names) - 1
        place = max([-1, *places]) + 1 if down else min([last + 1, *places]) - 1
        place = min(max(place, 0), last)
        before = self.selected_lanes if adds else frozenset()
        self._select_lanes(before | {names[place]})
        bar, top = self.verticalScrollBar(), place * self.lane_height
        space = self.viewport().height() - RULER_HEIGHT - self.lane_height
        bar.setValue(min(max(bar.value(), top - space), top))

    def _request(self, frame: int) -> None:
        frame = max(0, min(frame, self.scale.frame_count - 1))
        if frame != self.frame:
            self.set_frame(frame)
            self.frame_requested.emit(frame)

    def _select_lanes(self, names: frozenset[str]) -> None:
        if names != self.selected_lanes:
            self.selected_lanes = names
            self._forget_picture()
            self.lanes_selected.emit(names)

    def _select(self, selection: range | None) -> None:
        if selection != self.selection:
            self.set_selection(selection)
            self.selection_changed.emit(selection)
