"""Boards: what names them, and what cannot be meant."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stereotrack_core.calibrate.board import charuco, chessboard
from stereotrack_core.errors import InputError


@given(columns=st.integers(3, 20), rows=st.integers(3, 20))
def test_neighbours_are_one_square_apart(columns, rows):
    board = chessboard(f"{columns}x{rows}", 0.03)
    assert board.corners.shape == (columns * rows, 3)
    ends = board.corners[board.neighbours]
    np.testing.assert_allclose(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1), 0.03)
    assert len(board.neighbours) == (columns - 1) * rows + columns * (rows - 1)
    assert board.ambiguous == ((columns + rows) % 2 == 0)


def test_a_charuco_board_counts_squares():
    board = charuco("5x7:dict_4x4_50:0.018", 0.025)
    assert (board.columns, board.rows, board.dictionary) == (4, 6, "4X4_50")
    assert not board.ambiguous
    assert board.words == "ChArUco board with 5x7 squares, 4X4_50"


@pytest.mark.parametrize(
    ("size", "square", "remedy"),
    [
        ("9", 0.025, "9x6"),
        ("9x2", 0.025, "3 to 100"),
        ("9x6", 25.0, "0.025 for 25 mm"),
        ("9x6", float("nan"), "metres"),
        ("9x6", -0.1, "metres"),
    ],
)
def test_what_is_no_chessboard_is_refused(size, square, remedy):
    with pytest.raises(InputError) as refusal:
        chessboard(size, square)
    assert remedy in refusal.value.remedy


@pytest.mark.parametrize(
    ("text", "remedy"),
    [
        ("5x7", "5x7:4X4_50:0.018"),
        ("5x7:4X4_5:0.018", "4X4_50"),
        ("5x7:4X4_50:0.03", "Measure"),
        ("5x7:4X4_50:wide", "Measure"),
    ],
)
def test_what_is_no_charuco_board_is_refused(text, remedy):
    with pytest.raises(InputError) as refusal:
        charuco(text, 0.025)
    assert remedy in refusal.value.remedy
