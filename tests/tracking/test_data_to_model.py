"""Data that look for the model, against loops over data."""

import numpy as np
import pytest

from stereotrack_core.body.angles import ALL_JOINTS
from stereotrack_core.body.manifold import columns_of
from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
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


def test_information_is_that_of_a_numerical_jacobian(prepared):
    _, frames, residual = prepared
    found = gathered((residual.rows(frames),), frames, columns_of(ALL_JOINTS))
    A, b = numerical_information((residual,), BODY, POSES["pointing"], ALL_JOINTS)
    np.testing.assert_allclose(found.A, A, atol=1e-4 * abs(A).max())
    np.testing.assert_allclose(found.b, b, atol=1e-3 * abs(b).max())
