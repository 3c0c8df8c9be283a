"""Edits of clicks as they are made to a second, blind reading: the first one is not touched."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from itertools import chain

from stereotrack_core.annotation.click import Click, ClickKey, Visibility
from stereotrack_core.annotation.predict import ACCEPTED
from stereotrack_core.project.accept import AcceptPredictions
from stereotrack_core.project.click_edits import (
    DeleteClicks,
    MarkClicks,
    MoveClicks,
    PlaceClicks,
    PlaceRepeats,
    SwapLandmarks,
)
from stereotrack_core.project.edit import Edit, Together


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
