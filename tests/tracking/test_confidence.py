"""Signs by which a pose can be judged."""

import numpy as np
import pytest

from stereotrack_core.body.angles import ALL_JOINTS
from stereotrack_core.body.manifold import displaced
from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.filtering.sigma_points import scaled_weights, sigma_deviations
from stereotrack_core.tracking.estimate import limb_directions, limb_sigma_deg
from stereotrack_core.tracking.residuals.surface import (
    unexplained_fraction,
    unexplained_fraction_of,
)
from tests.tracking.scenes import POSES, surface_points

BODY = body_model(AVERAGE)


def test_the_unexplained_fraction_is_a_mean():
    distance = np.array([0.0, 0.05, -0.05, np.inf])
    assert unexplained_fraction(distance) == pytest.approx((0.0 + 0.5 + 0.5 + 1.0) / 4, abs=1e-6)
    assert np.isnan(unexplained_fraction(np.empty(0)))


def test_the_unexplained_fraction_of_clouds(rng):
    frames = BODY.frames(POSES["t"])
    own = surface_points(BODY, POSES["t"], 4000, rng)
    assert unexplained_fraction_of(own, BODY, frames) < 0.01
    assert unexplained_fraction_of(own + [0, 0, 3.0], BODY, frames) > 0.99
    mixed = np.concatenate([own, own + [0, 0, 3.0]])
    assert unexplained_fraction_of(rng.permutation(mixed), BODY, frames) == pytest.approx(
        0.5, abs=0.03
    )


def test_the_spread_of_limbs_is_that_of_their_directions(rng):
    """Against directions of drawn poses; the forearm moves with its upper arm."""
    n = 6 + 2 * len(ALL_JOINTS)
    sigma = np.r_[np.full(3, 0.01), np.full(3, 0.02), np.full(n - 6, 0.04)]
    weights = scaled_weights(n, 0.1, 2.0, 0.0)
    dX = sigma_deviations(np.diag(sigma**2), weights)
    frames = BODY.frames(displaced(POSES["pointing"], dX, ALL_JOINTS))
    found = limb_sigma_deg(frames, weights.covariance)
    drawn = displaced(POSES["pointing"], sigma * rng.normal(size=(4000, n)), ALL_JOINTS)
    true = limb_directions(BODY.frames(POSES["pointing"]))
    apart = np.linalg.norm(limb_directions(BODY.frames(drawn)) - true, axis=-1)
    np.testing.assert_allclose(found, np.degrees(np.sqrt((apart**2).mean(axis=0))), rtol=0.05)
    assert (found[4:] > found[2:4]).all()
