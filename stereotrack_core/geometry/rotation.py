"""Rotation vectors and matrices, for single rotations and for stacks of them."""

import numpy as np
import scipy

from stereotrack_core.arrays import FloatArray


def rotation_from_vector(vector: FloatArray) -> FloatArray:
    """Rotation matrices (..., 3, 3) of rotation vectors (..., 3), radians, active (Rodrigues)."""
    v = np.asarray(vector, dtype=np.float64)
    squared = np.einsum("...i,...i->...", v, v)
    angle = np.sqrt(squared)
    small = squared < 1e-8
    safe = np.where(small, 1.0, angle)
    a = np.where(small, 1.0 - squared / 6.0, np.sin(safe) / safe)
    b = np.where(small, 0.5 - squared / 24.0, (1.0 - np.cos(safe)) / (safe * safe))
    k = skew(v)
    return np.asarray(np.eye(3) + a[..., None, None] * k + b[..., None, None] * (k @ k))


def vector_from_rotation(rotation: FloatArray) -> FloatArray:
    """Rotation vector (..., 3) in radians of rotation matrices (..., 3, 3); angle in [0, pi]."""
    matrices = np.asarray(rotation, dtype=np.float64)
    off = np.swapaxes(matrices, -1, -2)
    axis = 0.5 * (matrices - off)[..., [2, 0, 1], [1, 2, 0]]
    sine = np.sqrt(np.einsum("...i,...i->...", axis, axis))
    cosine = 0.5 * (np.einsum("...ii->...", matrices) - 1.0)
    if np.all(cosine > -0.5):
        small = sine < 1e-6
        factor = np.where(small, 1.0, np.arctan2(sine, cosine) / np.where(small, 1.0, sine))
        return factor[..., None] * axis
    # Near half a turn the axis is in the symmetric part.
    rotations = scipy.spatial.transform.Rotation.from_matrix(matrices.reshape(-1, 3, 3))
    return np.asarray(rotations.as_rotvec().reshape(*matrices.shape[:-2], 3))


def skew(vector: FloatArray) -> FloatArray:
    """Matrix (..., 3, 3) whose product with w is the cross product of `vector` (..., 3) and w."""
    v = np.asarray(vector, dtype=np.float64)
    result: FloatArray = np.zeros((*v.shape[:-1], 3, 3))
    result[..., 0, 1], result[..., 0, 2] = -v[..., 2], v[..., 1]
    result[..., 1, 0], result[..., 1, 2] = v[..., 2], -v[..., 0]
    result[..., 2, 0], result[..., 2, 1] = -v[..., 1], v[..., 0]
    return result


def angle_between(a: FloatArray, b: FloatArray) -> FloatArray:
    """Angle in radians between vectors (..., 3); NaN without a length.

    Twice the angle at the base of the rhombus that both span, exact for all angles (W. Kahan).
    """
    u, v = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
    long_u, long_v = _length(u), _length(v)
    same_u, same_v = u * long_v[..., None], v * long_u[..., None]
    angle: FloatArray = 2.0 * np.arctan2(_length(same_u - same_v), _length(same_u + same_v))
    return np.where((long_u == 0) | (long_v == 0), np.nan, angle)


def _length(vector: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.einsum("...i,...i->...", vector, vector)))
