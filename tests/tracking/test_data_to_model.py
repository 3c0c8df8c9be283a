"""Data that look for the model, against loops over data."""

import numpy as np
import pytest

from stereotrack_core.body.angles import ALL_JOINTS
from stereotrack_core.body.manifold import columns_of
from stereotrack_core.body.model import body_model, placed_cones
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.body.surface import nearest_on_surface
from stereotrack_core.tracking.correction import gathered
from stereotrack_core.tracking.residuals.surface import Trust, surface_residual
from tests.tracking.scenes import POSES, numerical_information, surface_points

BODY = body_model(AVERAGE)
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


def test_information_is_that_of_a_numerical_jacobian(prepared):
    _, _, residual = prepared
    found = gathered((residual,), BODY, POSES["pointing"], columns_of(ALL_JOINTS))
    A, b = numerical_information((residual,), BODY, POSES["pointing"], ALL_JOINTS)
    np.testing.assert_allclose(found.A, A, atol=1e-4 * abs(A).max())
    np.testing.assert_allclose(found.b, b, atol=1e-3 * abs(b).max())
