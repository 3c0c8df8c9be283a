"""Do a frame of a recording once more, with a trace of what the step did."""

from __future__ import annotations

import copy
from dataclasses import dataclass, replace

import numpy as np

from stereotrack_core.body.model import body_model
from stereotrack_core.body.pose import Pose
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.state import Belief
from stereotrack_core.tracking.step_recorder import StepRecorder
from stereotrack_core.tracking.trace import StepTrace
from stereotrack_core.tracking.tracker import Tracker, initialiser
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


@dataclass(frozen=True, eq=False)
class RecordedStep:
    """What a step did, the cloud that it was done with, and where the tracker began in words."""

    trace: StepTrace
    cloud: Cloud
    words: str


def beginning_at(
    tracker: Tracker,
    cloud: Cloud,
    before: Estimate | None = None,
    here: Estimate | None = None,
) -> str:
    """Put a new tracker where a run was before a frame; where none was, the person is looked for.

    Parameters
    ----------
    tracker : Tracker
        A new one.
    cloud : Cloud
        Of the frame.
    before, here : Estimate or None
        What the run says of the frame before, and of the frame itself.

    Returns
    -------
    str
        A sentence that says where the tracker begins.
    """
    if before is not None and before.tracked:
        P = before.P if np.isfinite(before.P).all() else None
        if isinstance(tracker, ThesisTracker):
            tracker.start(before.pose, P=P)
            return STORED.format(besides=_DRAWN)
        tracker.start(before.pose, P=P)
        return STORED.format(besides=_LEARNED)
    if here is not None and here.tracked:
        tracker.start(here.pose)
        return FIRST
    if isinstance(tracker, ThesisTracker):
        tracker.start(_found_in(cloud, tracker))
    else:
        tracker.reinitialise()
    return NOBODY


def _found_in(cloud: Cloud, tracker: ThesisTracker) -> Pose:
    """Pose of whoever is in a cloud; the thesis's own body, without legs, cannot be looked for."""
    body = body_model(tracker.setup.body.skeleton.proportions)
    finder = initialiser(
        replace(tracker.setup, body=body, parameters=TrackingParameters(), volume=None)
    )
    finder.reinitialise()
    return finder.step(cloud).pose


def look_inside(tracker: Tracker, cloud: Cloud) -> StepTrace:
    """What the tracker's next step does, without doing it: the tracker stays as it is.

    A copy of the tracker, with its random numbers, does the step; what is found is equal to the
    last bit to what the tracker itself would find.
    """
    return traced_step(copy_of(tracker), cloud)


def copy_of(tracker: Tracker) -> Tracker:
    """An independent copy; what never changes is shared."""
    shared = (tracker.setup, tracker.setup.body)
    return copy.deepcopy(tracker, {id(each): each for each in shared})


def traced_step(tracker: Tracker, cloud: Cloud) -> StepTrace:
    """Let a tracker do its step, and record what it did."""
    recorder = StepRecorder(tracker.setup, Belief(tracker.pose, tracker.P))
    return recorder.trace(cloud.frame, tracker.step(cloud, recorder))
