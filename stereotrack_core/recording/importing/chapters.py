"""Videos that a camera splits while it records: which files are consecutive parts of one video.

GoPro states it in the names; other cameras (DJI, Canon, Panasonic, AVCHD) number their files, and
their times of creation tell that one begins where the one before ends.
"""

from __future__ import annotations

import re
from pathlib import Path

_GOPRO = re.compile(r"(G[HXSL])(\d{2})(\d{4})", re.IGNORECASE)  # GX010042: chapter 1 of video 42
_GOPRO_FIRST = re.compile(r"GOPR(\d{4})", re.IGNORECASE)  # before HERO6: GOPR0042, GP010042, ...
_GOPRO_NEXT = re.compile(r"GP(\d{2})(\d{4})", re.IGNORECASE)
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


def begins_at_end(begin: float | None, seconds: float, following: float | None) -> bool:
    """Whether a file was created when one of so many seconds that began at `begin` ended."""
    if begin is None or following is None or seconds <= 0:
        return False
    return seconds > _SAME_INSTANT_S and abs(begin + seconds - following) <= _SAME_INSTANT_S
