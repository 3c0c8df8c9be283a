"""A calibration as far as it is made, what follows from it, and how it is written."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Generic, Literal, TypeAlias, TypeVar

import numpy as np

from stereotrack_core.arrays import FloatArray, ImageArray
from stereotrack_core.calibrate import report
from stereotrack_core.calibrate.align import Alignment, aligned, from_board, from_cameras
from stereotrack_core.calibrate.board import Board
from stereotrack_core.calibrate.intrinsics import Intrinsics
from stereotrack_core.calibrate.pictures import Pictures, Sightings
from stereotrack_core.calibrate.report import Verdict
from stereotrack_core.calibrate.work import LensResult, Search, Source
from stereotrack_core.calibrate.world import World
from stereotrack_core.calibrate.world_checks import seen_board
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.images import DamagedFrame

StepName: TypeAlias = Literal["board", "pictures", "lenses", "world", "axes"]
STEPS: dict[StepName, str] = {
    "board": "Board",
    "pictures": "Pictures",
    "lenses": "Lenses",
    "world": "All cameras",
    "axes": "Axes and saving",
}

DOING: dict[StepName, str] = {
    "pictures": "Searching for the board",
    "lenses": "Calculating the lenses",
    "world": "Placing all cameras",
    "axes": "Looking for the floor",
}

Shot: TypeAlias = tuple[str, int]  # A picture: the name of its camera and its number
_USUAL = Board(9, 6, 0.025)
_R = TypeVar("_R")


AxesWay: TypeAlias = Literal["first", "board", "floor", "recording"]


@dataclass(frozen=True, eq=False)
class Axes:
    """Chosen origin and axes of the world."""

    way: AxesWay = "first"
    board_frame: int = -1  # number of the pictures in which the board lies on the floor
    frame: int = 0
    north: str = ""  # camera in the north for the floor; empty for that of the first view
    floor: Alignment | None = None
    """Alignment by the floor in the recording's depth; None until it is found."""


@dataclass(frozen=True, eq=False)
class Made(Generic[_R]):
    """A result, with the lens model that was chosen and the pictures unticked when it was made."""

    result: _R
    model: str
    unticked: frozenset[Shot]


