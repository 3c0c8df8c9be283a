"""Recordings in memory: rendered walls and boxes with exact geometry, no files."""

from pathlib import Path

import cv2
import numpy as np

from stereotrack_core.geometry.camera import Camera
from stereotrack_core.recording.description import Recording, Stream, View
from stereotrack_core.recording.reader import FrameSet, ViewImages
from tests.depth.scenes import camera, texture

WALL_Y = 2.5
BOX = np.array([[-0.25, 0.25], [0.8, 1.2], [0.5, 1.4]])  # x, y, z: low and high


def stereo_recording(**left_changes) -> Recording:
    """Two stereo views that look along y from different places, one of them turned."""
    cameras = {
        "A_right": camera("A_right", (0.0, -1.8, 1.0)),
        "A_left": camera("A_left", (-0.12, -1.8, 1.0), **left_changes),
        "B_right": camera("B_right", (0.6, -1.7, 1.1), (0.0, 0.2, 0.0)),
        "B_left": camera("B_left", (0.48, -1.7, 1.1), (0.0, 0.16, 0.0)),
    }
    views = tuple(
        View(v, "stereo", Stream(f"{v}_right", "-"), left=Stream(f"{v}_left", "-")) for v in "AB"
    )
    return Recording(Path(), "synthetic", 10.0, views, cameras)


def depth_recording(*, mask: bool = False) -> Recording:
    """One depth view."""
    stream = Stream("K", "-")
    view = View("K", "depth", stream, depth=stream, mask=Stream("", "-") if mask else None)
    return Recording(Path(), "depth", 30.0, (view,), {"K": camera("K", (0.0, -1.8, 1.0))})


def frame_set(recording: Recording, index: int, *, box: bool = True, shift: float = 0.0):
    """All images at one instant: the wall, and the box moved along x by `shift`."""
    views = {}
    for view in recording.views:
        reference = recording.reference_camera(view)
        image, depth, on_box = render(reference, box, shift)
        if view.kind == "stereo":
            left, _, _ = render(recording.cameras[view.left.camera], box, shift)
            views[view.name] = ViewImages(image=image, left=left)
        else:
            mask = on_box if view.mask else None
            views[view.name] = ViewImages(image=image, depth=depth.astype(np.float32), mask=mask)
    return FrameSet(index, views)


def render(cam: Camera, box: bool, shift: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Image, depth along the camera's z, and where the box is."""
    pixels = np.stack(np.meshgrid(np.arange(cam.width), np.arange(cam.height)), axis=-1)
    rays = cam.rays_world(pixels.astype(float))
    origin = cam.position_world
    to_wall = (WALL_Y - origin[1]) / rays[..., 1]
    grey = _sampled(_WALL, origin + rays * to_wall[..., None])
    distance, hit = to_wall, np.zeros(to_wall.shape, dtype=bool)
    if box:
        offset = np.array([shift, 0.0, 0.0])
        to_front = (BOX[1, 0] - origin[1]) / rays[..., 1]
        at = origin + rays * to_front[..., None] - offset
        hit = ((at >= BOX[:, 0] - 1e-9) & (at <= BOX[:, 1] + 1e-9)).all(axis=-1)
        grey = np.where(hit, _sampled(_FRONT, at), grey)
        distance = np.where(hit, to_front, distance)
    along_z = rays @ cam.camera_from_world.rotation[2]
    return grey.clip(0, 255).astype(np.uint8), distance * along_z, hit


def _sampled(image: np.ndarray, at: np.ndarray) -> np.ndarray:
    u, v = (at[..., 0] + 4.0) * 120, (4.0 - at[..., 2]) * 120
    return cv2.remap(image, u.astype(np.float32), v.astype(np.float32), cv2.INTER_CUBIC)


_WALL = texture(960, 960, seed=11)
_FRONT = texture(960, 960, seed=12)


class MemoryReader:
    """Frame sets and pictures of the empty scene as ``FrameReader`` gives them."""

    def __init__(self, recording: Recording, sets: list[FrameSet], empty: bool) -> None:
        self.frame_count = len(sets)
        self._sets = sets
        self._empty = frame_set(recording, 0, box=False) if empty else None

    def frame_set(self, k: int) -> FrameSet:
        return self._sets[k]

    def background(self, view: str):
        if self._empty is None:
            return None
        images = self._empty.views[view]
        return images.left, images.image
