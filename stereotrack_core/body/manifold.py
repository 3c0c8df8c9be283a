"""The error state on the manifold of poses (docs/method.md 4.5).

The torso is displaced by a translation and a left rotation vector, both in the world; a limb by
two tangents, rotations about the x and y axes of its own frame. There is no place where a degree
of freedom is lost.
"""

from __future__ import annotations

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.pose_kernels import displace
from stereotrack_core.body.skeleton import PARTS
from stereotrack_core.geometry.rotation import vector_from_rotation


def error_names(joints: tuple[int, ...]) -> tuple[str, ...]:
    """Names of the error state's numbers for these joints."""
    torso = [f"torso_{name}" for name in ("x", "y", "z", "rx", "ry", "rz")]
    return (*torso, *(f"{PARTS[j]}_{axis}" for j in joints for axis in ("tx", "ty")))


def displaced(pose: Pose, delta: FloatArray, joints: tuple[int, ...]) -> Pose:
    """Displace a pose by error states.

    Parameters
    ----------
    pose : Pose
        One pose.
    delta : (..., 6 + 2 J) float64
        Metres and radians.
    joints : tuple of int
        Parts whose joints are in the state.

    Returns
    -------
    Pose
        Stacked as `delta` is.

    Raises
    ------
    ValueError
        Where `delta` is of other joints.
    """
    if delta.shape[-1] != 6 + 2 * len(joints):
        raise ValueError(f"{delta.shape[-1]} numbers do not displace {len(joints)} joints")
    lead, shape = delta.shape[:-1], pose.rotations.shape
    stack = np.ascontiguousarray(delta, dtype=np.float64).reshape(-1, delta.shape[-1])
    rotations = np.empty((len(stack), *shape))
    turned = np.array(joints, dtype=np.int64)
    displace(np.ascontiguousarray(pose.rotations), turned, stack, rotations)
    return Pose(pose.position + delta[..., :3], rotations.reshape(*lead, *shape))


def difference(to: Pose, origin: Pose, joints: tuple[int, ...]) -> FloatArray:
    """Error state (6 + 2 J,) that displaces `origin` to `to`.

    A turn of a limb about its own axis, which displacements never make alone, is left out.
    """
    torso = vector_from_rotation(to.torso @ np.swapaxes(origin.torso, -1, -2))
    parts = list(joints)
    turned = np.swapaxes(origin.rotations[parts], -1, -2) @ to.rotations[parts]
    tangents = tangents_to_axis(turned[..., :, 2])
    return np.concatenate([to.position - origin.position, torso, tangents.reshape(-1)])


def tangents_to_axis(axis: FloatArray) -> FloatArray:
    """Tangents (..., 2) whose rotation turns (0, 0, 1) to the unit vectors `axis` (..., 3).

    Half a turn, which many rotations give, is made about x.
    """
    sine = np.hypot(axis[..., 0], axis[..., 1])
    angle = np.arctan2(sine, axis[..., 2])
    aside = sine > 1e-12
    factor = np.where(aside, angle / np.where(aside, sine, 1.0), 1.0)
    half_turn = np.where(~aside & (axis[..., 2] < 0), np.pi, 0.0)
    return np.stack([half_turn - axis[..., 1] * factor, axis[..., 0] * factor], axis=-1)
