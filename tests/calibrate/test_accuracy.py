"""Accuracy on rendered boards with blur and noise, and on real pictures; speed is not judged."""

import cv2
import numpy as np
import pytest

from stereotrack_core.calibrate.board import Board
from stereotrack_core.calibrate.detection import find_board
from stereotrack_core.calibrate.pictures import Sightings, pictures_of_glob
from stereotrack_core.calibrate.work import search
from stereotrack_core.calibrate.world import calibrate_world, pair_of
from stereotrack_core.simulation.rig import Sensor
from tests.calibrate.board_pictures import BoardRenderer, board_in_view
from tests.calibrate.scenes import BENT, BOARD, SIZE, looking_at
from tests.calibrate.test_world import off
from tests.conftest import SHARED_RECORDINGS

PAIRS = SHARED_RECORDINGS.parent / "stereo" / "opencv-chessboards"


@pytest.fixture(scope="module")
def real():
    """The board in thirteen real pairs of pictures."""
    if not PAIRS.is_dir():
        pytest.skip("the pictures are not beside this checkout")
    sides = ("left", "right")
    sources = [pictures_of_glob(str(PAIRS / side), side, "") for side in sides]
    return search(sources, Board(9, 6, 0.025), range(13))


@pytest.mark.slow
def test_real_pairs_are_fitted_as_well_as_by_opencv(real):
    world = calibrate_world(real.sightings, real.board, model="brown5")
    assert world.rms_px < 0.25
    assert [len(one) for one in world.sightings] == [13, 13]
    corners = [real.board.corners.astype(np.float32)] * 13
    pixels = [list(one.pixels.astype(np.float32)[:, None]) for one in real.sightings]
    lenses = []
    for i, own in enumerate(pixels):
        rms, matrix, distortions, *_ = cv2.calibrateCamera(corners, own, (640, 480), None, None)
        assert world.lenses[i].rms_px < rms + 1e-3
        lenses += [matrix, distortions]
    opencv, *_ = cv2.stereoCalibrate(
        corners, *pixels, *lenses, (640, 480), flags=cv2.CALIB_USE_INTRINSIC_GUESS
    )
    assert world.rms_px < opencv + 1e-3
    pair = pair_of(*world.cameras, *world.sightings)
    assert pair.baseline_m == pytest.approx(0.0832, abs=0.0003)
    assert pair.row_error_px < 0.2


def rendered(cameras, boards, blur_and_noise):
    """What rendered pictures of all cameras show."""
    seen = []
    for number, camera in enumerate(cameras):
        renderer = BoardRenderer(
            camera, BOARD, Sensor(np.ones((1, 3)), 1.0, *blur_and_noise, (7, number))
        )
        found = {}
        for k, board in enumerate(boards):
            corners = find_board(renderer.picture(board, k), BOARD)
            if corners is not None:
                found[k] = corners
        names = tuple(f"{k}" for k in found)
        frames = np.array(list(found), dtype=np.int64)
        pixels = np.array(list(found.values()))
        seen.append(Sightings(camera.name, SIZE, frames, pixels, names, (), len(boards)))
    return seen


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1])
def test_rendered_boards_give_lenses_and_places(seed):
    places = [(-0.9, -2.2, 1.4), (-0.78, -2.2, 1.4), (0.8, -2.3, 1.3), (0.92, -2.3, 1.3)]
    cameras = [BENT.camera(f"c{i}", SIZE, looking_at(place)) for i, place in enumerate(places)]
    rng = np.random.default_rng(seed)
    boards = []
    while len(boards) < 32:  # of which every camera sees about 25
        board = board_in_view(cameras[len(boards) % 4], BOARD, rng, (1.5, 3.0))
        boards.append(board)
    world = calibrate_world(rendered(cameras, boards, (0.7, 3.0)), BOARD)
    positions, turns = off(world, cameras)
    focal = [abs(a.focal / b.focal - 1) for a, b in zip(world.cameras, cameras, strict=True)]
    assert max(focal) < 0.002
    assert positions.max() < 0.005
    assert np.degrees(turns.max()) < 0.1
    assert world.held_out_px < 0.15
