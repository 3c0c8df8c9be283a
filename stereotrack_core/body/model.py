"""The body: a skeleton with cones around it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray
from stereotrack_core.body.angles import ALL_JOINTS, THESIS_JOINTS
from stereotrack_core.body.cones import Cones, body_cones
from stereotrack_core.body.parameters import BodyParameters
from stereotrack_core.body.pose import PartFrames, Pose, part_frames
from stereotrack_core.body.proportions import AVERAGE, Proportions
from stereotrack_core.body.skeleton import FOREARMS, HEAD, TORSO, UPPER_ARMS, Skeleton, skeleton


@dataclass(frozen=True, eq=False)
class BodyModel:
    """What is known about a person before tracking: lengths and shape."""

    skeleton: Skeleton
    cones: Cones

    def frames(self, pose: Pose) -> PartFrames:
        """Frames of all parts; see :func:`part_frames`."""
        return part_frames(self.skeleton, pose)

    @cached_property
    def joints(self) -> tuple[int, ...]:
        """Joints of a state: arms, head, and of legs and clavicles those that have a surface."""
        always = (*THESIS_JOINTS, HEAD)
        return tuple(j for j in ALL_JOINTS if j in always or np.any(self.cones.part == j))

    @cached_property
    def torso(self) -> PlacedCones:
        """The torso's large cone in the torso's own frame."""
        cones = self.cones[:1]
        return PlacedCones(cones.rotations, cones.origins, cones)


@dataclass(frozen=True, eq=False)
class PlacedCones:
    """The cones of a body in one pose: p_world = rotations p_cone + origins.

    Attributes
    ----------
    rotations : (C, 3, 3) float64
        world_from_cone.
    origins : (C, 3) float64, world, metres
    cones : Cones
    """

    rotations: FloatArray
    origins: FloatArray
    cones: Cones

    def __getitem__(self, index: BoolArray | slice) -> PlacedCones:
        """Some of the cones."""
        return PlacedCones(self.rotations[index], self.origins[index], self.cones[index])


def body_model(proportions: Proportions, parameters: BodyParameters | None = None) -> BodyModel:
    """Body with these proportions, or with average ones where the parameters say so."""
    shape = BodyParameters() if parameters is None else parameters
    lengths = AVERAGE if shape.proportions == "average" else proportions
    return BodyModel(skeleton(lengths), body_cones(lengths, shape))


def placed_cones(body: BodyModel, frames: PartFrames) -> PlacedCones:
    """Put the cones where the parts of one pose are."""
    of_part = frames.rotations[body.cones.part]
    return PlacedCones(
        rotations=of_part @ body.cones.rotations,
        origins=np.einsum("cij,cj->ci", of_part, body.cones.origins)
        + frames.origins[body.cones.part],
        cones=body.cones,
    )


def landmarks(body: BodyModel, pose: Pose) -> FloatArray:
    """The nine landmarks (..., 9, 3), world, metres, in the order of ``LANDMARKS``."""
    return landmarks_of_frames(body, body.frames(pose))


def landmarks_of_frames(body: BodyModel, frames: PartFrames) -> FloatArray:
    """The nine landmarks (..., 9, 3) where the parts' frames are known already."""
    lengths = body.skeleton.lengths
    shoulders = [frames.origins[..., part, :] for part in UPPER_ARMS]
    elbows = [frames.origins[..., part, :] for part in FOREARMS]
    hands = [_along(frames, part, lengths[part]) for part in FOREARMS]
    head = _along(frames, HEAD, lengths[HEAD])
    half_hips = 0.5 * body.skeleton.proportions.hip_width * frames.rotations[..., TORSO, :, 0]
    hip = frames.origins[..., TORSO, :]
    return np.stack([*shoulders, *elbows, *hands, head, hip - half_hips, hip + half_hips], axis=-2)


def _along(frames: PartFrames, part: int, length: float) -> FloatArray:
    result: FloatArray = frames.origins[..., part, :] + length * frames.rotations[..., part, :, 2]
    return result
