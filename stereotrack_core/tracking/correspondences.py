"""Which measured points belong to which part: nearest in space, and in colour where known."""

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.pose import Pose
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.tracking.part_colours import PartColours, colour_features
from stereotrack_core.tracking.residuals.surface import SurfaceResidual, Trust, surface_residual
from stereotrack_core.tracking.state import Setup

_TRUSTED = 0.25  # unexplained fraction above which a pose teaches nothing about colours


@dataclass(frozen=True, eq=False)
class DataToModel:
    """Gives measured points to the cones that are nearest.

    With colours they are nearest in six dimensions: three of space, three of colour. Data are then
    (N, 6): places and colour features side by side.
    """

    setup: Setup
    colours: PartColours | None = None  # learned so far; None if colours are not used

    def choose(self, cloud: Cloud) -> FloatArray:
        """Draw the data (N, 3), or (N, 6), evenly from the cloud; the same for the same frame."""
        points, colours = cloud.points, cloud.colours
        if self.colours is not None and colours is not None and len(colours) == len(points):
            points = np.hstack([points, colour_features(colours)])
        wanted, there = self.setup.parameters.data_points, len(points)
        if there > wanted:
            rng = np.random.default_rng((self.setup.seed, cloud.frame))
            points = points[np.sort(rng.choice(there, wanted, replace=False))]
        return points

    def surface(self, data: FloatArray, pose: Pose, *, wide: bool) -> SurfaceResidual:
        """Give data (N, 3 or 6) to the cones nearest at a pose; `wide` weights fall slowly."""
        p, body = self.setup.parameters, self.setup.body
        frames = body.frames(pose)
        trust = Trust.of(p, wide=wide)
        if self.colours is None or data.shape[1] == 3:
            return surface_residual(data, body, frames, trust)
        places = np.ascontiguousarray(data[:, :3])
        penalty = p.colour_weight * self.colours.penalty(body, places, data[:, 3:], frames)
        return surface_residual(places, body, frames, trust, penalty)

    def learned(self, cloud: Cloud, pose: Pose, unexplained_fraction: float) -> PartColours | None:
        """Colours after a frame, which teaches some if its pose explains the cloud."""
        if self.colours is None or not unexplained_fraction < _TRUSTED:
            return self.colours
        data, body = self.choose(cloud), self.setup.body
        if data.shape[1] == 3:
            return self.colours
        return self.colours.updated(body, data[:, :3], data[:, 3:], body.frames(pose))
