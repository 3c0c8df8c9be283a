"""Pictures of a calibration board with truth: any lens, blur and noise."""

import cv2
import numpy as np

from stereotrack_core.arrays import Float32Array, FloatArray, ImageArray
from stereotrack_core.calibrate.board import Board
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.simulation.rig import Sensor

_TEXELS = 32  # of a square's side
_SAMPLES = 3  # of a pixel's side
_BACKGROUND, _BLACK, _WHITE = 90.0, 25.0, 210.0  # grey levels
_MARGIN = 0.625  # white border in squares


class BoardRenderer:
    """Draws what one camera sees of a board; blur and noise are those of the sensor."""

    def __init__(self, camera: Camera, board: Board, sensor: Sensor) -> None:
        self._camera, self._sensor = camera, sensor
        self._square = board.square
        self._texture = _texture(board)
        x, y = np.meshgrid(
            np.linspace(-1 - _MARGIN, board.columns + _MARGIN, 24),
            np.linspace(-1 - _MARGIN, board.rows + _MARGIN, 24),
        )
        self._area = board.square * np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
        step = 1.0 / _SAMPLES
        offsets = (np.arange(_SAMPLES) - (_SAMPLES - 1) / 2) * step
        columns = (np.arange(camera.width)[:, None] + offsets).ravel()
        rows = (np.arange(camera.height)[:, None] + offsets).ravel()
        pixels = np.stack(np.meshgrid(columns, rows), axis=-1)
        rays = camera.normalised(pixels)
        known = np.linalg.norm(rays, axis=-1) < camera.widest_slope
        self._rays: FloatArray = np.where(known[..., None], rays, np.nan)

    def picture(self, world_from_board: RigidTransform, frame: int) -> ImageArray:
        """Grey picture (H, W); the noise depends on the frame."""
        pose = self._camera.camera_from_world @ world_from_board
        light = np.full((self._camera.height, self._camera.width, 1), _BACKGROUND, np.float32)
        top, bottom, left, right = self._box(world_from_board)
        if top < bottom and left < right:
            rays = self._rays[
                _SAMPLES * top : _SAMPLES * bottom, _SAMPLES * left : _SAMPLES * right
            ]
            light[top:bottom, left:right, 0] = self._drawn(rays, pose)
        return self._sensor.exposed(light, frame)

    def _box(self, world_from_board: RigidTransform) -> tuple[int, int, int, int]:
        """Rows and columns that show the board; all where that cannot be told."""
        height, width = self._camera.height, self._camera.width
        seen = self._camera.project(world_from_board.apply(self._area))
        if not np.isfinite(seen).all():
            return 0, height, 0, width
        low = np.floor(seen.min(axis=0)).astype(int) - 2
        high = np.ceil(seen.max(axis=0)).astype(int) + 3
        return max(low[1], 0), min(high[1], height), max(low[0], 0), min(high[0], width)

    def _drawn(self, rays: FloatArray, pose: RigidTransform) -> Float32Array:
        """Mean light (h, w) of the samples of pixels, from where their rays meet the board."""
        normal = pose.rotation[:, 2]
        ahead = rays @ normal[:2] + normal[2]
        with np.errstate(divide="ignore", invalid="ignore"):
            depth = float(normal @ pose.translation) / ahead
            points = np.concatenate([rays, np.ones_like(ahead)[..., None]], axis=-1)
            points = points * depth[..., None] - pose.translation
            on_board = points @ pose.rotation[:, :2] / self._square
            texels = ((on_board + 1.0 + _MARGIN) * _TEXELS - 0.5).clip(-1e4, 1e4)
        texels[~(depth > 0.01)] = -1e4
        maps = np.nan_to_num(texels, nan=-1e4).astype(np.float32)
        light = cv2.remap(
            self._texture, np.ascontiguousarray(maps[..., 0]),
            np.ascontiguousarray(maps[..., 1]), cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_CONSTANT, borderValue=(_BACKGROUND,),
        )  # fmt: skip
        height, width = light.shape[0] // _SAMPLES, light.shape[1] // _SAMPLES
        blocks = np.asarray(light).reshape(height, _SAMPLES, width, _SAMPLES)
        mean: Float32Array = blocks.mean(axis=(1, 3), dtype=np.float32)
        return mean


def _texture(board: Board) -> Float32Array:
    """Grey levels of the board, `_TEXELS` to a square, with its white border."""
    size = (board.columns + 1) * _TEXELS, (board.rows + 1) * _TEXELS
    if board.dictionary:
        pattern = np.asarray(board.aruco_board().generateImage(size), dtype=np.float32) / 255.0
    else:
        row, column = np.indices((size[1], size[0])) // _TEXELS
        pattern = ((row + column) % 2 == 0).astype(np.float32)
    border = round(_MARGIN * _TEXELS)
    framed = np.pad(pattern, border, constant_values=1.0)
    return np.asarray(_BLACK + (_WHITE - _BLACK) * framed, dtype=np.float32)


def board_in_view(
    camera: Camera, board: Board, rng: np.random.Generator, distances: tuple[float, float]
) -> RigidTransform:
    """A random place (world_from_board) at which a camera sees the whole board.

    The board is tilted by up to 50 degrees and turned by up to 30; `distances` are in metres.
    Raises ValueError where none is found.
    """
    middle = board.corners.mean(axis=0)
    frame = np.array([camera.width, camera.height])
    for _ in range(1000):
        pixel = rng.uniform(0.02, 0.98, 2) * frame
        slope = camera.normalised(pixel)
        direction = np.array([*slope, 1.0]) / np.linalg.norm([*slope, 1.0])
        centre = direction * rng.uniform(*distances)
        axis = rng.uniform(0, 2 * np.pi)
        tilt = np.radians(rng.uniform(5.0, 50.0)) * np.array([np.cos(axis), np.sin(axis), 0.0])
        roll = np.array([0.0, 0.0, np.radians(rng.uniform(-30.0, 30.0))])
        rotation = rotation_from_vector(tilt) @ rotation_from_vector(roll)
        placed = RigidTransform(rotation, centre - rotation @ middle)
        world_from_board = camera.world_from_camera @ placed
        outline = np.array([[-1.5, -1.5], [board.columns + 0.5, -1.5], [-1.5, board.rows + 0.5],
                            [board.columns + 0.5, board.rows + 0.5]]) * board.square  # fmt: skip
        corners = np.column_stack([outline, np.zeros(4)])
        seen = camera.project(world_from_board.apply(np.concatenate([corners, board.corners])))
        if np.isfinite(seen).all() and (seen > 1).all() and (seen < frame - 2).all():
            return world_from_board
    raise ValueError("the board does not fit into the image")
