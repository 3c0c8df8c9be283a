"""Each margin of the outline acts on its own cones and on nothing else."""

import numpy as np
import pytest

from stereotrack_core.body.model import CONTOUR_NAMES, body_cones
from stereotrack_core.body.parameters import BodyParameters, BodyShape
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.body.skeleton import PARTS

NAMES = tuple(row.name for row in BodyShape.rows() if row.name.startswith("contour_"))

EXPECTED = {
    "contour_torso_side": [(0, 0)],
    "contour_torso_front": [(0, 1)],
    "contour_shoulder_top": [(1, 0), (2, 0)],
    "contour_shoulder_front": [(1, 1), (2, 1)],
    "contour_jaw_side": [(3, 0)],
    "contour_jaw_front": [(3, 1)],
    "contour_head_side": [(4, 0)],
    "contour_head_front": [(4, 1)],
    "contour_upper_arm": [(5, 0), (5, 1), (6, 0), (6, 1)],
    "contour_forearm": [(7, 0), (7, 1), (9, 0), (9, 1)],
    "contour_hand": [(8, 0), (8, 1), (10, 0), (10, 1)],
}
"""Cone and axis, 0 for x and 1 for y, by margin."""


def test_every_margin_is_some_cones():
    assert set(NAMES) == set(EXPECTED) == {name for pair in CONTOUR_NAMES for name in pair}


@pytest.mark.parametrize("name", NAMES)
def test_a_margin_acts_on_its_cones_alone(name):
    plain, changed = (body_cones(AVERAGE, BodyShape().replaced(**v)) for v in ({}, {name: 0.03}))
    where = np.argwhere(changed.outline != plain.outline)
    assert [tuple(index) for index in where.tolist()] == EXPECTED[name]
    assert (changed.outline[tuple(where.T)] == 0.03).all()
    for field in ("r1", "r2", "height", "origins", "flatness"):
        np.testing.assert_array_equal(getattr(changed, field), getattr(plain, field))


def test_the_axes_of_the_cones_are_what_the_names_say():
    """Seen in the part's frame: x is the side, y the front, and a shoulder's x is above."""
    cones = body_cones(AVERAGE, BodyParameters(girdle=False))
    for name, ways in EXPECTED.items():
        wanted = {"side": 0, "front": 1, "top": 2}.get(name.rsplit("_", 1)[1])
        for cone, axis in ways if wanted is not None else []:
            assert abs(cones.rotations[cone, wanted, axis]) > 0.95, name


def test_upper_arms_forearms_and_hands_are_theirs():
    part = body_cones(AVERAGE, BodyParameters()).part
    named = {name: {PARTS[part[cone]] for cone, _ in ways} for name, ways in EXPECTED.items()}
    assert named["contour_upper_arm"] == {"left_upper_arm", "right_upper_arm"}
    assert named["contour_forearm"] == {"left_forearm", "right_forearm"} == named["contour_hand"]
    assert named["contour_head_side"] == {"head"} == named["contour_jaw_front"]


@pytest.mark.parametrize("legs", [True, False])
def test_legs_have_no_margin(legs):
    cones = body_cones(AVERAGE, BodyShape().replaced(legs=legs, contour_hand=0.01))
    assert cones.outline.shape == (len(cones), 2)
    assert (cones.outline[11:] == 0.0).all()
    assert (cones.outline[:11] != 0.0).all()
