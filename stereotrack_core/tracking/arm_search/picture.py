"""What the views should see of a body, drawn coarsely and compared with what they saw."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from stereotrack_core.arrays import Float32Array, FloatArray
from stereotrack_core.body.model import BodyModel, PlacedCones, placed_cones
from stereotrack_core.body.pose import PartFrames
from stereotrack_core.compiled import compiled
from stereotrack_core.depth.cloud import Cloud, ViewDepth

_AROUND = 25  # pixels around the person that are compared
_UNKNOWN = 0.1  # share of a pixel of the person without a range that speaks against a body there
# Numbers of a cone's image: column, row, radius, inverse range, bulge at both ends; in front.
COLUMNS = 11


@dataclass(frozen=True, eq=False)
class SeenPicture:
    """One view at one instant, thinned out."""

    measured: Float32Array  # (h, w), 1/metres. Inverse range; 0 where not known.
    person: FloatArray  # (h, w). 1 where the person is.
    left: float  # pixels, as `top`: place of the first pixel in the image
    top: float
    step: float  # pixels, distance to the next
    pinhole: FloatArray  # (3,)
    camera_from_world: FloatArray  # (3, 4)
    eye: FloatArray  # (3,), world
    scale: float  # disparity over inverse range

    def drawn(self, placed: PlacedCones) -> Float32Array:
        """Inverse ranges (h, w) of cones (C,); 0 where there are none."""
        return np.asarray(self.drawn_each(placed[None])[0])

    def drawn_each(self, placed: PlacedCones) -> Float32Array:
        """Inverse ranges (K, h, w) of cones in K poses (K, C), each by itself."""
        pictures = np.zeros((len(placed), *self.measured.shape), dtype=np.float32)
        box = self.left, self.top, self.step
        _draw_each(placed, self.camera_from_world, self.pinhole, self.eye, box, pictures)
        return pictures

    def unlike_pairs(
        self, rest: Float32Array, left: Float32Array, right: Float32Array, sigma: float
    ) -> FloatArray:
        """Pixels (K, L) in which bodies do not look as measured.

        `rest` (h, w) is trunk, head and legs as :meth:`drawn` draws them; of the arms `left`
        (K, h, w) and `right` (L, h, w) all pairs are taken. A difference of `sigma` pixels of
        disparity counts half.
        """
        pixels = np.empty((len(left), len(right)))
        as_seen = self.measured, self.person, self.scale
        _disagreements(rest, left, right, as_seen, sigma**2, pixels)
        return pixels

    def area(self, place: FloatArray) -> float:
        """Square metres that a pixel shows at a place (3,), world."""
        depth = float(self.camera_from_world[2, :3] @ place + self.camera_from_world[2, 3])
        return float((self.step * depth / self.pinhole[0]) ** 2)


def seen_pictures(cloud: Cloud, step: int) -> tuple[SeenPicture, ...]:
    """Pictures of the views in which somebody is, every `step`-th pixel."""
    for depth in cloud.depths.values():
        if step not in depth.thinned:
            depth.thinned[step] = _seen_picture(depth, step)
    found = (depth.thinned[step] for depth in cloud.depths.values())
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


def outline_cones(body: BodyModel, frames: PartFrames) -> PlacedCones:
    """The cones (..., C) in one pose or in stacked ones, as thick as their outlines are."""
    placed = placed_cones(body, frames)
    for end in ("r1", "r2"):
        placed[end] = np.maximum(placed[end] + placed["outline"][..., 0], 0.01)
    return placed


@compiled()
def cone_images(placed: Any, place: Any, pinhole: Any, eye: Any, images: Any) -> None:
    """Fill images (C, 11) of the cones `placed` (C,) in one view.

    `place` (3, 4) is camera_from_world, `pinhole` focal length and principal point, `eye` the
    camera's centre in the world.
    """
    for c in range(placed.shape[0]):
        cone, front = placed[c], 1.0
        R, s = cone.rotation, cone.flatness
        for end in range(2):
            height, r = cone.height * end, cone.r2 if end else cone.r1
            px, py = R[0, 2] * height + cone.origin[0], R[1, 2] * height + cone.origin[1]
            pz = R[2, 2] * height + cone.origin[2]
            a = place[0, 0] * px + place[0, 1] * py + place[0, 2] * pz + place[0, 3]
            b = place[1, 0] * px + place[1, 1] * py + place[1, 2] * pz + place[1, 3]
            z = place[2, 0] * px + place[2, 1] * py + place[2, 2] * pz + place[2, 3]
            if z < 0.3:
                front, z = 0.0, 0.3
            dx, dy, dz = eye[0] - px, eye[1] - py, eye[2] - pz
            wx = R[0, 0] * dx + R[1, 0] * dy + R[2, 0] * dz
            wy = R[0, 1] * dx + R[1, 1] * dy + R[2, 1] * dz
            norm = max(math.sqrt(wx * wx + wy * wy), 1e-9)
            wx, wy = wx / norm, wy / norm
            images[c, 5 * end] = pinhole[0] * a / z + pinhole[1]
            images[c, 5 * end + 1] = pinhole[0] * b / z + pinhole[2]
            images[c, 5 * end + 2] = pinhole[0] * r * math.sqrt(wy * wy + s * s * wx * wx) / z
            images[c, 5 * end + 3] = 1.0 / z
            images[c, 5 * end + 4] = r * math.sqrt(wx * wx + s * s * wy * wy)
        images[c, 10] = front


@compiled(inline="always")
def reached(im: Any, left: float, top: float, step: float, height: int, width: int) -> Any:
    """First and last row and column of a picture that a cone's image (11,) can reach."""
    most = max(im[2], im[7])
    i0 = max(0, math.ceil((min(im[1], im[6]) - most - top) / step))
    i1 = min(height - 1, math.floor((max(im[1], im[6]) + most - top) / step))
    j0 = max(0, math.ceil((min(im[0], im[5]) - most - left) / step))
    j1 = min(width - 1, math.floor((max(im[0], im[5]) + most - left) / step))
    return i0, i1, j0, j1


