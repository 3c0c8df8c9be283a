"""Rectification: a raw stereo pair becomes one with parallel axes and common rows (2.1.3)."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from stereotrack_core.arrays import BoolArray, Float32Array, FloatArray, ImageArray
from stereotrack_core.depth.cloud import DepthGeometry
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform

_IDENTITY_TOLERANCE = 0.02  # px; a block matcher's own noise is about three times this
_SMALLEST_BASELINE = 1e-3  # metres
_LARGEST_CONVERGENCE = np.deg2rad(60.0)
_SMALLEST_SCALE, _LARGEST_SCALE = 1.25, 2.0  # less only blurs, more shows nothing new


@dataclass(frozen=True, eq=False)
class PixelMap:
    """From where in the raw image each pixel of the rectified one is taken.

    `positions` (H, W, 2) and `fractions` (H, W) are the fixed-point form of ``cv2.convertMaps``, to
    1/32 px; `nearest` (H, W, 2) is the nearest raw pixel, `outside` (H, W) where there is none.
    """

    positions: NDArray[np.int16]
    fractions: NDArray[np.uint16]
    nearest: NDArray[np.int16]
    outside: BoolArray

    def apply(self, image: ImageArray) -> ImageArray:
        """Resample, bicubically if it is enlarged, as blur harms matching; black beyond."""
        enlarged = self.outside.size > image.shape[0] * image.shape[1]
        method = cv2.INTER_CUBIC if enlarged else cv2.INTER_LINEAR
        resampled = cv2.remap(image, self.positions, self.fractions, method)
        return resampled.astype(np.uint8, copy=False)

    def apply_nearest(self, values: Float32Array) -> Float32Array:
        """Resample values that must not be mixed; NaN where the raw image ends."""
        empty = np.zeros(0, dtype=np.uint16)
        resampled = cv2.remap(
            values, self.nearest, empty, cv2.INTER_NEAREST, borderValue=float("nan")
        )
        return resampled.astype(np.float32, copy=False)


@dataclass(frozen=True, eq=False)
class Rectification:
    """How a view's images become rectified ones; a map is None where nothing changes."""

    geometry: DepthGeometry
    left_map: PixelMap | None
    image_map: PixelMap | None

    def rectified(self, image: ImageArray) -> ImageArray:
        """The reference picture where the disparities or depths are, in its colours."""
        return image if self.image_map is None else self.image_map.apply(image)


def stereo_rectification(
    left: Camera, right: Camera, *, least_focal: float = 0.0, where: str = ""
) -> Rectification:
    """Rectify a stereo camera from its calibration, with the right image as reference.

    The rectified x axis is the base line, the z axis lies as near as it can to both optical axes.
    Each image keeps its own principal point, so that its centre stays; the difference of the two is
    ``disparity_offset``. Pictures of clearly wider lenses are enlarged to `least_focal` pixels, at
    most to twice their size.

    Raises InputError, which names the view `where`, for cameras that are no stereo pair.
    """
    _check_pair(left, right, where)
    rectified_from_world = common_rotation(left, right)
    baseline = float(np.linalg.norm(left.position_world - right.position_world))
    for matrices in (
        _matrices_as_they_are(left, right),
        _matrices(left, right, rectified_from_world),
    ):
        maps = [
            _raw_pixels(camera, matrix, rectified_from_world, _grid(camera, 17))
            for camera, matrix in zip((left, right), matrices, strict=True)
        ]
        unchanged = all(np.abs(raw - _grid(right, 17)).max() < _IDENTITY_TOLERANCE for raw in maps)
        if unchanged:
            break
    scale = min(least_focal / matrices[1][0, 0], _LARGEST_SCALE)
    if scale < _SMALLEST_SCALE:
        scale = 1.0
    size = round(scale * right.width), round(scale * right.height)
    if scale > 1.0:
        matrices = _enlarged(matrices[0], scale), _enlarged(matrices[1], scale)
    geometry = _geometry(matrices, baseline, rectified_from_world, right.position_world, size)
    if unchanged and scale == 1.0:
        return Rectification(geometry, None, None)
    left_map, image_map = (
        _pixel_map(camera, matrix, rectified_from_world, size)
        for camera, matrix in zip((left, right), matrices, strict=True)
    )
    return Rectification(geometry, left_map, image_map)


def depth_rectification(camera: Camera) -> Rectification:
    """Geometry of a depth image: undistorted and with square pixels, else as it is."""
    rotation, size = camera.camera_from_world.rotation, (camera.width, camera.height)
    plain, square = _matrices_as_they_are(camera, camera)[1], _matrices(camera, camera, rotation)[1]
    raw = _raw_pixels(camera, plain, rotation, _grid(camera, 17))
    if np.abs(raw - _grid(camera, 17)).max() < _IDENTITY_TOLERANCE:
        matrix, image_map = plain, None
    else:
        matrix, image_map = square, _pixel_map(camera, square, rotation, size)
    geometry = _geometry((matrix, matrix), 0.0, rotation, camera.position_world, size)
    return Rectification(geometry, None, image_map)


