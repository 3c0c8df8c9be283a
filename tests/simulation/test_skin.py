import numpy as np
import pytest
from scipy.spatial import cKDTree

from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.simulation.actor import actor
from stereotrack_core.simulation.motions import MOTIONS, T_POSE
from stereotrack_core.simulation.people import PEOPLE
from stereotrack_core.simulation.postures import Posture, state_of
from stereotrack_core.simulation.skeleton import (
    BONE,
    BONES,
    SIDES,
    PosedBones,
    posed_bones,
    rest_joints,
)
from tests.simulation.scenes import chain


@pytest.fixture(scope="module")
def dressed():
    return actor(PEOPLE["P2"], "plain")


def test_rigid_motion_of_all_bones_moves_the_surface_rigidly(dressed):
    rest = rest_joints(dressed.person)
    turn = rotation_from_vector(np.array([0.2, -0.3, 1.7]))
    shift = np.array([1.0, -2.0, 0.3])
    bones = PosedBones(np.tile(turn, (len(BONES), 1, 1)), rest @ turn.T + shift)
    vertices, normals = dressed.posed(bones)
    np.testing.assert_allclose(vertices, dressed.vertices @ turn.T + shift, atol=1e-9)
    np.testing.assert_allclose(normals, dressed.normals @ turn.T, atol=1e-9)


def test_limbs_do_not_collapse_when_arms_hang(dressed):
    """The upper arm keeps most of its thickness although its bone has turned by 90 degrees."""
    hanging, _ = dressed.posed(posed_bones(dressed.person, state_of(dressed.person, Posture())))
    stretched, _ = dressed.posed(posed_bones(dressed.person, state_of(dressed.person, T_POSE)))
    edges = dressed.triangles[:, :2]
    length = np.linalg.norm(np.diff(hanging[edges], axis=1)[:, 0], axis=1)
    before = np.linalg.norm(np.diff(stretched[edges], axis=1)[:, 0], axis=1)
    ratio = length / np.maximum(before, 1e-6)
    long_enough = before > 0.004
    assert np.percentile(ratio[long_enough], 0.5) > 0.3
    assert np.percentile(ratio[long_enough], 99.5) < 2.5


@pytest.mark.parametrize("motion", ["walk", "tie-shoes", "travolta"])
def test_feet_stay_on_the_floor(dressed, motion):
    for state in MOTIONS[motion].states(dressed.person, 12):
        vertices, _ = dressed.posed(posed_bones(dressed.person, state))
        assert -0.045 < vertices[:, 2].min() < 0.03


TRUNK = ("pelvis", "waist", "chest", "neck", "head", "thigh_left", "thigh_right")
REACH = 0.08


def depth_inside(points, vertices, normals):
    """How deep the points lie behind the surface, metres, where it is near and faces them."""
    distance, nearest = cKDTree(vertices).query(points, distance_upper_bound=REACH)
    near = np.isfinite(distance)
    away = points[near] - vertices[nearest[near]]
    height = np.einsum("ij,ij->i", away, normals[nearest[near]])
    facing = np.abs(height) > 0.85 * distance[near]
    return -height[facing].min(initial=0.0)


@pytest.mark.parametrize(
    "motion", ["cross-arms", "travolta", "whip", "point", "arms-at-sides", "shrug", "reach"]
)
def test_arms_stay_outside_of_the_trunk(motion):
    dressed = actor(PEOPLE["P3"], "plain")
    trunk = dressed.weights[:, [BONE[name] for name in TRUNK]].sum(axis=1) > 0.9
    arms = [BONE[f"{bone}_{side}"] for bone in ("forearm", "hand") for side in SIDES]
    arm = dressed.weights[:, arms].sum(axis=1) > 0.9
    frames = max(78, round(MOTIONS[motion].seconds * 10) + 16)
    for state in chain(dressed.person, (motion,), frames, fps=10).states[12::3]:
        vertices, normals = dressed.posed(posed_bones(dressed.person, state))
        assert depth_inside(vertices[arm], vertices[trunk], normals[trunk]) < 0.025
