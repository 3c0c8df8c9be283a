"""Rotations agree with scipy, undo each other and keep their precision near 0 and pi."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.spatial.transform import Rotation

from stereotrack_core.geometry.rotation import (
    angle_between,
    rotation_from_vector,
    skew,
    vector_from_rotation,
)

number = st.floats(-10, 10, allow_nan=False)
vectors = hnp.arrays(np.float64, 3, elements=number)


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


def test_stacks_are_treated_one_by_one():
    stack = np.random.default_rng(0).normal(size=(4, 2, 3))
    matrices = rotation_from_vector(stack)
    assert matrices.shape == (4, 2, 3, 3)
    assert np.array_equal(matrices[3, 1], rotation_from_vector(stack[3, 1]))
    assert np.allclose(vector_from_rotation(matrices), stack)
    assert vector_from_rotation(np.empty((0, 3, 3))).shape == (0, 3)


@given(vectors, vectors)
def test_skew_is_the_cross_product(a, b):
    assert np.allclose(skew(a) @ b, np.cross(a, b), rtol=1e-12, atol=1e-12)


@given(st.floats(1e-9, np.pi), st.floats(0.01, 100))
def test_the_angle_between_is_the_angle_turned(angle, length):
    turned = rotation_from_vector(np.array([0, 0, angle])) @ [length, 0, 0]
    assert angle_between(np.array([1.0, 0, 0]), turned) == pytest.approx(angle, rel=1e-6)


def test_angles_to_nothing_are_unknown():
    found = angle_between(np.array([[0, 0, 0], [np.nan, 0, 0], [1.0, 0, 0]]), np.array([1.0, 0, 0]))
    assert np.isnan(found[:2]).all()
    assert found[2] == 0
