"""Chooses what the world is turned by: the floor, a board, clicked points, or a person."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from PySide6.QtCore import QObject, Signal, Slot

from stereotrack_core.calibrate.align import POINTS
from stereotrack_core.calibrate.work import Source
from stereotrack_core.depth.floor import FindFloor
from stereotrack_core.interop.landmark_file import Stated
from stereotrack_core.interop.run_file import read_trajectory
from stereotrack_core.recording.landmarks import LandmarkTrajectory

from ...context import Context
from ...session.edits import WindowEdit
from ...session.project_opening import message_of_finding
from ...session.truth import Truth
from .axes import AxesWay, Person, PointClicks
from .controller import CalibrationController
from .reading import PictureReading, ReadPicture

FILE = "file"
"""Key of landmarks that are read from a file."""


class AligningController(QObject):
    """Changes what a calibration's world is turned by; clicks can be undone."""

    read = Signal()
    """Another picture for clicking is there."""

    def __init__(self, context: Context, calibration: CalibrationController) -> None:
        super().__init__(context.session)
        self._context, self._calibration = context, calibration
        self._reading = PictureReading(self)
        self._reading.read.connect(self._on_read)
        self.picture: ReadPicture | None = None
        """The picture that was read last."""
        context.session.closing.connect(self._reading.close)
        context.tasks.watch(self._reading.settled)

    def choose(self, way: AxesWay) -> None:
        """Choose what the world is turned by."""
        state = self._calibration.state
        changed: dict[str, Any] = {"way": way}
        if way == "board" and state.axes.board_frame not in state.board_frames:
            changed["board_frame"] = max(state.board_frames, default=-1)
        if way == "points" and state.axes.camera not in state.base:
            changed["camera"] = next(iter(state.base), "")
        self.change(**changed)
        if way == "floor" and state.axes.floor is None:
            self.find_floor()
        if way == "points":
            self._ask()

    def choose_board(self, frame: int) -> None:
        """Take the board of other pictures."""
        self.change(board_frame=frame)

    def choose_frame(self, frame: int) -> None:
        """Take another frame for the floor, or for clicking its points."""
        self.change(frame=frame, floor=None)
        if self._calibration.state.axes.way == "floor":
            self.find_floor()
        else:
            self._ask()

    def choose_north(self, camera: str) -> None:
        """Let another camera stand in the north."""
        self.change(north=camera, floor=None)
        if self._calibration.state.axes.way == "floor":
            self.find_floor()

    def change(self, **changed: Any) -> None:
        """Change what is chosen."""
        axes = replace(self._calibration.state.axes, **changed)
        self._calibration.change(axes=axes, saved="", saved_into=None)

    def find_floor(self) -> None:
        """Look for the floor in a frame of the recording."""
        state, track = self._calibration.state, self._context.session.track
        if state.recording is None or not state.base:
            return
        todo = FindFloor(
            state.recording.folder, state.base, track.settings.depth, state.axes.frame,
            state.axes.north,
        )  # fmt: skip
        self._calibration.begin("axes", todo, lambda found: self.change(floor=found))

    # ---- points of the floor

    def show_camera(self, camera: str) -> None:
        """Show the picture of another camera, and offer the first point that it lacks."""
        self.change(camera=camera)
        axes = self._calibration.state.axes
        self.change(point=axes.next_point(axes.clicks))
        self._ask()

    def choose_point(self, point: str) -> None:
        """Let the next click place another point."""
        self.change(point=point)

    def click(self, point: str, x: float, y: float) -> None:
        """Place a point in the picture that is shown."""
        axes = self._calibration.state.axes
        clicks = axes.with_click(axes.camera, point, (x, y))
        self._edit(f"Place {point} in {axes.camera}", clicks)
        self.change(point=axes.next_point(clicks))

    def remove(self, point: str) -> None:
        """Take a click away from the picture that is shown."""
        axes = self._calibration.state.axes
        if axes.camera in axes.clicked_in(point):
            clicks = axes.with_click(axes.camera, point, None)
            self._edit(f"Remove {point} in {axes.camera}", clicks)

    def clear(self) -> None:
        """Take all clicks away."""
        self._edit("Remove the clicked points", {})
        self.change(point=POINTS[0])

    def _edit(self, words: str, clicks: PointClicks) -> None:
        before = self._calibration.state.axes.clicks
        edit = WindowEdit(words, self._put_clicks, before, clicks, "calibrate", is_data=True)
        self._context.session.edits.do(edit)

    def _put_clicks(self, clicks: PointClicks) -> None:
        self.change(clicks=clicks)

    def source_of(self, camera: str) -> Source | None:
        """Where the pictures of a camera are: those of the board, or the recording's."""
        state = self._calibration.state
        if not state.of_recording:
            return next((one for one in state.sources if one.camera == camera), None)
        return Source(camera, str(state.recording.folder)) if state.recording else None

    def _ask(self) -> None:
        axes = self._calibration.state.axes
        source = self.source_of(axes.camera)
        if source is not None:
            self._reading.ask(source, axes.frame)

    @Slot(object)
    def _on_read(self, read: ReadPicture) -> None:
        self.picture = read
        self.read.emit()

    # ---- a person

    def persons(self) -> dict[str, str]:
        """Whose landmarks there are to choose from: keys with words."""
        session = self._context.session
        runs = {f"run {one.name}": f"Run {one.name}" for one in session.runs.entries if one.frames}
        truth = session.judging.truth
        reference = {"reference": _upper(truth.words)} if truth is not None else {}
        return {**runs, **reference, FILE: "A file …"}

    def choose_person(self, key: str) -> None:
        """Take the landmarks of a run, or of the reference."""
        trajectory = self._trajectory(key)
        if trajectory is not None:
            self._take(Person(key, trajectory, in_recording=True))

    def _trajectory(self, key: str) -> LandmarkTrajectory | None:
        session = self._context.session
        truth: Truth | None = session.judging.truth
        if key == "reference":
            return None if truth is None else truth.trajectory
        entry = next((one for one in session.runs.entries if f"run {one.name}" == key), None)
        return None if entry is None else entry.trajectory()

    def read_person(self, path: Path) -> None:
        """Take landmarks or a run from a file, which are in the world that is turned."""
        recording = self._context.session.document.recording

        def read(_task: object) -> Person:
            found = read_trajectory(path, Stated(tilted=True))
            if recording is not None:
                found = found.at_rate(recording.fps, path.name)
            return Person(f"{FILE} {path.name}", found, in_recording=False)

        self._context.tasks.begin(f"reading {path.name}", read, self._take)

    @Slot(object)
    def _take(self, person: Person) -> None:
        for note in person.trajectory.notes:
            self._context.session.message.emit(message_of_finding(note))
        numbers = person.trajectory.frame
        frames = (int(numbers.min()), int(numbers.max())) if len(numbers) else None
        self.change(person=person, frames=frames)


def _upper(words: str) -> str:
    return words[:1].upper() + words[1:]
