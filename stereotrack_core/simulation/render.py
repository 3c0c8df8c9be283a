"""Pictures of a scene by one camera; what stands still is drawn once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stereotrack_core.arrays import Float32Array, FloatArray, ImageArray, IntArray
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.simulation.actor import Actor
from stereotrack_core.simulation.disturbances import UNDISTURBED, Disturber, Shadows
from stereotrack_core.simulation.materials import material_table
from stereotrack_core.simulation.raster import LIGHT, SAMPLES, mark, rasterise, shade
from stereotrack_core.simulation.rig import Sensor
from stereotrack_core.simulation.room import ROOM_MATERIALS, Things

_NEAR = 0.15
_WIDEST = 2.2
"""Points further out, as share of the image's half diagonal, are not projected: there a
distortion model may fold back into the picture."""


@dataclass(frozen=True, eq=False)
class Posed:
    """An actor in a pose: vertices and normals (V, 3), world."""

    actor: Actor
    vertices: FloatArray
    normals: FloatArray


@dataclass(frozen=True, eq=False)
class Seen:
    """Truth of a picture's pixels (their upper left samples)."""

    depth: Float32Array
    """(H, W) is in metres along the camera's z; `stuff` (H, W) is the row of a person's materials
    (skin, hair, shirt ...), -1 for the room."""
    stuff: NDArray[np.int8]


