"""Distances of measured points from the surface (docs/method.md 4.1, 4.2 and 4.6)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.manifold import SURFACE, Rows, rows_of
from stereotrack_core.body.model import BodyModel, placed_cones
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.body.surface import ClosestPoints, nearest_on_surface, parts_of_cones
from stereotrack_core.tracking.estimate import Correspondences
from stereotrack_core.tracking.parameters import TrackingParameters

UNEXPLAINED_SCALE = 0.05  # metres from the model at which a datum counts as half unexplained
FIRST_LOSS = 2.0  # factor on the scale of the loss in the first iterations


def surface_distances(points: FloatArray, body: BodyModel, pose: Pose) -> FloatArray:
    """Signed distances (N,) of points (N, 3), world, from the body in a pose."""
    return nearest_on_surface(points, placed_cones(body, body.frames(pose)), np.inf).distance


def unexplained_fraction(distance: FloatArray) -> float:
    """Mean of d^2 / (d^2 + 50 mm^2) over signed distances (N,); infinite ones count 1."""
    if not len(distance):
        return float("nan")
    squared = np.minimum(distance, 1e3) ** 2
    return float(np.mean(squared / (squared + UNEXPLAINED_SCALE**2)))


@dataclass(frozen=True, eq=False)
class SurfaceResidual:
    """Signed distances of data from the surface; closest points move rigidly with their parts."""

    data: FloatArray  # (m, 3), world. Sorted by part.
    part: IntArray  # (m,)
    point: FloatArray  # (m, 3), world
    direction: FloatArray  # (m, 3), world. Along which the distance is measured, held fixed.
    distance: FloatArray  # (m,), metres
    variance: FloatArray  # (m,), square metres
    weight: FloatArray  # (m,)
    frames: PartFrames  # frames of the pose at which the data were paired
    kind: int = SURFACE

    @property
    def point_in_part(self) -> FloatArray:
        """The points (m, 3) in the frames of their parts."""
        return self.frames.local(self.part, self.point)

    @property
    def measured(self) -> FloatArray:
        """The data on their directions (m,): z = n . p."""
        return np.asarray(np.einsum("mi,mi->m", self.direction, self.data))

    def pairs(self) -> Correspondences:
        """What is compared with what."""
        sigma = np.sqrt(self.variance)
        return Correspondences(
            self.part, self.data, self.point, self.direction, self.distance, sigma, self.weight
        )

    def rows(self, frames: PartFrames) -> Rows:  # noqa: ARG002 - paired at the same pose
        """Distances, linearised where the data were paired."""
        off = self.distance, self.variance
        return rows_of(self.kind, self.part, self.point, self.direction, off)

    def predicted(self, frames: PartFrames) -> FloatArray:
        """The closest points on the same directions (S, m) for stacked poses: z_hat = n . p(x)."""
        points = frames.apply(self.part, self.point_in_part)
        return np.asarray(np.einsum("mi,...mi->...m", self.direction, points))


@dataclass(frozen=True)
class Trust:
    """How data are weighted."""

    reach: float  # Metres. Data farther from the model belong to nothing.
    scale: float  # Metres. Distance at which the weight has fallen to a quarter.
    sigma: float  # Metres. Standard deviation of one independent measurement.
    effective: float  # independent measurements in the data

    @staticmethod
    def of(p: TrackingParameters, *, wide: bool = False) -> Trust:
        """As the parameters state it; `wide`: weights fall off slowly, as at first."""
        scale = p.loss_scale * (FIRST_LOSS if wide else 1.0)
        reach = p.max_correspondence_distance
        return Trust(reach, scale, p.sigma_measurement, p.effective_sample_size)


def surface_residual(
    data: FloatArray,
    body: BodyModel,
    frames: PartFrames,
    trust: Trust,
    penalty: FloatArray | None = None,
) -> SurfaceResidual:
    """Give every datum (N, 3), world, to the nearest cone of one pose and weigh it.

    Weights are w = (g^2 / (g^2 + e^2))^2 and variances sigma^2 (m / N_eff) / w: neighbouring pixels
    of a block matcher are one measurement, not many. For `penalty` see :func:`nearest_on_surface`.
    """
    closest = nearest_on_surface(data, placed_cones(body, frames), trust.reach, penalty)
    return residual_of_closest(data, parts_of_cones(body, closest.cone), closest, frames, trust)


def residual_of_closest(
    data: FloatArray, part: IntArray, closest: ClosestPoints, frames: PartFrames, trust: Trust
) -> SurfaceResidual:
    """Residual of data whose closest points are known; data with part -1 are left out."""
    order = np.argsort(part.astype(np.int8), kind="stable")  # eight bits are sorted by radix
    order = order[np.count_nonzero(part < 0) :]
    e = closest.distance.take(order)
    squared = trust.scale**2
    weight = (squared / (squared + e**2)) ** 2
    crowd = max(1.0, len(data) / trust.effective)
    return SurfaceResidual(
        data=data.take(order, axis=0),
        part=part.take(order),
        point=closest.point.take(order, axis=0),
        direction=closest.direction.take(order, axis=0),
        distance=e,
        variance=trust.sigma**2 * crowd / np.maximum(weight, 1e-6),
        weight=weight,
        frames=frames,
    )
