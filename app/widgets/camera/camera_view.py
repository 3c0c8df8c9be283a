"""One picture with its overlays: zoom at the cursor, pan, loupe, what is under the cursor."""

from collections.abc import Callable
from math import hypot

from PySide6 import QtGui
from PySide6.QtCore import QEvent, QLineF, QPointF, QRectF, Qt, Signal
from PySide6.QtWidgets import QWidget

from ..redraw import RedrawQueue
from ..style.theme import current_theme
from .click_marks import ClickAct, ClickMarks, Offer
from .click_painting import paint_crosshair, paint_marks, paint_notes
from .cursor import ClickHand, CursorLabel, loupe, loupe_size
from .overlays import paint_overlay
from .picture import Picture, PictureView, alike

_CLICK_PIXELS = 4
_SNAPS = 6.0  # widget pixels from which the crosshair moves onto an epipolar curve
_COMPUTED = (
    "Clicks are placed in camera images, and this image is computed. Show the reference image "
    "(Shift+F2) or the left image (F2)."
)


_REASONS = Qt.FocusReason
_BY_KEYS = {_REASONS.TabFocusReason, _REASONS.BacktabFocusReason, _REASONS.ShortcutFocusReason}


class ViewActs(QWidget):
    """Parent of all views: what a person does in any of them is told here."""

    hovered = Signal(str)  # words about the pixel under the cursor; empty when the cursor leaves
    activated = Signal(str)  # name of the view that keys shall act on
    at_hand_changed = Signal(str)
    """Name of the view that a click goes to, and keys about clicks act on."""
    clicked = Signal(object)  # action that a click in a view means, if `set_clicking` allows clicks
    refused = Signal(str)  # why a click was not taken

    def __init__(self, redraw: RedrawQueue, choose_limb: Callable[[str], object]) -> None:
        super().__init__()
        self.redraw, self.choose_limb = redraw, choose_limb
        self.clicking, self.why_no_clicks = False, ""
        self._at_hand = ""

    def point_at(self, name: str) -> None:
        """Let clicks go to the view that the mouse is over."""
        if name != self._at_hand:
            self._at_hand = name
            self.at_hand_changed.emit(name)


