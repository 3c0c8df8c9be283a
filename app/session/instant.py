"""What is known about the frame that is shown, brought together when something has changed."""

import dataclasses
from collections import OrderedDict
from collections.abc import Callable

from stereotrack_core.annotation.reference import FittedClicks
from stereotrack_core.body.mesh import PartMesh, body_mesh
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.memory import usual_limit
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.tracking.frame import TrackedFrame
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.tuning.clouds import CloudKey, CloudStore, KeptClouds

from .base import Base
from .changes import Part, TellChange
from .document import Shared
from .jobs import LatestOnly, TaskList
from .judgement import reference_at
from .keypoints import KeypointPresenter
from .tracking import TrackPresenter
from .view_state import GhostBody, Instant, StepDrawing

_KEPT = 12


def _measuring(shared: Shared[CloudStore]) -> Callable[[tuple[DepthParameters, int]], Cloud]:
    """Function that takes clouds of one recording from its store, in one thread.

    Another recording gets another one of these, so that a thread that is late has nothing to do
    with it. Once the store is closed the work ends with the next images.
    """
    clouds: KeptClouds | None = None

    def measure(question: tuple[DepthParameters, int]) -> Cloud:
        nonlocal clouds
        parameters, frame = question
        with shared.used() as store:
            key = CloudKey(parameters, range(store.reader.frame_count))
            if clouds is None or clouds.key != key:
                clouds = store.clouds(key, cancelled=lambda: not shared.wanted)
            return clouds.take(frame)[0]

    return measure


