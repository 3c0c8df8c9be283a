"""What all peers have in common: everything but the way from the data to the pose."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.tracking.colours.tracker import ColouredTracker
from stereotrack_core.tracking.data_to_model import SurfaceResidual
from stereotrack_core.tracking.limits import limit_residuals
from stereotrack_core.tracking.residuals import Residual, innovation_of

WIDE, NARROW = 0, 2
"""Iterations of the tracker in which a datum's weight falls off slowly, and fast."""


class PeerTracker(ColouredTracker, ABC):
    """The tracker with another estimator in the place of its own.

    Body, error state, process noise, choice of data, correspondences with their weights, other
    sensors, limits, the search for somebody who has come back, the refusal of clouds that do not
    look like a body, and all that is stated about a frame are the tracker's. There is neither the
    search for arms nor a prior that is widened where the data ask for it: those belong to its own
    estimator.

    Parameters are those of :class:`ManifoldTracker`.
    """

    @abstractmethod
    def settle(self, frame: int, data: FloatArray, P0: FloatArray) -> None:
        """Set pose and covariance by the data.

        Parameters
        ----------
        frame : int
            For what is random: the same for the same frame.
        data : (N, 3) float64, world, or (N, 6) with colours
        P0 : (n, n) float64
            Covariance of the predicted pose, which ``self.pose`` is.
        """

    def track(self, cloud: Cloud, data: FloatArray) -> tuple[SurfaceResidual, float]:
        """Correct the predicted pose; returns the last pairs and the normalised innovation."""
        self.observe(cloud)
        P0 = self.P
        expected = self.correspond(data, WIDE)
        innovation = innovation_of(expected, self.body, self.pose, P0, self._columns)
        self.settle(cloud.frame, data, P0)
        carried = np.ones(len(P0), dtype=np.bool_)
        self._prior = self.prior(P0, carried)
        return self.correspond(data, NARROW), innovation

    def beside(self) -> tuple[Residual, ...]:
        """What the sensors beside the cloud's points say about the present pose."""
        return tuple(row for seen in self._observed for row in seen.residuals(self.body, self.pose))

    def limits(self) -> tuple[Residual, ...]:
        """Limits of joints and collisions at the present pose."""
        return limit_residuals(self.body, self.pose, self.parameters, self.joints)

    def random(self, frame: int) -> np.random.Generator:
        """Source of what is random in a frame."""
        return np.random.default_rng((self._seed, frame, 3))
