"""From a frame's measurements to a pose: what every way of estimating is given, and gives."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

from stereotrack_core.arrays import BoolArray, FloatArray
from stereotrack_core.body.pose import Pose
from stereotrack_core.tracking.data_to_model import SurfaceResidual
from stereotrack_core.tracking.estimate import Memory
from stereotrack_core.tracking.measurements import Measurements
from stereotrack_core.tracking.state import Belief, Setup


@dataclass(frozen=True, eq=False)
class Prediction(Belief):
    """A frame's prediction from the frame before.

    Attributes
    ----------
    movement : (n,) float64
        Displacement from the last frame's pose that was expected.
    gone : float
        Frames that have gone by.
    learned : (n, n) float64 or None
        Covariance that measurements between the frames have taken off; None without any.
    """

    movement: FloatArray
    gone: float
    learned: FloatArray | None = None


@dataclass(frozen=True, eq=False)
class Posterior(Belief):
    """What an estimator has found.

    Attributes
    ----------
    surface : SurfaceResidual
        Pairs of points of the last correction.
    innovation : float
        Normalised, of the frame's first correction.
    P0 : (n, n) float64
        Covariance of the prediction that was really used, as far as it was widened.
    carried : (n,) bool
        False for numbers that were not predicted but looked for anew.
    """

    surface: SurfaceResidual
    innovation: float
    P0: FloatArray
    carried: BoolArray


class Estimator(ABC):
    """A way from a prediction and measurements to a pose.

    Parameters
    ----------
    setup : Setup
    """

    def __init__(self, setup: Setup) -> None:
        self.setup = setup

    @abstractmethod
    def estimate(self, measured: Measurements, predicted: Prediction) -> Posterior:
        """Correct a frame's prediction by its measurements."""

    def begin(self, pose: Pose) -> None:  # noqa: B027 - most keep nothing from frame to frame
        """Forget what was kept of earlier frames: the next one is predicted from this pose."""

    def memory(self) -> Memory:
        """All that is kept from frame to frame."""
        return {}

    def recall(self, memory: Memory) -> None:  # noqa: B027
        """Go on as the estimator would whose memory this is."""
