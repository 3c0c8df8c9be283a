"""Is it the board that was named? Boards are transposed, miscounted, old, inverted, mirrored."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stereotrack_core.arrays import FloatArray, ImageArray
from stereotrack_core.calibrate.board import DICTIONARIES, Board
from stereotrack_core.calibrate.detection import (
    count_markers,
    find_board,
    mirrored_picture,
    mirrored_pixels,
)
from stereotrack_core.errors import Cancelled

MIRRORED = "the pictures are mirrored"
_LEAST_SHARE = 0.25  # of the corners of all pictures, from which a board is taken as it was named
_LEAST_MARKERS = 4
_SAMPLE = 3  # pictures in which all kinds of markers are looked for
_FAMILIES = tuple(
    name for name in DICTIONARIES if name.endswith("_1000") or not name.rsplit("_", 1)[-1].isdigit()
)
"""The larger dictionaries of the same kind begin with the markers of the smaller ones."""


@dataclass(frozen=True)
class Recognition:
    """The board as it is seen in the pictures, and what differs from what was named.

    `mirrored`: the pictures show it with left and right exchanged. `differences` are clauses.
    """

    board: Board
    mirrored: bool = False
    differences: tuple[str, ...] = ()

    def find(self, image: ImageArray) -> FloatArray | None:
        """Corners (n, 2) in a grey picture, in its own pixels; see :func:`find_board`."""
        if not self.mirrored:
            return find_board(image, self.board)
        pixels = find_board(mirrored_picture(image), self.board)
        return None if pixels is None else mirrored_pixels(pixels, image.shape[1])

    def find_either_side(self, image: ImageArray) -> tuple[FloatArray | None, bool]:
        """Corners in a grey picture as by :meth:`find`, and whether the print is mirrored in it.

        The back of a ChArUco board may have the mirrored print, so that every corner lies behind
        the same one of the front.
        """
        pixels = self.find(image)
        if pixels is not None or not self.board.dictionary:
            return pixels, self.mirrored
        other = replace(self, mirrored=not self.mirrored)
        return other.find(image), other.mirrored


def recognised(
    images: Sequence[ImageArray], named: Board, cancelled: Callable[[], bool] = lambda: False
) -> Recognition:
    """The board of some pictures that shows most corners in them, the named one before others.

    Chessboards are tried with squares counted instead of inner corners and one row or column more
    or less; ChArUco boards transposed, of the pattern before OpenCV 4.6, inverted, mirrored and of
    the other dictionaries. A mirrored chessboard looks like another chessboard and is not noticed.
    """
    first = Recognition(named)
    most = _count(images, first, cancelled)
    enough = _LEAST_SHARE * len(images) * len(named.corners)
    if not named.dictionary:
        if most >= enough:
            return _larger_chessboard(images, first, cancelled)
        tried = [first, *_chessboards(named)]
        return max(tried, key=lambda one: _count(images, one, cancelled))
    best = first
    if most < enough:
        for other in _charuco_variants(images, named):
            count = _count(images, other, cancelled)
            if count > most:
                best, most = other, count
            if most >= enough:
                break
    return best


def _larger_chessboard(
    images: Sequence[ImageArray], named: Recognition, cancelled: Callable[[], bool]
) -> Recognition:
    """The board as it was named, or the larger one that it is only a part of."""
    found = [image for image in images if named.find(image) is not None][:_SAMPLE]
    size = len(named.board.corners)
    larger = [one for one in _chessboards(named.board) if len(one.board.corners) > size]
    return max([named, *larger], key=lambda one: _count(found, one, cancelled))


def _count(
    images: Sequence[ImageArray], recognition: Recognition, cancelled: Callable[[], bool]
) -> int:
    """Corners in all images."""
    count = 0
    for image in images:
        if cancelled():
            raise Cancelled
        found = recognition.find(image)
        count += 0 if found is None else int(np.isfinite(found[:, 0]).sum())
    return count


def _chessboards(named: Board) -> Iterator[Recognition]:
    columns, rows = named.columns, named.rows
    sizes = [(columns - 1, rows - 1)]
    sizes += [(columns + i, rows + j) for i in (-1, 0, 1) for j in (-1, 0, 1)]
    for size in dict.fromkeys(sizes):
        if size == (columns, rows) or min(size) < 3:
            continue
        words = (
            f"the board has {size[0]}x{size[1]} inner corners; {columns}x{rows} "
            f"{'are its squares' if size == (columns - 1, rows - 1) else 'were named'}"
        )
        yield Recognition(replace(named, columns=size[0], rows=size[1]), False, (words,))


def _charuco_variants(images: Sequence[ImageArray], named: Board) -> Iterator[Recognition]:
    yield from _patterns(named, named, mirrored=False)
    some = images[:: max(1, len(images) // _SAMPLE)]
    inverted, mirrored, dictionary = _appearance(some, named)
    if dictionary:
        seen = replace(named, dictionary=dictionary, inverted=inverted)
        yield from _patterns(seen, named, mirrored=mirrored)


def _patterns(seen: Board, named: Board, *, mirrored: bool) -> Iterator[Recognition]:
    sizes = dict.fromkeys([(named.columns, named.rows), (named.rows, named.columns)])
    for columns, rows in sizes:
        for legacy in (False, True):
            board = replace(seen, columns=columns, rows=rows, legacy=legacy)
            yield Recognition(board, mirrored, _differences(board, named, mirrored))


def _appearance(images: Sequence[ImageArray], named: Board) -> tuple[bool, bool, str]:
    """Whether black and white, and left and right, are exchanged, and the dictionary of markers.

    Whatever shows most of the board's markers; the dictionary is empty where that is hardly any.
    """
    needed = (named.columns + 1) * (named.rows + 1) // 2
    families = [named.dictionary, *(one for one in _FAMILIES if _capacity(one) >= needed)]
    best, most = (False, False, ""), _LEAST_MARKERS - 1
    for inverted in (False, True):
        for mirrored in (False, True):
            seen = [mirrored_picture(one) if mirrored else one for one in images]
            seen = [255 - one for one in seen] if inverted else seen
            for name in families:
                count = max((count_markers(one, name, needed) for one in seen), default=0)
                if count > most:
                    best, most = (inverted, mirrored, name), count
    return *best[:2], _smallest(best[2], needed)


def _smallest(name: str, needed: int) -> str:
    """The smallest dictionary with as many markers as needed that begins like another one."""
    kind = name.rsplit("_", 1)[0]
    alike = [one for one in DICTIONARIES if one.rsplit("_", 1)[0] == kind]
    if not name or not _is_counted(name):
        return name
    return min((one for one in alike if _capacity(one) >= needed), key=_capacity, default=name)


def _is_counted(name: str) -> bool:
    return name.rsplit("_", 1)[-1].isdigit()


def _capacity(name: str) -> int:
    return int(name.rsplit("_", 1)[-1]) if _is_counted(name) else 100_000


def _differences(board: Board, named: Board, mirrored: bool) -> tuple[str, ...]:
    found = []
    if (board.columns, board.rows) != (named.columns, named.rows):
        found.append(f"the board has {board.columns + 1}x{board.rows + 1} squares, not the reverse")
    if board.dictionary != named.dictionary:
        found.append(f"its markers are of {board.dictionary}, not {named.dictionary}")
    if board.legacy != named.legacy:
        found.append("it is a legacy pattern, from before OpenCV 4.6")
    if board.inverted != named.inverted:
        found.append("its black and white are exchanged")
    if mirrored:
        found.append(MIRRORED)
    return tuple(found)
