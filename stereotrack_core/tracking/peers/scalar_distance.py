"""Stochastic descent on one number, the sum of distances, as a peer."""

from __future__ import annotations

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.manifold import displaced
from stereotrack_core.filtering.linearisation import Information, posterior
from stereotrack_core.tracking.data_to_model import SurfaceResidual
from stereotrack_core.tracking.peers.base import NARROW, WIDE, PeerTracker
from stereotrack_core.tracking.residuals import gathered

_FIRST_GAIN, _LARGEST_GAIN = 0.2, 0.7
"""First and largest gain of every number, in units of one over the curvature along it."""

_META = 0.1
"""Gain by which gains are adapted."""

_MEMORY = 0.9
"""How long the gains' own gradient remembers."""

_LEAST_CURVATURE = 0.1
"""Curvature of the mean distance that a number is taken to have that no datum speaks about."""

_LONGEST = 0.1
"""Metres and radians by which one step may move a number."""


class ScalarDistanceTracker(PeerTracker):
    """Stochastic meta descent on the sum of distances (Kehl, Bray, Van Gool 2005).

    DOI 10.1109/CVPR.2005.165; the descent is Schraudolph's, DOI 10.1049/cp:19991170. Every step
    draws other data and descends along the gradient g of their robust squared distances, each
    number with a gain of its own, which grows while steps agree:

    gain <- gain max(1/2, 1 - mu g v), dx = -gain g, v <- lambda v - gain (g + lambda H v)

    with the curvature H of the distances, both per datum. Gains are held below the stable ones of
    single numbers. There is no prior: each frame starts at the prediction
    and ends where the sum is least. The covariance that is stated, and nothing else, joins that
    curvature with the process noise.
    """

    def settle(self, frame: int, data: FloatArray, P0: FloatArray) -> None:
        """Descend from the prediction."""
        p, rng = self.parameters.peers, self.random(frame)
        share = 1.0 / self.parameters.effective_points
        slope = self.slope(data, WIDE)
        gain = _FIRST_GAIN / (share * np.diagonal(slope.A) + _LEAST_CURVATURE)
        v = np.zeros(len(P0))
        for i in range(p.scalar_iterations):
            drawn = data[rng.integers(0, len(data), p.scalar_data)]
            slope = self.slope(drawn, WIDE if 2 * i < p.scalar_iterations else NARROW)
            g, H = -share * slope.b, share * slope.A
            longest = _LARGEST_GAIN / (np.diagonal(H) + _LEAST_CURVATURE)
            gain = np.minimum(gain * np.maximum(0.5, 1.0 - _META * g * v), longest)
            step = np.clip(-gain * g, -_LONGEST, _LONGEST)
            self.pose = displaced(self.pose, step, self.joints)
            v = np.clip(_MEMORY * v - gain * (g + _MEMORY * (H @ v)), -1.0, 1.0)
        found = self.slope(data, NARROW)
        P0_inverse: FloatArray = np.linalg.inv(P0).astype(np.float64)
        _, self.P = posterior(P0_inverse, np.zeros(len(P0)), found)

    def slope(self, data: FloatArray, iteration: int) -> Information:
        """Curvature and negative gradient of the sum, at the pose; sensors and limits take part."""
        surface: SurfaceResidual = self.correspond(data, iteration)
        rows = (surface, *self.beside(), *self.limits())
        return gathered(rows, self.body, self.pose, self._columns)
