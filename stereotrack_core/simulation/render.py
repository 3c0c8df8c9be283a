"""Pictures of a scene by one camera, and the true depths in them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import Float32Array, FloatArray, ImageArray
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.simulation.actor import Actor
from stereotrack_core.simulation.rig import Sensor
from stereotrack_core.simulation.room import ROOM_MATERIALS, Things, material_table
from stereotrack_core.simulation.shading import (
    SAMPLES,
    Lamp,
    Raster,
    Samples,
    Shadows,
    Stuff,
    clothing,
    in_samples,
    shade,
)

_NEAR = 0.15
_WIDEST = 2.2
"""Points further out, as share of the image's half diagonal, are not projected: there a
distortion model may fold back into the picture."""

Projected = tuple[FloatArray, FloatArray]  # raw pixels (V, 2), NaN if not drawn, and 1 / z (V,)


@dataclass(frozen=True, eq=False)
class Posed:
    """An actor in a pose: vertices and normals (V, 3), world."""

    actor: Actor
    vertices: FloatArray
    normals: FloatArray


class CameraRenderer:
    """Draws what one camera sees; `lattice` (64, 64, 64) is the noise of the textures."""

    def __init__(
        self,
        camera: Camera,
        sensor: Sensor,
        things: Things,
        lattice: Float32Array,
        lamp: Lamp | None = None,
    ) -> None:
        self._camera = camera
        self._sensor = sensor
        self._lamp = lamp
        self._lattice = lattice
        height, width = SAMPLES * camera.height, SAMPLES * camera.width
        self._depth = np.zeros((height, width), np.float32)
        self._light = np.zeros((height, width, len(sensor.response)), np.float32)
        pixels, nearness = self._projected(things.vertices)
        raster = Raster.over(self._depth)
        raster.draw(in_samples(pixels), nearness, things.triangles)
        samples = raster.seen(things.triangles)
        points, normals = samples.of(things.vertices), samples.of(things.normals)
        stuff = Stuff(material_table(ROOM_MATERIALS), things.stuff[samples.triangle], points[:, 2])
        self._light[samples.where] = shade(points, normals, stuff, lattice, sensor.response)
        self._empty = _averaged(self._light)
        self._shaded = samples, points, _flat(samples, things.normals)

    def background(self) -> ImageArray:
        """The empty scene."""
        return self._sensor.exposed(self._empty, -1)

    def picture(self, people: Sequence[Posed], frame: int) -> ImageArray:
        """The scene with people in it."""
        projected = [self._projected(posed.vertices) for posed in people]
        room, light, shadows = self._light, self._empty, None
        if self._lamp is not None:
            shadows = self._lamp.shadows((one.actor.triangles, one.vertices) for one in people)
            samples, points, normals = self._shaded
            room = room.copy()
            room[samples.where] *= shadows.left_light(points, normals, False)[:, None]
            light = _averaged(room)
        box = self._box([pixels for pixels, _ in projected])
        if box is not None:
            rows, columns = box
            light = light.copy()
            light[rows, columns] = self._drawn(people, projected, box, room, shadows)
        return self._sensor.exposed(light, frame)

    def depth(self, people: Sequence[Posed]) -> Float32Array:
        """True depth (H, W) along the camera's z in metres, of the pixels' upper left samples."""
        nearness = self._depth.copy()
        _rasterised(people, [self._projected(one.vertices) for one in people], (0, 0), nearness)
        far = np.float32(1.0) / np.maximum(nearness[::SAMPLES, ::SAMPLES], np.float32(1e-3))
        return far.astype(np.float32)

    def _drawn(
        self,
        people: Sequence[Posed],
        projected: Sequence[Projected],
        box: tuple[slice, slice],
        room: Float32Array,
        shadows: Shadows | None,
    ) -> Float32Array:
        """Light (h, w, c) of the pixels of a box; `room` is that of all samples without people."""
        rows, columns = (slice(SAMPLES * s.start, SAMPLES * s.stop) for s in box)
        depth, light = self._depth[rows, columns].copy(), room[rows, columns].copy()
        origin = box[1].start, box[0].start
        for who, samples in _rasterised(people, projected, origin, depth):
            actor = who.actor
            rest = samples.of(actor.vertices)
            stuff = clothing(actor.materials, actor.marks, rest)
            normals = samples.of(who.normals)
            shaded = shade(rest, normals, stuff, self._lattice, self._sensor.response)
            light[samples.where] = shaded
            if shadows is not None:
                flat = _flat(samples, who.normals)
                left = shadows.left_light(samples.of(who.vertices), flat, True)
                light[samples.where] *= left[:, None]
        return _averaged(light)

    def _projected(self, vertices: FloatArray) -> Projected:
        camera = self._camera
        in_camera = camera.camera_from_world.apply(vertices)
        z = in_camera[:, 2]
        safe = np.maximum(z, _NEAR)
        reach = np.hypot(camera.width, camera.height) / 2 / camera.matrix[0, 0] * _WIDEST
        outside = (z < _NEAR) | (np.hypot(in_camera[:, 0], in_camera[:, 1]) > reach * safe)
        pixels = camera.project(vertices)
        pixels[outside] = np.nan
        return pixels, 1.0 / safe

    def _box(self, pixels: Sequence[FloatArray]) -> tuple[slice, slice] | None:
        size = np.array([self._camera.width, self._camera.height])
        points = np.concatenate([*pixels, np.zeros((0, 2))])
        points = points[(points > -1).all(axis=1) & (points < size).all(axis=1)]  # not NaN
        if not len(points):
            return None
        low = np.maximum(np.floor(points.min(axis=0)).astype(int) - 1, 0)
        high = np.minimum(np.ceil(points.max(axis=0)).astype(int) + 2, size)
        return slice(int(low[1]), int(high[1])), slice(int(low[0]), int(high[0]))


def _rasterised(
    people: Sequence[Posed],
    projected: Sequence[Projected],
    origin: tuple[int, int],
    depth: Float32Array,
) -> Iterator[tuple[Posed, Samples]]:
    """Draw everybody into `depth`, whose corner is the pixel (x, y) `origin`."""
    raster = Raster.over(depth)
    firsts = np.cumsum([0, *(len(posed.actor.triangles) for posed in people)]).tolist()
    for posed, first, (pixels, nearness) in zip(people, firsts, projected, strict=False):
        raster.draw(in_samples(pixels, origin), nearness, posed.actor.triangles, first)
    pairs = zip(people, firsts, strict=False)
    return ((posed, raster.seen(posed.actor.triangles, first)) for posed, first in pairs)


def _flat(samples: Samples, normals: FloatArray) -> FloatArray:
    """Normals (N, 3) of the first corners: shadows need no smooth ones."""
    return np.asarray(normals[samples.corners[:, 0]])


def _averaged(light: Float32Array) -> Float32Array:
    height, width, channels = light.shape
    blocks = light.reshape(height // SAMPLES, SAMPLES, width // SAMPLES, SAMPLES, channels)
    return np.asarray(blocks.mean(axis=(1, 3), dtype=np.float32))
