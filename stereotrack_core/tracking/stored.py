"""The body and the poses of a stored run, and its covariances in axes that its states give again.

A tracker's limbs have a turn about their own axis that no state keeps, and its covariance is about
the axes of limbs turned so. What is stored together with the state is about the axes of the chain
that the state stands for (:func:`pose_of_state`), so that both can be used together.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.angles import THESIS_JOINTS, pose_of_state, state_names
from stereotrack_core.body.model import BodyModel, body_model
from stereotrack_core.body.parameters import BodyParameters
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.body.skeleton import PARENTS, PARTS, TORSO
from stereotrack_core.errors import InputError
from stereotrack_core.parameters import Value
from stereotrack_core.recording.description import Subject
from stereotrack_core.tracking.run import Run

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


EARLIER: Mapping[str, Value] = MappingProxyType({"girdle": False})
"""What runs of older versions do not say because their program could do nothing else."""


def pose_of_run(run: Run, i: int) -> Pose | None:
    """Pose of a run's i-th frame, None where it is not tracked.

    Raises
    ------
    InputError
        Where the run's states are not those of a body.
    """
    if not run.tracked[i]:
        return None
    return pose_of_state(run.x[i], _joints_of(run.state_names))


def fps_of_run(run: Run) -> float:
    """Frames per second that the run's meta states.

    Raises
    ------
    InputError
        Where it states none.
    """
    fps = run.meta.get("fps")
    if not isinstance(fps, int | float) or not fps > 0:
        raise InputError(
            "the run does not state its frame rate",
            where="meta, fps",
            remedy="Name its recording, export as .csv, which needs none, or track again.",
        )
    return float(fps)


def body_of_run(run: Run) -> BodyModel:
    """Body that a run was tracked with: its subject's proportions and its shape parameters."""
    return body_model(proportions_of(subject_of_meta(run.meta)), shape_of_meta(run.meta))


def subject_of_meta(meta: Mapping[str, Any]) -> Subject | None:
    """Whose body was tracked."""
    stored = meta.get("subject")
    if not isinstance(stored, dict):
        return None
    fields = {field.name for field in dataclasses.fields(Subject)}
    return Subject(**{key: value for key, value in stored.items() if key in fields})


def shape_of_meta(meta: Mapping[str, Any]) -> BodyParameters:
    """Shape of the body that was tracked."""
    known = {row.name for row in BodyParameters.rows()}
    stored = {**EARLIER, **meta.get("body", {})}
    return BodyParameters().replaced(**{k: v for k, v in stored.items() if k in known})


def _joints_of(names: tuple[str, ...]) -> tuple[int, ...]:
    joints = joints_named(names)
    if joints is None:
        raise InputError(
            "the states are not those of a body",
            where="state_names",
            remedy="Track the recording again with this version.",
        )
    return joints
