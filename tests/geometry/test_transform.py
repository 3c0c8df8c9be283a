"""Rigid transforms chain and undo each other."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.transform import RigidTransform

vectors = hnp.arrays(np.float64, 3, elements=st.floats(-5, 5))
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


@given(transforms, points)
def test_the_matrix_does_the_same(a_from_b, in_b):
    homogeneous = np.concatenate([in_b, np.ones((4, 1))], axis=1)
    assert np.allclose((homogeneous @ a_from_b.matrix().T)[:, :3], a_from_b.apply(in_b))


def test_identity_changes_nothing():
    assert RigidTransform.identity().apply(np.array([1.0, 2, 3])).tolist() == [1, 2, 3]
