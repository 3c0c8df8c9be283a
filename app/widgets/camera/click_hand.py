"""The mouse over a picture that takes clicks: place, pick, drag."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeVar

from PySide6.QtCore import QLineF, QPointF, Qt

from .click_marks import ClickAct, ClickMark, ClickMarks, Offer, PredictionMark
from .picture import PictureView

HANDLE = 12.0  # widget pixels around a click within which it can be dragged
_STILL = 3.0
_Mark = TypeVar("_Mark", ClickMark, PredictionMark)


@dataclass(frozen=True)
class _Press:
    start: QPointF
    now: QPointF
    mark: ClickMark | PredictionMark | None
    offset: QPointF
    dragging: bool


class ClickHand:
    """From presses and moves of the left button to what they mean.

    A press within :data:`HANDLE` of a click that moves drags it; a proposal that is dragged becomes
    a click where it is dropped. A press that stays places the
    landmark that is offered, be it on another one's click: hands do lie on elbows. Only when that
    has been clicked in this picture already, or everything has, a press on a handle picks that
    click; with Ctrl it places even then.
    """

    def __init__(self, ground: PictureView) -> None:
        self._ground = ground
        self._press: _Press | None = None

    @property
    def dragging(self) -> bool:
        return self._press is not None and self._press.dragging

    @property
    def busy(self) -> bool:
        return self._press is not None

    def preview(self) -> tuple[str, QPointF] | None:
        press = self._press
        if press is None or press.mark is None or not press.dragging:
            return None
        return press.mark.landmark, self._ground.pixel_at(press.now - press.offset)

    def press(self, position: QPointF, marks: ClickMarks) -> None:
        mark = self.handle_at(position, marks)
        place = self._ground.place_of(mark.x, mark.y) if mark is not None else position
        self._press = _Press(position, position, mark, position - place, dragging=False)

    def move(self, position: QPointF) -> None:
        press = self._press
        if press is not None:
            far = (position - press.start).manhattanLength() > _STILL
            self._press = replace(press, now=position, dragging=press.dragging or far)

    def let_go(self) -> None:
        self._press = None

    def release(
        self, position: QPointF, marks: ClickMarks, modifiers: Qt.KeyboardModifier
    ) -> ClickAct | None:
        """What was done; None for nothing, as outside the picture."""
        self.move(position)
        press, self._press = self._press, None
        if press is None:
            return None
        anyway = bool(modifiers & Qt.KeyboardModifier.ControlModifier)
        if press.mark is not None and press.dragging and not anyway:
            pixel = self._ground.pixel_at(press.now - press.offset)
            if not self._ground.inside(pixel):
                return None
            key, moves = marks.key(press.mark.landmark), isinstance(press.mark, ClickMark)
            return ClickAct("move" if moves else "place", key, (pixel.x(), pixel.y()))
        offer = marks.offer
        if isinstance(press.mark, ClickMark) and not anyway and offer.picks:
            return ClickAct("pick", marks.key(press.mark.landmark))
        pixel = self._ground.pixel_at(position)
        if not self._ground.inside(pixel) or not offer.landmark:
            return None
        # with Shift the landmark is behind something
        shift = modifiers & Qt.KeyboardModifier.ShiftModifier
        key = marks.key(offer.landmark)
        return ClickAct("guess" if shift else "place", key, (pixel.x(), pixel.y()))

    def offer_at(self, position: QPointF, marks: ClickMarks) -> Offer:
        if marks.offer.picks and (mark := self.mark_at(position, marks)):
            return Offer(words=f"{mark.label}: click to select, drag to move", colour=mark.colour)
        return marks.offer

    def handle_at(self, position: QPointF, marks: ClickMarks) -> ClickMark | PredictionMark | None:
        """What can be dragged from a place in the widget: a click, else a proposal."""
        clicked = {mark.landmark for mark in marks.clicks}
        open_ones = [m for m in marks.predictions if m.proposed and m.landmark not in clicked]
        return self.mark_at(position, marks) or self._nearest(position, open_ones)

    def mark_at(self, position: QPointF, marks: ClickMarks) -> ClickMark | None:
        """The nearest click whose handle is under a place in the widget."""
        return self._nearest(position, marks.clicks)

    def _nearest(self, position: QPointF, marks: Sequence[_Mark]) -> _Mark | None:
        nearest = min(marks, key=partial(self._distance, position), default=None)
        far = nearest is None or self._distance(position, nearest) > HANDLE
        return None if far else nearest

    def _distance(self, position: QPointF, mark: ClickMark | PredictionMark) -> float:
        return QLineF(position, self._ground.place_of(mark.x, mark.y)).length()
