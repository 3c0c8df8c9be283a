"""Limits of joints and collisions as soft rows of the correction (method.md 4H)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.jacobian import Columns, point_jacobian
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
from stereotrack_core.tracking.arms_apart import ApartResidual, arms_apart
from stereotrack_core.tracking.parameters import TrackingParameters

_REST_SIGMA = {
    HEAD: np.radians(20.0),
    LEFT_THIGH: np.radians(45.0),
    RIGHT_THIGH: np.radians(45.0),
    LEFT_SHANK: np.radians(60.0),
    RIGHT_SHANK: np.radians(60.0),
}
"""Standard deviation of the limbs that no measure counts from straight; they only take data."""


_ELBOW_SIGMA = np.radians(3.0)
"""How firmly an elbow is kept from folding farther than its limit."""


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

    def jacobian(self, frames: PartFrames, columns: Columns) -> FloatArray:
        """Derivatives (m, n): only the part's own joint turns it against its parent."""
        J = np.zeros((len(self.measured), columns.n))
        own = frames.rotations[self.parent].T @ frames.rotations[self.part]
        at = columns.first[self.part]
        if at >= 0:
            J[:, at] = -self.across @ own[:, 1]
            J[:, at + 1] = self.across @ own[:, 0]
        return J

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

    def jacobian(self, frames: PartFrames, columns: Columns) -> FloatArray:
        """Derivatives (m, n): the torso's own movement changes nothing."""
        part = np.full(len(self.points), self.part, dtype=np.int64)
        world = frames.apply(part, self.points)
        outward = self.outward @ frames.rotations[TORSO].T
        J = point_jacobian(world, outward, part, frames, columns)
        J[:, :6] = 0.0
        return J

    def predicted(self, frames: PartFrames) -> FloatArray:
        """Places along the outward directions (S, m)."""
        turned = np.einsum("sij,mj->smi", frames.rotations[:, self.part], self.points)
        world = turned + frames.origins[:, self.part, None] - frames.origins[:, TORSO, None]
        local = np.einsum("sji,smj->smi", frames.rotations[:, TORSO], world)
        result: FloatArray = np.einsum("smi,mi->sm", local, self.outward)
        return result


Limit: TypeAlias = DirectionResidual | ClearanceResidual | ApartResidual


def limit_residuals(
    body: BodyModel, pose: Pose, parameters: TrackingParameters, joints: tuple[int, ...]
) -> tuple[Limit, ...]:
    """Rows for the limits that a pose violates, and for limbs that should rest."""
    rows: list[Limit] = [_resting(part) for part in joints if part in _REST_SIGMA]
    rows += _folded_elbows(pose, np.radians(parameters.least_elbow_angle))
    rows += _collisions(body, pose, parameters.clearance)
    if parameters.arms_apart > 0.0:
        rows += arms_apart(body, body.frames(pose), parameters.arms_apart)
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
        excess = bend - (np.pi - least_angle)
        if excess > 0.0:
            side = along[:2] / max(float(np.linalg.norm(along[:2])), 1e-9)
            further = np.append(np.cos(bend) * side, -np.sin(bend))[None]
            variance = np.full(1, _ELBOW_SIGMA**2)
            back = np.array([-excess])
            rows.append(DirectionResidual(fore, PARENTS[fore], further, back, variance))
    return rows


_COLLISION_SIGMA = 0.03
"""Metres; how firmly an arm is held off the torso."""

_CHECKED = 4
"""Places along a forearm, from elbow to hand, whose distance from the torso is checked."""


def _collisions(body: BodyModel, pose: Pose, clearance: float) -> list[ClearanceResidual]:
    """Hold the axes of forearms and hands off the torso's large cone."""
    if clearance <= 0.0:
        return []
    frames = body.frames(pose)
    length = body.skeleton.lengths[FOREARMS[0]]
    points = np.linspace(0.0, length, _CHECKED)[:, None] * np.array([0.0, 0.0, 1.0])
    world = np.concatenate(
        [points @ frames.rotations[fore].T + frames.origins[fore] for fore in FOREARMS]
    )
    feet = nearest_on_surface(world, placed_cones(body, frames)[:1], 0.5)
    to_torso = frames.rotations[TORSO]
    outward = feet.direction @ to_torso
    foot = (feet.foot - frames.origins[TORSO]) @ to_torso
    at_limit = np.einsum("mi,mi->m", outward, foot) + clearance
    close = ((feet.cone == 0) & (feet.distance < clearance)).reshape(len(FOREARMS), -1)
    rows = []
    for side, fore in enumerate(FOREARMS):
        kept = np.flatnonzero(close[side])
        if len(kept):
            at = kept + side * _CHECKED
            variance = np.full(len(kept), _COLLISION_SIGMA**2)
            rows.append(ClearanceResidual(fore, points[kept], outward[at], at_limit[at], variance))
    return rows
