"""Edits of clicks: place, move, take away, flag, swap, accept predictions."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

from stereotrack_core.annotation.click import Click, ClickKey, Visibility
from stereotrack_core.annotation.prediction import Prediction
from stereotrack_core.errors import InputError
from stereotrack_core.project.clicks import click_in, place_in_words, taken_away, values_of
from stereotrack_core.project.edit import Change, Edit, Stamp, State
from stereotrack_core.project.schema import CLICK, REPEAT_CLICK, Row, Table


@dataclass(frozen=True)
class PlaceClicks(Edit):
    """Set clicks, whether the landmarks had one before or not.

    Attributes
    ----------
    clicks : tuple of Click
        Those without author and time get the project's.
    text : str
        What it does in words; empty: told from the clicks.
    """

    kind: ClassVar[str] = "place clicks"
    clicks: tuple[Click, ...]
    text: str = ""

    def words(self) -> str:
        """``place left elbow in N_right, frame 213``."""
        return self.text or f"place {place_in_words([click.key for click in self.clicks])}"

    def changes(self, state: State, stamp: Stamp) -> Iterable[Change]:
        """Every click's row."""
        for click in self.clicks:
            yield _set(state, click, stamp)


def place(click: Click) -> PlaceClicks:
    """Set one click."""
    return PlaceClicks((click,))


@dataclass(frozen=True)
class MoveClicks(Edit):
    """Move existing clicks in their image (drag, nudge); repeated moves can become one edit.

    Whatever they came from, they are a person's own then.

    Attributes
    ----------
    keys : tuple of ClickKey
    by : (float, float)
        Pixels.
    """

    kind: ClassVar[str] = "move clicks"
    keys: tuple[ClickKey, ...]
    by: tuple[float, float]

    def __post_init__(self) -> None:
        if not all(map(math.isfinite, self.by)):
            raise ValueError(f"{self.by} is not a displacement in an image")

    def words(self) -> str:
        """``move left elbow in N_right, frame 213``."""
        return f"move {place_in_words(self.keys)}"

    def changes(self, state: State, stamp: Stamp) -> Iterable[Change]:
        """The rows of clicks that have a position."""
        for click in _present(state, self.keys):
            if click.position is not None:
                x, y = click.position
                moved = replace(click, position=(x + self.by[0], y + self.by[1]), origin="hand")
                yield _restated(state, moved, stamp)


@dataclass(frozen=True)
class DeleteClicks(Edit):
    """Take clicks away; that they were taken away is kept as a fact. Missing ones are passed."""

    kind: ClassVar[str] = "delete clicks"
    keys: tuple[ClickKey, ...]

    def words(self) -> str:
        """``delete left elbow in 4 cameras, frame 213``."""
        return f"delete {place_in_words(self.keys)}"

    def changes(self, state: State, stamp: Stamp) -> Iterable[Change]:
        """The rows of clicks that are there."""
        for click in _present(state, self.keys):
            yield _restated(state, taken_away(click), stamp)


@dataclass(frozen=True)
class MarkClicks(Edit):
    """State how existing clicks are seen, how sure they are, or flag them.

    Attributes
    ----------
    keys : tuple of ClickKey
    visibility : Visibility, optional
        Outside takes the position away.
    flag : str, optional
        Empty: no flag.
    sigma : float, optional
        Pixels per axis; ``usual_sigma`` takes a stated one away.
    """

    kind: ClassVar[str] = "mark clicks"
    keys: tuple[ClickKey, ...]
    visibility: Visibility | None = None
    flag: str | None = None
    sigma: float | None = None
    usual_sigma: bool = False

    def __post_init__(self) -> None:
        if self.sigma is not None and not 0 < self.sigma < math.inf:
            raise InputError(
                f"{self.sigma:g} px is not a valid click uncertainty",
                remedy="Enter a number above 0.",
            )

    def words(self) -> str:
        """``mark left elbow in N_right, frame 213, as guessed``."""
        said = [
            "" if self.visibility is None else self.visibility.name.lower(),
            "" if self.flag is None else self.flag or "not flagged",
            "" if self.sigma is None else f"uncertainty {self.sigma:g} px",
            "usual uncertainty" if self.usual_sigma else "",
        ]
        return f"mark {place_in_words(self.keys)}, as {', '.join(filter(None, said))}"

    def changes(self, state: State, stamp: Stamp) -> Iterable[Change]:
        """The rows of clicks that are there.

        Raises
        ------
        InputError
            Where a landmark outside the image shall be seen: nobody knows where.
        """
        for click in _present(state, self.keys):
            visibility = click.visibility if self.visibility is None else self.visibility
            outside = visibility == Visibility.OUTSIDE
            if click.position is None and not outside:
                raise InputError(
                    f"{place_in_words([click.key])} is outside the image and has no position",
                    remedy="Click its position instead.",
                )
            sigma = click.sigma if self.sigma is None else self.sigma
            marked = replace(
                click,
                position=None if outside else click.position,
                visibility=visibility,
                flag=click.flag if self.flag is None else self.flag,
                sigma=None if self.usual_sigma else sigma,
            )
            yield _restated(state, marked, stamp)


