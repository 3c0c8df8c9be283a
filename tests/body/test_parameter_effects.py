"""What the parameters of the body's shape change about its surface."""

import numpy as np
import pytest

from stereotrack_core.body.model import body_model, placed_cones
from stereotrack_core.body.parameters import BodyParameters
from stereotrack_core.body.pose import t_pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.body.skeleton import HEAD, LEFT_FOREARM, TORSO
from tests.effects import check


def model(**changes):
    return body_model(AVERAGE, BodyParameters().replaced(**changes))


def cone(part, **changes):
    """First cone of a part in the T pose: base and end (3,), radii there, and flatness."""
    body = model(**changes)
    placed = placed_cones(body, body.frames(t_pose(np.zeros(3))))
    one = placed[np.flatnonzero(placed["part"] == part)[0]]
    end = one["origin"] + one["height"] * one["rotation"][:, 2]
    return one["origin"], end, one["r1"], one["r2"], one["flatness"]


EFFECTS = [
    ("torso_radius_low", 0.15, 0.18, lambda **p: cone(TORSO, **p)[2], "slope", AVERAGE.scale, 1e-6),
    ("torso_radius_high", 0.15, 0.2, lambda **p: cone(TORSO, **p)[3], "slope", AVERAGE.scale, 1e-6),
    ("torso_flatness", 0.5, 0.8, lambda **p: cone(TORSO, **p)[4], "slope", 1.0, 1e-6),
    ("torso_forward_low", 0.0, 0.05, lambda **p: cone(TORSO, **p)[0][1], "slope", 1.0, 1e-6),
    ("torso_forward_low", 0.0, 0.05, lambda **p: cone(TORSO, **p)[1][1], "slope", 0.0, 1e-6),
    ("torso_forward_high", 0.0, 0.05, lambda **p: cone(TORSO, **p)[0][1], "slope", 0.0, 1e-6),
    ("torso_forward_high", 0.0, 0.05, lambda **p: cone(TORSO, **p)[1][1], "slope", 1.0, 1e-6),
    ("torso_forward_high", 0.0, 0.10, lambda **p: cone(TORSO, **p)[1][2], "slope", 0.0, 1e-6),
    ("head_forward", 0.0, 0.05, lambda **p: cone(HEAD, **p)[0][1], "slope", 1.0, 1e-6),
    ("arm_radius_factor", 0.8, 1.6, lambda **p: cone(LEFT_FOREARM, **p)[3], "ratio", 2.0, 1e-6),
    ("legs", False, True, lambda **p: len(model(**p).cones), "difference", 4, 0),
    ("girdle", False, True, lambda **p: len(model(**p).joints), "difference", 2, 0),
]


@pytest.mark.parametrize("row", EFFECTS, ids=lambda row: row[0])
def test_a_parameter_changes_the_surface_as_it_says(row):
    check(*row)
