"""Floor, cameras and the reference: what stands around the tracked body."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
import pyvista as pv

from stereotrack_core.arrays import FloatArray, ImageArray
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.landmarks import LANDMARKS, SKELETON

from ..style.theme import Theme
from .content import SceneContent
from .geometry import Shape, dashes

_FLOOR_HALF = 3.0
_FLOOR_STEP = 0.5
_ARROW_LENGTH = 0.5
_FRUSTUM_SHARE, _FRUSTUM_DEEPEST = 0.12, 0.45
_TEXTURE_WIDTH = 320
_CORNERS = np.array([[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]])
"""Where the corners of a picture are in its texture, whose rows count from below."""

_LANDMARK_METRES = 0.03
_LANDMARK_SIZES = np.array([2.5, 7.0])
_BONES = np.array([[LANDMARKS.index(a), LANDMARKS.index(b)] for a, b in SKELETON])
_SHOULDERS = [LANDMARKS.index("left_shoulder"), LANDMARKS.index("right_shoulder")]


def floor_lines(floor_z: float) -> FloatArray:
    """End points (2 L, 3) of the floor's grid."""
    steps = np.arange(-_FLOOR_HALF, _FLOOR_HALF + 1e-9, _FLOOR_STEP)
    ends = np.array([-_FLOOR_HALF, _FLOOR_HALF])
    along = np.stack(np.meshgrid(steps, ends, indexing="ij"), axis=-1).reshape(-1, 2)
    flat = np.concatenate([along, along[:, ::-1]])
    return np.column_stack([flat, np.full(len(flat), floor_z)])


def north_arrow(floor_z: float) -> FloatArray:
    """End points (6, 3) of an arrow north of the floor's grid."""
    foot = np.array([0.0, _FLOOR_HALF, floor_z])
    tip = foot + (0.0, _ARROW_LENGTH, 0.0)
    back = tip - (0.0, 0.18, 0.0)
    side = np.array([0.12, 0.0, 0.0])
    return np.stack([foot, tip, back - side, tip, back + side, tip])


class FloorLayer:
    """Grid of half a metre on the floor, with an arrow to the north."""

    def __init__(self, renderer: pv.Renderer) -> None:
        self._grid = Shape(renderer)
        self._arrow = Shape(renderer)
        self._height: float | None = None

    def show(self, content: SceneContent, visible: bool, theme: Theme, scale: float) -> None:
        """Lay the floor at the content's height."""
        if content.floor_z != self._height:
            self._grid.set_lines(floor_lines(content.floor_z))
            self._arrow.set_lines(north_arrow(content.floor_z))
            self._height = content.floor_z
        for shape, colour, width in (
            (self._grid, theme.scene_grid, 1.0),
            (self._arrow, theme.accent, 2.0),
        ):
            shape.actor.visibility = visible
            shape.set_colour(colour)
            shape.prop.line_width = width * scale

    @staticmethod
    def label(content: SceneContent) -> tuple[str, FloatArray]:
        """Return the arrow's letter and where (3,) it stands."""
        return "N", np.array([0.0, _FLOOR_HALF + _ARROW_LENGTH + 0.15, content.floor_z])


class ReferenceLayer:
    """Skeleton of the reference in dashes, seen through the model."""

    def __init__(self, renderer: pv.Renderer) -> None:
        self._bones = Shape(renderer)
        self._landmarks = Shape(renderer)
        self._landmarks.prop.render_points_as_spheres = True

    def set_dots_to(self, pixels_per_metre: float, scale: float) -> None:
        """Let landmarks be balls of three centimetres, within what can be seen."""
        size = float(np.clip(_LANDMARK_METRES * pixels_per_metre, *(scale * _LANDMARK_SIZES)))
        self._landmarks.prop.point_size = size

    def show(self, content: SceneContent, visible: bool, theme: Theme, scale: float) -> None:
        """Draw the bones whose two landmarks are known."""
        shown = visible and content.reference is not None
        for shape in (self._bones, self._landmarks):
            shape.actor.visibility = shown
            shape.set_colour(theme.reference)
        if content.reference is None or not shown:
            return
        self._bones.prop.line_width = 2.0 * scale
        points = content.reference
        middle = points[_SHOULDERS].mean(axis=0)
        starts = np.concatenate([points[_BONES[:, 0]], middle[None]])
        ends = np.concatenate([points[_BONES[:, 1]], points[[LANDMARKS.index("head")]]])
        self._bones.set_lines(dashes(starts, ends))
        self._landmarks.set_dots(points[np.isfinite(points).all(axis=1)])


