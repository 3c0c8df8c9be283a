"""What is known of people who stand, for the fit of the body's shape (docs/method.md 4.12)."""

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.body.skeleton import SHANKS, THIGHS, TORSO, UPPER_ARMS
from stereotrack_core.geometry.upright import Z_UP, Upright

# Radians by which the line from hips to shoulders leans forward in people who stand, and their
# spread: shoulder joints lie a little in front of hip joints.
_LEAN, _LEAN_SIGMA = np.radians(2.0), np.radians(1.0)
_LEVEL = np.cos(np.radians(30.0))
_ERECT = np.cos(np.radians(12.0))  # of the largest angles: arms from sideways, trunk from vertical


@dataclass(frozen=True, eq=False)
class UprightResidual:
    """Components of the trunk's long axis along two horizontal directions."""

    across: FloatArray  # (2, 3), world. Unit vectors to the person's right and forward.
    measured: FloatArray
    variance: FloatArray  # `measured` and `variance`: (2,)

    def predicted(self, frames: PartFrames) -> FloatArray:
        """Components (S, 2) for stacked poses."""
        return frames.rotations[:, TORSO, :, 2] @ self.across.T


def upright(pose: Pose, frames: int, world: Upright = Z_UP) -> tuple[UprightResidual, ...]:
    """One row pair for a T pose, none for any other; `frames` together count as one measurement."""
    torso = world.points(pose.torso.T).T
    sideways = np.abs([pose.rotations[part, 0, 2] for part in UPPER_ARMS])
    if torso[2, 2] < _ERECT or sideways.min() < _LEVEL:
        return ()
    right = np.array([torso[0, 0], torso[1, 0], 0.0])
    right /= np.linalg.norm(right)
    forward = np.cross([0.0, 0.0, 1.0], right)
    measured = np.array([0.0, np.sin(_LEAN)])
    variance = np.full(2, frames * _LEAN_SIGMA**2)
    across = np.stack([right, forward]) @ world.rotation
    return (UprightResidual(across, measured, variance),)


_SOLE_SIGMA = 0.03  # metres of a leg's lower end from the sole, in all frames alike
# Metres around a shank's axis in which data are its own, how many of them show where it ends, and
# the percentile along it that does.
_AROUND_SHANK, _LEAST_ON_SHANK, _LOWEST = 0.12, 15, 98.0
_STRETCHED = np.cos(np.radians(25.0))  # of a knee's largest bend with hips surely above the sole
_UNCUT = 0.85  # share of a leg that must be seen: else image or volume ends it


@dataclass(frozen=True, eq=False)
class SoleResidual:
    """Soles along their shanks, measured where the data of the shanks end.

    Data show where a leg that is modelled too short goes on, but none speaks against one that is
    too long; this does.
    """

    part: IntArray  # (m,). Shanks.
    direction: FloatArray  # (m, 3), world. Along the shanks, held fixed.
    measured: FloatArray
    variance: FloatArray  # `measured` and `variance`: (m,)

    def predicted(self, body: BodyModel, frames: PartFrames) -> FloatArray:
        """Places of the soles along the directions (..., m)."""
        length = body.skeleton.lengths[self.part, None]
        sole = (
            frames.origins[..., self.part, :] + length * frames.rotations[..., 2][..., self.part, :]
        )
        return np.asarray(np.sum(sole * self.direction, axis=-1))


def soles(data: FloatArray, body: BodyModel, pose: Pose, count: int) -> SoleResidual:
    """Rows for straight legs whose ends are seen in data (N, 3); all frames count as one."""
    frames, part, measured = body.frames(pose), list[int](), list[float]()
    for thigh, shank in zip(THIGHS, SHANKS, strict=True) if body.shape.legs else ():
        knee, along = frames.origins[shank], frames.rotations[shank, :, 2]
        if along @ frames.rotations[thigh, :, 2] < _STRETCHED:
            continue
        down = (data - knee) @ along
        aside = np.linalg.norm(data - knee - down[:, None] * along, axis=1)
        own = down[(aside < _AROUND_SHANK) & (down > 0.0)]
        if len(own) < _LEAST_ON_SHANK:
            continue
        end = float(np.percentile(own, _LOWEST))
        length = body.skeleton.lengths
        expected = (length[thigh] + length[shank]) / body.shape.leg_length_factor
        if length[thigh] + end > _UNCUT * expected:
            part.append(shank)
            measured.append(float(knee @ along) + end)
    variance = np.full(len(part), count * _SOLE_SIGMA**2)
    at = np.array(part, dtype=np.int64)
    return SoleResidual(at, frames.rotations[..., 2][at], np.array(measured), variance)
