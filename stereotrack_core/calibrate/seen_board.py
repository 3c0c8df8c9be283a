"""A board at rest, placed by cameras that are calibrated already."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.calibrate.board import Board
from stereotrack_core.calibrate.board_pose import board_poses
from stereotrack_core.calibrate.bundle import BundleCamera, adjusted
from stereotrack_core.calibrate.connection import corner_errors
from stereotrack_core.calibrate.lens import lens_of
from stereotrack_core.calibrate.sightings import Sightings
from stereotrack_core.calibrate.world_checks import ScaleCheck, scale_check
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform

_MOST_PX = 5.0


@dataclass(frozen=True, eq=False)
class SeenBoard:
    """Place of a board, its error in pixels, and its squares measured by the cameras."""

    world_from_board: RigidTransform
    rms_px: float
    scale: ScaleCheck
    cameras: tuple[str, ...]


def seen_board(
    cameras: Mapping[str, Camera], sightings: Sequence[Sightings], board: Board
) -> SeenBoard:
    """The board of the last frame that most cameras see.

    Raises InputError where no camera sees it, or where they contradict each other.
    """
    seeing = _last_seen([one for one in sightings if one.camera in cameras and len(one)])
    seen_by = [_bundle_camera(cameras[one.camera], one) for one in seeing]
    candidates = [
        own.camera_from_world.inverse() @ pose
        for own in seen_by
        for pose in board_poses(own.lens, board.corners, own.pixels[0])
    ]
    if not candidates:
        raise InputError(
            "the board cannot be placed", where="--board-on-floor", remedy="Use another picture."
        )
    best = min(candidates, key=lambda one: _cost(one, seen_by, board))
    found = adjusted(seen_by, [best], board.corners)
    if found.rms > _MOST_PX:
        raise InputError(
            f"{counted(len(seeing), 'camera')} that see the board contradict each other by "
            f"{found.rms:.0f} px",
            where="--board-on-floor",
            remedy="Check that the pictures were taken after the calibration, with no camera "
            "moved, and that picture k of all cameras is the same instant.",
        )
    names = tuple(one.camera for one in seeing)
    scale = scale_check([cameras[name] for name in names], seeing, board)
    return SeenBoard(found.boards[0], found.rms, scale, names)


def _last_seen(sightings: Sequence[Sightings]) -> list[Sightings]:
    """Those of the frame in which most cameras see the board, the last of several."""
    counts = Counter(int(frame) for one in sightings for frame in one.frames)
    if not counts:
        raise InputError(
            "no camera of the calibration sees the board",
            where="--board-on-floor",
            remedy="Name the videos or folders as the cameras, and check the size of the board.",
        )
    frame = max(counts, key=lambda one: (counts[one], one))
    seeing = [one.only(np.flatnonzero(one.frames == frame)) for one in sightings]
    return [one for one in seeing if len(one)]


def _bundle_camera(camera: Camera, sightings: Sightings) -> BundleCamera:
    lens = lens_of(camera)
    if lens is None:
        raise InputError(
            f"its lens has {camera.distortions.size} distortion coefficients",
            where=f"camera {camera.name}",
            remedy="Leave its pictures out of the folder.",
        )
    nothing = np.zeros(lens.values.size, dtype=bool)
    first = np.zeros(1, dtype=np.int64)
    return BundleCamera(
        lens, camera.camera_from_world, first, sightings.pixels, nothing, pose_free=False
    )


def _cost(world_from_board: RigidTransform, cameras: Sequence[BundleCamera], board: Board) -> float:
    """Sum over the cameras of the median error in pixels."""
    errors = (
        corner_errors(own.lens, own.camera_from_world @ world_from_board, own.pixels[0], board)
        for own in cameras
    )
    return sum(float(np.nanmedian(one)) for one in errors)