@dataclass(frozen=True, eq=False)
class Calibration:
    """Everything that the workspace shows is this, or follows from it."""

    step: StepName = "board"
    sources: tuple[Source, ...] = ()
    board: Board = _USUAL
    board_problem: str = ""
    every: int = 1
    model: str = "auto"
    unticked: frozenset[Shot] = frozenset()
    found: Search | None = None
    lenses: Made[Mapping[str, LensResult]] | None = None
    world: Made[World] | None = None
    axes: Axes = field(default_factory=Axes)
    saved_into: tuple[Path, Mapping[str, Camera]] | None = None
    """Folder of the recording that has this calibration, and the cameras."""
    saved: str = ""  # what was saved, as a sentence
    problem: tuple[StepName, InputError] | None = None  # what could not be calculated last
    busy: StepName | None = None
    shot: Shot | None = None
    recording: Recording | None = None

    @cached_property
    def sightings(self) -> tuple[Sightings, ...]:
        if self.found is None:
            return ()
        return tuple(
            one.without_frames(frame for camera, frame in self.unticked if camera == one.camera)
            for one in self.found.sightings
        )

    @cached_property
    def fits(self) -> dict[str, Intrinsics]:
        lenses = {} if self.lenses is None else self.lenses.result
        return {name: one for name, one in lenses.items() if isinstance(one, Intrinsics)}

    @cached_property
    def errors(self) -> dict[Shot, FloatArray]:
        """Errors (n, 2) of the corners in every picture that was used, of the step shown."""
        sightings = [one.sightings for one in self.fits.values()]
        errors: Sequence[FloatArray] = [one.errors for one in self.fits.values()]
        if self.step in ("world", "axes") and self.world is not None:
            sightings, errors = list(self.world.result.sightings), self.world.result.errors
        return {
            (one.camera, int(frame)): error
            for one, own in zip(sightings, errors, strict=True)
            for frame, error in zip(one.frames, own, strict=True)
        }

    @cached_property
    def left_out(self) -> dict[Shot, str]:
        """Why pictures of the board were not used, of the step shown or the search."""
        seen = list(self.found.sightings) if self.found is not None else []
        if self.step in ("world", "axes") and self.world is not None:
            seen += self.world.result.sightings
        elif self.step != "pictures":
            seen += [one.sightings for one in self.fits.values()]
        return {(out.camera, out.frame): out.reason for one in seen for out in one.left_out}

    @cached_property
    def recorded(self) -> dict[str, Camera]:
        views = () if self.recording is None else self.recording.views
        used = {one.camera for view in views for one in view.streams().values() if one.camera}
        cameras = {} if self.recording is None else self.recording.cameras
        return {name: one for name, one in cameras.items() if name in used}

    @cached_property
    def base(self) -> dict[str, Camera]:
        """The cameras whose world is turned: those placed here, else those of the recording."""
        if self.world is not None:
            return {one.name: one for one in self.world.result.cameras}
        guessed = self.recording is None or self.recording.guessed
        return {} if guessed or self.fits else self.recorded

    @property
    def of_recording(self) -> bool:
        return self.world is None and bool(self.base)

    @property
    def board_frames(self) -> tuple[int, ...]:
        if self.world is not None:
            return tuple(self.world.result.boards)
        return tuple(sorted({int(k) for one in self.sightings for k in one.frames}))

    @cached_property
    def alignment(self) -> Alignment | InputError | None:
        if not self.base or self.axes.way == "first":
            return None
        try:
            return self._turned()
        except InputError as error:
            return error

    def _turned(self) -> Alignment:
        if self.axes.way == "board":
            return self._turned_by_board()
        if self.axes.way == "floor":
            if self.axes.floor is not None:
                return self.axes.floor
            what = "no floor is found in the depth of the recording"
            remedy = "Choose another way, or a frame in which much of the floor is seen."
            raise InputError(what, where="axes", remedy=remedy)
        if self.recording is None:
            remedy = "Open the recording of these cameras."
            raise InputError("no recording is open", where="axes", remedy=remedy)
        return from_cameras(self.base, self.recorded)

    def _turned_by_board(self) -> Alignment:
        """By a board on the floor: one that was placed, or that calibrated cameras see."""
        frame, board = self.axes.board_frame, self.found_board
        if self.world is not None and frame in self.world.result.boards:
            return from_board(self.world.result.boards[frame], board.corners)
        seeing = [one for one in self.sightings if frame in one.frames and one.camera in self.base]
        if self.world is not None or not seeing:
            what = "the picture in which the board lies on the floor is not chosen"
            remedy = "Choose it in the list. The board has to be found in the pictures first."
            raise InputError(what, where="axes", remedy=remedy)
        alone = [one.only(np.flatnonzero(one.frames == frame)) for one in seeing]
        return from_board(seen_board(self.base, alone, board).world_from_board, board.corners)

    @property
    def found_board(self) -> Board:
        if self.world is not None:
            return self.world.result.board
        return self.board if self.found is None else self.found.board

    @cached_property
    def new_from_world(self) -> RigidTransform:
        if isinstance(self.alignment, Alignment):
            return self.alignment.new_from_old
        return RigidTransform.identity()

    @cached_property
    def cameras(self) -> dict[str, Camera]:
        """The calibrated cameras in their chosen world; lenses alone where there is one camera."""
        if self.world is not None or isinstance(self.alignment, Alignment):
            return aligned(self.base, self.new_from_world)
        return {name: one.camera for name, one in self.fits.items()} if self.alone else {}

    @cached_property
    def boards(self) -> tuple[RigidTransform, ...]:
        boards = self.world.result.boards if self.world is not None else {}
        return tuple(self.new_from_world @ one for one in boards.values())

    @property
    def alone(self) -> bool:
        return len(self.sources) == 1

    def made(self, result: Any) -> Made[Any]:
        return Made(result, self.model, self.unticked)

    def is_current(self, made: Made[Any] | None) -> bool:
        return made is not None and (made.model, made.unticked) == (self.model, self.unticked)

    def is_done(self, step: StepName) -> bool:
        match step:
            case "board":
                return bool(self.sources) and not self.board_problem
            case "pictures":
                return self.found is not None and any(map(len, self.found.sightings))
            case "lenses":
                wanted = {one.camera for one in self.sources}
                return wanted <= self.fits.keys() and self.is_current(self.lenses)
            case "world":
                return self.is_current(self.world)
            case "axes":
                return bool(self.saved)

    def is_stale(self, step: StepName) -> bool:
        made = {"lenses": self.lenses, "world": self.world}.get(step)
        return made is not None and not self.is_current(made)

    def why_not(self, step: StepName) -> str:
        if self.of_recording and step == "axes":
            return ""
        if step != "board" and not self.is_done("board"):
            return self.board_problem or "Choose the pictures of a camera first."
        if step not in ("board", "pictures") and not self.is_done("pictures"):
            return "Find the board in the pictures first."
        if step == "axes" and self.alone:
            return "" if self.fits else "Calculate the lens first."
        return self._why_no_world(step) if step in ("world", "axes") else ""

    def _why_no_world(self, step: StepName) -> str:
        if self.alone:
            return "One camera has no place relative to others. Add the pictures of another one."
        if self.found is not None and self.found.apart is not None:
            return str(self.found.apart)
        if self.found is not None and self.found.mirrored:
            return "Mirrored pictures have no place in a world. Film again without mirroring."
        if step == "axes" and self.world is None:
            return "Place all cameras first."
        return ""

    def why_not_save(self) -> str:
        done = "changed" if self.of_recording else "calculated"
        return "" if self.cameras else f"Nothing is {done} that could be saved."

    def next_step(self) -> StepName | None:
        return next((one for one in self.later_steps() if not self.why_not(one)), None)

    def later_steps(self) -> list[StepName]:
        order = list(STEPS)
        return order[order.index(self.step) + 1 :]

    def verdict(self, step: StepName) -> Verdict | None:
        if self.problem is not None and self.problem[0] == step:
            return report.of_error(self.problem[1])
        if step == "pictures" and self.found is not None:
            return report.of_search(self.found)
        if step == "lenses" and self.lenses is not None and self.lenses.result:
            return report.of_lenses(self.lenses.result)
        if step == "axes" and isinstance(self.alignment, InputError):
            return report.of_no_alignment(self.alignment)
        if step == "axes" and isinstance(self.alignment, Alignment):
            return report.of_alignment(self.alignment, self.cameras, self.boards)
        if step in ("world", "axes") and self.world is not None:
            return report.of_world(self.world.result)
        return report.of_lenses(self.fits) if step == "axes" and self.fits else None

    def with_input(self, **changed: Any) -> Calibration:
        """The same with other pictures or another board, of which nothing is known yet."""
        unknown = dict.fromkeys(("found", "lenses", "world", "saved_into", "problem", "busy"))
        return replace(self, **{**unknown, "unticked": frozenset(), "saved": "", **changed})


