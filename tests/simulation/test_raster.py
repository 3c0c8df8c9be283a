import numpy as np
import pytest

from stereotrack_core.simulation.raster import SAMPLES, Raster, in_samples


def drawn(pixels, depth_of_vertices, triangles, size=(20, 30)):
    raster = Raster.over(np.zeros((SAMPLES * size[0], SAMPLES * size[1]), np.float32))
    nearness = 1.0 / np.asarray(depth_of_vertices, float)
    raster.draw(in_samples(np.asarray(pixels, float)), nearness, np.asarray(triangles))
    return raster.depth, raster.triangle, raster.weights


def test_neighbours_leave_no_gap():
    corners = [[0.3, 0.4], [25.1, 1.2], [24.7, 17.9], [1.1, 16.6]]
    _, ids, _ = drawn(corners, [2, 2, 2, 2], [[0, 1, 2], [0, 2, 3]])
    inside = ids[3 * SAMPLES : 15 * SAMPLES, 3 * SAMPLES : 23 * SAMPLES]
    assert (inside >= 0).all()


def test_the_nearer_triangle_is_seen():
    pixels = [[0, 0], [29, 0], [0, 19], [29, 19]]
    _, ids, _ = drawn(pixels * 2, [3] * 4 + [2] * 4, [[4, 5, 6], [0, 1, 2], [1, 3, 2]])
    assert ids[5, 5] == 0
    assert ids[-5, -5] == 2


def test_coordinates_are_corrected_for_perspective():
    """Along a receding edge the middle of the picture is not the middle of the edge."""
    pixels = [[0, 10], [28, 10], [0, 19], [28, 19]]
    near, far = 1.0, 4.0
    depth, _, weights = drawn(pixels, [near, far, near, far], [[0, 1, 2], [1, 3, 2]])
    row, column = SAMPLES * 11, SAMPLES * 14
    middle = (column + 0.5) / SAMPLES - 0.5
    share = middle / 28
    expected_nearness = (1 - share) / near + share / far
    assert depth[row, column] == pytest.approx(expected_nearness, rel=1e-5)
    assert weights[row, column, 0] == pytest.approx(share / far / expected_nearness, rel=1e-4)


def test_what_is_not_a_number_is_dropped():
    _, ids, _ = drawn([[np.nan, 2], [22, 2], [2, 12]], [1, 1, 1], [[0, 1, 2]])
    assert (ids == -1).all()
