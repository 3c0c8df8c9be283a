"""BVH, the skeleton animation that 3-D programs read.

The file is y-up in centimetres, the person of the rest pose stands with both arms stretched
out sideways and faces +Z, left is +X: (X, Y, Z) = (-x, z, y) of this program's world. Bone
lengths are constant in BVH: they are the medians over the trajectory. The format has no
missing values: unknown landmarks stay where they were last known, and a file of the same name
with ``.json`` behind it lists those frames, the unit and the axes.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray
from stereotrack_core.atomic import write_files
from stereotrack_core.errors import InputError
from stereotrack_core.interop.bone_rotations import Joint, skeleton
from stereotrack_core.interop.gaps import checked_fps, contiguous
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory

_BVH_FROM_WORLD = 100.0 * np.array([[-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])


def write_bvh(path: Path, trajectory: LandmarkTrajectory, fps: float) -> None:
    """Write the skeleton's motion, and ``<path>.json`` with what the format cannot say.

    Raises
    ------
    InputError
        For a trajectory in which a landmark is never known.
    """
    fps = checked_fps(fps)
    first, points = contiguous(trajectory, str(path))
    unknown: BoolArray = np.asarray(np.isnan(points).any(axis=-1))
    landmarks = _held(points) @ _BVH_FROM_WORLD.T
    root, joints = skeleton(landmarks, ~unknown)
    channels = np.concatenate([root, *(_euler_zxy_deg(j.rotation) for j in joints)], axis=1)
    lines = ["HIERARCHY", *_hierarchy(joints, joints[0], 0), "MOTION", f"Frames: {len(points)}"]
    lines.append(f"Frame Time: {1.0 / fps:.10g}")
    lines += [" ".join(f"{value:.6f}" for value in row) for row in channels.tolist()]
    notes = _notes(fps, first, (np.flatnonzero(unknown.any(axis=1)) + first).tolist())
    beside = path.with_name(path.name + ".json")
    write_files({path: "\n".join(lines) + "\n", beside: json.dumps(notes, indent=2) + "\n"})


def _notes(fps: float, first: int, held: list[int]) -> dict[str, Any]:
    return {
        "unit": "cm",
        "axes": "X = -x (the person's left when facing north), Y = z (up), Z = y (north)",
        "rotation_order": "intrinsic Z, X, Y in degrees",
        "frames_per_second": fps,
        "first_frame": first,
        "frames_with_held_landmarks": held,
    }


def _held(points: FloatArray) -> FloatArray:
    """Landmarks (F, 9, 3) in which unknown ones stay where they were last (or first) known."""
    result = points.copy()
    for k, name in enumerate(LANDMARKS):
        known = np.flatnonzero(~np.isnan(points[:, k]).any(axis=-1))
        if not len(known):
            raise InputError(
                f"the landmark {name} is never known",
                remedy="BVH cannot leave it out; export as csv, trc or c3d instead.",
            )
        last = np.searchsorted(known, np.arange(len(points)), side="right") - 1
        result[:, k] = points[known[np.maximum(last, 0)], k]
    return result


def _euler_zxy_deg(rotation: FloatArray) -> FloatArray:
    """Angles (F, 3) in degrees with R = Rz Rx Ry, without jumps of a full turn.

    The last angle is taken from what the first leaves over, which stays exact where the
    middle one is near 90 degrees.
    """
    z = np.arctan2(-rotation[:, 0, 1], rotation[:, 1, 1])
    x = np.arctan2(rotation[:, 2, 1], np.hypot(rotation[:, 0, 1], rotation[:, 1, 1]))
    cosine, sine = np.cos(z), np.sin(z)
    y = np.arctan2(
        cosine * rotation[:, 0, 2] + sine * rotation[:, 1, 2],
        cosine * rotation[:, 0, 0] + sine * rotation[:, 1, 0],
    )
    result: FloatArray = np.rad2deg(np.unwrap(np.stack([z, x, y], axis=-1), axis=0))
    return result


def _hierarchy(joints: list[Joint], joint: Joint, depth: int) -> list[str]:
    indent, inner = "\t" * depth, "\t" * (depth + 1)
    kind, channels = "JOINT", "CHANNELS 3 "
    if not joint.parent:
        kind, channels = "ROOT", "CHANNELS 6 Xposition Yposition Zposition "
    lines = [f"{indent}{kind} {joint.name}", f"{indent}{{", f"{inner}{_offset(joint.offset)}"]
    lines.append(f"{inner}{channels}Zrotation Xrotation Yrotation")
    children = [child for child in joints if child.parent == joint.name]
    for child in children:
        lines += _hierarchy(joints, child, depth + 1)
    if not children:
        end = ["End Site", "{", f"\t{_offset(np.zeros(3))}", "}"]
        lines += [f"{inner}{line}" for line in end]
    return [*lines, f"{indent}}}"]


def _offset(offset: FloatArray) -> str:
    x, y, z = (offset + 0.0).tolist()  # adding zero turns -0.0 into 0.0
    return f"OFFSET {x:.6f} {y:.6f} {z:.6f}"
