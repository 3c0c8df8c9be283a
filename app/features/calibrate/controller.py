"""Carries a calibration from pictures of a board to a calibration.toml."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from stereotrack_core.calibrate import work
from stereotrack_core.calibrate.board import Board
from stereotrack_core.calibrate.work import Source
from stereotrack_core.depth.floor import FindFloor
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.calibration import write_calibration

from ...context import Context
from ...session.changes import RECORDING, Part
from ...session.jobs import Job, LatestOnly, NewestJob, Task
from ...session.replacing import replace_cameras
from .state import (
    DOING,
    STEPS,
    Axes,
    AxesWay,
    Calibration,
    Made,
    PictureReader,
    ReadPicture,
    Shot,
    StepName,
    checked,
    why_not_into,
)


class CalibrationController:
    """Owns the state, and has done what takes time."""

    def __init__(self, context: Context) -> None:
        self._context, self.changes = context, context.session.changes
        self.close_page = context.docks.close_alone
        self.state = Calibration()
        self.picture: ReadPicture | None = None
        title = "read a picture of the board"
        self.reading = LatestOnly(
            context.tasks, PictureReader(), title, self._on_read, lambda *_: None
        )
        self.job = NewestJob(context.tasks)
        self.changes.watch(RECORDING, self._on_recording)
        context.tasks.watch(self.reading.settled)
        context.session.losses.append(self._lost_words)

    def _lost_words(self) -> str:
        state = self.state
        made = state.lenses is not None or state.world is not None
        return "a calibration that is not saved" if made and not state.saved else ""

    def show(self, step: str) -> None:
        if step in STEPS and not self.state.why_not(step):
            self.change(step=step)

    def add_folder(self, folder: Path) -> None:
        """Add all cameras of a folder, or of a recording; those of the same name are replaced."""
        self._context.notifier.attempt(lambda: self._add(work.sources_in(folder)))

    def add_camera(self, place: Path) -> None:
        """Add a video, or a folder of images, as the pictures of one camera named as it is."""
        self._add((Source(place.stem if place.is_file() else place.name, str(place)),))

    def add_recording(self) -> None:
        if self.state.recording is not None:
            self.add_folder(self.state.recording.folder)

    def _add(self, sources: tuple[Source, ...]) -> None:
        known = {one.camera: one for one in (*self.state.sources, *sources)}
        self._begin_anew(sources=tuple(known.values()), shot=None)
        self.choose(sources[0].camera, 0)

    def remove(self, camera: str) -> None:
        left = tuple(one for one in self.state.sources if one.camera != camera)
        self._begin_anew(sources=left)

    def rename(self, camera: str, name: str) -> None:
        """Give a camera another name; one that is taken, or empty, is refused."""
        name = name.strip()
        taken = {one.camera for one in self.state.sources} - {camera}
        if not name or name in taken:
            self._context.notifier.say(f"{name!r} is taken already, or no name. Enter another one.")
            self.changes.tell(Part.CALIBRATION)
            return
        sources = self.state.sources
        renamed = (replace(one, camera=name) if one.camera == camera else one for one in sources)
        self._begin_anew(sources=tuple(renamed))

    def set_board(self, board: Board | None, problem: str = "") -> None:
        """Take the board that is written in the fields, or the reason why it is none."""
        if board is None:
            self._begin_anew(board_problem=problem)
        elif board != self.state.board or self.state.board_problem:
            self._begin_anew(board=board, board_problem="")

    def set_every(self, every: int) -> None:
        if every != self.state.every:
            self._begin_anew(every=every)

    def tick(self, shot: Shot, on: bool) -> None:
        unticked = self.state.unticked - {shot} if on else self.state.unticked | {shot}
        self.change(unticked=unticked, saved="")

    def choose(self, camera: str, frame: int) -> None:
        source = next((one for one in self.state.sources if one.camera == camera), None)
        if source is not None:
            self.reading.ask((source, frame))
            self.change(shot=(camera, frame))

    def _begin_anew(self, **chosen: Any) -> None:
        self.cancel()
        self._put(self.state.with_input(**chosen))

    def change(self, **changed: Any) -> None:
        self._put(replace(self.state, **changed))

    def _put(self, state: Calibration) -> None:
        self.state = state
        self.changes.tell(Part.CALIBRATION)
        self._context.actions.refresh_soon()

    def _on_read(self, _wanted: object, picture: ReadPicture) -> None:
        self.picture = picture
        self.changes.tell(Part.CALIBRATION)

    def why_not_calculate(self) -> str:
        if self.state.busy is not None:
            return "A calculation is running. Stop it first."
        if self.state.step in ("board", "axes"):
            return "Nothing is to be calculated in this step."
        return self.state.why_not(self.state.step)

    def calculate(self) -> None:
        state = self.state
        seen = state.sightings, state.found_board, state.model
        if state.step == "pictures":
            self._put(state.with_input())
            todo = partial(work.find_board_in, state.sources, state.board, state.every)
            self.begin("pictures", todo, self._on_found)
        elif state.step == "lenses":
            lenses = partial(work.fit_lenses, *seen)
            self.begin("lenses", lenses, lambda found: self.change(lenses=state.made(found)))
        elif state.step == "world":
            world = partial(work.fit_world, *seen)
            self.begin("world", world, lambda found: self._on_world(state.made(found)))

    def why_no_next(self) -> str:
        if self.state.busy is not None:
            return "A calculation is running. Stop it first."
        if self.state.next_step() is None:
            later = self.state.later_steps()
            return self.state.why_not(later[0]) if later else "This is the last step."
        return ""

    def go_on(self) -> None:
        step = self.state.next_step()
        if step is None or self.state.busy is not None:
            return
        self.change(step=step)
        if not self.state.is_done(step) and not self.why_not_calculate():
            self.calculate()

    def _on_found(self, found: work.Search) -> None:
        first = next((one for one in found.sightings if len(one)), None)
        self.change(found=found)
        if first is not None:
            self.choose(first.camera, int(first.frames[0]))

    def begin(self, step: StepName, todo: work.Step, done: Callable[[Any], None]) -> None:
        self.cancel()
        process = self._context.session.processes.calibration

        def in_process(own: Task) -> Any:
            return process(
                todo, lambda word: own.report(word.share, word.words), own.token.cancelled,
                listens=step == "pictures",
            )  # fmt: skip

        def fail(error: Exception) -> None:
            if isinstance(error, InputError):
                self.change(problem=(step, error))
            else:
                self._context.notifier.error(error)

        end = partial(self.change, busy=None)
        problem = self.state.problem
        self.change(busy=step, problem=None if problem and problem[0] == step else problem)
        self.job.run(Job(DOING[step], in_process, done, fail, ended=end))

    def cancel(self) -> None:
        if self.job.busy:
            self.job.give_up()
            self.change(busy=None)

    def choose_way(self, way: AxesWay) -> None:
        frames, board_frame = self.state.board_frames, self.state.axes.board_frame
        if way == "board" and board_frame not in frames:
            board_frame = max(frames, default=-1)
        self.turn(way=way, board_frame=board_frame)

    def turn(self, **changed: Any) -> None:
        """Change what the world is turned by; look for the floor where that is needed."""
        if changed.keys() & {"frame", "north"}:
            changed["floor"] = None
        axes = replace(self.state.axes, **changed)
        self.change(axes=axes, saved="", saved_into=None)
        recording, base = self.state.recording, self.state.base
        if axes.way == "floor" and axes.floor is None and recording is not None and base:
            depth = self._context.session.track.settings.depth
            todo = FindFloor(recording.folder, base, depth, axes.frame, axes.north)
            self.begin("axes", todo, lambda found: self.turn(floor=found))

    def _on_world(self, made: Made[Any]) -> None:
        frames = made.result.boards
        before = self.state.axes
        frame = before.board_frame if before.board_frame in frames else max(frames)
        axes = replace(before, board_frame=frame, floor=None)
        fits = {one.camera.name: one for one in made.result.lenses}
        lenses = replace(made, result=fits)  # they are calculated anew with the places
        self.change(world=made, lenses=lenses, axes=axes, saved="", saved_into=None)

    def save(self, path: Path) -> None:
        target = path if path.suffix else path.with_suffix(".toml")
        if self._context.notifier.attempt(lambda: write_calibration(target, checked(self.state))):
            self.change(saved=f"Saved: {path.name}.")

    def save_into_recording(self) -> None:
        """Replace the calibration of the open recording, and open it again."""
        state, session = self.state, self._context.session
        recording = state.recording
        if recording is None or why_not_into(state):
            return

        def write() -> None:
            cameras = checked(state)
            said = replace_cameras(session, cameras, f"Saved into {recording.name}")
            self.change(saved=said.sentence(), saved_into=(recording.folder, cameras))

        self._context.notifier.attempt(write)

    def _on_recording(self) -> None:
        recording = self._context.session.document.recording
        state = self.state
        folder, cameras = state.saved_into or (None, {})
        again = recording is None or recording.folder == folder
        replaced = again and not _are_alike(cameras, recording.cameras if recording else {})
        kept = again and not replaced
        # what was saved is turned already, and what it was before can still be seen
        stays = state.world is not None and (kept or state.axes.way == "board")
        self.change(
            recording=recording, axes=state.axes if stays else Axes(),
            saved_into=state.saved_into if kept else None, saved="" if replaced else state.saved,
        )  # fmt: skip


_AHEAD = np.array([[0.0, 0.0, 1.0], [0.2, 0.0, 1.0], [0.0, 0.2, 1.0]])  # metres, before a camera


def _are_alike(ours: Mapping[str, Camera], theirs: Mapping[str, Camera]) -> bool:
    """Whether cameras of the same name show what is before ours at the same pixels."""
    places = {one: one.world_from_camera.apply(_AHEAD) for one in ours.values()}
    both = ((one, theirs.get(one.name, one), place) for one, place in places.items())
    return all(np.allclose(a.project(place), b.project(place), atol=0.01) for a, b, place in both)
