"""One step of the Rauch-Tung-Striebel smoother for random walks (DOI 10.2514/3.3166)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from stereotrack_core.arrays import BoolArray, FloatArray


@dataclass(frozen=True, eq=False)
class BackwardStep:
    """How what is known of the next frame comes back to this one.

    Attributes
    ----------
    gain : (n, n) float64
        C: the smoothed error state of this frame is C times that of the next frame, both seen
        from what was filtered and from what was predicted of it. Columns that the next frame did
        not take over from this one are zero.
    P : (n, n) float64
        Smoothed covariance; never larger than the filtered one.
    """

    gain: FloatArray
    P: FloatArray


def backward_step(
    P: FloatArray, predicted: FloatArray, carried: BoolArray, after: FloatArray
) -> BackwardStep:
    """Go one frame back: C = P predicted^-1 and P + C (after - predicted) C'.

    The next state is this one plus noise, where it was carried over; elsewhere it was drawn anew
    and tells nothing about this one but through what is correlated with it here. A prediction
    that is in some direction more certain than P, as one whose parts were widened by different
    factors can be, is no random walk; it is widened until it is one, so that P never becomes
    indefinite.

    Parameters
    ----------
    P : (n, n) float64
        Filtered covariance of this frame.
    predicted : (n, n) float64
        Covariance that the next frame's correction began from.
    carried : (n,) bool
        Which numbers of the next frame were predicted from this one.
    after : (n, n) float64
        Smoothed covariance of the next frame.
    """
    gain = np.zeros_like(P)
    if not carried.any():
        return BackwardStep(gain, P)
    block = np.ix_(carried, carried)
    prior = _reachable(P[block], predicted[block])
    factor = scipy.linalg.cho_factor(prior)
    C = scipy.linalg.cho_solve(factor, P[carried]).T
    gain[:, carried] = C
    smoothed = P - C @ (prior - after[block]) @ C.T
    return BackwardStep(gain, 0.5 * (smoothed + smoothed.T))


def _reachable(P: FloatArray, predicted: FloatArray) -> FloatArray:
    """P plus the part of predicted - P that a process noise can have."""
    values, vectors = np.linalg.eigh(0.5 * (predicted + predicted.T) - P)
    result: FloatArray = P + (vectors * np.maximum(values, 0.0)) @ vectors.T
    return result
