"""Margins between the clouds' surface and the outline, found from silhouettes."""

import numpy as np
import pytest

from stereotrack_core.body.model import CONTOUR_NAMES, body_model
from stereotrack_core.body.parameters import BodyShape
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.tracking.residuals.silhouette import edge_maps
from stereotrack_core.tracking.shape_fit import fitted_outline
from tests.tracking.scenes import POSES
from tests.tracking.views import cloud_of_body

SHAPE = BodyShape()
BODY = body_model(AVERAGE, SHAPE)
NAMES = tuple(dict.fromkeys(name for pair in CONTOUR_NAMES for name in pair))
PLANTED = dict.fromkeys(NAMES, -0.004) | {
    "contour_torso_side": 0.006,
    "contour_upper_arm": 0.003,
    "contour_forearm": 0.0,
    "contour_hand": 0.005,
    "contour_head_side": 0.003,
    "contour_head_front": 0.003,
}
"""Round cones cannot be wider in front than at their sides where they are cast."""


def _seen(planted, poses, by=(0.0, 0.0, 0.0)):
    wide = body_model(AVERAGE, SHAPE.replaced(**planted))
    return [
        (Pose(pose.position + np.asarray(by), pose.rotations), edge_maps(cloud_of_body(wide, pose)))
        for pose in poses
    ]


def _margins(shape):
    return {name: shape.values()[name] for name in NAMES}


@pytest.fixture(scope="module")
def seen():
    heights = [Pose(p.position + [0.02, 0.01, 0.03], p.rotations) for p in POSES.values()]
    return _seen(PLANTED, [*POSES.values(), *heights])


def test_margins_that_are_in_the_silhouettes_are_recovered(seen):
    found = _margins(fitted_outline(BODY, seen))
    for name in ("torso_side", "upper_arm", "forearm", "hand", "head_side"):
        planted = PLANTED[f"contour_{name}"]
        assert found[f"contour_{name}"] == pytest.approx(planted, abs=0.002), name


def test_margins_of_what_nobody_sees_stay_as_they_were(seen):
    assert fitted_outline(BODY, []) == SHAPE
    unseen = [(pose, ()) for pose, _ in seen]
    assert fitted_outline(BODY, unseen) == SHAPE


def test_margins_stay_within_their_bounds():
    rows = {row.name: row for row in SHAPE.rows()}
    seen = _seen(dict.fromkeys(NAMES, 0.099), [POSES["t"]])
    cut = SHAPE.replaced(**dict.fromkeys(NAMES, 0.1))
    for name, value in _margins(fitted_outline(body_model(AVERAGE, cut), seen)).items():
        assert rows[name].minimum <= value <= rows[name].maximum
