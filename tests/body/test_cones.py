"""The cones that stand for the body."""

import dataclasses

import numpy as np
import pytest

from stereotrack_core.body.angles import pose_of_state
from stereotrack_core.body.model import body_cones, body_model, landmarks, placed_cones
from stereotrack_core.body.parameters import BodyParameters, BodyShape
from stereotrack_core.body.pose import t_pose
from stereotrack_core.body.proportions import AVERAGE, Proportions
from stereotrack_core.body.skeleton import CLAVICLES, PARTS
from tests.body.poses import random_pose


def test_the_thesis_has_eleven_cones_and_legs_add_four(body, legless):
    names = [PARTS[part] for part in legless.cones.part]
    assert len(legless.cones) == len(names) == 11
    expected = {"torso": 3, "head": 2, "left_upper_arm": 1, "right_upper_arm": 1}
    expected |= {"left_forearm": 2, "right_forearm": 2}
    assert {name: names.count(name) for name in set(names)} == expected
    assert len(body.cones) == 15
    assert {PARTS[part] for part in body.cones.part} == set(PARTS)


def test_shoulders_that_can_move_rest_where_fixed_ones_are(body):
    fixed = body_model(AVERAGE, BodyParameters(girdle=False))
    pose = t_pose(np.array([0.1, 0.2, 0.9]))
    here, there = (placed_cones(one, one.frames(pose)) for one in (body, fixed))
    np.testing.assert_allclose(here.rotations, there.rotations, atol=1e-15)
    np.testing.assert_allclose(here.origins, there.origins, atol=1e-15)
    np.testing.assert_array_equal(here.cones.sizes, there.cones.sizes)
    np.testing.assert_array_equal(here.cones.outline, there.cones.outline)


def test_lifted_shoulders_take_their_cones_along(body):
    x = np.zeros(6 + 2 * len(CLAVICLES))
    x[[7, 9]] = np.radians([-25.0, 0.0])
    frames = body.frames(pose_of_state(x, CLAVICLES))
    placed = placed_cones(body, frames)
    ends = placed.origins + placed.rotations[..., 2] * placed.cones.height[:, None]
    for part, lifted in zip(CLAVICLES, (0.05, 0.0), strict=True):
        (cone,) = np.flatnonzero(placed.cones.part == part)
        rise = ends[cone, 2] - AVERAGE.torso_length
        assert rise == pytest.approx(lifted, abs=0.025)
        assert (rise > 0.02) == (lifted > 0)


def test_radii_and_heights_are_those_of_the_table():
    parameters = BodyParameters(legs=False, torso_radius_low=0.165, torso_radius_high=0.175)
    c, a = body_cones(AVERAGE, parameters), AVERAGE
    rows = np.column_stack([c.r1, c.r2, c.height, c.flatness])
    shoulder = [0.075, 0.07, 0.5 * a.shoulder_width - 0.03, 1.0]
    upper = [0.058, 0.045, a.upper_arm_length, 1.0]
    fore, hand = [0.045, 0.032, a.forearm_length, 1.0], [0.040, 0.032, a.hand_length, 1.0]
    expected = [
        [0.165, 0.175, a.torso_length + 0.05, parameters.torso_flatness],
        *[shoulder] * 2,
        [0.06, 0.09, 0.135, 1.0],
        [0.09, 0.055, 0.135, 1.0],
        *[upper] * 2,
        *[fore, hand] * 2,
    ]
    np.testing.assert_allclose(rows, expected, atol=1e-3)


def test_only_hands_and_crown_end_in_half_spheres(legless):
    rounded = [PARTS[p] for p in legless.cones.part[legless.cones.round_end]]
    assert sorted(rounded) == ["head", "left_forearm", "right_forearm"]
    assert not legless.cones.round_base.any()


def test_arm_cones_lead_from_joint_to_joint(rng, legless):
    frames = legless.frames(random_pose(rng))
    placed = placed_cones(legless, frames)
    ends = placed.origins + placed.rotations[..., 2] * placed.cones.height[:, None]
    for side in ("left", "right"):
        upper, fore = PARTS.index(f"{side}_upper_arm"), PARTS.index(f"{side}_forearm")
        (u,), (f, h) = (np.flatnonzero(placed.cones.part == part) for part in (upper, fore))
        np.testing.assert_allclose(placed.origins[u], frames.origins[upper], atol=1e-12)
        np.testing.assert_allclose(ends[u], frames.origins[fore], atol=1e-12)
        np.testing.assert_allclose(placed.origins[h], ends[f], atol=1e-12)


def test_shoulder_cones_end_at_the_shoulders(legless):
    pose = t_pose(np.zeros(3))
    placed = placed_cones(legless, legless.frames(pose))
    ends = placed.origins + placed.rotations[..., 2] * placed.cones.height[:, None]
    np.testing.assert_allclose(ends[[1, 2]], landmarks(legless, pose)[:2], atol=1e-12)


def test_the_head_is_widest_around_its_landmark():
    shift = {"head_forward": 0.03, "head_rise": 0.02}
    body = body_model(AVERAGE, BodyShape(**shift))
    pose = t_pose(np.zeros(3))
    placed = placed_cones(body, body.frames(pose))
    lower, upper = np.flatnonzero(body.cones.part == PARTS.index("head"))
    expected = landmarks(body, pose)[6] + [0.0, 0.03, 0.02]
    np.testing.assert_allclose(placed.origins[upper], expected, atol=1e-12)
    lower_end = placed.origins[lower] + body.cones.height[lower] * placed.rotations[lower, :, 2]
    np.testing.assert_allclose(lower_end, expected, atol=1e-12)


def test_cones_are_turned_by_rotations(body):
    turned = body.cones.rotations @ np.swapaxes(body.cones.rotations, 1, 2)
    np.testing.assert_allclose(turned, np.tile(np.eye(3), (15, 1, 1)), atol=1e-15)
    np.testing.assert_allclose(np.linalg.det(body.cones.rotations), 1.0)


def test_cones_grow_with_the_proportions():
    tall = Proportions(**{k: 1.1 * v for k, v in dataclasses.asdict(AVERAGE).items()})
    small, big = (body_cones(p, BodyParameters()) for p in (AVERAGE, tall))
    for name in ("r1", "r2"):
        np.testing.assert_allclose(getattr(big, name), 1.1 * getattr(small, name))


@pytest.mark.parametrize(
    ("name", "value", "parts"),
    [("arm_radius_factor", 1.5, (2, 3, 4, 5)), ("leg_radius_factor", 0.8, (6, 7, 8, 9))],
)
def test_radius_factors_act_on_their_parts_alone(name, value, parts):
    plain, changed = (body_cones(AVERAGE, BodyShape(**v)) for v in ({}, {name: value}))
    factor = np.where(np.isin(plain.part, parts), value, 1.0)
    np.testing.assert_allclose(changed.r1, factor * plain.r1)
    np.testing.assert_allclose(changed.r2, factor * plain.r2)


def test_some_cones_can_be_chosen(body):
    chosen = body.cones[body.cones.part == 1]
    assert len(chosen) == 2
    np.testing.assert_array_equal(chosen.r2, [0.09, 0.055])
