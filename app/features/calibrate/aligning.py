"""Chooses what the world is turned by: the floor, a board, or clicked points."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from PySide6.QtCore import QObject, Signal, Slot

from stereotrack_core.calibrate.align import POINTS
from stereotrack_core.calibrate.work import Source
from stereotrack_core.depth.floor import FindFloor

from ...context import Context
from ...session.edits import WindowEdit
from .axes import AxesWay, PointClicks
from .controller import CalibrationController
from .saving import PictureReading, ReadPicture


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
        edit = WindowEdit(words, self._put_clicks, before, clicks, "calibrate")
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
