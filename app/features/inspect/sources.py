"""What is asked about a frame of a run, or of the tracker in progress; and what comes of it."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import CancelledError
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from stereotrack_core.body.model import body_of_subject
from stereotrack_core.errors import Cancelled
from stereotrack_core.recording.keypoints import Keypoints
from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.inspection import RecordedStep
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.repeating import stored_spec
from stereotrack_core.tracking.trace import StepTrace, movement
from stereotrack_core.tracking.tracker import Tracker, cameras_of, tracker_for
from stereotrack_core.tracking.tuning.process import KeptRecording, RecordStep

from ...session.runs import RunEntry
from ...session.session import Session
from ...session.tracking import LiveRun
from .steps import Step, steps_of

_SMOOTHED = " The run was smoothed, so its poses also depend on later frames."
_LOOKED_AGAIN = " A second look changed the frame; its arms then come from other random numbers."
_SAME_METRES, _SAME_RADIANS = 1e-4, np.radians(0.01)


@dataclass(frozen=True, eq=False)
class Question:
    """What a step is recorded from."""

    frame: int
    work: Callable[[], RecordedStep]
    """Has the step done; called in the background."""
    found: Estimate | None
    """What the run has kept of the frame, to be compared with."""
    source: object
    """The run or tracker that it is about."""
    settings: Settings

    def asks(self, frame: int, source: object, settings: Settings) -> bool:
        """Whether it asks about a frame of this run, with these settings."""
        return self.frame == frame and self.source is source and self.settings == settings


@dataclass(frozen=True, eq=False)
class Answer:
    """What the step did."""

    question: Question
    done: RecordedStep
    steps: tuple[Step, ...]
    compared: str
    """How the result differs from what the run has kept."""


def answer(question: Question) -> Answer:
    """Have the step done; called in a thread of its own."""
    done = question.work()
    return Answer(question, done, steps_of(done.trace), _compared(done.trace, question.found))


def live_question(frame: int, live: LiveRun) -> Question:
    """About the run in progress, which is held just before the frame."""
    asked = live.inspect()

    def work() -> RecordedStep:
        try:
            return asked.result()
        except CancelledError:
            raise Cancelled from None

    return Question(frame, work, None, live, live.settings)


def run_question(
    frame: int, session: Session, entry: RunEntry | None, settings: Settings
) -> Question:
    """About a run that has been there, or about a frame that no run knows."""
    kept, process = session.kept, session.processes.trials
    assert kept is not None  # noqa: S101 - there are no frames without
    seen = (entry.at(k) if entry is not None else None for k in (frame - 1, frame))
    before, here = (one.estimate if one is not None else None for one in seen)
    make = _maker(kept, entry, settings)
    keypoints = _keypoints(session, entry, settings, frame)
    meta = entry.stored.meta if entry is not None and entry.stored is not None else {}
    of_frame = None if entry is None else entry.at(frame)
    looked = None if of_frame is None else of_frame.keypoints
    task = RecordStep(kept, frame, settings, make, before, here, keypoints, looked)
    more = _SMOOTHED if meta.get("smoothed") else ""
    if entry is not None and any(a <= frame <= b for a, b in entry.looked_again):
        more += _LOOKED_AGAIN

    def work() -> RecordedStep:
        done: RecordedStep = process(task)
        return replace(done, words=done.words + more)

    return Question(frame, work, here, entry, settings)


def _keypoints(
    session: Session, entry: RunEntry | None, settings: Settings, frame: int
) -> Keypoints | None:
    """What a run was tracked with; what the next one would be, where there is none."""
    if entry is not None and (spec := entry.spec()) is not None:
        return spec.keypoints
    return session.keypoints.for_trial(settings, range(frame, frame + 1))


def _maker(of: KeptRecording, entry: RunEntry | None, settings: Settings) -> Callable[[], Tracker]:
    """What makes a tracker as a run has it; as the next one would, where there is none."""
    recording, usable = of.recording, of.views
    if entry is None:
        body, views, seed = body_of_subject(recording.subject, settings.body), usable, 0
    else:
        spec = entry.spec()
        kept = tuple(name for name in (spec and spec.views) or () if name in usable)
        body, views, seed = entry.body, kept or usable, spec.seed if spec else 0
    cameras, clouds = cameras_of(recording, views), not of.mono
    return partial(tracker_for, body, settings, cameras, recording.fps, seed, clouds=clouds)


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


def _compared(trace: StepTrace, found: Estimate | None) -> str:
    if found is None or not (found.tracked and trace.estimate.tracked):
        return ""
    off = movement(trace.body, found.pose, trace.after.pose)
    angle = max(off.turn, float(np.nanmax(off.limbs)))
    if off.shift < _SAME_METRES and angle < _SAME_RADIANS:
        return "The result equals the pose of the run."
    return (
        f"The result differs from the pose of the run by {1000.0 * off.shift:.1f} mm and up to "
        f"{np.degrees(angle):.1f}°."
    )
