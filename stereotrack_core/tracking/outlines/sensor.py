"""Outlines as a sensor: residuals of the same kind as those of the cloud's points.

Block matching widens thin limbs and pulls at their ranges; the edge of what differs from the
empty scene is sharp to about a pixel. Where an outline of the model borders on background it is
measured against the nearest edge in that view.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.body.skeleton import CLAVICLES, FOREARMS, HEAD, PARTS, TORSO, UPPER_ARMS
from stereotrack_core.body.surface import Feet, cone_tables, parts_of_cones
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.tracking.data_to_model import SurfaceResidual, Trust, residual_of_feet
from stereotrack_core.tracking.outlines.edges import EdgeMap, edge_maps
from stereotrack_core.tracking.outlines.kernels import measure_outline
from stereotrack_core.tracking.outlines.parameters import OutlineTrust

MEASURED_PARTS = (TORSO, *CLAVICLES, HEAD, *UPPER_ARMS, *FOREARMS)
"""Legs are left to the cloud: their cones are too rough to be measured at the edge."""

_MEASURED = np.isin(np.arange(len(PARTS)), MEASURED_PARTS)
_LIMB = np.isin(np.arange(len(PARTS)), (*UPPER_ARMS, *FOREARMS))

_ALONG = np.array([0.1, 0.3, 0.5, 0.7, 0.9])
"""Places along a cone where its outline is measured; 0 is the base."""


@dataclass(frozen=True, eq=False)
class Outlines:
    """Outlines of one pose in all views and how far the edges are from them.

    Attributes
    ----------
    cone : (m,) int64
    foot : (m, 3) float64, world
        On the surface, where a view grazes it.
    direction : (m, 3) float64, world
        Unit vector along which the edge is away, across the line of sight.
    distance : (m,) float64, metres
        From the outline to the edge, positive outwards.
    """

    cone: IntArray
    foot: FloatArray
    direction: FloatArray
    distance: FloatArray


def outlines_of(
    edges: tuple[EdgeMap, ...], body: BodyModel, frames: PartFrames, trust: OutlineTrust
) -> Outlines:
    """Measure the outlines of one pose against the edges of all views."""
    table = cone_tables(body.cones, frames)
    measured, limb = _MEASURED[body.cones.part], _LIMB[body.cones.part]
    room = 2 * len(_ALONG) * len(table)
    found = []
    for edge in edges:
        cone, distance = np.empty(room, dtype=np.int64), np.empty(room)
        foot, direction = np.empty((room, 3)), np.empty((room, 3))
        n = measure_outline(
            table,
            measured,
            limb,
            body.cones.outline,
            edge.distance,
            edge.range_z,
            edge.pinhole,
            edge.camera_from_world,
            _ALONG,
            trust.outline_depth,
            foot,
            direction,
            distance,
            cone,
        )
        kept = np.flatnonzero(np.abs(distance[:n]) < trust.outline_reach)
        found.append((cone[kept], foot[kept], direction[kept], distance[kept]))
    if not found:
        nowhere = np.empty((0, 3))
        return Outlines(np.empty(0, dtype=np.int64), nowhere, nowhere, np.empty(0))
    return Outlines(*(np.concatenate(values) for values in zip(*found, strict=True)))


@dataclass(frozen=True, eq=False)
class OutlineObservation:
    """The edges of one instant."""

    edges: tuple[EdgeMap, ...]
    trust: OutlineTrust

    def residuals(self, body: BodyModel, pose: Pose) -> tuple[SurfaceResidual, ...]:
        """Distances between the outlines of a pose and the edges near them."""
        if not self.edges:
            return ()
        frames = body.frames(pose)
        seen = outlines_of(self.edges, body, frames, self.trust)
        t = self.trust
        trust = Trust(t.outline_reach, t.outline_scale, t.outline_sigma, t.outline_points)
        feet = Feet(seen.cone, seen.distance, seen.foot, seen.direction)
        data = seen.foot + seen.distance[:, None] * seen.direction
        return (residual_of_feet(data, parts_of_cones(body, seen.cone), feet, frames, trust),)


@dataclass(frozen=True)
class OutlineSensor:
    """Measures outlines where views know the person's."""

    trust: OutlineTrust

    def observe(self, cloud: Cloud) -> OutlineObservation:
        """Measure the distances from the edges of one instant."""
        return OutlineObservation(edge_maps(cloud), self.trust)
