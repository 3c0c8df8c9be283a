"""The cells of a film strip: rows are views, columns are frames."""

from collections.abc import Callable, Mapping, Sequence

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QImage, QMouseEvent, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QWidget

from stereotrack_core.evaluation.failure_segments.film import FilmCell

from ..style.theme import current_theme
from .picture import image_of

_HEAD, _NAME, _GAP = 18, 22, 3  # pixels for frame numbers and names of views, and between cells
_CROSS = 5.0


class FilmView(QWidget):
    """Paints cells as large as there is room.

    `clicked` is called with a cell and the pixel of its camera's image that a person has clicked.
    """

    def __init__(self, clicked: Callable[[FilmCell, tuple[float, float]], object]) -> None:
        super().__init__()
        self._clicked = clicked
        self._cells: tuple[FilmCell, ...] = ()
        self._images: dict[tuple[FilmCell, int], QImage] = {}
        self._marks: Mapping[tuple[str, int], Sequence[tuple[float, float]]] = {}
        self._shown, self._frame = 0, -1
        self.setAccessibleName("Film strip")
        self.setMinimumSize(200, 120)

    def show_cells(self, cells: Sequence[FilmCell]) -> None:
        """Show other cells, view by view and in each by frames."""
        self._cells, self._images = tuple(cells), {}
        self.update()

    def show_layer(self, layer: int) -> None:
        """Show the pictures of one run, or of the reference."""
        self._shown = layer
        self.update()

    def show_marks(
        self, frame: int, marks: Mapping[tuple[str, int], Sequence[tuple[float, float]]]
    ) -> None:
        """Show the present frame, and clicks by camera and frame as pixels."""
        if (frame, marks) != (self._frame, self._marks):
            self._frame, self._marks = frame, marks
            self.update()

    def area_of(self, cell: FilmCell) -> QRectF:
        """Where a cell stands."""
        rows = list(dict.fromkeys(one.view for one in self._cells))
        columns = list(dict.fromkeys(one.frame for one in self._cells))
        room = (self.width() - _NAME) / len(columns), (self.height() - _HEAD) / len(rows)
        side = max(min(room) - _GAP, 1.0)
        left = _NAME + columns.index(cell.frame) * (side + _GAP)
        return QRectF(left, _HEAD + rows.index(cell.view) * (side + _GAP), side, side)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        if event.button() != Qt.MouseButton.LeftButton:
            return
        for cell in self._cells:
            area = self.area_of(cell)
            if area.contains(event.position()):
                place = (event.position() - area.topLeft()) / area.width()
                self._clicked(cell, cell.pixel_at(place.x(), place.y()))
                return

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter, theme = QPainter(self), current_theme()
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        centre = Qt.AlignmentFlag.AlignCenter
        for cell in self._cells:
            area = self.area_of(cell)
            painter.drawImage(area, self._image(cell))
            here = cell.frame == self._frame
            painter.setPen(QColor(theme.playhead if here else theme.muted))
            if cell.view == self._cells[0].view:
                head = QRectF(area.left(), 0, area.width(), _HEAD)
                painter.drawText(head, centre, str(cell.frame))
            if cell.frame == self._cells[0].frame:
                painter.drawText(QRectF(0, area.top(), _NAME, area.height()), centre, cell.view)
            if here:
                painter.drawRect(area)
            for pixel in self._marks.get((cell.camera, cell.frame), ()):
                self._paint_mark(painter, area, cell.place_of(pixel))

    def _paint_mark(self, painter: QPainter, area: QRectF, place: tuple[float, float]) -> None:
        at = area.topLeft() + QPointF(place[0] * area.width(), place[1] * area.height())
        if area.contains(at):
            for colour, width in (("black", 3.0), ("white", 1.4)):
                painter.setPen(QPen(QColor(colour), width))
                painter.drawLine(at - QPointF(_CROSS, 0), at + QPointF(_CROSS, 0))
                painter.drawLine(at - QPointF(0, _CROSS), at + QPointF(0, _CROSS))

    def _image(self, cell: FilmCell) -> QImage:
        layer = min(self._shown, len(cell.pictures) - 1)
        if (cell, layer) not in self._images:
            self._images[cell, layer] = image_of(cell.pictures[layer]).copy()
        return self._images[cell, layer]
