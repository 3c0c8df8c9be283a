"""All that one frame says about a pose, and what every way from it to the pose gives."""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray
from stereotrack_core.body.manifold import Rows, jacobian
from stereotrack_core.body.pose import Pose
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.tracking.correction import (
    Line,
    Observation,
    Residual,
    Sensor,
    gathered,
    solved,
)
from stereotrack_core.tracking.correspondences import DataToModel
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.residuals.clicks import ClickObservation
from stereotrack_core.tracking.residuals.detections import DetectionObservation
from stereotrack_core.tracking.residuals.limits import limit_rows
from stereotrack_core.tracking.residuals.reprojection import KeypointObservation
from stereotrack_core.tracking.residuals.silhouette import silhouettes_of
from stereotrack_core.tracking.residuals.surface import (
    SurfaceResidual,
    surface_distances,
    unexplained_fraction,
)
from stereotrack_core.tracking.state import Belief, Particles, Setup
from stereotrack_core.tracking.step_recorder import StepRecorder


@dataclass(frozen=True, eq=False)
class Measurements:
    """What one frame measures; paired anew with every pose."""

    setup: Setup
    cloud: Cloud
    data: FloatArray  # (N, 3) or (N, 6). Points of the cloud that look for the model.
    correspondences: DataToModel
    observed: tuple[Observation, ...] = ()  # what sensors beside the cloud's points saw
    trace: StepRecorder | None = None  # records what is done with them

    def surface(self, pose: Pose, *, wide: bool, every: int = 1) -> SurfaceResidual:
        """Distances of the data, or of every so many, from the surface that is nearest."""
        data = self.data[::every]
        surface = self.correspondences.surface(data, pose, wide=wide)
        if self.trace is not None:
            self.trace.corresponded(data, surface)
        return surface

    def beside(self, pose: Pose) -> tuple[Residual, ...]:
        """What the sensors say about a pose."""
        body = self.setup.body
        return tuple(row for seen in self.observed for row in seen.residuals(body, pose))

    def corrected(self, prior: Belief, at: Belief, surface: SurfaceResidual) -> Belief:
        """Correct a prior by all measurements, linearised at another pose.

        Iterated posterior linearisation (DOI 10.1109/TSP.2015.2454485): `at` is the posterior of
        the iteration before, and `prior` is always the frame's.
        """
        setup = self.setup
        frames, columns = setup.body.frames(at.pose), setup.columns
        sources = [each.rows(frames) for each in (surface, *self.beside(at.pose))]
        sources.append(self.limits(at.pose))
        after, dx = solved(setup.joints, prior, at.pose, gathered(sources, frames, columns))
        if self.trace is not None:
            lines = [Line(rows, jacobian(rows, frames, columns)) for rows in sources]
            self.trace.corrected(prior, at, after, dx, surface, lines)
        return after

    def limits(self, pose: Pose) -> Rows:
        """Limits of joints and collisions at a pose."""
        return limit_rows(self.setup.body, pose, self.setup.parameters, self.setup.joints)

    def unexplained_fraction(self, pose: Pose) -> float:
        """Share of the data that the body in a pose leaves unexplained."""
        return unexplained_fraction(surface_distances(self.data, self.setup.body, pose))

    def random(self, purpose: int) -> np.random.Generator:
        """Source of what is random in the frame; the same for the same frame and purpose."""
        return np.random.default_rng((self.setup.seed, self.cloud.frame, purpose))


def sensors_for(p: TrackingParameters) -> tuple[Sensor, ...]:
    """The sensors that the parameters ask for, beside the cloud's points."""
    sensors: list[Sensor] = [
        lambda cloud: DetectionObservation(
            tuple(d for d in cloud.detections if d.time == cloud.frame), p.detection_gate
        )
    ]
    sensors.append(lambda cloud: KeypointObservation(cloud.keypoints, p.keypoint_sigma))
    sensors.append(lambda cloud: ClickObservation(cloud.clicks))
    if p.measure_silhouettes:
        sensors.append(lambda cloud: silhouettes_of(cloud, p.silhouette_sigma))
    return tuple(sensors)


@dataclass(frozen=True, eq=False)
class Prediction(Belief):
    """A frame's prediction from the frame before."""

    gone: float  # frames that have gone by
    learned: FloatArray | None = None  # (n, n). Covariance that measurements between took off
    particles: Particles | None = None  # particles of the frame before, if the estimator left some


@dataclass(frozen=True, eq=False)
class Posterior(Belief):
    """What an estimator has found."""

    surface: SurfaceResidual  # pairs of points of the last correction
    innovation: float  # normalised, of the frame's first correction
    P0: FloatArray  # (n, n). Covariance of the prediction as it was used, maybe inflated
    carried: BoolArray  # (n,). False for numbers that were looked for anew
    particles: Particles | None = None  # for the next frame's prediction


class Estimator(ABC):
    """A way from a prediction and measurements to a pose; it keeps nothing from frame to frame."""

    def __init__(self, setup: Setup) -> None:
        self.setup = setup

    @abstractmethod
    def estimate(self, measured: Measurements, predicted: Prediction) -> Posterior:
        """Correct a frame's prediction by its measurements."""
