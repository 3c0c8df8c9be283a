"""What a camera view shows: one picture of one view, and the widget that holds it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QImage, QPainter, QResizeEvent, QTransform
from PySide6.QtWidgets import QSizePolicy, QWidget

from stereotrack_core.arrays import ImageArray

from ...session.view_state import Display, PictureKind
from ..redraw import RedrawQueue
from .overlays import Overlay


def _silent(_x: float, _y: float) -> str:
    return ""


@dataclass(frozen=True, eq=False)
class Picture:
    """One picture of one view at one instant."""

    view: str
    kind: PictureKind
    frame: int
    pixels: ImageArray | None
    """(H, W) or (H, W, 3) uint8, or None. Grey or BGR; None where there is nothing to show."""
    message: str = ""  # why there is nothing to show, or what is suspicious
    rotation: int = 0  # degrees clockwise that make it look upright
    make_overlay: Callable[[], Overlay] = Overlay  # makes what is drawn over it, when it is painted
    camera: str = ""  # the camera whose raw pixels these are; empty for a picture that was computed
    value_at: Callable[[float, float], str] = _silent
    """From column and row to words about the pixel: its value and the depth of its ray."""

    @cached_property
    def overlay(self) -> Overlay:
        return self.make_overlay()

    def looks_like(self, other: Picture) -> bool:
        """Whether it is painted like another one, whatever may be said of its pixels."""
        a, b = (replace(one, value_at=_silent, make_overlay=Overlay) for one in (self, other))
        painted_alike = self.pixels is other.pixels and alike(a, b)
        return painted_alike and alike(self.overlay, other.overlay)


def alike(a: Any, b: Any) -> bool:
    """Whether two values are equal, with all arrays in them."""
    if a is b or type(a) is not type(b):
        return a is b
    if isinstance(a, np.ndarray):
        return bool(np.array_equal(a, b, equal_nan=a.dtype.kind == "f"))
    if isinstance(a, tuple):
        return len(a) == len(b) and all(map(alike, a, b))
    if is_dataclass(a):
        return all(alike(getattr(a, part.name), getattr(b, part.name)) for part in fields(a))
    return bool(a == b)


def image_of(pixels: ImageArray) -> QImage:
    """An image of grey or BGR pixels (H, W) or (H, W, 3), which lives no longer than they do."""
    whole = np.ascontiguousarray(pixels)
    height, width = whole.shape[:2]
    form = QImage.Format.Format_Grayscale8 if whole.ndim == 2 else QImage.Format.Format_BGR888
    return QImage(whole.data, width, height, whole.strides[0], form)


_MOST_ZOOM = 64.0
_PERSON_SHARE, _LEAST_SHARE = 0.8, 0.5
_LEAST_PERSON = 0.2
"""Share of the picture below which nothing counts as a person: two clicks are not one."""


class PictureView(QWidget):
    """Holds one :class:`Picture` and knows which of its pixels is where in the widget."""

    def __init__(self, redraw: RedrawQueue, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._redraw = redraw
        self.picture: Picture | None = None
        self.painted: Picture | None = None
        self._stale = False  # whether something over the picture has changed since it was painted
        self._display = Display()
        self._image: QImage | None = None
        self.zoom = 1.0  # magnification over the fitting size, at least 1
        self._centre: QPointF | None = None
        self._by_hand = self._at_home = False
        self._home: QRectF | None = None
        self._before: tuple[float, QPointF | None, bool, bool] | None = None
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMinimumSize(120, 80)
        self.setAttribute(Qt.WidgetAttribute.WA_OpaquePaintEvent)

    @property
    def painted_frame(self) -> int:
        """Number of the frame that is painted; -1 before any is."""
        return -1 if self.painted is None else self.painted.frame

    def inside(self, pixel: QPointF) -> bool:
        width, height = self._size()
        return -0.5 <= pixel.x() < width - 0.5 and -0.5 <= pixel.y() < height - 0.5

    def raw_direction(self, x: float, y: float) -> tuple[float, float]:
        """Direction in raw pixels of one in the picture as it is shown."""
        inverse, _ = self._upright().inverted()
        return (inverse.map(QPointF(x, y)) - inverse.map(QPointF())).toTuple()

    def sizeHint(self) -> QSize:
        return QSize(480, 360)

    def show_picture(self, picture: Picture) -> None:
        """Show another picture, when it is its turn to be painted.

        Zoom and place are kept while its size stays the same. One that looks like that which is
        painted is not painted again; finding that out takes its time, and a turn for each view.
        """
        size_before, before = self._size(), self.picture
        self.picture = picture
        if before is None or picture.pixels is not before.pixels:
            self._image = None
        if self._size() != size_before:
            self.fit()
            self._go_home()
        self._redraw.soon(self._paint_other)

    def _paint_other(self) -> None:
        painted, wanted = self.painted, self.picture
        other = painted is None or wanted is None or not wanted.looks_like(painted)
        if other:
            self._keep_person()
        if other or self._stale:
            self.repaint()

    def set_display(self, display: Display) -> None:
        old, self._display = self._display, display
        if (old.brightness, old.contrast) != (display.brightness, display.contrast):
            self._image = None
        if old.keep_person != display.keep_person:
            self.fit()
            self._keep_person()
        self.update()

    def fit(self) -> None:
        self.zoom, self._centre, self._by_hand, self._at_home = 1.0, None, False, False
        self.update()

    def set_home(self, box: QRectF) -> bool:
        """Begin with this part of the picture, in raw pixels; False where somebody has zoomed."""
        if self.zoom != 1.0:
            return False
        self._home = box
        self._go_home()  # or when there is a picture
        return True

    def zoom_to(self, box: QRectF, share: float = 1.0) -> None:
        """Enlarge what is in a box of raw pixels until it takes this share of the widget."""
        place, (width, height) = self._to_widget().mapRect(box), self._upright_size()
        part = max(place.width() / self.width(), place.height() / self.height(), 1e-3)
        self.zoom = float(np.clip(self.zoom * share / part, 1.0, _MOST_ZOOM))
        centre = self._upright().map(box.center()) - QPointF(0.5 * width, 0.5 * height)
        # nothing beyond the picture is shown where more of the picture could be
        across = 0.5 * max(width - self.width() / self._scale(), 0.0)
        down = 0.5 * max(height - self.height() / self._scale(), 0.0)
        x, y = np.clip([centre.x(), centre.y()], [-across, -down], [across, down])
        self._centre = QPointF(x, y) if self.zoom > 1.0 else None
        self.update()

    def look_at(self, box: QRectF) -> None:
        """Show a box of raw pixels, enlarged where there is room, until `look_back`."""
        self._before = self.zoom, self._centre, self._by_hand, self._at_home
        self._by_hand, self._at_home = True, False
        place = self._to_widget().mapRect(box)
        self.zoom_to(box, max(1.0, place.width() / self.width(), place.height() / self.height()))

    def look_back(self) -> None:
        """Show again what was shown before `look_at`."""
        if self._before is not None:
            self.zoom, self._centre, self._by_hand, self._at_home = self._before
            self._before = None
            self.update()

    def zoom_by(self, factor: float, at: QPointF | None = None) -> None:
        """Zoom by `factor`, keeping the picture's point under `at` (widget) where it is."""
        place = at if at is not None else QPointF(self.rect().center())
        fixed = self.pixel_at(place)
        self._by_hand, self._at_home = True, False
        self.zoom = float(np.clip(self.zoom * factor, 1.0, _MOST_ZOOM))
        self._centre = None if self.zoom == 1.0 else self._centre or QPointF()
        self._pan(place - self._to_widget().map(fixed))
        self.update()

    def pixel_at(self, position: QPointF) -> QPointF:
        """Pixel of the picture, as recorded, under a place in the widget."""
        return self._to_widget().inverted()[0].map(position)

    def place_of(self, x: float, y: float) -> QPointF:
        """Place in the widget of a pixel of the picture."""
        return self._to_widget().map(QPointF(x, y))

    def _size(self) -> tuple[int, int]:
        """Columns and rows of the picture; 0 where there is nothing to show."""
        pixels = self.picture.pixels if self.picture is not None else None
        return (0, 0) if pixels is None else (pixels.shape[1], pixels.shape[0])

    def _image_of(self, pixels: ImageArray) -> QImage:
        """The picture as it is painted, made when that is done first."""
        if self._image is None:
            brightness, contrast = self._display.brightness, self._display.contrast
            if (brightness, contrast) != (0.0, 1.0):
                levels = (np.arange(256.0) - 127.5) * contrast + 127.5 + 255.0 * brightness
                pixels = np.clip(levels, 0, 255).astype(np.uint8)[pixels]
            # what is drawn most often is kept as the screen wants it; the copy owns its memory
            self._image = image_of(pixels).convertToFormat(QImage.Format.Format_RGB32)
        return self._image

    def _upright(self) -> QTransform:
        """From raw pixels to the picture turned upright, its corner at the origin."""
        width, height = self._size()
        # the centre of the top-left pixel is (0, 0), so the picture starts at (-1/2, -1/2)
        turn = self.picture.rotation % 360 if self.picture is not None else 0
        shift = {0: (0, 0), 90: (height, 0), 180: (width, height), 270: (0, width)}[turn]
        half = QTransform.fromTranslate(0.5, 0.5)
        return half * QTransform().rotate(turn) * QTransform.fromTranslate(*shift)

    def _upright_size(self) -> tuple[float, float]:
        width, height = self._size()
        turned = self.picture is not None and self.picture.rotation % 180 == 90
        return (height, width) if turned else (width, height)

    def _scale(self) -> float:
        width, height = self._upright_size()
        if not width or not height:
            return 1.0
        return self.zoom * min(self.width() / width, self.height() / height)

    def _to_widget(self) -> QTransform:
        width, height = self._upright_size()
        scale = self._scale()
        centre = self._centre or QPointF()
        x = 0.5 * self.width() - scale * (0.5 * width + centre.x())
        y = 0.5 * self.height() - scale * (0.5 * height + centre.y())
        return self._upright() * QTransform.fromScale(scale, scale) * QTransform.fromTranslate(x, y)

    def person_box(self) -> QRectF | None:
        """Where the person is in the picture, in raw pixels; None where nothing tells it."""
        return self.picture.overlay.person_box() if self.picture is not None else None

    def knows_person(self) -> bool:
        return self.person_box() is not None or self._home is not None

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        if self._at_home:
            self._go_home()

    def _go_home(self) -> None:
        if self._home is not None and any(self._size()) and not self._by_hand:
            self.zoom_to(self._home)
            self._at_home = True

    def _keep_person(self) -> None:
        """Enlarge the person, and move only when it is about to leave what is seen."""
        if not self._display.keep_person or self._by_hand or not any(self._size()):
            return  # before anything is computed that nobody asked for
        box = self.person_box() or self._home
        if box is None:
            return
        least = _LEAST_PERSON * max(self._size())
        wider, higher = (max(0.0, 0.5 * (least - side)) for side in box.size().toTuple())
        box = box.adjusted(-wider, -higher, wider, higher)
        place, seen = self._to_widget().mapRect(box), QRectF(self.rect())
        share = max(place.width() / seen.width(), place.height() / seen.height())
        if not seen.contains(place) or share <= _LEAST_SHARE:
            self._at_home = False
            self.zoom_to(box, _PERSON_SHARE)

    def _pan(self, by: QPointF) -> None:
        if self._centre is None:
            return
        moved, most = self._centre - by / self._scale(), 0.5 * np.array(self._upright_size())
        self._centre = QPointF(*np.clip(moved.toTuple(), -most, most))
        self.update()

    def _paint_message(self, painter: QPainter, colour: QColor) -> None:
        painter.setPen(colour)
        area = self.rect().adjusted(16, 8, -16, -8)
        flags = Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap
        painter.drawText(area, flags, self.picture.message if self.picture is not None else "")
