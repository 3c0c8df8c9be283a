"""What a tracker has told of one frame, in its order; nothing is worked out here."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

from stereotrack_core.arrays import BoolArray, FloatArray
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.sampling import SurfacePoints
from stereotrack_core.tracking.correction import Residual
from stereotrack_core.tracking.data_to_model import SurfaceResidual
from stereotrack_core.tracking.inside.observer import Observer
from stereotrack_core.tracking.search.arms import Arms
from stereotrack_core.tracking.search.search import Evidence
from stereotrack_core.tracking.state import State
from stereotrack_core.tracking.ukf import Projection


@dataclass(frozen=True, eq=False)
class Sought:
    """See :meth:`Observer.sought`."""

    pose: Pose


@dataclass(frozen=True, eq=False)
class Predicted:
    """See :meth:`Observer.predicted`."""

    before: State
    pose: Pose
    P: FloatArray


@dataclass(frozen=True, eq=False)
class PredictedState:
    """See :meth:`Observer.predicted_state`."""

    x: FloatArray
    P: FloatArray


@dataclass(frozen=True, eq=False)
class Sampled:
    """See :meth:`Observer.sampled`."""

    points: SurfacePoints
    inside: BoolArray
    seen: BoolArray


@dataclass(frozen=True, eq=False)
class Paired:
    """See :meth:`Observer.paired`."""

    sampled: SurfacePoints
    pairs: Projection


@dataclass(frozen=True, eq=False)
class Corresponded:
    """See :meth:`Observer.corresponded`."""

    data: FloatArray
    surface: SurfaceResidual


@dataclass(frozen=True, eq=False)
class Correcting:
    """See :meth:`Observer.correcting`."""

    prior: Pose
    P0: FloatArray
    pose: Pose
    P: FloatArray
    rows: tuple[Residual, ...]


@dataclass(frozen=True, eq=False)
class Corrected:
    """See :meth:`Observer.corrected`."""

    pose: Pose
    P: FloatArray
    dx: FloatArray


@dataclass(frozen=True, eq=False)
class CorrectedState:
    """See :meth:`Observer.corrected_state`."""

    x: FloatArray
    P: FloatArray


@dataclass(frozen=True, eq=False)
class Widened:
    """See :meth:`Observer.widened`."""

    P0: FloatArray


@dataclass(frozen=True, eq=False)
class Avoided:
    """See :meth:`Observer.avoided`."""

    x: FloatArray


@dataclass(frozen=True, eq=False)
class Searching:
    """See :meth:`Observer.searching`."""

    evidence: Evidence
    predicted: Pose
    present: Pose


@dataclass(frozen=True, eq=False)
class Proposed:
    """See :meth:`Observer.proposed`."""

    side: int
    arms: Arms
    kept: Arms
    expected: Arms
    other: FloatArray


@dataclass(frozen=True, eq=False)
class Refining:
    """See :meth:`Observer.refining`."""

    proposed: Pose


@dataclass(frozen=True, eq=False)
class Refined:
    """See :meth:`Observer.refined`."""

    pose: Pose
    cost: float


@dataclass(frozen=True, eq=False)
class Searched:
    """See :meth:`Observer.searched`."""

    pose: Pose


Event: TypeAlias = (
    Sought
    | Predicted
    | PredictedState
    | Sampled
    | Paired
    | Corresponded
    | Correcting
    | Corrected
    | CorrectedState
    | Widened
    | Avoided
    | Searching
    | Proposed
    | Refining
    | Refined
    | Searched
)


def _kept(event: Callable[..., Event]) -> Callable[..., None]:
    """A method of :class:`Observer` that keeps what it is told as an event of this kind."""

    def keep(self: Recorder, *told: Any) -> None:
        self.told.append((time.perf_counter(), event(*told)))

    return keep


class Recorder(Observer):
    """Keeps what it is told, with the time at which it was told.

    Attributes
    ----------
    told : list of (float, Event)
        Seconds of the performance counter, and what was told.
    """

    def __init__(self) -> None:
        self.told: list[tuple[float, Event]] = []

    sought = _kept(Sought)
    predicted = _kept(Predicted)
    predicted_state = _kept(PredictedState)
    sampled = _kept(Sampled)
    paired = _kept(Paired)
    corresponded = _kept(Corresponded)
    correcting = _kept(Correcting)
    corrected = _kept(Corrected)
    corrected_state = _kept(CorrectedState)
    widened = _kept(Widened)
    avoided = _kept(Avoided)
    searching = _kept(Searching)
    proposed = _kept(Proposed)
    refining = _kept(Refining)
    refined = _kept(Refined)
    searched = _kept(Searched)
