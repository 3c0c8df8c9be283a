"""Where the bones lie in the tracked body."""

import numpy as np
import pytest

from stereotrack_core.body.model import body_model, body_of_subject, landmarks
from stereotrack_core.body.offsets import (
    NO_OFFSETS,
    offset_axes,
    offsets_by_landmark,
    offsets_of,
    with_offsets,
)
from stereotrack_core.body.parameters import BodyShape
from stereotrack_core.body.pose import Pose, hanging_pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.body.skeleton import PARTS
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.recording.description import Subject
from stereotrack_core.recording.landmarks import LANDMARKS

BODY = body_model(AVERAGE)


def some_pose(seed=0):
    rng = np.random.default_rng(seed)
    pose = hanging_pose(rng.normal(size=3), rotation_from_vector(rng.normal(size=3)))
    turns = rotation_from_vector(rng.normal(size=(len(PARTS), 3)))
    return Pose(pose.position, np.concatenate([pose.rotations[:1], (pose.rotations @ turns)[1:]]))


def test_without_offsets_nothing_changes():
    pose = some_pose()
    known = body_of_subject(Subject("P", **vars(AVERAGE)))
    np.testing.assert_array_equal(known.offsets, NO_OFFSETS)
    np.testing.assert_array_equal(landmarks(known, pose), landmarks(BODY, pose))


def test_offsets_of_the_trunk_turn_with_the_trunk():
    pose = some_pose()
    offset = (0.01, -0.02, 0.03)
    body = body_of_subject(Subject("P", **vars(AVERAGE), offsets={"left_hip": offset}))
    moved = landmarks(body, pose) - landmarks(BODY, pose)
    k = LANDMARKS.index("left_hip")
    np.testing.assert_allclose(moved[k], pose.torso @ offset, atol=1e-12)
    np.testing.assert_array_equal(np.delete(moved, k, axis=0), 0.0)


def test_both_arms_mirror_each_other():
    """The mirror image of a pose has the mirror images of its axes."""
    pose, mirror = some_pose(3), np.diag([-1.0, 1.0, 1.0])
    swapped = [
        PARTS.index(p.replace("left", "@").replace("right", "left").replace("@", "right"))
        for p in PARTS
    ]
    other = Pose(mirror @ pose.position, mirror @ pose.rotations[swapped] @ mirror)
    axes = offset_axes(BODY.frames(pose))[LANDMARKS.index("left_elbow")]
    image = offset_axes(BODY.frames(other))[LANDMARKS.index("right_elbow")]
    np.testing.assert_allclose(image, mirror @ axes, atol=1e-12)


def test_across_a_straight_arm_nothing_is_known():
    frames = BODY.frames(hanging_pose(np.zeros(3)))
    for name in ("left_elbow", "right_hand"):
        axes = offset_axes(frames)[LANDMARKS.index(name)]
        np.testing.assert_allclose(axes, [[0, 0, 0], [0, 0, 0], [-1, 0, 0]], atol=1e-12)


def test_stacked_poses_are_moved_like_single_ones():
    poses = [some_pose(seed) for seed in range(3)]
    stack = Pose(np.stack([p.position for p in poses]), np.stack([p.rotations for p in poses]))
    offsets = np.random.default_rng(1).normal(0.0, 0.01, (9, 3))
    points = landmarks(BODY, stack)
    together = with_offsets(points, offsets, BODY.frames(stack))
    for k, pose in enumerate(poses):
        alone = with_offsets(points[k], offsets, BODY.frames(pose))
        np.testing.assert_allclose(together[k], alone, atol=1e-12)


def test_offsets_are_kept_by_name_and_with_another_surface():
    offsets = np.round(np.random.default_rng(1).normal(0.0, 0.01, (9, 3)), 5)
    by_name = offsets_by_landmark(offsets)
    np.testing.assert_array_equal(offsets_of(by_name), offsets)
    body = body_of_subject(Subject("P", offsets=by_name))
    wider = body.with_shape(BodyShape().replaced(torso_radius_low=0.2))
    np.testing.assert_array_equal(wider.offsets, offsets)
    assert wider.cones.r1[0] == pytest.approx(0.2 * wider.skeleton.proportions.scale)
