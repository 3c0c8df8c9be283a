"""Steps of a calibration as tasks of a process, for a window that shows how they go on."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path
from typing import TypeAlias

import numpy as np

from stereotrack_core.calibrate.board import Board
from stereotrack_core.calibrate.detection import Recognition
from stereotrack_core.calibrate.intrinsics import Intrinsics, calibrate_intrinsics
from stereotrack_core.calibrate.pictures import (
    Looked,
    Pictures,
    Sightings,
    check_same_length,
    find_in_pictures,
    ignore,
    pictures_of_folder,
    pictures_of_glob,
    places_in,
    recognised_in,
)
from stereotrack_core.calibrate.world import World, calibrate_world
from stereotrack_core.errors import Finding, InputError
from stereotrack_core.recording.folder import DESCRIPTION
from stereotrack_core.worker_processes import Asker


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
                remedy="Switch off mirroring in the recording software and record again.",
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
    board, seen, mirrored = named, [], []
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
            mirrored += [one.camera] * recognition.mirrored
        seen.append(own)
    sightings = tuple(one if len(one) else _empty(one, board) for one in seen)
    camera, shown, clauses = different
    findings = []
    if clauses:
        remedy = f"Calibrated with the {shown.words}."
        findings.append(Finding("warning", f"camera {camera}", "; ".join(clauses), remedy))
    return Search(board, sightings, tuple(mirrored), tuple(findings))


def _empty(sightings: Sightings, board: Board) -> Sightings:
    """No sightings, of as many corners as the board has."""
    pixels = np.zeros((0, len(board.corners), 2))
    return replace(sightings, pixels=pixels)


LensResult: TypeAlias = Intrinsics | InputError
"""A lens, or why it cannot be calibrated."""


@dataclass(frozen=True)
class Source:
    """Where the pictures of one camera are.

    `place` is a folder of images, a pattern of files, a video, or the folder of a recording.
    """

    camera: str
    place: str

    @property
    def of_recording(self) -> bool:
        """Whether the place is a recording, with other cameras in it."""
        return (Path(self.place) / DESCRIPTION).is_file()

    def open(self) -> Pictures:
        """The pictures.

        Raises InputError where there are none.
        """
        if not self.of_recording:
            return pictures_of_glob(self.place, self.camera, f"camera {self.camera}")
        found: Pictures | None = None
        for one in pictures_of_folder(Path(self.place)):
            if one.camera == self.camera and found is None:
                found = one
            else:
                one.close()
        if found is None:
            raise InputError(
                f"the recording has no camera {self.camera!r}",
                where=self.place,
                remedy="Name the camera as in the recording's description.",
            )
        return found


def sources_in(folder: Path) -> tuple[Source, ...]:
    """The cameras of a recording, or of a folder with one video or folder of images for each.

    Raises InputError where there is none.
    """
    if (folder / DESCRIPTION).is_file():
        opened = pictures_of_folder(folder)
        for one in opened:
            one.close()
        return tuple(Source(one.camera, str(folder)) for one in opened)
    return tuple(Source(name, str(path)) for name, path in places_in(folder).items())


@dataclass(frozen=True)
class Progress:
    """How far a step is, from 0 to 1, and what it is at."""

    share: float
    words: str


@dataclass(frozen=True, eq=False)
class Found:
    """What was found in the pictures; `apart` says why they are not of the same instants."""

    search: Search
    apart: InputError | None


@dataclass(frozen=True)
class FindBoard:
    """Looks for the board in every picture, or every so many; tells each as :class:`Progress`."""

    sources: tuple[Source, ...]
    board: Board
    every: int = 1

    def __call__(self, asker: Asker) -> Found:
        """Do it in the process."""
        opened: list[Pictures] = []
        try:
            opened += (source.open() for source in self.sources)
            counts = [one.count() for one in opened]
            frames = range(0, max(counts, default=0), self.every)
            total = sum(len(range(0, number, self.every)) for number in counts)
            done = count(1)

            def tell(looked: Looked) -> None:
                asker.tell(Progress(next(done) / total, f"{looked.camera}, {looked.name}"))

            found = search(opened, self.board, frames, on_picture=tell, cancelled=asker.cancelled)
            return Found(found, _apart(opened))
        finally:
            for one in opened:
                one.close()


def _apart(opened: Sequence[Pictures]) -> InputError | None:
    try:
        check_same_length(opened)
    except InputError as error:
        return error
    return None


@dataclass(frozen=True, eq=False)
class FitLenses:
    """Calibrates the lens of each camera from its own pictures."""

    sightings: tuple[Sightings, ...]
    board: Board
    model: str = "auto"

    def __call__(self, asker: Asker) -> Mapping[str, LensResult]:
        """Do it in the process."""
        found: dict[str, LensResult] = {}
        for k, one in enumerate(self.sightings):
            asker.tell(Progress(k / len(self.sightings), f"lens of {one.camera}"))
            try:
                found[one.camera] = calibrate_intrinsics(
                    one, self.board, model=self.model, stop=asker.cancelled
                )
            except InputError as error:
                found[one.camera] = error
        return found


@dataclass(frozen=True, eq=False)
class FitWorld:
    """Places all cameras in one world."""

    sightings: tuple[Sightings, ...]
    board: Board
    model: str = "auto"

    def __call__(self, asker: Asker) -> World:
        """Do it in the process."""
        return calibrate_world(self.sightings, self.board, model=self.model, stop=asker.cancelled)


Step: TypeAlias = Callable[[Asker], object]
"""Any of the tasks above."""
