"""What the views should see of a body, drawn coarsely and compared with what they saw."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from stereotrack_core.arrays import BoolArray, Float32Array, FloatArray
from stereotrack_core.body.model import BodyModel, placed_cones
from stereotrack_core.body.pose import PartFrames
from stereotrack_core.body.surface import cone_table
from stereotrack_core.depth.cloud import Cloud, ViewDepth
from stereotrack_core.tracking.search.picture_kernels import (
    COLUMNS,
    cone_images,
    disagreement,
    draw,
)

_AROUND = 25
"""Pixels around the person that are compared."""

_SPECKS = np.ones((5, 5), np.uint8)


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
        """Inverse ranges (h, w) of cones; 0 where there are none."""
        images = np.empty((len(table), COLUMNS))
        cone_images(table, self.camera_from_world, self.pinhole, self.eye, images)
        picture = np.zeros(self.measured.shape, dtype=np.float32)
        draw(images, self.left, self.top, self.step, picture)
        return picture

    def area(self, place: FloatArray) -> float:
        """Square metres that a pixel shows at a place (3,), world."""
        depth = float(self.camera_from_world[2, :3] @ place + self.camera_from_world[2, 3])
        return float((self.step * depth / self.pinhole[0]) ** 2)


def seen_pictures(cloud: Cloud, step: int) -> tuple[SeenPicture, ...]:
    """Pictures of the views in which somebody is, every `step`-th pixel."""
    found = (_seen_picture(depth, step) for depth in cloud.depths.values())
    return tuple(picture for picture in found if picture is not None)


def _seen_picture(depth: ViewDepth, step: int) -> SeenPicture | None:
    person = depth.foreground if depth.outline is None else depth.outline
    large = cv2.erode(person.astype(np.uint8), _SPECKS)
    rows, columns = np.flatnonzero(large.any(axis=1)), np.flatnonzero(large.any(axis=0))
    if not len(rows):
        return None
    top, left = max(0, rows[0] - _AROUND), max(0, columns[0] - _AROUND)
    box = slice(top, rows[-1] + _AROUND, step), slice(left, columns[-1] + _AROUND, step)
    ranges, g = depth.range_z[box], depth.geometry
    known = ranges > 0.0
    to_camera = g.world_from_depth.inverse()
    return SeenPicture(
        measured=np.where(known, 1.0 / np.where(known, ranges, 1.0), 0.0).astype(np.float32),
        person=np.ascontiguousarray(person[box]).astype(np.int8),
        left=float(left),
        top=float(top),
        step=float(step),
        pinhole=np.array([g.focal, g.c_x, g.c_y]),
        camera_from_world=to_camera.matrix()[:3],
        eye=g.world_from_depth.translation.copy(),
        scale=g.disparity_scale,
    )


def outline_table(body: BodyModel, frames: PartFrames, chosen: BoolArray) -> FloatArray:
    """Table of some cones, as thick as their outlines are; see :func:`cone_table`."""
    table = cone_table(placed_cones(body, frames)[chosen])
    table[:, 12:14] = np.maximum(table[:, 12:14] + body.cones.outline[chosen, :1], 0.01)
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

    def unlike(
        self,
        seen: SeenPicture,
        rest: Float32Array,
        left: Float32Array,
        right: Float32Array,
    ) -> float:
        """Pixels in which a body does not look as measured."""
        return float(
            disagreement(
                rest,
                left,
                right,
                seen.measured,
                seen.person,
                seen.scale,
                self.sigma**2,
                self.unknown,
            )
        )
