"""A calibration as far as it is made: what is chosen, what is calculated, and what follows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Generic, Literal, TypeAlias, TypeVar

from stereotrack_core.arrays import FloatArray
from stereotrack_core.calibrate import verdict
from stereotrack_core.calibrate.align import Alignment, aligned, from_cameras
from stereotrack_core.calibrate.board import Board
from stereotrack_core.calibrate.intrinsics import Intrinsics
from stereotrack_core.calibrate.pictures import Looked, Sightings
from stereotrack_core.calibrate.verdict import Verdict
from stereotrack_core.calibrate.work import Found, LensResult, Source
from stereotrack_core.calibrate.world import World
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform

from .axes import (
    Axes,
    alignment_by_board,
    alignment_by_clicks,
    alignment_by_floor,
)

StepName: TypeAlias = Literal["board", "pictures", "lenses", "world", "axes", "save"]
STEPS: dict[StepName, str] = {
    "board": "Board",
    "pictures": "Pictures",
    "lenses": "Lenses",
    "world": "All cameras",
    "axes": "Axes and floor",
    "save": "Save",
}
"""Steps with their titles, in their order."""

DOING: dict[StepName, str] = {
    "board": "Recognising the board",
    "pictures": "Searching for the board",
    "lenses": "Calculating the lenses",
    "world": "Placing all cameras",
    "axes": "Looking for the floor",
}
"""Messages shown while a step is calculated."""

Shot: TypeAlias = tuple[str, int]
"""A picture: the name of its camera and its number."""

_USUAL = Board(9, 6, 0.025)
_R = TypeVar("_R")


@dataclass(frozen=True, eq=False)
class KeptLenses:
    """Lenses that were calibrated before, which stay as they are."""

    file: Path
    cameras: Mapping[str, Camera]


@dataclass(frozen=True, eq=False)
class Made(Generic[_R]):
    """A result, with the lenses that were chosen and the pictures unticked when it was made."""

    result: _R
    model: str
    unticked: frozenset[Shot]
    kept: KeptLenses | None = None


@dataclass(frozen=True)
class Recorded:
    """The open recording, as far as it matters to a calibration."""

    folder: Path
    name: str
    cameras: Mapping[str, Camera] = field(compare=False)
    has_depth: bool = False
    """Whether a view measures depth, in which the floor may be seen."""
    guessed: bool = False
    """Whether the cameras are guessed, so that there is no world to turn."""


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
    kept: KeptLenses | None = None
    """Lenses of a calibration file; those that it lacks are calculated."""
    unticked: frozenset[Shot] = frozenset()
    found: Found | None = None
    lenses: Made[Mapping[str, LensResult]] | None = None
    world: Made[World] | None = None
    axes: Axes = field(default_factory=Axes)
    """What the world is turned by."""
    saved_into: Path | None = None
    """Folder of the recording that has this calibration."""
    saved: str = ""
    """What was saved, as a sentence."""
    problem: tuple[StepName, InputError] | None = None
    """What could not be calculated last."""
    busy: StepName | None = None
    """What is being calculated."""
    looked: Looked | None = None
    """The newest picture that was searched, while the search goes on."""
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
        """Lenses that could be calibrated and are not kept, by camera."""
        lenses = {} if self.lenses is None else self.lenses.result
        return {
            name: one
            for name, one in lenses.items()
            if isinstance(one, Intrinsics) and name not in self.given
        }

    @property
    def given(self) -> dict[str, Camera]:
        """Lenses that are kept, by the camera whose pictures are here."""
        kept = {} if self.kept is None else self.kept.cameras
        return {one.camera: kept[one.camera] for one in self.sources if one.camera in kept}

    @property
    def lens_cameras(self) -> dict[str, Camera]:
        """Cameras whose lens is known, kept or calculated."""
        return {**{name: one.camera for name, one in self.fits.items()}, **self.given}

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
    def base(self) -> dict[str, Camera]:
        """The cameras whose world is turned: those placed here, else those of the recording."""
        if self.world is not None:
            return {one.name: one for one in self.world.result.cameras}
        if self.recording is None or self.recording.guessed or self.lens_cameras:
            return {}
        return dict(self.recording.cameras)

    @property
    def of_recording(self) -> bool:
        """Whether the world of the open recording is turned, with nothing calculated here."""
        return self.world is None and bool(self.base)

    @property
    def board_frames(self) -> tuple[int, ...]:
        """Pictures in which the board may lie on the floor."""
        if self.world is not None:
            return tuple(self.world.result.boards)
        return tuple(sorted({int(k) for one in self.sightings for k in one.frames}))

    @cached_property
    def alignment(self) -> Alignment | InputError | None:
        """How the world is turned; None where it stays as it is."""
        if not self.base or self.axes.way == "first":
            return None
        try:
            return self._turned()
        except InputError as error:
            return error

    def _turned(self) -> Alignment:
        match self.axes.way:
            case "floor":
                return alignment_by_floor(self.axes)
            case "points":
                return alignment_by_clicks(self.axes, self.base)
            case "recording":
                return from_cameras(self.base, self._recorded_cameras())
            case _:
                world = self.world.result if self.world is not None else None
                board = self.board if world is None else world.board
                if world is None and self.found is not None:
                    board = self.found.search.board
                boards = None if world is None else world.boards
                return alignment_by_board(self.axes, self.base, board, boards, self.sightings)

    def _recorded_cameras(self) -> Mapping[str, Camera]:
        if self.recording is None:
            raise InputError(
                "no recording is open", where="axes", remedy="Open the recording of these cameras."
            )
        return self.recording.cameras

    @cached_property
    def new_from_world(self) -> RigidTransform:
        """From the world of the first camera to the chosen one."""
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
        """Places of the boards in the chosen world."""
        boards = self.world.result.boards if self.world is not None else {}
        return tuple(self.new_from_world @ one for one in boards.values())

    @property
    def alone(self) -> bool:
        """Whether there is one camera, which has no place relative to others."""
        return len(self.sources) == 1

    def is_current(self, made: Made[Any] | None) -> bool:
        """Whether a result is there, and of what is chosen and ticked now."""
        return made is not None and (made.model, made.unticked, made.kept) == (
            self.model, self.unticked, self.kept,
        )  # fmt: skip

    # ---- steps

    def is_done(self, step: StepName) -> bool:
        """Whether a step has its tick."""
        match step:
            case "board":
                return bool(self.sources) and not self.board_problem
            case "pictures":
                return self.found is not None and any(map(len, self.found.search.sightings))
            case "lenses":
                wanted = {one.camera for one in self.sources} - self.given.keys()
                if not wanted:
                    return self.is_done("pictures")
                return wanted <= self.fits.keys() and self.is_current(self.lenses)
            case "world":
                return self.is_current(self.world)
            case "axes":
                turned = isinstance(self.alignment, Alignment)
                if self.of_recording:
                    return turned
                return self.is_done("world") and (turned or self.axes.way == "first")
            case "save":
                return bool(self.saved)

    def is_stale(self, step: StepName) -> bool:
        """Whether a step was calculated before other pictures were ticked."""
        made = {"lenses": self.lenses, "world": self.world}.get(step)
        return made is not None and not self.is_current(made)

    def why_not(self, step: StepName) -> str:
        """Why a step cannot be taken now; empty where it can."""
        if self.of_recording and step in ("axes", "save"):
            turned = step == "axes" or bool(self.cameras) or bool(self.saved)
            return "" if turned else "Nothing is changed that could be saved."
        order = list(STEPS)
        needed: dict[StepName, str] = {
            "board": self.board_problem or "Choose the pictures of a camera first.",
            "pictures": "Find the board in the pictures first.",
        }
        for earlier, words in needed.items():
            if order.index(step) > order.index(earlier) and not self.is_done(earlier):
                return words
        if step in ("world", "axes"):
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
        lenses = {} if self.lenses is None else self.lenses.result
        if step == "lenses" and (own := {k: v for k, v in lenses.items() if k not in self.given}):
            return verdict.of_lenses(own)
        if step in ("axes", "save") and isinstance(self.alignment, InputError):
            return verdict.of_no_alignment(self.alignment)
        if isinstance(self.alignment, Alignment) and (step == "axes" or self.of_recording):
            return verdict.of_alignment(self.alignment, self.cameras)
        if step in ("world", "axes", "save") and self.world is not None:
            return verdict.of_world(self.world.result)
        if step == "save" and self.fits:
            return verdict.of_lenses(self.fits)
        return None

    # ---- changes

    def with_input(self, **changed: object) -> Calibration:
        """The same with other pictures or another board, of which nothing is known yet."""
        fresh = Calibration(recording=self.recording, model=self.model, kept=self.kept)
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
