"""A calibration as far as it is made: what is chosen, what is calculated, and what follows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Generic, Literal, TypeAlias, TypeVar

from stereotrack_core.arrays import FloatArray
from stereotrack_core.calibrate import verdict
from stereotrack_core.calibrate.align import Alignment, aligned, from_board, from_cameras
from stereotrack_core.calibrate.board import Board
from stereotrack_core.calibrate.changes import CameraChange
from stereotrack_core.calibrate.intrinsics import Intrinsics
from stereotrack_core.calibrate.pairs import PairFit
from stereotrack_core.calibrate.pictures import Looked
from stereotrack_core.calibrate.sightings import Sightings
from stereotrack_core.calibrate.verdict import Verdict
from stereotrack_core.calibrate.work import Found, LensResult, Source
from stereotrack_core.calibrate.world import World
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform

StepName: TypeAlias = Literal["board", "pictures", "lenses", "pairs", "world", "axes", "save"]
STEPS: dict[StepName, str] = {
    "board": "Board",
    "pictures": "Pictures",
    "lenses": "Lenses",
    "pairs": "Pairs",
    "world": "All cameras",
    "axes": "Axes and floor",
    "save": "Save",
}
"""Steps with their titles, in their order."""

Shot: TypeAlias = tuple[str, int]
"""A picture: the name of its camera and its number."""
AxesWay: TypeAlias = Literal["first", "board", "floor", "recording"]

_USUAL = Board(9, 6, 0.025)
_R = TypeVar("_R")


@dataclass(frozen=True, eq=False)
class Made(Generic[_R]):
    """A result, with the lens model and the unticked pictures that it was made with."""

    result: _R
    model: str
    unticked: frozenset[Shot]


@dataclass(frozen=True)
class Recorded:
    """The open recording, as far as it matters to a calibration."""

    folder: Path
    name: str
    cameras: Mapping[str, Camera] = field(compare=False)
    stereo: tuple[tuple[str, str], ...] = ()
    """Left and right cameras of its stereo views."""
    has_depth: bool = False
    """Whether a view measures depth, in which the floor may be seen."""


@dataclass(frozen=True, eq=False)
class Calibration:
    """Everything that the workspace shows is this, or follows from it."""

    step: StepName = "board"
    """The one that is shown."""
    sources: tuple[Source, ...] = ()
    board: Board = _USUAL
    board_problem: str = ""
    """Why what is written in the fields is no board."""
    recognised: str = ""
    """What the pictures showed of the board, as a sentence."""
    every: int = 1
    model: str = "auto"
    unticked: frozenset[Shot] = frozenset()
    found: Found | None = None
    lenses: Made[Mapping[str, LensResult]] | None = None
    pairs: Made[tuple[PairFit, ...]] | None = None
    world: Made[World] | None = None
    axes: AxesWay = "first"
    floor_frame: int = -1
    """Number of the pictures in which the board lies on the floor."""
    floor: Alignment | None = None
    """That of the floor in the depth of the open recording."""
    changes: tuple[CameraChange, ...] = ()
    """Against the open recording, as it was before the calibration was saved into it."""
    saved_into: Path | None = None
    """Folder of the recording that has this calibration."""
    saved: str = ""
    """What was saved, as a sentence."""
    problem: tuple[StepName, InputError] | None = None
    """What could not be calculated last."""
    busy: StepName | None = None
    """What is being calculated."""
    looked: tuple[Looked, ...] = ()
    """Pictures that were searched so far, without their pixels but for the last that has them."""
    shot: Shot | None = None
    """The picture that is shown."""
    recording: Recorded | None = None

    # ---- what follows

    @cached_property
    def sightings(self) -> tuple[Sightings, ...]:
        """What is ticked of what was found."""
        if self.found is None:
            return ()
        return tuple(
            one.without_frames(frame for camera, frame in self.unticked if camera == one.camera)
            for one in self.found.search.sightings
        )

    @cached_property
    def fits(self) -> dict[str, Intrinsics]:
        """Lenses that could be calibrated, by camera."""
        lenses = {} if self.lenses is None else self.lenses.result
        return {name: one for name, one in lenses.items() if isinstance(one, Intrinsics)}

    @property
    def errors(self) -> dict[Shot, FloatArray]:
        """Errors (n, 2) of the corners in every picture that was used, of the step shown."""
        if self.step in ("world", "axes", "save") and self.world is not None:
            return self._world_errors
        return self._lens_errors

    @cached_property
    def _lens_errors(self) -> dict[Shot, FloatArray]:
        return _by_shot([one.sightings for one in self.fits.values()],
                        [one.errors for one in self.fits.values()])  # fmt: skip

    @cached_property
    def _world_errors(self) -> dict[Shot, FloatArray]:
        if self.world is None:
            return {}
        return _by_shot(self.world.result.sightings, self.world.result.errors)

    @cached_property
    def left_out(self) -> dict[Shot, str]:
        """Why pictures of the board were not used, of the step shown or the search."""
        seen = list(self.found.search.sightings) if self.found is not None else []
        if self.step in ("world", "axes", "save") and self.world is not None:
            seen += self.world.result.sightings
        elif self.step != "pictures":
            seen += [one.sightings for one in self.fits.values()]
        return {(out.camera, out.frame): out.reason for one in seen for out in one.left_out}

    @cached_property
    def alignment(self) -> Alignment | InputError | None:
        """How the world is turned; None where it stays that of the first camera."""
        world = self.world.result if self.world is not None else None
        if world is None or self.axes == "first":
            return None
        try:
            if self.axes == "recording":
                return self._as_recorded(world)
            if self.axes == "floor":
                return self._to_floor()
            return self._on_floor(world)
        except InputError as error:
            return error

    def _on_floor(self, world: World) -> Alignment:
        board = world.boards.get(self.floor_frame)
        if board is None:
            raise InputError(
                "the picture in which the board lies on the floor is not chosen",
                where="axes",
                remedy="Choose it in the list.",
            )
        return from_board(board, world.board.corners)

    def _to_floor(self) -> Alignment:
        if self.floor is None:
            raise InputError(
                "no floor is found in the depth of the recording",
                where="axes",
                remedy="Choose another way, or a frame in which much of the floor is seen.",
            )
        return self.floor

    def _as_recorded(self, world: World) -> Alignment:
        if self.recording is None:
            raise InputError(
                "no recording is open", where="axes", remedy="Open the recording of these cameras."
            )
        return from_cameras({one.name: one for one in world.cameras}, self.recording.cameras)

    @cached_property
    def new_from_world(self) -> RigidTransform:
        """From the world of the first camera to the chosen one."""
        if isinstance(self.alignment, Alignment):
            return self.alignment.new_from_old
        return RigidTransform.identity()

    @cached_property
    def cameras(self) -> dict[str, Camera]:
        """The calibrated cameras in their chosen world; lenses alone where there is one camera."""
        if self.world is not None:
            found = {one.name: one for one in self.world.result.cameras}
            return aligned(found, self.new_from_world)
        return {name: one.camera for name, one in self.fits.items()} if self.alone else {}

    @cached_property
    def boards(self) -> tuple[RigidTransform, ...]:
        """Places of the boards in the chosen world."""
        boards = self.world.result.boards if self.world is not None else {}
        return tuple(self.new_from_world @ one for one in boards.values())

    @property
    def alone(self) -> bool:
        """Whether there is one camera, which has no place relative to others."""
        return len(self.sources) == 1

    def is_current(self, made: Made[Any] | None) -> bool:
        """Whether a result is there, and of what is chosen and ticked now."""
        return made is not None and made.model == self.model and made.unticked == self.unticked

    # ---- steps

    def is_done(self, step: StepName) -> bool:
        """Whether a step has its tick."""
        match step:
            case "board":
                return bool(self.sources) and not self.board_problem
            case "pictures":
                return self.found is not None and any(map(len, self.found.search.sightings))
            case "lenses":
                all_there = self.lenses is not None and len(self.fits) == len(self.sources)
                return all_there and self.is_current(self.lenses)
            case "pairs":
                placed = self.pairs is not None and any(not p.problem for p in self.pairs.result)
                return placed and self.is_current(self.pairs)
            case "world":
                return self.is_current(self.world)
            case "axes":
                turned = isinstance(self.alignment, Alignment)
                return self.is_done("world") and (turned or self.axes == "first")
            case "save":
                return bool(self.saved)

    def is_stale(self, step: StepName) -> bool:
        """Whether a step was calculated before other pictures were ticked."""
        made = {"lenses": self.lenses, "pairs": self.pairs, "world": self.world}.get(step)
        return made is not None and not self.is_current(made)

    def why_not(self, step: StepName) -> str:
        """Why a step cannot be taken now; empty where it can."""
        order = list(STEPS)
        needed: dict[StepName, str] = {
            "board": self.board_problem or "Choose the pictures of a camera first.",
            "pictures": "Find the board in the pictures first.",
        }
        for earlier, words in needed.items():
            if order.index(step) > order.index(earlier) and not self.is_done(earlier):
                return words
        if step in ("pairs", "world", "axes"):
            return self._why_no_world(step)
        if step == "save" and not self.cameras:
            return "Nothing is calculated that could be saved."
        return ""

    def _why_no_world(self, step: StepName) -> str:
        if self.alone:
            return "One camera has no place relative to others. Add the pictures of another one."
        if self.found is not None and self.found.apart is not None:
            return str(self.found.apart)
        if self.found is not None and self.found.search.mirrored:
            return "Mirrored pictures have no place in a world. Film again without mirroring."
        if step == "pairs" and not self.fits:
            return "Calculate the lenses first."
        if step == "axes" and self.world is None:
            return "Place all cameras first."
        return ""

    def next_step(self) -> StepName | None:
        """The step after the one that is shown which can be taken."""
        order = list(STEPS)
        later = order[order.index(self.step) + 1 :]
        return next((one for one in later if not self.why_not(one)), None)

    def verdict(self, step: StepName) -> Verdict | None:
        """What a step has come to; None where it has not been taken."""
        if self.problem is not None and self.problem[0] == step:
            return verdict.of_error(self.problem[1])
        if step == "pictures" and self.found is not None:
            return verdict.of_search(self.found.search, self.found.apart)
        if step == "lenses" and self.lenses is not None:
            return verdict.of_lenses(self.lenses.result)
        if step == "pairs" and self.pairs is not None:
            return verdict.of_pairs(self.pairs.result)
        if step == "axes" and isinstance(self.alignment, InputError):
            return verdict.of_error(self.alignment)
        if step in ("world", "axes", "save") and self.world is not None:
            return verdict.of_world(self.world.result)
        if step == "save" and self.fits:
            return verdict.of_lenses(self.fits)
        return None

    # ---- changes

    def with_input(self, **changed: object) -> Calibration:
        """The same with other pictures or another board, of which nothing is known yet."""
        fresh = Calibration(recording=self.recording, model=self.model)
        kept = {
            "step": self.step,
            "sources": self.sources,
            "board": self.board,
            "board_problem": self.board_problem,
            "every": self.every,
            "axes": self.axes,
            "shot": self.shot,
        }
        return replace(fresh, **{**kept, **changed})  # type: ignore[arg-type]


def _by_shot(
    sightings: Sequence[Sightings], errors: Sequence[FloatArray]
) -> dict[Shot, FloatArray]:
    return {
        (one.camera, int(frame)): error
        for one, own in zip(sightings, errors, strict=True)
        for frame, error in zip(one.frames, own, strict=True)
    }
