"""What was seen of the board: corners by camera and frame, and pictures left out with reasons."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray


@dataclass(frozen=True)
class LeftOut:
    """A picture that is not used; `reason` is a clause."""

    camera: str
    frame: int
    picture: str
    """Name of the file, or the number of the video's frame."""
    reason: str


@dataclass(frozen=True, eq=False)
class Sightings:
    """The board in the pictures of one camera.

    `frames` (F,) ascending; `pixels` (F, n, 2) of all corners of the board, raw, NaN where unseen.
    """

    camera: str
    size: tuple[int, int]  # width and height in pixels
    frames: IntArray
    pixels: FloatArray
    pictures: tuple[str, ...]
    left_out: tuple[LeftOut, ...] = ()
    searched: int = 0
    """Number of pictures in which the board was looked for."""
    mirrored: int = 0
    """Number of pictures in which the print of the board was found mirrored."""

    def __len__(self) -> int:
        return len(self.frames)

    def only(self, rows: IntArray) -> Sightings:
        """Those in some rows."""
        names = tuple(self.pictures[i] for i in rows)
        return replace(self, frames=self.frames[rows], pixels=self.pixels[rows], pictures=names)

    def without(self, rows: Iterable[int], reasons: Iterable[str]) -> Sightings:
        """All but some rows, which are left out for reasons."""
        why = dict(zip(rows, reasons, strict=True))
        gone = tuple(
            LeftOut(self.camera, int(self.frames[i]), self.pictures[i], reason)
            for i, reason in why.items()
        )
        kept = np.array([i for i in range(len(self)) if i not in why], dtype=np.int64)
        return replace(self.only(kept), left_out=self.left_out + gone)

    def without_frames(self, frames: Iterable[int]) -> Sightings:
        """All but some frames, as a person has chosen."""
        rows = np.flatnonzero(np.isin(self.frames, list(frames)))
        return self.without(rows.tolist(), ["left out by hand"] * len(rows))
