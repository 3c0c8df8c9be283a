"""How the surface follows shoulders that move on their own, on top of what follows the bones.

The surface is posed first as if the girdle only followed the arms. What the shoulders do
beside that moves it once more: the arm goes along with its joint, and the flesh between arm,
neck and chest turns about the clavicle's inner end, less and less towards head and ribs.
"""

from __future__ import annotations

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.simulation.people import Person
from stereotrack_core.simulation.skeleton import BONE, SIDES, SIGN, PosedBones, rest_joints
from stereotrack_core.simulation.skin import rigid_quaternions, skinned, smooth_step

_ARM = ("swing", "upper_arm", "forearm", "hand")


def girdle_weights(person: Person, vertices: FloatArray, weights: FloatArray) -> FloatArray:
    """Shares (V, 5) of what stays, of the left girdle and arm, and of the right ones.

    Parameters
    ----------
    person : Person
    vertices : (V, 3) float64, metres
        At rest.
    weights : (V, B) float64
        Of the bones.
    """
    shoulder = rest_joints(person)[BONE["upper_arm_right"]]
    half, z = shoulder[0], vertices[:, 2] - shoulder[2]
    height = smooth_step(z, -0.10, 0.12) * (1 - smooth_step(z, 0.10, 0.09))
    height *= 1 - weights[:, BONE["head"]]
    shares = np.zeros((len(vertices), 5))
    for side, name in enumerate(SIDES):
        arm = weights[:, [BONE[f"{bone}_{name}"] for bone in _ARM]].sum(axis=1)
        across = smooth_step(SIGN[side] * vertices[:, 0], 0.45 * half, 0.4 * half)
        shares[:, 1 + 2 * side] = (1 - arm) * across * height
        shares[:, 2 + 2 * side] = arm
    shares[:, 0] = 1 - shares[:, 1:].sum(axis=1)
    return shares


def without_own_girdle(bones: PosedBones) -> PosedBones:
    """The bones as they were if the shoulders only followed the arms; the same if they do."""
    if np.array_equal(bones.girdle, np.tile(np.eye(3), (2, 1, 1))):
        return bones
    rotation, joint = bones.rotation.copy(), bones.joint.copy()
    for side, name in enumerate(SIDES):
        rotation[BONE[f"clavicle_{name}"]] = (
            bones.girdle[side].T @ rotation[BONE[f"clavicle_{name}"]]
        )
        joint[[BONE[f"{bone}_{name}"] for bone in _ARM]] -= _arm_shift(bones, side)
    return PosedBones(rotation, joint)


def with_own_girdle(
    vertices: FloatArray, normals: FloatArray, shares: FloatArray, bones: PosedBones
) -> tuple[FloatArray, FloatArray]:
    """Move a surface (V, 3), world, that followed the bones without their own girdle."""
    turns = np.tile(np.eye(3), (5, 1, 1))
    shifts = np.zeros((5, 3))
    for side, name in enumerate(SIDES):
        pivot = bones.joint[BONE[f"clavicle_{name}"]]
        turns[1 + 2 * side] = bones.girdle[side]
        shifts[1 + 2 * side] = pivot - bones.girdle[side] @ pivot
        shifts[2 + 2 * side] = _arm_shift(bones, side)
    return skinned(vertices, normals, shares, rigid_quaternions(turns, shifts))


def _arm_shift(bones: PosedBones, side: int) -> FloatArray:
    """How far the girdle's own motion brings the shoulder, (3,) metres, world."""
    clavicle, shoulder = (
        bones.joint[BONE[f"{bone}_{SIDES[side]}"]] for bone in ("clavicle", "upper_arm")
    )
    out = shoulder - clavicle
    result: FloatArray = out - bones.girdle[side].T @ out
    return result
