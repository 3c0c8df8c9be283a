"""How the rows of a pair's details change if its calibration is changed a little."""

from __future__ import annotations

import numpy as np
import scipy

from stereotrack_core.arrays import FloatArray
from stereotrack_core.depth.rectify import common_rotation
from stereotrack_core.doctor.details import Details, Pair

NUMBERS = 7
TURN, LEFT_FOCAL, RIGHT_FOCAL, LENSES = (0, 1, 2), (3,), (4,), (5, 6)
"""Which of the numbers that change a calibration turn the right camera (radians), make the focal
length of the left or the right one smaller (as a share), and straighten both images."""

_NOISE_PX = 0.3
"""Row offset from which details count less while numbers are fitted."""


class RowChanges:
    """Row offsets of details with a pair's calibration changed by :data:`NUMBERS` numbers."""

    def __init__(self, cameras: Pair, details: Details) -> None:
        common = common_rotation(*cameras)
        self._focal = cameras[0].focal
        self._plane: list[FloatArray] = []
        self._turns: list[FloatArray] = []
        for camera, pixels in zip(cameras, (details.left, details.image), strict=True):
            rotation = camera.camera_from_world.rotation
            rays = camera.rays_world(pixels) @ rotation.T
            with np.errstate(divide="ignore", invalid="ignore"):
                self._plane.append(rays[:, :2] / rays[:, 2:])
            self._turns.append(common @ rotation.T)

    def rows(self, change: FloatArray) -> FloatArray:
        """Row offsets (N,), pixels."""
        turn = scipy.spatial.transform.Rotation.from_rotvec(change[:3]).as_matrix()
        ways = (
            (self._turns[0], 1.0 + change[3], change[5]),
            (self._turns[1] @ turn, 1.0 + change[4], change[6]),
        )
        heights = []
        for plane, (way, larger, bent) in zip(self._plane, ways, strict=True):
            straight = plane * larger * (1.0 + bent * np.sum(plane**2, axis=1, keepdims=True))
            rays = np.column_stack([straight, np.ones(len(straight))]) @ way.T
            with np.errstate(divide="ignore", invalid="ignore"):
                heights.append(np.where(rays[:, 2] > 0.1, rays[:, 1] / rays[:, 2], np.nan))
        return np.asarray(self._focal * (heights[0] - heights[1]))

    def fitted(self, free: tuple[int, ...]) -> FloatArray:
        """The numbers of which some are free, for the least row offsets."""

        def change(values: FloatArray) -> FloatArray:
            changed = np.zeros(NUMBERS)
            changed[list(free)] = values
            return changed

        solved = scipy.optimize.least_squares(
            lambda values: np.nan_to_num(self.rows(change(values)), nan=0.0),
            np.zeros(len(free)), loss="soft_l1", f_scale=_NOISE_PX, x_scale=0.01, max_nfev=30,
        )  # fmt: skip
        return change(solved.x)