class CameraLayer:
    """A frustum for each camera, with its image on it."""

    def __init__(self, renderer: pv.Renderer) -> None:
        self._renderer = renderer
        self._frusta: dict[str, _Frustum] = {}

    def show(self, content: SceneContent, visible: bool, theme: Theme, scale: float) -> None:
        """Place the cameras and show their newest images."""
        names = {camera.name for camera in content.cameras}
        for name in [name for name in self._frusta if name not in names]:
            self._frusta.pop(name).remove()
        depth = frustum_depth(content.cameras)
        for camera in content.cameras:
            if camera.name not in self._frusta:
                self._frusta[camera.name] = _Frustum(self._renderer)
            frustum = self._frusta[camera.name]
            frustum.place(camera, depth)
            frustum.show(content.camera_images.get(camera.name), visible, theme, scale)

    @staticmethod
    def labels(content: SceneContent) -> list[tuple[str, FloatArray]]:
        """Return each camera's name and where (3,) it stands."""
        return [(camera.name, camera.position_world) for camera in content.cameras]


class _Frustum:
    """Edges of what a camera sees, and a screen at their end."""

    def __init__(self, renderer: pv.Renderer) -> None:
        self._renderer = renderer
        self._edges, self._screen = Shape(renderer), Shape(renderer)
        self._camera: Camera | None = None
        self._depth = 0.0
        self._image: ImageArray | None = None

    def place(self, camera: Camera, depth: float) -> None:
        if camera is self._camera and depth == self._depth:
            return
        corners = frustum_corners(camera, depth)
        apex = np.broadcast_to(camera.position_world, (4, 3))
        rays = np.stack([apex, corners], axis=1).reshape(-1, 3)
        rim = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1).reshape(-1, 3)
        self._edges.set_lines(np.concatenate([rays, rim]))
        self._screen.set_triangles(corners, np.array([[0, 1, 2], [0, 2, 3]]))
        self._screen.mesh.active_texture_coordinates = _CORNERS
        self._camera, self._depth = camera, depth

    def show(self, image: ImageArray | None, visible: bool, theme: Theme, scale: float) -> None:
        self._edges.actor.visibility = visible
        self._edges.set_colour(theme.muted)
        self._edges.prop.line_width = 1.2 * scale
        self._screen.actor.visibility = visible and image is not None
        if image is not None and visible and image is not self._image:
            self._screen.actor.texture = _texture(image)
            self._image = image

    def remove(self) -> None:
        for shape in (self._edges, self._screen):
            self._renderer.remove_actor(shape.actor, render=False)


def frustum_depth(cameras: Sequence[Camera]) -> float:
    """Metres from cameras to their pictures: less for a small rig, so that none hides the rest."""
    places = np.array([camera.position_world for camera in cameras]).reshape(-1, 3)
    wide = float(np.linalg.norm(np.ptp(places, axis=0))) if len(places) > 1 else np.inf
    return min(_FRUSTUM_SHARE * wide, _FRUSTUM_DEEPEST)


def frustum_corners(camera: Camera, depth: float) -> FloatArray:
    """Corners (4, 3), world, of a camera's picture `depth` metres before it, from the top left."""
    right, bottom = camera.width - 0.5, camera.height - 0.5
    pixels = np.array([[-0.5, -0.5], [right, -0.5], [right, bottom], [-0.5, bottom]])
    flat = camera.normalised(pixels)
    in_camera = np.column_stack([flat, np.ones(4)]) * depth
    return camera.world_from_camera.apply(in_camera)


def _texture(image: ImageArray) -> pv.Texture:
    height, width = image.shape[:2]
    if width > _TEXTURE_WIDTH:
        size = (_TEXTURE_WIDTH, max(1, round(height * _TEXTURE_WIDTH / width)))
        image = np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)
    texture = pv.Texture(image if image.ndim == 3 else np.repeat(image[..., None], 3, axis=2))
    texture.interpolate = True
    return texture
