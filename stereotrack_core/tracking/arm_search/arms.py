"""Arms as directions, and where they could be: around what is expected, in usual places, and where
data are unexplained.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.angles import MIRROR
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import PartFrames, Pose, rotation_towards
from stereotrack_core.body.skeleton import FOREARMS, TORSO, UPPER_ARMS
from stereotrack_core.geometry.rotation import rotation_from_vector

LEFT, RIGHT = 0, 1
_S = float(np.sqrt(0.5))
# Upper arm and forearm of a right arm where arms usually are, torso's frame: hanging, bent,
# crossed, forward, sideways, raised, folded, at the back.
_CANONICAL = np.array(
    [
        [[0, 0, -1], [0, 0, -1]],
        [[0.2, 0, -1], [0, 0.3, -1]],
        [[0, 0, -1], [0, 1, 0]],
        [[0, 0, -1], [-0.5, 0.8, 0.2]],
        [[0, 0.3, -1], [-1, 0.5, 0]],
        [[0, 0.3, -1], [-0.8, 0.4, 0.5]],
        [[0.2, 0.5, -0.8], [-1, 0.1, 0.1]],
        [[0, 1, 0], [0, 1, 0]],
        [[0, 1, 0], [-1, 0.3, 0]],
        [[0.3, 0.8, -0.5], [0, 0.2, 1]],
        [[1, 0, 0], [1, 0, 0]],
        [[1, 0, 0], [0, 0.2, 1]],
        [[1, 0, -0.3], [-0.6, 0.8, 0]],
        [[_S, 0, _S], [_S, 0, _S]],
        [[0, 0.2, 1], [0, 0.1, 1]],
        [[0.5, 0.2, 0.8], [-0.9, 0, 0.3]],
        [[0.3, -0.3, -0.9], [-0.4, 0.3, -0.2]],
    ]
)


@dataclass(frozen=True, eq=False)
class Arms:
    """K proposals for one arm."""

    upper: FloatArray  # (K, 3). Unit vectors from shoulder to elbow, torso's frame.
    fore: FloatArray  # (K, 3). Unit vectors from elbow to hand, torso's frame.

    def __len__(self) -> int:
        return len(self.upper)

    def __getitem__(self, index: FloatArray | slice | list[int]) -> Arms:
        return Arms(self.upper[index], self.fore[index])


def directions(vectors: FloatArray) -> FloatArray:
    """Unit vectors (..., 3) along vectors (..., 3)."""
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-9))


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
    rotations = np.broadcast_to(pose.rotations, (*lead, *pose.rotations.shape[-3:])).copy()
    u, f = UPPER_ARMS[side], FOREARMS[side]
    turned = rotation_towards(rotations[..., u, :, :], upper)
    in_upper = np.einsum("...i,...ij->...j", fore, turned)
    rotations[..., u, :, :] = turned
    rotations[..., f, :, :] = rotation_towards(rotations[..., f, :, :], in_upper)
    return Pose(np.broadcast_to(pose.position, (*lead, 3)), rotations)


@dataclass(frozen=True, eq=False)
class ArmShape:
    """One arm's place and size, as balls swept along three segments."""

    side: int  # `LEFT` or `RIGHT`
    shoulder: FloatArray  # (3,), torso's frame
    upper_length: float  # metres, as the others
    fore_length: float
    hand_length: float
    radii: FloatArray  # (3, 2), metres. Of upper arm, forearm and hand, at both ends.

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
    limbs = UPPER_ARMS[side], FOREARMS[side]
    indices = np.concatenate([np.flatnonzero(cones["part"] == limb) for limb in limbs])
    return ArmShape(
        side=side,
        shoulder=body.skeleton.joints[UPPER_ARMS[side]],
        upper_length=p.upper_arm_length,
        fore_length=p.forearm_length,
        hand_length=p.hand_length,
        radii=np.stack([cones["r1"][indices], cones["r2"][indices]], axis=1),
    )


def arms_around(
    centre: Arms, count: int, upper_sigma: float, fore_sigma: float, rng: np.random.Generator
) -> Arms:
    """Draw arms around one arm, deviations in radians; the forearm turns with the upper arm."""
    whole = rotation_from_vector(rng.normal(size=(count, 3)) * upper_sigma)
    alone = rotation_from_vector(rng.normal(size=(count, 3)) * fore_sigma)
    fore = np.einsum("kij,kj->ki", alone, whole @ centre.fore[0])
    return Arms(whole @ centre.upper[0], fore)


def _hands_at(shape: ArmShape, targets: FloatArray, swivels: int, rng: np.random.Generator) -> Arms:
    """Arms whose hand's middle lies at the targets (K, 3), torso's frame, by two-bone geometry.

    The elbow lies on a circle about the line from shoulder to hand; `swivels` places on it are
    drawn for every target. Targets out of reach are aimed at with a straight arm.
    """
    wanted = np.repeat(targets - shape.shoulder, swivels, axis=0)
    distance = np.maximum(np.linalg.norm(wanted, axis=1), 1e-6)
    along = wanted / distance[:, None]
    a, b = shape.upper_length, shape.fore_length + 0.5 * shape.hand_length
    span = np.clip(distance, abs(a - b) + 1e-3, a + b - 1e-3)
    cosine = np.clip((a * a + span * span - b * b) / (2.0 * a * span), -1.0, 1.0)
    sine = np.sqrt(1.0 - cosine * cosine)
    across = _perpendicular(along, rng)
    upper = cosine[:, None] * along + sine[:, None] * across
    fore = span[:, None] * along - a * upper
    return Arms(upper, directions(fore))


def proposals(
    shape: ArmShape,
    predicted: Arms,
    present: Arms,
    unexplained: FloatArray,
    count: int,
    rng: np.random.Generator,
) -> Arms:
    """About `count` proposals for one arm; the first is the present one, the second the predicted.

    `predicted` and `present` are one arm each: from the last frame, and after following the data.
    Nothing explains the data `unexplained` (N, 3), torso's frame.
    """
    near, wide = np.radians([18.0, 45.0])
    usual = directions(_CANONICAL @ MIRROR if shape.side == LEFT else _CANONICAL)
    sets = [
        present,
        predicted,
        Arms(usual[:, 0], usual[:, 1]),
        arms_around(present, count // 4, near, near, rng),
        arms_around(predicted, count // 6, near, wide, rng),
        arms_around(predicted, count // 6, wide, wide, rng),
    ]
    offset = np.linalg.norm(unexplained - shape.shoulder, axis=1)
    targets = unexplained[offset < shape.reach]
    if len(targets):
        picked = targets[rng.integers(0, len(targets), max(1, count // 8))]
        hands = _hands_at(shape, picked, 2, rng)
        # Upper arms that point to the data; forearms are bent at random.
        upper = directions(picked - shape.shoulder)
        bend = rng.uniform(0.0, np.radians(130.0), len(upper))[:, None]
        across = _perpendicular(upper, rng)
        sets += [hands, Arms(upper, np.cos(bend) * upper + np.sin(bend) * across)]
    return joined(*sets)


def _perpendicular(along: FloatArray, rng: np.random.Generator) -> FloatArray:
    drawn = rng.normal(size=along.shape)
    return directions(drawn - np.einsum("ki,ki->k", drawn, along)[:, None] * along)
