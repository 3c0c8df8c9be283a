"""The error state: its inverse, and that no place is singular."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stereotrack_core.body.angles import ALL_JOINTS
from stereotrack_core.body.manifold import difference, displaced
from stereotrack_core.body.pose import t_pose
from stereotrack_core.body.skeleton import HEAD
from stereotrack_core.geometry.rotation import rotation_from_vector
from tests.body.poses import SPECIAL_POSES, random_pose

N = 6 + 2 * len(ALL_JOINTS)


def _error(rng, largest):
    """Error state with rotations up to `largest` radians each."""
    delta = rng.normal(size=N)
    rotation = delta[3:6]
    rotation *= rng.uniform(0, largest) / np.linalg.norm(rotation)
    tangents = delta[6:].reshape(-1, 2)
    lengths = rng.uniform(0, largest, (len(tangents), 1))
    tangents *= lengths / np.linalg.norm(tangents, axis=1, keepdims=True)
    return delta


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), largest=st.sampled_from([1e-9, 1e-3, 0.5, 3.1]))
def test_the_difference_of_a_displaced_pose_is_the_displacement(seed, largest):
    rng = np.random.default_rng(seed)
    pose, delta = random_pose(rng), _error(rng, largest)
    found = difference(displaced(pose, delta, ALL_JOINTS), pose, ALL_JOINTS)
    np.testing.assert_allclose(found, delta, atol=1e-7 if largest > 3 else 1e-12)


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_the_difference_leads_to_the_other_pose(seed):
    rng = np.random.default_rng(seed)
    origin, to = random_pose(rng), random_pose(rng)
    found = displaced(origin, difference(to, origin, ALL_JOINTS), ALL_JOINTS)
    np.testing.assert_allclose(found.position, to.position, atol=1e-12)
    np.testing.assert_allclose(found.torso, to.torso, atol=1e-7)
    np.testing.assert_allclose(found.rotations[1:, :, 2], to.rotations[1:, :, 2], atol=1e-7)


@pytest.mark.parametrize("angle", [0.0, 1e-13, 1e-6, 1.0, 3.0, np.pi - 1e-6, np.pi])
def test_tangents_turn_the_axis_to_where_it_is_wanted(angle):
    for azimuth in np.linspace(0, 2 * np.pi, 9):
        across = np.sin(angle) if angle < np.pi else 0.0
        axis = np.array([across * np.cos(azimuth), across * np.sin(azimuth), np.cos(angle)])
        origin, to = t_pose(np.zeros(3)), t_pose(np.zeros(3))
        origin.rotations[HEAD], to.rotations[HEAD, :, 2] = np.eye(3), axis
        tangents = difference(to, origin, (HEAD,))[6:]
        turned = rotation_from_vector(np.append(tangents, 0.0))
        np.testing.assert_allclose(turned[:, 2], axis, atol=1e-9)


def _seen(body, pose, joints):
    """What measurements can see of a pose: position, torso, directions of the limbs."""
    frames = body.frames(pose)
    directions = frames.rotations[..., 2][..., list(joints), :]
    shape = (*pose.position.shape[:-1], -1)
    return np.concatenate(
        [pose.position, pose.torso.reshape(shape), directions.reshape(shape)], axis=-1
    )


def _smallest_singular_value(function, n, step=1e-6):
    steps = step * np.eye(n)
    jacobian = (function(steps) - function(-steps)) / (2 * step)
    return np.linalg.svd(jacobian, compute_uv=False)[-1]


@pytest.mark.parametrize("name", [*SPECIAL_POSES, "random"])
def test_no_degree_of_freedom_is_lost_anywhere(rng, body, name):
    poses = [SPECIAL_POSES[name]] if name in SPECIAL_POSES else [random_pose(rng) for _ in range(9)]
    for pose in poses:
        smallest = _smallest_singular_value(
            lambda d, p=pose: _seen(body, displaced(p, d, ALL_JOINTS), ALL_JOINTS), N
        )
        assert smallest > 0.3
