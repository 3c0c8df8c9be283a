"""Content of the 3-D scene at one instant, and the eye that circles around it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from stereotrack_core.arrays import FloatArray, ImageArray
from stereotrack_core.body.mesh import PartMesh
from stereotrack_core.geometry.camera import Camera

from ...session.view_state import GhostBody, InsideScene

LAYERS: tuple[str, ...] = ("cloud", "model", "reference", "cameras", "ellipsoids", "floor")

FLOOR_HALF = 3.0  # metres from the origin to the edges of the floor
NORTH_TIP = FLOOR_HALF + 0.5  # metres from the origin to the tip of the arrow to the north


@dataclass(frozen=True)
class PointLegend:
    """What the colours of the measured points mean."""

    title: str
    entries: tuple[tuple[str, tuple[int, int, int]], ...]
    """Words with red, green and blue, 0 to 255."""


@dataclass(frozen=True, eq=False)
class Ellipsoid:
    """Where a limb's end is to be found, by the tracker's own covariance."""

    limb: str
    centre: FloatArray  # (3,) float64, world, metres
    covariance: FloatArray
    """(3, 3) float64, world, square metres. Drawn at two standard deviations."""


@dataclass(frozen=True, eq=False)
class SceneContent:
    """Everything that the scene draws; arrays are not changed after they were handed on."""

    cloud_points: FloatArray = field(default_factory=lambda: np.empty((0, 3)))
    """(N, 3) float64, world, metres."""
    cloud_colours: ImageArray = field(default_factory=lambda: np.empty((0, 3), np.uint8))
    """(N, 3) uint8. By view, limb or residual, as the caller chose."""
    point_legend: PointLegend | None = None
    meshes: tuple[PartMesh, ...] = ()
    reference: FloatArray | None = None
    """(9, 3) float64, world, metres, or None. Landmarks of the reference; NaN where not known."""
    reference_is_old: bool = False
    cameras: tuple[Camera, ...] = ()
    camera_images: Mapping[str, ImageArray] = field(default_factory=dict)
    """Mapping from camera name to (H, W) or (H, W, 3) uint8. Grey or RGB; shown on the frusta.
    Small ones: they are handed on to OpenGL as they are."""
    cameras_before: tuple[Camera, ...] = ()  # cameras of another calibration, drawn fainter
    boards: tuple[FloatArray, ...] = ()
    """(4, 3) float64, world, metres. Corners of calibration boards, around each."""
    highlighted: str = ""
    ellipsoids: tuple[Ellipsoid, ...] = ()
    ghosts: tuple[GhostBody, ...] = ()
    inside: InsideScene | None = None

    def parts_known(self) -> int:
        """How many kinds of things are there that a view of the scene has to hold."""
        body = bool(self.meshes) or self.reference is not None
        return bool(self.cameras) + bool(len(self.cloud_points)) + body

    def body_points(self) -> FloatArray:
        """Points (K, 3) that a view of the scene has to hold; cameras only if nothing else."""
        parts = [mesh.vertices for mesh in self.meshes]
        if self.reference is not None:
            parts.append(self.reference)
        if len(self.cloud_points):
            # the farthest points are often no part of the person
            ends = np.percentile(self.cloud_points, (2.0, 98.0), axis=0)
            parts.append(np.stack(np.meshgrid(*ends.T), axis=-1).reshape(-1, 3))
        parts += self.boards
        if self.boards or not parts:
            parts += [camera.position_world[None] for camera in self.cameras]
        points: FloatArray = np.concatenate([np.empty((0, 3)), *parts])
        return points[np.isfinite(points).all(axis=1)]


_FRUSTUM_SHARE, _FRUSTUM_DEEPEST = 0.12, 0.45


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


FIELD_OF_VIEW = np.radians(32.0)
_CLOSEST, _FARTHEST = 0.15, 60.0
_STEEPEST = np.pi / 2
_MARGIN = 1.12
_LEAST_DISTANCE = 1.0


@dataclass(frozen=True, eq=False)
class Orbit:
    """Where the eye is; z is up in the world."""

    focus: FloatArray  # (3,) float64, world, metres. The point that is looked at.
    azimuth: float
    elevation: float
    """`azimuth` and `elevation`: radians. Direction from the focus to the eye; azimuth 0 is east, a
    quarter turn is north."""
    distance: float  # metres

    @property
    def toward_eye(self) -> FloatArray:
        """Unit vector (3,) from the focus to the eye."""
        return self._along(np.cos(self.elevation), np.sin(self.elevation))

    @property
    def eye(self) -> FloatArray:
        """Place of the eye (3,), world, metres."""
        return self.focus + self.distance * self.toward_eye

    @property
    def up(self) -> FloatArray:
        """Unit vector (3,) that points up in the picture; defined from above as well."""
        return self._along(-np.sin(self.elevation), np.cos(self.elevation))

    def _along(self, flat: float, up: float) -> FloatArray:
        return np.array([flat * np.cos(self.azimuth), flat * np.sin(self.azimuth), up])

    @property
    def right(self) -> FloatArray:
        """Unit vector (3,) that points right in the picture."""
        return np.array([-np.sin(self.azimuth), np.cos(self.azimuth), 0.0])

    def turned(self, right: float, up: float) -> Orbit:
        """Return the eye after circling by angles in radians; it stops above and below."""
        elevation = float(np.clip(self.elevation + up, -_STEEPEST, _STEEPEST))
        return replace(self, azimuth=self.azimuth + right, elevation=elevation)

    def moved(self, right: float, up: float) -> Orbit:
        """Return the eye after moving sideways by shares of the picture's height."""
        metres = 2.0 * self.distance * np.tan(FIELD_OF_VIEW / 2)
        return replace(self, focus=self.focus + metres * (right * self.right + up * self.up))

    def zoomed(self, factor: float) -> Orbit:
        """Return the eye `factor` times as near, within sensible limits."""
        distance = float(np.clip(self.distance / factor, _CLOSEST, _FARTHEST))
        return replace(self, distance=distance)

    def project(self, points: FloatArray, width: float, height: float) -> FloatArray:
        """Picture positions (K, 2) of world points (K, 3); NaN behind the eye."""
        relative = np.asarray(points, dtype=np.float64).reshape(-1, 3) - self.eye
        depth = -relative @ self.toward_eye
        depth = np.where(depth > 1e-3, depth, np.nan)
        flat = relative @ np.column_stack([self.right, -self.up]) / depth[:, None]
        scale = height / 2 / np.tan(FIELD_OF_VIEW / 2)
        places: FloatArray = (width / 2, height / 2) + scale * flat
        return places

    def ray(self, x: float, y: float, width: float, height: float) -> FloatArray:
        """Direction (3,), not normalised, from the eye through a position in the picture."""
        slope = np.tan(FIELD_OF_VIEW / 2) / (height / 2)
        aside = (x - width / 2) * self.right + (height / 2 - y) * self.up
        ray: FloatArray = slope * aside - self.toward_eye
        return ray


