"""Clicks followed by their image patch over selected frames, in all views that have them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.follow import FollowedClick, follow_patch, pictures_of
from stereotrack_core.annotation.prefill import FOLLOWING, from_following
from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.project.project import Project
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader

from ....session.counting import counted
from ..selection import Selection
from .prefilling import keep_found

_FARTHEST = 60
"""Frames outside the selection within which a click is followed into it."""

OnProgress = Callable[[float, str], None]


@dataclass(frozen=True, eq=False)
class FollowedSelection:
    """What became of it.

    Attributes
    ----------
    predictions : int
        Places that can be accepted now.
    ways : tuple of str
        For each click how far it was followed, in words.
    words : str
    """

    predictions: int
    ways: tuple[str, ...]
    words: str


@dataclass(frozen=True)
class _Way:
    """A click and the frames that it is followed over, the first of which is its own."""

    click: Click
    frames: range


def follow_selection(
    project: Project,
    recording: Recording,
    selection: Selection,
    on_progress: OnProgress,
    cancelled: Callable[[], bool],
) -> FollowedSelection:
    """Follow clicks into the selection and keep what is found as predictions, not as clicks.

    Raises
    ------
    InputError
        Where there is no click to begin with, or the project cannot be written to.
    Cancelled
        When stopped; nothing is kept then.
    """
    ways = [(view, tuple(_ways(project, view.image.camera, selection))) for view in recording.views]
    count = sum(len(some) for _, some in ways)
    if not count:
        raise InputError(
            f"there is no click near {selection.words()} to follow",
            remedy="Click landmarks in the first frames of the selection first.",
        )
    found: list[FollowedClick] = []
    for view, some in ways:
        if not some:
            continue
        with FrameReader(recording, views=[view.name], colour=False) as reader:
            for way in some:
                if cancelled():
                    raise Cancelled
                words = f"{way.click.landmark.replace('_', ' ')} in {way.click.camera}"
                on_progress(len(found) / count, words)
                found.append(_followed(reader, way, cancelled))
    kept = _keep(project, found, selection)
    words = f"{counted(kept, 'point')} found by following {counted(count, 'click')}."
    return FollowedSelection(kept, tuple(one.words() for one in found), words)


def _followed(reader: FrameReader, way: _Way, cancelled: Callable[[], bool]) -> FollowedClick:
    pictures = pictures_of(reader, way.click.camera, way.frames)
    followed = follow_patch(pictures, np.array(way.click.position), cancelled=cancelled)
    return FollowedClick(way.click, np.array(way.frames[: len(followed.pixels)]), followed)


def _keep(project: Project, found: list[FollowedClick], selection: Selection) -> int:
    """Keep the places inside the selection."""
    sigma = project.click_sigmas()
    return keep_found(project, FOLLOWING, from_following(found, sigma=sigma), selection)


def _ways(project: Project, camera: str, selection: Selection) -> Iterator[_Way]:
    """Forward and backward from every click in or near the selection, as far as the next one."""
    frames = selection.frames
    near = project.clicks.between(max(frames.start - _FARTHEST, 0), frames.stop + _FARTHEST)
    rows: dict[str, list[Click]] = defaultdict(list)
    for click in near:
        if click.camera == camera and click.position is not None and selection.has(click.landmark):
            rows[click.landmark].append(click)
    for row in rows.values():
        numbers = [click.frame for click in row]
        following = [*numbers[1:], frames.stop]
        before = [frames.start - 1, *numbers[:-1]]
        for click, after, last in zip(row, following, before, strict=True):
            end, back = min(after, frames.stop), max(last, frames.start - 1)
            if end > max(click.frame + 1, frames.start):
                yield _Way(click, range(click.frame, end))
            if back < min(click.frame - 1, frames.stop - 1):
                yield _Way(click, range(click.frame, back, -1))
