"""Signs by which a pose can be judged without truth (docs/method.md 4.6)."""

from __future__ import annotations

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel, placed_cones
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.body.surface import nearest_on_surface

UNEXPLAINED_SCALE = 0.05
"""Metres from the model at which a datum counts as half unexplained."""

_MOST_POINTS = 1500


def unexplained_fraction_of(points: FloatArray, body: BodyModel, frames: PartFrames) -> float:
    """Share of the cloud that the model leaves unexplained: mean of d^2 / (d^2 + 50 mm^2).

    Parameters
    ----------
    points : (N, 3) float64, world
        The cloud; evenly thinned out where it is large.
    body : BodyModel
    frames : PartFrames
        Of one pose.
    """
    thin = points[:: max(1, len(points) // _MOST_POINTS)]
    feet = nearest_on_surface(thin, placed_cones(body, frames), np.inf)
    return unexplained_fraction(feet.distance)


def surface_distances(points: FloatArray, body: BodyModel, pose: Pose) -> FloatArray:
    """Signed distances (N,) of points (N, 3), world, from the body in a pose."""
    return nearest_on_surface(points, placed_cones(body, body.frames(pose)), np.inf).distance


def unexplained_fraction(distance: FloatArray) -> float:
    """Mean of d^2 / (d^2 + 50 mm^2) over signed distances (N,); infinite ones count 1."""
    if not len(distance):
        return float("nan")
    squared = np.minimum(distance, 1e3) ** 2
    return float(np.mean(squared / (squared + UNEXPLAINED_SCALE**2)))