def _check_pair(left: Camera, right: Camera, where: str) -> None:
    def refused(what: str, remedy: str) -> InputError:
        return InputError(what, where=where, remedy=remedy)

    names = f"{left.name} and {right.name}"
    if (left.width, left.height) != (right.width, right.height):
        raise refused(
            f"left and right image differ in size ({left.width} x {left.height} and"
            f" {right.width} x {right.height})",
            "A stereo view needs two images of the same size.",
        )
    to_left = right.camera_from_world.apply(left.position_world)
    length = float(np.linalg.norm(to_left))
    if not length > _SMALLEST_BASELINE:
        remedy = "Give each camera of the stereo view its own translation."
        raise refused(f"{names} have the same position", remedy)
    across, along_y, along_z = np.abs(to_left) / length
    if along_y > across:
        remedy = "Stereo cameras must be mounted side by side, along the rows of their images."
        raise refused(f"{names} are mounted one above the other", remedy)
    if along_z > across:
        remedy = "Check rotation and translation of both cameras."
        raise refused(f"{names} are mounted one behind the other", remedy)
    if to_left[0] > 0:
        what = f"{left.name} is to the right of {right.name}"
        raise refused(what, "Swap left and right in this view.")
    axes = [camera.camera_from_world.rotation[2] for camera in (left, right)]
    if np.arccos(np.clip(axes[0] @ axes[1], -1.0, 1.0)) > _LARGEST_CONVERGENCE:
        remedy = "Check the rotation of both cameras."
        raise refused(f"{names} look in different directions", remedy)


def common_rotation(left: Camera, right: Camera) -> FloatArray:
    """Rotation (3, 3) of the rectified cameras from the world; rows are their axes."""
    x = right.position_world - left.position_world
    x = x / np.linalg.norm(x)
    z = left.camera_from_world.rotation[2] + right.camera_from_world.rotation[2]
    y = np.cross(z, x)
    y /= np.linalg.norm(y)
    return np.stack([x, y, np.cross(x, y)])


def _matrices_as_they_are(left: Camera, right: Camera) -> tuple[FloatArray, FloatArray]:
    """Rectified intrinsics under the assumption that nothing needs to change."""
    focal, c_y = right.matrix[0, 0], right.matrix[1, 2]
    return _matrix(focal, left.matrix[0, 2], c_y), _matrix(focal, right.matrix[0, 2], c_y)


def _matrices(
    left: Camera, right: Camera, rectified_from_world: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Rectified intrinsics that keep the scale and the centre of both images."""
    focal = float(np.mean([camera.matrix[i, i] for camera in (left, right) for i in (0, 1)]))
    centre = np.array([(right.width - 1) / 2, (right.height - 1) / 2])
    principal = []
    for camera in (left, right):
        direction = rectified_from_world @ camera.rays_world(centre)
        principal.append(centre - focal * direction[:2] / direction[2])
    c_y = (principal[0][1] + principal[1][1]) / 2
    return _matrix(focal, principal[0][0], c_y), _matrix(focal, principal[1][0], c_y)


def _matrix(focal: float, c_x: float, c_y: float) -> FloatArray:
    return np.array([[focal, 0.0, c_x], [0.0, focal, c_y], [0.0, 0.0, 1.0]])


def _enlarged(matrix: FloatArray, scale: float) -> FloatArray:
    """Intrinsics of a picture that is enlarged about its outer corner; pixels count centres."""
    half = 0.5 * scale - 0.5
    change = np.array([[scale, 0.0, half], [0.0, scale, half], [0.0, 0.0, 1.0]])
    return change @ matrix


def _geometry(
    matrices: tuple[FloatArray, FloatArray],
    baseline: float,
    rotation: FloatArray,
    position: FloatArray,
    size: tuple[int, int],
) -> DepthGeometry:
    left_matrix, right_matrix = matrices
    return DepthGeometry(
        focal=float(right_matrix[0, 0]),
        c_x=float(right_matrix[0, 2]),
        c_y=float(right_matrix[1, 2]),
        baseline=baseline,
        disparity_offset=float(left_matrix[0, 2] - right_matrix[0, 2]),
        width=size[0],
        height=size[1],
        world_from_depth=RigidTransform(rotation.T, position),
    )


def _grid(camera: Camera, count: int) -> FloatArray:
    columns = np.linspace(0, camera.width - 1, count)
    rows = np.linspace(0, camera.height - 1, count)
    return np.stack(np.meshgrid(columns, rows), axis=-1)


def _raw_pixels(
    camera: Camera, matrix: FloatArray, rectified_from_world: FloatArray, pixels: FloatArray
) -> FloatArray:
    """Raw pixels (..., 2) that show what rectified pixels (..., 2) are to show."""
    x = (pixels[..., 0] - matrix[0, 2]) / matrix[0, 0]
    y = (pixels[..., 1] - matrix[1, 2]) / matrix[1, 1]
    directions = np.stack([x, y, np.ones_like(x)], axis=-1) @ rectified_from_world
    return camera.project(camera.position_world + directions)


def _pixel_map(
    camera: Camera, matrix: FloatArray, rectified_from_world: FloatArray, size: tuple[int, int]
) -> PixelMap:
    columns, rows = np.arange(size[0]), np.arange(size[1])
    pixels = np.stack(np.meshgrid(columns, rows), axis=-1).astype(np.float64)
    raw = _raw_pixels(camera, matrix, rectified_from_world, pixels)
    raw = np.nan_to_num(raw, nan=-1e4).clip(-1e4, 1e4).astype(np.float32)
    columns_raw, rows_raw = np.ascontiguousarray(raw[..., 0]), np.ascontiguousarray(raw[..., 1])
    positions, fractions = cv2.convertMaps(columns_raw, rows_raw, cv2.CV_16SC2)
    last = np.array([camera.width - 1, camera.height - 1])
    return PixelMap(
        positions=np.asarray(positions, dtype=np.int16),
        fractions=np.asarray(fractions, dtype=np.uint16),
        nearest=np.rint(raw).astype(np.int16),
        outside=np.any((raw < 0) | (raw > last), axis=-1),
    )
