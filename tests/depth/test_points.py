import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial import KDTree

from stereotrack_core.depth.points import inliers, thinned_pixels


def test_a_region_keeps_the_rows_and_columns_of_the_whole_image():
    whole, part = np.ones((20, 30), bool), np.zeros((20, 30), bool)
    part[4:, 7:] = True
    expected = thinned_pixels(part, 3, (0, 0))
    assert np.array_equal(thinned_pixels(whole[4:, 7:], 3, (7, 4)), expected)


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


@pytest.mark.parametrize("distance", [0.001, 0.02, 0.06, 0.4])
def test_outliers_agree_with_a_tree_on_a_cloud_with_far_points(distance):
    rng = np.random.default_rng(5)
    points = np.concatenate([rng.normal(0, 0.2, (3000, 3)), rng.uniform(-4, 4, (300, 3))])
    farthest, _ = KDTree(points).query(points, k=[9])
    expected = farthest[:, 0] <= distance
    assert np.array_equal(inliers(points, 8, distance, repeat=False), expected)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_points_on_a_line_count_each_of_their_neighbours_once(axis):
    points = np.zeros((4, 3))
    points[:, axis] = [0.0, 0.6, 1.5, 2.4]  # metres
    assert inliers(points, 2, 1.0, repeat=False).tolist() == [False, True, True, False]
