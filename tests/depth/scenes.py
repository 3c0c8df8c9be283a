"""Synthetic stereo images whose disparity is known exactly, and rigs to take them with."""

import cv2
import numpy as np

from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.transform import RigidTransform


def texture(height: int, width: int, *, seed: int = 0, blur: float = 1.2) -> np.ndarray:
    """Random grey image, smooth enough to be sampled between its pixels."""
    noise = np.random.default_rng(seed).normal(size=(height, width))
    smooth = cv2.GaussianBlur(noise, (0, 0), blur)
    scaled = 127 + 45 * smooth / smooth.std()
    return scaled.clip(0, 255).astype(np.float32)


def pair_with_disparity(disparity: np.ndarray, *, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Left and right image (H, W) uint8 where left shows at u + d(u, v) what right shows at u.

    `disparity` belongs to the right image's pixels and must be such that u + d grows with u.
    The left image is the texture; the right one samples it.
    """
    height, width = disparity.shape
    left = texture(height, width, seed=seed)
    rows, columns = np.mgrid[:height, :width].astype(np.float32)
    right = cv2.remap(left, columns + disparity.astype(np.float32), rows, cv2.INTER_CUBIC)
    return np.rint(left).astype(np.uint8), np.rint(right.clip(0, 255)).astype(np.uint8)


def camera(
    name: str,
    position: tuple[float, float, float],
    turn: tuple[float, float, float] = (0.0, 0.0, 0.0),
    *,
    focal: tuple[float, float] = (400.0, 400.0),
    principal: tuple[float, float] = (159.5, 119.5),
    distortions: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0),
    fisheye: bool = False,
    size: tuple[int, int] = (320, 240),
) -> Camera:
    """Camera at `position` that looks along world y (world z is up), then turned in its frame."""
    camera_from_axes = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    rotation = rotation_from_vector(np.array(turn)) @ camera_from_axes
    matrix = np.array(
        [[focal[0], 0.0, principal[0]], [0.0, focal[1], principal[1]], [0.0, 0.0, 1.0]]
    )
    return Camera(
        name=name,
        width=size[0],
        height=size[1],
        matrix=matrix,
        distortions=np.array(distortions),
        fisheye=fisheye,
        camera_from_world=RigidTransform(rotation, -rotation @ np.array(position)),
    )
