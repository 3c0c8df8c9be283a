"""Watch a copy of a tracker do one step, and take apart what it did."""

from __future__ import annotations

import copy
import time
from typing import TypeVar

from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.tracking.inside.events import Recorder
from stereotrack_core.tracking.inside.manifold import manifold_trace
from stereotrack_core.tracking.inside.thesis import thesis_trace
from stereotrack_core.tracking.inside.thesis_corrections import belief_of
from stereotrack_core.tracking.inside.trace import FrameTrace
from stereotrack_core.tracking.inside.watched import Watched
from stereotrack_core.tracking.state import Belief
from stereotrack_core.tracking.tracker import PersonTracker
from stereotrack_core.tracking.ukf import ThesisTracker

AnyTracker = TypeVar("AnyTracker", bound=ThesisTracker | PersonTracker)


def look_inside(tracker: ThesisTracker | PersonTracker, cloud: Cloud) -> FrameTrace:
    """What the tracker's next step does, without doing it: the tracker stays as it is.

    A copy of the tracker, with its random numbers, does the step; what is found is equal to the
    last bit to what the tracker itself would find.

    Parameters
    ----------
    tracker : ThesisTracker or PersonTracker
        Peers, which share the interface, are watched as far as they do.
    cloud : Cloud
    """
    return watched_step(copy_of(tracker), cloud)


def copy_of(tracker: AnyTracker) -> AnyTracker:
    """An independent copy; what never changes is shared."""
    shared = (tracker.setup, tracker.setup.body)
    return copy.deepcopy(tracker, {id(each): each for each in shared})


def watched_step(tracker: ThesisTracker | PersonTracker, cloud: Cloud) -> FrameTrace:
    """Let a tracker do its step, and take apart what it did."""
    recorder, before = Recorder(), _belief(tracker)
    begun = time.perf_counter()
    estimate = tracker.step(cloud, recorder)
    ended = time.perf_counter()
    watched = Watched(cloud.frame, before, begun, ended, tuple(recorder.told), estimate)
    if isinstance(tracker, ThesisTracker):
        return thesis_trace(tracker, watched)
    return manifold_trace(tracker, watched)


def _belief(tracker: ThesisTracker | PersonTracker) -> Belief:
    if isinstance(tracker, ThesisTracker):
        return belief_of(tracker.x, tracker.P)
    return Belief(tracker.pose, tracker.P)
