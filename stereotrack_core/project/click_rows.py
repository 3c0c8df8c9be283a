"""Clicks as rows of the tables ``click`` and ``repeat_click``, and back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from stereotrack_core.annotation.click import Click, ClickKey, Visibility
from stereotrack_core.project.edit import Stamp
from stereotrack_core.project.rows import Row
from stereotrack_core.project.schema import CLICK

COLUMNS = CLICK.columns


def click_of(row: Sequence[Any]) -> Click:
    """The click of a row in the order of :data:`COLUMNS`."""
    frame, camera, landmark, x, y, visibility, flag, sigma, origin, who, at, deleted = row
    return Click(
        frame=frame,
        camera=camera,
        landmark=landmark,
        position=None if x is None else (x, y),
        visibility=Visibility(visibility),
        flag=flag,
        sigma=sigma,
        origin=origin,
        who=who,
        at=at,
        deleted=bool(deleted),
    )


def values_of(click: Click, stamp: Stamp) -> Row:
    """Values of a click's row; who and when are filled in where it does not say them itself."""
    x, y = click.position or (None, None)
    return (
        None if x is None else float(x),
        None if y is None else float(y),
        int(click.visibility),
        click.flag,
        None if click.sigma is None else float(click.sigma),
        click.origin,
        click.who or stamp.who,
        click.at or stamp.at,
        int(click.deleted),
    )


def click_in(key: Row, values: Row) -> Click:
    """The click of a row's key (with or without round) and values."""
    return click_of((*key[-3:], *values))


def taken_away(click: Click) -> Click:
    """The click as deleted, to be stamped anew."""
    return replace(click, deleted=True, who="", at="")


def place_in_words(keys: Sequence[ClickKey]) -> str:
    """Where clicks are: ``left elbow in N_right, frame 213``."""
    landmarks = {key.landmark for key in keys}
    cameras = {key.camera for key in keys}
    frames = sorted({key.frame for key in keys})
    what = _named(next(iter(landmarks))) if len(landmarks) == 1 else f"{len(landmarks)} landmarks"
    where = next(iter(cameras)) if len(cameras) == 1 else f"{len(cameras)} cameras"
    when = f"frame {frames[0]}" if len(frames) == 1 else f"frames {frames[0]} to {frames[-1]}"
    return f"{what} in {where}, {when}"


def _named(landmark: str) -> str:
    return landmark.replace("_", " ")