def _store_of(recording: Recording, reader: Shared[FrameReader]) -> Shared[CloudStore]:
    # the tracker never sees the truth
    unaided = dataclasses.replace(recording, reference=None)
    store = CloudStore(unaided, reader.enter(), limit=usual_limit() // 4)

    def close() -> None:
        store.close()
        reader.leave()

    return Shared(store, close)


class CloudPresenter:
    """Clouds by frame and parameters; the newest question wins, the last few are kept."""

    def __init__(
        self, tell_change: TellChange, tasks: TaskList, settings: Callable[[], Settings]
    ) -> None:
        self._tell_change, self._tasks, self._settings = tell_change, tasks, settings
        self.reader: Shared[FrameReader] | None = None
        """Reader of the images in grey, as the tracker sees them."""
        self._store: Shared[CloudStore] | None = None
        self._worker: LatestOnly | None = None
        self._clouds: OrderedDict[tuple[DepthParameters, int], Cloud] = OrderedDict()
        self._points: tuple[tuple[DepthParameters, int], Cloud] | None = None
        self._failed: set[tuple[DepthParameters, int]] = set()

    def set_recording(self, recording: Recording | None) -> None:
        """Measure another recording; views without depth give nothing."""
        if self._worker is not None:
            self._worker.close()
            self._worker = None
        for shared in (self._store, self.reader):
            if shared is not None:
                shared.close()
        self._store = self.reader = None
        self._clouds.clear()
        self._points = None
        self._failed.clear()
        names = [view.name for view in recording.views if view.kind != "mono"] if recording else []
        if recording is not None and names:
            reader = FrameReader(recording, views=names, colour=False)
            self.reader = Shared(reader, reader.close)
            self._store = _store_of(recording, self.reader)
            measure, answers = _measuring(self._store), (self._on_measured, self._on_failed)
            self._worker = LatestOnly(self._tasks, measure, "measure points", *answers, late=True)

    @property
    def parameters(self) -> DepthParameters:
        """Those that points of the next run would be measured with."""
        return self._settings().depth

    @property
    def available(self) -> bool:
        return self._worker is not None

    def cloud(self, frame: int) -> Cloud | None:
        """The cloud of a frame, if it is there already.

        That of the frame which the tracker has just done may be without depth images.
        """
        key = self.parameters, frame
        points = self._points[1] if self._points is not None and self._points[0] == key else None
        return self._clouds.get(key, points)

    def whole(self, frame: int) -> bool:
        return (self.parameters, frame) in self._clouds

    def ask(self, frame: int) -> None:
        """Have the cloud of a frame made; a change of CLOUD tells when it is there."""
        key = self.parameters, frame
        if self._worker is not None and key not in self._clouds and key not in self._failed:
            self._worker.ask(key)

    def keep(self, cloud: Cloud, parameters: DepthParameters) -> None:
        """Keep a cloud of the tracker; without depth images it is still to be measured."""
        if not cloud.depths and cloud.view_names:
            self._points = (parameters, cloud.frame), cloud
        else:
            self._keep(cloud, parameters)

    def _keep(self, cloud: Cloud, parameters: DepthParameters) -> None:
        self._clouds[parameters, cloud.frame] = cloud
        self._clouds.move_to_end((parameters, cloud.frame))
        while len(self._clouds) > _KEPT:
            self._clouds.popitem(last=False)

    def given_up(self, frame: int) -> bool:
        return self._worker is None or (self.parameters, frame) in self._failed

    def settled(self) -> bool:
        return self._worker is None or self._worker.settled()

    def _on_measured(self, question: tuple[DepthParameters, int], cloud: Cloud) -> None:
        self._keep(cloud, question[0])  # where a view gave no depth, it has no images
        self._tell_change(Part.CLOUD, cloud)

    def _on_failed(self, question: tuple[DepthParameters, int], error: Exception) -> None:
        first = not self._failed
        self._failed.add(question)
        if first:
            self._tasks.failed(error)
        self._tell_change(Part.CLOUD)


_DEPTH_KINDS = {"disparity", "foreground", "depth"}
_AROUND = 16
_AROUND_GHOST = 10


class InstantPresenter:
    """Waits until what the views need is there, then tells it once."""

    def __init__(
        self,
        base: Base,
        keypoints: KeypointPresenter,
        clouds: CloudPresenter,
        track: TrackPresenter,
    ) -> None:
        self._changes, self._view_state = base.changes, base.view_state
        self._document, self._runs = base.document, base.runs
        self._keypoints, self._clouds, self._track = keypoints, clouds, track
        self._newest: TrackedFrame | None = None
        self.reference: LandmarkTrajectory | None = None
        self._reference_clicks: FittedClicks | None = None
        self.told: Instant | None = None
        self._soon = base.later(self.tell, 0)

    def clear(self) -> None:
        """Forget everything about a recording that was closed."""
        self._newest = self.told = self.reference = self._reference_clicks = None

    def show_reference(
        self, reference: LandmarkTrajectory | None, clicks: FittedClicks | None
    ) -> None:
        """Show another reference; its clicks say in which frames it is older than they."""
        told, before = self.told, self.reference
        self.reference, self._reference_clicks = reference, clicks
        aged = told is not None and told.reference_is_old is not self._is_old(told.frame_set.index)
        if reference is not before or aged:
            self.tell_soon()

    def _is_old(self, frame: int) -> bool:
        return self._reference_clicks is not None and self._reference_clicks.is_old(frame)

    def settled(self) -> bool:
        told = self.told
        if self._document.recording is None or self._document.frame_count == 0:
            return True
        if self._soon.isActive() or told is None or told.frame_set.index != self._document.frame:
            return False
        waits = self._cloud_wanted() and not self._clouds.given_up(self._document.frame)
        return not waits or (told.cloud is not None and self._clouds.whole(self._document.frame))

    def tell_soon(self) -> None:
        """Tell again when everything that happens now has happened."""
        self._soon.start()

    def tell(self) -> None:
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
        drawing, own, newest = self._drawing_at(frame), self.reference, self._newest
        newest = newest if newest is not None and newest.frame == frame else None
        matched = None if newest is None else newest.estimate.correspondences
        overlays = self._view_state.displayed.overlays
        self.told = Instant(
            recording=recording, frame_set=frame_set,
            cloud=cloud if drawing is None else drawing.cloud, meshes=self.meshes(frame),
            reference=reference_at(own or recording.reference, frame),
            reference_is_old=own is not None and self._is_old(frame), ghosts=self._ghosts(frame),
            correspondences=matched if drawing is None else None,
            inside=None if drawing is None else drawing.scene,
            keypoints=self._keypoints.at(frame) if "keypoints" in overlays else None,
        )  # fmt: skip
        self._changes.tell(Part.INSTANT)

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

    def _ghosts(self, frame: int) -> tuple[GhostBody, ...]:
        return tuple(
            GhostBody(
                self._runs.style(entry),
                body_mesh(entry.body, pose, around=_AROUND_GHOST),
            )
            for entry in self._runs.shown_beside()
            if (tracked := entry.at(frame)) is not None and (pose := tracked.pose) is not None
        )

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
        shown = "points" in self._view_state.display.overlays
        return (shown or self._view_state.scene_shows_points()) and not busy

    def _pictures_need_it(self) -> bool:
        return self._clouds.available and any(
            kind in _DEPTH_KINDS for kind in self._view_state.wanted().values()
        )

    def on_tracking(self) -> None:
        """Ask for what was not asked for while the tracker was busy."""
        if not self._track.running and not self.settled():
            self.tell_soon()

    def on_tracked(self, tracked: TrackedFrame) -> None:
        """Show the newest frame of the tracker with what is known of its step alone."""
        self._newest = tracked
        self.keep(tracked.cloud)

    def keep(self, cloud: Cloud) -> None:
        entry = self._track.entry or self._runs.active
        if entry is not None and entry.settings is not None:
            self._clouds.keep(cloud, entry.settings.depth)
        self.tell_soon()
