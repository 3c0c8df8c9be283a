"""BVH, the skeleton animation that 3-D programs read.

The file is y-up in centimetres, the person of the rest pose stands with both arms stretched
out sideways and faces +Z, left is +X: (X, Y, Z) = (-x, z, y) of this program's world. Bone
lengths are constant in BVH: they are the medians over the trajectory. The format has no
missing values: unknown landmarks stay where they were last known, and a file of the same name
with ``.json`` behind it lists those frames, the unit and the axes.
"""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray
from stereotrack_core.atomic import write_files
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.rotation import angle_between, rotation_from_vector
from stereotrack_core.interop.landmark_file import checked_fps, contiguous
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory

_OUTWARDS = {"left": np.array([1.0, 0.0, 0.0]), "right": np.array([-1.0, 0.0, 0.0])}
_UP = np.array([0.0, 1.0, 0.0])


@dataclass(frozen=True, eq=False)
class Joint:
    """A joint: rotations (F, 3, 3) parent_from_joint, offset (3,) in the parent's rest; cm."""

    name: str
    parent: str
    offset: FloatArray
    rotation: FloatArray


def skeleton(landmarks: FloatArray, known: BoolArray) -> tuple[FloatArray, list[Joint]]:
    """Root positions (F, 3) and joints in the channels' order, depth first; cm.

    Bone lengths are medians over frames in which both ends are `known` (F, 9).
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
    chest = np.swapaxes(world_from_hips, -1, -2) @ world_from_chest
    joints = [
        Joint("hips", "", np.zeros(3), world_from_hips),
        Joint("chest", "hips", _UP * length("hips", "shoulders"), chest),
        Joint("neck", "chest", np.zeros(3), neck),
        Joint("head", "neck", _UP * length("shoulders", "head"), still),
    ]
    for side, out in _OUTWARDS.items():
        shoulder, elbow, hand = f"{side}_shoulder", f"{side}_elbow", f"{side}_hand"
        upper = _turn(out, _local(world_from_chest, at[elbow] - at[shoulder]))
        fore = _turn(out, _local(world_from_chest @ upper, at[hand] - at[elbow]))
        joints += [
            Joint(shoulder, "chest", out * length("shoulders", shoulder), upper),
            Joint(elbow, shoulder, out * length(shoulder, elbow), fore),
            Joint(hand, elbow, out * length(elbow, hand), still),
        ]
    for side, out in _OUTWARDS.items():
        hip = f"{side}_hip"
        joints.append(Joint(hip, "hips", out * length("hips", hip), still))
    return hips, joints


def _unit(vectors: FloatArray) -> FloatArray:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length == 0, 1.0, length)


def _frame(x: FloatArray, y: FloatArray, *, exact: str) -> FloatArray:
    """Rotations (F, 3, 3) with one axis as given and the other as near as can be."""
    z = _unit(np.cross(x, y))
    x, y = (_unit(x), np.cross(z, _unit(x))) if exact == "x" else (np.cross(_unit(y), z), _unit(y))
    return np.stack([x, y, z], axis=-1)


def _local(world_from_parent: FloatArray, vectors: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("fji,fj->fi", world_from_parent, vectors))


def _turn(rest: FloatArray, directions: FloatArray) -> FloatArray:
    """Smallest rotations (F, 3, 3) that bring `rest` (3,) onto `directions` (F, 3)."""
    angle = np.nan_to_num(angle_between(np.broadcast_to(rest, directions.shape), directions))
    axis = np.cross(rest, directions)
    opposite = (np.linalg.norm(axis, axis=-1) == 0) & (angle > 1.0)
    axis[opposite] = [0.0, 0.0, 1.0]  # any axis across the bone will do; no bone rests along z
    return rotation_from_vector(_unit(axis) * angle[:, None])


_BVH_FROM_WORLD = 100.0 * np.array([[-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])


def write_bvh(path: Path, trajectory: LandmarkTrajectory, fps: float) -> None:
    """Write the motion, and ``<path>.json``; InputError where a landmark is never known."""
    fps = checked_fps(fps)
    first, points = contiguous(trajectory, str(path))
    unknown: BoolArray = np.asarray(np.isnan(points).any(axis=-1))
    if never := [name for k, name in enumerate(LANDMARKS) if unknown[:, k].all()]:
        remedy = "BVH cannot omit landmarks. Export as csv, trc or c3d instead."
        raise InputError(f"the landmark {never[0]} has no position in any frame", path, remedy)
    held = points.copy()
    for k in range(len(LANDMARKS)):  # unknown landmarks stay where they were last (or first) known
        known = np.flatnonzero(~unknown[:, k])
        last = np.searchsorted(known, np.arange(len(points)), side="right") - 1
        held[:, k] = points[known[np.maximum(last, 0)], k]
    landmarks = held @ _BVH_FROM_WORLD.T
    root, joints = skeleton(landmarks, ~unknown)
    channels = np.concatenate([root, *(_euler_zxy_deg(j.rotation) for j in joints)], axis=1)
    lines = ["HIERARCHY", *_hierarchy(joints, joints[0], 0), "MOTION", f"Frames: {len(points)}"]
    lines.append(f"Frame Time: {1.0 / fps:.10g}")
    lines += [" ".join(f"{value:.6f}" for value in row) for row in channels.tolist()]
    notes = {
        "unit": "cm",
        "axes": "X = -x (the person's left when facing north), Y = z (up), Z = y (north)",
        "rotation_order": "intrinsic Z, X, Y in degrees",
        "frames_per_second": fps,
        "first_frame": first,
        "frames_with_held_landmarks": (np.flatnonzero(unknown.any(axis=1)) + first).tolist(),
    }
    beside = path.with_name(path.name + ".json")
    write_files({path: "\n".join(lines) + "\n", beside: json.dumps(notes, indent=2) + "\n"})


def _euler_zxy_deg(rotation: FloatArray) -> FloatArray:
    """Angles (F, 3) in degrees with R = Rz Rx Ry, without jumps of a full turn. The last one is
    taken from what the first leaves over, which stays exact where the middle one is near 90
    degrees.
    """
    z = np.arctan2(-rotation[:, 0, 1], rotation[:, 1, 1])
    x = np.arctan2(rotation[:, 2, 1], np.hypot(rotation[:, 0, 1], rotation[:, 1, 1]))
    cosine, sine = np.cos(z), np.sin(z)
    y = np.arctan2(
        cosine * rotation[:, 0, 2] + sine * rotation[:, 1, 2],
        cosine * rotation[:, 0, 0] + sine * rotation[:, 1, 0],
    )
    return np.rad2deg(np.unwrap(np.stack([z, x, y], axis=-1), axis=0))


def _hierarchy(joints: list[Joint], joint: Joint, depth: int) -> list[str]:
    indent, inner = "\t" * depth, "\t" * (depth + 1)
    kind, channels = "JOINT", "CHANNELS 3 "
    if not joint.parent:
        kind, channels = "ROOT", "CHANNELS 6 Xposition Yposition Zposition "
    x, y, z = (joint.offset + 0.0).tolist()  # adding zero turns -0.0 into 0.0
    lines = [
        f"{indent}{kind} {joint.name}",
        f"{indent}{{",
        f"{inner}OFFSET {x:.6f} {y:.6f} {z:.6f}",
        f"{inner}{channels}Zrotation Xrotation Yrotation",
    ]
    children = [child for child in joints if child.parent == joint.name]
    for child in children:
        lines += _hierarchy(joints, child, depth + 1)
    if not children:
        end = ["End Site", "{", "\tOFFSET 0.000000 0.000000 0.000000", "}"]
        lines += [f"{inner}{line}" for line in end]
    return [*lines, f"{indent}}}"]
