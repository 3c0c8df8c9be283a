"""Stochastic descent on one number, the sum of distances, as a baseline."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.manifold import displaced
from stereotrack_core.body.pose import Pose
from stereotrack_core.filtering.linearisation import Information, posterior
from stereotrack_core.tracking.baselines.base import RANDOM, Baseline
from stereotrack_core.tracking.correction import gathered
from stereotrack_core.tracking.estimator import Measurements, Prediction
from stereotrack_core.tracking.state import Belief

STEPS, _DRAWN = 80, 300
"""Steps of the descent in a frame, and data drawn for each."""

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


class ScalarDistance(Baseline):
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

    def settle(self, measured: Measurements, predicted: Prediction) -> Belief:
        """Descend from the prediction."""
        rng, pose = measured.random(RANDOM), predicted.pose
        share = 1.0 / self.setup.parameters.effective_sample_size
        slope = slope_at(measured, pose, wide=True)
        gain = _FIRST_GAIN / (share * np.diagonal(slope.A) + _LEAST_CURVATURE)
        v = np.zeros(len(predicted.P))
        for i in range(STEPS):
            drawn = measured.data[rng.integers(0, len(measured.data), _DRAWN)]
            wide = 2 * i < STEPS
            slope = slope_at(replace(measured, data=drawn), pose, wide=wide)
            g, H = -share * slope.b, share * slope.A
            longest = _LARGEST_GAIN / (np.diagonal(H) + _LEAST_CURVATURE)
            gain = np.minimum(gain * np.maximum(0.5, 1.0 - _META * g * v), longest)
            step = np.clip(-gain * g, -_LONGEST, _LONGEST)
            pose = displaced(pose, step, self.setup.joints)
            v = np.clip(_MEMORY * v - gain * (g + _MEMORY * (H @ v)), -1.0, 1.0)
        found = slope_at(measured, pose, wide=False)
        P0_inverse: FloatArray = np.linalg.inv(predicted.P).astype(np.float64)
        _, P = posterior(P0_inverse, np.zeros(len(v)), found)
        return Belief(pose, P)


def slope_at(measured: Measurements, pose: Pose, *, wide: bool) -> Information:
    """Curvature and negative gradient of the sum at a pose; sensors and limits take part."""
    rows = (measured.surface(pose, wide=wide), *measured.beside(pose), *measured.limits(pose))
    return gathered(rows, measured.setup.body, pose, measured.setup.columns)
