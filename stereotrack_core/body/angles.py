"""The thesis's Euler chain, active and right-handed (section 2.5, docs/method.md 2.2).

As printed, R(alpha, beta, gamma) mixes active and passive factors: it equals Rz(-gamma) Ry(beta)
Rx(-alpha). Here R = Rz(gamma) Ry(beta) Rx(alpha).
"""

from itertools import chain

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.pose import REST, Pose
from stereotrack_core.body.skeleton import (
    CLAVICLES,
    FOREARMS,
    HEAD,
    LEFT_PARTS,
    PARENTS,
    PARTS,
    SHANKS,
    THIGHS,
    TORSO,
    UPPER_ARMS,
)

MIRROR = np.diag([-1.0, 1.0, 1.0])
# Joints of the thesis's 14 states, in their order.
THESIS_JOINTS: tuple[int, ...] = tuple(chain.from_iterable(zip(UPPER_ARMS, FOREARMS, strict=True)))
# Joints of a state that includes head, legs and shoulder girdle; begins with the thesis's.
ALL_JOINTS: tuple[int, ...] = (
    *THESIS_JOINTS,
    HEAD,
    *chain.from_iterable(zip(THIGHS, SHANKS, strict=True)),
    *CLAVICLES,
)


def state_names(joints: tuple[int, ...]) -> tuple[str, ...]:
    """Names of the numbers of a state vector with these joints."""
    torso = [f"torso_{name}" for name in ("x", "y", "z", "alpha", "beta", "gamma")]
    return (*torso, *(f"{PARTS[j]}_{name}" for j in joints for name in ("alpha", "beta")))


def euler_rotation(alpha: FloatArray, beta: FloatArray, gamma: FloatArray) -> FloatArray:
    """Rz(gamma) Ry(beta) Rx(alpha) (..., 3, 3) of angles (...) in radians."""
    sa, ca, sb, cb = np.sin(alpha), np.cos(alpha), np.sin(beta), np.cos(beta)
    sg, cg = np.sin(gamma), np.cos(gamma)
    rows = [
        [cg * cb, cg * sb * sa - sg * ca, cg * sb * ca + sg * sa],
        [sg * cb, sg * sb * sa + cg * ca, sg * sb * ca - cg * sa],
        [-sb + 0 * sg * sa, cb * sa + 0 * sg, cb * ca + 0 * sg],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def angles_of_rotation(rotation: FloatArray) -> FloatArray:
    """Angles (alpha, beta, gamma) (..., 3) of rotations (..., 3, 3); beta in [-pi/2, pi/2]."""
    r = rotation
    gamma = np.arctan2(r[..., 1, 0], r[..., 0, 0])
    beta = np.arctan2(-r[..., 2, 0], np.hypot(r[..., 0, 0], r[..., 1, 0]))
    # What remains after gamma and beta: exact where beta is a right angle and gamma is free.
    sine, cosine = np.sin(gamma), np.cos(gamma)
    alpha = np.arctan2(
        sine * r[..., 0, 2] - cosine * r[..., 1, 2], cosine * r[..., 1, 1] - sine * r[..., 0, 1]
    )
    return np.stack([alpha, beta, gamma], axis=-1)


def joint_rotation(part: int, alpha: FloatArray, beta: FloatArray) -> FloatArray:
    """parent_from_part (..., 3, 3) of a limb; left limbs mirror right ones (M R M)."""
    own = euler_rotation(alpha, beta, np.zeros_like(alpha))
    if part in LEFT_PARTS:
        own = MIRROR @ own @ MIRROR
    return np.asarray(REST[part] @ own)


def joint_angles(part: int, direction: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Angles (alpha, beta) that turn the limb's z axis to `direction` (..., 3), parent's frame."""
    d = direction @ REST[part]
    if part in LEFT_PARTS:
        d = d @ MIRROR
    alpha = np.arctan2(-d[..., 1], np.hypot(d[..., 0], d[..., 2]))
    beta = np.arctan2(d[..., 0], d[..., 2])
    return alpha, beta


def pose_of_state(x: FloatArray, joints: tuple[int, ...]) -> Pose:
    """Pose of a state (..., 6 + 2 J): position, torso angles, two angles of each joint."""
    x = np.asarray(x, dtype=np.float64)
    rotations = np.broadcast_to(REST, (*x.shape[:-1], *REST.shape)).copy()
    rotations[..., TORSO, :, :] = euler_rotation(x[..., 3], x[..., 4], x[..., 5])
    for k, part in enumerate(joints):
        at = 6 + 2 * k
        rotations[..., part, :, :] = joint_rotation(part, x[..., at], x[..., at + 1])
    return Pose(x[..., :3], rotations)


def state_of_pose(pose: Pose, joints: tuple[int, ...]) -> FloatArray:
    """State (..., 6 + 2 J) of a pose; the inverse of :func:`pose_of_state`.

    The turn of a limb about its own axis is no part of it: directions come out the same, the
    child's angles in the chain's own frame.
    """
    numbers: list[FloatArray] = [*np.moveaxis(pose.position, -1, 0)]
    numbers += [*np.moveaxis(angles_of_rotation(pose.torso), -1, 0)]
    known: dict[int, tuple[FloatArray, FloatArray]] = {}
    for part in joints:
        parent = PARENTS[part]
        direction = pose.rotations[..., part, :, 2]
        if parent != TORSO:
            given, own = known[parent]
            direction = np.einsum("...ji,...jk,...k->...i", own, given, direction)
        alpha, beta = joint_angles(part, direction)
        if any(PARENTS[other] == part for other in joints):
            known[part] = (pose.rotations[..., part, :, :], joint_rotation(part, alpha, beta))
        numbers += [alpha, beta]
    return np.stack(numbers, axis=-1)
