"""The fused point cloud, the depth images it came from, and whether they agree."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import cv2
import numpy as np

from stereotrack_core.arrays import BoolArray, Float32Array, FloatArray, ImageArray, IntArray
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.detections import Detection
from stereotrack_core.recording.sighted_keypoints import SightedKeypoints

_DEPTH_CAMERA_SCALE = 75.0  # focal length x baseline (px m) that depth cameras count as

_SPECKS = np.ones((5, 5), np.uint8)  # what is smaller than this many pixels is nobody


@dataclass(frozen=True, eq=False)
class DepthGeometry:
    """The undistorted, rectified pinhole of a view's depth image.

    A point (x, y, z) of this camera appears at u = focal x / z + c_x, v = focal y / z + c_y, in
    stereo views with disparity d = focal baseline / z + disparity_offset, the offset being c_x,left
    - c_x,right (2.1). A depth view has baseline 0.
    """

    focal: float  # pixels
    c_x: float
    c_y: float  # `c_x` and `c_y`: pixels
    baseline: float  # metres
    disparity_offset: float  # pixels
    width: int
    height: int
    world_from_depth: RigidTransform  # place of the rectified camera in the world

    @property
    def disparity_scale(self) -> float:
        """Disparity over inverse range, px m; a depth camera counts as a usual stereo camera."""
        return self.focal * self.baseline if self.baseline > 0 else _DEPTH_CAMERA_SCALE

    def disparity_at(self, ranges: Float32Array) -> Float32Array:
        """Disparity of a pair, pixels, at ranges z, metres."""
        return np.float32(self.focal * self.baseline) / ranges + np.float32(self.disparity_offset)

    def project(self, points: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Columns, rows and ranges z of points (N, 3), world; without sense where z <= 0."""
        x, y, z = self.world_from_depth.inverse().apply(points).T
        return self.focal * x / z + self.c_x, self.focal * y / z + self.c_y, z

    def points(
        self, u: FloatArray | IntArray, v: FloatArray | IntArray, z: FloatArray
    ) -> FloatArray:
        """Points (N, 3), world, metres, of pixels (u, v) with their ranges z, (2.2) and (2.3)."""
        x, y = (u - self.c_x) / self.focal * z, (v - self.c_y) / self.focal * z
        return self.world_from_depth.apply(np.stack([x, y, z], axis=1))


@dataclass(frozen=True, eq=False)
class ViewDepth:
    """Depth of one view at one instant."""

    geometry: DepthGeometry
    range_z: Float32Array  # (H, W), metres. Along the rectified camera's z, NaN where not known.
    foreground: BoolArray  # (H, W). Valid and in front of the background model.
    silhouette: BoolArray | None = None  # (H, W). Generously, what differs from the empty scene
    outline: BoolArray | None = None  # (H, W). The same with sharp edges, to be measured
    picture: ImageArray | None = None  # (H, W, 3). Rectified, BGR; None without colours

    @property
    def disparity(self) -> Float32Array | None:
        """Disparity (H, W), pixels, NaN where not known; None for depth views."""
        return self.geometry.disparity_at(self.range_z) if self.geometry.baseline > 0 else None

    @property
    def person(self) -> BoolArray:
        """Pixels (H, W) of the person: the outline where it is known."""
        return self.foreground if self.outline is None else self.outline

    @cached_property
    def extent(self) -> tuple[int, int, int, int] | None:
        """Left, top, right and bottom, half-open, of the person without specks; None: nobody."""
        left, top, width, height = cv2.boundingRect(cv2.erode(self.person.view(np.uint8), _SPECKS))
        return (left, top, left + width, top + height) if width else None

    @cached_property
    def edges(self) -> EdgeMap | None:
        """Signed distances from the outline, measured once; None without a person's outline."""
        if self.outline is None:
            return None
        g = self.geometry
        camera_from_world = g.world_from_depth.inverse().matrix()[:3]
        return edge_map(self.outline, self.range_z, (g.focal, g.c_x, g.c_y), camera_from_world)

    @cached_property
    def thinned(self) -> dict[int, Any]:
        """Pictures that others have thinned out of this view, by their step in pixels."""
        return {}


@dataclass(frozen=True)
class PointCounts:
    """What is left of a view's measurements after each step on the way to the cloud."""

    measured: int = 0  # pixels with a valid disparity or depth, in the part searched
    person: int = 0  # of these, those of the foreground or the mask, without small patches
    taken: int = 0  # points that were made of these: on every so many rows and columns
    inside: int = 0  # of these, those inside the working volume
    kept: int = 0  # of these, those that are no outliers
    # Median of the points, world, metres, where hardly any is inside the volume.
    middle: tuple[float, float, float] | None = None
    noise: float = 0.0  # grey levels, standard deviation of a stereo view's picture
    blur: float = 0.0  # pixels, standard deviation against the empty scene's picture


@dataclass(frozen=True, eq=False)
class Cloud:
    """Measured points of all views in the world at one instant."""

    frame: int
    points: FloatArray  # (N, 3), world, metres. Inside the working volume, outliers removed.
    view: IntArray  # (N,). Index into `view_names`.
    pixels: IntArray  # (N, 2). Column and row in the view's rectified depth image.
    view_names: tuple[str, ...]
    depths: Mapping[str, ViewDepth]  # by view name, without those that measured nothing
    # By view name: why a view is absent or suspicious, as a sentence.
    problems: Mapping[str, str] = field(default_factory=dict)
    seconds: Mapping[str, float] = field(default_factory=dict)  # by stage name
    colours: FloatArray | None = None  # (N, 3), BGR, 0 to 255; None without colours
    detections: tuple[Detection, ...] = ()  # since the frame before, up to this one
    keypoints: SightedKeypoints | None = None  # predicted by a 2-D detector for this frame
    clicks: tuple[Detection, ...] = ()  # landmarks that a person clicked in this frame's pictures
    counts: Mapping[str, PointCounts] = field(default_factory=dict)  # by view

    def part(self, chosen: BoolArray) -> Cloud:
        """The cloud with some of its points (N,) alone; images and the rest stay."""
        return replace(
            self,
            points=self.points[chosen],
            view=self.view[chosen],
            pixels=self.pixels[chosen],
            colours=None if self.colours is None else self.colours[chosen],
        )


