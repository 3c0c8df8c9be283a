"""Videos that a camera splits while it records: which files are consecutive parts of one video.

GoPro states it in the names; other cameras (DJI, Canon, Panasonic, AVCHD) number their files, and
their times of creation tell that one begins where the one before ends.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from stereotrack_core.recording.importing.source import Source

_GOPRO = re.compile(r"(G[HXSL])(\d{2})(\d{4})", re.IGNORECASE)  # GX010042: chapter 1 of video 42
_GOPRO_FIRST = re.compile(r"GOPR(\d{4})", re.IGNORECASE)  # before HERO6: GOPR0042, GP010042, ...
_GOPRO_NEXT = re.compile(r"GP(\d{2})(\d{4})", re.IGNORECASE)
_AS_USUAL = 0.01  # of a rate
_SAME_INSTANT_S = 1.5  # times of creation are whole seconds, rounded either way


def chapter_of(path: Path) -> tuple[str, int] | None:
    """The video that a file of a GoPro belongs to, and the number of its chapter from 1.

    None if the name is not one of a GoPro.
    """
    stem = path.stem
    if match := _GOPRO.fullmatch(stem):
        return f"{match[1].upper()}{match[3]}", int(match[2])
    if match := _GOPRO_FIRST.fullmatch(stem):
        return f"GOPR{match[1]}", 1
    if match := _GOPRO_NEXT.fullmatch(stem):
        return f"GOPR{match[2]}", int(match[1]) + 1
    return None


def is_next_file(before: Path, after: Path) -> bool:
    """Whether two files lie beside each other with names that differ in their numbers only."""
    alike = [re.sub(r"\d+", "0", path.name.casefold()) for path in (before, after)]
    return before.parent == after.parent and alike[0] == alike[1] and before.name < after.name


def _begins_at_end(begin: float | None, seconds: float, following: float | None) -> bool:
    """Whether a file was created when one of so many seconds that began at `begin` ended."""
    if begin is None or following is None or seconds <= 0:
        return False
    return seconds > _SAME_INSTANT_S and abs(begin + seconds - following) <= _SAME_INSTANT_S


def joined(sources: Sequence[Source]) -> tuple[list[Source], list[str]]:
    """The sources with consecutive chapters of a video as one, and notes about chapters."""
    result: list[Source] = []
    notes = []
    for one in sources:
        place = next((k for k, other in enumerate(result) if _follows(other, one)), None)
        if place is not None:
            result[place] = _continued(result[place], one)
            continue
        result.append(one)
        named = chapter_of(one.path)
        if named is not None and named[1] > 1:
            notes.append(
                f"{one.path.name} is chapter {named[1]} of a video whose chapter before is not "
                "there, or does not fit: it is a separate source"
            )
    for one in result:
        if one.chapters:
            names = ", ".join(path.name for path in one.chapters)
            notes.append(f"{names} follow each other: they are joined as {one.name}, "
                         f"{one.frames} frames")  # fmt: skip
    return result, notes


def _follows(before: Source, after: Source) -> bool:
    """Whether a video goes on where another one, or its last chapter, ends."""
    alike = before.kind == after.kind and before.size == after.size and before.track == after.track
    if before.images or after.images or not alike or before.topic or after.topic:
        return False
    last = before.chapters[-1] if before.chapters else before.path
    parts = [chapter_of(path) for path in (last, after.path)]
    if parts[0] is not None and parts[1] is not None:
        consecutive = parts[0] == (parts[1][0], parts[1][1] - 1)
        return consecutive and last.parent == after.path.parent
    if before.fps is None or after.fps is None or abs(before.fps / after.fps - 1) > _AS_USUAL:
        return False
    length = before.frames / before.fps
    return is_next_file(last, after.path) and _begins_at_end(before.created, length, after.created)


def _continued(first: Source, following: Source) -> Source:
    return replace(
        first, chapters=(*(first.chapters or (first.path,)), following.path),
        frames=first.frames + following.frames, sound=first.sound and following.sound,
        uneven=max(first.uneven, following.uneven), pause=max(first.pause, following.pause),
    )  # fmt: skip
