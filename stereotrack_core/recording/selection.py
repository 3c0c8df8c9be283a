"""Frames, views and seeds as a person writes them, and what they mean for a recording."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from stereotrack_core.errors import InputError

if TYPE_CHECKING:  # no more than that is needed, and the command line starts quickly
    from stereotrack_core.recording.description import Recording
    from stereotrack_core.recording.keypoints import Keypoints

_FEWEST_VIEWS = 2  # mono views without which a person's place in space is not known


def asked_frames(text: str | None, end: int = 2**31) -> range:
    """Frames from A to B of ``A:B`` as given to ``--frames``; from 0 and to `end` where left out.

    Raises InputError where the text cannot be read, or the end does not come after the first frame.
    """
    if text is None:
        return range(end)
    first, sign, last = text.partition(":")
    try:
        if not sign:
            raise ValueError
        asked = range(int(first) if first.strip() else 0, int(last) if last.strip() else end)
    except ValueError:
        what, remedy = f"{text!r} cannot be read", "Write A:B, for example 10:60."
        raise InputError(what, "--frames", remedy) from None
    if asked.start < 0 or (last.strip() and not asked):
        remedy = "Frames are counted from 0, and B must be larger than A."
        raise InputError(f"{text!r} contains no frame", "--frames", remedy)
    return asked


def frames_within(text: str | None, count: int) -> range:
    """Frames that ``--frames`` names out of `count`; InputError for others than the recording's."""
    if not count:
        raise InputError("the recording has no frames", remedy="See `stereotrack info`.")
    chosen = asked_frames(text, count)
    if chosen.stop > count or chosen.start >= count:
        what = f"{text!r} exceeds the end of the recording"
        raise InputError(what, "--frames", f"The recording has the frames 0:{count}.")
    return chosen


def views_of(recording: Recording, text: str | None) -> tuple[str, ...] | None:
    """View names that ``--views`` asks for, None for all; InputError for an unknown one."""
    if text is None:
        return None
    known = [view.name for view in recording.views]
    if text in known:
        return (text,)
    joined = "+" in text or not all(letter in known for letter in text)
    names = [name.strip() for name in text.split("+")] if joined else list(text)
    unknown = [name for name in names if name not in known]
    if unknown or not names:
        what = f"there is no view {(unknown or [text])[0]!r}"
        raise InputError(what, "--views", f"The recording has: {', '.join(known)}.")
    return tuple(dict.fromkeys(names))


def seeds_of(text: str) -> list[int]:
    """Seeds that ``--seeds`` names; InputError for anything but different whole numbers from 0."""
    try:
        seeds = [int(part) for part in text.split(",")]
    except ValueError:
        seeds = []
    if not seeds or min(seeds) < 0 or len(set(seeds)) < len(seeds):
        remedy = "Give distinct whole numbers from 0, for example 0,1,2."
        raise InputError(f"{text!r} is not a list of seeds", "--seeds", remedy)
    return seeds


def check_calibrated(recording: Recording) -> None:
    """Refuse a recording whose cameras are guessed; InputError says what to do."""
    if recording.guessed:
        what = "the calibration is a guess, so nothing in space can be computed"
        remedy = "Replace it with a calibration of these cameras."
        raise InputError(what, recording.folder / "calibration.toml", remedy)


def gives_depth(recording: Recording) -> bool:
    """Whether any view measures depth; mono views do not."""
    return any(view.kind != "mono" for view in recording.views)


def tracked_views(
    recording: Recording, views: Sequence[str] | None, keypoints: Keypoints | None
) -> tuple[str, ...]:
    """Names of the views that can be tracked: those that give depth, else those with keypoints.

    Raises InputError where there are none, or keypoints of only one view: it has no depth.
    """
    if gives_depth(recording) or keypoints is None:
        return usable_views(recording, views)
    check_calibrated(recording)
    known = set(keypoints.cameras)
    seen = [view.name for view in recording.views if view.image.camera in known]
    found = tuple(name for name in seen if views is None or name in views)
    if len(found) < _FEWEST_VIEWS:
        what = f"keypoints of {len(found)} view{'' if len(found) == 1 else 's'} tell no depth"
        raise InputError(what, "--keypoints", f"Give keypoints of at least {_FEWEST_VIEWS} views.")
    return found


def usable_views(recording: Recording, views: Sequence[str] | None) -> tuple[str, ...]:
    """Views that give depth and were asked for, in order; InputError for none, or guesses."""
    check_calibrated(recording)
    deep = tuple(view.name for view in recording.views if view.kind != "mono")
    if not deep:
        what, where = "no view provides depth, so there is nothing to track", recording.folder
        mono = "keypoints of a 2-D detector in at least two mono views"
        track = "(`stereotrack track --keypoints`)"
        remedy = f"Tracking needs a view of kind stereo or depth, or {mono} {track}."
        raise InputError(what, where / "recording.toml", remedy)
    if views is None:
        return deep
    unknown = [name for name in views if name not in deep]
    if unknown or not views:
        what = f"unknown view with depth: {', '.join(unknown) or 'none given'}"
        raise InputError(what, "--views", f"Available: {', '.join(deep)}.")
    return tuple(name for name in deep if name in views)
