"""Decoding of the person finder's numbers, and suppression of what is found twice."""

import numpy as np

from stereotrack_core.pose_model.blazepose import (
    Candidates,
    anchors,
    decode,
    refined,
    sigmoid,
    suppress,
)


def test_anchors_are_the_middles_of_the_cells():
    places = anchors()
    assert places.shape == (2254, 2)
    assert places[:2].tolist() == [[4, 4], [4, 4]]  # two in each cell of 8 pixels, row by row
    assert places[2].tolist() == [12, 4]
    assert places[1568].tolist() == [8, 8]
    assert places[-1].tolist() == [208, 208]


def test_a_detection_is_relative_to_its_anchor():
    raw, logits = np.zeros((2254, 12), np.float32), np.full(2254, -9.0, np.float32)
    raw[2] = (1, 2, 10, 20, 3, 4, 3, -30, 0, 0, 0, 0)
    raw[700, 2:4] = 8
    logits[[2, 700]] = 1.0, 3.0
    found = decode(raw, logits)
    np.testing.assert_allclose(found.scores, sigmoid([3.0, 1.0]))  # the surest first
    np.testing.assert_allclose(found.boxes[1], [8, -4, 18, 16])
    np.testing.assert_allclose(found.points[1, :2], [[15, 8], [15, -26]])


def test_nobody_is_found_where_nothing_is_sure():
    found = suppress(decode(np.zeros((2254, 12), np.float32), np.full(2254, -1e9, np.float32)))
    assert len(found) == 0
    assert found.boxes.shape == (0, 4)


def test_detections_of_one_person_become_their_weighted_mean():
    boxes = np.array([[0, 0, 10, 10], [2, 0, 12, 10], [50, 50, 60, 60]], float)
    points = np.repeat(boxes[:, None, :2], 4, axis=1)
    found = suppress(Candidates(boxes, points, np.array([0.9, 0.6, 0.7])))
    np.testing.assert_allclose(found.scores, [0.9, 0.7])
    np.testing.assert_allclose(found.boxes, [[0.8, 0, 10.8, 10], [50, 50, 60, 60]])
    np.testing.assert_allclose(found.points[:, 0], [[0.8, 0], [50, 50]])


def test_sigmoid_takes_any_number():
    np.testing.assert_allclose(sigmoid([-1e30, 0.0, 1e30]), [0.0, 0.5, 1.0], atol=1e-12)


def test_landmarks_move_to_the_peak_of_their_heat_map():
    heat = np.full((64, 64, 3), -20.0, np.float32)
    heat[30, 21:24, 0] = 4.0  # around column 22, row 30 of cells of four pixels
    heat[5, 60, 2] = -1.0  # too little to be believed
    places = np.array([[81.0, 119.0], [300.0, 10.0], [240.0, 20.0]])
    found = refined(places, heat)
    np.testing.assert_allclose(found[0], [88, 120], atol=1e-3)
    np.testing.assert_array_equal(found[1:], places[1:])  # beside the crop; unsure