def checked(state: Calibration) -> Mapping[str, Camera]:
    """The cameras to be written. Raises InputError where there are none."""
    if isinstance(state.alignment, InputError):
        raise state.alignment
    if not state.cameras:
        what = "nothing is calculated that could be saved"
        remedy = "Calculate the lenses, and place all cameras."
        raise InputError(what, where="calibration", remedy=remedy)
    return state.cameras


def why_not_into(state: Calibration) -> str:
    """Why the calibration cannot replace that of the open recording."""
    if state.recording is None:
        return "No recording is open."
    if state.world is None and not (state.of_recording and state.cameras):
        return "Place all cameras first, or choose what the world is turned by."
    if isinstance(state.alignment, InputError):
        return f"The world is not turned yet: {state.alignment.what}."
    missing = [name for name in state.recorded if name not in state.cameras]
    if missing:
        return (
            f"The calibration lacks {', '.join(missing)}. Name the cameras as the recording "
            "does: double-click a name in step 1."
        )
    for name, old in state.recorded.items():
        new = state.cameras[name]
        if (new.width, new.height) != (old.width, old.height):
            return (
                f"{name} was calibrated with pictures of {new.width} × {new.height}, the recording "
                f"has {old.width} × {old.height}."
            )
    return ""


@dataclass(frozen=True, eq=False)
class ReadPicture:
    """A picture that was read, or why it was not."""

    source: Source
    frame: int
    name: str
    image: ImageArray | None
    problem: str = ""


class PictureReader:
    """Reads a picture, and keeps its source open; used by one thread."""

    def __init__(self) -> None:
        self._source: Source | None = None
        self._pictures: Pictures | None = None

    def __call__(self, wanted: tuple[Source, int]) -> ReadPicture:
        source, frame = wanted
        try:
            if self._pictures is None or source != self._source:
                if self._pictures is not None:
                    self._pictures.close()
                self._source, self._pictures = source, source.open()
            image = self._pictures.read(frame)
        except (InputError, DamagedFrame) as problem:
            return ReadPicture(source, frame, f"picture {frame}", None, str(problem))
        return ReadPicture(source, frame, self._pictures.name(frame), image)
