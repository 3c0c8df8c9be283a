"""Rotations agree with scipy and keep their precision near 0 and pi; transforms undo each other."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.spatial.transform import Rotation

from stereotrack_core.geometry.rotation import (
    angle_between,
    rotation_from_vector,
    vector_from_rotation,
)
from stereotrack_core.geometry.transform import RigidTransform

vectors = hnp.arrays(np.float64, 3, elements=st.floats(-10, 10, allow_nan=False))


@given(vectors)
def test_the_matrix_is_a_rotation_and_that_of_scipy(vector):
    matrix = rotation_from_vector(vector)
    assert np.allclose(matrix @ matrix.T, np.eye(3), rtol=0, atol=1e-12)
    assert np.linalg.det(matrix) == pytest.approx(1)
    assert np.allclose(matrix, Rotation.from_rotvec(vector).as_matrix(), rtol=0, atol=1e-12)


@given(vectors)
def test_the_vector_comes_back(vector):
    matrix = rotation_from_vector(vector)
    found = vector_from_rotation(matrix)
    assert np.linalg.norm(found) <= np.pi + 1e-9
    assert np.allclose(rotation_from_vector(found), matrix, rtol=0, atol=1e-7)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-6, 9.9e-5, 1.01e-4, 1e-3])
def test_small_angles_are_exact(angle):
    axis = np.array([2.0, -1, 2]) / 3
    found = vector_from_rotation(rotation_from_vector(axis * angle))
    assert np.allclose(found, axis * angle, rtol=1e-9, atol=1e-16)


@given(st.floats(1e-9, np.pi), st.floats(0.01, 100))
def test_the_angle_between_is_the_angle_turned(angle, length):
    turned = rotation_from_vector(np.array([0, 0, angle])) @ [length, 0, 0]
    assert angle_between(np.array([1.0, 0, 0]), turned) == pytest.approx(angle, rel=1e-6)


transforms = st.builds(lambda r, t: RigidTransform(rotation_from_vector(r), t), vectors, vectors)

points = hnp.arrays(np.float64, (4, 3), elements=st.floats(-5, 5))


@given(transforms, transforms, points)
def test_chaining_is_applying_one_after_the_other(a_from_b, b_from_c, in_c):
    expected = a_from_b.apply(b_from_c.apply(in_c))
    assert np.allclose((a_from_b @ b_from_c).apply(in_c), expected, rtol=0, atol=1e-10)


@given(transforms, points)
def test_the_inverse_undoes(a_from_b, in_b):
    assert np.allclose(a_from_b.inverse().apply(a_from_b.apply(in_b)), in_b, rtol=0, atol=1e-10)
    assert np.allclose(
        a_from_b.matrix() @ a_from_b.inverse().matrix(), np.eye(4), rtol=0, atol=1e-12
    )
