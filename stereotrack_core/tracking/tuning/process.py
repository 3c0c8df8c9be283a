"""Trials and step traces in a process of their own, which keeps the clouds for them."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from uuid import uuid4

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
    mono: tuple[str, ...] = ()
    """Mono views that are tracked by keypoints, where no view gives depth."""
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
    """A trial, by its place among those of a task, is prepared, or its origin says more."""

    place: int
    body: BodyModel
    """That is tracked."""
    origin: Origin


@dataclass(frozen=True, eq=False)
class TrialFrame:
    """A frame of a trial is done."""

    place: int
    frame: TrackedFrame
    """Without its cloud."""
    seconds: float
    """Since the trial began."""


@dataclass(frozen=True, eq=False)
class TrackTrials:
    """Tracks trials one after the other; tells at the end which clouds are kept."""

    of: KeptRecording
    trials: tuple[Trial, ...]

    def __call__(self, asker: Asker) -> None:
        """Do it in the process."""
        store = self.of.store(asker)
        try:
            for place, trial in enumerate(self.trials):
                begun = time.perf_counter()
                with trial.begun(store, asker.cancelled) as (run, hooks):
                    asker.tell(TrialBegun(place, run.body, run.origin()))
                    for advance in trial.advances(run, hooks):
                        run = advance.run
                        for tracked in advance.gained.frames:
                            seconds = time.perf_counter() - begun
                            asker.tell(TrialFrame(place, tracked.without_cloud(), seconds))
                    if run.look.changed:
                        asker.tell(TrialBegun(place, run.body, run.origin()))
        finally:
            asker.tell(store.holdings())


@dataclass(frozen=True, eq=False)
class MakeClouds:
    """Makes the clouds of a trial ahead; tells at the end which ones are kept."""

    of: KeptRecording
    trial: Trial

    def __call__(self, asker: Asker) -> None:
        """Do it in the process."""
        store = self.of.store(asker)
        try:
            clouds = store.clouds(self.trial.key, self.trial.reach, asker.cancelled)
            for frame in self.trial.reach:
                clouds.take(frame)
        finally:
            asker.tell(store.holdings())


@dataclass(frozen=True, eq=False)
class RecordStep:
    """Does a frame of a run once more."""

    of: KeptRecording
    frame: int
    settings: Settings
    make: Callable[[], TrackModel]
    before: Estimate | None
    here: Estimate | None
    """`before` and `here`: what the run says of the frame before, and of the frame itself."""
    keypoints: Keypoints | None = None
    """That the run is tracked with."""
    seen: Keypoints | None = None
    """What the pose detector saw in the frame, instead of them."""

    def __call__(self, asker: Asker) -> RecordedStep:
        """Do it in the process."""
        store = self.of.store(asker)
        frames = range(store.reader.frame_count)
        key = CloudKey(self.settings.depth, frames, self.settings.uses_detector)
        cloud, _ = store.clouds(key, cancelled=asker.cancelled).take(self.frame)
        seen = keypoints_in_views(store.recording, self.of.views, self.keypoints).at(self.frame)
        if self.seen is not None:
            seen = seen_in_views(store.recording, cloud.view_names, self.seen)
        cloud = replace(cloud, keypoints=seen)
        model = self.make()
        state, words = beginning_at(model, cloud, self.before, self.here)
        return RecordedStep(explain(model, state, cloud), cloud, words)
