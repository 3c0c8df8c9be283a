"""Which frames of a reference are old: their clicks are no longer those that it was fitted to."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any
from zlib import crc32

from stereotrack_core.annotation.click import Click

FITTED_TO = "fitted_to"
"""Name in a reference's `meta` of frames and checksums of their clicks."""


def checksums(clicks: Iterable[Click]) -> dict[int, int]:
    """Checksum of what is said of each frame that has clicks."""
    said: dict[int, list[tuple[object, ...]]] = {}
    for one in clicks:
        if not one.deleted:
            place = one.camera, one.landmark, one.position
            said.setdefault(one.frame, []).append(
                (*place, int(one.visibility), one.flag, one.sigma)
            )
    return {frame: crc32(repr(sorted(own, key=repr)).encode()) for frame, own in said.items()}


@dataclass(frozen=True)
class FittedClicks:
    """The clicks that a reference was fitted to, and where they have changed since."""

    sums: Mapping[int, int]
    """Checksum of the clicks of each frame, as they were."""
    changed: frozenset[int]
    """Frames whose clicks are others now."""

    def after_edit(self, frames: Collection[int], clicks: Iterable[Click]) -> FittedClicks:
        """The same after an edit of these frames, whose clicks are given as they are now."""
        edited = _changed(self.sums, checksums(clicks), frames)
        return replace(self, changed=(self.changed - set(frames)) | edited)

    def is_old(self, frame: int) -> bool:
        """Whether clicks have changed that decide the reference in a frame.

        These are the frame's own or, where it had none, all from the clicked frame before it to
        the one after it.
        """
        clicked = sorted(self.sums)
        before, after = bisect_right(clicked, frame) - 1, bisect_left(clicked, frame)
        first = clicked[before] if before >= 0 else 0
        last = clicked[after] if after < len(clicked) else None
        return any(first <= one and (last is None or one <= last) for one in self.changed)


def fitted_clicks(meta: Mapping[str, Any], clicks: Iterable[Click]) -> FittedClicks | None:
    """What a reference's `meta` says of its clicks beside all clicks as they are now.

    None where it says nothing: a reference that was imported, or fitted by an older version.
    """
    rows = meta.get(FITTED_TO)
    if not isinstance(rows, list) or not all(_is_row(row) for row in rows):
        return None
    sums, now = dict(rows), checksums(clicks)
    return FittedClicks(sums, _changed(sums, now, sums.keys() | now.keys()))


def _changed(
    before: Mapping[int, int], now: Mapping[int, int], frames: Iterable[int]
) -> frozenset[int]:
    return frozenset(frame for frame in frames if before.get(frame) != now.get(frame))


def _is_row(row: object) -> bool:
    return isinstance(row, list) and len(row) == 2 and all(type(value) is int for value in row)
