"""One watched step, before it is taken apart."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.inside.events import Event
from stereotrack_core.tracking.state import Belief


@dataclass(frozen=True, eq=False)
class Watched:
    """What a tracker has told of one step.

    Attributes
    ----------
    frame : int
    start : Belief
        Of the tracker before the step.
    begun, ended : float
        Seconds of the performance counter.
    told : tuple of (float, Event)
        When, and what.
    estimate : Estimate
        What the step has given.
    """

    frame: int
    start: Belief
    begun: float
    ended: float
    told: tuple[tuple[float, Event], ...]
    estimate: Estimate

    def pauses(self) -> list[float]:
        """Seconds before each event, since the event before it."""
        times = [self.begun, *(at for at, _ in self.told)]
        return [b - a for a, b in pairwise(times)]

    @property
    def rest(self) -> float:
        """Seconds from the last event to the end."""
        return self.ended - (self.told[-1][0] if self.told else self.begun)
