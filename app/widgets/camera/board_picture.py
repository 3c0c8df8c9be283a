"""A picture of a calibration board with the corners that were found in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QImage, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QSizePolicy, QWidget

from stereotrack_core.arrays import BoolArray, FloatArray, ImageArray

from ..style.theme import Theme, current_theme

_ENLARGED = 20.0
"""How much longer errors are drawn than they are."""
_SHADE = QColor(0, 0, 0, 165)
_FOUND, _ERROR = QColor("#56d364"), QColor("#ff8a2b")
"""Bright on any picture."""


@dataclass(frozen=True, eq=False)
class BoardShot:
    """What is shown: grey `image` (H, W), corners (n, 2) and their errors (n, 2) in its pixels.

    Corners are NaN where unseen. `columns` is the number of corners in a row.
    """

    title: str
    image: ImageArray | None = None
    corners: FloatArray | None = None
    errors: FloatArray | None = None
    columns: int = 0
    message: str = ""
    """Said where there is no picture."""


_NOTHING = BoardShot("", message="Choose a picture in the list to see it here.")


class BoardPicture(QWidget):
    """Shows one picture as large as there is room."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.shot = _NOTHING
        self._image = QImage()
        self.setMinimumSize(200, 100)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setAccessibleName("Picture of the board")
        self.setToolTip(
            "Green: corners that were found, in their order. Orange: their errors, "
            f"{_ENLARGED:.0f} times enlarged."
        )

    def sizeHint(self) -> QSize:
        return QSize(480, 360)

    def show_shot(self, shot: BoardShot | None) -> None:
        """Show this picture, or none."""
        shot = shot or _NOTHING
        if shot.image is not self.shot.image:
            self._image = _qimage(shot.image)
        self.shot = shot
        self.setAccessibleDescription(shot.title)
        self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        theme = current_theme()
        painter.fillRect(self.rect(), QColor(theme.base))
        if self._image.isNull():
            painter.setPen(QColor(theme.muted))
            box = self.rect().adjusted(16, 16, -16, -16)
            flags = Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap
            painter.drawText(box, flags, self.shot.message or _NOTHING.message)
        else:
            self._paint_shot(painter)
        painter.end()

    def _paint_shot(self, painter: QPainter) -> None:
        size = QSize(self._image.size()).scaled(self.size(), Qt.AspectRatioMode.KeepAspectRatio)
        place = QRectF(0.0, 0.0, size.width(), size.height())
        place.moveCenter(QRectF(self.rect()).center())
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        painter.drawImage(place, self._image)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        scale = place.width() / self._image.width()
        if self.shot.corners is not None:
            at = (self.shot.corners + 0.5) * scale + (place.left(), place.top())
            self._paint_corners(painter, at)
            if self.shot.errors is not None:
                _paint_errors(painter, at, self.shot.errors * scale * _ENLARGED)
        self._paint_title(painter, place)

    def _paint_corners(self, painter: QPainter, at: FloatArray) -> None:
        known = np.isfinite(at[:, 0])
        rows = at.reshape(-1, self.shot.columns, 2) if self.shot.columns else at[None]
        painter.setPen(QPen(_FOUND, 1.0))
        for row in rows:
            ends = [QPointF(x, y) for x, y in row[np.isfinite(row[:, 0])]]
            painter.drawPolyline(ends)
        painter.setBrush(_FOUND)
        for k, (x, y) in enumerate(at[known]):
            radius = 4.0 if k == 0 and known[0] else 2.2
            painter.drawEllipse(QPointF(x, y), radius, radius)

    def _paint_title(self, painter: QPainter, place: QRectF) -> None:
        if not self.shot.title:
            return
        metrics = painter.fontMetrics()
        room = place.width() - 20.0
        words = metrics.elidedText(self.shot.title, Qt.TextElideMode.ElideMiddle, int(room))
        box = QRectF(place.left() + 4.0, place.top() + 4.0,
                     metrics.horizontalAdvance(words) + 12.0, metrics.height() + 4.0)  # fmt: skip
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(_SHADE)
        painter.drawRoundedRect(box, 4.0, 4.0)
        painter.setPen(QColor("white"))
        painter.drawText(box, Qt.AlignmentFlag.AlignCenter, words)


