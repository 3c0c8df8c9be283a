"""Arms as directions: what proposals are made of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import PartFrames, Pose, rotation_towards
from stereotrack_core.body.skeleton import FOREARMS, TORSO, UPPER_ARMS

LEFT, RIGHT = 0, 1


@dataclass(frozen=True, eq=False)
class Arms:
    """K proposals for one arm.

    Attributes
    ----------
    upper, fore : (K, 3) float64
        Unit vectors from shoulder to elbow and from elbow to hand, torso's frame.
    """

    upper: FloatArray
    fore: FloatArray

    def __len__(self) -> int:
        return len(self.upper)

    def __getitem__(self, index: FloatArray | slice | list[int]) -> Arms:
        return Arms(self.upper[index], self.fore[index])


def joined(*arms: Arms) -> Arms:
    """All proposals one after the other."""
    return Arms(
        np.concatenate([arm.upper for arm in arms]), np.concatenate([arm.fore for arm in arms])
    )


def arm_of_pose(frames: PartFrames, side: int) -> Arms:
    """The arm of one pose as a single proposal."""
    torso = frames.rotations[TORSO]
    upper = frames.rotations[UPPER_ARMS[side], :, 2] @ torso
    fore = frames.rotations[FOREARMS[side], :, 2] @ torso
    return Arms(upper[None], fore[None])


def with_arm(pose: Pose, side: int, upper: FloatArray, fore: FloatArray) -> Pose:
    """Pose, or poses, with one arm turned to directions (..., 3) of proposals, torso's frame."""
    lead = upper.shape[:-1]
    rotations = np.broadcast_to(pose.rotations, (*lead, *pose.rotations.shape)).copy()
    u, f = UPPER_ARMS[side], FOREARMS[side]
    turned = rotation_towards(pose.rotations[u], upper)
    in_upper = np.einsum("...i,...ij->...j", fore, turned)
    rotations[..., u, :, :] = turned
    rotations[..., f, :, :] = rotation_towards(pose.rotations[f], in_upper)
    return Pose(np.broadcast_to(pose.position, (*lead, 3)), rotations)


@dataclass(frozen=True, eq=False)
class ArmShape:
    """One arm's place and size, as balls swept along three segments.

    Attributes
    ----------
    side : int
        ``LEFT`` or ``RIGHT``.
    shoulder : (3,) float64, torso's frame
    upper_length, fore_length, hand_length : float, metres
    radii : (3, 2) float64, metres
        Of upper arm, forearm and hand, at both ends.
    """

    side: int
    shoulder: FloatArray
    upper_length: float
    fore_length: float
    hand_length: float
    radii: FloatArray

    @property
    def reach(self) -> float:
        """From the shoulder to the finger tips of a straight arm, metres."""
        return self.upper_length + self.fore_length + self.hand_length

    def nodes(self, arms: Arms) -> FloatArray:
        """Shoulder, elbow, wrist and finger tip (K, 4, 3), torso's frame."""
        nodes = np.empty((len(arms), 4, 3))
        nodes[:, 0] = self.shoulder
        nodes[:, 1] = self.shoulder + self.upper_length * arms.upper
        nodes[:, 2] = nodes[:, 1] + self.fore_length * arms.fore
        nodes[:, 3] = nodes[:, 2] + self.hand_length * arms.fore
        return nodes


def arm_shape(body: BodyModel, side: int) -> ArmShape:
    """Shape of a body's arm, where the shoulder rests."""
    p, cones = body.skeleton.proportions, body.cones
    of_upper = np.flatnonzero(cones.part == UPPER_ARMS[side])
    of_fore = np.flatnonzero(cones.part == FOREARMS[side])
    indices = np.concatenate([of_upper, of_fore])
    return ArmShape(
        side=side,
        shoulder=body.skeleton.joints[UPPER_ARMS[side]],
        upper_length=p.upper_arm_length,
        fore_length=p.forearm_length,
        hand_length=p.hand_length,
        radii=np.stack([cones.r1[indices], cones.r2[indices]], axis=1),
    )
