"""Calibrations of upright images, for videos that are stored lying as those of telephones.

A video player, and OpenCV as well, turns such a video before anybody sees it, so that most tools
calibrate the turned images. The lens is the same: pixels and axes are turned back.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform

_MOST_COEFFICIENTS = 8  # with thin prisms and a tilted sensor, the model has axes of its own

STORED_FROM_UPRIGHT = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
"""Axes of images that are shown turned by 90 degrees clockwise: x is upright y, y is -x."""


def as_stored(camera: Camera, turned: int) -> Camera:
    """The camera of images as stored, from that of the images turned by degrees clockwise.

    Raises InputError where its distortion model or a skew cannot be turned.
    """
    if camera.distortions.size > _MOST_COEFFICIENTS or camera.matrix[0, 1]:
        raise InputError(
            f"the calibration of {camera.name} is of turned images, and its distortion model "
            "cannot be turned back",
            remedy="Calibrate with the images as stored, or with at most 8 coefficients.",
        )
    for _ in range(turned // 90):
        camera = _quarter_back(camera)
    return camera


def _quarter_back(camera: Camera) -> Camera:
    """Undo a quarter turn clockwise: pixel (u, v) is shown at (height - 1 - v, u)."""
    height = camera.width  # of the image before the turn
    (fx, _, cx), (_, fy, cy), _ = camera.matrix
    distortions = camera.distortions.copy()
    if not camera.fisheye and distortions.size >= 4:
        p1, p2 = distortions[2:4]
        distortions[2:4] = -p2, p1
    return replace(
        camera, width=camera.height, height=height,
        matrix=np.array([[fy, 0.0, cy], [0.0, fx, height - 1 - cx], [0.0, 0.0, 1.0]]),
        distortions=distortions,
        camera_from_world=RigidTransform(STORED_FROM_UPRIGHT, np.zeros(3))
        @ camera.camera_from_world,
    )  # fmt: skip
