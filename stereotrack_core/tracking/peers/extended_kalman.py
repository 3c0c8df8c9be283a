"""The extended Kalman filter as a peer."""

from __future__ import annotations

from stereotrack_core.arrays import FloatArray
from stereotrack_core.tracking.peers.base import WIDE, PeerTracker


class ExtendedKalmanTracker(PeerTracker):
    """One linearisation at the prediction, one correction (Kalman, DOI 10.1115/1.3662552).

    With the Jacobian H of the distances at the predicted pose, P = (I - K H) P0 and
    dx = K nu with K = P0 H' (H P0 H' + R)^-1. It is computed in the information form, which is
    the same by the matrix inversion lemma: P = (P0^-1 + H' R^-1 H)^-1 and dx = P H' R^-1 nu;
    there are many more data than states.
    """

    def settle(self, frame: int, data: FloatArray, P0: FloatArray) -> None:  # noqa: ARG002
        """Correct once."""
        self.correct(self.pose, P0, self.correspond(data, WIDE))
