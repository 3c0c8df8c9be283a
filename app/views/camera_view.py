"""One picture with its overlays: zoom at the cursor, pan, loupe, what is under the cursor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import (
    QColor,
    QEnterEvent,
    QImage,
    QMouseEvent,
    QPainter,
    QPainterPath,
    QPaintEvent,
    QPen,
    QTransform,
    QWheelEvent,
)
from PySide6.QtWidgets import QSizePolicy, QWidget

from app.theme import current_theme
from app.views.overlays import paint_overlay
from app.views.picture import Picture, brightened

LOUPE_SIZE = 170
LOUPE_FACTOR = 4.0
_CLICK_PIXELS = 4
_MOST_ZOOM = 64.0
_PERSON_SHARE, _LEAST_SHARE = 0.8, 0.5


@dataclass(frozen=True)
class Display:
    """How pictures are displayed, the same for all views.

    Attributes
    ----------
    overlays : frozenset of str
        Names of the overlays that are switched on.
    highlighted : str
        Limb that is selected everywhere, or empty.
    brightness : float
        -1 to 1.
    contrast : float
        Factor.
    loupe : bool
    keep_person : bool
        Whether views enlarge the person and follow it, until somebody zooms by hand.
    """

    overlays: frozenset[str] = frozenset({"outline", "reference"})
    highlighted: str = ""
    brightness: float = 0.0
    contrast: float = 1.0
    loupe: bool = False
    keep_person: bool = False


class CameraView(QWidget):
    """Paints one :class:`Picture`; data are never resampled, only displayed.

    Signals
    -------
    hovered : str
        Words about the pixel under the cursor; empty when the cursor leaves.
    pressed : ()
        The view was clicked into.
    limb_clicked : str
        A limb's outline was clicked, or empty for a click beside the model.
    painted : int
        The frame that has just been painted.
    """

    hovered = Signal(str)
    pressed = Signal()
    limb_clicked = Signal(str)
    painted = Signal(int)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._picture: Picture | None = None
        self._display = Display()
        self._image = QImage()
        self._zoom = 1.0
        self._centre: QPointF | None = None
        self._cursor: QPointF | None = None
        self._drag: tuple[QPointF, QPointF] | None = None
        self._dragged = False
        self._by_hand = False
        self.painted_frame = -1
        self.setMouseTracking(True)
        self.setFocusPolicy(Qt.FocusPolicy.ClickFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMinimumSize(120, 80)
        self.setAttribute(Qt.WidgetAttribute.WA_OpaquePaintEvent)

    @property
    def picture(self) -> Picture | None:
        """What is shown."""
        return self._picture

    @property
    def zoom(self) -> float:
        """Magnification over the fitting size, at least 1."""
        return self._zoom

    def sizeHint(self) -> QSize:
        return QSize(480, 360)

    def show_picture(self, picture: Picture) -> None:
        """Show another picture; zoom and place are kept while its size stays the same."""
        size_before = self._image.size()
        self._picture = picture
        self._make_image()
        if self._image.size() != size_before:
            self.fit()
        self._keep_person()
        self._tell_hover()
        self.update()

    def set_display(self, display: Display) -> None:
        """Change how pictures are displayed."""
        old, self._display = self._display, display
        if (old.brightness, old.contrast) != (display.brightness, display.contrast):
            self._make_image()
        if old.keep_person != display.keep_person:
            self.fit()
            self._keep_person()
        self.update()

    def fit(self) -> None:
        """Show the whole picture."""
        self._zoom, self._centre, self._by_hand = 1.0, None, False
        self.update()

    def zoom_by(self, factor: float, at: QPointF | None = None) -> None:
        """Zoom by `factor`, keeping the picture's point under `at` (widget) where it is."""
        place = at if at is not None else QPointF(self.rect().center())
        fixed = self.pixel_at(place)
        self._by_hand = True
        self._zoom = float(np.clip(self._zoom * factor, 1.0, _MOST_ZOOM))
        if self._zoom == 1.0:
            self._centre = None
        else:
            self._centre = QPointF(0.0, 0.0) if self._centre is None else self._centre
            moved = self._to_widget().map(fixed)
            self._pan(place - moved)
        self.update()

    def pixel_at(self, position: QPointF) -> QPointF:
        """Pixel of the picture, as recorded, under a place in the widget."""
        inverse, _ = self._to_widget().inverted()
        return inverse.map(position)

    def place_of(self, x: float, y: float) -> QPointF:
        """Place in the widget of a pixel of the picture."""
        return self._to_widget().map(QPointF(x, y))

    def _make_image(self) -> None:
        pixels = self._picture.pixels if self._picture is not None else None
        if pixels is None:
            self._image = QImage()
            return
        lit = np.ascontiguousarray(
            brightened(pixels, self._display.brightness, self._display.contrast)
        )
        height, width = lit.shape[:2]
        grey = lit.ndim == 2
        form = QImage.Format.Format_Grayscale8 if grey else QImage.Format.Format_BGR888
        image = QImage(lit.data, width, height, lit.strides[0], form)
        # what is drawn most often is kept as the screen wants it; the copy also owns its memory
        self._image = image.convertToFormat(QImage.Format.Format_RGB32)

    def _upright(self) -> QTransform:
        """From raw pixels to the picture turned upright, its corner at the origin."""
        width, height = self._image.width(), self._image.height()
        # the centre of the top-left pixel is (0, 0), so the picture starts at (-1/2, -1/2)
        turn = self._picture.rotation % 360 if self._picture is not None else 0
        shift = {0: (0, 0), 90: (height, 0), 180: (width, height), 270: (0, width)}[turn]
        half = QTransform.fromTranslate(0.5, 0.5)
        return half * QTransform().rotate(turn) * QTransform.fromTranslate(*shift)

    def _upright_size(self) -> tuple[float, float]:
        width, height = self._image.width(), self._image.height()
        turned = self._picture is not None and self._picture.rotation % 180 == 90
        return (height, width) if turned else (width, height)

    def _scale(self) -> float:
        width, height = self._upright_size()
        if not width or not height:
            return 1.0
        return self._zoom * min(self.width() / width, self.height() / height)

    def _to_widget(self) -> QTransform:
        """From raw pixels to the widget."""
        width, height = self._upright_size()
        scale = self._scale()
        centre = self._centre if self._centre is not None else QPointF(0.0, 0.0)
        x = 0.5 * self.width() - scale * (0.5 * width + centre.x())
        y = 0.5 * self.height() - scale * (0.5 * height + centre.y())
        return self._upright() * QTransform.fromScale(scale, scale) * QTransform.fromTranslate(x, y)

    def _keep_person(self) -> None:
        """Enlarge the person, and move only when it is about to leave what is seen."""
        if not self._display.keep_person or self._by_hand or self._picture is None:
            return
        box = self._picture.overlay.person_box()
        if box is None or self._image.isNull():
            return
        place = self._to_widget().mapRect(box)
        seen = QRectF(self.rect())
        share = max(place.width() / seen.width(), place.height() / seen.height())
        if seen.contains(place) and share > _LEAST_SHARE:
            return
        zoom = self._zoom * _PERSON_SHARE / max(share, 1e-3)
        self._zoom = float(np.clip(zoom, 1.0, _MOST_ZOOM))
        width, height = self._upright_size()
        centre = self._upright().map(box.center())
        self._centre = centre - QPointF(0.5 * width, 0.5 * height)

    def _pan(self, by: QPointF) -> None:
        if self._centre is None:
            return
        width, height = self._upright_size()
        moved = self._centre - by / self._scale()
        self._centre = QPointF(
            float(np.clip(moved.x(), -0.5 * width, 0.5 * width)),
            float(np.clip(moved.y(), -0.5 * height, 0.5 * height)),
        )
        self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        theme = current_theme()
        painter = QPainter(self)
        painter.fillRect(self.rect(), QColor(theme.scene_bottom))
        if self._image.isNull():
            self._paint_message(painter, QColor(theme.muted))
        else:
            self._paint_picture(painter, self._to_widget(), self._scale())
            if self._display.loupe and self._cursor is not None:
                self._paint_loupe(painter, self._cursor, QColor(theme.accent))
        painter.end()
        if self._picture is not None:
            self.painted_frame = self._picture.frame
            self.painted.emit(self._picture.frame)

    def _paint_picture(self, painter: QPainter, transform: QTransform, scale: float) -> None:
        if self._picture is None:
            return
        painter.save()
        painter.setTransform(transform, True)
        # enlarged pixels stay squares, so that one sees what was measured
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, scale < 3.0)
        painter.drawImage(QPointF(-0.5, -0.5), self._image)
        paint_overlay(
            painter,
            self._picture.overlay,
            self._display.overlays,
            self._display.highlighted,
            scale,
        )
        painter.restore()

    def _paint_message(self, painter: QPainter, colour: QColor) -> None:
        words = self._picture.message if self._picture is not None else ""
        painter.setPen(colour)
        area = self.rect().adjusted(16, 8, -16, -8)
        flags = Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap
        painter.drawText(area, flags, words)

    def _paint_loupe(self, painter: QPainter, place: QPointF, rim: QColor) -> None:
        radius = 0.5 * LOUPE_SIZE
        circle = QRectF(place.x() - radius, place.y() - radius, LOUPE_SIZE, LOUPE_SIZE)
        path = QPainterPath()
        path.addEllipse(circle)
        painter.save()
        painter.setClipPath(path)
        painter.fillRect(circle, QColor("black"))
        enlarge = (
            QTransform.fromTranslate(-place.x(), -place.y())
            * QTransform.fromScale(LOUPE_FACTOR, LOUPE_FACTOR)
            * QTransform.fromTranslate(place.x(), place.y())
        )
        self._paint_picture(painter, self._to_widget() * enlarge, LOUPE_FACTOR * self._scale())
        painter.setPen(QPen(QColor(255, 255, 255, 160), 1))
        painter.drawLine(place - QPointF(9, 0), place + QPointF(9, 0))
        painter.drawLine(place - QPointF(0, 9), place + QPointF(0, 9))
        painter.restore()
        painter.setPen(QPen(rim, 2))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawEllipse(circle)

    def wheelEvent(self, event: QWheelEvent) -> None:
        if event.angleDelta().y():
            self.zoom_by(1.2 ** (event.angleDelta().y() / 120.0), event.position())
        event.accept()

    def mousePressEvent(self, event: QMouseEvent) -> None:
        self.pressed.emit()
        if event.button() in {Qt.MouseButton.LeftButton, Qt.MouseButton.MiddleButton}:
            self._drag = (event.position(), event.position())
            self._dragged = False

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        self._cursor = event.position()
        if self._drag is not None:
            start, last = self._drag
            if (event.position() - start).manhattanLength() > _CLICK_PIXELS or self._dragged:
                self._dragged = self._by_hand = True
                self._pan(event.position() - last)
                if self._zoom > 1.0:
                    self.setCursor(Qt.CursorShape.ClosedHandCursor)
            self._drag = (start, event.position())
        self._tell_hover()
        if self._display.loupe:
            self.update()

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        if (
            self._drag is not None
            and not self._dragged
            and event.button() == Qt.MouseButton.LeftButton
        ):
            self.limb_clicked.emit(self._limb_at(event.position()))
        self._drag = None
        self.unsetCursor()

    def mouseDoubleClickEvent(self, _event: QMouseEvent) -> None:
        self.fit()

    def enterEvent(self, event: QEnterEvent) -> None:
        self._cursor = event.position()
        self._tell_hover()

    def leaveEvent(self, _event: QEvent) -> None:
        self._cursor = None
        self.hovered.emit("")
        self.update()

    def _limb_at(self, position: QPointF) -> str:
        if self._picture is None:
            return ""
        pixel = self.pixel_at(position)
        nearest_last = [shape.limb for shape in self._picture.overlay.shapes]
        order = {limb: place for place, limb in enumerate(nearest_last)}
        hit = [limb for limb, path in self._picture.overlay.paths if path.contains(pixel)]
        return max(hit, key=lambda limb: order[limb], default="")

    def _tell_hover(self) -> None:
        if self._cursor is None or self._picture is None or self._image.isNull():
            return
        pixel = self.pixel_at(self._cursor)
        column, row = round(pixel.x()), round(pixel.y())
        if 0 <= column < self._image.width() and 0 <= row < self._image.height():
            words = self._picture.value_at(pixel.x(), pixel.y())
            self.hovered.emit(
                f"{self._picture.view}  x {pixel.x():.1f}  y {pixel.y():.1f}  {words}"
            )
        else:
            self.hovered.emit("")
