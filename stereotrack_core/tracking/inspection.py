"""Do a frame of a recording once more, with a trace of what the step did."""

from __future__ import annotations

import copy
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from stereotrack_core.body.manifold import difference
from stereotrack_core.body.model import BodyModel, body_model
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.recording.description import Recording
from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.parameters import Settings, TrackingParameters
from stereotrack_core.tracking.state import Belief
from stereotrack_core.tracking.step_recorder import StepRecorder
from stereotrack_core.tracking.trace import StepTrace
from stereotrack_core.tracking.tracker import PersonTracker, initialiser, tracker_for
from stereotrack_core.tracking.ukf import ThesisTracker

STORED = (
    "Starts from the pose and covariance stored for the previous frame, not from the original "
    "tracker. The rest of its state, such as {besides}, is not stored."
)
_DRAWN = "its random numbers (other model points are sampled)"
_LEARNED = "alternative poses of its first frames and learned colours"
FIRST = (
    "The run has no pose for the previous frame. The step therefore starts from the run's pose of "
    "this frame, with the uncertainty of an initial pose."
)
NOBODY = "No pose is known for the previous frame, so the pose is initialised automatically."


AnyTracker = TypeVar("AnyTracker", bound=ThesisTracker | PersonTracker)


@dataclass(frozen=True, eq=False)
class Beginning:
    """A tracker about to do a frame, and a sentence that says where it begins."""

    tracker: ThesisTracker | PersonTracker
    words: str


@dataclass(frozen=True, eq=False)
class Way:
    """How a frame is tracked."""

    recording: Recording
    settings: Settings
    body: BodyModel
    views: tuple[str, ...]
    """That are used."""
    seed: int

    def tracker(self) -> ThesisTracker | PersonTracker:
        """Make the tracker."""
        views = [self.recording.view(name) for name in self.views]
        cameras = [self.recording.reference_camera(view).position_world for view in views]
        fps = self.recording.fps
        made = tracker_for(self.body, self.settings, np.array(cameras), fps, self.seed)
        assert isinstance(made, ThesisTracker | PersonTracker)  # noqa: S101 - there are no others
        return made


@dataclass(frozen=True, eq=False)
class Known:
    """What a run says around a frame."""

    before: Estimate | None = None
    earlier: Estimate | None = None
    """`before` and `earlier`: of the frame before, and of the one before that."""
    here: Estimate | None = None
    """Of the frame itself."""


def beginning_at(way: Way, known: Known, cloud: Cloud) -> Beginning:
    """Begin where a run was before a frame; where none was, the person is looked for."""
    before, here = known.before, known.here
    if before is not None and before.tracked:
        return _as_stored(way.tracker(), before, known.earlier)
    tracker = way.tracker()
    if here is not None and here.tracked:
        tracker.start(here.pose)
        return Beginning(tracker, FIRST)
    if isinstance(tracker, ThesisTracker):
        tracker.start(_found_in(cloud, way, tracker))
    else:
        tracker.reinitialise()
    return Beginning(tracker, NOBODY)


def _as_stored(
    tracker: ThesisTracker | PersonTracker, before: Estimate, earlier: Estimate | None
) -> Beginning:
    P = before.P if np.isfinite(before.P).all() else None
    if isinstance(tracker, ThesisTracker):
        tracker.start(before.pose, P=P)
        return Beginning(tracker, STORED.format(besides=_DRAWN))
    movement = None
    if earlier is not None and earlier.tracked:
        movement = difference(before.pose, earlier.pose, tracker.setup.joints)
    tracker.start(before.pose, P=P, movement=movement)
    return Beginning(tracker, STORED.format(besides=_LEARNED))


def _found_in(cloud: Cloud, way: Way, tracker: ThesisTracker) -> Pose:
    """Pose of whoever is in a cloud; the thesis's own body, without legs, cannot be looked for."""
    body = body_model(proportions_of(way.recording.subject))
    finder = initialiser(
        replace(tracker.setup, body=body, parameters=TrackingParameters(), volume=None)
    )
    finder.reinitialise()
    return finder.step(cloud).pose


def look_inside(tracker: ThesisTracker | PersonTracker, cloud: Cloud) -> StepTrace:
    """What the tracker's next step does, without doing it: the tracker stays as it is.

    A copy of the tracker, with its random numbers, does the step; what is found is equal to the
    last bit to what the tracker itself would find.

    `tracker`: baselines record what they share with it.
    """
    return traced_step(copy_of(tracker), cloud)


def copy_of(tracker: AnyTracker) -> AnyTracker:
    """An independent copy; what never changes is shared."""
    shared = (tracker.setup, tracker.setup.body)
    return copy.deepcopy(tracker, {id(each): each for each in shared})


def traced_step(tracker: ThesisTracker | PersonTracker, cloud: Cloud) -> StepTrace:
    """Let a tracker do its step, and record what it did."""
    recorder = StepRecorder(tracker.setup, Belief(tracker.pose, tracker.P))
    return recorder.trace(cloud.frame, tracker.step(cloud, recorder))
