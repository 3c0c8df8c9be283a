"""Corners in rendered pictures, and boards that are not what was named."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.calibrate.board import Board, charuco, chessboard
from stereotrack_core.calibrate.detection import find_board, recognised, tilts
from stereotrack_core.calibrate.lens import BROWN, Lens
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.simulation.rig import Sensor
from tests.calibrate.board_pictures import BoardRenderer
from tests.calibrate.scenes import HERE

_LENS = Lens(BROWN, np.array([300.0, 301, 160, 119, -0.15, 0.03, 5e-4, -4e-4, 0, 0, 0, 0]))
_CAMERA = _LENS.camera("a", (320, 240), HERE)
_SENSOR = Sensor(np.ones((1, 3)), 1.0, 0.6, 2.5, (0, 1))
CHESS = Board(7, 4, 0.06)
CHARUCO = Board(4, 3, 0.09, "4X4_50", 0.06)


def placed(board, turn=(0.3, -0.25, 0.1), away=0.9):
    rotation = rotation_from_vector(np.array(turn))
    return RigidTransform(rotation, np.array([0, 0, away]) - rotation @ board.corners.mean(axis=0))


def picture(board, frame=0, **place):
    pose = placed(board, **place)
    image = BoardRenderer(_CAMERA, board, _SENSOR).picture(pose, frame)
    return image, _CAMERA.project(pose.apply(board.corners))


def close_to(found, true):
    seen = np.isfinite(found[:, 0])
    assert seen.mean() > 0.7
    np.testing.assert_allclose(found[seen], true[seen], atol=0.5)


@pytest.mark.parametrize("board", [CHESS, CHARUCO], ids=["chessboard", "charuco"])
def test_corners_are_found_to_fractions_of_a_pixel(board):
    image, true = picture(board)
    found = find_board(image, board)
    seen = np.isfinite(found[:, 0])
    assert seen.mean() > 0.9
    assert np.sqrt(np.mean(np.square(found - true)[seen].sum(axis=1))) < 0.1


@pytest.mark.parametrize(
    ("shown", "named", "words"),
    [
        (CHESS, replace(CHESS, columns=8, rows=5), "are its squares"),
        (CHESS, replace(CHESS, columns=8), "were named"),
        (CHARUCO, replace(CHARUCO, columns=3, rows=4), "not the reverse"),
        (replace(CHARUCO, legacy=True), CHARUCO, "legacy"),
    ],
)
def test_a_board_that_was_named_wrongly_is_recognised(shown, named, words):
    image, true = picture(shown)
    found = recognised([image], named)
    assert found.board == shown
    assert not found.mirrored
    assert words in " ".join(found.differences)
    close_to(found.find(image), true)


def test_mirrored_pictures_are_recognised_by_their_markers():
    image, true = picture(CHARUCO)
    found = recognised([np.ascontiguousarray(image[:, ::-1])], CHARUCO)
    assert found.mirrored
    assert found.board == CHARUCO
    corners = found.find(np.ascontiguousarray(image[:, ::-1]))
    close_to(corners, np.column_stack([319 - true[:, 0], true[:, 1]]))


def test_the_board_that_was_named_is_taken_where_it_is_seen():
    image, _ = picture(CHESS)
    found = recognised([image, picture(CHESS, away=-5.0)[0]], CHESS)
    assert found.board == CHESS
    assert found.differences == ()


@pytest.mark.parametrize(
    ("size", "square", "remedy"),
    [("9", 0.025, "9x6"), ("9x6", 25.0, "0.025 for 25 mm"), ("9x6", -0.1, "metres")],
)
def test_what_is_no_chessboard_is_refused(size, square, remedy):
    with pytest.raises(InputError) as refusal:
        chessboard(size, square)
    assert remedy in refusal.value.remedy


@pytest.mark.parametrize(
    ("text", "remedy"),
    [("5x7", "5x7:4X4_50:0.018"), ("5x7:4X4_5:0.018", "4X4_50"), ("5x7:4X4_50:0.03", "Measure")],
)
def test_what_is_no_charuco_board_is_refused(text, remedy):
    with pytest.raises(InputError) as refusal:
        charuco(text, 0.025)
    assert remedy in refusal.value.remedy


def test_a_board_whose_corners_are_counted_the_other_way_is_tilted_as_much():
    turned = [rotation_from_vector(np.radians([angle, 0.0, 0.0])) for angle in (20.0, -20.0, 160.0)]
    found = tilts([RigidTransform(rotation, np.array([0.0, 0.0, 2.0])) for rotation in turned])
    assert np.degrees(found).max() < 35.0
