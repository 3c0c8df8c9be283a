"""What the views should see of a body, drawn coarsely and compared with what they saw."""

import math
from typing import Any, NamedTuple

import numpy as np

from stereotrack_core.arrays import Float32Array, FloatArray, Int8Array
from stereotrack_core.body.model import BodyModel, PlacedCones, placed_cones
from stereotrack_core.body.pose import PartFrames
from stereotrack_core.compiled import compiled
from stereotrack_core.depth.cloud import Cloud, ViewDepth

_AROUND = 25  # pixels around the person that are compared
_UNKNOWN = 0.1  # share of a pixel of the person without a range that speaks against a body there
# Numbers of a cone's image: column, row, radius, inverse range, bulge at both ends; in front.
_COLUMNS = 11


class SeenPicture(NamedTuple):
    """One view at one instant, thinned out; compiled loops take it as it is."""

    measured: Float32Array  # (h, w), 1/metres. Inverse range; 0 where not known.
    person: Int8Array  # (h, w). 1 where the person is.
    left: float  # pixels, as `top`: place of the first pixel in the image
    top: float
    step: float  # pixels, distance to the next
    pinhole: FloatArray  # (3,). Focal length and principal point, pixels.
    camera_from_world: FloatArray  # (3, 4)
    eye: FloatArray  # (3,), world
    scale: float  # disparity over inverse range

    def drawn(self, placed: PlacedCones) -> tuple[Float32Array, Int8Array]:
        """Inverse ranges (h, w) of cones (C,), 0 beside them, and parts in front, -1 for none."""
        picture = np.zeros(self.measured.shape, dtype=np.float32)
        owner = np.full(self.measured.shape, -1, dtype=np.int8)
        images = np.empty((len(placed), _COLUMNS))
        _project(placed, self, images)
        _draw(images, self, placed["part"], picture, owner)
        return picture, owner

    def unlike(
        self, rest: PlacedCones, left: PlacedCones, right: PlacedCones, sigma: float
    ) -> FloatArray:
        """Pixels (K, L) in which bodies do not look as measured.

        `rest` (C,) are cones of trunk, head and legs; of the arms `left` (K, A) and `right` (L, B)
        all pairs are taken. A difference of `sigma` pixels of disparity counts half.
        """
        pixels = np.empty((len(left), len(right)))
        _disagreements(self, rest, left, right, sigma**2, pixels)
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
    to_camera = g.world_from_depth.inverse()
    return SeenPicture(
        measured=np.divide(1.0, ranges, out=np.zeros_like(ranges), where=ranges > 0.0),
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
def _project(placed: Any, seen: Any, images: Any) -> None:
    """Fill images (C, 11) of the cones `placed` (C,) in one view."""
    place, pinhole, eye = seen.camera_from_world, seen.pinhole, seen.eye
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
def _reached(im: Any, seen: Any) -> Any:
    """First and last row and column of a picture that a cone's image (11,) can reach."""
    height, width = seen.measured.shape
    most = max(im[2], im[7])
    i0 = max(0, math.ceil((min(im[1], im[6]) - most - seen.top) / seen.step))
    i1 = min(height - 1, math.floor((max(im[1], im[6]) + most - seen.top) / seen.step))
    j0 = max(0, math.ceil((min(im[0], im[5]) - most - seen.left) / seen.step))
    j1 = min(width - 1, math.floor((max(im[0], im[5]) + most - seen.left) / seen.step))
    return i0, i1, j0, j1


@compiled(inline="always")
def _near_at(im: Any, column: float, line: float) -> Any:
    """Inverse range of a cone's front at a pixel; 0 beside it."""
    bx, by = im[5] - im[0], im[6] - im[1]
    u, v = column - im[0], line - im[1]
    t = min(1.0, max(0.0, (u * bx + v * by) / max(bx * bx + by * by, 1e-9)))
    r = im[2] + t * (im[7] - im[2])
    x, y = u - t * bx, v - t * by
    away, squared_radius = x * x + y * y, r * r
    if not away < squared_radius:
        return 0.0
    across = away / squared_radius
    axis, bulge = im[3] + t * (im[8] - im[3]), im[4] + t * (im[9] - im[4])
    return 1.0 / (1.0 / axis - bulge * math.sqrt(1.0 - across))


@compiled()
def _draw(images: Any, seen: Any, part: Any, out_picture: Any, out_owner: Any) -> None:
    """Draw cones into a picture (h, w) of inverse ranges, nearer ones in front; 0 is nothing.

    If they are given, the `part` (C,) that is in front becomes the pixel's owner (h, w).
    """
    for c in range(images.shape[0]):
        im = images[c]
        if im[10] < 0.5:
            continue
        i0, i1, j0, j1 = _reached(im, seen)
        for i in range(i0, i1 + 1):
            for j in range(j0, j1 + 1):
                near = _near_at(im, seen.left + seen.step * j, seen.top + seen.step * i)
                if near > out_picture[i, j]:
                    out_picture[i, j] = near
                    if part is not None:
                        out_owner[i, j] = part[c]


@compiled()
def _draw_with(rest: Any, arms: Any, seen: Any, squared_sigma: float, pictures: Any) -> Any:
    """Draw arms in K poses (K, A) over copies (K, h, w) of a picture; return pixels' costs."""
    images, costs = np.empty((arms.shape[1], _COLUMNS)), np.empty(pictures.shape)
    for k in range(arms.shape[0]):
        pictures[k] = rest
        _project(arms[k], seen, images)
        _draw(images, seen, None, pictures[k], None)
        for i in range(rest.shape[0]):
            for j in range(rest.shape[1]):
                model, known = pictures[k, i, j], seen.measured[i, j]
                if model == 0.0:
                    costs[k, i, j] = seen.person[i, j]
                elif seen.person[i, j] == 0:
                    costs[k, i, j] = 1.0
                elif known > 0.0:
                    e = seen.scale * (model - known)
                    costs[k, i, j] = e * e / (e * e + squared_sigma)
                else:
                    costs[k, i, j] = _UNKNOWN
    return costs


@compiled()
def _disagreements(
    seen: Any, rest: Any, left: Any, right: Any, squared_sigma: float, out_pixels: Any
) -> None:
    """Fill sums over the pixels; see :meth:`SeenPicture.unlike`."""
    height, width = seen.measured.shape
    images, behind = np.empty((rest.shape[0], _COLUMNS)), np.zeros((height, width), np.float32)
    _project(rest, seen, images)
    _draw(images, seen, None, behind, None)
    one = np.empty((left.shape[0], height, width), np.float32)
    other = np.empty((right.shape[0], height, width), np.float32)
    one_costs = _draw_with(behind, left, seen, squared_sigma, one)
    other_costs = _draw_with(behind, right, seen, squared_sigma, other)
    # A pixel shows the nearer arm, so that each pair takes pixels of both. The pairs of an arm are
    # summed up side by side, which the processor does for several at once.
    other = np.ascontiguousarray(other.transpose(1, 2, 0))
    other_costs = np.ascontiguousarray(other_costs.transpose(1, 2, 0))
    out_pixels[:] = 0.0
    for k in range(left.shape[0]):
        for i in range(height):
            for j in range(width):
                near, cost = one[k, i, j], one_costs[k, i, j]
                for m in range(right.shape[0]):
                    nearer = near >= other[i, j, m]
                    out_pixels[k, m] += cost if nearer else other_costs[i, j, m]