class CameraView(PictureView):
    """Paints one :class:`Picture`."""

    def __init__(self, name: str, acts: ViewActs) -> None:
        super().__init__(acts.redraw, acts)
        self._name, self._acts = name, acts
        self._cursor: QPointF | None = None
        self._drag: tuple[QPointF, QPointF] | None = None
        self._dragged = False
        self._marks: ClickMarks | None = None
        self._hand = ClickHand(self)
        self.crosshair: QPointF | None = None
        """Raw pixel at which a key places a landmark; None: no crosshair is shown."""
        self.label = CursorLabel(self)
        self.setMouseTracking(True)
        self._by_keys = False
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)

    @property
    def marks(self) -> ClickMarks | None:
        """Clicks and what belongs to them, if they are of the picture that is shown."""
        marks, shown = self._marks, self.picture
        if marks is None or shown is None:
            return None
        return marks if (marks.frame, marks.camera) == (shown.frame, shown.camera) else None

    def show_picture(self, picture: Picture) -> None:
        super().show_picture(picture)
        self._show_cursor()
        self._tell_hover()

    def set_marks(self, marks: ClickMarks | None) -> None:
        """Draw clicks; those of another frame or camera than the picture's wait for theirs."""
        before, self._marks = self._marks, marks
        if alike(before, marks):
            return
        at_once = marks and before and not before.clicks and len(marks.clicks) > 1
        if marks is None or before is None or marks.frame != before.frame or at_once:
            self._keep_person()  # never while clicks are placed in the frame that is shown
        self._show_cursor()
        self._stale = True
        self._redraw.soon(self._paint_other)

    def set_crosshair(self, pixel: QPointF | None) -> None:
        if pixel != self.crosshair:
            self.crosshair = pixel
            self.update()

    def move_crosshair(self, x: float, y: float) -> None:
        """Move the crosshair by so many widget pixels, and onto an epipolar curve that is near.

        A step of one pixel stays where it leads.
        """
        if self.crosshair is None:
            return
        scale, (across, down) = self._scale(), self.raw_direction(x, y)
        pixel = self.crosshair + QPointF(across, down) / scale
        near = self.marks.on_curve(pixel) if self.marks is not None and hypot(x, y) > 1.0 else None
        if near is not None and QLineF(near, pixel).length() * scale <= _SNAPS:
            pixel = near
        if self.inside(pixel):
            self.set_crosshair(pixel)

    def person_box(self) -> QRectF | None:
        """Where run, reference, clicks or the model fitted to them show a person."""
        marks, box = self.marks, super().person_box()
        clicked = marks.person_box() if marks is not None else None
        return box.united(clicked) if box is not None and clicked is not None else box or clicked

    def drop_click(self) -> None:
        """Place nothing by the button that is held; other clicks are allowed from now on."""
        self._hand.let_go()
        self._show_cursor()

    def why_no_clicks(self) -> str:
        """Why this picture takes no clicks now, as a sentence; empty where it does."""
        if self.picture is not None and not self.picture.camera:
            return _COMPUTED
        return self._acts.why_no_clicks

    def paintEvent(self, _event: QtGui.QPaintEvent) -> None:
        theme = current_theme()
        painter = QtGui.QPainter(self)
        painter.fillRect(self.rect(), QtGui.QColor(theme.scene_bottom))
        if not any(self._size()):
            self._paint_message(painter, QtGui.QColor(theme.muted))
        else:
            self._paint_picture(painter, self._to_widget())
            if self._display.loupe and self._cursor is not None:
                size, rim = loupe_size(QRectF(self.rect())), QtGui.QColor(theme.accent)
                with loupe(painter, self._cursor, size, self._scale(), rim) as enlarge:
                    self._paint_picture(painter, self._to_widget() * enlarge)
            area, overlay = QRectF(self.rect()), self.picture and self.picture.overlay
            paint_notes(
                painter, self.marks, self._display.overlays, area,
                reference_is_old=bool(overlay and overlay.reference_is_old),
            )  # fmt: skip
        if self._by_keys:
            painter.setPen(QtGui.QPen(QtGui.QColor(theme.accent), 4.0))
            painter.drawRect(self.rect())
        painter.end()
        self.painted, self._stale = self.picture, False

    def _paint_picture(self, painter: QtGui.QPainter, transform: QtGui.QTransform) -> None:
        if self.picture is None or self.picture.pixels is None:
            return
        painter.save()
        painter.setTransform(transform, True)
        # enlarged pixels stay squares, so that one sees what was measured
        small = hypot(transform.m11(), transform.m12()) < 3.0
        painter.setRenderHint(QtGui.QPainter.RenderHint.SmoothPixmapTransform, small)
        painter.drawImage(QPointF(-0.5, -0.5), self._image_of(self.picture.pixels))
        painter.restore()
        shown = self._display.overlays
        paint_overlay(painter, self.picture.overlay, shown, self._display.highlighted, transform)
        if (marks := self.marks) is None:
            return
        if (preview := self._hand.preview()) is not None:
            marks = marks.with_moved(preview[0], preview[1].x(), preview[1].y())
        paint_marks(painter, marks, transform, shown, QRectF(self.rect()))
        if self.crosshair is not None:
            paint_crosshair(painter, transform.map(self.crosshair), marks.offer.colour)

    def wheelEvent(self, event: QtGui.QWheelEvent) -> None:
        if event.angleDelta().y():
            self.zoom_by(1.2 ** (event.angleDelta().y() / 120.0), event.position())
            self._show_cursor()
        event.accept()

    def mousePressEvent(self, event: QtGui.QMouseEvent) -> None:
        self._cursor = event.position()
        self._acts.point_at(self._name)
        self._acts.activated.emit(self._name)
        left, marks = event.button() == Qt.MouseButton.LeftButton, self.marks
        if left and self._acts.clicking:
            why_not = self.why_no_clicks()
            if why_not or marks is None:
                self._acts.refused.emit(why_not or "Loading image …")
            else:
                self._hand.press(event.position(), marks)
                self.update()
        elif left or event.button() in {Qt.MouseButton.MiddleButton, Qt.MouseButton.RightButton}:
            self._hand.let_go()
            self._drag = (event.position(), event.position())
            self._dragged = False

    def mouseMoveEvent(self, event: QtGui.QMouseEvent) -> None:
        self._cursor = event.position()
        self._acts.point_at(self._name)
        if self._drag is not None:
            start, last = self._drag
            if (event.position() - start).manhattanLength() > _CLICK_PIXELS or self._dragged:
                self._dragged = self._by_hand = True
                self._at_home = False
                self._pan(event.position() - last)
                if self.zoom > 1.0:
                    self.setCursor(Qt.CursorShape.ClosedHandCursor)
            self._drag = (start, event.position())
        if self._hand.busy:
            self._hand.move(event.position())
            self._say_offer()
            self.update()
        elif self._drag is None:
            self._show_cursor()
        self._tell_hover()
        if self._display.loupe:
            self.update()

    def mouseReleaseEvent(self, event: QtGui.QMouseEvent) -> None:
        if self._hand.busy and event.button() == Qt.MouseButton.LeftButton:
            marks, dragged = self.marks, self._hand.dragging
            if marks is not None:
                done = self._hand.release(event.position(), marks, event.modifiers())
                if done is not None:
                    self._do(done, marks)
                elif not dragged and not marks.offer.landmark:
                    self._acts.refused.emit(f"{marks.offer.words.capitalize()}.")
            self._hand.let_go()
            self.update()
        elif self._drag is not None and not self._dragged:
            self._click_without_hand(event)
        self._drag = None
        self._show_cursor()

    def _do(self, act: ClickAct, marks: ClickMarks) -> None:
        """Draw what a person has done at once, and tell of it; what is refused goes again.

        Storing it, and finding out what follows from it, takes several times as long as a person
        should wait for an answer.
        """
        drawn = self._marks = marks.with_act(act)
        self.repaint()
        self._acts.clicked.emit(act)
        if self._marks is drawn:
            self.set_marks(marks)

    def _click_without_hand(self, event: QtGui.QMouseEvent) -> None:
        """A click that places nothing: it selects a limb, or with the right button a click."""
        marks, button = self.marks, event.button()
        if not self._acts.clicking and button == Qt.MouseButton.LeftButton:
            self._acts.choose_limb(self._limb_at(event.position()))
        elif self._acts.clicking and button == Qt.MouseButton.RightButton and marks is not None:
            mark = self._hand.mark_at(event.position(), marks)
            if mark is not None:
                self._acts.clicked.emit(ClickAct("pick", marks.key(mark.landmark)))

    def mouseDoubleClickEvent(self, event: QtGui.QMouseEvent) -> None:
        if self._acts.clicking and event.button() == Qt.MouseButton.LeftButton:
            return  # the first of both has placed something; a second click would move it
        self.fit()

    def focusInEvent(self, event: QtGui.QFocusEvent) -> None:
        self._by_keys = event.reason() in _BY_KEYS
        if self._by_keys:
            self._acts.activated.emit(self._name)
        super().focusInEvent(event)

    def focusOutEvent(self, event: QtGui.QFocusEvent) -> None:
        self._by_keys = False
        super().focusOutEvent(event)

    def _show_cursor(self) -> None:
        """The cursor and what is written beside it say what the left button would do."""
        self._say_offer()
        if not self._acts.clicking or not any(self._size()):
            self.unsetCursor()
        elif self.why_no_clicks():
            self.setCursor(Qt.CursorShape.ForbiddenCursor)
        else:
            marks, place = self.marks, self._cursor
            handle = marks is not None and place is not None and self._hand.handle_at(place, marks)
            self.setCursor(Qt.CursorShape.SizeAllCursor if handle else Qt.CursorShape.CrossCursor)

    def _say_offer(self) -> None:
        marks, cursor = self.marks, self._cursor
        moving = self._drag is not None or self._hand.dragging
        offer = Offer()
        if self._acts.clicking and marks is not None and cursor is not None and not moving:
            there = self.inside(self.pixel_at(cursor)) and not self.why_no_clicks()
            offer = self._hand.offer_at(cursor, marks) if there else offer
        if cursor is None or not offer.words:
            self.label.hide()
            return
        clear = 0.5 * loupe_size(QRectF(self.rect())) if self._display.loupe else 0.0
        self.label.say(offer.words, offer.colour, cursor, clear)

    def enterEvent(self, event: QtGui.QEnterEvent) -> None:
        self._cursor = event.position()
        self._acts.point_at(self._name)
        self._show_cursor()
        self._tell_hover()

    def leaveEvent(self, _event: QEvent) -> None:
        self._cursor = None
        self._say_offer()
        self._acts.hovered.emit("")
        self.update()

    def _limb_at(self, position: QPointF) -> str:
        if self.picture is None:
            return ""
        pixel, overlay = self.pixel_at(position), self.picture.overlay
        nearest_last = {shape.limb: place for place, shape in enumerate(overlay.shapes)}
        hit = [limb for limb, path in overlay.paths if path.contains(pixel)]
        return max(hit, key=nearest_last.__getitem__, default="")

    def _tell_hover(self) -> None:
        if self._cursor is None or self.picture is None or not any(self._size()):
            return
        pixel, words = self.pixel_at(self._cursor), ""
        if self.inside(pixel):
            value = self.picture.value_at(pixel.x(), pixel.y())
            words = f"{self._name}  x {pixel.x():.1f}  y {pixel.y():.1f}  {value}"
        self._acts.hovered.emit(words)
