"""What the views should see of a body, drawn coarsely and compared with what they saw."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import Float32Array, FloatArray
from stereotrack_core.body.model import Cones
from stereotrack_core.body.pose import PartFrames
from stereotrack_core.body.surface import cone_tables
from stereotrack_core.depth.cloud import Cloud, ViewDepth
from stereotrack_core.tracking.arm_search.picture_kernels import (
    disagreements,
    draw_each,
)

_AROUND = 25
"""Pixels around the person that are compared."""


@dataclass(frozen=True, eq=False)
class SeenPicture:
    """One view at one instant, thinned out.

    Attributes
    ----------
    measured : (h, w) float32, 1/metres
        Inverse range; 0 where not known.
    person : (h, w) int8
        1 where the person is.
    left, top, step : float, pixels
        Place of the first pixel in the image, and distance to the next.
    pinhole : (3,) float64
    camera_from_world : (3, 4) float64
    eye : (3,) float64, world
    scale : float
        Disparity over inverse range.
    """

    measured: Float32Array
    person: FloatArray
    left: float
    top: float
    step: float
    pinhole: FloatArray
    camera_from_world: FloatArray
    eye: FloatArray
    scale: float

    def drawn(self, table: FloatArray) -> Float32Array:
        """Inverse ranges (h, w) of cones (C, 18); 0 where there are none."""
        picture: Float32Array = self.drawn_each(table[None])[0]
        return picture

    def drawn_each(self, tables: FloatArray) -> Float32Array:
        """Inverse ranges (K, h, w) of cones in K poses (K, C, 18), each by itself."""
        pictures = np.zeros((len(tables), *self.measured.shape), dtype=np.float32)
        box = self.left, self.top, self.step
        draw_each(tables, self.camera_from_world, self.pinhole, self.eye, box, pictures)
        return pictures

    def area(self, place: FloatArray) -> float:
        """Square metres that a pixel shows at a place (3,), world."""
        depth = float(self.camera_from_world[2, :3] @ place + self.camera_from_world[2, 3])
        return float((self.step * depth / self.pinhole[0]) ** 2)


def seen_pictures(cloud: Cloud, step: int) -> tuple[SeenPicture, ...]:
    """Pictures of the views in which somebody is, every `step`-th pixel."""
    found = (_seen_picture(depth, step) for depth in cloud.depths.values())
    return tuple(picture for picture in found if picture is not None)


def _seen_picture(depth: ViewDepth, step: int) -> SeenPicture | None:
    if depth.extent is None:
        return None
    left, top, right, bottom = depth.extent
    left, top = max(0, left - _AROUND), max(0, top - _AROUND)
    box = slice(top, bottom - 1 + _AROUND, step), slice(left, right - 1 + _AROUND, step)
    ranges, g = depth.range_z[box], depth.geometry
    known = ranges > 0.0
    to_camera = g.world_from_depth.inverse()
    return SeenPicture(
        measured=np.where(known, 1.0 / np.where(known, ranges, 1.0), 0.0).astype(np.float32),
        person=np.ascontiguousarray(depth.person[box]).astype(np.int8),
        left=float(left),
        top=float(top),
        step=float(step),
        pinhole=np.array([g.focal, g.c_x, g.c_y]),
        camera_from_world=to_camera.matrix()[:3],
        eye=g.world_from_depth.translation.copy(),
        scale=g.disparity_scale,
    )


def outline_table(cones: Cones, frames: PartFrames) -> FloatArray:
    """Tables (..., C, 18) of cones, as thick as their outlines are; see :func:`cone_tables`."""
    table = cone_tables(cones, frames)
    table[..., 12:14] = np.maximum(table[..., 12:14] + cones.outline[:, :1], 0.01)
    return table


@dataclass(frozen=True)
class Likeness:
    """How pictures are compared.

    Attributes
    ----------
    sigma : float, pixels
        Difference of disparities that counts half.
    unknown : float
        Share of a pixel of the person without a range that speaks against a body there.
    """

    sigma: float
    unknown: float

    def unlike_pairs(
        self, seen: SeenPicture, rest: Float32Array, left: Float32Array, right: Float32Array
    ) -> FloatArray:
        """Pixels (K, L) in which bodies do not look as measured.

        Parameters
        ----------
        seen : SeenPicture
        rest : (h, w) float32
            Trunk, head and legs as :meth:`SeenPicture.drawn` draws them.
        left, right : (K, h, w) and (L, h, w) float32
            Arms, of which all pairs are taken.
        """
        pixels = np.empty((len(left), len(right)))
        as_seen = seen.measured, seen.person, seen.scale
        disagreements(rest, left, right, *as_seen, self.sigma**2, self.unknown, pixels)
        return pixels
