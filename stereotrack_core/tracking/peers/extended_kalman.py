"""The extended Kalman filter as a baseline."""

from __future__ import annotations

from stereotrack_core.tracking.estimator import Prediction
from stereotrack_core.tracking.measurements import Measurements
from stereotrack_core.tracking.peers.base import Baseline
from stereotrack_core.tracking.state import Belief


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
