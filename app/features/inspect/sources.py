"""From a run, or the tracker in progress, to a tracker that is about to do a frame."""

from __future__ import annotations

import dataclasses
import threading
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from stereotrack_core.blas_threads import one_blas_thread
from stereotrack_core.body.model import BodyModel, body_model
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.selection import usable_views
from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.inspection import (
    Beginning,
    Known,
    Way,
    beginning_at,
    copy_of,
    traced_step,
)
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.repeating import stored_spec
from stereotrack_core.tracking.run import Pipeline
from stereotrack_core.tracking.trace import StepTrace, movement
from stereotrack_core.tracking.tracker import PersonTracker
from stereotrack_core.tracking.tuning.attempt import stoppable
from stereotrack_core.tracking.ukf import ThesisTracker

from ...session.runs import RunEntry
from .steps import Step, steps_of

LIVE = (
    "Starts from the state of the tracker in progress. A copy processes this frame; the tracker "
    "itself does not advance."
)
_SMOOTHED = " The run was smoothed, so its poses also depend on later frames."
_SAME_METRES, _SAME_RADIANS = 1e-4, np.radians(0.01)


@dataclass(frozen=True, eq=False)
class Question:
    """What the inside of a frame is worked out from.

    Attributes
    ----------
    frame : int
    cloud : Cloud
    begin : callable
        Makes the tracker that does the frame; called in the background.
    found : Estimate or None
        What the run has kept of the frame, to be compared with.
    source : object
        The run or tracker that it is about.
    settings : Settings
    stop : Event
        Set when nobody wants to know any more.
    """

    frame: int
    cloud: Cloud
    begin: Callable[[Cloud], Beginning]
    found: Estimate | None
    source: object
    settings: Settings
    stop: threading.Event


@dataclass(frozen=True, eq=False)
class Inside:
    """What was worked out.

    Attributes
    ----------
    question : Question
    trace : StepTrace
    steps : tuple of Step
    words : str
        Where the tracker began.
    compared : str
        How the result differs from what the run has kept.
    """

    question: Question
    trace: StepTrace
    steps: tuple[Step, ...]
    words: str
    compared: str


def asks_the_same(asked: Question | None, frame: int, source: object, settings: Settings) -> bool:
    """Whether a frame was asked about already, of the same run and with the same settings."""
    return (
        asked is not None
        and asked.frame == frame
        and asked.source is source
        and asked.settings == settings
    )


def answer(question: Question) -> Inside:
    """Let the tracker do its frame; called in a thread of its own."""
    release = one_blas_thread.hold()
    try:
        begun = question.begin(question.cloud)
        trace = traced_step(begun.tracker, question.cloud)
    finally:
        release()
    plain = BodyModel(trace.body.skeleton, trace.body.cones)  # this one never stops
    trace = dataclasses.replace(trace, body=plain)
    return Inside(question, trace, steps_of(trace), begun.words, _compared(trace, question.found))


def live_question(frame: int, cloud: Cloud, pipeline: Pipeline, *, started: bool) -> Question:
    """About the tracker in progress, which is held just before the frame.

    Parameters
    ----------
    frame : int
    cloud : Cloud
    pipeline : Pipeline
    started : bool
        Whether the tracker has a pose already.
    """
    tracker = pipeline.tracker
    assert isinstance(tracker, ThesisTracker | PersonTracker)  # noqa: S101 - no others are made
    twin = copy_of(tracker)

    def begin(cloud: Cloud) -> Beginning:
        if not started and len(cloud.points):
            twin.start(pipeline.first_pose(cloud))
        return Beginning(twin, LIVE)

    return Question(frame, cloud, begin, None, pipeline, pipeline.settings, threading.Event())


def run_question(
    frame: int, cloud: Cloud, recording: Recording, entry: RunEntry | None, settings: Settings
) -> Question:
    """About a run that has been there, or about a frame that no run knows."""
    way, known, stop = way_of(recording, entry, settings), Known(), threading.Event()
    way = dataclasses.replace(way, body=stoppable(way.body, stop.is_set))
    if entry is not None:
        known = Known(*(_estimate(entry, k) for k in (frame - 1, frame - 2, frame)))
    smoothed = entry is not None and _smoothed(entry)

    def begin(cloud: Cloud) -> Beginning:
        begun = beginning_at(way, known, cloud)
        return Beginning(begun.tracker, begun.words + _SMOOTHED) if smoothed else begun

    return Question(frame, cloud, begin, known.here, entry, settings, stop)


def settings_of(entry: RunEntry) -> Settings:
    """Settings of a run.

    Raises
    ------
    InputError
        Where a stored run does not say how it was made.
    """
    if entry.settings is not None:
        return entry.settings
    run = entry.run()
    return stored_spec(run).spec.settings if run is not None else Settings()


def way_of(recording: Recording, entry: RunEntry | None, settings: Settings) -> Way:
    """How a run tracks its frames; how the next one would, where there is none."""
    body: BodyModel = (
        entry.body
        if entry is not None
        else body_model(proportions_of(recording.subject), settings.body)
    )
    views, seed = usable_views(recording, None), 0
    if entry is not None and entry.origin is not None:
        views, seed = tuple(entry.origin.spec.views or ()), entry.origin.spec.seed
    elif entry is not None and entry.stored is not None:
        meta = entry.stored.meta
        kept = tuple(name for name in meta.get("views", ()) if name in views)
        views, seed = kept or views, int(meta.get("seed", 0))
    return Way(recording, settings, body, tuple(views), seed)


def _estimate(entry: RunEntry, frame: int) -> Estimate | None:
    tracked = entry.at(frame)
    return tracked.estimate if tracked is not None else None


def _smoothed(entry: RunEntry) -> bool:
    return entry.stored is not None and bool(entry.stored.meta.get("smoothed", False))


def _compared(trace: StepTrace, found: Estimate | None) -> str:
    """How the result differs from what the run has kept."""
    if found is None or not (found.tracked and trace.estimate.tracked):
        return ""
    pose: Pose = found.pose
    off = movement(trace.body, pose, trace.after.pose)
    angle = max(off.turn, float(np.nanmax(off.limbs)))
    if off.shift < _SAME_METRES and angle < _SAME_RADIANS:
        return "The result equals the pose of the run."
    return (
        f"The result differs from the pose of the run by {1000.0 * off.shift:.1f} mm and up to "
        f"{np.degrees(angle):.1f}°."
    )
