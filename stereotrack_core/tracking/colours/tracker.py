"""The tracker whose data look for their part by place and colour."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.tracking.colours.features import colour_features
from stereotrack_core.tracking.colours.model import PartColours
from stereotrack_core.tracking.data_to_model import SurfaceResidual, Trust, surface_residual
from stereotrack_core.tracking.detections.listening import ListeningTracker
from stereotrack_core.tracking.estimate import Estimate, Memory
from stereotrack_core.tracking.parameters import TrackingParameters

_WIDE_ITERATIONS = 2

_TRUSTED = 0.25
"""Unexplained fraction of the cloud above which a pose teaches nothing."""


class ColouredTracker(ListeningTracker):
    """Give data to the part that is nearest in six dimensions: three of space, three of colour.

    With weight 0, and in recordings without colours, nothing differs from
    :class:`ListeningTracker`. Data are then (N, 6): places and colour features side by side.

    Parameters are those of :class:`ManifoldTracker`.
    """

    def __init__(
        self,
        body: BodyModel,
        parameters: TrackingParameters,
        cameras: FloatArray,
        fps: float,
        seed: int,
    ) -> None:
        self._known = PartColours(body)
        self._chosen: FloatArray | None = None
        super().__init__(body, parameters, cameras, fps, seed)

    def step(self, cloud: Cloud) -> Estimate:
        """Follow to the next cloud, and learn from it where it is well explained."""
        self._chosen = None
        estimate = super().step(cloud)
        data = self._chosen
        if data is not None and estimate.tracked and estimate.unexplained_fraction < _TRUSTED:
            frames, memory = self.body.frames(self.pose), self.parameters.colours.colour_memory
            self._known.learn(data[:, :3], data[:, 3:], frames, memory)
        return estimate

    def memory(self) -> Memory:
        """All that the next step depends on, the parts' colours too."""
        if self.parameters.colours.colour_weight == 0.0:
            return super().memory()
        known = self._known
        return {
            **super().memory(),
            "colour_count": known.count,
            "colour_mean": known.mean,
            "colour_square": known.square,
        }

    def recall(self, memory: Memory) -> None:
        """Go on as the tracker would whose memory this is."""
        super().recall(memory)
        if "colour_count" in memory:
            known = self._known
            known.count, known.mean = memory["colour_count"].copy(), memory["colour_mean"].copy()
            known.square = memory["colour_square"].copy()

    def choose(self, cloud: Cloud) -> FloatArray:
        """Draw the data (N, 3), or (N, 6) with their colours."""
        colours = cloud.colours
        if self.parameters.colours.colour_weight == 0.0 or colours is None:
            return super().choose(cloud)
        if len(colours) != len(cloud.points):
            return super().choose(cloud)
        wider = np.hstack([cloud.points, colour_features(colours)])
        self._chosen = super().choose(replace(cloud, points=wider))
        return self._chosen

    def correspond(self, data: FloatArray, iteration: int) -> SurfaceResidual:
        """Give the data to the cones that are nearest at the present pose."""
        if data.shape[1] == 3:
            return super().correspond(data, iteration)
        p, frames = self.parameters, self.body.frames(self.pose)
        scale = p.robust_wide if iteration < _WIDE_ITERATIONS else p.robust_narrow
        trust = Trust(p.reach, scale, p.sigma_measurement, p.effective_points)
        places = np.ascontiguousarray(data[:, :3])
        penalty = p.colours.colour_weight * self._known.penalty(places, data[:, 3:], frames)
        surface = surface_residual(places, self.body, frames, trust, penalty)
        self.observer.corresponded(data, surface)
        return surface
