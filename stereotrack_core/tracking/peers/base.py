"""What baselines have in common: everything but the way from the data to the pose."""

from __future__ import annotations

from abc import abstractmethod

import numpy as np

from stereotrack_core.tracking.correction import innovation_of
from stereotrack_core.tracking.estimator import Estimator, Posterior, Prediction
from stereotrack_core.tracking.measurements import Measurements
from stereotrack_core.tracking.state import Belief

RANDOM = 3
"""Purpose for which baselines draw random numbers."""


class Baseline(Estimator):
    """Another estimator in the place of the iterated one.

    Body, error state, process noise, choice of data, correspondences with their weights, other
    sensors, limits, the search for somebody who has come back, the refusal of clouds that do not
    look like a body, and all that is stated about a frame are the tracker's. There is neither the
    search for arms nor a prior that is widened where the data ask for it: those belong to the
    iterated estimator.
    """

    @abstractmethod
    def settle(self, measured: Measurements, predicted: Prediction) -> Belief:
        """Find the pose and its covariance by the data."""

    def estimate(self, measured: Measurements, predicted: Prediction) -> Posterior:
        """Correct the predicted pose."""
        expected = measured.surface(predicted.pose, wide=True)
        innovation = innovation_of(expected, self.setup, predicted)
        found = self.settle(measured, predicted)
        carried = np.ones(len(predicted.P), dtype=np.bool_)
        surface = measured.surface(found.pose, wide=False)
        return Posterior(found.pose, found.P, surface, innovation, predicted.P, carried)
