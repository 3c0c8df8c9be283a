import numpy as np
import pytest
from scipy.spatial import cKDTree

from stereotrack_core.simulation.actor import actor
from stereotrack_core.simulation.motions import MOTIONS
from stereotrack_core.simulation.people import PEOPLE
from stereotrack_core.simulation.skeleton import (
    BONE,
    SIDES,
    posed_bones,
)
from tests.simulation.scenes import chain


@pytest.fixture(scope="module")
def dressed():
    return actor(PEOPLE["P2"], "plain")


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
