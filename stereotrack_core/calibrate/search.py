"""The board looked for in the pictures of all cameras."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stereotrack_core.calibrate.board import Board
from stereotrack_core.calibrate.pictures import (
    Looked,
    Pictures,
    find_in_pictures,
    ignore,
    recognised_in,
)
from stereotrack_core.calibrate.recognition import MIRRORED, Recognition
from stereotrack_core.calibrate.sightings import Sightings
from stereotrack_core.counting import counted
from stereotrack_core.errors import Finding, InputError


@dataclass(frozen=True, eq=False)
class Search:
    """The board as it was seen, what each camera saw of it, and what differs from what was named.

    `mirrored` are the names of cameras whose pictures are mirrored.
    """

    board: Board
    sightings: tuple[Sightings, ...]
    mirrored: tuple[str, ...]
    findings: tuple[Finding, ...]

    def check_not_mirrored(self) -> None:
        """Refuse mirrored pictures, which have no place in a world.

        Raises InputError, which names the cameras.
        """
        if self.mirrored:
            raise InputError(
                "the pictures are mirrored, so that left and right would be exchanged in the world",
                where=f"camera {', '.join(self.mirrored)}",
                remedy="Switch off mirroring in the recording software and record again. If the "
                "mirrored print is on the back of the board, show both sides to these cameras.",
            )


def search(
    sources: Sequence[Pictures],
    named: Board,
    frames: Sequence[int],
    *,
    on_picture: Callable[[Looked], None] = ignore,
    cancelled: Callable[[], bool] = lambda: False,
) -> Search:
    """Look for the board in some frames of every camera, as far as it has them.

    Raises
    ------
    InputError
        Pictures that cannot be read, or cameras that show different boards.
    Cancelled
    """
    board, seen = named, []
    known: Recognition | None = None
    different: tuple[str, Board, tuple[str, ...]] = ("", named, ())
    for one in sources:
        recognition = recognised_in(one, board, cancelled)
        if known is None and recognition.differences and not different[0]:
            different = one.camera, recognition.board, recognition.differences
        there = [frame for frame in frames if frame < one.count()]
        own = find_in_pictures(one, recognition, there, on_picture=on_picture, cancelled=cancelled)
        if len(own):
            if known is not None and recognition.board != known.board:
                raise InputError(
                    f"it shows a {recognition.board.words}, other cameras a {known.board.words}",
                    where=f"camera {one.camera}",
                    remedy="Film the same board with all cameras.",
                )
            known, board = recognition, recognition.board
        seen.append(own)
    sightings = tuple(one if len(one) else _empty(one, board) for one in seen)
    both = any(0 < one.mirrored < len(one) for one in sightings)
    mirrored = () if both else tuple(one.camera for one in sightings if one.mirrored)
    camera, shown, clauses = different
    clauses = tuple(one for one in clauses if one != MIRRORED or mirrored)
    findings = []
    if clauses:
        remedy = f"Calibrated with the {shown.words}."
        findings.append(Finding("warning", f"camera {camera}", "; ".join(clauses), remedy))
    if both:
        count = counted(sum(one.mirrored for one in sightings), "picture")
        what = f"{count} show the print mirrored, others as it is: taken for the back of the board"
        remedy = "Both sides must lie exactly on each other, on a thin board."
        findings.append(Finding("note", "board", what, remedy))
    return Search(board, sightings, mirrored, tuple(findings))


def _empty(sightings: Sightings, board: Board) -> Sightings:
    """No sightings, of as many corners as the board has."""
    pixels = np.zeros((0, len(board.corners), 2))
    return replace(sightings, pixels=pixels)