FRAMES_APART = 5  # of so many frames one is asked, which is enough for a calibration
_HALO = 9  # pixels (of 640) by which a person may be wider than another view's points say
_WIDTH = 640
_BEHIND = 0.15  # metres of the background behind a point; nearer it may be an occluder
_EVERY = 7  # points of which one is asked for
_FEWEST = 20  # points of other views without which a view is not asked


def contradicted_share(cloud: Cloud) -> float:
    """Share of points that other views see through, mean over these; NaN with too few of either."""
    shares = []
    for place, name in enumerate(cloud.view_names):
        depth = cloud.depths.get(name)
        if depth is None:
            continue
        through = seen_through(depth, cloud.points[cloud.view != place][::_EVERY])
        if through is not None:
            shares.append(through)
    return float(np.mean(shares)) if shares else float("nan")


def seen_through(depth: ViewDepth, points: FloatArray) -> float | None:
    """Share of other views' points (N, 3) behind which a view sees the background."""
    geometry = depth.geometry
    with np.errstate(divide="ignore", invalid="ignore"):
        u, v, z = geometry.project(points)
    ahead = z > 0.0
    column, row, z = np.rint(u[ahead]), np.rint(v[ahead]), z[ahead]
    inside = (column >= 0) & (column < geometry.width) & (row >= 0) & (row < geometry.height)
    pixel = row[inside].astype(np.int64), column[inside].astype(np.int64)
    margin = max(1, round(_HALO * geometry.width / _WIDTH))
    kernel = np.ones((2 * margin + 1, 2 * margin + 1), np.uint8)
    person = cv2.dilate(depth.person.view(np.uint8), kernel)[pixel] > 0
    seen = depth.range_z[pixel]
    asked = person | np.isfinite(seen)
    if np.count_nonzero(asked) < _FEWEST:
        return None
    through = ~person & (seen > z[inside] + _BEHIND)
    return float(np.mean(through[asked]))


def colours_of(
    views: Sequence[str], depths: Mapping[str, ViewDepth], view: IntArray, pixels: IntArray
) -> FloatArray | None:
    """Colours (N, 3) at pixels (N, 2) of views (N,), BGR 0 to 255, means of 3 x 3 pixels; or None.

    Cameras are not matched to each other: gains differ by up to 14 %, shirt and arm by more.
    """
    pictures = {name: d.picture for name, d in depths.items() if d.picture is not None}
    if not pictures:
        return None
    colours = np.full((len(view), 3), np.nan)
    for name, picture in pictures.items():
        u, v = pixels[of_view := view == views.index(name)].T
        colours[of_view] = cv2.blur(picture, (3, 3))[v, u]
    return colours


_LEAST_PATCH = 150  # pixels below which a patch of the silhouette is noise
_AROUND = 32  # pixels around a silhouette in which outlines are still measured


@dataclass(frozen=True, eq=False)
class EdgeMap:
    """Distances from the silhouette's edge in one view, around the person."""

    distance: Float32Array  # (h, w), pixels. Positive outside of the silhouette, negative inside.
    range_z: Float32Array  # (h, w), metres. NaN where not known.
    pinhole: FloatArray  # (5,). Focal length, principal point, column and row of the first pixel
    camera_from_world: FloatArray  # (3, 4). Rotation and translation.


def edge_map(
    outline: BoolArray,
    range_z: Float32Array,
    lens: tuple[float, float, float],
    camera_from_world: FloatArray,
) -> EdgeMap | None:
    """Edge of an outline (H, W), or None; `lens`: focal length and principal point, pixels."""
    left, top, width, height = cv2.boundingRect(outline.view(np.uint8))
    patches = outline[top : top + height, left : left + width].astype(np.uint8)
    cv2.filterSpeckles(patches, 0, _LEAST_PATCH - 1, 0)
    column, row, width, height = cv2.boundingRect(patches)
    if not width:
        return None
    person = patches[row : row + height, column : column + width]
    left, top = left + column, top + row
    before, above = min(_AROUND, left), min(_AROUND, top)
    after = min(_AROUND, outline.shape[1] - left - width)
    below = min(_AROUND, outline.shape[0] - top - height)
    left, top = left - before, top - above
    inside = cv2.copyMakeBorder(person, above, below, before, after, cv2.BORDER_CONSTANT)
    outward = cv2.distanceTransform(1 - inside, cv2.DIST_L2, 5)
    inward = cv2.distanceTransform(inside, cv2.DIST_L2, 5)
    # Both count to the middle of a pixel on the other side; the edge runs half a pixel before it.
    distance = outward - inward - (0.5 - inside.astype(np.float32))
    height, width = distance.shape
    return EdgeMap(
        distance=distance.astype(np.float32, copy=False),
        range_z=np.ascontiguousarray(range_z[top : top + height, left : left + width]),
        pinhole=np.array([*lens, left, top], dtype=np.float64),
        camera_from_world=camera_from_world,
    )
