import numpy as np
import pytest

from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.simulation.actor import actor
from stereotrack_core.simulation.motions import MOTIONS, T_POSE
from stereotrack_core.simulation.people import PEOPLE
from stereotrack_core.simulation.postures import Posture, Stand, state_of
from stereotrack_core.simulation.skeleton import BONES, PosedBones, posed_bones, rest_joints


@pytest.fixture(scope="module")
def dressed():
    return actor(PEOPLE["P2"], "plain")


def test_weights_are_shares(dressed):
    assert dressed.weights.min() >= 0
    np.testing.assert_allclose(dressed.weights.sum(axis=1), 1)
    assert (dressed.weights > 0.5).any(axis=0)[[BONES.index("head"), BONES.index("chest")]].all()


def test_bones_at_rest_leave_the_surface_as_it_is(dressed):
    rest = rest_joints(dressed.person)
    bones = PosedBones(np.tile(np.eye(3), (len(BONES), 1, 1)), rest)
    vertices, normals = dressed.posed(bones)
    np.testing.assert_allclose(vertices, dressed.vertices, atol=1e-12)
    np.testing.assert_allclose(normals, dressed.normals, atol=1e-12)


@pytest.mark.parametrize("heading", [0.4, 1.7, 3.1, -2.5])
def test_rigid_motion_of_all_bones_moves_the_surface_rigidly(dressed, heading):
    rest = rest_joints(dressed.person)
    turn = rotation_from_vector(np.array([0.2, -0.3, heading]))
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


def test_turned_person_is_turned(dressed):
    state = state_of(dressed.person, T_POSE, Stand(np.array([1.0, 2.0]), np.pi / 2))
    vertices, _ = dressed.posed(posed_bones(dressed.person, state))
    span = np.ptp(vertices, axis=0)
    assert span[1] > 1.5 > 0.5 > span[0]
