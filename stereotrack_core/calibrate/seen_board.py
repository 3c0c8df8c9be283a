"""A board at rest, placed by cameras that are calibrated already."""

from __future__ import annotations

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
    known = [one for one in sightings if one.camera in cameras and len(one)]
    counts: dict[int, int] = {}
    for one in known:
        for frame in one.frames.tolist():
            counts[frame] = counts.get(frame, 0) + 1
    if not counts:
        raise InputError(
            "no camera of the calibration sees the board",
            where="--board-on-floor",
            remedy="Name the videos or folders as the cameras, and check the size of the board.",
        )
    frame = max(counts, key=lambda one: (counts[one], one))
    seeing = [one.only(np.flatnonzero(one.frames == frame)) for one in known]
    seeing = [one for one in seeing if len(one)]
    bundle_cameras, candidates = [], []
    for one in seeing:
        camera = cameras[one.camera]
        lens = lens_of(camera)
        if lens is None:
            raise InputError(
                f"its lens has {camera.distortions.size} distortion coefficients",
                where=f"camera {one.camera}",
                remedy="Leave its pictures out of the folder.",
            )
        nothing = np.zeros(lens.values.size, dtype=bool)
        bundle_cameras.append(
            BundleCamera(
                lens,
                camera.camera_from_world,
                np.zeros(1, np.int64),
                one.pixels,
                nothing,
                pose_free=False,
            )
        )
        poses = board_poses(lens, board.corners, one.pixels[0])
        candidates += [camera.world_from_camera @ pose for pose in poses]

    def cost(world_from_board: RigidTransform) -> float:
        return sum(
            float(np.nanmedian(corner_errors(own.lens, own.camera_from_world @ world_from_board,
                                             own.pixels[0], board)))
            for own in bundle_cameras
        )  # fmt: skip

    if not candidates:
        raise InputError(
            "the board cannot be placed", where="--board-on-floor", remedy="Use another picture."
        )
    found = adjusted(bundle_cameras, [min(candidates, key=cost)], board.corners)
    if found.rms > _MOST_PX:
        raise InputError(
            f"{counted(len(seeing), 'camera')} that see the board contradict each other by "
            f"{found.rms:.0f} px",
            where="--board-on-floor",
            remedy="Check that the pictures were taken after the calibration, with no camera "
            "moved, and that picture k of all cameras is the same instant.",
        )
    names = tuple(one.camera for one in seeing)
    return SeenBoard(
        found.boards[0],
        found.rms,
        scale_check([cameras[name] for name in names], seeing, board),
        names,
    )
