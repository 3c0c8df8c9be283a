"""The fused point cloud, the depth images it came from, and whether they agree."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import cv2
import numpy as np

from stereotrack_core.arrays import BoolArray, Float32Array, FloatArray, ImageArray, IntArray
from stereotrack_core.depth.edges import EdgeMap, edge_map
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.detections import Detection
from stereotrack_core.recording.sighted_keypoints import SightedKeypoints

_DEPTH_CAMERA_SCALE = 75.0
"""Focal length times base line (pixels, metres) of the stereo camera whose uncertainty of range
a depth camera is taken to have."""


_SPECKS = np.ones((5, 5), np.uint8)
"""What is smaller than this many pixels is nobody."""


@dataclass(frozen=True, eq=False)
class DepthGeometry:
    """The undistorted, rectified pinhole of a view's depth image.

    A point (x, y, z) in this camera appears at u = focal x / z + c_x, v = focal y / z + c_y.
    For stereo views its disparity is d = focal baseline / z + disparity_offset, where the
    offset is c_x,left - c_x,right (2.1); a depth view has baseline 0.
    """

    focal: float
    """Pixels."""
    c_x: float
    c_y: float
    """`c_x` and `c_y`: pixels."""
    baseline: float
    """Metres."""
    disparity_offset: float
    """Pixels."""
    width: int
    height: int
    world_from_depth: RigidTransform
    """Place of the rectified camera in the world."""

    @property
    def disparity_scale(self) -> float:
        """Disparity over inverse range, pixels times metres.

        A depth camera is taken to be as uncertain of its ranges as a usual stereo camera.
        """
        return self.focal * self.baseline if self.baseline > 0 else _DEPTH_CAMERA_SCALE

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
    disparity: Float32Array | None
    """(H, W), pixels. NaN where invalid; None for depth views."""
    range_z: Float32Array
    """(H, W), metres. Along the rectified camera's z, NaN where not known."""
    foreground: BoolArray
    """(H, W). Valid and in front of the background model."""
    silhouette: BoolArray | None = None
    """(H, W). Where the picture differs from the empty scene's, generously; None where that is not
    known."""
    outline: BoolArray | None = None
    """(H, W). The same with sharp edges, for those who measure them."""
    picture: ImageArray | None = None
    """(H, W, 3). The reference picture, rectified, BGR; None where colours are not wanted or not
    there."""

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

    measured: int = 0
    """Pixels with a valid disparity or depth value, in the part of the image that was searched."""
    person: int = 0
    """Of these, those of the foreground or the mask, without small patches."""
    taken: int = 0
    """Points that were made of these: on every so many rows and columns."""
    inside: int = 0
    """Of these, those inside the working volume."""
    kept: int = 0
    """Of these, those that are no outliers."""
    middle: tuple[float, float, float] | None = None
    """(x, y, z). Median of the points, world, metres, where hardly any is inside the volume."""
    noise: float = 0.0
    """Grey levels. Standard deviation of the noise of a stereo view's picture."""
    blur: float = 0.0
    """Pixels. Standard deviation of the blur that the picture has more than the empty scene's."""


@dataclass(frozen=True, eq=False)
class Cloud:
    """Measured points of all views in the world at one instant."""

    frame: int
    points: FloatArray
    """(N, 3), world, metres. Inside the working volume, outliers removed."""
    view: IntArray
    """(N,). Index into `view_names`."""
    pixels: IntArray
    """(N, 2). Column and row in the view's rectified depth image."""
    view_names: tuple[str, ...]
    depths: Mapping[str, ViewDepth]
    """By view name. Views without a measurement at this instant are
    absent."""
    problems: Mapping[str, str] = field(default_factory=dict)
    """By view name. Why a view is absent or suspicious, as a sentence."""
    seconds: Mapping[str, float] = field(default_factory=dict)
    """By stage name."""
    colours: FloatArray | None = None
    """(N, 3). Of the points, BGR from 0 to 255; None where colours are not wanted or not there."""
    detections: tuple[Detection, ...] = ()
    """What came since the frame before, up to this one's instant."""
    keypoints: SightedKeypoints | None = None
    """What a 2-D detector has predicted of this instant; None where nothing is known of any."""
    clicks: tuple[Detection, ...] = ()
    """Landmarks that a person clicked in this frame's pictures."""
    counts: Mapping[str, PointCounts] = field(default_factory=dict)
    """By view name. Where each view's points went; views without images
    are absent."""

    def part(self, chosen: BoolArray) -> Cloud:
        """The cloud with some of its points (N,) alone; images and the rest stay."""
        return replace(
            self,
            points=self.points[chosen],
            view=self.view[chosen],
            pixels=self.pixels[chosen],
            colours=None if self.colours is None else self.colours[chosen],
        )


FRAMES_APART = 5
"""Of so many frames one is asked, which is enough for a calibration."""

_HALO = 9
"""Pixels in an image 640 wide by which a person may be wider than another view's points say."""

_WIDTH = 640

_BEHIND = 0.15
"""Metres by which the background has to be behind a point; what is nearer may be an occluder."""

_EVERY = 7
"""Points of which one is asked for."""

_FEWEST = 20
"""Points of other views without which a view is not asked."""


def contradicted_share(cloud: Cloud) -> float:
    """Share of the points that another view sees through, mean over the views that are asked.

    NaN where there are no two views, or too few points. Pixels without a depth prove nothing.
    """
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