class CameraRenderer:
    """Draws what one camera sees: things that stand still, and people.

    `lattice` (64, 64, 64) is the noise of the textures.
    """

    def __init__(
        self,
        camera: Camera,
        sensor: Sensor,
        things: Things,
        lattice: Float32Array,
        disturber: Disturber = UNDISTURBED,
    ) -> None:
        self._camera = camera
        self._sensor = sensor
        self._disturber = disturber
        self._lattice = lattice
        height, width = SAMPLES * camera.height, SAMPLES * camera.width
        self._depth = np.zeros((height, width), np.float32)
        self._light = np.zeros((height, width, len(sensor.response)), np.float32)
        ids, weights = _empty_ids(self._depth)
        pixels, nearness = self._projected(things.vertices)
        rasterise(pixels, nearness, things.triangles, 0, 0, 0, self._depth, ids, weights)
        shade(
            ids, weights, 0, things.triangles, things.vertices, things.normals, things.stuff,
            material_table(ROOM_MATERIALS), np.zeros(8), lattice, LIGHT, sensor.response,
            self._light,
        )  # fmt: skip
        self._empty = _averaged(self._light)
        self._room = things, ids, weights

    def background(self) -> ImageArray:
        """The empty scene."""
        return self._exposed(self._empty, -1)

    def picture(self, people: Sequence[Posed], frame: int) -> ImageArray:
        """The scene with people in it."""
        projected = [self._projected(posed.vertices) for posed in people]
        surfaces = [(p.actor.triangles, p.vertices, p.normals) for p in people]
        shadows = Shadows.of(self._disturber, surfaces, frame)
        room, light = self._light, self._empty
        if shadows is not None:
            things, ids, weights = self._room
            room = room.copy()
            surface = things.triangles, things.vertices, things.normals
            shadows.darken((ids, weights, 0), surface, False, room)
            light = _averaged(room)
        box = self._box([pixels for pixels, _ in projected])
        if box is not None:
            light = light.copy()
            top, bottom, left, right = box
            light[top:bottom, left:right] = self._drawn(people, projected, box, room, shadows)
        return self._exposed(light, frame)

    def _exposed(self, light: Float32Array, frame: int) -> ImageArray:
        """Picture of light (H, W, c); frame -1 is the empty scene."""
        light = self._disturber.on_sensor(self._camera.name, light, frame)
        sensor = self._sensor if frame < 0 else self._disturber.sensor(self._sensor)
        return sensor.exposed(light, frame)

    def seen(self, people: Sequence[Posed]) -> Seen:
        """Truth of every pixel, for measuring what a matcher makes of the pictures."""
        depth = self._depth.copy()
        projected = [self._projected(posed.vertices) for posed in people]
        stuff = np.full(depth.shape, -1, np.int8)
        for who, ids, weights, first in _rasterised(people, projected, 0, 0, depth):
            mark(ids, weights, first, who.triangles, who.vertices, who.marks, stuff)
        picked = np.s_[::SAMPLES, ::SAMPLES]
        far = np.float32(1.0) / np.maximum(depth[picked], np.float32(1e-3))
        return Seen(far.astype(np.float32), stuff[picked])

    def _drawn(
        self,
        people: Sequence[Posed],
        projected: Sequence[tuple[FloatArray, FloatArray]],
        box: tuple[int, int, int, int],
        room: Float32Array,
        shadows: Shadows | None,
    ) -> Float32Array:
        """Light (h, w, c) of the pixels of a box; `room` is that of all samples without people."""
        top, bottom, left, right = box
        samples = np.s_[SAMPLES * top : SAMPLES * bottom, SAMPLES * left : SAMPLES * right]
        depth, light = self._depth[samples].copy(), room[samples].copy()
        drawn = _rasterised(people, projected, left, top, depth)
        for posed, (who, ids, weights, first) in zip(people, drawn, strict=True):
            shade(
                ids, weights, first, who.triangles, who.vertices, posed.normals, who.stuff,
                who.materials, who.marks, self._lattice, LIGHT, self._sensor.response, light,
            )  # fmt: skip
            if shadows is not None:
                surface = who.triangles, posed.vertices, posed.normals
                shadows.darken((ids, weights, first), surface, True, light)
        return _averaged(light)

    def _projected(self, vertices: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Raw pixels (V, 2), NaN where not to be drawn, and 1 / z (V,)."""
        camera = self._camera
        in_camera = camera.camera_from_world.apply(vertices)
        z = in_camera[:, 2]
        safe = np.maximum(z, _NEAR)
        reach = np.hypot(camera.width, camera.height) / 2 / camera.matrix[0, 0] * _WIDEST
        outside = (z < _NEAR) | (np.hypot(in_camera[:, 0], in_camera[:, 1]) > reach * safe)
        pixels = camera.project(vertices)
        pixels[outside] = np.nan
        return pixels, 1.0 / safe

    def _box(self, pixels: Sequence[FloatArray]) -> tuple[int, int, int, int] | None:
        """Rows and columns that people touch: top, bottom, left, right."""
        size = np.array([self._camera.width, self._camera.height])
        seen = [p[np.isfinite(p).all(axis=1)] for p in pixels]
        points = np.concatenate([p for p in seen if len(p)] or [np.zeros((0, 2))])
        points = points[(points > -1).all(axis=1) & (points < size).all(axis=1)]
        if not len(points):
            return None
        low = np.maximum(np.floor(points.min(axis=0)).astype(int) - 1, 0)
        high = np.minimum(np.ceil(points.max(axis=0)).astype(int) + 2, size)
        return int(low[1]), int(high[1]), int(low[0]), int(high[0])


def _rasterised(
    people: Sequence[Posed],
    projected: Sequence[tuple[FloatArray, FloatArray]],
    left: int,
    top: int,
    depth: Float32Array,
) -> list[tuple[Actor, IntArray, Float32Array, int]]:
    """Draw everybody into `depth`; for each what is seen where, and the number of the first."""
    ids, weights = _empty_ids(depth)
    drawn, first = [], 0
    for posed, (pixels, nearness) in zip(people, projected, strict=True):
        triangles = posed.actor.triangles
        rasterise(pixels, nearness, triangles, first, left, top, depth, ids, weights)
        drawn.append((posed.actor, ids, weights, first))
        first += len(triangles)
    return drawn


def _empty_ids(depth: Float32Array) -> tuple[IntArray, Float32Array]:
    ids = np.full(depth.shape, -1, np.int32)
    return ids, np.zeros((*depth.shape, 2), np.float32)  # type: ignore[return-value]


def _averaged(light: Float32Array) -> Float32Array:
    """Means of the samples of each pixel."""
    height, width, channels = light.shape
    blocks = light.reshape(height // SAMPLES, SAMPLES, width // SAMPLES, SAMPLES, channels)
    result: Float32Array = blocks.mean(axis=(1, 3), dtype=np.float32)
    return result
