"""Limits of joints and collisions as soft rows of the correction (method.md 4H)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel, placed_cones
from stereotrack_core.body.pose import HANGING, PartFrames, Pose
from stereotrack_core.body.skeleton import (
    FOREARMS,
    HEAD,
    LEFT_SHANK,
    LEFT_THIGH,
    PARENTS,
    RIGHT_SHANK,
    RIGHT_THIGH,
    TORSO,
)
from stereotrack_core.body.surface import nearest_on_surface
from stereotrack_core.tracking.parameters import TrackingParameters

_REST_SIGMA = {
    HEAD: np.radians(20.0),
    LEFT_THIGH: np.radians(45.0),
    RIGHT_THIGH: np.radians(45.0),
    LEFT_SHANK: np.radians(60.0),
    RIGHT_SHANK: np.radians(60.0),
}
"""Standard deviation of the limbs that no measure counts from straight; they only take data."""


@dataclass(frozen=True, eq=False)
class DirectionResidual:
    """Components of a part's direction across an axis that is fixed to its parent.

    Attributes
    ----------
    part, parent : int
    across : (m, 3) float64
        Unit vectors in the parent's frame.
    measured, variance : (m,) float64
    """

    part: int
    parent: int
    across: FloatArray
    measured: FloatArray
    variance: FloatArray

    def predicted(self, frames: PartFrames) -> FloatArray:
        """Components (S, m)."""
        direction = frames.rotations[:, self.part, :, 2]
        local = np.einsum("sji,sj->si", frames.rotations[:, self.parent], direction)
        result: FloatArray = local @ self.across.T
        return result


@dataclass(frozen=True, eq=False)
class ClearanceResidual:
    """Distances of points of a part from the torso, along fixed directions of the torso's frame.

    Attributes
    ----------
    part : int
    points : (m, 3) float64
        In the frame of the part.
    outward : (m, 3) float64
        In the torso's frame.
    measured, variance : (m,) float64
    """

    part: int
    points: FloatArray
    outward: FloatArray
    measured: FloatArray
    variance: FloatArray

    def predicted(self, frames: PartFrames) -> FloatArray:
        """Places along the outward directions (S, m)."""
        turned = np.einsum("sij,mj->smi", frames.rotations[:, self.part], self.points)
        world = turned + frames.origins[:, self.part, None] - frames.origins[:, TORSO, None]
        local = np.einsum("sji,smj->smi", frames.rotations[:, TORSO], world)
        result: FloatArray = np.einsum("smi,mi->sm", local, self.outward)
        return result


def limit_residuals(
    body: BodyModel, pose: Pose, parameters: TrackingParameters, joints: tuple[int, ...]
) -> tuple[DirectionResidual | ClearanceResidual, ...]:
    """Rows for the limits that a pose violates, and for limbs that should rest."""
    rows: list[DirectionResidual | ClearanceResidual] = [
        _resting(part) for part in joints if part in _REST_SIGMA
    ]
    rows += _folded_elbows(pose, np.radians(parameters.least_elbow_angle))
    rows += _collisions(body, pose, parameters.clearance)
    return tuple(rows)


def _resting(part: int) -> DirectionResidual:
    rest = HANGING if PARENTS[part] == TORSO and part != HEAD else np.eye(3)
    variance = np.full(2, _REST_SIGMA[part] ** 2)
    return DirectionResidual(part, PARENTS[part], rest[:, :2].T, np.zeros(2), variance)


def _folded_elbows(pose: Pose, least_angle: float) -> list[DirectionResidual]:
    """Ask elbows that are bent beyond their limit to come back to it."""
    rows = []
    for fore in FOREARMS:
        along = pose.rotations[fore, :, 2]
        bend = float(np.arccos(np.clip(along[2], -1.0, 1.0)))
        if bend > np.pi - least_angle:
            limit = np.cos(np.pi - least_angle)
            axis = np.array([[0.0, 0.0, 1.0]])
            variance = np.full(1, np.radians(3.0) ** 2)
            rows.append(DirectionResidual(fore, PARENTS[fore], axis, np.array([limit]), variance))
    return rows


_COLLISION_SIGMA = 0.03
"""Metres; how firmly an arm is held off the torso."""


def _collisions(body: BodyModel, pose: Pose, clearance: float) -> list[ClearanceResidual]:
    """Hold the axes of forearms and hands off the torso's large cone."""
    if clearance <= 0.0:
        return []
    frames = body.frames(pose)
    placed = placed_cones(body, frames)[:1]
    rows = []
    for fore in FOREARMS:
        along = np.linspace(0.0, body.skeleton.lengths[fore], 4)
        points = along[:, None] * np.array([0.0, 0.0, 1.0])
        world = frames.apply(np.full(len(points), fore), points)
        feet = nearest_on_surface(world, placed, 0.5)
        close = (feet.cone == 0) & (feet.distance < clearance)
        if not close.any():
            continue
        to_torso = frames.rotations[TORSO]
        outward = feet.direction[close] @ to_torso
        foot = (feet.foot[close] - frames.origins[TORSO]) @ to_torso
        at_limit = np.einsum("mi,mi->m", outward, foot) + clearance
        variance = np.full(len(at_limit), _COLLISION_SIGMA**2)
        rows.append(ClearanceResidual(fore, points[close], outward, at_limit, variance))
    return rows
