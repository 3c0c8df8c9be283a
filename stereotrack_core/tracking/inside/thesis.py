"""What the thesis's tracker has told becomes a trace."""

from __future__ import annotations

import numpy as np

from stereotrack_core.tracking.collisions import Clearance
from stereotrack_core.tracking.inside import events
from stereotrack_core.tracking.inside.corrections import Place
from stereotrack_core.tracking.inside.thesis_corrections import (
    belief_of,
    jump_of,
    thesis_correction,
)
from stereotrack_core.tracking.inside.trace import Correction, FrameTrace, Jump
from stereotrack_core.tracking.inside.watched import Watched
from stereotrack_core.tracking.state import Belief
from stereotrack_core.tracking.ukf import ThesisTracker


def thesis_trace(tracker: ThesisTracker, watched: Watched) -> FrameTrace:
    """Take a step of the thesis's tracker apart."""
    reader = _Reader(tracker, watched)
    for (_, event), pause in zip(watched.told, watched.pauses(), strict=True):
        reader.read(event, pause)
    estimate = watched.estimate
    return FrameTrace(
        frame=watched.frame,
        method="thesis",
        body=tracker.setup.body,
        state_names=tracker.state_names,
        before=watched.start,
        predicted=reader.predicted,
        after=Belief(estimate.pose, estimate.P),
        corrections=tuple(reader.corrections),
        estimate=estimate,
        jump=reader.jump,
        seconds=reader.seconds | {"judge": watched.rest},
    )


class _Reader:
    """Reads events one by one."""

    def __init__(self, tracker: ThesisTracker, watched: Watched) -> None:
        self.tracker = tracker
        self.predicted = watched.start
        self.corrections: list[Correction] = []
        self.jump: Jump | None = None
        self.seconds: dict[str, float] = {}
        self._state = (tracker.x, tracker.P)
        self._drawn: list[events.Sampled] = []
        self._paired: events.Paired | None = None
        self._looked = 0.0

    def read(self, event: events.Event, pause: float) -> None:
        """Take in one event that came so many seconds after the one before."""
        match event:
            case events.PredictedState(x, P):
                self._state, self.predicted = (x, P), belief_of(x, P)
                self._count("predict", pause)
            case events.Sampled():
                if self.tracker.setup.parameters.sampling == "regular":
                    self._drawn.clear()  # the pattern is drawn anew until it is dense enough
                self._drawn.append(event)
                self._looked += pause
            case events.Paired():
                self._paired = event
                self._looked += pause
            case events.CorrectedState():
                self._correct(event, pause)
            case events.Avoided(x):
                p = self.tracker.setup.parameters
                before = belief_of(*self._state).pose
                after = belief_of(x, self._state[1]).pose
                least = Clearance(p.clearance, np.radians(p.least_elbow_angle))
                self.jump = jump_of(self.tracker.setup.body, before, after, least)
                self._count("collisions", pause)

    def _correct(self, done: events.CorrectedState, pause: float) -> None:
        if self._paired is None:
            return
        place = Place("follow", len(self.corrections) + 1, self._looked, pause)
        found = thesis_correction(self.tracker, self._state, self._drawn, self._paired, done, place)
        self.corrections.append(found)
        self._count("sample and pair", self._looked)
        self._count("correct", pause)
        self._state, self._paired, self._looked = (done.x, done.P), None, 0.0
        self._drawn = []

    def _count(self, step: str, seconds: float) -> None:
        self.seconds[step] = self.seconds.get(step, 0.0) + seconds
