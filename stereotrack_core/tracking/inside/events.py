"""What a tracker has told of one frame, in its order; nothing is worked out here."""

# ruff: noqa: D102 - what the methods mean stands at Observer
from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TypeAlias

from stereotrack_core.arrays import BoolArray, FloatArray
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.sampling import SurfacePoints
from stereotrack_core.tracking.data_to_model import SurfaceResidual
from stereotrack_core.tracking.inside.observer import Observer
from stereotrack_core.tracking.residuals import Residual
from stereotrack_core.tracking.search.arms import Arms
from stereotrack_core.tracking.search.search import Evidence
from stereotrack_core.tracking.thesis import Projection


@dataclass(frozen=True, eq=False)
class Sought:
    """See :meth:`Observer.sought`."""

    pose: Pose


@dataclass(frozen=True, eq=False)
class Predicted:
    """See :meth:`Observer.predicted`."""

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


class Recorder(Observer):
    """Keeps what it is told, with the time at which it was told.

    Attributes
    ----------
    told : list of (float, Event)
        Seconds of the performance counter, and what was told.
    """

    def __init__(self) -> None:
        self.told: list[tuple[float, Event]] = []

    def _keep(self, event: Event) -> None:
        self.told.append((time.perf_counter(), event))

    def sought(self, pose: Pose) -> None:
        self._keep(Sought(pose))

    def predicted(self, pose: Pose, P: FloatArray) -> None:
        self._keep(Predicted(pose, P))

    def predicted_state(self, x: FloatArray, P: FloatArray) -> None:
        self._keep(PredictedState(x, P))

    def sampled(self, points: SurfacePoints, inside: BoolArray, seen: BoolArray) -> None:
        self._keep(Sampled(points, inside, seen))

    def paired(self, sampled: SurfacePoints, pairs: Projection) -> None:
        self._keep(Paired(sampled, pairs))

    def corresponded(self, data: FloatArray, surface: SurfaceResidual) -> None:
        self._keep(Corresponded(data, surface))

    def correcting(
        self, prior: Pose, P0: FloatArray, pose: Pose, P: FloatArray, rows: tuple[Residual, ...]
    ) -> None:
        self._keep(Correcting(prior, P0, pose, P, rows))

    def corrected(self, pose: Pose, P: FloatArray, dx: FloatArray) -> None:
        self._keep(Corrected(pose, P, dx))

    def corrected_state(self, x: FloatArray, P: FloatArray) -> None:
        self._keep(CorrectedState(x, P))

    def widened(self, P0: FloatArray) -> None:
        self._keep(Widened(P0))

    def avoided(self, x: FloatArray) -> None:
        self._keep(Avoided(x))

    def searching(self, evidence: Evidence, predicted: Pose, present: Pose) -> None:
        self._keep(Searching(evidence, predicted, present))

    def proposed(
        self, side: int, arms: Arms, kept: Arms, expected: Arms, other: FloatArray
    ) -> None:
        self._keep(Proposed(side, arms, kept, expected, other))

    def refining(self, proposed: Pose) -> None:
        self._keep(Refining(proposed))

    def refined(self, pose: Pose, cost: float) -> None:
        self._keep(Refined(pose, cost))

    def searched(self, pose: Pose) -> None:
        self._keep(Searched(pose))
