"""Boards before cameras, without pictures: corners projected and disturbed."""

import numpy as np

from stereotrack_core.calibrate.board import Board
from stereotrack_core.calibrate.lens import BROWN5, FISHEYE, RATIONAL, Lens
from stereotrack_core.calibrate.pictures import Sightings
from stereotrack_core.geometry.transform import RigidTransform
from tests.calibrate.board_pictures import board_in_view
from tests.tracking.views import looking

BOARD = Board(9, 6, 0.06)
SIZE = (640, 480)
HERE = RigidTransform.identity()

BENT = Lens(BROWN5, np.array([600.0, 603.0, 322.0, 236.0, -0.2, 0.06, 6e-4, -4e-4, 0.02, 0, 0, 0]))
WIDE = Lens(
    RATIONAL, np.array([330.0, 331.0, 318.0, 241.0, 0.9, 0.25, 4e-4, -3e-4, 0.02, 1.2, 0.45, 0.06])
)
ROUND = Lens(FISHEYE, np.array([250.0, 251.0, 322.0, 238.0, -0.02, 0.006, -0.003, 0.0006]))


def looking_at(place, target=(0.0, 0.0, 1.0)):
    """Pose camera_from_world of an upright camera."""
    return looking(np.asarray(place, float), np.asarray(target, float)).inverse()


def boards_before(camera, count, seed, board=BOARD, distances=(1.0, 2.5)):
    """Random places, world_from_board, at which the camera sees the whole board."""
    rng = np.random.default_rng(seed)
    return [board_in_view(camera, board, rng, distances) for _ in range(count)]


def sightings_of(camera, boards, seed, noise=0.1, board=BOARD):
    """What a camera sees of boards, whole ones only, frame k of board k."""
    rng = np.random.default_rng([seed, *camera.name.encode()])
    frames, pixels = [], []
    for k, world_from_board in enumerate(boards):
        seen = camera.project(world_from_board.apply(board.corners))
        inside = np.isfinite(seen).all() and (seen > 0).all() and (seen < SIZE).all()
        facing = (camera.camera_from_world @ world_from_board).rotation[2, 2] > 0.3
        if inside and facing:
            frames.append(k)
            pixels.append(seen + rng.normal(0, noise, seen.shape))
    names = tuple(f"{k:03d}.png" for k in frames)
    return Sightings(
        camera.name, SIZE, np.array(frames, dtype=np.int64),
        np.array(pixels).reshape(-1, len(board.corners), 2), names, (), len(boards),
    )  # fmt: skip
