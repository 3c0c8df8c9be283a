"""What is known about the frame that is shown, brought together when something has changed."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QObject, QTimer, Signal, Slot

from stereotrack_core.body.mesh import PartMesh, body_mesh
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.recording.keypoints import Keypoints
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.tracking.estimate import Correspondences
from stereotrack_core.tracking.frame import TrackedFrame

from ..widgets.style.colours import LineStyle
from .clouds import CloudPresenter
from .document import DocumentPresenter
from .judgement import reference_at
from .keypoints import KeypointPresenter
from .pictures import Ghost, Instant, StepDrawing
from .runs import RunList
from .tracking import TrackPresenter
from .view_state import ViewState

_DEPTH_KINDS = {"disparity", "foreground", "depth"}
_AROUND = 16
_AROUND_GHOST = 10


class InstantPresenter(QObject):
    """Waits until what the views need is there, then tells it once."""

    ready = Signal(object)
    """Everything about one frame; all views show it together."""

    def __init__(
        self,
        document: DocumentPresenter,
        clouds: CloudPresenter,
        runs: RunList,
        track: TrackPresenter,
        keypoints: KeypointPresenter,
        view_state: ViewState,
        parent: QObject,
    ) -> None:
        super().__init__(parent)
        self._keypoints = keypoints
        keypoints.changed.connect(self.tell_soon)
        self._document, self._clouds, self._runs, self._track = document, clouds, runs, track
        self._view_state = view_state
        self._newest: TrackedFrame | None = None
        self.reference: LandmarkTrajectory | None = None
        """Shown instead of the recording's own."""
        self.is_old: Callable[[int], bool] = lambda _frame: False
        """Whether it was fitted before the last click of a frame."""
        self.told: Instant | None = None
        """What was told last."""
        self._drawn: list[object] = []
        self._soon = QTimer(self, singleShot=True, interval=0)
        self._soon.timeout.connect(self.tell)
        document.frame_read.connect(self.tell)
        clouds.measured.connect(self.tell_soon)
        runs.active_changed.connect(self._on_runs)
        runs.changed.connect(self._on_runs)
        track.advanced.connect(self._on_advanced)
        track.rested.connect(self._keep)
        track.state_changed.connect(self._on_track_state)
        view_state.drawing_changed.connect(self.tell_soon)
        view_state.display_changed.connect(self.tell_soon)

    def clear(self) -> None:
        """Forget everything about a recording that was closed."""
        self._newest = self.told = self.reference = None

    def settled(self) -> bool:
        """Whether everything that is wanted for this frame has been told."""
        told = self.told
        if self._document.recording is None or self._document.frame_count == 0:
            return True
        if self._soon.isActive() or told is None or told.frame_set.index != self._document.frame:
            return False
        waits = self._cloud_wanted() and not self._clouds.given_up(self._document.frame)
        return not waits or (told.cloud is not None and self._clouds.whole(self._document.frame))

    @Slot()
    def tell_soon(self) -> None:
        """Tell again when everything that happens now has happened."""
        self._soon.start()

    @Slot()
    def tell(self, _what: object = None) -> None:
        """Tell the instant, if what it needs is there; else ask for what is missing."""
        self._soon.stop()
        frame_set, recording = self._document.frame_set, self._document.recording
        if frame_set is None or recording is None:
            return
        frame = frame_set.index
        cloud = self._clouds.cloud(frame)
        self._track.show_depths(shown=self._pictures_need_it())
        if not self._clouds.whole(frame) and self._cloud_wanted():
            self._clouds.ask(frame)
            if self._pictures_need_it() and not self._clouds.given_up(frame):
                return
        drawing, own = self._drawing_at(frame), self.reference
        self._drawn = self._drawn_runs(frame)
        self.told = Instant(
            recording=recording,
            frame_set=frame_set,
            cloud=cloud if drawing is None else drawing.cloud,
            meshes=self.meshes(frame),
            reference=reference_at(own or recording.reference, frame),
            reference_is_old=own is not None and self.is_old(frame),
            ghosts=self._ghosts(frame),
            runs=self._shown_runs(),
            correspondences=self._correspondences(frame) if drawing is None else None,
            inside=None if drawing is None else drawing.scene,
            keypoints=self._keypoints_at(frame),
        )
        self.ready.emit(self.told)

    def meshes(self, frame: int) -> tuple[PartMesh, ...]:
        """The model of the active run, or of the step inside the frame that is looked at."""
        drawing = self._drawing_at(frame)
        if drawing is not None:
            return body_mesh(drawing.body, drawing.pose, around=_AROUND)
        active = self._runs.active
        tracked = active.at(frame) if active is not None and active.visible else None
        if active is None or tracked is None or tracked.pose is None:
            return ()
        return body_mesh(active.body, tracked.pose, around=_AROUND)

    def _ghosts(self, frame: int) -> tuple[Ghost, ...]:
        """Models of the runs that are drawn beside the active one."""
        return tuple(
            Ghost(
                entry.name,
                self._runs.style(entry),
                body_mesh(entry.body, pose, around=_AROUND_GHOST),
            )
            for entry in self._runs.shown_beside()
            if (tracked := entry.at(frame)) is not None and (pose := tracked.pose) is not None
        )

    def _shown_runs(self) -> tuple[tuple[str, LineStyle], ...]:
        active = self._runs.active
        shown = [active] if active is not None and active.visible else []
        shown += [entry for entry in self._runs.shown_beside() if entry.frames]
        return tuple((entry.name, self._runs.style(entry)) for entry in shown)

    @Slot()
    def _on_runs(self) -> None:
        """Tell again where another run is drawn, or one in another way."""
        told = self.told
        if told is None or self._drawn_runs(told.frame_set.index) != self._drawn:
            self.tell_soon()

    def _drawn_runs(self, frame: int) -> list[object]:
        """What of the runs a frame shows; runs by identity."""
        shown = (self._runs.active, *self._runs.shown_beside())
        return [
            (id(entry), id(entry.at(frame)), entry.name, self._runs.style(entry), entry.visible)
            for entry in shown
            if entry is not None and entry.frames
        ]

    def _correspondences(self, frame: int) -> Correspondences | None:
        newest = self._newest
        return (
            newest.estimate.correspondences
            if newest is not None and newest.frame == frame
            else None
        )

    def _keypoints_at(self, frame: int) -> Keypoints | None:
        shown = "keypoints" in self._view_state.displayed.overlays
        return self._keypoints.at(frame) if shown else None

    def _drawing_at(self, frame: int) -> StepDrawing | None:
        drawing = self._view_state.drawing
        return drawing if drawing is not None and drawing.frame == frame else None

    def _cloud_wanted(self) -> bool:
        if not self._clouds.available or self._drawing_at(self._document.frame) is not None:
            return False
        if self._pictures_need_it():
            return True
        # measuring for the scene alone would take time from the tracker or hold up playback
        busy = self._track.running or self._document.playing
        return self._view_state.points_wanted() and not busy

    def _pictures_need_it(self) -> bool:
        return self._clouds.available and any(
            kind in _DEPTH_KINDS for kind in self._view_state.wanted().values()
        )

    @Slot()
    def _on_track_state(self) -> None:
        """Ask for what was not asked for while the tracker was busy."""
        if not self._track.running and not self.settled():
            self.tell_soon()

    @Slot(object)
    def _on_advanced(self, tracked: TrackedFrame) -> None:
        self._newest = tracked
        self._keep(tracked.cloud)

    @Slot(object)
    def _keep(self, cloud: Cloud) -> None:
        entry = self._track.entry or self._runs.active
        if entry is not None and entry.settings is not None:
            self._clouds.keep(cloud, entry.settings.depth)
        self.tell_soon()