def _paint_errors(painter: QPainter, at: FloatArray, errors: FloatArray) -> None:
    known = np.isfinite(at).all(axis=1) & np.isfinite(errors).all(axis=1)
    painter.setPen(QPen(_ERROR, 1.5))
    for (x, y), (right, down) in zip(at[known], errors[known], strict=True):
        painter.drawLine(QPointF(x, y), QPointF(x + right, y + down))


def _qimage(image: ImageArray | None) -> QImage:
    if image is None:
        return QImage()
    pixels = np.ascontiguousarray(image)
    height, width = pixels.shape
    form = QImage.Format.Format_Grayscale8
    return QImage(pixels.data, width, height, pixels.strides[0], form).copy()


_ROOM = 22.0
"""Pixels below the map for its words."""


@dataclass(frozen=True, eq=False)
class CoverageShown:
    """An image of `size` (width, height), the `cells` (r, c) reached, and `corners` (n, 2)."""

    title: str
    size: tuple[int, int]
    cells: BoolArray
    corners: FloatArray
    """Raw pixels, none of them NaN."""


class CoverageMap(QWidget):
    """Cells of the image that hold corners, and the corners themselves."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.shown: CoverageShown | None = None
        self.setMinimumSize(140, 80)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setAccessibleName("Coverage of the image")
        self.setToolTip(
            "Dots: all corners of the board in this camera's pictures. Cells without a colour: "
            "the board was never there, so that the distortion is a guess."
        )

    def sizeHint(self) -> QSize:
        return QSize(280, 220)

    def show_coverage(self, shown: CoverageShown | None) -> None:
        """Show this, or nothing."""
        self.shown = shown
        self.setAccessibleDescription("" if shown is None else shown.title)
        self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter, theme = QPainter(self), current_theme()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if self.shown is None:
            painter.setPen(QColor(theme.muted))
            words = "Calculate the lenses to see where in the image the board was."
            flags = Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap
            painter.drawText(self.rect().adjusted(12, 12, -12, -12), flags, words)
        else:
            _paint(painter, self.shown, QRectF(self.rect()), theme)
        painter.end()


def _paint(painter: QPainter, shown: CoverageShown, area: QRectF, theme: Theme) -> None:
    width, height = shown.size
    room = area.adjusted(1.0, 1.0, -1.0, -_ROOM)
    scale = min(room.width() / width, room.height() / height)
    image = QRectF(0.0, 0.0, scale * width, scale * height)
    image.moveCenter(room.center())
    image.moveTop(room.top())
    painter.fillRect(image, QColor(theme.base))
    rows, columns = shown.cells.shape
    reached = QColor(theme.good)
    reached.setAlpha(70)
    for row, column in np.argwhere(shown.cells).tolist():
        cell = QRectF(
            image.left() + column * image.width() / columns,
            image.top() + row * image.height() / rows,
            image.width() / columns,
            image.height() / rows,
        )
        painter.fillRect(cell, reached)
    painter.setPen(QPen(QColor(theme.border), 1.0))
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.drawRect(image)
    painter.setPen(QPen(QColor(theme.text), 1.6))
    at = (shown.corners + 0.5) * scale + (image.left(), image.top())
    painter.drawPoints([QPointF(x, y) for x, y in at])
    painter.setPen(QColor(theme.muted))
    words = QRectF(area.left(), image.bottom() + 2.0, area.width(), _ROOM - 4.0)
    cut = painter.fontMetrics().elidedText(
        shown.title, Qt.TextElideMode.ElideRight, int(words.width())
    )
    painter.drawText(words, Qt.AlignmentFlag.AlignCenter, cut)
