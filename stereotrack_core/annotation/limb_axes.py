"""How the places of landmarks make the directions of limbs that errors are reported for.

An axis is a difference of landmarks, or of middles of two. With landmarks whose errors P_l are
independent, its direction is off by the mean square angle

    v = sum over l of w_l^2 tr((I - d d^T) P_l) / length^2,

with the weights w_l of the landmarks in it and its unit vector d.
"""

from __future__ import annotations

import numpy as np

from stereotrack_core.annotation.landmark_set import LandmarkSet
from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.recording.landmarks import LANDMARKS

SCORED: tuple[str, ...] = tuple(limb for limb in LIMBS if limb != "head")
"""Limbs whose errors are reported; the head enters no measure."""

_SHOULDERS = {"left_shoulder": 0.5, "right_shoulder": 0.5}
_HIPS = {"left_hip": -0.5, "right_hip": -0.5}
_WEIGHTS: dict[str, dict[str, float]] = {
    "torso": {**_SHOULDERS, **_HIPS},
    "torso_cross_axis": {"left_shoulder": -1.0, "right_shoulder": 1.0},
    "head": {"head": 1.0, "left_shoulder": -0.5, "right_shoulder": -0.5},
    "left_upper_arm": {"left_elbow": 1.0, "left_shoulder": -1.0},
    "right_upper_arm": {"right_elbow": 1.0, "right_shoulder": -1.0},
    "left_forearm": {"left_hand": 1.0, "left_elbow": -1.0},
    "right_forearm": {"right_hand": 1.0, "right_elbow": -1.0},
}

AXES: tuple[str, ...] = tuple(_WEIGHTS)
"""A limb's own axis has its name; the torso has its cross axis besides the long one."""

_LIMB_OF_AXIS: tuple[str, ...] = tuple(
    "torso" if axis == "torso_cross_axis" else axis for axis in AXES
)

COUNTS = np.array([float(limb in SCORED) for limb in _LIMB_OF_AXIS])
"""Ones (7,) for the axes of limbs whose errors are reported, zeros for the others."""

OWN_AXES = [AXES.index(limb) for limb in LIMBS]
"""Places of the limbs' own axes, in the order of ``LIMBS``."""

_FURTHER = 0.5  # weight of a landmark that is none of the nine in the axes of its limb
_SHORTEST = 0.05  # metres; a shorter axis is no limb, and counts as long as this


def axis_quadratics(nine: FloatArray, landmark_set: LandmarkSet) -> FloatArray:
    """Q (..., n, 7, 3, 3) with which v (..., a) = sum over l of tr(Q (..., l, a) P_l).

    Of the nine landmarks (..., 9, 3), world, and n landmarks of a set, in the order of
    :data:`AXES`, in 1 / square metres; NaN where an axis is not known.
    """
    result: FloatArray = np.zeros((*nine.shape[:-2], len(landmark_set.names), len(AXES), 3, 3))
    for i, (weights, limb) in enumerate(zip(_WEIGHTS.values(), _LIMB_OF_AXIS, strict=True)):
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
                result[..., place, i, :, :] = weight**2 * quadratic
    return result


def mean_squares(quadratics: FloatArray, covariance: FloatArray) -> FloatArray:
    """Mean square angles v (..., 7) from :func:`axis_quadratics` and covariances (..., n, 3, 3)."""
    result: FloatArray = np.einsum("...laij,...lji->...a", quadratics, covariance)
    return result


def limb_sigma_deg(
    nine: FloatArray, covariance: FloatArray, landmark_set: LandmarkSet
) -> FloatArray:
    """Root mean square angles (..., 6) in degrees by which limbs may be off.

    The covariances (..., n, 3, 3) of the set's landmarks are taken for independent.
    """
    v = mean_squares(axis_quadratics(nine, landmark_set), covariance)
    return np.degrees(np.sqrt(np.maximum(v[..., OWN_AXES], 0.0)))


def axis_sigma_deg(
    limb_sigma_deg: FloatArray, nine: FloatArray, covariance: FloatArray, landmark_set: LandmarkSet
) -> FloatArray:
    """Angles (..., 7) in degrees of all axes from what a fit states for the limbs (..., 6).

    The torso's cross axis is as much surer or less sure than the long axis as the landmarks say.
    """
    v = mean_squares(axis_quadratics(nine, landmark_set), covariance)
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = np.sqrt(v / v[..., :1])
    result: FloatArray = limb_sigma_deg[..., [LIMBS.index(limb) for limb in _LIMB_OF_AXIS]].copy()
    cross = AXES.index("torso_cross_axis")
    result[..., cross] *= np.nan_to_num(relative[..., cross], nan=1.0, posinf=1.0)
    return result
