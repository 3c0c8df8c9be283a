"""A skeleton of rotating bones of constant length from nine landmarks.

Axes of this file are those of BVH: y up, the person of the rest pose stands with both arms
stretched out sideways and faces +z, left is +x.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray
from stereotrack_core.geometry.rotation import angle_between, rotation_from_vector
from stereotrack_core.recording.landmarks import LANDMARKS

_OUTWARDS = {"left": np.array([1.0, 0.0, 0.0]), "right": np.array([-1.0, 0.0, 0.0])}
_UP = np.array([0.0, 1.0, 0.0])


@dataclass(frozen=True, eq=False)
class Joint:
    """A joint with its motion; centimetres, y up.

    Attributes
    ----------
    name : str
    parent : str
        Empty for the root.
    offset : (3,) float64
        In the parent's rest frame.
    rotation : (F, 3, 3) float64
        parent_from_joint.
    """

    name: str
    parent: str
    offset: FloatArray
    rotation: FloatArray


def skeleton(landmarks: FloatArray, known: BoolArray) -> tuple[FloatArray, list[Joint]]:
    """Root positions (F, 3) and joints, parents first, of landmarks (F, 9, 3) in BVH's axes.

    `known` (F, 9) says which landmarks count for the bone lengths.
    """
    at = {name: landmarks[:, k] for k, name in enumerate(LANDMARKS)}
    seen = {name: known[:, k] for k, name in enumerate(LANDMARKS)}
    hips = (at["left_hip"] + at["right_hip"]) / 2.0
    shoulders = (at["left_shoulder"] + at["right_shoulder"]) / 2.0
    seen["hips"] = seen["left_hip"] & seen["right_hip"]
    seen["shoulders"] = seen["left_shoulder"] & seen["right_shoulder"]
    at |= {"hips": hips, "shoulders": shoulders}

    def length(a: str, b: str) -> float:
        both = seen[a] & seen[b]
        frames = both if both.any() else np.ones(len(both), dtype=np.bool_)
        return float(np.median(np.linalg.norm(at[b][frames] - at[a][frames], axis=-1)))

    # the long axis is exact in the pelvis, the cross axis in the chest: spines twist and bend
    world_from_hips = _frame(at["left_hip"] - at["right_hip"], shoulders - hips, exact="y")
    across = at["left_shoulder"] - at["right_shoulder"]
    world_from_chest = _frame(across, world_from_hips[..., 1], exact="x")
    still = np.broadcast_to(np.eye(3), world_from_hips.shape)
    neck = _turn(_UP, _local(world_from_chest, at["head"] - shoulders))
    joints = [
        Joint("hips", "", np.zeros(3), world_from_hips),
        Joint(
            "chest",
            "hips",
            _UP * length("hips", "shoulders"),
            _relative(world_from_hips, world_from_chest),
        ),
        Joint("neck", "chest", np.zeros(3), neck),
        Joint("head", "neck", _UP * length("shoulders", "head"), still),
    ]
    for side, out in _OUTWARDS.items():
        shoulder, elbow, hand = f"{side}_shoulder", f"{side}_elbow", f"{side}_hand"
        upper = _turn(out, _local(world_from_chest, at[elbow] - at[shoulder]))
        fore = _turn(out, _local(world_from_chest @ upper, at[hand] - at[elbow]))
        joints += [
            Joint(f"{side}_hip", "hips", out * length("hips", f"{side}_hip"), still),
            Joint(shoulder, "chest", out * length("shoulders", shoulder), upper),
            Joint(elbow, shoulder, out * length(shoulder, elbow), fore),
            Joint(hand, elbow, out * length(elbow, hand), still),
        ]
    return hips, list(_depth_first(joints, joints[0]))


def _depth_first(joints: list[Joint], joint: Joint) -> Iterator[Joint]:
    """Order of the channels in the file."""
    yield joint
    for child in joints:
        if child.parent == joint.name:
            yield from _depth_first(joints, child)


def _unit(vectors: FloatArray) -> FloatArray:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    result: FloatArray = vectors / np.where(length == 0, 1.0, length)
    return result


def _frame(x: FloatArray, y: FloatArray, *, exact: str) -> FloatArray:
    """Rotations (F, 3, 3) with one axis as given and the other as near as can be."""
    z = _unit(np.cross(x, y))
    x, y = (_unit(x), np.cross(z, _unit(x))) if exact == "x" else (np.cross(_unit(y), z), _unit(y))
    result: FloatArray = np.stack([x, y, z], axis=-1)
    return result


def _relative(world_from_parent: FloatArray, world_from_child: FloatArray) -> FloatArray:
    result: FloatArray = np.swapaxes(world_from_parent, -1, -2) @ world_from_child
    return result


def _local(world_from_parent: FloatArray, vectors: FloatArray) -> FloatArray:
    result: FloatArray = np.einsum("fji,fj->fi", world_from_parent, vectors)
    return result


def _turn(rest: FloatArray, directions: FloatArray) -> FloatArray:
    """Smallest rotations (F, 3, 3) that bring `rest` (3,) onto `directions` (F, 3)."""
    angle = np.nan_to_num(angle_between(np.broadcast_to(rest, directions.shape), directions))
    axis = np.cross(rest, directions)
    opposite = (np.linalg.norm(axis, axis=-1) == 0) & (angle > 1.0)
    axis[opposite] = [0.0, 0.0, 1.0]  # any axis across the bone will do; no bone rests along z
    return rotation_from_vector(_unit(axis) * angle[:, None])
