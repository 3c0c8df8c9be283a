"""Points of the body in the pictures of cameras: what every reprojection has in common.

Pictures are those of ideal cameras without distortion: pixels of the raw picture are undistorted
once, and the prediction is a pinhole's. Pixels count from the principal point.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.manifold import PIXEL, Rows, rows_of
from stereotrack_core.body.pose import PartFrames
from stereotrack_core.geometry.camera import Camera

_NEAREST = 0.05
"""Metres in front of a camera within which nothing is projected."""


def undistorted(camera: Camera, pixels: FloatArray) -> FloatArray:
    """Pixels (..., 2) of the ideal camera, from the principal point, of raw pixels (..., 2)."""
    result: FloatArray = float(camera.matrix[0, 0]) * camera.normalised(pixels)
    return result


def pinhole(in_camera: FloatArray, focal: FloatArray | float) -> FloatArray:
    """Pixels (..., 2) of points (..., 3) in the camera's frame; NaN behind the camera.

    `focal` (...) is in pixels.
    """
    depth = np.where(in_camera[..., 2:] > _NEAREST, in_camera[..., 2:], np.nan)
    result: FloatArray = np.asarray(focal)[..., None] * in_camera[..., :2] / depth
    return result


def pixel_gradients(
    rotation: FloatArray, in_camera: FloatArray, focal: FloatArray | float
) -> FloatArray:
    """Derivatives (..., 2, 3) of pixels by world points.

    Parameters
    ----------
    rotation : (..., 3, 3) float64
        camera_from_world.
    in_camera : (..., 3) float64
        The points in the camera's frame.
    focal : (...) float64
        Pixels.
    """
    z = in_camera[..., 2:]
    slope = in_camera[..., :2] / z
    rows = rotation[..., :2, :] - slope[..., None] * rotation[..., 2:, :]
    result: FloatArray = (np.asarray(focal)[..., None] / z)[..., None] * rows
    return result


@dataclass(frozen=True, eq=False)
class PinholePoints:
    """m points of the body, each in the picture of a camera."""

    part: IntArray
    """(m,)."""
    point: FloatArray
    """(m, 3). In the frames of the parts."""
    rotation: FloatArray
    """(m, 3, 3). camera_from_world."""
    translation: FloatArray
    """(m, 3), metres. camera_from_world."""
    focal: FloatArray
    """(m,), pixels."""

    def in_camera(self, frames: PartFrames) -> FloatArray:
        """The points (..., m, 3) in the frames of their cameras, for one pose or stacked ones."""
        world = frames.apply(self.part, self.point)
        result: FloatArray = np.einsum("mij,...mj->...mi", self.rotation, world) + self.translation
        return result

    def pixels(self, frames: PartFrames) -> FloatArray:
        """Their pixels (..., m, 2); NaN behind the camera."""
        return pinhole(self.in_camera(frames), self.focal)


@dataclass(frozen=True, eq=False)
class ReprojectionResidual:
    """Measured pixels of points of the body."""

    points: PinholePoints
    measured: FloatArray
    """(2 m,), pixels, column and row of one point after the other."""
    variance: FloatArray
    """(2 m,), square pixels."""

    def predicted(self, frames: PartFrames) -> FloatArray:
        """The points' pixels (S, 2 m) for stacked poses."""
        pixels = self.points.pixels(frames)
        return pixels.reshape(len(pixels), -1)

    def rows(self, frames: PartFrames) -> Rows:
        """Columns and rows of the pixels in turn, linearised at one pose."""
        points, at = self.points, self.points.in_camera(frames)
        off = self.measured - pinhole(at, points.focal).reshape(-1), self.variance
        along = pixel_gradients(points.rotation, at, points.focal).reshape(-1, 3)
        world = np.repeat(frames.apply(points.part, points.point), 2, axis=0)
        return rows_of(PIXEL, np.repeat(points.part, 2), world, along, off)