@dataclass(frozen=True)
class SwapLandmarks(Edit):
    """Exchange the clicks of two landmarks in one image (left and right mixed up).

    A landmark that the image has no click of takes over the other's; the other is deleted then.
    """

    kind: ClassVar[str] = "swap landmarks"
    frame: int
    camera: str
    first: str
    second: str

    def words(self) -> str:
        """``swap left elbow and right elbow in N_right, frame 213``."""
        names = f"{self.first} and {self.second}".replace("_", " ")
        return f"swap {names} in {self.camera}, frame {self.frame}"

    def changes(self, state: State, stamp: Stamp) -> Iterable[Change]:
        """The rows of both."""
        keys = [ClickKey(self.frame, self.camera, name) for name in (self.first, self.second)]
        found = [next(iter(_present(state, [key])), None) for key in keys]
        for here, there in ((0, 1), (1, 0)):
            click, own = found[there], found[here]
            if click is not None:
                yield _restated(state, replace(click, landmark=keys[here].landmark), stamp)
            elif own is not None:
                yield _restated(state, taken_away(own), stamp)


@dataclass(frozen=True)
class PlaceRepeats(Edit):
    """Set clicks of a second, blind reading; the first reading is not touched.

    Attributes
    ----------
    round : int
        Which repetition, from 1.
    clicks : tuple of Click
        Deleted ones take a click of this reading away.
    """

    kind: ClassVar[str] = "place repeats"
    round: int
    clicks: tuple[Click, ...]

    def words(self) -> str:
        """``place left elbow in N_right, frame 213, again``."""
        return f"place {place_in_words([click.key for click in self.clicks])}, blind repeat"

    def changes(self, state: State, stamp: Stamp) -> Iterable[Change]:
        """Every click's row.

        Raises
        ------
        InputError
            Where the round is not counted from 1.
        """
        if self.round < 1:
            raise InputError(
                f"there is no blind repeat {self.round}", remedy="Blind repeats are counted from 1."
            )
        for click in self.clicks:
            key: Row = (self.round, *click.key)
            yield state.change(REPEAT_CLICK, key, values_of(click, stamp))


def _present(state: State, keys: Sequence[ClickKey], table: Table = CLICK) -> Iterable[Click]:
    """The clicks of these keys that are there and not deleted."""
    for key in keys:
        values = state.row(table, key)
        if values is not None and not (click := click_in(key, values)).deleted:
            yield click


def _restated(state: State, click: Click, stamp: Stamp) -> Change:
    """The change to a click by whoever makes the edit."""
    return _set(state, replace(click, who="", at=""), stamp)


def _set(state: State, click: Click, stamp: Stamp) -> Change:
    """The change that lets `click` stand, unless it says what stands there."""
    before = state.row(CLICK, click.key)
    if before is not None and click_in(click.key, before).says_the_same(click):
        return Change(CLICK, click.key, before, before)
    return Change(CLICK, click.key, before, values_of(click, stamp))


@dataclass(frozen=True)
class AcceptPredictions(Edit):
    """Let predictions be clicks, noted as accepted; where a person has clicked, that click stays.

    Attributes
    ----------
    predictions : tuple of Prediction
        Of several for one landmark in one image the last one counts.
    even_deleted : bool
        Also where somebody has taken a click away; for a single prediction that was looked at.
    """

    kind: ClassVar[str] = "accept predictions"
    predictions: tuple[Prediction, ...]
    even_deleted: bool = False

    def words(self) -> str:
        """``accept left elbow in N_right, frame 213``."""
        return f"accept {place_in_words([one.key for one in self.predictions])}"

    def changes(self, state: State, stamp: Stamp) -> Iterable[Change]:
        """The rows of landmarks that nobody has clicked."""
        for prediction in self.predictions:
            before = state.row(CLICK, prediction.key)
            if before is not None:
                there = click_in(prediction.key, before)
                if not (there.deleted and self.even_deleted):
                    continue
            click = Click(*prediction.key, prediction.position, origin="accepted")
            yield Change(CLICK, prediction.key, before, values_of(click, stamp))
