"""Carries a calibration from pictures of a board to a calibration.toml."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from PySide6.QtCore import QObject, Signal, Slot

from stereotrack_core.calibrate import work
from stereotrack_core.calibrate.board import Board
from stereotrack_core.calibrate.work import LookedAt, Progress, Source
from stereotrack_core.errors import InputError
from stereotrack_core.recording.calibration import read_calibration
from stereotrack_core.recording.description import Recording

from ...context import Context
from ...services.tasks.task import Task
from . import saving
from .axes import Axes
from .saving import PictureReading
from .state import DOING, STEPS, Calibration, KeptLenses, Made, Recorded, Shot, StepName


class CalibrationController(QObject):
    """Owns the state, and has done what takes time.

    Signals
    -------
    changed : ()
        :attr:`state` is another one.
    progressed : float, str
        How far the work is; 0 where nobody knows.
    """

    changed = Signal()
    progressed = Signal(float, str)

    def __init__(self, context: Context) -> None:
        super().__init__(context.session)
        self._context = context
        self.state = Calibration()
        self.reading = PictureReading(self)
        self._task: Task | None = None
        session = context.session
        session.opened.connect(self._on_recording)
        session.closed.connect(self._on_recording)
        session.closing.connect(self._on_closing)
        context.tasks.watch(self.reading.settled)

    # ---- what is chosen

    def show(self, step: str) -> None:
        """Show a step."""
        if step in STEPS and not self.state.why_not(step):
            self.change(step=step)

    def add_folder(self, folder: Path) -> None:
        """Add all cameras of a folder, or of a recording; those of the same name are replaced."""
        self._context.notifier.attempt(lambda: self._add(work.sources_in(folder)))

    def add_camera(self, place: Path) -> None:
        """Add a video, or a folder of images, as the pictures of one camera named as it is."""
        self._add((Source(place.stem if place.is_file() else place.name, str(place)),))

    def add_recording(self) -> None:
        """Add the cameras of the open recording."""
        if self.state.recording is not None:
            self.add_folder(self.state.recording.folder)

    def _add(self, sources: tuple[Source, ...]) -> None:
        known = {one.camera: one for one in (*self.state.sources, *sources)}
        self._begin_anew(sources=tuple(known.values()), shot=None)
        self.choose(sources[0].camera, 0)

    def remove(self, camera: str) -> None:
        """Leave a camera out."""
        left = tuple(one for one in self.state.sources if one.camera != camera)
        self._begin_anew(sources=left)

    def rename(self, camera: str, name: str) -> None:
        """Give a camera another name; one that is taken, or empty, is refused."""
        name = name.strip()
        taken = {one.camera for one in self.state.sources} - {camera}
        if not name or name in taken:
            self._context.notifier.say(f"{name!r} is taken already, or no name. Enter another one.")
            self.changed.emit()
            return
        self._begin_anew(
            sources=tuple(
                Source(name, one.place) if one.camera == camera else one
                for one in self.state.sources
            )
        )

    def set_board(self, board: Board | None, problem: str = "") -> None:
        """Take the board that is written in the fields, or the reason why it is none."""
        if board is None:
            self._begin_anew(board_problem=problem)
        elif board != self.state.board or self.state.board_problem:
            self._begin_anew(board=board, board_problem="")

    def set_every(self, every: int) -> None:
        """Use only every so many pictures."""
        if every != self.state.every:
            self._begin_anew(every=every)

    def set_model(self, model: str) -> None:
        """Choose a lens model."""
        self.change(model=model, saved="")

    def tick(self, shot: Shot, on: bool) -> None:
        """Use a picture, or leave it out."""
        unticked = self.state.unticked - {shot} if on else self.state.unticked | {shot}
        self.change(unticked=unticked, saved="")

    def choose(self, camera: str, frame: int) -> None:
        """Show a picture."""
        source = next((one for one in self.state.sources if one.camera == camera), None)
        if source is not None:
            self.reading.ask(source, frame)
            self.change(shot=(camera, frame))

    def keep_lenses(self, file: Path | None) -> None:
        """Keep the lenses of a calibration file, or calculate all of them."""
        if file is None:
            self.change(kept=None, saved="")
        else:
            self._context.notifier.attempt(lambda: self._keep(file))

    def _keep(self, file: Path) -> None:
        kept = KeptLenses(file, read_calibration(file))
        names = [one.camera for one in self.state.sources]
        if not kept.cameras.keys() & set(names):
            raise InputError(
                f"it has none of the cameras {', '.join(names)}",
                where=str(file),
                remedy="Name the cameras as in the file: double-click a name in step 1. The file "
                f"has {', '.join(kept.cameras)}.",
            )
        self.change(kept=kept, saved="")

    def _begin_anew(self, **chosen: object) -> None:
        self.cancel()
        self._put(self.state.with_input(**chosen))

    def change(self, **changed: Any) -> None:
        """Change fields of the state."""
        self._put(replace(self.state, **changed))

    def _put(self, state: Calibration) -> None:
        self.state = state
        self.changed.emit()
        self._context.actions.refresh_soon()

    # ---- what is calculated

    def why_not_calculate(self) -> str:
        """Why the step that is shown cannot be calculated now."""
        if self.state.busy is not None:
            return "A calculation is running. Stop it first."
        if self.state.step in ("axes", "save"):
            return "Nothing is to be calculated in this step."
        given, sources = self.state.given, self.state.sources
        if self.state.step == "lenses" and given and len(given) == len(sources):
            return "All lenses are kept as they are."
        return self.state.why_not(self.state.step) or (
            self.state.why_not("pictures") if self.state.step == "board" else ""
        )

    def calculate(self) -> None:
        """Calculate the step that is shown."""
        match self.state.step:
            case "board":
                self.recognise()
            case "pictures":
                self.find()
            case "lenses":
                self._fit_lenses()
            case "world":
                self._fit_world()

    def why_no_next(self) -> str:
        """Why there is no step after the one that is shown."""
        if self.state.busy is not None:
            return "A calculation is running. Stop it first."
        if self.state.next_step() is None:
            order = list(STEPS)
            later = order[order.index(self.state.step) + 1 :]
            return self.state.why_not(later[0]) if later else "This is the last step."
        return ""

    def go_on(self) -> None:
        """Show the next step, and calculate it where that is still to be done."""
        step = self.state.next_step()
        if step is None or self.state.busy is not None:
            return
        self.change(step=step)
        if not self.state.is_done(step) and not self.why_not_calculate():
            self.calculate()

    def recognise(self) -> None:
        """Tell the board from the first pictures of the cameras."""
        todo = work.RecogniseBoard(self.state.sources, self.state.board)
        self.begin("board", todo, self._on_recognised)

    def find(self) -> None:
        """Look for the board in all pictures."""
        state = self._changed_input()
        todo = work.FindBoard(state.sources, state.board, state.every)
        self.begin("pictures", todo, self._on_found)

    def _on_found(self, found: work.Found) -> None:
        first = next((one for one in found.search.sightings if len(one)), None)
        self.change(found=found, looked=None)
        if first is not None:
            self.choose(first.camera, int(first.frames[0]))

    def _changed_input(self) -> Calibration:
        self.state = self.state.with_input(recognised=self.state.recognised)
        return self.state

    def _fit_lenses(self) -> None:
        state = self.state
        sightings = tuple(one for one in state.sightings if one.camera not in state.given)
        todo = work.FitLenses(sightings, self._found_board(), state.model)
        self.begin("lenses", todo, lambda result: self.change(lenses=self._made(result, state)))

    def _fit_world(self) -> None:
        state = self.state
        todo = work.FitWorld(state.sightings, self._found_board(), state.model, state.given)
        self.begin("world", todo, lambda result: self._on_world(self._made(result, state)))

    def _found_board(self) -> Board:
        found = self.state.found
        return self.state.board if found is None else found.search.board

    @staticmethod
    def _made(result: Any, state: Calibration) -> Made[Any]:
        return Made(result, state.model, state.unticked, state.kept)

    def begin(self, step: StepName, todo: work.Step, done: Callable[[Any], None]) -> None:
        """Have a task done for a step, instead of what is being calculated."""
        self.cancel()
        process = self._context.session.processes.calibration
        task = Task(DOING[step], lambda own: process(todo, own.tell, own.token.cancelled))

        def finished(result: Any) -> None:
            if task is self._task:
                self._end()
                done(result)

        def failed(error: Exception) -> None:
            if task is not self._task:
                return
            self._end()
            if isinstance(error, InputError):
                self.change(problem=(step, error))
            else:
                self._context.notifier.error(error)

        task.finished.connect(finished)
        task.failed.connect(failed)
        task.stopped.connect(lambda: self._end() if task is self._task else None)
        task.told.connect(lambda words: self._hear(task, words))
        self._task = task
        problem = self.state.problem
        self.change(busy=step, problem=None if problem and problem[0] == step else problem)
        self.progressed.emit(0.0, DOING[step])
        self._context.tasks.start(task)

    def _end(self) -> None:
        self._task = None
        self.change(busy=None)

    def cancel(self) -> None:
        """Stop what is being calculated; what was calculated before stays."""
        if self._task is not None:
            task, self._task = self._task, None
            task.cancel()
            self.change(busy=None, looked=None)

    def _hear(self, task: Task, words: list[Any]) -> None:
        if task is not self._task:
            return
        for word in words:
            if isinstance(word, Progress):
                self._tell(task, word.share, word.words)
        looked = [word for word in words if isinstance(word, LookedAt)]
        if looked:
            last = looked[-1]
            said = f"{last.looked.camera}, {last.looked.name}"
            self._tell(task, last.done / max(last.count, 1), said)
            shown = next((o.looked for o in reversed(looked) if o.looked.image is not None), None)
            self.change(looked=shown or self.state.looked)

    def _tell(self, task: Task, share: float, words: str) -> None:
        task.report(share, words)
        self.progressed.emit(share, f"{task.title}: {words}")

    def _on_recognised(self, found: Any) -> None:
        words = f"{found.board.words[:1].upper()}{found.board.words[1:]}"
        said = f"{words}: {'; '.join(found.differences) or 'as described'}."
        self._put(self.state.with_input(board=found.board, board_problem="", recognised=said))

    # ---- the world

    def _on_world(self, made: Made[Any]) -> None:
        frames = made.result.boards
        before = self.state.axes
        frame = before.board_frame if before.board_frame in frames else max(frames)
        axes = replace(before, board_frame=frame, floor=None)
        self.change(world=made, axes=axes, saved="", saved_into=None)

    def save(self, path: Path) -> None:
        """Write the calibration."""
        notifier = self._context.notifier

        def write() -> None:
            saving.write_to(self.state, path)
            self.change(saved=f"Saved: {path.name}.")

        notifier.attempt(write)

    def save_into_recording(self) -> None:
        """Replace the calibration of the open recording, and open it again."""
        state = self.state
        if state.recording is None or saving.why_not_into(state):
            return
        recording = state.recording

        def write() -> None:
            kept = saving.save_into(state, recording)
            words = f"Saved into {recording.name}. The calibration before is {kept.name}."
            self.change(saved=words, saved_into=recording.folder)
            self._context.session.opening.open(recording.folder, workspace="calibrate")

        self._context.notifier.attempt(write)

    def close_page(self) -> None:
        """Go back to the welcome page; the calibration stays as far as it is."""
        self._context.docks.close_alone()

    # ---- the session

    @Slot()
    def _on_recording(self) -> None:
        recording = self._context.session.document.recording
        known = None if recording is None else _recorded(recording)
        before = self.state.axes
        if known is None or known.folder == self.state.saved_into:
            axes = Axes() if self.state.world is None else before  # it is turned already
            self.change(recording=known, axes=axes)  # what it was before can still be seen
            return
        axes = before if before.way == "board" and self.state.world is not None else Axes()
        self.change(recording=known, axes=axes, saved_into=None)

    @Slot()
    def _on_closing(self) -> None:
        self.cancel()
        self.reading.close()


def _recorded(recording: Recording) -> Recorded:
    """What matters of a recording: the cameras that its views use."""
    views = recording.views
    used = {stream.camera for view in views for stream in view.streams().values() if stream.camera}
    return Recorded(
        recording.folder,
        recording.name,
        {name: one for name, one in recording.cameras.items() if name in used},
        any(view.kind != "mono" for view in views),
        recording.guessed,
    )
