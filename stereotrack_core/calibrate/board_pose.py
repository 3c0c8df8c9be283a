"""Where a board is, seen by one camera; both answers where the picture allows two."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.calibrate.lens import Lens
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.transform import RigidTransform

_LEAST_CORNERS = 4


def board_poses(lens: Lens, corners: FloatArray, pixels: FloatArray) -> list[RigidTransform]:
    """Poses camera_from_board of one picture, the likelier one first; empty where there is none.

    A flat board far away looks nearly the same tilted either way, so that there are two (Collins
    and Bartoli, Infinitesimal plane-based pose estimation, 2014).

    Parameters
    ----------
    corners : (n, 3); metres, board frame
    pixels : (n, 2); raw pixels, NaN where unseen
    """
    seen = np.isfinite(pixels[:, 0])
    if seen.sum() < _LEAST_CORNERS:
        return []
    camera = lens.camera("", (1, 1), RigidTransform.identity())
    flat = camera.normalised(pixels[seen])
    known = np.isfinite(flat).all(axis=1) & (np.abs(flat) < 50).all(axis=1)
    if known.sum() < _LEAST_CORNERS:
        return []
    board = corners[seen][known]
    middle = board.mean(axis=0)
    try:
        _, vectors, places, _ = cv2.solvePnPGeneric(
            board - middle, flat[known], np.eye(3), np.zeros(4), flags=cv2.SOLVEPNP_IPPE
        )
    except cv2.error:
        return []
    found = []
    for vector, place in zip(vectors, places, strict=True):
        rotation = rotation_from_vector(np.asarray(vector, dtype=np.float64).ravel())
        translation = np.asarray(place, dtype=np.float64).ravel() - rotation @ middle
        if np.isfinite(translation).all() and (board @ rotation[2] + translation[2] > 0).all():
            found.append(RigidTransform(rotation, translation))
    return found


def likeliest_poses(
    lens: Lens, corners: FloatArray, pictures: FloatArray
) -> list[RigidTransform | None]:
    """The likelier camera_from_board of pictures (F, n, 2); None where there is none."""
    poses = [board_poses(lens, corners, pixels) for pixels in pictures]
    return [found[0] if found else None for found in poses]


def tilts(poses: Sequence[RigidTransform]) -> FloatArray:
    """Angles (F,) in radians between the boards' normals and their mean direction."""
    normals = np.array([pose.rotation[:, 2] for pose in poses]).reshape(-1, 3)
    mean = normals.mean(axis=0)
    length = np.linalg.norm(mean)
    angles: FloatArray = np.arccos(np.clip(normals @ mean / max(length, 1e-12), -1.0, 1.0))
    return angles
