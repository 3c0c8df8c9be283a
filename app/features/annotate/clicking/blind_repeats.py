"""Frames that are annotated a second time, without showing what was clicked the first time."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import chain

from stereotrack_core.annotation.agreement import next_repeat
from stereotrack_core.annotation.click import ACCEPTED, Click, ClickKey, Visibility
from stereotrack_core.project.clicks import (
    AcceptPredictions,
    DeleteClicks,
    MarkClicks,
    MoveClicks,
    PlaceClicks,
    PlaceRepeats,
    SwapLandmarks,
)
from stereotrack_core.project.edit import Edit, Together
from stereotrack_core.project.project import Project

from ....session.counting import counted

USUAL_SHARE = 0.05
"""Part of the frames that is annotated again where this is switched on."""

_SHARE, _FRAME = "repeats.share", "repeats.frame"
_ROUND = 1


@dataclass(frozen=True)
class Repeat:
    """A frame that is being annotated again.

    Attributes
    ----------
    frame : int
    round : int
        Which repetition, from 1.
    """

    frame: int
    round: int


class BlindRepeats:
    """Weaves finished frames in again, and keeps their second reading apart from the first.

    What is under way is kept in the project, so that the first reading stays hidden when the
    program was closed in between.
    """

    def __init__(self, project: Project) -> None:
        self._project = project
        frame = project.view_settings.get(_FRAME)
        self._active = Repeat(frame, _ROUND) if isinstance(frame, int) else None

    @property
    def share(self) -> float:
        """Part of the finished frames that comes again; 0 where this is switched off."""
        return float(self._project.view_settings.get(_SHARE, 0.0))

    def switch(self, share: float) -> None:
        """Let this part of the frames come again; 0 switches it off."""
        self._project.view_settings.set(_SHARE, share or None)

    @property
    def active(self) -> Repeat | None:
        """The frame that is being annotated again."""
        return self._active

    def hides(self, frame: int) -> bool:
        """Whether clicks, predictions and model of this frame must not be shown."""
        return self._active is not None and self._active.frame == frame

    def due(self) -> int | None:
        """The finished frame that should be annotated again now; None while none is due."""
        if not self.share or self._active is not None or self._project.read_only:
            return None
        keyframes = [one for one in self._project.marks.keyframes() if one.done]
        done = [one.frame for one in sorted(keyframes, key=lambda one: (one.at, one.frame))]
        repeated = {click.frame for click in self._project.clicks.again(_ROUND)}
        return next_repeat(done, repeated, self.share)

    def begin(self, frame: int) -> Repeat:
        """Annotate a frame again, from now on."""
        self._active = Repeat(frame, _ROUND)
        self._project.view_settings.set(_FRAME, frame)
        return self._active

    def finish(self) -> None:
        """Show the frame as it is again; what was clicked of the second reading stays."""
        self._active = None
        self._project.view_settings.set(_FRAME, None)

    def clicks(self) -> tuple[Click, ...]:
        """The second reading of the frame so far."""
        if self._active is None:
            return ()
        return self._project.clicks.again_at(self._active.round, self._active.frame)

    def place(self, clicks: Iterable[Click]) -> None:
        """Set clicks of the second reading; the first one is not touched.

        Raises
        ------
        ValueError
            Where none is under way, or a click is of another frame.
        """
        active = self._active
        placed = tuple(clicks)
        if active is None or any(click.frame != active.frame for click in placed):
            raise ValueError("these clicks belong to a frame without a blind repeat")
        self._project.apply(PlaceRepeats(active.round, placed))

    def delete(self, keys: Iterable[ClickKey]) -> None:
        """Take clicks of the second reading away."""
        wanted = set(keys)
        gone = [replace(one, deleted=True) for one in self.clicks() if one.key in wanted]
        if gone:
            self.place(gone)

    def missing(self) -> tuple[ClickKey, ...]:
        """What the first reading has of the frame and the second one has not yet."""
        if self._active is None:
            return ()
        there = {click.key for click in self.clicks()}
        first = self._project.clicks.at(self._active.frame)
        return tuple(sorted(click.key for click in first if click.key not in there))

    def words(self) -> str:
        """What is going on, for the person who clicks; empty where nothing is."""
        if self._active is None:
            return ""
        count = len(self.clicks())
        return (
            f"Blind repeat of frame {self._active.frame}: {counted(count, 'click')} done, "
            f"{len(self.missing())} to go. Earlier clicks are hidden."
        )


def second_reading(
    edit: Edit, clicks: Mapping[ClickKey, Click], round_number: int
) -> PlaceRepeats | None:
    """The edit of the second reading that an edit of clicks means; None where it means nothing.

    Parameters
    ----------
    edit : Edit
    clicks : mapping from ClickKey to Click
        The second reading as it is.
    round_number : int
    """
    changed = {click.key: click for click in _changed(edit, clicks)}
    placed = tuple(replace(click, who="", at="") for click in changed.values())
    return PlaceRepeats(round_number, placed) if placed else None


def _changed(edit: Edit, clicks: Mapping[ClickKey, Click]) -> Iterable[Click]:
    match edit:
        case PlaceClicks():
            yield from edit.clicks
        case MoveClicks():
            yield from _moved(edit, clicks)
        case DeleteClicks():
            yield from (replace(click, deleted=True) for click in _there(edit.keys, clicks))
        case MarkClicks():
            yield from (_marked(edit, click) for click in _there(edit.keys, clicks))
        case AcceptPredictions():
            yield from _accepted(edit, clicks)
        case SwapLandmarks():
            yield from _swapped(edit, clicks)
        case Together():
            yield from chain.from_iterable(_changed(part, clicks) for part in edit.edits)


def _there(keys: Iterable[ClickKey], clicks: Mapping[ClickKey, Click]) -> list[Click]:
    return [clicks[key] for key in keys if key in clicks]


def _moved(edit: MoveClicks, clicks: Mapping[ClickKey, Click]) -> Iterable[Click]:
    for click in _there(edit.keys, clicks):
        if click.position is not None:
            x, y = click.position
            yield replace(click, position=(x + edit.by[0], y + edit.by[1]))


def _accepted(edit: AcceptPredictions, clicks: Mapping[ClickKey, Click]) -> Iterable[Click]:
    for one in edit.predictions:
        if one.key not in clicks:
            yield Click(*one.key, one.position, origin=ACCEPTED)


def _marked(edit: MarkClicks, click: Click) -> Click:
    visibility = click.visibility if edit.visibility is None else edit.visibility
    outside = visibility == Visibility.OUTSIDE
    if click.position is None and not outside:
        return click
    sigma = click.sigma if edit.sigma is None else edit.sigma
    return replace(
        click,
        position=None if outside else click.position,
        visibility=visibility,
        flag=click.flag if edit.flag is None else edit.flag,
        sigma=None if edit.usual_sigma else sigma,
    )


def _swapped(edit: SwapLandmarks, clicks: Mapping[ClickKey, Click]) -> Iterable[Click]:
    for here, there in ((edit.first, edit.second), (edit.second, edit.first)):
        own = clicks.get(ClickKey(edit.frame, edit.camera, here))
        other = clicks.get(ClickKey(edit.frame, edit.camera, there))
        if other is not None:
            yield replace(other, landmark=here)
        elif own is not None:
            yield replace(own, deleted=True)
