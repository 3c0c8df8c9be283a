"""BVH files, read back by forward kinematics written for these tests alone."""

import json
import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from stereotrack_core.interop.bvh import write_bvh
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory


def joints_of(path):
    """World positions (F, 3) of every joint in the world's metres, and the frame time."""
    hierarchy, motion = path.read_text().split("MOTION\n")
    count, time, rows = motion.split("\n", 2)
    values = np.array([line.split() for line in rows.strip().split("\n")], dtype=float)
    assert count == f"Frames: {len(values)}"
    stack, places, column = [], {}, 0
    name = offset = None
    for line in hierarchy.split("\n")[1:]:
        word, *rest = line.split() or [""]
        if word in ("ROOT", "JOINT", "End"):
            name = rest[0] if word != "End" else None
        elif word == "OFFSET":
            offset = np.array(rest, dtype=float)
            stack.append(None)
            if name is None:
                continue
        elif word == "CHANNELS":
            assert rest[-3:] == ["Zrotation", "Xrotation", "Yrotation"]
            origin = (np.zeros((len(values), 3)), Rotation.identity())
            parent = stack[-2] if len(stack) > 1 else origin
            position = parent[0] + parent[1].apply(offset)
            if rest[0] == "6":
                assert rest[1:4] == ["Xposition", "Yposition", "Zposition"]
                position = position + values[:, column : column + 3]
                column += 3
            angles = values[:, column : column + 3]
            column += 3
            turn = parent[1] * Rotation.from_euler("ZXY", angles, degrees=True)
            stack[-1] = (position, turn)
            places[name] = position
        elif word == "}":
            stack.pop()
    assert column == values.shape[1]
    in_metres = {name: p[:, [0, 2, 1]] * [-0.01, 0.01, 0.01] for name, p in places.items()}
    return in_metres, float(re.fullmatch(r"Frame Time: (\S+)", time).group(1))


def assert_landmarks(places, points, atol=1e-6):
    for k, name in enumerate(LANDMARKS):
        np.testing.assert_allclose(places[name], points[:, k], atol=atol, err_msg=name)


@pytest.mark.parametrize("seed", range(2))
def test_joints_are_where_the_landmarks_are(tmp_path, body_trajectory, seed):
    trajectory = body_trajectory(np.random.default_rng(seed), range(6))
    path = tmp_path / "a.bvh"
    write_bvh(path, trajectory, 30.0)
    places, time = joints_of(path)
    assert_landmarks(places, trajectory.points)
    assert time == pytest.approx(1 / 30)


def test_another_library_finds_the_joints_there(tmp_path, random, body_trajectory):
    bvhio = pytest.importorskip("bvhio")
    trajectory = body_trajectory(random, range(3))
    write_bvh(tmp_path / "a.bvh", trajectory, 30.0)
    root = bvhio.readAsHierarchy(str(tmp_path / "a.bvh"))
    for frame in (0, 2):
        root.loadPose(frame)
        places = {joint.Name: joint.PositionWorld for joint, *_ in root.layout()}
        found = np.array([tuple(places[name]) for name in LANDMARKS]) / 100.0
        world = np.stack([-found[:, 0], found[:, 2], found[:, 1]], axis=1)
        np.testing.assert_allclose(world, trajectory.points[frame], atol=1e-5)


def test_t_pose_is_the_rest_pose(tmp_path):
    x = np.array([-0.2, 0.2, -0.5, 0.5, -0.8, 0.8, 0.0, -0.1, 0.1])
    z = np.array([1.4] * 6 + [1.6, 0.9, 0.9])
    points = np.stack([x, np.zeros(9), z], axis=-1)[None]
    write_bvh(tmp_path / "a.bvh", LandmarkTrajectory(np.array([0]), points), 10.0)
    row = (tmp_path / "a.bvh").read_text().strip().split("\n")[-1].split()
    np.testing.assert_allclose([float(v) for v in row[:3]], [0, 90, 0], atol=1e-6)
    np.testing.assert_allclose([float(v) for v in row[3:]], 0, atol=1e-6)
    places, _ = joints_of(tmp_path / "a.bvh")
    assert_landmarks(places, points)


def test_arms_opposite_to_the_rest_pose_and_torso_upside_down(tmp_path, random, body_trajectory):
    points = body_trajectory(random, [0]).points.repeat(3, axis=0)
    at = {name: k for k, name in enumerate(LANDMARKS)}
    across = points[:, at["right_shoulder"]] - points[:, at["left_shoulder"]]
    points[1, at["left_elbow"]] = points[1, at["left_shoulder"]] + across[1] * 0.29 / 0.38
    fore = points[1, at["left_elbow"]] - points[1, at["left_shoulder"]]
    points[1, at["left_hand"]] = points[1, at["left_elbow"]] - fore * 0.33 / 0.29
    points[2] = points[0] * [1, -1, -1]
    write_bvh(tmp_path / "a.bvh", LandmarkTrajectory(np.arange(3), points), 10.0)
    assert_landmarks(joints_of(tmp_path / "a.bvh")[0], points)


def test_unknown_landmarks_are_held_and_listed(tmp_path, random, body_trajectory):
    still = body_trajectory(random, [0]).points.repeat(5, axis=0)
    points = still.copy()
    points[[0, 3]] = np.nan
    points[2, 4, 1] = np.nan
    trajectory = LandmarkTrajectory(np.array([4, 5, 6, 7, 9]), points)
    write_bvh(tmp_path / "a.bvh", trajectory, 10.0)
    places, _ = joints_of(tmp_path / "a.bvh")
    assert_landmarks(places, still[[0, 0, 0, 0, 0, 0]])
    notes = json.loads((tmp_path / "a.bvh.json").read_text())
    assert notes["frames_with_held_landmarks"] == [4, 6, 7, 8]
    assert notes["first_frame"] == 4
    assert notes["unit"] == "cm"
