"""Trials and step traces in a process of their own, which keeps the clouds for them."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from uuid import uuid4

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.keypoints import Keypoints
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.sighted_keypoints import keypoints_in_views
from stereotrack_core.tracking.detecting import seen_in_views
from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.frame import Origin, TrackedFrame
from stereotrack_core.tracking.inspection import RecordedStep, beginning_at, explain
from stereotrack_core.tracking.model import TrackModel
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.tuning.clouds import CloudKey, CloudStore
from stereotrack_core.tracking.tuning.trial import Trial
from stereotrack_core.worker_processes import Asker

_STORE = "clouds"


@dataclass(frozen=True, eq=False)
class KeptRecording:
    """A recording whose clouds a process keeps from task to task, until another one comes."""

    recording: Recording
    mono: tuple[str, ...] = ()  # mono views that are tracked by keypoints
    key: str = field(default_factory=lambda: uuid4().hex)
    """What tells it from others, also from itself before it was corrected."""

    @property
    def views(self) -> tuple[str, ...]:
        """Views that are tracked: those that give depth, else the mono ones."""
        deep = tuple(view.name for view in self.recording.views if view.kind != "mono")
        return deep or self.mono

    def store(self, asker: Asker) -> CloudStore:
        """What the process keeps of it."""
        key, store = asker.kept.get(_STORE, ("", None))
        if key != self.key:
            forget(asker)
            reader = FrameReader(self.recording, views=self.views, colour=False)
            mono = [name for name in self.views if name in self.mono]
            store = CloudStore(self.recording, reader, mono=mono)
            asker.kept[_STORE] = self.key, store
        known: CloudStore = store
        return known


def forget(asker: Asker) -> None:
    """Keep no clouds any more."""
    _, store = asker.kept.pop(_STORE, ("", None))
    if store is not None:
        store.close()
        store.reader.close()


@dataclass(frozen=True, eq=False)
class TrialBegun:
    """A trial is prepared, or its origin says more."""

    body: BodyModel  # that is tracked
    origin: Origin


@dataclass(frozen=True, eq=False)
class TrialFrame:
    """A frame of a trial is done."""

    frame: TrackedFrame  # without its cloud
    seconds: float  # since the trial began


@dataclass(frozen=True, eq=False)
class TrackTrial:
    """Tracks a trial."""

    of: KeptRecording
    trial: Trial

    def __call__(self, asker: Asker) -> None:
        """Do it in the process."""
        store, begun = self.of.store(asker), time.perf_counter()
        with self.trial.begun(store, asker.cancelled) as (run, hooks):
            asker.tell(TrialBegun(run.body, run.origin()))
            for advance in self.trial.advances(run, hooks):
                run = advance.run
                for tracked in advance.gained.frames:
                    seconds = time.perf_counter() - begun
                    asker.tell(TrialFrame(tracked.without_cloud(), seconds))
            if run.look.changed:
                asker.tell(TrialBegun(run.body, run.origin()))


@dataclass(frozen=True, eq=False)
class MakeClouds:
    """Makes the clouds of a trial ahead."""

    of: KeptRecording
    trial: Trial

    def __call__(self, asker: Asker) -> None:
        """Do it in the process."""
        clouds = self.of.store(asker).clouds(self.trial.key, self.trial.reach, asker.cancelled)
        for frame in self.trial.reach:
            clouds.take(frame)


@dataclass(frozen=True, eq=False)
class RecordStep:
    """Does a frame of a run once more."""

    of: KeptRecording
    frame: int
    settings: Settings
    make: Callable[[], TrackModel]
    before: Estimate | None
    here: Estimate | None  # `before`, `here`: what the run says of both frames
    keypoints: Keypoints | None = None  # that the run is tracked with
    seen: Keypoints | None = None  # what the pose detector saw in the frame, instead of them
    truth: FloatArray | None = None  # (9, 3). Landmarks in the frame, for the record alone.
    views: tuple[str, ...] = ()  # that the run used; empty: all

    def __call__(self, asker: Asker) -> RecordedStep:
        """Do it in the process."""
        return self.recorded(self.of.store(asker), asker.cancelled)

    def recorded(self, store: CloudStore, cancelled: Callable[[], bool]) -> RecordedStep:
        """Do it with the clouds of a store. Raises Cancelled, InputError."""
        frames = range(store.reader.frame_count)
        settings = self.settings
        key = CloudKey(settings.depth, frames, settings.uses_detector, self.views)
        cloud, _ = store.clouds(key, cancelled=cancelled).take(self.frame)
        seen = keypoints_in_views(store.recording, self.of.views, self.keypoints)(self.frame)
        if self.seen is not None:
            seen = seen_in_views(store.recording, cloud.view_names, self.seen)
        cloud = replace(cloud, keypoints=seen)
        model = self.make()
        state, words = beginning_at(model, cloud, self.before, self.here)
        return RecordedStep(explain(model, state, cloud, self.truth), cloud, words)
