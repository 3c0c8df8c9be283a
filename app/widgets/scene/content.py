"""What the 3-D scene shows at one instant."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from stereotrack_core.arrays import FloatArray, ImageArray
from stereotrack_core.body.mesh import PartMesh
from stereotrack_core.geometry.camera import Camera

from ...session.drawn import GhostBody, InsideScene
from ...session.runs import RunStyle

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
    run: str = ""
    ghosts: tuple[GhostBody, ...] = ()
    floor_z: float = 0.0  # Metres. Height of the floor in the world.
    inside: InsideScene | None = None

    @property
    def runs(self) -> tuple[tuple[str, RunStyle], ...]:
        """All runs that are drawn, the active one first; empty where it is alone."""
        others = tuple((ghost.name, ghost.style) for ghost in self.ghosts)
        return ((self.run, "solid"), *others) if others and self.meshes else others

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
