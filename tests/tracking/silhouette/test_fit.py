"""Margins between the clouds' surface and the outline, found from silhouettes."""

import numpy as np
import pytest

from stereotrack_core.body.model import CONTOUR_NAMES, body_model, placed_cones
from stereotrack_core.body.parameters import BodyShape
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.tracking.residuals.silhouette import contours_of, edge_maps
from stereotrack_core.tracking.shape_fit import LENGTH_SIGMAS, FreeBody, fitted_outline
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


def test_people_differ_in_height_in_single_lengths_and_in_surface():
    free = FreeBody(AVERAGE, SHAPE, lengths=tuple(LENGTH_SIGMAS))
    lengths = [0.05, 0.07, 0.04, 0.04, 0.04, 0.05, 0.06]
    surface = [0.02, 0.02, 0.10, 0.015, 0.015, 0.015, 0.15, 0.03, 0.01, 0.12, 0.008, 0.15, 0.12]
    expected = np.diag(np.square([*lengths, *surface]))
    expected[:7, :7] += 0.06**2
    np.testing.assert_allclose(np.linalg.inv(free.information), expected, atol=1e-12)
    proportions, shape = free.parts(free.start + np.r_[0.1, np.zeros(6), 0.01, np.zeros(12)])
    assert proportions.shoulder_width == pytest.approx(AVERAGE.shoulder_width * np.exp(0.1))
    assert proportions.hip_width == pytest.approx(AVERAGE.hip_width)
    assert shape.torso_radius_low == pytest.approx(SHAPE.torso_radius_low + 0.01)


def test_margins_are_fitted_by_weighted_least_squares_that_distrust_outliers(seen):
    rows, squares = [], []
    for pose, edges in seen[:2]:
        frames = BODY.frames(pose)
        found = contours_of(edges, BODY, frames)
        for cone, point, distance in zip(found.cone, found.point, found.distance, strict=True):
            one = placed_cones(BODY, frames)[cone]
            place = ((point - one["origin"]) @ one["rotation"])[:2] ** 2
            row = np.zeros(len(NAMES))
            for name, share in zip(CONTOUR_NAMES[cone], place / place.sum(), strict=True):
                row[NAMES.index(name)] += share
            rows.append(row)
            squares.append(distance)
    A, e = np.array(rows), np.array(squares)
    theta = np.zeros(len(NAMES))
    for _ in range(8):
        w = 1.0 / (6.0 * (0.015**2 + (e - A @ theta) ** 2))
        normal = np.eye(len(NAMES)) / 0.015**2 + A.T @ (w[:, None] * A)
        theta = np.linalg.solve(normal, A.T @ (w * e))
    values = _margins(fitted_outline(BODY, seen[:2]))
    limits = {row.name: (row.minimum, row.maximum) for row in SHAPE.rows()}
    for name, change in zip(NAMES, theta, strict=True):
        expected = np.clip(SHAPE.values()[name] + change, *limits[name])
        assert values[name] == pytest.approx(expected, abs=1e-7)
