"""Which measured points belong to which part: nearest in space, and in colour where known."""

from __future__ import annotations

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.pose import Pose
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.tracking.estimate import Memory
from stereotrack_core.tracking.residuals.colour import PartColours, colour_features
from stereotrack_core.tracking.residuals.surface import SurfaceResidual, Trust, surface_residual
from stereotrack_core.tracking.state import Setup

_TRUSTED = 0.25
"""Unexplained fraction of the cloud above which a pose teaches nothing about colours."""


class DataToModel:
    """Gives measured points to the cones that are nearest.

    With colours they are nearest in six dimensions: three of space, three of colour. Data are then
    (N, 6): places and colour features side by side. Where a recording has no colours, or they
    have no weight, nothing differs.

    Parameters
    ----------
    coloured : bool
        Whether colours are learned and used, where the parameters want it.
    """

    def __init__(self, setup: Setup, *, coloured: bool = False) -> None:
        self.setup = setup
        coloured = coloured and setup.parameters.colour_weight > 0.0
        self._known = PartColours(setup.body) if coloured else None
        self._chosen: FloatArray | None = None

    def choose(self, cloud: Cloud) -> FloatArray:
        """Draw the data (N, 3), or (N, 6), evenly from the cloud; the same for the same frame."""
        points, colours = cloud.points, cloud.colours
        usable = self._known is not None and colours is not None and len(colours) == len(points)
        if usable and colours is not None:
            points = np.hstack([points, colour_features(colours)])
        wanted, there = self.setup.parameters.data_points, len(points)
        if there > wanted:
            rng = np.random.default_rng((self.setup.seed, cloud.frame))
            points = points[np.sort(rng.choice(there, wanted, replace=False))]
        self._chosen = points if usable else None
        return points

    def surface(self, data: FloatArray, pose: Pose, *, wide: bool) -> SurfaceResidual:
        """Give the data to the cones that are nearest at a pose.

        Parameters
        ----------
        data : (N, 3) or (N, 6) float64
            See :meth:`choose`.
        wide : bool
            Whether a datum's weight falls off slowly with its distance.
        """
        p, body = self.setup.parameters, self.setup.body
        frames = body.frames(pose)
        trust = Trust.of(p, wide=wide)
        if self._known is None or data.shape[1] == 3:
            return surface_residual(data, body, frames, trust)
        places = np.ascontiguousarray(data[:, :3])
        penalty = p.colour_weight * self._known.penalty(places, data[:, 3:], frames)
        return surface_residual(places, body, frames, trust, penalty)

    def learn(self, pose: Pose, unexplained_fraction: float) -> None:
        """Learn the parts' colours from the data of a frame, where its pose explains the cloud."""
        data = self._chosen
        if self._known is None or data is None or not unexplained_fraction < _TRUSTED:
            return
        self._known.learn(data[:, :3], data[:, 3:], self.setup.body.frames(pose))

    def memory(self) -> Memory:
        """All that the next frame's correspondences depend on."""
        known = self._known
        if known is None:
            return {}
        return {
            "colour_count": known.count,
            "colour_mean": known.mean,
            "colour_square": known.square,
        }

    def recall(self, memory: Memory) -> None:
        """Go on as those would whose memory this is."""
        known = self._known
        if known is not None and "colour_count" in memory:
            known.count, known.mean = memory["colour_count"].copy(), memory["colour_mean"].copy()
            known.square = memory["colour_square"].copy()
