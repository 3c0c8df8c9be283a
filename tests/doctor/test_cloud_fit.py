"""A view's points are laid onto those of the others, and what has to be done for it is measured."""

import numpy as np
import pytest

from stereotrack_core.doctor.cloud_fit import Eye, fit_clouds, surface_of
from stereotrack_core.geometry.rotation import rotation_from_vector

EYE = Eye(np.array([0.0, -3.0, 1.2]), np.array([0.0, 1.0, 0.0]))


def ball(seed, facing):
    """Points of two bumpy balls, of the half that faces a place."""
    rng = np.random.default_rng(seed)
    ways = rng.normal(size=(3000, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    ways = ways[ways @ (facing / np.linalg.norm(facing)) > 0.1]
    bumps = 1.0 + 0.2 * np.sin(5 * ways[:, :1]) * np.cos(4 * ways[:, 2:])
    middle = np.where(rng.random(len(ways))[:, None] < 0.5, [-0.4, 0.0, 1.0], [0.4, 0.1, 1.4])
    return middle + 0.3 * bumps * ways


@pytest.fixture(scope="module")
def own():
    return ball(1, np.array([0.0, -1.0, 0.0]))


@pytest.fixture(scope="module")
def others():
    eye = np.array([2.0, -2.5, 1.2])
    return surface_of(ball(2, np.array([0.6, -1.0, 0.0])), eye)


def fitted(points, others, way):
    return fit_clouds([surface_of(points, EYE.centre)], [others], EYE, way)


def test_points_in_place_stay_there(own, others):
    fit = fitted(own, others, "any")
    assert fit.shift < 0.01
    assert fit.gain < 0.05


def test_a_turn_of_the_camera_is_measured(own, others):
    turn = rotation_from_vector(np.radians([0.0, 0.0, 3.0]))
    fit = fitted((own - EYE.centre) @ turn.T + EYE.centre, others, "turn")
    assert np.degrees(fit.amount) == pytest.approx(3.0, abs=0.3)
    assert fit.gain > 0.3


def test_distances_that_are_too_large_are_measured(own, others):
    fit = fitted((own - EYE.centre) * 1.1 + EYE.centre, others, "range")
    assert fit.amount == pytest.approx(1 / 1.1, abs=0.01)
    along = own + 0.05 * ((own - EYE.centre) @ EYE.axis)[:, None] * EYE.axis
    assert fitted(along, others, "depth").amount == pytest.approx(1 / 1.05, abs=0.01)


def test_a_displaced_camera_is_measured(own, others):
    fit = fitted(own + [0.08, 0.06, 0.0], others, "shift")
    assert fit.amount == pytest.approx(0.1, abs=0.01)


def test_nothing_in_common_gives_no_fit(own, others):
    assert fitted(own + [5.0, 0.0, 0.0], others, "any") is None
    assert fit_clouds([], [], EYE) is None
