"""What is drawn of clicks over one camera's picture, and what a person does there."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import nan
from typing import Literal

import numpy as np
from PySide6.QtCore import QPointF, QRectF
from PySide6.QtGui import QPainterPath, QPolygonF

from stereotrack_core.annotation.click import ClickKey
from stereotrack_core.arrays import FloatArray


@dataclass(frozen=True)
class ClickMark:
    """A landmark as a person has placed it in this picture."""

    landmark: str
    label: str
    colour: str
    x: float
    y: float  # `x` and `y`: raw pixels
    guessed: bool = False
    doubted: bool = False
    accepted: bool = False
    outlier: bool = False
    """`guessed`, `doubted`, `accepted` and `outlier`: guessed behind something; flagged as
    uncertain; was a prediction; the fit takes it for an outlier."""
    chosen: bool = False
    at_hand: bool = False
    held: bool = False
    """`chosen`, `at_hand` and `held`: whether clicking places this landmark; keys act on this
    click; Alt+arrows move it."""


@dataclass(frozen=True)
class PredictionMark:
    """A landmark as the program would place it."""

    landmark: str
    label: str
    colour: str
    x: float
    y: float
    error_px: float = nan  # how far the click is from it; NaN without a click
    spread_px: float = nan  # standard deviation of the place
    chosen: bool = False
    proposed: bool = False
    """For this frame, to be accepted or dragged; else it is known from elsewhere."""
    guessed: bool = False  # hidden in the nearest clicked frames
    opacity: float = 1.0
    certain: bool = True
    """Whether it is within the limit of sigma up to which predictions are accepted."""


@dataclass(frozen=True, eq=False)
class CurveMark:
    """Where a landmark that was clicked in another view can be; (K, 2) raw pixels."""

    colour: str
    from_view: str
    points: FloatArray


@dataclass(frozen=True, eq=False)
class LimbMark:
    """Outline of a limb of the fitted model, raw pixels; the less is known of it the fainter."""

    limb: str
    path: QPainterPath
    opacity: float = 1.0


@dataclass(frozen=True)
class ResidualMark:
    """From a click to the place of its landmark on the fitted model; raw pixels."""

    colour: str
    start: tuple[float, float]
    end: tuple[float, float]


@dataclass(frozen=True)
class Offer:
    """What the next click in a picture does."""

    landmark: str = ""  # what it places; empty: it places nothing
    words: str = ""
    colour: str = ""  # `#rrggbb` of the landmark's limb; empty where nothing is placed
    moves: bool = False  # the landmark is clicked here already, so that the click moves it

    @property
    def picks(self) -> bool:
        """Whether a click on a click takes that one in hand, as none is to be placed there."""
        return self.moves or not self.landmark


@dataclass(frozen=True, eq=False)
class ClickMarks:
    """Everything about clicks that is drawn over one picture."""

    frame: int
    camera: str
    clicks: tuple[ClickMark, ...] = ()
    predictions: tuple[PredictionMark, ...] = ()
    curves: tuple[CurveMark, ...] = ()
    residuals: tuple[ResidualMark, ...] = ()
    model: tuple[LimbMark, ...] = ()
    model_is_old: bool = False  # whether the model was fitted before the last click
    outside: tuple[str, ...] = ()  # labels of landmarks that a person says are not in the picture
    proposed_outside: tuple[str, ...] = ()
    """Labels of landmarks that are proposed as outside, as in the nearest clicked frames."""
    offer: Offer = Offer()

    def key(self, landmark: str) -> ClickKey:
        return ClickKey(self.frame, self.camera, landmark)

    def on_curve(self, pixel: QPointF) -> QPointF | None:
        """The point of the epipolar curves that is nearest to a raw pixel; None without curves."""
        place, none = np.array(pixel.toTuple()), np.empty((0, 2))
        start = np.concatenate([none, *(curve.points[:-1] for curve in self.curves)])
        way = np.concatenate([none, *(np.diff(curve.points, axis=0) for curve in self.curves)])
        length = np.maximum(np.square(way).sum(axis=1), 1e-12)
        share = np.clip(((place - start) * way).sum(axis=1) / length, 0.0, 1.0)
        nearest = start + share[:, None] * way
        away = np.linalg.norm(nearest - place, axis=1)
        return QPointF(*nearest[np.nanargmin(away)]) if np.isfinite(away).any() else None

    def person_box(self) -> QRectF | None:
        """Box around the clicks and the model that is fitted to them, in pixels."""
        places = [QPointF(mark.x, mark.y) for mark in self.clicks]
        box = QPolygonF(places).boundingRect() if len(places) > 1 else QRectF()
        for mark in self.model:
            box = box.united(mark.path.boundingRect())
        return box if box.isValid() else None

    def with_moved(self, landmark: str, x: float, y: float) -> ClickMarks:
        """The same while a click or proposal is being dragged; its residual is left out."""
        clicks = tuple(
            replace(mark, x=x, y=y) if mark.landmark == landmark else mark for mark in self.clicks
        )
        moved = next((mark for mark in self.clicks if mark.landmark == landmark), None)
        start = (moved.x, moved.y) if moved is not None else None
        residuals = tuple(one for one in self.residuals if one.start != start)
        predictions = tuple(
            replace(mark, x=x, y=y) if mark.proposed and mark.landmark == landmark else mark
            for mark in self.predictions
        )
        return replace(self, clicks=clicks, residuals=residuals, predictions=predictions)

    def with_act(self, act: ClickAct) -> ClickMarks:
        """The same once a person has placed or moved a click, before anybody has stored it."""
        name, offer, guessed = act.key.landmark, self.offer, act.what == "guess"
        if act.what == "pick":
            return self
        if any(mark.landmark == name for mark in self.clicks):
            return self.with_moved(name, *act.pixel)
        mark = ClickMark(name, offer.words, offer.colour, *act.pixel, guessed=guessed, chosen=True)
        predictions = tuple(one for one in self.predictions if one.landmark != name)
        return replace(self, clicks=(*self.clicks, mark), predictions=predictions)


@dataclass(frozen=True)
class ClickAct:
    """What a person does with a click: place it, also as a guess, drag it, or pick it."""

    what: Literal["place", "guess", "move", "pick"]
    key: ClickKey
    pixel: tuple[float, float] = (nan, nan)  # raw pixel where it comes to
