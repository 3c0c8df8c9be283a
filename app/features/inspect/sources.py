"""From a run, or the tracker in progress, to a tracker that is about to do a frame."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import CancelledError
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from stereotrack_core.body.model import body_model
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.errors import Cancelled
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.selection import usable_views
from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.repeating import stored_spec
from stereotrack_core.tracking.trace import StepTrace, movement
from stereotrack_core.tracking.tracker import Tracker, cameras_of, tracker_for
from stereotrack_core.tracking.tuning.process import RecordedStep, RecordStep

from ...session.runs import RunEntry
from ...session.session import Session
from ...session.tracking import LiveRun
from .steps import Step, steps_of

LIVE = (
    "Starts from the state of the tracker in progress. A copy processes this frame; the tracker "
    "itself does not advance."
)
_SMOOTHED = " The run was smoothed, so its poses also depend on later frames."
_SAME_METRES, _SAME_RADIANS = 1e-4, np.radians(0.01)


@dataclass(frozen=True, eq=False)
class Question:
    """What the inside of a frame is worked out from."""

    frame: int
    work: Callable[[], RecordedStep]
    """Has the step done; called in the background."""
    found: Estimate | None
    """What the run has kept of the frame, to be compared with."""
    source: object
    """The run or tracker that it is about."""
    settings: Settings


@dataclass(frozen=True, eq=False)
class Inside:
    """What was worked out."""

    question: Question
    trace: StepTrace
    cloud: Cloud
    """That the step was done with."""
    steps: tuple[Step, ...]
    words: str
    """Where the tracker began."""
    compared: str
    """How the result differs from what the run has kept."""


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
    done = question.work()
    compared = _compared(done.trace, question.found)
    return Inside(question, done.trace, done.cloud, steps_of(done.trace), done.words, compared)


def live_question(frame: int, live: LiveRun) -> Question:
    """About the run in progress, which is held just before the frame."""
    asked = live.inspect()

    def work() -> RecordedStep:
        try:
            found = asked.result()
        except CancelledError:
            raise Cancelled from None
        return RecordedStep(found.trace, found.cloud, LIVE)

    return Question(frame, work, None, live, live.settings)


def run_question(
    frame: int, session: Session, entry: RunEntry | None, settings: Settings
) -> Question:
    """About a run that has been there, or about a frame that no run knows."""
    kept, process = session.kept, session.processes.trials
    assert kept is not None  # noqa: S101 - there are no frames without
    before, earlier, here = (_estimate(entry, k) for k in (frame - 1, frame - 2, frame))
    make = _maker(kept.recording, entry, settings)
    task = RecordStep(kept, frame, settings.depth, make, (before, earlier, here))
    smoothed = entry is not None and _smoothed(entry)

    def work() -> RecordedStep:
        done: RecordedStep = process(task)
        return replace(done, words=done.words + _SMOOTHED) if smoothed else done

    return Question(frame, work, here, entry, settings)


def settings_of(entry: RunEntry) -> Settings:
    """Settings of a run.

    Raises
    ------
    InputError
        Where a stored run does not say how it was made.
    """
    if entry.settings is not None:
        return entry.settings
    return stored_spec(entry.stored).spec.settings if entry.stored is not None else Settings()


def _maker(
    recording: Recording, entry: RunEntry | None, settings: Settings
) -> Callable[[], Tracker]:
    """What makes a tracker as a run has it; as the next one would, where there is none."""
    usable = usable_views(recording, None)
    if entry is None:
        body, views, seed = body_model(proportions_of(recording.subject), settings.body), usable, 0
    else:
        spec = entry.spec()
        kept = tuple(name for name in (spec and spec.views) or () if name in usable)
        body, views, seed = entry.body, kept or usable, spec.seed if spec else 0
    cameras = cameras_of(recording, views)
    return partial(tracker_for, body, settings, cameras, recording.fps, seed)


def _estimate(entry: RunEntry | None, frame: int) -> Estimate | None:
    tracked = entry.at(frame) if entry is not None else None
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
