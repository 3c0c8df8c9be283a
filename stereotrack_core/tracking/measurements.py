"""All that one frame says about a pose, paired anew with every pose."""

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.manifold import Rows
from stereotrack_core.body.pose import Pose
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.tracking.correction import Observation, Residual, gathered, solved
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.part_colours import PartColours, colour_features
from stereotrack_core.tracking.residuals.clicks import ClickObservation
from stereotrack_core.tracking.residuals.detections import DetectionObservation
from stereotrack_core.tracking.residuals.limits import limit_rows
from stereotrack_core.tracking.residuals.reprojection import KeypointObservation
from stereotrack_core.tracking.residuals.silhouette import silhouettes_of
from stereotrack_core.tracking.residuals.surface import (
    SurfaceResidual,
    Trust,
    surface_distances,
    surface_residual,
    unexplained_fraction,
)
from stereotrack_core.tracking.state import Belief, Setup
from stereotrack_core.tracking.step_recorder import StepRecorder

_TRUSTED = 0.25  # unexplained fraction above which a pose teaches nothing about colours


def chosen_data(setup: Setup, cloud: Cloud, learned: PartColours | None = None) -> FloatArray:
    """Draw data evenly from the cloud; the same for the same frame.

    They are places (N, 3); with `learned` colours places and colour features (N, 6), which are near
    a part in six dimensions.
    """
    points, colours = cloud.points, cloud.colours
    if learned is not None and colours is not None and len(colours) == len(points):
        points = np.hstack([points, colour_features(colours)])
    wanted, there = setup.parameters.data_points, len(points)
    if there > wanted:
        rng = np.random.default_rng((setup.seed, cloud.frame))
        points = points[np.sort(rng.choice(there, wanted, replace=False))]
    return points


def colours_after(
    setup: Setup, colours: PartColours | None, cloud: Cloud, pose: Pose, unexplained: float
) -> PartColours | None:
    """Learned colours after a frame, which teaches some if its pose explains the cloud."""
    if colours is None or not unexplained < _TRUSTED:
        return colours
    data = chosen_data(setup, cloud, colours)
    if data.shape[1] == 3:
        return colours
    return colours.updated(setup.body, data[:, :3], data[:, 3:], setup.body.frames(pose))


@dataclass(frozen=True, eq=False)
class Measurements:
    """What one frame measures."""

    setup: Setup
    cloud: Cloud
    data: FloatArray  # (N, 3) or (N, 6). Points of the cloud that look for the model.
    colours: PartColours | None = None  # learned so far; None if colours are not used
    observed: tuple[Observation, ...] = ()  # what sensors beside the cloud's points saw
    trace: StepRecorder | None = None  # records what is done with them

    def surface(self, pose: Pose, *, wide: bool, every: int = 1) -> SurfaceResidual:
        """Distances of the data, or of every so many, from the nearest surface.

        `wide` weights fall slowly.
        """
        p, body, data = self.setup.parameters, self.setup.body, self.data[::every]
        frames, trust = body.frames(pose), Trust.of(p, wide=wide)
        if self.colours is None or data.shape[1] == 3:
            surface = surface_residual(data, body, frames, trust)
        else:
            places = np.ascontiguousarray(data[:, :3])
            penalty = p.colour_weight * self.colours.penalty(body, places, data[:, 3:], frames)
            surface = surface_residual(places, body, frames, trust, penalty)
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
        frames = setup.body.frames(at.pose)
        sources = [each.rows(frames) for each in (surface, *self.beside(at.pose))]
        sources.append(self.limits(at.pose))
        after, dx = solved(setup.joints, prior, at.pose, gathered(sources, frames, setup.columns))
        if self.trace is not None:
            self.trace.corrected(prior, at, after, dx, surface, sources)
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


def observations(p: TrackingParameters, cloud: Cloud) -> tuple[Observation, ...]:
    """What the sensors beside the cloud's points saw, as far as the parameters ask for them."""
    detections = tuple(d for d in cloud.detections if d.time == cloud.frame)
    seen = (
        DetectionObservation(detections, p.detection_gate),
        KeypointObservation(cloud.keypoints, p.keypoint_sigma),
        ClickObservation(cloud.clicks),
    )
    return (*seen, silhouettes_of(cloud, p.silhouette_sigma)) if p.measure_silhouettes else seen
