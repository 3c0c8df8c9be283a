"""Data that look for the model, against loops over data."""

import numpy as np
import pytest

from stereotrack_core.body.angles import ALL_JOINTS
from stereotrack_core.body.manifold import columns_of, displaced
from stereotrack_core.body.model import body_model, placed_cones
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.body.surface import nearest_on_surface
from stereotrack_core.tracking.correction import gathered
from stereotrack_core.tracking.residuals.surface import Trust, surface_residual
from tests.tracking.scenes import POSES, numerical_information, surface_points

BODY = body_model(AVERAGE)
_STATE = 6 + 2 * len(ALL_JOINTS)
TRUST = Trust(reach=0.25, scale=0.06, sigma=0.02, effective=150.0)


@pytest.fixture
def prepared(rng):
    frames = BODY.frames(POSES["pointing"])
    data = surface_points(BODY, POSES["pointing"], 600, rng, 0.03)
    data = np.concatenate([data, [[2.0, 2.0, 2.0]]])
    return data, frames, surface_residual(data, BODY, frames, TRUST)


def test_every_datum_within_reach_is_there_once_with_its_cones_part(prepared):
    data, frames, residual = prepared
    closest = nearest_on_surface(data, placed_cones(BODY, frames), TRUST.reach)
    assert closest.cone[-1] == -1
    assert len(residual.part) == (closest.cone >= 0).sum() < len(data)
    assert (np.diff(residual.part) >= 0).all()
    for i in range(0, len(residual.part), 20):
        (j,) = np.flatnonzero((data == residual.data[i]).all(axis=1))
        assert residual.part[i] == BODY.cones.part[closest.cone[j]]
        assert residual.distance[i] == closest.distance[j]
        np.testing.assert_array_equal(residual.point[i], closest.point[j])


def test_weights_and_variances_are_those_of_the_text(prepared):
    data, _, residual = prepared
    w = [(0.06**2 / (0.06**2 + e**2)) ** 2 for e in residual.distance]
    np.testing.assert_allclose(residual.weight, w)
    np.testing.assert_allclose(residual.variance, [0.02**2 * (len(data) / 150) / x for x in w])
    at_scale = surface_residual(data, BODY, prepared[1], Trust(0.25, 1e3, 0.02, 1e6))
    np.testing.assert_allclose(at_scale.variance, 0.02**2, rtol=1e-6)


def test_feet_move_rigidly_with_their_parts_on_fixed_directions(prepared, rng):
    _, frames, residual = prepared
    moved = [
        displaced(POSES["pointing"], 0.3 * rng.normal(size=_STATE), ALL_JOINTS) for _ in range(3)
    ]
    stack = BODY.frames(
        Pose(np.array([p.position for p in moved]), np.array([p.rotations for p in moved]))
    )
    predicted = residual.predicted(stack)
    for s, pose in enumerate(moved):
        there = BODY.frames(pose)
        for i in range(0, len(residual.part), 25):
            part = residual.part[i]
            local = frames.rotations[part].T @ (residual.point[i] - frames.origins[part])
            near = there.rotations[part] @ local + there.origins[part]
            assert predicted[s, i] == pytest.approx(residual.direction[i] @ near, abs=1e-12)


def test_where_it_was_made_the_residual_is_the_distance(prepared):
    _, frames, residual = prepared
    here = residual.predicted(type(frames)(frames.rotations[None], frames.origins[None]))[0]
    np.testing.assert_allclose(residual.measured - here, residual.distance, atol=1e-12)


def test_no_data_within_reach_give_no_rows(prepared):
    _, frames, _ = prepared
    residual = surface_residual(np.full((5, 3), 9.0), BODY, frames, TRUST)
    assert len(residual.variance) == 0
    one = type(frames)(frames.rotations[None], frames.origins[None])
    assert residual.predicted(one).shape == (1, 0)


def test_information_is_that_of_a_numerical_jacobian(prepared):
    _, _, residual = prepared
    found = gathered((residual,), BODY, POSES["pointing"], columns_of(ALL_JOINTS))
    A, b = numerical_information((residual,), BODY, POSES["pointing"], ALL_JOINTS)
    np.testing.assert_allclose(found.A, A, atol=1e-4 * abs(A).max())
    np.testing.assert_allclose(found.b, b, atol=1e-3 * abs(b).max())
