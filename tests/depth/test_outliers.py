import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial import KDTree

from stereotrack_core.depth.points import inliers


def brute_force(points, neighbours, distance, repeat):
    kept = list(range(len(points)))
    while True:
        left = []
        for i in kept:
            others = sorted(float(np.linalg.norm(points[i] - points[j])) for j in kept if j != i)
            if len(others) >= neighbours and others[neighbours - 1] <= distance:
                left.append(i)
        changed = len(left) != len(kept)
        kept = left
        if not repeat or not changed:
            return kept


@given(
    arrays(np.float64, st.tuples(st.integers(0, 30), st.just(3)), elements=st.floats(0.0, 0.3)),
    st.integers(1, 6),
    st.floats(0.01, 0.2),
    st.booleans(),
)
@settings(max_examples=80, deadline=None)
def test_outliers_agree_with_brute_force(points, neighbours, distance, repeat):
    got = np.flatnonzero(inliers(points, neighbours, distance, repeat=repeat))
    assert got.tolist() == brute_force(points, neighbours, distance, repeat)


def test_the_order_of_points_does_not_matter():
    rng = np.random.default_rng(2)
    points, order = rng.normal(size=(400, 3)), rng.permutation(400)
    kept = inliers(points, 8, 0.9, repeat=True)
    assert 0 < kept.sum() < 400
    assert np.array_equal(inliers(points[order], 8, 0.9, repeat=True), kept[order])


def test_without_neighbours_all_stay():
    assert inliers(np.zeros((3, 3)), 0, 0.06, repeat=True).all()


@pytest.mark.parametrize("distance", [0.001, 0.02, 0.06, 0.4])
def test_outliers_agree_with_a_tree_on_a_cloud_with_far_points(distance):
    rng = np.random.default_rng(5)
    points = np.concatenate([rng.normal(0, 0.2, (3000, 3)), rng.uniform(-4, 4, (300, 3))])
    farthest, _ = KDTree(points).query(points, k=[9])
    expected = farthest[:, 0] <= distance
    assert np.array_equal(inliers(points, 8, distance, repeat=False), expected)


def test_points_on_top_of_each_other_are_neighbours():
    points = np.concatenate([np.zeros((9, 3)), np.ones((8, 3))])
    assert inliers(points, 8, 0.06, repeat=False).tolist() == [True] * 9 + [False] * 8


def test_an_empty_cloud_stays_empty():
    assert inliers(np.zeros((0, 3)), 8, 0.06, repeat=True).shape == (0,)