STANDARD_VIEWS: dict[str, tuple[float, float]] = {
    "home": (np.radians(60.0), np.radians(14.0)),
    "front": (np.pi / 2, 0.0),
    "side": (0.0, 0.0),
    "top": (-np.pi / 2, np.pi / 2),
}
"""Azimuth and elevation; a person in the initial pose faces north, so front is from there."""


def orbit_around(points: FloatArray, view: str, aspect: float = 1.0) -> Orbit:
    """Return the `view`, of :data:`STANDARD_VIEWS`, from which all world `points` (K, 3) are seen.

    Without points a person's place at the origin is looked at; `aspect` is the picture's width over
    its height.
    """
    azimuth, elevation = STANDARD_VIEWS[view]
    if not len(points):
        points = np.array([[-0.9, -0.9, 0.0], [0.9, 0.9, 1.9]])
    orbit = Orbit(points.mean(axis=0), azimuth, elevation, 1.0)
    relative = points - orbit.focus
    axes = np.stack([orbit.right, orbit.up])
    flat = relative @ axes.T
    middle = 0.5 * (flat.min(axis=0) + flat.max(axis=0))
    focus = orbit.focus + middle @ axes
    # a point is seen where it stands aside by no more than the opening at its own depth
    slope = np.tan(FIELD_OF_VIEW / 2)
    aside = (np.abs(flat - middle) / (max(aspect, 0.3), 1.0)).max(axis=1)
    distance = float(np.max(relative @ orbit.toward_eye + _MARGIN * aside / slope))
    return Orbit(focus, azimuth, elevation, max(distance, _LEAST_DISTANCE))
