"""Registration of one limb, and the joints that are imposed afterwards."""

import numpy as np
import pytest

from stereotrack_core.body.angles import ALL_JOINTS
from stereotrack_core.body.manifold import columns_of, displaced
from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.body.skeleton import LEFT_FOREARM, PARTS, RIGHT_UPPER_ARM, TORSO
from stereotrack_core.experiments.baselines import estimators
from stereotrack_core.experiments.baselines.estimators import Registered, joined, rigid_jacobian
from stereotrack_core.geometry.rotation import rotation_from_vector, vector_from_rotation
from tests.experiments.baselines.test_baselines import given, make
from tests.tracking.scenes import POSES, angle_errors, surface_points

STEP = 1e-6


@pytest.mark.parametrize("part", range(len(PARTS)))
def test_the_jacobian_of_a_part_is_its_movement(part):
    body, pose = body_model(AVERAGE), POSES["pointing"]
    frames, columns = body.frames(pose), columns_of(ALL_JOINTS)
    J = rigid_jacobian(part, frames, columns)
    for i in range(columns.n):
        moved = body.frames(displaced(pose, STEP * np.eye(columns.n)[i], ALL_JOINTS))
        shift = (moved.origins[part] - frames.origins[part]) / STEP
        turn = vector_from_rotation(moved.rotations[part] @ frames.rotations[part].T) / STEP
        np.testing.assert_allclose(J[:, i], np.concatenate([shift, turn]), atol=1e-4)


def test_a_limb_is_moved_to_its_data_without_regard_to_its_joint(monkeypatch):
    rng = np.random.default_rng(0)
    monkeypatch.setattr(estimators, "ITERATIONS", 20)
    tracker = make("limb-icp")
    tracker.start(POSES["t"])
    body = tracker.setup.body
    points = surface_points(body, POSES["t"], 6000, rng)
    surface = given(tracker, points)[0].surface(POSES["t"], wide=False)
    arm = surface.data[surface.part == LEFT_FOREARM]
    origin = body.frames(POSES["t"]).origins[LEFT_FOREARM]
    turn, shift = rotation_from_vector(np.array([0.0, 0.08, 0.1])), np.array([0.0, 0.03, 0.04])
    moved = (arm - origin) @ turn.T + origin + shift
    register = tracker.leader.estimator.register
    found = register(LEFT_FOREARM, moved, POSES["t"], len(points))
    axis = turn @ body.frames(POSES["t"]).rotations[LEFT_FOREARM][:, 2]
    assert np.degrees(np.arccos(found.rotation[:, 2] @ axis)) < 1.0
    across = found.origin - (origin + shift)
    assert np.linalg.norm(across - (across @ axis) * axis) < 0.005
    assert np.linalg.eigvalsh(found.information).min() > -1e-6


def test_joints_are_imposed_by_how_certain_each_limb_is():
    tracker = make("limb-icp")
    tracker.start(POSES["reaching"])
    frames = tracker.setup.body.frames(POSES["reaching"])
    sure = np.diag([1e6] * 6)
    turned = rotation_from_vector(np.array([0.0, 0.0, 0.2])) @ frames.rotations[RIGHT_UPPER_ARM]
    limbs = [
        Registered(TORSO, frames.rotations[TORSO], frames.origins[TORSO], sure),
        Registered(RIGHT_UPPER_ARM, turned, frames.origins[RIGHT_UPPER_ARM] + 0.05, 1e-4 * sure),
    ]
    measured, _ = given(tracker, np.empty((0, 3)))
    found = joined(limbs, measured, POSES["reaching"])
    dx = np.linalg.solve(found.A + 1e-3 * np.eye(len(found.b)), found.b)
    pose = displaced(POSES["reaching"], dx, tracker.setup.joints)
    assert np.linalg.norm(pose.position - POSES["reaching"].position) < 1e-3
    off = angle_errors(tracker.setup.body, pose, POSES["reaching"])
    assert off[TORSO] < 0.1
    assert off[RIGHT_UPPER_ARM] > 5.0


def test_limbs_without_data_stay_where_they_are_expected():
    rng = np.random.default_rng(1)
    tracker = make("limb-icp")
    tracker.start(POSES["t"])
    points = surface_points(tracker.setup.body, POSES["t"], 4000, rng)
    surface = given(tracker, points)[0].surface(POSES["t"], wide=False)
    seen = surface.data[surface.part != LEFT_FOREARM]
    found = tracker.leader.estimator.settle(*given(tracker, seen))
    assert angle_errors(tracker.setup.body, found.pose, POSES["t"])[LEFT_FOREARM] < 3.0
    assert np.isfinite(found.P).all()
