"""A pose's covariance in axes that its state gives again.

A tracker's limbs have a turn about their own axis that no state keeps, and its covariance is about
the axes of limbs turned so. What is stored together with the state is about the axes of the chain
that the state stands for (:func:`pose_of_state`), so that both can be used together.
"""

from __future__ import annotations

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.angles import THESIS_JOINTS, pose_of_state, state_names
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.skeleton import PARENTS, PARTS, TORSO

AXES_KEY, CHAIN_AXES = "covariance_axes", "chain"
"""What a run's meta says of its covariances; runs of older versions do not say it."""


def in_chain_axes(pose: Pose, x: FloatArray, P: FloatArray, joints: tuple[int, ...]) -> FloatArray:
    """Turn the covariance (n, n) of a manifold error state to the axes of the state's own chain.

    Both limbs point the same way, so that tangents t about the pose's axes are T t about the
    chain's, T the turn between them about the limb. A state of the thesis's joints alone has no
    manifold: its covariance is returned as it is.

    Parameters
    ----------
    pose : Pose
        As the tracker has it.
    x : (n,) float64
        Its state.
    P : (n, n) float64
    joints : tuple of int
        Parts whose joints are in the state.
    """
    if joints == THESIS_JOINTS or not np.isfinite(P).all():
        return P
    own, chain = _world(pose), _world(pose_of_state(x, joints))
    turn = np.eye(len(P))
    for k, part in enumerate(joints):
        at = slice(6 + 2 * k, 8 + 2 * k)
        turn[at, at] = (chain[part].T @ own[part])[:2, :2]
    result: FloatArray = turn @ P @ turn.T
    return result


def joints_named(names: tuple[str, ...]) -> tuple[int, ...] | None:
    """Joints of a state with these names; None where they are not those of a body."""
    parts = [name.removesuffix("_alpha") for name in names[6:] if name.endswith("_alpha")]
    if not all(part in PARTS for part in parts):
        return None
    joints = tuple(PARTS.index(part) for part in parts)
    return joints if state_names(joints) == tuple(names) else None


def _world(pose: Pose) -> FloatArray:
    """Rotations world_from_part (P, 3, 3)."""
    result = pose.rotations.copy()
    for part, parent in enumerate(PARENTS):
        if part != TORSO:
            result[part] = result[parent] @ pose.rotations[part]
    return result