@compiled(inline="always")
def near_at(im: Any, column: float, line: float) -> Any:
    """Inverse range of a cone's front at a pixel; 0 beside it."""
    bx, by = im[5] - im[0], im[6] - im[1]
    u, v = column - im[0], line - im[1]
    t = min(1.0, max(0.0, (u * bx + v * by) / max(bx * bx + by * by, 1e-9)))
    r = im[2] + t * (im[7] - im[2])
    x, y = u - t * bx, v - t * by
    across = (x * x + y * y) / (r * r)
    if not across < 1.0:
        return 0.0
    axis, bulge = im[3] + t * (im[8] - im[3]), im[4] + t * (im[9] - im[4])
    return 1.0 / (1.0 / axis - bulge * math.sqrt(1.0 - across))


@compiled()
def _draw(images: Any, left: float, top: float, step: float, picture: Any) -> None:
    """Draw cones into a picture (h, w) of inverse ranges, nearer ones in front; 0 is nothing."""
    for c in range(images.shape[0]):
        im = images[c]
        if im[10] < 0.5:
            continue
        i0, i1, j0, j1 = reached(im, left, top, step, picture.shape[0], picture.shape[1])
        for i in range(i0, i1 + 1):
            for j in range(j0, j1 + 1):
                near = near_at(im, left + step * j, top + step * i)
                picture[i, j] = max(picture[i, j], near)


@compiled()
def _draw_each(placed: Any, place: Any, pinhole: Any, eye: Any, box: Any, pictures: Any) -> None:
    """Draw cones in K poses (K, C) into pictures (K, h, w); `box` is left, top and step."""
    images = np.empty((placed.shape[1], COLUMNS))
    for k in range(placed.shape[0]):
        cone_images(placed[k], place, pinhole, eye, images)
        _draw(images, box[0], box[1], box[2], pictures[k])


@compiled()
def _disagreements(
    rest: Any, left: Any, right: Any, as_seen: Any, squared_sigma: float, out_pixels: Any
) -> None:
    """Fill sums over the pixels; see :meth:`SeenPicture.unlike_pairs`."""
    measured, person, scale = as_seen
    for k in range(left.shape[0]):
        for m in range(right.shape[0]):
            total = 0.0
            for i in range(rest.shape[0]):
                for j in range(rest.shape[1]):
                    model = max(rest[i, j], left[k, i, j], right[m, i, j])
                    if model == 0.0:
                        total += person[i, j]
                    elif person[i, j] == 0:
                        total += 1.0
                    elif measured[i, j] > 0.0:
                        e = scale * (model - measured[i, j])
                        total += e * e / (e * e + squared_sigma)
                    else:
                        total += _UNKNOWN
            out_pixels[k, m] = total
