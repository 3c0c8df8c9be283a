"""Steps of a calibration as tasks of a process, for a window that shows how they go on."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeAlias

import numpy as np

from stereotrack_core.calibrate import pictures
from stereotrack_core.calibrate.board import Board
from stereotrack_core.calibrate.detection import Recognition
from stereotrack_core.calibrate.intrinsics import Intrinsics, calibrate_intrinsics
from stereotrack_core.calibrate.world import World, calibrate_world
from stereotrack_core.errors import Finding, InputError
from stereotrack_core.recording.folder import DESCRIPTION, open_recording
from stereotrack_core.work import NO_WORK, Work
from stereotrack_core.worker_processes import Asker


@dataclass(frozen=True, eq=False)
class Search:
    """The board as it was seen by each camera; mirrored ones, differences, why not in step."""

    board: Board
    sightings: tuple[pictures.Sightings, ...]
    mirrored: tuple[str, ...]
    findings: tuple[Finding, ...]
    apart: InputError | None = None

    def check_not_mirrored(self) -> None:
        """Refuse mirrored pictures, which have no place in a world. Raises InputError."""
        if self.mirrored:
            raise InputError(
                "the pictures are mirrored, so that left and right would be exchanged in the world",
                f"camera {', '.join(self.mirrored)}",
                "Switch off mirroring in the recording software and record again.",
            )


def search(
    sources: Sequence[pictures.Pictures], named: Board, frames: Sequence[int], work: Work = NO_WORK
) -> Search:
    """Look for the board in some frames of every camera. Raises InputError."""
    board, seen, mirrored = named, [], []
    known: Recognition | None = None
    different: tuple[str, Board, tuple[str, ...]] = ("", named, ())
    for number, one in enumerate(sources):
        recognition = pictures.recognised_in(one, board, work)
        if known is None and recognition.differences and not different[0]:
            different = one.camera, recognition.board, recognition.differences
        there = [frame for frame in frames if frame < one.count()]
        part = work.part(number / len(sources), (number + 1) / len(sources))
        own = pictures.find_in_pictures(one, recognition, there, part)
        if len(own):
            if known is not None and recognition.board != known.board:
                what = f"it shows a {recognition.board.words}, other cameras a {known.board.words}"
                remedy = "Film the same board with all cameras."
                raise InputError(what, f"camera {one.camera}", remedy)
            known, board = recognition, recognition.board
            mirrored += [one.camera] * recognition.mirrored
        seen.append(own)
    nothing = np.zeros((0, len(board.corners), 2))
    sightings = tuple(one if len(one) else replace(one, pixels=nothing) for one in seen)
    camera, shown, clauses = different
    remedy = f"The {shown.words} is used."
    found = Finding("warning", f"camera {camera}", "; ".join(clauses), remedy)
    return Search(board, sightings, tuple(mirrored), (found,) if clauses else ())


LensResult: TypeAlias = Intrinsics | InputError  # a lens, or why it cannot be calibrated


@dataclass(frozen=True)
class Source:
    """Where the pictures of a camera are: folder of images, pattern, video, or recording."""

    camera: str
    place: str

    @property
    def of_recording(self) -> bool:
        """Whether the place is a recording, with other cameras in it."""
        return (Path(self.place) / DESCRIPTION).is_file()

    def open(self) -> pictures.Pictures:
        """The pictures. Raises InputError where there are none."""
        if self.of_recording:
            return pictures.pictures_of_recording(Path(self.place), self.camera)
        return pictures.pictures_of_glob(self.place, self.camera, f"camera {self.camera}")


def sources_in(folder: Path) -> tuple[Source, ...]:
    """The cameras of a recording, or of a folder with one source each. Raises InputError."""
    if not folder.is_dir():
        raise InputError("there is no such folder", folder, "Give the folder of the cameras.")
    if not (folder / DESCRIPTION).is_file():
        return tuple(Source(name, str(path)) for name, path in pictures.places_in(folder).items())
    streams = [view.streams().items() for view in open_recording(folder).views]
    cameras = [one.camera for own in streams for key, one in own if key not in pictures.NO_PICTURES]
    return tuple(Source(name, str(folder)) for name in dict.fromkeys(cameras))


@dataclass(frozen=True)
class Progress:
    """How far a step is, from 0 to 1, and what it is at."""

    share: float
    words: str


Step: TypeAlias = Callable[[Asker], object]  # a function below but for its last argument


def find_board_in(sources: Sequence[Source], board: Board, every: int, asker: Asker) -> Search:
    """Look for the board in every picture, or every so many."""
    opened: list[pictures.Pictures] = []
    work = Work(lambda share, words: asker.tell(Progress(share, words)), asker.cancelled)
    try:
        opened += (source.open() for source in sources)
        frames = range(0, max((one.count() for one in opened), default=0), every)
        found = search(opened, board, frames, work)
        try:
            pictures.check_same_length(opened)
        except InputError as error:
            return replace(found, apart=error)
        return found
    finally:
        for one in opened:
            one.close()


def fit_lenses(
    sightings: Sequence[pictures.Sightings], board: Board, model: str, asker: Asker
) -> dict[str, LensResult]:
    """Calibrate the lens of each camera from its own pictures."""
    found: dict[str, LensResult] = {}
    for k, one in enumerate(sightings):
        asker.tell(Progress(k / len(sightings), f"lens of {one.camera}"))
        try:
            found[one.camera] = calibrate_intrinsics(one, board, model=model)
        except InputError as error:
            found[one.camera] = error
    return found


def fit_world(
    sightings: Sequence[pictures.Sightings], board: Board, model: str, _asker: Asker
) -> World:
    """Place all cameras in one world."""
    return calibrate_world(sightings, board, model=model)
