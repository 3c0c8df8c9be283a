"""What baselines have in common, and the simplest of them."""

from __future__ import annotations

from abc import abstractmethod

import numpy as np

from stereotrack_core.tracking.correction import innovation_of
from stereotrack_core.tracking.estimator import Estimator, Measurements, Posterior, Prediction
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


class ExtendedKalman(Baseline):
    """One linearisation at the prediction, one correction (Kalman, DOI 10.1115/1.3662552).

    With the Jacobian H of the distances at the predicted pose, P = (I - K H) P0 and
    dx = K nu with K = P0 H' (H P0 H' + R)^-1. It is computed in the information form, which is
    the same by the matrix inversion lemma: P = (P0^-1 + H' R^-1 H)^-1 and dx = P H' R^-1 nu;
    there are many more data than states.
    """

    def settle(self, measured: Measurements, predicted: Prediction) -> Belief:
        """Correct once."""
        surface = measured.surface(predicted.pose, wide=True)
        return measured.corrected(predicted, predicted, surface)
