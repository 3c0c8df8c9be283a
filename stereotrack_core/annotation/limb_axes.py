"""How the places of landmarks make the directions of limbs that errors are reported for.

An axis is a difference of landmarks, or of middles of two. With landmarks whose errors P_l are
independent, its direction is off by the mean square angle

    v = sum over l of w_l^2 tr((I - d d^T) P_l) / length^2,

with the weights w_l of the landmarks in it and its unit vector d.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stereotrack_core.annotation.landmark_set import LandmarkSet
from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.recording.landmarks import LANDMARKS

SCORED: tuple[str, ...] = tuple(limb for limb in LIMBS if limb != "head")
"""Limbs whose errors are reported; the head enters no measure."""

_SHOULDERS = {"left_shoulder": 0.5, "right_shoulder": 0.5}
_HIPS = {"left_hip": -0.5, "right_hip": -0.5}
_AXES: tuple[tuple[str, dict[str, float]], ...] = (
    ("torso", {**_SHOULDERS, **_HIPS}),
    ("torso", {"left_shoulder": -1.0, "right_shoulder": 1.0}),
    ("head", {"head": 1.0, "left_shoulder": -0.5, "right_shoulder": -0.5}),
    ("left_upper_arm", {"left_elbow": 1.0, "left_shoulder": -1.0}),
    ("right_upper_arm", {"right_elbow": 1.0, "right_shoulder": -1.0}),
    ("left_forearm", {"left_hand": 1.0, "left_elbow": -1.0}),
    ("right_forearm", {"right_hand": 1.0, "right_elbow": -1.0}),
)
"""Limb and weights of every axis; the torso has its long and its cross axis."""

_FURTHER = 0.5
"""Weight of a landmark that is none of the nine in the axes of its limb."""

_SHORTEST = 0.05
"""Metres; a shorter axis is no limb, and counts as long as this."""


def limb_quadratics(nine: FloatArray, landmark_set: LandmarkSet) -> FloatArray:
    """What turns covariances into angles: v (..., m) = sum over l of tr(Q (..., l, m) P_l).

    Parameters
    ----------
    nine : (..., 9, 3) float64, world, metres
        The landmarks of every reference.
    landmark_set : LandmarkSet
        n landmarks.

    Returns
    -------
    (..., n, 6, 3, 3) float64, 1 / square metres
        Limbs in the order of ``LIMBS``; NaN where an axis is not known.
    """
    result: FloatArray = np.zeros((*nine.shape[:-2], len(landmark_set.names), len(LIMBS), 3, 3))
    for limb, weights in _AXES:
        axis = sum(weight * nine[..., LANDMARKS.index(name), :] for name, weight in weights.items())
        length = np.linalg.norm(axis, axis=-1)[..., None]
        along = axis / np.where(length > 0, length, 1.0)
        across = np.eye(3) - along[..., :, None] * along[..., None, :]
        quadratic = across / np.maximum(length, _SHORTEST)[..., None] ** 2
        for place, landmark in enumerate(landmark_set.landmarks):
            weight = weights.get(landmark.name, 0.0)
            if landmark.name not in LANDMARKS and landmark.limb == limb:
                weight = _FURTHER
            if weight:
                result[..., place, LIMBS.index(limb), :, :] += weight**2 * quadratic
    return result


def limb_sigma_deg(
    nine: FloatArray, covariance: FloatArray, landmark_set: LandmarkSet
) -> FloatArray:
    """Root mean square angles (..., 6) in degrees by which limbs may be off.

    Parameters
    ----------
    nine : (..., 9, 3) float64, world, metres
    covariance : (..., n, 3, 3) float64, square metres
        Of the landmarks of the set, taken for independent.
    landmark_set : LandmarkSet
    """
    quadratics = limb_quadratics(nine, landmark_set)
    v = np.einsum("...lmij,...lji->...m", quadratics, covariance)
    result: FloatArray = np.degrees(np.sqrt(np.maximum(v, 0.0)))
    return result


def scored(limbs: Sequence[str] = SCORED) -> FloatArray:
    """Ones (6,) for the limbs that count, zeros for the others."""
    return np.array([float(limb in limbs) for limb in LIMBS])
